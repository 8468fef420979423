"""Families against one of them, over scenes: the geometric mean of the ratios scene by scene.

Scenes are few and differ, so the interval is Student's over the scenes: it holds for further scenes of the kind. What
is not known of each scene's ratio is in how they scatter.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aliascope.trade.reach import Answer, Family, at_time, ends, to_error
from aliascope.trade.records import Interval, Ratio
from aliascope.trade.uncertainty import Array, student

Name = tuple[str, str]


@dataclass(frozen=True)
class Compared:
    """What each family of a scene comes to at the same errors and times: by family, an answer each."""

    scene: str
    families: dict[Name, Family]
    to_error: dict[Name, list[Answer]]
    at_time: dict[Name, list[Answer]]


def compared(scene: str, families: Sequence[Family], errors: Sequence[float], times: Sequence[float]) -> Compared:
    """All families of a scene at the errors and times."""
    return Compared(
        scene,
        {family.name: family for family in families},
        {family.name: [to_error(family, error) for error in errors] for family in families},
        {family.name: [at_time(family, seconds) for seconds in times] for family in families},
    )


def base_family(fronts: Sequence[dict[Name, float]]) -> Name | None:
    """The family that is on most fronts, from the probability of each family's most probable mode, scene by scene; of
    those that are on as many the one of most scenes, the one that is on them most surely, the first by name."""
    names = sorted({name for front in fronts for name in front})

    def rank(name: Name) -> tuple[int, int, float]:
        found = [front[name] for front in fronts if name in front]
        return sum(p >= 0.5 for p in found), len(found), math.fsum(found)

    return max(names, key=rank, default=None)


def ratios(scenes: Sequence[Compared], base: Name) -> tuple[Ratio, ...]:
    """Every family against the base, by name."""
    names = sorted({name for scene in scenes for name in scene.families})
    return tuple(_ratio(scenes, base, name) for name in names)


def _ratio(scenes: Sequence[Compared], base: Name, name: Name) -> Ratio:
    both = [scene for scene in scenes if base in scene.families and name in scene.families]
    times = {scene.scene: _of_scene(scene, scene.to_error, base, name) for scene in both}
    errors = {scene.scene: _of_scene(scene, scene.at_time, base, name) for scene in both}
    told = tuple(scene.scene for scene in both if times[scene.scene] or errors[scene.scene])
    return Ratio(*name, _over_scenes(list(times.values())), _over_scenes(list(errors.values())), told)


@dataclass(frozen=True)
class _Shift:
    """The logarithm of a ratio on one scene, and what it could be (DRAWS,); `known`: whether that says anything."""

    value: float
    draws: Array
    known: bool


def _of_scene(scene: Compared, answers: dict[Name, list[Answer]], base: Name, name: Name) -> _Shift | None:
    """The mean over the targets that both come to by what was measured; None where there is no such target."""
    pairs = [
        (own, other)
        for own, other in zip(answers[name], answers[base], strict=True)
        if own.how in _MEASURED and other.how in _MEASURED and math.isfinite(own.value - other.value)
    ]
    if not pairs:
        return None
    known = scene.families[name].known and scene.families[base].known
    draws = np.mean([_difference(own.draws, other.draws) for own, other in pairs], axis=0)
    return _Shift(math.fsum(own.value - other.value for own, other in pairs) / len(pairs), draws, known)


_MEASURED = ("measured", "between")


def _difference(own: Array, other: Array) -> Array:
    """Where neither is reached nothing is told of the ratio."""
    with np.errstate(invalid="ignore"):
        return np.nan_to_num(own - other, nan=0.0, posinf=math.inf, neginf=-math.inf)


def _over_scenes(found: Sequence[_Shift | None]) -> Interval | None:
    shifts = [shift for shift in found if shift is not None]
    if not shifts:
        return None
    if len(shifts) == 1:
        low, high = ends(shifts[0].draws) if shifts[0].known else (None, None)
        return Interval(math.exp(shifts[0].value), low, high)
    return mean_ratio([shift.value for shift in shifts])


def mean_ratio(logs: Sequence[float]) -> Interval:
    """The geometric mean of two or more ratios, from their logarithms, with Student's interval."""
    values = np.array(logs)
    return student(float(values.mean()), float(values.std(ddof=1)) / math.sqrt(len(values)), len(values) - 1)
