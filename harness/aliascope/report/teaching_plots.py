"""Figures for a paper: discrepancy against the number of points, point sets, their spectra, as SVG."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from aliascope.report.charts import Series
from aliascope.report.plots import power_of_ten, svg_of
from aliascope.report.teaching import spread_out

Array = NDArray[np.float64]
COLOURS = ("#0072B2", "#009E73", "#D55E00", "#CC79A7", "#444444")
INK, SOFT, GRID = "#222222", "#777777", "#dddddd"


def convergence_svg(series: Sequence[Series], title: str, label: str, counts: Sequence[int]) -> str:
    """Log-log, 6.4 inches wide, `label` on the upright axis; filled: measured, hollow: published, dotted: closed."""
    few = len(series) <= len(COLOURS)

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlim(min(n for one in series for n, _ in one.measured) / 1.2, counts[-1] * (4.0 if few else 8.0))
        axes.set_xticks(counts, [f"{n:,}" for n in counts])
        axes.yaxis.set_major_formatter(power_of_ten)
        axes.yaxis.set_minor_formatter(_two_and_five)
        axes.tick_params(axis="x", which="minor", length=0)
        axes.xaxis.set_minor_formatter(lambda value, position: "")
        axes.grid(which="major", linewidth=0.3, color=GRID)
        for i, one in enumerate(series):
            _draw_series(axes, one, COLOURS[i] if few else SOFT)
        _name_ends(axes, series, few)
        axes.set_title(title, loc="left", fontsize=9, fontweight="bold")
        axes.set_xlabel("points")
        axes.set_ylabel(label)

    return svg_of(draw, (6.4, 4.4 if few else max(4.4, 0.16 * len(series) + 1.0)))


def _two_and_five(value: float, position: float) -> str:
    """The text of a minor tick of a logarithmic axis: those of 2 and 5 have one."""
    return power_of_ten(value, position) if f"{value:e}"[0] in "25" else ""


def _draw_series(axes: Axes, one: Series, colour: str) -> None:
    axes.plot(*zip(*one.measured, strict=True), color=colour, marker="o", markersize=3, linewidth=1.1)
    if one.published:
        look: dict[str, Any] = {"marker": "o", "markersize": 7, "markerfacecolor": "none", "linestyle": "none"}
        axes.plot(*zip(*one.published, strict=True), color=colour, **look)
    if one.closed:
        constant, exponent = one.closed
        n = np.array([one.measured[0][0], one.measured[-1][0]])
        axes.plot(n, constant * n**exponent, color=colour, linewidth=0.8, linestyle=":")


def _name_ends(axes: Axes, series: Sequence[Series], few: bool) -> None:
    """The names beside the last points, apart by a line's height: in logarithms, as the axis is."""
    low, high = (math.log10(limit) for limit in axes.get_ylim())
    ends = [(one.measured[-1][0], math.log10(one.measured[-1][1])) for one in series]
    line = (high - low) * (0.035 if few else 0.9 / max(len(series), 18))
    places = spread_out([value for _, value in ends], line, low, high)
    right = max(n for n, _ in ends) * 1.25
    for i, (one, (n, value), place) in enumerate(zip(series, ends, places, strict=True)):
        axes.plot([n * 1.04, right], [10**value, 10**place], color=GRID, linewidth=0.5, zorder=0)
        colour = COLOURS[i] if few else INK
        axes.text(right * 1.03, 10**place, one.name, va="center", color=colour, fontsize=8 if few else 6.5)


def sets_svg(sets: Mapping[str, Sequence[Array]]) -> str:
    """A row a process, a column a count."""

    def draw(figure: Figure) -> None:
        rows = len(sets)
        columns = max(len(of) for of in sets.values())
        for i, (name, of) in enumerate(sets.items()):
            for j, points in enumerate(of):
                axes = figure.add_subplot(rows, columns, i * columns + j + 1)
                axes.plot(
                    points[:, 0], points[:, 1], ".", color=INK, markersize=20.0 / math.sqrt(len(points)) ** 0.8 + 0.5
                )
                axes.set(xlim=(0, 1), ylim=(0, 1), aspect="equal", xticks=(), yticks=())
                axes.spines[["top", "right"]].set_visible(True)
                for line in axes.lines:
                    line.set_markeredgewidth(0)
                if i == 0:
                    axes.set_title(f"{len(points):,} points", fontsize=8)
                if j == 0:
                    axes.set_ylabel(name, fontsize=8)

    return svg_of(draw, (6.4, 2.1 * len(sets) + 0.3))


def spectra_svg(spectra: Mapping[str, tuple[Array, Array, Array]], n: int) -> str:
    """A column a process: the power in two dimensions, black 0 and white 2, and its radial mean.

    spectra: name to (power (2K+1, 2K+1), frequencies (K,), radial power (K,)).
    """

    def draw(figure: Figure) -> None:
        columns = len(spectra)
        for j, (name, (power, frequencies, radial)) in enumerate(spectra.items()):
            edge = len(frequencies) + 0.5
            plane = figure.add_subplot(2, columns, j + 1)
            plane.imshow(power, cmap="gray", vmin=0, vmax=2, extent=(-edge, edge, -edge, edge), origin="lower")
            plane.set(xticks=(), yticks=())
            plane.set_title(name, fontsize=8)
            axes = figure.add_subplot(2, columns, columns + j + 1)
            axes.axhline(1.0, color=GRID, linewidth=0.6, zorder=0)
            axes.axvline(math.sqrt(n), color=GRID, linewidth=0.6, zorder=0)
            axes.plot(frequencies, radial, color=COLOURS[j % len(COLOURS)], linewidth=0.9)
            axes.set(xlim=(0, edge), ylim=(0, 2.2), yticks=(0, 1, 2) if j == 0 else ())
            axes.set_xlabel("cycles over the side", fontsize=6.5)
            axes.tick_params(labelsize=6.5)

    return svg_of(draw, (1.55 * len(spectra), 3.1))
