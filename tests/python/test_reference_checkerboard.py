"""The checkerboard to the horizon: against rays, scan lines, another split, the other axis, and mpmath."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from reference_scenes import box, brute_force, reference_of, scene, stored

from aliascope.errors import Unsupported
from aliascope.geometry import frame_of
from aliascope.model import Checker, Plane, Scene
from aliascope.references import Ambiguous, checkerboard, lattice, make
from aliascope.references.checkerboard import Board, board_of, far_part, half_plane, near_part

SIZE = (12, 9)
COLOURS = [[0.05, 0.06, 0.04], [0.9, 0.8, 0.85]]
PATTERN = {"type": "checker", "scale": 1.3, "origin": [0.137, 0.2917, 0.0733], "colours": COLOURS}
CAMERA = {"type": "perspective", "eye": [0.3, 1.2, 4.2], "look_at": [-2.1, 0.4, 0], "vertical_fov_degrees": 47.0}
ROLLED = CAMERA | {"up": [0.3, 1, 0.1]}


def floor(camera: dict[str, object] = CAMERA, **changes: object) -> Scene:
    plane = {"type": "plane", "material": "board", "point": [0, 0, 0], "normal": [0, 1, 0]}
    scale = {"scale": changes.pop("scale", PATTERN["scale"])}
    materials = {"board": {"emission": [1.0, 0.8, 0.5], "pattern": PATTERN | scale}}
    return scene(plane | changes, camera=camera, materials=materials)


def parts(of: Scene, size: tuple[int, int]) -> tuple[Board, object]:
    plane, frame = of.surfaces[0], frame_of(of, size)
    assert isinstance(plane, Plane)
    pattern = of.materials[plane.material].pattern
    assert isinstance(pattern, Checker)
    return board_of(plane, pattern, frame), frame


SCENES = {
    "level": floor(),
    "rolled": floor(ROLLED),
    "ceiling": floor(ROLLED | {"look_at": [-2.1, 2.4, 0]}, point=[0, 3.1, 0]),
    "wall across x": floor(ROLLED | {"look_at": [1.0, 0.4, -3]}, normal=[-2, 0, 0], point=[3.3, 0, 0]),
    "wall across z": floor(ROLLED, normal=[0, 0, 1], point=[0, 0, -2.17]),
    "orthographic": floor({"type": "orthographic", "eye": [0.3, 5.2, 4.2], "look_at": [-2.1, 0.4, 0], "height": 6.0}),
    "parallel to the picture": floor(CAMERA | {"look_at": [0.3, 1.2, 0]}, normal=[0, 0, 1], point=[0, 0, -3]),
    "fine squares": floor(ROLLED, scale=300.0),
    "close to the floor": floor(CAMERA | {"eye": [0.3, 1e-3, 4.2]}),
}


@pytest.mark.parametrize("name", SCENES)
def test_views_agree_with_a_million_rays(name: str) -> None:
    of = SCENES[name]
    reference = make(of, SIZE)
    assert reference.method == "checkerboard"
    assert reference.error < 5e-10
    board, _ = parts(of, SIZE)
    corners = board.nearness[:2] @ np.indices((13, 10)).reshape(2, -1) + board.nearness[2]
    signs = np.sign(corners).reshape(13, 10)
    on_horizon = np.argwhere(np.abs(signs[:-1, :-1] + signs[1:, :-1] + signs[:-1, 1:] + signs[1:, 1:]) < 4)
    chosen = [tuple(on_horizon[len(on_horizon) // 2])] if len(on_horizon) else []
    for seed, (x, y) in enumerate([*chosen, (3, 7), (8, 2), (11, 8)]):
        mean, standard_error = brute_force(of, SIZE, (int(x), int(y)), seed)
        # 5 standard errors: about 1 in 2 million for each value; 1e-9 for pixels of one colour.
        assert np.all(np.abs(reference.exact[y, x] - mean) <= 5 * standard_error + 1e-9), (x, y)


def test_horizon_pixels_of_the_scene_agree_with_a_million_rays() -> None:
    of, exact = stored("checker-horizon"), reference_of("checker-horizon").exact
    for seed, (x, y) in enumerate(((3, 26), (65, 26), (66, 26), (119, 26))):
        mean, standard_error = brute_force(of, (128, 96), (x, y), seed)
        assert np.all(np.abs(exact[y, x] - mean) <= 5 * standard_error), (x, y)


@pytest.mark.parametrize("name", ["level", "rolled", "ceiling", "wall across x"])
def test_squares_one_by_one_and_borders_agree(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the two halves of the method meet is free: four times as far, ten times as many squares are polygons."""
    of = SCENES[name]
    here = make(of, SIZE)
    monkeypatch.setattr(lattice, "DEEP", 4 * lattice.DEEP)
    there = make(of, SIZE)
    # Both leave out the same, CUT, toward the horizon. Squares by the thousand, 1e-16 each.
    assert np.abs(here.exact - there.exact).max() < 2e-12


@pytest.mark.parametrize("name", ["rolled", "ceiling", "wall across x"])
def test_both_axes_give_the_same(name: str) -> None:
    """Summation in b instead of a: other integrands, along the same borders, with other rests toward the horizon."""
    board, frame = parts(SCENES[name], SIZE)
    order = [1, 0]
    swapped = Board(
        eye=board.eye[order],
        across=board.across[order],
        nearness=board.nearness,
        to_picture=board.to_picture[:, [1, 0, 2]],
        slope=lattice.Slope(-board.slope.c, board.slope.along_b, board.slope.along_a),
        sign=board.sign,
    )
    level = 1.0 / (1.5 * lattice.DEEP * board.slope.steepness)
    one, one_error = far_part(board, frame, level)
    other, other_error = far_part(swapped, frame, level)
    assert np.abs(one).max() > 1e-4
    # The farther axis's terms end at MOST_TERMS: its remainder is larger.
    remainder = swapped.slope.terms(1.0 / level, 1e-17)[1]
    assert np.all(np.abs(one - other) <= one_error + other_error + remainder + 1e-13)
    assert np.abs(one - other).max() < 1e-11  # measured: 2e-12


def test_pixels_below_the_horizon_agree_with_scan_lines() -> None:
    """Closed form along the scan line between breaks, 20 Gauss-Legendre nodes down it between breaks of that."""
    of = SCENES["rolled"]
    board, _ = parts(of, SIZE)
    exact = make(of, SIZE).exact
    low, high = (np.array(c) * np.array([1.0, 0.8, 0.5]) for c in COLOURS)
    for x, y in ((2, 8), (7, 6), (5, 7)):
        wave = board.sign * scan_lines(board, x, y)
        expected = low * (1 + wave) / 2 + high * (1 - wave) / 2
        assert np.abs(exact[y, x] - expected).max() < 1e-12, (x, y)


def scan_lines(board: Board, x: int, y: int) -> float:
    """The mean of s(a) s(b) over a pixel. Between two heights at which a border of squares meets another, or a side of
    the pixel, the breaks of a scan line move along straight lines: the outer integral is of affine functions."""
    corners = board.at(np.array([[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]], dtype=float))[:, :2]
    first, last = np.floor(corners.min(axis=0)).astype(int), np.ceil(corners.max(axis=0)).astype(int)
    heights = [0.0, 1.0]
    rows = board.to_picture
    for i in range(first[0], last[0] + 1):
        for j in range(first[1], last[1] + 1):
            px, py, w = rows @ np.array([i, j, 1.0])
            if w > 0 and x < px / w < x + 1:
                heights.append(py / w - y)
    borders = [(axis, k) for axis in (0, 1) for k in range(first[axis], last[axis] + 1)]
    lines = [board.across[axis] + (board.eye[axis] - k) * board.nearness for axis, k in borders]
    for line in lines:  # a = k is a line on the picture
        if line[1] != 0.0:
            heights.extend(-(line[0] * side + line[2]) / line[1] - y for side in (x, x + 1))
    heights = sorted({h for h in heights if 0.0 <= h <= 1.0})
    nodes, weights = np.polynomial.legendre.leggauss(20)
    total = 0.0
    for begin, end in itertools.pairwise(heights):
        for node, weight in zip(nodes, weights, strict=True):
            height = y + (begin + end) / 2 + (end - begin) / 2 * node
            breaks = [-(line[1] * height + line[2]) / line[0] for line in lines if line[0] != 0.0]
            ends = np.array(sorted({x, x + 1, *(b for b in breaks if x < b < x + 1)}))
            middles = np.column_stack([(ends[1:] + ends[:-1]) / 2, np.full(len(ends) - 1, height)])
            cells = np.floor(board.at(middles)[:, :2]).sum(axis=1)
            total += weight * (end - begin) / 2 * float((np.diff(ends) * (1 - 2 * (cells % 2))).sum())
    return total


def test_border_integrals_agree_with_mpmath() -> None:
    slope = lattice.Slope(c=5000.0, along_a=-0.13, along_b=0.51)
    start, step = (0.31, 5.47, 61.0), (-1.7, 6.9, 3.74)
    value, error = lattice.integrals(lattice.Lines(np.array([start]), np.array([step])), slope)
    with mpmath.workdps(20):
        expected = float(border_integral(start, step, slope, slope.terms(61.0, 1e-17)[0]))
    assert abs(expected) > 1e-4
    assert abs(value[0] - expected) <= error[0] < 1e-12


@pytest.mark.parametrize("ratio", [0.73, -0.241, 0.019, -3.1])
def test_rows_and_pieces_agree(ratio: float) -> None:
    slope = lattice.Slope(c=5000.0, along_a=-0.13, along_b=0.51)
    for down in (903.7, -903.7):
        step = np.array([ratio * down, down, (ratio * slope.along_a + slope.along_b) * down])
        lines = lattice.Lines(np.array([[0.31, 5.47, 3000.0]]), step[np.newaxis])
        terms, remainder = lattice._row_terms(lines.start[0], step, slope, lattice.ROWS_ERROR)
        assert remainder <= lattice.ROWS_ERROR
        by_rows = lattice._sum_rows(lines.start[0], step, terms)
        by_pieces = lattice._sum_pieces(lines, slope, float(min(3000.0, 3000.0 + step[2])))[0]
        assert abs(by_rows) > 1e-9
        assert abs(by_rows - by_pieces) < 1e-14 + remainder  # 1000 pieces of 1e-6, each rounded


def border_integral(start: tuple[float, ...], step: tuple[float, ...], slope: lattice.Slope, terms: int) -> mpmath.mpf:
    (a, b, w), (da, db, dw) = ([mpmath.mpf(v) for v in vector] for vector in (start, step))
    ends = {mpmath.mpf(0), mpmath.mpf(1)}
    for first, along in ((a, da), (b, db)):
        low, high = sorted((first, first + along))
        ends |= {(k - first) / along for k in range(int(mpmath.floor(low)) + 1, int(mpmath.ceil(high)))}
    total = mpmath.mpf(0)
    places = sorted(ends)
    for begin, end in itertools.pairwise(places):
        middle = (begin + end) / 2
        cell = mpmath.floor(a + middle * da)
        sign = (-1) ** int(cell + mpmath.floor(b + middle * db))

        def integrand(t: mpmath.mpf, cell: mpmath.mpf = cell) -> mpmath.mpf:
            depth, found = w + t * dw, mpmath.mpf(0)
            for m in range(1, terms + 1):
                polynomial = mpmath.eulerpoly(m, a + t * da - cell) / mpmath.factorial(m)
                growth = mpmath.mpf(slope.along_a) ** (m - 1) * mpmath.factorial(m + 1) / 2
                found += polynomial * growth / depth ** (m + 2)
            return found

        total += sign * mpmath.quad(integrand, [begin, end], maxdegree=3)
    return total * slope.c * db


def test_what_is_beyond_the_cut_is_within_its_bound() -> None:
    """A walk a hundred times as far, for slopes that are near simple fractions and for others."""
    slope = lattice.Slope(c=5000.0, along_a=-0.02, along_b=-0.56)
    largest = 0.0
    for ratio in (0.5, 1 / 3 + 1e-5, (math.sqrt(5) - 1) / 2, 0.041, -1.37, 1.0, 2e-4):
        down = -1.71
        start, depth = np.array([0.37, 0.81, 100.0]), 2000.0
        bound = lattice.beyond(depth, ratio * down, down, slope, lattice.convergents(ratio))
        step = np.array([ratio * down, down, 1.0])
        begin = start + (depth - 100.0) * step
        rest, _ = checkerboard._doublings(lattice.Lines(begin[np.newaxis], 2e5 * step[np.newaxis]))
        value, _ = lattice.integrals(rest, slope)
        assert abs(value.sum()) <= bound, ratio
        largest = max(largest, abs(float(value.sum())) / bound)
    assert largest > 0.01  # the bound says something


@pytest.mark.parametrize("ratio", [0.0, 0.375, 1 / 3, math.pi, -0.7231, 17.25])
def test_convergents_are_those_of_the_fraction(ratio: float) -> None:
    found = lattice.convergents(ratio)
    part = Fraction(ratio) % 1
    for q, quotient in found[:12]:
        nearest = Fraction(round(part * q), q)
        if quotient == math.inf:
            assert nearest == part
        else:
            assert abs(nearest - part) <= Fraction(1, q * q)


def test_nothing_of_the_plane_and_all_of_the_sky() -> None:
    for camera in (CAMERA | {"look_at": [0, 9, 0]}, CAMERA | {"look_at": [0.3, 4.0, 4.1]}):
        of = floor(camera)
        exact = make(of, SIZE).exact
        board, frame = parts(of, SIZE)
        assert len(half_plane(board, frame, 0.0)) == 0
        assert np.array_equal(exact, np.broadcast_to(of.view.background, exact.shape))
        assert not near_part(board, frame, 1e-2)[0].any()


def test_the_sky_is_background_and_the_horizon_has_its_share() -> None:
    of = stored("checker-horizon")
    exact = reference_of("checker-horizon").exact
    background = np.array(of.view.background)
    assert np.array_equal(exact[:26], np.broadcast_to(background, (26, 128, 3)))
    # The horizon crosses row 26 at 0.1559: so much is sky, and the mean over the row nearly the mean of the colours.
    low, high = (np.array(c) for c in of.materials["board"].pattern.colours)
    sky = 26.155909608905358 - 26
    expected = sky * background + (1 - sky) * (low + high) / 2
    assert np.abs(exact[26].mean(axis=0) - expected).max() < 2e-3  # a wave of some 0.02 in 128 pixels


PLANE = {"type": "plane", "material": "board", "point": [0, 0, 0], "normal": [0, 1, 0]}
BOARD = {"board": {"emission": [1, 1, 1], "pattern": PATTERN}, "red": {"emission": [1, 0, 0]}}
REFUSED = {
    "two planes": (scene(PLANE, PLANE | {"point": [0, -1, 0]}, camera=CAMERA, materials=BOARD), "other surfaces"),
    "no pattern": (scene(PLANE | {"material": "red"}, camera=CAMERA, materials=BOARD), "no checkerboard"),
    "a polygon too": (scene(PLANE, box(1, 1, 5, 5), camera=CAMERA, materials=BOARD), "no answer for polygon"),
    "oblique": (floor(normal=[0, 1, 0.01]), "three families of lines"),
    "from its edge": (floor({"type": "orthographic", "eye": [0, 1, 4], "look_at": [0, 1, 0], "height": 2}), "edge"),
    "through the eye": (floor(point=[0, 1.2, 0]), "edge"),
    "too many squares": (
        floor({"type": "orthographic", "eye": [0, 9, 4], "look_at": [0, 1, 0], "height": 2.0}, scale=1.23457e8),
        "squares toward",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_exact_answer_is_refused(name: str) -> None:
    of, reason = REFUSED[name]
    with pytest.raises(Unsupported, match=reason):
        make(of, SIZE)


def test_a_plane_where_the_pattern_changes_has_no_colour() -> None:
    with pytest.raises(Ambiguous, match="not certain"):
        make(floor(point=[0, 0.2917 + 2 / 1.3, 0]), SIZE)
