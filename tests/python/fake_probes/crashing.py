"""Probes that take their process with them, or raise what nobody foresaw; and one beside them."""

from __future__ import annotations

import os
import signal

from aliascope.stability.records import Probe
from fake_probes import probe


def _crash(at: float) -> float:
    if at > 1e3:
        os.kill(os.getpid(), signal.SIGSEGV)
    return 0.0


def _raise(at: float) -> float:
    return 0.0 / abs(at - 1e3)


def probes() -> list[Probe]:
    return [
        probe("crashing", _crash),
        probe("raising", _raise, excused=True),
        probe("beside", lambda at: 0.0),
    ]
