"""Polygons of constant emission: the area of what is seen of each, pixel by pixel.

What is seen of a polygon is its outline without the outlines in front of it (polygon Booleans: GEOS's OverlayNG,
through shapely). The area of a region in every pixel follows from its edges alone, by Green's theorem: cut the edges at
the borders of the pixels; a piece that rises by dy in a pixel, with mean x (relative to the pixel) m, takes dy (1 - m)
from this pixel and dy from each one to its right. It is the "area" and "cover" of Levien's LibArt and of FreeType's
smooth rasterizer (ftgrays.c), in double precision. Pixels that no piece touches are exactly 0 or 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from aliascope.geometry import Array, Frame
from aliascope.model import Scene
from aliascope.references.canvas import Canvas, Coverage
from aliascope.references.projection import Outline, outlines_of
from aliascope.references.result import EPSILON, Exact, Method, checked
from aliascope.references.visibility import Order, depth_order

Index = NDArray[np.int64]
UNDERFLOW_PX = 1e-30


def coverage(region: shapely.Geometry, width: int, height: int) -> Coverage:
    """The area of a polygon or several, with holes or without, in each pixel of a picture.

    Within 4 eps max(width, height) per pixel that an edge touches in that row, else exact.
    """
    # Products of such numbers underflow, and GEOS then falls back to snapping, by 1e-12 of the picture's size.
    region = shapely.transform(region, lambda places: np.where(np.abs(places) < UNDERFLOW_PX, 0.0, places))
    return parts_coverage(shapely.intersection(region, shapely.box(0.0, 0.0, width, height)), width, height)


def parts_coverage(parts: shapely.Geometry, width: int, height: int) -> Coverage:
    """The same of polygons, one or an array of them, that lie within the picture and share no area."""
    start, end = edges_of(parts)
    if not len(start):
        return Coverage(np.zeros((height, width)), np.zeros((height, width)))
    first, second = _pieces(start, end, width, height)
    middle = (first + second) / 2
    column, row = np.floor(middle).astype(np.int64).T
    kept = (column < width) & (row < height)  # a piece on the right or lower border bounds nothing to its right
    first, second, middle, column, row = (a[kept] for a in (first, second, middle, column, row))
    rise = first[:, 1] - second[:, 1]  # a counter-clockwise edge that goes down the numbers of y has the inside right
    right_of = np.clip(1.0 - (middle[:, 0] - column), 0.0, 1.0)
    cell = row * (width + 1) + column
    # One column more than the picture has takes what the last pixel of a row hands to its right.
    shape = (height, width + 1)
    partial, whole = _sums(cell, rise * right_of, shape), _sums(cell + 1, rise, shape)
    area = (np.cumsum(whole, axis=1) + partial)[:, :width]
    piece = second - first
    length = _sums(cell, np.hypot(piece[:, 0], piece[:, 1]), shape)[:, :width]
    touched = _sums(cell, np.ones(len(cell)), shape)[:, :width] > 0.0
    return Coverage(np.clip(np.where(touched, area, np.rint(area)), 0.0, 1.0), length)


def _sums(cell: Index, weights: Array, shape: tuple[int, int]) -> Array:
    sums = np.bincount(cell, weights, shape[0] * shape[1])
    return sums.astype(np.float64).reshape(shape)


def edges_of(region: shapely.Geometry) -> tuple[Array, Array]:
    """The edges of a region, (n, 2) each end; outer rings counter-clockwise, as numbers, and holes clockwise."""
    parts = shapely.get_parts(region)
    areas = [part for part in parts.tolist() if part.geom_type == "Polygon" and not part.is_empty]
    rings = shapely.get_rings(shapely.orient_polygons(np.array(areas, dtype=object)))
    points, ring = shapely.get_coordinates(rings, return_index=True)
    same = ring[1:] == ring[:-1]
    return points[:-1][same], points[1:][same]


def _pieces(start: Array, end: Array, width: int, height: int) -> tuple[Array, Array]:
    """The edges (n, 2) cut wherever they cross a line between pixels: the two ends of every piece, (m, 2)."""
    limit = (width, height)
    start, end = np.clip(start, 0.0, limit), np.clip(end, 0.0, limit)
    count = np.arange(len(start))
    edges, times, points = [count, count], [np.zeros(len(start)), np.ones(len(start))], [start, end]
    for axis in (0, 1):
        edge, time, point = _crossings(start, end, axis)
        edges.append(edge)
        times.append(time)
        points.append(point)
    all_edges = np.concatenate(edges)
    order = np.lexsort((np.concatenate(times), all_edges))
    path, edge = np.concatenate(points)[order], all_edges[order]
    same = edge[1:] == edge[:-1]
    return path[:-1][same], path[1:][same]


def _crossings(start: Array, end: Array, axis: int) -> tuple[Index, Array, Array]:
    """Where edges cross the lines of whole coordinate `axis`: the edge's number, how far along it, and the point."""
    from_, to = start[:, axis], end[:, axis]
    first = np.floor(np.minimum(from_, to)) + 1
    many = np.maximum(np.ceil(np.maximum(from_, to)) - first, 0).astype(np.int64)
    edge = np.repeat(np.arange(len(start)), many)
    before = np.repeat(np.cumsum(many) - many, many)
    line = first[edge] + (np.arange(len(edge)) - before)
    time = (line - from_[edge]) / (to - from_)[edge]
    point = np.empty((len(edge), 2))
    point[:, axis] = line  # exactly on the line, so that both pixels see the same corner
    other = 1 - axis
    point[:, other] = start[edge, other] + time * (end - start)[edge, other]
    return edge, time, point


def visible_regions(outlines: Sequence[Outline], order: Order) -> Iterator[shapely.Geometry]:
    """What is seen of each polygon: its outline without those in front of it."""
    for outline, front in zip(outlines, order.in_front, strict=True):
        yield shapely.difference(outline.region, shapely.union_all([outlines[j].region for j in front]))


def visible(frame: Frame, outlines: Sequence[Outline], order: Order) -> Iterator[Coverage]:
    """The coverage of what is seen of each polygon."""
    for seen in visible_regions(outlines, order):
        yield coverage(seen, frame.width, frame.height)


def coverage_error(frame: Frame, outlines: Sequence[Outline], order: Order, canvas: Canvas) -> float:
    """A bound of the error of the coverages on the canvas, summed over all surfaces, in any pixel.

    Every edge moved as far as rounding may have moved it, the strips that the order leaves open, the sums along rows,
    and how far the visible parts and the outline of all together, which is found apart from them, disagree.
    """
    displacement = max((outline.displacement_px for outline in outlines), default=0.0)
    together = coverage(shapely.union_all([o.region for o in outlines]), frame.width, frame.height)
    gap = float(np.abs(canvas.covered - together.area).max())
    sums = 4 * EPSILON * max(frame.width, frame.height) * len(outlines)
    return displacement * float(canvas.length.max()) + 2 * order.displacement_px + sums + gap


def colour_of(outline: Outline) -> Array:
    """The radiance (3,) of a surface that has no pattern: the methods' features hold that."""
    return np.array(outline.material.emission)


def make(scene: Scene, frame: Frame) -> Exact:
    """The mean radiance over each pixel: the colours, weighted by the area of what is seen of each."""
    outlines = outlines_of(scene, frame)
    order = depth_order(outlines)
    canvas = Canvas(frame.width, frame.height)
    for outline, part in zip(outlines, visible(frame, outlines, order), strict=True):
        colour = colour_of(outline)
        canvas.add(part, colour, float(colour.max()))
    return checked(canvas, np.array(scene.view.background), coverage_error(frame, outlines, order, canvas))


METHOD = Method(
    name="polygons",
    title="areas of the visible parts of polygons",
    features=frozenset({"orthographic", "perspective", "polygon"}),
    make=make,
)
