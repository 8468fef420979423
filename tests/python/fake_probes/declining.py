"""Probes that decline, and one whose library is not there."""

from __future__ import annotations

from aliascope.errors import NotAvailable, Unsupported
from aliascope.stability.records import Probe
from fake_probes import probe


def _no_more_than_a_thousand(at: float) -> float:
    if at > 1e3:
        raise Unsupported("at most 1000")
    return 0.0


def _not_there(at: float) -> float:
    raise NotAvailable("OSMesa is not there")


def probes() -> list[Probe]:
    return [
        probe("careful", _no_more_than_a_thousand, refuses_from=1e6),
        probe("osmesa", _not_there, kind="renderer", extreme="far", excused=True),
    ]
