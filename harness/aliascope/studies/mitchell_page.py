"""The page of a table of `aliascope mitchell`: what a lecture would show of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aliascope import places, point_sets
from aliascope.native import samplers
from aliascope.point_sets import PointSpectrum
from aliascope.records import Estimate
from aliascope.report import charts
from aliascope.report.teaching import PageTable, Panel, Section, TeachingPage, Value
from aliascope.studies import mitchell_text
from aliascope.studies.mitchell import CONSTANT, COUNTS, MEASURE, PROCESSES, SHARE, Cell, Table
from aliascope.studies.mitchell_series import plotted
from aliascope.studies.mitchell_text import figure, plain, shown_measure, spread

Array = NDArray[np.float64]
SPECTRUM_COUNTS = (256, 1600)
SPECTRUM_REALISATIONS = 10
EDGE = (0.61, 0.66)
"""Angle and offset of the edge that the page draws: one that cuts no corner."""


@dataclass(frozen=True)
class Pictures:
    """The sets of the first realisation by process, by rising count, and mean spectra by count and process."""

    sets: Mapping[str, list[Array]]
    spectra: Mapping[int, Mapping[str, PointSpectrum]]


def pictures_of(table: Table) -> Pictures:
    """Those of the lecture's processes."""
    seed = table.options.seed
    sets = {each.name: [samplers.points(each.generator, n, 2, seed) for n in COUNTS] for each in PROCESSES}
    spectra = {n: {each.name: _spectrum(each.generator, n, seed) for each in PROCESSES} for n in SPECTRUM_COUNTS}
    return Pictures(sets, spectra)


def _spectrum(generator: str, n: int, seed: int) -> PointSpectrum:
    count = SPECTRUM_REALISATIONS if samplers.randomised(generator, n) else 1
    sets = [samplers.points(generator, n, 2, (seed + i) % 2**64) for i in range(count)]
    return point_sets.point_spectrum(sets, round(2.5 * math.sqrt(n)))


def page_of(table: Table, name: str, pictures: Pictures | None) -> TeachingPage:
    """The page NAME.html; pictures are the lecture's table's."""
    if table.name == "lecture" and pictures:
        return _lecture_page(table, name, pictures)
    return _samplers_page(table, name) if table.name == "samplers" else _hardware_page(table, name)


def _facts(table: Table) -> tuple[str, ...]:
    return f"version {places.own_version()}", f"seed {table.options.seed}"


def _notes(table: Table) -> Section:
    return Section("notes", "What this shows", definitions=tuple(mitchell_text.notes(table)))


# --- the lecture's table ----------------------------------------------------------------------------------------------


def _lecture_page(table: Table, name: str, pictures: Pictures) -> TeachingPage:
    half = table.options.half_count
    shown = ("half", "With half a count added") if half else ("table", "The table")
    other = ("table", "As it is defined") if half else ("half", "With half a count added")
    return TeachingPage(
        title="Discrepancy of random edges",
        lead=(
            "An edge crosses a pixel. The share of the samples on one side of it is what the renderer takes for the "
            "share of the area there. How far the two are apart, as a root mean square over random edges, is the "
            "pattern's edge discrepancy: the error of an antialiased black and white edge."
        ),
        facts=_facts(table),
        sections=(
            Section(*shown, (_measured_text(half),), (_lecture_table(table, half),)),
            Section(
                "convergence",
                "How fast it falls",
                ("Filled: measured. Rings: published in 1992. Dotted: closed forms of random and jittered points.",),
                (_slopes_table(table),),
                (_convergence(table),),
            ),
            Section("edge", "What one edge does", (_EDGE_TEXT,), panels=_edge_panels(pictures), columns=5),
            Section("sets", "The point sets", ("One realisation of each.",), panels=_set_panels(pictures), columns=5),
            Section("spectra", "Their spectra", (_spectra_text(),), panels=_spectrum_panels(pictures), columns=5),
            Section(*other, (_measured_text(not half),), (_lecture_table(table, not half),)),
            _notes(table),
            *_columns(table),
            Section("files", "Files beside this page", files=_lecture_files(name, pictures)),
        ),
    )


def _measured_text(half: bool) -> str:
    if half:
        return (
            "The same with the variance 1/(4 N²) added to each mean square, what a count that is off by half a point "
            "would add. It brings the figures to the published ones; why is not known, and it is no part of the "
            "definition."
        )
    return (
        "The root of the mean square over isotropic edges, which has a closed form for a set of points, and over "
        f"realisations: as many as bring the standard error (±) below {SHARE:.1%}, where their number was not chosen. "
        "Zaremba's set is not random, so its figures are exact."
    )


def _convergence(table: Table) -> Panel:
    series, label = plotted(table)
    return Panel(charts.convergence_chart(series, label, table.counts))


def _lecture_table(table: Table, half: bool) -> PageTable:
    rows = []
    for process in table.processes:
        values = []
        for cell in table.row(process):
            shown = cell.shown(half)
            values += [_value(shown), _plain(cell.published), _plain(cell.ratio(half), ".3f", True)]
        rows.append((process, tuple(values)))
    return PageTable(
        "Discrepancy of random edges, half a count added" if half else "Discrepancy of random edges",
        ("process", *("measured", "1992", "ratio") * len(table.counts)),
        tuple(rows),
        tuple((f"{n:,} points", 3) for n in table.counts),
    )


def _plain(value: float | None, form: str = ".3g", strong: bool = False) -> Value:
    return Value("–" if value is None else plain(value, form), strong=strong)


def _value(estimate: Estimate) -> Value:
    text = spread(estimate)
    return Value(figure(estimate), "" if text in ("", "unknown") else "exact" if text == "exact" else f"± {text}")


def _slopes_table(table: Table) -> PageTable:
    rows = []
    for each in table.slopes:
        others = (_plain(each.published, ".3f"), _plain(each.closed_form, ".2f"))
        rows.append((each.process, (_slope(each.fitted), *others)))
    caption = f"The exponent of N, fitted to each row; the closed forms are {CONSTANT:.6f} times N to theirs"
    return PageTable(caption, ("process", "measured", "1992", "closed form"), tuple(rows))


def _slope(fitted: Estimate) -> Value:
    text = spread(fitted)
    if fitted.value is None:
        return _plain(None)
    return Value(plain(fitted.value, ".3f"), f"± {text}" if text not in ("", "unknown", "exact") else text)


_EDGE_TEXT = (
    "The same edge across the 16 points of each, as a renderer would have it that takes the share of the samples for "
    "the coverage of the pixel. One edge tells little: the table has them all."
)


def _edge_panels(pictures: Pictures) -> tuple[Panel, ...]:
    found = []
    for name, sets in pictures.sets.items():
        markup, inside, area = charts.edge_picture(sets[0], *EDGE)
        share = inside / 16
        note = f"{inside} of 16 samples, {share:.3f}; area {area:.3f}; off by {share - area:+.3f}"
        found.append(Panel(markup, name, note))
    return tuple(found)


def _set_panels(pictures: Pictures) -> tuple[Panel, ...]:
    return tuple(
        Panel(charts.set_picture(sets[i], name), f"{name}, {n:,}")
        for i, n in enumerate(COUNTS)
        for name, sets in pictures.sets.items()
    )


def _spectra_text() -> str:
    return (
        f"The power at every frequency, mean of {SPECTRUM_REALISATIONS} realisations, frequency 0 in the middle, black "
        "none, white twice that of independent points; and its mean over directions. Jittered and Poisson-disk sets "
        "have little power at low frequencies and noise beyond: blue noise. N-rooks sets are even along the axes "
        "alone, the dark cross. Zaremba's, which has the least discrepancy, has its power in single frequencies, where "
        "it can beat with a picture's own."
    )


def _spectrum_panels(pictures: Pictures) -> tuple[Panel, ...]:
    found = []
    for n, spectra in pictures.spectra.items():
        for i, (name, each) in enumerate(spectra.items()):
            radial = charts.radial_picture(
                each.frequencies.tolist(), each.radial_power.tolist(), math.sqrt(n), i, f"{name}, {n:,} points"
            )
            found.append(Panel(charts.power_picture(each.power, f"{name}, {n:,} points") + radial, f"{name}, {n:,}"))
    return tuple(found)


def _columns(table: Table) -> tuple[Section, ...]:
    """The measures that were chosen beside the table's, if any were."""
    found = []
    for spec in table.options.columns:
        rows = [(process, tuple(_column(cell, spec) for cell in table.row(process))) for process in table.processes]
        found.append(PageTable(f"{spec}, mean over realisations", ("process", *_counts(table)), tuple(rows)))
    text = "Other measures of the same sets; see aliascope list measures for what they are."
    return (Section("columns", "Other measures", (text,), tuple(found)),) if found else ()


def _column(cell: Cell, spec: str) -> Value:
    column = cell.columns.get(spec)
    return _value(column.estimate) if column else Value("–", reason=cell.reason)


def _counts(table: Table) -> list[str]:
    return [f"{n:,} point{'s' * (n > 1)}" for n in table.counts]


def _lecture_files(name: str, pictures: Pictures) -> tuple[tuple[str, tuple[tuple[str, str], ...]], ...]:
    sets = [f"points/{process}-{n}.csv" for process in pictures.sets for n in COUNTS]
    spectra = [f"plots/spectra-{n}.{kind}" for n in pictures.spectra for kind in ("svg", "csv")]
    return (
        ("The tables", ((f"{name}.csv", f"{name}.csv"), (f"{name}.json", f"{name}.json"))),
        ("The plot", ((f"{name}.svg", f"plots/{name}.svg"), (f"{name}.csv", f"plots/{name}.csv"))),
        ("The sets", (("points.svg", "plots/points.svg"), *((path[7:], path) for path in sets))),
        ("The spectra", tuple((path[6:], path) for path in spectra)),
    )


# --- samplers and hardware --------------------------------------------------------------------------------------------


def _samplers_page(table: Table, name: str) -> TeachingPage:
    half = table.options.half_count
    caption = f"{shown_measure(half)}; where a sampler has no such count, of the nearest that it has, (N)"
    slopes = {each.process: each.fitted for each in table.slopes}
    rows = []
    for process in table.processes:
        values = [_cell_value(cell, half) for cell in table.row(process)]
        rows.append((process, (*values, _slope(slopes[process]))))
    whole = PageTable(caption, ("sampler", *_counts(table), "exponent of N"), tuple(rows))
    lead = (
        "The table of 1992 again, with every sampler that is registered: the root mean square, over isotropic edges "
        "and realisations, of the share of points on one side less the share of the area there."
    )
    return TeachingPage(
        title="Every sampler at random edges",
        lead=lead,
        facts=_facts(table),
        sections=(
            Section("table", "The table", ("By rising figure at 256 points.",), (whole,)),
            Section("convergence", "How fast it falls", (_SHARES_TEXT,), panels=(_convergence(table),)),
            *_columns(table),
            _notes(table),
            Section("files", "Files beside this page", files=_plain_files(name, True)),
        ),
    )


_SHARES_TEXT = (
    f"As a share of what jittered points have, {CONSTANT:.6f} N^-3/4: level lines fall as they do, rising ones more "
    "slowly, up to random points, whose N^-1/2 is a slope of 1/4 here."
)


def _cell_value(cell: Cell, half: bool) -> Value:
    if cell.reason:
        return Value("–", reason=cell.reason)
    value = _value(cell.shown(half))
    return value if cell.n == cell.asked else Value(f"({cell.n:,}) {value.text}", value.spread)


def _hardware_page(table: Table, name: str) -> TeachingPage:
    half = table.options.half_count
    specs = list(dict.fromkeys(spec for cell in table.cells for spec in cell.columns))
    tables = []
    for spec in (MEASURE, *specs):
        rows = []
        for process in table.processes:
            cells = table.row(process)
            values = [_cell_value(cell, half) if spec == MEASURE else _column(cell, spec) for cell in cells]
            rows.append((process, tuple(replace(value, spread=value.spread.replace("exact", "")) for value in values)))
        caption = shown_measure(half) if spec == MEASURE else spec
        tables.append(PageTable(caption, ("pattern", *_counts(table)), tuple(rows)))
    panels = [_pattern_panel(cell, half) for process in table.processes for cell in table.row(process)]
    return TeachingPage(
        title="What a pixel's samples can be",
        lead=(
            "A pixel of multisampling hardware has 1 to 16 samples, the same in every pixel. The ordered grid, the "
            "standard locations of Vulkan and Direct3D, and the best sets on an 8 × 8 grid, as the SGI "
            "InfiniteReality had it, at random edges. Figures without an error are exact."
        ),
        facts=_facts(table),
        sections=(
            Section("table", "The table", tables=tuple(tables)),
            Section(
                "patterns",
                "The patterns",
                ("The second coordinate downward, as in a picture.",),
                panels=tuple(panels),
                columns=5,
            ),
            _notes(table),
            Section("files", "Files beside this page", files=_plain_files(name, False)),
        ),
    )


GRIDS = {"standard-msaa": 16, "regular": 0}
"""The cells a side that a pattern's places are of; 8 where it is not said."""


def _pattern_panel(cell: Cell, half: bool) -> Panel:
    title = f"{cell.process}, {cell.asked}"
    if cell.reason:
        return Panel("", title, cell.reason)
    note = f"{MEASURE} {figure(cell.shown(half))}, half-plane {figure(cell.columns['half-plane'].estimate)}"
    grid = GRIDS.get(cell.process, 8)
    return Panel(charts.set_picture(np.array(cell.points), title, grid, downward=True), title, note)


def _plain_files(name: str, plotted: bool) -> tuple[tuple[str, tuple[tuple[str, str], ...]], ...]:
    tables = ("The table", ((f"{name}.csv", f"{name}.csv"), (f"{name}.json", f"{name}.json")))
    plot = ("The plot", ((f"{name}.svg", f"plots/{name}.svg"), (f"{name}.csv", f"plots/{name}.csv")))
    return (tables, plot) if plotted else (tables,)
