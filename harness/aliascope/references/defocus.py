"""Surfaces that face the viewer, out of the focus of a round lens: pixel, lens and outline in one integral.

From the lens's point l, a surface at the depth d is seen moved by -l (1/d - 1/F) in the picture: blurred by a disc, the
circle of confusion, of radius R = lens_radius |1/d - 1/F|, the same over all of a surface that is parallel to the
picture. The mean over pixel and lens is the area of the outline under the convolution of the pixel's square with that
disc.

Of a polygon, by Green's theorem, it is an integral along the edges of

    G = 1 / (pi R^2) * integral over the disc of clamp(1 - x - s_x, 0, 1) [0 <= y + s_y <= 1] ds,

(x, y) from the pixel's corner, which has a closed form: second differences of the first moment of the part of a disc to
the left of and above a corner. Of a disc of radius a it is the mean over r, from |a - R| to a + R, of the area of the
pixel within r of its centre, weighted by the chord that two circles of radii a and R at the distance r have in common.
Both integrals are over one variable, between breaks that are known (`quadrature`).
"""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import NDArray

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame
from aliascope.model import Disc, Polygon, Scene
from aliascope.references.canvas import Coverage
from aliascope.references.discs import circle_coverage
from aliascope.references.layers import SLACK_PX, Layer, Part, composed, filled, parallel, touched
from aliascope.references.polygons import coverage, edges_of, visible_regions
from aliascope.references.projection import Circle, Outline, outlines_of
from aliascope.references.quadrature import integrate
from aliascope.references.result import EPSILON, Exact, Method, checked
from aliascope.references.visibility import depth_order

SHARP_PX = 1e-11
"""A circle of confusion smaller than this is a point; what it is counts in the error bound."""
ROUNDER = 1.01
"""shapely's rounded corners of 16 segments a quarter turn lie within 0.13 % of the circle."""
CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
SIGNS = (1.0, -1.0, -1.0, 1.0)


def _chords(y: Array) -> Array:
    """The integral of sqrt(1 - y^2) from 0: half the area of the unit disc between the heights 0 and y."""
    half: Array = 0.5 * (y * np.sqrt((1.0 - y) * (1.0 + y)) + np.arcsin(y))
    return half


def quadrant_area(a: Array, b: Array) -> Array:
    """The area of the part of the unit disc with x < a and y < b."""
    a, b = np.clip(a, -1.0, 1.0), np.clip(b, -1.0, 1.0)
    h = np.sqrt((1.0 - a) * (1.0 + a))
    y = np.clip(b, -h, h)
    beside = np.where(
        a > 0.0, 2.0 * (_chords(np.minimum(b, -h)) + math.pi / 4 + _chords(np.maximum(b, h)) - _chords(h)), 0.0
    )
    area: Array = a * (y + h) + _chords(y) + _chords(h) + beside
    return area


def quadrant_moment(a: Array, b: Array) -> Array:
    """The integral of a - x over the part of the unit disc with x < a and y < b."""
    b, inner = np.clip(b, -1.0, 1.0), np.clip(a, -1.0, 1.0)
    h = np.sqrt((1.0 - inner) * (1.0 + inner))
    y = np.clip(b, -h, h)
    within = (inner * inner + 1.0) * (y + h) / 2 - (y**3 + h**3) / 6 + inner * (_chords(y) + _chords(h))
    beside = _chords(np.minimum(b, -h)) + math.pi / 4 + _chords(np.maximum(b, h)) - _chords(h)
    moment: Array = within + np.where(a > 0.0, 2.0 * a * beside, 0.0)
    return moment


def _to_right(x: Array, y: Array, radius: float) -> Array:
    """G at places (x, y) from the pixel's corner."""
    result = np.zeros(np.broadcast(x, y).shape)
    for (right, below), sign in zip(CORNERS, SIGNS, strict=True):
        result += sign * quadrant_moment((right - x) / radius, (below - y) / radius)
    return result * (radius / math.pi)


def blurred_polygon(region: shapely.Geometry, radius: float, frame: Frame) -> tuple[Coverage, float]:
    """The mean over a disc of this radius (px) of the part of each pixel that a moved polygon covers, and a bound of
    what the quadrature adds to its error."""
    if radius < SHARP_PX:
        return coverage(region, frame.width, frame.height), 4.0 * radius
    start, end = edges_of(region)
    column, row = touched(shapely.boundary(region), radius, frame)
    pixel = np.repeat(np.arange(len(column)), len(start))
    corner = np.column_stack([column, row])[pixel]
    from_ = np.tile(start, (len(column), 1)) - corner
    along = np.tile(end - start, (len(column), 1))
    nearest, farthest = np.minimum(from_, from_ + along), np.maximum(from_, from_ + along)
    counts = (
        (nearest < 1.0 + radius).all(axis=1) & (farthest[:, 1] > -radius) & (along[:, 1] != 0.0)
    )  # where G is not 0
    pixel, from_, along = pixel[counts], from_[counts], along[counts]

    def integrand(owner: NDArray[np.int64], u: Array) -> Array:
        x, y = (from_[owner, axis, np.newaxis] + u * along[owner, axis, np.newaxis] for axis in (0, 1))
        weighted: Array = -along[owner, 1, np.newaxis] * _to_right(x, y, radius)
        return weighted

    shares, error = integrate(integrand, _breaks(from_, along, radius))
    area = filled(region, frame)
    inside = column.astype(np.int64), row.astype(np.int64)
    area[inside[1], inside[0]] = np.bincount(pixel, shares, len(column))
    length = np.zeros_like(area)
    length[inside[1], inside[0]] = math.sqrt(2.0) * len(start)
    return Coverage(area, length), error * len(start)


def _breaks(from_: Array, along: Array, radius: float) -> Array:
    """Where, in [0, 1], the edges (n, 2) meet the lines and circles at which G is not smooth; with both ends."""
    found = [np.zeros(len(from_)), np.ones(len(from_))]
    with np.errstate(divide="ignore", invalid="ignore"):
        for axis in (0, 1):
            found += [
                (line - from_[:, axis]) / along[:, axis]
                for side in (0.0, 1.0)
                for line in (side - radius, side + radius)
            ]
        squared = (along**2).sum(axis=1)
        for corner in CORNERS:
            ahead = ((corner - from_) * along).sum(axis=1)
            aside = (along[:, 0] * (corner[1] - from_[:, 1]) - along[:, 1] * (corner[0] - from_[:, 0])) / np.sqrt(
                squared
            )
            root = np.sqrt(np.maximum((radius - aside) * (radius + aside), 0.0) * squared)
            found += [(ahead - root) / squared, (ahead + root) / squared]
    breaks = np.stack(found, axis=1)
    return np.clip(np.where(np.isfinite(breaks), breaks, 0.0), 0.0, 1.0)


def blurred_circle(circle: Circle, radius: float, frame: Frame) -> tuple[Coverage, float]:
    """The same of a disc."""
    if radius < SHARP_PX:
        return circle_coverage(circle, frame.width, frame.height), 4.0 * radius
    nearest, wide = abs(circle.radius - radius), 2.0 * min(circle.radius, radius)
    column, row = touched(shapely.Point(circle.x, circle.y), nearest + wide, frame)
    x, y = circle.x - column, circle.y - row

    def area(owner: NDArray[np.int64], r: Array) -> Array:
        result = np.zeros(r.shape)
        for (right, below), sign in zip(CORNERS, SIGNS, strict=True):
            result += sign * quadrant_area((right - x[owner, np.newaxis]) / r, (below - y[owner, np.newaxis]) / r)
        return result * r * r

    def integrand(owner: NDArray[np.int64], past: Array) -> Array:
        r = nearest + past
        chord = np.sqrt(past * (r + nearest) * (wide - past) * (r + nearest + wide)) / r
        return area(owner, r) * chord / (math.pi * radius**2)

    sides = [np.abs(x), np.abs(1.0 - x), np.abs(y), np.abs(1.0 - y)]
    distances = np.stack([*sides, *(np.hypot(right - x, below - y) for right, below in CORNERS)], axis=1)
    ends = np.column_stack([np.zeros(len(x)), np.full(len(x), wide)])
    shares, error = integrate(integrand, np.column_stack([np.clip(distances - nearest, 0.0, wide), ends]))
    result, length = np.zeros((frame.height, frame.width)), np.zeros((frame.height, frame.width))
    result[row.astype(np.int64), column.astype(np.int64)] = shares
    length[row.astype(np.int64), column.astype(np.int64)] = min(2.0 * math.pi * circle.radius, 4.0)
    return Coverage(result, length), error + 16 * EPSILON * (nearest + wide + 1.0) ** 2


def make(scene: Scene, frame: Frame) -> Exact:
    """The mean radiance over pixel and lens. Raises Unsupported where surfaces blur over each other's borders."""
    if scene.camera.blades:
        raise Unsupported("the lens has blades: only a round one has an exact method")
    margin = 3.0 * max((_radius_px(scene, frame, depth) for depth in _depths(scene, frame)), default=0.0) + 2.0
    outlines = outlines_of(scene, frame, margin)
    alike: dict[float, list[Outline]] = {}
    layers, errors = [], 0.0
    for outline in outlines:
        depth = parallel(scene, frame, outline)
        radius = _radius_px(scene, frame, depth)
        if outline.circle is None:
            alike.setdefault(depth, []).append(outline)
            continue
        share, error = blurred_circle(outline.circle, radius, frame)
        core = shapely.Point(outline.circle.x, outline.circle.y).buffer(outline.circle.radius - radius - SLACK_PX)
        layers.append(Layer((Part(outline, share, core),), _grown(outline.region, radius)))
        errors += error
    for depth, group in alike.items():
        layer, error = _polygons(group, _radius_px(scene, frame, depth), frame)
        layers.append(layer)
        errors += error
    canvas = composed(layers, frame)
    # The circles of confusion are rounded as the outlines are.
    displacement = max((outline.displacement_px for outline in outlines), default=0.0) * 2
    sums = 8 * EPSILON * (max(frame.width, frame.height) + margin) * (len(outlines) + 1)
    return checked(canvas, np.array(scene.view.background), displacement * float(canvas.length.max()) + errors + sums)


def _radius_px(scene: Scene, frame: Frame, depth: float) -> float:
    assert scene.camera.lens_radius is not None  # the method requires a lens
    assert scene.camera.focus_distance is not None
    return scene.camera.lens_radius * abs(1.0 / depth - 1.0 / scene.camera.focus_distance) / frame.pixel


def _depths(scene: Scene, frame: Frame) -> list[float]:
    """Of the surfaces before the eye."""
    places = (
        each.points[0] if isinstance(each, Polygon) else each.centre
        for each in scene.surfaces
        if isinstance(each, Polygon | Disc)
    )
    depths = (float((np.array(place) - frame.eye) @ frame.forward) for place in places)
    return [depth for depth in depths if depth > 0.0]


def _grown(region: shapely.Geometry, by_px: float) -> shapely.Geometry:
    return shapely.buffer(region, by_px * ROUNDER + SLACK_PX, quad_segs=16)


def _polygons(group: list[Outline], radius: float, frame: Frame) -> tuple[Layer, float]:
    """Polygons at one depth."""
    parts, errors = [], 0.0
    for outline, seen in zip(group, visible_regions(group, depth_order(group)), strict=True):
        share, error = blurred_polygon(seen, radius, frame)
        parts.append(Part(outline, share, shapely.buffer(seen, -(radius * ROUNDER + SLACK_PX), quad_segs=16)))
        errors += error
    return Layer(tuple(parts), _grown(shapely.union_all([each.region for each in group]), radius)), errors


METHOD = Method(
    name="defocus",
    title="convolutions of outlines with the disc of a lens",
    features=frozenset({"perspective", "polygon", "disc", "lens"}),
    make=make,
    requires="lens",
)
