"""Sets of points in [0, 1)^d, measured: how far apart, how even, how good a net, at which frequencies.

The unit square (or cube) is taken as a torus, as a pattern that is repeated from pixel to pixel has no border.
"""

from __future__ import annotations

from aliascope.point_sets.distances import densest_distance, minimum_distance
from aliascope.point_sets.nets import t_value
from aliascope.point_sets.periodogram import PointSpectrum, default_cut_off, point_spectrum
from aliascope.point_sets.summary import PointStatistics, point_statistics
from aliascope.point_sets.voronoi import voronoi_areas

__all__ = [
    "PointSpectrum",
    "PointStatistics",
    "default_cut_off",
    "densest_distance",
    "minimum_distance",
    "point_spectrum",
    "point_statistics",
    "t_value",
    "voronoi_areas",
]
