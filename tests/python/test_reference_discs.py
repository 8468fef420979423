"""Areas of circles in pixels, against quadrature with 30 digits."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aliascope.references.discs import circle_coverage
from aliascope.references.projection import Circle

TOLERANCE = 1e-13  # the centre relative to a pixel, and a few roots and products of numbers near 1


def area_in_pixel(circle: Circle, x: int, y: int) -> mpmath.mpf:
    """The integral, over the pixel's width, of how much of the column lies in the circle."""
    with mpmath.workdps(30):
        cx, cy, r = (mpmath.mpf(c) for c in (circle.x, circle.y, circle.radius))

        def length(at: mpmath.mpf) -> mpmath.mpf:
            square = (r - (at - cx)) * (r + (at - cx))
            half = mpmath.sqrt(max(square, mpmath.mpf(0)))
            return max(min(cy + half, y + 1) - max(cy - half, y), mpmath.mpf(0))

        # The integrand has its kinks where the circle meets the pixel's rows, and its roots at the circle's ends.
        breaks = [mpmath.mpf(x), mpmath.mpf(x + 1), cx - r, cx + r]
        for line in (y, y + 1):
            square = (r - (line - cy)) * (r + (line - cy))
            if square > 0:
                breaks += [cx - mpmath.sqrt(square), cx + mpmath.sqrt(square)]
        inside = sorted({b for b in breaks if x <= b <= x + 1})
        return mpmath.quad(length, inside) if len(inside) > 1 else mpmath.mpf(0)


def compare(circle: Circle, width: int, height: int, most: int = 24, tolerance: float = TOLERANCE) -> None:
    """Some of the pixels that the circle cuts; all others must be 0 or 1, as their middles say."""
    found = circle_coverage(circle, width, height).area
    rows, columns = np.nonzero((found > 0) & (found < 1))
    for i in np.unique(np.linspace(0, len(rows) - 1, min(most, len(rows))).astype(int)):
        expected = area_in_pixel(circle, int(columns[i]), int(rows[i]))
        assert abs(found[rows[i], columns[i]] - expected) <= tolerance, (circle, columns[i], rows[i])
    whole = (found == 0) | (found == 1)
    y, x = np.indices(found.shape) + 0.5
    inside = np.hypot(x - circle.x, y - circle.y) < circle.radius
    # A pixel of area 0 or 1 whose middle is on the other side is one that the circle only just touches, or a tiny one.
    wrong = whole & (inside != (found == 1))
    assert not wrong[np.abs(np.hypot(x - circle.x, y - circle.y) - circle.radius) > 0.71].any()


CIRCLES = {
    "ordinary": Circle(5.3, 4.1, 3.7),
    "within a pixel": Circle(5.3, 4.4, 0.21),
    "a pixel's size": Circle(5.3, 4.4, 0.55),
    "over one side, by a hair": Circle(5.3, 4.25, 0.25 + 1e-9),
    "tangent to one side": Circle(5.5, 4.25, 0.25),
    "tangent to all sides": Circle(5.5, 4.5, 0.5),
    "through the corners": Circle(5.5, 4.5, math.sqrt(0.5)),
    "through corners, 3-4-5": Circle(6.0, 5.0, 5.0),
    "tangent to many lines": Circle(6.0, 5.0, 4.0),
    "centre on a corner": Circle(6.0, 5.0, 0.4),
    "centre on a side": Circle(6.3, 5.0, 0.4),
    "centre just outside": Circle(5.999999, 4.3, 0.2),
    "tiny": Circle(5.3, 4.4, 1e-5),
    "tiny, on a corner": Circle(5.0, 4.0, 1e-5),
    "tiny, on a side": Circle(5.0, 4.4, 1e-7),
    "less than the numbers near it": Circle(5.3, 4.4, 1e-17),
    "past the border": Circle(-1.3, 4.4, 3.3),
    "outside": Circle(-5.3, 4.4, 3.3),
    "large": Circle(-90.3, -45.7, 107.9),
    "huge": Circle(-70000.25, 50000.5, 86026.3),
    "huge, flat": Circle(6.25, -99999.5, 100004.1),
    "huge, tangent to a row": Circle(6.25, -99995.5, 100000.5),
    "huge, past a power of two": Circle(-51.3, -65530.3, 65536.4),
    "enormous": Circle(-7e7 + 0.3, 5.2, 7e7 + 5.1),
}


@pytest.mark.parametrize("name", CIRCLES)
def test_areas_are_those_of_quadrature(name: str) -> None:
    compare(CIRCLES[name], 12, 10)


def test_the_huge_ones_cross_the_picture() -> None:
    for name in ("large", "huge", "huge, flat", "huge, tangent to a row", "enormous"):
        found = circle_coverage(CIRCLES[name], 12, 10).area
        assert ((found > 0) & (found < 1)).sum() >= 10, name
        assert 0.0 in found, name
        assert 1.0 in found, name


@settings(max_examples=80, deadline=None)
@given(
    x=st.floats(-2.0, 14.0, allow_subnormal=False),
    y=st.floats(-2.0, 12.0, allow_subnormal=False),
    exponent=st.floats(-8.0, 2.0),
)
def test_any_circle(x: float, y: float, exponent: float) -> None:
    compare(Circle(x, y, 10.0**exponent), 12, 10, most=3)


@settings(max_examples=80, deadline=None)
@given(quarters=st.tuples(st.integers(0, 48), st.integers(0, 40)), radius=st.integers(1, 24))
def test_circles_on_a_grid_touch_lines_and_corners(quarters: tuple[int, int], radius: int) -> None:
    compare(Circle(quarters[0] / 4, quarters[1] / 4, radius / 4), 12, 10, most=3)


@settings(max_examples=100, deadline=None)
@given(
    x=st.floats(20.0, 40.0, allow_subnormal=False),
    y=st.floats(20.0, 40.0, allow_subnormal=False),
    exponent=st.floats(-7.0, math.log10(19.0)),
)
def test_areas_sum_to_the_area_of_the_circle(x: float, y: float, exponent: float) -> None:
    radius = 10.0**exponent
    # At most 8 (r + 1) pixels are cut, each within 1e-14.
    assert abs(circle_coverage(Circle(x, y, radius), 60, 60).area.sum() - math.pi * radius**2) < 8e-14 * (radius + 1)


def test_growing_by_a_hair_grows_by_a_hair() -> None:
    """Steps at tangency, where a circle turns from none to one or to two arcs in a pixel, would show here."""
    for middle in (0.25, 0.5, math.hypot(0.5, 0.25), 0.75, math.hypot(0.5, 0.75)):
        radii = middle + np.linspace(-1e-6, 1e-6, 201)
        areas = np.array([circle_coverage(Circle(5.5, 4.25, r), 12, 10).area[3:6, 4:7] for r in radii])
        # The area grows by at most its arc, 2 pi r, times the step of 1e-8.
        assert np.diff(areas, axis=0).min() >= -1e-15
        assert np.diff(areas, axis=0).max() <= 2 * math.pi * middle * 1.1e-8
