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
    """One way of going too far, a column of the map. `axis` says what its levels are, with their unit; `both_ways`:
    1 is the usual, and what is far from it on either side is extreme."""

    name: str
    group: Group
    title: str
    axis: str
    both_ways: bool = False


NEVER = math.inf
"""A component may not decline at any level."""


@dataclass(frozen=True)
class Probe:
    """One component at one extreme.

    `measure` gives the error at one level, in `unit`, 0 or more, of one level of the extreme's axis. It raises an
    AliascopeError where the component declines; NaN and infinity say that the result was none.

    `levels` go from mild to extreme. `bound` is the error that should not be passed at any of them; `precision` the
    error that cannot be fallen below, of the format of the result (2^-53 for doubles): digits are lost from there.
    `against` says in a few words what the truth is. `quick` are the levels that a test can afford. `excused`: where it
    breaks, it is another program's arithmetic that does (POV-Ray's, Embree's, Mesa's), or a safeguard of ours is
    switched off in this row, and no check fails; `excused_from`: from this level on. `refuses_from` is the first level
    at which the component may decline, as measured: earlier, declining is a failure. NEVER: at none; None: at any.
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
    excused: bool = False
    excused_from: float | None = None
    refuses_from: float | None = None

    @property
    def name(self) -> str:
        return f"{self.component} | {self.extreme}"


Status = Literal["keeps", "breaks", "refuses", "absent", "failed"]
"""What is to be said of a cell first: `failed`, that a measurement of it ended with no answer; `absent`, that the
component is not there; `refuses`, that it keeps its bound as far as it goes."""


@dataclass(frozen=True)
class Reading:
    """The error at one level; None where the component declined, with its message in `refused`, or where measuring came
    to no end, with what became of it in `failed`. A result that was not finite has an error of infinity. `seconds` is
    the CPU time of measuring."""

    at: float
    error: float | None
    refused: str = ""
    seconds: float = 0.0
    failed: str = ""


@dataclass(frozen=True)
class Cell:
    """What a probe found: its readings in the order of its levels, and what they are to be read by. `absent` says why
    the component is not there, if so."""

    component: str
    kind: Kind
    extreme: str
    unit: str
    against: str
    precision: float
    bound: float
    readings: tuple[Reading, ...]
    note: str = ""
    excused: bool = False
    absent: str = ""

    @property
    def status(self) -> Status:
        if any(each.failed for each in self.readings):
            return "failed"
        if self.absent:
            return "absent"
        if self.breaks_at is not None:
            return "breaks"
        return "keeps" if self.refused_from is None else "refuses"

    @property
    def breaks_at(self) -> float | None:
        """The first level at which the bound is passed; None where it is kept at all that were not refused."""
        return next((each.at for each in self.readings if self.passed(each)), None)

    @property
    def breaks(self) -> tuple[float, ...]:
        """Where levels go both ways from the mildest, the first level of each way at which the bound is passed, the
        lower one first; else the one of `breaks_at`, or none."""
        broken = [each.at for each in self.readings if self.passed(each)]
        if not broken or broken[0] == self.readings[0].at:
            return tuple(broken[:1])
        mildest = self.readings[0].at
        below = [at for at in broken if at < mildest]
        above = [at for at in broken if at > mildest]
        return (*below[:1], *above[:1])

    @property
    def refused_from(self) -> float | None:
        """The first level at which the component declined."""
        return next((each.at for each in self.readings if each.refused), None)

    @property
    def failed_from(self) -> float | None:
        """The first level at which measuring came to no end."""
        return next((each.at for each in self.readings if each.failed), None)

    @property
    def worst(self) -> Reading | None:
        """The first of those with the largest error; None where there is no error."""
        measured = [each for each in self.readings if each.error is not None]
        return max(measured, key=lambda each: each.error or 0.0, default=None)

    @property
    def digits_lost(self) -> float | None:
        """Of the worst reading, decimal digits over the precision; infinite for a result that is none, None where
        there is no error."""
        return None if self.worst is None or self.worst.error is None else self.lost(self.worst.error)

    def passed(self, reading: Reading) -> bool:
        """Whether a reading is past the bound."""
        return reading.error is not None and reading.error > self.bound

    def lost(self, error: float) -> float:
        """Decimal digits that an error is over the precision, at least 0."""
        if not math.isfinite(error):
            return math.inf
        return max(0.0, math.log10(error / self.precision)) if error > 0.0 else 0.0
