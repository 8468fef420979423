"""The picture of `aliascope uneven`: what each sample stands for, the error of edges, what the multi-stage filter lets
through."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from aliascope.native import filters, uneven
from aliascope.studies.point_pictures import GRID, SOFT, STYLE

if TYPE_CHECKING:
    from aliascope.studies.uneven import Outcome

COLOURS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
SIDE = 480
"""Pixels of a picture of cells."""
MOST_TIMES = 16.0
"""The range of the colours: from a 16th of the plain average's weight to 16 times it."""
HIGHEST = 2.0
"""Cycles a pixel."""


def figure(outcomes: Sequence[Outcome], title: str) -> Figure:
    """One panel a method, under them the errors and the frequency responses."""
    with rc_context(STYLE):
        columns = max(len(outcomes), 2)
        made = Figure(figsize=(max(2.35 * columns, 7.4), 5.6), layout="constrained")
        made.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=10)
        upper, lower = made.subfigures(2, 1, squeeze=False, height_ratios=(1.0, 1.1))[:, 0]
        panels = upper.subplots(1, columns, squeeze=False)[0]
        for axes, one in zip(panels, outcomes, strict=False):
            _draw_cells(axes, one)
        for axes in panels[len(outcomes) :]:
            axes.set_axis_off()
        bar = upper.colorbar(
            ScalarMappable(LogNorm(1.0 / MOST_TIMES, MOST_TIMES), "PuOr_r"),
            ax=panels.tolist(),
            ticks=[1 / 16, 1 / 4, 1, 4, 16],
            format=lambda value, _: f"{value:g}" if value >= 1.0 else f"1/{1 / value:g}",
            pad=0.01,
            aspect=24,
        )
        bar.set_label("weight, plain average = 1")
        bar.minorticks_off()
        errors, responses = lower.subplots(1, 2)
        _draw_errors(errors, outcomes)
        _draw_responses(responses)
    return made


def _draw_cells(axes: Axes, one: Outcome) -> None:
    """The nearest sample's weight times the number of samples, over the filter's support, and the pixel in it."""
    from scipy.spatial import cKDTree

    radius = float(one.positions[-1])
    at = radius * ((np.arange(SIDE) + 0.5) / SIDE * 2.0 - 1.0)
    nearest = cKDTree(one.samples).query(np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2))[1]
    # Below the range, and where the filter is negative: the last colour.
    times = np.clip(one.weights * len(one.weights), 1.0 / MOST_TIMES, MOST_TIMES)
    axes.imshow(
        times[nearest].reshape(SIDE, SIDE),
        origin="lower",
        extent=(-radius, radius, -radius, radius),
        cmap="PuOr_r",
        norm=LogNorm(1.0 / MOST_TIMES, MOST_TIMES),
        interpolation="nearest",
    )
    size = min(max(400.0 / len(one.samples), 0.3), 9.0)
    axes.scatter(one.samples[:, 0], one.samples[:, 1], s=size, color="black", linewidths=0, clip_on=False, zorder=3)
    if radius > 0.5:
        axes.add_patch(Rectangle((-0.5, -0.5), 1, 1, fill=False, linewidth=0.8, linestyle=(0, (3, 2))))
    axes.set(xlim=(-radius, radius), ylim=(-radius, radius), aspect="equal")
    ticks = [-radius, 0.0, radius]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.tick_params(length=2, labelsize=7)
    axes.set_title(one.method, loc="left", fontweight="bold", pad=14)
    axes.annotate(
        f"filter {one.filter}", (0, 1), (0, 4), xycoords="axes fraction", textcoords="offset points", color=SOFT
    )


def _draw_errors(axes: Axes, outcomes: Sequence[Outcome]) -> None:
    """The mean error by the edge's position, with a standard deviation of the realisations to either side."""
    for colour, one in zip(_cycled(len(outcomes)), outcomes, strict=True):
        low, high = one.mean - one.deviation, one.mean + one.deviation
        axes.fill_between(one.positions, low, high, color=colour, alpha=0.15, linewidth=0)
        axes.plot(one.positions, one.mean, color=colour, linewidth=1.2, label=one.method)
    axes.axhline(0.0, color=SOFT, linewidth=0.6, zorder=0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_xlabel("where the edge is, pixels from the centre")
    axes.set_title("error of a filtered edge from 0 to 1", loc="left", fontweight="bold")
    axes.legend(frameon=False, fontsize=7)


def _cycled(count: int) -> list[str]:
    return [COLOURS[i % len(COLOURS)] for i in range(count)]


def stages_response(frequencies: NDArray[np.float64], side: int = 144) -> NDArray[np.float64]:
    """What the weighting multi-stage lets through along x, of side x side evenly spread samples."""
    radius = filters.radius("multi-stage")
    x = radius * ((np.arange(side) + 0.5) / side * 2.0 - 1.0)
    weights = uneven.weights(np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2), "multi-stage")
    profile = weights.reshape(side, side).sum(axis=0)
    return np.asarray(np.cos(2.0 * np.pi * np.outer(frequencies, x)) @ profile)


def _draw_responses(axes: Axes) -> None:
    """Of the two readings of the multi-stage filter, and of the box."""
    frequencies = np.linspace(0.0, HIGHEST, 401)
    lines: list[tuple[str, str, dict[str, Any]]] = [
        ("multi-stage", "boxes of 1, 1/2, 1/2, 1/4 pixel", {"color": COLOURS[2], "linewidth": 1.4}),
        ("multi-stage:radius=4.5", "boxes of 1, 2, 2, 4 pixels", {"color": COLOURS[4], "linewidth": 1.2}),
        ("box", "box of 1 pixel", {"color": SOFT, "linewidth": 0.8, "linestyle": (0, (4, 2))}),
    ]
    for spec, label, look in lines:
        axes.plot(frequencies, filters.response(spec, frequencies), label=label, **look)
    dots = np.linspace(0.0, HIGHEST, 33)
    axes.plot(dots, stages_response(dots), ".", color=COLOURS[2], markersize=4, label="the weights of even samples")
    axes.axvline(0.5, color=GRID, linewidth=0.8, zorder=0)
    axes.axhline(0.0, color=SOFT, linewidth=0.6, zorder=0)
    small: dict[str, Any] = {"textcoords": "offset points", "color": SOFT, "fontsize": 6.5}
    axes.annotate("a picture holds\nwhat is below", (0.5, -0.16), (-3, 0), ha="right", va="center", **small)
    axes.set_xlim(0.0, HIGHEST)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_xlabel("frequency, cycles a pixel")
    axes.set_title("amplitude left by the multi-stage filter", loc="left", fontweight="bold")
    axes.legend(frameon=False, fontsize=7)
