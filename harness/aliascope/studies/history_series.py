"""The series of `aliascope history`: one figure of one mode on one scene, over runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import median
from typing import Literal

from aliascope import plan
from aliascope.history import KeptCell, KeptRun
from aliascope.regression.records import CellName

ALIKE = 3
"""Runs with the same error that tell it for exact."""
ALL_SCENES, ALL_MODES = "all scenes", "all modes"
TIME = "cpu-seconds"
RAYS = "rays-"

Kind = Literal["exact", "errors", "ranks"]


@dataclass(frozen=True)
class Point:
    """A figure of the run of this index."""

    run: int
    value: float
    standard_error: float | None = None


@dataclass(frozen=True)
class Series:
    """A figure of a mode over runs; `machine`: the only one that it is of, empty for all of them."""

    name: CellName
    metric: str
    machine: str
    kind: Kind
    points: tuple[Point, ...]


@dataclass(frozen=True)
class Asked:
    """Patterns of the shell; nothing stands for all."""

    scenes: tuple[str, ...] = ()
    renderers: tuple[str, ...] = ()
    modes: tuple[str, ...] = ()
    metrics: tuple[str, ...] = ()


def in_order(kept: Sequence[KeptRun]) -> tuple[KeptRun, ...]:
    """Runs in the order of time, those of one revision together, where the first of them is. A tree with changes is
    another one each time."""
    first: dict[str, str] = {}
    for run in kept:
        first[run.revision] = min(run.started, first.get(run.revision, run.started))

    def begun(run: KeptRun) -> str:
        return first[run.revision] if named(run.revision) else run.started

    return tuple(sorted(kept, key=lambda run: (begun(run), run.revision if named(run.revision) else "", run.started)))


def named(revision: str) -> bool:
    """Whether it says what the source was."""
    return not revision.endswith("+") and revision != "unknown"


def machine_of(run: KeptRun) -> str:
    """What times are compared on: the processor and how many cores there are. A new kernel is no new machine."""
    cores = run.machine.get("cores")
    return run.machine.get("processor", "unknown") + (f", {cores} cores" if cores else "")


Cells = Mapping[CellName, Mapping[int, KeptCell]]


def chosen(runs: Sequence[KeptRun], asked: Asked) -> Cells:
    """The cells that were asked for, by name and run."""
    found: dict[CellName, dict[int, KeptCell]] = {}
    for index, run in enumerate(runs):
        for cell in run.cells:
            found.setdefault(cell.name, {})[index] = cell
    names = list(found)
    wanted: tuple[tuple[tuple[str, ...], str, Callable[[CellName], str]], ...] = (
        (asked.scenes, "scene", lambda name: name.scene),
        (asked.renderers, "renderer", lambda name: name.renderer),
        (asked.modes, "mode", lambda name: name.mode),
    )
    for patterns, what, part in wanted:
        if patterns:
            chosen = set(plan.matching(patterns, list(dict.fromkeys(map(part, names))), what))
            names = [name for name in names if part(name) in chosen]
    return {name: found[name] for name in names}


def series_of(runs: Sequence[KeptRun], cells: Cells) -> Iterable[Series]:
    for name, by_run in cells.items():
        errors = tuple(
            Point(i, cell.rmse.value, cell.rmse.standard_error)
            for i, cell in by_run.items()
            if cell.rmse.value is not None
        )
        if errors:
            yield Series(name, "rmse", "", _kind(runs, by_run, errors), errors)
        machines = dict.fromkeys(machine_of(runs[i]) for i in by_run)
        for machine in machines:
            own = [(i, cell.cpu_seconds) for i, cell in by_run.items() if machine_of(runs[i]) == machine]
            times = tuple(Point(i, time) for i, time in own if time is not None)
            if times:
                yield Series(name, TIME, machine, "ranks", times)
        counts = tuple(Point(i, cell.samples) for i, cell in by_run.items() if cell.samples is not None)
        if counts:
            yield Series(name, "samples", "", "exact", counts)
        for ray in dict.fromkeys(ray for cell in by_run.values() for ray in cell.rays):
            rays = tuple(Point(i, cell.rays.get(ray, 0.0)) for i, cell in by_run.items() if cell.samples is not None)
            if rays == counts:  # one primary ray a sample: nothing that the samples do not say
                continue
            yield Series(name, RAYS + ray, "", "exact", rays)


def _kind(runs: Sequence[KeptRun], by_run: Mapping[int, KeptCell], points: Sequence[Point]) -> Kind:
    """Of errors."""
    alike = most = pairs = same = 0
    for one, other in pairwise(points):
        if not _comparable(runs, by_run, one.run, other.run):
            continue
        pairs += 1
        alike = alike + 1 if one.value == other.value else 0
        same += one.value == other.value
        most = max(most, alike)
    if most + 1 >= ALIKE and 2 * same >= pairs:
        return "exact"
    # Errors of the same draws are no independent ones: standard errors are then too wide, which raises no alarm.
    return "errors" if all(point.standard_error for point in points) else "ranks"


def _comparable(runs: Sequence[KeptRun], by_run: Mapping[int, KeptCell], one: int, other: int) -> bool:
    """Whether exact figures of two runs have to be the same, if nothing changed."""
    return machine_of(runs[one]) == machine_of(runs[other]) and by_run[one].draws == by_run[other].draws


def pooled(runs: Sequence[KeptRun], series: Sequence[Series]) -> list[Series]:
    """Of each renderer on each machine, the times of all its modes as one series, where it has two or more."""
    groups: dict[tuple[str, str], list[Series]] = {}
    for one in series:
        if one.metric == TIME and all(point.value > 0.0 for point in one.points):
            groups.setdefault((one.name.renderer, one.machine), []).append(one)
    found = []
    for (renderer, machine), members in groups.items():
        logs: dict[int, list[float]] = {}
        for one in members:
            middle = median(point.value for point in one.points)
            for point in one.points:
                logs.setdefault(point.run, []).append(math.log(point.value / middle))
        # A run of few of the modes would say something else than the others.
        points = tuple(Point(i, math.exp(median(logs[i]))) for i in sorted(logs) if 2 * len(logs[i]) > len(members))
        if len(members) > 1 and points:
            found.append(Series(CellName(ALL_SCENES, renderer, ALL_MODES), TIME, machine, "ranks", points))
    return found


METRICS = ("rmse", TIME, "samples")


def rank(metric: str) -> tuple[int, str]:
    return (METRICS.index(metric) if metric in METRICS else len(METRICS), metric)


def order_of(one: Series) -> tuple[object, ...]:
    name = one.name
    return (*rank(one.metric), name.scene != ALL_SCENES, name.scene, name.renderer, name.mode, one.machine)
