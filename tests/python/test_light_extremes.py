"""Light beyond what float holds: an error that names the pixel, from every renderer, never a picture with NaN."""

from __future__ import annotations

import pytest
from povray_scenes import scene_of

from aliascope import renderers
from aliascope.errors import AliascopeError, JobFailed
from aliascope.model import Scene
from aliascope.renderers.base import Request
from aliascope.stability.running import all_probes, run


def glaring() -> Scene:
    """A square of 1e40, 1e30 times the 1e10 of its pattern, in the middle of pixel (3, 4) of 8 x 6; black around it."""
    square = [(-0.8, -1.8, 0.0), (-0.2, -1.8, 0.0), (-0.2, -1.2, 0.0), (-0.8, -1.2, 0.0)]
    pattern = {"type": "checker", "scale": 0.01, "colours": ((1e10,) * 3, (1e10,) * 3)}
    materials = {"lamp": {"emission": (1e30,) * 3, "pattern": pattern}}
    return scene_of([{"type": "polygon", "material": "lamp", "points": square}], materials, size=(8, 6))


@pytest.mark.parametrize(
    ("renderer", "mode"),
    [
        ("embree", "uniform:n=1,sampler=regular"),
        ("embree", "uniform:n=1,sampler=regular,filter=tent"),
        ("embree", "uniform:film=float,filter=mitchell,n=1,sampler=regular"),
        ("embree", "adaptive:n=16"),
        ("osmesa", "none"),
        ("povray", "none"),
    ],
)
def test_light_that_float_does_not_hold_is_an_error(renderer: str, mode: str) -> None:
    found = renderers.find(renderer)
    with pytest.raises(AliascopeError) as refused:
        found.render(Request(glaring(), 8, 6, renderers.mode_of(found, mode)))
    if renderer == "povray":  # which knows before it draws
        assert "may reach 1e+40" in str(refused.value)
    else:
        assert isinstance(refused.value, JobFailed)
        assert "not finite" in str(refused.value)
        # The first that a filter reaches; at a distance of 1 a tent is 0, and at 2 Mitchell's is.
        assert f"pixel {(2, 3) if 'mitchell' in mode else (3, 4)}" in str(refused.value)


WHERE = {"povray": "may reach 1e+40", "metrics": "first at x=0, y=0", "exr": "first at x=0, y=0"}
"""What the message says that does not say "pixel"."""

NOT_FINITE = [name for name in all_probes() if name.endswith("| not-finite")]


@pytest.mark.parametrize("name", NOT_FINITE)
def test_what_is_no_number_is_named(name: str) -> None:
    """By renderers, estimators, metrics and files: no reading of the map is a picture or a figure of it."""
    for reading in run(all_probes()[name]).readings:
        assert reading.error is None
        assert WHERE.get(name.partition(" |")[0], "pixel") in reading.refused
