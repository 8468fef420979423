"""Light, shadows, patterns and endless planes in OSMesa: the same pixels as the tracer's, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from aliascope.errors import Unsupported
from aliascope.model import LoadedMesh, Scene
from aliascope.native import raster
from aliascope.native.loading import module
from aliascope.renderers import embree, mode_of
from aliascope.renderers.base import Request, lacks
from aliascope.renderers.osmesa import RENDERER

Array = NDArray[np.float64]

LAMP = {"type": "point", "position": (1.31, 2.97, 1.53), "intensity": (0.9, 0.7, 0.5)}
NEAR_LAMP = LAMP | {"position": (-1.17, 1.91, 0.87), "intensity": (3.1, 2.7, 2.9), "falloff": "inverse-square"}
SUN = {"type": "directional", "direction": (0.61, -1.13, -0.47), "intensity": (0.5, 0.6, 0.7)}
LIGHTS = {"lamp": LAMP, "near lamp": NEAR_LAMP, "sun": SUN}

BALL = {"type": "sphere", "material": "matt", "centre": (-0.47, 0.43, -0.31), "radius": 0.53}
COIN = {"type": "disc", "material": "board", "centre": (0.61, 0.79, 0.17), "normal": (0.3, 1.0, 0.4), "radius": 0.47}
SAIL = {"type": "polygon", "material": "rings", "points": [(0.11, 0.31, 0.83), (0.97, 0.27, 0.71), (0.57, 1.13, 0.77)]}
WALL = {"type": "plane", "material": "matt", "point": (0.0, 0.0, -3.17), "normal": (0.4, 0.1, -1.3)}
FLOOR = {"type": "plane", "material": "board", "point": (0.0, -0.21, 0.0), "normal": (0.0, 2.0, 0.0)}
TABLE = {
    "type": "polygon",
    "material": "board",
    "points": [(-2.87, -0.19, -3.13), (-2.61, -0.19, 2.09), (2.79, -0.19, 2.41), (3.04, -0.19, -2.73)],
}
DARK = (0.2, 0.3, 0.4)
MATERIALS = {
    "matt": {"albedo": (0.8, 0.6, 0.4), "emission": (0.01, 0.02, 0.03)},
    "board": {
        "albedo": (0.7, 0.8, 0.9),
        "pattern": {"type": "checker", "scale": 0.83, "origin": (0.13, 0.29, 0.07), "colours": [DARK, (1, 1, 1)]},
    },
    "rings": {"albedo": (0.9, 0.5, 0.3), "pattern": {"type": "zone-plate", "scale": 3.1, "origin": (0.5, 0.4, 0.3)}},
    "glow": {"emission": (0.3, 0.2, 0.1)},
}  # fmt: skip
PERSPECTIVE = {
    "type": "perspective",
    "eye": (0.31, 1.87, 4.21),
    "look_at": (0.07, 0.31, 0),
    "vertical_fov_degrees": 38.0,
}
ORTHOGRAPHIC = {"type": "orthographic", "eye": (0.31, 1.87, 4.21), "look_at": (0.07, 0.31, 0), "height": 3.1}


def scene_of(surfaces: list[dict[str, Any]], lights: list[dict[str, Any]], **changed: Any) -> Scene:
    contents: dict[str, Any] = {
        "title": "t",
        "shows": "s",
        "view": {"size": (96, 72), "background": (0.05, 0.06, 0.07)},
        "camera": PERSPECTIVE,
        "materials": MATERIALS,
        "surfaces": surfaces,
        "lights": lights,
    }
    return Scene.model_validate(contents | changed)


def render(scene: Scene, mode: str) -> Array:
    pixels = RENDERER.render(Request(scene, *scene.view.size, mode_of(RENDERER, mode))).pixels
    return pixels.astype(np.float64)


def traced(scene: Scene, mode: str = "uniform:n=1,sampler=regular") -> Array:
    request = Request(scene, *scene.view.size, mode_of(embree.RENDERER, mode))
    return embree.RENDERER.render(request).pixels.astype(np.float64)


def without_edges(scene: Scene) -> NDArray[np.bool_]:
    """The pixels, (height, width), with no edge in their 3 x 3 neighbourhood: of a surface, a check or a shadow.

    An edge is a jump between neighbours in the tracer's picture of 4 x 4 times the pixels: shading changes by a few
    per cent at most from one to the next.
    """
    width, height = scene.view.size
    request = Request(scene, 4 * width, 4 * height, mode_of(embree.RENDERER, "uniform:n=1,sampler=regular"))
    fine = embree.RENDERER.render(request).pixels.astype(np.float64)
    low, high = ndimage.minimum_filter(fine, (3, 3, 1)), ndimage.maximum_filter(fine, (3, 3, 1))
    crossed = (high > 1.05 * low + 0.01).any(axis=2).reshape(height, 4, width, 4).any(axis=(1, 3))
    return ~ndimage.maximum_filter(crossed, 3)


CASTS = {
    "sphere": [TABLE, BALL],
    "disc": [TABLE, COIN],
    "polygon": [TABLE, SAIL],
    "plane": [FLOOR, WALL],
    "all": [FLOOR, WALL, BALL, COIN, SAIL],
    "a ball that does not take light": [FLOOR, BALL | {"material": "glow"}],
}


@pytest.mark.parametrize("camera", [PERSPECTIVE, ORTHOGRAPHIC], ids=["perspective", "orthographic"])
@pytest.mark.parametrize("lights", [["lamp"], ["near lamp"], ["sun"], ["lamp", "near lamp", "sun"]], ids=", ".join)
@pytest.mark.parametrize("surfaces", list(CASTS))
def test_lit_pixels_are_those_of_the_tracer(surfaces: str, lights: list[str], camera: dict[str, Any]) -> None:
    scene = scene_of(CASTS[surfaces], [LIGHTS[name] for name in lights], camera=camera)
    drawn, expected = render(scene, "none"), traced(scene)
    inner = without_edges(scene)
    assert inner.mean() > 0.3  # there is something left to compare
    # Both shade in double and round to float at the end, a few times on the way: 1e-4 is a thousand of those.
    assert np.abs(drawn - expected)[inner].max() < 1e-4
    # At edges one sample falls to one side or to the other, in float for the tracer and its shadow rays: but seldom.
    assert (np.abs(drawn - expected).max(axis=2) > 1e-4).mean() < 2e-3
    assert np.ptp(drawn[inner][:, 0]) > 0.1


def test_without_its_occluders_a_scene_is_brighter() -> None:
    """So that the scenes above have shadows at all: each occluder darkens pixels that do not show it."""
    for name in ("sphere", "disc", "polygon"):
        receiver, occluder = CASTS[name]
        bare = render(scene_of([receiver], [SUN]), "none")
        both = render(scene_of([receiver, occluder], [SUN]), "none")
        shown = render(scene_of([occluder | {"material": "glow"}], []), "none")[..., 0] > 0.2
        assert ((both < bare).all(axis=2) & ~shown).sum() > 20, name


@pytest.mark.parametrize(
    "surface",
    [
        TABLE,
        TABLE | {"points": TABLE["points"][::-1]},
        FLOOR,
        FLOOR | {"normal": (0.0, -0.5, 0.0)},
        COIN | {"radius": 9.0},
        COIN | {"radius": 9.0, "normal": (-0.3, -1.0, -0.4)},
    ],
    ids=["polygon", "polygon turned", "plane", "plane turned", "disc", "disc turned"],
)
def test_light_from_behind_gives_nothing(surface: dict[str, Any]) -> None:
    """The lamps lie below the floor, or the disc, which is seen from above."""
    lights = [LAMP | {"position": (0.3, -20.0, 0.2)}, SUN | {"direction": (0.1, 1.0, 0.1)}]
    scene = scene_of([surface | {"material": "matt"}], lights)
    pixels = render(scene, "none").reshape(-1, 3).astype(np.float32)
    allowed = np.array([MATERIALS["matt"]["emission"], scene.view.background], np.float32)
    assert (pixels[:, np.newaxis] == allowed).all(axis=2).any(axis=1).all()
    assert (pixels == allowed[0]).all(axis=1).any()


# Sample shading


def zone_plate() -> Scene:
    """Rings of up to 0.7 cycles a pixel, all of them within one triangle."""
    points = [(-9.0, -9.0, 0.0), (30.0, -9.0, 0.0), (-9.0, 30.0, 0.0)]
    pattern = {"type": "zone-plate", "scale": 18.0, "origin": (-1.71, -1.13, 0.0)}
    return scene_of(
        [{"type": "polygon", "material": "plate", "points": points}],
        [],
        camera={"type": "orthographic", "eye": (0, 0, 5), "look_at": (0, 0, 0), "height": 3.0},
        materials={"plate": {"emission": (1, 1, 1), "pattern": pattern}},
    )


def test_a_zone_plate_gains_by_sample_shading_and_by_nothing_else() -> None:
    scene = zone_plate()
    exact = traced(scene, "uniform:n=1024,sampler=regular")

    def rmse(pixels: Array) -> float:
        return float(np.sqrt(np.mean((pixels - exact) ** 2)))

    once = rmse(render(scene, "none"))
    np.testing.assert_array_equal(render(scene, "msaa"), render(scene, "none"))
    # Four independent samples would halve the error; these are spread over the pixel, and do better. A pattern that was
    # evaluated at one place four times would leave it as it is.
    each = rmse(render(scene, "msaa:sample-shading=1"))
    assert each < 0.5 * once
    # The same four places in four passes: equal but for the rounding of sums in float.
    passes = raster.Raster(scene, scene.view.size).render(raster.Passes(raster.sample_positions(), np.full(4, 0.25)))[0]
    np.testing.assert_allclose(render(scene, "msaa:sample-shading=1"), passes, rtol=0, atol=1e-6)
    assert rmse(render(scene, "msaa:n=8,sample-shading=1")) < 0.5 * once


@pytest.mark.parametrize("surfaces", ["sphere", "plane", "all"])
def test_sample_shading_is_four_passes_in_one(surfaces: str) -> None:
    """Light and shadows too: the samples' places in a pass each give the same picture, but for edges of polygons, which
    the rasteriser snaps anew in each pass."""
    scene = scene_of(CASTS[surfaces], [LAMP, SUN])
    passes = raster.Raster(scene, scene.view.size).render(raster.Passes(raster.sample_positions(), np.full(4, 0.25)))[0]
    differ = np.abs(render(scene, "msaa:sample-shading=1") - passes).max(axis=2) > 1e-6  # rounding of sums in float
    assert differ.mean() < 0.002
    assert (np.abs(render(scene, "msaa") - passes).max(axis=2) > 0.01).mean() > 0.02


# What is refused


def mesh_scene(count: int, lights: list[dict[str, Any]], material: str = "matt") -> Scene:
    corners = np.random.default_rng(7).uniform(-1.0, 1.0, (count, 3, 3))
    scene = scene_of([TABLE], lights)
    mesh = LoadedMesh(material=material, sha256="0" * 64, triangles=corners)
    return scene.model_copy(update={"surfaces": (mesh,)})


def test_more_surfaces_than_shadows_are_tested_for_are_an_empty_cell() -> None:
    most = raster.MOST_SHADOW_TESTS
    assert most == module("_raster", "OSMesa").lib.RASTER_MOST_SHADOW_TESTS
    none = mode_of(RENDERER, "none")
    for fine in (mesh_scene(most, [SUN]), mesh_scene(most // 2, [SUN, LAMP]), mesh_scene(most + 1, [])):
        assert lacks(RENDERER, fine, none) is None
    assert lacks(RENDERER, mesh_scene(most + 1, [SUN], "glow"), none) is None  # nothing takes light
    for scene, lights in (
        (mesh_scene(most + 1, [SUN]), "1 light:"),
        (mesh_scene(most // 2 + 1, [SUN, LAMP]), "2 lights:"),
    ):
        reason = lacks(RENDERER, scene, none)
        assert reason is not None
        assert f"triangles and {lights}" in reason
        assert str(most) in reason
        with pytest.raises(Unsupported, match="triangles"):  # the library holds the same rule
            render(scene, "none")


def test_the_mesh_that_may_just_be_drawn_is_drawn() -> None:
    scene = mesh_scene(raster.MOST_SHADOW_TESTS, [SUN])
    differ = np.abs(render(scene, "none") - traced(scene)).max(axis=2) > 1e-4
    # A heap of triangles is edges and shadows all over; a sample on the other side of one is seldom.
    assert differ.mean() < 0.02


def test_a_large_mesh_without_lights_is_drawn_as_the_tracer_draws_it() -> None:
    scene = mesh_scene(100_000, [], "glow").model_copy(update={"surfaces": mesh_scene(100_000, [], "rings").surfaces})
    glowing = {"rings": scene.materials["rings"].model_copy(update={"emission": (1.0, 0.5, 0.25)})}
    scene = scene.model_copy(update={"materials": scene.materials | glowing})
    differ = np.abs(render(scene, "none") - traced(scene)).max(axis=2) > 1e-4
    assert differ.mean() < 0.02  # as above
