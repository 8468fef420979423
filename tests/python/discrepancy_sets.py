"""Point sets that the tests of discrepancies share, and the symmetries of the square."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
BELOW_ONE = 1.0 - 2.0**-53

EXTREMES: dict[str, Points] = {
    "one point": np.array([[0.3, 0.7]]),
    "the middle": np.array([[0.5, 0.5]]),
    "the origin": np.array([[0.0, 0.0]]),
    "the far corner": np.array([[1.0, 1.0]]),
    "just below one": np.array([[BELOW_ONE, BELOW_ONE]]),
    "equal points": np.full((7, 2), 0.375),
    "equal points in a corner": np.full((5, 2), [1.0, 0.0]),
    "just below one, many": np.full((6, 2), BELOW_ONE),
    "on the diagonal": np.repeat(np.linspace(0.0, 1.0, 9)[:, None], 2, axis=1),
    "on a level line": np.column_stack([np.linspace(0.0, 1.0, 9), np.full(9, 0.25)]),
    "on the left side": np.column_stack([np.zeros(6), np.linspace(0.0, 1.0, 6)]),
    "on the border": np.array([[0, 0.25], [0.25, 1], [1, 0.75], [0.75, 0], [0, 0], [1, 1]]),
    "the corners": np.array([[0, 0], [0, 1], [1, 0], [1, 1]], float),
}


def small_sets(count: int, dimensions: int, most: int, seed: int) -> Iterator[Points]:
    """`count` sets of 1 to `most` points, (n, dimensions): random; on coarse grids, so with equal coordinates and
    equal points; with coordinates from {0, 1, 1 - 2^-53, 1/2} among them; on a line; of a lattice; of
    van der Corput."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        n = int(rng.integers(1, most + 1))
        kind = number % 6
        points = rng.random((n, dimensions))
        if kind == 1:
            points = rng.integers(0, 5, (n, dimensions)) / 4
        elif kind == 2:
            border = rng.choice([0.0, 1.0, BELOW_ONE, 0.5], (n, dimensions))
            points = np.where(rng.random((n, dimensions)) < 0.6, border, points)
        elif kind == 3:
            points = np.repeat(points[:, :1], dimensions, axis=1)
            points[:, 0] = rng.choice([points[0, 0], 0.25], n)
        elif kind == 4:
            generator = 1 + rng.integers(0, n, dimensions)
            points = np.arange(n)[:, None] * generator % n / n
        elif kind == 5:
            points[:, 0] = np.arange(n) / n
            points[:, 1:] = np.array(
                [[van_der_corput(i, base) for base in (2, 3, 5)[: dimensions - 1]] for i in range(n)]
            )
        yield points


def van_der_corput(index: int, base: int) -> float:
    """The radical inverse of an index."""
    value, place = 0.0, 1.0 / base
    while index:
        index, digit = divmod(index, base)
        value += digit * place
        place /= base
    return value


def hammersley(n: int, dimensions: int = 2) -> Points:
    """(i/n, phi_2(i), phi_3(i), ...)."""
    columns = [np.arange(n) / n]
    columns += [np.array([van_der_corput(i, base) for i in range(n)]) for base in (2, 3, 5, 7)[: dimensions - 1]]
    return np.column_stack(columns)


SYMMETRIES: dict[str, Callable[[Points], Points]] = {
    "identity": lambda p: p,
    "swap": lambda p: p[:, ::-1],
    "flip x": lambda p: np.column_stack([1 - p[:, 0], p[:, 1]]),
    "flip y": lambda p: np.column_stack([p[:, 0], 1 - p[:, 1]]),
    "turn by 90": lambda p: np.column_stack([1 - p[:, 1], p[:, 0]]),
    "turn by 180": lambda p: 1 - p,
    "turn by 270": lambda p: np.column_stack([p[:, 1], 1 - p[:, 0]]),
    "other diagonal": lambda p: np.column_stack([1 - p[:, 1], 1 - p[:, 0]]),
}
