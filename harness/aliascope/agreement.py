"""Whether a converged reference agrees with an independent estimate of the same picture: statistics, no more.

`studies/agree_judge.py` compares renderers with parts of it.

With d the difference of the two and v the sum of their variances, the squares of their standard errors, d / sqrt(v)
has Student's distribution, nearly, with Welch's degrees of freedom (Welch 1947). Three families share SIGNIFICANCE,
each divided by how many tests it has (Bonferroni): every value; the mean over every block of 8 x 8 pixels and channel;
the mean over the picture of each channel. Pixels are independent under the box filter; under another they share
samples, which makes the variance of a block `correlation` times larger. So a sound file is called wrong in less than 1
run in 1000, as far as means of many samples are normal.

A detail that fills a thousandth of a pixel can be met by no sample of the check, which then knows of no scatter. The
stored file does: samples that meet something by chance have a variance that is inverse to their number, and the check
is granted at least the stored variance times that ratio.

The fourth test is of the standard errors: the mean of d^2 / v over pixels is that of Student's distribution,
n / (n - 2); more than SLACK above it (and five of its own standard errors) says that they are too small. It finds
what is spread over all pixels and stays below each one's limit.

What is found 99 times in 100: one value that is off by (t + 2.6) sqrt(v), t the limit of the first family, 7 to 9 here;
and a picture that is off as a whole by (t + 2.6) sqrt(mean v / pixels), some 1e-6 at 128 x 96, so that a gain of 0.1 %
is far beyond it. What is less is found by the digest in the file alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from aliascope.geometry import Array

SIGNIFICANCE = 1e-3
BLOCK = 8
SLACK = 0.1


@dataclass(frozen=True)
class Estimate:
    """Mean and standard error of the mean, (height, width, 3) float64, of `replicates` pictures, which have `samples`
    a pixel in all."""

    mean: Array
    standard_error: Array
    replicates: int
    samples: int


@dataclass(frozen=True)
class Agreement:
    """`reason` is empty where the two agree. The value whose difference is the largest share of its limit: `place`
    (row, column, channel), with its `difference` and `tolerance`."""

    reason: str
    place: tuple[int, int, int]
    difference: float
    tolerance: float
    mean_square: float
    """The mean of d^2 / v, over what Student's distribution has: near 1."""


def correlation(pictures: Array) -> float:
    """How much more the means over blocks scatter than if pixels were independent, 1 or more: from replicates,
    (R, height, width, 3)."""
    together = blocks(pictures).var(axis=0, ddof=1).sum()
    apart = blocks(pictures.var(axis=0, ddof=1), squared=True).sum()
    return max(1.0, float(together / apart)) if apart > 0.0 else 1.0


def agreement(stored: Estimate, again: Estimate, rounding: float, factor: float = 1.0) -> Agreement:
    """Compares a stored reference with another estimate of the same.

    rounding: what float32 does to a value; factor: the `correlation` of pixels. A NaN never agrees.
    """
    one = stored.standard_error**2
    other = np.maximum(again.standard_error**2, one * (stored.samples / again.samples))
    variance = one + other
    freedom = welch(one, other, stored.replicates - 1, again.replicates - 1)
    difference = stored.mean - again.mean
    limit = student.isf(SIGNIFICANCE / 3 / 2 / difference.size, freedom) * np.sqrt(variance) + rounding
    share = np.where(np.isnan(difference), np.inf, np.abs(difference) / limit)
    row, column, channel = (int(i) for i in np.unravel_index(int(np.argmax(share)), share.shape))
    worst = float(difference[row, column, channel])
    scattered = variance > (4 * rounding) ** 2
    mean_square, excess = _mean_square(difference, variance, freedom, scattered)
    reason = ""
    if not bool((np.abs(difference) <= limit).all()):
        most = float(limit[row, column, channel])
        reason = f"pixel ({column}, {row}) channel {channel} differs by {worst:.3g}, at most {most:.3g}"
    else:
        # A block may owe its variance to one value of one of the two: no fewer degrees of freedom than that has.
        least = min(stored.replicates, again.replicates) - 1
        reason = _means(difference, variance * factor, least, rounding)
    if not reason and excess > 0.0:
        reason = f"its standard errors are too small: the differences' squares are {mean_square:.3g} of what they say"
    return Agreement(reason, (row, column, channel), abs(worst), float(limit[row, column, channel]), mean_square)


def welch(one: Array, other: Array, freedom: Array | float, others: Array | float) -> Array:
    """Degrees of freedom of the sum of two estimated variances (Welch 1947), from those of each; infinity for one that
    is known."""
    # In the power of two above the larger: without rounding, and no square is beyond a double.
    exponent = -np.frexp(np.maximum(one, other))[1]
    one, other = np.ldexp(one, exponent), np.ldexp(other, exponent)
    below = one**2 / freedom + other**2 / others
    least = np.minimum(freedom, others)
    found: Array = np.where(below > 0.0, (one + other) ** 2 / np.where(below > 0.0, below, 1.0), least)
    return found


def blocks(pictures: Array, squared: bool = False) -> Array:
    """The means (..., rows, columns, 3) over blocks of BLOCK x BLOCK pixels, those at the border smaller; `squared`: of
    variances, whose sum is over the square of the count."""
    sums, count = pictures, np.ones((1, 1, 1))
    for axis in (-3, -2):
        starts = np.arange(0, pictures.shape[axis], BLOCK)
        sums = np.add.reduceat(sums, starts, axis=axis)
        many = np.diff([*starts.tolist(), pictures.shape[axis]])
        count = count * (many[:, np.newaxis, np.newaxis] if axis == -3 else many[:, np.newaxis])
    means: Array = sums / (count**2 if squared else count)
    return means


def _means(difference: Array, variance: Array, freedom: int, rounding: float) -> str:
    """What is wrong with the means over blocks and over the picture, if anything."""
    means = np.abs(blocks(difference))
    spread = np.sqrt(blocks(variance, squared=True))
    limit = student.isf(SIGNIFICANCE / 3 / 2 / means.size, freedom) * spread + rounding
    if not bool((means <= limit).all()):
        row, column, channel = (int(i) for i in np.unravel_index(int(np.argmax(means / limit)), means.shape))
        return (
            f"the block of pixels from ({column * BLOCK}, {row * BLOCK}) channel {channel} differs by "
            f"{means[row, column, channel]:.3g} in the mean, at most {limit[row, column, channel]:.3g}"
        )
    whole = np.abs(difference.mean(axis=(0, 1)))
    most = student.isf(SIGNIFICANCE / 3 / 2 / whole.size, freedom) * np.sqrt(variance.sum(axis=(0, 1)))
    most = most / (variance.size / whole.size) + rounding
    if not bool((whole <= most).all()):
        channel = int(np.argmax(whole / most))
        return f"channel {channel} of the whole picture differs by {whole[channel]:.3g}, at most {most[channel]:.3g}"
    return ""


def _mean_square(
    difference: Array, variance: Array, freedom: Array, scattered: NDArray[np.bool_]
) -> tuple[float, float]:
    """The mean of d^2 / v over that of Student's distribution, and by how much it is beyond its limit."""
    safe = np.where(scattered, variance, 1.0)
    square = np.where(scattered, difference**2 / safe * (freedom - 2.0) / freedom, 0.0).sum(axis=2)
    channels = scattered.sum(axis=2)
    used = channels > 0
    if int(used.sum()) < 2:
        return 1.0, 0.0
    # One number a pixel: its channels are not independent.
    each = square[used] / channels[used]
    mean, spread = float(each.mean()), float(each.std(ddof=1)) / float(np.sqrt(used.sum()))
    return mean, mean - 1.0 - SLACK - 5.0 * spread
