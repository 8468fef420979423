"""Bias and coverage against the mean number of samples, one figure an integrand."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from aliascope.report.inline_svg import INK, RULE, SOFT
from aliascope.studies.estimate import Measured
from aliascope.studies.point_pictures import save

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8c6d31", "#7f7f7f")
MARKERS = "os^DvpX*"
_STYLE: dict[Any, Any] = {
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": SOFT,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "font.size": 8,
    "text.parse_math": False,
}


def draw(rows: Sequence[Measured], confidence: float, paths: Sequence[Path]) -> None:
    """Writes the figure of one integrand to each path, .svg or .png. Raises OSError."""
    with rc_context(_STYLE):
        figure = Figure(figsize=(5.0, 4.5), layout="constrained")
        figure.patch.set_alpha(0.0)
        bias, coverage = figure.subplots(2, 1, sharex=True)
        counts = [row.samples for row in rows]
        _prepare(bias, counts)
        _prepare(coverage, counts)
        bias.axhline(0.0, color=SOFT, linewidth=0.7)
        coverage.axhline(100.0 * confidence, color=SOFT, linewidth=0.7)
        scale = abs(rows[0].exact) or 1.0
        names = list(dict.fromkeys(_name(row) for row in rows))
        for name in names:
            look = _look(names.index(name))
            mine = [row for row in rows if _name(row) == name]
            _points(bias, mine, [100.0 * row.bias / scale for row in mine], look, name)
            stated = [row for row in mine if row.coverage is not None]
            _points(coverage, stated, [100.0 * (row.coverage or 0.0) for row in stated], look, name)
            for row in mine:
                error = 200.0 * row.bias_standard_error / scale
                bias.errorbar(row.samples, 100.0 * row.bias / scale, error, color=look["color"], linewidth=0.8)
        bias.set_ylabel("bias, % of the integral" if rows[0].exact else "bias, hundredths")
        coverage.set_ylabel("intervals that hold it, %")
        least = 100.0 * min([row.coverage for row in rows if row.coverage is not None] or [0.0])
        room = 0.06 * (100.0 - least) + 0.5
        coverage.set_ylim(least - room, 100.0 + room)
        coverage.set_xlabel("mean samples a pixel")
        coverage.annotate(
            f"{100.0 * confidence:g} % stated", (0.0, 100.0 * confidence), (3, -3), xycoords=("axes fraction", "data"),
            textcoords="offset points", va="top", color=SOFT, fontsize=7,
        )  # fmt: skip
        figure.legend(*bias.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=7)
        for path in paths:
            figure.patch.set_facecolor("white")
            figure.patch.set_alpha(1.0 if path.suffix == ".png" else 0.0)
            save(figure, path)


def _name(row: Measured) -> str:
    """What belongs together: an estimator, where it is unbiased, on another sampler."""
    name = row.estimator.split(":")[0]
    if "unbiased=1" in row.estimator:
        name += ", unbiased"
    return name if row.sampler == "random" else f"{name} on {row.sampler}"


def _look(number: int) -> dict[str, Any]:
    return {"color": COLOURS[number % len(COLOURS)], "marker": MARKERS[number % len(MARKERS)]}


def _points(axes: Axes, rows: Sequence[Measured], values: list[float], look: dict[str, Any], name: str) -> None:
    ordered = sorted(zip([row.samples for row in rows], values, strict=True))
    axes.plot(
        [x for x, _ in ordered],
        [y for _, y in ordered],
        label=name,
        markersize=5,
        markeredgewidth=0,
        linewidth=0.9 if name == "fixed" else 0.0,  # the baseline is one line through its counts
        clip_on=False,
        **look,
    )


def _prepare(axes: Axes, counts: Sequence[float]) -> None:
    axes.set_xscale("log")
    low, high = min(counts) / 1.3, max(counts) * 1.3
    axes.set_xlim(low, high)
    ticks = [float(4**k) for k in range(30) if low <= 4**k <= high]
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.grid(color=RULE, linewidth=0.6)
    axes.set_axisbelow(True)
