"""Which numbers of points to try: one an octave, as many as the pattern can have."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

from aliascope.native import samplers


def counts(spec: str, d: int, least: int, most: int) -> list[int]:
    """Of each octave around a power of two, cut to [least, most], the number that a pattern has best.

    The power of two itself, on which nets are complete; else the nearest power k^m (grids), else the nearest Fibonacci
    number (lattices), else the nearest number at all. Empty where the pattern has none of them in d dimensions.
    """
    found = []
    for octave in range(math.floor(math.log2(least)), math.ceil(math.log2(most)) + 1):
        for n in _candidates(1 << octave):
            if least <= n <= most and samplers.refusal(spec, n, d) is None:
                found.append(n)
                break
    return found


def _candidates(middle: int) -> Iterator[int]:
    """Numbers of [middle / sqrt 2, middle sqrt 2), the best first."""
    low, high = middle / math.sqrt(2.0), middle * math.sqrt(2.0)

    def near(numbers: set[int]) -> list[int]:
        return sorted((n for n in numbers if low <= n < high), key=lambda n: (abs(math.log(n / middle)), n))

    powers = {k**m for m in range(2, 17) for k in range(_root(low, m), _root(high, m) + 2)}
    fibonacci = {1, 2}
    a, b = 1, 2
    while b < high:
        a, b = b, a + b
        fibonacci.add(b)
    others = {middle + step for step in range(-8, 9)}
    ordered = itertools.chain([middle], near(powers), near(fibonacci), near(others))
    yield from dict.fromkeys(ordered)


def _root(value: float, power: int) -> int:
    return max(1, math.floor(math.pow(value, 1.0 / power)))
