"""Where the commands `points` and `discrepancy` have their points from: a sampler, or a file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput
from aliascope.native.samplers import Sampler
from aliascope.studies.point_files import STANDARD_INPUT, read_points

Array = NDArray[np.float64]
_CHUNK = 1 << 16


@dataclass(frozen=True)
class SampledPoints:
    """Points [first, first + n) of one pixel of a sampler; another realisation is another seed."""

    name: str
    n: int
    d: int
    seed: int
    pixel: tuple[int, int]
    first: int
    sampler: Sampler
    groups: tuple[int, ...] | None = None
    arrangement: str = "joint"

    @property
    def randomised(self) -> bool:
        return self.sampler.randomised

    @property
    def document(self) -> dict[str, Any]:
        """The beginning of what --json prints."""
        whole = {"sampler": self.name, "n": self.n, "d": self.d, "seed": self.seed}
        return whole if self.groups is None else {**whole, "groups": self.groups, "arrangement": self.arrangement}

    def chunks(self, weights: bool) -> Iterator[Array]:
        """All rows, (up to 65536, d), or d + 1 with the weight of each point as the last column."""
        for begin in range(self.first, self.first + self.n, _CHUNK):
            count = min(_CHUNK, self.first + self.n - begin)
            values = self.sampler.points(count, begin, self.pixel)
            yield np.column_stack([values, self.sampler.weights(count, begin)]) if weights else values

    def realisation(self, index: int) -> Array:
        """(n, d); index 0 has the seed that was asked for, and the next ones those after it."""
        seed = (self.seed + index) % 2**64
        groups = self.groups or self.d
        sampler = Sampler(self.name, self.n, groups, seed, self.arrangement) if index else self.sampler
        return sampler.points(self.n, self.first, self.pixel)


@dataclass(frozen=True)
class StoredPoints:
    """Points of a file."""

    name: str
    values: Array
    randomised = False

    @property
    def n(self) -> int:
        return len(self.values)

    @property
    def d(self) -> int:
        return int(self.values.shape[1])

    @property
    def document(self) -> dict[str, Any]:
        """The beginning of what --json prints."""
        return {"file": self.name, "n": self.n, "d": self.d}

    def chunks(self, weights: bool) -> Iterator[Array]:
        """All rows, (n, d). Raises InvalidInput where weights are asked for."""
        if weights:
            raise InvalidInput("--weights are a sampler's; a file has none")
        yield self.values

    def realisation(self, index: int) -> Array:
        """(n, d), whatever the index."""
        return self.values


PointSource = SampledPoints | StoredPoints


def is_file(name: str) -> bool:
    """Whether this is a file's name and no spec: it has a slash or a suffix, or is "-"."""
    return name == STANDARD_INPUT or "/" in name or ("." in name and ":" not in name)


def open_source(
    name: str,
    n: int | None,
    d: int | None,
    seed: int,
    pixel: tuple[int, int],
    first: int,
    groups: tuple[int, ...] | None = None,
    arrangement: str = "joint",
) -> PointSource:
    """A sampler's spec, for which n must be given and d is 2 if not, or `groups`, so arranged, say all; or a file,
    which has a slash or a suffix, or is "-", standard input.

    Of a file: rows [first, first + n), to the end if n is not given, and the first d columns, or all. Raises the
    sampler's errors; InvalidInput for a file that cannot be read or has fewer rows or columns.
    """
    if is_file(name):
        if groups is not None:
            raise InvalidInput("--groups are of a sampler's dimensions; the points of a file are as they are")
        values = read_points(name)
        rows, columns = values.shape
        if first + (n or 1) > rows or (d or 1) > columns:
            raise InvalidInput(f"{name}: has {rows} points of {columns} dimensions, fewer than asked for")
        return StoredPoints(name, values[first : None if n is None else first + n, :d])
    if n is None:
        raise InvalidInput("-n is missing: how many points of the sampler")
    if groups is not None and d not in (None, sum(groups)):
        raise InvalidInput(f"-d {d}: the groups have {sum(groups)} dimensions")
    dimensions = sum(groups) if groups else d or 2
    sampler = Sampler(name, n, groups or dimensions, seed, arrangement)
    return SampledPoints(sampler.spec, n, dimensions, seed, pixel, first, sampler, groups, arrangement)
