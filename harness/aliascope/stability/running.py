"""Finding the probes, and running them."""

from __future__ import annotations

import math
import pkgutil
import time
from collections.abc import Iterable
from importlib import import_module

from aliascope.errors import AliascopeError, InvalidInput
from aliascope.stability import probes
from aliascope.stability.extremes import EXTREMES
from aliascope.stability.records import Cell, Probe, Reading


def all_probes() -> dict[str, Probe]:
    """Those of all modules, by their names, in the order of modules and of what they list."""
    found: dict[str, Probe] = {}
    for module in pkgutil.iter_modules(probes.__path__):
        for probe in import_module(f"{probes.__name__}.{module.name}").probes():
            if probe.extreme not in EXTREMES:
                raise InvalidInput(f"{module.name}: there is no extreme {probe.extreme!r}")
            if probe.name in found:
                raise InvalidInput(f"{module.name}: two probes are {probe.name!r}")
            found[probe.name] = probe
    return found


def run(probe: Probe, levels: Iterable[float] | None = None) -> Cell:
    """Measures at the probe's levels, or at those that are given."""
    readings = tuple(_reading(probe, at) for at in (probe.levels if levels is None else levels))
    return Cell(
        probe.component,
        probe.kind,
        probe.extreme,
        probe.unit,
        probe.against,
        probe.precision,
        probe.bound,
        readings,
        probe.note,
    )


def _reading(probe: Probe, at: float) -> Reading:
    begun = time.process_time()
    try:
        error = probe.measure(at)
    except AliascopeError as refusal:
        return Reading(at, None, str(refusal), time.process_time() - begun)
    return Reading(at, error if math.isfinite(error) else math.inf, seconds=time.process_time() - begun)
