"""The arrays that sets of points come in."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput

Points = NDArray[np.float64]
"""(n, d), each value in [0, 1), or in [0, 1] where it says so."""


def outside(values: Points, closed: bool) -> int | None:
    """The first row that has a value outside [0, 1), of [0, 1] where `closed`, or no number; None if all are inside."""
    # Without memory for an answer a row: NaN is neither least nor greatest, but comes out as both.
    if values.size and values.min() >= 0.0 and (values.max() <= 1.0 if closed else values.max() < 1.0):
        return None
    rows = np.flatnonzero(~((values >= 0.0) & ((values <= 1.0) if closed else (values < 1.0))).all(axis=1))
    return int(rows[0]) if rows.size else None


def checked(points: Any, closed: bool = False) -> Points:
    """Points as (n, d) float64 of n, d >= 1. Raises InvalidInput: another shape, no numbers, values outside [0, 1), or
    [0, 1] where `closed`."""
    try:
        given = np.asarray(points)
    except ValueError:  # rows of different lengths
        raise InvalidInput("points are an array of shape (n, d); these rows differ in length") from None
    if given.dtype.kind not in "fiu":
        raise InvalidInput(f"points are real numbers, not {given.dtype}")
    values = given.astype(np.float64)
    if values.ndim != 2 or 0 in values.shape:
        raise InvalidInput(f"points are an array of shape (n, d), not {values.shape}")
    row = outside(values, closed)
    if row is not None:
        unit = "[0, 1]" if closed else "[0, 1)"
        raise InvalidInput(f"point {row} is not in {unit}: {', '.join(f'{value:.17g}' for value in values[row])}")
    return values + 0.0  # no negative zeros, which would be other points than zero
