"""The POV-Ray renderer on lit scenes: that they follow the shading equation, with all surfaces, patterns and lights."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from povray_scenes import Array, evaluate, mode, render, render_all, scene_of

from aliascope import api
from aliascope.model import LoadedMesh, Scene
from aliascope.renderers import povray
from aliascope.renderers.povray import RENDERER
from aliascope.renderers.povray_light import distances_to_triangles
from aliascope.renderers.povray_limits import FARTHEST, LIT_EXTENT, SHADOW_GAP, world_scale
from aliascope.scene_io import SceneFile

# Rounding to 16 bits is half a quantum; colours, lights and their sums are float32: a few times 2^-24, 6e-8.
QUANTA = 0.52


# The pictures


POINT = {"type": "point", "position": (1.3, 3.9, 2.1), "intensity": (0.31, 0.33, 0.29)}
NEAR = {"type": "point", "position": (-1.7, 2.3, 1.9), "intensity": (1.9, 1.7, 1.1), "falloff": "inverse-square"}
SUN = {"type": "directional", "direction": (0.37, -0.83, -0.41), "intensity": (0.27, 0.24, 0.23)}
CHECKS = {
    "type": "checker",
    "scale": 1.37,
    "origin": (0.131, 0.293, -0.217),
    "colours": [(0.2, 0.3, 0.4), (0.9, 0.8, 0.7)],
}
RINGS = {
    "type": "zone-plate",
    "scale": 2.71,
    "origin": (0.61, -0.52, -0.73),
    "colours": [(0.1, 0.1, 0.2), (0.8, 0.9, 1)],
}
MATERIALS: dict[str, dict[str, Any]] = {
    "floor": {"albedo": (0.8, 0.7, 0.6), "pattern": CHECKS},
    "red": {"albedo": (0.9, 0.2, 0.1)},
    "glow": {"albedo": (0.3, 0.0, 0.5), "emission": (0.05, 0.2, 0.0)},
    "lamp": {"emission": (0.1, 0.5, 0.7)},
    "rings": {"albedo": (0.5, 0.6, 0.4), "emission": (0.1, 0.05, 0.0), "pattern": RINGS},
}
SURFACES = [
    {"type": "plane", "material": "floor", "point": (0.3, -0.713, 0.2), "normal": (0.02, -1.9, 0.05)},
    {"type": "sphere", "material": "red", "centre": (0.83, 0.11, -0.31), "radius": 0.77},
    {"type": "sphere", "material": "glow", "centre": (-0.91, 0.27, 0.13), "radius": 0.59},
    {"type": "disc", "material": "lamp", "centre": (0.2, 1.3, -1.1), "normal": (0.3, 0.2, 1), "radius": 0.53},
    {
        "type": "polygon",
        "material": "rings",
        "points": [(-2, -0.5, -1.9), (2.3, -0.5, -1.9), (2, 1.9, -2), (-2, 1.9, -2)],
    },
]
VIEWS: dict[str, dict[str, Any]] = {
    "perspective": {"type": "perspective", "vertical_fov_degrees": 47.3},
    "orthographic": {"type": "orthographic", "height": 4.13},
}


def stage(view: str = "perspective", size: tuple[int, int] = (96, 64), **changed: Any) -> Scene:
    """Every kind of surface, pattern and light at once."""
    surfaces = [s | {"points": coplanar(s["points"])} if "points" in s else s for s in SURFACES]
    return scene_of(
        changed.get("surfaces", surfaces),
        MATERIALS,
        camera={"eye": (0.4, 1.7, 4.3), "look_at": (0.03, 0.21, -0.37), "up": (0.1, 1.0, 0.05), **VIEWS[view]},
        size=size,
        background=(0.05, 0.1, 0.2),
        lights=changed.get("lights", [POINT, NEAR, SUN]),
    )


def coplanar(points: Any) -> list[tuple[float, ...]]:
    """The points with the fourth moved into the plane of the first three."""
    a, b, c, d = (np.array(p, float) for p in points)
    normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
    return [tuple(p.tolist()) for p in (a, b, c, d - ((d - a) @ normal) * normal)]


@pytest.mark.parametrize("view", list(VIEWS))
def test_every_pixel_follows_the_shading_equation(view: str) -> None:
    scene = stage(view)
    rendering, expected = render(scene, "none"), evaluate(scene)
    assert rendering.quantum == 1.0 / 65535.0
    assert len(np.unique(expected.round(3).reshape(-1, 3), axis=0)) > 500  # it is a picture of many values
    np.testing.assert_allclose(rendering.pixels, expected, rtol=0, atol=QUANTA * rendering.quantum)


def flat_neighbours(picture: Array, tolerance: float) -> Array:
    """Pixels that differ from all eight neighbours by less than the tolerance; the border is left out."""
    inner = picture[1:-1, 1:-1]
    flat = np.zeros(picture.shape[:2], bool)
    height, width = picture.shape[:2]
    shifted = [picture[1 + y : height - 1 + y, 1 + x : width - 1 + x] for y in (-1, 0, 1) for x in (-1, 0, 1)]
    flat[1:-1, 1:-1] = np.logical_and.reduce([np.abs(s - inner).max(-1) < tolerance for s in shifted])
    return flat


@pytest.mark.parametrize("view", list(VIEWS))
def test_the_tracer_draws_the_same(view: str) -> None:
    """Where no edge passes: shading changes by up to 0.04 from pixel to pixel here, edges of shadows by more."""
    scene = stage(view, size=(128, 96))
    traced = api.render(SceneFile("stage", Path("stage.toml"), scene), "embree", "uniform:n=1,sampler=regular").pixels
    drawn = render(scene, "none").pixels
    flat = flat_neighbours(traced, 0.04)
    assert flat.mean() > 0.35  # rings, checks and shadows are most of the picture
    # The brief of both renderers; half a quantum is 1.5e-5, and the tracer's vertices are float32.
    np.testing.assert_allclose(drawn[flat], traced[flat], rtol=0, atol=1e-4)


ONE_SIDED: list[dict[str, Any]] = [
    {"type": "plane", "point": (0, 0, 0), "normal": (0, 0, 1)},
    {"type": "plane", "point": (0, 0, 0), "normal": (0, 0, -1)},
    {"type": "disc", "centre": (0, 0, 0), "normal": (0, 0, 1), "radius": 99.0},
    {"type": "disc", "centre": (0, 0, 0), "normal": (0, 0, -1), "radius": 99.0},
    {"type": "polygon", "points": [(-99, -99, 0), (99, -99, 0), (0, 99, 0)]},
    {"type": "polygon", "points": [(0, 99, 0), (99, -99, 0), (-99, -99, 0)]},
    {"type": "sphere", "centre": (0, 0, 0), "radius": 40.0},  # seen from within
]


def test_light_from_the_other_side_gives_nothing() -> None:
    """Both kinds of light before and behind each surface: whichever way its normal points, those before it count."""
    before: list[dict[str, Any]] = [
        {"type": "point", "position": (0.3, 0.2, 5.0), "intensity": (0.25, 0, 0)},
        {"type": "directional", "direction": (0, 0.6, -0.8), "intensity": (0, 0.5, 0)},
    ]
    behind: list[dict[str, Any]] = [
        {"type": "point", "position": (0.3, 0.2, -5.0), "intensity": (0.25, 0, 0)},
        {"type": "directional", "direction": (0, 0.6, 0.8), "intensity": (0, 0.5, 0.5)},
    ]
    materials = {"white": {"albedo": (1.0, 1.0, 1.0)}}
    scenes = [
        scene_of([{"material": "white", **surface}], materials, size=(8, 8), lights=before + behind)
        for surface in ONE_SIDED
    ]
    for scene, rendering in zip(scenes, render_all(scenes), strict=True):
        expected = evaluate(scene)
        if scene.surfaces[0].type == "sphere":
            assert expected[..., 1:].max() == 0.0  # it lets no sun in; both point lights are within
        else:
            np.testing.assert_allclose(expected[..., 1:], [[[0.4, 0.0]] * 8] * 8, rtol=0, atol=1e-12)
        np.testing.assert_allclose(rendering.pixels, expected, rtol=0, atol=QUANTA / 65535.0)


def test_inverse_square_falls_off_exactly() -> None:
    """A white plane that faces the camera, lit from a distance before its middle: I d / (d^2 + r^2)^1.5."""
    distances, scenes = (0.01, 1.7, 1e4), []
    for d in distances:
        light = {"type": "point", "position": (0, 0, d), "intensity": (0.9 * d**2,) * 3, "falloff": "inverse-square"}
        camera = {"type": "orthographic", "eye": (0, 0, 9), "look_at": (0, 0, 0), "height": 4 * d}
        plane = {"type": "plane", "material": "white", "point": (0, 0, 0), "normal": (0, 0, 1)}
        scenes.append(scene_of([plane], {"white": {"albedo": (1, 1, 1)}}, camera, (24, 16), lights=[light]))
    u, v = np.meshgrid(np.arange(24) + 0.5 - 12, np.arange(16) + 0.5 - 8)
    for d, rendering in zip(distances, render_all(scenes), strict=True):
        expected = 0.9 * d**3 / (d**2 + (u**2 + v**2) * (d / 4) ** 2) ** 1.5
        assert rendering.quantum == 1.0 / 65535.0  # the bound of the light is tight here: 0.9 at the foot
        # 1e-6: what POV-Ray's own fall-off differs by (FADE_SHARE squared).
        np.testing.assert_allclose(rendering.pixels[..., 0], expected, rtol=1e-6, atol=QUANTA / 65535.0)


def test_a_wall_on_a_floor_leaks_no_light() -> None:
    """Their line of contact, in pixels of 1/8000: behind the wall, which is lit from its other side, the floor is dark
    up to it. POV-Ray alone has no shadows nearer than SHADOW_GAP, 8 pixels here."""
    lights: list[dict[str, Any]] = [
        {"type": "point", "position": (3.0, 0.4, 1.1), "intensity": (0.9,) * 3},
        {"type": "directional", "direction": (-3.0, -0.4, -1.1), "intensity": (0.9,) * 3},
    ]
    surfaces = [
        {"type": "polygon", "points": [(-0.5, -0.5, 0), (0.6, -0.5, 0), (0, 0.7, 0)]},
        {"type": "polygon", "points": [(1.3e-4, -0.3, -0.2), (4e-4, 0.4, -0.2), (2.7e-4, 0.05, 0.3)]},
    ]
    camera = {"type": "orthographic", "eye": (-0.5, 0.1, 1), "look_at": (0, 0, 0), "height": 0.004}
    materials = {"white": {"albedo": (1, 1, 1)}}
    scenes = [
        scene_of([{"material": "white"} | each for each in surfaces], materials, camera, (48, 32), lights=[light])
        for light in lights
    ]
    for scene, rendering in zip(scenes, render_all(scenes), strict=True):
        assert SHADOW_GAP / world_scale(scene) < 2e-7
        assert evaluate(scene).max() == 0.0
        assert rendering.pixels.max() == 0.0


def test_a_mesh_is_its_triangles_in_double() -> None:
    """A height field 1e5 from the origin, whose float32 vertices would lie a quarter of a pixel off."""
    far = np.array([1e5, -2e5, 3e5])
    grid = np.linspace(-2.03, 2.11, 14)
    x, y = np.meshgrid(grid, grid, indexing="ij")
    z = 0.4 * np.sin(1.7 * x) * np.cos(1.3 * y)
    points = np.stack([x, y, z], -1) + far
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    triangles = np.concatenate([np.stack(t, -2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])
    camera = {
        "type": "perspective",
        "vertical_fov_degrees": 40.0,
        "eye": tuple(far + np.array([0.7, -3.1, 4.3])),
        "look_at": tuple(far),
    }
    lights = [
        {"type": "point", "position": tuple(far + np.array([3.1, 2.2, 2.7])), "intensity": (0.6,) * 3},
        {"type": "directional", "direction": (0.4, 0.2, -0.7), "intensity": (0.1, 0.2, 0.3)},
    ]
    scene = scene_of([], {"white": {"albedo": (0.9, 1, 1)}}, camera=camera, size=(64, 48), lights=lights)
    mesh = LoadedMesh(material="white", sha256="0" * 64, triangles=triangles)
    scene = scene.model_copy(update={"surfaces": (mesh,)})
    assert "mesh" in scene.features()
    got, expected = render(scene, "none").pixels, evaluate(scene)
    off = np.abs(got - expected).max(-1) > QUANTA / 65535.0
    # Coordinates of 3e5 in double are known to 6e-11; a point that near an edge of a triangle may fall either way.
    assert off.sum() <= 1
    assert expected.std() > 0.05


def test_bright_light_keeps_the_threshold_of_antialiasing(monkeypatch: pytest.MonkeyPatch) -> None:
    """At an exposure, +AM1 compares darker colours, with a threshold that was lowered as much: the same samples as in
    EXR, which has no exposure."""
    scene = stage(lights=[SUN | {"intensity": (2.0, 3.0, 4.3)}])
    text = "am1:depth=3,threshold=0.15,jitter=0"
    exposed = render(scene, text)
    assert exposed.quantum == 4.0 / 65535.0
    monkeypatch.setattr(povray, "LARGEST_EXPOSURE", 0.0)
    half = render(scene, text)
    assert half.quantum > exposed.quantum
    assert half.cost.samples == exposed.cost.samples > 96 * 64
    np.testing.assert_allclose(exposed.pixels, half.pixels, rtol=2.0**-11, atol=exposed.quantum)


def test_the_world_is_scaled_by_a_power_of_two_that_keeps_it_in_reach() -> None:
    for scene in (stage(), stage("orthographic"), stage(lights=[]), stage(surfaces=SURFACES[1:3])):
        assert np.log2(world_scale(scene)) % 1.0 == 0.0
        assert RENDERER.unable(scene, mode("none")) is None
    spheres = stage(surfaces=SURFACES[1:3])
    assert LIT_EXTENT / 16 < world_scale(spheres) <= LIT_EXTENT / 4
    assert world_scale(stage(surfaces=SURFACES[1:3], lights=[])) == 1.0


def test_a_plane_reaches_to_its_horizon() -> None:
    """2,000 rows of pixels: the last half pixel before the horizon is there; and from 3,000 km up, a plane is, too."""
    plane = {"type": "plane", "material": "white", "point": (0, 0, 0), "normal": (0, 1, 0)}
    materials = {"white": {"emission": (1, 1, 1)}}
    camera = {"type": "perspective", "vertical_fov_degrees": 40.0, "eye": (0, 2, 0), "look_at": (0, 2, -1)}
    scene = scene_of([plane], materials, camera=camera, size=(4, 2000))
    column = render(scene, "none").pixels[:, 1, 0]
    assert column[:1000].max() == 0.0
    assert column[1000:].min() == 1.0
    low = {"eye": (0.0, 3e6, 0.0), "look_at": (0.0, 2e6, -1e6)}
    high = scene.model_copy(update={"camera": scene.camera.model_copy(update=low)})
    assert render(high, "none").pixels[1999, 1, 0] == 1.0
    assert 3e6 * world_scale(high) < FARTHEST


def test_distances_to_triangles() -> None:
    """Against the least of a fine grid of points of the triangle, which is up to its spacing farther."""
    rng = np.random.default_rng(7)
    triangles = rng.normal(size=(40, 3, 3))
    steps = np.linspace(0, 1, 101)
    weights = np.array([(a, b, 1 - a - b) for a in steps for b in steps if a + b <= 1 + 1e-9])
    for place in (np.zeros(3), np.array([0.3, -2.0, 1.1])):
        grid = np.linalg.norm(np.einsum("wi,tij->twj", weights, triangles) - place, axis=-1).min(axis=1)
        found = distances_to_triangles(triangles, place)
        assert (found <= grid + 1e-12).all()
        assert (grid - found).max() < 0.05  # edges are up to 5 long, the grid's spacing then 0.05


@pytest.mark.parametrize(
    ("lights", "reason"),
    [
        ([NEAR | {"position": (0.83, 0.11, 0.46)}], "may reach"),  # on the red sphere
        ([SUN | {"intensity": (1e5, 0, 0)}], "may reach"),
        ([POINT | {"position": (0.83, 0.11, 0.46)}], None),  # without a fall-off that is no brighter
    ],
)
def test_lights_it_cannot_have(lights: list[dict[str, Any]], reason: str | None) -> None:
    found = RENDERER.unable(stage(lights=lights), mode("none"))
    assert (reason in (found or "")) if reason else found is None
