"""Figures for a paper: the spectra of a scene's errors, and the filters' frequency responses, as SVG."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aliascope.records import Estimate, ModeRow
from aliascope.report.filters import FREQUENCIES, HIGHEST, NYQUIST, Response
from aliascope.report.plots import power_of_ten, svg_of
from aliascope.report.pool import usable
from aliascope.report.spectra import SceneSpectra

MOST_LINES = 6
DASHES = ("-", (0, (4, 1.5)), (0, (1, 1.5)), (0, (4, 1.5, 1, 1.5)))
MOST_DECADES = 8


@dataclass(frozen=True)
class Line:
    """One spectrum of the figure: the row that it is of, its powers and how much structure its error has."""

    row: ModeRow
    powers: tuple[float, ...]
    structure: float | None


def telling(spectra: SceneSpectra, rows: Sequence[ModeRow]) -> list[Line]:
    """The spectra that the figure shows, by renderer, and within it by rising structure.

    One a family, at a like count for all: the one whose samples a pixel are nearest to the median of the scene's rows.
    Where that makes more than MOST_LINES, of each renderer only the families with the least and the most structure.
    """
    known = [
        Line(row, powers, _structure(row))
        for row, powers in zip(rows, spectra.rows, strict=True)
        if not isinstance(powers, str) and any(powers)
    ]
    counts = sorted(_log_count(line) for line in known)
    families: dict[tuple[str, str], list[Line]] = {}
    for line in known:
        families.setdefault((line.row.renderer, line.row.family), []).append(line)
    renderers: dict[str, list[Line]] = {}
    for (renderer, _), lines in families.items():
        median = counts[(len(counts) - 1) // 2]
        nearest = min(lines, key=lambda line: abs(_log_count(line) - median))
        renderers.setdefault(renderer, []).append(nearest)
    for renderer, lines in renderers.items():
        lines.sort(key=lambda line: (line.structure is None, line.structure))
        if len(families) > MOST_LINES and len(lines) > 2:
            measured = [line for line in lines if line.structure is not None] or lines
            renderers[renderer] = [measured[0], measured[-1]]
    return [line for lines in renderers.values() for line in lines]


def _log_count(line: Line) -> float:
    return math.log(max(line.row.samples_per_pixel, 1e-3))


def _structure(row: ModeRow) -> float | None:
    value = row.metrics.get("structure", Estimate(None)).value
    return value if usable(value) else None


def spectrum_svg(title: str, spectra: SceneSpectra, rows: Sequence[ModeRow], palette: Mapping[str, str]) -> str:
    """Power density against cycles per pixel, the power logarithmic; 6.4 by 4.2 inches."""
    lines = telling(spectra, rows)
    seen: dict[str, int] = {}

    def draw(figure: Figure) -> None:
        axes = figure.add_subplot()
        axes.set_yscale("log")
        axes.grid(which="major", linewidth=0.3, color="#dddddd")
        axes.axvline(NYQUIST, color="#999999", linewidth=0.8, linestyle="--", zorder=1)
        for line in lines:
            renderer = line.row.renderer
            dashes = DASHES[seen.setdefault(renderer, 0) % len(DASHES)]
            seen[renderer] += 1
            axes.plot(
                spectra.frequencies,
                [power or math.nan for power in line.powers],
                color=palette.get(renderer, "#666666"),
                linestyle=dashes,
                linewidth=1.1,
                label=_label(line),
            )
        _limits(axes, lines)
        axes.set_title(title, loc="left", fontsize=9, fontweight="bold")
        axes.set_xlabel("cycles per pixel (dashed: Nyquist)")
        axes.set_ylabel("power density of the error")
        if lines:
            figure.legend(loc="outside lower left", fontsize=6.5)

    return svg_of(draw, (6.4, 4.2))


def _label(line: Line) -> str:
    structure = "" if line.structure is None else f": structure {line.structure:.2g}"
    return f" {line.row.renderer} {line.row.label}{structure}"  # matplotlib leaves out labels that begin with "_"


def _limits(axes: Axes, lines: Sequence[Line]) -> None:
    axes.set_xlim(0.0, math.sqrt(0.5))
    axes.yaxis.set_major_formatter(power_of_ten)
    axes.yaxis.set_minor_formatter(lambda value, position: "")
    powers = [power for line in lines for power in line.powers if power > 0.0]
    if powers:
        high = max(powers)
        axes.set_ylim(max(min(powers), high * 10.0**-MOST_DECADES) / 2.0, high * 2.0)


def filters_svg(responses: Sequence[Response]) -> str:
    """One small plot a filter, the others faint behind it; what lies beyond the Nyquist frequency is shaded."""
    columns = 4
    lines = max(1, -(-len(responses) // columns))

    def draw(figure: Figure) -> None:
        first: Axes | None = None
        for i, response in enumerate(responses):
            axes = figure.add_subplot(lines, columns, i + 1, sharex=first, sharey=first)
            first = first or axes
            axes.axvspan(NYQUIST, HIGHEST, color="#f0f0ec", linewidth=0.0, zorder=0)
            axes.axvline(NYQUIST, color="#999999", linewidth=0.8, linestyle="--", zorder=1)
            axes.axhline(0.0, color="#cccccc", linewidth=0.5, zorder=1)
            for other in responses:
                axes.plot(FREQUENCIES, other.amplitude, color="#cccccc", linewidth=0.5, zorder=1)
            axes.plot(FREQUENCIES, response.amplitude, color="#16181b", linewidth=1.3, zorder=2)
            axes.set_title(f"{response.name}, radius {response.radius:g}", loc="left", fontsize=8)
            axes.set_xlim(0.0, HIGHEST)
            axes.set_ylim(-0.3, 1.1)
            axes.set_xticks([0.0, 0.5, 1.0, 1.5, 2.0], ["0", ".5", "1", "1.5", "2"])
        figure.supxlabel("cycles per pixel (dashed: Nyquist)", fontsize=8)
        figure.supylabel("amplitude", fontsize=8)

    return svg_of(draw, (6.4, 1.6 * lines + 0.3))
