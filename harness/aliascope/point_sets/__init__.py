"""Sets of points, measured: how far apart, how even, how good a net, at which frequencies, with what discrepancy.

But for discrepancies the unit square (or cube) is taken as a torus, as a pattern that is repeated from pixel to pixel
has no border.
"""

from __future__ import annotations

from aliascope.point_sets.discrepancies import Refused, measure_all, quick
from aliascope.point_sets.distances import densest_distance
from aliascope.point_sets.periodogram import PointSpectrum, default_cut_off, point_spectrum
from aliascope.point_sets.summary import PointStatistics, point_statistics
from aliascope.point_sets.voronoi import voronoi_areas

__all__ = [
    "PointSpectrum",
    "PointStatistics",
    "Refused",
    "default_cut_off",
    "densest_distance",
    "measure_all",
    "point_spectrum",
    "point_statistics",
    "quick",
    "voronoi_areas",
]
