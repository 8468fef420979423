"""The POV-Ray renderer's area lights: penumbrae and shading against integrals over the light."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from povray_scenes import Array, render, scene_of
from scipy import integrate

from aliascope.model import Scene

HALF_STEP = 0.5 / 65535.0 + 2.0**-24
LIGHT = {
    "type": "area",
    "corner": (-4.0, -3.0, 12.0),
    "edges": ((8.0, 0, 0), (0, 4.0, 3.0)),
    "intensity": (0.9, 0.6, 0.3),
}


def lit(occluded: bool, **light: object) -> Scene:
    """A floor, one unit a pixel, below a light that is tilted; a half-plane x < 0 at a third of its height."""
    floor = {"type": "plane", "material": "floor", "point": (0, 0, 0), "normal": (0, 0, 1)}
    points = [(-999.0, -999.0, 4.0), (0.0, -999.0, 4.0), (0.0, 999.0, 4.0), (-999.0, 999.0, 4.0)]
    roof = {"type": "polygon", "material": "floor", "points": points}
    camera = {"type": "orthographic", "eye": (0, 0, 3), "look_at": (0, 0, 0), "height": 4.0}
    return scene_of(
        [floor, roof] if occluded else [floor],
        {"floor": {"albedo": (0.8, 0.8, 0.8)}},
        camera=camera,
        size=(14, 4),
        lights=[{**LIGHT, **light}],
    )


def share(x: float, y: float, s: float, t: float, occluded: bool) -> float:
    """n.l of the point (s, t) in [0, 1]^2 of the light, from x, y on the floor; 0 where the half-plane hides it."""
    toward = np.array((-4 + 8 * s - x, -3 + 4 * t - y, 12 + 3 * t))
    if occluded and x + 4 / toward[2] * toward[0] < 0:
        return 0.0
    return float(toward[2] / np.linalg.norm(toward))


def places() -> list[tuple[float, float]]:
    return [(x + 0.5, y + 0.5) for y in (1, 0, -1, -2) for x in range(-7, 7)]


def integral(x: float, y: float, occluded: bool) -> float:
    """By scipy; within a line of the light the half-plane hides what lies left of a place."""

    def visible_from(t: float) -> float:
        height = 12 + 3 * t
        hidden = (x - x * height / 4 + 4) / 8 if occluded else 0.0
        return min(max(hidden, 0.0), 1.0)

    value = integrate.dblquad(lambda s, t: share(x, y, s, t, False), 0, 1, visible_from, 1, epsabs=1e-7)[0]
    return float(value)


def grid_means(x: float, y: float, side: int) -> tuple[float, float, float]:
    """Over the middles of side x side cells: of n.l without the half-plane, of visibility, and of their product."""
    middles = (np.arange(side) + 0.5) / side
    places = [(s, t) for s in middles for t in middles]
    cosines = np.array([share(x, y, s, t, False) for s, t in places])
    products = np.array([share(x, y, s, t, True) for s, t in places])
    return float(cosines.mean()), float((products > 0.0).mean()), float(products.mean())


def picture(values: list[float]) -> Array:
    return 0.8 * np.array(values).reshape(4, 14, 1) * np.array(LIGHT["intensity"])


@pytest.mark.parametrize("side", [2, 4, 8, 16])
def test_the_points_of_a_light_are_the_middles_of_equal_cells(side: int) -> None:
    means = [grid_means(x, y, side) for x, y in places()]
    got = render(lit(True), f"none:light_grid={side}").pixels
    # POV-Ray multiplies the means of n.l and of visibility. 8e-6, 15e-6 / 2, is the rounding to 16 bits.
    expected = picture([cosine * visible for cosine, visible, _ in means])
    np.testing.assert_allclose(got, expected, rtol=0, atol=HALF_STEP + 1e-6)
    # So it is off by their covariance over the light, of which this scene has much: 0.0033 at most.
    assert 1e-3 < np.abs(got - picture([product for _, _, product in means])).max() < 4e-3


@pytest.mark.parametrize("occluded", [False, True])
def test_the_penumbra_of_a_straight_edge_is_the_integral_over_the_light(occluded: bool) -> None:
    expected = picture([integral(x, y, occluded) for x, y in places()])
    got = render(lit(occluded), "none:light_grid=16").pixels
    # An edge across 16 columns of points is known to half a column, 1/32 of the light (0.0225; beside it there is the
    # covariance of 0.0033: see above, whose signs do not add up here); without one the midpoint rule
    # is off by (1/16)^2 / 24 of the second derivatives, which are below 1.
    np.testing.assert_allclose(got, expected, rtol=0, atol=0.9 * 0.8 / 32 if occluded else 2e-4)
    if occluded:
        assert got.min() == 0.0
        assert got[..., 0].max() > 0.6


def test_adaptive_points_are_fewer_and_jitter_repeats_itself() -> None:
    scene = lit(True)
    texts = ["none:light_grid=16", "none:light_grid=16,light_adaptive=1", *["none:light_grid=16,light_jitter=on"] * 2]
    with ThreadPoolExecutor(4) as pool:
        plain, adaptive, first, again = pool.map(lambda text: render(scene, text, threads=2).pixels, texts)
    exact = picture([integral(x, y, True) for x, y in places()])
    np.testing.assert_allclose(adaptive, plain, rtol=0, atol=0.9 * 0.8 / 16)  # a column of points at the edge
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - plain).max() > 1e-3
    np.testing.assert_allclose(first, exact, rtol=0, atol=0.9 * 0.8 / 16)  # points move by a cell at most
