"""What `aliascope stability` says: words of cells and levels, the map as tables for a terminal, what breaks below."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table
from rich.text import Text

from aliascope.stability.extremes import EXTREMES
from aliascope.stability.records import Cell, Extreme, Group, Kind, Reading
from aliascope.studies.stability import GROUPS, KINDS, Map

WIDTH = 100
"""Columns of a terminal that a table may take."""

STEPS = (1.0, 3.0, 6.0, 9.0, 12.0)
"""Decimal digits lost at which a cell gets another colour; past the last, and where nothing is left, are two more."""

_STYLES = ("green", "cyan", "yellow", "magenta", "red", "bold red", "bold red reverse")

PLURALS: dict[Kind, str] = {kind: "film" if kind == "film" else f"{kind}s" for kind in KINDS}

# --- words ------------------------------------------------------------------------------------------------------------


def power(value: float) -> tuple[int, int, int] | None:
    """(base, exponent, what is added) of a level that is a power of ten, or next to one of two; else None."""
    if value != 0.0:
        exponent = round(math.log10(abs(value)))
        if (exponent >= 4 or exponent <= -3) and value == float(f"1e{exponent}"):
            return 10, exponent, 0
    if value == math.floor(value) and 2**15 < value <= 2**64:
        for added in (0, 1, -1):
            mantissa, exponent = math.frexp(value - added)
            if mantissa == 0.5 and value - added + added == value:
                return 2, exponent - 1, added
    return None


def level(value: float) -> str:
    """A level: 10^9, 2^24+1, 0.01."""
    found = power(value)
    if found is None:
        return number(value)
    base, exponent, added = found
    return f"{base}^{exponent}{added:+d}" if added else f"{base}^{exponent}"


def number(value: float, digits: int = 3) -> str:
    """A figure with a few digits; integers that are no longer than that are whole."""
    if math.isinf(value):
        return "none"
    if value == math.floor(value) and abs(value) < 1e6:
        return f"{value:.0f}"
    return f"{value:.{digits}g}"


def levels(values: Iterable[float], joint: str = ", ") -> str:
    return joint.join(map(level, values))


def cell_text(cell: Cell) -> str:
    """What stands in the map: where it breaks, or that it does not."""
    if cell.absent:
        return "not there"
    parts = [levels(cell.breaks)] if cell.breaks else []
    if cell.failed_from is not None:
        parts.append(f"fails at {level(cell.failed_from)}")
    if not parts and cell.refused_from is not None:
        parts.append(f"refuses at {level(cell.refused_from)}")
    return ", ".join(parts) or "keeps"


def lost_text(cell: Cell) -> str:
    """The digits that a cell loses at its worst; empty where that is none, or there is no error."""
    lost = cell.digits_lost
    if lost is None or lost < 0.05:
        return ""
    return "nothing left" if math.isinf(lost) else f"{lost:.1f} digits lost"


def step(cell: Cell) -> int | None:
    """Which of the colours a cell has, 0 the mildest; None where it has no error."""
    lost = cell.digits_lost
    if lost is None:
        return None
    return len(STEPS) + 1 if math.isinf(lost) else sum(lost >= each for each in STEPS)


def error_text(reading: Reading, cell: Cell) -> str:
    if reading.error is None or math.isinf(reading.error):
        return "no finite result"
    return f"{number(reading.error)} {cell.unit}"


def break_text(cell: Cell) -> str:
    """Where and how badly a cell breaks, in a line."""
    assert cell.worst is not None
    worst = cell.worst
    told = f"from {levels(cell.breaks, ' and ')} on; the bound is {number(cell.bound)} {cell.unit}"
    told += f", at worst: {error_text(worst, cell)} at {level(worst.at)}, against {cell.against}"
    return told + (f". {cell.note}" if cell.note else "")


def refusal_text(cell: Cell) -> str:
    first = next(each for each in cell.readings if each.refused)
    return f"from {level(first.at)} on: {first.refused}"


def failure_text(cell: Cell) -> str:
    first = next(each for each in cell.readings if each.failed)
    return f"at {level(first.at)}: {first.failed}"


def summary(found: Map) -> str:
    """What came out, in a sentence."""
    excused = sum(cell.status == "breaks" and cell.excused for cell in found.cells)
    ours = sum(cell.status == "breaks" and not cell.excused for cell in found.cells)
    parts = [f"{sum(cell.status == 'keeps' for cell in found.cells)} of {len(found.cells)} cells keep their bounds"]
    for count, what in (
        (sum(cell.status == "refuses" for cell in found.cells), "keep them until they decline"),
        (ours, "of ours pass them"),
        (excused, "pass them by the arithmetic of others, or without a safeguard"),
        (sum(cell.status == "absent" for cell in found.cells), "could not be measured for want of a library"),
        (len(found.failed) + len(found.lost), "failed"),
    ):
        if count:
            parts.append(f"{count} {what}")
    return ", ".join(parts)


# --- tables -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Grid:
    """The part of the map that is of one group: its extremes and rows, of those that there is a cell of."""

    group: Group
    extremes: tuple[Extreme, ...]
    rows: tuple[tuple[Kind, str], ...]
    cells: dict[tuple[Kind, str, str], Cell]

    def row(self, kind: Kind, component: str) -> tuple[Cell | None, ...]:
        return tuple(self.cells.get((kind, component, extreme.name)) for extreme in self.extremes)


def grids(cells: Sequence[Cell]) -> list[Grid]:
    """Of the groups of extremes that there are cells of. Rows stand in the order of `cells`."""
    made = []
    for group in GROUPS:
        own = {(c.kind, c.component, c.extreme): c for c in cells if EXTREMES[c.extreme].group == group}
        names = {extreme for _, _, extreme in own}
        extremes = tuple(each for each in EXTREMES.values() if each.name in names)
        if own:
            made.append(Grid(group, extremes, tuple(dict.fromkeys((kind, name) for kind, name, _ in own)), own))
    return made


def _parts(grid: Grid) -> Iterator[Grid]:
    """A grid in parts that fit the width, each with the rows that it has cells of."""
    chosen: list[Extreme] = []
    room = WIDTH - _first(grid) - 2
    for extreme in grid.extremes:
        wide = _wide(grid, extreme) + 2
        if chosen and wide > room:
            yield _part(grid, chosen)
            chosen, room = [], WIDTH - _first(grid) - 2
        chosen.append(extreme)
        room -= wide
    yield _part(grid, chosen)


def _part(grid: Grid, extremes: Sequence[Extreme]) -> Grid:
    names = {each.name for each in extremes}
    own = {key: cell for key, cell in grid.cells.items() if key[2] in names}
    rows = tuple(row for row in grid.rows if any((*row, name) in own for name in names))
    return Grid(grid.group, tuple(extremes), rows, own)


def _first(grid: Grid) -> int:
    """The width of the column of names; a longer one goes on in a new line."""
    names = (grid.group, *(PLURALS[kind] for kind, _ in grid.rows), *(component for _, component in grid.rows))
    return min(34, max(map(len, names)))


def _wide(grid: Grid, extreme: Extreme) -> int:
    """Of the longest line of a column."""
    texts = [_in_lines(cell) for (_, _, name), cell in grid.cells.items() if name == extreme.name]
    return max(len(line) for text in (_head(extreme), *texts) for line in text.split("\n"))


def _in_lines(cell: Cell) -> str:
    """The text of a cell, broken where it has parts."""
    return cell_text(cell).replace(", ", ",\n").replace(" at ", "\nat ")


def _head(extreme: Extreme) -> str:
    """Long names in lines, broken where they have a hyphen."""
    return extreme.name.replace("-", "-\n") if len(extreme.name) > 9 else extreme.name


def _table(grid: Grid) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="bold", title_style="bold", title_justify="left")
    table.add_column(grid.group, width=_first(grid), overflow="fold")
    for extreme in grid.extremes:
        table.add_column(_head(extreme), width=_wide(grid, extreme), overflow="fold")
    above: Kind | None = None
    for kind, component in grid.rows:
        if kind != above:
            table.add_row(Text(PLURALS[kind], style="dim italic"))
            above = kind
        table.add_row(Text(component), *(_coloured(cell) for cell in grid.row(kind, component)))
    return table


def _coloured(cell: Cell | None) -> Text:
    if cell is None:
        return Text("")
    found = step(cell)
    return Text(_in_lines(cell), style="dim" if found is None else _STYLES[found])


def show(found: Map, console: Console) -> None:
    """The map on a terminal, and what is to be said of its cells."""
    for grid in grids(found.cells):
        for part in _parts(grid):
            console.print(_table(part))
            console.print()
    legend = Text("Coloured by the decimal digits that the worst reading has lost: ")
    names = [f"below {each:g}" for each in STEPS] + [f"{STEPS[-1]:g} or more", "nothing left"]
    for place, (name, style) in enumerate(zip(names, _STYLES, strict=True)):
        legend.append(", " if place else "").append(name, style=style)
    console.print(legend)
    for line in lines(found):
        console.print(Text(line), soft_wrap=True)


def lines(found: Map) -> list[str]:
    """What breaks, what declines, what failed, and the sum of it."""
    told = [f"breaks    {_named(cell)}: {break_text(cell)}" for cell in found.ours]
    told += [f"excused    {_named(cell)}: {break_text(cell)}" for cell in found.broken if cell.excused]
    told += [f"declines  {_named(cell)}: {refusal_text(cell)}" for cell in found.cells if cell.refused_from is not None]
    told += [f"FAILED    {_named(cell)}: {failure_text(cell)}" for cell in found.failed]
    told += [f"FAILED    the probes of {module}: {reason}" for module, reason in found.lost.items()]
    told += [f"not there {name}: {reason}" for name, reason in absences(found).items()]
    return [*told, summary(found) + "."]


def absences(found: Map) -> dict[str, str]:
    """What could not be measured for want of a library, with the reason."""
    return {
        **{f"the probes of {module}": reason for module, reason in found.absent.items()},
        **{cell.component: cell.absent for cell in found.cells if cell.absent},
    }


def _named(cell: Cell) -> str:
    return f"{cell.component}, {cell.extreme}"
