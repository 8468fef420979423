"""Patterns of space and time: does it pay that samples near each other in the pixel are far apart in time?

"Decorrelate space and time: nearby samples in space should differ greatly in time" (Hanrahan 2000, CS348B, "Space-time
patterns"). For each pattern in x, y and t this measures how far apart near samples are in time, how even the pattern is
in the plane, in each plane with time and in all three, and the error of a picture in motion that is drawn with it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aliascope import statistics
from aliascope.native import discrepancy, samplers
from aliascope.native.estimate import normal_quantile, student_t_quantile
from aliascope.native.tracer import Tracer
from aliascope.records import Estimate

Array = NDArray[np.float64]
Tell = Callable[[str | None, int, int], None]
Interval = tuple[float, float]

COUNTS = (16, 64)
GROUPS = (2, 1)
"""The place in the pixel, the time."""
PLANES: Mapping[str, tuple[int, ...]] = {"xy": (0, 1), "xt": (0, 2), "yt": (1, 2), "xyt": (0, 1, 2)}
CONFIDENCE = 0.95
BINS = 16
"""Of the profile: distances up to 4 in units of N^-1/2, a quarter each."""
BIN = 0.25
UNKNOWN = Estimate(None)


@dataclass(frozen=True)
class Pattern:
    """A sampler in three dimensions, and how its plane and its time go together."""

    sampler: str
    arrangement: str = "joint"

    @property
    def name(self) -> str:
        return self.sampler if self.arrangement == "joint" else f"{self.sampler}, {self.arrangement}"


JOINT = (
    *("cook", "pan-diagonal", "mitchell-spacetime", "random", "n-rooks", "latin-square", "multi-jittered"),
    *("orthogonal-array:strength=3", "hammersley", "halton", "halton:scramble=owen", "sobol:scramble=owen"),
    *("pmj02", "r2"),
)
"""As they lay out three dimensions themselves. `jittered` and other planar patterns pad them: see PLANAR."""
PLANAR = ("jittered", "hammersley", "sobol:scramble=owen", "correlated-multi-jittered", "blue-noise")
"""Those that are looked at padded and decorrelated too: the same places and times, dealt out in two ways."""
PATTERNS = (
    *(Pattern(sampler) for sampler in JOINT),
    *(Pattern(sampler, arrangement) for sampler in PLANAR for arrangement in ("padded", "decorrelated")),
)
TABLES = ("cook", "pan-diagonal", "mitchell-spacetime")
"""One sample in each cell of a grid and in each slot of time, as jittered points have: `jittered`, padded, has them
dealt out at random, these by a table."""


@dataclass(frozen=True)
class Options:
    """realisations: of each randomised pattern; pictures: of each, with seeds of their own; the first seed."""

    realisations: int = 64
    pictures: int = 12
    seed: int = 0


@dataclass(frozen=True)
class Row:
    """What one pattern of n samples comes to; only a reason where there is none.

    near: mean difference in time, around the border, of a sample and its nearest neighbour, over the 1/4 of independent
    times: 2 at most. moran: the correlation of their times. profile: `near` of all pairs by distance. star: the star
    discrepancy by plane. rmse: of the picture.
    """

    pattern: Pattern
    n: int
    near: Estimate = UNKNOWN
    moran: Estimate = UNKNOWN
    profile: tuple[Estimate, ...] = ()
    star: Mapping[str, Estimate] = field(default_factory=dict)
    rmse: Estimate = UNKNOWN
    reason: str | None = None


def interval(estimate: Estimate, count: int) -> Interval | None:
    """Student's, of the mean of so many; None where there is no standard error."""
    if estimate.value is None or estimate.standard_error is None or count < 2:
        return None
    half = student_t_quantile(0.5 + 0.5 * CONFIDENCE, count - 1) * estimate.standard_error
    return estimate.value - half, estimate.value + half


# --- the pattern itself -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Neighbours:
    """Of one pixel's samples: `near` and `moran` as in a Row; the profile's bins, NaN where no pair is."""

    near: float
    moran: float
    profile: Array


def neighbours(centre: Array, around: Array) -> Neighbours:
    """centre: a pixel's samples (n, 3); around: those of the eight pixels about it, in its coordinates.

    Two of equal distance are taken in their order.
    """
    n = len(centre)
    everything = np.concatenate([centre, around])
    squares = ((centre[:, None, :2] - everything[None, :, :2]) ** 2).sum(axis=-1)
    squares[np.arange(n), np.arange(n)] = np.inf
    apart = np.abs(centre[:, None, 2] - everything[None, :, 2])
    differences = 4.0 * np.minimum(apart, 1.0 - apart)
    nearest = squares.argmin(axis=1)
    mine, theirs = centre[:, 2], everything[nearest, 2]
    bins = np.floor(np.sqrt(np.where(np.isfinite(squares), squares, 1e9) * n) / BIN).astype(np.int64)
    kept = bins < BINS
    counts = np.bincount(bins[kept], minlength=BINS)
    sums = np.bincount(bins[kept], differences[kept], BINS)
    profile = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
    return Neighbours(
        float(differences[np.arange(n), nearest].mean()), float(12.0 * ((mine - 0.5) * (theirs - 0.5)).mean()), profile
    )


def _realisation(pattern: Pattern, n: int, seed: int) -> tuple[Array, Neighbours]:
    """The samples of a pixel, and how they lie among themselves and those of the pixels about it."""
    sampler = samplers.Sampler(pattern.sampler, n, GROUPS, seed, pattern.arrangement)
    centre = sampler.points(n)
    places = [(x, y) for y in (-1, 0, 1) for x in (-1, 0, 1) if (x, y) != (0, 0)]
    around = np.concatenate([sampler.points(n, pixel=place) + np.array([*place, 0.0]) for place in places])
    return centre, neighbours(centre, around)


def measure_pattern(pattern: Pattern, n: int, options: Options) -> Row:
    """All but the picture. Raises Unsupported where there is no such pattern."""
    count = options.realisations if samplers.randomised(pattern.sampler, n, GROUPS, pattern.arrangement) else 1
    found: list[Neighbours] = []
    stars: dict[str, list[float]] = {name: [] for name in PLANES}
    for i in range(count):
        points, one = _realisation(pattern, n, (options.seed + i) % 2**64)
        found.append(one)
        for name, columns in PLANES.items():
            stars[name].append(discrepancy.measure("star", np.ascontiguousarray(points[:, columns]), 0).value)
    profile = np.stack([one.profile for one in found])
    bins = [column[~np.isnan(column)].tolist() for column in profile.T]
    return Row(
        pattern,
        n,
        near=statistics.mean([one.near for one in found]),
        moran=statistics.mean([one.moran for one in found]),
        profile=tuple(statistics.mean(values) for values in bins),
        star={name: statistics.mean(values) for name, values in stars.items()},
    )


# --- the picture ------------------------------------------------------------------------------------------------------

REFERENCE = "sobol:scramble=owen"
REPLICATES, REPLICATE_SAMPLES = 8, 2048
OTHER_SEEDS = 1 << 32
"""Where the reference's begin: no picture has them."""


@dataclass(frozen=True)
class Reference:
    """The mean of `REPLICATES` pictures: pixels (height, width, 3), their standard error as a root mean square."""

    pixels: Array
    standard_error: float


def reference_of(tracer: Tracer, tell: Tell) -> Reference:
    pictures = []
    for i in range(REPLICATES):
        tell("the reference", i, REPLICATES)
        pictures.append(tracer.render(REFERENCE, REPLICATE_SAMPLES, OTHER_SEEDS + i)[0].astype(np.float64))
    stack = np.stack(pictures)
    return Reference(stack.mean(axis=0), math.sqrt(float(stack.var(axis=0, ddof=1).mean()) / REPLICATES))


def picture_error(tracer: Tracer, reference: Reference, pattern: Pattern, n: int, options: Options) -> Estimate:
    """Root mean square over pictures. Of a pattern that is not randomised there is one, and no standard error."""
    randomised = samplers.randomised(pattern.sampler, n, tracer.groups, pattern.arrangement)
    errors = []
    for i in range(options.pictures if randomised else 1):
        picture = tracer.render(pattern.sampler, n, (options.seed + i) % 2**64, arrangement=pattern.arrangement)[0]
        errors.append(math.sqrt(float(((picture - reference.pixels) ** 2).mean())))
    return statistics.root_mean_square(errors)


# --- what goes with what ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RankCorrelation:
    """Spearman's, over patterns, and its interval as if they were drawn from many (Bonett and Wright 2000)."""

    value: float
    interval: Interval
    patterns: int


def rank_correlation(x: Sequence[float], y: Sequence[float]) -> RankCorrelation | None:
    """Of five pairs or more, not all x or y the same; else None."""
    n = len(x)
    if n < 5 or len(set(x)) < 2 or len(set(y)) < 2:
        return None
    value = float(np.corrcoef(_ranks(x), _ranks(y))[0, 1])
    half = normal_quantile(0.5 + 0.5 * CONFIDENCE) * math.sqrt((1.0 + 0.5 * value**2) / (n - 3))
    z = math.atanh(min(max(value, -1.0 + 1e-12), 1.0 - 1e-12))
    return RankCorrelation(value, (math.tanh(z - half), math.tanh(z + half)), n)


def _ranks(values: Sequence[float]) -> Array:
    """Those of equal values are their mean."""
    array = np.asarray(values)
    return np.array([(array < value).sum() + 0.5 * (array == value).sum() for value in array], np.float64)


@dataclass(frozen=True)
class Dealing:
    """The same places and times, dealt out otherwise than at random: the ratio of the errors, and its interval."""

    pattern: Pattern
    other: Pattern
    n: int
    near: tuple[float, float]
    """Of `pattern`, of `other`."""
    ratio: float
    interval: Interval | None

    @property
    def verdict(self) -> str:
        """Which has less error: "less" that of the pattern, "more", or "alike" where the interval holds 1."""
        if self.interval is None or self.interval[0] <= 1.0 <= self.interval[1]:
            return "alike"
        return "less" if self.interval[1] < 1.0 else "more"


def dealings(rows: Sequence[Row]) -> list[Dealing]:
    """Decorrelated against padded, and tables of slots against padded jittered points, where both were measured."""
    by_key = {(row.pattern, row.n): row for row in rows if row.reason is None}
    pairs = [(Pattern(name), Pattern("jittered", "padded")) for name in TABLES]
    pairs += [(Pattern(name, "decorrelated"), Pattern(name, "padded")) for name in PLANAR]
    found = []
    for n in sorted({row.n for row in rows}):
        for pattern, other in pairs:
            if (pattern, n) in by_key and (other, n) in by_key:
                found.append(_dealing(by_key[pattern, n], by_key[other, n]))
    return found


def _dealing(row: Row, other: Row) -> Dealing:
    a, b = row.rmse, other.rmse
    assert a.value is not None
    assert b.value is not None
    assert row.near.value is not None
    assert other.near.value is not None
    ratio, limits = a.value / b.value, None
    if a.standard_error is not None and b.standard_error is not None:
        half = normal_quantile(0.5 + 0.5 * CONFIDENCE) * math.hypot(
            a.standard_error / a.value, b.standard_error / b.value
        )
        limits = (ratio * math.exp(-half), ratio * math.exp(half))
    return Dealing(row.pattern, other.pattern, row.n, (row.near.value, other.near.value), ratio, limits)
