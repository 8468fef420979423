"""star-bounds, dispersion, min-distance and t-value, against brute force, scipy, and what is known of nets."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import Voronoi, cKDTree

from aliascope.errors import InvalidInput, SpecError, Unsupported
from aliascope.native.discrepancy import Measured, measure, registered
from aliascope.native.samplers import points

Points = NDArray[np.float64]

ROUNDING = 4 * np.finfo(float).eps
"""Of values below 1 that some steps in double lead to."""

LAST = 1 - 2.0**-53


def small_sets(dimensions: int, count: int, most: int) -> list[Points]:
    """Random, gridded, and degenerate: equal points, on a line, on the border, in corners, next to 1."""
    rng = np.random.default_rng(dimensions)
    found = []
    for number in range(count):
        n = int(rng.integers(1, most + 1))
        values = rng.random((n, dimensions))
        kind = number % 7
        if kind == 1:
            values = np.floor(values * 5) / 4
        elif kind == 2:
            values[:] = values[0]
        elif kind == 3:
            values[:, 1:] = values[:, :1]
        elif kind == 4:
            values[:, int(rng.integers(dimensions))] = float(rng.integers(2))
        elif kind == 5:
            values = np.round(values)
        elif kind == 6:
            values = np.where(values < 0.3, LAST, values)
        found.append(values)
    return found


def radical_inverse(base: int, digits: int) -> Points:
    """Of 0 to base^digits - 1."""
    n = base**digits
    return np.array([sum(i // base**k % base * base ** (digits - 1 - k) for k in range(digits)) / n for i in range(n)])


def hammersley(n: int) -> Points:
    """Up to 64 points."""
    return np.stack([np.arange(n) / n, radical_inverse(2, 6)[:n]], axis=1)


def lattice(n: int, generator: int) -> Points:
    return np.stack([np.arange(n) / n, np.arange(n) * generator % n / n], axis=1)


def larcher_pillichshammer(n: int) -> Points:
    values = []
    for i in range(n):
        v, y, left = 1 << 31, 0, i
        while left:
            y ^= v if left & 1 else 0
            left, v = left >> 1, v | v >> 1
        values.append([i / n, y / 2**32])
    return np.array(values)


def structured_sets() -> list[Points]:
    return [*map(hammersley, (1, 2, 7, 8, 13)), lattice(8, 5), lattice(13, 8), points("regular", 9)]


def symmetries(values: Points) -> list[Points]:
    """The square's reflections and rotations of a set whose coordinates 1 - x are exact."""
    found = []
    for x in (values[:, 0], 1 - values[:, 0]):
        for y in (values[:, 1], 1 - values[:, 1]):
            found += [np.stack([x, y], axis=1), np.stack([y, x], axis=1)]
    return found


def dyadic(n: int, seed: int) -> Points:
    return np.random.default_rng(seed).integers(0, 2**20 + 1, (n, 2)) / 2.0**20


# --- star-bounds ------------------------------------------------------------------------------------------------------


def star_by_hand(values: Points) -> Fraction:
    """All corners of the grid, open and closed."""
    exact = [[Fraction(float(x)) for x in row] for row in values]
    n = len(exact)
    best = Fraction(0)
    for corner in itertools.product(*[sorted({*column, Fraction(1)}) for column in zip(*exact, strict=True)]):
        volume = math.prod(corner, start=Fraction(1))
        closed = sum(all(x <= c for x, c in zip(row, corner, strict=True)) for row in exact)
        opened = sum(all(x < c for x, c in zip(row, corner, strict=True)) for row in exact)
        best = max(best, Fraction(closed, n) - volume, volume - Fraction(opened, n))
    return best


def holds(bounds: Measured, exact: float | Fraction) -> bool:
    """The lower bound is rounded to the nearest double, the upper one up."""
    return bounds.certainty == "bounds" and bounds.lower <= float(exact) + ROUNDING and exact <= bounds.upper


def at_corner(values: Points, bounds: Measured) -> float:
    corner = np.array(bounds.witness)
    inside = (values <= corner if bounds.closed else values < corner).all(axis=1).mean()
    return abs(float(inside) - float(np.prod(corner)))


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4])
@pytest.mark.parametrize("spec", ["star-bounds", "star-bounds:gap=0", "star-bounds:gap=0.2,iterations=0"])
def test_bounds_hold_the_star_discrepancy(dimensions: int, spec: str) -> None:
    """Within the gap that was asked for, with the corner that has the lower one."""
    gap = {"star-bounds": 0.01, "star-bounds:gap=0": 0.0}.get(spec, 0.2)
    for values in small_sets(dimensions, 105, 40):
        bounds = measure(spec, values)
        assert holds(bounds, measure("star", values).value), (values, bounds)
        assert bounds.upper - bounds.lower <= gap + (dimensions + 3) * ROUNDING
        assert bounds.value == bounds.lower
        assert len(bounds.witness) == dimensions
        assert at_corner(values, bounds) == pytest.approx(bounds.value, abs=ROUNDING)


@pytest.mark.parametrize(("dimensions", "most"), [(1, 12), (2, 8), (3, 5), (5, 3)])
def test_bounds_against_fractions(dimensions: int, most: int) -> None:
    for values in small_sets(dimensions, 42, most):
        exact = star_by_hand(values)
        assert holds(measure("star-bounds:gap=0.05", values), exact)
        bounds = measure("star-bounds:gap=0", values)
        assert holds(bounds, exact)
        assert bounds.value == pytest.approx(float(exact), abs=ROUNDING)


def test_bounds_in_many_dimensions() -> None:
    """Random boxes never exceed the upper bound; and the bounds of more and less work overlap."""
    rng = np.random.default_rng(8)
    values = rng.random((128, 8))
    found = [measure(f"star-bounds:work={work}", values, seed=3) for work in (0, 1, 100)]
    corners = rng.random((20000, 8)) ** (1 / 8)
    inside = np.array([(values < corner).all(axis=1).mean() for corner in corners])
    seen = float(np.abs(inside - corners.prod(axis=1)).max())
    lower = max(bounds.lower for bounds in found)
    for bounds in found:
        assert max(seen, lower) <= bounds.upper <= 1
    assert found[0].upper == 1
    assert [bounds.upper for bounds in found] == sorted((bounds.upper for bounds in found), reverse=True)
    assert found[2].upper - found[2].lower < 0.1  # 0.08 when this was written
    assert found[2].lower > seen


def test_threshold_accepting_finds_it() -> None:
    """Without any work for the upper bound. Of these seeds two come to the exact value, the worst to 91 % of it."""
    values = points("halton", 256, 3)
    exact = measure("star", values).value
    found = [measure("star-bounds:iterations=20000,work=0", values, seed=seed).value for seed in range(4)]
    assert min(found) > 0.85 * exact
    assert max(found) == pytest.approx(exact, abs=ROUNDING)
    few = [measure("star-bounds:iterations=50,work=0", values, seed=seed) for seed in range(8)]
    assert len({bounds.value for bounds in few}) > 1  # the seed matters
    assert few[3] == measure("star-bounds:iterations=50,work=0", values, seed=3)


def diagonal(n: int, dimensions: int) -> Points:
    """(i/n, ..., i/n) for i from 0 to n - 1."""
    return np.repeat(np.arange(n)[:, None] / n, dimensions, axis=1)


def star_of_diagonal(n: int, dimensions: int) -> Fraction:
    """A closed box up to i/n in every dimension has i + 1 points; an open one that lacks some is best cut there in one
    dimension alone, and has as many points as its volume, for i/n from 0 to 1."""
    return max(Fraction(i + 1, n) - Fraction(i, n) ** dimensions for i in range(n))


@pytest.mark.parametrize("dimensions", [1, 2, 3, 5, 8, 10])
def test_bounds_of_sets_whose_star_is_known(dimensions: int) -> None:
    """With work for the gap, with little, and with none: the truth is between them in any case."""
    rng = np.random.default_rng(dimensions)
    cases = [(diagonal(n, dimensions), star_of_diagonal(n, dimensions)) for n in (1, 2, 16)]
    for _ in range(3):
        point = rng.random(dimensions) ** 0.25
        exact = max(Fraction(point.max()), 1 - math.prod(map(Fraction, point.tolist()), start=Fraction(1)))
        cases.append((np.repeat(point[None], 9, axis=0), exact))
    for values, exact in cases:
        for spec in ("star-bounds", "star-bounds:work=0.01", "star-bounds:iterations=0", "star-bounds:work=0"):
            bounds = measure(spec, values, seed=5)
            assert holds(bounds, exact), (spec, exact, bounds)
            assert bounds.value == bounds.lower > 0.0
            assert measure(spec, values, seed=5) == bounds
        exactly = measure("star-bounds:gap=0", values)
        assert exactly.value == pytest.approx(float(exact), abs=dimensions * ROUNDING)
        assert exactly.upper == pytest.approx(float(exact), abs=dimensions * ROUNDING)


def test_bounds_of_one_point_and_equal_points() -> None:
    for n in (1, 50):
        bounds = measure("star-bounds:gap=0", [[0.5, 0.5]] * n)
        assert (bounds.value, bounds.closed, bounds.witness) == (0.75, True, (0.5, 0.5))
    assert measure("star-bounds:gap=0", [[0.0] * 12]).value == 1.0
    assert measure("star-bounds:gap=0", [[0.0] * 12]).witness == ()
    assert measure("star-bounds:gap=0", [[LAST, LAST]]).value == pytest.approx(1.0, abs=ROUNDING)


# --- dispersion -------------------------------------------------------------------------------------------------------


def largest_box(values: Points) -> Fraction:
    """All pairs of sides at points or the border."""
    exact = [(Fraction(float(x)), Fraction(float(y))) for x, y in values]
    sides = [sorted({Fraction(0), Fraction(1), *(point[axis] for point in exact)}) for axis in (0, 1)]
    best = Fraction(0)
    for x0, x1 in itertools.combinations(sides[0], 2):
        within = [y for x, y in exact if x0 < x < x1]
        ends = sorted({Fraction(0), Fraction(1), *within})
        best = max(best, (x1 - x0) * max(b - a for a, b in itertools.pairwise(ends)))
    return best


def box_is_empty(values: Points, box: tuple[float, ...]) -> bool:
    x0, y0, x1, y1 = box
    return not bool(((values > [x0, y0]) & (values < [x1, y1])).all(axis=1).any())


def test_largest_box_against_fractions() -> None:
    for values in [*small_sets(2, 280, 12), *structured_sets()]:
        found = measure("dispersion", values)
        assert found.value == pytest.approx(float(largest_box(values)), rel=1e-15), values
        x0, y0, x1, y1 = found.witness
        assert (x1 - x0) * (y1 - y0) == found.value
        assert box_is_empty(values, found.witness)


def nearest_in_square(values: Points) -> Fraction:
    """Squared: the largest distance to the nearest point, over circumcentres, bisectors on the border, and corners."""
    exact = [*{(Fraction(float(x)), Fraction(float(y))) for x, y in values}]
    zero, one = Fraction(0), Fraction(1)
    centres = list(itertools.product((zero, one), repeat=2))
    # Bisectors a x + b y = c.
    lines = [
        (2 * (q[0] - p[0]), 2 * (q[1] - p[1]), q[0] ** 2 - p[0] ** 2 + q[1] ** 2 - p[1] ** 2)
        for p, q in itertools.combinations(exact, 2)
    ]
    for a, b, c in lines:
        centres += [(side, (c - a * side) / b) for side in (zero, one) if b]
        centres += [((c - b * side) / a, side) for side in (zero, one) if a]
    for (a, b, c), (d, e, f) in itertools.combinations(lines, 2):
        across = a * e - b * d
        if across:
            centres.append(((c * e - b * f) / across, (a * f - c * d) / across))
    return max(min((x - p[0]) ** 2 + (y - p[1]) ** 2 for p in exact) for x, y in centres if 0 <= x <= 1 and 0 <= y <= 1)


def test_largest_disc_against_fractions() -> None:
    for values in [*small_sets(2, 210, 6), *structured_sets()[:4]]:
        found = measure("dispersion:of=disc", values)
        assert found.value == pytest.approx(math.sqrt(nearest_in_square(values)), rel=1e-15, abs=ROUNDING), values
        x, y, radius = found.witness
        assert radius == found.value
        assert np.hypot(*(values - [x, y]).T).min() == pytest.approx(radius, abs=ROUNDING)


@pytest.mark.parametrize("spec", ["random", "halton", "jittered", "sobol", "lattice", "regular"])
def test_largest_disc_against_voronoi(spec: str) -> None:
    """With the set mirrored in the four sides, the border is made of cells' sides: all centres are vertices."""
    values = lattice(1597, 987) if spec == "lattice" else points(spec, 1600, seed=5)
    mirrored = [values, *(values * s + o for s, o in [((-1, 1), (0, 0)), ((1, -1), (0, 0))])]
    mirrored += [values * s + o for s, o in [((-1, 1), (2, 0)), ((1, -1), (0, 2)), ((-1, -1), (0, 0))]]
    mirrored += [values * -1 + o for o in ((2, 0), (0, 2), (2, 2))]
    vertices = Voronoi(np.unique(np.concatenate(mirrored), axis=0), qhull_options="Qbb Qc Qz").vertices
    vertices = vertices[((vertices >= -1e-9) & (vertices <= 1 + 1e-9)).all(axis=1)]
    # Qhull's vertices are right to some 1e-12; that far off, they are not beyond the largest.
    expected = cKDTree(values).query(np.clip(vertices, 0, 1))[0].max()
    assert measure("dispersion:of=disc", values).value == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("spec", ["dispersion", "dispersion:of=disc"])
def test_no_empty_place_is_larger(spec: str) -> None:
    rng = np.random.default_rng(4)
    for values in [rng.random((40, 2)), hammersley(40), dyadic(40, 2)]:
        most = measure(spec, values).value
        if spec == "dispersion:of=disc":
            assert cKDTree(values).query(rng.random((100000, 2)))[0].max() <= most
            continue
        # Random boxes, shrunk to the points' coordinates or not, that turn out to be empty.
        corners = np.sort(rng.random((100000, 2, 2)), axis=1)
        empty = ~((values > corners[:, :1]) & (values < corners[:, 1:])).all(axis=2).any(axis=1)
        areas = np.prod(corners[:, 1] - corners[:, 0], axis=1)
        assert empty.sum() > 1000
        assert areas[empty].max() <= most


@pytest.mark.parametrize("spec", ["dispersion", "dispersion:of=disc", "min-distance", "min-distance:torus=0"])
def test_symmetries_of_the_square(spec: str) -> None:
    for seed in range(30):
        found = [measure(spec, turned).value for turned in symmetries(dyadic(30, seed))]
        assert found == pytest.approx([found[0]] * 8, rel=1e-15)


def test_dispersion_at_the_extremes() -> None:
    def box(values: Any) -> float:
        return measure("dispersion", values).value

    def disc(values: Any) -> float:
        return measure("dispersion:of=disc", values).value

    for n in (1, 300):
        assert box([[0.25, 0.5]] * n) == 0.75
        assert disc([[0.25, 0.5]] * n) == math.hypot(0.75, 0.5)
        assert box([[0.0, 0.0]] * n) == 1.0
        assert disc([[0.0, 0.0]] * n) == math.sqrt(2)
        assert disc([[LAST, LAST]] * n) == pytest.approx(math.sqrt(2), abs=ROUNDING)
        assert box([[LAST, LAST]] * n) == LAST
    line = np.stack([np.full(101, 0.25), np.linspace(0, 1, 101)], axis=1)
    assert box(line) == 0.75
    assert disc(line) == pytest.approx(math.hypot(0.75, 0.005), abs=ROUNDING)
    border = np.concatenate([[[t, 0], [t, 1], [0, t], [1, t]] for t in np.linspace(0, 1, 65)])
    assert box(border) == 1.0
    assert disc(border) == 0.5
    # Distances whose squares underflow, and sites closer together than a corner's rounding.
    assert disc([[0.0, 0.5], [1e-300, 0.5], [2e-300, 0.5]]) == pytest.approx(math.hypot(1, 0.5), abs=ROUNDING)


@pytest.mark.parametrize("k", [1, 2, 7, 32])
def test_dispersion_of_centred_grids(k: int) -> None:
    """Between two columns, over the whole height: (2 grid cells, less where the border is nearer)."""
    grid = points("regular", k * k)
    assert measure("dispersion", grid).value == pytest.approx(0.5 if k == 1 else 1 / k, rel=1e-14)
    assert measure("dispersion:of=disc", grid).value == pytest.approx(math.sqrt(0.5) / k, rel=1e-14)


# --- min-distance -----------------------------------------------------------------------------------------------------


def distance_by_hand(values: Points, torus: bool) -> float:
    exact = [[Fraction(float(x)) for x in row] for row in values]

    def square(p: list[Fraction], q: list[Fraction]) -> Fraction:
        apart = [abs(a - b) for a, b in zip(p, q, strict=True)]
        return sum((min(x, 1 - x) if torus else x) ** 2 for x in apart) + Fraction(0)

    least = min(square(p, q) for p, q in itertools.combinations(exact, 2))
    return math.sqrt(least * 2**400) / 2.0**200  # so that small squares keep their digits


@pytest.mark.parametrize("dimensions", [1, 2, 3, 7])
@pytest.mark.parametrize("torus", [0, 1])
def test_distance_against_fractions(dimensions: int, torus: int) -> None:
    for values in small_sets(dimensions, 84, 30):
        if len(values) < 2:
            continue
        found = measure(f"min-distance:torus={torus}", values)
        assert found.value == pytest.approx(distance_by_hand(values, bool(torus)), rel=2e-15, abs=0), values
        if dimensions <= 4:
            pair = np.array(found.witness).reshape(2, dimensions)
            assert distance_by_hand(pair, bool(torus)) == pytest.approx(found.value, rel=2e-15, abs=0)
        else:
            assert found.witness == ()


@pytest.mark.parametrize("dimensions", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("torus", [0, 1])
def test_distance_against_scipy(dimensions: int, torus: int) -> None:
    """Even, clustered, and of very unequal scales."""
    rng = np.random.default_rng(dimensions)
    even = rng.random((3000, dimensions))
    for values in (even, even**9, np.where(rng.random((3000, 1)) < 0.5, even * 1e-3, even)):
        nearest = cKDTree(values, boxsize=1.0 if torus else None).query(values, k=2)[0][:, 1]
        assert measure(f"min-distance:torus={torus}", values).value == pytest.approx(nearest.min(), rel=1e-10, abs=0)


def test_distance_at_the_extremes() -> None:
    with pytest.raises(Unsupported, match="two points or more"):
        measure("min-distance", [[0.5, 0.5]])
    assert measure("min-distance", [[0.3, 0.7]] * 1000).value == 0
    assert measure("min-distance", [[0.0, 0.5], [1.0, 0.5]]).value == 0
    assert measure("min-distance:torus=0", [[0.0, 0.5], [1.0, 0.5]]).value == 1
    assert measure("min-distance", [[0.0, 0.5], [LAST, 0.5]]).value == 2.0**-53
    assert measure("min-distance", [[1e-200, 0.5], [3e-200, 0.5]]).value == pytest.approx(2e-200, rel=1e-15)
    for k in (2, 5, 33):
        assert measure("min-distance", points("regular", k * k)).value == pytest.approx(1 / k, rel=1e-13)
        line = np.stack([np.full(k, 0.5), np.arange(k) / k], axis=1)
        assert measure("min-distance", line).value == pytest.approx(1 / k, rel=1e-13)


# --- t-value ----------------------------------------------------------------------------------------------------------


def t_by_hand(values: Points, base: int) -> int:
    """Every elementary interval asked for its points, coordinates as whole multiples of 1/n."""
    n, s = values.shape
    m = round(math.log(n, base))
    cells = np.floor(values * n + (0 if base == 2 else n * 2.0**-48)).astype(int)
    for t in range(m + 1):
        shapes = [k for k in itertools.product(range(m - t + 1), repeat=s) if sum(k) == m - t]
        counts = [
            np.unique(
                np.stack([cells[:, d] // base ** (m - k) for d, k in enumerate(shape)]), axis=1, return_counts=True
            )
            for shape in shapes
        ]
        if all(len(count) == base ** (m - t) and (count == base**t).all() for _, count in counts):
            return t
    raise AssertionError


@pytest.mark.parametrize("spec", ["random", "sobol", "sobol:scramble=owen", "halton", "jittered"])
@pytest.mark.parametrize("dimensions", [1, 2, 3, 4])
def test_t_against_counting(spec: str, dimensions: int) -> None:
    for n in (1, 2, 4, 16, 64):
        if spec == "jittered" and round(math.sqrt(n)) ** 2 != n:
            continue
        values = points(spec, n, dimensions, seed=2)
        found = measure("t-value", values)
        assert (found.value, found.certainty) == (t_by_hand(values, 2), "exact"), (spec, n)


def test_t_of_sobols_pairs() -> None:
    """Two dimensions of Sobol's together can be far from t = 0."""
    values = points("sobol", 64, 12)
    found = {}
    for pair in itertools.combinations(range(12), 2):
        found[pair] = int(measure("t-value", values[:, pair]).value)
        assert found[pair] == t_by_hand(values[:, pair], 2), pair
    assert found[0, 1] == 0
    assert max(found.values()) >= 3


def test_nets_in_two_dimensions() -> None:
    for m in (0, 1, 5, 10, 16):
        for values in (points("sobol", 2**m), points("sobol:scramble=owen", 2**m, seed=9)):
            assert measure("t-value", values).value == 0
        assert measure("t-value", larcher_pillichshammer(2**m)).value == 0
    for m in (0, 1, 3, 4):
        assert measure("t-value", hammersley(2**m)).value == 0


@pytest.mark.parametrize("base", [3, 5, 7])
def test_t_in_other_bases(base: int) -> None:
    """(i/n, radical inverse) is a (0, m, 2)-net in any base, though its coordinates are no double."""
    for m in (1, 2, 3, 4):
        n = base**m
        values = np.stack([np.arange(n) / n, radical_inverse(base, m)], axis=1)
        assert measure(f"t-value:base={base}", values).value == 0
        swapped = values.copy()
        swapped[[0, -1], 1] = swapped[[-1, 0], 1]
        assert measure(f"t-value:base={base}", swapped).value == t_by_hand(swapped, base)


def test_sets_that_are_no_net() -> None:
    for m in (1, 4, 9):
        assert measure("t-value", np.full((2**m, 3), 0.3)).value == m
        half = points("sobol", 2**m, 3) / 2
        assert measure("t-value", half).value == m


def test_t_says_what_it_does_not_do() -> None:
    with pytest.raises(Unsupported, match="power of 2 points; these are 12"):
        measure("t-value", points("random", 12))
    with pytest.raises(Unsupported, match="power of 3 points; these are 8"):
        measure("t-value:base=3", points("random", 8))
    with pytest.raises(Unsupported, match="point 1 has a coordinate of 1"):
        measure("t-value", [[0.0, 0.0], [1.0, 0.5]])
    with pytest.raises(SpecError):
        measure("t-value:base=1", [[0.5, 0.5]])
    assert measure("t-value", [[0.0, 0.0], [LAST, LAST]]).value == 0
    with pytest.raises(Unsupported, match=r"more than 2\^30 counts"):
        measure("t-value", points("sobol", 2**16, 60))  # some seconds


# --- all four ---------------------------------------------------------------------------------------------------------


def test_the_registry_describes_them() -> None:
    infos = {info.name: info for info in registered()}
    assert [text.split("=")[0] for text in infos["star-bounds"].parameters] == ["gap", "iterations", "work"]
    assert infos["dispersion"].most_dimensions == 2
    with pytest.raises(Unsupported, match="2 dimensions; these have 3"):
        measure("dispersion", [[0.5, 0.5, 0.5]])
    for name in ("star-bounds", "dispersion", "min-distance", "t-value"):
        with pytest.raises(InvalidInput):
            measure(name, [[0.5, np.nan], [0.5, 0.5]])
