"""The files of a regression run for machines and for those who review: JSON, JUnit, Markdown."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from aliascope import history
from aliascope.errors import CheckFailed, NotAvailable, NotWritable, Unsupported
from aliascope.references import Reference, files
from aliascope.regression.records import CellName, CellVerdict, Check, Control, Run
from aliascope.renderers.base import filter_of
from aliascope.studies import regress_page
from aliascope.studies import regress_text as text
from aliascope.studies.regress import Seen
from aliascope.text_files import write_text

HISTORY = "history.sqlite"

# --- JSON -------------------------------------------------------------------------------------------------------------

_PICTURES = ("first", "mean", "p_values")
"""Of what was observed: for the page alone."""
_DIGITS = 9


def document(run: Run) -> dict[str, Any]:
    """What --json prints, and results.json holds: all of a run but pictures. A figure that is none is null."""
    plain = _plain(dataclasses.replace(run, cells=(), controls=(), empty=()))
    return {
        **plain,
        "passed": run.passed,
        "summary": text.summary(run),
        "shared": text.SHARED,
        "cells": [_cell(cell) for cell in run.cells],
        "controls": [{**_name(control.name), **_fields(control)} for control in run.controls],
        "empty": [{**_name(name), "reason": reason} for name, reason in run.empty],
    }


def results(run: Run) -> str:
    """results.json."""
    return json.dumps(document(run), allow_nan=False) + "\n"


def _cell(cell: CellVerdict) -> dict[str, Any]:
    status = "passed" if cell.passed else "crashed" if cell.failed else "failed"
    checks = [{**_fields(check), "headroom": _plain(check.headroom)} for check in text.in_order(cell.checks)]
    observed = None if cell.observed is None else _fields(cell.observed)
    made = {"status": status, "problem": cell.problem, "again": cell.again, "bless": cell.bless}
    return {**_name(cell.name), **made, "checks": checks, "observed": observed}


def _name(name: CellName) -> dict[str, str]:
    return {"scene": name.scene, "renderer": name.renderer, "mode": name.mode}


def _fields(record: Any) -> dict[str, Any]:
    """Of a record without its cell's name and pictures, which would stand there again and again."""
    kept = [field.name for field in dataclasses.fields(record) if field.name not in ("name", *_PICTURES)]
    return {key: _plain(getattr(record, key)) for key in kept}


def _plain(value: Any) -> Any:
    """As JSON has it."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return _fields(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(each) for each in value]
    if isinstance(value, float | np.floating):
        return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


# --- JUnit ------------------------------------------------------------------------------------------------------------

_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold, not even escaped."""


def junit(run: Run) -> str:
    """A test suite for each scene, with a case for each cell, and one for the controls, as Ant's schema has them, which
    those of Jenkins and others take in: a case has at most one of skipped, error, failure."""
    scenes = dict.fromkeys([*(cell.name.scene for cell in run.cells), *(name.scene for name, _ in run.empty)])
    suites = {scene: [_case_of(cell) for cell in run.cells if cell.name.scene == scene] for scene in scenes}
    for name, reason in run.empty:
        suites[name.scene].append(_case(name, name.mode, 0.0, ("skipped", "not drawn", reason)))
    if run.controls:
        suites["the controls"] = [_case_of_control(control) for control in run.controls]
    if run.skipped:
        suites["the renderers"] = [
            _case(f"aliascope.renderers.{name}", "is there", 0.0, ("skipped", "not there", reason))
            for name, reason in run.skipped.items()
        ]
    root = ElementTree.Element("testsuites")
    for place, (title, cases) in enumerate(suites.items()):
        root.append(_suite(place, title, cases, run))
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _suite(place: int, name: str, cases: Sequence[ElementTree.Element], run: Run) -> ElementTree.Element:
    counts = {
        kind: str(sum(case.find(tag) is not None for case in cases))
        for kind, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped"))
    }
    seconds = sum(float(case.get("time", "0")) for case in cases)
    suite = ElementTree.Element(
        "testsuite",
        {
            "name": _clean(name),
            "package": "aliascope.regress",
            "id": str(place),
            "timestamp": run.started[:19],  # the schema wants no time zone; it is UTC
            "hostname": "localhost",
            "tests": str(len(cases)),
            **counts,
            "time": f"{seconds:.3f}",
        },
    )
    properties = ElementTree.SubElement(suite, "properties")
    facts = {"revision": run.revision, "command": run.command, **run.machine, **run.versions}
    for key, value in facts.items():
        ElementTree.SubElement(properties, "property", {"name": _clean(key), "value": _clean(value)})
    suite.extend(cases)
    ElementTree.SubElement(suite, "system-out")
    ElementTree.SubElement(suite, "system-err")
    return suite


def _case_of(cell: CellVerdict) -> ElementTree.Element:
    """Its time is that of rendering all its pictures, CPU time."""
    replicates = cell.observed.replicates if cell.observed is not None else ()
    seconds = sum(replicate.cpu_seconds for replicate in replicates)
    if cell.passed:
        return _case(cell.name, cell.name.mode, seconds)
    told = (cell.problem or "; ".join(text.reasons(cell)), "\n".join(text.cell_lines(cell)))
    return _case(cell.name, cell.name.mode, seconds, ("error" if cell.failed else "failure", *told))


def _case_of_control(control: Control) -> ElementTree.Element:
    found = None if control.caught else ("failure", "not caught", text.control_line(control))
    where = f"aliascope.controls.{control.name.scene}.{control.name.renderer}"
    return _case(where, f"{control.defect} in {control.name.mode} is caught", 0.0, found)


def _case(
    where: CellName | str, name: str, seconds: float, outcome: tuple[str, str, str] | None = None
) -> ElementTree.Element:
    """outcome: the tag, a message of a line, and the text."""
    classname = where if isinstance(where, str) else f"aliascope.{where.scene}.{where.renderer}"
    case = ElementTree.Element(
        "testcase", {"classname": _clean(classname), "name": _clean(name), "time": f"{seconds:.3f}"}
    )
    if outcome is not None:
        tag, message, told = outcome
        kind = {} if tag == "skipped" else {"type": "crash" if tag == "error" else "regression"}
        ElementTree.SubElement(case, tag, {"message": _clean(message), **kind}).text = _clean(told)
    return case


def _clean(value: str) -> str:
    return _NO_XML.sub("\ufffd", value)


# --- Markdown ---------------------------------------------------------------------------------------------------------


def markdown(run: Run) -> str:
    """A summary for a review: failures first, the rest folded."""
    failed, fine = text.split(run)
    parts = [f"## aliascope regress: {'passed' if run.passed else 'FAILED'}", _escaped(text.summary(run)) + "."]
    parts += [_failures(failed)] if failed else []
    parts += _after(failed)
    if run.controls:
        parts += ["### Controls", _controls(run.controls)]
    if warned := text.warnings_of(run):
        parts += ["### Warnings", _table([(cell, check) for cell, check in warned])]
    if run.skipped:
        parts += [
            "### Skipped",
            "\n".join(f"- {_escaped(f'{name}: {reason}')}" for name, reason in run.skipped.items()),
        ]
    parts += _folded(f"All checks of {text.counted(len(fine), 'cell')} that passed", _checks(fine))
    parts += _folded(
        f"{text.counted(len(run.empty), 'cell')} not drawn",
        "\n".join(f"- `{name.text}`: {_escaped(reason)}" for name, reason in run.empty),
    )
    facts = {"revision": run.revision, "started": run.started, "command": run.command, **run.machine, **run.versions}
    parts += _folded("How it was made", "\n".join(f"- {_escaped(f'{key}: {value}')}" for key, value in facts.items()))
    return "\n\n".join([*parts, " ".join(text.head(run))]) + "\n"


def _failures(failed: Sequence[CellVerdict]) -> str:
    rows: list[Sequence[str]] = []
    for cell in failed:
        wrong = [check for check in text.in_order(cell.checks) if not (check.passed or check.warning)]
        if cell.problem:
            rows.append((f"`{cell.name.text}`", _escaped(cell.problem), "", "", ""))
        rows += [_row(cell, check) for check in wrong]
    return _rows(rows)


def _after(failed: Sequence[CellVerdict]) -> list[str]:
    """The commands, as blocks that can be copied."""
    return [f"`{cell.name.text}`\n\n```\n{chr(10).join(told)}\n```" for cell in failed if (told := text.after(cell))]


def _controls(controls: Sequence[Control]) -> str:
    made = ["| put in | into | caught by |", "|---|---|---|"]
    for control in controls:
        by = _escaped(control.by) if control.caught else f"**not caught** {_escaped(control.problem)}"
        made.append(f"| {_escaped(control.defect)} | `{control.name.text}` | {by.strip()} |")
    return "\n".join(made)


def _checks(cells: Sequence[CellVerdict]) -> str:
    return _table([(cell, check) for cell in cells for check in text.in_order(cell.checks)]) if cells else ""


def _table(pairs: Sequence[tuple[CellVerdict, Check]]) -> str:
    return _rows([_row(cell, check) for cell, check in pairs])


def _row(cell: CellVerdict, check: Check) -> tuple[str, ...]:
    unit = f" {check.unit}" if check.unit else ""
    limit = f"{'≥' if check.at_least else '≤'} {text.number(check.limit)}{unit}"
    about = "; ".join([check.about, *text.notes(check), *([check.detail] if check.detail else [])])
    observed = f"{text.number(check.observed)}{unit}"
    return f"`{cell.name.text}`", *map(_escaped, (about, observed, limit, text.headroom(check)))


def _rows(rows: Sequence[Sequence[str]]) -> str:
    head = ["| cell | check | observed | limit | head-room |", "|---|---|--:|--:|--:|"]
    return "\n".join([*head, *(f"| {' | '.join(row)} |" for row in rows)])


def _folded(title: str, body: str) -> list[str]:
    return [f"<details><summary>{title}</summary>\n\n{body}\n\n</details>"] if body else []


def _escaped(value: str) -> str:
    """Words as they are: no markup, no new cell of a table."""
    for mark, escape in (("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("|", "\\|"), ("*", "\\*"), ("_", "\\_")):
        value = value.replace(mark, escape)
    return " ".join(value.split())


HISTORY = "history.sqlite"


# --- writing ----------------------------------------------------------------------------------------------------------


def check_writable(folder: Path) -> None:
    """Makes the folder, before anything takes time. Raises NotWritable."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise NotWritable(f"{folder}: cannot be written: {error.strerror}; choose another folder with -o") from error


def check_drawn(seen: Seen) -> None:
    """Raises NotAvailable or Unsupported where there is no cell: a run that tests nothing passes nothing."""
    if seen.cells:
        return
    if seen.skipped:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in seen.skipped.items())
        raise NotAvailable(f"nothing is left to test, as renderers are not there: {reasons}")
    name, reason = seen.empty[0] if seen.empty else (None, "the suite has no mode for these scenes; name one with -m")
    raise Unsupported(f"nothing to test: {name.text}: {reason}" if name else f"nothing to test: {reason}")


def write(
    folder: Path, run: Run, seen: Seen, junit_path: Path | None = None, markdown_path: Path | None = None
) -> Path:
    """Writes the page, results.json and summary.md of a folder and the files that were asked for, and adds the run to
    its history. Returns the path of the page. Raises NotWritable; InvalidInput for a history of a newer version."""
    write_text(folder / "results.json", results(run))
    write_text(folder / "summary.md", markdown(run))
    if junit_path:
        write_text(junit_path, junit(run))
    if markdown_path:
        write_text(markdown_path, markdown(run))
    scenes = {cell.name.scene: cell.file for cell in seen.cells}
    page = regress_page.write(folder, run, scenes, _references(seen))
    history.add(folder / HISTORY, run)
    return page


def _references(seen: Seen) -> dict[tuple[str, str], Reference]:
    """Those that are there, by scene and filter."""
    found = {}
    for cell in seen.cells:
        key = cell.name.scene, filter_of(cell.spec)
        scene = cell.file.scene
        if key not in found:
            with contextlib.suppress(CheckFailed):  # which the verdict says
                found[key] = files.load(seen.asked.references, key[0], scene, scene.view.size, key[1])
    return found
