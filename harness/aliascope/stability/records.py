"""What a probe is, and what it finds: frozen, and free of behaviour but for what follows from the fields alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

Kind = Literal["renderer", "sampler", "measure", "estimator", "statistic", "filter", "metric", "film"]
"""What a component is: the rows of the map are grouped by it."""

Group = Literal["geometry", "radiance", "counts", "statistics", "points", "metrics"]
"""What an extreme is of: the columns of the map are grouped by it."""


@dataclass(frozen=True)
class Extreme:
    """One way of going too far, a column of the map. `axis` says what its levels are, with their unit."""

    name: str
    group: Group
    title: str
    axis: str


@dataclass(frozen=True)
class Probe:
    """One component at one extreme.

    `measure` gives the error at one level, in `unit`, 0 or more, of one level of the extreme's axis. It raises an
    AliascopeError where the component declines; NaN and infinity say that the result was none.

    `levels` go from mild to extreme. `bound` is the error that should not be passed at any of them; `precision` the
    error that cannot be fallen below, of the format of the result (2^-53 for doubles): digits are lost from there.
    `against` says in a few words what the truth is. `quick` are the levels that a test can afford.
    """

    component: str
    kind: Kind
    extreme: str
    unit: str
    against: str
    precision: float
    bound: float
    levels: tuple[float, ...]
    measure: Callable[[float], float]
    quick: tuple[float, ...] = ()
    note: str = ""

    @property
    def name(self) -> str:
        return f"{self.component} | {self.extreme}"


@dataclass(frozen=True)
class Reading:
    """The error at one level; None where the component declined, with its message in `refused`. A result that was not
    finite has an error of infinity. `seconds` is the CPU time of measuring."""

    at: float
    error: float | None
    refused: str = ""
    seconds: float = 0.0


@dataclass(frozen=True)
class Cell:
    """What a probe found: its readings in the order of its levels, and what they are to be read by."""

    component: str
    kind: Kind
    extreme: str
    unit: str
    against: str
    precision: float
    bound: float
    readings: tuple[Reading, ...]
    note: str = ""

    @property
    def breaks_at(self) -> float | None:
        """The first level at which the bound is passed; None where it is kept at all that were not refused."""
        return next((each.at for each in self.readings if each.error is not None and each.error > self.bound), None)

    @property
    def refused_from(self) -> float | None:
        """The first level at which the component declined."""
        return next((each.at for each in self.readings if each.error is None), None)

    @property
    def digits_lost(self) -> float | None:
        """Of the worst reading, decimal digits over the precision; infinite for a result that is none, None where all
        were refused."""
        errors = [each.error for each in self.readings if each.error is not None]
        return max(map(self.lost, errors)) if errors else None

    def lost(self, error: float) -> float:
        """Decimal digits that an error is over the precision, at least 0."""
        if not math.isfinite(error):
            return math.inf
        return max(0.0, math.log10(error / self.precision)) if error > 0.0 else 0.0
