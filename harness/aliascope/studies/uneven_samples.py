"""The samples that `aliascope uneven` filters: crowded ones of a sampler, or a file's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput, Unsupported
from aliascope.native import samplers
from aliascope.studies.point_files import read_points
from aliascope.studies.point_source import is_file

Array = NDArray[np.float64]
N = 64
CROWD = 0.75


@dataclass(frozen=True)
class CrowdedSamples:
    """n samples of a pixel, of which the share `crowd` lies in its left half, as an adaptive sampler leaves them that
    met an edge there. The others are spread, so thinly, over the pixel, and around it as far as a filter reaches."""

    name: str
    n: int
    crowd: float
    seed: int

    @property
    def title(self) -> str:
        """Such as "sobol, 64 samples a pixel, 75 % of them in its left half"."""
        return f"{self.name}, {self.n} samples a pixel" + f", {100 * self.crowd:g} % in its left half" * (
            self.crowd > 0
        )

    @property
    def _crowded(self) -> int:
        return round(self.crowd * self.n)

    @property
    def randomised(self) -> bool:
        return samplers.randomised(self.name, 1)

    def realisation(self, index: int, radius: float) -> Array:
        """(samples, 2) in pixels from the pixel's centre, over [-radius, radius) either way."""
        even = self._part(self._thin(radius), f"spread over {2.0 * radius:g} x {2.0 * radius:g} pixels", index)
        crowd = self._part(self._crowded, "in the left half of one", 2**32 + index)
        return np.concatenate([radius * (2.0 * even - 1.0), (crowd - (1.0, 0.5)) * (0.5, 1.0)])

    def count(self, radius: float) -> int:
        """How many a realisation has."""
        return self._crowded + self._thin(radius)

    def _thin(self, radius: float) -> int:
        return round((self.n - self._crowded) * (2.0 * radius) ** 2)

    def _part(self, count: int, where: str, seed: int) -> Array:
        if count == 0:
            return np.empty((0, 2))
        try:
            return samplers.points(self.name, count, seed=(self.seed + seed) % 2**64)
        except Unsupported as error:
            raise Unsupported(f"{error} (-n and --crowd make {count} samples, {where})") from None


@dataclass(frozen=True)
class StoredSamples:
    """Those of a file, [0, 1) being the whole support of the filter."""

    name: str
    points: Array
    crowd = 0.0
    randomised = False

    @property
    def n(self) -> int:
        return len(self.points)

    @property
    def title(self) -> str:
        return f"{self.name}, {self.n} samples"

    def count(self, radius: float) -> int:
        """How many there are, whatever the radius."""
        return self.n

    def realisation(self, index: int, radius: float) -> Array:
        """(n, 2) in pixels from the pixel's centre, whatever the index."""
        return radius * (2.0 * self.points - 1.0)


def open_samples(source: str, n: int | None, crowd: float | None, seed: int) -> CrowdedSamples | StoredSamples:
    """None: not said. Raises the sampler's errors; InvalidInput for a file that cannot be read, or n or crowd of it."""
    if crowd is not None and not 0.0 <= crowd <= 1.0:
        raise InvalidInput(f"--crowd {crowd:g} is no share of the samples: 0 to 1")
    if not is_file(source):
        count = N if n is None else n
        return CrowdedSamples(samplers.canonical(source), count, CROWD if crowd is None else crowd, seed)
    points = read_points(source)
    if n is not None or crowd is not None:
        raise InvalidInput(
            f"-n and --crowd are a sampler's; the samples of {source} are as many and lie where they lie"
        )
    if points.shape[1] != 2:
        raise Unsupported(f"{source}: samples have two columns, x and y, not {points.shape[1]}")
    return StoredSamples(source, points)
