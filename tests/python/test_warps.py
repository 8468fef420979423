"""Warps from Python, against scipy: quadrature of the densities, and distributions from histograms."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate, stats

from aliascope import points
from aliascope.errors import InvalidInput, SpecError
from aliascope.native import warps
from aliascope.native.warps import Density, Warp

Array = NDArray[np.float64]
HEMISPHERES = (warps.COSINE_HEMISPHERE, warps.UNIFORM_HEMISPHERE)


def rng() -> np.random.Generator:
    return np.random.default_rng(11)


@pytest.mark.parametrize("warp", [*HEMISPHERES, warps.SPHERE], ids=lambda warp: warp.name)
def test_densities_of_directions_integrate_to_one(warp: Warp) -> None:
    def pdf(polar: float, azimuth: float) -> float:
        ring = np.sin(polar)
        w = [[ring * np.cos(azimuth), ring * np.sin(azimuth), np.cos(polar)]]
        return float(warp.pdf(w)[0] * ring)

    end = np.pi if warp is warps.SPHERE else np.pi / 2
    whole, error = integrate.dblquad(pdf, 0, 2 * np.pi, 0, end)
    assert abs(whole - 1) < 1e-9 + error


@pytest.mark.parametrize(
    ("warp", "moment", "expected"),
    [
        (warps.DISC, lambda p: p[:, 0] ** 2, 1 / 4),
        (warps.DISC, lambda p: np.hypot(p[:, 0], p[:, 1]), 2 / 3),
        (warps.COSINE_HEMISPHERE, lambda p: p[:, 2], 2 / 3),
        (warps.COSINE_HEMISPHERE, lambda p: p[:, 0] ** 2, 1 / 4),
        (warps.UNIFORM_HEMISPHERE, lambda p: p[:, 2], 1 / 2),
        (warps.UNIFORM_HEMISPHERE, lambda p: p[:, 1] ** 2, 1 / 3),
        (warps.SPHERE, lambda p: p[:, 2] ** 4, 1 / 5),
        (warps.SPHERE, lambda p: p[:, 0] * p[:, 1] + p[:, 2], 0),
        (warps.TRIANGLE, lambda p: p[:, 0], 1 / 3),
        (warps.TRIANGLE, lambda p: p[:, 1] * p[:, 2], 1 / 12),
    ],
)
def test_moments_by_sobol_points(warp: Warp, moment: Callable[[Array], Array], expected: float) -> None:
    # The error of 2^16 points of a net is below 3e-5 for integrands of bounded variation: log(N)/N.
    assert moment(warp.sample(points("sobol", 1 << 16))).mean() == pytest.approx(expected, abs=3e-5)


def test_a_line_is_the_distribution_of_a_histogram() -> None:
    for n in (1, 2, 7, 1000):
        weights = rng().exponential(size=n) ** 3 + 1e-9  # scipy's has no inverse across empty cells
        density = Density(weights)
        same = stats.rv_histogram((weights, np.linspace(0, 1, n + 1)), density=False)
        u = np.linspace(0, 1, 4001)[:-1]
        # scipy sums n weights and interpolates: its shares are off by n eps, and x by that over the density.
        x = density.sample(u[:, np.newaxis]).ravel()
        assert same.cdf(x) == pytest.approx(u, abs=4 * n * 2.0**-53 + 1e-15)
        assert density.inverse(x[:, np.newaxis]).ravel() == pytest.approx(same.cdf(x), abs=4 * n * 2.0**-53 + 1e-15)
        centres = (np.arange(n) + 0.5) / n
        assert density.pdf(centres[:, np.newaxis]) == pytest.approx(same.pdf(centres), rel=n * 1e-15)


def test_a_plane_is_its_marginal_and_its_rows() -> None:
    weights = rng().exponential(size=(5, 9))
    density = Density(weights)
    edges = [np.linspace(0, 1, n + 1) for n in weights.shape]
    marginal = stats.rv_histogram((weights.sum(axis=1), edges[0]), density=False)
    rows = [stats.rv_histogram((row, edges[1]), density=False) for row in weights]
    u = points("sobol", 512)
    drawn = density.sample(u)
    assert marginal.cdf(drawn[:, 1]) == pytest.approx(u[:, 1], abs=1e-14)
    back = [rows[int(y * 5)].cdf(x) for x, y in drawn]
    assert back == pytest.approx(u[:, 0], abs=1e-14)
    pdf = [rows[int(y * 5)].pdf(x) * marginal.pdf(y) for x, y in drawn]
    assert density.pdf(drawn) == pytest.approx(pdf, rel=1e-13)
    assert density.inverse(drawn) == pytest.approx(u, abs=1e-14)


def test_an_estimator_may_use_any_density() -> None:
    """The integral of x^8 + 0.1 y^2 by points of a coarse picture of it: unbiased, and with less variance."""

    def integrand(p: Array) -> Array:
        return p[:, 0] ** 8 + 0.1 * p[:, 1] ** 2

    centres = (np.arange(16) + 0.5) / 16
    density = Density(centres[np.newaxis, :] ** 8 + 0.1 * centres[:, np.newaxis] ** 2)
    u = rng().random((100_000, 2))
    drawn = density.sample(u)
    estimates = integrand(drawn) / density.pdf(drawn)
    exact = 1 / 9 + 0.1 / 3
    assert abs(estimates.mean() - exact) < 5 * estimates.std() / len(u) ** 0.5  # once in 1.7 million
    assert estimates.std() < integrand(u).std() / 3


def test_what_has_no_meaning_is_refused() -> None:
    for weights, words in (([0.0, 0.0], "all weights are zero"), ([1.0, np.nan], "column 1"), ([[1], [-2.0]], "row 1")):
        with pytest.raises(SpecError, match=words):
            Density(weights)
    for shape in (np.ones((2, 2, 2)), np.ones((0,)), np.ones((3, 0)), 1.0):
        with pytest.raises(InvalidInput, match="weights of a density"):
            Density(shape)
    with pytest.raises(InvalidInput, match=r"\(n, 2\)"):
        warps.SPHERE.sample([0.5, 0.5])
    with pytest.raises(InvalidInput):
        warps.DISC.inverse([[2.0, 0.0]])
    with pytest.raises(InvalidInput, match="one line"):
        warps.triangle_pdf([[0, 0, 0], [1, 1, 1], [2, 2, 2]])
    with pytest.raises(InvalidInput, match="three vertices"):
        warps.triangle_pdf([[0, 0, 0], [1, 1, 1]])
    assert warps.triangle_pdf([[0, 0, 0], [2, 0, 0], [0, 1, 0]]) == 1.0
    assert warps.DISC.sample(np.empty((0, 2))).shape == (0, 2)
