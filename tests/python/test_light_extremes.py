"""Light beyond what float holds: an error that names the pixel, from every renderer, never a picture with NaN."""

from __future__ import annotations

import ast
import math
import re
from pathlib import Path
from typing import Any

import pytest
from povray_scenes import scene_of

from aliascope import renderers
from aliascope.errors import AliascopeError, JobFailed, Unsupported
from aliascope.model import Scene
from aliascope.renderers.base import Request
from aliascope.stability import naming
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
        assert 'may reach 1e+40 of "lamp", in pixel (3, 4)' in str(refused.value)
    else:
        assert isinstance(refused.value, JobFailed)
        assert "not finite" in str(refused.value)
        # The first that a filter reaches; at a distance of 1 a tent is 0, and at 2 Mitchell's is.
        assert f"pixel {(2, 3) if 'mitchell' in mode else (3, 4)}" in str(refused.value)


NOT_FINITE = [name for name in all_probes() if name.endswith("| not-finite")]


@pytest.mark.parametrize("name", NOT_FINITE)
def test_what_is_no_number_is_named(name: str) -> None:
    """By renderers, samplers, estimators, measures, filters, metrics and files, at all levels: what names nothing is no
    refusal (below)."""
    cell = run(all_probes()[name])
    assert (cell.status, cell.refused_from) == ("refuses", all_probes()[name].levels[0]), cell.readings


def test_a_message_that_names_nothing_is_a_failure() -> None:
    def refuse() -> None:
        raise Unsupported("no number in pixel (1, 2)")

    for act, names, status in (
        (refuse, r"pixel \(1, 2\)", "refuses"),
        (refuse, r"pixel \(2, 1\)", "failed"),
        (lambda: math.nan, "nan", "failed"),
    ):
        acts = [(refuse, "no number"), (act, names)]
        cell = run(naming.probe("c", "statistic", "the pixel", lambda at, acts=acts: acts))
        assert cell.status == status, cell.readings


def test_without_the_plugin_its_cells_are_absent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(naming, "PLUGIN", Path("nowhere.so"))
    cell = run(all_probes()["sampler-plugin | not-finite"])
    assert (cell.status, cell.absent) == (
        "absent",
        "nowhere.so, a sampler whose numbers are none, is not built: run make",
    )


@pytest.mark.parametrize(
    ("surface", "camera", "pixels"),
    [
        ({"type": "sphere", "centre": (1.5, 0.5, 0.0), "radius": 0.3}, None, {(5, 2)}),
        ({"type": "disc", "centre": (1.5, 0.5, 0.0), "normal": (0.0, 0.6, 0.8), "radius": 0.3}, None, {(5, 2)}),
        ({"type": "sphere", "centre": (9.5, 0.5, 0.0), "radius": 0.3}, None, set()),
        (
            {"type": "plane", "point": (0.0, 0.0, 0.0), "normal": (0.0, 0.0, 1.0)},
            None,
            {(3, 2), (4, 2), (3, 3), (4, 3)},
        ),
        # A road from behind the eye to far ahead: the lower half of the picture.
        (
            {"type": "polygon", "points": [(-1.0, -1.0, 9.0), (1.0, -1.0, 9.0), (1.0, -1.0, -9e9), (-1.0, -1.0, -9e9)]},
            {"type": "perspective", "eye": (0.0, 0.0, 0.0), "look_at": (0.0, 0.0, -1.0), "vertical_fov_degrees": 60.0},
            {(x, y) for x in range(8) for y in range(3, 6)},
        ),
    ],
)
def test_povray_names_what_is_too_bright_and_a_pixel_of_it(
    surface: dict[str, Any], camera: dict[str, Any] | None, pixels: set[tuple[int, int]]
) -> None:
    camera = camera or {"type": "orthographic", "eye": (0.0, 0.0, 9.0), "look_at": (0.0, 0.0, 0.0), "height": 6.0}
    lamps = {"lamp": {"emission": (1e10,) * 3}, "dim": {"emission": (1.0,) * 3}}
    small = {"type": "sphere", "centre": (-1.5, 0.5, 0.0), "radius": 0.1, "material": "dim"}
    scene = scene_of([{**surface, "material": "lamp"}, small], lamps, camera=camera, size=(8, 6))
    povray = renderers.find("povray")
    with pytest.raises(Unsupported) as refused:
        povray.render(Request(scene, 8, 6, renderers.mode_of(povray, "none")))
    named = re.search(r'1e\+10 of "lamp"(?:, in pixel (\(\d+, \d+\)))?$', str(refused.value))
    assert named, refused.value
    assert {ast.literal_eval(each) for each in named.groups() if each} <= pixels
    assert bool(named.group(1)) == bool(pixels)


def test_povray_names_pixels_of_the_picture_that_is_asked_for() -> None:
    """And not of the scene's own size."""
    povray = renderers.find("povray")
    with pytest.raises(Unsupported, match=r"pixel \(3[2-7], 4[2-7]\)$"):
        povray.render(Request(glaring(), 80, 60, renderers.mode_of(povray, "none")))


def test_povray_names_the_background() -> None:
    povray = renderers.find("povray")
    dim = {"type": "sphere", "centre": (0.0, 0.0, 0.0), "radius": 1.0, "material": "dim"}
    scene = scene_of([dim], {"dim": {"emission": (1.0,) * 3}}, size=(8, 6), background=(0.0, 0.0, 1e30))
    with pytest.raises(Unsupported, match=r"end at 65504, and this one may reach 1e\+30 in the background$"):
        povray.render(Request(scene, 8, 6, renderers.mode_of(povray, "none")))
