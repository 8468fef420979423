"""OSMesa's lens, motion and lights with an area, as sums of passes: against the tracer, sample by sample and converged,
and against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate, stats
from test_osmesa_light import BALL, CASTS, COIN, FLOOR, LAMP, ORTHOGRAPHIC, PERSPECTIVE, SAIL, SUN, WALL, scene_of

from aliascope import scene_io
from aliascope.errors import InvalidInput, Unsupported
from aliascope.model import Frames, LoadedMesh, Scene
from aliascope.native import raster, samplers
from aliascope.renderers import embree, mode_of
from aliascope.renderers.base import Request, lacks
from aliascope.renderers.osmesa import RENDERER, passes_of

Array = NDArray[np.float64]

ROUND = PERSPECTIVE | {"lens_radius": 0.21, "focus_distance": 4.3}
BLADES = ROUND | {"blades": 5}
SHUTTER = {"shutter": (0.1, 0.8), "response": "triangle"}

MOVES = {"type": "translate", "by": (0.3, 0.2, -0.4)}
TURNS = {"type": "rotate", "axis": (0.2, 1.0, 0.3), "centre": (0.1, 0.2, 0.1), "degrees": 50.0}
TILTS = {"type": "rotate", "axis": (0.1, 1.0, 0.0), "centre": (0.1, 0.2, 0.1), "degrees": 20.0}
MOVING = [
    FLOOR | {"motion": TILTS},
    WALL,
    BALL | {"motion": MOVES},
    COIN | {"motion": TURNS},
    SAIL | {"motion": TURNS},
]

AREA = {"type": "area", "corner": (0.8, 2.3, 0.4), "edges": ((0.9, -0.2, 0.1), (0.0, 0.1, 1.1))}
DISC = {"type": "disc", "centre": (-1.5, 2.1, 1.1), "normal": (0.4, -1.0, -0.2), "radius": 0.6}
SPHERE = {"type": "sphere", "centre": (0.3, 2.2, 0.9), "radius": 0.5}
EVEN, FADING = {"intensity": (0.4, 0.5, 0.3)}, {"intensity": (2.1, 1.7, 1.9), "falloff": "inverse-square"}
LIGHTS = [each | kind for each in (AREA, DISC, SPHERE) for kind in (EVEN, FADING)]

SCENES = {
    "round lens": scene_of(CASTS["all"], [LAMP, SUN], camera=ROUND),
    "blades": scene_of(CASTS["all"], [LAMP, SUN], camera=BLADES),
    "motion": scene_of(MOVING, [LAMP, SUN], camera=PERSPECTIVE | SHUTTER),
    "motion, orthographic": scene_of(MOVING, [LAMP, SUN], camera=ORTHOGRAPHIC | SHUTTER),
    "area": scene_of(CASTS["all"], [AREA | EVEN]),
    "area, fading": scene_of(CASTS["all"], [AREA | FADING]),
    "disc": scene_of(CASTS["all"], [DISC | EVEN]),
    "disc, fading": scene_of(CASTS["all"], [DISC | FADING]),
    "sphere": scene_of(CASTS["all"], [SPHERE | EVEN]),
    "sphere, fading": scene_of(CASTS["all"], [SPHERE | FADING]),
    "everything": scene_of(MOVING, [LAMP, *LIGHTS], camera=BLADES | SHUTTER),
}


def drawn(scene: Scene, mode: str, seed: int = 0, renderer: Any = RENDERER) -> Array:
    request = Request(scene, *scene.view.size, mode_of(renderer, mode), seed)
    return renderer.render(request).pixels.astype(np.float64)


# Against the tracer


@pytest.mark.parametrize("name", list(SCENES))
def test_a_pass_is_the_tracers_sample(name: str) -> None:
    """The points of halton are the same in all pixels: then a pass holds, pixel by pixel, what the tracer's sample of
    that number finds. All are in the mean, so that one that was off would show."""
    scene, count = SCENES[name], 8
    seen = drawn(scene, f"accumulate:n={count}")
    wanted = drawn(scene, f"uniform:n={count},sampler=halton", renderer=embree.RENDERER)
    differ = np.abs(seen - wanted).max(axis=2)
    # Both shade in double; 1e-4 is a thousand roundings of float. Where a sample lies next to an edge, float decides on
    # which side, as do the corners that OSMesa snaps and the straight lines of the tracer's motion.
    assert (differ > 1e-4).mean() < 0.005
    assert np.median(differ) < 1e-6
    assert wanted.std() > 0.04
    assert np.abs(drawn(scene, "accumulate:n=1") - wanted).mean() > 0.002  # each pass is another picture


@pytest.mark.parametrize("name", ["blades", "motion", "everything"])
def test_converged_pictures_are_the_tracers(name: str) -> None:
    """Eight scrambled pictures of each, with 64 samples: Welch's t for each value, each block of 8 x 8, the whole."""
    scene = SCENES[name].model_copy(update={"view": SCENES[name].view.model_copy(update={"size": (32, 24)})})
    sampler = "sampler=sobol,sampler.scramble=owen"
    both = [
        np.array([drawn(scene, f"{mode}:n=64,{sampler}", seed, renderer) for seed in range(first, first + 8)])
        for mode, renderer, first in (("accumulate", RENDERER, 1), ("uniform", embree.RENDERER, 101))
    ]

    def limits(pictures: list[Array]) -> Array:
        """The share of the limit that each difference makes, at a significance of 1e-3 over all (Bonferroni)."""
        variances = [each.var(axis=0, ddof=1) / len(each) for each in pictures]
        deviation = np.sqrt(sum(variances))
        with np.errstate(invalid="ignore", divide="ignore"):
            degrees = deviation**4 / sum(variance**2 / 7 for variance in variances)
        limit = stats.t.isf(0.5e-3 / deviation.size, np.nan_to_num(degrees, nan=7.0)) * deviation
        # Values that all samples agree on scatter by float's rounding alone.
        return np.asarray(np.abs(pictures[0].mean(axis=0) - pictures[1].mean(axis=0)) / (limit + 2e-6))

    blocks = [each.reshape(8, 3, 8, 4, 8, 3).mean(axis=(2, 4)) for each in both]
    whole = [each.mean(axis=(1, 2)) for each in both]
    # OSMesa's edges lie up to .0014 pixel off in the mean (raster.h): with a step of 1 across an edge in every pixel
    # of a block that would be .0014, and is far less here.
    assert limits(both).max() <= 1.0
    assert limits(blocks).max() <= 1.0
    assert limits(whole).max() <= 1.0
    brighter = [both[0] * 1.01, both[1]]
    assert limits([each.mean(axis=(1, 2)) for each in brighter]).max() > 1.0  # the test can fail


def crumpled(material: str, **more: Any) -> Scene:
    """24 triangles in three frames of other shapes, and one that stands still, over the floor."""
    random = np.random.default_rng(5)
    shape = random.normal(0.0, 0.4, (24, 3, 3)) + random.uniform((-1.2, 0.6, -1.0), (1.2, 1.4, 1.0), (24, 1, 3))
    frames = shape + np.cumsum(random.normal(0.0, 0.2, (3, 24, 3, 3)), axis=0)
    going = Frames(type="frames", files=("1.ply", "2.ply", "3.ply"))  # of the names nothing depends on
    mesh = LoadedMesh(material=material, sha256="", triangles=shape, motion=going, frames=frames)
    still = LoadedMesh(material=material, sha256="", triangles=shape[:1] + 0.3)
    scene = scene_of([FLOOR, SAIL | {"motion": TURNS}], [LAMP, SUN], camera=PERSPECTIVE | SHUTTER)
    return scene.model_copy(update={"surfaces": (*scene.surfaces, still, mesh)})


def test_a_mesh_of_frames_is_the_tracers() -> None:
    scene = crumpled("matt")
    seen = drawn(scene, "accumulate:n=8")
    wanted = drawn(scene, "uniform:n=8,sampler=halton", renderer=embree.RENDERER)
    differ = np.abs(seen - wanted).max(axis=2)
    assert (differ > 1e-4).mean() < 0.01  # next to edges, of which there are many, float decides
    assert np.median(differ) < 1e-6
    assert np.abs(drawn(scene, "accumulate:n=1") - wanted).mean() > 0.01


def test_a_pattern_that_is_stretched_is_an_empty_cell() -> None:
    scene = crumpled("rings")
    assert "stretches its pattern" in (lacks(RENDERER, scene, mode_of(RENDERER, "accumulate")) or "")
    with pytest.raises(Unsupported, match="has a pattern and a motion of frames"):  # the library holds the same rule
        drawn(scene, "accumulate")


# Against closed forms


FLAT = {"white": {"emission": (1.0, 1.0, 1.0)}}
WIDTH, HEIGHT = 24, 4


def half_plane(depth: float, **more: Any) -> dict[str, Any]:
    """All that lies to the right of x = 0.1 at a depth before the eye."""
    points = [(0.1, -99.0, -depth), (99.0, -99.0, -depth), (99.0, 99.0, -depth), (0.1, 99.0, -depth)]
    return {"type": "polygon", "material": "white", "points": points} | more


def seen_from_the_origin(surface: dict[str, Any], **camera: Any) -> Scene:
    eye = {"type": "perspective", "eye": (0, 0, 0), "look_at": (0, 0, -1), "vertical_fov_degrees": 20.0}
    return scene_of([surface], [], camera=eye | camera, materials=FLAT, view={"size": (WIDTH, HEIGHT)})


def assert_columns(scene: Scene, wanted: Array) -> None:
    """The picture's columns are those, by 16 scrambled pictures of 512 passes: Student's t at a significance of 1e-4
    over all columns (Bonferroni), and .0014 of a step of 1 for the place of OSMesa's edges (raster.h)."""
    text = "accumulate:n=512,sampler=sobol,sampler.scramble=owen"
    columns = np.array([drawn(scene, text, seed)[..., 0].mean(axis=0) for seed in range(16)])
    deviation = columns.std(axis=0, ddof=1) / 4.0
    assert deviation.max() < 2e-3
    steepest = np.abs(np.diff(wanted)).max()
    limit = stats.t.isf(0.5e-4 / WIDTH, 15) * deviation + 0.0014 * steepest + 1e-6
    assert (np.abs(columns.mean(axis=0) - wanted) <= limit).all()


@pytest.mark.parametrize(("depth", "focus"), [(3.0, 5.0), (9.0, 5.0)])
def test_a_defocused_edge_is_a_circular_segment(depth: float, focus: float) -> None:
    """A point of the edge's plane is spread over a disc in the picture, of which the edge cuts a segment: its share is
    1 - (acos s - s sqrt(1 - s^2)) / pi at a distance of s radii."""
    pixel = 2.0 * np.tan(np.radians(10.0)) / HEIGHT
    radius = 5.3 * pixel / abs(1.0 / depth - 1.0 / focus)

    def share(x: float) -> float:
        s = float(np.clip((x - 0.1 / depth / pixel) / 5.3, -1.0, 1.0))
        return 1.0 - (np.arccos(s) - s * np.sqrt(1.0 - s * s)) / np.pi

    scene = seen_from_the_origin(half_plane(depth), lens_radius=radius, focus_distance=focus)
    left = np.arange(WIDTH) - WIDTH / 2
    wanted = np.array([integrate.quad(share, x, x + 1.0)[0] for x in left])
    assert ((wanted > 0.01) & (wanted < 0.99)).sum() >= 9
    assert_columns(scene, wanted)


@pytest.mark.parametrize("response", ["box", "triangle"])
def test_a_translating_edge_is_the_distribution_of_the_response(response: str) -> None:
    pixel, depth, opening, closing = 2.0 * np.tan(np.radians(10.0)) / HEIGHT, 4.0, 0.2, 0.9
    speed = 11.7 * pixel * depth
    moves = {"type": "translate", "by": (speed, 0.7, 0.0)}
    scene = seen_from_the_origin(half_plane(depth, motion=moves), shutter=(opening, closing), response=response)
    law = stats.uniform() if response == "box" else stats.triang(0.5)
    start = 0.1 / depth / pixel + opening * 11.7
    x = np.arange(WIDTH * 512) / 512 + 1 / 1024 - WIDTH / 2
    wanted = law.cdf((x - start) / (11.7 * (closing - opening))).reshape(WIDTH, -1).mean(axis=1)
    assert ((wanted > 0.01) & (wanted < 0.99)).sum() >= 7
    assert_columns(scene, wanted)


def irradiance(corners: Array, point: Array, normal: Array) -> float:
    """Of a polygon of radiance 1 (Lambert 1760): half the sum over its edges of the angle times the cosine."""
    to = corners - point
    to /= np.linalg.norm(to, axis=1)[:, np.newaxis]
    total = 0.0
    for a, b in zip(to, np.roll(to, -1, axis=0), strict=True):
        across = np.cross(a, b)
        total += np.arccos(np.clip(a @ b, -1.0, 1.0)) * (across @ normal) / np.linalg.norm(across)
    return abs(0.5 * total)


def test_a_parallelogram_gives_lamberts_irradiance() -> None:
    floor = {"type": "plane", "material": "white", "point": (0.0, 0.0, 0.0), "normal": (0.0, 1.0, 0.0)}
    lamp = {"type": "area", "corner": (-0.4, 1.7, -0.3), "edges": ((1.1, 0.2, 0.1), (0.1, 0.3, 0.9))}
    camera = {"type": "orthographic", "eye": (0, 9, 0), "look_at": (0, 0, 0), "up": (0, 0, -1), "height": 3.0}
    scene = scene_of(
        [floor],
        [lamp | {"intensity": (1, 1, 1), "falloff": "inverse-square"}],
        camera=camera,
        materials={"white": {"albedo": (1, 1, 1)}},
        view={"size": (8, 6)},
    )
    corner, (a, b) = np.array(lamp["corner"]), np.array(lamp["edges"])
    corners = np.array([corner, corner + a, corner + a + b, corner + b])
    radiance = np.pi / np.linalg.norm(np.cross(a, b))
    # All passes through the pixels' centres.
    count = 1024
    points = samplers.points("lattice", count, 4)
    passes = raster.Passes(np.full((count, 2), 0.5), np.full(count, 1 / count), lights=points[:, np.newaxis, 2:])
    seen = raster.Raster(scene, (8, 6)).render(passes)[0][..., 0]
    wanted = np.array(
        [
            [
                radiance / np.pi * irradiance(corners, np.array([0.5 * x - 1.75, 0.0, 0.5 * y - 1.25]), np.eye(3)[1])
                for x in range(8)
            ]
            for y in range(6)
        ]
    )
    assert wanted.max() > 2.0 * wanted.min()
    np.testing.assert_allclose(seen, wanted, rtol=2e-3)  # the lattice: 1e-3 measured
    turned = scene.lights[0].model_copy(update={"edges": lamp["edges"][::-1]})
    dark = raster.Raster(scene.model_copy(update={"lights": (turned,)}), (8, 6)).render(passes)[0]
    assert not dark.any()  # it shines to its other side


# Modes


@pytest.mark.parametrize(
    ("name", "missing"),
    [("blades", "a lens"), ("motion", "motion"), ("area", "lights with an area")],
)
def test_other_modes_say_that_accumulate_draws_it(name: str, missing: str) -> None:
    for text in ("none", "msaa", "msaa:n=8"):
        mode = mode_of(RENDERER, text)
        reason = lacks(RENDERER, SCENES[name], mode)
        assert reason == f"{mode.name} of OSMesa does not draw {missing}: accumulate does, a sum over passes"
        with pytest.raises(Unsupported, match="accumulate"):
            drawn(SCENES[name], text)
    assert lacks(RENDERER, SCENES[name], mode_of(RENDERER, "accumulate")) is None


def test_a_pattern_without_the_dimensions_is_an_empty_cell() -> None:
    mode = mode_of(RENDERER, "accumulate:n=4,sampler=standard-msaa")
    assert lacks(RENDERER, scene_of(CASTS["all"], [SUN]), mode) is None
    assert "dimension" in (lacks(RENDERER, SCENES["motion"], mode) or "")
    cook = mode_of(RENDERER, "accumulate:n=16,sampler=cook")
    assert lacks(RENDERER, SCENES["motion"], cook) is None
    assert RENDERER.seeded(cook)
    assert lacks(RENDERER, SCENES["blades"], cook) is not None


def test_needs_have_dimensions_of_their_own() -> None:
    passes = passes_of(mode_of(RENDERER, "accumulate:n=32"), SCENES["everything"])
    points = samplers.points("halton", 32, 17)
    np.testing.assert_array_equal(passes.offsets, points[:, :2])
    assert passes.times is not None
    assert passes.lens is not None
    assert passes.lights is not None
    assert passes.lights.shape == (32, 6, 2)  # the point light has none
    np.testing.assert_array_equal(passes.lights.reshape(32, 12), points[:, 5:])
    assert 0.1 <= passes.times.min() < passes.times.max() <= 0.8
    assert np.hypot(*passes.lens.T).max() <= 0.21


@pytest.mark.parametrize("name", ["discs", "checker-horizon", "spheres"])
def test_what_a_scene_does_not_need_changes_no_bit(name: str) -> None:
    scene = scene_io.load(name).scene
    idle: dict[str, Any] = {"shutter": (0.0, 1.0), "response": "triangle"}
    if scene.camera.type == "perspective":
        idle |= {"lens_radius": 0.0, "focus_distance": 3.0, "blades": 6}
    stated = scene.model_copy(update={"camera": scene.camera.model_copy(update=idle)})
    for text in ("none", "msaa", "accumulate:n=3"):
        passes = passes_of(mode_of(RENDERER, text), stated)
        assert passes.times is passes.lens is passes.lights is None
        np.testing.assert_array_equal(drawn(stated, text), drawn(scene, text))


def test_passes_that_are_not_the_scenes_are_refused() -> None:
    built = raster.Raster(SCENES["blades"], (8, 6))
    with pytest.raises(InvalidInput, match="points of the lens"):
        built.render(raster.Passes(np.full((1, 2), 0.5), np.ones(1)))
    with pytest.raises(ValueError, match=r"1 weights and lens of shape \(2, 2\)"):
        built.render(raster.Passes(np.full((1, 2), 0.5), np.ones(1), lens=np.zeros((2, 2))))
