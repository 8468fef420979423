"""The power spectrum of points, its radial average, and its anisotropy."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput, Unsupported
from aliascope.point_sets.arrays import Points, checked

LARGEST_CUT_OFF = 2048
_WIDTH = 14
"""Cells of the grid that a point is spread over, in each dimension: for 12 digits at twofold oversampling."""
_BETA = math.pi * _WIDTH * 0.75
"""Of the Kaiser-Bessel window: pi w (1 - 1 / (2 * oversampling)), beyond which its transform would not fall."""
_ROUNDING = 1e-12
"""Bound of the error of a sum of n phases, as a share of n; the test has its measured value, 1e-13."""


class PointSpectrum(NamedTuple):
    """The power spectrum of points in the unit square, averaged over realisations, up to a cut-off K.

    `power`: (2K + 1, 2K + 1), that of frequency (x, y), in cycles over the square's side, at [K + y, K + x]; 0 for
    frequency 0, whose n says nothing. Independent uniform points have 1 everywhere in the mean. `frequencies`: (K,), 1
    to K, the rings; ring r has the frequencies at a distance from r - 1/2 to r + 1/2 from 0. `radial_power`: (K,), the
    mean of a ring. `standard_error`: (K,), that of `radial_power` from realisation to realisation; None for one.
    `anisotropy`: (K,), in dB: 10 log10 of the variance of `power` in a ring over the square of its mean. Where power
    does not depend on direction it is -10 log10(realisations) in the mean, what chance leaves of it (Ulichney 1988);
    nan where a ring has no power, or no variance, beyond rounding.
    """

    power: NDArray[np.float64]
    frequencies: NDArray[np.int64]
    radial_power: NDArray[np.float64]
    standard_error: NDArray[np.float64] | None
    anisotropy: NDArray[np.float64]
    realisations: int
    n: int


def default_cut_off(n: int) -> int:
    """Four times sqrt(n), around which evenly spread points have their first peak, and 16 or more.

    Past 512 it grows no further until that is twice sqrt(n), and ends at 1024: the time goes with its square.
    """
    return min(max(16, min(math.ceil(4.0 * math.sqrt(n)), 512), math.ceil(2.0 * math.sqrt(n))), 1024)


def point_spectrum(realisations: Iterable[Any], cut_off: int | None = None) -> PointSpectrum:
    """The spectrum of point sets, each (n, 2) with the same n: the periodogram

        P(k) = |sum over points of exp(-2 pi i k.x)|^2 / n,   k integer, -K <= k_x, k_y <= K

    averaged over the sets, which Bartlett 1964, "The spectral analysis of two-dimensional point processes", defines;
    radial average and anisotropy as in Ulichney 1988, "Dithering with blue noise", equations 6 to 8, over one of each
    two frequencies k and -k, as they have the same power. The sums of phases come from a fast Fourier transform of the
    points on a finer grid and are good to 1e-12 n; a P below 1e-24 n, which is
    rounding, is 0.

    cut_off: K, 1 to 2048; see `default_cut_off`. Time: n + K^2 log K for each set. Raises InvalidInput; Unsupported
    where d is not 2.
    """
    sets = (_planar(points) for points in realisations)
    first = next(sets, None)
    if first is None:
        raise InvalidInput("a spectrum needs one realisation or more")
    n = len(first)
    cut_off = default_cut_off(n) if cut_off is None else cut_off
    if not 1 <= cut_off <= LARGEST_CUT_OFF:
        raise InvalidInput(f"the cut-off of a spectrum is 1 to {LARGEST_CUT_OFF}, not {cut_off}")
    ring, bins = _rings(cut_off)
    total = np.zeros((cut_off + 1, 2 * cut_off + 1))
    each = []
    for points in itertools.chain([first], sets):
        if len(points) != n:
            raise InvalidInput(f"the realisations of a spectrum have as many points each, not {n} and {len(points)}")
        power = np.abs(_phases(points, cut_off)) ** 2 / n
        power[power < _ROUNDING**2 * n] = 0.0
        total += power
        each.append(_by_ring(power, ring) / bins)
    return _averaged(total / len(each), ring, bins, np.array(each), n)


def _planar(points: Any) -> Points:
    values = checked(points)
    if values.shape[1] != 2:
        raise Unsupported(f"a spectrum is that of two dimensions, not {values.shape[1]}")
    return values


def _averaged(
    power: NDArray[np.float64],
    ring: NDArray[np.int64],
    bins: NDArray[np.int64],
    each: NDArray[np.float64],
    n: int,
) -> PointSpectrum:
    """power: (K + 1, 2K + 1), the upper half of the mean periodogram; each: (realisations, K) means of rings."""
    radial = _by_ring(power, ring) / bins
    around = np.concatenate([[0.0], radial, [0.0]])  # ring 0 and what lies past ring K
    variance = _by_ring((power - around[ring]) ** 2, ring) / (bins - 1)
    # A sum of phases S = sqrt(n P) that is wrong by e makes P wrong by 2 sqrt(P / n) e.
    real = variance > (4.0 * _ROUNDING) ** 2 * n * radial
    anisotropy = np.full_like(radial, np.nan)
    anisotropy[real] = 10.0 * np.log10(variance[real] / radial[real] ** 2)
    count = len(each)
    error = each.std(axis=0, ddof=1) / math.sqrt(count) if count > 1 else None
    whole = np.concatenate([power[:0:-1, ::-1], power])
    cut_off = len(radial)
    whole[cut_off, cut_off] = 0.0
    return PointSpectrum(whole, np.arange(1, cut_off + 1), radial, error, anisotropy, count, n)


def _rings(cut_off: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The ring of each frequency of the upper half, (K + 1, 2K + 1), and how many each ring from 1 to K has.

    Ring 0: frequency 0 and the mirror images of others on its row; ring K + 1: all past K.
    """
    y, x = np.mgrid[0 : cut_off + 1, -cut_off : cut_off + 1]
    ring = np.minimum(np.rint(np.hypot(x, y)), cut_off + 1).astype(np.int64)
    ring[0, : cut_off + 1] = 0
    return ring, np.bincount(ring.ravel(), minlength=cut_off + 2)[1 : cut_off + 1]


def _by_ring(values: NDArray[np.float64], ring: NDArray[np.int64]) -> NDArray[np.float64]:
    """Sums over the rings 1 to K."""
    sums = np.bincount(ring.ravel(), weights=values.ravel(), minlength=len(values) + 1)
    return np.asarray(sums[1 : len(values)], dtype=np.float64)


def _phases(points: Points, cut_off: int) -> NDArray[np.complex128]:
    """The sum of exp(-2 pi i (k_x x + k_y y)) at [k_y, K + k_x], k_y from 0: (K + 1, 2K + 1).

    By gridding (Jackson et al. 1991, "Selection of a convolution function for Fourier inversion using gridding"): each
    point is a Kaiser-Bessel window on a grid of twice the frequencies, whose transform is known and divided out.
    """
    import scipy.fft  # takes a while to load, and most commands measure no points
    import scipy.special

    side = scipy.fft.next_fast_len(max(2 * (2 * cut_off + 1), 2 * _WIDTH), real=True)
    grid = np.zeros(side * side)
    offsets = np.arange(_WIDTH)
    for begin in range(0, len(points), 4096):
        place = points[begin : begin + 4096] * side
        corner = np.ceil(place - _WIDTH / 2)
        cells = corner[:, :, np.newaxis] + offsets
        inside = np.maximum(1.0 - ((cells - place[:, :, np.newaxis]) * (2.0 / _WIDTH)) ** 2, 0.0)
        weight = scipy.special.i0(_BETA * np.sqrt(inside))
        cell = cells.astype(np.int64) % side
        index = cell[:, 1, :, np.newaxis] * side + cell[:, 0, np.newaxis, :]
        np.add.at(grid, index.ravel(), (weight[:, 1, :, np.newaxis] * weight[:, 0, np.newaxis, :]).ravel())
    transformed = scipy.fft.fft2(grid.reshape(side, side))
    x, y = np.arange(-cut_off, cut_off + 1), np.arange(cut_off + 1)
    return transformed[y[:, np.newaxis], x] / (_window_transform(y, side)[:, np.newaxis] * _window_transform(x, side))


def _window_transform(frequency: NDArray[np.int64], side: int) -> NDArray[np.float64]:
    """The Fourier integral of I0(beta sqrt(1 - (2 x / w)^2)), |x| <= w / 2, at frequency / side."""
    root = np.sqrt(_BETA**2 - (np.pi * _WIDTH * frequency / side) ** 2)
    return _WIDTH * np.sinh(root) / root
