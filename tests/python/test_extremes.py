"""Properties that hold however far an input goes: values within their bounds, or an error that names what is wrong."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import aliascope
from aliascope import api, metrics, scene_io
from aliascope.errors import AliascopeError, InvalidInput, Unsupported
from aliascope.native import discrepancy, estimate, filters, samplers, uneven, warps
from aliascope.native.tracer import Options, Tracer
from aliascope.placement import moved, scaled
from aliascope.renderers import mode_of
from aliascope.renderers.base import Request
from aliascope.renderers.embree import RENDERER
from aliascope.stability import sampler_checks, sampler_definitions
from aliascope.stability.probes import counts
from aliascope.stability.probes.samplers import ROWS

quickly = settings(max_examples=60, deadline=None, derandomize=True)

# --- samplers ---------------------------------------------------------------------------------------------------------

WHOLE = ("n-queens", "poisson-disk", "best-candidate", "blue-noise", "mitchell-spacetime", "latin-square", "lattice")
"""Made in time proportional to N, or more."""

FAR = [base + more for base in (1 << 24, 1 << 31, 1 << 32, 1 << 48, 1 << 53, 1 << 63) for more in (-1, 0, 1)]
few = st.integers(0, 300)
wide = st.one_of(few, st.sampled_from(FAR), st.integers(0, 2**64 - 1))


@given(
    spec=st.sampled_from([row.spec for row in ROWS]),
    n=wide,
    small=few,
    dimensions=st.one_of(st.integers(1, 5), st.sampled_from((16, 1000))),
    first=wide,
    seed=st.integers(0, 2**64 - 1),
    pixel=st.tuples(st.integers(-(2**31), 2**31 - 1), st.integers(-(2**31), 2**31 - 1)),
)
@settings(max_examples=300, deadline=None, derandomize=True)
def test_points_lie_in_the_unit_cube_or_are_refused(
    spec: str, n: int, small: int, dimensions: int, first: int, seed: int, pixel: tuple[int, int]
) -> None:
    if spec.partition(":")[0] in WHOLE or spec in ("gauss-legendre", "clenshaw-curtis"):
        n, first, dimensions = small, min(first, 300), min(dimensions, 16)
    try:
        points = samplers.Sampler(spec, n, dimensions, seed).points(3, first, pixel)
    except Unsupported:
        return
    assert np.isfinite(points).all()
    assert (points >= 0.0).all()
    assert (points.astype(np.float32) < 1.0).all()


@given(value=st.one_of(st.integers(max_value=-1), st.integers(min_value=2**64)))
@settings(max_examples=12, deadline=None, derandomize=True)
def test_numbers_that_c_has_no_room_for_are_named(value: int) -> None:
    calls = (
        lambda: samplers.points("random", value),
        lambda: samplers.points("random", 1, value),
        lambda: samplers.points("random", 1, seed=value),
        lambda: samplers.points("random", 1, first=value),
        lambda: samplers.weights("random", value),
        lambda: samplers.points("random", 1, pixel=(0, value if value > 0 else value - 2**31)),
        lambda: aliascope.discrepancy([[0.5, 0.5]], "star", seed=value),
        lambda: aliascope.estimate(lambda x: x[:, 0], n=value),
        lambda: aliascope.estimate(lambda x: x[:, 0], group=(2**31 - 1, 0, 2, 1) if value < 0 else (value, 0, 1, 1)),
        lambda: aliascope.render("edge", "embree", "uniform:n=1", size=(2, 2), seed=value),
        lambda: aliascope.render("edge", "embree", "uniform:n=1", size=(2, 2), threads=value),
        lambda: aliascope.render("edge", "embree", "uniform:n=1", size=(value, 2)),
    )
    for call in calls:
        with pytest.raises(InvalidInput, match=r"from .* not |pixels a side, not|at most"):
            call()


def test_an_index_past_the_end_is_named() -> None:
    with pytest.raises(Unsupported, match="sobol has no points 4294967295 to 4294967296"):
        samplers.points("sobol", 2, first=2**32 - 1)


def doctored(spec: str, n: int, dimensions: int, first: int, row: int, value: float) -> sampler_checks.Drawn:
    """Points of which one has another coordinate."""
    drawn = sampler_checks.draw(spec, n, dimensions, first, min(n, 64))
    drawn.points[row, dimensions - 1] = value
    return drawn


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.spec)
def test_the_checks_of_the_map_see_one_point_that_is_elsewhere(row) -> None:
    """Moved to where another is, or by a millionth; what is random without a rule is seen where a point comes twice."""
    if row.check is sampler_checks.as_one_by_one:
        drawn = doctored(row.spec, row.n, row.dimensions, 0, 0, 0.123)
    else:
        right = sampler_checks.draw(row.spec, row.n, row.dimensions, 0, row.n)
        assert row.check(right) <= (1e-15 if row.exact else 0.0)
        drawn = sampler_checks.Drawn(row.spec, row.n, 0, right.points.copy())
        drawn.points[3] = drawn.points[5] + (1e-6 if row.exact else 0.0)
    assert row.check(drawn) > (1e-15 if row.exact else 0.0)


def test_what_the_map_holds_points_against() -> None:
    """Halton's table, Sobol's first points and r2's of their papers; a Legendre zero, sqrt(3/5)."""
    half = Fraction(1, 2)
    assert sampler_definitions.halton(0, 3, 11) == [Fraction(13, 16), Fraction(19, 27), Fraction(7, 25)]
    assert sampler_definitions.sobol(0, 3, 3) == [Fraction(3, 4), Fraction(1, 4), Fraction(1, 4)]
    assert [float(x) for x in sampler_definitions.r2(0, 2, 1)] == pytest.approx([0.2548776662, 0.0698402910], abs=1e-10)
    assert float(sampler_definitions.gauss_legendre(3, 1, 2)[0]) == pytest.approx(0.5 + math.sqrt(0.15), abs=1e-16)
    assert sampler_definitions.clenshaw_curtis(3, 1, 1)[0] == pytest.approx(half, abs=1e-50)
    assert sampler_definitions.zaremba(4, 2, 0)[1] == Fraction(1, 3)
    assert sampler_definitions.as_stored(1 - Fraction(1, 1 << 40)) == 1 - Fraction(1, 1 << 24)


# --- sums -------------------------------------------------------------------------------------------------------------


@given(st.lists(st.floats(-1e150, 1e150), min_size=2, max_size=40), st.sampled_from((0.0, 1.0, 1e8, -1e15)))
@example([1.0, 1.0, 1.0], 1e8)
@quickly
def test_moments_keep_ten_digits(values: list[float], offset: float) -> None:
    data = np.array(values) + offset
    exact = [Fraction(float(value)) for value in data]
    mean = sum(exact) / len(exact)
    variance = sum((value - mean) ** 2 for value in exact) / (len(exact) - 1)
    found = estimate.Moments(data)
    largest = max(abs(value) for value in exact)
    assert abs(Fraction(found.mean) - mean) <= Fraction(1, 10**14) * largest
    assume(variance == 0 or float(variance) > 1e-290)
    assert abs(Fraction(found.variance) - variance) <= Fraction(1, 10**10) * variance


@pytest.mark.parametrize("film", ["float", "compensated", "double"])
def test_a_pixel_of_many_samples(film: str) -> None:
    """A float's sum stands still at 2^24 samples of 1; the others keep the picture's last place."""
    made = Tracer(counts._scene(1, 1), (1, 1), options=Options(film=film)).render("r2", 1 << 21)[0]
    error = np.abs(made.ravel() / np.array(counts.COLOUR) - 1.0).max()
    assert (error > 1e-3) if film == "float" else (error < 1e-7)


# --- points -----------------------------------------------------------------------------------------------------------

coordinate = st.one_of(
    st.sampled_from((0.0, 0.5, 5e-324, math.nextafter(1.0, 0.0), 1.0 - 2.0**-24)),
    st.floats(0.0, 1.0, exclude_max=True),
)


@given(st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=8), st.booleans())
@settings(max_examples=20, deadline=None, derandomize=True)
def test_measures_of_any_points_are_within_their_bounds(points: list[tuple[float, float]], repeated: bool) -> None:
    """Discrepancies are from 0 to 1, distances to the square's diagonal; t is a whole number up to log2 n."""
    given_points = np.array(points * (2 if repeated else 1))
    for info in discrepancy.registered():
        if info.name in ("edge-mean", "edge-max") and len(points) > 2:
            continue  # 0.2 s each
        try:
            measured = discrepancy.measure(info.name, given_points)
        except InvalidInput:
            continue
        most = len(given_points) if info.name == "t-value" else math.sqrt(2.0)
        assert 0.0 <= measured.value <= most + 1e-12, info.name


# --- filters ----------------------------------------------------------------------------------------------------------


@given(st.sampled_from([info.name for info in filters.registered()]), st.floats(-9.0, 9.0), st.floats(-1e3, 1e3))
@quickly
def test_filters_are_whole_and_finite(name: str, x: float, frequency: float) -> None:
    made = filters.Filter(name)
    assert made.integral(-math.inf, math.inf) == pytest.approx(1.0, abs=1e-14)
    assert made.integral(-math.inf, x) + made.integral(x, math.inf) == pytest.approx(1.0, abs=1e-13)
    assert math.isfinite(float(made.evaluate(x)))
    assert abs(float(made.response(frequency))) <= 1.5  # lobes' magnitudes add up to less


# --- metrics ----------------------------------------------------------------------------------------------------------


@given(
    arrays(
        np.float32,
        (12, 12, 1),
        elements=st.floats(-(2.0**100), 2.0**100, width=32),
        fill=st.sampled_from((0.0, 1.0, 1e-30)),
    ),
    st.sampled_from((0.0, 1.0, 1e30)),
)
@settings(max_examples=10, deadline=None, derandomize=True)
def test_metrics_are_finite_or_say_why_not(picture: np.ndarray, constant: float) -> None:
    pictures = np.repeat(picture, 3, axis=2)
    for other in (pictures, np.full_like(pictures, constant)):
        for name, measured in metrics.measure(pictures, other).items():
            if measured.value is None:
                assert measured.details[f"{name}-reason"]
            else:
                assert math.isfinite(measured.value), name


# --- scenes -----------------------------------------------------------------------------------------------------------

SCENE = scene_io.load("edge").scene


def rendered(scene) -> np.ndarray:
    return RENDERER.render(Request(scene, 16, 12, mode_of(RENDERER, "uniform:n=16"))).pixels


@given(st.floats(-1e9, 1e9), st.floats(-30.0, 30.0))
@settings(max_examples=10, deadline=None, derandomize=True)
def test_a_scene_elsewhere_or_of_another_size_is_drawn_alike(by: float, power: float) -> None:
    """Coordinates are rounded to 2^-24 of a unit where they are 10^9 units off: a sample of 16 may lie on the other
    side of the edge, in few pixels."""
    original = rendered(SCENE)
    for other in (moved(SCENE, (by, -by, 0.5 * by)), scaled(SCENE, 2.0**power)):
        apart = np.abs(rendered(other) - original).max(axis=2)
        assert (apart > 1e-5).sum() <= 3
        assert apart.max() <= 2.1 / 16


# --- what is no number ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_named(value: float) -> None:
    points = np.array([[0.1, 0.2], [value, 0.5], [0.3, 0.4]])
    picture = np.zeros((12, 12, 3), np.float32)
    broken = picture.copy()
    broken[3, 5, 1] = value
    shown = r"nan|NaN|inf|finite"
    calls = [
        lambda: aliascope.point_statistics(points),
        lambda: aliascope.point_spectrum(points),
        lambda: aliascope.voronoi_areas(points, (0.0, 0.0, 1.0, 1.0)),
        lambda: aliascope.uneven_weights(points),
        lambda: uneven.weights(points),
        lambda: aliascope.error(broken, picture),
        lambda: aliascope.error(picture, broken),
        lambda: aliascope.estimate(lambda x: np.full(len(x), value)),
        lambda: estimate.Moments([1.0, value]).variance,
        lambda: aliascope.render("edge", "embree", "uniform:n=1", size=(4, 3), shift=(value, 0.0)),
        lambda: aliascope.reference("edge", size=(4, 3), shift=(0.0, value)),
        lambda: aliascope.render("edge", "embree", "uniform:n=1", size=(4, 3), least_seconds=value),
        lambda: warps.Density([1.0, value]),
        lambda: warps.triangle_pdf([[0, 0, 0], [1, 0, value], [0, 1, 0]]),
        *(lambda name=info.name: api.discrepancy(points, name) for info in discrepancy.registered()),
    ]
    if math.isnan(value):
        calls += [
            lambda: filters.evaluate("tent", [0.0, value]),
            lambda: filters.integral("tent", value, 1.0),
            lambda: warps.Density([1.0, 2.0]).sample([[0.5], [value]]),
            lambda: aliascope.render("edge", "embree", "uniform:n=1", size=(4, 3), time_limit=value),
        ]
    for call in calls:
        with pytest.raises(AliascopeError, match=shown):
            call()
