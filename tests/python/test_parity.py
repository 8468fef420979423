"""The three renderers agree on where a pixel is, and draw the same scenes."""

from __future__ import annotations

import numpy as np
import pytest

from aliascope import api, references, scene_io
from aliascope.model import Scene
from aliascope.renderers import RENDERERS, mode_of
from aliascope.renderers.base import Request

PRECISE = {"embree": "uniform:n=256", "osmesa": "accumulate:n=256", "povray": "am1:depth=9,threshold=0,jitter=0"}


def edge_scene(steep: bool, size: int, offset: float) -> Scene:
    """White below (left of, where steep) a line of slope 1 : 8 that passes `offset` pixels above (right of) the
    middle; a unit is a pixel."""
    reach = 8.0 * size
    line = [(-reach, offset - reach / 8.0), (reach, offset + reach / 8.0), (reach, -reach), (-reach, -reach)]
    points = [(y, x, 0.0) if steep else (x, y, 0.0) for x, y in line]
    return Scene.model_validate(
        {
            "title": "edge",
            "shows": "an edge",
            "view": {"size": (size, size)},
            "camera": {"type": "orthographic", "eye": (0, 0, 9), "look_at": (0, 0, 0), "height": float(size)},
            "materials": {"white": {"emission": (1, 1, 1)}},
            "surfaces": [{"type": "polygon", "material": "white", "points": points}],
        }
    )


@pytest.mark.parametrize("steep", [False, True])
@pytest.mark.parametrize("name", list(RENDERERS))
def test_an_edge_of_slope_one_in_eight_lies_where_it_is(name: str, steep: bool) -> None:
    """Within 0.01 pixel in the mean over its phases: 48 columns hold each of 8 phases 6 times."""
    size, offset = 48, 2.71828
    renderer = RENDERERS[name]
    request = Request(edge_scene(steep, size, offset), size, size, mode_of(renderer, PRECISE[name]))
    pixels = renderer.render(request).pixels.astype(np.float64)[:, :, 1]
    filled = pixels.sum(axis=1) if steep else pixels.sum(axis=0)
    assert abs(filled.mean() - size / 2 - offset) < 0.01
    # Which side is white, and which way the line leans, tell a mirrored picture.
    lit, dark = ((0, 0), (0, -1)) if steep else ((-1, 0), (0, 0))
    assert pixels[lit] == 1.0
    assert pixels[dark] == 0.0
    halves = (filled[: size // 2].mean(), filled[size // 2 :].mean())
    assert bool(halves[0] > halves[1]) is steep  # y points up: the upper rows of the steep edge reach further right


@pytest.mark.parametrize("scene", ["edge", "zone-plate", "discs"])
@pytest.mark.parametrize("name", list(RENDERERS))
def test_every_renderer_comes_close_to_the_exact_picture(name: str, scene: str) -> None:
    """256 or 81 samples a pixel: an RMSE over the whole picture below 0.008, where one sample has 0.05 to 0.3 (a shift
    by a quarter of a pixel, or one swapped colour, is far above)."""
    file = scene_io.load(scene)
    exact = references.make(file.scene, file.scene.view.size).exact
    pixels = api.render(file, name, PRECISE[name]).pixels
    assert np.sqrt(np.mean((pixels - exact) ** 2)) < 0.008


@pytest.mark.parametrize("name", list(RENDERERS))
def test_another_size_keeps_the_vertical_extent(name: str) -> None:
    """Twice as wide at the same height: the middle is the same picture."""
    mode = {"embree": "uniform:n=1,sampler=regular", "osmesa": "none", "povray": "none"}[name]
    narrow = api.render("edge", name, mode, size=(64, 48)).pixels
    wide = api.render("edge", name, mode, size=(128, 48)).pixels
    assert np.array_equal(wide[:, 32:96], narrow)
