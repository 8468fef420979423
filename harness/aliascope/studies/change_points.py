"""Where a series of figures goes to another level, by tests whose error rate is stated.

Two models. Figures whose noise is not known, and has outliers, as times have: ranks. A part [i, j) of the series is set
against the rest by the rank-sum test (Wilcoxon 1945, Mann and Whitney 1947; U_k of Pettitt 1979 is twice its sum about
the mean). Figures that come with standard errors: the difference of the means over its standard error, which is
widened where the figures scatter by more than their standard errors have it (Birge 1932).

The most telling split into before and after has half of the level, the most telling stretch that goes away and comes
back the other half (Olshen, Venkatraman, Lucito, Wigler 2004: a search for splits alone does not see a regression that
was mended). Its p-value is that of the most telling of all places: the bound of Bonferroni, or, where that is above
the level, the share of permutations of the ranks that have one as telling. What was found divides the series, and each
part is searched again at its share of the level by length, so that all parts without a change together raise an alarm
at most as often.

Where a change is: all places at which twice the logarithm of the likelihood is within 2 log 40 of the largest, a set of
about 95 % (Siegmund 1988); that of Laplace's distribution goes with ranks.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri, stdtr
from scipy.stats import rankdata

from aliascope.geometry import Array

Indices = NDArray[np.int64]

EXACT_UP_TO = 50
"""Figures up to which the distribution of rank sums is exact; the normal one, which has wider tails, beyond."""
_DRAWS = 20000
"""Permutations for splits; for stretches as many as take about as long as 40 figures do."""
_FEW = 16
_HARDLY_TIED = 0.98
"""The variance of ranks, over that without ties, from which on more than _FEW are taken for untied."""
_SHOWS = 0.01
"""The p-value at most of a change between its neighbours, or the level where that is more."""
_WIDTH = 2.0 * math.log(40.0)
CONFIDENCE = 0.95
_ROUNDING = 1e-12
"""Relative, of chances that are equal but for the order of additions."""


@dataclass(frozen=True)
class Change:
    """The figures from `at` on have another level than those before. It may be anywhere from `earliest` to `latest`."""

    at: int
    earliest: int
    latest: int
    p_value: float


class Scan(Protocol):
    """A part of a series, ready to be searched."""

    def split(self, level: float) -> tuple[int, float]:
        """The most telling place of a change and its p-value, or 1 where that is above the level for sure."""

    def stretch(self, level: float) -> tuple[int, int, float]:
        """The most telling [i, j) against the rest, both ends inside, and its p-value as above."""

    def likelihood(self) -> Array:
        """Twice the logarithm of the likelihood of a change at 1, 2, ..., but for a constant."""


def by_ranks(values: Sequence[float], level: float) -> list[Change]:
    """The changes of a series whose noise is unknown, but the same before and after, at the significance `level`."""
    array = np.asarray(values, dtype=np.float64)
    return _changes(len(array), lambda low, high: Ranks(array[low:high]), level)


def by_errors(values: Sequence[float], errors: Sequence[float], freedom: Sequence[float], level: float) -> list[Change]:
    """The changes of independent figures with standard errors > 0, each of so many degrees of freedom."""
    x, s, f = (np.asarray(each, dtype=np.float64) for each in (values, errors, freedom))
    return _changes(len(x), lambda low, high: Measured(x[low:high], s[low:high], f[low:high]), level)


def _changes(n: int, scan: Callable[[int, int], Scan], level: float) -> list[Change]:
    found: dict[int, float] = {}
    parts = [(0, n)]
    while parts:
        low, high = parts.pop()
        if high - low < 2:
            continue
        places, p = _search(scan(low, high), level * (high - low) / n / 2.0)
        if places:
            cuts = [low + place for place in places]
            found |= dict.fromkeys(cuts, p)
            ends = [low, *cuts, high]
            parts += list(pairwise(ends))
    cuts = _kept(sorted(found), n, scan, max(level, _SHOWS))
    # Each change again, between its neighbours: a stretch or a later change may have drawn it aside.
    placed = []
    for before, at, after in zip([0, *cuts], cuts, [*cuts[1:], n], strict=False):
        likely = scan(before, after).likelihood()
        near = before + 1 + np.flatnonzero(likely >= likely.max() - _WIDTH)
        best = before + 1 + int(likely.argmax())
        placed.append(Change(best, int(near[0]), int(near[-1]), min(1.0, found[at])))
    return list({change.at: change for change in placed}.values())


def _kept(cuts: list[int], n: int, scan: Callable[[int, int], Scan], most: float) -> list[int]:
    """The changes that show between their neighbours too: one end of a stretch can be chance where the other is none
    (Olshen and others 2004)."""
    while cuts:
        ends = [0, *cuts, n]
        chances = [scan(before, after).split(most)[1] for before, after in zip(ends, ends[2:], strict=False)]
        worst = max(range(len(cuts)), key=chances.__getitem__)
        if chances[worst] <= most:
            break
        cuts = cuts[:worst] + cuts[worst + 1 :]
    return cuts


def _search(part: Scan, level: float) -> tuple[list[int], float]:
    """What divides a part: one place, two, or none; the p-value is doubled, as two searches share the level."""
    at, of_split = part.split(level)
    first, last, of_stretch = part.stretch(level)
    if min(of_split, of_stretch) > level:
        return [], 1.0
    return ([at], 2.0 * of_split) if of_split <= of_stretch else ([first, last], 2.0 * of_stretch)


def least_p_value(n: int) -> float:
    """What `by_ranks` can have of n figures at best, as it is compared with the level; 1 or more: it finds nothing."""
    return 4.0 / math.comb(n, n // 2) if n >= 2 else 1.0


def tested(least: Sequence[float], significance: float) -> tuple[float, int]:
    """The level for each of many tests, and how many count, given the least p-value each can have (Tarone 1990).

    Tests that could not reach the level whatever the figures were are no chance of an alarm, and are not counted.
    """
    for count in range(1, len(least) + 1):
        if sum(p <= significance / count for p in least) <= count:
            return significance / count, sum(p <= significance / count for p in least)
    return significance, 0


# --- ranks ------------------------------------------------------------------------------------------------------------


class Ranks:
    """By ranks; equal figures have the mean of theirs. Ranks are doubled, to be whole numbers."""

    def __init__(self, values: Array) -> None:
        self.values = values
        self.ranks = np.rint(2.0 * rankdata(values)).astype(np.int64)
        self.n = len(values)
        self.sums = np.concatenate([[0], np.cumsum(self.ranks)])
        untied = 2 * np.arange(1, self.n + 1)
        if self.n > _FEW and self.ranks.var() > _HARDLY_TIED * untied.var():
            # The distribution without ties has tails that are a little wider, and is made once for all series.
            self.kind = tuple(untied.tolist())
        else:
            self.kind = tuple(np.sort(self.ranks).tolist())

    def pettitt(self) -> Indices:
        """U_k = 2 (sum of the first k ranks) - k (n + 1), k = 1 ... n - 1 (Pettitt 1979)."""
        k = np.arange(1, self.n)
        return self.sums[1:-1] - k * (self.n + 1)

    def _splits(self) -> Array:
        tails = Tails.of(self.kind)
        return np.array([tails(self.sums[k : k + 1], k)[0] for k in range(1, self.n)])

    def split(self, level: float) -> tuple[int, float]:
        chances = self._splits()
        at = int(chances.argmin())
        if chances[at] > level:
            return at + 1, 1.0
        bound = sum(Tails.of(self.kind).most(float(chances[at]), m) for m in range(1, self.n))
        return at + 1, _p_value(float(chances[at]), _null_splits, self.kind, bound, level)

    def stretch(self, level: float) -> tuple[int, int, float]:
        best = (math.inf, 0, self.n)
        for m in range(1, self.n - 1):
            chances = Tails.of(self.kind)(self.sums[m:] - self.sums[:-m], m)[1:-1]  # at the ends they are splits
            if chances.min() < best[0]:
                best = (float(chances.min()), int(chances.argmin()) + 1, int(chances.argmin()) + 1 + m)
        if best[0] > level:
            return 0, self.n, 1.0
        tails = Tails.of(self.kind)
        bound = sum((self.n - 1 - m) * tails.most(best[0], m) for m in range(1, self.n - 1))
        return best[1], best[2], _p_value(best[0], _null_stretches, self.kind, bound, level)

    def likelihood(self) -> Array:
        """Of Laplace's distribution, whose levels are medians: an outlier moves no change by much."""
        x, places = self.values, range(1, self.n)
        sums = np.array([_deviations(x[:k]) + _deviations(x[k:]) for k in places])
        scale = sums.min() / self.n
        return np.asarray(-2.0 * sums / scale) if scale > 0.0 else np.where(sums > 0.0, -np.inf, 0.0)


def _deviations(values: Array) -> float:
    """The sum of distances from the median."""
    return float(np.abs(values - np.median(values)).sum())


def _p_value(
    chance: float, null: Callable[[tuple[int, ...]], Array], kind: tuple[int, ...], bound: float, level: float
) -> float:
    """Of the least of many chances: the sum of the places' own chances to be as small, or, where that says too little,
    by permutations."""
    if bound <= level:
        return bound
    least = null(kind)
    as_telling = int(np.searchsorted(least, chance * (1.0 + _ROUNDING), side="right"))
    return min(1.0, (as_telling + 1) / (len(least) + 1), bound)


class Tails:
    """The two-sided chance of the sum of m of the doubled ranks, drawn without replacement."""

    def __init__(self, kind: tuple[int, ...]) -> None:
        ranks = np.array(kind, dtype=np.int64)
        self.n = len(ranks)
        self.variance = float(ranks.astype(np.float64).var())
        self.untied = len(set(kind)) == self.n
        self.exact: list[Array] | None = None
        if self.n <= EXACT_UP_TO:
            ways = _ways(ranks)
            self.exact = [self._both(row) for row in ways]
            self.reached = [np.unique(both[row > 0.0]) for both, row in zip(self.exact, ways, strict=True)]

    @staticmethod
    @lru_cache(maxsize=256)
    def of(kind: tuple[int, ...]) -> Tails:
        """Those of ranks with these ties; kept, as most series have none."""
        return Tails(kind)

    @staticmethod
    def _both(ways: Array) -> Array:
        total = ways.sum()
        below, above = np.cumsum(ways), np.cumsum(ways[::-1])[::-1]
        return np.asarray(np.minimum(1.0, 2.0 * np.minimum(below, above) / total))

    def most(self, chance: float, m: int) -> float:
        """How likely it is that m ranks are as telling as `chance`: their sums reach certain chances only."""
        if self.exact is None:
            return chance
        reached = self.reached[m]
        count = int(np.searchsorted(reached, chance * (1.0 + _ROUNDING), side="right"))
        return float(reached[count - 1]) if count else 0.0

    def __call__(self, sums: Indices, m: int) -> Array:
        mean = m * (self.n + 1)
        if self.exact is not None:
            if self.untied:  # odd sums are those of ties, half way between two that can be: the less telling one
                sums = sums + (sums % 2) * np.sign(mean - sums)
            return np.asarray(self.exact[m][sums])
        variance = self.variance * m * (self.n - m) / (self.n - 1)
        if variance == 0.0:
            return np.ones(sums.shape)
        # Half of the least distance of two sums without ties, as the distribution is not continuous.
        away = np.maximum(np.abs(sums - mean) - 1.0, 0.0)
        return np.asarray(2.0 * ndtr(-away / math.sqrt(variance)))


def _ways(ranks: Indices) -> Array:
    """[m, s]: in how many ways m of the ranks have the sum s. Below 2^53 for 50, so exact in float64."""
    n, most = len(ranks), int(ranks.sum())
    ways = np.zeros((n + 1, most + 1))
    ways[0, 0] = 1.0
    for count, rank in enumerate(ranks.tolist()):
        ways[1 : count + 2, rank:] += ways[: count + 1, : most + 1 - rank].copy()
    return ways


def _permuted(kind: tuple[int, ...], draws: int) -> Indices:
    """Sums of the first 0, 1, ... n of the ranks in random orders, (draws, n + 1); always the same ones."""
    generator = np.random.Generator(np.random.PCG64(len(kind)))
    orders = generator.permuted(np.tile(np.array(kind, dtype=np.int64), (draws, 1)), axis=1)
    return np.concatenate([np.zeros((draws, 1), dtype=np.int64), np.cumsum(orders, axis=1)], axis=1)


@lru_cache(maxsize=256)
def _null_splits(kind: tuple[int, ...]) -> Array:
    """The least chance of all splits of each permutation, sorted."""
    n, tails = len(kind), Tails.of(kind)
    sums = _permuted(kind, min(_DRAWS, max(1000, 4_000_000 // n)))
    least = np.ones(len(sums))
    for k in range(1, n):
        np.minimum(least, tails(sums[:, k], k), out=least)
    return np.sort(least)


@lru_cache(maxsize=256)
def _null_stretches(kind: tuple[int, ...]) -> Array:
    """The same of all stretches that touch neither end."""
    n, tails = len(kind), Tails.of(kind)
    sums = _permuted(kind, min(_DRAWS, max(500, 8_000_000 // (n * n))))
    least = np.ones(len(sums))
    for m in range(1, n - 1):
        chances = tails(sums[:, 1 + m : n] - sums[:, 1 : n - m], m)
        np.minimum(least, chances.min(axis=1), out=least)
    return np.sort(least)


# --- standard errors --------------------------------------------------------------------------------------------------


class Measured:
    """By standard errors: Student's distribution with Satterthwaite's degrees of freedom, the bound of Bonferroni.

    Means are plain ones. With weights from the standard errors of figures that were estimated with them, a figure that
    came out low by chance, and its standard error with it, would count for more.
    """

    def __init__(self, values: Array, errors: Array, freedom: Array) -> None:
        self.n = len(values)
        moved = values - values[0]  # squares of what is left keep their digits
        self.first = _before(moved)
        self.variances = _before(errors**2.0)
        self.fourths = _before(errors**4.0 / freedom)
        self.scaled = [_before(moved**power / errors**2.0) for power in range(3)]

    def _chance(self, i: Indices, j: Indices) -> Array:
        """Of [i, j) against the rest: the two-sided p-value."""
        inside, outside = (j - i).astype(np.float64), (self.n - (j - i)).astype(np.float64)
        first = self.first[j] - self.first[i]
        means = first / inside, (self.first[-1] - first) / outside
        part, fourth = self.variances[j] - self.variances[i], self.fourths[j] - self.fourths[i]
        variance = part / inside**2 + (self.variances[-1] - part) / outside**2
        spread = fourth / inside**4 + (self.fourths[-1] - fourth) / outside**4
        birge = np.maximum(1.0, self._scatter(i, j, means) / max(self.n - 2, 1))
        t = np.abs(means[0] - means[1]) / np.sqrt(birge * variance)
        return np.asarray(2.0 * stdtr(variance**2 / spread, -t))

    def _scatter(self, i: Indices, j: Indices, means: tuple[Array, Array]) -> Array:
        """The sum of squares about the two means, in standard errors."""
        zero, one, two = (sums[j] - sums[i] for sums in self.scaled)
        others = [sums[-1] - part for sums, part in zip(self.scaled, (zero, one, two), strict=True)]
        about = two - 2.0 * means[0] * one + means[0] ** 2 * zero
        return np.asarray(about + others[2] - 2.0 * means[1] * others[1] + means[1] ** 2 * others[0])

    def _splits(self) -> Array:
        return self._chance(np.zeros(self.n - 1, dtype=np.int64), np.arange(1, self.n))

    def split(self, level: float) -> tuple[int, float]:
        chances = self._splits()
        at = int(chances.argmin())
        return at + 1, min(1.0, float(chances[at]) * (self.n - 1))

    def stretch(self, level: float) -> tuple[int, int, float]:
        i, j = np.triu_indices(self.n, 1)
        inner = (i > 0) & (j < self.n)
        i, j = i[inner], j[inner]
        if not len(i):
            return 0, self.n, 1.0
        chances = self._chance(i, j)
        best = int(chances.argmin())
        return int(i[best]), int(j[best]), min(1.0, float(chances[best]) * len(i))

    def likelihood(self) -> Array:
        """z^2 of the two-sided chances."""
        return np.square(ndtri(np.clip(self._splits(), 1e-300, 1.0) / 2.0))


def _before(values: Array) -> Array:
    """Sums of the first 0, 1, ... values."""
    return np.concatenate([[0.0], np.cumsum(values)])
