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

from aliascope.statistics import FittedRate
from aliascope.trade.convergence import against_samples
from aliascope.trade.records import QUANTISATION, Afford, How, Interval, Reach
from aliascope.trade.uncertainty import Array, Points, ends, quantiles, student_draws

WELL_KNOWN = 2.0
"""The largest factor by which a time that is extrapolated may be off, at either end of its interval."""

FALLS = -0.1
"""An exponent against samples above which an error is taken not to fall."""


@dataclass(frozen=True)
class Family:
    """The modes of a scene that differ in their count alone: `own` are their places in `points`, by rising time.

    `sooner` are their times and errors (modes, 1 + DRAWS), in each draw by rising time, `better` their errors and
    times, in each draw by rising error; the first draw is what was measured. known: whether the spreads of all its
    modes are. falling: its error goes on falling with more samples, as far as its rate tells; `slopes` (1 + DRAWS,)
    are then the exponent and what it could be.
    """

    points: Points
    name: tuple[str, str]
    own: NDArray[np.intp]
    sooner: tuple[Array, Array]
    better: tuple[Array, Array]
    known: bool
    falling: bool
    slopes: Array


@dataclass(frozen=True)
class Answer:
    """At one target: the logarithm of the figure and what it could be (1 + DRAWS,), inf where it is not reached; None
    where it cannot be; and the mode to choose."""

    figures: Array | None
    how: How
    mode: int


def families(points: Points) -> list[Family]:
    """Those of a scene, by renderer and name."""
    return [_family(points, name, own) for name, own in points.families().items()]


def _family(points: Points, name: tuple[str, str], own: NDArray[np.intp]) -> Family:
    spreads = (points.time_spread.standard_error[own], points.error_spread.standard_error[own])
    known = not bool(np.isnan(spreads).any())
    time = np.column_stack((points.time[own], points.times[own]))
    error = np.column_stack((points.error[own], points.errors[own]))
    sooner, better = _in_order(time, error), _in_order(error, time)
    rate = against_samples(points, own)
    if rate is None or rate.curved or rate.interval[1] > FALLS or rate.count < len(own):
        return Family(points, name, own, sooner, better, known, False, np.empty(0))
    return Family(points, name, own, sooner, better, known, True, _slopes(points, name, own, rate))


def _slopes(points: Points, name: tuple[str, str], own: NDArray[np.intp], rate: FittedRate) -> Array:
    """The exponent, and what it could be: the fit to what the errors could be, with which it hangs together, and what
    the scatter about the line adds to that."""
    along = np.log([points.rows[i].samples_per_pixel for i in own])
    spread = points.error_spread.standard_error[own]
    weight = spread**-2.0 if (spread > 0.0).all() else np.ones(len(own))
    centred = along - np.average(along, weights=weight)
    share = weight * centred / (weight * centred**2).sum()
    drawn = share @ (points.errors[own] - points.error[own][:, None])
    more = rate.standard_error**2 - float((np.nan_to_num(share * spread) ** 2).sum())
    drawn += student_draws(points.key, name, math.sqrt(max(0.0, more)), rate.freedom)
    return np.concatenate(([rate.exponent], np.minimum(rate.exponent + drawn, FALLS / 2.0)))


def _in_order(along: Array, across: Array) -> tuple[Array, Array]:
    """Both (n, draws), sorted in each draw by the first, of equals by the second."""
    order = np.lexsort((across, along), axis=0)
    return np.take_along_axis(along, order, 0), np.take_along_axis(across, order, 0)


def crossing(along: Array, across: Array, target: float) -> Array:
    """Where the envelope of points (n, draws) first falls to `target`, as (draws,): the least `along`; inf where no
    point is as low. All are logarithms, and points in order of rising `along`. A line from or to a point at -inf is a
    step."""
    x, y = along[0].copy(), across[0].copy()
    found: Array = np.where(y <= target, x, np.inf)
    missing = y > target
    for next_x, next_y in zip(along[1:], across[1:], strict=True):
        hit = missing & (next_y <= target)
        if hit.any():
            x0, y0, x1, y1 = x[hit], y[hit], next_x[hit], next_y[hit]
            with np.errstate(invalid="ignore"):
                line = x0 + (y0 - target) / (y0 - y1) * (x1 - x0)
            found[hit] = np.where(np.isneginf(x0) | np.isneginf(y1), x1, line)
            missing &= ~hit
            if not missing.any():
                break
        # The lowest of those so far bounds the line to the first that is low enough.
        lower = next_y < y
        x, y = np.where(lower, next_x, x), np.where(lower, next_y, y)
    return found


def to_error(family: Family, error: float) -> Answer:
    """The logarithm of the CPU seconds that reach an error."""
    points, own, target = family.points, family.own, math.log(error)
    able = np.flatnonzero(points.error[own] <= target)
    if len(able):
        return Answer(crossing(*family.sooner, target), "measured" if able[0] == 0 else "between", int(own[able[0]]))
    nearest = int(own[np.argmin(points.error[own])])
    # The last digits of a target that is QUANTISATION itself are not to decide.
    if family.falling and error >= QUANTISATION * (1.0 - 1e-9):
        times, errors = _of_mode(points, nearest)
        figures = times + (target - errors) / family.slopes
        if _well_known(figures - figures[0]):
            return Answer(figures, "extrapolated", nearest)
    return Answer(None, "cannot", nearest)


def at_time(family: Family, seconds: float) -> Answer:
    """The logarithm of the error after so many CPU seconds."""
    points, own, target = family.points, family.own, math.log(seconds)
    able = own[points.time[own] <= target]
    if not len(able):
        return Answer(None, "cannot", int(own[0]))
    mode = int(able[np.argmin(points.error[able])])
    figures = crossing(*family.better, target)
    if points.error[own].min() < points.error[mode]:
        return Answer(figures, "between", mode)
    floor = math.log(QUANTISATION)
    if family.falling and points.error[mode] > floor:
        times, errors = _of_mode(points, mode)
        further = errors + family.slopes * (target - times)
        if _well_known((further - further[0]) / family.slopes[0]):
            return Answer(np.maximum(floor, further), "extrapolated", mode)
    return Answer(figures, "measured", mode)


def _of_mode(points: Points, mode: int) -> tuple[Array, Array]:
    """The time and the error of one mode, as measured and as they could be (1 + DRAWS,)."""
    times = np.concatenate(([points.time[mode]], points.times[mode]))
    return times, np.concatenate(([points.error[mode]], points.errors[mode]))


def _well_known(off: Array) -> bool:
    """Whether the logarithm of a time is known, from what it could be off by (1 + DRAWS,)."""
    low, high = quantiles(off)
    return max(-low, high) < math.log(WELL_KNOWN)


def reach(family: Family, error: float, answer: Answer) -> Reach:
    """The answer at an error, as records have it."""
    row = family.points.rows[answer.mode]
    best = math.exp(family.points.error[family.own].min())
    return Reach(*family.name, error, interval(family, answer), answer.how, row.mode, row.label, best)


def afford(family: Family, seconds: float, answer: Answer) -> Afford:
    """The answer at a time, as records have it."""
    row = family.points.rows[answer.mode]
    fastest = math.exp(family.points.time[family.own[0]])
    return Afford(*family.name, seconds, interval(family, answer), answer.how, row.mode, row.label, fastest)


def interval(family: Family, answer: Answer) -> Interval | None:
    """The figure itself, with its ends where the spreads of the family's modes are known."""
    if answer.figures is None:
        return None
    value = math.exp(answer.figures[0])
    return Interval(value, *ends(answer.figures)) if family.known else Interval(value, None, None)
