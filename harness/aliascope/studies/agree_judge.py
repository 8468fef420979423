"""Whether two renderers' pictures of a scene are estimates of the same integral: statistics, no more.

Of each renderer there are R pictures ("replicates"), alike but for their seeds, whose mean is without bias. What is
tested are differences of means: of every value; of every block of 8 x 8 pixels and channel; of each channel over the
picture; and of the coefficients with which known flaws (`Effect`: another gain, a shift, a blur) are found in the
pictures, by least squares. d / sqrt(v) has Student's distribution, nearly, with Welch's degrees of freedom (1947), v
being the sum of two variances. As a variance comes from how whole pictures scatter, samples that all pixels share do no
harm. The four kinds share SIGNIFICANCE, each divided by how many tests of it all cells of the run have (Bonferroni).

Two things widen a limit. `Side.bound` is what a renderer's values may be off by in every picture, a sum that no seed
averages out: half the step of its output, edges that a rasteriser snaps. And a well stratified pattern counts a detail
with floor(N p) or ceil(N p) of its N samples, mostly with the same one of the two in all pictures, which then scatter
less than they are off. So the standard error of a value is at least that of one sample more or less in each picture,
range / (N sqrt(R)), and of a block, whose pixels may share their samples, the mean of its values'; and no less than
what the other side's would be with as many samples.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from aliascope.agreement import BLOCK, SIGNIFICANCE, blocks, welch
from aliascope.geometry import Array

KINDS = ("pixel", "block", "picture", "effect")
"""Of tests."""

FOUND = 2.6
"""Standard errors beyond its limit at which a difference is found 99 times in 100: Student's quantile for 15 degrees of
freedom, 2.33 for many."""


@dataclass(frozen=True)
class Side:
    """One renderer's pictures of a scene: (R, height, width, 3) float64, of `samples` a pixel each; `bound`
    (height, width, 3) is what their mean may be off by, whatever the seeds."""

    renderer: str
    pictures: Array
    samples: int
    bound: Array


@dataclass(frozen=True)
class Effect:
    """A flaw that a renderer could have: `amount` of it, in a unit, changes the picture by `change`
    (height, width, 3)."""

    name: str
    amount: float
    unit: str
    change: Array


@dataclass(frozen=True)
class Tests:
    """All tests of one kind: differences of the means, their standard errors, what no seed averages out, the limits."""

    kind: str
    difference: Array
    standard_error: Array
    bound: Array
    limit: Array
    projected: Callable[[Array], Array]
    """What a change of the picture makes of `difference`."""

    @property
    def share(self) -> Array:
        """Of its limit, that each difference is; infinite for one that is no number."""
        share = np.abs(self.difference) / np.where(self.limit > 0.0, self.limit, np.finfo(float).tiny)
        return np.where(np.isnan(share), np.inf, share)

    @property
    def errors(self) -> Array:
        """Standard errors that each difference is beyond its bound, signed; infinite where there are none."""
        beyond = np.maximum(np.abs(self.difference) - self.bound, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            many = np.where(beyond > 0.0, beyond / self.standard_error, 0.0)
        return np.copysign(many, self.difference)

    def catches(self, change: Array) -> bool:
        """Whether a test of this kind would fail if the second renderer had this change too, and its opposite."""
        moved = self.projected(change)
        return all(bool((np.abs(self.difference - sign * moved) > self.limit).any()) for sign in (1.0, -1.0))

    def least(self, change: Array) -> float:
        """The multiple of a change from which on it is found 99 times in 100; infinite where it is never."""
        moved = np.abs(self.projected(change))
        within = moved > 1e-9 * float(np.abs(change).max(initial=0.0))
        if not within.any():
            return float("inf")
        return float(((self.limit + FOUND * self.standard_error)[within] / moved[within]).min())


@dataclass(frozen=True)
class Worst:
    """The test whose difference is the largest share of its limit. `place`: (row, column, channel) of a value, the
    first pixel of a block, (channel,) of a picture, (number,) of an effect."""

    kind: str
    place: tuple[int, ...]
    difference: float
    standard_error: float
    limit: float

    @property
    def share(self) -> float:
        return abs(self.difference) / self.limit if self.limit > 0.0 else float("inf") if self.difference else 0.0


@dataclass(frozen=True)
class Found:
    """Of an effect: how much of it the second renderer has more than the first, in its unit, with the standard error,
    the limit, and what of it is the `bound`; the least amount that the run would have found; and whether it finds
    `amount`, put in on purpose."""

    effect: Effect
    value: float
    standard_error: float
    limit: float
    bound: float
    least: float
    caught: bool

    @property
    def granted(self) -> bool:
        """Whether there is more of it than chance would have, within the limit: what is granted explains it."""
        return self.limit - self.bound < abs(self.value) <= self.limit


@dataclass(frozen=True)
class Judgement:
    """What came out of all tests of one pair of renderers on one scene."""

    tests: tuple[Tests, ...]
    worst: Mapping[str, Worst]
    """By kind."""
    found: tuple[Found, ...]

    @property
    def failed(self) -> list[Worst]:
        return [worst for worst in self.worst.values() if not worst.share <= 1.0]

    @property
    def nearest(self) -> Worst:
        """To its limit, or furthest beyond."""
        return max(self.worst.values(), key=lambda worst: worst.share)


def judge(
    one: Side, other: Side, ranges: Array, effects: Sequence[Effect], cells: int, significance: float = SIGNIFICANCE
) -> Judgement:
    """Tests two sides against each other.

    ranges (height, width, 3): between the largest and the least value that a sample of a pixel can have. cells: how
    many pairs are tested in this run; significance: the chance that all of its tests have together to call what agrees
    different.
    """
    seen = [effect for effect in effects if (effect.change**2).sum() > 0.0]
    floors = [ranges / (side.samples * np.sqrt(len(side.pictures))) for side in (one, other)]
    plain = [np.zeros(1), np.zeros(1)]
    fits, sides, chance = _Fits(seen), (one, other), significance / len(KINDS) / cells
    tests = [
        _tests("pixel", lambda each: each, lambda bound: bound, sides, floors, chance),
        _tests("block", blocks, blocks, sides, [blocks(floor) for floor in floors], chance),
        _tests("picture", _mean, _mean, sides, plain, chance),
    ]
    if seen:
        tests.append(_tests("effect", fits.of, fits.bound, sides, plain, chance))
    worst = {each.kind: _worst(each) for each in tests}
    return Judgement(tuple(tests), worst, tuple(_found(number, each, tests) for number, each in enumerate(seen)))


def _mean(pictures: Array) -> Array:
    mean: Array = pictures.mean(axis=(-3, -2))
    return mean


class _Fits:
    """The coefficients of effects in pictures, each by itself: (I . change) / (change . change)."""

    def __init__(self, effects: Sequence[Effect]) -> None:
        self._changes = [effect.change / (effect.change**2).sum() for effect in effects]

    def of(self, pictures: Array) -> Array:
        # No matrix product, whose rounding depends on how it is shared among threads.
        return np.stack([(pictures * change).sum(axis=(-3, -2, -1)) for change in self._changes], axis=-1)

    def bound(self, bound: Array) -> Array:
        return np.array([float((bound * np.abs(change)).sum()) for change in self._changes])


def _tests(
    kind: str,
    project: Callable[[Array], Array],
    project_bound: Callable[[Array], Array],
    sides: tuple[Side, Side],
    floors: Sequence[Array],
    chance: float,
) -> Tests:
    """All of a kind on one pair; `chance`: that one of them calls what agrees different."""
    means, variances, freedoms = [], [], []
    for side in sides:
        values = project(side.pictures)
        # Around the first: equal values have no variance, not that of their rounding.
        moved = values - values[0]
        means.append(values[0] + moved.mean(axis=0))
        variances.append(moved.var(axis=0, ddof=1) / len(side.pictures))
        freedoms.append(float(len(side.pictures) - 1))
    counts = [side.samples * len(side.pictures) for side in sides]
    least = [np.maximum(floors[i] ** 2, _like(variances[1 - i], counts[1 - i] / counts[i], kind)) for i in (0, 1)]
    freedom = welch(
        *(np.maximum(variances[i], least[i]) for i in (0, 1)),
        *(np.where(least[i] > variances[i], 1e9, freedoms[i]) for i in (0, 1)),
    )
    spread = np.sqrt(np.maximum(variances[0], least[0]) + np.maximum(variances[1], least[1]))
    difference = means[1] - means[0]
    quantile = student.isf(chance / 2 / difference.size, freedom)
    bound = project_bound(sides[0].bound) + project_bound(sides[1].bound)
    return Tests(kind, difference, spread, bound, quantile * spread + bound, project)


def _like(variance: Array, ratio: float, kind: str) -> Array:
    """What a variance would be with other samples; values and blocks alone may hang on a detail that few meet."""
    return variance * ratio if kind in ("pixel", "block") else np.zeros_like(variance)


def _worst(tests: Tests) -> Worst:
    place = tuple(int(i) for i in np.unravel_index(int(np.argmax(tests.share)), tests.difference.shape))
    shown = tuple(BLOCK * i for i in place[:2]) + place[2:] if tests.kind == "block" else place
    figures = (float(each[place]) for each in (tests.difference, tests.standard_error, tests.limit))
    return Worst(tests.kind, shown, *figures)


def _found(number: int, effect: Effect, tests: Sequence[Tests]) -> Found:
    fits = tests[-1]
    value, error, limit, bound = (
        effect.amount * float(each[number]) for each in (fits.difference, fits.standard_error, fits.limit, fits.bound)
    )
    least = min(each.least(effect.change) for each in tests)
    caught = any(each.catches(effect.change) for each in tests)
    return Found(effect, value, error, limit, bound, effect.amount * least, caught)
