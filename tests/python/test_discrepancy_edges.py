"""The discrepancies of random edges: edge-rms against its closed form in 50 digits and against drawn edges, and the
measures that draw against edges that are drawn and clipped here in other ways."""

from __future__ import annotations

import math
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
import scipy.stats
import shapely
from discrepancy_sets import EXTREMES, SYMMETRIES, Points, hammersley, small_sets
from numpy.typing import NDArray
from scipy.integrate import quad

from aliascope.errors import SpecError, Unsupported
from aliascope.native import samplers
from aliascope.native.discrepancy import canonical, measure

Floats = NDArray[np.float64]
KINDS = ["isotropic", "angle-offset", "two-points", "chord"]
SIGMAS = 5.0  # two-sided significance 6e-7 of each comparison; below 200 of them: 1e-4 in all

# --- the closed form --------------------------------------------------------------------------------------------------


def exact_rms(points: Points) -> float:
    """The closed form in 50 digits."""
    with mpmath.workdps(50):
        exact = [tuple(mpmath.mpf(value) for value in row) for row in points.tolist()]

        def corner(a: mpmath.mpf, b: mpmath.mpf) -> mpmath.mpf:
            if a == 0 or b == 0:
                return mpmath.mpf(0)
            cubes = a**3 * mpmath.asinh(b / a) + b**3 * mpmath.asinh(a / b)
            return a * b * mpmath.hypot(a, b) / 3 + cubes / 6

        n = len(exact)
        potentials = sum(corner(a, b) for x, y in exact for a in (x, 1 - x) for b in (y, 1 - y))
        pairs = sum(mpmath.hypot(x - u, y - v) for x, y in exact for u, v in exact)
        return float(mpmath.sqrt((2 * potentials / n - pairs / n**2 - mean_distance()) / 4))


def mean_distance() -> mpmath.mpf:
    """Of two uniform points of the square."""
    return (2 + mpmath.sqrt(2) + 5 * mpmath.asinh(1)) / 15


def test_constants_are_the_integrals_that_they_stand_for() -> None:
    """The mean distance by quadrature over the difference's density 4 (1 - u) (1 - v), in polar coordinates, where the
    root's kink at 0 is smooth; and the constants that the issue and the header state."""
    with mpmath.workdps(20):
        wedge = mpmath.quad(
            lambda angle: mpmath.quad(
                lambda r: 8 * r**2 * (1 - r * mpmath.cos(angle)) * (1 - r * mpmath.sin(angle)),
                [0, 1 / mpmath.cos(angle)],
            ),
            [0, mpmath.pi / 4],
        )
        assert abs(wedge - mean_distance()) < 1e-15
        assert float(mpmath.sqrt(mean_distance() / 4)) == pytest.approx(0.361042, abs=5e-7)  # its last digit


def test_one_point_by_quadrature() -> None:
    """The square of one point's value is a quarter of 2 phi(x) less the mean distance, phi by numerical integration."""
    for x, y in ((0.5, 0.5), (0.25, 0.9), (0.0, 1.0)):
        phi = mpmath.quad(lambda u, v, x=x, y=y: mpmath.hypot(u - x, v - y), sorted({0, x, 1}), sorted({0, y, 1}))
        expected = mpmath.sqrt((2 * phi - mean_distance()) / 4)
        assert measure("edge-rms", [[x, y]]).value == pytest.approx(float(expected), abs=1e-6)  # the integrand's kink


@pytest.mark.parametrize("name", EXTREMES)
def test_extremes(name: str) -> None:
    points = EXTREMES[name]
    found = measure("edge-rms", points)
    assert found.value == pytest.approx(exact_rms(points), rel=0, abs=1e-14)
    assert (found.certainty, found.lower, found.upper) == ("exact", found.value, found.value)
    assert found.standard_error == 0.0
    for kind in KINDS:
        rms = measure(f"edge-rms:edges={kind},draws=4096", points)
        mean = measure(f"edge-mean:edges={kind},draws=4096", points)
        most = measure(f"edge-max:edges={kind},draws=4096", points)
        assert 0 < mean.value < rms.value < most.value <= 1.0
        if kind == "isotropic":
            assert abs(rms.value - found.value) < SIGMAS * rms.standard_error


def test_closed_form_to_14_digits() -> None:
    for points in small_sets(200, 2, 16, seed=8):
        assert measure("edge-rms", points).value == pytest.approx(exact_rms(points), rel=0, abs=1e-14), points.tolist()


@pytest.mark.parametrize("n", [63, 64, 65, 128, 129])
def test_runs_of_any_length(n: int) -> None:
    points = hammersley(n)
    assert measure("edge-rms", points).value == pytest.approx(exact_rms(points), rel=0, abs=1e-14)


def long_double_rms(points: Points) -> float:
    """The closed form in numpy's long double, pairwise sums."""
    x, y = points.astype(np.longdouble).T
    potentials = np.longdouble(0)
    with np.errstate(divide="ignore", invalid="ignore"):
        for a, b in ((x, y), (1 - x, y), (x, 1 - y), (1 - x, 1 - y)):
            term = a * b * np.hypot(a, b) / 3 + (a**3 * np.arcsinh(b / a) + b**3 * np.arcsinh(a / b)) / 6
            potentials += np.where((a == 0) | (b == 0), 0, term).sum()
    n, two = len(points), np.longdouble(2)
    rows = [2 * np.hypot(x[i] - x[:i], y[i] - y[:i]).sum() for i in range(1, n)]
    mean = (2 + np.sqrt(two) + 5 * np.arcsinh(two / 2)) / 15
    return float(np.sqrt((2 * potentials / n - np.array(rows).sum() / n / n - mean) / 4))


@pytest.mark.parametrize("n", [1024, 4096])
def test_no_digits_are_lost_at_many_points(n: int) -> None:
    """The square is 4e-7 to 1e-5 of the distances, near 1/2, that it is a difference of. They are rounded to double, by
    5e-17 at most; this averages out over sums that go on in long double, least on a grid, whose rows are alike. Of the
    square 1e-17 leaves 1e-14 of the root."""
    for sampler in ("hammersley", "halton", "regular"):
        points = hammersley(n) if sampler == "hammersley" else samplers.points(sampler, n, 2)
        assert measure("edge-rms", points).value == pytest.approx(long_double_rms(points), rel=0, abs=1e-14)


@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_symmetries_of_the_square(symmetry: str) -> None:
    points = np.random.default_rng(3).integers(0, 2**20, (60, 2)) / 2**20  # 1 - x is exact
    changed = SYMMETRIES[symmetry](points)
    assert measure("edge-rms", changed).value == pytest.approx(measure("edge-rms", points).value, rel=0, abs=1e-15)


@pytest.mark.parametrize("n", [1, 4, 9, 49])
@pytest.mark.parametrize(("sampler", "exponent"), [("random", 1.0), ("jittered", 1.5)])
def test_expected_squares(sampler: str, exponent: float, n: int) -> None:
    """E D^2 is a quarter of the mean distance over N for random points, over N^(3/2) for jittered ones: in each of the
    N cells of side N^-1/2 the mean distance is that side's share."""
    squares = np.array(
        [measure("edge-rms", samplers.points(sampler, n, 2, seed=seed)).value ** 2 for seed in range(2000)]
    )
    expected = float(mean_distance()) / 4 / n**exponent
    assert abs(squares.mean() - expected) < SIGMAS * squares.std(ddof=1) / math.sqrt(len(squares))


# --- drawn edges ------------------------------------------------------------------------------------------------------


def draw_edges(kind: str, count: int, rng: np.random.Generator) -> Floats:
    """Edges a x + b y + c = 0, (3, about count): those of isotropic lines in a disc that meet the square are kept."""
    if kind in ("isotropic", "angle-offset"):
        angle = rng.uniform(0, math.pi, count)
        a, b = np.cos(angle), np.sin(angle)
        width = np.abs(a) + np.abs(b)
        offset = rng.uniform(-0.5, 0.5, count) * (math.sqrt(2) if kind == "isotropic" else width)
        kept = np.abs(offset) < width / 2
        return np.array([a, b, offset - (a + b) / 2])[:, kept]
    if kind == "two-points":
        p, q = rng.random((2, 2, count))
    else:
        border = rng.uniform(0, 4, (2, count))
        border = border[:, np.floor(border[0]) != np.floor(border[1])]
        side, along = np.divmod(border, 1.0)
        x = np.choose(side.astype(int), [along, 1 + 0 * along, 1 - along, 0 * along])
        y = np.choose(side.astype(int), [0 * along, along, 1 + 0 * along, 1 - along])
        (p, q) = zip(x, y, strict=True)
    a, b = q[1] - p[1], p[0] - q[0]
    return np.array([a, b, -a * p[0] - b * p[1]])


def clipped_area(edges: Floats) -> Floats:
    """Of a x + b y + c >= 0 in the square: the mean over x of the edge's height there, clipped to [0, 1], by its
    antiderivative; x being the coordinate along which the edge is the less steep."""
    a, b, c = edges
    a, b = np.where(np.abs(b) < np.abs(a), [b, a], [a, b])
    below = -c / b
    rise = -a / b
    step = np.where(np.abs(rise) < 1e-6, 1e-6, rise)  # one that is less steep is tilted: 1e-6 / 8 of area
    start = below + (rise - step) / 2

    def integral(height: Floats) -> Floats:
        inside = np.clip(height, 0.0, 1.0)
        return inside * inside / 2 + np.maximum(height - 1.0, 0.0)

    under = (integral(start + step) - integral(start)) / step
    return np.where(b > 0, 1 - under, under)


def shapely_area(a: float, b: float, c: float) -> float:
    """The same by GEOS, of a half-plane that is a long rectangle."""
    length = math.hypot(a, b)
    normal, along = np.array([a, b]) / length, np.array([-b, a]) / length
    foot = np.array([0.5, 0.5]) - ((a + b) / 2 + c) / length * normal
    ends = [foot + 4 * along, foot - 4 * along]
    return float(
        shapely.Polygon([*ends, ends[1] + 4 * normal, ends[0] + 4 * normal]).intersection(shapely.box(0, 0, 1, 1)).area
    )


def values_at(edges: Floats, points: Points) -> Floats:
    """|n/N - area| at each edge."""
    a, b, c = edges
    count = sum((a * x + b * y + c >= 0).astype(float) for x, y in points)
    return np.abs(count / len(points) - clipped_area(edges))


@pytest.mark.parametrize("kind", KINDS)
def test_the_areas_of_these_tests_are_geos(kind: str) -> None:
    edges = draw_edges(kind, 500, np.random.default_rng(1))
    expected = [shapely_area(*edge) for edge in edges.T]
    # GEOS rounds intersections to double: 1e-12. Here eps is divided by the edge's slope, 7e-5 and more in these draws.
    assert np.abs(clipped_area(edges) - expected).max() < 1e-12 + np.finfo(float).eps / 7e-5


def test_edge_rms_is_the_mean_square_over_ten_million_edges() -> None:
    rng, points = np.random.default_rng(12), samplers.points("random", 5, 2, seed=1)
    squares = np.concatenate([values_at(draw_edges("isotropic", 250_000, rng), points) ** 2 for _ in range(45)])
    assert len(squares) > 10**7
    error = squares.std() / math.sqrt(len(squares))
    assert error < 6e-4 * squares.mean()  # so the root is checked to 1.5e-3
    assert abs(measure("edge-rms", points).value ** 2 - squares.mean()) < SIGMAS * error


SETS = {
    "one in a corner": np.array([[0.0, 0.0]]),
    "one beside the middle": np.array([[0.5, 0.4]]),
    "two": np.array([[0.1, 0.9], [0.9, 0.1]]),
    "thirteen": hammersley(13) ** 2,
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", SETS)
def test_edges_are_drawn_as_they_say(kind: str, name: str) -> None:
    """The library's mean and mean square against those over edges that are drawn here."""
    points = SETS[name]
    values = values_at(draw_edges(kind, 400_000, np.random.default_rng(7)), points)
    mean = measure(f"edge-mean:edges={kind}", points, seed=3)
    assert abs(mean.value - values.mean()) < SIGMAS * math.hypot(mean.standard_error, scipy.stats.sem(values))
    rms = measure(f"edge-rms:edges={kind},draws=524288", points, seed=4)
    square_error = math.hypot(2 * rms.value * rms.standard_error, scipy.stats.sem(values**2))
    assert abs(rms.value**2 - (values**2).mean()) < SIGMAS * square_error
    assert {mean.certainty, rms.certainty} == {"estimated"}


def quadrature(weight: Callable[[float, float], float]) -> float:
    """The mean of area (1 - area) over lines with a density in (angle, chord) against the invariant measure; tau is the
    line's distance from the nearest corner's parallel, up to the square's middle."""
    totals = []
    for of_area in (lambda area: area * (1 - area), lambda area: 1.0):

        def over_offset(angle: float, of_area: Callable[[float], float] = of_area) -> float:
            a, b = math.cos(angle), math.sin(angle)
            corner = quad(lambda tau: of_area(tau**2 / (2 * a * b)) * weight(angle, tau / (a * b)), 0, b)[0]
            return float(
                corner + quad(lambda tau: of_area((tau - b / 2) / a) * weight(angle, 1 / a), b, (a + b) / 2)[0]
            )

        totals.append(quad(over_offset, 0, math.pi / 4)[0])
    return float(totals[0] / totals[1])


# Mean area (1 - area): D^2 N of random points. Two points of the square are on a line with its chord's cube as density
# (Santalo 1976, I.4). Of chords a third joins opposite sides: E[A (1 - A)] is 5/24 there, 7/72 at corners.
MEANS: dict[str, Callable[[], float]] = {
    "isotropic": lambda: quadrature(lambda angle, chord: 1.0),
    "angle-offset": lambda: quadrature(lambda angle, chord: 1 / (math.cos(angle) + math.sin(angle))),
    "two-points": lambda: quadrature(lambda angle, chord: chord**3),
    "chord": lambda: (5 / 24 + 2 * 7 / 72) / 3,
}


@pytest.mark.parametrize("kind", KINDS)
def test_one_random_point_has_the_expected_square(kind: str) -> None:
    """Over the point the square integrates to mean area (1 - area); by Gauss-Legendre's rule, of 1e-4 relative error
    here (the square is smooth but along the border)."""
    expected = MEANS[kind]()
    if kind == "isotropic":
        assert expected == pytest.approx(float(mean_distance()) / 4, rel=1e-8)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    total = variance = 0.0
    for i, j in np.ndindex(6, 6):
        point = [[(1 + nodes[i]) / 2, (1 + nodes[j]) / 2]]
        found = measure(f"edge-rms:draws=200000,edges={kind}", point, seed=6 * i + j)
        share = weights[i] * weights[j] / 4
        total += share * found.value**2
        variance += (share * 2 * found.value * found.standard_error) ** 2
    assert abs(total - expected) < SIGMAS * math.sqrt(variance) + 1e-4 * expected


@pytest.mark.parametrize("name", ["edge-mean", "edge-rms"])
def test_standard_errors_are_those_of_the_spread_over_seeds(name: str) -> None:
    points = hammersley(11)
    found = [measure(f"{name}:draws=1000,edges=isotropic", points, seed=seed) for seed in range(400)]
    stated = np.mean([one.standard_error**2 for one in found])
    ratio = np.var([one.value for one in found], ddof=1) / stated
    low, high = scipy.stats.chi2.ppf([1e-4, 1 - 1e-4], 399) / 399  # significance 2e-4
    assert low < ratio < high


@pytest.mark.parametrize("kind", KINDS)
def test_edge_max_is_met_at_its_edge(kind: str) -> None:
    rng = np.random.default_rng(2)
    for n in (1, 3, 40, 1500):
        points = rng.random((n, 2))
        found = measure(f"edge-max:draws=3000,edges={kind}", points, seed=n)
        a, b, c = found.witness
        count = (a * points[:, 0] + b * points[:, 1] + c >= 0).mean()
        assert abs(count - shapely_area(a, b, c)) == pytest.approx(found.value, rel=0, abs=1e-12)
        assert (found.certainty, found.lower, found.upper, found.closed) == ("bounds", found.value, 1.0, True)


@pytest.mark.parametrize("kind", KINDS)
def test_edge_max_is_below_half_planes(kind: str) -> None:
    for points in small_sets(60, 2, 12, seed=9):
        most, bound = measure(f"edge-max:draws=2000,edges={kind}", points).value, measure("half-plane", points).value
        assert 0.3 * bound < most <= bound + 1e-15  # draws come near, but not to the sharpest of corners


def test_the_first_edges_do_not_depend_on_how_many_follow() -> None:
    points = hammersley(20)
    most = [measure(f"edge-max:draws={draws}", points, seed=5).value for draws in (1, 2, 15, 16, 17, 100, 5000)]
    assert most == sorted(most)
    assert most[0] < most[-1]
    means = [measure(f"edge-mean:draws={draws}", points, seed=5).value for draws in (2, 3)]
    third = 3 * means[1] - 2 * means[0]  # of the third edge alone
    assert -1e-15 < third < measure("edge-max:draws=3", points, seed=5).value + 1e-15


def test_draws_depend_on_the_seed_alone() -> None:
    points = hammersley(20)
    spec = "edge-mean:draws=1000"
    assert measure(spec, points, seed=1) == measure(spec, points, seed=1)
    values = {measure(spec, points, seed=seed).value for seed in (0, 1, 2**63, 2**64 - 1)}
    assert len(values) == 4


@pytest.mark.parametrize("kind", ["isotropic", "angle-offset", "chord"])
def test_edges_do_not_depend_on_the_points_of_the_same_seed(kind: str) -> None:
    """Hashed for another purpose: over seeds one random point and one edge come to mean area (1 - area)."""
    spec = f"edge-max:draws=1,edges={kind}"
    squares = np.array([measure(spec, samplers.points("random", 1, 2, seed=s), seed=s).value ** 2 for s in range(8000)])
    assert abs(squares.mean() - MEANS[kind]()) < SIGMAS * scipy.stats.sem(squares)


def test_specs() -> None:
    assert canonical("edge-rms:edges=isotropic") == "edge-rms"
    assert canonical("edge-mean:edges=chord,draws=524288") == "edge-mean:edges=chord"
    one = [[0.5, 0.5]]
    for wrong in ("edge-rms:draws=1", "edge-mean:draws=1", "edge-max:draws=0", "edge-mean:edges=any", "edge-mean:n=3"):
        with pytest.raises(SpecError):
            measure(wrong, one)
    for name in ("edge-rms", "edge-mean", "edge-max"):
        with pytest.raises(Unsupported, match="in 2 dimensions"):
            measure(name, [[0.5, 0.5, 0.5]])
