"""`aliascope discrepancy --orders`: how fast a sampler's star discrepancy D* falls with the number N of its points.

The lecture has O(log^(d-1) N / N) for Hammersley's points in d dimensions and O(log^d N / N) for Halton's. Such a bound
has terms of lower order too: of Hammersley's in base 2, N D* = m/3 + 13/9 - (-1)^m 4/(9 N) at N = 2^m, exactly (Halton
and Zaremba 1969, "The extreme and L2 discrepancies of some plane sets"; log N / (3 log 2) is the first term). So what
is fitted to N D* is c log^p N + c0 with c, c0 >= 0, for p = d - 1 and p = d; and beside them the power N^(1-r), as
random points have with r = 1/2. All by least squares of the logarithm of D*, which weighs each N alike.

The likelihood of a fit beside the best one's is exp((A_best - A) / 2), A = m log(sum of squares / m) + 2 k Akaike's
criterion for m residuals and k parameters (Burnham and Anderson 2002, section 2.6). Residuals of a pattern that is not
random are no independent draws; likelihoods and intervals are what they would be if they were.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope import statistics
from aliascope.errors import Unsupported
from aliascope.native.discrepancy import measure
from aliascope.native.samplers import Sampler, refusal

Array = NDArray[np.float64]
REALISATIONS = 16
"""Of a randomised pattern, where it is not said."""
LEAST_POINTS = 16
LEAST_COUNTS = 5
"""For a fit of two parameters."""
MOST_DIMENSIONS = 4
# By dimensions: where the exact star discrepancy of all N together takes some seconds; then for 16 realisations.
_MOST_POINTS = {1: 1 << 17, 2: 1 << 17, 3: 1 << 11, 4: 1 << 8}
_MOST_POINTS_OF_MANY = {1: 1 << 14, 2: 1 << 14, 3: 1 << 9, 4: 1 << 7}
_CONFIDENCE = 0.95
_ROUNDING = 1e-15
"""Of the logarithm of D*: the least that a residual can say."""


@dataclass(frozen=True)
class At:
    """D* at N points: the mean over realisations, and its standard error where there are several."""

    n: int
    star: float
    standard_error: float | None


@dataclass(frozen=True)
class Fit:
    """N D* = c log^p N + c0, or c N^(1-r) where `log_power` is None.

    `interval`: of c, or of r; `residual`: standard deviation of log D* about the fit; `likelihood`: beside the best's.
    """

    log_power: int | None
    c: float
    c0: float
    rate: float | None
    interval: tuple[float, float]
    residual: float
    criterion: float
    likelihood: float = 1.0

    @property
    def name(self) -> str:
        """Such as "log^2 N / N"."""
        if self.log_power is None:
            return "N^-r"
        return ("1", "log N")[self.log_power] + " / N" if self.log_power < 2 else f"log^{self.log_power} N / N"

    def star(self, n: Array) -> Array:
        """D* as the fit has it."""
        if self.rate is not None:
            return np.asarray(self.c * n**-self.rate)
        assert self.log_power is not None
        return np.asarray((self.c * np.log(n) ** self.log_power + self.c0) / n)


@dataclass(frozen=True)
class Orders:
    """D* at several N, and the fits of c log^(d-1) N, c log^d N and N^(1-r), in this order."""

    sampler: str
    d: int
    seed: int
    realisations: int
    at: tuple[At, ...]
    fits: tuple[Fit, Fit, Fit]

    @property
    def best(self) -> Fit:
        """The most likely one."""
        return min(self.fits, key=lambda fit: fit.criterion)

    def ratios(self, log_power: int, less: float = 0.0) -> list[float]:
        """(N D* - `less`) / log^p N at each N."""
        return [(one.n * one.star - less) / math.log(one.n) ** log_power for one in self.at]


def measure_orders(
    spec: str,
    d: int,
    seed: int,
    most: int | None = None,
    realisations: int | None = None,
    tell: Callable[[str, int, int], None] = lambda what, done, total: None,
) -> Orders:
    """The orders of a sampler in d = 1 to 4 dimensions, at N = 2^k from 16 to `most` points.

    Where the pattern has not 2^k points, at the next number below 2^(k+1) that it has. Raises SpecError; Unsupported
    for other dimensions, and where there are fewer than five N.
    """
    if not 1 <= d <= MOST_DIMENSIONS:
        raise Unsupported(f"--orders are of star, which is exact in 1 to {MOST_DIMENSIONS} dimensions, not {d}")
    if most is not None and most < LEAST_POINTS << (LEAST_COUNTS - 1):
        raise Unsupported(
            f"-n {most}: a fit takes {LEAST_COUNTS} numbers of points from 16, 32, ... on, so -n 256 or more"
        )
    sampler = Sampler(spec, _counts(spec, d, 64 * LEAST_POINTS)[0], d, seed)
    if not sampler.randomised and (realisations or 1) > 1:
        raise Unsupported(f"{sampler.spec} is not randomised: it has one realisation, not {realisations}")
    rounds = (realisations or REALISATIONS) if sampler.randomised else 1
    if most is None:
        most = (_MOST_POINTS if rounds == 1 else _MOST_POINTS_OF_MANY)[d]
    counts = _counts(spec, d, most)
    if len(counts) < LEAST_COUNTS:
        raise Unsupported(
            f"{sampler.spec} in {d} dimensions has {len(counts)} of the numbers of points from {LEAST_POINTS} to "
            f"{most}, a fit takes {LEAST_COUNTS}: raise -n, or choose another sampler"
        )
    found = []
    for index, n in enumerate(counts):
        tell(f"{n} points", index, len(counts))
        stars = [_star(sampler.spec, n, d, (seed + number) % 2**64) for number in range(rounds)]
        mean = statistics.mean(stars)
        assert mean.value is not None
        found.append(At(n, mean.value, mean.standard_error))
    return Orders(sampler.spec, d, seed, rounds, tuple(found), fits(found, d))


def _star(spec: str, n: int, d: int, seed: int) -> float:
    return measure("star", Sampler(spec, n, d, seed).points(n)).value


def _counts(spec: str, d: int, most: int) -> list[int]:
    """One number of points in each [2^k, 2^(k+1)), up to `most`, where the pattern has any. Raises the refusal of the
    first where it has none."""
    found, first = [], LEAST_POINTS
    while first <= most:
        for n in range(first, min(2 * first, most + 1)):
            if refusal(spec, n, d) is None:
                found.append(n)
                break
        first *= 2
    if not found:
        Sampler(spec, LEAST_POINTS, d)  # says why
    return found


# --- fits -------------------------------------------------------------------------------------------------------------


def fits(at: Sequence[At], d: int) -> tuple[Fit, Fit, Fit]:
    """The three fits of five N or more."""
    n, star = np.array([one.n for one in at], float), np.array([one.star for one in at])
    made = [_log_fit(n, star, d - 1), _log_fit(n, star, d), _power_fit(n, star)]
    best = min(fit.criterion for fit in made)
    first, second, third = (replace(fit, likelihood=math.exp((best - fit.criterion) / 2)) for fit in made)
    return first, second, third


def _log_fit(n: Array, star: Array, power: int) -> Fit:
    """With c0, or without where that is no worse by the criterion: c0 > 0 may be none, and is c at power 0."""
    from scipy.optimize import least_squares  # takes a second to load, and most commands fit nothing

    target, term = np.log(n * star), np.log(n) ** power
    c = math.exp(float(np.mean(target - np.log(term))))
    one_term = _fit(target - np.log(c * term), 1.0 / np.full((len(n), 1), c), power, c, 0.0)
    if power == 0:
        return one_term

    def residuals(logs: Array) -> Array:
        return np.asarray(target - np.logaddexp(logs[0] + np.log(term), logs[1]))

    # In the logarithms of c and c0, which are positive then.
    found = least_squares(residuals, [math.log(c / 2.0), float(target[0])], xtol=1e-14, ftol=1e-14, gtol=1e-14)
    c, c0 = (float(value) for value in np.exp(found.x))
    slopes = np.column_stack([term, np.ones_like(n)]) / (c * term + c0)[:, np.newaxis]
    return min(one_term, _fit(residuals(found.x), slopes, power, c, c0), key=lambda fit: fit.criterion)


def _fit(residuals: Array, slopes: Array, power: int, c: float, c0: float) -> Fit:
    """slopes: derivatives of the logarithm of the fit by c, and by c0 if it is fitted."""
    residual, error = _spread(residuals, slopes)
    return Fit(power, c, c0, None, (max(0.0, c - error), c + error), residual, _criterion(residuals, slopes.shape[1]))


def _power_fit(n: Array, star: Array) -> Fit:
    slopes = np.column_stack([-np.log(n), np.ones_like(n)])
    rate, constant = (float(value) for value in np.linalg.lstsq(slopes, np.log(star), rcond=None)[0])
    residuals = np.log(star) - slopes @ [rate, constant]
    residual, error = _spread(residuals, slopes)
    interval = rate - error, rate + error
    return Fit(None, math.exp(constant), 0.0, rate, interval, residual, _criterion(residuals, 2))


def _spread(residuals: Array, slopes: Array) -> tuple[float, float]:
    """The residuals' standard deviation, and half the interval of the first parameter, by Student's t."""
    from scipy.stats import t

    freedom = len(residuals) - slopes.shape[1]
    deviation = math.sqrt(float(residuals @ residuals) / freedom)
    error = deviation * math.sqrt(float(np.linalg.pinv(slopes.T @ slopes)[0, 0]))
    return deviation, error * float(t.ppf(0.5 + _CONFIDENCE / 2, freedom))


def _criterion(residuals: Array, parameters: int) -> float:
    m = len(residuals)
    return m * math.log(max(float(residuals @ residuals) / m, _ROUNDING**2)) + 2.0 * parameters


# --- what is printed --------------------------------------------------------------------------------------------------


def document(orders: Orders) -> dict[str, Any]:
    """What --json prints."""
    powers = orders.d - 1, orders.d
    ratios = {f"n-star-over-log^{power}": orders.ratios(power) for power in powers}
    return {
        "sampler": orders.sampler,
        "d": orders.d,
        "seed": orders.seed,
        "realisations": orders.realisations,
        "points": [
            {
                "n": one.n,
                "star": one.star,
                "standard_error": one.standard_error,
                **{name: values[index] for name, values in ratios.items()},
            }
            for index, one in enumerate(orders.at)
        ],
        "fits": [_fit_document(fit) for fit in orders.fits],
        "best": orders.best.name,
    }


def _fit_document(fit: Fit) -> dict[str, Any]:
    if fit.rate is not None:
        terms: dict[str, Any] = {"constant": fit.c, "rate": fit.rate, "rate_interval": list(fit.interval)}
    else:
        terms = {
            "log_power": fit.log_power,
            "constant": fit.c,
            "constant_interval": list(fit.interval),
            "lower_order": fit.c0,
        }
    return {"order": fit.name, **terms, "residual": fit.residual, "relative_likelihood": fit.likelihood}


def lines(orders: Orders) -> list[str]:
    """The table of N D* and its ratios, the fits, and which describes it."""
    return [*_head(orders), *_ratio_lines(orders), "", *_fit_lines(orders), "", *_verdict(orders)]


def _head(orders: Orders) -> list[str]:
    several = f", mean of {orders.realisations} realisations" if orders.realisations > 1 else ""
    return [f"{orders.sampler} in {orders.d} dimension{'s' * (orders.d != 1)}: star discrepancy D*, exact{several}"]


def _ratio_lines(orders: Orders) -> list[str]:
    levelled = min(orders.fits[:2], key=lambda fit: fit.criterion)
    columns = [
        ("N", [str(one.n) for one in orders.at]),
        ("D*", [f"{one.star:.6g}" for one in orders.at]),
        ("N D*", [f"{one.n * one.star:.4g}" for one in orders.at]),
    ]
    for power in filter(None, (orders.d - 1, orders.d)):
        columns += [(f"N D* / {_log(power)}", [f"{value:.4f}" for value in orders.ratios(power)])]
    if levelled.log_power and levelled.c0:
        less = [f"{value:.4f}" for value in orders.ratios(levelled.log_power, levelled.c0)]
        columns.append((f"(N D* - {levelled.c0:.3g}) / {_log(levelled.log_power)}", less))
    widths = [max(len(name), *map(len, cells)) for name, cells in columns]
    rows = [[name for name, _ in columns], *zip(*(cells for _, cells in columns), strict=True)]
    return ["  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True)) for row in rows]


def _log(power: int) -> str:
    return "log N" if power == 1 else f"log^{power} N"


def _fit_lines(orders: Orders) -> list[str]:
    texts = [(fit.name, formula(fit), f"{100 * fit.residual:.2g} %", f"{fit.likelihood:.2g}") for fit in orders.fits]
    heads = ("order", "N D* by least squares, 95 % interval", "residual", "likelihood beside the best")
    widths = [max(map(len, column)) for column in zip(heads, *texts, strict=True)]
    return [
        "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in (heads, *texts)
    ]


def formula(fit: Fit) -> str:
    """N D* as it is fitted, such as "0.483 [0.481, 0.485] log N + 1.43"."""
    low, high = fit.interval
    if fit.rate is not None:
        return f"{fit.c:.3g} N^(1 - r), r = {fit.rate:.3f} [{low:.3f}, {high:.3f}]"
    rest = f" + {fit.c0:.3g}" if fit.c0 else ""
    return f"{fit.c:.3g} [{low:.3g}, {high:.3g}]" + (f" {_log(fit.log_power)}" if fit.log_power else "") + rest


def _verdict(orders: Orders) -> list[str]:
    best = orders.best
    others = [fit for fit in orders.fits if fit is not best and fit.likelihood > 1.0 - _CONFIDENCE]
    text = f"described best by {best.name}"
    if best.rate is not None:
        text += f", r = {best.rate:.3f}"
    if others:
        text += "; not told apart from it: " + ", ".join(fit.name for fit in others)
    return [text]
