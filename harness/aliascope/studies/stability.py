"""`aliascope stability`: runs the probes in worker processes, each by its name, and puts what they find in order.

The parent imports no module with probes, nor what they rest on: workers list them, and measure. A probe is one task;
where its process ends, or takes too long, it is tried again level by level, so that what it found before is there and
the level that it ends at is known.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from fnmatch import fnmatchcase
from typing import get_args

from aliascope import renderers
from aliascope.errors import AliascopeError, InvalidInput, JobFailed, NotAvailable, near_misses
from aliascope.stability import running
from aliascope.stability.extremes import EXTREMES
from aliascope.stability.records import Cell, Group, Kind, Probe, Reading
from aliascope.workers import Task, Workers

GROUPS: tuple[Group, ...] = get_args(Group)
KINDS: tuple[Kind, ...] = get_args(Kind)

LISTING_LIMIT = 120.0
"""Seconds that a module may take to list its probes; it imports what they need."""

Tell = Callable[[str | None, int, int], None]


@dataclass(frozen=True)
class Asked:
    """The options of a run. `patterns`: of which one must match the component, the extreme or component/extreme; none:
    all. `quick`: the quick levels alone, of the probes that have some. `time_limit`: seconds that a probe may take."""

    patterns: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    quick: bool = False
    processes: int = 2
    time_limit: float = 300.0
    command: str = "aliascope stability"
    package: str = running.PACKAGE


@dataclass(frozen=True)
class Map:
    """What a run found: its cells by kind, component and extreme, in the order of KINDS, of names and of EXTREMES.
    `lost`: modules that could not list their probes, with the reason; `absent`: what those lack that did not for
    want of a library."""

    asked: Asked
    started: str
    wall_seconds: float
    cells: tuple[Cell, ...]
    lost: Mapping[str, str]
    absent: Mapping[str, str]
    versions: Mapping[str, str]

    @property
    def broken(self) -> tuple[Cell, ...]:
        """The cells that pass their bound."""
        return tuple(cell for cell in self.cells if cell.breaks)

    @property
    def ours(self) -> tuple[Cell, ...]:
        """Of those, the ones that are to be mended here."""
        return tuple(cell for cell in self.broken if not cell.excused)

    @property
    def failed(self) -> tuple[Cell, ...]:
        """The cells of which a measurement came to no end."""
        return tuple(cell for cell in self.cells if cell.failed_from is not None)

    @property
    def exit_code(self) -> int:
        """4 where a measurement of ours came to no end, 1 where a component of ours passes its bound, else 0."""
        if self.lost or any(not cell.excused for cell in self.failed):
            return JobFailed.exit_code
        return 1 if self.ours else 0


@dataclass(frozen=True)
class _Work:
    module: str
    probe: Probe
    levels: tuple[float, ...]


def run(asked: Asked, tell: Tell) -> Map:
    """Runs all that is asked for. Raises InvalidInput for what matches nothing, NotAvailable where nothing that was
    asked for is there."""
    started, begun = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    _check_names(asked)
    with Workers(asked.processes) as workers:
        listed = _listed(asked, workers, tell)
        work = _chosen(asked, listed)
        versions = _versions(work, workers)
        cells = _measured(work, asked, workers, tell)
    if not cells and listed.lost:
        raise JobFailed("; ".join(f"{module}: {reason}" for module, reason in listed.lost.items()))
    reasons = {**listed.absent, **{cell.component: cell.absent for cell in cells if cell.absent}}
    if not any(cell.readings for cell in cells):
        raise NotAvailable(
            "nothing to measure is there: " + "; ".join(f"{name}: {why}" for name, why in reasons.items())
        )
    ordered = tuple(sorted(cells, key=place_of))
    return Map(asked, started, time.monotonic() - begun, ordered, listed.lost, listed.absent, versions)


_PLACES = {name: place for place, name in enumerate(EXTREMES)}


def place_of(cell: Cell) -> tuple[int, str, int]:
    """What the cells of a map are sorted by: the same whatever ended first."""
    return KINDS.index(cell.kind), cell.component, _PLACES[cell.extreme]


# --- what there is ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Listed:
    work: tuple[tuple[str, Probe], ...]
    lost: Mapping[str, str]
    absent: Mapping[str, str]


def _listed(asked: Asked, workers: Workers, tell: Tell) -> _Listed:
    """The probes of all modules, each asked in a worker."""
    names = running.modules(asked.package)
    tasks = [workers.begin(running.described, [name], LISTING_LIMIT) for name in names]
    found: dict[str, Mapping[str, Probe]] = {}
    lost: dict[str, str] = {}
    absent: dict[str, str] = {}
    for done, (name, task) in enumerate(zip(names, tasks, strict=True)):
        short = name.rpartition(".")[2]
        tell(f"what there is: {short}", done, len(names))
        try:
            found[name] = task.result()
        except NotAvailable as error:
            absent[short] = str(error)
        except Exception as error:  # noqa: BLE001  (a module of probes that does not load loses its own alone)
            lost[short] = str(error) if isinstance(error, AliascopeError) else f"{type(error).__name__}: {error}"
    running.joined(found.values())  # two of one name would be one cell
    work = tuple((module, probe) for module, probes in found.items() for probe in probes.values())
    return _Listed(work, lost, absent)


def _check_names(asked: Asked) -> None:
    for words, known, what in ((asked.groups, GROUPS, "group"), (asked.kinds, KINDS, "kind")):
        for word in words:
            if word not in known:
                raise InvalidInput(f'unknown {what} "{word}"{near_misses(word, known)}')


def _chosen(asked: Asked, listed: _Listed) -> list[_Work]:
    """What matches, those of renderers first: they take longest."""
    names = {name for _, probe in listed.work for name in names_of(probe)}
    for pattern in asked.patterns:
        if not listed.lost and not listed.absent and not any(fnmatchcase(name, pattern) for name in names):
            raise InvalidInput(f'"{pattern}" matches no component, extreme or component/extreme{_near(pattern, names)}')
    work = [
        _Work(module, probe, running.from_mild(probe, probe.quick if asked.quick else probe.levels))
        for module, probe in listed.work
        if _matches(asked, probe) and (probe.quick or not asked.quick)
    ]
    if not work and not listed.lost and not listed.absent:
        raise InvalidInput("no probe is all of what was asked for; leave out a pattern, --group, --kind or --quick")
    return sorted(work, key=lambda each: KINDS.index(each.probe.kind))


def names_of(probe: Probe) -> tuple[str, str, str]:
    """What a pattern may match."""
    return probe.component, probe.extreme, f"{probe.component}/{probe.extreme}"


def _near(pattern: str, names: Iterable[str]) -> str:
    """Near misses; not the hundreds of names where there is none."""
    near = near_misses(pattern, names)
    return near if "did you mean" in near else ""


def _matches(asked: Asked, probe: Probe) -> bool:
    if asked.groups and EXTREMES[probe.extreme].group not in asked.groups:
        return False
    if asked.kinds and probe.kind not in asked.kinds:
        return False
    if not asked.patterns:
        return True
    return any(fnmatchcase(name, pattern) for name in names_of(probe) for pattern in asked.patterns)


# --- measuring --------------------------------------------------------------------------------------------------------


def _measured(work: Sequence[_Work], asked: Asked, workers: Workers, tell: Tell) -> list[Cell]:
    """What came of each."""
    tasks = [_begun(workers, each, each.levels, asked.time_limit) for each in work]
    cells = []
    for done, (each, task) in enumerate(zip(work, tasks, strict=True)):
        tell(each.probe.name, done, len(work))
        try:
            cells.append(task.result())
        except JobFailed:
            cells.append(_again(workers, each, asked.time_limit))
    tell(None, len(work), len(work))
    return cells


def _begun(workers: Workers, work: _Work, levels: Sequence[float], time_limit: float) -> Task[Cell]:
    arguments = [work.module, work.probe.name, tuple(levels)]
    return workers.begin(running.run_named, arguments, time_limit, {"probe": work.probe.name, "levels": len(levels)})


def _again(workers: Workers, work: _Work, time_limit: float) -> Cell:
    """Level by level, up to the one that its process does not survive."""
    readings: list[Reading] = []
    for at in work.levels:
        try:
            cell = _begun(workers, work, [at], time_limit).result()
        except JobFailed as failure:
            return running.cell_of(work.probe, [*readings, Reading(at, None, failed=str(failure))])
        if cell.absent:
            return replace(cell, readings=tuple(readings))
        readings += cell.readings
    return running.cell_of(work.probe, readings)


def _versions(work: Sequence[_Work], workers: Workers) -> dict[str, str]:
    """Of the renderers that take part."""
    components = {each.probe.component.partition(":")[0] for each in work if each.probe.kind == "renderer"}
    names = [name for name in renderers.RENDERERS if name in components]
    tasks = [workers.begin(_versions_of, [name], LISTING_LIMIT) for name in names]
    found: dict[str, str] = {}
    for name, task in zip(names, tasks, strict=True):
        try:
            found.update(task.result())
        except AliascopeError as error:  # its cells say so too
            found[name] = str(error)
    return found


def _versions_of(name: str) -> dict[str, str]:
    return dict(renderers.find(name).versions())
