"""`aliascope points -o FILE`: points as a table or a drawing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput, NotWritable, Unsupported


def write_points(path: Path, values: NDArray[np.float64], title: str) -> None:
    """Writes (n, columns) as .csv or .npy, or draws the first two dimensions as .svg or .png."""
    ending = path.suffix.lower()
    try:
        if ending == ".csv":
            np.savetxt(path, values, fmt="%.17g", delimiter=",")
        elif ending == ".npy":
            np.save(path, values)
        elif ending in (".svg", ".png"):
            _draw(path, values, title)
        else:
            raise InvalidInput(f'{path}: points are written as .csv, .npy, .svg or .png, not "{ending}"')
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error


def _draw(path: Path, values: NDArray[np.float64], title: str) -> None:
    if values.shape[1] < 2:
        raise Unsupported("a drawing of points needs two dimensions")
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 5.3), layout="constrained")
    axes = figure.add_subplot()
    # Dots cover about a sixteenth of the square, and are never too small to see.
    axes.scatter(values[:, 0], values[:, 1], s=max(1500.0 / len(values), 0.4), color="#0072B2", linewidths=0)
    axes.set(xlim=(0, 1), ylim=(0, 1), aspect="equal", xticks=(0, 0.5, 1), yticks=(0, 0.5, 1))
    axes.set_title(f"{title}, {len(values)} points", loc="left", fontsize="medium")
    figure.savefig(path, dpi=160)
