"""`aliascope mitchell --table samplers`: the lecture's table for every registered sampler, plugins too."""

from __future__ import annotations

import numpy as np

from aliascope.errors import AliascopeError
from aliascope.native import samplers
from aliascope.studies.mitchell import COUNTS, Cell, Options, Slope, Table, measured, slope
from aliascope.studies.realisations import Tell

SHARE = 0.03
"""The standard error below which a cell is done, of its figure: some patterns take a tenth of a second to make."""


def samplers_table(options: Options, tell: Tell | None = None) -> Table:
    """Every sampler as it is by default and, where it can be, Owen-scrambled, by rising figure at 256 points.

    Each has the count nearest to 16, 256 and 1,600 that it can have, within a factor of two; else a reason.
    """
    cells = measured([_cell(spec, n) for spec in _specs() for n in COUNTS], SHARE, options, tell)
    by_spec = {spec: [cell for cell in cells if cell.process == spec] for spec in _specs()}
    ordered = sorted(by_spec, key=lambda spec: [_rank(by_spec[spec][i]) for i in (1, 0, 2)])
    slopes = tuple(_slope(spec, by_spec[spec], options.half_count) for spec in ordered)
    return Table("samplers", options, tuple(cell for spec in ordered for cell in by_spec[spec]), slopes)


def _specs() -> list[str]:
    found = []
    for info in samplers.registered():
        found.append(info.name)
        scrambles = [text for text in info.parameters if text.startswith("scramble=")]
        if scrambles and "owen" in scrambles[0]:
            found.append(f"{info.name}:scramble=owen")
    return found


def _cell(spec: str, asked: int) -> Cell:
    n, reason = nearest_count(spec, asked)
    return Cell(spec, spec, asked, n, reason=reason)


def nearest_count(spec: str, asked: int) -> tuple[int | None, str]:
    """The count nearest to the one asked for, by ratio and within a factor of two, that has points of equal weight.

    None where there is none, and the reason: that of the count which was asked for.
    """
    reason = _refusal(spec, asked)
    if not reason:
        return asked, ""
    ranked = sorted(range((asked + 1) // 2, 2 * asked + 1), key=lambda n: (max(n / asked, asked / n), n))
    n = next((n for n in ranked if not _refusal(spec, n)), None)
    return n, "" if n else reason


def _refusal(spec: str, n: int) -> str:
    try:
        reason = samplers.refusal(spec, n)
        if reason is None and np.ptp(samplers.weights(spec, n)) > 1e-9 / n:  # equal weights are 1/n each, rounded
            reason = (
                f"{spec} is a rule of quadrature: its points differ in weight, so counting them measures another rule"
            )
    except AliascopeError as error:  # of a plugin that needs a parameter, or has no weights
        reason = str(error)
    return reason or ""


def _rank(cell: Cell) -> float:
    return cell.plain.value if cell.plain.value is not None else float("inf")


def _slope(spec: str, cells: list[Cell], half_count: bool) -> Slope:
    there = [cell for cell in cells if cell.n is not None and not cell.reason]
    shown = [cell.shown(half_count) for cell in there]
    return Slope(spec, slope([cell.n or 0 for cell in there], shown), None, None)
