"""OSMesa at the extremes of geometry, with and without what compensates for them."""

from __future__ import annotations

from collections.abc import Mapping

from aliascope.renderers.osmesa import RENDERER
from aliascope.stability.extremes import EXTREMES
from aliascope.stability.records import Probe
from aliascope.stability.rows import Row, probes_of

SNAPPED = (
    "Corners are snapped to 1/256 pixel: the edge lies up to 0.0011 pixels off, and one 1e-4 pixels from a sample is "
    "on its other side."
)

NOTES: Mapping[str, str] = {
    "coplanar": "A face 1e-7 units before another is behind it in places: depth is float, and in an orthographic view "
    "its step is 2^-23 of the range of all depths; compare leaves the cell empty from one part in 2^22 on.",
    "near-axis": SNAPPED,
    "near-diagonal": SNAPPED,
    "on-samples": SNAPPED,
}

AS_THEY_ARE: Mapping[str, str] = {
    "far": "At 1e6 units the error is 1.35 times that of exact samples, at 1e7 16 times, and from 1e8 on nothing is "
    "left: coordinates in float are off by 0.24 pixels there, by 2.4 and by 24.",
    "sliver": "At a length of 1e8 widths the error is 4.3 times that of exact samples, and from 1e9 on nothing is "
    "left: its corners in float are off by 6 pixels and by 60.",
}

ROWS = (
    Row(
        "osmesa",
        RENDERER,
        "accumulate:n=16,sampler=regular",
        "none",
        NOTES,
        {},
        {"coplanar", "near-axis", "near-diagonal"},
        {},
    ),
    Row(
        "osmesa:recentre=0",
        RENDERER,
        "accumulate:n=16,sampler=regular,recentre=0",
        "none:recentre=0",
        {**NOTES, **AS_THEY_ARE},
        {"dense": (1.0, 1e2, 1e4)},
        EXTREMES,
        {},
        quick=False,
    ),
)


def probes() -> list[Probe]:
    return [probe for row in ROWS for probe in probes_of(row)]
