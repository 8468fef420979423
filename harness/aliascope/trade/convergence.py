"""How fast the errors of families fall, with the samples and with the time that they take."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from aliascope.statistics import FittedRate, fit_rate
from aliascope.trade.records import Convergence, Efficiency, Interval
from aliascope.trade.uncertainty import Array, Points, ends

_UNIT = 1 << 20
"""Samples a pixel are counted in parts of this size: adaptive modes have no whole number of them."""


def convergence(points: Points) -> dict[tuple[str, str], Convergence]:
    """Of each family with three or more counts, by renderer and family."""
    found = {}
    for (renderer, family), own in points.families().items():
        fit = against_samples(points, own)
        if fit is None:
            continue
        per_time = _against_time(points, own, fit)
        found[renderer, family] = Convergence(
            renderer,
            family,
            Interval(fit.exponent, *fit.interval),
            Interval(per_time.exponent, *per_time.interval) if per_time else None,
            fit.curved,
            fit.count,
        )
    return found


def against_samples(points: Points, own: NDArray[np.intp]) -> FittedRate | None:
    """The rate of a family's error; None with fewer than three counts."""
    counts = np.array([points.rows[i].samples_per_pixel for i in own])
    return _fit(points, own, counts, points.error_spread.standard_error[own])


def _against_time(points: Points, own: NDArray[np.intp], fit: FittedRate) -> FittedRate | None:
    # What is not known of times counts as errors, through the slope.
    spread = np.hypot(points.error_spread.standard_error[own], fit.exponent * points.time_spread.standard_error[own])
    return _fit(points, own, np.exp(points.time[own]), spread)


def _fit(points: Points, own: NDArray[np.intp], along: Array, spread: Array) -> FittedRate | None:
    usable = np.isfinite(points.error[own]) & (along > 0.0)
    counts = [max(1, round(float(value) / float(along[usable].min()) * _UNIT)) for value in along[usable]]
    if len(set(counts)) < 3:
        return None
    errors = np.exp(points.error[own][usable])
    standard_errors = np.nan_to_num(spread[usable]) * errors
    freedom = np.nan_to_num(points.error_spread.freedom[own][usable]).min()
    return fit_rate(counts, errors.tolist(), standard_errors.tolist(), float(freedom))


def efficiency(points: Points) -> tuple[Efficiency, ...]:
    """Of each mode that has an error above 0, the best first."""
    found = []
    for i, row in enumerate(points.rows):
        if math.isinf(points.error[i]):
            continue
        figures = -2.0 * points.errors[i] - points.times[i]
        value = -2.0 * float(points.error[i]) - float(points.time[i])
        known = math.isfinite(points.time_spread.standard_error[i] + points.error_spread.standard_error[i])
        low, high = ends(np.concatenate(([value], figures))) if known else (None, None)
        found.append(Efficiency(row.renderer, row.mode, Interval(math.exp(value), low, high)))
    return tuple(sorted(found, key=lambda each: (-each.value.value, each.renderer, each.mode)))
