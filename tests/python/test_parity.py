"""The renderers agree on where a pixel is, and draw the same scenes: each those that it says it draws."""

from __future__ import annotations

import numpy as np
import pytest

from aliascope import api, references, scene_io
from aliascope.geometry import frame_of
from aliascope.model import Scene
from aliascope.renderers import RENDERERS, mode_of
from aliascope.renderers.base import Request, lacks


def drawn_by(*scenes: Scene) -> list[str]:
    """The renderers that draw all of these, with either of their modes here."""
    return [
        name
        for name, renderer in RENDERERS.items()
        if not any(
            lacks(renderer, scene, mode_of(renderer, mode))
            for scene in scenes
            for mode in (renderer.probe_mode, renderer.single_mode)
        )
    ]


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
    request = Request(edge_scene(steep, size, offset), size, size, mode_of(renderer, renderer.probe_mode))
    pixels = renderer.render(request).pixels.astype(np.float64)[:, :, 1]
    filled = pixels.sum(axis=1) if steep else pixels.sum(axis=0)
    assert abs(filled.mean() - size / 2 - offset) < 0.01
    # Which side is white, and which way the line leans, tell a mirrored picture.
    lit, dark = ((0, 0), (0, -1)) if steep else ((-1, 0), (0, 0))
    assert pixels[lit] == 1.0
    assert pixels[dark] == 0.0
    halves = (filled[: size // 2].mean(), filled[size // 2 :].mean())
    assert bool(halves[0] > halves[1]) is steep  # y points up: the upper rows of the steep edge reach further right


@pytest.mark.parametrize(
    ("scene", "name"),
    [(scene, name) for scene in ("edge", "zone-plate", "discs") for name in drawn_by(scene_io.load(scene).scene)],
)
def test_every_renderer_comes_close_to_the_exact_picture(name: str, scene: str) -> None:
    """256 or 81 samples a pixel: an RMSE over the whole picture below 0.008, where one sample has 0.05 to 0.3 (a shift
    by a quarter of a pixel, or one swapped colour, is far above)."""
    file = scene_io.load(scene)
    exact = references.make(file.scene, file.scene.view.size).exact
    pixels = api.render(file, name, RENDERERS[name].probe_mode).pixels
    assert np.sqrt(np.mean((pixels - exact) ** 2)) < 0.008


@pytest.mark.parametrize("name", drawn_by(scene_io.load("edge").scene))
def test_another_size_keeps_the_vertical_extent(name: str) -> None:
    """Twice as wide at the same height: the middle is the same picture."""
    mode = RENDERERS[name].single_mode
    narrow = api.render("edge", name, mode, size=(64, 48)).pixels
    wide = api.render("edge", name, mode, size=(128, 48)).pixels
    assert np.array_equal(wide[:, 32:96], narrow)


INSIDE = Scene.model_validate(
    {
        "title": "inside",
        "shows": "the inner side",
        "view": {"size": (32, 24), "background": (0, 0, 0.5)},
        "camera": {
            "type": "perspective",
            "eye": (0.1, 0.2, 0.3),
            "look_at": (1, 0.3, 0),
            "vertical_fov_degrees": 70,
        },
        "materials": {"wall": {"emission": (0.5, 0.25, 0.75)}, "ball": {"emission": (0.125, 1, 0.25)}},
        "surfaces": [
            {"type": "sphere", "material": "wall", "centre": (0, 0, 0), "radius": 2},
            {"type": "sphere", "material": "ball", "centre": (1.2, 0.3, -0.2), "radius": 0.3},
        ],
    }
)


@pytest.mark.parametrize("name", drawn_by(INSIDE))
def test_a_camera_inside_a_sphere_sees_its_inner_side(name: str) -> None:
    """And what else is in there; with one sample a pixel, at the same places in all of them."""
    renderer = RENDERERS[name]
    pixels = renderer.render(Request(INSIDE, 32, 24, mode_of(renderer, renderer.single_mode))).pixels
    green = np.round(pixels[:, :, 1], 3)
    assert set(np.unique(green)) == {0.25, 1.0}
    frame = frame_of(INSIDE, (32, 24))
    x, y = np.meshgrid(np.arange(32) + 0.5, np.arange(24) + 0.5)
    u, v = (2 * x / 32 - 1) * frame.half_width, (1 - 2 * y / 24) * frame.half_height
    ray = frame.forward + u[..., np.newaxis] * frame.right + v[..., np.newaxis] * frame.up
    toward = np.array([1.2, 0.3, -0.2]) - frame.eye
    along = ray @ toward / np.linalg.norm(ray, axis=2)
    assert np.array_equal(green == 1.0, toward @ toward - along**2 < 0.09)
