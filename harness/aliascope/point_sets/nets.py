"""The quality parameter t of nets."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput, Unsupported
from aliascope.point_sets.arrays import Points, checked

MOST_WORK = 2_000_000_000
"""The most counts of a point in an interval that `t_value` begins with: about 10 seconds."""


def t_value(points: Any, base: int = 2) -> int:
    """The least t for which the points (n, s) are a (t, m, s)-net in a base, n = base^m. From 0, the best, to m.

    A (t, m, s)-net has base^t points in each elementary interval of volume base^(t - m), of every shape: base^-k_1 by
    ... by base^-k_s with k_1 + ... + k_s = m - t (Niederreiter 1987, definition 2.2; Sobol 1967 in base 2). Any
    base^m points are an (m, m, s)-net. Found by counting, from t = 0 up, each t until a shape of it fails: n counts for
    each of at most binomial(m + s, s) shapes.

    In a base that is a power of 2 intervals are told apart exactly. In others their borders are no float64, and a
    coordinate up to 2^-48 below one, which is what rounding in making it may have cost, counts as on it. Raises
    InvalidInput; Unsupported where n is no power of the base, and where counting would take too long.
    """
    values = checked(points)
    n, s = values.shape
    if base < 2:
        raise InvalidInput(f"the base of a net is 2 or more, not {base}")
    m = _exponent(n, base)
    if m is None:
        raise Unsupported(f"a net in base {base} has a power of {base} points; {n} is none")
    work = math.comb(m + s, s) * n
    if work > MOST_WORK:
        raise Unsupported(
            f"t of {n} points in {s} dimensions takes up to {work:.2g} counts, more than {MOST_WORK:.0g}: "
            "take fewer dimensions or points"
        )
    levels = _levels(values, base, m)
    return next(t for t in range(m + 1) if _is_net(levels, base, m, t))


def _exponent(n: int, base: int) -> int | None:
    m = 0
    while n % base == 0:
        n //= base
        m += 1
    return m if n == 1 else None


def _levels(values: Points, base: int, m: int) -> list[list[NDArray[np.int64]]]:
    """[dimension][k]: of which interval of length base^-k each point is."""
    scaled = values * float(base**m)
    cells = np.floor(scaled).astype(np.int64)
    if base & (base - 1):
        nearest = np.rint(scaled)
        on_border = np.abs(scaled - nearest) <= base**m * 2.0**-48
        cells[on_border] = np.minimum(nearest[on_border].astype(np.int64), base**m - 1)
    return [[column // base ** (m - k) for k in range(m + 1)] for column in cells.T]


def _is_net(levels: list[list[NDArray[np.int64]]], base: int, m: int, t: int) -> bool:
    for shape in _shapes(m - t, len(levels)):
        interval = levels[0][shape[0]]
        for level, k in zip(levels[1:], shape[1:], strict=True):
            interval = interval * base**k + level[k]
        if (np.bincount(interval, minlength=base ** (m - t)) != base**t).any():
            return False
    return True


def _shapes(total: int, parts: int) -> Iterator[tuple[int, ...]]:
    """All (k_1, ..., k_parts) of non-negative numbers with that sum, by where the bars between them stand."""
    for bars in itertools.combinations(range(total + parts - 1), parts - 1):
        ends = (-1, *bars, total + parts - 1)
        yield tuple(b - a - 1 for a, b in itertools.pairwise(ends))
