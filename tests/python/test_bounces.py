"""Diffuse bounces of the tracer: furnaces, form factors, quadrature."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from transport_scenes import drawn, grey, quad, scene_of

from aliascope.model import Scene
from aliascope.native.tracer import Tracer
from aliascope.renderers import embree, mode_of
from aliascope.renderers.base import Request

WITHIN = {
    "type": "perspective",
    "eye": (0.1, 0.2, 0.3),
    "look_at": (0.5, 0.1, -1.0),
    "vertical_fov_degrees": 70.0,
}
BALL = [{"type": "sphere", "material": "wall", "centre": (0.0, 0.0, 0.0), "radius": 1.5}]
LOW, SIDE = -1.1, 2.3
X, Y, Z = SIDE * np.eye(3)
CORNER = np.full(3, LOW)
BOX = [
    quad("wall", corner, first, second)
    for corner, first, second in (
        (CORNER, X, Y),
        (CORNER + Z, X, Y),
        (CORNER, Y, Z),
        (CORNER + X, Y, Z),
        (CORNER, Z, X),
        (CORNER + Y, Z, X),
    )
]


@pytest.mark.parametrize("bounces", [1, 2, 5])
@pytest.mark.parametrize("enclosure", [BALL, BOX], ids=["ball", "box"])
def test_in_a_closed_furnace_each_bounce_adds_a_power_of_the_albedo(
    enclosure: list[dict[str, Any]], bounces: int
) -> None:
    albedo = np.array([0.5, 0.8, 0.0])
    wall = {"wall": {"emission": grey(0.3), "albedo": tuple(albedo)}}
    got, cost = drawn(scene_of(enclosure, wall, WITHIN, (9.0, 9.0, 9.0), diffuse_bounces=bounces), (24, 18), 256)
    expected = 0.3 * sum(albedo**k for k in range(bounces + 1))
    assert got.mean(axis=(0, 1)) == pytest.approx(expected, rel=1e-3)
    assert got[:, :, 2] == pytest.approx(0.3, rel=1e-6)
    assert cost.primary_rays < cost.bounce_rays <= bounces * cost.primary_rays or bounces == 1


def test_a_white_furnace_with_no_emission_keeps_the_sky() -> None:
    """Convex objects of albedo 1 before a sky of 0.7 cannot be told from it, sample by sample."""
    box = [
        {**each, "points": [tuple(0.4 * np.array(p) + [0.2, 0.3, 0.1]) for p in each["points"]]} for each in BOX
    ]  # turned by the view
    camera = {"type": "orthographic", "eye": (4.0, 5.0, 9.0), "look_at": (0.0, 0.0, 0.0), "height": 4.0}
    for convex in (BALL, box):
        scene = scene_of(convex, {"wall": {"albedo": grey(1.0)}}, camera, grey(0.7), diffuse_bounces=3)
        got, cost = drawn(scene, (16, 16), 64)
        assert cost.bounce_rays > 1000
        # A ray that starts at the horizon, lifted by 1e-5, may meet its own ball again, once or twice: still white.
        assert np.abs(got - 0.7).max() < 1e-3


def test_the_end_of_a_path_is_the_last_that_shines() -> None:
    """Albedo 1 in a white ball: 1 + B, no roulette ends it."""
    for bounces in (1, 4, 8):
        wall = {"wall": {"emission": grey(1.0), "albedo": grey(1.0)}}
        got, cost = drawn(scene_of(BALL, wall, WITHIN, diffuse_bounces=bounces), (8, 8), 16)
        assert got == pytest.approx(1.0 + bounces, rel=1e-3)
        assert cost.bounce_rays == bounces * cost.primary_rays


PARALLEL = 2.0 / np.pi * (np.log(2.0 / np.sqrt(3.0)) + 2.0 * np.sqrt(2.0) * np.arctan(1.0 / np.sqrt(2.0)) - np.pi / 2.0)
"""From a unit square to that at distance 1: Howell's catalogue C-11, X = Y = 1."""
PERPENDICULAR = (
    2.0 * np.arctan(1.0) - np.sqrt(2.0) * np.arctan(1.0 / np.sqrt(2.0)) + 0.25 * np.log(4.0 / 3.0 * (3.0 / 4.0) ** 2)
) / np.pi
"""Between unit squares with a common edge: C-14, H = W = 1."""


def receiver(height: float, lamp: dict[str, Any] | None, **more: Any) -> Scene:
    """A unit square of albedo 0.8 on the floor that fills the picture, seen from a height."""
    camera = {"type": "orthographic", "eye": (0.5, 0.5, height), "look_at": (0.5, 0.5, 0.0), "height": 1.0}
    floor = quad("paper", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    materials = {"paper": {"albedo": grey(0.8)}, "lamp": {"emission": (1.0, 2.0, 0.5)}}
    return scene_of([floor, *([lamp] if lamp else [])], materials, camera, **more)


@pytest.mark.parametrize(
    ("height", "corner", "first", "second", "factor"),
    [
        (0.5, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), PARALLEL),
        (9.0, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), PERPENDICULAR),
    ],
    ids=["parallel", "perpendicular"],
)
def test_squares_see_each_other_by_their_form_factor(
    height: float, corner: Any, first: Any, second: Any, factor: float
) -> None:
    assert 0.199 < factor < 0.201  # the published 0.1998 and 0.2000
    got, cost = drawn(receiver(height, quad("lamp", corner, first, second), diffuse_bounces=1), (16, 16), 1024)
    wanted = 0.8 * factor * np.array([1.0, 2.0, 0.5])
    assert got.mean(axis=(0, 1)) == pytest.approx(wanted, rel=1e-3)
    assert cost.shadow_rays > 0.99 * cost.primary_rays
    # The light of that radiance, pi intensity / area, in its place.
    light = {"type": "area", "corner": corner, "edges": (first, second), "falloff": "inverse-square"}
    light |= {"intensity": tuple(np.array([1.0, 2.0, 0.5]) / np.pi)}
    lit = drawn(receiver(height, None, lights=[light]), (16, 16), 1024)[0]
    # But for the pixels at a common edge, where the light's 1 / distance^2 has no variance that would be finite.
    away = np.s_[:, 2:] if height == 9.0 else np.s_[:, :]
    assert lit[away].mean(axis=(0, 1)) == pytest.approx(got[away].mean(axis=(0, 1)), rel=1e-3)
    assert np.abs(lit - got)[away].max() < 0.01


def test_discs_and_balls_shine_as_lights_of_their_kind_do() -> None:
    """A disc over the middle: pi L sin^2 of its half angle; a ball: as the point light at its centre."""
    spot = {"type": "orthographic", "eye": (0.3, 0.2, 0.5), "look_at": (0.3, 0.2, 0.0), "height": 1e-5}
    floor = {"type": "plane", "material": "paper", "point": (0.0, 0.0, 0.0), "normal": (0.0, 0.0, 1.0)}
    materials = {"paper": {"albedo": grey(1.0)}, "lamp": {"emission": grey(1.0)}}
    disc = {"type": "disc", "material": "lamp", "centre": (0.3, 0.2, 1.9), "normal": (0.0, 0.0, 0.2), "radius": 0.8}
    ball = {"type": "sphere", "material": "lamp", "centre": (0.9, 0.6, 1.3), "radius": 0.7}
    away = np.array([0.6, 0.4, 1.3])
    for lamp, wanted in ((disc, 0.8**2 / (0.8**2 + 1.9**2)), (ball, 0.7**2 * 1.3 / np.linalg.norm(away) ** 3)):
        got = drawn(scene_of([floor, lamp], materials, spot, diffuse_bounces=1), (1, 1), 16384)[0]
        assert got[0, 0, 0] == pytest.approx(wanted, rel=1e-3)


def test_light_of_lamps_goes_on_from_what_it_lights() -> None:
    """A point light in the middle of a ball lights all of it alike, by 1; each bounce adds a power of the albedo."""
    light = {"type": "point", "position": (0.0, 0.0, 0.0), "intensity": (1.0, 0.5, 0.2)}
    scene = scene_of(BALL, {"wall": {"albedo": grey(0.6)}}, WITHIN, lights=[light], diffuse_bounces=3)
    got = drawn(scene, (8, 8), 64)[0]
    assert got == pytest.approx(np.array([1.0, 0.5, 0.2]) * (0.6 + 0.36 + 0.216 + 0.1296) + 0.0 * got, rel=1e-3)


def cornell() -> Scene:
    """A box with a lamp, a mirror ball, a glossy one, and a moving one that shines."""
    wall = {"wall": {"albedo": (0.7, 0.6, 0.5)}, "lamp": {"emission": grey(6.0), "albedo": grey(0.2)}}
    wall |= {"steel": {"albedo": grey(0.1), "reflection": grey(0.8)}, "glow": {"emission": (0.1, 0.5, 0.9)}}
    wall |= {"shiny": {"albedo": grey(0.3), "reflection": grey(0.5), "gloss": {"type": "ggx", "roughness": 0.2}}}
    lamp = quad("lamp", (-0.4, 1.15, -0.4), (0.8, 0.0, 0.0), (0.0, 0.0, 0.7))
    balls = [
        {"type": "sphere", "material": name, "centre": centre, "radius": 0.35}
        for name, centre in (("steel", (-0.4, -0.7, -0.5)), ("shiny", (0.5, -0.6, -0.2)), ("glow", (0.0, 0.2, -0.7)))
    ]
    balls[2]["motion"] = {"type": "translate", "by": (0.3, 0.1, 0.0)}
    light = {"type": "sphere", "centre": (0.6, 0.6, 0.0), "radius": 0.1, "intensity": grey(0.2)}
    camera = {**WITHIN, "eye": (0.0, 0.0, 1.0), "look_at": (0.0, 0.0, -1.0), "shutter": (0.0, 1.0)}
    return scene_of(
        [*BOX, lamp, *balls], wall, camera, lights=[light], diffuse_bounces=3, mirror_bounces=2, view={"size": (32, 24)}
    )


def test_needs_dimensions_rays_and_bits() -> None:
    scene = cornell()
    needs = scene.needs()
    assert (needs.diffuse_bounces, needs.mirror_bounces, needs.emitters) == (3, 2, 2)
    built = Tracer(scene, (33, 21))
    assert built.dimensions == needs.dimensions == 2 + 1 + 2 + 2 + 5 * 3
    one, three = (built.render("sobol:scramble=owen", 13, 4, threads) for threads in (1, 3))
    assert np.array_equal(one[0], three[0])
    assert one[1].bounce_rays == three[1].bounce_rays > 0
    assert one[1].reflection_rays == three[1].reflection_rays > 0
    adaptive = built.render_adaptive("fixed", "sobol:scramble=owen", 13, 4)
    assert np.allclose(adaptive[0], one[0], atol=1e-5)  # the same samples in other packets
    stopped, counts, _ = built.render_adaptive("student-t", "sobol:scramble=owen", 64, 4)
    assert np.isfinite(stopped).all()
    assert counts.min() < counts.max()
    mode = mode_of(embree.RENDERER, "uniform:n=4")
    seen = embree.RENDERER.render(Request(scene, 8, 8, mode)).cost.rays
    assert set(seen) == {"primary", "reflection", "bounce", "shadow"}
    assert min(seen.values()) > 0


def test_bounces_that_nothing_asks_for_cost_nothing() -> None:
    """Black surfaces that shine: no albedo, so nothing bounces."""
    scene = scene_of(BALL, {"wall": {"emission": (0.1, 0.2, 0.3)}}, WITHIN)
    asked = scene_of(BALL, {"wall": {"emission": (0.1, 0.2, 0.3)}}, WITHIN, diffuse_bounces=8)
    assert asked.needs() == scene.needs()
    assert asked.features() == scene.features()
    plain, other = drawn(scene), drawn(asked)
    assert np.array_equal(plain[0], other[0])
    assert other[1].bounce_rays == other[1].shadow_rays == 0
