"""The star discrepancy over the number of points with the fits of its order, and N D* over powers of log N."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from aliascope.errors import InvalidInput, NotWritable
from aliascope.studies.orders import Fit, Orders
from aliascope.studies.point_pictures import GRID, SOFT, STYLE, save

# Okabe and Ito's, which eyes of all kinds tell apart.
_COLOURS = ("#0072B2", "#D55E00", "#009E73")
_DASHES: tuple[Any, ...] = ("solid", (0, (5, 2)), (0, (1, 1.5)))


def check(path: Path) -> None:
    """Raises InvalidInput for a file that no picture is written as."""
    if path.suffix.lower() not in (".svg", ".png"):
        raise InvalidInput(f'{path}: the picture is written as .svg or .png, not "{path.suffix}"')


def draw(path: Path, orders: Orders) -> None:
    """Writes .svg or .png. Raises InvalidInput, NotWritable."""
    check(path)
    with rc_context(STYLE):
        figure = Figure(figsize=(5.6, 7.2), layout="constrained")
        above, below = figure.subplots(2, 1, height_ratios=(3, 2))
        _draw_star(above, orders)
        _draw_ratios(below, orders)
    try:
        save(figure, path)
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error


def _draw_star(axes: Axes, orders: Orders) -> None:
    n, star = np.array([one.n for one in orders.at], float), np.array([one.star for one in orders.at])
    along = np.geomspace(n[0], n[-1], 200)
    for fit, colour, dashes in zip(orders.fits, _COLOURS, _DASHES, strict=True):
        width = 1.8 if fit is orders.best else 1.0
        axes.plot(along, fit.star(along), color=colour, linestyle=dashes, linewidth=width, label=_label(fit))
    axes.plot(n, star, "o", color="black", markersize=3.5, label="D*, exact", zorder=3)
    if orders.realisations > 1:
        errors = [2.0 * (one.standard_error or 0.0) for one in orders.at]
        axes.errorbar(n, star, errors, fmt="none", color="black", linewidth=0.8)
    _axis_of_n(axes, n)
    _log_scale(axes)
    axes.set_ylabel("star discrepancy D*")
    axes.legend(frameon=False, fontsize=7, loc="lower left", handlelength=3)
    several = f", mean of {orders.realisations} realisations" if orders.realisations > 1 else ""
    dimensions = f"{orders.d} dimension{'s' * (orders.d != 1)}"
    axes.set_title(f"{orders.sampler} in {dimensions}{several}", loc="left", fontweight="bold")


def _label(fit: Fit) -> str:
    if fit.rate is not None:
        return f"N^-r, r = {fit.rate:.3f}; residual {100 * fit.residual:.2g} %"
    term = f" {_log(fit.log_power)}" if fit.log_power else ""
    terms = f"({fit.c:.3g}{term} + {fit.c0:.3g})" if fit.c0 else f"{fit.c:.3g}{term}"
    return f"{terms} / N; residual {100 * fit.residual:.2g} %"


def _log(power: int) -> str:
    return "log" + ("", "²", "³", "⁴")[power - 1] + " N"


def _draw_ratios(axes: Axes, orders: Orders) -> None:
    """N D* over the powers of log N, and less the lower order that was fitted: what is of that order levels."""
    n = np.array([one.n for one in orders.at], float)
    for fit, colour in zip(orders.fits[:2], _COLOURS, strict=False):
        power = fit.log_power or 0
        ratios = np.array(orders.ratios(power))
        name = f"N D* / {_log(power)}" if power else "N D*"
        axes.plot(n, ratios, "o-", color=colour, markersize=3, linewidth=1.0, label=name)
        if fit.c0:
            less = np.array(orders.ratios(power, fit.c0))
            label = name.replace("N D*", f"(N D* - {fit.c0:.3g})")
            axes.plot(n, less, "o:", color=colour, markersize=3, markerfacecolor="white", linewidth=1.0, label=label)
    _axis_of_n(axes, n)
    _log_scale(axes)
    axes.set_ylabel("ratio")
    axes.legend(frameon=False, fontsize=7, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)


def _log_scale(axes: Axes) -> None:
    """Powers of ten, and where there are few of them their multiples by 2 and 5 too, written out."""
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high / low < 200.0 else (1.0,)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _axis_of_n(axes: Axes, n: Any) -> None:
    axes.set_xscale("log", base=2)
    axes.set_xlim(n[0] / 1.2, n[-1] * 1.2)
    first, last = math.ceil(math.log2(n[0])), math.floor(math.log2(n[-1]))
    step = 2 if last - first > 8 else 1
    ticks = [2**k for k in range(first, last + 1, step)]
    axes.set_xticks(ticks, [str(tick) for tick in ticks])
    axes.minorticks_off()
    axes.grid(color=GRID, linewidth=0.5)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_xlabel("points N", color=SOFT)
