"""The verdicts of a regression run, for its page: what failed first, then every cell with its head-room."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args
from urllib.parse import urlencode

from jinja2 import Environment
from markupsafe import Markup

from aliascope.regression.records import CellVerdict, Check, Family, Run
from aliascope.report.files import source

FAMILIES = {
    "effect": "Effects",
    "block": "Blocks",
    "value": "Values",
    "variance": "Variance",
    "accuracy": "Accuracy",
    "cost": "Cost",
    "time": "Time",
}
"""The columns of the table: families of checks, as people call them."""
assert tuple(FAMILIES) == get_args(Family)


@dataclass(frozen=True)
class _Line:
    """A check as it is shown."""

    about: str
    observed: str
    limit: str
    headroom: str
    p_value: float | None
    detail: str
    bad: bool
    warning: bool


@dataclass(frozen=True)
class _Row:
    """A cell as it is shown: its worst check by family, None where there is none; all of them; where to look at it."""

    verdict: CellVerdict
    worst: Sequence[_Line | None]
    lines: Sequence[_Line]
    link: str
    """The fragment that shows it; "" where there is no picture."""
    least: float
    """The least head-room of its checks, infinite where it has none; below all others for what has a problem."""


def verdicts_html(run: Run | None, pages: Environment) -> Markup:
    """The section; nothing without a run."""
    if run is None:
        return Markup("")
    rows = sorted((_row(cell) for cell in run.cells), key=lambda row: (row.verdict.passed, row.least))
    text = pages.from_string(source("verdicts.html")).render(
        run=run,
        rows=rows,
        failed=[row for row in rows if not row.verdict.passed],
        warned=[row for row in rows if row.verdict.passed and any(line.warning for line in row.lines)],
        families=FAMILIES,
    )
    return Markup(text)  # escaped by the environment


def _row(cell: CellVerdict) -> _Row:
    lines = sorted(cell.checks, key=lambda check: (check.passed, check.warning, _room(check)))
    by_family = [[check for check in lines if check.family == family] for family in FAMILIES]
    hard = [check for check in lines if not check.warning]
    return _Row(
        verdict=cell,
        worst=[_line(of[0]) if of else None for of in by_family],
        lines=[_line(check) for check in lines],
        link=_link(cell),
        least=-math.inf if cell.problem else min(map(_room, hard), default=math.inf),
    )


def _room(check: Check) -> float:
    """Head-room to order by: a figure that is none, or beyond a limit of 0, comes first."""
    if check.headroom is None or math.isnan(check.headroom):
        return math.inf if check.passed else -math.inf
    return check.headroom


def _line(check: Check) -> _Line:
    unit = f" {check.unit}" if check.unit else ""
    return _Line(
        about=check.about if check.tests == 1 else f"{check.about}, the worst of {check.tests}",
        observed=f"{_figure(check.observed)}{unit}",
        limit=f"{'at least' if check.at_least else 'at most'} {_figure(check.limit)}{unit}",
        headroom=_percent(check.headroom),
        p_value=None if check.p_value is None or math.isnan(check.p_value) else check.p_value,
        detail=check.detail,
        bad=not check.passed and not check.warning,
        warning=not check.passed and check.warning,
    )


def _percent(headroom: float | None) -> str:
    if headroom is None or not math.isfinite(headroom):
        return "none"
    return f"{100.0 * headroom:.0f} %".replace("-", "\u2212") if headroom > -10.0 else "beyond"


def _figure(value: float) -> str:
    return f"{value:.4g}".replace("-", "\u2212")


def _link(cell: CellVerdict) -> str:
    observed, name = cell.observed, cell.name
    if observed is None or observed.first is None:
        return ""
    place = {"x": observed.worst.x, "y": observed.worst.y} if observed.worst is not None else {}
    view = "p-values-a" if observed.p_values is not None else "errors"
    shown = {"scene": name.scene, "a": f"{name.renderer} {name.mode}", "b": "reference", "view": view}
    return "#" + urlencode({**shown, **place})
