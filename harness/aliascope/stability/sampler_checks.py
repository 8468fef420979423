"""What holds of a pattern's points by its definition, held against the very doubles that the library gives.

Each check takes a `Drawn` and gives an error: of patterns that have no randomness the distance from the definition, of
others the share of points that lie where the definition has none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from math import isqrt

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from aliascope.native import samplers
from aliascope.stability.sampler_definitions import Definition, as_stored, fibonacci, primes, strata

PIXEL = (3, 5)
SEED = 7
MOST_EXACT = 256
"""Points that are held against fractions: of more the first and the last."""


@dataclass(frozen=True)
class Drawn:
    """Points [first, first + len(points)) of N, (count, dimensions)."""

    spec: str
    n: int
    first: int
    points: NDArray[np.float64]

    @property
    def dimensions(self) -> int:
        return int(self.points.shape[1])

    def column(self, dimension: int) -> list[float]:
        return [float(value) for value in self.points[:, dimension]]


Check = Callable[[Drawn], float]


def draw(spec: str, n: int, dimensions: int, first: int, count: int) -> Drawn:
    return Drawn(spec, n, first, samplers.Sampler(spec, n, dimensions, SEED).points(count, first, PIXEL))


def error_of(drawn: Drawn, check: Check) -> float:
    """That of the check; infinite where a point is none, or is another when it is asked for by itself."""
    points = drawn.points
    if not (np.isfinite(points).all() and (points >= 0.0).all() and (points.astype(np.float32) < 1.0).all()):
        return math.inf
    last = draw(drawn.spec, drawn.n, drawn.dimensions, drawn.first + len(points) - 1, 1)
    return check(drawn) if np.array_equal(last.points[0], points[-1]) else math.inf


def defined(definition: Definition) -> Check:
    """The largest distance of a coordinate from its definition."""

    def check(drawn: Drawn) -> float:
        count = len(drawn.points)
        rows = (
            range(count) if count <= MOST_EXACT else (*range(MOST_EXACT // 2), *range(count - MOST_EXACT // 2, count))
        )
        return max(
            float(abs(Fraction(float(value)) - as_stored(truth)))
            for row in rows
            for value, truth in zip(
                drawn.points[row], definition(drawn.n, drawn.dimensions, drawn.first + row), strict=True
            )
        )

    return check


def rank_one(drawn: Drawn) -> float:
    """A lattice: in two dimensions Fibonacci's; in more, point i is i times point 1, modulo 1, in N-ths prime to N."""
    n = drawn.n
    if drawn.dimensions <= 2:
        return defined(lambda *of: fibonacci(*of)[: drawn.dimensions])(drawn)
    step = [round(Fraction(float(value)) * n) for value in draw(drawn.spec, n, drawn.dimensions, 1, 1).points[0]]
    if any(math.gcd(each, n) != 1 for each in step):
        return 1.0
    return defined(lambda n, _, index: [Fraction(index * each % n, n) for each in step])(drawn)


def multiples(denominator: int) -> Check:
    """Points of hardware's grids: the largest distance from the grid; 1 where two are the same."""

    def check(drawn: Drawn) -> float:
        if len(np.unique(drawn.points, axis=0)) < len(drawn.points):
            return 1.0
        return float(np.abs(drawn.points * denominator - np.round(drawn.points * denominator)).max()) / denominator

    return check


Strata = Iterable[tuple[tuple[int, ...], tuple[int, ...]]]
"""Dimensions, and into how many equal parts each is cut: at most one point lies in each cell that this makes."""


def _misplaced(drawn: Drawn, cut: Strata) -> int:
    """Of the worst of the cuts, points that share their cell."""
    numbers: dict[tuple[int, int], list[int]] = {}

    def of(dimension: int, parts: int) -> list[int]:
        key = (dimension, parts)
        if key not in numbers:
            numbers[key] = strata(drawn.column(dimension), parts)
        return numbers[key]

    count = len(drawn.points)
    return max(
        count - len(set(zip(*(of(*one) for one in zip(dimensions, parts, strict=True)), strict=True)))
        for dimensions, parts in cut
    )


def stratified(cut: Callable[[int, int], Strata]) -> Check:
    """`cut` gives those of N points in so many dimensions."""
    return lambda drawn: _misplaced(drawn, cut(drawn.n, drawn.dimensions)) / len(drawn.points)


def in_each_axis(n: int, dimensions: int) -> Strata:
    """As rooks stand."""
    return (((dimension,), (n,)) for dimension in range(dimensions))


def in_pairs(n: int, dimensions: int) -> Strata:
    """A square grid of N cells in dimensions (0,1), (2,3), ...; a last one by itself has N parts."""
    k = isqrt(n)
    for first in range(0, dimensions, 2):
        yield ((first, first + 1), (k, k)) if first + 1 < dimensions else ((first,), (n,))


def in_pairs_and_axes(n: int, dimensions: int) -> Strata:
    """Both, the pairs where N is a square."""
    yield from in_each_axis(n, dimensions)
    if isqrt(n) ** 2 == n:
        yield from in_pairs(n, dimensions)


def in_all_pairs(n: int, dimensions: int) -> Strata:
    """As an orthogonal array of strength 2."""
    return ((pair, (isqrt(n), isqrt(n))) for pair in combinations(range(dimensions), 2))


def in_space_and_time(n: int, _: int) -> Strata:
    return (((0, 1), (isqrt(n), isqrt(n))), ((2,), (n,)))


def latin(n: int, dimensions: int) -> Strata:
    """In three dimensions the whole square."""
    return in_all_pairs(n, 3) if dimensions == 3 else in_each_axis(n, dimensions)


def _aligned(drawn: Drawn, size: int) -> Iterator[Drawn]:
    """The last block of `size` points from a multiple of it, where these points have one."""
    begin = (drawn.first + len(drawn.points)) // size * size - size
    if begin >= drawn.first:
        rows = slice(begin - drawn.first, begin - drawn.first + size)
        yield Drawn(drawn.spec, drawn.n, begin, drawn.points[rows])


def _powers_up_to(base: int, most: int) -> Iterator[int]:
    power = base
    while power <= most:
        yield power
        power *= base


def digital(first: int) -> Check:
    """Dimensions from `first` on in the primes as bases: b^m points from a multiple of b^m have one in each b^m-th."""

    def check(drawn: Drawn) -> float:
        worst = 0.0
        for dimension, base in zip(
            range(first, drawn.dimensions), primes(max(drawn.dimensions - first, 1)), strict=False
        ):
            for size in _powers_up_to(base, len(drawn.points)):
                for block in _aligned(drawn, size):
                    worst = max(worst, _misplaced(block, [((dimension,), (size,))]) / size)
        return worst

    return check


def net(drawn: Drawn) -> float:
    """In each dimension 2^m points from a multiple of 2^m have one in each 2^m-th; the first two dimensions are a
    (0, 2)-sequence: one in each elementary interval."""
    worst = 0.0
    for size in _powers_up_to(2, len(drawn.points)):
        for block in _aligned(drawn, size):
            cut: list[tuple[tuple[int, ...], tuple[int, ...]]] = [
                ((dimension,), (size,)) for dimension in range(drawn.dimensions)
            ]
            if drawn.dimensions > 1:
                cut += [((0, 1), (1 << a, size >> a)) for a in range(size.bit_length())]
            worst = max(worst, _misplaced(block, cut) / size)
    return worst


def net_in_pairs(drawn: Drawn) -> float:
    """Each pair of dimensions by itself is such a net, in an order of its own: as many points as a power of two."""
    worst = 0.0
    for first in range(0, drawn.dimensions, 2):
        pair = Drawn(drawn.spec, drawn.n, drawn.first, drawn.points[:, first : first + 2])
        worst = max(worst, net(pair))
    return worst


def moved(definition: Definition) -> Check:
    """All are moved by one vector, modulo 1: how far that of the first point is from that of each other."""

    def check(drawn: Drawn) -> float:
        origin = draw(drawn.spec, drawn.n, drawn.dimensions, 0, 1).points[0]
        start = definition(drawn.n, drawn.dimensions, 0)
        by = [Fraction(float(value)) - truth for value, truth in zip(origin, start, strict=True)]

        def truth(n: int, dimensions: int, index: int) -> list[Fraction]:
            return [(value + shift) % 1 for value, shift in zip(definition(n, dimensions, index), by, strict=True)]

        return defined(truth)(drawn)

    return check


def unrepeated(drawn: Drawn) -> float:
    """Random: no point is one of those that a shorter counter would have taken its index for, and none comes twice;
    means and variances within six of their standard deviations (2e-9 each)."""
    values = drawn.points.ravel()
    count = len(values)
    if len(np.unique(values)) < count - 1:  # of 32 bits: two alike in 10^4 have a probability of 1 %
        return 1.0
    last = drawn.first + len(drawn.points) - 1
    for bits in (8, 16, 24, 31, 32):
        if last >> bits:
            short = draw(drawn.spec, drawn.n, drawn.dimensions, last % (1 << bits), 1).points[0]
            if np.array_equal(short, drawn.points[-1]):
                return 1.0
    if count >= 100:
        mean, square = abs(values.mean() - 0.5), abs(((values - 0.5) ** 2).mean() - 1 / 12)
        if mean > 6 / math.sqrt(12 * count) or square > 6 * math.sqrt(1 / 180 / count):
            return 1.0
    return 0.0


def apart(least: float) -> Check:
    """Whether all points, which must be all N, keep `least` of the largest distance that N can, on the torus; 1 where
    two are the same, in parts of that distance else."""

    def check(drawn: Drawn) -> float:
        worst = 0.0
        for first in range(0, drawn.dimensions - 1, 2):
            pair = drawn.points[:, first : first + 2]
            if len(pair) < 2:
                continue
            largest = math.sqrt(2 / (math.sqrt(3) * drawn.n))
            nearest = float(np.asarray(cKDTree(pair, boxsize=np.ones(2)).query(pair, k=2)[0])[:, 1].min())
            if nearest == 0.0:
                return 1.0
            worst = max(worst, least - nearest / largest)
        return worst if worst > 1e-12 else 0.0  # the tree's own roundings

    return check


def as_one_by_one(drawn: Drawn) -> float:
    """A sequence whose points depend on those before: each is the same whatever else is asked for; the largest
    difference."""
    rows: Sequence[int] = range(0, len(drawn.points), max(1, len(drawn.points) // 4))
    alone = [draw(drawn.spec, drawn.n, drawn.dimensions, drawn.first + row, 1).points[0] for row in rows]
    return max(float(np.abs(drawn.points[row] - one).max()) for row, one in zip(rows, alone, strict=True))
