"""The page of `aliascope estimate`: bias and coverage of estimators, as plots and tables. It loads nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from aliascope.report.files import source
from aliascope.report.inline_svg import inline


@dataclass(frozen=True)
class Row:
    """One estimator, its figures as text. biased, short: the bias, the coverage are off by more than chance."""

    estimator: str
    samples: str
    bias: str
    bias_error: str
    biased: bool
    rmse: str
    ratio: str
    coverage: str
    coverage_error: str
    apart: str
    short: bool


@dataclass(frozen=True)
class Section:
    """One integrand; `name` is that of its files."""

    name: str
    integrand: str
    title: str
    exact: str
    svg: str
    rows: Sequence[Row]


@dataclass(frozen=True)
class Page:
    """All of the page; `headlines` are what came out, in words."""

    headlines: Sequence[str]
    sections: Sequence[Section]
    notes: Sequence[str]
    dimensions: int
    repetitions: int
    confidence: str
    seed: int


def page_html(page: Page) -> str:
    """The text of the page."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    # The plots' own style attributes are many and differ, so styles are allowed; scripts and loads are not.
    return environment.from_string(source("bias.html")).render(
        page=page,
        plots={section.name: Markup(inline(section.svg, section.name)) for section in page.sections},
        style=Markup(source("page.css") + source("bias.css")),
        policy="default-src 'none'; style-src 'unsafe-inline'",
    )
