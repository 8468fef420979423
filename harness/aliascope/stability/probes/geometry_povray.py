"""POV-Ray at the extremes of geometry, with and without what compensates for them."""

from __future__ import annotations

from collections.abc import Mapping

from aliascope.renderers.povray import RENDERER
from aliascope.stability.extremes import EXTREMES
from aliascope.stability.records import Probe
from aliascope.stability.rows import Row, probes_of

NOTES: Mapping[str, str] = {
    "depth-range": "Refused from a ratio of 1e11 on: it sees nothing nearer than 1e-4 units nor beyond 1e7, and no "
    "scale brings both ends between.",
    "grazing": "Triangles, discs and planes are missed by rays that meet them at a sine below 1e-10: from 5.7e-9 "
    "degrees on nothing is left, and compare leaves the cell empty.",
    "on-samples": "A sample on an edge sees the one face or the other, and never neither.",
    "wide": "Refused from 1e-4 degrees on: what is ahead and what is in the corners are farther apart than its range.",
}

AS_THEY_ARE: Mapping[str, str] = {
    "far": "At 1e8 units nothing is left: the boxes that bound triangles are float, whose steps are 8 units there.",
    "scaled": "Refused below 1e-4 units and beyond 1e7, between which its world lies.",
    "depth-range": "Refused from a ratio of 1e7 on, where its world ends.",
    "grazing": "Refused from 1e-6 degrees on, where the floor reaches beyond 1e7 units.",
    "narrow": "Refused from 1e-5 degrees on, from where the scene is farther than 1e7 units.",
    "wide": "Refused from 0.01 degrees on, where the scene is nearer than 1e-4 units.",
    "shadow": "At a factor of 1e-3 the plate throws no shadow (0.047 rms): it is nearer to the floor than 1e-3 units; "
    "then refused, for the rim of its ball.",
}

ROWS = (
    Row("povray", RENDERER, "regular:n=16", "none", NOTES, {}, {"grazing"}, {"depth-range": 1e11, "wide": 1e-4}),
    Row(
        "povray:recentre=0",
        RENDERER,
        "regular:n=16,recentre=0",
        "none:recentre=0",
        {**NOTES, **AS_THEY_ARE},
        {"dense": (1.0, 1e2, 1e4)},
        EXTREMES,
        {
            "scaled": 1e-6,
            "depth-range": 1e7,
            "grazing": 1e-6,
            "narrow": 1e-5,
            "wide": 1e-2,
            "shadow": 1e-4,
        },
        quick=False,
    ),
)


def probes() -> list[Probe]:
    return [probe for row in ROWS for probe in probes_of(row)]
