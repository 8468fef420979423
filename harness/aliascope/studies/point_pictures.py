"""Pictures of point sets and of their spectra. The same figures give the same file."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from aliascope.point_sets import PointSpectrum
from aliascope.report.plots import settle

INK, ACCENT, GRID, SOFT = "#0072B2", "#D55E00", "#d9d9d9", "#666666"
STYLE: dict[Any, Any] = {
    "text.parse_math": False,  # names are shown as they are, "$" included
    "font.family": ["sans-serif"],
    "font.size": 8,
    "svg.hashsalt": "aliascope",
    "axes.linewidth": 0.6,
    "axes.titlesize": 9,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
}
_MANY = 20_000
"""More dots than this are one picture in an SVG too, which would else have megabytes."""


def save(figure: Figure, path: Path) -> None:
    """Writes .svg or .png. Raises OSError."""
    with rc_context(STYLE), warnings.catch_warnings():
        # A name in a script that matplotlib's font lacks is drawn as boxes.
        warnings.filterwarnings("ignore", message="Glyph")
        settle(figure)
        kept = {"Date": None, "Creator": "aliascope"} if path.suffix.lower() == ".svg" else {"Software": "aliascope"}
        figure.savefig(path, dpi=160, metadata=kept)


def points_figure(values: NDArray[np.float64], title: str, dimensions: list[int], weighted: bool) -> Figure:
    """The first two columns of (n, columns) as dots in the unit square, over its n strata where n is a small square.

    Coloured by the last column if that is weights, else by a third if there is one.
    """
    n = len(values)
    with rc_context(STYLE):
        coloured = weighted or len(dimensions) > 2
        figure = Figure(figsize=(5.6 if coloured else 5.0, 5.2), layout="constrained")
        axes = figure.add_subplot()
        side = math.isqrt(n)
        if side * side == n and 2 <= side <= 16:
            for line in np.arange(1, side) / side:
                axes.axhline(line, color=GRID, linewidth=0.6, zorder=0)
                axes.axvline(line, color=GRID, linewidth=0.6, zorder=0)
        # Dots cover about a sixteenth of the square, from 8 points across down to what can still be seen.
        size = min(max(6000.0 / n, 0.4), 60.0)
        look: dict[str, Any] = {"s": size, "linewidths": 0, "rasterized": n > _MANY, "clip_on": n > _MANY}
        if coloured:
            column = values[:, -1 if weighted else 2]
            span = (0.0, float(column.max())) if weighted else (0.0, 1.0)
            dots = axes.scatter(
                values[:, 0], values[:, 1], c=column, cmap="viridis", vmin=span[0], vmax=span[1], **look
            )
            label = "weight" if weighted else f"dimension {dimensions[2]}"
            figure.colorbar(dots, ax=axes, label=label, shrink=0.8, pad=0.02, aspect=30)
        else:
            axes.scatter(values[:, 0], values[:, 1], color=INK, **look)
        axes.set(xlim=(0, 1), ylim=(0, 1), aspect="equal", xticks=(0, 0.5, 1), yticks=(0, 0.5, 1))
        axes.set_xlabel(f"dimension {dimensions[0]}")
        axes.set_ylabel(f"dimension {dimensions[1]}")
        _title(axes, title, f"{n} point{'s' * (n != 1)}")
    return figure


def spectrum_figure(spectrum: PointSpectrum, title: str, text: str, dimensions: list[int]) -> Figure:
    """The power in two dimensions, and under it its radial mean and its anisotropy."""
    with rc_context(STYLE):
        figure = Figure(figsize=(5.2, 8.0), layout="constrained")
        plane, radial, anisotropy = figure.subplots(3, 1, height_ratios=(4.6, 1.3, 1.3))
        _draw_plane(figure, plane, spectrum, dimensions)
        _title(plane, title, text)
        _draw_radial(radial, spectrum)
        _draw_anisotropy(anisotropy, spectrum)
    return figure


def _title(axes: Axes, title: str, text: str) -> None:
    """The name in bold, smaller where it is long, and a line under it."""
    size = min(9.0, 9.0 * 55 / max(len(title), 1))
    axes.set_title(title, loc="left", pad=16, fontweight="bold", fontsize=size)
    line = axes.annotate(text, (0, 1), (0, 4), xycoords="axes fraction", textcoords="offset points", color=SOFT)
    line.set_in_layout(False)  # else a long one takes its width from the axes


def _draw_plane(figure: Figure, axes: Axes, spectrum: PointSpectrum, dimensions: list[int]) -> None:
    edge = len(spectrum.frequencies) + 0.5
    extent = (-edge, edge, -edge, edge)
    image = axes.imshow(spectrum.power, cmap="gray", vmin=0.0, vmax=2.0, extent=extent, origin="lower")
    axes.set_xlabel(f"frequency in dimension {dimensions[0]}, cycles over the side")
    axes.set_ylabel(f"in dimension {dimensions[1]}")
    ticks = [0.0, 0.5, 1.0, 1.5, 2.0]
    figure.colorbar(image, ax=axes, label="power", extend="max", ticks=ticks, shrink=0.8, pad=0.02, aspect=30)


def _draw_radial(axes: Axes, spectrum: PointSpectrum) -> None:
    power, error = spectrum.radial_power, spectrum.standard_error
    _frequency_axis(axes, spectrum, 1.0, "independent\npoints")
    if error is not None:
        low, high = np.maximum(power - 2.0 * error, 0.0), power + 2.0 * error
        axes.fill_between(spectrum.frequencies, low, high, color=INK, alpha=0.25, linewidth=0)
    axes.plot(spectrum.frequencies, power, color=INK, linewidth=1.0)
    axes.set_ylim(0.0, max(2.0, 1.05 * float(power.max())))
    axes.set_ylabel("radial mean power")


def _draw_anisotropy(axes: Axes, spectrum: PointSpectrum) -> None:
    expected = -10.0 * math.log10(spectrum.realisations)
    _frequency_axis(axes, spectrum, expected, "no direction\npreferred")
    ratio = spectrum.anisotropy
    axes.plot(spectrum.frequencies, ratio, color=ACCENT, linewidth=1.0)
    there = np.concatenate([[False], ~np.isnan(ratio), [False]])
    alone = there[1:-1] & ~there[:-2] & ~there[2:]
    axes.plot(spectrum.frequencies[alone], ratio[alone], ".", color=ACCENT, markersize=4)
    seen = np.append(ratio[~np.isnan(ratio)], expected)
    axes.set_ylim(min(float(seen.min()), expected - 5.0) - 1.0, max(float(seen.max()), expected + 5.0) + 1.0)
    axes.set_ylabel("anisotropy, dB")
    axes.set_xlabel("distance from frequency 0, cycles over the side")


def _frequency_axis(axes: Axes, spectrum: PointSpectrum, level: float, text: str) -> None:
    """The axis of the rings, with a line where evenly spread points peak, and one at the level of no structure."""
    last, peak = len(spectrum.frequencies), math.sqrt(spectrum.n)
    axes.set_xlim(0, last + 0.5)
    axes.spines[["top", "right"]].set_visible(False)
    axes.axhline(level, color=SOFT, linewidth=0.6, linestyle=(0, (4, 3)))
    small: dict[str, Any] = {"textcoords": "offset points", "color": SOFT, "fontsize": 6.5}
    words = axes.annotate(text, (1, level), (4, 0), xycoords=("axes fraction", "data"), va="center", **small)
    words.set_in_layout(False)  # there is room, under the bar of colours
    if peak < last:
        axes.axvline(peak, color=GRID, linewidth=0.8, zorder=0)
        axes.annotate("√n", (peak, 1.0), (2, -1), xycoords=("data", "axes fraction"), va="top", **small)
