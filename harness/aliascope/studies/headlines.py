"""The sentences at the top of a report, computed from its rows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from aliascope.records import Estimate, ModeRow, SceneSection
from aliascope.report.pool import Curve, in_common, pool, under_one_filter
from aliascope.statistics import rate

TARGETS = (0.01, 0.02, 0.05, 0.1, 0.2)


def headlines(scenes: Sequence[SceneSection]) -> tuple[str, ...]:
    """What came out, the most telling first; nothing where there is nothing to say."""
    return tuple(sentence for sentence in (_to_reach(scenes), _rates(scenes)) if sentence)


def _value(estimate: Estimate) -> float:
    assert estimate.value is not None  # RMSE and time always have one
    return estimate.value


def _to_reach(scenes: Sequence[SceneSection]) -> str:
    """Of the modes that drew each of the scenes that the report pools."""
    common = in_common(scenes)
    modes = [mode for mode in pool(common) if not mode.missing]
    target = next((t for t in TARGETS if any(_rmse(mode) <= t for mode in modes)), None)
    if target is None:
        return ""
    parts = []
    for renderer in dict.fromkeys(mode.renderer for mode in modes):
        own = [mode for mode in modes if mode.renderer == renderer]
        able = [mode for mode in own if _rmse(mode) <= target]
        if able:
            fastest = min(able, key=lambda mode: _value(mode.cpu_seconds))
            parts.append(f"{renderer} {_time(fastest.cpu_seconds)} ({fastest.label})")
        else:
            best = min(own, key=_rmse)
            parts.append(f"{renderer} cannot (its best is {_figure(best.metrics['rmse'])}, {best.label})")
    over = f"the scene {common[0].name}" if len(common) == 1 else f"{len(common)} scenes"
    return f"CPU time a picture to reach an RMSE of {target:g} over {over}: {'; '.join(parts)}."


def _rmse(mode: Curve) -> float:
    return _value(mode.metrics["rmse"])


def _time(estimate: Estimate) -> str:
    seconds = _value(estimate)
    if seconds <= 0.0:  # POV-Ray tells whole milliseconds
        return "less time than it can tell"
    return f"{_figure(estimate, 1e3)} ms" if seconds < 0.0995 else f"{_figure(estimate)} s"


def _figure(estimate: Estimate, scale: float = 1.0) -> str:
    """Two digits, and the standard error with one, where it is known."""
    error = estimate.standard_error
    return _digits(_value(estimate) * scale, 2) + (f" ± {_digits(error * scale, 1)}" if error else "")


def _digits(value: float, count: int) -> str:
    return f"{value:.0f}" if value >= 99.5 else f"{value:.{count}g}"


def _rates(scenes: Sequence[SceneSection]) -> str:
    """The exponents of the tracer's patterns, over scenes: each scene's own fit, then their mean and its spread."""
    families: dict[str, list[float]] = {}
    once = under_one_filter(scenes)
    for scene in once:
        for family, rows in by_family(row for row in scene.rows if row.renderer == "embree").items():
            fit = rate([row.samples_per_pixel for row in rows], [_value(row.metrics["rmse"]) for row in rows])
            if fit:
                families.setdefault(family, []).append(fit.exponent)
    shown = sorted((sum(found) / len(found), min(found), max(found), family) for family, found in families.items())
    if not shown:
        return ""
    parts = [
        f"N^{average:.2f} ({family.removeprefix('uniform ')}"
        + (f", {lowest:.2f} to {highest:.2f})" if f"{lowest:.2f}" != f"{highest:.2f}" else ")")
        for average, lowest, highest, family in shown
    ]
    spread = ", the mean over scenes and its range" if len(once) > 1 else ""
    return f"In the tracer the error falls with the samples a pixel as{spread}: {'; '.join(parts)}."


def by_family(rows: Iterable[ModeRow]) -> dict[str, list[ModeRow]]:
    """Rows that differ in their count alone, by the name of their family."""
    found: dict[str, list[ModeRow]] = {}
    for row in rows:
        found.setdefault(row.family, []).append(row)
    return found
