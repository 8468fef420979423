"""Point sets at their extremes: each a function of one level, made of doubles."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

Table = list[tuple[float, float]]

LAST = math.nextafter(1.0, 0.0)


def coincident(at: float) -> Table:
    """All at one place."""
    return [(0.3, 0.7)] * int(at)


def close(at: float) -> Table:
    """Pairs and threes at that distance from each other, near the origin so that it can be any."""
    return [
        (0.0, 0.0),
        (at, 0.0),
        (0.0, at),
        (0.5, 0.5),
        (0.5, 0.5 + at),
        (0.8, 0.3),
        (2.3 * at, 1.7 * at),
        (3.0 * at, 0.4),
    ]


def collinear(at: float) -> Table:
    """On a line that rounding bends, the first ones on a diagonal."""
    n = int(at)
    along = [(i + 0.5) / n for i in range(n)]
    return [(x, x) if i < n // 2 else (x, 0.25 + x / 3.0) for i, x in enumerate(along)]


def border(at: float) -> Table:
    """So far from the border, on it, and at the last double below 1."""
    far = 1.0 - at
    return [(0.0, 0.0), (LAST, LAST), (at, far), (0.5, at), (0.0, 0.4), (far, 0.7), (0.3, LAST), (1e-9, 0.2)]


def torus(at: float) -> Table:
    """Two on either side of the border, others far."""
    return [(at, 0.5), (LAST, 0.5), (0.3, 0.1), (0.6, 0.9)]


def axis_lines(at: float) -> Table:
    """On lines of that slope: one near the border, where it is kept, one in the middle, where doubles round it; and the
    same upright."""
    lying = [(0.125, at), (0.875, 7.0 * at), (0.25, 0.375), (0.75, 0.375 + 0.5 * at)]
    return lying + [(y, x) for x, y in lying]


def few(at: float) -> Table:
    return [(0.3, 0.7), (0.9, 0.05), (0.45, 0.31), (0.11, 0.13)][: int(at)]


def grid(at: float) -> Table:
    """The middles of k x k cells."""
    k = math.isqrt(int(at))
    return [((i + 0.5) / k, (j + 0.5) / k) for j in range(k) for i in range(k)]


SETS: Mapping[str, Callable[[float], Table]] = {
    "coincident": coincident,
    "close": close,
    "collinear": collinear,
    "border": border,
    "axis-lines": axis_lines,
    "few-points": few,
    "grid": grid,
}

LEVELS: Mapping[str, tuple[float, ...]] = {
    "coincident": (2.0, 16.0, 128.0, 1024.0),
    "close": (1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 1e-30, 1e-100, 1e-300),
    "collinear": (2.0, 3.0, 6.0, 10.0),
    "border": (1e-3, 1e-9, 1e-15, 1e-17, 1e-30, 1e-100, 1e-300, 0.0),
    "axis-lines": (1e-1, 1e-4, 1e-8, 1e-12, 1e-15, 1e-18, 1e-30, 1e-100, 1e-300),
    "few-points": (4.0, 3.0, 2.0, 1.0),
    "grid": (1.0, 4.0, 9.0, 16.0),
}
