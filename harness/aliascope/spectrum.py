"""Pictures seen as signals: how much of an error lies at which frequency."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import CheckFailed, InvalidInput


class RadialSpectrum(NamedTuple):
    """A spectrum by distance from frequency 0, over rings that have at least one frequency. Each array has (rings,).

    `frequencies`: the mean frequency of a ring, in cycles per pixel, rising from 0 to at most sqrt(1/2): the corners of
    the square of frequencies lie past 1/2, the Nyquist frequency of the axes. `power`: the mean power density of a
    ring, in squared values; white noise of variance s^2 has s^2 everywhere. `bins`: how many frequencies a ring has, so
    sum(bins * power) / sum(bins) is the variance. A real picture's frequencies come in equal pairs and the window joins
    neighbours: under noise, equal in all channels, the standard error of `power` is about 2 power / sqrt(bins).
    """

    frequencies: NDArray[np.float64]
    power: NDArray[np.float64]
    bins: NDArray[np.int64]


def radial_spectrum(error: NDArray[Any]) -> RadialSpectrum:
    """The power of an error picture by frequency, averaged over directions.

    error: (height, width), or (height, width, channels), of which the power is the channels' mean; real. Raises
    InvalidInput for another shape, CheckFailed where a value is no number. Rings are 1 / min(height, width) cycles per
    pixel wide, the first around 0 half as wide.

    The periodogram under a Hann window w(x, y) = sin^2(pi (x + 1/2) / width) sin^2(pi (y + 1/2) / height), Welch 1967,
    "The use of fast Fourier transform for the estimation of power spectra":

        P(f) = |sum of w(x, y) (e(x, y) - m) exp(-2 pi i f.(x, y))|^2 / sum of w^2

    with the weighted mean m = sum(w e) / sum(w), which the metric `bias` tells: a constant has no power. By Parseval
    the mean of P over all frequencies is sum(w^2 (e - m)^2) / sum(w^2), the variance under the squared window, and
    white noise of variance s^2 has E P = s^2, but less in the first two rings, out of which m takes its part. A wave of
    amplitude a has a mean P of a^2 / 2, nearly all of it within two frequencies of its own and of their mirror image.
    """
    if error.ndim not in (2, 3) or 0 in error.shape:
        raise InvalidInput(
            f"a spectrum needs an array of (height, width) or (height, width, channels), not {error.shape}"
        )
    if not np.isfinite(error).all():
        raise CheckFailed("the error has values that are no numbers: it has no spectrum")
    values = np.asarray(error, dtype=np.float64).reshape(*error.shape[:2], -1)
    height, width, _ = values.shape
    window = np.outer(_hann(height), _hann(width))[:, :, np.newaxis]
    mean = (window * values).sum(axis=(0, 1)) / window.sum()
    transformed = np.fft.fft2(window * (values - mean), axes=(0, 1))
    power = (np.abs(transformed) ** 2).mean(axis=2) / (window**2).sum()

    radius = np.hypot(np.fft.fftfreq(height)[:, np.newaxis], np.fft.fftfreq(width)[np.newaxis, :])
    ring = np.rint(radius * min(height, width)).astype(np.int64).ravel()
    bins = np.bincount(ring)
    there = bins > 0
    counts = bins[there]
    return RadialSpectrum(
        frequencies=np.bincount(ring, weights=radius.ravel())[there] / counts,
        power=np.bincount(ring, weights=power.ravel())[there] / counts,
        bins=counts,
    )


def _hann(count: int) -> NDArray[np.float64]:
    """Sampled at pixel centres: no pixel weighs 0, and a side of one pixel weighs 1."""
    return np.sin(np.pi * (np.arange(count) + 0.5) / count) ** 2
