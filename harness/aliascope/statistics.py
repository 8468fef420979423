"""Means with their uncertainty, and rates of convergence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
    # In the power of two above the largest: without rounding, and no square is beyond a double.
    exponent = math.frexp(max(map(abs, values), default=0.0))[1]
    squares = mean([math.ldexp(value, -exponent) ** 2 for value in values])
    assert squares.value is not None
    root, error = math.sqrt(squares.value), squares.standard_error
    if error is not None and root > 0.0:
        error /= 2.0 * root
    return Estimate(math.ldexp(root, exponent), None if error is None else math.ldexp(error, exponent))


@dataclass(frozen=True)
class Spread:
    """How runs of the same work differ: the standard deviation of the logarithms of their times, from so many degrees
    of freedom; `known` is what it is at least, whatever the runs say."""

    sigma: float
    freedom: float
    known: float = 0.0


CAUGHT = 0.95
"""Variances of one mode beyond this quantile of what chance makes count no more than that."""

ROUNDS = 200
"""Steps to the pooled variance at most."""


def pooled_spread(groups: Sequence[Sequence[float]], drift: float = 0.0) -> Spread | None:
    """The spread that groups of runs have in common, each of one piece of work: the standard deviation of the
    logarithms of their times. None without two runs, above zero, of one piece.

    Each group's variance is of n - 1 degrees of freedom. Outliers count little: the pooled variance is that under which
    the groups' own, none above its CAUGHT quantile, are as large as such variances are in the mean (an M-estimate of
    scale, Huber 1964). Of three runs each with normal noise, with one run in twenty much slower, and with noise of
    Student's t with 4 degrees of freedom, intervals from it cover 95 to 97 % of the true times; of modes whose own
    spreads differ by up to a factor of two either way 92 %.

    drift: by how much the machine became slower from the first quarter of the runs to the last. As runs lie by chance
    between, that spreads them by 4/3 drift / sqrt(12) at least.
    """
    from scipy.special import chdtr, chdtri  # the distributions alone; scipy.stats takes a second to load

    logs = [np.log(group) for group in groups if len(group) > 1 and min(group) > 0.0]
    if not logs:
        return None
    freedom = np.array([len(each) - 1 for each in logs], dtype=np.float64)
    variances = np.array([each.var(ddof=1) for each in logs])
    ends = chdtri(freedom, 1.0 - CAUGHT) / freedom
    # The mean of min(V, end) for V of mean 1: a chi-squared variable over its degrees of freedom.
    expected = chdtr(freedom + 2.0, ends * freedom) + ends * (1.0 - CAUGHT)
    wanted, variance = float((freedom * expected).sum()), float(np.average(variances, weights=freedom))
    for _ in range(ROUNDS if variance > 0.0 else 0):  # falls from the plain mean, which outliers make too large
        ratio = float((freedom * np.minimum(variances / variance, ends)).sum()) / wanted
        variance *= ratio
        if abs(ratio - 1.0) < 1e-9:
            break
    return Spread(math.sqrt(variance), float(freedom.sum()), abs(drift) * (4.0 / 3.0) / math.sqrt(12.0))


_OF_MEDIAN = (1.0, 1.0, 0.707, 0.670, 0.546, 0.536, 0.463, 0.459, 0.410, 0.408)
"""Standard errors of the median of 0 to 9 values of the normal distribution, in standard deviations."""


def median_time(seconds: Sequence[float], spread: Spread | None) -> Estimate:
    """The median of timed runs, its standard error and its interval of 95 %, from the spread of runs of such work;
    without it nothing is known but the median."""
    from scipy.special import stdtrit

    value = float(np.median(np.asarray(seconds)))
    if spread is None or value <= 0.0:
        return Estimate(value)
    n = len(seconds)
    share = _OF_MEDIAN[n] if n < len(_OF_MEDIAN) else math.sqrt(math.pi / (2.0 * n + 1.0))
    half = share * max(float(stdtrit(spread.freedom, 0.975)) * spread.sigma, 1.96 * spread.known)
    error = value * share * max(spread.sigma, spread.known)
    return Estimate(value, error, (value * math.exp(-half), value * math.exp(half)))


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


def near_logarithms(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Logarithms of positive values, and a number that is to be added to them: the logarithm of the first where all are
    within half as much again, as differences of near logarithms have few digits; else 0."""
    if values.max() <= 1.5 * values.min():
        return np.log1p((values - values[0]) / values[0]), math.log(values[0])
    return np.log(values), 0.0


def rate(counts: Sequence[float], errors: Sequence[float]) -> Rate | None:
    """The power law through (n, error), by least squares of the logarithms; None with fewer than three of them."""
    pairs = [(float(n), float(e)) for n, e in zip(counts, errors, strict=True) if n > 0 and e > 0]
    if len({n for n, _ in pairs}) < 3:
        return None
    from scipy.stats import linregress  # takes a second to load, and most commands fit nothing

    (x, x_origin), (y, y_origin) = map(near_logarithms, np.array(pairs).T)
    fit = linregress(x, y)
    return Rate(float(fit.slope), float(fit.stderr), math.exp(float(fit.intercept) + (y_origin - fit.slope * x_origin)))


@dataclass(frozen=True)
class FittedRate:
    """error = constant * n^exponent over [least_n, most_n], with a 95 % interval of the exponent.

    curved: the points lie on a bend, at 1 % significance; the interval then takes in the slopes of the bend at both
    ends, so that it holds the rate at least_n and at most_n. local: the slope at most_n, of the bend if there is one.
    standard_error is that of the straight line's exponent, with `freedom` degrees of freedom.
    """

    exponent: float
    interval: tuple[float, float]
    constant: float
    least_n: int
    most_n: int
    count: int
    curved: bool
    local: float
    standard_error: float
    freedom: float


def fit_rate(
    counts: Sequence[int], errors: Sequence[float], standard_errors: Sequence[float], freedom: float = 0.0
) -> FittedRate:
    """The power law through three or more (n, error), all above 0, by weighted least squares of the logarithms.

    Weights are those of the standard errors, or equal where one of them is 0. The interval is Student's, with the
    scatter about the line in it where that is larger than the standard errors account for (Birge 1932). Raises
    ValueError for fewer than three.

    freedom: the degrees of freedom that the standard errors are known with, together; 0 where that is not known. With
    it the scatter, unless it is larger than they account for at 1 % significance, and the standard errors are pooled,
    which makes three points enough for a useful interval.
    """
    from scipy.special import stdtrit  # the quantiles alone; scipy.stats takes a second to load

    if len(set(counts)) < 3:
        raise ValueError("a rate is of three numbers of points or more")
    x, x_origin = near_logarithms(np.array(counts, dtype=np.float64))
    y, y_origin = near_logarithms(np.array(errors, dtype=np.float64))
    spread = np.array(standard_errors) / np.array(errors)
    weighted = bool((spread > 0.0).all())
    spread = spread if weighted else np.ones_like(x)
    middle = float(np.average(x, weights=spread**-2.0))
    line, line_error, free = _least_squares(x - middle, y, spread, 1, weighted, freedom)
    half = float(stdtrit(free, 0.975)) * line_error
    low, high, local, curved = line[1] - half, line[1] + half, line[1], False
    if len(x) >= 5:
        bend, bend_error, bend_free = _least_squares(x - middle, y, spread, 2, weighted, freedom)
        if abs(bend[2]) > float(stdtrit(bend_free, 0.995)) * bend_error:
            ends = [bend[1] + 2.0 * bend[2] * (end - middle) for end in (x.min(), x.max())]
            low, high, local, curved = min(low, *ends), max(high, *ends), ends[1], True
    constant = math.exp((line[0] - line[1] * middle) + (y_origin - line[1] * x_origin))
    return FittedRate(line[1], (low, high), constant, min(counts), max(counts), len(x), curved, local, line_error, free)


def _least_squares(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    spread: NDArray[np.float64],
    degree: int,
    weighted: bool,
    freedom: float,
) -> tuple[list[float], float, float]:
    """The coefficients of a polynomial, constant first, the standard error of the last, its degrees of freedom."""
    design = np.vander(x, degree + 1, increasing=True) / spread[:, None]
    covariance = np.linalg.inv(design.T @ design)
    found = covariance @ (design.T @ (y / spread))
    free = float(len(x) - degree - 1)
    squares = float((((y / spread) - design @ found) ** 2).sum())
    scatter = squares / free if free else 0.0
    if weighted and freedom and not _larger(scatter, free, freedom):
        free += freedom
        scatter = (squares + freedom) / free
    elif weighted:
        scatter = max(1.0, scatter)
    return found.tolist(), math.sqrt(covariance[-1, -1] * scatter), free


def _larger(scatter: float, free: float, freedom: float) -> bool:
    """Whether scatter over the squares of standard errors is more than 1, at 1 % significance (Fisher's F)."""
    from scipy.special import fdtrc

    return free > 0 and float(fdtrc(free, freedom, scatter)) < 0.01
