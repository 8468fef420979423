"""The tables of `aliascope mitchell` as lines of text, and the sentences that go under them."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

from aliascope.records import Estimate
from aliascope.studies.mitchell import CONSTANT, MEASURE, Cell, Table

NONE = "-"
WIDTH = 100
Notes = list[tuple[str, str]]


def figure(estimate: Estimate) -> str:
    """A value to the last digit that its standard error leaves; four digits where it has none."""
    value, error = estimate.value, estimate.standard_error
    if value is None:
        return NONE
    if not error or value == 0.0:
        return f"{value:.4g}"
    return f"{value:.{max(0, 1 - math.floor(math.log10(error)))}f}"


def spread(estimate: Estimate) -> str:
    """The standard error, to two digits."""
    if estimate.value is None:
        return ""
    error = estimate.standard_error
    if error is None:
        return "unknown"
    return "exact" if error == 0.0 else f"{error:.{max(0, 1 - math.floor(math.log10(error)))}f}"


def plain(value: float | None, form: str = ".3g") -> str:
    """A figure without an error."""
    return NONE if value is None else f"{value:{form}}"


def aligned(rows: Sequence[Sequence[str]], left: int = 1) -> list[str]:
    """Lines of a table: the first `left` columns flush left, the others flush right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        "  ".join(
            f"{text:<{w}}" if i < left else f"{text:>{w}}" for i, (text, w) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def lines(table: Table) -> list[str]:
    """The table, what follows from it, and what is to be said of it."""
    head = {"lecture": _lecture, "samplers": _by_count, "hardware": _by_count}[table.name](table)
    found = [*head]
    for name, text in notes(table):
        found += ["", *textwrap.wrap(f"{name}: {text}", WIDTH)]
    return found


# --- the lecture's table ----------------------------------------------------------------------------------------------


def _lecture(table: Table) -> list[str]:
    half = table.options.half_count
    columns = table.options.columns
    head = ["process", "points", "half count" if half else "edge-rms", "+-", "published", "ratio"]
    head += ["edge-rms", "ratio"] if half else []
    head += ["closed form", "realisations"]
    for spec in columns:
        head += [spec, "+-"]
    rows = [head]
    for cell in table.cells:
        row = [cell.process, f"{cell.n:,}", figure(cell.shown(half)), spread(cell.shown(half))]
        row += [plain(cell.published), plain(cell.ratio(half), ".3f")]
        row += [figure(cell.plain), plain(cell.ratio(False), ".3f")] if half else []
        row += [plain(cell.closed_form, ".4g"), f"{cell.realisations:,}"]
        for spec in columns:
            row += [figure(cell.columns[spec].estimate), spread(cell.columns[spec].estimate)]
        rows.append(row)
    slopes = [["exponent of N", "fitted", "+-", "published", "closed form"]]
    for each in table.slopes:
        fitted = [plain(each.fitted.value, ".3f"), spread(each.fitted)]
        slopes.append([each.process, *fitted, plain(each.published, ".3f"), plain(each.closed_form, ".2f")])
    return [*aligned(rows), "", *aligned(slopes)]


def notes(table: Table) -> Notes:
    """What is to be said under a table, as (heading, text)."""
    return {"lecture": lecture_notes, "samplers": _samplers_notes, "hardware": _hardware_notes}[table.name](table)


def lecture_notes(table: Table) -> Notes:
    """What is reproduced, fitted and unknown, in figures of this table."""
    return [
        ("Reproduced", _reproduced(table)),
        ("Fitted", _fitted(table)),
        ("Unknown", UNKNOWN),
        ("Searched", SEARCHED),
    ]


def off(cells: Sequence[Cell], half_count: bool) -> float:
    """By how much the farthest of these cells is off its published figure."""
    return max(abs(ratio - 1.0) for cell in cells if (ratio := cell.ratio(half_count)) is not None)


def _reproduced(table: Table) -> str:
    random = table.row("random")
    others = [cell for name in ("zaremba", "jittered", "n-rooks") for cell in table.row(name)]
    large = [cell for cell in others if cell.asked > 16]
    small = [1.0 - (cell.ratio(False) or 1.0) for cell in others if cell.asked == 16]
    orders = [f"{n:,}" for n in table.counts if _ordered(table, n)]
    text = (
        f"Over isotropic edges the random row comes within {off(random, False):.1%} of the published one, and follows "
        f"{CONSTANT:.6f} N^-1/2, its closed form. Zaremba, jittered and N-rooks come within {off(large, False):.0%} at "
        f"256 and 1,600 points, and {min(small):.0%} to {max(small):.0%} low at 16. "
    )
    if not orders:
        return text + "The order of the published table is not met."
    return text + (
        "The order Zaremba < jittered < Poisson-disk < N-rooks < random is that of the published table at "
        f"{_and(orders)} points."
    )


def _ordered(table: Table, n: int) -> bool:
    values = [cell.plain.value for cell in table.cells if cell.asked == n]
    return values == sorted(values, key=lambda value: value or 0.0)


def _and(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _fitted(table: Table) -> str:
    disks = table.row("poisson-disk")
    others = [cell for cell in table.cells if cell.process != "poisson-disk"]
    return (
        "--half-count adds 1/(4 N^2) to each mean square, what a count that is off by half a point would add. With it "
        f"all twelve cells without Poisson-disk's come within {off(others, True):.1%}, and Poisson-disk's within "
        f"{off(disks, True):.1%}. It was found by looking at the misfit, and is no part of the definition. The "
        "generators are those that fit best: Zaremba with x = i/N, N-rooks on the corners of the lattice, Poisson-disk "
        "by darts on the torus that keep 0.8 of the densest packing's distance while there is room."
    )


UNKNOWN = (
    "How Mitchell drew his edges and how many, how he made his Poisson-disk sets, how many sets a figure is the mean "
    "of, and what the half count stands for. Nothing that could be found says so."
)
SEARCHED = (
    "aliascope mitchell --search measures 20 generators under four ways to draw an edge and four statistics, with the "
    "half count and without. Off by (root mean square over the fifteen cells, each process by the generator that fits "
    "best): without it 7.4% at the least, for chords and the mean of roots; 9.1% for isotropic edges and the root mean "
    "square, which are the table's. With it isotropic edges come nearest, 3.0% for the mean of roots and 3.8% for the "
    "root mean square: a difference no larger than what its 128 realisations leave open."
)


# --- samplers and hardware --------------------------------------------------------------------------------------------


def _by_count(table: Table) -> list[str]:
    """A row a pattern, a column a count; then the further measures in the same shape, then what has no figure."""
    half = table.options.half_count
    fitted = {each.process: each.fitted for each in table.slopes}
    counts = [f"{n:,} point{'s' * (n > 1)}" for n in table.counts]
    exact = table.name == "hardware"  # so there is no need to say it of each
    head = [shown_measure(half), *counts, *(["exponent of N"] if fitted else [])]
    rows = [head]
    for process in table.processes:
        row = [process, *(_counted(cell, half, exact) for cell in table.row(process))]
        if fitted:
            slope = fitted[process]
            row.append(f"{plain(slope.value, '.3f')} {_error(slope)}")
        rows.append(row)
    found = aligned(rows)
    for spec in dict.fromkeys(spec for cell in table.cells for spec in cell.columns):
        rows = [[spec, *counts]]
        for process in table.processes:
            cells = [
                cell.columns[spec].estimate if spec in cell.columns else Estimate(None) for cell in table.row(process)
            ]
            rows.append([process, *(_with_error(each, exact) for each in cells)])
        found += ["", *aligned(rows)]
    return found


def _counted(cell: Cell, half_count: bool, exact: bool) -> str:
    """The figure and its error; the count before it where it is another."""
    if cell.reason:
        return NONE
    nearest = "" if cell.n == cell.asked else f"({cell.n:,}) "
    shown = cell.shown(half_count)
    return f"{nearest}{_with_error(shown, exact)}"


def _with_error(estimate: Estimate, exact: bool) -> str:
    error = _error(estimate)
    return figure(estimate) if exact and error == "exact" else f"{figure(estimate)} {error}"


def _error(estimate: Estimate) -> str:
    text = spread(estimate)
    return f"+-{text}" if text and text[0].isdigit() else text.replace("unknown", "+-?")


def shown_measure(half_count: bool) -> str:
    """What the figures of a table are."""
    return f"{MEASURE}, half a count added" if half_count else MEASURE


def _not_there(table: Table) -> Notes:
    """The cells without figures, those with the same reason together."""
    found: dict[tuple[str, str], list[str]] = {}
    for cell in table.cells:
        if cell.reason:
            found.setdefault((cell.process, cell.reason), []).append(f"{cell.asked:,}")
    texts = [
        f"{'' if reason.startswith(process) else f'{process}: '}{reason} ({_and(counts)})"
        for (process, reason), counts in found.items()
    ]
    return [("Not there", "; ".join(texts) + ".")] if texts else []


def _samplers_notes(table: Table) -> Notes:
    large = [cell for cell in table.cells if cell.asked == table.counts[-1] and cell.plain.value is not None]
    found = []
    if large:
        best = min(large, key=lambda cell: cell.plain.value or math.inf)
        before = next((cell for cell in large if cell.process == "zaremba"), None)
        text = f"{best.process} has the least at {best.n:,} points, {figure(best.plain)}"
        if before is not None and best is not before and before.plain.value and best.plain.value:
            text += f", {1.0 - best.plain.value / before.plain.value:.0%} less than Zaremba's {figure(before.plain)}"
        if best.process == "regular":
            largest = 0.5 / math.sqrt(best.n or 1) / (best.plain.value or math.inf)
            text += (
                ". Few random edges run along its rows; one that does is off by up to 1/(2 sqrt N), "
                f"{largest:.0f} times that, as --column half-plane shows"
            )
        found.append(("Best", text + "."))
    return [
        *found,
        (
            "Counts",
            "(N) is the nearest count that a sampler has, within a factor of two, by ratio. Figures of other counts "
            "are not those of the column; the exponent is fitted to the counts that there are.",
        ),
        ("Error", "Realisations go on until the standard error is below 3%; patterns that are not random have one."),
        *_not_there(table),
    ]


def _hardware_notes(table: Table) -> Notes:
    how: dict[str, dict[str, list[int]]] = {cell.process: {} for cell in table.cells}
    for cell in table.cells:
        if cell.process.startswith("8x8-"):
            how[cell.process].setdefault(cell.generator, []).append(cell.asked)
    found = []
    for process, ways in how.items():
        parts = [f"{_and([str(n) for n in counts])} points: {way}" for way, counts in ways.items()]
        if parts:
            found.append(
                (process, f"The least {process[4:]} of all sets of cell centres of the 8 x 8 grid. {'; '.join(parts)}.")
            )
    return [
        *found,
        (
            "Exhaustive",
            "All sets were compared, some by an argument that leaves them out together: "
            "aliascope.studies.hardware_search says which, and makes these sets again.",
        ),
        *_not_there(table),
    ]
