"""A probe that takes for ever at a level."""

from __future__ import annotations

import time

from aliascope.stability.records import Probe
from fake_probes import probe


def _hang(at: float) -> float:
    if at > 1.0:
        time.sleep(600.0)
    return 0.0


def probes() -> list[Probe]:
    return [probe("hanging", _hang)]
