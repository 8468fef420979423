"""The report: one page that needs nothing but itself, and its figures as SVG and CSV.

`page.html` is the skeleton, in the order of a reader's questions: what came out, let me see it, can I trust it. What is
interactive is drawn by the scripts from the JSON of `document.py` and the pictures of `encode.py`.
"""

from __future__ import annotations

import base64
import contextlib
import hashlib
import math
import os
from datetime import datetime
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from aliascope.errors import NotWritable
from aliascope.records import ReportData
from aliascope.report.document import document, script_json
from aliascope.report.encode import PictureStore
from aliascope.report.plots import colours, plot_csv, plot_svg, plots_of
from aliascope.report.tables import results_csv

SCRIPTS = (
    "core.js",
    "metrics.js",
    "state.js",
    "pictures.js",
    "plot.js",
    "choose.js",
    "tables.js",
    "sheet.js",
    "controls.js",
    "viewer.js",
    "page.js",
)
"""In the order of their use of each other; they become one function."""


def write_report(folder: Path, data: ReportData) -> Path:
    """Writes report.html, results.csv and plots/ to a folder, which is made; each file whole or not at all.

    Returns the path of report.html. Raises NotWritable, and InvalidInput where a picture has not its reference's size.
    """
    text = page(data)
    renderers = [row.renderer for scene in data.scenes for row in scene.rows]
    for plot in plots_of(data):
        _write(folder / "plots" / f"{plot.name}.svg", plot_svg(plot, colours(renderers)))
        _write(folder / "plots" / f"{plot.name}.csv", plot_csv(plot))
    _write(folder / "results.csv", results_csv(data))
    return _write(folder / "report.html", text)


def page(data: ReportData) -> str:
    """The text of report.html."""
    pictures = PictureStore()
    values = document(data, pictures)
    values["colours"] = colours(values["renderers"])
    style = _source("page.css")
    body = "\n".join(_source(name) for name in SCRIPTS)
    script = f'(() => {{\n"use strict";\n{body}\n}})();\n'
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["figures"] = _figures
    return environment.from_string(_source("page.html")).render(
        data=data,
        started=_date(data.started),
        wall=_duration(data.wall_seconds),
        plots=[(plot.name, plot.title) for plot in plots_of(data)],
        quanta=_quanta(data),
        undrawn=_undrawn(data),
        policy=f"default-src 'none'; script-src '{_digest(script)}'; style-src '{_digest(style)}'",
        style=Markup(style),  # ours
        script=Markup(script),  # ours
        json=Markup(script_json(values)),  # escaped by script_json
        pictures=pictures.texts,
    )


def _source(name: str) -> str:
    return files(__name__).joinpath(name).read_text(encoding="utf-8")


def _digest(text: str) -> str:
    """What a content security policy knows an inline script or style by: nothing else on the page may run or load."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")


def _write(path: Path, text: str) -> Path:
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        with contextlib.suppress(OSError):  # where the folder is none, neither is the file
            temporary.unlink()
    return path


def _date(text: str) -> str:
    """A date of ISO 8601 as a person reads it; anything else as it is."""
    try:
        return datetime.fromisoformat(text).strftime("%Y-%m-%d %H:%M %Z").strip()
    except ValueError:
        return text


def _duration(seconds: float) -> str:
    if not math.isfinite(seconds):
        return "an unknown time"
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s"


def _figures(value: float) -> str:
    """Three significant digits."""
    return f"{value:.3g}"


def _quanta(data: ReportData) -> list[tuple[str, list[float]]]:
    """The steps of each renderer's output, coarsest first; 0 is float."""
    found: dict[str, set[float]] = {}
    for scene in data.scenes:
        for row in scene.rows:
            found.setdefault(row.renderer, set()).add(row.quantum)
    return [(renderer, sorted(steps, reverse=True)) for renderer, steps in found.items()]


def _undrawn(data: ReportData) -> list[tuple[str, str, list[tuple[str, int]]]]:
    """(renderer, reason, [(scene, number of modes)]) of the empty cells."""
    found: dict[tuple[str, str], dict[str, int]] = {}
    for scene in data.scenes:
        for cell in scene.empty:
            scenes = found.setdefault((cell.renderer, cell.reason), {})
            scenes[scene.name] = scenes.get(scene.name, 0) + 1
    return [(renderer, reason, list(scenes.items())) for (renderer, reason), scenes in found.items()]
