"""The files of a stability map for machines and for reading: JSON, CSV, Markdown, and the page beside them."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path
from typing import Any

from aliascope import places
from aliascope.errors import NotWritable
from aliascope.sharing import records_shared
from aliascope.stability.extremes import EXTREMES
from aliascope.stability.records import Cell, Reading
from aliascope.studies import stability_page
from aliascope.studies import stability_text as text
from aliascope.studies.stability import Map
from aliascope.text_files import write_text

NO_RESULT = "the result was no finite number"

# --- JSON -------------------------------------------------------------------------------------------------------------


def document(found: Map) -> dict[str, Any]:
    """What --json prints, and stability.json holds. Null stands for an error or a loss that is infinite, or that is
    not there: `reason` says which."""
    names = {cell.extreme for cell in found.cells}
    asked = found.asked
    return {
        "started": found.started,
        "wall_seconds": round(found.wall_seconds, 3),
        "version": places.own_version(),
        "revision": places.revision(),
        "machine": places.machine(),
        "versions": dict(found.versions),
        "command": asked.command,
        "quick": asked.quick,
        "holds": found.exit_code == 0,
        "summary": text.summary(found),
        "counts": {
            status: sum(cell.status == status for cell in found.cells)
            for status in ("keeps", "breaks", "refuses", "absent", "failed")
        },
        "extremes": [
            {"name": each.name, "group": each.group, "title": each.title, "axis": each.axis}
            for each in EXTREMES.values()
            if each.name in names
        ],
        "cells": [_cell(cell) for cell in found.cells],
        "absent": text.absences(found),
        "lost": dict(found.lost),
    }


def _cell(cell: Cell) -> dict[str, Any]:
    lost = cell.digits_lost
    reason = "there is no error" if lost is None else NO_RESULT if math.isinf(lost) else ""
    return {
        "component": cell.component,
        "kind": cell.kind,
        "extreme": cell.extreme,
        "group": EXTREMES[cell.extreme].group,
        "status": cell.status,
        "text": text.cell_text(cell),
        "excused": cell.excused,
        "unit": cell.unit,
        "against": cell.against,
        "bound": cell.bound,
        "precision": cell.precision,
        "breaks": list(cell.breaks),
        "refused_from": cell.refused_from,
        "failed_from": cell.failed_from,
        "digits_lost": _finite(lost),
        "reason": cell.absent or reason,
        "note": cell.note,
        "readings": [_reading(each, cell) for each in cell.readings],
    }


def _reading(reading: Reading, cell: Cell) -> dict[str, Any]:
    return {
        "at": reading.at,
        "error": _finite(reading.error),
        "outcome": outcome(reading, cell),
        "reason": reason_of(reading),
        "cpu_seconds": round(reading.seconds, 6),
    }


def outcome(reading: Reading, cell: Cell) -> str:
    """What became of a level, in a word."""
    if reading.failed:
        return "failed"
    if reading.refused:
        return "refused"
    return "broken" if cell.passed(reading) else "kept"


def reason_of(reading: Reading) -> str:
    """Why a reading has no error, if so."""
    return reading.failed or reading.refused or (NO_RESULT if reading.error == math.inf else "")


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


# --- CSV and Markdown -------------------------------------------------------------------------------------------------

COLUMNS = (
    *("kind", "component", "extreme", "group", "level", "axis", "error", "unit", "bound", "precision"),
    *("digits_lost", "outcome", "excused", "reason", "cpu_seconds"),
)


def table_csv(found: Map) -> str:
    """A row a reading; a cell of what is not there has none."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for cell in found.cells:
        extreme = EXTREMES[cell.extreme]
        for each in cell.readings:
            error = _finite(each.error)
            writer.writerow(
                [
                    *(cell.kind, cell.component, cell.extreme, extreme.group, repr(each.at), extreme.axis),
                    *("" if error is None else repr(error), cell.unit, repr(cell.bound), repr(cell.precision)),
                    *("" if error is None else f"{cell.lost(error):.3f}", outcome(each, cell), int(cell.excused)),
                    *(" ".join(reason_of(each).split()), f"{each.seconds:.6f}"),
                ]
            )
    return out.getvalue()


def markdown(found: Map) -> str:
    """The map, a table for each group of extremes, and what breaks."""
    parts = [f"{text.summary(found)}."]
    for grid in text.grids(found.cells):
        head = [grid.group, *(each.name for each in grid.extremes)]
        rows = [
            [f"`{component}`", *("" if cell is None else _marked(cell) for cell in grid.row(kind, component))]
            for kind, component in grid.rows
        ]
        parts.append("\n".join(_line(row) for row in (head, ["---"] * len(head), *rows)))
    parts.append(
        "Where a component passes its bound: in bold, of ours; in italics, by the arithmetic of others or without a "
        "safeguard. Columns: "
        + "; ".join(
            f"{e.name}: {e.title[0].lower()}{e.title[1:]} ({e.axis})"
            for g in text.grids(found.cells)
            for e in g.extremes
        )
        + "."
    )
    listed = [f"- `{cell.component}`, {cell.extreme}: {_escaped(text.break_text(cell))}" for cell in found.broken]
    if listed:
        parts.append("\n".join(listed))
    return "\n\n".join(parts) + "\n"


def _marked(cell: Cell) -> str:
    told = text.cell_text(cell)
    if not cell.breaks and cell.failed_from is None:
        return told
    return f"*{told}*" if cell.excused else f"**{told}**"


def _line(row: list[str]) -> str:
    return f"| {' | '.join(row)} |"


def _escaped(told: str) -> str:
    for mark in ("\\", "|", "*", "_", "<"):
        told = told.replace(mark, f"\\{mark}")
    return " ".join(told.split())


# --- writing ----------------------------------------------------------------------------------------------------------


def check_writable(folder: Path) -> None:
    """Makes the folder, before anything takes time. Raises NotWritable."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise NotWritable(f"{folder}: cannot be written: {error.strerror}; choose another folder with -o") from error


def write(folder: Path, found: Map) -> Path:
    """Writes the page, stability.json, .csv and .md; returns the path of the page. Raises NotWritable."""
    found = records_shared(found)
    write_text(folder / "stability.json", json.dumps(document(found), allow_nan=False, indent=1) + "\n")
    write_text(folder / "stability.csv", table_csv(found))
    write_text(folder / "stability.md", markdown(found))
    return write_text(folder / "report.html", stability_page.html(found))
