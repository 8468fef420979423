"""How far a picture is from its reference. Over all pixels and channels, peak 1."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import CheckFailed, InvalidInput, near_misses
from aliascope.records import Pixels

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measured:
    """A metric's value: None where it has none (the PSNR of equal pictures), with the reason in `details`."""

    value: float | None
    details: Mapping[str, Any] = field(default_factory=dict)


Metric = Callable[[Array, Array], Measured]


def bias(image: Array, reference: Array) -> Measured:
    """The mean signed error, image - reference."""
    return Measured(float((image - reference).mean()))


def mae(image: Array, reference: Array) -> Measured:
    """The mean absolute error."""
    return Measured(float(np.abs(image - reference).mean()))


def mse(image: Array, reference: Array) -> float:
    return float(((image - reference) ** 2).mean())


def rmse(image: Array, reference: Array) -> Measured:
    """The root of the mean squared error."""
    return Measured(math.sqrt(mse(image, reference)))


def psnr(image: Array, reference: Array) -> Measured:
    """10 log10(1 / MSE), in decibels; none for equal pictures."""
    error = mse(image, reference)
    if error == 0.0:
        return Measured(None, {"psnr-reason": "the pictures are equal"})
    return Measured(-10.0 * math.log10(error))


def largest(image: Array, reference: Array) -> Measured:
    """The largest absolute error, and where: x, y, channel."""
    error = np.abs(image - reference)
    y, x, channel = (int(i) for i in np.unravel_index(int(error.argmax()), error.shape))
    return Measured(float(error[y, x, channel]), {"max-at": [x, y, channel]})


def relative_mse(image: Array, reference: Array) -> Measured:
    """The mean of (a - r)^2 / (r^2 + 0.01)."""
    return Measured(float(((image - reference) ** 2 / (reference**2 + 0.01)).mean()))


METRICS: Mapping[str, Metric] = {
    "bias": bias,
    "mae": mae,
    "rmse": rmse,
    "psnr": psnr,
    "relative-mse": relative_mse,
    "max": largest,
}


def chosen(text: str | None) -> list[str]:
    """The metrics named in "rmse,max"; all of them for None. Raises InvalidInput."""
    wanted = [name.strip() for name in text.split(",")] if text else list(METRICS)
    for name in wanted:
        if name not in METRICS:
            raise InvalidInput(f'unknown metric "{name}"{near_misses(name, METRICS)}')
    return wanted


def measure(image: Pixels, reference: Pixels, wanted: list[str] | None = None) -> dict[str, Measured]:
    """The metrics of a picture, by name.

    image, reference: (height, width, channels). Raises InvalidInput where their sizes or channels differ, CheckFailed
    where either has a NaN or an infinity: how many, and where the first is.
    """
    if image.shape != reference.shape:
        raise InvalidInput(f"the picture has {_size(image)}, the reference {_size(reference)}: they can't be compared")
    check_finite(image, "the picture")
    check_finite(reference, "the reference")
    a, r = image.astype(np.float64), reference.astype(np.float64)
    return {name: METRICS[name](a, r) for name in wanted or METRICS}


def check_finite(image: Pixels, what: str) -> None:
    """Raises CheckFailed where a picture has values that are no numbers."""
    broken = ~np.isfinite(image)
    if broken.any():
        y, x, channel = (int(i) for i in np.argwhere(broken)[0])
        nans = int(np.isnan(image).sum())
        raise CheckFailed(
            f"{what} has {nans} NaN and {int(broken.sum()) - nans} infinite values, "
            f"the first at x={x}, y={y}, channel {channel}"
        )


def _size(image: Pixels) -> str:
    height, width, channels = image.shape
    return f"{width} x {height} pixels of {channels} channels"
