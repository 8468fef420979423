"""A plane with a checkerboard, seen whole, to the horizon: the mean of every pixel to 1e-9, the horizon's too.

The plane's normal is along an axis, so that the pattern is s(a) s(b), its coordinates a and b those of the two other
axes in squares. On the picture 1/w, w the depth, is affine, and a = a_eye + A / (1/w) with A affine.

Near the viewer, to the depth at which squares shrink steadily (`lattice.DEEP` of them), each square is a polygon on the
picture: their areas as in `polygons`. From there to the horizon the mean comes from integrals along the borders of the
pixels: the formula, and the proof of its error, are in `lattice`. With both together a pixel on the horizon, in which
squares without number lie, costs a walk along its sides: until what is left of them, which is bounded, is below 1e-11.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame
from aliascope.model import Checker, Plane, Scene
from aliascope.references import lattice
from aliascope.references.canvas import Canvas, Coverage
from aliascope.references.lattice import Lines, Slope
from aliascope.references.polygons import coverage, parts_coverage
from aliascope.references.result import EPSILON, Ambiguous, Exact, Method, checked

MOST_SQUARES = 1_000_000
LAYER = 1e-9
"""A plane closer than this, in squares, to where the pattern's third axis changes has no certain colour."""


@dataclass(frozen=True)
class Board:
    """The plane on the picture. Affine functions of the picture's (x, y), in pixels, are (3,): of x, of y, constant.

    (a, b) = eye + (across / nearness), nearness = 1/w; `to_picture` (3, 3) takes (a, b, 1) to (x w, y w, w). `sign`: of
    the square (0, 0), +1 where it has the pattern's first colour.
    """

    eye: Array
    across: Array
    nearness: Array
    to_picture: Array
    slope: Slope
    sign: float

    def at(self, places: Array) -> Array:
        """(a, b, w) of places (..., 2) on the picture before the horizon."""
        near = affine(self.nearness, places)
        ab = [self.eye[i] + affine(self.across[i], places) / near for i in (0, 1)]
        return np.stack([*ab, 1.0 / near], axis=-1)


def affine(coefficients: Array, places: Array) -> Array:
    value: Array = places[..., 0] * coefficients[0] + places[..., 1] * coefficients[1] + coefficients[2]
    return value


def board_of(plane: Plane, pattern: Checker, frame: Frame) -> Board:
    """Raises Unsupported for a plane that is not across an axis, or is seen from its edge."""
    normal = np.array(plane.normal)
    if np.count_nonzero(normal) != 1:
        raise Unsupported("the checkerboard's plane is not across an axis: on others it has three families of lines")
    third = int(np.argmax(np.abs(normal)))
    layer = pattern.scale * (plane.point[third] - pattern.origin[third])
    if abs(layer - round(layer)) <= LAYER * max(1.0, abs(layer)):
        raise Ambiguous("the plane lies where the pattern changes along its normal: which colour it has is not certain")
    to_plane = float(plane.point[third] - frame.eye[third])
    # A ray through (x, y): direction = ahead (3 axes, 3 coefficients), the sides of the picture in units of `right`.
    middle = frame.middle
    sideways = np.outer(frame.right, [frame.pixel, 0.0, -frame.pixel * middle[0]])
    sideways += np.outer(frame.up, [0.0, -frame.pixel, frame.pixel * middle[1]])
    constant = np.array([0.0, 0.0, 1.0])
    if frame.perspective:
        ahead = sideways + np.outer(frame.forward, constant)
        nearness, where = ahead[third] / to_plane if to_plane else np.zeros(3), ahead
    else:
        if frame.forward[third] == 0.0:
            raise Unsupported("the checkerboard's plane is seen from its edge")
        depth = (to_plane * constant - sideways[third]) / frame.forward[third]
        nearness, where = constant, sideways + np.outer(frame.forward, depth)
    if not nearness.any():
        raise Unsupported("the checkerboard's plane is seen from its edge")
    # Of the two axes the one along which the depth grows less comes first: its terms fall faster.
    axes = sorted({0, 1, 2} - {third}, key=lambda axis: abs(float(frame.forward[axis])))
    relative = np.array(pattern.origin) - frame.eye
    relative[third] = to_plane
    columns = np.column_stack([np.eye(3)[axes[0]] / pattern.scale, np.eye(3)[axes[1]] / pattern.scale, relative])
    w = frame.forward @ columns if frame.perspective else constant
    x = frame.right @ columns / frame.pixel + w * middle[0]
    y = -(frame.up @ columns) / frame.pixel + w * middle[1]
    to_picture = np.array([x, y, w])
    return Board(
        eye=-pattern.scale * relative[axes],
        across=pattern.scale * where[axes],
        nearness=nearness,
        to_picture=to_picture,
        slope=Slope(float(np.linalg.det(to_picture)), float(w[0]), float(w[1])),
        sign=1.0 - 2.0 * (math.floor(layer) % 2),
    )


def half_plane(board: Board, frame: Frame, level: float) -> Array:
    """The corners (n, 2) of the part of the picture where the nearness is at least `level`; none: (0, 2)."""
    corners = np.array([[0.0, 0.0], [frame.width, 0.0], [frame.width, frame.height], [0.0, frame.height]])
    above = affine(board.nearness, corners) - level
    kept: list[Array] = []
    for here, there, value, following in zip(
        corners, np.roll(corners, -1, axis=0), above, np.roll(above, -1), strict=True
    ):
        if value >= 0.0:
            kept.append(here)
        if (value >= 0.0) != (following >= 0.0):
            kept.append(here + (there - here) * (value / (value - following)))
    return np.array(kept).reshape(-1, 2)


# --- near: squares ----------------------------------------------------------------------------------------------------


def near_part(board: Board, frame: Frame, level: float) -> tuple[Array, Array]:
    """The integral of s(a) s(b) over each pixel's part of nearness `level` or more, and a bound of its error."""
    nothing = np.zeros((frame.height, frame.width))
    corners = half_plane(board, frame, level)
    region = shapely.Polygon(corners) if len(corners) >= 3 else shapely.Polygon()
    if region.is_empty:
        return nothing, nothing
    places = board.at(corners)[:, :2]
    footprint = shapely.Polygon(places)
    low, high = np.floor(places.min(axis=0)), np.ceil(places.max(axis=0))
    if float(np.prod(high - low)) > MOST_SQUARES:
        raise Unsupported(f"the picture shows more than {MOST_SQUARES} squares of the checkerboard near the viewer")
    a, b = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    even = (a + b) % 2.0 == 0.0
    squares = shapely.intersection(shapely.box(a[even], b[even], a[even] + 1.0, b[even] + 1.0), footprint)
    squares = squares[shapely.area(squares) > 0.0]
    drawn = shapely.transform(squares, lambda ab: _picture(board, ab))
    part = parts_coverage(drawn, frame.width, frame.height)
    whole = coverage(region, frame.width, frame.height)
    moved = 8 * EPSILON * _terms(board, shapely.get_coordinates(squares)) + 32 * EPSILON * sum(frame.spans)
    error = 2 * part.length * moved + 16 * EPSILON * (frame.width + len(drawn)) * (part.length > 0.0)
    return 2.0 * part.area - whole.area, error + moved * whole.length


def _picture(board: Board, ab: Array) -> Array:
    x, y, w = (row[0] * ab[:, 0] + row[1] * ab[:, 1] + row[2] for row in board.to_picture)
    return np.column_stack([x / w, y / w])


def _terms(board: Board, ab: Array) -> float:
    """The sizes of the terms that a place's coordinates (px) are sums of, the largest over places (n, 2)."""
    sizes = np.abs(np.column_stack([ab, np.ones(len(ab))])) @ np.abs(board.to_picture).T
    w = np.column_stack([ab, np.ones(len(ab))]) @ board.to_picture[2]
    places = np.abs(_picture(board, ab)).max(axis=1)
    return float(((sizes[:, :2].max(axis=1) + places * sizes[:, 2]) / w).max(initial=0.0))


# --- far: the borders of pixels ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sides:
    """Lines of the picture, from `first` to `last`, (n, 2); where `endless`, `last` lies on the horizon."""

    first: Array
    last: Array
    endless: NDArray[np.bool_]


def _clip(board: Board, first: Array, last: Array, level: float) -> tuple[Sides, lattice.Index, Array]:
    """The parts of lines where 0 <= nearness <= level, the numbers of the lines, and -1 where they were turned."""
    begin, end = affine(board.nearness, first), affine(board.nearness, last)
    turned = begin < end  # toward the horizon
    one, other = np.where(turned[:, np.newaxis], last, first), np.where(turned[:, np.newaxis], first, last)
    high, low = np.maximum(begin, end), np.minimum(begin, end)
    with np.errstate(divide="ignore", invalid="ignore"):
        enter = np.where(high > level, (high - level) / (high - low), 0.0)[:, np.newaxis]
        leave = np.where(low < 0.0, high / (high - low), 1.0)[:, np.newaxis]
    step = other - one
    kept = np.nonzero((high > 0.0) & (low < level))[0]
    one, other, enter, leave, step = one[kept], other[kept], enter[kept], leave[kept], step[kept]
    sides = Sides(one + enter * step, np.where(leave < 1.0, one + leave * step, other), low[kept] <= 0.0)
    direction: Array = np.where(turned, -1.0, 1.0)[kept]
    return sides, kept, direction


def _side_integrals(board: Board, sides: Sides) -> tuple[Array, Array]:
    """The border integral along each side and a bound of its error, (n,)."""
    if not len(sides.first):
        return np.zeros(0), np.zeros(0)
    start = board.at(sides.first)
    step = np.zeros_like(start)
    finite = ~sides.endless
    step[finite] = board.at(sides.last[finite]) - start[finite]
    error = np.zeros(len(start))
    for i in np.nonzero(sides.endless)[0].tolist():
        across, down = (float(affine(board.across[k], sides.last[i])) for k in (0, 1))
        depth, error[i] = lattice.cut_depth(float(start[i, 2]), across, down, board.slope)
        step[i] = np.array([across, down, 1.0]) * (depth - start[i, 2])
    lines, owner = _doublings(Lines(start, step))
    value, more = lattice.integrals(lines, board.slope)
    total: Array = np.bincount(owner, value, len(start)).astype(np.float64)
    return total, error + np.bincount(owner, more, len(start))


def _doublings(lines: Lines) -> tuple[Lines, lattice.Index]:
    """The lines cut wherever their depth has doubled, and which line each part is of."""
    starts, steps, owners = [], [], []
    start, step = lines.start, lines.step
    owner = np.arange(len(start))
    while len(owner):
        reach = np.where(step[:, 2] > start[:, 2], start[:, 2] / np.where(step[:, 2] == 0.0, 1.0, step[:, 2]), 1.0)
        starts.append(start)
        steps.append(step * reach[:, np.newaxis])
        owners.append(owner)
        left = reach < 1.0
        start, step = (start + step * reach[:, np.newaxis])[left], (step * (1.0 - reach)[:, np.newaxis])[left]
        owner = owner[left]
    return Lines(np.concatenate(starts), np.concatenate(steps)), np.concatenate(owners)


def _rim(board: Board, frame: Frame, level: float) -> tuple[Array, Array, lattice.Index]:
    """Where the line of nearness `level` crosses pixels: from, to, with the far side on the left, and which pixels."""
    gradient = board.nearness[:2]
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(frame.width), np.arange(frame.height)))
    middle = np.column_stack([x + 0.5, y + 0.5])
    squared = float(gradient @ gradient)
    if squared == 0.0 or not math.isfinite(level):
        return np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.int64)
    foot = middle + np.outer((level - affine(board.nearness, middle)) / squared, gradient)
    along = np.array([-gradient[1], gradient[0]]) / math.sqrt(squared)
    low, high = np.full(len(x), -np.inf), np.full(len(x), np.inf)
    for axis, corner in ((0, x), (1, y)):
        if along[axis] == 0.0:
            outside = (foot[:, axis] < corner) | (foot[:, axis] >= corner + 1)
            high[outside] = -np.inf
            continue
        ends = np.stack([corner - foot[:, axis], corner + 1 - foot[:, axis]]) / along[axis]
        low, high = np.maximum(low, ends.min(axis=0)), np.minimum(high, ends.max(axis=0))
    kept = np.nonzero(low < high)[0]
    return foot[kept] + np.outer(low[kept], along), foot[kept] + np.outer(high[kept], along), kept


def far_part(board: Board, frame: Frame, level: float) -> tuple[Array, Array]:
    """The integral of s(a) s(b) over each pixel's part of nearness between 0 and `level`, and a bound of its error."""
    width, height = frame.width, frame.height
    x, y = np.meshgrid(np.arange(width), np.arange(height + 1))
    rows = np.column_stack([x.ravel(), y.ravel()]).astype(np.float64)
    x, y = np.meshgrid(np.arange(width + 1), np.arange(height))
    columns = np.column_stack([x.ravel(), y.ravel()]).astype(np.float64)
    rim_first, rim_last, rim_pixel = _rim(board, frame, level)
    first = np.concatenate([rows, columns])
    last = np.concatenate([rows + np.array([1.0, 0.0]), columns + np.array([0.0, 1.0])])
    sides, kept, direction = _clip(board, first, last, level)
    sides = Sides(
        np.concatenate([sides.first, rim_first]),
        np.concatenate([sides.last, rim_last]),
        np.concatenate([sides.endless, np.zeros(len(rim_first), np.bool_)]),
    )
    value, error = _side_integrals(board, sides)
    grid, slack = np.zeros(len(first)), np.zeros(len(first))
    grid[kept], slack[kept] = value[: len(kept)] * direction, error[: len(kept)]
    total, bound = np.zeros(height * width), np.zeros(height * width)
    total[rim_pixel], bound[rim_pixel] = value[len(kept) :], error[len(kept) :]
    flat, upright = grid[: len(rows)].reshape(height + 1, width), grid[len(rows) :].reshape(height, width + 1)
    # Once around a pixel: along its top, down its right side, back along its bottom, up its left side.
    around = flat[:-1] + upright[:, 1:] - flat[1:] - upright[:, :-1]
    flat, upright = slack[: len(rows)].reshape(height + 1, width), slack[len(rows) :].reshape(height, width + 1)
    around_bound = flat[:-1] + upright[:, 1:] + flat[1:] + upright[:, :-1]
    return around + total.reshape(height, width), around_bound + bound.reshape(height, width)


def make(scene: Scene, frame: Frame) -> Exact:
    """The mean radiance over each pixel. Raises Unsupported where there is more than one plane across an axis."""
    if len(scene.surfaces) != 1:
        raise Unsupported("a checkerboard to the horizon is exact alone; the scene has other surfaces")
    plane = scene.surfaces[0]
    assert isinstance(plane, Plane)  # the method's features hold this
    material = scene.materials[plane.material]
    pattern = material.pattern
    if not isinstance(pattern, Checker):
        raise Unsupported("the plane has no checkerboard")
    board = board_of(plane, pattern, frame)
    slope = board.slope
    level = 1.0 / (lattice.DEEP * slope.steepness) if slope.steepness else math.inf
    near, near_error = near_part(board, frame, level) if math.isfinite(level) else (0.0, 0.0)
    far, far_error = far_part(board, frame, level)
    _, remainder = slope.terms(1.0 / level, 1e-17) if math.isfinite(level) else (1, 0.0)
    seen = half_plane(board, frame, 0.0)
    whole = coverage(shapely.Polygon(seen) if len(seen) >= 3 else shapely.Polygon(), frame.width, frame.height)
    wave = board.sign * (near + far)
    canvas = Canvas(frame.width, frame.height)
    low, high = (np.array(colour) * np.array(material.emission) for colour in pattern.colours)
    for colour, share in ((low, (whole.area + wave) / 2), (high, (whole.area - wave) / 2)):
        canvas.add(Coverage(np.clip(share, 0.0, 1.0), whole.length), colour, float(colour.max()))
    # Rounding of the view moves the horizon, and all with it, by this (px); the sides of a pixel are 4 long.
    moved = 64 * EPSILON * sum(frame.spans)
    error = float(np.max(near_error + far_error)) + remainder + 5 * moved
    return checked(canvas, np.array(scene.view.background), error)


METHOD = Method(
    name="checkerboard",
    title="a checkerboard to the horizon: squares nearby, Boole's summation beyond",
    features=frozenset({"orthographic", "perspective", "plane", "checker"}),
    make=make,
)
