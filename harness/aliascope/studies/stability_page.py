"""What the page of a stability map shows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

from aliascope import places
from aliascope.report.stability import Item, MapCell, MapHead, MapTable, StabilityPage, stability_page
from aliascope.stability.extremes import EXTREMES
from aliascope.stability.records import Cell, Reading
from aliascope.studies import stability_text as text
from aliascope.studies.stability import Map

TITLES = {
    "geometry": "Geometry",
    "radiance": "Radiance",
    "counts": "Counts",
    "statistics": "Statistics",
    "points": "Geometry of points",
    "metrics": "Metrics",
}

STATUSES = {
    "keeps": "keeps its bound",
    "breaks": "breaks",
    "refuses": "keeps its bound as far as it goes",
    "absent": "is not there",
    "failed": "failed",
}


def html(found: Map) -> str:
    """The text of the page."""
    return stability_page(page_of(found))


def page_of(found: Map) -> StabilityPage:
    indices = {(cell.kind, cell.component, cell.extreme): place for place, cell in enumerate(found.cells)}
    files = (
        ("stability.json", "all figures"),
        ("stability.csv", "a row a reading"),
        ("stability.md", "the tables, for a README"),
    )
    steps = (
        f"below {text.STEPS[0]:g}",
        *(f"{low:g} to {high:g}" for low, high in pairwise(text.STEPS)),
    )
    return StabilityPage(
        lead=text.summary(found) + ".",
        facts=(
            f"version {places.own_version()}",
            f"revision {places.revision()}",
            f"{found.started[:16].replace('T', ' ')} UTC",
            *(["quick levels alone"] if found.asked.quick else []),
        ),
        tables=tuple(_table(grid, indices) for grid in text.grids(found.cells)),
        legend=tuple(enumerate((*steps, f"{text.STEPS[-1]:g} or more", "nothing left"))),
        lists=tuple(each for each in _lists(found) if each[2]),
        notes=tuple(_notes(found)),
        files=files,
        data={"cells": [_data(cell) for cell in found.cells]},
    )


# --- the tables -------------------------------------------------------------------------------------------------------


def _table(grid: text.Grid, indices: dict[tuple[Any, str, str], int]) -> MapTable:
    kinds: dict[str, list[tuple[str, tuple[MapCell | None, ...]]]] = {}
    for kind, component in grid.rows:
        cells = tuple(
            None if cell is None else _cell(cell, indices[kind, component, cell.extreme])
            for cell in grid.row(kind, component)
        )
        kinds.setdefault(text.PLURALS[kind], []).append((component, cells))
    heads = tuple(MapHead(each.name, each.title, each.axis) for each in grid.extremes)
    return MapTable(grid.group, TITLES[grid.group], heads, tuple((kind, tuple(rows)) for kind, rows in kinds.items()))


def _cell(cell: Cell, index: int) -> MapCell:
    marks = []
    if cell.refused_from is not None:
        marks.append("refused")
    if cell.breaks or cell.failed_from is not None:
        marks.append("excused" if cell.excused else "ours")
    if cell.failed_from is not None:
        marks.append("failed")
    if cell.absent:
        marks.append("absent")
    lost = text.lost_text(cell)
    label = f"{cell.component}, {cell.extreme}: {_told(cell)}"
    return MapCell(
        index, text.cell_text(cell), _short(lost), text.step(cell), tuple(marks), f"{label}; {lost}" if lost else label
    )


def _short(lost: str) -> str:
    return lost.removesuffix(" lost")


def _told(cell: Cell) -> str:
    """What became of a cell, in words."""
    told = STATUSES[cell.status]
    if cell.breaks:
        whose = "by others or without a safeguard" if cell.excused else "ours"
        told = f"breaks at {text.levels(cell.breaks, ' and ')}, {whose}"
    if cell.refused_from is not None:
        told += f", refuses at {text.level(cell.refused_from)}"
    if cell.failed_from is not None:
        told = (
            f"{told}, at {text.level(cell.failed_from)}"
            if not cell.breaks
            else f"{told}, fails at {text.level(cell.failed_from)}"
        )
    return told


# --- what is said of cells --------------------------------------------------------------------------------------------


def _lists(found: Map) -> Iterable[tuple[str, str, tuple[Item, ...]]]:
    places_of = {id(cell): place for place, cell in enumerate(found.cells)}

    def items(cells: Iterable[Cell], words: Any) -> tuple[Item, ...]:
        return tuple(Item(places_of[id(cell)], f"{cell.component}, {cell.extreme}", words(cell)) for cell in cells)

    lost = tuple(Item(None, f"the probes of {module}", reason) for module, reason in found.lost.items())
    absent = tuple(Item(None, name, reason) for name, reason in text.absences(found).items())
    refused = [cell for cell in found.cells if cell.refused_from is not None]
    yield "Failed", "bad", (*items(found.failed, text.failure_text), *lost)
    yield "What breaks, and is ours", "bad", items(found.ours, text.break_text)
    yield (
        "What breaks by the arithmetic of others, or without a safeguard",
        "",
        items((c for c in found.broken if c.excused), text.break_text),
    )
    yield "What declines", "", items(refused, text.refusal_text)
    yield "What is not there", "", absent


def _notes(found: Map) -> Iterable[tuple[str, str]]:
    machine = places.machine()
    yield "Machine", f"{machine['processor']}, {machine['cores']} cores, {machine['system']}"
    yield from found.versions.items()
    yield "Command", found.asked.command
    seconds = sum(each.seconds for cell in found.cells for each in cell.readings)
    yield "Time", f"{found.wall_seconds:.0f} s, of which probes took {seconds:.0f} s of CPU time in their processes"


# --- for the scripts --------------------------------------------------------------------------------------------------


def _data(cell: Cell) -> dict[str, Any]:
    extreme = EXTREMES[cell.extreme]
    return {
        "component": cell.component,
        "kind": cell.kind,
        "extreme": cell.extreme,
        "title": extreme.title,
        "axis": extreme.axis,
        "unit": cell.unit,
        "against": cell.against,
        "bound": cell.bound,
        "precision": cell.precision,
        "told": _told(cell),
        "lost": text.lost_text(cell),
        "note": cell.note,
        "absent": cell.absent,
        "readings": [_reading(each, cell) for each in cell.readings],
        "falling": _falling([each.at for each in cell.readings]),
    }


def _falling(levels: Sequence[float]) -> bool:
    """Whether what is more extreme is less, so that the axis goes the other way."""
    return len(levels) > 1 and all(a >= b for a, b in pairwise(levels)) and levels[0] > levels[-1]


def _reading(reading: Reading, cell: Cell) -> dict[str, Any]:
    """`error`: null for none, "none" for a result that was no finite number."""
    infinite = reading.error is not None and math.isinf(reading.error)
    return {
        "at": reading.at,
        "level": text.level(reading.at),
        "error": "none" if infinite else reading.error,
        "lost": None if reading.error is None or infinite else round(cell.lost(reading.error), 1),
        "over": cell.passed(reading),
        "refused": reading.refused,
        "failed": reading.failed,
    }
