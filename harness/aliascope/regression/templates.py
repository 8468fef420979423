"""What a picture's difference from its reference is looked for: a few patterns that defects of renderers leave.

With I the reference, D = picture - reference, and a pattern T ("template"): the coefficient of T in D is
sum(w T D) / sum(w T T), over pixels and channels, each template by itself: so much of T explains D best. Each is in a
unit for people: a gain in %, a shift in pixels. Coefficients are linear in D: the mean over replicates is that of the
mean picture, and what the templates have in common does not matter to a test that asks whether there is anything.

w = 1 / (m^2 + FLOOR), m the largest value of the reference within a pixel of there, in the channel: noise goes with
brightness, and one bright highlight would otherwise be all that is looked at.

Blocks look for what no template has: the mean of D over BLOCK x BLOCK pixels and channels, over the root of the mean of
m^2 + FLOOR there, so that a limit means the same in bright and dark.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from aliascope.geometry import Array

FLOOR = 0.1
"""The square of a value, below which noise no longer falls with brightness."""

BLOCK = 16
BLOCK_MARGIN = 1 / 2550

PER_CENT = 0.01

NOTHING = 1e-9
"""A template whose root mean square is less than this has no norm to divide by."""


@dataclass(frozen=True)
class Template:
    """`pattern` gives what one `unit` of it adds to a picture of this reference. `margin`: how much of it is no
    regression, in its unit: a tenth of the least that must be caught."""

    name: str
    unit: str
    margin: float
    pattern: Callable[[Array], Array]


def _around(picture: Array, right: int, down: int) -> Array:
    """What stands so many pixels to the right and down of each pixel; beyond the border it goes on as straight as it
    came, so that there is no edge at the border."""
    height, width = picture.shape[:2]
    padded = np.pad(picture, ((1, 1), (1, 1), (0, 0)), mode="reflect", reflect_type="odd")
    return padded[1 + down : 1 + down + height, 1 + right : 1 + right + width]


def _channel(number: int) -> Callable[[Array], Array]:
    def offset(reference: Array) -> Array:
        pattern = np.zeros_like(reference)
        pattern[..., number] = 1.0
        return pattern

    return offset


def _gain(reference: Array) -> Array:
    return PER_CENT * reference


def _right(reference: Array) -> Array:
    return (_around(reference, -1, 0) - _around(reference, 1, 0)) / 2


def _down(reference: Array) -> Array:
    return (_around(reference, 0, -1) - _around(reference, 0, 1)) / 2


def _wider(right: int, down: int) -> Callable[[Array], Array]:
    """A box of width 1 + e adds e I'' / 12: its variance is (1 + e)^2 / 12, of which half goes with I''."""

    def wider(reference: Array) -> Array:
        second = _around(reference, right, down) - 2 * reference + _around(reference, -right, -down)
        return PER_CENT * second / 12

    return wider


def _aslant(reference: Array) -> Array:
    """Samples whose x and y hang together, with correlation e, add e d2I/dxdy / 12."""
    mixed = (
        _around(reference, 1, 1) - _around(reference, 1, -1) - _around(reference, -1, 1) + _around(reference, -1, -1)
    )
    return PER_CENT * mixed / 4 / 12


TEMPLATES = (
    Template("offset of red", "", 1 / 2550, _channel(0)),
    Template("offset of green", "", 1 / 2550, _channel(1)),
    Template("offset of blue", "", 1 / 2550, _channel(2)),
    Template("gain", "%", 0.1, _gain),
    Template("moved right", "pixel", 1 / 320, _right),
    Template("moved down", "pixel", 1 / 320, _down),
    Template("wider across", "%", 1.0, _wider(1, 0)),
    Template("wider down", "%", 1.0, _wider(0, 1)),
    Template("aslant", "%", 1.0, _aslant),
)
BY_NAME = {template.name: template for template in TEMPLATES}


def moved(reference: Array, shift: tuple[float, float]) -> Array:
    """The reference moved by (right, down) pixels, linear between pixels, its border repeated. It only stands in for
    the picture that would be exact there: what it is off by is the same for all who are compared by it."""
    if shift == (0.0, 0.0):
        return reference
    found: Array = ndimage.shift(reference, (shift[1], shift[0], 0.0), order=1, mode="nearest")
    return found


class Basis:
    """The templates of one reference, and its blocks, ready to be found in differences from it.

    reference: (height, width, 3) float64, linear; `names`: of the templates to look for (`names_of`).
    """

    def __init__(self, reference: Array, names: Sequence[str]) -> None:
        self.reference = reference
        self.brightest = ndimage.maximum_filter(reference, (3, 3, 1), mode="nearest")
        weights = 1.0 / (self.brightest**2 + FLOOR)
        self._projections = []
        for name in names:
            pattern = BY_NAME[name].pattern(reference)
            weighted = weights * pattern
            norm = float((weighted * pattern).sum())
            self._projections.append(weighted / norm if norm > 0.0 else np.zeros_like(pattern))
        self._scales = np.sqrt(block_means(self.brightest**2) + FLOOR)

    def coefficients(self, difference: Array) -> tuple[float, ...]:
        """Of each template, how much of it there is in a difference, in its unit."""
        # No matrix product, whose rounding depends on how it is shared among threads.
        return tuple(float((each * difference).sum()) for each in self._projections)

    def known(self, standard_error: Array) -> tuple[float, ...]:
        """The standard errors of the coefficients where each value has its own, independent of the others'."""
        return tuple(float(np.sqrt(((each * standard_error) ** 2).sum())) for each in self._projections)

    def blocks(self, difference: Array) -> tuple[float, ...]:
        """The means of a difference over blocks, row by row, relative to their brightness."""
        return tuple((block_means(difference) / self._scales).ravel().tolist())

    def known_blocks(self, standard_error: Array) -> tuple[float, ...]:
        """The standard errors of the blocks where each value has its own."""
        spread = np.sqrt(block_means(standard_error**2) / _block_counts(standard_error.shape))
        return tuple((spread / self._scales).ravel().tolist())

    def floor_blocks(self, floor: Array, together: bool) -> tuple[float, ...]:
        """The least standard errors of the blocks from those of values, which all go up and down `together`, as their
        mean then does, or each by itself."""
        spread = block_means(floor) if together else np.sqrt(block_means(floor**2) / _block_counts(floor.shape))
        return tuple((spread / self._scales).ravel().tolist())


def names_of(reference: Array) -> tuple[str, ...]:
    """The templates that can be told in pictures of this reference: a picture of one colour shows no shift."""
    return tuple(
        template.name
        for template in TEMPLATES
        if float(np.sqrt((template.pattern(reference) ** 2).mean())) > NOTHING * (1.0 + float(np.abs(reference).max()))
    )


def block_means(values: Array) -> Array:
    """The means over blocks and channels: (rows, columns), those at the right and the bottom smaller."""
    rows, columns = (np.arange(0, side, BLOCK) for side in values.shape[:2])
    sums = np.add.reduceat(np.add.reduceat(values.sum(axis=2), rows, axis=0), columns, axis=1)
    means: Array = sums / _block_counts(values.shape)
    return means


def _block_counts(shape: tuple[int, ...]) -> Array:
    """Values in each block."""
    sides = [np.diff([*range(0, side, BLOCK), side]).astype(np.float64) for side in shape[:2]]
    return np.outer(*sides) * shape[2]


def block_place(number: int, size: tuple[int, int]) -> tuple[int, int]:
    """The first pixel (x, y) of a block of a picture of this (width, height)."""
    columns = -(-size[0] // BLOCK)
    return BLOCK * (number % columns), BLOCK * (number // columns)


class Surroundings:
    """What a value of a picture may be beside its reference: from the least to the largest of 5 x 5 pixels there."""

    def __init__(self, reference: Array) -> None:
        self._least = ndimage.minimum_filter(reference, (5, 5, 1), mode="nearest")
        self._largest = ndimage.maximum_filter(reference, (5, 5, 1), mode="nearest")
        self._scale = np.sqrt(self._largest**2 + FLOOR)

    def outlier(self, picture: Array) -> float:
        """How far the most outlying value lies beyond that, relative to the brightness there; NaN counts for nothing:
        such values are counted for themselves."""
        finite = np.where(np.isfinite(picture), picture, self._least)
        beyond = np.maximum(finite - self._largest, self._least - finite)
        return float((np.maximum(beyond, 0.0) / self._scale).max())
