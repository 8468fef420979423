"""Metrics of the error's values, wherever they lie in the picture."""

from __future__ import annotations

import math

import numpy as np

from aliascope.metrics.base import Array, Measured, mean_difference, no_value


def bias(image: Array, reference: Array) -> Measured:
    """The mean signed error, image - reference."""
    return Measured(mean_difference(image, reference))


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
        return no_value("psnr", "the pictures are equal")
    return Measured(-10.0 * math.log10(error))


def relative_mse(image: Array, reference: Array) -> Measured:
    """The mean of (a - r)^2 / (r^2 + 0.01)."""
    return Measured(float(((image - reference) ** 2 / (reference**2 + 0.01)).mean()))


def largest(image: Array, reference: Array) -> Measured:
    """The largest absolute error, and where: x, y, channel."""
    error = np.abs(image - reference)
    y, x, channel = (int(i) for i in np.unravel_index(int(error.argmax()), error.shape))
    return Measured(float(error[y, x, channel]), {"max-at": [x, y, channel]})


def p99(image: Array, reference: Array) -> Measured:
    """The 99th percentile of the absolute error: all but a hundredth of the values are as close or closer.

    Between the two sorted values around 0.99 (n - 1), counted from 0, it goes linearly: definition 7 of Hyndman and Fan
    1996, "Sample quantiles in statistical packages", NumPy's own. n counts pixels times channels.
    """
    return Measured(float(np.percentile(np.abs(image - reference), 99.0, method="linear")))
