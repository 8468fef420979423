"""`aliascope estimate`: what estimators are off by, and how often their intervals hold what they say they hold.

Every repetition is a pixel of its own, whose samples are independent of the others'. Of the estimates come the bias and
the root mean square error; of the estimates and their standard errors the coverage: in how many repetitions Student's
interval, of the degrees of freedom that the estimator states, holds the integral, which is known.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope import integrands, statistics
from aliascope.errors import InvalidInput, Unsupported
from aliascope.integrands import Integrand
from aliascope.native import estimate as native
from aliascope.native import samplers
from aliascope.native.estimate import Estimates, Estimator, Moments, student_t_quantile

Array = NDArray[np.float64]
Tell = Callable[[str | None, int, int], None]

INTEGRANDS = ("product", "gaussian", "edge", "bright-feature:brightness=100")
"""Smooth ones, the edge through a pixel, and one per cent of a pixel that is a hundred times as bright as white."""
AT_ONCE = 10_000
PILOT = 1 << 14
COUNTS = (4, 16, 64, 256, 1024)
ROUNDING = 1e-13
"""Of the integral: what sums of up to 10^4 values round by, as a random walk, with room. An interval of a constant has
no width."""


@dataclass(frozen=True)
class Asked:
    """What to measure. `estimators` and `sampler` are None for a telling set."""

    integrands: tuple[Integrand, ...]
    estimators: tuple[str, ...] | None
    sampler: str | None
    dimensions: int
    samples: int
    repetitions: int
    confidence: float
    seed: int


@dataclass(frozen=True)
class Measured:
    """One estimator on one integrand. `samples` is the mean of a repetition; `ratio` is the RMSE over that of as many
    independent samples in every repetition; coverage is None where the estimator states no standard error."""

    integrand: str
    exact: float
    estimator: str
    sampler: str
    samples: float
    bias: float
    bias_standard_error: float
    rmse: float
    rmse_standard_error: float
    ratio: float | None
    coverage: float | None
    coverage_standard_error: float | None
    reach: int

    @property
    def biased(self) -> bool:
        """Whether the bias is more than four standard errors: by chance once in 16,000."""
        return abs(self.bias) > max(4.0 * self.bias_standard_error, ROUNDING * abs(self.exact))


def measure_all(asked: Asked, tell: Tell) -> list[Measured]:
    """All estimators on all integrands. Raises SpecError, Unsupported, InvalidInput."""
    jobs = []
    for integrand in asked.integrands:
        spread = _spread(integrand, asked.dimensions)
        for spec, sampler in _rows(asked, spread):
            jobs.append((integrand, spread, Estimator(spec, sampler, asked.samples, asked.dimensions, seed=asked.seed)))
    found = []
    for done, (integrand, spread, estimator) in enumerate(jobs):
        tell(f"{integrand.spec}  {estimator.spec}", done, len(jobs))
        found.append(_measure(asked, integrand, spread, estimator))
    return found


def parse_integrands(specs: Sequence[str], dimensions: int) -> tuple[Integrand, ...]:
    """Those of these specs, or the telling ones that exist in so many dimensions. Raises SpecError, Unsupported."""
    found = tuple(integrands.parse(spec) for spec in specs or INTEGRANDS)
    if not specs:
        found = tuple(one for one in found if one.refusal(dimensions) is None)
    for one in found:
        one.exact(dimensions)  # raises where there is none
    return found


def _rows(asked: Asked, spread: float) -> list[tuple[str, str]]:
    """Pairs of an estimator and a sampler."""
    sampler = asked.sampler or "random"
    if not samplers.Sampler(sampler, asked.samples, asked.dimensions).randomised:
        raise Unsupported(f"{sampler} is not random: every repetition would be the same; scrambled sequences are")
    if asked.estimators is not None:
        return [(native.canonical(spec), sampler) for spec in asked.estimators]
    rows = [(spec, sampler) for spec in telling(asked.samples, asked.dimensions, spread)]
    if asked.sampler is None and asked.samples >= 256:
        rows.append(("fixed:n=256", "sobol:scramble=owen"))
    return rows


def telling(most: int, dimensions: int, spread: float) -> list[str]:
    """All estimators that are registered, with settings that suit values of this standard deviation.

    Those that decide aim at about 256 samples: at an interval of an eighth of the deviation to either side, a deviation
    of the mean of a sixteenth.
    """
    half, deviation = (f"tolerance={spread / by:.2g}" if spread else "tolerance=0.01" for by in (8.0, 16.0))
    cells = 16 if dimensions > 1 else 4
    settings: dict[str, list[str]] = {
        "fixed": [f"n={n}" for n in COUNTS if n <= most],
        "stratified": [f"n={cells * n}" for n in (1, 16) if cells * n <= most],
        "student-t": [half, f"{half},minimum=32", f"{half},unbiased=1"],
        "chi-squared": [deviation, f"{deviation},minimum=32", f"{deviation},unbiased=1"],
        "whitted": ["", "unbiased=1"],
        "kajiya": ["", "unbiased=1"],
        "mitchell": ["", "cells=1,margin=0", "unbiased=1"],
    }
    found = []
    for info in native.registered():
        for keys in settings.get(info.name, [""]):
            spec = native.canonical(f"{info.name}:{keys}" if keys else info.name)
            try:
                Estimator(spec, "random", most, dimensions)
            except InvalidInput:
                continue  # not with so few samples or dimensions
            found.append(spec)
    return found


def _spread(integrand: Integrand, dimensions: int) -> float:
    """The standard deviation of a value, to a few per cent."""
    return float(integrand.evaluate(samplers.points("sobol:scramble=owen", PILOT, dimensions)).std())


def _measure(asked: Asked, integrand: Integrand, spread: float, estimator: Estimator) -> Measured:
    parts = [
        estimator.estimate(integrand.evaluate, (first, 0, min(AT_ONCE, asked.repetitions - first), 1))
        for first in range(0, asked.repetitions, AT_ONCE)
    ]
    exact = integrand.exact(asked.dimensions)
    errors = np.concatenate([part.means.ravel() for part in parts]) - exact
    samples = sum(part.spent for part in parts) / asked.repetitions
    bias, rmse = Moments(errors), statistics.root_mean_square(errors.tolist())
    assert rmse.value is not None
    assert rmse.standard_error is not None
    coverage = _coverage(parts, errors, exact, asked.confidence)
    return Measured(
        integrand=integrand.spec,
        exact=exact,
        estimator=estimator.spec,
        sampler=estimator.sampler.spec,
        samples=samples,
        bias=bias.mean,
        bias_standard_error=bias.standard_error,
        rmse=rmse.value,
        rmse_standard_error=rmse.standard_error,
        ratio=rmse.value * math.sqrt(samples) / spread if spread else None,
        coverage=coverage,
        coverage_standard_error=_binomial(coverage, asked.repetitions),
        reach=estimator.reach,
    )


def _binomial(share: float | None, count: int) -> float | None:
    return None if share is None else math.sqrt(share * (1.0 - share) / count)


def _coverage(parts: Sequence[Estimates], errors: Array, exact: float, confidence: float) -> float | None:
    deviations = np.concatenate([part.standard_errors.ravel() for part in parts])
    degrees = np.concatenate([part.degrees.ravel() for part in parts])
    if np.isnan(deviations).any() or np.isnan(degrees).any():
        return None
    different, which = np.unique(degrees, return_inverse=True)
    quantiles = np.array([-student_t_quantile((1.0 - confidence) / 2.0, one) for one in different])
    held = np.abs(errors) <= quantiles[which] * deviations + ROUNDING * abs(exact)
    return float(held.mean())


def document(asked: Asked, measured: Sequence[Measured]) -> dict[str, Any]:
    """What --json prints."""
    return {
        "dimensions": asked.dimensions,
        "repetitions": asked.repetitions,
        "confidence": asked.confidence,
        "seed": asked.seed,
        "results": [_result(one) for one in measured],
    }


def _result(one: Measured) -> dict[str, Any]:
    found = {name: getattr(one, name) for name in COLUMNS} | {"biased": one.biased}
    if one.coverage is None:
        found["reason"] = NO_INTERVAL
    return found


NO_INTERVAL = "it states no standard error"
COLUMNS = (
    *("integrand", "exact", "estimator", "sampler", "samples", "bias", "bias_standard_error", "rmse"),
    *("rmse_standard_error", "ratio", "coverage", "coverage_standard_error", "reach"),
)


def csv_text(measured: Sequence[Measured]) -> str:
    """All figures, one row an estimator and integrand; empty where there is none."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for one in measured:
        values = [getattr(one, name) for name in COLUMNS]
        writer.writerow([repr(value) if isinstance(value, float) else value for value in values])
    return out.getvalue()


def label(one: Measured) -> str:
    """The estimator, and the sampler where it is not the plain one."""
    return one.estimator if one.sampler == "random" else f"{one.estimator} on {one.sampler}"


def by_integrand(measured: Sequence[Measured]) -> dict[str, list[Measured]]:
    """In their order."""
    found: dict[str, list[Measured]] = {}
    for one in measured:
        found.setdefault(one.integrand, []).append(one)
    return found


def lines(asked: Asked, measured: Sequence[Measured]) -> list[str]:
    """A table for each integrand."""
    found: list[str] = []
    width = max(len(label(one)) for one in measured)
    for integrand, rows in by_integrand(measured).items():
        found += [""] * bool(found)
        found.append(f"{integrand}: {rows[0].exact:.6g} in {asked.dimensions} dimensions")
        columns = "samples  bias        +-       RMSE       over fixed"
        found.append(f"  {'estimator':{width}}  {columns}  coverage of {asked.confidence:g}")
        found += [f"  {label(one):{width}}  {_figures(one, asked.confidence)}" for one in rows]
    marked = ["*: a bias of more than four standard errors."] * any(one.biased for one in measured)
    return [*found, "", *marked, *notes(measured)]


def _figures(one: Measured, confidence: float) -> str:
    ratio = f"{one.ratio:10.3f}" if one.ratio is not None else " " * 10
    bias = f"{one.bias:+.2e}{'*' if one.biased else ' '}  {one.bias_standard_error:.1e}"
    return f"{one.samples:7.1f}  {bias}  {one.rmse:.3e}  {ratio}  {coverage_text(one, confidence)}"


def coverage_text(one: Measured, confidence: float) -> str:
    """The coverage, its binomial error, and how far it is below what was stated."""
    if one.coverage is None or one.coverage_standard_error is None:
        return f"none: {NO_INTERVAL}"
    text = f"{one.coverage:.4f} +- {one.coverage_standard_error:.4f}"
    below = confidence - one.coverage
    return f"{text}, {abs(below):.4f} {'below' if below > 0 else 'above'}"


def notes(measured: Sequence[Measured]) -> list[str]:
    """What the figures mean, as far as it is needed for these."""
    found = ["RMSE over fixed: over that of as many independent samples in every repetition; below 1 is better."]
    if any(one.sampler != "random" for one in measured):
        found.append(
            "Samples of a sequence are not independent. The standard error takes them as if they were, so the interval "
            "is as wide as that of random samples, however much less the error is."
        )
    if any(one.reach for one in measured):
        found.append("An estimator that looks at neighbouring pixels shares samples between repetitions.")
    return found
