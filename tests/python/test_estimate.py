"""Estimates from Python: against exact fractions and SciPy, and what happens when an integrand fails."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate, stats

import aliascope
from aliascope.errors import InvalidInput, JobFailed, SpecError, Unsupported
from aliascope.native import estimate
from aliascope.native.estimate import Estimator, Moments
from aliascope.native.warps import Density

VALUES = st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=60)


@settings(max_examples=60, deadline=None)
@given(VALUES, st.sampled_from([0.0, 1e8, -1e12]), st.integers(0, 60))
def test_moments_are_those_of_exact_fractions(values: list[float], shift: float, at: int) -> None:
    given_values = [value + shift for value in values]
    exact = [Fraction(value) for value in given_values]
    mean = sum(exact) / len(exact)
    variance = sum((value - mean) ** 2 for value in exact) / (len(exact) - 1)
    whole, merged = Moments(given_values), Moments(given_values[:at])
    merged.merge(Moments(given_values[at:]))
    spread = float(max(exact) - min(exact))
    for moments in (whole, merged):
        assert moments.count == len(exact)
        # A rounding of the mean itself, and of about one a value in the differences.
        assert abs(Fraction(moments.mean) - mean) <= 2e-16 * abs(float(mean)) + 4e-16 * len(exact) * spread
        assert moments.variance == pytest.approx(float(variance), rel=1e-13 * len(exact), abs=1e-30 * shift**2)


def test_the_interval_is_that_of_scipy() -> None:
    values = np.random.Generator(np.random.PCG64(3)).normal(size=12)
    expected = stats.t.interval(0.9, 11, values.mean(), stats.sem(values))
    assert Moments(values).interval(0.9) == pytest.approx(expected, rel=1e-12)
    with pytest.raises(InvalidInput):
        Moments([1.0]).interval()
    with pytest.raises(JobFailed, match="not a finite"):
        Moments([1.0, math.nan])


def test_strata() -> None:
    draws = np.random.Generator(np.random.PCG64(4)).random((3, 50))
    found = estimate.stratify([Moments(row) for row in draws], [1.0, 2.0, 1.0])
    shares = np.array([0.25, 0.5, 0.25])
    assert found.mean == pytest.approx(shares @ draws.mean(axis=1), rel=1e-14)
    assert found.standard_error == pytest.approx(math.sqrt(shares**2 @ draws.var(axis=1, ddof=1) / 50), rel=1e-13)
    assert 49 <= found.degrees <= 147  # between the least of a stratum and all together
    with pytest.raises(InvalidInput):
        estimate.stratify([Moments([1.0])], [1.0, 2.0])
    with pytest.raises(InvalidInput):
        estimate.stratify([Moments()])


def test_channels_and_groups() -> None:
    def integrand(points: estimate.Array) -> estimate.Array:
        return np.stack([points[:, 0], points[:, 1] ** 2, np.ones(len(points))], axis=1)

    made = Estimator("fixed", "sobol:scramble=owen", 4096, 2, channels=3, seed=1).estimate(integrand, (-5, 7, 3, 2))
    assert made.means.shape == (2, 3, 3)
    assert made.counts.shape == made.degrees.shape == (2, 3)
    # Owen-scrambled nets of 2^12 points on smooth functions err by some 4096^-1.5 = 4e-6.
    assert np.abs(made.means - [1 / 2, 1 / 3, 1]).max() < 1e-4
    assert made.standard_errors[..., 2].max() == 0.0
    assert made.spent == 6 * 4096
    assert len(np.unique(made.means[..., 0])) == 6  # every pixel has samples of its own


def test_scipy_integrates_the_same() -> None:
    found = aliascope.estimate(lambda x: np.exp(x[:, 0]) * np.cos(3 * x[:, 1]), sampler="gauss-legendre", n=144)
    expected, _ = integrate.dblquad(lambda y, x: math.exp(x) * math.cos(3 * y), 0, 1, 0, 1, epsabs=1e-13)
    assert found.means[0, 0, 0] == pytest.approx(expected, abs=1e-12)
    assert np.isnan(found.standard_errors).all()  # a rule's error is not random


def test_importance() -> None:
    density = Density(np.array([1.0, 3.0, 0.0, 2.0]))

    def integrand(x: estimate.Array) -> estimate.Array:
        return np.where((x[:, 0] < 0.5) | (x[:, 0] >= 0.75), 1.0 + x[:, 0], 0.0)  # 0 where the density is

    by = estimate.importance(integrand, lambda u: (x := density.sample(u), density.pdf(x)))
    made = Estimator("fixed", "random", 1 << 16, 1).estimate(by)
    # 1/2 + 1/8 over [0, 1/2), 1/4 + (1 - 9/16)/2 beyond; five standard errors.
    assert abs(made.means[0, 0, 0] - (0.625 + 0.25 + 0.21875)) < 5 * made.standard_errors[0, 0, 0]
    nowhere = estimate.importance(lambda x: 1.0 / x, lambda u: (np.zeros_like(u), np.zeros(len(u))))
    with np.errstate(divide="ignore"):
        assert Estimator("fixed", "random", 16, 1).estimate(nowhere).means[0, 0, 0] == 0.0


def test_what_an_integrand_raises_comes_through() -> None:
    class Stop(Exception):
        pass

    def stop(points: estimate.Array) -> estimate.Array:
        raise Stop("enough")

    estimator = Estimator("student-t", samples=64)
    for _ in range(2):
        with pytest.raises(Stop, match="enough"):
            estimator.estimate(stop)
    with pytest.raises(InvalidInput, match="shape"):
        estimator.estimate(lambda points: points[:, :2])
    with pytest.raises(JobFailed, match="not finite"):
        estimator.estimate(lambda points: np.full(len(points), np.inf))
    with pytest.raises(InvalidInput, match="one pixel"):
        estimator.estimate(lambda points: points[:, 0], (0, 0, 0, 1))
    assert estimator.estimate(lambda points: points[:, 0]).counts[0, 0] <= 64


def test_an_integrand_may_keep_its_points() -> None:
    kept: list[estimate.Array] = []

    def integrand(points: estimate.Array) -> estimate.Array:
        kept.append(points)
        return points[:, 0]

    estimator = Estimator("fixed", samples=20_000)  # more than are asked for at once
    mean = estimator.estimate(integrand).means[0, 0, 0]
    assert len(kept) > 1
    assert np.concatenate(kept)[:, 0].mean() == pytest.approx(mean, rel=1e-12)
    assert (np.concatenate(kept) == estimator.sampler.points(20_000)).all()


def test_specs() -> None:
    assert estimate.canonical("student-t:confidence=0.95,batch=2") == "student-t:batch=2"
    assert Estimator("chi-squared:minimum=8,unbiased=1").spec == "chi-squared:unbiased=1"
    with pytest.raises(SpecError, match="student-t"):
        estimate.canonical("student")
    with pytest.raises(Unsupported, match="no sequence"):
        Estimator("student-t", "jittered", 64)
    names = {info.name: info for info in estimate.registered()}
    assert {"fixed", "stratified", "student-t", "chi-squared"} <= set(names)
    assert any("default 0.95" in key for key in names["student-t"].parameters)
