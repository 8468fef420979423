"""Where the command `aliascope points` has its points from: a sampler, or a file."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput
from aliascope.native.samplers import Sampler
from aliascope.point_sets.arrays import checked

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

    @property
    def randomised(self) -> bool:
        return self.sampler.randomised

    @property
    def document(self) -> dict[str, Any]:
        """The beginning of what --json prints."""
        return {"sampler": self.name, "n": self.n, "d": self.d, "seed": self.seed}

    def chunks(self, weights: bool) -> Iterator[Array]:
        """All rows, (up to 65536, d), or d + 1 with the weight of each point as the last column."""
        for begin in range(self.first, self.first + self.n, _CHUNK):
            count = min(_CHUNK, self.first + self.n - begin)
            values = self.sampler.points(count, begin, self.pixel)
            yield np.column_stack([values, self.sampler.weights(count, begin)]) if weights else values

    def realisation(self, index: int) -> Array:
        """(n, d); index 0 has the seed that was asked for, and the next ones those after it."""
        seed = (self.seed + index) % 2**64
        sampler = Sampler(self.name, self.n, self.d, seed) if index else self.sampler
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
    """A file has a slash or a suffix; else it is the spec of a sampler."""
    return "/" in name or ("." in name and ":" not in name)


def open_source(name: str, n: int | None, d: int | None, seed: int, pixel: tuple[int, int], first: int) -> PointSource:
    """A sampler's spec, for which n must be given and d is 2 if not; or a file, which has a slash or a suffix.

    Of a file: rows [first, first + n), to the end if n is not given, and the first d columns, or all. Raises the
    sampler's errors; InvalidInput for a file that cannot be read or has fewer rows or columns.
    """
    if is_file(name):
        values = read_points(Path(name))
        rows, columns = values.shape
        if first + (n or 1) > rows or (d or 1) > columns:
            raise InvalidInput(f"{name}: has {rows} points of {columns} dimensions, fewer than asked for")
        return StoredPoints(name, values[first : None if n is None else first + n, :d])
    if n is None:
        raise InvalidInput("-n is missing: how many points of the sampler")
    sampler = Sampler(name, n, d or 2, seed)
    return SampledPoints(sampler.spec, n, d or 2, seed, pixel, first, sampler)


def read_points(path: Path) -> Array:
    """Points (n, d) of a .csv file, no header, or a .npy file. Raises InvalidInput."""
    ending = path.suffix.lower()
    if ending not in (".csv", ".npy"):
        raise InvalidInput(f"{path}: points are read from .csv or .npy files")
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="loadtxt: input contained no data")
            values = np.load(path) if ending == ".npy" else np.loadtxt(path, delimiter=",", ndmin=2)
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read: {error.strerror or error}") from error
    except (ValueError, EOFError) as error:
        raise InvalidInput(f"{path}: is no table of numbers: {error}") from error
    try:
        return checked(values)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None
