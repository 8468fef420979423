"""What pixels hold of a convex polygon: exactly, in fractions, and as a grid of exact samples finds it.

Places are in pixels from the left and top border of the picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from aliascope.geometry import Array

Point = tuple[Fraction, Fraction]


def coverage(polygon: Sequence[Point], size: tuple[int, int]) -> Array:
    """The share of each pixel that lies within a convex polygon, (height, width) float64: rounded once, at the end."""
    width, height = size
    corners = _counter_clockwise(polygon)
    shares = np.zeros((height, width))
    for y in range(height):
        row = _cut(corners, Fraction(0), Fraction(1), Fraction(-y))
        row = _cut(row, Fraction(0), Fraction(-1), Fraction(y + 1))
        if not row:
            continue
        least, most = min(x for x, _ in row), max(x for x, _ in row)
        for x in range(max(0, int(least // 1)), min(width, int(-(-most // 1)))):
            pixel = _cut(row, Fraction(1), Fraction(0), Fraction(-x))
            pixel = _cut(pixel, Fraction(-1), Fraction(0), Fraction(x + 1))
            shares[y, x] = float(_area(pixel))
    return shares


def samples(polygon: Sequence[Point], size: tuple[int, int], side: int) -> Array:
    """The share of side x side samples of each pixel, at the middles of its cells, within a convex polygon."""
    width, height = size
    corners = _counter_clockwise(polygon)
    inside = np.ones((height * side, width * side), dtype=bool)
    x = (np.arange(width * side, dtype=np.longdouble) + 0.5) / side
    y = ((np.arange(height * side, dtype=np.longdouble) + 0.5) / side)[:, np.newaxis]
    for (ax, ay), (bx, by) in zip(corners, (*corners[1:], corners[0]), strict=True):
        a, b = ay - by, bx - ax
        inside &= _long(a) * x + _long(b) * y - _long(a * ax + b * ay) >= 0.0
    return np.asarray(inside.reshape(height, side, width, side).mean(axis=(1, 3)))


def _long(value: Fraction) -> np.longdouble:
    """To 2^-63 of itself: the rest of a double's rounding is a double's own."""
    first = float(value)
    return np.longdouble(first) + np.longdouble(float(value - Fraction(first)))


def _counter_clockwise(polygon: Sequence[Point]) -> list[Point]:
    """With the inside where a x + b y - c is positive: see `samples`."""
    return list(polygon) if _signed(polygon) > 0 else list(polygon)[::-1]


def _signed(polygon: Sequence[Point]) -> Fraction:
    """Twice the area, negative the other way round."""
    following = (*polygon[1:], *polygon[:1])
    return sum((ax * by - bx * ay for (ax, ay), (bx, by) in zip(polygon, following, strict=True)), Fraction(0))


def _area(polygon: Sequence[Point]) -> Fraction:
    return abs(_signed(polygon)) / 2


def _cut(polygon: Sequence[Point], a: Fraction, b: Fraction, c: Fraction) -> list[Point]:
    """The part of a convex polygon with a x + b y + c >= 0 (Sutherland and Hodgman 1974)."""
    kept: list[Point] = []
    for here, after in zip(polygon, (*polygon[1:], *polygon[:1]), strict=True):
        by, after_by = (a * x + b * y + c for x, y in (here, after))
        if by >= 0:
            kept.append(here)
        if (by > 0 > after_by) or (by < 0 < after_by):
            t = by / (by - after_by)
            kept.append((here[0] + t * (after[0] - here[0]), here[1] + t * (after[1] - here[1])))
    return kept
