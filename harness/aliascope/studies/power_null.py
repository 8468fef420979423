"""How often a regression run raises an alarm where nothing changed: whole runs, repeated with other replicates.

A repetition draws of the pool of each seeded cell (`power_pool`) replicates for now and as many others for what was
blessed, and judges all checks of the run with its limits. That is harder than what happens on one machine, where both
have the same seeds and nothing differs at all: here everything differs but what the renderer does.
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.stats import beta

from aliascope.errors import JobFailed
from aliascope.regression.records import Blessed, Check, Observed
from aliascope.regression.verdict import Chances, judge
from aliascope.studies.power_kept import Kept
from aliascope.studies.power_pool import Pool

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Null:
    """Of so many repetitions, those with any alarm; and all alarms, by cell and check."""

    repetitions: int
    alarms: int
    by: Mapping[str, int] = field(default_factory=dict)

    def joined(self, other: Null) -> Null:
        by = Counter(self.by) + Counter(other.by)
        return Null(self.repetitions + other.repetitions, self.alarms + other.alarms, dict(by))

    @property
    def bound(self) -> float:
        """The upper end of the one-sided 95 % interval of Clopper and Pearson (1934) for the share of runs with an
        alarm."""
        if self.alarms >= self.repetitions:
            return 1.0
        return float(beta.ppf(CONFIDENCE, self.alarms + 1, self.repetitions - self.alarms))


def blessed_of(observed: Observed) -> Blessed:
    """What would be kept of it, had it been blessed."""
    return Blessed(observed, "", "", {}, "", "", "")


def alarms_of(now: Observed, then: Observed, chances: Chances) -> list[Check]:
    """The checks that fail a run."""
    checks = judge(now, blessed_of(then), chances)
    return [check for check in checks if not check.passed and not check.warning]


def repeated(folder: Path, keys: Sequence[str], chances: Chances, replicates: int, numbers: Sequence[int]) -> Null:
    """The repetitions of these numbers, from the pools that are kept under these keys; each draws by itself, whatever
    the others do. Runs in a worker process."""
    pools, found = _pools(folder, tuple(keys)), Null(0, 0)
    for number in numbers:
        random = np.random.Generator(np.random.PCG64(number))
        by: Counter[str] = Counter()
        for pool in pools:
            order = random.permutation(len(pool.products)).tolist()
            now, then = pool.chosen(order[:replicates]), pool.chosen(order[replicates : 2 * replicates])
            by.update(f"{now.name.text}  {check.family}: {check.about}" for check in alarms_of(now, then, chances))
        found = found.joined(Null(1, int(bool(by)), dict(by)))
    return found


@functools.cache
def _pools(folder: Path, keys: tuple[str, ...]) -> list[Pool]:
    """Loaded once a process."""
    found = [Kept(folder).get(key) for key in keys]
    pools = [pool for pool in found if isinstance(pool, Pool)]
    if len(pools) != len(keys):
        raise JobFailed(f"{folder}: was emptied while it was in use; run the command again")
    return pools
