"""The lecture's table "Discrepancy of random edges", measured again: five processes at 16, 256 and 1,600 points.

Each cell is the root, over realisations and random edges, of the mean square of n(A)/N - area, A what lies on one side
of the edge; isotropic edges, and over those exact (`edge-rms`). The published figures are of Mitchell 1992, "Ray
tracing and irregularities of distribution", Third Eurographics Workshop on Rendering, as the lecture prints them.

`half_count` adds the variance 1/(4 N^2), that of a count which is off by half a point. It is a fit after the fact: its
cause is not known, and it is no part of the definition.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from aliascope import statistics
from aliascope.errors import InvalidInput
from aliascope.native import discrepancy
from aliascope.records import Estimate
from aliascope.studies import realisations
from aliascope.studies.realisations import Asked, Found, Tell

COUNTS = (16, 256, 1600)
MEASURE = "edge-rms"
SHARE = 0.007
"""The standard error below which a cell is done, of its figure."""
COLUMN_SHARE = 0.03
"""The same of a chosen column; a half-plane discrepancy of 1,600 points takes twenty times an edge-rms."""
CONSTANT = math.sqrt((2.0 + math.sqrt(2.0) + 5.0 * math.asinh(1.0)) / 60.0)
"""0.361042: N independent points have the root mean square CONSTANT N^-1/2, a quarter of the mean distance of two
points of the unit square being under the root. In a cell of k x k it is 1/k of that, so jittered points have CONSTANT
N^-3/4."""


NO_FIGURE = Estimate(None)


@dataclass(frozen=True)
class Process:
    """A row of the table. `generator`: the sampler that makes it; `exponent`: of its closed form, if it has one."""

    name: str
    generator: str
    published: tuple[float, float, float]
    exponent: float | None = None


PROCESSES = (
    Process("zaremba", "zaremba", (0.0504, 0.00478, 0.00111)),
    Process("jittered", "jittered", (0.0538, 0.00595, 0.00146), -0.75),
    Process("poisson-disk", "poisson-disk:radius=0.8", (0.0613, 0.00767, 0.00241)),
    Process("n-rooks", "n-rooks:corner=1", (0.0637, 0.0123, 0.00488)),
    Process("random", "random", (0.0924, 0.0224, 0.00866), -0.5),
)


@dataclass(frozen=True)
class Options:
    """What is asked of a table. `realisations`: None for as many as it takes; `columns`: further measures."""

    realisations: int | None = None
    half_count: bool = False
    columns: tuple[str, ...] = ()
    seed: int = 0
    threads: int = 1


@dataclass(frozen=True)
class Column:
    """A further measure of a cell: its mean over realisations."""

    measure: str
    estimate: Estimate
    realisations: int


@dataclass(frozen=True)
class Cell:
    """One process at n points. `asked`: the count that was asked for, where n is the nearest that there is.

    A cell that cannot be had has the `reason`, and no figures.
    """

    process: str
    generator: str
    asked: int
    n: int | None = None
    plain: Estimate = NO_FIGURE
    realisations: int = 0
    published: float | None = None
    closed_form: float | None = None
    columns: Mapping[str, Column] = field(default_factory=dict)
    reason: str = ""
    points: tuple[tuple[float, float], ...] = ()
    """Those of a set that no sampler has."""

    def shown(self, half_count: bool) -> Estimate:
        """The figure of the cell, with the half count or without."""
        return with_half_count(self.plain, self.n) if half_count and self.n else self.plain

    def ratio(self, half_count: bool) -> float | None:
        """To the published figure."""
        value = self.shown(half_count).value
        return value / self.published if self.published and value is not None else None


@dataclass(frozen=True)
class Slope:
    """The exponent of N that fits a process's figures, beside that of the published ones and of the closed form."""

    process: str
    fitted: Estimate
    published: float | None
    closed_form: float | None


@dataclass(frozen=True)
class Table:
    """A table of cells, in the order of their rows. `name`: lecture, samplers or hardware."""

    name: str
    options: Options
    cells: tuple[Cell, ...]
    slopes: tuple[Slope, ...] = ()

    @property
    def processes(self) -> list[str]:
        """The rows."""
        return list(dict.fromkeys(cell.process for cell in self.cells))

    @property
    def counts(self) -> list[int]:
        """The columns, by the counts that were asked for."""
        return sorted({cell.asked for cell in self.cells})

    def row(self, process: str) -> list[Cell]:
        """The cells of a process, by rising count."""
        return sorted((cell for cell in self.cells if cell.process == process), key=lambda cell: cell.asked)


def with_half_count(plain: Estimate, n: int) -> Estimate:
    """The figure with the variance 1/(4 n^2) added; its standard error by the delta method."""
    if plain.value is None:
        return plain
    value = math.hypot(plain.value, 0.5 / n)
    error = plain.standard_error
    return Estimate(value, None if error is None else error * plain.value / value)


def closed_form(process: Process, n: int) -> float | None:
    """The expectation of the square, rooted, where it is known."""
    return None if process.exponent is None else CONSTANT * n**process.exponent


def columns_of(texts: Sequence[str]) -> tuple[str, ...]:
    """The measures of `--column M,M...`, in canonical form. Raises SpecError; InvalidInput for the table's own."""
    from aliascope.studies.discrepancy import asked

    found = tuple(asked(texts))
    if MEASURE in found:
        raise InvalidInput(f"--column {MEASURE}: that is what the table shows; others are star, half-plane, edge-mean")
    two = {info.name for info in discrepancy.registered() if info.least_dimensions <= 2 <= info.most_dimensions}
    for spec in found:
        if spec.split(":")[0] not in two:
            raise InvalidInput(f"--column {spec}: is no measure of two dimensions")
    return found


def measured(cells: Sequence[Cell], share: float, options: Options, tell: Tell | None = None) -> list[Cell]:
    """The cells with their figures, until a standard error is below its share; those with a reason stay without."""
    specs = {MEASURE: share, **dict.fromkeys(options.columns, COLUMN_SHARE)}
    asked = [
        Asked(cell.generator, cell.n, spec, spec == MEASURE, limit, options.realisations)
        for cell in cells
        if cell.n is not None
        for spec, limit in specs.items()
    ]
    found = iter(realisations.measure_all(asked, options.seed, options.threads, tell))
    return [cell if cell.n is None else _with_figures(cell, [next(found) for _ in specs], options) for cell in cells]


def _with_figures(cell: Cell, found: Sequence[Found], options: Options) -> Cell:
    """`found`: of the table's measure, then of the columns."""
    plain, *others = found
    columns = {
        spec: Column(spec, other.estimate, len(other.values))
        for spec, other in zip(options.columns, others, strict=True)
    }
    return replace(cell, plain=plain.estimate, realisations=len(plain.values), columns=columns)


def lecture_table(options: Options, tell: Tell | None = None) -> Table:
    """The fifteen cells of the lecture's table, and the slopes of its rows."""
    cells = [
        Cell(process.name, process.generator, n, n, published=published, closed_form=closed_form(process, n))
        for process in PROCESSES
        for n, published in zip(COUNTS, process.published, strict=True)
    ]
    cells = measured(cells, SHARE, options, tell)
    slopes = []
    for process in PROCESSES:
        own = [cell for cell in cells if cell.process == process.name]
        shown = [cell.shown(options.half_count) for cell in own]
        published = slope(COUNTS, [Estimate(value) for value in process.published]).value
        slopes.append(Slope(process.name, slope(COUNTS, shown), published, process.exponent))
    return Table("lecture", options, tuple(cells), tuple(slopes))


def slope(counts: Sequence[int], estimates: Sequence[Estimate]) -> Estimate:
    """The exponent of the power law through (n, value), and what the values' standard errors leave open of it.

    Least squares of the logarithms: the exponent is sum w_i log v_i with w_i = (x_i - m) / sum (x - m)^2, x = log n, so
    its variance is sum (w_i s_i / v_i)^2, s_i the standard error of v_i. Those of different counts are taken as
    independent: the same seed shares points between them, of 16 points with 256 a sixteenth.
    """
    values = [estimate.value or 0.0 for estimate in estimates]
    fit = statistics.rate(counts, values)
    if fit is None:
        return Estimate(None)
    errors = [estimate.standard_error for estimate in estimates]
    logs = [math.log(n) for n in counts]
    centre = sum(logs) / len(logs)
    spread = sum((x - centre) ** 2 for x in logs)
    total = 0.0
    for x, value, error in zip(logs, values, errors, strict=True):
        if error is None:
            return Estimate(fit.exponent)
        total += ((x - centre) / spread * error / value) ** 2
    return Estimate(fit.exponent, math.sqrt(total))


def document(table: Table) -> dict[str, Any]:
    """What --json prints."""
    options = table.options
    found: dict[str, Any] = {
        "table": table.name,
        "half_count": options.half_count,
        "seed": options.seed,
        "measure": MEASURE,
        "cells": [_cell_document(cell, options.half_count) for cell in table.cells],
    }
    if table.slopes:
        found["slopes"] = [
            {
                "process": each.process,
                "slope": each.fitted.value,
                "standard_error": each.fitted.standard_error,
                "published": each.published,
                "closed_form": each.closed_form,
            }
            for each in table.slopes
        ]
    return found


def _cell_document(cell: Cell, half_count: bool) -> dict[str, Any]:
    shown = cell.shown(half_count)
    found: dict[str, Any] = {
        "process": cell.process,
        "generator": cell.generator,
        "n": cell.n,
        "mean": shown.value,
        "standard_error": shown.standard_error,
        "published": cell.published,
        "ratio": cell.ratio(half_count),
        "closed_form": cell.closed_form,
        "realisations": cell.realisations,
        "plain": _figures(cell, False),
        "with_half_count": _figures(cell, True),
    }
    if cell.n != cell.asked:
        found["asked"] = cell.asked
    if cell.columns:
        found["columns"] = {
            spec: {
                "mean": column.estimate.value,
                "standard_error": column.estimate.standard_error,
                "realisations": column.realisations,
            }
            for spec, column in cell.columns.items()
        }
    if cell.points:
        found["points"] = [list(point) for point in cell.points]
    if cell.reason:
        found["reason"] = cell.reason
    return found


def _figures(cell: Cell, half_count: bool) -> dict[str, float | None]:
    shown = cell.shown(half_count)
    return {"mean": shown.value, "standard_error": shown.standard_error, "ratio": cell.ratio(half_count)}
