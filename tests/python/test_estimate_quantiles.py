"""Quantiles against SciPy where it is exact, and against mpmath where it is not."""

from __future__ import annotations

import itertools
import math

import mpmath
import numpy as np
import pytest
from scipy import stats

from aliascope.errors import InvalidInput
from aliascope.native.estimate import chi_squared_quantile, normal_quantile, student_t_quantile

CLOSE = 1e-12  # what estimate.h promises, relative
PS = [1e-300, 1e-100, 1e-30, 1e-12, 1e-5, 0.01, 0.05, 0.1, 0.11, 0.25, 0.4, 0.49, 0.5 - 1e-9, 0.5 + 1e-12]
PS += [0.6, 0.75, 0.9, 0.95, 0.99, 1 - 1e-6, 1 - 1e-12]
DEGREES = [1, 2, 2.5, 3, 10, 1e3, 9999, 1e4, 1e9, 1e12]


@pytest.mark.parametrize("p", PS)
def test_normal_quantiles_are_those_of_scipy(p: float) -> None:
    assert normal_quantile(p) == pytest.approx(stats.norm.ppf(p), rel=CLOSE, abs=0)


def _off(found: float, p: float, cdf: mpmath.mpf, density: mpmath.mpf) -> float:
    """How far a quantile is from the exact one, relative: one Newton step, of 36 digits."""
    return abs(float((mpmath.mpf(p) - cdf) / density / found))


def _integral(density: object, start: mpmath.mpf, end: mpmath.mpf, width: mpmath.mpf) -> mpmath.mpf:
    """Of a density that falls off from `start`, over steps of `width`, until nothing is left or `end` is reached."""
    sign, total, at = (1 if end > start else -1), mpmath.mpf(0), start
    while abs(end - at) > 0:
        step = sign * min(width, abs(end - at))
        part = mpmath.quad(density, [at, at + step])
        total += part
        at += step
        if abs(part) < abs(total) * mpmath.mpf(10) ** -15:
            break
    return abs(total)


def _student_off(p: float, degrees: float) -> float:
    x = mpmath.mpf(student_t_quantile(p, degrees))
    v = mpmath.mpf(degrees)
    scale = mpmath.exp(mpmath.loggamma((v + 1) / 2) - mpmath.loggamma(v / 2)) / mpmath.sqrt(v * mpmath.pi)

    def density(t: mpmath.mpf) -> mpmath.mpf:
        return scale * mpmath.exp(-(v + 1) / 2 * mpmath.log1p(t * t / v))

    if abs(p - 0.5) < 0.3:
        cdf = mpmath.mpf("0.5") + mpmath.sign(x) * mpmath.quad(density, [0, abs(x)])
    else:  # by 1/s for t: the tail of few degrees is long
        tail = mpmath.betainc(v / 2, mpmath.mpf("0.5"), 0, v / (v + x * x), regularized=True) / 2
        cdf = tail if x < 0 else 1 - tail
    return _off(float(x), p, cdf, density(x))


@pytest.fixture(autouse=True)
def _many_digits() -> object:
    with mpmath.workdps(36):
        yield


@pytest.mark.parametrize(("degrees", "p"), [c for c in itertools.product(DEGREES, PS) if c[0] <= 1e4])
def test_student_quantiles_are_exact(degrees: float, p: float) -> None:
    assert _student_off(p, degrees) < CLOSE


@pytest.mark.parametrize(("degrees", "p"), list(itertools.product([1e9, 1e12], PS)))
def test_student_quantiles_of_many_degrees(degrees: float, p: float) -> None:
    # Fisher's expansion (Abramowitz and Stegun 26.7.5); the term left off is below z^8/degrees^3 = 4e-15 of it.
    z = (
        mpmath.sqrt(2) * mpmath.erfinv(2 * mpmath.mpf(p) - 1)
        if 1e-12 < p < 1 - 1e-11
        else mpmath.mpf(normal_quantile(p))
    )
    expected = z + (z**3 + z) / (4 * degrees) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * degrees**2)
    assert student_t_quantile(p, degrees) == pytest.approx(float(expected), rel=CLOSE, abs=0)


@pytest.mark.parametrize(("degrees", "p"), [c for c in itertools.product(DEGREES, PS) if c[0] <= 1e4])
@pytest.mark.parametrize("upper", [False, True])
def test_chi_squared_quantiles_are_those_of_scipy(degrees: float, p: float, upper: bool) -> None:
    expected = stats.chi2.isf(p, degrees) if upper else stats.chi2.ppf(p, degrees)
    assert chi_squared_quantile(p, degrees, upper=upper) == pytest.approx(expected, rel=CLOSE, abs=0)


@pytest.mark.parametrize(("degrees", "p"), list(itertools.product([1e9, 1e12], [1e-300, 1e-12, 0.05, 0.6])))
@pytest.mark.parametrize("upper", [False, True])
def test_chi_squared_quantiles_of_many_degrees(degrees: float, p: float, upper: bool) -> None:
    # SciPy is off by up to 4e-6 of these. The density is integrated outward from x in steps of about its fall.
    x, a = mpmath.mpf(chi_squared_quantile(p, degrees, upper=upper)), mpmath.mpf(degrees) / 2

    def density(y: mpmath.mpf) -> mpmath.mpf:
        return mpmath.exp((a - 1) * mpmath.log(y / 2) - y / 2 - mpmath.loggamma(a)) / 2

    deviation = mpmath.sqrt(2 * mpmath.mpf(degrees))
    far = x + (50 if upper else -50) * deviation
    tail = _integral(density, x, far, 2 * deviation / (1 + abs(normal_quantile(p))))
    assert _off(float(x), p, tail, density(x)) < CLOSE


def test_what_scipy_gives_for_many_p() -> None:
    """Four hundred p and degrees at random, log-uniform, where SciPy is good."""
    drawn = np.random.Generator(np.random.PCG64(11)).random((400, 2))
    for u, v in drawn:
        degrees, p = 10.0 ** (4.0 * v), 10.0 ** (-12.0 * u) / 2.0
        assert student_t_quantile(p, degrees) == pytest.approx(stats.t.ppf(p, degrees), rel=CLOSE, abs=0) or (
            _student_off(p, degrees) < CLOSE
        )
        for upper in (False, True):
            expected = stats.chi2.isf(p, degrees) if upper else stats.chi2.ppf(p, degrees)
            assert chi_squared_quantile(p, degrees, upper=upper) == pytest.approx(expected, rel=CLOSE, abs=0)


def test_refused() -> None:
    for call in (normal_quantile, lambda p: student_t_quantile(p, 3), lambda p: chi_squared_quantile(p, 3)):
        for p in (0.0, 1.0, math.nan):
            with pytest.raises(InvalidInput):
                call(p)
