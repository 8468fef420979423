"""aliascope: how well renderers antialias, and what that costs.

Everything that the commands do can be had from here, with numpy arrays: `aliascope.points("sobol", 16)`,
`aliascope.discrepancy(points, "star").value`, `aliascope.point_statistics(points)`,
`aliascope.render("edge", "embree", "uniform:n=16")`, `aliascope.error(image, reference)`,
`aliascope.uneven_weights(samples)`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from aliascope.api import (
        discrepancy,
        error,
        estimate,
        integrate,
        load_scene,
        point_spectrum,
        point_statistics,
        points,
        reference,
        render,
        uneven_weights,
        voronoi_areas,
    )

__all__ = [
    "discrepancy",
    "error",
    "estimate",
    "integrate",
    "load_scene",
    "point_spectrum",
    "point_statistics",
    "points",
    "reference",
    "render",
    "uneven_weights",
    "voronoi_areas",
]


def __getattr__(name: str) -> Any:
    # Late, so that `aliascope --version` does not wait for numpy, scipy and shapely.
    if name in __all__:
        from aliascope import api

        return getattr(api, name)
    raise AttributeError(f"module 'aliascope' has no attribute {name!r}")
