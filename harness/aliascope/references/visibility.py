"""Which surface hides which: the order in depth of every two outlines that overlap on the picture.

Newell, Newell and Sancha 1972 sort polygons and split them where they cross; here no order of all is needed: the
visible part of a surface is its outline without those of all surfaces in front of it, and two surfaces that cross are
refused. So outlines that overlap in a circle (a before b before c before a) are no trouble.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from aliascope.errors import Unsupported
from aliascope.references.projection import SLIVER_PX, Circle, Outline
from aliascope.references.result import Ambiguous

UNDECIDED_PX = 1e-9
"""Two surfaces may touch: where rounding leaves open which is in front, in a strip no wider than this."""


@dataclass(frozen=True)
class Order:
    """`in_front[i]`: the numbers of the outlines that hide outline i where both are.

    `displacement_px` bounds what rounding leaves open: strips, next to where two surfaces touch, of this width in all.
    """

    in_front: tuple[tuple[int, ...], ...]
    displacement_px: float


def depth_order(outlines: Sequence[Outline]) -> Order:
    """Raises Unsupported where two surfaces cross on the picture, Ambiguous where they lie at the same depth."""
    regions = [outline.region for outline in outlines]
    in_front: list[list[int]] = [[] for _ in outlines]
    open_px = 0.0
    if regions:
        first, second = shapely.STRtree(regions).query(regions, predicate="intersects")
        for a, b in zip(first.tolist(), second.tolist(), strict=True):
            if a < b and overlap(outlines[a], outlines[b]):
                nearer, strip_px = _nearer(outlines[a], outlines[b])
                open_px += strip_px
                in_front[b if nearer else a].append(a if nearer else b)
    return Order(tuple(tuple(sorted(front)) for front in in_front), open_px)


def overlap(a: Outline, b: Outline) -> bool:
    """Whether two outlines share more than a sliver."""
    if a.circle is not None and b.circle is not None:
        distance = math.hypot(a.circle.x - b.circle.x, a.circle.y - b.circle.y)
        return distance < a.circle.radius + b.circle.radius - SLIVER_PX
    if a.circle is not None:
        return not apart(a.circle, b.region)
    if b.circle is not None:
        return not apart(b.circle, a.region)
    common = shapely.intersection(a.region, b.region)
    return bool(common.area > SLIVER_PX * common.length)


def apart(circle: Circle, region: shapely.Geometry) -> bool:
    """Whether the inside of the circle and the region share nothing."""
    if region.is_empty:
        return True
    return bool(shapely.distance(region, shapely.Point(circle.x, circle.y)) >= circle.radius - SLIVER_PX)


def circle_within(circle: Circle, region: shapely.Geometry) -> bool:
    """Whether the region holds the whole circle."""
    centre = shapely.Point(circle.x, circle.y)
    if region.is_empty or not shapely.contains(region, centre):
        return False
    return bool(shapely.distance(shapely.boundary(region), centre) >= circle.radius - SLIVER_PX)


def region_within(region: shapely.Geometry, circle: Circle) -> bool:
    """Whether the circle holds the whole region."""
    offset = shapely.get_coordinates(region) - (circle.x, circle.y)
    return bool(np.hypot(offset[:, 0], offset[:, 1]).max(initial=0.0) <= circle.radius + SLIVER_PX)


def _nearer(a: Outline, b: Outline) -> tuple[bool, float]:
    """Whether a lies in front of b where both are, and the width of the strip (px) for which that is not certain."""
    corners = shapely.get_coordinates(shapely.intersection(a.region, b.region))
    value_a, rounding_a = a.nearness.at(corners)
    value_b, rounding_b = b.nearness.at(corners)
    difference, rounding = value_a - value_b, rounding_a + rounding_b
    lowest, highest = float((difference - rounding).min()), float((difference + rounding).max())
    if lowest > 0.0:
        return True, 0.0
    if highest < 0.0:
        return False, 0.0
    # Both signs are possible. The difference is affine, so the wrong sign is confined to a strip of the overlap.
    spread = float(difference.max() - difference.min())
    extent = float(np.hypot(*np.ptp(corners, axis=0)))
    strips = [-lowest / spread * extent, highest / spread * extent] if spread > 0.0 else [math.inf, math.inf]
    if min(strips) > UNDECIDED_PX:
        what = f"{a.label} and {b.label}"
        if float(np.abs(difference).max()) > float(rounding.max()):
            raise Unsupported(f"{what} cross each other on the picture: which one is seen has no exact answer")
        if a.material == b.material:
            return a.number < b.number, 0.0  # they look the same: either may be in front
        raise Ambiguous(f"{what} lie at the same depth on the picture: which one is seen has no answer")
    return strips[0] < strips[1], min(strips)
