"""The page of `aliascope stability`: the map as tables, and the readings of each cell. It loads nothing but itself."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup, escape

from aliascope.report.document import script_json
from aliascope.report.files import digest, environment, source


@dataclass(frozen=True)
class MapCell:
    """A cell of a table. `index`: of its readings in the data of the scripts; `step`: which of the colours it has, None
    where there is no error; `marks`: words of refused, ours, excused, failed, absent; `label`: all of it, read
    aloud."""

    index: int
    text: str
    lost: str
    step: int | None
    marks: tuple[str, ...]
    label: str


@dataclass(frozen=True)
class MapHead:
    """The head of a column."""

    name: str
    title: str
    axis: str


@dataclass(frozen=True)
class MapTable:
    """A group of extremes; `rows`: of each kind of component, (component, a cell or none for each head)."""

    key: str
    title: str
    heads: tuple[MapHead, ...]
    kinds: tuple[tuple[str, tuple[tuple[str, tuple[MapCell | None, ...]], ...]], ...]


@dataclass(frozen=True)
class Item:
    """A line of a list; `index` is that of its cell, None where it is of none."""

    index: int | None
    name: str
    text: str


@dataclass(frozen=True)
class StabilityPage:
    """All of the page; `legend`: (step, words) of each colour; `data` is what the scripts read."""

    lead: str
    facts: tuple[str, ...]
    tables: tuple[MapTable, ...]
    legend: tuple[tuple[int, str], ...]
    lists: tuple[tuple[str, str, tuple[Item, ...]], ...]
    """(heading, class, lines) of each."""
    notes: tuple[tuple[str, str], ...]
    files: tuple[tuple[str, str], ...]
    data: Mapping[str, Any]


def typeset(text: str) -> Markup:
    """Text with its powers raised: 10^-9."""

    def raised(found: re.Match[str]) -> str:
        return f"{found[1]}<sup>{found[2].replace('-', '−')}</sup>"

    return Markup(re.sub(r"(\d)\^(-?\d+)", raised, str(escape(text))))  # escaped; what is added is ours


def breakable(name: str) -> Markup:
    """A name that may go on in a new line after its hyphens, commas and colons."""
    return Markup(re.sub(r"([-,:])(?=.)", r"\1<wbr>", str(escape(name))))  # escaped; what is added is ours


def stability_page(page: StabilityPage) -> str:
    """The text of the page."""
    style = source("page.css") + source("stability.css")
    body = "\n".join(source(name) for name in ("plain_data.js", "core.js", "stability_plot.js", "stability.js"))
    script = f'(() => {{\n"use strict";\n{body}\n}})();\n'
    values = {**page.data, "colours": {}, "families": []}
    return (
        environment()
        .from_string(source("stability.html"))
        .render(
            page=page,
            typeset=typeset,
            breakable=breakable,
            policy=f"default-src 'none'; script-src '{digest(script)}'; style-src '{digest(style)}'",
            style=Markup(style),  # ours
            script=Markup(script),  # ours
            json=Markup(script_json(values)),  # escaped by script_json
        )
    )
