"""Discrepancies of many points, in whole numbers: the same sums as of few, over arrays of Python's."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

from aliascope.stability.exact.boxes import mean_distance_of, mean_distance_within

Whole = NDArray[Any]
"""Of Python's integers, which have no last digit."""

BITS = 72
"""Coordinates are multiples of 2^-72: those of doubles from 2^-20 on are."""
UNIT = 1 << BITS
ROOT_BITS = 40
"""More, of a root of whole numbers."""


def lattice(count: int) -> NDArray[np.float64]:
    """Fibonacci's lattice in the middles of cells, (count, 2), for a Fibonacci number: even, and of few differences,
    so that roundings repeat."""
    before, last = 1, 1
    while last < count:
        before, last = last, before + last
    if last != count:
        raise ValueError(f"{count} is no Fibonacci number")
    numbers = np.arange(count)
    return np.stack([(numbers + 0.5) / count, (numbers * before % count + 0.5) / count], axis=1)


def whole_numbers(points: NDArray[np.float64]) -> Whole:
    """In UNITs. Raises ValueError for coordinates that are no multiples."""
    made = np.array([[Fraction(float(value)) * UNIT for value in row] for row in points], dtype=object)
    if any(value.denominator != 1 for value in made.ravel()):
        raise ValueError(f"coordinates are multiples of 2^-{BITS}")
    return np.array([[int(value) for value in row] for row in made], dtype=object)


def _off(x: Whole) -> Whole:
    found: Whole = abs(x - UNIT // 2)
    return found


def _around(x: Whole, y: Whole) -> Whole:
    apart = abs(x - y)
    found: Whole = apart * (UNIT - apart)
    return found


def _mixture(x: Whole, y: Whole) -> Whole:
    apart = abs(x - y)
    found: Whole = 15 * UNIT**2 - 2 * UNIT * (_off(x) + _off(y)) - 6 * UNIT * apart + 4 * apart * apart
    return found


_Two = Callable[[Whole, Whole], Whole]
_One = Callable[[Whole], Whole]

KERNELS: dict[str, tuple[Fraction, int, _One, int, _Two]] = {
    "l2-star": (Fraction(1, 3), 2 * UNIT**2, lambda x: UNIT**2 - x * x, UNIT, lambda x, y: UNIT - np.maximum(x, y)),
    "l2-extreme": (
        Fraction(1, 12),
        2 * UNIT**2,
        lambda x: x * (UNIT - x),
        UNIT**2,
        lambda x, y: np.minimum(x, y) * (UNIT - np.maximum(x, y)),
    ),
    "l2-centered": (
        Fraction(13, 12),
        2 * UNIT**2,
        lambda x: 2 * UNIT**2 + _off(x) * UNIT - _off(x) ** 2,
        2 * UNIT,
        lambda x, y: 2 * UNIT + _off(x) + _off(y) - abs(x - y),
    ),
    "l2-wrap": (Fraction(4, 3), 3, lambda x: 4 + 0 * x, 2 * UNIT**2, lambda x, y: 3 * UNIT**2 - 2 * _around(x, y)),
    "l2-mixture": (
        Fraction(19, 12),
        12 * UNIT**2,
        lambda x: 20 * UNIT**2 - 3 * _off(x) * UNIT - 3 * _off(x) ** 2,
        8 * UNIT**2,
        _mixture,
    ),
    "l2-periodic": (Fraction(1, 3), 3, lambda x: 1 + 0 * x, 2 * UNIT**2, lambda x, y: UNIT**2 - 2 * _around(x, y)),
}
"""The constant, and the two functions with what they are over (l2.c names the papers)."""


def _rows(points: Whole) -> Iterator[tuple[Whole, Whole]]:
    """Each point with all that follow it."""
    for i in range(len(points)):
        yield points[i], points[i + 1 :]


def l2_square(name: str, points: NDArray[np.float64]) -> Fraction:
    """The square of an L2 discrepancy in two dimensions."""
    constant, one_unit, one, two_unit, two = KERNELS[name]
    at = whole_numbers(points)
    singles = int((one(at[:, 0]) * one(at[:, 1])).sum())
    pairs = int((two(at[:, 0], at[:, 0]) * two(at[:, 1], at[:, 1])).sum())
    for own, others in _rows(at):
        if len(others):
            pairs += 2 * int((two(own[0], others[:, 0]) * two(own[1], others[:, 1])).sum())
    n = len(points)
    return constant**2 - Fraction(2 * singles, n * one_unit**2) + Fraction(pairs, (n * two_unit) ** 2)


_root = np.frompyfunc(math.isqrt, 1, 1)


def edge_rms_square(points: NDArray[np.float64]) -> mpmath.mpf:
    """The square of the discrepancy of isotropic edges: distances to 2^-112, the other terms in mpmath."""
    at = whole_numbers(points)
    pairs = 0
    for own, others in _rows(at):
        if len(others):
            square = (others[:, 0] - own[0]) ** 2 + (others[:, 1] - own[1]) ** 2
            pairs += int(_root(square << 2 * ROOT_BITS).sum())
    n = len(points)
    near = mpmath.fsum(mean_distance_of(Fraction(x), Fraction(y)) for x, y in points.tolist())
    apart = mpmath.ldexp(mpmath.mpf(pairs), -BITS - ROOT_BITS)
    return (2 * near / n - 2 * apart / n**2 - mean_distance_within()) / 4
