"""What each setting of each key of a renderer's modes does to time and error, all other keys being the same.

Modes are paired with the one that differs from them in this key alone, and has its baseline there: the key's default,
or its least value where no mode has the default. A key that takes an inner spec (the pattern, the method of an adaptive
mode) is turned from name to name, and each key of an inner spec by itself, under the inner spec's name: keys of the
same name in two of them are two knobs, with defaults of their own. Forms that take the same keys (POV-Ray's am1 and
am2) are settings of a knob of their own, METHOD.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass

from aliascope.records import ModeRow, SceneSection
from aliascope.trade.ratios import mean_ratio
from aliascope.trade.records import Interval, Knob
from aliascope.trade.uncertainty import Points, Spread, satterthwaite, student

METHOD = "method"
"""The knob whose settings are forms."""

_Turned = tuple[str, str, str]
"""A knob: renderer, form or forms, key."""
_Place = tuple[str, Hashable]
"""Where modes differ by a knob alone: the scene, and what the modes have in common."""


@dataclass(frozen=True)
class _Entry:
    """A mode as one of those that a knob turns into each other; `others` is what they have in common.

    `default`: 2 where the setting is what the mode has by default, 1 where its inner spec has, 0 where none has."""

    turned: _Turned
    others: Hashable
    setting: str
    default: int


@dataclass(frozen=True)
class _Measured:
    """A mode on a scene: its time and error as logarithms, each with standard error and degrees of freedom."""

    time: float
    error: float
    time_spread: tuple[float, float]
    error_spread: tuple[float, float]


def knobs(sections: Sequence[SceneSection], measured: Sequence[Points]) -> tuple[Knob, ...]:
    """All that two modes or more differ by, by renderer, form, key and setting. Scenes under several filters are one:
    their errors are each against its own reference."""
    found: dict[_Turned, dict[_Place, dict[str, _Measured]]] = {}
    defaults: dict[_Turned, tuple[int, str]] = {}
    for section, points in zip(sections, measured, strict=True):
        scene = section.name.removesuffix(f", {section.filter}")
        forms = _alike_forms(points.rows)
        for i, row in enumerate(points.rows):
            if not math.isfinite(points.error[i]):
                continue
            one = _Measured(
                float(points.time[i]),
                float(points.error[i]),
                _at(points.time_spread, i),
                _at(points.error_spread, i),
            )
            for entry in _entries(row, forms.get((row.renderer, form_of(row)))):
                found.setdefault(entry.turned, {}).setdefault((scene, entry.others), {})[entry.setting] = one
                if entry.default:
                    defaults[entry.turned] = max(defaults.get(entry.turned, (0, "")), (entry.default, entry.setting))
    baselines = {turned: setting for turned, (_, setting) in defaults.items()}
    return tuple(knob for turned in sorted(found) for knob in _knobs(turned, found[turned], baselines.get(turned)))


def _at(spread: Spread, i: int) -> tuple[float, float]:
    return float(spread.standard_error[i]), float(spread.freedom[i])


def form_of(row: ModeRow) -> str:
    """The name of a mode's form."""
    return row.mode.partition(":")[0]


def _written(row: ModeRow) -> set[str]:
    """The keys that a mode's spec names: those that differ from their defaults."""
    return {item.partition("=")[0] for item in row.mode.partition(":")[2].split(",") if item}


def _alike_forms(rows: Sequence[ModeRow]) -> dict[tuple[str, str], str]:
    """By renderer and form, the forms that take the same keys, where there are others."""
    keys: dict[tuple[str, frozenset[str]], set[str]] = {}
    for row in rows:
        outer = frozenset(key for key in row.settings if "." not in key)
        if outer:
            keys.setdefault((row.renderer, outer), set()).add(form_of(row))
    return {
        (renderer, form): ", ".join(sorted(forms))
        for (renderer, _), forms in keys.items()
        if len(forms) > 1
        for form in forms
    }


def _entries(row: ModeRow, alike: str | None) -> Iterator[_Entry]:
    """The knobs that a mode has a setting of."""
    settings, form, written = row.settings, form_of(row), _written(row)
    every = frozenset(settings.items())
    for key, value in settings.items():
        inner = [name for name in settings if name.startswith(f"{key}.")]
        outer = key.rpartition(".")[0]
        turned = (row.renderer, f"{form}, {settings[outer]}" if outer else form, key)
        if inner:
            others = frozenset((name, told) for name, told in every if name != key and name not in inner)
            yield _Entry(turned, others, _whole(row, key, value), 2 * written.isdisjoint((key, *inner)))
        else:
            # An inner spec that is left out as a whole is the mode's own default, whatever its keys' own defaults are.
            own = key not in written
            yield _Entry(turned, every - {(key, value)}, value, own * (1 if outer in written else 2))
    if alike:
        yield _Entry((row.renderer, alike, METHOD), every, form, 0)


def _whole(row: ModeRow, key: str, name: str) -> str:
    """The text of an inner spec without its defaults, as the family of the mode has it; else its name."""
    words = [word.removeprefix(f"{key}=") for word in row.family.split()[1:]]
    return next((word for word in words if word.partition(":")[0] == name), name)


def _knobs(turned: _Turned, groups: dict[_Place, dict[str, _Measured]], default: str | None) -> Iterator[Knob]:
    """Of one key, each setting against the baseline."""
    settings = sorted({setting for group in groups.values() for setting in group}, key=_order)
    if len(settings) < 2:
        return
    baseline = default if default is not None else settings[0]
    for setting in _told(settings, baseline):
        pairs: dict[str, list[tuple[_Measured, _Measured]]] = {}
        for (scene, _), group in groups.items():
            if setting != baseline and setting in group and baseline in group:
                pairs.setdefault(scene, []).append((group[setting], group[baseline]))
        if not pairs:
            continue
        times = [[_difference(a.time, b.time, a.time_spread, b.time_spread) for a, b in own] for own in pairs.values()]
        errors = [
            [_difference(a.error, b.error, a.error_spread, b.error_spread) for a, b in own] for own in pairs.values()
        ]
        yield Knob(*turned, setting, baseline, _ratio(times), _ratio(errors), tuple(pairs), sum(map(len, times)))


def _told(settings: Sequence[str], baseline: str) -> list[str]:
    """Without inner specs of the name of the baseline, which their keys tell, and without variants of what is plain."""
    names = {setting: setting.partition(":")[0] for setting in settings}
    return [
        setting
        for setting, name in names.items()
        if setting == baseline or (name != names[baseline] and (setting == name or name not in names))
    ]


def _order(setting: str) -> tuple[bool, float, str]:
    """Numbers first, by size."""
    try:
        return (False, float(setting), "")
    except ValueError:
        return (True, 0.0, setting)


_Ratio = tuple[float, float, float]
"""The logarithm of a ratio, its standard error, its degrees of freedom."""


def _difference(own: float, other: float, *spreads: tuple[float, float]) -> _Ratio:
    errors, freedoms = zip(*spreads, strict=True)
    return own - other, *satterthwaite(errors, freedoms)


def _ratio(scenes: Sequence[Sequence[_Ratio]]) -> Interval:
    """The geometric mean over scenes of the mean over a scene's pairs. The interval is Student's over scenes; of one
    scene over its pairs; of a single pair from what is not known of its two modes."""
    means = [math.fsum(value for value, _, _ in pairs) / len(pairs) for pairs in scenes]
    if len(means) > 1:
        return mean_ratio(means)
    if len(scenes[0]) > 1:
        return mean_ratio([value for value, _, _ in scenes[0]])
    return student(*scenes[0][0])
