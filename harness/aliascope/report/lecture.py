"""The page of `aliascope integrate --lecture`: plots, and the views of sampling as a table. It loads nothing."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from aliascope.report.files import environment, source
from aliascope.report.inline_svg import inline


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
    pages = environment()
    pages.filters["formula"] = formula
    # The plots' own style attributes are many and differ, so styles are allowed; scripts and loads are not.
    return pages.from_string(source("lecture.html")).render(
        page=page,
        plots={figure.name: Markup(inline(figure.svg, figure.name)) for figure in page.figures},
        style=Markup(style),
        policy="default-src 'none'; style-src 'unsafe-inline'",
    )


def formula(text: str) -> Markup:
    """Text with its powers and indices set as such, and signs for "<=", "~" and the minus of a number."""
    safe = str(escape(text))
    safe = re.sub(r"\^\(?(-?[\d./d]*[\dd])\)?", r"<sup>\1</sup>", safe)
    safe = safe.replace("D_N", "D<sub>N</sub>").replace("&lt;=", "≤").replace("~ N", "∼ N")
    return Markup(re.sub(r"(?<![\w-])-(?=[\d.])", "\u2212", safe))
