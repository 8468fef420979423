"""The lecture's Delta(x, y) = n(x, y)/N - xy over the square as a picture, its extreme marked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput, NotWritable, Unsupported
from aliascope.native.discrepancy import measure

SIDE = 512


def delta(points: NDArray[np.float64], side: int) -> NDArray[np.float64]:
    """Delta at the centres of side x side cells, (row, column) = (y, x), y upward."""
    at = (np.arange(side) + 0.5) / side
    # A point counts at all centres right of and above it.
    first = np.searchsorted(at, points, side="right")
    counts = np.zeros((side + 1, side + 1))
    np.add.at(counts, (first[:, 1], first[:, 0]), 1.0)
    counts = counts.cumsum(axis=0).cumsum(axis=1)[:side, :side]
    return counts / len(points) - at[:, None] * at[None, :]


def draw(path: Path, points: NDArray[np.float64], title: str) -> None:
    """Writes the picture of points (n, 2) as .svg or .png. Raises InvalidInput, Unsupported, NotWritable."""
    if path.suffix.lower() not in (".svg", ".png"):
        raise InvalidInput(f'{path}: the picture is written as .svg or .png, not "{path.suffix}"')
    if points.shape[1] != 2:
        raise Unsupported(f"Delta(x, y) is of two dimensions; these points have {points.shape[1]}")
    import matplotlib
    from matplotlib.figure import Figure

    star = measure("star", points)
    values = delta(points, SIDE)
    most = float(np.abs(values).max())
    figure = Figure(figsize=(6.2, 5.4), layout="constrained")
    axes = figure.add_subplot()
    shown = axes.imshow(
        values, origin="lower", extent=(0, 1, 0, 1), cmap="PuOr_r", vmin=-most, vmax=most, interpolation="nearest"
    )
    if len(points) <= 4096:
        axes.scatter(
            points[:, 0], points[:, 1], s=max(min(12.0, 3000.0 / len(points)), 0.5), color="black", linewidths=0
        )
    x, y = star.witness
    axes.plot([x, x, 0], [0, y, y], color="#009E73", linewidth=1.5, clip_on=False)
    axes.plot([x], [y], marker="o", color="#009E73", markersize=6, clip_on=False, zorder=5)
    axes.set(xlim=(0, 1), ylim=(0, 1), aspect="equal", xticks=(0, 0.5, 1), yticks=(0, 0.5, 1), xlabel="x", ylabel="y")
    axes.set_title(f"{title}, {len(points)} points\nstar discrepancy {star.value:.4g}", loc="left", fontsize="medium")
    figure.colorbar(shown, ax=axes, shrink=0.85, label="n(x, y)/N - xy")
    matplotlib.rcParams["svg.hashsalt"] = "aliascope"
    try:
        figure.savefig(path, dpi=160, metadata={"Date": None} if path.suffix.lower() == ".svg" else None)
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error
