"""Lights within solids, on surfaces, in their planes and through them: every renderer gives a finite picture, the one
that `scenes/README.md` describes, or says why it has none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aliascope.model import Scene
from aliascope.renderers import base, embree, mode_of, osmesa, povray

Array = NDArray[np.float64]

SIZE = (24, 18)
RENDERERS = {"embree": embree.RENDERER, "osmesa": osmesa.RENDERER, "povray": povray.RENDERER}
ONE_SAMPLE = {"embree": "uniform:n=1,sampler=regular", "osmesa": "none", "povray": "none"}
CORNERS = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)]
FLOOR = {"type": "polygon", "material": "matt", "points": [(x, 0.0, z) for x, z in CORNERS]}
SLOPE = {"type": "polygon", "material": "matt", "points": [(x, 0.13 * x + 0.07 * z, z) for x, z in CORNERS]}
WALL = {"type": "polygon", "material": "matt", "points": [(-9, -9, -4), (9, -9, -4), (9, 9, -4), (-9, 9, -4)]}
BALL = {"type": "sphere", "material": "matt", "centre": (0.3, 1.1, -0.7), "radius": 0.9}
AIMED = {"type": "orthographic", "eye": (0.0, 3.0, 0.0), "look_at": (0.0, 0.0, 0.0), "up": (0, 0, -1), "height": 1.8}


def scene_of(surfaces: list[dict[str, Any]], *lights: dict[str, Any], **camera: Any) -> Scene:
    eye = {"type": "perspective", "eye": (0.7, 2.3, 5.9), "look_at": (0.1, 0.4, 0), "vertical_fov_degrees": 47.0}
    return Scene.model_validate(
        {
            "title": "t",
            "shows": "s",
            "view": {"size": SIZE},
            "camera": camera or eye,
            "materials": {"matt": {"albedo": (0.8, 0.7, 0.6)}, "glow": {"emission": (1.0, 1.0, 1.0)}},
            "surfaces": surfaces,
            "lights": [{"intensity": (1, 1, 1), **light} for light in lights],
        }
    )


def drawn(renderer: str, scene: Scene, mode: str | None = None) -> Array:
    parsed = mode_of(RENDERERS[renderer], mode or ONE_SAMPLE[renderer])
    assert base.lacks(RENDERERS[renderer], scene, parsed) is None
    return RENDERERS[renderer].render(base.Request(scene, *SIZE, parsed)).pixels.astype(np.float64)


@pytest.mark.parametrize("falloff", ["none", "inverse-square"])
@pytest.mark.parametrize("renderer", RENDERERS)
def test_a_lamp_in_an_opaque_sphere_lights_its_inside_alone(renderer: str, falloff: str) -> None:
    lamp = {"type": "point", "position": (0.5, 1.2, -0.9), "falloff": falloff}
    assert not drawn(renderer, scene_of([FLOOR, WALL, BALL], lamp)).any()
    within = {"type": "perspective", "eye": (0.2, 1.0, -0.2), "look_at": (0.5, 1.2, -3.0), "vertical_fov_degrees": 80.0}
    inside = drawn(renderer, scene_of([FLOOR, WALL, BALL], lamp, **within))
    assert inside.min() > 0.3
    # Of the nearest place, 0.48 away, 2.8 comes back; the exposure for that has steps of 8 / 65535.
    np.testing.assert_allclose(
        inside,
        drawn("embree", scene_of([BALL], lamp, **within)),
        rtol=2e-6,
        atol=1e-4 if renderer == "povray" else 1e-6,
    )


@pytest.mark.parametrize("renderer", RENDERERS)
def test_a_lamp_on_a_surface_lights_what_lies_to_both_of_its_sides(renderer: str) -> None:
    """And that surface not at all: it sees the lamp edge-on."""
    lamp = {"type": "point", "position": (0.4, 0.13 * 0.4 - 0.07 * 1.1, -1.1)}
    for height in (2.3, -2.3):
        eye = {"type": "perspective", "eye": (0.7, height, 5.9), "look_at": (0.1, 0.2 * height, 0)}
        eye["vertical_fov_degrees"] = 47.0
        seen, free = (drawn(renderer, scene_of(surfaces, lamp, **eye)) for surfaces in ([SLOPE, WALL], [WALL]))
        is_wall = drawn(renderer, scene_of([SLOPE, {**WALL, "material": "glow"}], lamp, **eye))[:, :, 0] == 1.0
        assert 0.1 < is_wall.mean() < 0.9
        np.testing.assert_allclose(seen[is_wall], free[is_wall], rtol=0, atol=1e-5 if renderer == "povray" else 1e-7)
        assert np.abs(seen[~is_wall]).max() < 1e-6


@pytest.mark.parametrize("falloff", ["none", "inverse-square"])
@pytest.mark.parametrize("renderer", RENDERERS)
def test_a_pixel_that_looks_at_a_lamp_in_the_floor_is_finite(renderer: str, falloff: str) -> None:
    """Its centre, and with it the one ray, goes to a lamp itself, but for a rounding, which could be of any size beside
    a distance that is none but a rounding."""
    places = [(0.05 + 0.1 * x, 0.05 + 0.1 * z) for x in (-9, -2, 0, 3, 8) for z in (-7, -1, 0, 5)]
    lamps = [{"type": "point", "position": (x, 0.13 * x + 0.07 * z, z), "falloff": falloff} for x, z in places]
    scene = scene_of([SLOPE], *lamps, **AIMED)
    reason = base.lacks(RENDERERS[renderer], scene, mode_of(RENDERERS[renderer], ONE_SAMPLE[renderer]))
    if reason:
        assert (renderer, falloff) == ("povray", "inverse-square")
        assert "may reach inf" in reason
        return
    pixels = drawn(renderer, scene)
    assert np.isfinite(pixels).all()
    # POV-Ray lights the very place of a lamp from wherever rounding has left it.
    assert np.abs(pixels).max() < (1.0 if renderer == "povray" else 1e-6)


@pytest.mark.parametrize("falloff", ["none", "inverse-square"])
def test_a_light_in_the_ceiling_is_not_hidden_by_it(falloff: str) -> None:
    """It lies in the ceiling's plane: to the bit as if there were none, where the ceiling is not seen."""
    light = {"type": "area", "corner": (-0.5, 2.7, -1.3), "edges": [(1.2, 0, 0), (0, 0, 1.1)], "falloff": falloff}
    ceiling = {**FLOOR, "points": [(x, 2.7, z) for x, z in CORNERS]}
    looking_down = {"type": "perspective", "eye": (0.3, 2.1, 3.2), "look_at": (0, 0, 0), "vertical_fov_degrees": 40.0}
    mode = "uniform:n=16"
    bare, under = (
        drawn("embree", scene_of(surfaces, light, **looking_down), mode)
        for surfaces in ([FLOOR, BALL], [FLOOR, BALL, ceiling])
    )
    assert bare.max() > 0.04
    assert np.array_equal(bare, under)


LARGE = {"type": "area", "corner": (-0.7, -0.8, -1.7), "edges": [(1.5, 0, 0), (0, 1.6, 0)]}
UPPER = {"type": "area", "corner": (-0.7, 0.0, -1.7), "edges": [(1.5, 0, 0), (0, 0.8, 0)]}


def test_of_a_light_that_crosses_a_surface_each_side_gets_its_part() -> None:
    """Half of it lies below the floor, which hides that half from the wall and the ball, and faces the other half."""
    half, upper = (drawn("embree", scene_of([FLOOR, WALL, BALL], light), "uniform:n=256") for light in (LARGE, UPPER))
    assert upper.max() > 0.3
    assert np.abs(half - 0.5 * upper).max() < 0.02  # 256 points of the light, and as many of its half
    assert np.abs(np.mean(half - 0.5 * upper)) < 5e-4


SUNKEN: list[dict[str, Any]] = [
    LARGE | {"falloff": "inverse-square"},
    {"type": "disc", "centre": (0.1, 0.0, -1.2), "normal": (0.3, 1.0, 0.2), "radius": 0.7, "falloff": "inverse-square"},
    {"type": "sphere", "centre": (0.1, 0.1, -1.2), "radius": 0.7, "falloff": "inverse-square"},
    {"type": "sphere", "centre": (0.1, 0.7, -1.2), "radius": 0.7},
    {"type": "disc", "centre": (0.1, 0.0, -1.2), "normal": (0.0, 1.0, 0.0), "radius": 0.7, "falloff": "inverse-square"},
]


@pytest.mark.parametrize("light", SUNKEN)
def test_lights_through_surfaces_give_finite_pixels(light: dict[str, Any]) -> None:
    pixels = drawn("embree", scene_of([FLOOR, WALL, BALL], light), "uniform:n=64")
    assert np.isfinite(pixels).all()
    assert pixels.min() >= 0.0
    assert pixels.max() > 0.01


@pytest.mark.parametrize("kind", ["area", "disc", "sphere"])
def test_a_light_in_an_opaque_sphere_is_dark_outside(kind: str) -> None:
    shapes = {
        "area": {"corner": (0.2, 1.0, -0.8), "edges": [(0.2, 0, 0), (0, 0, 0.2)]},
        "disc": {"centre": (0.3, 1.1, -0.7), "normal": (0.0, 1.0, 0.0), "radius": 0.3},
        "sphere": {"centre": (0.3, 1.1, -0.7), "radius": 0.3},
    }
    assert not drawn("embree", scene_of([FLOOR, WALL, BALL], {"type": kind, **shapes[kind]}), "uniform:n=16").any()
