"""What `aliascope estimate -o` writes: the page, the figures of its plots, the plots as SVG and PNG."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from aliascope import integrands
from aliascope.errors import NotWritable
from aliascope.report.bias import Page, Row, Section, page_html
from aliascope.report.files import write_text
from aliascope.studies.estimate import Asked, Measured, by_integrand, csv_text, label, notes
from aliascope.studies.estimate_plots import draw

SHORT = 5.0
"""Standard errors below what was stated: by chance once in three million."""


def write(folder: Path, asked: Asked, measured: Sequence[Measured]) -> Path:
    """Writes estimate.html, estimate.csv and the plots; returns the path of the page. Raises NotWritable."""
    write_text(folder / "estimate.csv", csv_text(measured))
    sections: list[Section] = []
    for integrand, rows in by_integrand(measured).items():
        name = re.sub(r"[^a-z0-9]+", "-", integrand.lower()).strip("-")
        svg = folder / f"{name}.svg"
        try:
            draw(rows, asked.confidence, (folder / f"{name}.png", svg))
        except OSError as error:
            raise NotWritable(f"{svg}: cannot be written: {error.strerror}") from error
        title = integrands.parse(integrand).title
        exact = f"{rows[0].exact:.6g}"
        table = [_row(one, asked) for one in rows]
        text = svg.read_text(encoding="utf-8")
        sections.append(Section(name, integrand, title[:1].upper() + title[1:], exact, text, table))
    page = Page(
        headlines=headlines(asked, measured),
        sections=sections,
        notes=[f"Red: a bias of more than four standard errors, a share that is {SHORT:g} short.", *notes(measured)],
        dimensions=asked.dimensions,
        repetitions=asked.repetitions,
        confidence=f"{100.0 * asked.confidence:g} %",
        seed=asked.seed,
    )
    return write_text(folder / "estimate.html", page_html(page))


def short(one: Measured, asked: Asked) -> bool:
    """Whether the intervals hold less often than stated, by more than chance."""
    if one.coverage is None:
        return False
    chance = math.sqrt(asked.confidence * (1.0 - asked.confidence) / asked.repetitions)
    return asked.confidence - one.coverage > SHORT * chance


def _row(one: Measured, asked: Asked) -> Row:
    places = _places(one.bias_standard_error)
    row = Row(
        estimator=label(one),
        samples=f"{one.samples:.1f}",
        bias=_signed(one.bias, places),
        bias_error=f"{one.bias_standard_error:.{places}f}",
        biased=one.biased,
        rmse=f"{one.rmse:.3g}",
        ratio="" if one.ratio is None else f"{one.ratio:.2f}",
        coverage="",
        coverage_error="",
        apart="",
        short=short(one, asked),
    )
    if one.coverage is None or one.coverage_standard_error is None:
        return row
    return replace(
        row,
        coverage=f"{100.0 * one.coverage:.1f}",
        coverage_error=f"{100.0 * one.coverage_standard_error:.1f}",
        apart=_signed(100.0 * (one.coverage - asked.confidence), 1),
    )


def _places(error: float) -> int:
    """How many decimal places show two digits of an error, at most 8."""
    return min(max(1 - math.floor(math.log10(error)), 0), 8) if error > 0.0 else 8


def _signed(value: float, places: int) -> str:
    return f"{value:+.{places}f}".replace("-", "\u2212")


def headlines(asked: Asked, measured: Sequence[Measured]) -> list[str]:
    """What came out, in words."""
    found = []
    biased = [one for one in measured if one.biased and one.exact]
    if biased:
        worst = max(biased, key=lambda one: abs(one.bias / one.exact))
        share = _signed(100.0 * worst.bias / worst.exact, 1)
        found.append(
            f"The largest bias is that of {label(worst)} on {worst.integrand}: {share} % of the integral, with "
            f"{worst.samples:.0f} samples a pixel."
        )
    else:
        found.append(f"No bias beyond four standard errors in {asked.repetitions} repetitions.")
    cured = [one for one in measured if "unbiased=1" in one.estimator]
    if cured and not any(one.biased for one in cured):
        found.append("With unbiased=1 (Kirk and Arvo 1991) no bias is left beyond four standard errors.")
    stated = [one for one in measured if one.coverage is not None]
    if stated:
        least = min(stated, key=lambda one: one.coverage or 0.0)
        holds = sum(not short(one, asked) for one in stated)
        found.append(
            f"{holds} of {len(stated)} hold the {100.0 * asked.confidence:g} % they state; least {label(least)} on "
            f"{least.integrand}: {100.0 * (least.coverage or 0.0):.1f} %."
        )
    return found
