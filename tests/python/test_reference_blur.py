"""References of surfaces that slide under a shutter or lie out of a lens's focus: against quadrature and by hand."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
import shapely
import shapely.affinity
from reference_scenes import BACKGROUND, COLOURS, SIZE, box, disc, polygon, scene
from scipy.integrate import dblquad

from aliascope import motion
from aliascope.errors import Unsupported
from aliascope.geometry import frame_of
from aliascope.model import Scene
from aliascope.native import tracer
from aliascope.references import make
from aliascope.references.defocus import blurred_circle, blurred_polygon, quadrant_area, quadrant_moment
from aliascope.references.polygons import coverage
from aliascope.references.projection import Circle
from aliascope.references.quadrature import integrate

FRAME = frame_of(scene(), SIZE)
RED = np.array(COLOURS["red"]) - BACKGROUND


def slides(surface: dict[str, object], x: float, y: float) -> dict[str, object]:
    """The surface, moving by so many pixels, right and down, in a unit of time."""
    return surface | {"motion": {"type": "translate", "by": [x, -y, 0.0]}}


def shutter(opening: float, closing: float, response: str = "box") -> dict[str, object]:
    return {
        "type": "orthographic",
        "eye": [0, 0, 16],
        "look_at": [0, 0, 0],
        "height": SIZE[1],
        "shutter": [opening, closing],
        "response": response,
    }


MOVING = {
    "one polygon": [slides(polygon([(2.3, 1.2), (5.7, 2.1), (5.1, 5.9), (3.3, 3.4)]), 4.7, 1.9)],
    "horizontally and vertically": [
        slides(box(1.3, 1.2, 3.7, 3.4), 5.3, 0.0),
        slides(box(9.3, 1.2, 11.1, 3.9), 0.0, 3.1),
    ],
    "less than a pixel": [slides(polygon([(2.3, 1.2), (5.7, 2.1), (5.1, 5.9)]), 0.03, -0.07)],
    "layers that move together": [
        slides(box(1.3, 1.2, 5.7, 5.9), 3.3, 1.7),
        slides(polygon([(2.1, 0.4), (6.9, 3.1), (2.4, 4.9)], 1.0, "green"), 3.3, 1.7),
        slides(polygon([(3.1, 2.0), (5.0, 2.2), (4.1, 7.1)], 2.0, "blue"), 3.3, 1.7),
    ],
    "before one that stands, behind another": [
        box(0.3, 0.4, 11.2, 8.1, -2.0, "green"),
        slides(box(2.3, 1.9, 4.1, 3.2), 3.9, 1.3),
        slides(box(6.3, 6.9, 6.9, 7.4, -3.0, "blue"), 1.9, 0.3),
    ],
    "on a polygon that moves too": [
        slides(box(1.2, 1.1, 9.3, 7.9), 0.7, 0.4),
        slides(box(4.4, 3.7, 5.1, 4.9, 1.0, "blue"), 0.9, -0.8),
    ],
}


@pytest.mark.parametrize("response", ["box", "triangle"])
@pytest.mark.parametrize("name", MOVING)
def test_sliding_polygons_are_the_mean_of_their_moments(name: str, response: str) -> None:
    of = scene(*MOVING[name], camera=shutter(0.17, 0.83, response))
    found = make(of, SIZE)
    assert found.method == "moving-polygons"
    assert 0.0 < found.error < 1e-11
    moments = 90
    share = (np.arange(moments) + 0.5) / moments
    weights = np.ones(moments) if response == "box" else 2.0 - np.abs(4.0 * share - 2.0)
    stills = [make(motion.at(of, 0.17 + 0.66 * each), SIZE).exact for each in share]
    mean = np.tensordot(weights / moments, np.array(stills), axes=1)
    # The midpoint rule at a dozen kinks of slopes up to 5 pixels: an eighth of h^2 of each, h = 0.66 / 90 of time.
    assert np.abs(found.exact - mean).max() < 2e-4
    opened = make(motion.at(of, 0.17), SIZE).exact
    assert np.abs(found.exact - opened).max() > 50 * np.abs(found.exact - mean).max()


@pytest.mark.parametrize("response", ["box", "triangle"])
def test_a_translating_edge_against_quadrature_of_20_digits(response: str) -> None:
    """An upright edge from x = 2.3 that moves by 5.1 pixels a unit of time: pixel (x, y) is covered by the mean of
    clamp(x + 1 - edge, 0, 1)."""
    of = scene(slides(box(2.3, -3.0, 40.0, 12.0), 5.1, 0.0), camera=shutter(0.25, 0.75, response))
    found = make(of, SIZE).exact[4, :, 0]
    for x in range(SIZE[0]):

        def covered(t: mpmath.mpf, x: int = x) -> mpmath.mpf:
            weight = 2 if response == "box" else 4 * (1 - abs(4 * t - 2))
            return weight * min(max(x + 1 - mpmath.mpf("2.3") - mpmath.mpf("5.1") * t, 0), 1)

        breaks = [mpmath.mpf(side - 2.3) / mpmath.mpf("5.1") for side in (x, x + 1)]
        inner = sorted(
            {mpmath.mpf(1) / 4, mpmath.mpf(1) / 2, mpmath.mpf(3) / 4, *(b for b in breaks if 0.25 < b < 0.75)}
        )
        expected = BACKGROUND[0] + RED[0] * float(mpmath.quad(covered, inner))
        assert abs(found[x] - expected) < 1e-14  # doubles of numbers below 1, a few roundings


def test_perspective_scales_the_way() -> None:
    """At twice the depth half the pixels: the same picture as the orthographic one of the plane z = 0."""
    flat = shutter(0.1, 0.9)
    lens = flat | {"type": "perspective", "vertical_fov_degrees": 2 * math.degrees(math.atan(4.5 / 16))}
    del lens["height"]
    of = slides(polygon([(2.3, 1.2), (5.7, 2.1), (5.1, 5.9)]), 3.7, 1.9)
    assert np.abs(make(scene(of, camera=flat), SIZE).exact - make(scene(of, camera=lens), SIZE).exact).max() < 1e-12


def disc_area(a: float, b: float) -> float:
    """The part of the unit disc with x < a and y < b, by quadrature."""

    def across(y: float) -> float:
        w = math.sqrt(max(0.0, 1.0 - y * y))
        return max(0.0, min(a, w) + w)

    h = math.sqrt(max(0.0, 1.0 - a * a))
    ends = sorted({-1.0, *(y for y in (-h, h) if y < b), min(1.0, b)})
    return float(mpmath.quad(lambda y: across(float(y)), ends)) if b > -1.0 else 0.0


def test_quadrants_of_the_disc_against_quadrature() -> None:
    rng = np.random.default_rng(7)
    for a, b in [*rng.uniform(-1.3, 1.3, (40, 2)), (0.0, 0.0), (-0.6, -0.8), (2.0, -0.3), (3.0, 3.0), (0.6, -0.9)]:
        area = disc_area(a, b)
        assert abs(quadrant_area(np.array(a), np.array(b)) - area) < 1e-7  # of the quadrature at its root ends
        # d/da of the moment is the area.
        step = 1e-5
        ends = quadrant_moment(np.array([a - step, a + step]), np.array(b))
        assert abs((ends[1] - ends[0]) / (2 * step) - quadrant_area(np.array(a), np.array(b))) < 1e-5
    assert quadrant_moment(np.array(-1.5), np.array(2.0)) == 0.0
    assert abs(quadrant_moment(np.array(1.0), np.array(2.0)) - math.pi) < 1e-15


def segment(depth: float, radius: float) -> float:
    """The share of a disc that lies farther than `depth` from its middle."""
    x = min(1.0, max(-1.0, depth / radius))
    return (math.acos(x) - x * math.sqrt(1.0 - x * x)) / math.pi


@pytest.mark.parametrize("radius", [0.3, 1.7, 4.1])
def test_a_defocused_edge_against_quadrature(radius: float) -> None:
    """A half plane, leaning: the share of the lens that sees it is a circular segment, known in closed form."""
    normal = np.array([math.cos(0.37), math.sin(0.37)])
    along, middle = np.array([-normal[1], normal[0]]), np.array([5.3, 4.2])
    corners = [
        middle - 60 * along,
        middle + 60 * along,
        middle + 60 * along - 90 * normal,
        middle - 60 * along - 90 * normal,
    ]
    found, error = blurred_polygon(shapely.Polygon(corners), radius, FRAME)
    assert error < 1e-10
    for x, y in [(5, 4), (3, 6), (7, 1), (5, 0), (2, 2)]:
        expected, _ = dblquad(
            lambda v, u: segment((u - 5.3) * normal[0] + (v - 4.2) * normal[1], radius), x, x + 1, y, y + 1, epsabs=1e-9
        )
        assert abs(found.area[y, x] - expected) < 1e-8  # of the quadrature, which meets a root


@pytest.mark.parametrize("radius", [1e-6, 0.4, 1.1, 3.9])
@pytest.mark.parametrize(
    "corners", [[(3.3, 1.2), (8.9, 2.7), (5.1, 7.3)], [(4.2, 3.1), (4.9, 3.3), (4.6, 3.8), (4.4, 3.4)]]
)
def test_a_defocused_polygon_is_the_mean_over_the_lens(corners: list[tuple[float, float]], radius: float) -> None:
    region = shapely.Polygon(corners)
    found, error = blurred_polygon(region, radius, FRAME)
    assert error < 1e-10
    rings, turns = 24, 36
    total = np.zeros(SIZE[::-1])
    for ring in range(rings):
        r = radius * math.sqrt((ring + 0.5) / rings)
        for turn in range(turns):
            angle = 2 * math.pi * (turn + 0.618 * ring) / turns
            moved = shapely.affinity.translate(region, r * math.cos(angle), r * math.sin(angle))
            total += coverage(moved, *SIZE).area
    # 864 points of a spiral stand for cells of the lens, each as wide as 3 % of it.
    assert np.abs(found.area - total / (rings * turns)).max() < 2e-3 * min(1.0, radius)
    assert abs(found.area.sum() - region.area) < 1e-9 or radius > 1.2  # what stays on the picture keeps its area


@pytest.mark.parametrize(("a", "radius"), [(1.9, 0.7), (0.6, 1.9), (1.3, 1.3), (0.02, 2.3), (2.3, 1e-6), (1.7, 1e-13)])
def test_a_defocused_disc_against_quadrature(a: float, radius: float) -> None:
    """The share of the lens that sees a disc is the common area of two circles, known in closed form."""
    circle = Circle(5.37, 4.21, a)
    found, error = blurred_circle(circle, radius, FRAME)
    assert error < 1e-9
    assert abs(found.area.sum() - math.pi * a * a) < 1e-10

    def common(d: float) -> float:
        if d >= a + radius:
            return 0.0
        if d <= abs(a - radius):
            return min(1.0, (a / radius) ** 2)
        one = math.acos((d * d + a * a - radius * radius) / (2 * d * a))
        other = math.acos((d * d + radius * radius - a * a) / (2 * d * radius))
        both = a * a * (one - math.sin(2 * one) / 2) + radius * radius * (other - math.sin(2 * other) / 2)
        return both / (math.pi * radius * radius)

    if radius < 0.1:
        return  # a step, for the quadrature
    for x, y in [(5, 4), (6, 5), (4, 5), (7, 4), (5, 6)]:
        expected, _ = dblquad(lambda v, u: common(math.hypot(u - 5.37, v - 4.21)), x, x + 1, y, y + 1, epsabs=1e-7)
        assert abs(found.area[y, x] - expected) < 1e-6  # of the quadrature, which meets roots


LENS = {
    "type": "perspective",
    "eye": [0, 0, 16],
    "look_at": [0, 0, 0],
    "vertical_fov_degrees": 2 * math.degrees(math.atan(4.5 / 16)),
    "lens_radius": 2.0,
    "focus_distance": 14.0,
}
"""A circle of confusion of 2 * (1/14 - 1/16) * 16 = 2/7 of a pixel at z = 0."""


def test_a_lens_in_a_scene() -> None:
    of = scene(
        box(-20.0, -20.0, 40.0, 40.0, -4.0, "green"),
        polygon([(2.3, 1.2), (5.7, 2.1), (4.1, 5.9)]),
        polygon([(5.7, 2.1), (7.9, 4.4), (4.1, 5.9)], 0.0, "blue"),
        disc(9.1, 6.2, 1.1, 1.0),
        camera=LENS,
    )
    found = make(of, SIZE)
    assert found.method == "defocus"
    assert 0.0 < found.error < 1e-9
    built = tracer.Tracer(of, SIZE)
    pictures = np.array([built.render("sobol:scramble=shift", 4096, seed, 1, "box")[0] for seed in range(16)], float)
    mean, error = pictures.mean(axis=0), pictures.std(axis=0, ddof=1) / 4
    # Student's t of 15 degrees, 324 values, 1 in 1000 for all: 6.3. A part of a pixel that none of 65,536 samples met
    # is smaller than 15 of them. 1e-7: float32.
    assert np.all(np.abs(mean - found.exact) < 6.3 * error + np.where(error == 0.0, 15 / 65536, 0.0) + 2e-7)
    # Seen through the middle of the lens alone, the picture is another one.
    sharp = make(scene(*[s.model_dump() for s in of.surfaces], camera=LENS | {"lens_radius": 0.0}), SIZE).exact
    assert np.abs(sharp - found.exact).max() > 0.02


def test_the_circle_of_confusion_is_two_sevenths_of_a_pixel() -> None:
    edge = scene(box(5.9, -30.0, 60.0, 40.0), camera=LENS)
    found = (make(edge, SIZE).exact[4, :, 0] - BACKGROUND[0]) / RED[0]
    mean = float(mpmath.quad(lambda x: segment(float(5.9 - x), 2 / 7), [5, 5.9 - 2 / 7, 6]))
    assert abs(found[5] - mean) < 1e-7
    assert abs(found[4]) < 1e-15


REFUSED = {
    "blurs that overlap": (
        scene(slides(box(1, 1, 4, 4), 3, 0), box(5, 2, 7, 6, -1.0), camera=shutter(0, 1)),
        "blur over",
    ),
    "over an edge": (scene(slides(box(1, 1, 4, 4), 3, 0), box(-5, -2, 5, 6, -1.0), camera=shutter(0, 1)), "blur over"),
    "on what slides from under it": (
        scene(slides(box(1, 1, 6, 6), 3, 0), box(2, 2, 5, 5, 1.0, "blue"), camera=shutter(0, 1)),
        "blur over",
    ),
    "turning": (
        scene(
            box(1, 1, 5, 5) | {"motion": {"type": "rotate", "axis": [0, 0, 1], "degrees": 10.0}}, camera=shutter(0, 1)
        ),
        "turns",
    ),
    "toward the viewer": (
        scene(box(1, 1, 5, 5) | {"motion": {"type": "translate", "by": [1, 0, 1]}}, camera=shutter(0, 1)),
        "toward the viewer",
    ),
    "tilted and moving": (
        scene(slides(polygon([(1, 1, 0), (5, 1, 1), (5, 5, 1)]), 1, 0), camera=shutter(0, 1)),
        "not parallel to the picture",
    ),
    "two at one depth that meet": (
        scene(slides(box(4.4, 4.3, 5, 5), 1, 0), box(-5, -2, 15, 16, 0.0, "blue"), camera=shutter(0, 1)),
        "same depth",
    ),
    "a moving disc": (scene(slides(disc(5, 5, 2), 1, 0), camera=shutter(0, 1)), "no answer for disc"),
    "a lens with blades": (scene(box(1, 1, 5, 5), camera=LENS | {"blades": 6}), "blades"),
    "a lens before a tilted polygon": (scene(polygon([(1, 1, 0), (5, 1, 1), (5, 5, 1)]), camera=LENS), "not parallel"),
    "a lens before what overlaps": (scene(box(1, 1, 5, 5), box(3, 3, 7, 7, 1.0, "blue"), camera=LENS), "blur over"),
    "a lens, near the blurred border of what is behind": (
        scene(box(-2, -2, 8, 12, -4.0, "green"), disc(6.6, 4.5, 0.5), camera=LENS),
        "blur over",
    ),
    "a lens and motion": (
        scene(slides(box(1, 1, 5, 5), 1, 0), camera=LENS | {"shutter": [0.0, 1.0]}),
        '"defocus" has no answer for motion',
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_blurs_without_an_exact_answer_is_refused(name: str) -> None:
    of, reason = REFUSED[name]
    with pytest.raises(Unsupported, match=reason):
        make(of, SIZE)


def test_what_does_not_move_needs_another_method() -> None:
    still: Scene = scene(box(1, 1, 5, 5))
    assert make(still, SIZE).method == "polygons"


def test_integrals_between_breaks_with_roots_at_them() -> None:
    breaks = np.array([[0.0, 0.3, 1.0], [0.0, 0.0, 1.0]])
    found, error = integrate(lambda owner, t: np.sqrt(np.abs(t - 0.3 * (1 - owner[:, np.newaxis]))), breaks)
    expected = [2 / 3 * (0.3**1.5 + 0.7**1.5), 2 / 3]
    assert np.abs(found - expected).max() <= error + 1e-15
    assert error < 1e-12
    with pytest.raises(Unsupported, match="does not settle"):
        integrate(lambda owner, t: 1 / np.maximum(t, 1e-300), np.array([[0.0, 1.0]]))
