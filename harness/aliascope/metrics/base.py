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
