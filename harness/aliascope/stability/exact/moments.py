"""Statistics of doubles in mpmath, at the caller's working precision."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import mpmath

Floats = Sequence[float]
Number = Any
"""One of mpmath's, which has no types."""


def _numbers(values: Floats) -> list[Number]:
    return [mpmath.mpf(float(value)) for value in values]


def mean(values: Floats) -> Number:
    return mpmath.fsum(_numbers(values)) / len(values)


def variance(values: Floats) -> Number:
    """Of one value, unbiased."""
    middle = mean(values)
    return mpmath.fsum((value - middle) ** 2 for value in _numbers(values)) / (len(values) - 1)


def standard_error(values: Floats) -> Number:
    return mpmath.sqrt(variance(values) / len(values))


def root_mean_square(values: Floats) -> Number:
    return mpmath.sqrt(mpmath.fsum(value**2 for value in _numbers(values)) / len(values))


def upper_end(values: Floats, confidence: float) -> Number:
    """Of Student's interval about the mean."""
    error = standard_error(values)
    return mean(values) + (_student_quantile(len(values) - 1, confidence) * error if error else 0)


@lru_cache(maxsize=64)
def _student_quantile(degrees: int, confidence: float) -> Number:
    """t beyond which lies half of what is left, to 30 digits."""
    with mpmath.workdps(30):
        wanted = (1 - mpmath.mpf(confidence)) / 2
        if degrees == 1:
            return mpmath.cot(mpmath.pi * wanted)
        t = mpmath.sqrt(2) * mpmath.erfinv(1 - 2 * wanted)
        for _ in range(60):  # Newton's steps from below, the tail being convex: they stay there
            step = (student_tail(t, degrees) - wanted) / student_density(t, degrees)
            t += step
            if abs(step) < mpmath.mpf(10) ** -20 * t:
                break
        return t


def stratified(values: Floats, each: int, sizes: Floats | None = None) -> Number:
    """The standard error of the mean over strata of `each` values: those of one are collapsed in pairs (Cochran 1977,
    section 5A.12)."""
    parts = [values[i : i + each] for i in range(0, len(values), each)]
    shares = _numbers([1.0] * len(parts) if sizes is None else sizes)
    whole = mpmath.fsum(shares)
    shares = [share / whole for share in shares]
    if each > 1:
        return mpmath.sqrt(mpmath.fsum(w**2 * variance(part) / each for w, part in zip(shares, parts, strict=True)))
    weighted = [w * part[0] for w, part in zip(shares, parts, strict=True)]
    squares, begin = mpmath.mpf(0), 0
    while begin < len(weighted):
        size = 3 if len(weighted) - begin == 3 else 2
        group = weighted[begin : begin + size]
        middle = mpmath.fsum(group) / size
        squares += mpmath.fsum((value - middle) ** 2 for value in group) * size / (size - 1)
        begin += size
    return mpmath.sqrt(squares)


def satterthwaite_degrees(values: Floats) -> Number:
    """Of strata of two values, all of one size."""
    variances = [variance(values[i : i + 2]) for i in range(0, len(values), 2)]
    return mpmath.fsum(variances) ** 2 / mpmath.fsum(each**2 for each in variances)


def slope(counts: Sequence[int], errors: Floats) -> Number:
    """Of the line through the logarithms, by least squares."""
    x, y = ([mpmath.log(value) for value in _numbers(given)] for given in ([float(n) for n in counts], errors))
    middle = mpmath.fsum(x) / len(x)
    return mpmath.fsum((a - middle) * b for a, b in zip(x, y, strict=True)) / mpmath.fsum((a - middle) ** 2 for a in x)


def student_density(t: Number, degrees: float) -> Number:
    v = mpmath.mpf(degrees)
    scale = mpmath.exp(mpmath.loggamma((v + 1) / 2) - mpmath.loggamma(v / 2)) / mpmath.sqrt(v * mpmath.pi)
    return scale * mpmath.exp(-(v + 1) / 2 * mpmath.log1p(mpmath.mpf(t) ** 2 / v))


def student_tail(t: Number, degrees: float) -> Number:
    """P(T > t) for t > 0."""
    if degrees == 1:
        return mpmath.atan(1 / t) / mpmath.pi
    if degrees == 2:
        root = mpmath.sqrt(2 + t * t)
        return 1 / (root * (root + t))
    if degrees > 1e3:  # where the series is slow
        return _integral(lambda s: student_density(s, degrees), t)
    v = mpmath.mpf(degrees)
    return mpmath.betainc(v / 2, mpmath.mpf(1) / 2, 0, v / (v + t * t), regularized=True) / 2


def _integral(density: Callable[[Number], Number], begin: Number) -> Number:
    """From `begin` to where a law close to the normal one has nothing left for 30 digits."""
    return mpmath.quad(density, mpmath.linspace(begin, begin + 12, 13))


def chi_squared_density(x: Number, degrees: float) -> Number:
    half, value = mpmath.mpf(degrees) / 2, mpmath.mpf(x) / 2
    return mpmath.exp((half - 1) * mpmath.log(value) - value - mpmath.loggamma(half)) / 2


def chi_squared_tail(x: Number, degrees: float, upper: bool) -> Number:
    """P(X > x), or P(X < x)."""
    if degrees > 1e3:
        unit = mpmath.sqrt(2 * mpmath.mpf(degrees)) * (1 if upper else -1)
        return _integral(lambda s: abs(unit) * chi_squared_density(x + unit * s, degrees), mpmath.mpf(0))
    half, value = mpmath.mpf(degrees) / 2, mpmath.mpf(x) / 2
    bounds = (value, mpmath.inf) if upper else (0, value)
    return mpmath.gammainc(half, *bounds, regularized=True)


def quantile_error(
    tail: Number, wanted: float, density: Callable[[Number, float], Number], at: float, degrees: float
) -> float:
    """Of a quantile, relative: how far its tail is from the wanted one, by Newton's step."""
    return float(abs((tail - mpmath.mpf(wanted)) / (density(mpmath.mpf(at), degrees) * at)))
