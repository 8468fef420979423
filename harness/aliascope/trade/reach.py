"""What a family of modes takes to reach an error, and the error that it has after a time.

Between modes the lower left envelope of a family counts: the straight lines, in logarithms, through those of its modes
that no other one of it beats in both. Beyond its last mode a family goes on by its rate against samples, a sample
taking the time that it takes in that mode, where the rate is known well enough; never below QUANTISATION.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aliascope.trade.convergence import against_samples
from aliascope.trade.records import QUANTISATION, Afford, How, Interval, Reach
from aliascope.trade.uncertainty import Array, Points, student_draws

WELL_KNOWN = 2.0
"""The largest factor by which a time that is extrapolated may be off, at either end of its interval."""

FALLS = -0.1
"""An exponent against samples above which an error is taken not to fall."""


@dataclass(frozen=True)
class Family:
    """The modes of a scene that differ in their count alone: `own` are their places in `points`, by rising time.

    known: whether the spreads of all its modes are. falling: its error goes on falling with more samples, as far as
    its rate tells; `slope` is then the exponent, and `slopes` (DRAWS,) what it could be.
    """

    points: Points
    name: tuple[str, str]
    own: NDArray[np.intp]
    known: bool
    falling: bool
    slope: float
    slopes: Array


@dataclass(frozen=True)
class Answer:
    """At one target: the logarithm of the figure, NaN where there is none, what it could be (DRAWS,), inf where it is
    not reached, and the mode to choose."""

    value: float
    draws: Array
    how: How
    mode: int


def families(points: Points) -> list[Family]:
    """Those of a scene, by renderer and name."""
    return [_family(points, name, own) for name, own in points.families().items()]


def _family(points: Points, name: tuple[str, str], own: NDArray[np.intp]) -> Family:
    spreads = (points.time_spread.standard_error[own], points.error_spread.standard_error[own])
    known = not bool(np.isnan(spreads).any())
    rate = against_samples(points, own)
    if rate is None or rate.curved or rate.interval[1] > FALLS:
        return Family(points, name, own, known, False, math.nan, np.empty(0))
    slopes = rate.exponent + student_draws(points.key, name, rate.standard_error, rate.freedom)
    return Family(points, name, own, known, True, rate.exponent, np.minimum(slopes, FALLS / 2.0))


def crossing(along: Array, across: Array, target: float) -> Array:
    """Where the envelope of points (draws, n) first falls to `target`, as (draws,): the least `along`; inf where no
    point is as low. All are logarithms. A line from or to a point at -inf is a step."""
    order = np.argsort(along, axis=-1, kind="stable")
    x, y = np.take_along_axis(along, order, -1), np.take_along_axis(across, order, -1)
    low = y <= target
    first = np.argmax(low, axis=-1)
    rows = np.arange(len(x))
    # The lowest of those before bounds the line, with the first that is as low; of equals the soonest.
    least = np.minimum.accumulate(y, axis=-1)[rows, np.maximum(first - 1, 0)]
    previous = np.argmax(y <= least[:, None], axis=-1)
    x0, y0, x1, y1 = x[rows, previous], y[rows, previous], x[rows, first], y[rows, first]
    step = (first == 0) | np.isneginf(x0) | np.isneginf(y1)
    with np.errstate(invalid="ignore", divide="ignore"):
        found: Array = np.where(step, x1, x0 + (y0 - target) / (y0 - y1) * (x1 - x0))
    return np.where(low.any(axis=-1), found, np.inf)


def to_error(family: Family, error: float) -> Answer:
    """The logarithm of the CPU seconds that reach an error."""
    points, own, target = family.points, family.own, math.log(error)
    time, height = points.time[own], points.error[own]
    able = np.flatnonzero(height <= target)
    if len(able):
        value = float(crossing(time[None], height[None], target)[0])
        draws = crossing(points.times[:, own], points.errors[:, own], target)
        return Answer(value, draws, "measured" if able[0] == 0 else "between", int(own[able[0]]))
    nearest = int(own[np.argmin(height)])
    # The last digits of a target that is QUANTISATION itself are not to decide.
    if family.falling and error >= QUANTISATION * (1.0 - 1e-9):
        value = float(points.time[nearest] + (target - points.error[nearest]) / family.slope)
        further = (target - points.errors[:, nearest]) / family.slopes
        draws = points.times[:, nearest] + further
        if _well_known(draws - value):
            return Answer(value, draws, "extrapolated", nearest)
    return Answer(math.nan, np.empty(0), "cannot", nearest)


def at_time(family: Family, seconds: float) -> Answer:
    """The logarithm of the error after so many CPU seconds."""
    points, own, target = family.points, family.own, math.log(seconds)
    time, height = points.time[own], points.error[own]
    able = np.flatnonzero(time <= target)
    if not len(able):
        return Answer(math.nan, np.empty(0), "cannot", int(own[0]))
    mode = int(own[able[np.argmin(height[able])]])
    value = float(crossing(height[None], time[None], target)[0])
    draws = crossing(points.errors[:, own], points.times[:, own], target)
    if height.min() < points.error[mode]:
        return Answer(value, draws, "between", mode)
    floor = math.log(QUANTISATION)
    if family.falling and points.error[mode] > floor:
        further = float(points.error[mode]) + family.slope * (target - float(points.time[mode]))
        drawn = points.errors[:, mode] + family.slopes * (target - points.times[:, mode])
        if _well_known((drawn - further) / family.slope):
            return Answer(max(floor, further), np.maximum(floor, drawn), "extrapolated", mode)
    return Answer(value, draws, "measured", mode)


def _well_known(off: Array) -> bool:
    """Whether the logarithm of a time is known, from what it could be off by (DRAWS,)."""
    low, high = np.quantile(off, (0.025, 0.975), method="inverted_cdf")
    return max(-float(low), float(high)) < math.log(WELL_KNOWN)


def reach(family: Family, error: float) -> Reach:
    """The answer at an error, as records have it."""
    answer, points = to_error(family, error), family.points
    row = points.rows[answer.mode]
    best = math.exp(points.error[family.own].min())
    return Reach(*family.name, error, interval(family, answer), answer.how, row.mode, row.label, best)


def afford(family: Family, seconds: float) -> Afford:
    """The answer at a time, as records have it."""
    answer, points = at_time(family, seconds), family.points
    row = points.rows[answer.mode]
    fastest = math.exp(points.time[family.own].min())
    return Afford(*family.name, seconds, interval(family, answer), answer.how, row.mode, row.label, fastest)


def interval(family: Family, answer: Answer) -> Interval | None:
    """The figure itself, with its ends where the spreads of the family's modes are known; without the upper one where
    it may not be reached at all."""
    if math.isnan(answer.value):
        return None
    value = math.exp(answer.value)
    if not family.known:
        return Interval(value, None, None)
    return Interval(value, *ends(answer.draws))


def ends(draws: Array) -> tuple[float | None, float | None]:
    """Of the interval of 95 %, from logarithms (DRAWS,) that may be infinite."""
    low, high = (float(end) for end in np.quantile(draws, (0.025, 0.975), method="inverted_cdf"))
    return (math.exp(low) if low < math.inf else None, math.exp(high) if high < math.inf else None)
