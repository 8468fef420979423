"""Measures of point sets, exact against bounded or estimated: what an exact value costs, and how wide bounds are."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aliascope.native import discrepancy, samplers
from aliascope.native.discrepancy import Measured
from aliascope.pipeline import Progress
from aliascope.trade.ratios import mean_ratio
from aliascope.trade.records import Knob

RENDERER = "measures"
"""What stands where the knobs of modes have their renderer."""

SETS = tuple(
    f"{spec} {seed}" for spec in ("random", "halton:scramble=owen", "sobol:scramble=owen") for seed in range(2)
)
"""Samplers and seeds."""

ROUNDS = 3
LEAST_SECONDS = 0.01
"""A measure is timed so often, each time repeated until it has taken so long, exact and other in turn."""


@dataclass(frozen=True)
class Turn:
    """An exact measure of sets of so many points, and one that is not: `width` is how far off that may be, at 95 %,
    relative to the exact value."""

    dimensions: int
    points: int
    exact: str
    other: str
    width: Callable[[Measured, float], float]


def _between(found: Measured, exact: float) -> float:
    return (found.upper - found.lower) / exact


def _below(found: Measured, exact: float) -> float:
    """Of a lower bound alone: what it lacks; an exact hit counts as a rounding."""
    return max(exact - found.value, math.ulp(exact)) / exact


def _of_draws(found: Measured, exact: float) -> float:
    return 2.0 * 1.96 * found.standard_error / exact


TURNS = (
    *(
        Turn(dimensions, points, "star", f"star-bounds:gap={gap}", _between)
        for dimensions, points in ((2, 1024), (3, 256), (4, 64))
        for gap in (0.01, 0.05)
    ),
    *(Turn(2, 1024, "half-plane", f"edge-max:draws={draws}", _below) for draws in (8192, 131072)),
    *(Turn(2, 1024, "edge-rms", f"edge-rms:draws={draws}", _of_draws) for draws in (8192, 131072)),
)


def knobs(turns: Sequence[Turn], sets: Sequence[str], progress: Progress) -> tuple[Knob, ...]:
    """One for each turn, over all sets: the geometric mean of the ratios of time, and of the relative widths, which
    stand where modes have their ratios of errors: what is exact has none."""
    found = []
    for i, turn in enumerate(turns):
        progress("measures, exact and bounded", i, len(turns))
        times, widths = zip(*(_one(turn, name) for name in sets), strict=True)
        found.append(
            Knob(
                renderer=RENDERER,
                form=f"{turn.points} points, d={turn.dimensions}",
                knob=turn.exact,
                setting=turn.other,
                baseline=turn.exact,
                time=mean_ratio(times),
                error=mean_ratio(widths),
                scenes=tuple(sets),
                pairs=len(sets),
                kind="measure",
            )
        )
    progress(None, len(turns), len(turns))
    return tuple(found)


def _one(turn: Turn, name: str) -> tuple[float, float]:
    """The logarithms of the ratio of times, and of the width, on one set."""
    spec, _, seed = name.rpartition(" ")
    points = samplers.points(spec, turn.points, turn.dimensions, int(seed))
    exact, other = (discrepancy.measure(measure, points) for measure in (turn.exact, turn.other))
    seconds = [[_seconds(measure, points) for measure in (turn.exact, turn.other)] for _ in range(ROUNDS)]
    of_exact, of_other = np.median(np.array(seconds), axis=0)
    return math.log(of_other / of_exact), math.log(turn.width(other, exact.value))


def _seconds(measure: str, points: NDArray[np.float64]) -> float:
    """CPU seconds of one measurement."""
    begun, count = time.thread_time(), 0
    while (spent := time.thread_time() - begun) < LEAST_SECONDS or count == 0:
        discrepancy.measure(measure, points)
        count += 1
    return spent / count
