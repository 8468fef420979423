"""The measures `box` and `half-plane` against brute force in fractions, random search, and the square's symmetries."""

from __future__ import annotations

import ctypes
import itertools
import math
import random
import subprocess
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from aliascope.native.discrepancy import measure

Points = NDArray[np.float64]
Line = tuple[int, int, int]

# Directions that differ by less than 2^-50 count as one (half_plane.c): 3.6e-15 of area, and some eps of rounding.
HALF_PLANE_ERROR = 5e-15
# One rounding of the result; the search itself errs by N eps or so and can only prefer a box that is as much worse.
BOX_ERROR = 2e-15


def hammersley(n: int) -> Points:
    return np.array([(i / n, int(f"{i:b}"[::-1], 2) / 2 ** i.bit_length() if i else 0.0) for i in range(n)])


def small_sets() -> Iterator[tuple[str, Points]]:
    """Sets of 1 to 9 points of every kind that could go wrong."""
    draw = np.random.default_rng(5)
    for trial in range(60):
        n = 1 + trial % 8
        yield f"random {trial}", draw.random((n, 2))
        for steps in (2, 3, 4):  # thirds do not lie on a line once they are rounded, quarters do
            yield f"grid of {steps}, {trial}", draw.integers(0, steps + 1, (n, 2)) / steps
        yield f"equal points {trial}", np.repeat(draw.random((1 + n // 3, 2)), 3, axis=0)[: n + 1]
        along = draw.integers(0, 65, n) / 64
        yield f"diagonal {trial}", np.column_stack([along, along])
        yield f"on a line {trial}", np.column_stack([along, 0.25 + along / 2])
        yield f"nearly on a line {trial}", np.column_stack([draw.random(n)] * 2) * (1 - draw.random((n, 2)) * 3e-16)
        # Exactly on a line and around its middle, but their differences are rounded, and so are directions.
        doubled = 2.0 ** -np.arange(1, 11)
        yield f"doubled {trial}", np.column_stack([draw.random() * doubled, draw.integers(1024) / 2048 + doubled])
        yield f"level {trial}", np.column_stack([draw.random(n), np.full(n, draw.random())])
        side = draw.integers(0, 2, n)
        border = np.column_stack([np.where(side, draw.integers(0, 2, n), draw.random(n))] * 2)
        border[:, 1] = np.where(side, draw.random(n), draw.integers(0, 2, n))
        yield f"border {trial}", border
        yield f"corners {trial}", draw.integers(0, 2, (n, 2)).astype(float)
        yield f"to the last bit {trial}", draw.choice([0.0, 5e-324, 1e-300, 2.0**-53, 0.5, 1 - 2.0**-53, 1.0], (n, 2))
        yield f"cluster {trial}", 0.3 + draw.random((n, 2)) * 10.0 ** -(1 + trial % 17)
    for n in range(1, 10):
        yield f"Hammersley {n}", hammersley(n)
        for generator in range(1, n):
            yield f"lattice {n} {generator}", np.array([(i / n, i * generator % n / n) for i in range(n)])


SMALL_SETS = list(small_sets())


def exact(points: Points) -> list[tuple[Fraction, Fraction]]:
    return [(Fraction(float(x)), Fraction(float(y))) for x, y in points]


def whole(points: Points) -> tuple[list[tuple[int, int]], int]:
    """The points as whole multiples of a power of two, and its reciprocal: arithmetic without fractions to shorten."""
    given = exact(points)
    unit = max(value.denominator for point in given for value in point)
    return [(int(x * unit), int(y * unit)) for x, y in given], unit


def clipped_area(a: Fraction | int, b: Fraction | int, c: Fraction | int) -> Fraction:
    """The area of a x + b y + c >= 0 in the unit square, by the textbook formula: whole numbers do not cancel."""
    unit = math.lcm(*(Fraction(value).denominator for value in (a, b, c)))
    a, b, c = (int(value * unit) for value in (a, b, c))
    if a < 0:  # x and 1 - x change places; and so for y
        a, c = -a, c + a
    if b < 0:
        b, c = -b, c + b
    if a == 0 or b == 0:
        side = a or b
        return Fraction(max(c + side, 0) - max(c, 0), side) if side else Fraction(c >= 0)
    squares = max(c + a + b, 0) ** 2 - max(c + a, 0) ** 2 - max(c + b, 0) ** 2 + max(c, 0) ** 2
    return Fraction(squares, 2 * a * b)


def lines(points: list[tuple[int, int]], unit: int) -> set[Line]:
    """All lines through two points; and through each alone those among which is the one that it halves: the ends of
    that chord lie on the square and on its mirror image in the point, so at corners of what these two share."""
    found = set()

    def add(x: int, y: int, dx: int, dy: int) -> None:
        if dx or dy:
            found.add((dy, -dx, dx * y - dy * x))

    for (x, y), (u, v) in itertools.combinations(set(points), 2):
        add(x, y, u - x, v - y)
    for x, y in set(points):
        half_width, half_height = min(x, unit - x), min(y, unit - y)
        add(x, y, half_width, half_height)
        add(x, y, half_width, -half_height)
        add(x, y, 1, 0)
        add(x, y, 0, 1)
    return found


def brute_half_plane(points: Points) -> Fraction:
    """Over all lines, with all or none of the points on it, which a tilt can leave on one side."""
    given, unit = whole(points)
    best = Fraction(0)
    for a, b, c in lines(given, unit):
        values = [a * x + b * y + c for x, y in given]
        inside, on = sum(value > 0 for value in values), sum(value == 0 for value in values)
        area = clipped_area(a * unit, b * unit, c)
        best = max(best, *(abs(Fraction(count, len(given)) - area) for count in (inside, inside + on)))
    return best


def brute_box(points: Points) -> Fraction:
    """Over all boxes with their sides at coordinates, 0 or 1, open and closed."""
    given, unit = whole(points)
    sides = [sorted({0, unit, *(point[d] for point in given)}) for d in range(2)]
    best = 0
    spans = [list(itertools.combinations_with_replacement(side, 2)) for side in sides]
    for closed in (False, True):
        inside = [
            np.array([[a <= p[d] <= b if closed else a < p[d] < b for p in given] for a, b in spans[d]], dtype=int)
            for d in range(2)
        ]
        counts = (inside[0] @ inside[1].T).tolist()
        heights = [d - c for c, d in spans[1]]
        for i, (a, b) in enumerate(spans[0]):
            # Of one count and width, only the extreme heights matter.
            least: dict[int, int] = {}
            most: dict[int, int] = {}
            for n, height in zip(counts[i], heights, strict=True):
                least[n] = min(least.get(n, height), height)
                most[n] = max(most.get(n, height), height)
            for extremes in (least, most):
                for n, height in extremes.items():
                    best = max(best, abs(n * unit**2 - len(given) * (b - a) * height))
    return Fraction(best, len(given) * unit**2)


BRUTE: dict[str, tuple[Callable[[Points], Fraction], float]] = {
    "box": (brute_box, BOX_ERROR),
    "half-plane": (brute_half_plane, HALF_PLANE_ERROR),
}


@pytest.mark.parametrize("spec", BRUTE)
def test_brute_force_in_fractions_says_the_same(spec: str) -> None:
    brute, error = BRUTE[spec]
    for name, points in SMALL_SETS:
        assert measure(spec, points).value == pytest.approx(float(brute(points)), rel=0, abs=error), name


def test_a_boxs_witness_has_the_value() -> None:
    for name, points in SMALL_SETS:
        found = measure("box", points)
        (a, c, b, d), given = (Fraction(value) for value in found.witness), exact(points)
        if found.closed:
            value = Fraction(sum(a <= x <= b and c <= y <= d for x, y in given), len(given)) - (b - a) * (d - c)
        else:
            value = (b - a) * (d - c) - Fraction(sum(a < x < b and c < y < d for x, y in given), len(given))
        assert found.value == pytest.approx(float(value), rel=0, abs=BOX_ERROR), name


def test_a_half_planes_witness_has_the_value() -> None:
    """Its coefficients are rounded, so the points of its edge lie beside it by an eps or so: moved out by more."""
    for name, points in SMALL_SETS:
        found = measure("half-plane", points)
        assert found.closed
        (a, b, c), given = (Fraction(value) for value in found.witness), exact(points)
        c += Fraction(1e-14)
        value = Fraction(sum(a * x + b * y + c >= 0 for x, y in given), len(given)) - clipped_area(a, b, c)
        assert found.value == pytest.approx(float(value), rel=0, abs=5e-14), name  # 1e-14 at |(a, b)| > 1/2, 2 sqrt 2


def areas(a: Points, b: Points, c: Points) -> Points:
    """The area of a x + b y + c >= 0, by integrating the edge's height over x between its kinks."""
    steep = np.abs(b) < np.abs(a)
    a, b = np.where(steep, b, a), np.where(steep, a, b)
    kinks = np.clip(
        np.stack([np.zeros_like(a), -c / np.where(a == 0, 1, a), -(b + c) / np.where(a == 0, 1, a), a**0]), 0, 1
    )
    kinks.sort(axis=0)
    heights = np.clip(-(a * kinks + c) / b, 0, 1)
    below = np.sum(np.diff(kinks, axis=0) * (heights[1:] + heights[:-1]) / 2, axis=0)
    return np.asarray(np.where(b > 0, 1 - below, below))


@pytest.mark.parametrize("n", [1, 2, 5, 20, 100])
def test_random_search_never_exceeds(n: int) -> None:
    draw = np.random.default_rng(n)
    for points in (draw.random((n, 2)), draw.integers(0, 8, (n, 2)) / 7, hammersley(n)):
        sides = np.sort(draw.random((40000, 2, 2)), axis=1)
        # Half of the sides at points, with them or without: nearer to the extremes.
        for d in range(2):
            at = points[draw.integers(0, n, (20000, 2)), d] + draw.choice([-1e-9, 0.0, 1e-9], (20000, 2))
            sides[:20000, :, d] = np.clip(np.sort(at, axis=1), 0, 1)
        inside = np.all((points >= sides[:, :1]) & (points <= sides[:, 1:]), axis=2).mean(axis=1)
        found = np.abs(inside - np.prod(sides[:, 1] - sides[:, 0], axis=1)).max()
        assert found <= measure("box", points).value + 1e-14

        angle = draw.random(20000) * 2 * math.pi
        a, b = np.cos(angle), np.sin(angle)
        through = np.where(draw.random((20000, 1)) < 0.5, points[draw.integers(0, n, 20000)], draw.random((20000, 2)))
        c = -(a * through[:, 0] + b * through[:, 1]) + draw.choice([-1e-9, 0.0, 1e-9], 20000)
        share = (np.column_stack([a, b]) @ points.T + c[:, None] >= 0).mean(axis=1)
        assert np.abs(share - areas(a, b, c)).max() <= measure("half-plane", points).value + 1e-14


@pytest.mark.parametrize("spec", BRUTE)
def test_reflections_and_rotations_leave_it(spec: str) -> None:
    draw = np.random.default_rng(3)
    for n in (1, 7, 60, 250):
        points = draw.integers(0, 2**30 + 1, (n, 2)) / 2**30  # so that 1 - x is exact
        values = [
            measure(spec, np.column_stack([other[:, order[0]], other[:, order[1]]])).value
            for order in ((0, 1), (1, 0))
            for flip in itertools.product((False, True), repeat=2)
            for other in [np.where(flip, 1 - points, points)]
        ]
        assert np.ptp(values) <= 1e-14


def middling_sets() -> Iterator[tuple[str, Points]]:
    """Sets that fill buckets of directions, or that pruning does not help with."""
    draw = np.random.default_rng(8)
    yield "random", draw.random((150, 2))
    yield "Hammersley", hammersley(128)
    yield "a narrow strip", np.column_stack([0.4 + draw.random(300) * 1e-6, draw.random(300)])
    level = np.column_stack([draw.integers(0, 101, 250) / 100, np.full(250, 0.3)])
    yield "a cross, with equal points", np.concatenate([level, level[:50, ::-1]])
    yield "two clusters", np.concatenate([draw.random((60, 2)) * 1e-7 + shift for shift in (0.2, 0.7)])
    yield "circle", 0.5 + 0.4 * np.column_stack([f(np.arange(90) * 2 * math.pi / 90) for f in (np.cos, np.sin)])
    yield "three lines", np.concatenate([draw.random((40, 1)) * (0.3, 0.4) + shift for shift in (0.1, 0.3, 0.5)])


@pytest.mark.parametrize(("name", "points"), list(middling_sets()), ids=[name for name, _ in middling_sets()])
def test_larger_sets_by_counting_for_every_line(name: str, points: Points) -> None:
    """In doubles: a point within 1e-13 of an edge counts as on it, which is worth 2e-13 of area at most."""
    x, y = points.T
    n = len(points)
    i, j = np.triu_indices(n, 1)
    dx, dy = x[j] - x[i], y[j] - y[i]
    across, up = np.minimum(x, 1 - x), np.minimum(y, 1 - y)
    dx = np.concatenate([dx, across, across])
    dy = np.concatenate([dy, up, np.where(across + up > 0, -up, 1)])  # of a corner, a side
    at = np.concatenate([i, np.arange(n), np.arange(n)])
    dx, dy, at = (values[(dx != 0) | (dy != 0)] for values in (dx, dy, at))
    length = np.hypot(dx, dy)
    a, b = dy / length, -dx / length
    side = a[:, None] * (x - x[at, None]) + b[:, None] * (y - y[at, None])
    area = areas(a, b, -(a * x[at] + b * y[at]))
    best = max(((side >= -1e-13).mean(axis=1) - area).max(), ((side <= 1e-13).mean(axis=1) - (1 - area)).max())
    assert measure("half-plane", points).value == pytest.approx(best, rel=0, abs=4e-13), name


@pytest.mark.parametrize(("name", "points"), list(middling_sets()), ids=[name for name, _ in middling_sets()])
def test_larger_sets_by_the_best_run_of_every_strip(name: str, points: Points) -> None:
    """In doubles, strip by strip in NumPy, without any pruning."""
    n, best = len(points), 0.0
    x, y = points[np.argsort(points[:, 1])].T
    sides = np.unique([0.0, 1.0, *x])
    for i, left in enumerate(sides):
        right = sides[i:, None]
        inside = ((x >= left) & (x <= right)).cumsum(axis=1) / n
        area = (right - left) * y
        before = np.column_stack([np.zeros(len(right)), inside[:, :-1]])
        best = max(best, (inside - area - np.minimum.accumulate(before - area, axis=1)).max())
        between = ((x > left) & (x < right)).cumsum(axis=1) / n
        area = np.column_stack([np.zeros(len(right)), area, right - left])  # ends at 0 and 1 too
        before = np.column_stack([np.zeros(len(right)), np.zeros(len(right)), between])
        after = np.column_stack([np.zeros(len(right)), between, between[:, -1]])
        best = max(best, (area - before - np.minimum.accumulate(area - after, axis=1)).max())
    assert measure("box", points).value == pytest.approx(best, rel=0, abs=1e-14), name


def test_a_centred_grid_has_half_a_row_too_many() -> None:
    for k in range(1, 41):
        ticks = (np.arange(k) + 0.5) / k
        grid = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
        assert measure("half-plane", grid).value == pytest.approx(1 / (2 * k), rel=0, abs=HALF_PLANE_ERROR)


def test_one_point_cuts_off_what_turning_about_it_finds_least() -> None:
    """The least area over all angles, from the chord's two parts being equal, at 40 digits."""
    draw = random.Random(4)
    with mpmath.workdps(40):
        for _ in range(40):
            x, y = draw.random(), draw.random()

            def reach(angle: mpmath.mpf, x: float = x, y: float = y) -> mpmath.mpf:
                u, v = mpmath.cos(angle), mpmath.sin(angle)
                return min(((1 if u > 0 else 0) - x) / u, ((1 if v > 0 else 0) - y) / v)

            def difference(angle: mpmath.mpf, reach: Callable[[mpmath.mpf], mpmath.mpf] = reach) -> mpmath.mpf:
                return reach(angle) - reach(angle + mpmath.pi)

            # Two angles at 0.1 of each other between which the parts change places, then by bisection.
            angles = [mpmath.mpf(k) / 10 + mpmath.mpf("0.013") for k in range(33)]
            found = [
                mpmath.findroot(difference, (p, q), solver="anderson", tol=1e-50, verify=False)
                for p, q in itertools.pairwise(angles)
                if difference(p) * difference(q) < 0
            ]
            least = mpmath.inf
            for angle in found:
                a, b = (Fraction(*mpmath.mpf(v).as_integer_ratio()) for v in (mpmath.sin(angle), -mpmath.cos(angle)))
                area = clipped_area(a, b, -(a * Fraction(x) + b * Fraction(y)))
                least = min(least, float(area), float(1 - area))
            assert measure("half-plane", [[x, y]]).value == pytest.approx(1 - least, rel=0, abs=HALF_PLANE_ERROR)


@pytest.fixture(scope="module")
def halfplane_area(tmp_path_factory: pytest.TempPathFactory) -> Callable[[float, float, float], float]:
    """The C function, which the library keeps to itself."""
    source = Path(__file__).parents[2] / "csrc/discrepancy/halfplane_area.c"
    library = tmp_path_factory.mktemp("area") / "area.so"
    subprocess.run(["cc", "-O2", "-ffp-contract=off", "-shared", "-fPIC", source, "-o", library, "-lm"], check=True)
    function = ctypes.CDLL(str(library)).asc_halfplane_area
    function.argtypes, function.restype = [ctypes.c_double] * 3, ctypes.c_double
    return function


def test_areas_have_twelve_digits_for_every_line(halfplane_area: Callable[[float, float, float], float]) -> None:
    """Also of what little is cut off. The header promises 1e-15 of the area."""
    draw = random.Random(2)
    cases = [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, 0.0, 0.0), (1e308, 1e308, -1.7e308), (5e-324, 0.0, -5e-324)]
    for exponent in range(1, 301):
        slope = 10.0**-exponent
        for offset in (0.0, -0.3, -1.0, -slope, -slope / 3, -1 - slope / 3, -1 - slope):
            cases += [(1.0, slope, offset), (slope, -1.0, -offset), (-1.0, slope, 0.4), (-slope, -1.0, -offset)]
    for _ in range(5000):
        a, b = (draw.choice((-1, 1)) * draw.random() * 10.0 ** -draw.choice((0, 0, 1, 5, 12, 17)) for _ in range(2))
        cases.append((a, b, -(a * draw.random() + b * draw.random())))
        x, y = draw.choice((0, 1)), draw.choice((0, 1))  # past a corner by little, or not at all
        cases.append((a, b, -(a * x + b * y) + draw.choice((-1, 0, 1)) * 10.0 ** -draw.randrange(5, 20)))
    for case in cases:
        expected = clipped_area(*(Fraction(value) for value in case)) if any(case[:2]) else Fraction(case[2] >= 0)
        assert abs(Fraction(halfplane_area(*case)) - expected) <= expected * Fraction(1e-15) + Fraction(1e-300), case
