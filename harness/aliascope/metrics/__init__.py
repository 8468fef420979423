"""How far a picture is from its reference. Over all pixels and channels, peak 1."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from aliascope.errors import InvalidInput, near_misses
from aliascope.metrics.base import Measured, Metric
from aliascope.metrics.differences import bias, largest, mae, p99, psnr, relative_mse, rmse
from aliascope.metrics.local_structure import structure
from aliascope.metrics.perceptual import flip, ssim
from aliascope.records import MetricInfo, Pixels

__all__ = ["ABOUT", "METRICS", "Measured", "Metric", "check_finite", "chosen", "measure"]

_ALL: Mapping[str, tuple[Metric, MetricInfo]] = {
    "bias": (bias, MetricInfo("bias", "zero")),
    "mae": (mae, MetricInfo("mean |error|", "less")),
    "rmse": (rmse, MetricInfo("RMSE", "less")),
    "psnr": (psnr, MetricInfo("PSNR", "more", unit="dB")),
    "relative-mse": (relative_mse, MetricInfo("relative MSE", "less")),
    "max": (largest, MetricInfo("largest |error|", "less")),
    "p99": (p99, MetricInfo("99th percentile of |error|", "less")),
    "ssim": (ssim, MetricInfo("SSIM", "more", best=1.0)),
    "flip": (flip, MetricInfo("FLIP", "less")),
    "structure": (
        structure,
        MetricInfo("structure", "less", signed=True, axis="structure of the error (0: noise)"),
    ),
}
METRICS: Mapping[str, Metric] = {name: metric for name, (metric, _) in _ALL.items()}
ABOUT: Mapping[str, MetricInfo] = {name: about for name, (_, about) in _ALL.items()}
"""What a report says of each, and which values are better."""


def chosen(text: str | None) -> list[str]:
    """The metrics named in "rmse,max"; all of them for None. Raises InvalidInput."""
    wanted = [name.strip() for name in text.split(",")] if text else list(METRICS)
    for name in wanted:
        if name not in METRICS:
            raise InvalidInput(f'unknown metric "{name}"{near_misses(name, METRICS)}')
    return wanted


def measure(
    image: Pixels,
    reference: Pixels,
    wanted: list[str] | None = None,
    names: tuple[str, str] = ("the picture", "the reference"),
) -> dict[str, Measured]:
    """The metrics of a picture, by name.

    image, reference: (height, width, channels); names: what errors call them. Raises InvalidInput where their sizes or
    channels differ, and where either has a NaN or an infinity: how many, and where the first is.
    """
    if image.shape != reference.shape:
        raise InvalidInput(f"the picture has {_size(image)}, the reference {_size(reference)}: they can't be compared")
    for pixels, name in zip((image, reference), names, strict=True):
        check_finite(pixels, name)
    a, r = image.astype(np.float64), reference.astype(np.float64)
    return {name: METRICS[name](a, r) for name in wanted or METRICS}


def check_finite(image: Pixels, what: str) -> None:
    """Raises InvalidInput where a picture has values that are no numbers."""
    broken = ~np.isfinite(image)
    if broken.any():
        y, x, channel = (int(i) for i in np.argwhere(broken)[0])
        nans = int(np.isnan(image).sum())
        raise InvalidInput(
            f"{what} has {nans} NaN and {int(broken.sum()) - nans} infinite values, "
            f"the first at x={x}, y={y}, channel {channel}"
        )


def _size(image: Pixels) -> str:
    height, width, channels = image.shape
    return f"{width} x {height} pixels of {channels} channels"
