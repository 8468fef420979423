"""Discrepancies of a few points over boxes, in fractions: every candidate is looked at."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import combinations, product
from math import prod

import mpmath

Points = Sequence[tuple[Fraction, ...]]

ONE = Fraction(1)
HALF = Fraction(1, 2)


def star(points: Points) -> Fraction:
    """sup over [0, x) of |n/N - volume|: closed boxes with corners at coordinates, open ones at 1 too."""
    worst = Fraction(0)
    axes = [sorted({point[d] for point in points}) for d in range(len(points[0]))]
    for corner in product(*axes):
        inside = sum(all(p <= c for p, c in zip(point, corner, strict=True)) for point in points)
        worst = max(worst, Fraction(inside, len(points)) - prod(corner))
    for corner in product(*([*axis, ONE] for axis in axes)):
        inside = sum(all(p < c for p, c in zip(point, corner, strict=True)) for point in points)
        worst = max(worst, prod(corner) - Fraction(inside, len(points)))
    return worst


def box(points: Points) -> Fraction:
    """sup over [a, b] x [c, d] of |n/N - area|."""
    worst = Fraction(0)
    axes = [sorted({Fraction(0), ONE, *(point[d] for point in points)}) for d in range(2)]
    pairs = [[(low, high) for low in axis for high in axis if low <= high] for axis in axes]
    for (left, right), (bottom, top) in product(*pairs):
        area = (right - left) * (top - bottom)
        closed = sum(left <= x <= right and bottom <= y <= top for x, y in points)
        inner = sum(left < x < right and bottom < y < top for x, y in points)
        worst = max(worst, Fraction(closed, len(points)) - area, area - Fraction(inner, len(points)))
    return worst


def empty_box(points: Points) -> Fraction:
    """The area of the largest open box without points."""
    axes = [sorted({Fraction(0), ONE, *(point[d] for point in points)}) for d in range(2)]
    pairs = [list(combinations(axis, 2)) for axis in axes]
    return max(
        (
            (right - left) * (top - bottom)
            for (left, right), (bottom, top) in product(*pairs)
            if not any(left < x < right and bottom < y < top for x, y in points)
        ),
        default=Fraction(0),
    )


def t_value(points: Points) -> int:
    """The least t of which 2^m points are a (t, m, s)-net in base 2."""
    m, s = len(points).bit_length() - 1, len(points[0])
    for t in range(m):
        shapes = (shape for shape in product(range(m - t + 1), repeat=s) if sum(shape) == m - t)
        if all(_even(points, shape, 2**t) for shape in shapes):
            return t
    return m


def _even(points: Points, shape: Sequence[int], share: int) -> bool:
    met: dict[tuple[int, ...], int] = {}
    for point in points:
        cell = tuple(int(x * 2**k) for x, k in zip(point, shape, strict=True))
        met[cell] = met.get(cell, 0) + 1
    return len(met) * share == len(points) and set(met.values()) == {share}


# The two functions of each kernel (l2.c names the papers), and the constant.
_Kernel = tuple[Fraction, Callable[[Fraction], Fraction], Callable[[Fraction, Fraction], Fraction]]


def _off(x: Fraction) -> Fraction:
    return abs(x - HALF)


KERNELS: dict[str, _Kernel] = {
    "l2-star": (Fraction(1, 3), lambda x: (1 - x * x) / 2, lambda x, y: 1 - max(x, y)),
    "l2-extreme": (Fraction(1, 12), lambda x: x * (1 - x) / 2, lambda x, y: min(x, y) * (1 - max(x, y))),
    "l2-centered": (
        Fraction(13, 12),
        lambda x: 1 + _off(x) / 2 - _off(x) ** 2 / 2,
        lambda x, y: 1 + (_off(x) + _off(y) - abs(x - y)) / 2,
    ),
    "l2-wrap": (Fraction(4, 3), lambda x: Fraction(4, 3), lambda x, y: Fraction(3, 2) - abs(x - y) * (1 - abs(x - y))),
    "l2-mixture": (
        Fraction(19, 12),
        lambda x: Fraction(5, 3) - _off(x) / 4 - _off(x) ** 2 / 4,
        lambda x, y: Fraction(15, 8) - (_off(x) + _off(y)) / 4 - abs(x - y) * 3 / 4 + abs(x - y) * abs(x - y) / 2,
    ),
    "l2-periodic": (Fraction(1, 3), lambda x: Fraction(1, 3), lambda x, y: HALF - abs(x - y) * (1 - abs(x - y))),
}


def l2_square(name: str, points: Points) -> Fraction:
    """The square of an L2 discrepancy."""
    constant, one, two = KERNELS[name]
    singles, pairs, n = Fraction(0), Fraction(0), len(points)
    met: dict[tuple[Fraction, ...], int] = {}
    for point in points:
        met[point] = met.get(point, 0) + 1
    for point, count in met.items():
        singles += count * prod(map(one, point))
        for other, others in met.items():
            if point <= other:
                pairs += count * others * (1 if point == other else 2) * prod(map(two, point, other))
    return constant ** len(points[0]) - 2 * singles / n + pairs / n**2


def mean_distance_within() -> mpmath.mpf:
    """Of two points in the square."""
    return (2 + mpmath.sqrt(2) + 5 * mpmath.asinh(1)) / 15


def mean_distance_of(x: Fraction, y: Fraction) -> mpmath.mpf:
    """Of the points of the square from one."""
    return mpmath.fsum(_corner(u, v) for u in (x, 1 - x) for v in (y, 1 - y))


def _corner(a: Fraction, b: Fraction) -> mpmath.mpf:
    """The integral of sqrt(u^2 + v^2) over [0, a] x [0, b]."""
    if a == 0 or b == 0:
        return mpmath.mpf(0)
    p, q = (mpmath.mpf(each.numerator) / each.denominator for each in (a, b))
    return p * q * mpmath.hypot(p, q) / 3 + (p**3 * mpmath.asinh(q / p) + q**3 * mpmath.asinh(p / q)) / 6


def edge_rms_square(points: Points) -> mpmath.mpf:
    """The square of the discrepancy of isotropic edges, as an energy distance (edge_rms.c)."""
    n = len(points)
    met: dict[tuple[Fraction, ...], int] = {}
    for point in points:
        met[point] = met.get(point, 0) + 1
    places = [(tuple(mpmath.mpf(v.numerator) / v.denominator for v in point), count) for point, count in met.items()]
    near = mpmath.fsum(count * mean_distance_of(*point) for point, count in met.items())
    apart = mpmath.fsum(
        count * others * mpmath.hypot(p[0] - q[0], p[1] - q[1]) for (p, count), (q, others) in combinations(places, 2)
    )
    return (2 * near / n - 2 * apart / n**2 - mean_distance_within()) / 4
