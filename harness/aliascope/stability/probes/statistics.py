"""Moments, intervals, quantiles, strata, and the harness's own statistics, against mpmath of the same doubles."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import mpmath
import numpy as np

from aliascope.agreement import welch
from aliascope.native import estimate
from aliascope.regression.student import student_test
from aliascope.stability.exact import moments as exact
from aliascope.stability.records import Probe
from aliascope.statistics import fit_rate, mean, rate, root_mean_square
from aliascope.trade.uncertainty import pooled, satterthwaite

COUNT = 512
DIGITS = 60
ROUNDING = 2.0**-53
TEN_DIGITS = 1e-10
QUANTILES = 1e-12
"""What estimate.h says of them."""

Floats = Sequence[float]
Measured = Callable[[float], float]


def _about(at: float, count: int = COUNT) -> list[float]:
    """Normal values of deviation 1 about `at`: the figures are of the very doubles, whatever rounding made them."""
    values: list[float] = (at + np.random.default_rng(1).standard_normal(count)).tolist()
    return values


def _equal(at: float) -> list[float]:
    """So many that are 1e8 + 1/10."""
    return [1e8 + 0.1] * int(at)


def _two(at: float) -> list[float]:
    """Of this difference, over what they are."""
    return [1.0, 1.0 + at]


SETS: dict[str, tuple[Callable[[float], list[float]], tuple[float, ...]]] = {
    "mean": (_about, tuple(10.0**k for k in range(0, 16, 2))),
    "zero-variance": (_equal, (2.0, 4.0, 64.0, 512.0)),
    "two-values": (_two, (1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15)),
}


def _relative(found: float | None, truth: mpmath.mpf) -> float:
    """Infinite where there is nothing found; of a truth of 0, the error itself."""
    if found is None:
        return math.inf
    return float(abs(found - truth) / (abs(truth) if truth else 1))


def _of_values(
    figure: Callable[[list[float]], float | None],
    truth: Callable[[Floats], mpmath.mpf],
    made: Callable[[float], list[float]],
    at: float,
) -> float:
    values = made(at)
    found = figure(values)
    with mpmath.workdps(DIGITS):
        return _relative(found, truth(values))


def _merged(values: list[float]) -> estimate.Moments:
    """By parts of 1, 2, 3, ... values."""
    whole, begin = estimate.Moments(), 0
    for size in range(1, len(values) + 1):
        whole.merge(estimate.Moments(values[begin : begin + size]))
        begin += size
    return whole


def _strata(values: list[float], each: int) -> list[estimate.Moments]:
    return [estimate.Moments(values[i : i + each]) for i in range(0, len(values), each)]


def _upper_end(values: list[float]) -> float:
    return estimate.Moments(values).interval(0.99)[1]


def _tested(values: list[float]) -> float:
    return float(student_test(np.array(values)[:, None], 0.0, 0.0, 0.05).standard_error[0])


def _pooled(values: list[float]) -> float:
    return float(pooled([values], [0], [0])[0][0])


FIGURES: dict[str, tuple[Callable[[list[float]], float | None], Callable[[Floats], mpmath.mpf]]] = {
    "variance": (lambda values: estimate.Moments(values).variance, exact.variance),
    "variance:merged=1": (lambda values: _merged(values).variance, exact.variance),
    "mean": (lambda values: estimate.Moments(values).mean, exact.mean),
    "mean:merged=1": (lambda values: _merged(values).mean, exact.mean),
    "standard-error": (lambda values: estimate.Moments(values).standard_error, exact.standard_error),
    "interval": (_upper_end, partial(exact.upper_end, confidence=0.99)),
    "stratify": (
        lambda values: estimate.stratify(_strata(values, 2)).standard_error,
        partial(exact.stratified, each=2),
    ),
    "stratify:values=1": (
        lambda values: estimate.stratify(_strata(values, 1)).standard_error,
        partial(exact.stratified, each=1),
    ),
    "stratify:degrees": (lambda values: estimate.stratify(_strata(values, 2)).degrees, exact.satterthwaite_degrees),
    "mean-of-runs": (lambda values: mean(values).value, exact.mean),
    "error-of-runs": (lambda values: mean(values).standard_error, exact.standard_error),
    "root-mean-square": (lambda values: root_mean_square(values).value, exact.root_mean_square),
    "student-test": (_tested, exact.standard_error),
    "pooled-variance": (_pooled, exact.variance),
}
APART = {
    ("pooled-variance", "zero-variance"),
    ("pooled-variance", "two-values"),
    ("stratify:degrees", "zero-variance"),
    ("stratify:degrees", "two-values"),
}
"""Where there is something else by design: a least variance; degrees of parts that all count alike."""

LOGARITHMS = {"pooled-variance"}
"""Those of logarithms, which no double has above 745: up to 1e8 is far enough."""


def _uneven_strata(at: float) -> float:
    """Strata of one value and of sizes that differ."""
    values, sizes = _about(at, 64), [1.0 + 0.25 * (i % 4) for i in range(64)]
    found = estimate.stratify([estimate.Moments([value]) for value in values], sizes)
    with mpmath.workdps(DIGITS):
        return _relative(found.standard_error, exact.stratified(values, each=1, sizes=sizes))


# ---- Confidence and degrees of freedom ----


def _interval_of_two(at: float) -> float:
    """Half the interval of 0 and 1, by Cauchy's law."""
    confidence = 1.0 - at
    low, high = estimate.Moments([0.0, 1.0]).interval(confidence)
    with mpmath.workdps(DIGITS):
        half = mpmath.cot(mpmath.pi * (1 - mpmath.mpf(confidence)) / 2) / 2
        return max(_relative(high, half + 0.5), _relative(low, 0.5 - half))


def _student(q: float, degrees: float) -> float:
    found = -estimate.student_t_quantile(q, degrees)
    with mpmath.workdps(DIGITS):
        return exact.quantile_error(
            exact.student_tail(mpmath.mpf(found), degrees), q, exact.student_density, found, degrees
        )


def _chi_squared(q: float, degrees: float, upper: bool) -> float:
    found = estimate.chi_squared_quantile(q, degrees, upper=upper)
    with mpmath.workdps(DIGITS):
        tail = exact.chi_squared_tail(mpmath.mpf(found), degrees, upper)
        return exact.quantile_error(tail, q, exact.chi_squared_density, found, degrees)


def _normal(at: float) -> float:
    found = -estimate.normal_quantile(at)
    with mpmath.workdps(DIGITS):
        tail = mpmath.erfc(mpmath.mpf(found) / mpmath.sqrt(2)) / 2
        return exact.quantile_error(tail, at, lambda x, _: mpmath.npdf(x), found, math.inf)


CONFIDENCES = (0.05, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15)
FREEDOMS = (1.0, 2.0, 3.0, 10.0, 1e3, 9999.0, 1e4, 1e6, 1e9, 1e12)

# ---- Fits and sums of variances ----


def _near_counts(at: float) -> tuple[list[int], list[float]]:
    """Counts from `at` on, and errors that fall with them, each with a bit of its own."""
    counts = [int(at) + i for i in range(8)]
    errors = [1.0 - (i + 0.25 * (i % 3)) / at for i in range(8)]
    return counts, errors


def _rate(figure: Callable[[list[int], list[float]], float], at: float) -> float:
    counts, errors = _near_counts(at)
    found = figure(counts, errors)
    with mpmath.workdps(DIGITS):
        return _relative(found, exact.slope(counts, errors))


def _plain_rate(counts: list[int], errors: list[float]) -> float:
    found = rate(counts, errors)
    return math.nan if found is None else found.exponent


def _fitted_rate(counts: list[int], errors: list[float]) -> float:
    return fit_rate(counts, errors, [0.0] * len(errors)).exponent


def _welch(at: float) -> float:
    """Of two variances, the same at every scale."""
    found = float(welch(np.array(3.0 * at), np.array(at), 4.0, 9.0))
    return _relative(found, mpmath.mpf(16) / (mpmath.mpf(9) / 4 + mpmath.mpf(1) / 9))


def _satterthwaite(at: float) -> float:
    error, degrees = satterthwaite([3.0 * at, 4.0 * at], [4.0, 9.0])
    truth = mpmath.mpf(625) / (mpmath.mpf(81) / 4 + mpmath.mpf(256) / 9)
    return max(_relative(error, 5 * mpmath.mpf(at)), _relative(degrees, truth))


def _strata_at(at: float) -> float:
    """Degrees of freedom of two strata, the same at every scale."""
    found = estimate.stratify([estimate.Moments([0.0, at, 2.0 * at]), estimate.Moments([0.0, at, at, 0.0])])
    variances = mpmath.mpf(1) / 3, mpmath.mpf(1) / 12
    truth = sum(variances) ** 2 / (variances[0] ** 2 / 2 + variances[1] ** 2 / 3)
    return max(_relative(found.degrees, truth), _relative(found.standard_error, mpmath.sqrt(sum(variances)) / 2 * at))


def _probe(component: str, extreme: str, run: Measured, levels: tuple[float, ...], bound: float = TEN_DIGITS) -> Probe:
    middle = levels[len(levels) // 2]
    quick = (1.0, 10.0) if extreme == "freedom" else (levels[0], levels[-1] if extreme in ("dim", "bright") else middle)
    against = "mpmath of the same doubles"
    return Probe(component, "statistic", extreme, "relative", against, ROUNDING, bound, levels, run, quick)


def _root_mean_square(at: float) -> float:
    found = root_mean_square([3.0 * at, 4.0 * at])
    half = mpmath.mpf(at) / 2
    truth = half * mpmath.sqrt(50), half * 7 / mpmath.sqrt(50)  # the root of 25/2; its error 7/2 over twice that
    return max(_relative(found.value, truth[0]), _relative(found.standard_error, truth[1]))


SMALL = (1.0, 1e-30, 1e-60, 1e-90, 1e-120, 1e-150)
LARGE = (1.0, 1e30, 1e60, 1e90, 1e120, 1e150)
FURTHER = 1e200
"""The harness's own sums go on to there and its inverse; squares of moments end at 1e154."""


def probes() -> list[Probe]:
    found = []
    for extreme, (made, levels) in SETS.items():
        for component, (figure, truth) in FIGURES.items():
            if (component, extreme) in APART:
                continue
            kept = tuple(at for at in levels if at <= 1e8) if component in LOGARITHMS else levels
            found.append(_probe(component, extreme, partial(_of_values, figure, truth, made), kept))
    means = SETS["mean"][1]
    found.append(_probe("stratify:sizes=uneven", "mean", _uneven_strata, means))
    found.append(_probe("interval", "confidence", _interval_of_two, CONFIDENCES))
    found.append(_probe("normal-quantile", "confidence", _normal, (*CONFIDENCES, 1e-100, 1e-300), QUANTILES))
    found.append(
        _probe("student-t-quantile", "confidence", partial(_student, degrees=2.0), (*CONFIDENCES, 1e-100), QUANTILES)
    )
    found.append(_probe("student-t-quantile", "freedom", partial(_student, 0.5e-12), FREEDOMS, QUANTILES))
    for name, upper in (("chi-squared-quantile", False), ("chi-squared-quantile:upper=1", True)):
        of_two = partial(_chi_squared, degrees=2.0, upper=upper)
        found.append(_probe(name, "confidence", of_two, (*CONFIDENCES, 1e-100), QUANTILES))
        found.append(_probe(name, "freedom", partial(_chi_squared, 1e-12, upper=upper), FREEDOMS, QUANTILES))
    found.append(_probe("rate", "mean", partial(_rate, _plain_rate), means[1:6]))
    found.append(_probe("fit-rate", "mean", partial(_rate, _fitted_rate), means[1:6]))
    for component, run in (
        ("welch", _welch),
        ("satterthwaite", _satterthwaite),
        ("root-mean-square", _root_mean_square),
    ):
        found.append(_probe(component, "dim", run, (*SMALL, 1.0 / FURTHER)))
        found.append(_probe(component, "bright", run, (*LARGE, FURTHER)))
    found.append(_probe("stratify:degrees", "dim", _strata_at, SMALL))
    found.append(_probe("stratify:degrees", "bright", _strata_at, LARGE))
    return found
