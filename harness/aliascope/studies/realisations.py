"""Measures of a sampler's point sets over realisations: as many as are asked for, or as a standard error takes.

Realisation i is the set of the seed S + i, so `aliascope points SAMPLER -n N --seed S+i` prints it. The threads do not
change what comes out: which realisations are made follows from the values of those before alone.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from aliascope import statistics
from aliascope.native import discrepancy, samplers
from aliascope.native.discrepancy import Measured
from aliascope.records import Estimate

FIRST, GROWTH, STEP = 64, 3.0, 32
"""Realisations of the first round; by what factor the number grows at most from round to round, as the spread of few
says little of how many it takes; all numbers are multiples of STEP, which is also what a thread takes at a time."""
MOST = 1 << 20

Tell = Callable[[str | None, int, int], None]


@dataclass(frozen=True)
class Asked:
    """A measure of n points of a sampler in two dimensions, over its realisations.

    `squares`: root of the mean of squares, else the mean. `share`: go on until the standard error is below this share
    of it; `count`: or exactly as many. A pattern that is not randomised has one realisation.
    """

    sampler: str
    n: int
    measure: str
    squares: bool
    share: float
    count: int | None = None


@dataclass(frozen=True)
class Found:
    """The figure, and the values of the realisations that it is of. A single one of a measure that draws has the
    standard error of that."""

    estimate: Estimate
    values: tuple[float, ...]


def workers() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0))


def realisation(sampler: str, n: int, measures: Sequence[str], seed: int) -> list[Measured]:
    """Measures of the set of a seed, taken modulo 2^64; those that draw draw by the same seed."""
    seed %= 2**64
    points = samplers.points(sampler, n, 2, seed)
    return [discrepancy.measure(spec, points, seed) for spec in measures]


def measure_all(asked: Sequence[Asked], seed: int, threads: int, tell: Tell | None = None) -> list[Found]:
    """What each comes to. `tell` is told what is measured, how many realisations are done, and of how many.

    Raises what the samplers and measures raise.
    """
    runs = [_Run(one, seed) for one in asked]
    pool = ThreadPoolExecutor(threads)
    try:
        while any(run.goal > len(run.values) for run in runs):
            _run_round(runs, pool, tell)
            for run in runs:
                run.plan()
    finally:
        pool.shutdown(cancel_futures=True)
    return [run.found() for run in runs]


def _run_round(runs: Sequence[_Run], pool: ThreadPoolExecutor, tell: Tell | None) -> None:
    """Every run to its goal; the longest pieces first, so that no thread is left with one at the end."""
    pieces = [(run, piece) for run in runs for piece in run.pieces()]
    pieces.sort(key=lambda entry: -entry[0].asked.n)
    done, total = sum(len(run.values) for run in runs), sum(run.goal for run in runs)
    made = pool.map(lambda entry: entry[0].values_of(entry[1]), pieces)
    for (run, _), values in zip(pieces, made, strict=True):
        if tell:
            tell(f"{run.asked.sampler}, {run.asked.n} points, {run.asked.measure}", done, total)
        run.values += values
        done += len(values)


class _Run:
    """The realisations of one that is asked for: `values` so far, and up to how many to go on for now."""

    def __init__(self, asked: Asked, seed: int) -> None:
        self.asked, self.seed = asked, seed
        self.randomised = samplers.randomised(asked.sampler, asked.n)
        self.values: list[float] = []
        self.own_error = 0.0
        self.goal = (asked.count or FIRST) if self.randomised else 1

    def pieces(self) -> Iterator[range]:
        """Those up to the goal, in order."""
        for begin in range(len(self.values), self.goal, STEP):
            yield range(begin, min(begin + STEP, self.goal))

    def values_of(self, piece: range) -> list[float]:
        """The measure of these realisations."""
        values = []
        for index in piece:
            (measured,) = realisation(self.asked.sampler, self.asked.n, [self.asked.measure], self.seed + index)
            values.append(measured.value)
            if not self.randomised and measured.certainty == "estimated":
                self.own_error = measured.standard_error
        return values

    def plan(self) -> None:
        """Sets the goal higher where the standard error is not below what was asked for."""
        made = len(self.values)
        if not self.randomised or self.asked.count is not None or made >= MOST:
            return
        estimate = self._pooled()
        assert estimate.value is not None
        assert estimate.standard_error is not None
        wanted = self.asked.share * estimate.value
        if estimate.standard_error < wanted or estimate.standard_error == 0.0:
            return
        factor = min((estimate.standard_error / wanted) ** 2 * 1.05, GROWTH) if wanted > 0.0 else GROWTH
        self.goal = min(max(math.ceil(made * factor / STEP), made // STEP + 1) * STEP, MOST)

    def _pooled(self) -> Estimate:
        return statistics.root_mean_square(self.values) if self.asked.squares else statistics.mean(self.values)

    def found(self) -> Found:
        """The figure of all values."""
        if not self.randomised:
            return Found(Estimate(self.values[0], self.own_error), tuple(self.values))
        return Found(self._pooled(), tuple(self.values))
