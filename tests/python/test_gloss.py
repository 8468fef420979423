"""Glossy reflection of the tracer: its lobes against quadrature over the hemisphere, and their limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import integrate
from transport_scenes import drawn, grey, scene_of

from aliascope.native.tracer import Tracer
from aliascope.renderers import base, embree, mode_of

FLOOR = {"type": "plane", "material": "shiny", "point": (0.0, 0.0, 0.0), "normal": (0.0, 0.0, 1.0)}
LOBES = [
    *({"type": "phong", "exponent": exponent} for exponent in (1.0, 7.0, 150.0)),
    *({"type": "ggx", "roughness": roughness} for roughness in (0.2, 0.5, 1.0)),
]
ANGLES = (20.0, 65.0)


def value(lobe: dict[str, Any], eye: np.ndarray, way: np.ndarray) -> float:
    """What of the radiance from a direction goes to the eye, in a steradian; the normal is z."""
    if lobe["type"] == "phong":
        exponent = lobe["exponent"]
        mirrored = np.array([-eye[0], -eye[1], eye[2]])
        return float((exponent + 1.0) / (2.0 * np.pi) * max(0.0, mirrored @ way) ** exponent)
    alpha = lobe["roughness"]
    half = (eye + way) / np.linalg.norm(eye + way)
    slope = (1.0 - half[2] ** 2) / half[2] ** 2
    # Walter et al. 2007, eq. 33; Heitz 2014, eqs. 72 and 99.
    facets = alpha**2 / (np.pi * half[2] ** 4 * (alpha**2 + slope) ** 2)
    hidden = [0.5 * (np.sqrt(1.0 + alpha**2 * (1.0 / v[2] ** 2 - 1.0)) - 1.0) for v in (eye, way)]
    return float(facets / (1.0 + sum(hidden)) / (4.0 * eye[2]))


def direction(cosine: float, turn: float) -> np.ndarray:
    out = np.sqrt(max(0.0, 1.0 - cosine**2))
    return np.array([out * np.cos(turn), out * np.sin(turn), cosine])


def to_eye(angle: float) -> np.ndarray:
    return direction(np.cos(np.radians(angle)), np.pi)


def looking(angle: float) -> dict[str, Any]:
    """So near that all rays are one."""
    eye = tuple((9.0 * to_eye(angle)).tolist())
    return {"type": "orthographic", "eye": eye, "look_at": (0.0, 0.0, 0.0), "height": 1e-6}


def shiny(lobe: dict[str, Any] | None, **more: Any) -> dict[str, Any]:
    return {"shiny": {"reflection": grey(1.0), "gloss": lobe}, **more}


def over_hemisphere(lobe: dict[str, Any], angle: float) -> float:
    eye = to_eye(angle)

    def ring(cosine: float) -> float:
        return 2.0 * integrate.quad(lambda turn: value(lobe, eye, direction(cosine, turn)), 0.0, np.pi, epsabs=1e-9)[0]

    return float(integrate.quad(ring, 1e-9, 1.0, epsabs=1e-7, limit=200, points=[np.cos(np.radians(angle))])[0])


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("lobe", LOBES, ids=lambda each: "-".join(map(str, each.values())))
def test_before_a_white_sky_a_lobe_gives_its_directional_albedo(lobe: dict[str, Any], angle: float) -> None:
    got = drawn(scene_of([FLOOR], shiny(lobe), looking(angle), grey(1.0)), (1, 1), 65536)[0]
    albedo = over_hemisphere(lobe, angle)
    assert 0.3 < albedo < 1.0 + 1e-6
    # Owen's nets of 2^16 points: sigma N^-3/4 where the lobe's share that is lost has a smooth border: below 2e-4.
    assert got[0, 0, 0] == pytest.approx(albedo, abs=3e-4)
    assert got[0, 0, 0] <= 1.0 + 1e-7


@pytest.mark.parametrize("lobe", LOBES[1:5], ids=lambda each: "-".join(map(str, each.values())))
def test_a_surface_that_shines_is_seen_through_the_lobe(lobe: dict[str, Any]) -> None:
    """A disc over the floor, facing it, of radiance 1: the lobe's integral over the disc."""
    radius, centre = 0.25, np.array([0.9, 0.1, 0.45])  # 63 degrees from the normal
    lamp = {"type": "disc", "material": "lamp", "centre": tuple(centre), "normal": (0.0, 0.0, 3.0), "radius": radius}
    eye = to_eye(65.0)

    def seen(turn: float, out: float) -> float:
        way = centre + radius * out * np.array([np.cos(turn), np.sin(turn), 0.0])
        squared = way @ way
        distance = np.sqrt(squared)
        return value(lobe, eye, way / distance) * way[2] / (distance * squared) * radius**2 * out

    expected = integrate.dblquad(seen, 0.0, 1.0, 0.0, 2.0 * np.pi, epsabs=1e-6)[0]
    assert expected > 0.03
    scene = scene_of([FLOOR, lamp], shiny(lobe, lamp={"emission": (1.0, 0.5, 0.0)}), looking(65.0), mirror_bounces=1)
    assert scene.needs().emitters == 1
    assert Tracer(scene, (1, 1)).dimensions == scene.needs().dimensions == 6
    got, cost = drawn(scene, (1, 1), 65536)
    assert got[0, 0] == pytest.approx(expected * np.array([1.0, 0.5, 0.0]), rel=2e-3)
    assert cost.shadow_rays > 60000
    assert cost.reflection_rays > 20000


@pytest.mark.parametrize(
    ("lobe", "most"), [({"type": "phong", "exponent": 1e6}, 0.01), ({"type": "ggx", "roughness": 1e-3}, 0.06)]
)
def test_the_sharpest_lobes_are_mirrors(lobe: dict[str, Any], most: float) -> None:
    """A lobe of the width 1.4e-3 (Phong; GGX 2e-3, with long tails) moves a phase of 5 radians a unit, at a distance of
    up to 6, by 0.05: what 64 samples leave of its value's 0.03 (0.06), and, in the mean of 432 pixels, nothing."""
    plate = {"type": "plane", "material": "rings", "point": (2.5, 0.0, 0.0), "normal": (1.0, 0.0, -0.3)}
    pattern = {"type": "zone-plate", "scale": 1.3, "origin": (2.5, 0.0, 0.3)}
    rings = {"rings": {"emission": grey(1.0), "pattern": pattern}}
    camera = {"type": "orthographic", "eye": (-6.0, 0.3, 4.0), "look_at": (0.0, 0.1, 0.0), "height": 1.5}
    sharp, mirror = (
        drawn(scene_of([FLOOR, plate], shiny(each, **rings), camera), (24, 18), 64)[0] for each in (lobe, None)
    )
    assert mirror.std() > 0.2
    assert abs((sharp - mirror).mean()) < 1e-3
    assert np.abs(sharp - mirror).max() < most
    wide = {**lobe, "exponent": 1e4} if lobe["type"] == "phong" else {**lobe, "roughness": 1e-2}
    other = drawn(scene_of([FLOOR, plate], shiny(wide, **rings), camera), (24, 18), 64)[0]
    assert np.abs(other - mirror).max() > 2.0 * np.abs(sharp - mirror).max()


def test_what_is_reflected_and_what_is_scattered_make_no_more_than_arrives() -> None:
    ball = {"type": "sphere", "material": "m", "centre": (0.0, 0.0, 0.0), "radius": 0.9}
    camera = {"type": "orthographic", "eye": (0.0, 0.0, 9.0), "look_at": (0.0, 0.0, 0.0), "height": 2.0}
    for lobe in (None, *LOBES):
        mixed = {"m": {"albedo": grey(0.3), "reflection": grey(0.7), "gloss": lobe}}
        got = drawn(scene_of([ball], mixed, camera, grey(1.0), diffuse_bounces=1), (12, 12), 64)[0]
        assert got.max() <= 1.0 + 1e-6
        if lobe is None:  # whichever way a path goes: no noise
            assert got.min() >= 1.0 - 1e-6
    colours = {"m": {"albedo": (0.5, 0.2, 0.9), "reflection": (0.5, 0.8, 0.1)}}
    got = drawn(scene_of([ball], colours, camera, grey(1.0), diffuse_bounces=1), (24, 24), 256)[0]
    # The chances of a way are one for all channels, which scatters those: by 1 at most, over 147,456 samples.
    assert np.abs(got.mean(axis=(0, 1)) - 1.0).max() < 5.0 / np.sqrt(24 * 24 * 256)


def test_gloss_has_two_dimensions_a_bounce_and_samplers_that_lack_them_are_refused() -> None:
    scene = scene_of([FLOOR], shiny(LOBES[3]), mirror_bounces=3)
    assert Tracer(scene, (8, 8)).dimensions == scene.needs().dimensions == 2 + 3 * 2
    for sampler in ("standard-msaa,n=4", "cook,n=16"):
        reason = base.lacks(embree.RENDERER, scene, mode_of(embree.RENDERER, f"uniform:sampler={sampler}"))
        assert reason is not None
        assert "dimension" in reason
