"""The sentences at the top of a report, computed from its rows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from aliascope.records import Estimate, ModeRow, SceneSection
from aliascope.report.pool import Curve, in_common, pool, under_one_filter
from aliascope.statistics import Rate, mean, rate, told_apart

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
            alike = _alike(fastest, able, lambda mode: mode.cpu_seconds)
            parts.append(f"{renderer} {_time(fastest.cpu_seconds)} ({fastest.label}{alike})")
        else:
            best = min(own, key=_rmse)
            alike = _alike(best, own, lambda mode: mode.metrics["rmse"])
            parts.append(f"{renderer} cannot (its best is {_figure(best.metrics['rmse'])}, {best.label}{alike})")
    over = f"the scene {common[0].name}" if len(common) == 1 else f"{len(common)} scenes"
    return f"CPU time a picture to reach an RMSE of {target:g} over {over}: {'; '.join(parts)}."


def _alike(best: Curve, modes: Iterable[Curve], figure: Callable[[Curve], Estimate]) -> str:
    """Which modes cannot be told from the best by this figure, the nearest by name."""
    if _value(figure(best)) <= 0.0:  # too short a time to be told is no figure
        return ""
    alike = [mode for mode in modes if mode is not best and not told_apart(figure(mode), figure(best))]
    if not alike:
        return ""
    nearest = min(alike, key=lambda mode: _value(figure(mode)))
    more = f" and {len(alike) - 1} more" if len(alike) > 1 else ""
    return f"; {nearest.label}{more} within its uncertainty"


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
    """The exponents of the tracer's patterns, over scenes: each scene's own fit, then their mean."""
    families: dict[str, list[Rate]] = {}
    once = under_one_filter(scenes)
    for scene in once:
        for family, rows in by_family(row for row in scene.rows if row.renderer == "embree").items():
            fit = rate([row.samples_per_pixel for row in rows], [_value(row.metrics["rmse"]) for row in rows])
            if fit:
                families.setdefault(family, []).append(fit)
    if not families:
        return ""
    exponents = [(_exponent(fits), family.removeprefix("uniform ")) for family, fits in families.items()]
    parts = [f"N^{_power(found)} ({name})" for found, name in sorted(exponents, key=lambda each: _value(each[0]))]
    counts = {len(fits) for fits in families.values()}
    scenes_told = f"{max(counts)} scenes" if len(counts) == 1 else f"{min(counts)} to {max(counts)} scenes"
    over = " (fit ± standard error)" if counts == {1} else f" (mean over {scenes_told} ± standard error)"
    return f"In the tracer the error falls with the samples a pixel as{over}: {'; '.join(parts)}."


def _exponent(fits: Sequence[Rate]) -> Estimate:
    """Of one scene with the fit's own standard error, of several with that of their mean, from how they scatter."""
    if len(fits) == 1:
        return Estimate(fits[0].exponent, fits[0].standard_error)
    return mean([fit.exponent for fit in fits])


def _power(exponent: Estimate) -> str:
    """Two decimals, and the standard error; three where it is as small as that."""
    value, error = _value(exponent), exponent.standard_error
    if error is None:
        return f"{value:.2f}"
    if error < 5e-4:
        return f"{value:.3f} ± <0.001"
    decimals = 2 if error >= 5e-3 else 3
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"


def by_family(rows: Iterable[ModeRow]) -> dict[str, list[ModeRow]]:
    """Rows that differ in their count alone, by the name of their family."""
    found: dict[str, list[ModeRow]] = {}
    for row in rows:
        found.setdefault(row.family, []).append(row)
    return found
