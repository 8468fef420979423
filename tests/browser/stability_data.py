"""A map of every kind of cell, as large as one gets: made up, but for its form."""

from __future__ import annotations

import math

from aliascope.stability.extremes import EXTREMES
from aliascope.stability.records import Cell, Kind, Reading
from aliascope.studies.stability import Asked, Map, place_of

COMPONENTS: dict[Kind, tuple[str, ...]] = {
    "renderer": ("embree", "embree:relative=0", "osmesa", "povray", "povray:moved=0"),
    "sampler": tuple(
        f"{name}{form}"
        for name in ("halton", "hammersley", "sobol", "pmj02", "zaremba", "correlated-multi-jittered")
        for form in ("", ":scramble=owen", ":scramble=owen-full", ":scramble=digit")
    ),
    "measure": ("star", "half-plane", "l2-star", "edges", "voronoi", "extreme", "centred", "wrap-around"),
    "estimator": ("fixed", "student-t", "chi-squared", "mitchell", "whitted", "kajiya"),
    "statistic": ("mean", "variance", "standard-error", "quantile:t", "quantile:chi-squared", "skewness"),
    "filter": ("box", "tent", "gaussian", "mitchell", "lanczos", "catmull-rom"),
    "metric": ("rmse", "psnr", "mae", "bias", "relative-mse", "ssim", "flip", "p99"),
    "film": ("double", "float", "pairwise", "compensated"),
}
"""Rows of the map."""

COVERED: dict[str, tuple[Kind, ...]] = {
    "geometry": ("renderer",),
    "radiance": ("renderer", "filter", "film"),
    "counts": ("sampler", "film", "renderer"),
    "statistics": ("statistic", "estimator"),
    "points": ("measure", "sampler"),
    "metrics": ("metric",),
}


def cell(kind: Kind, component: str, extreme: str, form: int) -> Cell:
    """One of eight forms: from exact to broken, declining, failed, and none."""
    levels = tuple(10.0**k for k in range(0, 13, 2))
    if extreme.startswith("near"):
        levels = tuple(10.0**-k for k in range(3, 13))
    if extreme in ("on-samples", "border"):
        levels = (1e-3, 1e-6, 1e-9, 0.0)
    grown = (0.0, 1e-17, 3e-10, 2e-5, 1e-2, 0.9, 1e3)[form % 7]
    readings = [Reading(at, grown * (i + 1) ** 4 / 1e3, seconds=0.01) for i, at in enumerate(levels)]
    if form == 6:
        readings[-1] = Reading(levels[-1], math.inf)
    if form in (1, 3):
        readings[-2:] = [Reading(at, None, "a scene is at most 10^9 units large") for at in levels[-2:]]
    if form == 7:
        readings[-1:] = [Reading(levels[-1], None, failed="its process ended by SIGSEGV")]
    excused = component in ("osmesa", "povray", "povray:moved=0")
    return Cell(
        component,
        kind,
        extreme,
        "of its own RMSE" if kind == "renderer" else "relative",
        "a picture in double, at the origin" if kind == "renderer" else "mpmath of the same doubles",
        2.0**-24 if kind == "renderer" else 2.0**-53,
        0.1 if kind == "renderer" else 1e-10,
        tuple(readings),
        "POV-Ray keeps the planes of a box in float; <b>beyond</b> that, pixels go dark." if form == 4 else "",
        excused,
    )


def cells() -> list[Cell]:
    made = []
    for place, extreme in enumerate(EXTREMES.values()):
        for kind in COVERED[extreme.group]:
            for row, component in enumerate(COMPONENTS[kind]):
                if (row * 7 + place * 3) % 4 != 3:
                    made.append(cell(kind, component, extreme.name, (row * 5 + place * 11 + row * place) % 8))
    gone = "OSMesa (Debian: libosmesa6) is not there: libOSMesa.so.8: cannot open shared object file"
    made.append(Cell("osmesa:absent", "renderer", "far", "pixels", "nothing", 1e-7, 0.1, (), "", True, gone))
    return made


def large() -> Map:
    """Some three hundred cells."""
    found = tuple(sorted(cells(), key=place_of))
    lost = {"unheard": "ModuleNotFoundError: No module named 'unheard'"}
    asked = Asked(command="aliascope stability <script>alert('no')</script>")
    return Map(asked, "2026-01-02T10:00:00+00:00", 123.4, found, lost, {}, {"povray": "3.7.0", "embree": "3.13.5"})


def small() -> Map:
    """A cell that keeps its bound, alone."""
    return Map(
        Asked(quick=True), "2026-01-02T10:00:00+00:00", 1.0, (cell("statistic", "variance", "mean", 0),), {}, {}, {}
    )
