"""Means with their uncertainty, and rates of convergence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aliascope.records import Estimate


def mean(values: Sequence[float]) -> Estimate:
    """The mean and its standard error, from n - 1 degrees of freedom; unknown for a single value."""
    array = np.asarray(values, dtype=np.float64)
    if len(array) < 2:
        return Estimate(float(array[0]) if len(array) else None)
    # Around the first value: the mean of large, nearly equal values keeps its digits.
    moved = array - array[0]
    return Estimate(float(array[0] + moved.mean()), float(moved.std(ddof=1) / math.sqrt(len(array))))


def root_mean_square(values: Sequence[float]) -> Estimate:
    """The root of the mean of squares, its standard error by the delta method: d sqrt(x) = dx / (2 sqrt(x))."""
    squares = mean([value * value for value in values])
    assert squares.value is not None
    root = math.sqrt(squares.value)
    if squares.standard_error is None or root == 0.0:
        return Estimate(root, squares.standard_error)
    return Estimate(root, squares.standard_error / (2.0 * root))


TELLING = 2.0
"""Standard errors of a difference from which on it is taken for one: 95 % of what is none stays below."""


def told_apart(a: Estimate, b: Estimate) -> bool:
    """Whether two figures differ by more than TELLING standard errors of their difference, the estimates being
    independent. An uncertainty that is not known counts as none: nothing is called alike on a guess."""
    if a.value is None or b.value is None:
        return True
    return abs(a.value - b.value) > TELLING * math.hypot(a.standard_error or 0.0, b.standard_error or 0.0)


@dataclass(frozen=True)
class Rate:
    """error = constant * n^exponent, fitted; `standard_error` is the exponent's."""

    exponent: float
    standard_error: float | None
    constant: float


def rate(counts: Sequence[float], errors: Sequence[float]) -> Rate | None:
    """The power law through (n, error), by least squares of the logarithms; None with fewer than three of them."""
    pairs = [(math.log(n), math.log(e)) for n, e in zip(counts, errors, strict=True) if n > 0 and e > 0]
    if len({n for n, _ in pairs}) < 3:
        return None
    from scipy.stats import linregress  # takes a second to load, and most commands fit nothing

    x, y = np.array(pairs).T
    fit = linregress(x, y)
    return Rate(float(fit.slope), float(fit.stderr), math.exp(float(fit.intercept)))
