"""What `aliascope knobs` says: the one table for a terminal, its document, its CSV, the same as Markdown."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from aliascope.studies import compare as comparing
from aliascope.studies.knobs import Turned
from aliascope.trade.records import Interval, Knob

HEADINGS = ("renderer", "form", "knob", "setting", "against", "time ratio", "error ratio", "pairs, scenes")
NOTE = (
    "Time and error of a setting over those of the one that it is against, all other keys the same: geometric means "
    "over scenes, with intervals of 95 %. Of measures the error is the width of their bounds, relative to the exact "
    "value, over point sets."
)


def cells(knob: Knob) -> tuple[str, ...]:
    """A row of the table."""
    where = f"{knob.pairs}, {len(knob.scenes)}"
    return (
        *(knob.renderer, knob.form, knob.knob, knob.setting, knob.baseline),
        *(interval(knob.time), interval(knob.error), where),
    )


def interval(found: Interval) -> str:
    if found.low is None or found.high is None:
        return f"{found.value:.3g}"
    return f"{found.value:.3g} [{found.low:.3g}, {found.high:.3g}]"


def table(knobs: Sequence[Knob]) -> list[str]:
    """Aligned columns; what stands above already is left out."""
    rows = [HEADINGS, *(cells(knob) for knob in knobs)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEADINGS))]
    lines, above = [], ("",) * len(HEADINGS)
    for row in rows:
        same = next((i for i in range(3) if row[i] != above[i]), 3)
        shown = (*("" for _ in range(same)), *row[same:])
        lines.append("  ".join(cell.ljust(width) for cell, width in zip(shown, widths, strict=True)).rstrip())
        above = row
    return lines


def markdown(knobs: Sequence[Knob]) -> list[str]:
    """The same for a README."""
    rule = ("---",) * len(HEADINGS)
    return [f"| {' | '.join(row)} |" for row in (HEADINGS, rule, *(cells(knob) for knob in knobs))]


def lines(turned: Turned) -> list[str]:
    headlines = turned.comparison.data.headlines
    told = [line for line in comparing.summary_lines(turned.comparison, turned.plan) if line not in headlines]
    return [*table(turned.knobs), NOTE, *told]


def document(turned: Turned) -> dict[str, Any]:
    summary = comparing.summary(turned.comparison, turned.plan)
    return {
        **{key: value for key, value in summary.items() if key not in ("headlines", "trade")},
        "knobs": [asdict(knob) for knob in turned.knobs],
    }


def knobs_csv(knobs: Sequence[Knob]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    ratios = [f"{what}{end}" for what in ("time", "error") for end in ("", "_low", "_high")]
    writer.writerow(["kind", "renderer", "form", "knob", "setting", "baseline", *ratios, "pairs", "scenes"])
    for knob in knobs:
        figures = [figure for found in (knob.time, knob.error) for figure in (found.value, found.low, found.high)]
        row = [knob.kind, knob.renderer, knob.form, knob.knob, knob.setting, knob.baseline]
        writer.writerow([*row, *figures, knob.pairs, " ".join(name.replace(" ", "-") for name in knob.scenes)])
    return out.getvalue()
