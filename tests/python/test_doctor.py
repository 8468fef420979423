"""What doctor says of a renderer that it does not know by name."""

from __future__ import annotations

import pytest

from aliascope import renderers
from aliascope.renderers.embree import Embree
from aliascope.studies import doctor


class Fourth(Embree):
    name = "fourth"
    title = "A fourth"
    probe_mode = "uniform:n=400,sampler=regular"


class Random(Fourth):
    """Random samples place an edge 0.03 pixel off, and more."""

    probe_mode = "uniform:n=1,sampler=random"


@pytest.mark.parametrize(("renderer", "holds"), [(Fourth(), True), (Random(), False)])
def test_a_new_renderer_is_probed_in_the_mode_that_it_names(
    monkeypatch: pytest.MonkeyPatch, renderer: Fourth, holds: bool
) -> None:
    monkeypatch.setattr(renderers, "RENDERERS", {renderer.name: renderer})
    document = doctor.examine()
    (entry,) = document["renderers"]
    assert entry["mode"] == renderer.probe_mode
    assert entry["holds"] is holds
    assert any(renderer.probe_mode in line for line in doctor.lines_of(document))
