"""Finding the probes, and running them: here, or by their names in worker processes."""

from __future__ import annotations

import functools
import math
import pkgutil
import time
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module

from aliascope.errors import AliascopeError, InvalidInput, NotAvailable
from aliascope.stability.extremes import EXTREMES
from aliascope.stability.records import Cell, Probe, Reading

PACKAGE = "aliascope.stability.probes"
"""Whose modules list the probes."""


def modules(package: str = PACKAGE) -> list[str]:
    """The names of the modules with probes, sorted; none of them is imported."""
    return sorted(f"{package}.{each.name}" for each in pkgutil.iter_modules(import_module(package).__path__))


@functools.cache
def probes_of(module: str) -> Mapping[str, Probe]:
    """The probes that a module lists, by their names. Raises InvalidInput for one that cannot be run."""
    found: dict[str, Probe] = {}
    for probe in import_module(module).probes():
        if problem := _problem(probe, found):
            raise InvalidInput(f"{module}: {probe.name}: {problem}")
        found[probe.name] = probe
    return found


def _problem(probe: Probe, others: Mapping[str, Probe]) -> str:
    if probe.extreme not in EXTREMES:
        return f"there is no extreme {probe.extreme!r}"
    if probe.name in others:
        return "there are two of this name"
    if not probe.levels or not all(isinstance(at, float | int) for at in (*probe.levels, *probe.quick)):
        return "its levels are to be numbers of Python"
    if not all(map(math.isfinite, (*probe.levels, *probe.quick))):
        return "its levels are to be finite"
    if not 0.0 < probe.precision < math.inf or not 0.0 <= probe.bound < math.inf:
        return "its precision is to be above 0, its bound 0 or more"
    return ""


def all_probes() -> dict[str, Probe]:
    """Those of all modules, by their names, in the order of modules and of what they list."""
    return joined([probes_of(module) for module in modules()])


def joined(lists: Iterable[Mapping[str, Probe]]) -> dict[str, Probe]:
    """All of them. Raises InvalidInput where two have one name."""
    found: dict[str, Probe] = {}
    for each in lists:
        for name in each:
            if name in found:
                raise InvalidInput(f"two modules have a probe {name!r}")
        found.update(each)
    return found


def described(module: str) -> dict[str, Probe]:
    """The probes of a module as they can be sent to another process: they say all, and measure there no more."""
    return {name: replace(probe, measure=_elsewhere) for name, probe in probes_of(module).items()}


def _elsewhere(at: float) -> float:
    raise AssertionError(f"level {at:g}: what is described only is measured by its name, where its module is")


def run_named(module: str, name: str, levels: Sequence[float]) -> Cell:
    """Runs a probe that a module lists. Overflows are looked for here, and told by the error: they warn of nothing."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return run(probes_of(module)[name], levels)


def from_mild(probe: Probe, levels: Iterable[float]) -> tuple[float, ...]:
    """Levels of a probe from mild to extreme: as they are, or, where both ways from 1 are extreme, from there."""
    if not EXTREMES[probe.extreme].both_ways:
        return tuple(levels)
    return tuple(sorted(levels, key=lambda at: abs(math.log(at)) if at > 0.0 else math.inf))


def run(probe: Probe, levels: Iterable[float] | None = None) -> Cell:
    """Measures at the probe's levels, or at those that are given. A component that is not there is not asked again."""
    readings: list[Reading] = []
    for at in from_mild(probe, probe.levels if levels is None else levels):
        try:
            readings.append(_reading(probe, at))
        except NotAvailable as error:
            return cell_of(probe, readings, absent=str(error))
    return cell_of(probe, readings)


def cell_of(probe: Probe, readings: Sequence[Reading], absent: str = "") -> Cell:
    """What was found of a probe."""
    order = {at: i for i, at in enumerate(from_mild(probe, probe.levels))}
    found = tuple(_allowed(probe, each, order) for each in readings)
    cell = Cell(
        probe.component,
        probe.kind,
        probe.extreme,
        probe.unit,
        probe.against,
        probe.precision,
        probe.bound,
        found,
        probe.note,
        probe.excused,
        absent,
    )
    if probe.excused_from is None or cell.breaks_at is None:
        return cell
    return replace(cell, excused=probe.excused or order.get(cell.breaks_at, 0) >= order[probe.excused_from])


def _allowed(probe: Probe, reading: Reading, order: Mapping[float, int]) -> Reading:
    """The reading, as a failure where the component declined and may not."""
    if not reading.refused or probe.refuses_from is None:
        return reading
    if order.get(reading.at, 0) >= order.get(probe.refuses_from, len(order)):
        return reading
    return replace(reading, refused="", failed=f"declined, which it may not here: {reading.refused}")


def _reading(probe: Probe, at: float) -> Reading:
    begun = time.process_time()
    try:
        error = probe.measure(at)
    except NotAvailable:
        raise
    except AliascopeError as refusal:
        return Reading(at, None, str(refusal) or type(refusal).__name__, time.process_time() - begun)
    except Exception as failure:  # noqa: BLE001  (of a probe, or of what it tries: it is to be seen in the map)
        told = f"{type(failure).__name__}: {failure}"
        return Reading(at, None, seconds=time.process_time() - begun, failed=told)
    return Reading(at, float(error) if math.isfinite(error) else math.inf, seconds=time.process_time() - begun)
