"""Plots of error against N, and of error against the dimension."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter

from aliascope.integration import Convergence, ErrorAt
from aliascope.report.inline_svg import INK, PAPER, RULE, SOFT
from aliascope.report.plots import limits, power_of_ten, svg_of

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = "os^Dv"


@dataclass(frozen=True)
class Line:
    """One line of a plot: y with its standard error at each x; points at the floor of rounding are hollow."""

    label: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    y_error: tuple[float, ...]
    hollow: tuple[bool, ...]
    colour: int | None = None
    """Which of the colours; the line's own number if None."""
    dashed: bool | None = None
    """If None, the lines that come after all colours are taken."""

    @classmethod
    def of(cls, result: Convergence, label: str) -> Line:
        """The errors of a sampler."""
        return cls.through(label, [(float(error.n), error, 1.0) for error in result.errors])

    @classmethod
    def through(cls, label: str, rows: Sequence[tuple[float, ErrorAt, float]]) -> Line:
        """Errors at their x, each over a size. One of 0 is drawn where rounding begins to be felt."""
        least = [max(error.rmse, error.floor / 64.0) for _, error, _ in rows]
        return cls(
            label,
            tuple(x for x, _, _ in rows),
            tuple(y / size for y, (_, _, size) in zip(least, rows, strict=True)),
            tuple(error.standard_error / size for _, error, size in rows),
            tuple(error.at_floor for _, error, _ in rows),
        )


@dataclass(frozen=True)
class Guide:
    """A dashed line x^exponent, through the first point of the line `through`, times `above`."""

    exponent: float
    text: str
    through: int = 0
    above: float = 1.7
    at: float = 0.6
    """Where along the line its text is, from 0 to 1."""


def convergence_svg(title: str, lines: Sequence[Line], guides: Sequence[Guide] | None = None) -> str:
    """Error against N, log-log. Without guides given: N^-1/2 and N^-1 through the first line."""
    if guides is None:
        guides = (Guide(-0.5, "N^-1/2"), Guide(-1.0, "N^-1"))
    return _svg(title, lines, guides, "N", "RMSE, or |error| of a fixed pattern", None)


def dimensions_svg(title: str, lines: Sequence[Line], y_label: str) -> str:
    """Error against the dimension, log-log."""
    return _svg(title, lines, (), "d, dimensions", y_label, None)


def ratio_svg(title: str, lines: Sequence[Line]) -> str:
    """|error| / (V D*) against N, with a line at 1, which nothing crosses."""
    return _svg(title, lines, (), "N", "|error| / (V D*_N)", 1.0)


def _svg(
    title: str, lines: Sequence[Line], guides: Sequence[Guide], x_label: str, y_label: str, ceiling: float | None
) -> str:
    shown = [line for line in lines if line.x]

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        _prepare(axes, shown, ceiling)
        for guide in guides:
            if guide.through < len(shown):
                _draw_guide(axes, guide, shown[guide.through])
        for index, line in enumerate(shown):
            _draw_line(axes, line, index)
        axes.set_title(title, loc="left", fontsize=9, fontweight="bold", color=INK)
        axes.set_xlabel(x_label, color=INK)
        axes.set_ylabel(y_label, color=INK)
        if shown:
            figure.legend(loc="outside lower center", ncols=2, fontsize=7.5, labelcolor=INK)

    return svg_of(draw, (4.4, 3.1 + 0.17 * -(-len(shown) // 2)))  # the legend has two columns


def _prepare(axes: Axes, shown: Sequence[Line], ceiling: float | None) -> None:
    axes.set(xscale="log", yscale="log")
    axes.set_facecolor("none")
    axes.tick_params(which="both", colors=SOFT)
    for spine in axes.spines.values():
        spine.set_color(SOFT)
    axes.grid(which="major", linewidth=0.4, color=RULE)
    axes.set_axisbelow(True)
    if ceiling is not None:
        axes.axhline(ceiling, color=INK, linewidth=1.2)
        axes.annotate(
            "1", (0, ceiling), (3, 2), xycoords=("axes fraction", "data"), textcoords="offset points", color=INK
        )
    if not shown:
        return
    x = sorted({value for line in shown for value in line.x})
    y = [value for line in shown for value in line.y]
    errors = [value for line in shown for value in line.y_error]
    low, high = limits(y + ([ceiling] if ceiling else []), errors + ([0.0] if ceiling else []))
    axes.set_xlim(*limits(x, [0.0] * len(x)))
    axes.set_ylim(low, high)
    axes.yaxis.set_major_formatter(power_of_ten)
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_minor_formatter(NullFormatter())
    if max(x) <= 64:  # dimensions: each has its tick
        axes.xaxis.set_major_locator(FixedLocator(x))
        axes.xaxis.set_minor_locator(FixedLocator([]))
    axes.xaxis.set_major_formatter(lambda value, position: f"{value:.0f}")


def _draw_guide(axes: Axes, guide: Guide, line: Line) -> None:
    first, last = line.x[0], line.x[-1]
    start = guide.above * line.y[0]
    end = start * (last / first) ** guide.exponent
    axes.plot([first, last], [start, end], color=SOFT, linewidth=0.9, linestyle=(0, (4, 3)), zorder=1)
    middle = first * (last / first) ** guide.at
    axes.annotate(
        guide.text,
        (middle, start * (middle / first) ** guide.exponent),
        (4, 3),
        textcoords="offset points",
        fontsize=7.5,
        color=SOFT,
        clip_on=True,
    )


def _draw_line(axes: Axes, line: Line, index: int) -> None:
    number = index if line.colour is None else line.colour
    colour, marker = COLOURS[number % len(COLOURS)], MARKERS[number % len(MARKERS)]
    style = (0, (5, 1.5)) if (number >= len(COLOURS) if line.dashed is None else line.dashed) else "-"
    lower = [min(error, 0.999 * y) for y, error in zip(line.y, line.y_error, strict=True)]
    axes.errorbar(line.x, line.y, yerr=[lower, line.y_error], fmt="none", ecolor=colour, elinewidth=0.7, zorder=2)
    drawn: dict[str, Any] = {"color": colour, "marker": marker, "markersize": 3.8}
    axes.plot(line.x, line.y, linewidth=1.1, linestyle=style, markeredgewidth=0.0, label=line.label, zorder=3, **drawn)
    rounding = [(x, y) for x, y, hollow in zip(line.x, line.y, line.hollow, strict=True) if hollow]
    if rounding:
        axes.plot(*zip(*rounding, strict=True), linestyle="none", markerfacecolor=PAPER, zorder=4, **drawn)
