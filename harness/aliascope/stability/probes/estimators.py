"""Estimators of one pixel: their figures, and whether they stop where their criterion says, against mpmath of the
values that they asked for."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import mpmath
import numpy as np
from numpy.typing import NDArray

from aliascope.native.estimate import Estimates, Estimator, settings
from aliascope.stability.exact import moments as exact
from aliascope.stability.records import Probe

SAMPLES = 1024
DIGITS = 50
ROUNDING = 2.0**-53
TEN_DIGITS = 1e-10

Array = NDArray[np.float64]

CELLS = 16
"""Of `stratified`, by default."""
INDEPENDENT = ("fixed", "student-t", "chi-squared")
"""Their figures are those of all values, as of independent ones."""
PLAIN = (*INDEPENDENT, "stratified", "mitchell:cells=1,margin=0", "kajiya:cells=1,margin=0", "whitted:start=0,margin=0")


class _Asked:
    """An integrand of one pixel that keeps what it answered, in order."""

    def __init__(self, value: Callable[[Array], Array]) -> None:
        self.value, self.values = value, list[float]()

    def __call__(self, points: Array) -> Array:
        found = self.value(points)
        self.values += found.tolist()
        return found


def _run(spec: str, asked: _Asked, samples: int = SAMPLES) -> Estimates:
    return Estimator(spec, "random", samples, 2, seed=5).estimate(asked)


def _dyadic(points: Array, level: float) -> Array:
    """A product, in steps of 2^-10, and added to the level as exact, up to 1e12."""
    return np.asarray(level + np.floor(1024.0 * points[:, 0] * points[:, 1]) / 1024.0, dtype=np.float64)


def _relative(found: float, truth: mpmath.mpf) -> float:
    return float(abs(found - truth) / (abs(truth) if truth else 1))


def _figures(spec: str, each: int, samples: int, level: float) -> float:
    """Of values about `level`: the mean and its standard error; `each`: values of a stratum, 0 where there is one."""
    asked = _Asked(partial(_dyadic, level=level))
    made = _run(spec, asked, samples)
    with mpmath.workdps(DIGITS):
        truth = exact.stratified(asked.values, each) if each else exact.standard_error(asked.values)
        return max(
            _relative(float(made.means.item()), exact.mean(asked.values)),
            _relative(float(made.standard_errors.item()), truth),
        )


def _difference(level: float) -> float:
    """`fixed` of two samples, whose values are 1 and 1 + level."""
    asked = _Asked(lambda points: np.asarray(1.0 + level * (np.arange(len(points)) % 2), dtype=np.float64))
    made = _run("fixed", asked, 2)
    with mpmath.workdps(DIGITS):
        return max(
            _relative(float(made.means.item()), exact.mean(asked.values)),
            _relative(float(made.standard_errors.item()), exact.standard_error(asked.values)),
        )


def _least(spec: str) -> int:
    """Samples that it takes where nothing differs."""
    found = settings(spec)
    return int(found["minimum"]) if "minimum" in found else 4 if spec.startswith("whitted") else SAMPLES


def _alike(spec: str, value: Callable[[float], float], level: float) -> float:
    """Values that are all the same: the mean is that value, no error, and it stops at once."""
    made = _run(spec, _Asked(lambda points: np.full(len(points), value(level))))
    error = float(made.standard_errors.item())
    apart = abs(float(made.means.item()) - value(level)) / (value(level) or 1.0)
    return apart + (0.0 if math.isnan(error) else error) + abs(int(made.counts.item()) / _least(spec) - 1.0)


def _contrast(spec: str, level: float) -> float:
    """Values of `level` and half of it, whose contrast is a third: enough for a threshold above that, too much for one
    below. Black is alike throughout."""
    if level == 0.0:
        return _alike(spec, lambda at: at, level)

    def stops(threshold: float) -> bool:
        asked = _Asked(lambda points: np.where(np.arange(len(points)) % 2 == 0, level, level / 2.0))
        return int(_run(f"{spec},red={threshold}", asked).counts.item()) == _least(spec)

    return float(not stops(0.334)) + float(stops(0.333))


TOLERANCE = 0.1


def _stops(name: str, at: float) -> float:
    """Whether it stopped with the first sample that is enough, by mpmath's quantiles: 0 if so."""
    confidence = 1.0 - at
    asked = _Asked(lambda points: points[:, 0])
    made = _run(f"{name}:tolerance={TOLERANCE},confidence={confidence!r}", asked)
    n = int(made.counts.item())
    with mpmath.workdps(DIGITS):
        return float(n == SAMPLES or not _enough(name, asked.values[:n], confidence)) + float(
            _enough(name, asked.values[: n - 1], confidence)
        )


def _enough(name: str, values: list[float], confidence: float) -> bool:
    """By the tail beyond what the tolerance leaves, which rises or falls with the quantile."""
    degrees, error = len(values) - 1, exact.standard_error(values)
    left = 1 - mpmath.mpf(confidence)
    if name == "student-t":
        return bool(exact.student_tail(TOLERANCE / error, degrees) <= left / 2)
    return bool(exact.chi_squared_tail(degrees * (error / TOLERANCE) ** 2, degrees, upper=False) <= left)


def _probe(
    component: str,
    extreme: str,
    run: Callable[[float], float],
    levels: tuple[float, ...],
    unit: str = "relative",
    note: str = "",
) -> Probe:
    precision, bound = (1.0, 0.0) if unit == "wrong decisions" else (ROUNDING, TEN_DIGITS)
    quick = (levels[0], levels[len(levels) // 2])
    against = "mpmath of the values asked for"
    return Probe(component, "estimator", extreme, unit, against, precision, bound, levels, run, quick, note)


MEANS = (1.0, 1e4, 1e8, 1e10, 1e12)
BLACK = (1.0, 1e-30, 1e-100, 1e-300, 1e-323, 0.0)
CONFIDENCES = (1e-1, 1e-2, 1e-4, 1e-6, 1e-9, 1e-12)


def probes() -> list[Probe]:
    found = [_probe(name, "mean", partial(_figures, name, 0, SAMPLES), MEANS) for name in INDEPENDENT]
    found.append(_probe("stratified", "mean", partial(_figures, "stratified", SAMPLES // CELLS, SAMPLES), MEANS))
    # One sample a cell: neighbours are collapsed.
    found.append(_probe("stratified:k=8", "mean", partial(_figures, "stratified:k=8", 1, 64), MEANS))
    for spec in PLAIN:
        name = spec.partition(":")[0]
        found.append(_probe(name, "zero-variance", partial(_alike, spec, lambda at: at), (0.1, 1e8 + 0.1, 1e30, 1e150)))
        if name in ("mitchell", "kajiya", "whitted"):
            found.append(_probe(name, "black", partial(_contrast, spec), BLACK))
    found.append(_probe("fixed", "two-values", _difference, (1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15)))
    return found + [
        _probe(name, "confidence", partial(_stops, name), CONFIDENCES, "wrong decisions")
        for name in ("student-t", "chi-squared")
    ]
