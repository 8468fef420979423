"""Student's tests of means of replicates, against a margin; and the jackknife of a ratio."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from aliascope.agreement import welch
from aliascope.geometry import Array


@dataclass(frozen=True)
class Tested:
    """Of each test: the mean, its standard error, the limit of |mean|, the two-sided p-value."""

    mean: Array
    standard_error: Array
    limit: Array
    p_value: Array

    @property
    def share(self) -> Array:
        """Of its limit, that each mean is; infinite for one that is no number."""
        return np.asarray(np.where(np.isnan(self.mean), np.inf, np.abs(self.mean) / self.limit))


def student_test(
    values: Array, margin: Array | float, known: Array | float, chance: float, floor: Array | float = 0.0
) -> Tested:
    """Student's test of the mean of values (K, n), one test a column, with what is `known` of its standard error
    besides, from so much that it counts as exact. `floor`: the least that its own standard error can be."""
    # Around the first: equal values have no variance, not that of their rounding.
    moved = values - values[0]
    mean = values[0] + moved.mean(axis=0)
    own = moved.var(axis=0, ddof=1) / len(values)
    least = np.broadcast_to(np.asarray(floor, dtype=np.float64) ** 2, own.shape)
    other = np.broadcast_to(np.asarray(known, dtype=np.float64) ** 2, own.shape)
    freedom = welch(np.maximum(own, least), other, np.where(least > own, 1e9, len(values) - 1.0), 1e9)
    own = np.maximum(own, least)
    error = np.sqrt(own + other)
    beyond = np.abs(mean) - margin
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.where(beyond <= 0.0, 0.0, beyond / error)
    limit = margin + np.asarray(student.isf(chance / 2, freedom)) * error
    return Tested(mean, error, limit, 2.0 * np.asarray(student.sf(t, freedom)))


def jackknife(now: Array, then: Array) -> tuple[float, float, int]:
    """The logarithm of the ratio of root mean squares over blocks, its standard error by leaving out a block at a time,
    and the degrees of freedom: blocks that have an error, less one."""
    seen = now + then > 2.0**-48
    now, then = now[seen], then[seen]
    if len(now) == 0:
        return (math.nan if np.isnan(seen).any() else 0.0), 0.0, 1
    logs = 0.5 * np.log(np.maximum(now.sum(), 2.0**-48) / np.maximum(then.sum(), 2.0**-48))
    if len(now) == 1:
        return float(logs), 0.0, 1
    without = 0.5 * np.log(np.maximum(now.sum() - now, 2.0**-48) / np.maximum(then.sum() - then, 2.0**-48))
    spread = math.sqrt((len(now) - 1) / len(now) * float(((without - without.mean()) ** 2).sum()))
    return float(logs), spread, len(now) - 1
