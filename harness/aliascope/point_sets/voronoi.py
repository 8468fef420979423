"""The Voronoi cells of points on the torus."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import Unsupported
from aliascope.point_sets.arrays import Points, checked

MOST_UNEVEN = 10_000
"""The most points whose cells are found where they reach across the square: half a minute at worst, on a diagonal."""

SAME = 2.0**44
"""Points that are one when rounded to 1 / SAME, around the torus too, are at the same place: Qhull takes some of them
for one and some not."""


def voronoi_areas(points: Any) -> NDArray[np.float64]:
    """The areas of the Voronoi cells of (n, 2) points on the unit torus: (n,) float64, which sum to 1.

    Points at the same place share their cell in equal parts. Exact but for rounding: copies of the points around the
    square leave every cell as it is on the torus, see `_cells`. Corners are good to about 1e-16 over the distance of
    the points around them. Raises InvalidInput; Unsupported if not d = 2, and for more than 10^4 points of which some
    cells reach over an eighth of the square.
    """
    values = checked(points)
    if values.shape[1] != 2:
        raise Unsupported(f"Voronoi areas are those of two dimensions, not {values.shape[1]}")
    cells = np.round(values * SAME) % SAME
    _, first, place, shared = np.unique(cells, axis=0, return_index=True, return_inverse=True, return_counts=True)
    return (_cells(values[first]) / shared)[place.reshape(-1)]


def _cells(sites: Points) -> NDArray[np.float64]:
    """Areas for different sites, from a planar diagram of the sites and their copies within a margin.

    Leaving copies out can only enlarge a cell, and a site within twice the radius of a cell (seen from its own site) is
    all that can cut it. So where the margin is twice the largest radius, the cells are those of the torus. At margin 1
    they are in any case: a cell lies in its site +- 1/2, between the site's own copies, and whatever cuts it there in
    its site +- 1.
    """
    count = len(sites)
    for axis in (0, 1):
        if (sites[:, axis] == sites[0, axis]).all():
            return _strips(sites[:, 1 - axis])
    margin = min(1.0, 4.0 / math.sqrt(count))
    while (ridges := _ridges(sites, margin)) is None or (margin < 1.0 and 2.0 * ridges.radius > margin):
        margin = min(1.0, 4.0 * margin)
        if margin > 0.25 and count > MOST_UNEVEN:
            raise Unsupported(
                f"some cells of these {count} points reach across the torus, which takes too long: "
                f"take {MOST_UNEVEN} points or fewer"
            )
    # The triangle of a site and a ridge: the ridge is its base, half the distance of the two sites its height.
    triangles = ridges.lengths * ridges.distances / 4.0
    areas = np.bincount(ridges.pairs.ravel(), weights=np.repeat(triangles, 2), minlength=count)
    return np.asarray(areas[:count], dtype=np.float64)


def _strips(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """For sites in a line across, where Qhull would take their number squared: from half-way to half-way."""
    order = np.argsort(places)
    gaps = np.diff(places[order], append=places[order[0]] + 1.0)
    areas = np.empty_like(places)
    areas[order] = (gaps + np.roll(gaps, 1)) / 2.0
    return areas


class _Ridges(NamedTuple):
    """The edges of the cells of the sites: which two points each parts, their distance, its length; and the largest
    distance of a site from a corner of its cell."""

    pairs: NDArray[np.int32]
    distances: NDArray[np.float64]
    lengths: NDArray[np.float64]
    radius: float


def _ridges(sites: Points, margin: float) -> _Ridges | None:
    """None where the margin is too small for the cells of all sites to be finite."""
    from scipy.spatial import QhullError, Voronoi  # takes half a second to load, and most commands measure no points

    try:
        diagram = Voronoi(_with_copies(sites, margin))
    except QhullError:  # all in a line
        if margin == 1.0:  # where they are not
            raise
        return None
    inner = (diagram.ridge_points < len(sites)).any(axis=1)
    pairs, ends = diagram.ridge_points[inner], np.array(diagram.ridge_vertices)[inner]
    if (ends < 0).any():
        assert margin < 1.0, "the cells of a tiled square are finite"
        return None
    first, second = diagram.points[pairs[:, 0]], diagram.points[pairs[:, 1]]
    start, end = diagram.vertices[ends[:, 0]], diagram.vertices[ends[:, 1]]
    corners = np.concatenate([start - first, end - first])
    return _Ridges(pairs, np.hypot(*(second - first).T), np.hypot(*(end - start).T), float(np.hypot(*corners.T).max()))


def _with_copies(sites: Points, margin: float) -> Points:
    """The sites, and after them those of their eight copies that lie within the margin around the unit square."""
    steps = [np.array([dx, dy]) for dx in (-1.0, 0.0, 1.0) for dy in (-1.0, 0.0, 1.0) if dx or dy]
    copies = np.concatenate([sites + step for step in steps])
    near = ((copies >= -margin) & (copies <= 1.0 + margin)).all(axis=1)
    return np.concatenate([sites, copies[near]])
