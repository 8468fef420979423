"""Modules of probes as the map has to bear them: broken, crashing, hanging, declining, not there, not loading."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from aliascope.stability.records import Probe

LEVELS = (1.0, 1e3, 1e6)


def probe(component: str, measure: Callable[[float], float], **more: Any) -> Probe:
    asked: dict[str, Any] = {"kind": "statistic", "extreme": "mean", "levels": LEVELS, "quick": (1.0,), **more}
    return Probe(
        component=component,
        unit="relative",
        against="nothing",
        precision=1e-16,
        bound=1e-10,
        measure=measure,
        **asked,
    )
