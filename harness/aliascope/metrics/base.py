"""What a metric is."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""A picture as metrics take it: (height, width, channels) float64, linear, finite."""


@dataclass(frozen=True)
class Measured:
    """A metric's value: None where it has none (the PSNR of equal pictures), with the reason in `details`."""

    value: float | None
    details: Mapping[str, Any] = field(default_factory=dict)


Metric = Callable[[Array, Array], Measured]
"""A picture and its reference, of one shape, to the figure. The first line of its docstring is its help."""


def no_value(name: str, reason: str) -> Measured:
    """A metric that has no value here, and why: `details` has it as "NAME-reason"."""
    return Measured(None, {f"{name}-reason": reason})


def mean_difference(image: Array, reference: Array) -> float:
    """The mean of image - reference, as if in twice the precision: where errors of either sign cancel, their rounding
    would be what is left.

    Sums in pairs, each with what its rounding lost (Knuth's TwoSum: The Art of Computer Programming 2, 4.2.2); these
    are added up for themselves. So does the difference of two pixels.
    """
    parts = np.concatenate([image.ravel(), -reference.ravel()])
    count, lost = image.size, 0.0
    while parts.size > 1:
        left, right = parts[: parts.size // 2], parts[parts.size // 2 : parts.size // 2 * 2]
        rest = parts[parts.size // 2 * 2 :]
        total = left + right
        taken = total - left
        lost += float(((left - (total - taken)) + (right - taken)).sum())
        parts = np.concatenate([total, rest])
    return (float(parts[0]) + lost) / count
