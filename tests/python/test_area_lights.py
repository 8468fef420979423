"""Lights with an area against closed forms: Lambert's polygon formula, form factors, point lights, quadrature."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import integrate

from aliascope.model import Scene
from aliascope.native.tracer import Tracer
from aliascope.renderers import base, embree, mode_of

FLOOR = {"type": "plane", "material": "white", "point": (0.0, 0.0, 0.0), "normal": (0.0, 0.0, 1.0)}
UP = np.array([0.0, 0.0, 1.0])


def scene_of(light: dict[str, Any], centre: tuple[float, float], height: float, *surfaces: dict[str, Any]) -> Scene:
    """A white floor, z = 0, seen from above round a place."""
    camera = {"type": "orthographic", "eye": (*centre, 40.0), "look_at": (*centre, 0.0), "height": height}
    return Scene.model_validate(
        {
            "title": "t",
            "shows": "s",
            "view": {"size": (8, 8)},
            "camera": camera,
            "materials": {"white": {"albedo": (1.0, 1.0, 1.0)}},
            "surfaces": [FLOOR, *surfaces],
            "lights": [{"intensity": (1.0, 0.5, 0.25), **light}],
        }
    )


def drawn(scene: Scene, size: tuple[int, int] = (1, 1), samples: int = 4096, seed: int = 0) -> np.ndarray:
    pixels, _ = Tracer(scene, size).render("sobol:scramble=owen", samples, seed)
    assert np.allclose(pixels * [1.0, 2.0, 4.0], pixels[:, :, :1], rtol=1e-5, atol=0.0)
    return pixels[:, :, 0].astype(np.float64)


def area(corner: Any, *edges: Any, falloff: str = "inverse-square") -> dict[str, Any]:
    return {"type": "area", "corner": corner, "edges": edges, "falloff": falloff}


def lambert(corners: np.ndarray, point: np.ndarray, normal: np.ndarray) -> float:
    """The form factor of a point to a polygon above its horizon (Lambert 1760): the sum over its sides of the angle
    that each takes up, times the cosine of that plane, over 2 pi."""
    rays = corners - point
    rays /= np.linalg.norm(rays, axis=1)[:, np.newaxis]
    total = 0.0
    for first, second in zip(rays, np.roll(rays, -1, axis=0), strict=True):
        across = np.cross(first, second)
        total += np.arccos(first @ second) * (across @ normal) / np.linalg.norm(across)
    return abs(total) / (2.0 * np.pi)


PLACE, TINY = (0.31, -0.17), 1e-4
# Down over the place, and standing beside it, facing it.
LIGHTS = {
    "above": ((-0.4, -0.9, 1.7), (0.2, 1.9, 0.3), (1.3, 0.1, -0.2)),
    "beside": ((-1.1, -0.8, 0.2), (0.1, 1.7, 0.0), (0.0, 0.2, 1.4)),
}


@pytest.mark.parametrize("name", LIGHTS)
def test_a_parallelogram_gives_lamberts_irradiance(name: str) -> None:
    corner, a, b = (np.array(each) for each in LIGHTS[name])
    corners = np.array([corner, corner + a, corner + a + b, corner + b])
    size = np.linalg.norm(np.cross(a, b))
    # Radiance pi I / A; irradiance over pi is radiance times the form factor.
    wanted = np.pi / size * lambert(corners, np.array([*PLACE, 0.0]), UP)
    seen = drawn(scene_of(area(*LIGHTS[name]), PLACE, TINY), samples=16384)
    assert seen[0, 0] == pytest.approx(wanted, rel=2e-4)  # the steps of scrambled Sobol: 1e-5 measured
    turned = (LIGHTS[name][0], LIGHTS[name][2], LIGHTS[name][1])
    assert not drawn(scene_of(area(*turned), PLACE, TINY)).any()  # shines to the other side alone


# Unit squares: opposite at a distance of 1; at a right angle with a side in common (Howell's catalogue, C-11, C-14).
OPPOSITE = (
    2.0 / np.pi * (np.log(np.sqrt(4.0 / 3.0)) + 2.0 * np.sqrt(2.0) * np.arctan(np.sqrt(0.5)) - 2.0 * np.arctan(1.0))
)
AT_RIGHT_ANGLE = (2.0 * np.arctan(1.0) - np.sqrt(2.0) * np.arctan(np.sqrt(0.5)) + 0.25 * np.log(0.75)) / np.pi


def test_form_factors_of_squares() -> None:
    assert (round(OPPOSITE, 6), round(AT_RIGHT_ANGLE, 6)) == (0.199825, 0.200044)  # as published
    opposite = area((-0.5, -0.5, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    assert drawn(scene_of(opposite, (0.0, 0.0), 1.0), (32, 32), 256).mean() / np.pi == pytest.approx(OPPOSITE, rel=2e-4)
    beside = area((-0.5, -0.5, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    columns = drawn(scene_of(beside, (0.0, 0.0), 1.0), (32, 32), 1024).mean(axis=0) / np.pi
    # Next to the common side the integrand is without bound, and so is its variance: the first column by Lambert.
    corners = np.array([(-0.5, -0.5, 0.0), (-0.5, 0.5, 0.0), (-0.5, 0.5, 1.0), (-0.5, -0.5, 1.0)])
    nodes, weights = np.polynomial.legendre.leggauss(8)
    x, y = -0.5 + (0.5 + 0.5 * nodes) / 32.0, (np.arange(100) + 0.5) / 100.0 - 0.5
    exact = [np.mean([lambert(corners, np.array([each, other, 0.0]), UP) for other in y]) for each in x]
    columns[0] = 0.5 * weights @ exact
    assert columns.mean() == pytest.approx(AT_RIGHT_ANGLE, rel=1e-3)


def test_a_sphere_above_the_horizon_is_the_point_light_at_its_centre() -> None:
    centre, distant = np.array([0.9, 0.6, 1.3]), np.array([*PLACE, 0.0])
    ball = {"type": "sphere", "centre": tuple(centre), "radius": 1.1, "falloff": "inverse-square"}
    away = centre - distant
    wanted = away[2] / np.linalg.norm(away) ** 3
    assert drawn(scene_of(ball, PLACE, TINY), samples=16384)[0, 0] == pytest.approx(wanted, rel=2e-4)
    assert not drawn(scene_of(ball | {"centre": (*PLACE, 0.5)}, PLACE, TINY)).any()  # from within


def test_a_disc_over_its_axis() -> None:
    """Irradiance pi L sin^2 of the half angle that it is seen under."""
    plate = {"type": "disc", "centre": (*PLACE, 1.9), "normal": (0.0, 0.0, -0.2), "radius": 0.8}
    fading = scene_of(plate | {"falloff": "inverse-square"}, PLACE, TINY)
    assert drawn(fading, samples=16384)[0, 0] == pytest.approx(1.0 / (0.8**2 + 1.9**2), rel=2e-4)
    # Without fall-off, the mean over the disc of the cosine: 2 h (sqrt(r^2 + h^2) - h) / r^2.
    mean = 2.0 * 1.9 * (np.hypot(0.8, 1.9) - 1.9) / 0.8**2
    for normal in ((0.0, 0.0, -0.2), (0.0, 0.0, 3.0)):  # to both sides
        seen = drawn(scene_of(plate | {"normal": normal}, PLACE, TINY), samples=16384)
        assert seen[0, 0] == pytest.approx(mean, rel=2e-4)


def test_a_sphere_without_fall_off_is_the_mean_over_the_cap_that_is_seen() -> None:
    height, radius = 2.3, 0.9
    ball = {"type": "sphere", "centre": (*PLACE, height), "radius": radius}

    def cosine(z: float) -> float:  # to the cap's points z below the centre, which are uniform in z
        out = np.sqrt(radius**2 - z**2)
        return float((height - z) / np.hypot(height - z, out))

    low = radius**2 / height
    wanted = integrate.quad(cosine, low, radius)[0] / (radius - low)
    assert drawn(scene_of(ball, PLACE, TINY), samples=16384)[0, 0] == pytest.approx(wanted, rel=2e-4)


def test_the_soft_shadow_of_a_straight_edge() -> None:
    """A half-plane at height 1 below a light at height 3: at each place that part of the light counts that is seen past
    the edge, by scipy's quadrature."""
    edge, bottom, top = 0.137, 1.0, 3.0
    occluder = [(-50.0, -50.0, bottom), (edge, -50.0, bottom), (edge, 50.0, bottom), (-50.0, 50.0, bottom)]
    lamp = area((-0.7, -0.4, top), (1.3, 0.0, 0.0), (0.0, 0.9, 0.0), falloff="none")
    plate = {"type": "polygon", "material": "white", "points": occluder}
    worst, values = 0.0, []
    for x in (-0.6, -0.21, 0.05, 0.4, 0.9):
        scene = scene_of(lamp, (x, 0.13), TINY, plate)
        below = scene.camera.model_copy(
            update={"eye": (x, 0.13, 0.9), "look_at": (x, 0.13, 0.0), "up": (0.0, 1.0, 0.0)}
        )
        # The light's point lx is seen where x + (lx - x) bottom / top is beyond the edge.
        first = np.clip(x + (edge - x) * top / bottom, -0.7, 0.6)
        whole, _ = integrate.dblquad(
            lambda y, lx, x=x: top / np.sqrt((lx - x) ** 2 + (y - 0.13) ** 2 + top**2), first, 0.6, -0.4, 0.5
        )
        values.append(whole / (1.3 * 0.9))
        worst = max(worst, abs(drawn(scene.model_copy(update={"camera": below}), samples=16384)[0, 0] - values[-1]))
    assert min(values) == 0.0
    assert sum(0.05 < value < 0.9 for value in values) >= 2
    assert worst < 1e-3


def test_a_light_below_the_surface_gives_nothing_and_costs_no_shadow_ray() -> None:
    for light in (
        area((0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), falloff="none"),
        {"type": "disc", "centre": (0.0, 0.0, -1.0), "normal": (0.0, 0.0, 1.0), "radius": 0.9},
        {"type": "sphere", "centre": (0.0, 0.0, -1.0), "radius": 0.9},
    ):
        pixels, cost = Tracer(scene_of(light, PLACE, 1.0), (4, 4)).render("halton", 16)
        assert not pixels.any()
        assert cost.shadow_rays == 0


def two_lights() -> Scene:
    scene = scene_of(area(*LIGHTS["above"]), PLACE, 3.0).model_dump()
    ball = {"type": "sphere", "centre": (1.0, 0.3, 1.2), "radius": 0.4, "intensity": (0.2, 0.3, 0.4)}
    point = {"type": "point", "position": (1.0, 2.0, 3.0), "intensity": (0.1, 0.1, 0.1)}
    return Scene.model_validate(scene | {"lights": (point, *scene["lights"], ball)})


def test_each_light_has_dimensions_of_its_own_and_threads_change_no_bit() -> None:
    scene = two_lights()
    built = Tracer(scene, (37, 27))
    assert built.dimensions == scene.needs().dimensions == 6
    one, three = (built.render("sobol:scramble=owen", 21, 4, threads)[0] for threads in (1, 3))
    assert np.array_equal(one, three)
    alone = [Tracer(scene.model_copy(update={"lights": (each,)}), (37, 27)) for each in scene.lights]
    apart = sum(each.render("sobol:scramble=owen", 256)[0] for each in alone)
    assert np.abs(apart - built.render("sobol:scramble=owen", 256)[0]).max() < 5e-3
    adaptive = built.render_adaptive("fixed", "sobol:scramble=owen", 21, 4)[0]
    assert np.allclose(adaptive, one, atol=1e-6)  # the same samples in other packets


def test_lights_are_sampled_apart() -> None:
    """Two lights in one place, of half the intensity each, scatter half as much (in variance) as one."""
    lamp = area(*LIGHTS["above"])
    half = lamp | {"intensity": (0.5, 0.25, 0.125)}
    one = scene_of(lamp, PLACE, TINY)
    two = Scene.model_validate(one.model_dump() | {"lights": (half, half)})
    spread = [render_once(each).var() for each in (one, two)]
    # 4,096 values each: a variance to 1 / sqrt(2048) or so, the ratio to 3 %; five of those.
    assert spread[1] / spread[0] == pytest.approx(0.5, abs=0.08)


def render_once(scene: Scene) -> np.ndarray:
    """One random sample a pixel."""
    return Tracer(scene, (64, 64)).render("random", 1)[0][:, :, 0].astype(np.float64)


@pytest.mark.parametrize("sampler", ["standard-msaa,n=4", "sgi-8x8,n=8"])
def test_planar_patterns_are_refused(sampler: str) -> None:
    reason = base.lacks(embree.RENDERER, two_lights(), mode_of(embree.RENDERER, f"uniform:sampler={sampler}"))
    assert reason is not None
    assert "dimension" in reason
