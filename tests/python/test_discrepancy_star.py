"""The star discrepancy against its definition in exact fractions."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import prod

import numpy as np
import pytest
from discrepancy_sets import EXTREMES, Points, hammersley, small_sets

from aliascope.errors import Unsupported
from aliascope.native import samplers
from aliascope.native.discrepancy import Measured, measure


def at_corner(points: Points, corner: tuple[float, ...], closed: bool) -> Fraction:
    """|n/N - volume| of the box [0, corner), or [0, corner], exact."""
    inside = points <= corner if closed else points < corner
    count = int(inside.all(axis=1).sum())
    return abs(Fraction(count, len(points)) - prod(map(Fraction, corner), start=Fraction(1)))


def star_in_fractions(points: Points) -> Fraction:
    """The largest over all corners of the points' coordinates and 1, open and closed."""
    sides = [sorted({*column.tolist(), 1.0}) for column in points.T]
    return max(at_corner(points, corner, closed) for corner in product(*sides) for closed in (False, True))


def check_against_fractions(points: Points) -> Measured:
    found = measure("star", points)
    expected = star_in_fractions(points)
    # The count over N and the volume are rounded in long double, their difference once more to double.
    assert found.value == pytest.approx(float(expected), rel=1e-15, abs=1e-18), points.tolist()
    assert float(at_corner(points, found.witness, found.closed)) == pytest.approx(found.value, rel=1e-15, abs=1e-18)
    assert found.certainty == "exact"
    assert found.lower == found.value == found.upper
    return found


@pytest.mark.parametrize(("dimensions", "sets", "most"), [(1, 150, 12), (2, 240, 14), (3, 150, 6), (4, 120, 4)])
def test_star_is_its_definition(dimensions: int, sets: int, most: int) -> None:
    for points in small_sets(sets, dimensions, most, seed=dimensions):
        check_against_fractions(points)


@pytest.mark.parametrize("name", EXTREMES)
def test_extremes(name: str) -> None:
    points = EXTREMES[name]
    check_against_fractions(points)
    check_against_fractions(np.hstack([points, points[:, ::-1]])[:, :3])
    check_against_fractions(points[:, :1])


def test_known_values() -> None:
    """One dimension, Niederreiter 1992, theorem 2.6: 1/(2N) + max |x_i - (2i - 1)/(2N)|. One point in two
    dimensions: max(x, y, 1 - x y)."""
    for n in (1, 2, 17, 1000):
        centred = (np.arange(n) + 0.5)[:, None] / n
        assert measure("star", centred).value == pytest.approx(1 / (2 * n), rel=0, abs=2**-53)  # coordinates round
        values = np.sort(np.random.default_rng(n).random(n))
        expected = 1 / (2 * n) + np.abs(values - (2 * np.arange(1, n + 1) - 1) / (2 * n)).max()
        assert measure("star", values[:, None]).value == pytest.approx(expected, rel=1e-12, abs=0)
    for x, y in ((0.5, 0.5), (0.9, 0.95), (0.2, 0.9)):
        assert measure("star", [[x, y]]).value == pytest.approx(max(x, y, 1 - x * y), rel=1e-15, abs=0)


def star_by_tables(points: Points) -> float:
    """O(N^d): cumulated counts on the grid of all coordinates."""
    n, dimensions = points.shape
    sides = [np.unique(np.append(column, 1.0)) for column in points.T]
    closed = np.zeros([len(side) for side in sides])
    np.add.at(closed, tuple(np.searchsorted(side, column) for side, column in zip(sides, points.T, strict=True)), 1)
    volume = np.ones([1] * dimensions)
    for axis, side in enumerate(sides):
        closed = closed.cumsum(axis)
        volume = volume * side.reshape([-1 if other == axis else 1 for other in range(dimensions)])
    opened = np.zeros_like(closed)
    opened[(slice(1, None),) * dimensions] = closed[(slice(None, -1),) * dimensions]
    return float(max((closed / n - volume).max(), (volume - opened / n).max()))


@pytest.mark.parametrize("n", [31, 32, 33, 63, 64, 65, 500, 1023, 1024, 1025, 2000])
def test_many_points_in_two_dimensions(n: int) -> None:
    """Block counts from 1 to 45, full and not."""
    rng = np.random.default_rng(n)
    gridded = rng.integers(0, 40, (n, 2)) / 40
    for points in (rng.random((n, 2)), hammersley(n), gridded, samplers.points("sobol", n, 2), rng.random((n, 2)) ** 3):
        # Products of two doubles in both; the table's are rounded to double.
        assert measure("star", points).value == pytest.approx(star_by_tables(points), rel=1e-12, abs=1e-15)


@pytest.mark.parametrize(("n", "dimensions"), [(33, 3), (90, 3), (34, 4)])
def test_many_points_in_more_dimensions(n: int, dimensions: int) -> None:
    rng = np.random.default_rng(n)
    gridded = rng.integers(0, 9, (n, dimensions)) / 8
    for points in (rng.random((n, dimensions)), hammersley(n, dimensions), gridded, rng.random((n, dimensions)) ** 2):
        assert measure("star", points).value == pytest.approx(star_by_tables(points), rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4])
def test_no_box_exceeds_it(dimensions: int) -> None:
    rng = np.random.default_rng(11)
    points = rng.random((40, dimensions))
    found = measure("star", points)
    corners = np.vstack([rng.random((20_000, dimensions)), rng.choice(points.ravel(), (20_000, dimensions))])
    counts = (points[None] < corners[:, None]).all(axis=2).mean(axis=1)
    assert np.abs(counts - corners.prod(axis=1)).max() <= found.value + 1e-15
    assert float(at_corner(points, found.witness, found.closed)) == pytest.approx(found.value, rel=1e-15, abs=0)


@pytest.mark.parametrize("dimensions", [2, 3, 4])
def test_axes_and_points_may_change_places(dimensions: int) -> None:
    rng = np.random.default_rng(5)
    for points in small_sets(30, dimensions, 12, seed=50):
        expected = measure("star", points).value
        for _ in range(3):
            changed = rng.permutation(points)[:, rng.permutation(dimensions)]
            assert measure("star", changed).value == pytest.approx(expected, rel=1e-15, abs=1e-18)


def test_five_dimensions_are_refused() -> None:
    with pytest.raises(Unsupported, match="1 to 4 dimensions"):
        measure("star", np.full((3, 5), 0.5))
