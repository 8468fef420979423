"""The page of `aliascope integrate --lecture`: plots, and the views of sampling as a table. It loads nothing."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup, escape

from aliascope.report.files import source

THEMED: Mapping[str, str] = {
    "#16181b": "var(--ink)",
    "#5a6067": "var(--soft)",
    "#d9d9d3": "var(--rule)",
    "#ffffff": "var(--paper)",
}
"""The colours of a plot that change with the page's theme."""


@dataclass(frozen=True)
class Figure:
    """A plot: the stem of its files, the page of the lecture, what was measured."""

    name: str
    title: str
    text: str
    svg: str


@dataclass(frozen=True)
class Cell:
    """A measured rate and its interval, or the reason why there is none; what theory has."""

    rate: str | None
    interval: str
    reason: str
    theory: str


@dataclass(frozen=True)
class Row:
    """A sampler with a cell for every integrand."""

    sampler: str
    cells: Sequence[Cell]


@dataclass(frozen=True)
class Page:
    """All of the page. views: (title, text, rows); columns: (title, integrand)."""

    figures: Sequence[Figure]
    views: Sequence[tuple[str, str, Sequence[Row]]]
    columns: Sequence[tuple[str, str]]
    realisations: int
    seed: int


def page_html(page: Page) -> str:
    """The text of the page."""
    style = source("page.css") + source("lecture.css")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["formula"] = formula
    # The plots' own style attributes are many and differ, so styles are allowed; scripts and loads are not.
    return environment.from_string(source("lecture.html")).render(
        page=page,
        plots={figure.name: Markup(themed(figure.svg, figure.name)) for figure in page.figures},
        style=Markup(style),
        policy="default-src 'none'; style-src 'unsafe-inline'",
    )


def formula(text: str) -> Markup:
    """Text with its powers and indices set as such, and signs for "<=", "~" and the minus of a number."""
    safe = str(escape(text))
    safe = re.sub(r"\^\(?(-?[\d./d]*[\dd])\)?", r"<sup>\1</sup>", safe)
    safe = safe.replace("D_N", "D<sub>N</sub>").replace("&lt;=", "≤").replace("~ N", "∼ N")
    return Markup(re.sub(r"(?<![\w-])-(?=[\d.])", "\u2212", safe))


def themed(svg: str, name: str) -> str:
    """A plot as part of a page: its own element alone, colours of the theme, ids that no other plot has."""
    body = svg[svg.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    body = re.sub(r'\b(id="|xlink:href="#|url\(#)', rf"\g<1>{name}-", body)
    for colour, variable in THEMED.items():
        body = body.replace(colour, variable)
    return re.sub(r'<svg [^>]*?(viewBox="[^"]*")[^>]*>', _opening(name), body, count=1)


def _opening(name: str) -> str:
    return rf'<svg xmlns:xlink="http://www.w3.org/1999/xlink" \1 role="img" aria-labelledby="{name}-title">'
