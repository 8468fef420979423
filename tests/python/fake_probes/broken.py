"""Probes that break: one of ours, one of others, one whose result is none, one both ways from 1."""

from __future__ import annotations

import math

from aliascope.stability.records import Probe
from fake_probes import probe


def probes() -> list[Probe]:
    return [
        probe("ours", lambda at: at * 1e-13, note="It is | meant to."),
        probe("povray", lambda at: at * 1e-13, kind="renderer", extreme="far", excused=True),
        probe("none", lambda at: math.nan if at > 1.0 else 0.0),
        probe("both", lambda at: 1e-13 * max(at, 1.0 / at), extreme="scaled", levels=(1e-9, 1e-6, 1.0, 1e6)),
    ]
