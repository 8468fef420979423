"""What the analysis of the trade comes to: frozen, and free of behaviour. All intervals are of 95 %."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

QUANTISATION = 1.0 / 255.0 / 12.0**0.5
"""The RMSE of rounding to 8 bits, of values that fall anywhere between two steps: the natural end of the trade."""


@dataclass(frozen=True)
class Interval:
    """A figure and its interval; an end that is not known is None."""

    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True)
class OnFront:
    """How probable it is that no other mode is both faster and better, given what is not known of times and errors.
    Not `known` where no spread is known of the mode's time nor of its error, as of one timed run of one picture."""

    renderer: str
    mode: str
    probability: float
    known: bool = True


How = Literal["measured", "between", "extrapolated", "cannot"]
"""A mode of the family has it; it lies between two modes of the family; beyond the last, by the family's rate; the
family's error does not fall that far, or its time is not that short."""


@dataclass(frozen=True)
class Reach:
    """What a family of modes (those of a renderer that differ in their count alone) takes to reach `error`, and the
    mode to choose: the fastest that reaches it, or that comes nearest. `seconds` is None where it cannot. `best` is the
    least error that was measured of the family."""

    renderer: str
    family: str
    error: float
    seconds: Interval | None
    how: How
    mode: str
    label: str
    best: float


@dataclass(frozen=True)
class Afford:
    """The error that a family has after `seconds`, and the mode to choose: the best that takes no longer."""

    renderer: str
    family: str
    seconds: float
    error: Interval | None
    how: How
    mode: str
    label: str
    fastest: float


@dataclass(frozen=True)
class Convergence:
    """How fast the error of a family falls: as samples^exponent, and as CPU seconds^per_time. `curved`: not as a
    power."""

    renderer: str
    family: str
    exponent: Interval
    per_time: Interval | None
    curved: bool
    modes: int


@dataclass(frozen=True)
class Efficiency:
    """1 / (MSE x CPU seconds) of a mode."""

    renderer: str
    mode: str
    value: Interval


@dataclass(frozen=True)
class SceneTrade:
    """The trade on one scene. `equal_error` and `equal_time` have each family at each of a few errors and times, the
    same for all families; `quantisation` each family at the error QUANTISATION."""

    scene: str
    front: tuple[OnFront, ...]
    equal_error: tuple[Reach, ...]
    equal_time: tuple[Afford, ...]
    quantisation: tuple[Reach, ...]
    convergence: tuple[Convergence, ...]
    efficiency: tuple[Efficiency, ...]


@dataclass(frozen=True)
class Ratio:
    """A family against `base`, over scenes: the geometric mean of the ratios scene by scene, of time at equal error and
    of error at equal time, each the mean over the round errors and times that both come to; None where no scene has
    one. Below 1 is better than the base. `scenes` are those that have a ratio."""

    renderer: str
    family: str
    time: Interval | None
    error: Interval | None
    scenes: tuple[str, ...]


@dataclass(frozen=True)
class Knob:
    """What one setting of one key does to time and error, all other keys being the same: the geometric mean, over
    scenes and the other keys' values, of the ratios to the setting `baseline`, in `pairs` pairs of modes. `kind` is
    "mode" for keys of modes, or what else was turned ("measure")."""

    renderer: str
    form: str
    knob: str
    setting: str
    baseline: str
    time: Interval
    error: Interval
    scenes: tuple[str, ...]
    pairs: int
    kind: str = "mode"


@dataclass(frozen=True)
class Trade:
    """All scenes. `base` is the renderer and family that ratios are to. `front` is that of scenes together."""

    scenes: tuple[SceneTrade, ...]
    ratios: tuple[Ratio, ...]
    base: tuple[str, str] | None
    knobs: tuple[Knob, ...]
    front: tuple[OnFront, ...] = ()
