"""What `aliascope mitchell -o DIR` writes: figures as CSV and JSON, drawings as SVG, and a page that shows them."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from aliascope.report.files import write_text
from aliascope.report.teaching import teaching_page
from aliascope.studies import mitchell_page
from aliascope.studies.mitchell import COUNTS, Table
from aliascope.studies.mitchell_search import Combination
from aliascope.studies.mitchell_series import plotted, series_of

NAMES = {"lecture": "mitchell", "samplers": "samplers", "hardware": "hardware"}
TITLES = {"lecture": "Discrepancy of random edges", "samplers": "Every sampler at random edges"}


def write_table(folder: Path, table: Table, document: dict[str, Any]) -> list[Path]:
    """The page NAME.html, NAME.csv, NAME.json; plots/ and points/ where the table has them. Raises NotWritable."""
    name = NAMES[table.name]
    written = [
        write_text(folder / f"{name}.csv", table_csv(table)),
        write_text(folder / f"{name}.json", json.dumps(document, allow_nan=False, indent=1) + "\n"),
    ]
    pictures: mitchell_page.Pictures | None = None
    if table.name != "hardware":
        written += _write_plot(folder, name, table)
    if table.name == "lecture":
        pictures = mitchell_page.pictures_of(table)
        written += _write_pictures(folder, pictures)
    page = mitchell_page.page_of(table, name, pictures)
    return [write_text(folder / f"{name}.html", teaching_page(page)), *written]


def _write_plot(folder: Path, name: str, table: Table) -> list[Path]:
    from aliascope.report.teaching_plots import convergence_svg

    series = series_of(table)
    rows = [["process", "points", "measured", "published", "closed_form"]]
    for one in series:
        published = dict(one.published)
        for n, value in one.measured:
            closed = one.closed[0] * n ** one.closed[1] if one.closed else ""
            rows.append([one.name, f"{n:g}", repr(value), str(published.get(n, "")), str(closed)])
    drawn, label = plotted(table)
    svg = convergence_svg(drawn, TITLES[table.name], label, table.counts)
    return [write_text(folder / "plots" / f"{name}.svg", svg), write_text(folder / "plots" / f"{name}.csv", _csv(rows))]


def _write_pictures(folder: Path, pictures: mitchell_page.Pictures) -> list[Path]:
    from aliascope.report.teaching_plots import sets_svg, spectra_svg

    written = []
    for process, sets in pictures.sets.items():
        for points in sets:
            rows = [[f"{x:.17g}", f"{y:.17g}"] for x, y in points]
            written.append(write_text(folder / "points" / f"{process}-{len(points)}.csv", _csv(rows)))
    written.append(write_text(folder / "plots" / "points.svg", sets_svg(pictures.sets)))
    for n in pictures.spectra:
        found = pictures.spectra[n]
        planes = {
            name: (each.power, each.frequencies.astype(np.float64), each.radial_power) for name, each in found.items()
        }
        written.append(write_text(folder / "plots" / f"spectra-{n}.svg", spectra_svg(planes, n)))
        first = next(iter(found.values()))
        head = ["cycles_over_the_side", *found]
        columns = [first.frequencies.tolist(), *(each.radial_power.tolist() for each in found.values())]
        written.append(write_text(folder / "plots" / f"spectra-{n}.csv", _csv([head, *zip(*columns, strict=True)])))
    return written


def table_csv(table: Table) -> str:
    """A row a cell, every figure; empty where there is none."""
    specs = list(dict.fromkeys(spec for cell in table.cells for spec in cell.columns))
    head = ["process", "generator", "asked", "points", "mean", "standard_error", "published", "ratio", "closed_form"]
    head += ["realisations", "plain", "plain_standard_error", "with_half_count", "with_half_count_standard_error"]
    rows: list[Sequence[Any]] = [[*head, *(x for spec in specs for x in (spec, f"{spec} standard_error")), "reason"]]
    half = table.options.half_count
    for cell in table.cells:
        shown, plain, other = cell.shown(half), cell.plain, cell.shown(True)
        row: list[Any] = [cell.process, cell.generator, cell.asked, cell.n, shown.value, shown.standard_error]
        row += [cell.published, cell.ratio(half), cell.closed_form, cell.realisations]
        row += [plain.value, plain.standard_error, other.value, other.standard_error]
        for spec in specs:
            column = cell.columns.get(spec)
            row += [column.estimate.value, column.estimate.standard_error] if column else [None, None]
        rows.append([*row, cell.reason])
    return _csv(rows)


def write_search(folder: Path, combinations: Sequence[Combination], document: dict[str, Any]) -> list[Path]:
    """search.json, and search.csv with a row for every generator of every combination and count."""
    head = ["edges", "statistic", "half_count", "misfit", "process", "generator", "best", "points"]
    rows: list[Sequence[Any]] = [[*head, "mean", "standard_error", "ratio"]]
    for each in combinations:
        for fit in each.fits:
            for n, figure, ratio in zip(COUNTS, fit.figures, fit.ratios, strict=True):
                first = [each.edges, each.statistic, int(each.half_count), each.misfit, fit.process, fit.generator]
                rows.append([*first, int(fit in each.best), n, figure.value, figure.standard_error, ratio])
    return [
        write_text(folder / "search.csv", _csv(rows)),
        write_text(folder / "search.json", json.dumps(document, allow_nan=False, indent=1) + "\n"),
    ]


def _csv(rows: Iterable[Sequence[Any]]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()
