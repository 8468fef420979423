"""The POV-Ray renderer's mode `accumulate` under lights with an area: each frame is lit by one point of each."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from povray_scenes import Array, hits, mode, pixel_rays, render, scene_of
from scipy import integrate

from aliascope.errors import Unsupported
from aliascope.geometry import frame_of
from aliascope.model import Scene
from aliascope.native import samplers
from aliascope.native.tracer import Tracer
from aliascope.records import Rendering
from aliascope.renderers import povray
from aliascope.renderers.base import Request, lacks
from aliascope.renderers.povray import RENDERER
from aliascope.renderers.povray_area_lights import LightPoints, points_on
from aliascope.renderers.povray_frames import frames_of
from aliascope.renderers.povray_light import lighting_of

STEP = 1.0 / 65535.0
WHITE = (1.0, 1.0, 1.0)
AREA = {"type": "area", "corner": (-1.5, -0.9, 3.0), "edges": ((0, 1.7, 0.3), (1.5, 0, -0.2))}
DISC = {"type": "disc", "centre": (-1.0, -0.1, 3.0), "normal": (0.2, 0.1, -1.0), "radius": 0.9}
SPHERE = {"type": "sphere", "centre": (-1.0, -0.1, 2.7), "radius": 0.9}
EVEN = {"falloff": "none", "intensity": (0.7, 0.8, 0.9)}
FADING = {"falloff": "inverse-square", "intensity": (7.0, 8.0, 9.0)}
LIGHTS: dict[str, dict[str, Any]] = {
    "area": AREA | EVEN,
    "disc": DISC | EVEN,
    "fading area": AREA | FADING,
    "fading disc": DISC | FADING,
    "fading sphere": SPHERE | FADING,
}


def lit(*lights: dict[str, Any], size: tuple[int, int] = (24, 18)) -> Scene:
    """A ball above a floor."""
    return scene_of(
        [
            {"type": "plane", "material": "floor", "point": (0, 0, 0), "normal": (0, 0, 1)},
            {"type": "sphere", "material": "ball", "centre": (1.2, 0.3, 0.6), "radius": 0.5},
        ],
        {"floor": {"albedo": (0.8, 0.7, 0.6)}, "ball": {"albedo": (0.5, 0.8, 0.8), "emission": (0.05, 0.0, 0.0)}},
        camera={
            "type": "perspective",
            "eye": (0.5, -5, 4),
            "look_at": (0.3, 0, 0.3),
            "up": (0, 0, 1),
            "vertical_fov_degrees": 40.0,
        },
        size=size,
        lights=list(lights),
    )


def points_of(light: dict[str, Any], u: Array) -> LightPoints:
    found = points_on(lit(light).lights[0], u)
    assert found is not None
    return found


def arriving(light: dict[str, Any], points: LightPoints, at: Array, normals: Array) -> Array:
    """What each point of the light, alone, brings to places (..., 3), without shadows: (points, ..., 1 | 3)."""
    shape = (-1, *(1,) * (at.ndim - 1), 3)
    toward = points.places.reshape(shape) - at
    distance = np.linalg.norm(toward, axis=-1, keepdims=True)
    shares: Array = np.maximum(0.0, (normals * toward).sum(-1, keepdims=True) / distance)
    if light["falloff"] != "none":
        cosine = np.maximum(0.0, -(points.facing.reshape(shape) * toward).sum(-1, keepdims=True) / distance)
        shares = points.share * shares * cosine / distance**2
    return shares


def evaluate(scene: Scene, light: dict[str, Any], points: LightPoints, offset: Array) -> Array:
    """A frame: by the textbook, each ray and each shadow ray against every surface."""
    origins, directions = pixel_rays(frame_of(scene), (float(offset[0]), float(offset[1])))
    (near, upright, _), (ball, outward, _) = hits(scene, origins, directions)
    on_ball = ball < near
    distance = np.where(on_ball, ball, near)
    at = origins + distance[..., None] * directions
    normals = np.where(on_ball[..., None], outward, upright)
    normals = normals * -np.sign((normals * directions).sum(-1))[..., None]
    toward = points.places[0] - at
    blocked = np.logical_or.reduce([t < 1.0 for t, _, _ in hits(scene, at + 1e-9 * normals, toward)])
    shares = arriving(light, points, at, normals)[0] * ~blocked[..., None]
    materials = [
        np.where(on_ball[..., None], *pair) for pair in (((0.5, 0.8, 0.8), (0.8, 0.7, 0.6)), ((0.05, 0, 0), 0))
    ]
    return np.asarray(materials[0] * np.array(light["intensity"]) * shares + materials[1])


@pytest.fixture(scope="module")
def rendered() -> dict[str, Rendering]:
    jobs = {name: (lit(light), "accumulate:n=3") for name, light in LIGHTS.items()}
    jobs |= {f"{name}, many": (lit(light), "accumulate:n=32,sampler=sobol") for name, light in LIGHTS.items()}
    both = lit(LIGHTS["fading disc"], {"type": "point", "position": (3, -3, 4), **EVEN}, LIGHTS["area"])
    jobs["two and a point"] = (both, "accumulate:n=2")
    with ThreadPoolExecutor(len(jobs)) as pool:
        return dict(zip(jobs, pool.map(lambda job: render(*job), jobs.values()), strict=True))


@pytest.mark.parametrize("name", list(LIGHTS))
def test_each_frame_is_lit_by_its_point_of_the_light(rendered: dict[str, Rendering], name: str) -> None:
    light = LIGHTS[name]
    samples = samplers.points("halton", 3, 4)
    points = points_of(light, samples[:, 2:])
    scene = lit(light)
    frames = [evaluate(scene, light, points.only(i), offset) for i, offset in enumerate(samples[:, :2])]
    got = rendered[name]
    assert got.quantum >= STEP * 2.0 ** np.ceil(np.log2(np.max(frames)))  # no frame is clipped
    expected = np.mean(frames, axis=0)
    assert 0.2 < expected.max() < 3.0
    # Each value is rounded by half a step, to float32 before. A ray may pass a silhouette by less than the rounding.
    wrong = np.abs(got.pixels - expected).max(axis=-1) > 0.5 * got.quantum + 1e-6
    assert wrong.sum() <= 1


@pytest.mark.parametrize("name", list(LIGHTS))
def test_the_mean_over_frames_is_the_integral(rendered: dict[str, Rendering], name: str) -> None:
    """Against the tracer, which integrates by pixel. Thirty-two frames are off by little but in penumbrae: 0.003 to
    0.004 were measured, 0.034 for the sphere, half of whose points and more are hidden from a place."""
    exact, _ = Tracer(lit(LIGHTS[name]), (24, 18)).render("sobol:scramble=owen", 1024)
    wrong = rendered[f"{name}, many"].pixels - exact
    assert np.sqrt((wrong**2).mean()) < (0.04 if "sphere" in name else 0.006)
    assert abs(wrong.mean()) < (0.02 if "sphere" in name else 0.002)


def test_each_light_has_dimensions_of_its_own(rendered: dict[str, Rendering]) -> None:
    samples = samplers.points("halton", 2, 6)
    scene = lit(LIGHTS["fading disc"], {"type": "point", "position": (3, -3, 4), **EVEN}, LIGHTS["area"])
    point = LightPoints(np.array([(3.0, -3.0, 4.0)]), np.zeros((1, 3)), 1.0, flat=True)
    expected = np.zeros((18, 24, 3))
    for offset, first, second in zip(samples[:, :2], samples[:, 2:4], samples[:, 4:], strict=True):
        for name, u in (("fading disc", first), ("area", second)):
            expected += evaluate(scene, LIGHTS[name], points_of(LIGHTS[name], u[np.newaxis]), offset) / 2
        expected += evaluate(scene, EVEN, point, offset) / 2
    emitted = evaluate(scene, EVEN | {"intensity": (0.0, 0.0, 0.0)}, point, samples[0, :2])
    off = np.abs(rendered["two and a point"].pixels - expected)
    off[emitted.max(axis=-1) > 0.0] = 0.0  # the ball's own light was added three times
    off[evaluate(scene, EVEN | {"intensity": (0.0, 0.0, 0.0)}, point, samples[1, :2]).max(axis=-1) > 0.0] = 0.0
    assert (off.max(axis=-1) > 0.5 * rendered["two and a point"].quantum + 1e-6).sum() <= 1


# The points themselves, against closed forms


def over(light: dict[str, Any], place: tuple[float, float, float], n: int = 1 << 16) -> float:
    """The integral by the points, at a place on a surface that faces up."""
    points = points_of(light, samplers.points("sobol", n))
    return float(arriving(light, points, np.array(place), np.array((0.0, 0.0, 1.0))).mean())


def test_a_parallelogram_gives_lamberts_irradiance() -> None:
    """Lambert 1760, the sum over its sides of the angle times the cosine between the side's plane and the surface."""
    place = np.array((0.31, -0.17, 0.0))
    corner, (a, b) = np.array(AREA["corner"]), np.array(AREA["edges"])
    rays = np.array([corner, corner + a, corner + a + b, corner + b]) - place
    rays /= np.linalg.norm(rays, axis=1)[:, np.newaxis]
    total = 0.0
    for first, second in zip(rays, np.roll(rays, -1, axis=0), strict=True):
        across = np.cross(first, second)
        total += np.arccos(first @ second) * across[2] / np.linalg.norm(across)
    form_factor = abs(total) / (2.0 * np.pi)
    # Radiance pi I / A; 1e-5 is what 65,536 points of Sobol were off by.
    wanted = np.pi * form_factor / np.linalg.norm(np.cross(a, b))
    assert over(LIGHTS["fading area"], tuple(place)) == pytest.approx(wanted, rel=1e-4)
    turned = LIGHTS["fading area"] | {"edges": AREA["edges"][::-1]}
    assert over(turned, tuple(place)) == 0.0  # it shines to the other side alone


def test_a_disc_over_its_axis() -> None:
    plate = {"type": "disc", "centre": (0.3, 0.2, 1.9), "normal": (0.0, 0.0, -0.2), "radius": 0.8, "intensity": WHITE}
    place = (0.3, 0.2, 0.0)
    assert over(plate | {"falloff": "inverse-square"}, place) == pytest.approx(1.0 / (0.8**2 + 1.9**2), rel=1e-4)
    # The mean over the disc of the cosine: 2 h (sqrt(r^2 + h^2) - h) / r^2.
    mean = 2.0 * 1.9 * (np.hypot(0.8, 1.9) - 1.9) / 0.8**2
    assert over(plate | {"falloff": "none"}, place) == pytest.approx(mean, rel=1e-4)


def test_a_sphere_is_the_part_of_it_that_is_seen() -> None:
    ball = {"type": "sphere", "radius": 1.1, "falloff": "inverse-square", "intensity": WHITE}
    centre = np.array((0.9, 0.6, 1.3))
    wanted = centre[2] / np.linalg.norm(centre) ** 3  # the point light at its centre
    assert over(ball | {"centre": tuple(centre)}, (0.0, 0.0, 0.0)) == pytest.approx(wanted, rel=1e-3)
    assert over(ball | {"centre": (0.0, 0.0, 0.5)}, (0.0, 0.0, 0.0)) == 0.0  # from within
    # Partly below the horizon: radiance I / r^2 over its cone of directions, those above the horizon.
    centre, half = np.array((1.5, 0.0, 0.2)), np.arcsin(1.1 / np.hypot(1.5, 0.2))
    low = np.arctan2(centre[2], centre[0])

    def cosine(turn: float, angle: float) -> float:
        up = np.cos(angle) * np.sin(low) + np.sin(angle) * np.cos(turn) * np.cos(low)
        return float(max(0.0, up) * np.sin(angle))

    whole = integrate.dblquad(cosine, 0.0, half, 0.0, 2.0 * np.pi, epsabs=1e-6)[0] / np.pi / 1.1**2
    assert over(ball | {"centre": tuple(centre)}, (0.0, 0.0, 0.0)) == pytest.approx(whole, rel=1e-3)


# How bright frames may be


def test_the_peak_is_that_of_the_brightest_frame() -> None:
    """A lamp of 0.02 units over the floor, half of which a wall beside it hides from no place: the ceiling that it
    hangs from, a unit behind it, is not near to its light."""
    floor = {"type": "plane", "material": "white", "point": (0, 0, 0), "normal": (0, 0, 1)}
    points = [(-9, -9, 2.02), (9, -9, 2.02), (9, 9, 2.02), (-9, 9, 2.02)]
    ceiling = {"type": "polygon", "material": "white", "points": points}
    light = {**FADING, "type": "area", "corner": (-0.5, -0.5, 2.0), "edges": ((0, 1, 0), (1, 0, 0)), "intensity": WHITE}
    scene = scene_of([floor, ceiling], {"white": {"albedo": WHITE}}, lights=[light])
    frames = frames_of(mode("accumulate:n=8"), 0, scene)
    assert lighting_of(scene, frames).peak == pytest.approx(0.25)  # 1 / 2^2; of the ceiling, 1 / 0.02^2
    upward = scene.lights[0].model_copy(update={"edges": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))})
    turned = scene.model_copy(update={"lights": (upward,)})
    assert lighting_of(turned, frames_of(mode("accumulate:n=8"), 0, turned)).peak == pytest.approx(2500.0)


def test_the_nearest_triangle_is_found_among_many() -> None:
    rng = np.random.default_rng(5)
    places = rng.uniform(-1.0, 1.0, (400, 3)) * (4.0, 4.0, 0.5) - (0, 0, 2.0)
    places[:, 2] += 0.4 * np.hypot(places[:, 0], places[:, 1])  # the nearest to a light are not below its middle
    corners = places[:, np.newaxis] + np.array([(0, 0, 0), (0.3, 0, 0.1), (0, 0.2, 0)])
    surfaces = [
        {"type": "polygon", "material": f"m{i % 3}", "points": patch} for i, patch in enumerate(corners.tolist())
    ]
    materials = {f"m{i}": {"albedo": (0.3 * (i + 1),) * 3} for i in range(3)}
    wide = LIGHTS["fading disc"] | {"centre": (0.0, 0.0, 1.5), "normal": (0.0, 0.0, -1.0), "radius": 6.0}
    scene = scene_of(surfaces, materials, lights=[wide])
    points = points_of(wide, samplers.points("halton", 20))
    # Points all over each triangle; the nearest of them is farther than the triangle by 0.01 at most.
    a, b = (np.arange(31) + 0.0)[:, None] / 30, (np.arange(31) + 0.0)[None, :] / 30
    inside = (a + b <= 1.0)[..., None]
    brightest = 0.0
    for i, (p, q, r) in enumerate(corners):
        spread = np.where(inside, p + a[..., None] * (q - p) + b[..., None] * (r - p), p).reshape(-1, 1, 3)
        nearest = np.linalg.norm(spread - points.places, axis=-1).min()
        brightest = max(brightest, 0.3 * (i % 3 + 1) * 9.0 / nearest**2)
    frames = frames_of(mode("accumulate:n=20"), 0, scene)
    frames = povray.Frames(frames.shifts, frames.weights, lights=(points,))
    assert brightest * (1.0 - 1e-12) <= lighting_of(scene, frames).peak <= 1.02 * brightest


def test_more_light_than_files_hold_is_an_empty_cell() -> None:
    near = {**FADING, "type": "sphere", "centre": (0.3, 0.2, 0.5), "radius": 0.4999, "intensity": WHITE}
    assert "65504" in (lacks(RENDERER, lit(near), mode("accumulate")) or "")
    # Nearer in the frames of a sampler than in those that were looked at before: refused when it renders.
    touching = lit({**near, "radius": 0.5})
    tip = LightPoints(np.array([(0.3, 0.2, 1e-4)]), np.array([(0.0, 0.0, -1.0)]), 4.0, flat=False)
    frames = povray.Frames(np.zeros((1, 2)), np.ones(1), lights=(tip,))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(povray, "frames_of", lambda *_: frames)
        with pytest.raises(Unsupported, match="65504"):
            RENDERER.render(Request(touching, 8, 6, mode("accumulate:n=1")))


# What mirrors show


def test_lights_are_not_seen_in_mirrors() -> None:
    """A mirror below an area light, seen from where the light would be in it: the background, and the light that its
    albedo gives back."""
    mirror = {"type": "plane", "material": "mirror", "point": (0, 0, 0), "normal": (0, 0, 1)}
    lamp = {**AREA, **EVEN, "corner": (-9.0, -9.0, 20.0), "edges": ((0, 18.0, 0), (18.0, 0, 0))}
    dark = scene_of([mirror], {"mirror": {"reflection": (0.8, 0.5, 0.3)}}, background=(0.2, 0.4, 0.6), lights=[lamp])
    albedo = scene_of(
        [mirror],
        {"mirror": {"reflection": (0.8, 0.5, 0.3), "albedo": (0.2, 0.2, 0.2)}},
        background=(0.2, 0.4, 0.6),
        lights=[lamp],
    )
    alone = scene_of([mirror], {"mirror": {"albedo": (0.2, 0.2, 0.2)}}, lights=[lamp])
    modes = ("none", "accumulate:n=2")
    with ThreadPoolExecutor(6) as pool:
        jobs = [(scene, text) for text in modes for scene in (dark, albedo, alone)]
        pictures = list(pool.map(lambda job: render(*job).pixels.astype(np.float64), jobs))
    shown = np.array((0.16, 0.2, 0.18))
    for first, second, third in (pictures[:3], pictures[3:]):
        np.testing.assert_allclose(first, np.broadcast_to(shown, first.shape), rtol=0, atol=0.5 * STEP + 2.0**-24)
        assert third.min() > 0.05
        np.testing.assert_allclose(second, third + shown, rtol=0, atol=2.0 * STEP)


# What stays empty


@pytest.mark.parametrize("text", ["none", "am1", "am2", "regular:n=4", "accumulate:n=4"])
def test_a_sphere_without_fall_off_is_an_empty_cell(text: str) -> None:
    assert "each place sees" in (lacks(RENDERER, lit(SPHERE | EVEN), mode(text)) or "")


@pytest.mark.parametrize(
    ("name", "reason"),
    [("disc", "diagonals"), ("fading disc", "diagonals"), ("fading area", "cosine"), ("fading sphere", "not spheres")],
)
def test_povrays_own_area_lights_are_even_parallelograms(name: str, reason: str) -> None:
    scene = lit(LIGHTS[name])
    assert reason in (lacks(RENDERER, scene, mode("am1")) or "")
    assert lacks(RENDERER, scene, mode("accumulate")) is None
    assert lacks(RENDERER, lit(LIGHTS["area"]), mode("am1:light_grid=4")) is None


@pytest.mark.parametrize("key", ["light_grid=4", "light_adaptive=1", "light_jitter=on"])
def test_keys_of_area_lights_are_for_scenes_that_have_them(key: str) -> None:
    point = lit({"type": "point", "position": (3, -3, 4), **EVEN})
    for text in (f"none:{key}", f"am2:depth=2,{key}", f"regular:n=4,{key}"):
        reason = lacks(RENDERER, point, mode(text)) or ""
        assert key.partition("=")[0] in reason
        assert "are for area lights" in reason
        assert lacks(RENDERER, lit(LIGHTS["area"]), mode(text)) is None
    assert lacks(RENDERER, point, mode("none:light_grid=8")) is None  # the default


def test_a_sampler_without_the_dimensions_says_so() -> None:
    reason = lacks(RENDERER, lit(LIGHTS["area"]), mode("accumulate:n=4,sampler=standard-msaa"))
    assert reason is not None
    assert "standard-msaa" in reason
    assert "dimension" in reason
