"""The sentences at the top of a report, computed from its rows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from aliascope.records import Estimate, ModeRow, SceneSection
from aliascope.statistics import rate

TARGETS = (0.01, 0.02, 0.05, 0.1, 0.2)


@dataclass(frozen=True)
class Overall:
    """One mode over all scenes that it drew: root mean square of its RMSE, mean CPU time of a picture."""

    renderer: str
    mode: str
    rmse: float
    cpu_seconds: float


def headlines(scenes: Sequence[SceneSection]) -> tuple[str, ...]:
    """What came out, the most telling first; nothing where there is nothing to say."""
    return tuple(sentence for sentence in (_to_reach(scenes), _rates(scenes)) if sentence)


def over_all(scenes: Sequence[SceneSection]) -> list[Overall]:
    """The modes that drew every scene that their renderer drew at all."""
    drawn: dict[tuple[str, str], list[ModeRow]] = {}
    for scene in scenes:
        for row in scene.rows:
            drawn.setdefault((row.renderer, row.mode), []).append(row)
    most = {renderer: max(len(rows) for (name, _), rows in drawn.items() if name == renderer) for renderer, _ in drawn}
    return [
        Overall(
            renderer,
            mode,
            math.sqrt(sum(_value(row.metrics["rmse"]) ** 2 for row in rows) / len(rows)),
            sum(_value(row.cpu_seconds) for row in rows) / len(rows),
        )
        for (renderer, mode), rows in drawn.items()
        if len(rows) == most[renderer]
    ]


def _value(estimate: Estimate) -> float:
    assert estimate.value is not None  # RMSE and time always have one
    return estimate.value


def _to_reach(scenes: Sequence[SceneSection]) -> str:
    modes = over_all(scenes)
    renderers = list(dict.fromkeys(mode.renderer for mode in modes))
    target = next((t for t in TARGETS if any(mode.rmse <= t for mode in modes)), None)
    if target is None:
        return ""
    parts = []
    for renderer in renderers:
        own = [mode for mode in modes if mode.renderer == renderer]
        able = [mode for mode in own if mode.rmse <= target]
        if able:
            fastest = min(able, key=lambda mode: mode.cpu_seconds)
            parts.append(f"{renderer} {fastest.mode} takes {_seconds(fastest.cpu_seconds)}")
        else:
            best = min(own, key=lambda mode: mode.rmse)
            parts.append(f"{renderer} cannot (its best is {best.rmse:.2g}, {best.mode})")
    over = "this scene" if len(scenes) == 1 else f"these {len(scenes)} scenes"
    return f"To reach an RMSE of {target:g} over {over}: {'; '.join(parts)} of CPU time a picture."


def _seconds(seconds: float) -> str:
    return f"{seconds * 1e3:.2g} ms" if seconds < 0.0995 else f"{seconds:.2g} s"


def _rates(scenes: Sequence[SceneSection]) -> str:
    """The exponents of the tracer's patterns, over scenes: each scene's own fit, then their mean and its spread."""
    families: dict[str, list[float]] = {}
    for scene in scenes:
        for family, rows in by_family(row for row in scene.rows if row.renderer == "embree").items():
            fit = rate([row.samples_per_pixel for row in rows], [_value(row.metrics["rmse"]) for row in rows])
            if fit:
                families.setdefault(family, []).append(fit.exponent)
    shown = sorted((sum(found) / len(found), min(found), max(found), family) for family, found in families.items())
    if not shown:
        return ""
    parts = [
        f"N^{average:.2f} ({family.removeprefix('uniform ')}"
        + (f", {lowest:.2f} to {highest:.2f} from scene to scene)" if lowest != highest else ")")
        for average, lowest, highest, family in shown
    ]
    return f"In the tracer the error falls with the samples a pixel as {'; '.join(parts)}."


def by_family(rows: Iterable[ModeRow]) -> dict[str, list[ModeRow]]:
    """Rows that differ in their count alone, by the name of their family."""
    found: dict[str, list[ModeRow]] = {}
    for row in rows:
        found.setdefault(row.family, []).append(row)
    return found
