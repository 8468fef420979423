"""Pixels put together from what is seen of each surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aliascope.geometry import Array


@dataclass(frozen=True)
class Coverage:
    """The part of each pixel that a region covers, (height, width) in [0, 1], and the length (px) of its edges there.

    Edges that rounding moved by d pixels make an error of at most d times that length.
    """

    area: Array
    length: Array


class Canvas:
    """The sum, over all surfaces, of area times radiance; what is left of a pixel shows the background.

    `covered` and `length` are sums of all coverages, (height, width). A pixel that one surface covers has exactly its
    radiance.
    """

    def __init__(self, width: int, height: int) -> None:
        self._sum = np.zeros((height, width, 3))
        self.covered = np.zeros((height, width))
        self.length = np.zeros((height, width))
        self.brightest = 0.0
        self.surfaces = 0

    def add(self, part: Coverage, radiance: Array, brightest: float) -> None:
        """Adds what is seen of a surface: its radiance (3,), or (height, width, 3), is at most `brightest`."""
        self._sum += part.area[:, :, np.newaxis] * radiance
        self.covered += part.area
        self.length += part.length
        self.brightest = max(self.brightest, brightest)
        self.surfaces += 1

    def over(self, background: Array) -> Array:
        """The picture, (height, width, 3), on a background (3,)."""
        self.brightest = max(self.brightest, float(background.max()))
        picture: Array = self._sum + (1.0 - self.covered)[:, :, np.newaxis] * background
        return picture
