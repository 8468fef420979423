"""Polygons that slide under an open shutter: the part of each pixel that they cover, in the mean over time.

By Green's theorem, as in `polygons`, a pixel's covered area is a sum over edges; that of one straight edge that moves
along a straight line is a polynomial of degree 2 in time between moments that are known: when one of its ends meets a
side's line of the pixel, or its own line a corner. Times the tent of a triangular response it has degree 3, which
Gauss-Legendre integrates with two nodes, exactly.
"""

from __future__ import annotations

import math

import numpy as np
import shapely

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame
from aliascope.model import Polygon, Scene, Translate
from aliascope.references.canvas import Coverage
from aliascope.references.layers import SLACK_PX, Layer, Part, composed, filled, parallel, touched
from aliascope.references.polygons import coverage, edges_of, visible_regions
from aliascope.references.projection import Outline, outlines_of
from aliascope.references.result import EPSILON, Exact, Method, checked
from aliascope.references.visibility import depth_order

CHUNK = 1 << 15
GAUSS = 0.5 / math.sqrt(3.0)
"""The two nodes lie this far, in widths of the interval, from its middle."""


def edge_share(from_: Array, to: Array) -> Array:
    """What an edge from `from_` to `to`, (..., 2) from a pixel's corner, adds to the area covered of that pixel."""
    rise = to - from_
    first, last = np.clip(from_[..., 1], 0.0, 1.0), np.clip(to[..., 1], 0.0, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = rise[..., 0] / rise[..., 1]
        left, right = np.minimum(from_[..., 0], to[..., 0]), np.maximum(from_[..., 0], to[..., 0])
        one, other = (np.clip(from_[..., 0] + (y - from_[..., 1]) * slope, left, right) for y in (first, last))
        low, high = np.minimum(one, other), np.maximum(one, other)
        width = high - low
        before = (np.minimum(high, 0.0) - np.minimum(low, 0.0)) / width
        low_in, high_in = np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0)
        slanted = before + (high_in - low_in) / width * (1.0 - 0.5 * (low_in + high_in))
        to_right = np.where(width > 0.0, slanted, 1.0 - low_in)
    share: Array = np.where(first == last, 0.0, (first - last) * to_right)
    return share


def _breaks(from_: Array, to: Array, way: Array, duration: float) -> Array:
    """The moments from 0 to `duration` between which `edge_share` of edges (n, 2) that move by `way` (2,) in a unit of
    time is a polynomial, in order, with both ends and the middle."""
    moments = [np.full(len(from_), moment) for moment in (0.0, 0.5 * duration, duration)]
    along = to - from_
    with np.errstate(divide="ignore", invalid="ignore"):
        for side in (0.0, 1.0):
            moments += [(side - end[:, axis]) / way[axis] for end in (from_, to) for axis in (0, 1)]
            for other in (0.0, 1.0):
                offset = np.array([side, other]) - from_
                turned = along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]
                moments.append(turned / (along[:, 0] * way[1] - along[:, 1] * way[0]))
    found = np.stack(moments, axis=1)
    found = np.clip(np.where(np.isfinite(found), found, 0.0), 0.0, duration)
    return np.sort(found, axis=1)


def _edge_means(from_: Array, to: Array, way: Array, duration: float, tent: bool) -> Array:
    """The mean of `edge_share` over the time, for edges (n, 2) from the corners of their pixels."""
    breaks = _breaks(from_, to, way, duration)
    middle, width = 0.5 * (breaks[:, 1:] + breaks[:, :-1]), breaks[:, 1:] - breaks[:, :-1]
    total = np.zeros(len(from_))
    for sign in (-1.0, 1.0):
        time = middle + sign * GAUSS * width
        weight = 0.5 * width / duration
        if tent:
            weight = weight * (2.0 - np.abs(4.0 * time / duration - 2.0))
        moved = time[..., np.newaxis] * way
        total += (weight * edge_share(from_[:, np.newaxis] + moved, to[:, np.newaxis] + moved)).sum(axis=1)
    return total


def swept(region: shapely.Geometry, way: Array, duration: float) -> shapely.Geometry:
    """Where the border of a region passes on its way."""
    start, end = edges_of(region)
    corners = np.stack([start, end, end + way * duration, start + way * duration], axis=1)
    return shapely.union_all(shapely.convex_hull(shapely.multipoints(corners)))


def moving_coverage(region: shapely.Geometry, way: Array, duration: float, tent: bool, frame: Frame) -> Coverage:
    """The part of each pixel that a region covers, in the mean over `duration` in which it moves by `way` px in a unit
    of time; the response is even, or a tent."""
    if not way.any():
        return coverage(region, frame.width, frame.height)
    area, length = filled(region, frame), np.zeros((frame.height, frame.width))
    start, end = edges_of(region)
    column, row = touched(swept(region, way, duration), 0.0, frame)
    corner = np.column_stack([column, row])
    for first in range(0, len(corner), max(1, CHUNK // len(start))):
        part = corner[first : first + max(1, CHUNK // len(start))]
        from_, to = ((ends - part[:, np.newaxis]).reshape(-1, 2) for ends in (start, end))
        means = _edge_means(from_, to, way, duration, tent).reshape(len(part), len(start)).sum(axis=1)
        columns, rows = part.astype(np.int64).T
        area[rows, columns] = np.clip(means, 0.0, 1.0)
        length[rows, columns] = math.sqrt(2.0) * len(start)
    return Coverage(area, length)


def _way(scene: Scene, frame: Frame, outline: Outline) -> tuple[float, float]:
    """By how many pixels, right and down, a surface moves in a unit of time."""
    depth = parallel(scene, frame, outline)
    motion = scene.surfaces[outline.number].motion
    if motion is None:
        return 0.0, 0.0
    if not isinstance(motion, Translate):
        raise Unsupported(f"{outline.label} turns: only motion along a line has an exact method")
    by = np.array(motion.by)
    if abs(float(by @ frame.forward)) > 4 * EPSILON * float(np.linalg.norm(by)):
        raise Unsupported(f"{outline.label} moves toward the viewer or away: its way on the picture is not even")
    scale = frame.pixel * (depth if frame.perspective else 1.0)
    return float(by @ frame.right) / scale, -float(by @ frame.up) / scale


def _layer(
    group: list[Outline], way: Array, shutter: tuple[float, float], tent: bool, frame: Frame
) -> tuple[Layer, float]:
    """Polygons that move alike, and how many edges what is seen of one of them has at most."""
    opening, duration = shutter[0], shutter[1] - shutter[0]
    order = depth_order(group)
    parts, most = [], 0.0
    for outline, seen in zip(group, visible_regions(group, order), strict=True):
        placed = shapely.transform(seen, lambda places: places + way * opening)
        share = moving_coverage(placed, way, duration, tent, frame)
        core = placed
        if way.any():
            core = shapely.difference(placed, shapely.buffer(swept(placed, way, duration), SLACK_PX))
        parts.append(Part(outline, share, core))
        most = max(most, float(len(edges_of(seen)[0])))
    together = shapely.transform(shapely.union_all([each.region for each in group]), lambda p: p + way * opening)
    reach = shapely.union(together, swept(together, way, duration)) if way.any() else together
    return Layer(tuple(parts), shapely.buffer(reach, SLACK_PX)), most


def make(scene: Scene, frame: Frame) -> Exact:
    """The mean radiance over pixel and time. Raises Unsupported where surfaces blur over each other's borders."""
    shutter = scene.camera.shutter
    assert shutter is not None  # reading a scene leaves motion only under an open shutter
    farthest = max((_farthest_px(scene, frame, surface) for surface in scene.surfaces), default=0.0)
    outlines = outlines_of(scene, frame, farthest + 2.0)
    alike: dict[tuple[float, float], list[Outline]] = {}
    for outline in outlines:
        alike.setdefault(_way(scene, frame, outline), []).append(outline)
    tent = scene.camera.response == "triangle"
    made = [_layer(group, np.array(way), shutter, tent, frame) for way, group in alike.items()]
    canvas = composed([layer for layer, _ in made], frame)
    # A way is rounded as the places are, and at most as long as `farthest`.
    displacement = 2 * max((o.displacement_px for o in outlines), default=0.0) + 16 * EPSILON * farthest
    # Each of 14 intervals of each edge has a few roundings of numbers up to 1.
    sums = 8 * EPSILON * (14 * sum(most for _, most in made) + max(frame.width, frame.height))
    return checked(canvas, np.array(scene.view.background), displacement * float(canvas.length.max()) + sums)


def _farthest_px(scene: Scene, frame: Frame, surface: object) -> float:
    """How far a surface moves on the picture, at most, as far as it lies before the eye."""
    if not isinstance(surface, Polygon) or not isinstance(surface.motion, Translate):
        return 0.0
    depth = float(((np.array(surface.points) - frame.eye) @ frame.forward).min())
    if frame.perspective and depth <= 0.0:
        return 0.0  # it is refused, or not there
    return float(np.linalg.norm(surface.motion.by)) / (frame.pixel * (depth if frame.perspective else 1.0))


METHOD = Method(
    name="moving-polygons",
    title="areas of polygons that slide, over the time",
    features=frozenset({"orthographic", "perspective", "polygon", "motion"}),
    make=make,
    requires="motion",
)
