"""Areas of polygons in pixels, against exact fractions."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_scenes import scene

from aliascope.geometry import frame_of
from aliascope.references.canvas import Canvas, Coverage
from aliascope.references.polygons import coverage, coverage_error
from aliascope.references.visibility import depth_order

WIDTH, HEIGHT = 12, 9
Corner = tuple[Fraction, Fraction]
# Coordinates up to 12 are cut within eps 12; an area sums a few such pieces.
TOLERANCE = 1e-13


def area_in_pixel(corners: list[tuple[float, float]], x: int, y: int) -> Fraction:
    """The area of a simple polygon in a pixel, exactly: clipped to the four sides (Sutherland and Hodgman 1974).

    Clipping a concave polygon leaves edges along the sides that are run through both ways; they enclose nothing.
    """
    polygon = [(Fraction(a), Fraction(b)) for a, b in corners]
    for axis, side, sign in ((0, x, 1), (0, x + 1, -1), (1, y, 1), (1, y + 1, -1)):
        clipped: list[Corner] = []
        for first, second in itertools.pairwise([*polygon, *polygon[:1]]):
            before, after = sign * (first[axis] - side), sign * (second[axis] - side)
            if before >= 0:
                clipped.append(first)
            if (before < 0) != (after < 0):
                t = before / (before - after)
                clipped.append(tuple(a + t * (b - a) for a, b in zip(first, second, strict=True)))  # type: ignore[arg-type]
        polygon = clipped
    pairs = itertools.pairwise([*polygon, *polygon[:1]])
    return abs(sum((a[0] * b[1] - b[0] * a[1] for a, b in pairs), Fraction(0))) / 2


def compare(corners: list[tuple[float, float]], tolerance: float = TOLERANCE) -> None:
    found = coverage(shapely.Polygon(corners), WIDTH, HEIGHT).area
    expected = np.array([[float(area_in_pixel(corners, x, y)) for x in range(WIDTH)] for y in range(HEIGHT)])
    assert np.abs(found - expected).max() <= tolerance


SHAPES = {
    "triangle": [(1.3, 0.7), (10.1, 3.3), (4.9, 8.2)],
    "concave": [(1.1, 1.2), (10.7, 1.9), (9.3, 7.7), (5.2, 2.3), (2.4, 7.1)],
    "on pixel borders": [(2.0, 1.0), (9.0, 1.0), (9.0, 7.0), (2.0, 7.0)],
    "corners on corners, slanted": [(1.0, 1.0), (10.0, 4.0), (7.0, 8.0)],
    "along a diagonal of the pixels": [(1.0, 1.0), (8.0, 8.0), (1.0, 8.0)],
    "within one pixel": [(4.2, 3.1), (4.9, 3.3), (4.4, 3.8)],
    "a needle": [(0.5, 0.5), (11.4, 8.3), (11.4, 8.3 + 1e-9)],
    "tiny": [(4.5, 3.5), (4.5 + 1e-7, 3.5 + 2e-8), (4.5 + 3e-8, 3.5 + 1e-7)],
    "the whole picture": [(-3.0, -3.0), (20.0, -3.0), (20.0, 15.0), (-3.0, 15.0)],
    "past every border": [(-5.3, 4.1), (6.2, -7.7), (19.9, 5.3), (5.1, 17.4)],
    "outside": [(-5.3, 4.1), (-2.2, -7.7), (-1.1, 5.3)],
    "a corner next to nothing from the border": [(0.0, 1.0), (0.0, -1.3e-253), (13.0, 1e-11)],
    "nearly level": [(0.0, 4.0 - 1e-13), (12.0, 4.0 + 1e-13), (12.0, 6.0), (0.0, 6.0)],
}


@pytest.mark.parametrize("name", SHAPES)
def test_areas_are_those_of_exact_fractions(name: str) -> None:
    compare(SHAPES[name])
    compare(SHAPES[name][::-1])


def test_edges_far_outside_stay_in_place() -> None:
    # The clip to the picture rounds where an edge of length 2e6 meets it: 1e6 eps = 2e-10, were it not for GEOS's
    # double-double intersections, which leave a few eps of the picture.
    compare([(-1e6, -3e5), (1e6 + 3.0, 3e5 + 2.0), (1e6, 4e5), (-1e6, 2.0)])


corners = st.lists(st.tuples(st.floats(-3.0, 15.0), st.floats(-3.0, 12.0)), min_size=3, max_size=3)


@settings(max_examples=60, deadline=None)
@given(corners)
def test_any_triangle(triangle: list[tuple[float, float]]) -> None:
    shape = shapely.Polygon(triangle)
    if shape.is_valid and shape.area > 1e-6:
        compare(triangle)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 12), st.integers(0, 9)), min_size=3, max_size=3))
def test_triangles_with_corners_on_pixel_corners(triangle: list[tuple[int, int]]) -> None:
    if shapely.Polygon(triangle).area > 0:
        compare([(float(x), float(y)) for x, y in triangle])


def star(y: float = 48.3) -> shapely.Polygon:
    rng = np.random.default_rng(5)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 300))
    radius = rng.uniform(10, 45, 300)
    return shapely.Polygon(np.column_stack([64.1 + radius * np.cos(angle), y + radius * np.sin(angle)]))


def test_areas_sum_to_the_area_of_the_polygon() -> None:
    shape = star()
    # 3000 pixels, each within a few eps of the coordinates, 128: 3000 * 3e-14 at the worst.
    assert abs(coverage(shape, 128, 96).area.sum() - shape.area) < 1e-10


def test_holes_and_several_parts() -> None:
    shape = shapely.box(1.5, 1.5, 9.5, 7.5) - shapely.box(3.25, 3.25, 6.5, 5.5)
    island = shapely.box(4.5, 4.25, 5.25, 4.75)
    found = coverage(shapely.union_all([shape, island]), WIDTH, HEIGHT).area
    assert found[3, 3] == 1 - 0.75 * 0.75  # dyadic: nothing rounds
    assert found[4, 4] == 0.5 * 0.5
    assert found[4, 5] == 0.25 * 0.5
    assert found[4, 6] == 0.5
    assert found[2, 2] == 1.0
    assert found.sum() == shape.area + island.area


def test_pixels_that_no_edge_touches_are_exactly_0_or_1() -> None:
    for y in (48.3, 0.3):  # in row 0 coordinates have digits that the sums round away
        found = coverage(star(y), 128, 96)
        untouched = found.length == 0.0
        assert set(np.unique(found.area[untouched]).tolist()) == {0.0, 1.0}


def test_the_length_of_edges_in_pixels_sums_to_the_outline() -> None:
    shape = shapely.Polygon(SHAPES["concave"])
    assert coverage(shape, WIDTH, HEIGHT).length.sum() == pytest.approx(shape.length, rel=1e-14)


def test_parts_that_leave_a_gap_are_in_the_error_bound() -> None:
    """Should the Booleans go wrong, the outline of all polygons together tells."""
    order, frame = depth_order([]), frame_of(scene(), (WIDTH, HEIGHT))
    canvas = Canvas(WIDTH, HEIGHT)
    assert coverage_error(frame, [], order, canvas) == 0.0
    area = np.zeros((HEIGHT, WIDTH))
    area[3, 4] = 1e-7
    canvas.add(Coverage(area, np.zeros_like(area)), np.ones(3), 1.0)
    assert coverage_error(frame, [], order, canvas) == 1e-7


def test_an_empty_region_covers_nothing() -> None:
    found = coverage(shapely.Polygon(), WIDTH, HEIGHT)
    assert not found.area.any()
    assert not found.length.any()
