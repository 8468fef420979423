"""All statistics of a point set at once."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from aliascope.errors import Unsupported
from aliascope.native.discrepancy import measure
from aliascope.point_sets.arrays import checked
from aliascope.point_sets.distances import densest_distance
from aliascope.point_sets.voronoi import voronoi_areas


@dataclass(frozen=True)
class PointStatistics:
    """Figures of n points on the unit torus; None where the points have none, and `reasons` by the figure's name.

    `minimum_distance`: on the torus; `minimum_distance_share`: over that of the densest packing, at most 1;
    `minimum_distance_plain`: not over the borders. `voronoi_area_...`: of the cells on the torus, their mean 1/n but
    for rounding, the standard deviation over all n. `t_value`: the least t of a (t, m, d)-net in the base.
    """

    minimum_distance: float | None = None
    minimum_distance_share: float | None = None
    minimum_distance_plain: float | None = None
    voronoi_area_mean: float | None = None
    voronoi_area_standard_deviation: float | None = None
    voronoi_area_minimum: float | None = None
    voronoi_area_maximum: float | None = None
    t_value: int | None = None
    reasons: dict[str, str] = field(default_factory=dict)


def point_statistics(points: Any, base: int = 2) -> PointStatistics:
    """The statistics of points (n, d) in [0, 1); `base` is that of `t_value`. Raises InvalidInput.

    Distances and t are the measures `min-distance` and `t-value` of the C library. Minimum distances for any d, their
    share for 1 to 3, Voronoi areas for 2. About 3 seconds for 10^5 points of two dimensions, nearly all for the cells.

    >>> point_statistics([[0.0, 0.0], [0.5, 0.5]]).minimum_distance
    0.7071067811865476
    """
    values = checked(points)
    n, d = values.shape
    found: dict[str, float | int] = {}
    reasons: dict[str, str] = {}
    try:
        found["minimum_distance"] = nearest = measure("min-distance", values).value
        found["minimum_distance_plain"] = measure("min-distance:torus=0", values).value
        found["minimum_distance_share"] = nearest / densest_distance(n, d)
    except Unsupported as error:
        distances = ("minimum_distance", "minimum_distance_plain", "minimum_distance_share")
        reasons.update({name: str(error) for name in distances if name not in found})
    names = tuple(f"voronoi_area_{name}" for name in ("mean", "standard_deviation", "minimum", "maximum"))
    try:
        areas = voronoi_areas(values)
        figures = (math.fsum(areas) / n, areas.std(), areas.min(), areas.max())
        found.update(zip(names, map(float, figures), strict=True))
    except Unsupported as error:
        reasons.update(dict.fromkeys(names, str(error)))
    try:
        found["t_value"] = int(measure(f"t-value:base={base}", values).value)
    except Unsupported as error:
        reasons["t_value"] = str(error)
    return PointStatistics(**found, reasons=reasons)  # type: ignore[arg-type]
