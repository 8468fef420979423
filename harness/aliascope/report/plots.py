"""Figures for a paper: error against CPU time as SVG, the data of each beside it as CSV."""

from __future__ import annotations

import csv
import io
import math
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from aliascope.records import Estimate, ReportData
from aliascope.report.document import number
from aliascope.report.pool import Curve, curve_of, efficiency, in_common, pareto_front, pool, under_one_filter, usable
from aliascope.report.trade import TITLES

OKABE_ITO: Mapping[str, str] = {"embree": "#0072B2", "povray": "#D55E00", "osmesa": "#009E73"}
OTHERS = ("#CC79A7", "#E69F00", "#56B4E9")
MARKERS = "os^DvpX*"
COLUMNS = (
    *("renderer", "mode", "label", "family", "samples_per_pixel", "cpu_seconds", "cpu_seconds_standard_error"),
    *("rmse", "rmse_standard_error", "efficiency", "on_pareto_front", "scenes_missing"),
)
_STYLE: dict[Any, Any] = {
    "text.parse_math": False,  # names are shown as they are, "$" included
    "font.family": ["sans-serif"],
    "font.size": 8,
    "svg.hashsalt": "aliascope",  # the same data gives the same file
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "legend.frameon": False,
}


@dataclass(frozen=True)
class Plot:
    """One figure: `name` for its files, and the curves that it shows."""

    name: str
    title: str
    curves: tuple[Curve, ...]


def colours(renderers: Sequence[str]) -> dict[str, str]:
    """One colour a renderer, the same everywhere in the report; `page.js` gets them from here."""
    others = [name for name in dict.fromkeys(renderers) if name not in OKABE_ITO]
    return {**OKABE_ITO, **{name: OTHERS[i % len(OTHERS)] for i, name in enumerate(others)}}


def plots_of(data: ReportData) -> list[Plot]:
    """All scenes together, then each: their files' names are made of letters, digits and "-" and are all different.

    A scene NAME has NAME-spectrum too, see `spectrum_name`; "filters" and the tables of the trade are no scene's.
    """
    plots: list[Plot] = []
    taken = {"filters", *TITLES}
    if len(data.scenes) > 1:
        taken.add("all-scenes")
        common = in_common(data.scenes)
        counted = len(under_one_filter(data.scenes))
        title = f"{len(common)} of {counted} scenes, which every renderer drew in much the same modes"
        if len(common) == counted:
            title = f"All {counted} scenes" if counted > 1 else f"The scene {common[0].name}"
        plots.append(Plot("all-scenes", title, pool(common)))
    for scene in data.scenes:
        stem = re.sub(r"[^a-z0-9]+", "-", scene.name.lower()).strip("-")[:60] or "scene"
        name = next(n for n in _numbered(stem) if not {n, spectrum_name(n)} & taken)
        taken |= {name, spectrum_name(name)}
        plots.append(Plot(name, scene.title or scene.name, tuple(curve_of(row) for row in scene.rows)))
    return plots


def spectrum_name(name: str) -> str:
    """The name of the files of a scene's spectra, from that of its plot."""
    return f"{name}-spectrum"


def _numbered(stem: str) -> Iterator[str]:
    yield stem
    yield from (f"{stem}-{i}" for i in range(2, 1_000_000))


def plot_csv(plot: Plot) -> str:
    """The data of a plot, one row a point, in the order of the table; empty where unknown."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    shown = _shown(plot.curves)
    front = {id(curve) for curve in _front(shown)}
    for curve in plot.curves:
        rmse = curve.metrics.get("rmse", Estimate(None))
        figures = [curve.cpu_seconds.value, curve.cpu_seconds.standard_error, rmse.value, rmse.standard_error]
        writer.writerow(
            [curve.renderer, curve.mode, curve.label, curve.family, number(curve.samples_per_pixel)]
            + [number(figure) for figure in [*figures, efficiency(curve)]]
            + [int(id(curve) in front), "; ".join(curve.missing)]
        )
    return out.getvalue()


def plot_svg(plot: Plot, palette: Mapping[str, str]) -> str:
    """The plot as SVG, 6.4 by 4.2 inches, log-log; points without a positive RMSE and time are in the CSV alone."""
    shown = _shown(plot.curves)

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        _set_limits(axes, shown)
        _draw(axes, shown, palette)
        axes.set_title(plot.title, loc="left", fontsize=9, fontweight="bold")
        axes.set_xlabel("CPU seconds a picture")
        axes.set_ylabel("RMSE against the reference")
        if shown:
            figure.legend(loc="outside right upper", fontsize=6.5)

    return svg_of(draw, (6.4, 4.2))


def svg_of(draw: Callable[[Figure], None], inches: tuple[float, float]) -> str:
    """What is drawn into a figure, as SVG in the style of all of them; the same drawing gives the same text."""
    with rc_context(_STYLE), warnings.catch_warnings():
        # A name in a script that matplotlib's font lacks is drawn as boxes; the CSV has it.
        warnings.filterwarnings("ignore", message="Glyph")
        figure = Figure(figsize=inches, layout="constrained")
        draw(figure)
        settle(figure)
        out = io.StringIO()
        FigureCanvasSVG(figure).print_svg(out, metadata={"Date": None, "Creator": "aliascope"})
    return out.getvalue()


def settle(figure: Figure) -> None:
    """Takes the layout as it is, rounded: its solver's last digits differ from run to run, and an SVG would show it."""
    engine = figure.get_layout_engine()
    assert engine is not None  # `svg_of` gave it one
    engine.execute(figure)
    figure.set_layout_engine("none")
    for axes in figure.axes:
        axes.set_position(np.round(axes.get_position(original=True).bounds, 6).tolist())


def _coordinates(curve: Curve) -> tuple[float, float] | None:
    seconds, rmse = curve.cpu_seconds.value, curve.metrics.get("rmse", Estimate(None)).value
    if seconds is None or rmse is None or not (usable(seconds) and usable(rmse)) or seconds <= 0.0 or rmse <= 0.0:
        return None
    return seconds, rmse


def _shown(curves: Sequence[Curve]) -> list[Curve]:
    return [curve for curve in curves if _coordinates(curve) is not None]


def _front(shown: Sequence[Curve]) -> list[Curve]:
    """The Pareto front among the curves that lack no scene."""
    whole = [curve for curve in shown if not curve.missing]
    return [whole[i] for i in pareto_front([_coordinates(curve) or (0.0, 0.0) for curve in whole])]


def _set_limits(axes: Axes, shown: Sequence[Curve]) -> None:
    """Around the points and their bars, half a decade at least: matplotlib has no limits for a single value."""
    if not shown:
        return
    x, y = zip(*(_coordinates(curve) or (1.0, 1.0) for curve in shown), strict=True)
    axes.set_xlim(limits(x, [curve.cpu_seconds.standard_error for curve in shown]))
    axes.set_ylim(limits(y, [curve.metrics["rmse"].standard_error for curve in shown]))


def limits(values: Sequence[float], errors: Sequence[float | None]) -> tuple[float, float]:
    """The ends of a logarithmic axis for positive values and their bars."""
    spreads = [number(error) or 0.0 for error in errors]
    low = math.log10(min(v - e if e < v else v for v, e in zip(values, spreads, strict=True)))
    high = math.log10(max(v + e for v, e in zip(values, spreads, strict=True)))
    room = max(0.06 * (high - low), (0.5 - (high - low)) / 2.0)
    return 10.0 ** (low - room), 10.0 ** (high + room)


def _draw(axes: Axes, shown: Sequence[Curve], palette: Mapping[str, str]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(power_of_ten)
        axis.set_minor_formatter(lambda value, position: "")
    axes.grid(which="major", linewidth=0.3, color="#dddddd")
    front = [_coordinates(curve) or (0.0, 0.0) for curve in _front(shown)]
    if front:
        axes.step(*zip(*front, strict=True), where="post", color="#999999", linewidth=2.5, alpha=0.5, zorder=1)
        axes.lines[-1].set_label("Pareto front")
    families: dict[tuple[str, str], list[Curve]] = {}
    for curve in shown:
        families.setdefault((curve.renderer, curve.family), []).append(curve)
    count: dict[str, int] = {}
    for (renderer, family), members in families.items():
        marker = MARKERS[count.setdefault(renderer, 0) % len(MARKERS)]
        count[renderer] += 1
        _draw_family(axes, members, palette.get(renderer, "#666666"), marker)
        _label(axes.lines[-1], family if family.startswith(renderer) else f"{renderer} {family}")


def _draw_family(axes: Axes, members: Sequence[Curve], colour: str, marker: str) -> None:
    members = sorted(members, key=lambda curve: curve.samples_per_pixel)
    points = [_coordinates(curve) or (0.0, 0.0) for curve in members]
    x, y = [list(values) for values in zip(*points, strict=True)]
    x_error = [number(curve.cpu_seconds.standard_error) or 0.0 for curve in members]
    y_error = [number(curve.metrics["rmse"].standard_error) or 0.0 for curve in members]
    # A bar may not reach 0 on a logarithmic axis.
    lower = [[min(e, 0.999 * v) for v, e in zip(v_, e_, strict=True)] for v_, e_ in ((x, x_error), (y, y_error))]
    axes.errorbar(
        x, y, xerr=[lower[0], x_error], yerr=[lower[1], y_error], fmt="none", ecolor=colour, elinewidth=0.6, zorder=2
    )
    axes.plot(x, y, color=colour, marker=marker, markersize=3.5, linewidth=0.8, markeredgewidth=0.0, zorder=3)


def _label(line: Line2D, text: str) -> None:
    # matplotlib leaves labels that begin with "_" out of the legend
    line.set_label(text if not text.startswith("_") else f" {text}")


def power_of_ten(value: float, position: float) -> str:
    """The text of a tick of a logarithmic axis."""
    return f"{value:.0e}" if value < 1e-4 or value >= 1e5 else f"{value:g}"
