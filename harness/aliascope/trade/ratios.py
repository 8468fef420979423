"""Families against one of them, over scenes: the geometric mean of the ratios scene by scene.

Scenes are few and differ, so the interval is Student's over the scenes: it holds for further scenes of the kind. What
is not known of each scene's ratio is in how they scatter. (The percentiles of a bootstrap over 3, 7 and 15 scenes hold
less than the 95 % that they are to: tests/python/test_trade_coverage.py.)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from aliascope.trade.reach import Answer, Family
from aliascope.trade.records import Interval, Ratio
from aliascope.trade.uncertainty import Array, ends, student

Name = tuple[str, str]


@dataclass(frozen=True)
class Compared:
    """What each family of a scene comes to at the same errors and times: an answer for each of these, errors from the
    largest, times from the longest."""

    scene: str
    families: dict[Name, Family]
    to_error: dict[Name, list[Answer]]
    at_time: dict[Name, list[Answer]]


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
    """The logarithm of a ratio on one scene and what it could be (1 + DRAWS,); `known`: whether that says anything."""

    figures: Array
    known: bool


def _of_scene(scene: Compared, answers: dict[Name, list[Answer]], base: Name, name: Name) -> _Shift | None:
    """The mean over the targets that both come to by what was measured; None where there is no such target."""
    found = [
        _difference(own.figures, other.figures)
        for own, other in zip(_near(answers[name]), _near(answers[base]), strict=True)
        if own is not None and other is not None and own.figures is not None and other.figures is not None
    ]
    found = [figures for figures in found if math.isfinite(figures[0])]
    if not found:
        return None
    # A draw in which neither is reached, or each but at other targets, tells nothing of the ratio.
    with np.errstate(invalid="ignore"):
        figures = np.nan_to_num(np.mean(found, axis=0), nan=0.0, posinf=math.inf, neginf=-math.inf)
    return _Shift(figures, scene.families[name].known and scene.families[base].known)


def _near(answers: Sequence[Answer]) -> list[Answer | None]:
    """Those of one family that count, of targets from the easiest to the hardest: not what is extrapolated, and of the
    targets that it reaches with its end alone (its fastest mode is better than that, or its best one faster) only the
    last, since far from its modes little is told of its trade."""
    following = [*(answer.how for answer in answers[1:]), "cannot"][: len(answers)]
    return [
        answer
        if answer.how == "between" or (answer.how == "measured" and then not in ("measured", "extrapolated"))
        else None
        for answer, then in zip(answers, following, strict=True)
    ]


def _difference(own: Array, other: Array) -> Array:
    """NaN where neither is reached."""
    with np.errstate(invalid="ignore"):
        found: Array = own - other
    return found


def _over_scenes(found: Sequence[_Shift | None]) -> Interval | None:
    shifts = [shift for shift in found if shift is not None]
    if not shifts:
        return None
    if len(shifts) == 1:
        low, high = ends(shifts[0].figures) if shifts[0].known else (None, None)
        return Interval(math.exp(shifts[0].figures[0]), low, high)
    return mean_ratio([float(shift.figures[0]) for shift in shifts])


def mean_ratio(logs: Sequence[float]) -> Interval:
    """The geometric mean of two or more ratios, from their logarithms, with Student's interval."""
    values = np.array(logs)
    return student(float(values.mean()), float(values.std(ddof=1)) / math.sqrt(len(values)), len(values) - 1)
