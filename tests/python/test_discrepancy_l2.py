"""The L2 discrepancies against SciPy, against their definitions in exact fractions, and their symmetries."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, pairwise, product

import numpy as np
import pytest
from discrepancy_sets import EXTREMES, SYMMETRIES, Points, hammersley, small_sets
from numpy.typing import NDArray
from scipy.stats import qmc

from aliascope.native import samplers
from aliascope.native.discrepancy import measure

NAMES = ["l2-star", "l2-extreme", "l2-centered", "l2-wrap", "l2-mixture", "l2-periodic"]
SCIPYS: dict[str, Callable[[Points], float]] = {
    "l2-star": lambda points: float(qmc.discrepancy(points, method="L2-star")),
    "l2-centered": lambda points: math.sqrt(qmc.discrepancy(points, method="CD")),
    "l2-wrap": lambda points: math.sqrt(qmc.discrepancy(points, method="WD")),
    "l2-mixture": lambda points: math.sqrt(qmc.discrepancy(points, method="MD")),
}


@pytest.mark.parametrize("name", SCIPYS)
@pytest.mark.parametrize(("n", "dimensions"), [(1, 1), (7, 1), (255, 2), (256, 2), (257, 2), (700, 3), (60, 12)])
def test_scipys(name: str, n: int, dimensions: int) -> None:
    rng = np.random.default_rng(n)
    for points in (rng.random((n, dimensions)), samplers.points("halton", n, dimensions), rng.random((n, 2))[:, :1]):
        # The square is a difference of terms near 1. SciPy adds n^2 products one by one in double: n^2 half ulps.
        rounding = 2e-13 + 1.1e-16 * n**2
        assert measure(name, points).value ** 2 == pytest.approx(SCIPYS[name](points) ** 2, rel=1e-12, abs=rounding)


# Definitions. A family of intervals in one dimension falls into pieces in each of which an interval contains the same
# points; of a piece: its share of the family, and the integrals over it of the interval's length and its square.


@dataclass(frozen=True)
class Piece:
    share: Fraction
    length: Fraction
    square: Fraction
    holds: tuple[bool, ...]  # of each point


def integrals(low: Fraction, high: Fraction) -> tuple[Fraction, Fraction, Fraction]:
    """Of 1, t and t^2 over [low, high]."""
    return high - low, (high**2 - low**2) / 2, (high**3 - low**3) / 3


def pieces_from_a_corner(values: list[Fraction], below_half: bool, above_half: bool) -> list[Piece]:
    """Intervals between t and a corner, t uniform: [0, t) where it is True for t's half of [0, 1], else [t, 1]."""
    ends = sorted({Fraction(0), Fraction(1, 2), Fraction(1), *values})
    found = []
    for low, high in pairwise(ends):
        middle = (low + high) / 2
        from_origin = below_half if high <= Fraction(1, 2) else above_half
        span = integrals(low, high) if from_origin else integrals(1 - high, 1 - low)
        found.append(Piece(*span, tuple((value < middle) == from_origin for value in values)))
    return found


def pieces_between(values: list[Fraction], wrapped: bool) -> list[Piece]:
    """Intervals [s, t) for s < t, s and t uniform; if `wrapped`, for s > t [s, 1] with [0, t) too."""
    ends = sorted({Fraction(0), Fraction(1), *values})
    spans = list(pairwise(ends))
    found = []
    for (a, b), (c, d) in product(spans, spans):
        s, t = (a + b) / 2, (c + d) / 2
        if (a, b) == (c, d):  # a triangle each way, of lengths up to b - a
            side = b - a
            share, length, square = side**2 / 2, side**3 / 6, side**4 / 12
            found.append(Piece(share, length, square, (False,) * len(values)))
            if wrapped:
                found.append(Piece(share, share - length, share - 2 * length + square, (True,) * len(values)))
            continue
        if s > t and not wrapped:
            continue
        ((s0, s1, s2), (t0, t1, t2)) = integrals(a, b), integrals(c, d)
        share, length, square = s0 * t0, s0 * t1 - s1 * t0, s0 * t2 - 2 * s1 * t1 + s2 * t0
        if s > t:  # the length is 1 + (t - s)
            length, square = share + length, share + 2 * length + square
            found.append(Piece(share, length, square, tuple(v > s or v < t for v in values)))
        else:
            found.append(Piece(share, length, square, tuple(s < v < t for v in values)))
    return found


def half(pieces: list[Piece]) -> list[Piece]:
    return [Piece(p.share / 2, p.length / 2, p.square / 2, p.holds) for p in pieces]


def pieces(name: str, values: list[Fraction]) -> list[Piece]:
    if name == "l2-star":
        return pieces_from_a_corner(values, below_half=True, above_half=True)
    if name == "l2-extreme":
        return pieces_between(values, wrapped=False)
    if name == "l2-centered":  # from the nearest corner
        return pieces_from_a_corner(values, below_half=True, above_half=False)
    if name in ("l2-wrap", "l2-periodic"):
        return pieces_between(values, wrapped=True)
    # Mixture: half from the farther corner, half wrapped
    return half(pieces_from_a_corner(values, below_half=False, above_half=True)) + half(pieces_between(values, True))


# What a dimension that a projection leaves out counts; 0: there is no projection but the whole.
LEFT_OUT = {
    "l2-star": Fraction(0),
    "l2-extreme": Fraction(0),
    "l2-periodic": Fraction(0),
    "l2-centered": Fraction(1),
    "l2-wrap": Fraction(1),
    "l2-mixture": Fraction(9, 8),
}


def square_in_fractions(name: str, points: Points) -> Fraction:
    """The integral of (n/N - volume)^2 over all products of intervals, summed over projections."""
    n, dimensions = points.shape
    by_dimension = [pieces(name, [Fraction(value) for value in column.tolist()]) for column in points.T]
    total = Fraction(0)
    for size in range(1, dimensions + 1):
        weight = LEFT_OUT[name] ** (dimensions - size)
        for chosen in combinations(by_dimension, size) if weight else ():
            for box in product(*chosen):
                count = Fraction(sum(all(flags) for flags in zip(*(p.holds for p in box), strict=True)), n)
                share, length, square = (
                    math.prod((getattr(p, what) for p in box), start=Fraction(1))
                    for what in ("share", "length", "square")
                )
                total += weight * (count**2 * share - 2 * count * length + square)
    return total


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("dimensions", "sets", "most"), [(1, 60, 7), (2, 40, 3), (3, 12, 1)])
def test_definitions(name: str, dimensions: int, sets: int, most: int) -> None:
    for points in small_sets(sets, dimensions, most, seed=dimensions):
        expected = math.sqrt(square_in_fractions(name, points))
        # A square of at least 0.01 is a difference of terms up to 4, products of which are rounded to double.
        assert measure(name, points).value == pytest.approx(expected, rel=1e-13, abs=0), points.tolist()


def kernel_in_fractions(name: str, points: Points) -> Fraction:
    """The formulas of the publications; `test_definitions` has where they come from."""
    h = Fraction(1, 2)
    first = {"l2-star": (1, 3), "l2-extreme": (1, 12), "l2-centered": (13, 12)}
    first |= {"l2-wrap": (4, 3), "l2-mixture": (19, 12), "l2-periodic": (1, 3)}
    constant = Fraction(*first[name])
    one: dict[str, Callable[[Fraction], Fraction]] = {
        "l2-star": lambda x: (1 - x * x) / 2,
        "l2-extreme": lambda x: x * (1 - x) / 2,
        "l2-centered": lambda x: 1 + abs(x - h) / 2 - abs(x - h) ** 2 / 2,
        "l2-mixture": lambda x: Fraction(5, 3) - abs(x - h) / 4 - abs(x - h) ** 2 / 4,
        "l2-wrap": lambda x: constant,
        "l2-periodic": lambda x: constant,
    }
    two: dict[str, Callable[[Fraction, Fraction], Fraction]] = {
        "l2-star": lambda x, y: 1 - max(x, y),
        "l2-extreme": lambda x, y: min(x, y) - x * y,
        "l2-centered": lambda x, y: 1 + (abs(x - h) + abs(y - h) - abs(x - y)) / 2,
        "l2-mixture": lambda x, y: (
            Fraction(15, 8) - (abs(x - h) + abs(y - h)) / 4 - abs(x - y) * 3 / 4 + abs(x - y) ** 2 / 2
        ),
        "l2-wrap": lambda x, y: Fraction(3, 2) - abs(x - y) + abs(x - y) ** 2,
        "l2-periodic": lambda x, y: h - abs(x - y) + abs(x - y) ** 2,
    }
    n, dimensions = points.shape
    exact = [[Fraction(value) for value in row] for row in points.tolist()]
    singles = sum(math.prod((one[name](x) for x in row), start=Fraction(1)) for row in exact)
    pairs = sum(
        math.prod((two[name](x, y) for x, y in zip(row, other, strict=True)), start=Fraction(1))
        for row in exact
        for other in exact
    )
    return constant**dimensions - 2 * Fraction(singles) / n + Fraction(pairs) / n**2


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("dimensions", "sets", "most"), [(1, 60, 12), (2, 120, 9), (3, 60, 6), (5, 30, 4)])
def test_formulas(name: str, dimensions: int, sets: int, most: int) -> None:
    for points in small_sets(sets, min(dimensions, 4), most, seed=70 + dimensions):
        given = np.hstack([points, points[:, :1] / 2]) if dimensions > 4 else points
        expected = math.sqrt(kernel_in_fractions(name, given))
        assert measure(name, given).value == pytest.approx(expected, rel=1e-12, abs=0), given.tolist()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("extreme", EXTREMES)
def test_extremes(name: str, extreme: str) -> None:
    points = EXTREMES[extreme]
    for given in (points, points[:, :1], np.hstack([points, points])):
        expected = math.sqrt(kernel_in_fractions(name, given))
        found = measure(name, given)
        assert found.value == pytest.approx(expected, rel=1e-12, abs=0)
        assert (found.certainty, found.lower, found.upper) == ("exact", found.value, found.value)


def test_one_point_by_hand() -> None:
    """In the middle of [0, 1]: the integral of t^2 from 0 to 1/2, and of (1 - t)^2 from there."""
    assert measure("l2-star", [[0.5]]).value == pytest.approx(math.sqrt(1 / 12), rel=1e-15, abs=0)
    assert measure("l2-star", [[0.0]]).value == pytest.approx(math.sqrt(1 / 3), rel=1e-15, abs=0)


WholeNumbers = NDArray[np.int32]


def square_of_a_lattice(name: str, points: Points) -> Fraction:
    """The same formulas for points (n, 2) that are whole multiples of 1/n, n a power of two up to 4096: in whole
    numbers, of 31 bits for the terms, 63 for some products, and any number for their sums."""
    n = len(points)
    whole = np.rint(points * n).astype(np.int32)
    assert (whole == points * n).all()
    off = np.abs(2 * whole - n)  # |x - 1/2| in units of 1 / 2n
    first, one_unit, one, two_unit, two = FORMULAS[name]
    singles = sum(math.prod(row) for row in one(whole, off, n).tolist())
    pairs, block = 0, 256
    for start in range(0, n, block):  # pairs of equal blocks once, the others twice
        rows = slice(start, start + block)
        terms = [two(whole[rows, None, d], whole[start:, d], off[rows, None, d] + off[start:, d], n) for d in (0, 1)]
        assert max(abs(term).max() for term in terms) < 2**28  # so 64 products are below 2^62
        sums = (terms[0].astype(np.int64) * terms[1]).reshape(block, -1, 64).sum(axis=2)
        pairs += 2 * sum(sums.ravel().tolist()) - sum(sums[:, : block // 64].ravel().tolist())
    return first**2 - Fraction(2 * singles, n * (one_unit * n**2) ** 2) + Fraction(pairs, (n * two_unit * n**2) ** 2)


# The first term; the others as whole numbers, in units of 1 / (unit n^2).
Formula = tuple[Fraction, int, Callable[..., WholeNumbers], int, Callable[..., WholeNumbers]]
FORMULAS: dict[str, Formula] = {
    "l2-star": (
        Fraction(1, 3),
        2,
        lambda x, off, n: n * n - x * x,
        1,
        lambda x, y, offs, n: n * (n - np.maximum(x, y)),
    ),
    "l2-extreme": (
        Fraction(1, 12),
        2,
        lambda x, off, n: x * (n - x),
        1,
        lambda x, y, offs, n: np.minimum(x, y) * (n - np.maximum(x, y)),
    ),
    "l2-centered": (
        Fraction(13, 12),
        8,
        lambda x, off, n: 8 * n * n + 2 * off * n - off * off,
        4,
        lambda x, y, offs, n: 4 * n * n + n * (offs - 2 * np.abs(x - y)),
    ),
    "l2-wrap": (
        Fraction(4, 3),
        3,
        lambda x, off, n: 4 * n * n + 0 * x,
        2,
        lambda x, y, offs, n: 3 * n * n - 2 * np.abs(x - y) * (n - np.abs(x - y)),
    ),
    "l2-mixture": (
        Fraction(19, 12),
        48,
        lambda x, off, n: 80 * n * n - 6 * off * n - 3 * off * off,
        8,
        lambda x, y, offs, n: 15 * n * n - n * (offs + 6 * np.abs(x - y)) + 4 * (x - y) ** 2,
    ),
    "l2-periodic": (
        Fraction(1, 3),
        3,
        lambda x, off, n: n * n + 0 * x,
        2,
        lambda x, y, offs, n: n * n - 2 * np.abs(x - y) * (n - np.abs(x - y)),
    ),
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("n", [1024, 4096])
def test_no_digits_are_lost_at_many_points(name: str, n: int) -> None:
    """The square is 1e-8 to 1e-6 of the terms near 1 that it is the difference of. Products are rounded to double, by
    1e-16, and those of a lattice are much alike, so that not all of it averages out: half of that is allowed, which
    leaves 9 digits of the square. Plain sums in double leave ten times as much of l2-mixture's and l2-wrap's."""
    points = hammersley(n)
    square = float(square_of_a_lattice(name, points))
    assert square < 1e-4
    assert measure(name, points).value ** 2 == pytest.approx(square, rel=1e-14, abs=5e-17)


@pytest.mark.parametrize("name", NAMES)
def test_symmetries(name: str) -> None:
    """All eight of the square, but l2-star's boxes start at the origin: of its symmetries there is the swap alone."""
    rng = np.random.default_rng(3)
    points = rng.integers(0, 2**20, (50, 2)) / 2**20  # 1 - x is exact
    expected = measure(name, points).value
    for symmetry, change in SYMMETRIES.items():
        value = measure(name, change(points)).value
        if name != "l2-star" or symmetry in ("identity", "swap"):
            assert value == pytest.approx(expected, rel=1e-13, abs=0), symmetry
        else:
            assert value != pytest.approx(expected, rel=1e-3), symmetry


@pytest.mark.parametrize("name", ["l2-wrap", "l2-periodic"])
def test_wrapped_ones_do_not_see_a_shift(name: str) -> None:
    rng = np.random.default_rng(4)
    points = rng.integers(0, 2**20, (50, 3)) / 2**20
    shifted = (points + np.array([0.25, 0.5, 0.8125])) % 1.0
    assert measure(name, shifted).value == pytest.approx(measure(name, points).value, rel=1e-13, abs=0)
