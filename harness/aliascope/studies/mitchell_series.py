"""The lines that the plots of a table draw."""

from __future__ import annotations

from dataclasses import replace

from aliascope.report.charts import Series
from aliascope.studies.mitchell import CONSTANT, Table


def series_of(table: Table) -> list[Series]:
    """The lines of the table's plot; the figures that it shows."""
    half = table.options.half_count
    exponents = {each.process: each.closed_form for each in table.slopes}
    found = []
    for process in table.processes:
        row = [cell for cell in table.row(process) if cell.plain.value is not None]
        measured = tuple((float(cell.n or 0), cell.shown(half).value or 0.0) for cell in row)
        published = tuple((float(cell.n or 0), cell.published) for cell in row if cell.published)
        exponent = exponents.get(process)
        if measured:
            found.append(Series(process, measured, published, None if exponent is None else (CONSTANT, exponent)))
    return found


def plotted(table: Table) -> tuple[list[Series], str]:
    """What the plot of a table draws, and what its axis says.

    Of samplers, which mostly fall alike, their shares of the jittered closed form, and not those with one count alone.
    """
    series = series_of(table)
    if table.name != "samplers":
        return series, "root mean square of n(A)/N - area"
    shares = [
        replace(one, measured=tuple((n, value / (CONSTANT * n**-0.75)) for n, value in one.measured))
        for one in series
        if len(one.measured) > 1
    ]
    return shares, "root mean square, over that of jittered points"
