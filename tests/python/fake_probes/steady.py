"""Probes that keep their bounds, in another order than that of the map."""

from __future__ import annotations

from aliascope.stability.records import Probe
from fake_probes import probe


def probes() -> list[Probe]:
    return [
        probe("rmse", lambda at: 0.0, kind="metric", extreme="huge"),
        probe("variance", lambda at: at * 1e-17, quick=()),
        probe("mean", lambda at: 0.0, extreme="zero-variance"),
        probe("mean", lambda at: 0.0),
        probe("embree", lambda at: 0.0, kind="renderer", extreme="far"),
    ]
