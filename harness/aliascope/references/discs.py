"""Discs that face the viewer, and polygons, of constant emission: circles' areas in pixels in closed form.

The part of a pixel within a circle is bounded by parts of the pixel's sides and by arcs: a polygon of at most eight
corners and a segment of the circle on each arc. The corners are roots of t^2 + 2 b t + q = 0 along each side, where
q = |corner - centre|^2 - r^2 is a difference of squares that are nearly equal for a circle much larger than a pixel, so
that whole pixels and fractions are squared apart, the former in integers: nothing cancels. Segments are taken from
their chord, by a series where they are flat.

Outlines of which one crosses a circle have no closed form here and are refused: a circle lies within what is seen of
another surface, or holds it, or lies apart.
"""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame
from aliascope.model import Scene
from aliascope.references.canvas import Canvas, Coverage
from aliascope.references.polygons import colour_of, coverage
from aliascope.references.projection import SLIVER_PX, Circle, Outline, outlines_of
from aliascope.references.result import EPSILON, Exact, Method, checked
from aliascope.references.visibility import apart, circle_within, depth_order, region_within

Index = NDArray[np.int64]
Mask = NDArray[np.bool_]
FLAT = 0.05
"""Below this angle (radians), theta - sin(theta) comes from its series: three terms are exact to 1e-17 of it."""


def circle_coverage(circle: Circle, width: int, height: int) -> Coverage:
    """The part of each pixel of a picture within a circle, (height, width), to 1e-14 (tests: against mpmath, 1e-13).

    The circle's centre and radius in pixels, each at most 1e8.
    """
    area, length = np.zeros((height, width)), np.zeros((height, width))
    left, right = _whole(circle.x - circle.radius, circle.x + circle.radius, width)
    top, bottom = _whole(circle.y - circle.radius, circle.y + circle.radius, height)
    if left >= right or top >= bottom:
        return Coverage(area, length)
    columns, rows = np.arange(left, right + 1), np.arange(top, bottom + 1)
    power = _power(columns[np.newaxis, :], rows[:, np.newaxis], circle)
    corners = np.stack([power[:-1, :-1], power[:-1, 1:], power[1:, 1:], power[1:, :-1]], axis=-1)
    inside = (corners <= 0.0).all(axis=-1)
    area[top:bottom, left:right] = inside
    # A pixel that meets the disc has a corner within sqrt(1/2) of it, whose power is then below 1.5 r + 0.5.
    reach = 2.0 * circle.radius + 2.0
    row, column = np.nonzero(~inside & (corners.min(axis=-1) <= reach))
    if len(row):
        found = _areas(corners[row, column], column + left, row + top, circle)
        area[row + top, column + left] = found
        length[row + top, column + left] = np.where(found > 0.0, min(2 * math.pi * circle.radius, 4.0), 0.0)
    return Coverage(area, length)


def _whole(low: float, high: float, limit: int) -> tuple[int, int]:
    """The first pixel and the one past the last between low and high, with one more each side, within the picture."""
    return max(0, math.floor(low) - 1), min(limit, math.ceil(high) + 1)


def _power(column: Index, row: Index, circle: Circle) -> Array:
    """|corner - centre|^2 - radius^2 of pixel corners, within 8 eps (radius + 1) where it is near 0.

    With centre = X + fx, radius = R + fr, X and R whole: (i - X)^2 + (j - Y)^2 - R^2 is exact in integers.
    """
    x, y, radius = (math.floor(c) for c in (circle.x, circle.y, circle.radius))
    fx, fy, fr = circle.x - x, circle.y - y, circle.radius - radius
    i, j = column - x, row - y
    whole: Array = (i * i + j * j - radius * radius).astype(np.float64)
    return whole - 2.0 * (i * fx + j * fy + radius * fr) + (fx * fx + fy * fy - fr * fr)


def _areas(power: Array, column: Index, row: Index, circle: Circle) -> Array:
    """The area of pixels (n,) within the circle, of the power (n, 4) of their corners, clockwise on the picture.

    Clockwise on the picture is counter-clockwise as numbers: sides 0 to 3 go right, down, left, up.
    """
    near = _relative(column, row, circle)
    from_, to, crossed = _inside(power, near, circle.radius)
    corner = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    along = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    first = corner + from_[:, :, np.newaxis] * along  # (n, 4, 2), from the middle of the pixel
    last = corner + to[:, :, np.newaxis] * along
    area = np.where(crossed, _cross(first, last), 0.0).sum(axis=1) / 2
    centre_inside = np.all((near >= 0.0) & (near <= 1.0), axis=1)
    for side in range(4):
        pending = crossed[:, side].copy()
        for steps in (1, 2, 3, 4):
            other = (side + steps) % 4
            here = pending & crossed[:, other]
            pending &= ~here
            arc_from, arc_to = last[here, side], first[here, other]
            area[here] += _cross(arc_from, arc_to) / 2
            centre = near[here] - 0.5
            # More than half the circle needs the centre in the pixel, for the arc has it in its hull; and then an arc
            # with a short chord is one that returns to its own side.
            major = centre_inside[here] & (steps == 4)
            area[here] += _segments(arc_from - centre, arc_to - centre, arc_to - arc_from, major, circle.radius)
    untouched = ~np.any(crossed, axis=1) & centre_inside
    area[untouched] = math.pi * circle.radius**2  # the circle lies within one pixel
    clipped: Array = np.clip(area, 0.0, 1.0)
    return clipped


def _relative(column: Index, row: Index, circle: Circle) -> Array:
    """The centre from the pixel's first corner, (n, 2): whole pixels and fractions apart."""
    x, y = math.floor(circle.x), math.floor(circle.y)
    return np.column_stack([(x - column) + (circle.x - x), (y - row) + (circle.y - y)])


def _inside(power: Array, near: Array, radius: float) -> tuple[Array, Array, Mask]:
    """Where each side (n, 4) enters and leaves the circle, in [0, 1], and whether it is inside anywhere."""
    ahead = np.column_stack([near[:, 0], near[:, 1], 1.0 - near[:, 0], 1.0 - near[:, 1]])  # the centre along a side
    aside = np.column_stack([near[:, 1], 1.0 - near[:, 0], 1.0 - near[:, 1], near[:, 0]])  # and away from its line
    # r - |aside| is exact where the two are close, which is where it matters, and r + |aside| cannot cancel.
    discriminant = (radius - np.abs(aside)) * (radius + np.abs(aside))
    meets = discriminant > 0.0
    root = np.sqrt(np.where(meets, discriminant, 0.0))
    # Roots of t^2 - 2 ahead t + power: the larger one in size first, the other from their product.
    large = np.where(ahead >= 0.0, ahead + root, ahead - root)
    safe = np.where(large == 0.0, 1.0, large)
    with np.errstate(over="ignore"):  # a root beyond all numbers is beyond the side too
        small = np.where(large == 0.0, 0.0, power / safe)
    enter, leave = np.minimum(large, small), np.maximum(large, small)
    # The corners' own signs decide about the ends, so that two sides agree about the corner between them.
    following = np.roll(power, -1, axis=1)
    from_ = np.where(power <= 0.0, 0.0, np.clip(enter, 0.0, 1.0))
    to = np.where(following <= 0.0, 1.0, np.clip(leave, 0.0, 1.0))
    crossed = (power <= 0.0) | (following <= 0.0) | (meets & (enter < 1.0) & (leave > 0.0))
    return from_, to, crossed & (to > from_)


def _cross(a: Array, b: Array) -> Array:
    product: Array = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def _segments(arc_from: Array, arc_to: Array, chord: Array, major: Mask, radius: float) -> Array:
    """The area between chords and their arcs, from `arc_from` to `arc_to` around the origin: r^2/2 (theta - sin theta).

    The chord tells a small angle well, and one of half a turn badly; the ends' directions the other way round.
    """
    length = np.hypot(chord[:, 0], chord[:, 1])
    small = 2.0 * np.arcsin(np.minimum(length / (2.0 * radius), 1.0))
    # r^2 theta^3 / 12 without r^2, which may be huge while theta is tiny.
    series = 1 - small**2 / 20 * (1 - small**2 / 42 * (1 - small**2 / 72))
    flat = (radius * small) ** 2 * small / 12 * series
    minor = np.where(small < FLAT, flat, radius**2 / 2 * (small - np.sin(small)))
    turn = np.arctan2(_cross(arc_from, arc_to), (arc_from * arc_to).sum(axis=1)) % (2.0 * math.pi)
    wide = radius**2 / 2 * (turn - np.sin(turn))
    return np.where(length > radius, wide, np.where(major, math.pi * radius**2 - minor, minor))


def make(scene: Scene, frame: Frame) -> Exact:
    """The mean radiance over each pixel. Raises Unsupported where an outline crosses a circle."""
    outlines = outlines_of(scene, frame)
    order = depth_order(outlines)
    canvas = Canvas(frame.width, frame.height)
    for outline, front in zip(outlines, order.in_front, strict=True):
        colour = colour_of(outline)
        canvas.add(_seen(outline, [outlines[j] for j in front], frame), colour, float(colour.max()))
    # Rounding moves outlines, and outlines that lie in each other by less than a sliver count as apart.
    displacement = max((outline.displacement_px for outline in outlines), default=0.0) + 2 * SLIVER_PX
    sums = 8 * EPSILON * max(frame.width, frame.height) * (len(outlines) + 1)
    error = displacement * float(canvas.length.max()) + 2 * order.displacement_px + sums
    return checked(canvas, np.array(scene.view.background), error)


def _seen(outline: Outline, front: list[Outline], frame: Frame) -> Coverage:
    """The coverage of what is seen of a surface behind the surfaces `front`."""
    front = _outermost(front)
    polygons = shapely.union_all([f.region for f in front if f.circle is None])
    circles = [(f.circle, f.label) for f in front if f.circle is not None]
    nothing = Coverage(np.zeros((frame.height, frame.width)), np.zeros((frame.height, frame.width)))
    if outline.circle is None:
        seen = shapely.difference(outline.region, polygons)
        if any(region_within(seen, circle) for circle, _ in circles):
            return nothing
        result = coverage(seen, frame.width, frame.height)
        return _without(result, [(c, label) for c, label in circles if not apart(c, seen)], seen, outline, frame)
    circle = outline.circle
    if circle_within(circle, polygons) or any(_circle_in_circle(circle, other) for other, _ in circles):
        return nothing
    result = circle_coverage(circle, frame.width, frame.height)
    for piece in shapely.get_parts(polygons).tolist():
        if not apart(circle, piece):
            if not region_within(piece, circle):
                raise _crossing(outline.label, "a polygon in front of it")
            hidden = coverage(piece, frame.width, frame.height)
            result = Coverage(result.area - hidden.area, result.length + hidden.length)
    for other, label in circles:
        if not _circle_in_circle(other, circle):
            raise _crossing(outline.label, label)
    around = outline.region  # a polygon around the disc: what lies in the disc lies in it
    return _without(result, circles, shapely.difference(around, polygons), outline, frame)


def _without(
    result: Coverage, circles: list[tuple[Circle, str]], seen: shapely.Geometry, outline: Outline, frame: Frame
) -> Coverage:
    """A coverage less the circles in front, which must lie within `seen`.

    None of them holds another, and two that cross are refused where the farther of them is looked at.
    """
    for circle, label in circles:
        if apart(circle, seen):
            continue  # hidden itself, here
        if not circle_within(circle, seen):
            raise _crossing(label, f"the outline of what is seen of {outline.label}")
        hidden = circle_coverage(circle, frame.width, frame.height)
        result = Coverage(result.area - hidden.area, result.length + hidden.length)
    return result


def _outermost(front: list[Outline]) -> list[Outline]:
    """The surfaces that no other of them holds whole: the rest hide nothing more. Of two equal ones, the first."""
    kept: list[Outline] = []
    for i, inner in enumerate(front):
        held = (_holds(outer, inner) and (j < i or not _holds(inner, outer)) for j, outer in enumerate(front) if j != i)
        if not any(held):
            kept.append(inner)
    return kept


def _holds(outer: Outline, inner: Outline) -> bool:
    if outer.circle is not None:
        if inner.circle is not None:
            return _circle_in_circle(inner.circle, outer.circle)
        return region_within(inner.region, outer.circle)
    if inner.circle is not None:
        return circle_within(inner.circle, outer.region)
    return False  # two polygons: their union takes care of it


def _circle_in_circle(inner: Circle, outer: Circle) -> bool:
    distance = math.hypot(inner.x - outer.x, inner.y - outer.y)
    return distance + inner.radius <= outer.radius + SLIVER_PX


def _crossing(one: str, other: str) -> Unsupported:
    return Unsupported(f"{one} and {other} cross on the picture: a circle cut by another outline has no exact method")


METHOD = Method(
    name="discs",
    title="areas of the visible parts of discs and polygons",
    features=frozenset({"orthographic", "perspective", "polygon", "disc"}),
    make=make,
)
