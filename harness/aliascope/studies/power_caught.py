"""Which defects a regression run catches: cells with a defect, judged as in a run, with the limits of the whole suite.

By the pictures alone: that a wider filter also costs more samples is not counted. Nothing is assumed to be caught, nor
to be out of sight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aliascope.regression.records import Check, Observed
from aliascope.regression.verdict import Chances
from aliascope.studies.power_defects import Injected
from aliascope.studies.power_null import alarms_of
from aliascope.studies.regress_suite import Cell


@dataclass(frozen=True)
class Caught:
    """What became of a defect in a cell, `tries` times: caught how often, and of the time when it was nearest to its
    limit the check that failed by the most, with how many times its limit was observed, None where the limit is 0 and
    any is too much."""

    scene: str
    renderer: str
    mode: str
    defect: str
    tries: int
    caught: int
    by: str
    times: float | None
    p_value: float | None


def judged(cell: Cell, found: Sequence[Injected], chances: Chances) -> list[Caught]:
    """What became of each defect in the repetitions of a cell."""
    outcomes: dict[str, list[list[Check] | str]] = {}
    for each in found:
        for name, wrong in each.wrong.items():
            result = wrong if isinstance(wrong, str) else _seen(wrong, each.plain, chances)
            outcomes.setdefault(name, []).append(result)
        for name, several in each.placed.items():
            outcomes[name] += [_seen(wrong, each.plain, chances) for wrong in several]
    return [_caught(cell, name, each) for name, each in outcomes.items()]


def _seen(wrong: Observed, plain: Observed, chances: Chances) -> list[Check]:
    return [check for check in alarms_of(wrong, plain, chances) if check.family != "cost"]


def _caught(cell: Cell, name: str, outcomes: Sequence[list[Check] | str]) -> Caught:
    caught = [each for each in outcomes if each]
    least: tuple[float, str, float | None] | None = None
    for each in caught:
        best = (np.inf, each, None) if isinstance(each, str) else max(map(_extent, each), key=lambda one: one[0])
        if least is None or best[0] < least[0]:
            least = best
    times, by, p_value = least or (0.0, "", None)
    place = (cell.name.scene, cell.name.renderer, cell.name.mode, name)
    return Caught(*place, len(outcomes), len(caught), by, None if np.isinf(times) else times, p_value)


def _extent(check: Check) -> tuple[float, str, float | None]:
    """How many times its limit was observed, or the limit the observed where it is a lower one."""
    above, below = (check.limit, check.observed) if check.at_least else (check.observed, check.limit)
    times = abs(above / below) if below and np.isfinite(above) else np.inf
    return times, f"{check.family}: {check.about}", check.p_value
