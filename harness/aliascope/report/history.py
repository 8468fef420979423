"""The page of `aliascope history`: what changed, and each mode over the runs. It loads nothing but itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from aliascope.report.document import script_json
from aliascope.report.files import digest, environment, source
from aliascope.report.plots import colours


@dataclass(frozen=True)
class Entry:
    """A step in the list. `row` is the index of its mode in the data of the scripts; `up`: more of error or cost."""

    row: int
    scene: str
    renderer: str
    mode: str
    metric: str
    machine: str
    levels: str
    change: str
    interval: str
    why: str
    up: bool


@dataclass(frozen=True)
class Place:
    """The steps between two runs; `also`: what else changed there."""

    where: str
    entries: tuple[Entry, ...]
    also: tuple[str, ...]


@dataclass(frozen=True)
class HistoryPage:
    """All of the page; `data` is what the scripts read, but for the colours."""

    lead: str
    facts: tuple[str, ...]
    places: tuple[Place, ...]
    notes: tuple[tuple[str, str], ...]
    runs: tuple[tuple[str, ...], ...]
    files: tuple[tuple[str, str], ...]
    data: Mapping[str, Any]
    renderers: Sequence[str]
    shown: int = 6
    """Entries of a place that are not folded away."""


def history_page(page: HistoryPage) -> str:
    """The text of the page."""
    style = source("page.css") + source("history.css")
    body = "\n".join(source(name) for name in ("plain_data.js", "core.js", "history_plot.js", "history.js"))
    script = f'(() => {{\n"use strict";\n{body}\n}})();\n'
    values = {**page.data, "colours": colours(page.renderers), "families": []}
    return (
        environment()
        .from_string(source("history.html"))
        .render(
            page=page,
            policy=f"default-src 'none'; script-src '{digest(script)}'; style-src '{digest(style)}'",
            style=Markup(style),  # ours
            script=Markup(script),  # ours
            json=Markup(script_json(values)),  # escaped by script_json
        )
    )
