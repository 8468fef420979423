"""The round errors and times at which modes are compared."""

from __future__ import annotations

import math
from collections.abc import Sequence

from aliascope.trade.uncertainty import Points

MOST = 5
"""Targets of a scene's tables at most."""

_ROUNDING = 1e-12
"""Figures come as logarithms, and go back."""


def series(low: float, high: float) -> list[float]:
    """The numbers 1, 2, 5 x 10^k in [low, high], both above 0, but for roundings."""
    found = []
    for power in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1):
        found += [float(f"{digit}e{power}") for digit in (1, 2, 5)]
    return [value for value in found if low * (1.0 - _ROUNDING) <= value <= high * (1.0 + _ROUNDING)]


def errors(points: Points) -> list[float]:
    """Round errors, the largest first, that tell families apart: two or more reach them (or the one that there is),
    and not each with its fastest mode."""
    groups = list(points.families().values())
    fastest = [math.exp(points.error[own[0]]) for own in groups]
    return sorted(_chosen([math.exp(points.error[own].min()) for own in groups], fastest), reverse=True)


def times(points: Points) -> list[float]:
    """Round times, the shortest first, that two families or more have a mode for (or the one that there is), and of
    which not each has its slowest."""
    groups = list(points.families().values())
    slowest = [math.exp(points.time[own[-1]]) for own in groups]
    return _chosen([math.exp(points.time[own[0]]) for own in groups], slowest)


def _chosen(starts: Sequence[float], ends: Sequence[float]) -> list[float]:
    """Round numbers from the second least start on, below the largest end."""
    ordered = sorted(start for start in starts if start > 0.0)
    top = max(ends, default=0.0)
    if not ordered or top <= 0.0:
        return []
    low = ordered[min(1, len(ordered) - 1)]
    return [value for value in series(low, max(low, top)) if value < top * (1.0 - _ROUNDING)]


def few(found: Sequence[float]) -> list[int]:
    """Which of them a table shows: MOST at most, evenly spread, with both ends."""
    if len(found) <= MOST:
        return list(range(len(found)))
    return [round(i * (len(found) - 1) / (MOST - 1)) for i in range(MOST)]
