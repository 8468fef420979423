"""`aliascope history`: error and cost of each mode over the runs of `aliascope regress`, and their steps.

A series is one figure of one mode on one scene, over runs in the order of time; those of one revision stand together.
Three kinds of figures:

- Exact ones, the same to the last digit from run to run: samples, rays, and an error whose draws are the same. Any
  change of one is a step. An error counts as exact once three runs on one machine had the same, and at most half of all
  runs had another than the one before. Another machine may round otherwise: its figures are compared with its own, and
  with those of others only beyond `ROUNDING`. Where scene, size or draws changed, the step says so.
- Errors with standard errors, of draws that differ: `change_points.by_errors`.
- Times: `change_points.by_ranks` on each machine by itself, and of each renderer also the median of all its modes, each
  over its own median: what slows all of them is told sooner by all.

All tests of an answer share SIGNIFICANCE (Bonferroni, after Tarone): one history in a hundred in which nothing changed
shows a step. Runs are taken for independent.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import fmean, median

import numpy as np
from scipy.special import ndtri, stdtr, stdtrit

from aliascope import plan
from aliascope.errors import InvalidInput
from aliascope.history import KeptCell, KeptRun
from aliascope.regression.records import CellName
from aliascope.studies import change_points
from aliascope.studies.change_points import CONFIDENCE, Change
from aliascope.studies.history_series import (
    ALL_SCENES,
    Asked,
    Cells,
    Point,
    Series,
    chosen,
    in_order,
    machine_of,
    order_of,
    pooled,
    rank,
    series_of,
)

SIGNIFICANCE = 0.01
ROUNDING = 1e-3
"""Relative, of what is exact on one machine: another instruction set may let a ray miss what it hit."""


@dataclass(frozen=True)
class Step:
    """A series has another level from the run `at` on; it is known to come after the run `before` and not after the run
    `after`. `ratio`: new over old level, with its 95 % interval where there is one: over draws of an exact figure, that
    is for other seeds than these. `p_value`: None for a step by definition. `also`: what else changed there."""

    series: Series
    before: int
    at: int
    after: int
    old: float
    new: float
    ratio: float | None
    interval: tuple[float, float] | None
    p_value: float | None
    also: tuple[str, ...]


@dataclass(frozen=True)
class Answer:
    """`runs` in their order. `tests` share SIGNIFICANCE, at `level` each; `untested` series are too short for it."""

    runs: tuple[KeptRun, ...]
    series: tuple[Series, ...]
    steps: tuple[Step, ...]
    tests: int
    level: float
    untested: int

    @property
    def revisions(self) -> list[str]:
        return list(dict.fromkeys(run.revision for run in self.runs))

    @property
    def machines(self) -> list[str]:
        return list(dict.fromkeys(machine_of(run) for run in self.runs))

    @property
    def cells(self) -> list[CellName]:
        return list(dict.fromkeys(one.name for one in self.series if one.name.scene != ALL_SCENES))


def answer(kept: Sequence[KeptRun], asked: Asked) -> Answer:
    """The series that were asked for and their steps, newest first. Raises InvalidInput for what the history lacks."""
    if not kept:
        raise InvalidInput("the history has no runs yet; aliascope regress makes one")
    runs = in_order(kept)
    cells = chosen(runs, asked)
    series = list(series_of(runs, cells))
    series += pooled(runs, series)
    names = list(dict.fromkeys(one.metric for one in series))
    wanted = set(plan.matching(asked.metrics, sorted(names, key=rank), "metric") if asked.metrics else names)
    series = sorted((one for one in series if one.metric in wanted), key=order_of)
    least = [p for one in series for p in _least(cells, one)]
    level, tests = change_points.tested(least, SIGNIFICANCE)
    steps = [step for one in series for step in _steps(runs, cells, one, level)]
    steps.sort(key=lambda step: (-step.after, -step.before, order_of(step.series)))
    untested = sum(p > level for p in least)
    return Answer(runs, tuple(series), tuple(steps), tests, level, untested)


# --- steps ------------------------------------------------------------------------------------------------------------


def _least(cells: Cells, one: Series) -> list[float]:
    """The least p-value that each test of the series can have. An exact figure has none but where the draws changed."""
    if one.kind == "exact":
        by_run = cells[one.name]
        draws = [by_run[point.run].draws for point in one.points] if one.metric == "rmse" else []
        return [0.0 for old, new in pairwise(draws) if old != new]
    if one.kind == "errors":
        return [0.0 if len(one.points) > 1 else 1.0]
    return [change_points.least_p_value(len(one.points))]


def _steps(runs: Sequence[KeptRun], cells: Cells, one: Series, level: float) -> list[Step]:
    by_run = cells.get(one.name, {})
    if one.kind == "exact":
        return _exact_steps(runs, by_run, one, level)
    values = [point.value for point in one.points]
    if one.kind == "ranks":
        # A change of a time is a factor, for where it lies; ranks are the same.
        logs = [math.log(value) for value in values] if min(values) > 0.0 else values
        changes = change_points.by_ranks(logs, level)
    else:
        errors = [point.standard_error or 0.0 for point in one.points]
        freedom = [float(max(by_run[point.run].pictures - 1, 1)) for point in one.points]
        changes = change_points.by_errors(values, errors, freedom, level)
    ends = [0, *(change.at for change in changes), len(values)]
    parts = [one.points[low:high] for low, high in pairwise(ends)]
    return [
        _step(runs, by_run, one, change, before, after)
        for change, (before, after) in zip(changes, pairwise(parts), strict=True)
    ]


def _step(
    runs: Sequence[KeptRun],
    by_run: Mapping[int, KeptCell],
    one: Series,
    change: Change,
    before: Sequence[Point],
    after: Sequence[Point],
) -> Step:
    """A step that a test has found between two levels."""
    ranks = one.kind == "ranks"
    ratio, interval = _shift(before, after) if ranks else _quotient(before, after, by_run)
    middle: Callable[[list[float]], float] = median if ranks else fmean
    old, new = (middle([point.value for point in part]) for part in (before, after))
    points = one.points
    here = points[change.at - 1].run, points[change.at].run
    also = _also(runs, by_run, *here)
    first, last = points[change.earliest - 1].run, points[change.latest].run
    return Step(one, first, here[1], last, old, new, ratio, interval, change.p_value, also)


def _exact_steps(runs: Sequence[KeptRun], by_run: Mapping[int, KeptCell], one: Series, level: float) -> list[Step]:
    """Each change of an exact figure. With other draws, an error is another one: that is no step, unless by more than
    the standard errors have it."""
    steps = []
    latest: dict[tuple[str, str], Point] = {}
    previous: Point | None = None
    for point in one.points:
        key = (machine_of(runs[point.run]), by_run[point.run].draws if one.metric == "rmse" else "")
        if previous is not None:
            known = latest.get(key)
            compared = known or previous
            p_value = None
            if known is not None:
                changed = point.value != known.value
            elif one.metric == "rmse" and by_run[previous.run].draws != by_run[point.run].draws:
                p_value = _other_draws(by_run, previous, point)
                changed = p_value is not None and p_value <= level
            else:
                changed = abs(point.value - previous.value) > ROUNDING * max(abs(previous.value), abs(point.value))
            if changed:
                steps.append(_exact_step(runs, by_run, one, (previous, compared, point), p_value))
                latest.clear()
        latest[key] = previous = point
    return steps


def _exact_step(
    runs: Sequence[KeptRun],
    by_run: Mapping[int, KeptCell],
    one: Series,
    points: tuple[Point, Point, Point],
    p_value: float | None,
) -> Step:
    """From the run before, and the one that the figure is compared with, to the run that has another."""
    previous, compared, point = points
    ratio = point.value / compared.value if compared.value else None
    interval = None
    if one.metric == "rmse":
        paired = _paired(by_run[compared.run], by_run[point.run])
        interval = paired if p_value is None else _quotient([compared], [point], by_run)[1]
    also = _also(runs, by_run, compared.run, point.run)
    return Step(one, previous.run, point.run, point.run, compared.value, point.value, ratio, interval, p_value, also)


def _other_draws(by_run: Mapping[int, KeptCell], one: Point, other: Point) -> float | None:
    """The two-sided p-value of two errors of independent draws (Welch); None without standard errors."""
    if not one.standard_error or not other.standard_error:
        return None
    variance = one.standard_error**2 + other.standard_error**2
    t = abs(one.value - other.value) / math.sqrt(variance)
    return float(2.0 * stdtr(_freedom(by_run, [one], [other]), -t))


def _freedom(by_run: Mapping[int, KeptCell], before: Sequence[Point], after: Sequence[Point]) -> float:
    """Of the difference of two means (Satterthwaite)."""
    variance = spread = 0.0
    for part in (before, after):
        for point in part:
            own = ((point.standard_error or 0.0) / len(part)) ** 2
            variance += own
            spread += own**2 / max(by_run[point.run].pictures - 1, 1)
    return variance**2 / spread if spread else math.inf


def _paired(old: KeptCell, new: KeptCell) -> tuple[float, float] | None:
    """The interval of the ratio of two errors, by what each draw brings to the two mean squares (the delta method) and
    Student's t; None where the draws differ or there are too few."""
    one, other = (np.array([each or 0.0 for each in cell.rmse_of_each]) ** 2 for cell in (old, new))
    if old.draws != new.draws or len(one) < 2 or len(one) != len(other) or not (one.any() and other.any()):
        return None
    parts = 0.5 * (other / other.mean() - one / one.mean())
    half = float(stdtrit(len(parts) - 1, 0.5 + CONFIDENCE / 2.0) * parts.std(ddof=1)) / math.sqrt(len(parts))
    ratio = math.sqrt(float(other.mean() / one.mean()))
    return ratio * math.exp(-half), ratio * math.exp(half)


Sized = tuple[float | None, tuple[float, float] | None]


def _shift(before: Sequence[Point], after: Sequence[Point]) -> Sized:
    """The ratio of two levels by the median of all ratios (Hodges and Lehmann 1963), and the interval of the rank-sum
    test that goes with it, by the normal distribution (Hollander, Wolfe and Chicken 2014, eq. 4.25)."""
    if not all(point.value > 0.0 for point in (*before, *after)):
        return None, None
    ratios = np.sort(np.array([other.value / one.value for one in before for other in after]))
    m, n = len(before), len(after)
    z = float(-ndtri(0.5 - CONFIDENCE / 2.0))
    cut = math.floor(m * n / 2.0 - z * math.sqrt(m * n * (m + n + 1) / 12.0))
    interval = (float(ratios[cut - 1]), float(ratios[-cut])) if cut >= 1 else None
    return float(np.median(ratios)), interval


def _quotient(before: Sequence[Point], after: Sequence[Point], by_run: Mapping[int, KeptCell]) -> Sized:
    """The ratio of two means, with the interval of their logarithms' difference by the standard errors."""
    old, new = (sum(point.value for point in part) / len(part) for part in (before, after))
    if old <= 0.0 or new <= 0.0:
        return None, None
    variance = 0.0
    for part, level in ((before, old), (after, new)):
        variance += sum(((point.standard_error or 0.0) / (len(part) * level)) ** 2 for point in part)
    half = float(stdtrit(_freedom(by_run, before, after), 0.5 + CONFIDENCE / 2.0)) * math.sqrt(variance)
    return new / old, (new / old * math.exp(-half), new / old * math.exp(half))


def _also(runs: Sequence[KeptRun], by_run: Mapping[int, KeptCell], one: int, other: int) -> tuple[str, ...]:
    """What changed between two runs beside the revision."""
    found = []
    old, new = by_run.get(one), by_run.get(other)
    if old and new:
        found += ["scene, size or filter"] if old.subject != new.subject else []
        found += ["seeds or shifts"] if old.draws != new.draws else []
    if machine_of(runs[one]) != machine_of(runs[other]):
        found.append("machine")
    elif runs[one].machine.get("system") != runs[other].machine.get("system"):
        found.append(f"system {runs[one].machine.get('system')} → {runs[other].machine.get('system')}")
    before = {**runs[one].versions, **(old.versions if old else {})}
    after = {**runs[other].versions, **(new.versions if new else {})}
    for name in dict.fromkeys([*before, *after]):
        if before.get(name) != after.get(name):
            found.append(f"{name} {before.get(name, '–')} → {after.get(name, '–')}")
    return tuple(found)
