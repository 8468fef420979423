"""A page of tables and figures that needs nothing but itself, and no scripts: for a screen in a lecture, or a phone.

What it shows comes as sections; `teaching.html` is the skeleton. Figures are SVG in the colours of the page, so that
they follow it from light to dark.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from aliascope.report.files import digest, environment, source


@dataclass(frozen=True)
class Value:
    """A cell of a table. `spread`: what stands behind the figure, smaller; `reason`: why there is none."""

    text: str
    spread: str = ""
    reason: str = ""
    strong: bool = False


@dataclass(frozen=True)
class PageTable:
    """A table: `groups` are heads over several columns, (text, how many), the first column not among them."""

    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Value, ...]], ...]
    groups: tuple[tuple[str, int], ...] = ()

    @property
    def begins(self) -> set[int]:
        """The columns, from 0, at which a group begins."""
        found, at = set(), 0
        for _, count in self.groups:
            found.add(at)
            at += count
        return found


@dataclass(frozen=True)
class Panel:
    """A figure, its markup trusted: it is made here. `title` and `note` are text."""

    markup: str
    title: str = ""
    note: str = ""


@dataclass(frozen=True)
class Section:
    """A part of the page. `definitions`: (term, text); `columns`: how many panels side by side, where there is room."""

    key: str
    heading: str
    paragraphs: tuple[str, ...] = ()
    tables: tuple[PageTable, ...] = ()
    panels: tuple[Panel, ...] = ()
    columns: int = 1
    definitions: tuple[tuple[str, str], ...] = ()
    files: tuple[tuple[str, tuple[tuple[str, str], ...]], ...] = ()
    """(what they are, ((text, address beside the page), ...))."""


@dataclass(frozen=True)
class TeachingPage:
    """All of a page."""

    title: str
    lead: str
    facts: tuple[str, ...]
    sections: tuple[Section, ...]


def teaching_page(page: TeachingPage) -> str:
    """The text of the page."""
    style = source("page.css") + source("teaching.css")
    return (
        environment()
        .from_string(source("teaching.html"))
        .render(
            page=page,
            policy=f"default-src 'none'; img-src data:; style-src '{digest(style)}'",
            style=Markup(style),  # ours
            markup=Markup,
        )
    )


def attributes(values: dict[str, object]) -> str:
    """Of an SVG element."""
    return "".join(f' {name.replace("_", "-")}="{Markup.escape(value)}"' for name, value in values.items())


def spread_out(places: Sequence[float], distance: float, low: float, high: float) -> list[float]:
    """Places moved apart to at least a distance, each as little as this takes, in their order and within [low, high].

    Least squares under an order is the pooling of neighbours (Barlow et al. 1972, "Statistical inference under order
    restrictions"), here of the places less their rank's share.
    """
    order = sorted(range(len(places)), key=lambda i: places[i])
    pools: list[list[float]] = []
    for rank, i in enumerate(order):
        pools.append([places[i] - rank * distance, 1.0])
        while len(pools) > 1 and pools[-2][0] >= pools[-1][0]:
            value, weight = pools.pop()
            pools[-1] = [
                (pools[-1][0] * pools[-1][1] + value * weight) / (pools[-1][1] + weight),
                pools[-1][1] + weight,
            ]
    moved = [value for value, weight in pools for _ in range(int(weight))]
    most = high - (len(places) - 1) * distance
    found = [0.0] * len(places)
    for rank, i in enumerate(order):
        found[i] = min(max(moved[rank], low), max(most, low)) + rank * distance
    return found
