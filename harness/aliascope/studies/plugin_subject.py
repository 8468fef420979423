"""The sampler that `aliascope plugin check` looks at: which sizes it has, and its values, each call noted first."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aliascope.native.probing import Memory, Probe

# One of each line is tried, the first that the pattern has: squares, powers of two, cubes, primes and their squares,
# Fibonacci's numbers, and none of these.
COUNTS = (
    (1,),
    (2, 3, 4, 5),
    (7, 6, 8, 9, 11),
    (16, 17, 13, 25, 27, 21, 12),
    (64, 81, 55, 49, 100, 121, 47),
    (250, 256, 233, 243, 169, 343, 225),
    (1000, 1024, 987, 961, 900, 997),
)
DIMENSIONS = (1, 2, 3, 5, 8)
PIXELS = ((0, 0), (3, -4), (2**31 - 1, 2**31 - 1), (-(2**31), -(2**31)))


class Broken(Exception):
    """A contract that does not hold: the reason, in one line."""


class NothingToCheck(Exception):
    """A contract that asks nothing of this sampler: why, in one line."""


@dataclass(frozen=True)
class Finding:
    """What a check that held has looked at, and a digest of the bits that another process must get as well."""

    text: str
    digest: str = ""


@dataclass
class Subject:
    """`note` is told what comes next, so that a crash can be said to have come from it."""

    spec: str
    note: Callable[[str], None]
    memory: Memory = field(default_factory=lambda: Memory(1 << 17))

    def probe(self, samples: int, dimensions: int, seed: int = 0) -> Probe:
        self.note(f"in create for N = {samples}, D = {dimensions}")
        return Probe(self.spec, samples, dimensions, seed)

    def made(self, samples: int, dimensions: int, seed: int = 0) -> Probe:
        """A sampler of a size that is there. Raises Broken."""
        probe = self.probe(samples, dimensions, seed)
        if not probe.made:
            raise Broken(
                f"create for N = {samples}, D = {dimensions} gave {probe.status} with seed {seed}, and not before"
            )
        return probe

    def sizes(self) -> Iterator[tuple[int, int]]:
        """(N, D) that the sampler has. Raises NothingToCheck where it has none."""
        found = self._sizes
        if not found:
            raise NothingToCheck("the sampler has none of the counts and dimensions that are tried")
        yield from found

    @functools.cached_property
    def _sizes(self) -> list[tuple[int, int]]:
        found = []
        for dimensions in DIMENSIONS:
            for counts in COUNTS:
                first = next((n for n in counts if self.has(n, dimensions)), None)
                if first is not None:
                    found.append((first, dimensions))
        return found

    def has(self, samples: int, dimensions: int) -> bool:
        probe = self.probe(samples, dimensions)
        self.note(f"in destroy for N = {samples}, D = {dimensions}")
        probe.destroy()
        return probe.made

    def fill(
        self,
        probe: Probe,
        pixel: tuple[int, int],
        first: int,
        count: int,
        first_dimension: int = 0,
        dimension_count: int | None = None,
    ) -> NDArray[np.float64]:
        """(count, dimension_count). Values outside [0, 1) pass, other errors raise Broken."""
        columns = probe.dimensions - first_dimension if dimension_count is None else dimension_count
        buffer = self.memory.in_the_middle(count * columns)
        where = self.place(probe, pixel, first, count, first_dimension, columns)
        self.note(f"in fill of {where}")
        status = probe.fill(buffer, pixel, first, count, first_dimension, columns)
        if status not in ("ASC_OK", "ASC_OUT_OF_RANGE"):
            raise Broken(f"fill of {where} gave {status}")
        return buffer.values.reshape(count, columns)

    def weights(self, probe: Probe, first: int, count: int) -> NDArray[np.float64]:
        """(count,). Weights that are no numbers pass, other errors raise Broken."""
        buffer = self.memory.in_the_middle(count)
        where = f"N = {probe.samples}, samples {first} to {first + count - 1}"
        self.note(f"in weights of {where}")
        status = probe.weights(buffer, first, count)
        if status not in ("ASC_OK", "ASC_NUMERIC"):
            raise Broken(f"weights of {where} gave {status}")
        return buffer.values

    @staticmethod
    def place(
        probe: Probe, pixel: tuple[int, int], first: int, count: int, first_dimension: int, dimension_count: int
    ) -> str:
        """A range in words."""
        text = f"N = {probe.samples}, D = {probe.dimensions}, "
        text += f"sample {first}" if count == 1 else f"samples {first} to {first + count - 1}"
        if dimension_count != probe.dimensions:
            last = first_dimension + dimension_count - 1
            text += f", dimension{'' if dimension_count == 1 else 's'} {first_dimension}"
            text += "" if dimension_count == 1 else f" to {last}"
        return text + (f" of pixel {pixel[0]},{pixel[1]}" if pixel != (0, 0) else "")


def same(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Bit for bit."""
    return a.tobytes() == b.tobytes()
