"""Rows of comparisons that never were: made from chosen times and errors, or drawn about true ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from aliascope.records import Estimate, ModeRow, SceneSection
from aliascope.statistics import root_mean_square

PIXELS = np.zeros((1, 1, 3), np.float32)


def row(
    family: str,
    count: int,
    seconds: Sequence[float],
    rmse: Sequence[float],
    renderer: str = "embree",
    settings: Mapping[str, str] | None = None,
    mode: str = "",
    reference: float = 0.0,
    deterministic: bool = False,
) -> ModeRow:
    """A mode with these timed runs and these draws of RMSE. `reference` is the standard error that its error has of
    the reference."""
    error = root_mean_square(rmse)
    if reference:
        error = Estimate(error.value, math.hypot(error.standard_error or 0.0, reference))
    return ModeRow(
        renderer=renderer,
        mode=mode or f"{family.replace(' ', ':sampler=')}:n={count}",
        label=f"{family}, n={count}",
        family=family,
        samples_per_pixel=float(count),
        cpu_seconds=Estimate(float(np.median(seconds))),
        metrics={"rmse": error},
        pictures=len(rmse),
        pixels=PIXELS,
        seconds=tuple(seconds),
        draws={"rmse": tuple(rmse)},
        deterministic=deterministic,
        settings=settings if settings is not None else {"n": str(count)},
    )


def section(name: str, rows: Sequence[ModeRow], filter_: str = "box") -> SceneSection:
    return SceneSection(name, name, "", PIXELS, "exact", tuple(rows), filter=filter_)


def drawn(
    random: np.random.Generator,
    family: str,
    count: int,
    seconds: float,
    rmse: float,
    draws: int = 3,
    renderer: str = "embree",
) -> ModeRow:
    """A mode of this true time and error. MSE scatters by some 8 %, as a sum of squares does, times by some 3 %; the
    modes themselves differ in how much, by a factor of 1.5 and of 1.35 (one standard deviation)."""
    spread = 0.08 * math.exp(0.4 * random.standard_normal())
    squares = rmse**2 * random.gamma(spread**-2.0, spread**2.0, draws)
    noise = 0.03 * math.exp(0.3 * random.standard_normal())
    times = seconds * np.exp(noise * random.standard_normal(draws))
    return row(family, count, times.tolist(), np.sqrt(squares).tolist(), renderer)
