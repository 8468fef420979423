"""Structured aliasing told from noise.

Independent samples in each pixel leave errors that know nothing of each other: white noise, which the eye forgives. The
same pattern of samples in every pixel leaves errors that repeat: moiré, staircases, Cook's "aliases" (Cook 1986,
"Stochastic sampling in computer graphics"). At equal RMSE the two differ in their *local* spectra, flat or peaked: the
moiré of a zone plate runs through all frequencies, so its spectrum over the whole picture has no peaks.

By the theorem of Wiener and Khinchin a spectrum is flat where the autocovariance is 0 at each lag but 0, so that is
what is measured, in blocks of 8 x 8 pixels. e(p) is the error at pixel p (its channels make it a vector), q_t(p) =
e(p) . e(p + t) the product of a pair of pixels that lie t apart:

    ratio = sum over lags t and blocks B of (sum over p in B of q_t(p))^2  /  sum over t and p of q_t(p)^2

Where errors are independent with mean 0, E q_t(p) q_t(p') = 0 for two different pairs of one lag, so the two sums have
the same expectation, whatever the errors' distribution, and however they change over the picture: no need of stationary
or normal noise. By Cauchy and Schwarz the ratio is at most 64, the pixels of a block, so

    structure = (ratio - 1) / (64 - 1)

is 0 for such noise, at most 1, and at least -1/63. An error that is the same everywhere has 1 (but for the pairs that
the blocks at the border lack), a plane wave cos(k.p) has about 1/2: its products are (cos(k.t) + cos(k.(2p + t))) /
2, of which the second term adds nothing to a block's sum and half of the squares. It is quadratic: where the share s of
the error's power is structured and the rest is noise, it is about s^2 of what the structure alone has.

Were the sign of each error tossed, the signs of a lag's products would be independent, and the square of a block's sum
would have the variance 2 ((sum of q_t^2)^2 - sum of q_t^4). The root of their total, over 63 sum of q_t^2, is told as
the standard deviation under noise: 0.0005 for 128 x 96 pixels of normal noise, more for fewer pixels with an error. It
is a little low (10% for normal noise, 15% on a line): the squares of two lags go together where two pairs of theirs
make a parallelogram.

Samples that neighbouring pixels share, under a filter wider than a pixel, make noise that neighbours share: it has some
structure too (0.03 where each value is the mean of two neighbours' noise), far from that of moiré.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from aliascope.metrics.base import Array, Measured, no_value

BLOCK = 8
"""Pixels of a block's side: a zone plate's frequency changes little over so few."""

REACH = 2
"""The farthest lag along an axis, in pixels: the local spectrum is seen in 5 x 5 frequencies."""


def structure(image: Array, reference: Array) -> Measured:
    """How much neighbouring errors go together: 0 for noise, about 1/2 for moiré, at most 1; none for equal pictures.

    Detail `structure-noise`: the standard deviation that pure noise of these sizes would give it; a value of more than
    four of them is no noise. A bias counts as structure: the errors of neighbours agree.
    """
    error = image - reference
    largest = np.abs(error).max()
    if largest == 0.0:
        return no_value("structure", "the pictures are equal")
    error /= largest  # so that fourth powers neither overflow nor vanish
    of_blocks = of_pairs = spread = 0.0
    for products in _pairs(error):
        squares = products**2
        block_squares = _block_sums(squares)
        of_blocks += float((_block_sums(products) ** 2).sum())
        of_pairs += float(block_squares.sum())
        spread += float((block_squares**2).sum() - (squares**2).sum())
    if of_pairs == 0.0:
        return no_value("structure", f"no two pixels within {REACH} of each other have an error")
    free = BLOCK * BLOCK - 1
    noise = math.sqrt(2.0 * max(spread, 0.0)) / of_pairs / free
    return Measured((of_blocks / of_pairs - 1.0) / free, {"structure-noise": noise})


def _pairs(error: Array) -> Iterator[NDArray[np.float64]]:
    """The products of the pixels that lie a lag apart, for each lag of a half plane: the other half has the same."""
    height, width, _ = error.shape
    for dy in range(min(REACH + 1, height)):
        for dx in range(-REACH if dy else 1, REACH + 1):
            if abs(dx) < width:
                here = error[: height - dy, max(0, -dx) : width - max(0, dx)]
                there = error[dy:, max(0, dx) : width + min(0, dx)]
                yield np.einsum("yxc,yxc->yx", here, there)


def _block_sums(values: NDArray[np.float64]) -> NDArray[np.float64]:
    rows = np.add.reduceat(values, np.arange(0, values.shape[0], BLOCK), axis=0)
    return np.add.reduceat(rows, np.arange(0, values.shape[1], BLOCK), axis=1)
