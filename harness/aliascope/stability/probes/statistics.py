"""Moments and quantiles, against mpmath."""

from __future__ import annotations

import mpmath
import numpy as np

from aliascope.native import estimate
from aliascope.stability.records import Probe

COUNT = 4096


def _variance(at: float) -> float:
    """Of normal values of deviation 1 about `at`: the figures are of the very doubles, whatever rounding made them."""
    values = at + np.random.default_rng(1).standard_normal(COUNT)
    with mpmath.workdps(60):
        exact = [mpmath.mpf(float(value)) for value in values]
        mean = mpmath.fsum(exact) / COUNT
        truth = mpmath.fsum((value - mean) ** 2 for value in exact) / (COUNT - 1)
        return float(abs(estimate.Moments(values).variance / truth - 1))


def probes() -> list[Probe]:
    return [
        Probe(
            "variance",
            "statistic",
            "mean",
            "relative",
            "mpmath of the same doubles",
            2.0**-53,
            1e-10,
            tuple(10.0**k for k in range(0, 16, 2)),
            _variance,
            (1.0, 1e8),
        )
    ]
