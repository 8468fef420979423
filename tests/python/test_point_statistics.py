"""Statistics of point sets, against brute force in fractions, against NumPy and SciPy, and what is known of them."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, HalfspaceIntersection
from scipy.stats import qmc

import aliascope
from aliascope import point_sets
from aliascope.errors import InvalidInput, Unsupported
from aliascope.native.discrepancy import measure

Array = NDArray[np.float64]
EPS = np.finfo(float).eps


def uniform(n: int, d: int = 2, seed: int = 0) -> Array:
    return np.random.default_rng(seed).random((n, d))


def minimum_distance(points: Any, toroidal: bool = True) -> float:
    return measure("min-distance" if toroidal else "min-distance:torus=0", points).value


def t_value(points: Any, base: int = 2) -> int:
    return int(measure(f"t-value:base={base}", points).value)


def grid(k: int) -> Array:
    return np.array([((i + 0.5) / k, (j + 0.5) / k) for i in range(k) for j in range(k)])


COORDINATES = st.one_of(
    st.sampled_from([0.0, 0.25, 0.5, 1.0 - 2.0**-24]),  # in line, in the same place, on the borders
    st.floats(0.0, 1.0, exclude_max=True, allow_subnormal=False),
)


def small_sets(dimensions: int = 2) -> st.SearchStrategy[Array]:
    shape = st.integers(1, 12).map(lambda n: (n, dimensions))
    return shape.flatmap(lambda s: hnp.arrays(np.float64, s, elements=COORDINATES))


# --- distances --------------------------------------------------------------------------------------------------------


def test_distances_go_over_the_borders() -> None:
    points = [[0.05, 0.5], [0.95, 0.5], [0.5, 0.2]]
    assert minimum_distance(points) == pytest.approx(0.1, rel=1e-12)
    assert minimum_distance(points, toroidal=False) == pytest.approx(math.hypot(0.45, 0.3), rel=1e-12)
    assert minimum_distance([[0.25, 0.5]] * 3) == 0.0


def test_the_densest_packings_have_their_distance() -> None:
    # Hexagons do not fit the torus: in 14 rows of 12 the nearest are those of the next row, slightly too near.
    rows, columns = 14, 12
    hexagonal = np.array(
        [((i + 0.5 * (j % 2)) / columns, (j + 0.25) / rows) for j in range(rows) for i in range(columns)]
    )
    expected = math.hypot(1 / 24, 1 / 14) / math.sqrt(2 / (math.sqrt(3) * 168))
    assert expected > 0.997
    assert point_sets.point_statistics(hexagonal).minimum_distance_share == pytest.approx(expected, rel=1e-12)
    face_centred = (np.array([[0, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 0]]) + 0.5) / 2.0 % 1.0
    assert minimum_distance(face_centred) == pytest.approx(point_sets.densest_distance(4, 3), rel=1e-12)
    assert point_sets.densest_distance(5, 1) == pytest.approx(0.2, rel=1e-15)
    assert point_sets.densest_distance(100) == pytest.approx(math.sqrt(2 / (math.sqrt(3) * 100)), rel=1e-15)
    with pytest.raises(Unsupported):
        point_sets.densest_distance(5, 4)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(small_sets())
def test_no_set_beats_the_densest_packing(points: Array) -> None:
    found = point_sets.point_statistics(points)
    if len(points) > 1:
        assert found.minimum_distance_share is not None
        assert 0.0 <= found.minimum_distance_share <= 1.0
        assert found.minimum_distance <= found.minimum_distance_plain + 4 * EPS


# --- Voronoi cells ----------------------------------------------------------------------------------------------------


def cell_area(points: Array, index: int) -> float:
    """By cutting the plane with the bisectors of one site and all others' copies, two periods around."""
    site = points[index]
    steps = np.array(list(itertools.product((-2, -1, 0, 1, 2), repeat=2)), dtype=float)
    away = (points[:, None] + steps).reshape(-1, 2) - site
    away = away[(away != 0.0).any(axis=1)]
    halfspaces = np.column_stack([away, -(away**2).sum(axis=1) / 2.0])
    corners = HalfspaceIntersection(halfspaces, np.zeros(2)).intersections
    return float(ConvexHull(corners).volume)


@pytest.mark.parametrize("n", [1, 2, 3, 5, 40, 90])
def test_voronoi_areas_are_those_of_cut_half_planes(n: int) -> None:
    points = uniform(n, seed=n)
    areas = point_sets.voronoi_areas(points)
    assert areas == pytest.approx([cell_area(points, i) for i in range(n)], abs=1e-12)  # Qhull's own rounding


@pytest.mark.parametrize("k", [1, 2, 3, 16, 100])
def test_a_grid_has_equal_cells(k: int) -> None:
    assert point_sets.voronoi_areas(grid(k)) == pytest.approx(np.full(k * k, 1.0 / (k * k)), rel=1e-9)


def test_points_in_line_and_at_the_same_place() -> None:
    # Strips from half-way to half-way, however far their cells reach across.
    places = np.sort(uniform(2000, 1)[:, 0])
    gaps = np.diff(np.append(places, places[0] + 1.0))
    line = np.column_stack([np.full(2000, 0.3), places])
    assert point_sets.voronoi_areas(line) == pytest.approx((gaps + np.roll(gaps, 1)) / 2.0, abs=1e-15)
    assert point_sets.voronoi_areas(line[:, ::-1]) == pytest.approx((gaps + np.roll(gaps, 1)) / 2.0, abs=1e-15)
    diagonal = np.repeat(uniform(60, 1), 2, axis=1)
    # Both are good to about 1e-16 over the least distance, 1e-4 here.
    assert point_sets.voronoi_areas(diagonal) == pytest.approx([cell_area(diagonal, i) for i in range(60)], abs=1e-10)
    shared = point_sets.voronoi_areas([[0.1, 0.1], [0.6, 0.1], [0.1, 0.1], [0.1, 0.1]])
    assert shared == pytest.approx([1 / 6, 1 / 2, 1 / 6, 1 / 6], rel=1e-12)
    nearly = point_sets.voronoi_areas([[0.0, 0.0], [1e-45, 1e-45], [1.0 - 2.0**-53, 0.0], [0.0, 0.86]])
    assert nearly == pytest.approx([1 / 6, 1 / 6, 1 / 6, 1 / 2], rel=1e-12)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(small_sets())
def test_voronoi_areas_fill_the_torus(points: Array) -> None:
    areas = point_sets.voronoi_areas(points)
    assert (areas >= 0.0).all()
    assert areas.sum() == pytest.approx(1.0, abs=1e-9)  # Qhull joins corners that are nearly one


def test_many_points_on_a_diagonal_are_refused() -> None:
    with pytest.raises(Unsupported, match="take 10000 points or fewer"):
        point_sets.voronoi_areas(np.repeat(uniform(10_001, 1), 2, axis=1))


def test_clusters_need_a_wide_margin() -> None:
    # 400 points in a corner a hundredth wide and one far away, whose cell is nearly the whole torus.
    points = np.concatenate([0.01 * uniform(400), [[0.5, 0.5]]])
    areas = point_sets.voronoi_areas(points)
    assert areas.sum() == pytest.approx(1.0, abs=1e-9)
    for index in (0, 17, 400):
        assert areas[index] == pytest.approx(cell_area(points, index), rel=1e-6)


def test_random_cells_vary_as_gilbert_says() -> None:
    """The variance of a Poisson-Voronoi cell is 0.280 / n^2 (Gilbert 1962). 20 sets of 2,000; their own scatter says
    how sure the mean is, at 4 standard errors, and 0.0005 is for the third digit's rounding."""
    each = [float(point_sets.voronoi_areas(uniform(2000, seed=seed)).var()) * 2000**2 for seed in range(20)]
    error = np.std(each, ddof=1) / math.sqrt(20)
    assert error < 0.005
    assert abs(np.mean(each) - 0.280) < 4 * error + 0.0005


# --- nets -------------------------------------------------------------------------------------------------------------


def brute_t(points: list[tuple[Fraction, ...]], base: int, m: int) -> int:
    """The least t by its definition, a point and an interval at a time."""
    s = len(points[0])
    for t in range(m + 1):
        shapes = [shape for shape in itertools.product(range(m - t + 1), repeat=s) if sum(shape) == m - t]
        if all(
            sum(all(a <= x * base**k < a + 1 for x, a, k in zip(point, corner, shape, strict=True)) for point in points)
            == base**t
            for shape in shapes
            for corner in itertools.product(*(range(base**k) for k in shape))
        ):
            return t
    raise AssertionError("one interval has all")


def radical_inverse(i: int, base: int) -> Fraction:
    value, place = Fraction(0), Fraction(1, base)
    while i:
        i, digit = divmod(i, base)
        value, place = value + digit * place, place / base
    return value


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 5), st.integers(1, 3), st.integers(0, 2**32 - 1), st.booleans())
def test_t_is_that_of_the_definition(m: int, s: int, seed: int, even: bool) -> None:
    if even:  # scrambled nets, of which some dimensions are taken out of order: t of all sizes
        chosen = np.random.default_rng(seed).permutation(8)[:s]
        points = qmc.Sobol(8, bits=20, rng=np.random.default_rng(seed)).random(2**m)[:, chosen]
    else:
        points = np.floor(uniform(2**m, s, seed) * 8) / 8
    exact = [tuple(map(Fraction, row)) for row in points.tolist()]
    assert t_value(points) == brute_t(exact, 2, m)


@pytest.mark.parametrize("m", [1, 4, 10, 16])
def test_sobols_first_two_dimensions_have_t_0(m: int) -> None:
    assert t_value(aliascope.points("sobol", 2**m)) == 0
    assert t_value(aliascope.points("sobol:scramble=owen", 2**m, seed=m)) == 0
    assert t_value(qmc.Sobol(2, scramble=False).random(2**m)) == 0


@pytest.mark.parametrize("s", [1, 2, 3, 4, 5])
def test_sobols_t_is_within_its_bound_and_meets_it(s: int) -> None:
    """Of the sequence: the sum of the degrees of the primitive polynomials less one each (Sobol 1967), 0, 0, 1, 3, 5,
    which runs of its points at multiples of their number keep to, and some meet."""
    bound = (0, 0, 1, 3, 5)[s - 1]
    found = []
    for m, block in itertools.product(range(4, 11), (0, 1, 5)):
        found.append(t_value(aliascope.points("sobol", 2**m, s, first=block << m)))
    assert max(found) <= bound
    if s <= 3:
        assert max(found) == bound


def test_halton_is_no_net_in_base_2_and_its_dimensions_are_in_theirs() -> None:
    points = aliascope.points("halton", 3**5, 3)
    assert t_value(points[:, [1]], base=3) == 0
    assert t_value(aliascope.points("halton", 256)[:, [0]]) == 0
    assert t_value(aliascope.points("halton", 256)) > 2
    assert t_value(uniform(256)) > 2


@pytest.mark.parametrize(("base", "m"), [(3, 7), (5, 4), (7, 3), (4, 5), (10, 3)])
def test_hammersley_in_other_bases_has_t_0(base: int, m: int) -> None:
    n = base**m
    exact = [(Fraction(i, n), radical_inverse(i, base)) for i in range(n)]
    points = np.array([[float(x) for x in row] for row in exact])
    assert t_value(points, base) == 0
    # An ulp less, as another order of the same additions may leave it, is the same point where borders are no double.
    assert (t_value(np.maximum(np.nextafter(points, -1.0), 0.0), base) == 0) == (base != 4)
    assert t_value(np.maximum(points - 2.0**-44, 0.0), base) > 0  # what is clearly below a border is below it
    # A point that is moved to another interval of length 1 / n leaves its own empty: t is the least for which both
    # intervals are one, found the slow way where that takes no minute.
    moved = points.copy()
    moved[0, 0] = moved[-1, 0]
    found = t_value(moved, base)
    assert found > 0
    if n < 200:
        assert found == brute_t([tuple(map(Fraction, row)) for row in moved.tolist()], base, m)


def test_faures_points_in_base_3_are_a_net_of_three_dimensions() -> None:
    """Faure 1982: the digits of i, times powers of Pascal's matrix modulo 3; a (0, 3)-sequence."""
    m = 6
    pascal = np.array([[math.comb(c, r) for c in range(m)] for r in range(m)])
    digits = np.array([[i // 3**j % 3 for j in range(m)] for i in range(3**m)])
    power, columns = np.eye(m, dtype=int), []
    for _ in range(3):
        columns.append((digits @ power.T % 3) @ (3.0 ** -np.arange(1, m + 1)))
        power = power @ pascal % 3
    points = np.column_stack(columns)
    assert t_value(points, base=3) == 0
    with_i = np.column_stack([np.arange(3**m) / 3**m, points])
    assert t_value(with_i, base=3) == 0
    assert t_value(np.column_stack([with_i, points[:, 2] * 0.5 + 0.5]), base=3) > 0


# --- spectrum ---------------------------------------------------------------------------------------------------------


def direct(points: Array, cut_off: int) -> Array:
    """The periodogram by its definition."""
    k = np.arange(-cut_off, cut_off + 1)
    x, y = np.exp(-2j * np.pi * np.outer(k, points[:, 0])), np.exp(-2j * np.pi * np.outer(k, points[:, 1]))
    power: Array = np.abs(y @ x.T) ** 2 / len(points)
    power[cut_off, cut_off] = 0.0
    return power


@pytest.mark.parametrize(("n", "cut_off"), [(1, 1), (1, 20), (2, 7), (37, 64), (500, 100), (5000, 33)])
def test_the_spectrum_is_that_of_the_definition(n: int, cut_off: int) -> None:
    points = uniform(n, seed=n)
    found = point_sets.point_spectrum([points], cut_off).power
    # Sums of phases are good to 1e-12 n (measured: 3e-13 n and less): in P, 2 sqrt(P / n) 1e-12 n.
    assert np.abs(found - direct(points, cut_off)).max() < 4e-12 * math.sqrt(n * max(found.max(), 1.0))


def test_on_a_raster_the_spectrum_is_the_ffts() -> None:
    generator = np.random.default_rng(3)
    cells = generator.choice(64 * 64, 300, replace=False)
    image = np.zeros((64, 64))
    image.ravel()[cells] = 1.0
    points = np.column_stack([cells % 64, cells // 64]) / 64.0
    power = np.abs(np.fft.fft2(image)) ** 2 / 300
    power[0, 0] = 0.0
    found = point_sets.point_spectrum([points], 31).power
    k = np.arange(-31, 32)
    assert found == pytest.approx(power[k[:, None], k], abs=1e-9)


@pytest.mark.parametrize("k", [2, 8, 32])
def test_a_grid_has_peaks_at_its_multiples_and_nothing_else(k: int) -> None:
    found = point_sets.point_spectrum([grid(k)], 2 * k)
    frequency = np.arange(-2 * k, 2 * k + 1)
    on = frequency % k == 0
    peaks = np.outer(on, on)
    peaks[2 * k, 2 * k] = False
    assert found.power[peaks] == pytest.approx(np.full(peaks.sum(), float(k * k)), rel=1e-9)
    assert not found.power[~peaks].any()
    assert not found.radial_power[: k - 1].any()
    assert np.isnan(found.anisotropy[: k - 1]).all()
    assert found.anisotropy[k - 1] > 0.0


def test_independent_points_have_power_1() -> None:
    """In each ring within 4.5 of its standard errors, 64 rings: significance 5e-4 in all. 40 realisations, as few have
    standard errors that are too small now and then."""
    sets = [uniform(256, seed=seed) for seed in range(40)]
    found = point_sets.point_spectrum(sets)
    assert found.standard_error is not None
    assert (np.abs(found.radial_power - 1.0) < 4.5 * found.standard_error).all()
    k = np.arange(1, 65)
    rings = np.pi * ((k + 0.5) ** 2 - (k - 0.5) ** 2) / 2
    # A mean of 40 periodograms has variance 1/40; of a ring, over as many as it has, but for chance: 40 realisations
    # give a standard deviation to 11%.
    assert found.standard_error == pytest.approx(1 / np.sqrt(40 * rings), rel=0.55)
    assert found.anisotropy[20:].mean() == pytest.approx(-10 * math.log10(40), abs=0.2)


def test_jittered_points_have_their_closed_form() -> None:
    """E P = 1 - (sinc(k_x / s) sinc(k_y / s))^2 for s x s strata, as each point is uniform in its own and their means
    cancel. Rings within 4.5 standard errors of it, 60 realisations."""
    side, cut_off = 16, 40
    found = point_sets.point_spectrum([aliascope.points("jittered", side**2, seed=seed) for seed in range(60)], cut_off)
    y, x = np.mgrid[-cut_off : cut_off + 1, -cut_off : cut_off + 1]
    expected = 1.0 - (np.sinc(x / side) * np.sinc(y / side)) ** 2
    ring = np.rint(np.hypot(x, y))
    means = np.array([expected[ring == r].mean() for r in found.frequencies])
    assert found.standard_error is not None
    assert (np.abs(found.radial_power - means) < 4.5 * found.standard_error).all()
    assert found.radial_power[0] < 0.05


def test_rings_anisotropy_and_realisations_are_ulichneys() -> None:
    sets = [uniform(60, seed=seed) * [1.0, 0.5] for seed in range(3)]
    cut_off = 12
    found = point_sets.point_spectrum(iter(sets), cut_off)
    power = np.mean([direct(points, cut_off) for points in sets], axis=0)
    assert found.power == pytest.approx(power, abs=1e-9)
    assert (found.realisations, found.n) == (3, 60)
    for r in range(1, cut_off + 1):
        members = [
            (x, y)
            for x in range(-cut_off, cut_off + 1)
            for y in range(cut_off + 1)
            if r - 0.5 <= math.hypot(x, y) < r + 0.5 and (y > 0 or x > 0)
        ]
        values = np.array([power[cut_off + y, cut_off + x] for x, y in members])
        assert found.radial_power[r - 1] == pytest.approx(values.mean(), rel=1e-9)
        ratio = values.var(ddof=1) / values.mean() ** 2
        assert found.anisotropy[r - 1] == pytest.approx(10 * math.log10(ratio), abs=1e-6)
        each = [np.mean([direct(p, cut_off)[cut_off + y, cut_off + x] for x, y in members]) for p in sets]
        assert found.standard_error is not None
        assert found.standard_error[r - 1] == pytest.approx(np.std(each, ddof=1) / math.sqrt(3), rel=1e-9)


def test_frequencies_are_where_the_docstring_says() -> None:
    # Two points half a side apart in x: P = 2 at even k_x, 0 at odd ones, whatever k_y is.
    found = point_sets.point_spectrum([np.array([[0.0, 0.3], [0.5, 0.3]])], 2)
    assert found.power == pytest.approx(np.array([[2, 0, 2, 0, 2]] * 2 + [[2, 0, 0, 0, 2]] + [[2, 0, 2, 0, 2]] * 2))
    # A diagonal pair: its waves run along k_x + k_y.
    found = point_sets.point_spectrum([np.array([[0.0, 0.0], [0.25, 0.25]])], 2)
    assert found.power[2 - 2, 2 + 2] == pytest.approx(2.0)
    assert found.power[2 + 1, 2 + 1] == pytest.approx(0.0)


def test_one_point_has_no_anisotropy_to_speak_of() -> None:
    found = point_sets.point_spectrum([uniform(1)])
    assert found.radial_power == pytest.approx(np.ones(16))
    assert np.isnan(found.anisotropy).all()
    assert found.standard_error is None


def test_what_has_no_spectrum() -> None:
    with pytest.raises(Unsupported, match="two dimensions"):
        point_sets.point_spectrum([uniform(4, 3)])
    with pytest.raises(InvalidInput, match="cut-off"):
        point_sets.point_spectrum([uniform(4)], 0)
    with pytest.raises(InvalidInput, match="cut-off"):
        point_sets.point_spectrum([uniform(4)], 4096)
    with pytest.raises(InvalidInput, match="4 and 5"):
        point_sets.point_spectrum([uniform(4), uniform(5)])
    with pytest.raises(InvalidInput, match="one realisation"):
        point_sets.point_spectrum([])


# --- together ---------------------------------------------------------------------------------------------------------


def test_the_statistics_of_the_package() -> None:
    found = aliascope.point_statistics(grid(8))
    assert found.minimum_distance == pytest.approx(0.125, rel=1e-12)
    assert found.minimum_distance_share == pytest.approx(math.sqrt(math.sqrt(3) / 2), rel=1e-12)
    assert found.voronoi_area_mean == pytest.approx(1 / 64, rel=1e-12)
    assert found.voronoi_area_standard_deviation == pytest.approx(0.0, abs=1e-12)
    assert found.voronoi_area_minimum == pytest.approx(found.voronoi_area_maximum, rel=1e-9)
    assert found.t_value == 3  # a column of 8 in each of 8 strips, and none in the next finer
    assert found.reasons == {}


def test_the_areas_of_the_statistics() -> None:
    points = uniform(50)
    areas, found = point_sets.voronoi_areas(points), aliascope.point_statistics(points)
    assert found.voronoi_area_standard_deviation == pytest.approx(np.sqrt(((areas - 0.02) ** 2).mean()), rel=1e-9)
    assert (found.voronoi_area_minimum, found.voronoi_area_maximum) == (areas.min(), areas.max())


def test_what_points_do_not_have_says_why() -> None:
    one = aliascope.point_statistics([[0.5, 0.5]])
    assert (one.minimum_distance, one.voronoi_area_mean, one.t_value) == (None, 1.0, 0)
    assert set(one.reasons) == {"minimum_distance", "minimum_distance_share", "minimum_distance_plain"}
    many = aliascope.point_statistics(uniform(12, 5))
    assert many.minimum_distance is not None
    assert set(many.reasons) >= {"minimum_distance_share", "voronoi_area_mean", "t_value"}
    assert aliascope.point_statistics(aliascope.points("halton", 27)[:, 1:], base=3).t_value == 0


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((0, 2)),
        np.zeros(4),
        [[0.5, 1.0]],
        [[0.5, -1e-300]],
        [[np.nan, 0.5]],
        [[0.1, 0.2], [0.3]],
        [["a", "b"]],
        [[0.5j, 0.0]],
    ],
)
def test_what_are_no_points(points: Any) -> None:
    for function in (point_sets.point_statistics, aliascope.point_spectrum):
        with pytest.raises(InvalidInput):
            function(points)


def test_the_spectrum_of_the_package_takes_one_set_or_many() -> None:
    one, other = uniform(10, seed=1), uniform(10, seed=2)
    assert aliascope.point_spectrum(one).realisations == 1
    both = aliascope.point_spectrum(np.array([one, other]), cut_off=5)
    assert both.realisations == 2
    assert np.array_equal(both.power, aliascope.point_spectrum([one, other], cut_off=5).power)
