"""All scenes together: one row a mode, its error and time pooled over the scenes that it drew."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from aliascope.records import Estimate, ModeRow, SceneSection


@dataclass(frozen=True)
class Curve:
    """A row as plots and tables see it, of one scene or pooled. `missing` names the scenes that a pooled row lacks."""

    renderer: str
    mode: str
    label: str
    family: str
    samples_per_pixel: float
    cpu_seconds: Estimate
    metrics: Mapping[str, Estimate]
    pictures: int
    missing: tuple[str, ...] = ()
    rays_per_pixel: float | None = None
    instructions: float | None = None


def curve_of(row: ModeRow) -> Curve:
    """A scene's row without its picture."""
    return Curve(
        renderer=row.renderer,
        mode=row.mode,
        label=row.label,
        family=row.family,
        samples_per_pixel=row.samples_per_pixel,
        cpu_seconds=row.cpu_seconds,
        metrics=row.metrics,
        pictures=row.pictures,
        rays_per_pixel=_rays_per_pixel(row),
        instructions=row.instructions,
    )


def _rays_per_pixel(row: ModeRow) -> float | None:
    """Of all kinds; None where the renderer does not count them."""
    return sum(row.rays.values()) / (row.pixels.shape[0] * row.pixels.shape[1]) if row.rays else None


def in_common(scenes: Sequence[SceneSection]) -> tuple[SceneSection, ...]:
    """The scenes that every renderer drew in much the same modes, since others would favour the one that left out the
    hard ones, or have no mode to pool: of those that every renderer drew, the most that share at least half of each
    renderer's modes with one of them.

    All of them that have a row, where there is none in common.
    """
    drawn = [(scene, _modes(scene)) for scene in under_one_filter(scenes) if scene.rows]
    every = set().union(*(modes for _, modes in drawn))
    common = [(scene, modes) for scene, modes in drawn if set(modes) == every]
    if not common:
        return tuple(scene for scene, _ in drawn)
    groups = [tuple(scene for scene, modes in common if _alike(modes, first)) for _, first in common]
    return max(groups, key=lambda group: len(group))


def _modes(scene: SceneSection) -> dict[str, set[str]]:
    """The modes that drew a scene, by renderer."""
    found: dict[str, set[str]] = {}
    for row in scene.rows:
        found.setdefault(row.renderer, set()).add(row.mode)
    return found


def _alike(modes: Mapping[str, set[str]], others: Mapping[str, set[str]]) -> bool:
    return all(2 * len(own & others[name]) >= len(own | others[name]) for name, own in modes.items())


def under_one_filter(scenes: Sequence[SceneSection]) -> tuple[SceneSection, ...]:
    """Each scene once: the sections under the filter of the first one that was drawn.

    Modes under another filter are modes of their own; over both, every mode would lack a scene.
    """
    first = next((scene.filter for scene in scenes if scene.rows), "box")
    return tuple(scene for scene in scenes if scene.filter == first)


def pool(scenes: Sequence[SceneSection]) -> tuple[Curve, ...]:
    """One curve for each renderer and mode, in order of first appearance.

    Pooled over scenes that weigh the same: RMSE as the root of the mean square, PSNR from that RMSE, the
    largest error as the largest, all else (CPU time too) as the mean. A figure that one of the scenes lacks is None.
    """
    found: dict[tuple[str, str], dict[str, ModeRow]] = {}
    for scene in scenes:
        for row in scene.rows:
            found.setdefault((row.renderer, row.mode), {})[scene.name] = row
    names = [scene.name for scene in scenes]
    return tuple(_pooled(rows, names) for rows in found.values())


def _pooled(rows: Mapping[str, ModeRow], names: Sequence[str]) -> Curve:
    drawn = list(rows.values())
    metrics = dict.fromkeys(name for row in drawn for name in row.metrics)
    pooled = {m: _POOLS.get(m, _mean)([row.metrics.get(m, Estimate(None)) for row in drawn]) for m in metrics}
    if "psnr" in pooled and "rmse" in pooled:
        pooled["psnr"] = _psnr(pooled["rmse"])
    spp = [row.samples_per_pixel for row in drawn]
    return Curve(
        renderer=drawn[0].renderer,
        mode=drawn[0].mode,
        label=drawn[0].label,
        family=drawn[0].family,
        samples_per_pixel=math.fsum(spp) / len(spp),
        cpu_seconds=_mean([row.cpu_seconds for row in drawn]),
        metrics=pooled,
        pictures=sum(row.pictures for row in drawn),
        missing=tuple(name for name in names if name not in rows),
        rays_per_pixel=_mean([Estimate(_rays_per_pixel(row)) for row in drawn]).value,
        instructions=_mean([Estimate(row.instructions) for row in drawn]).value,
    )


def rounded(value: float | None, digits: int = 6) -> float | None:
    """A figure for the page's scripts, which show three digits: None where there is none or it is not finite."""
    return float(f"{value:.{digits}g}") if value is not None and math.isfinite(value) else None


def usable(value: float | None) -> bool:
    """Whether a figure is there and finite."""
    return value is not None and math.isfinite(value)


def _values(estimates: Sequence[Estimate]) -> list[float] | None:
    values = [e.value for e in estimates if e.value is not None and math.isfinite(e.value)]
    return values if len(values) == len(estimates) else None


def _errors(estimates: Sequence[Estimate]) -> list[float] | None:
    errors = [e.standard_error for e in estimates if e.standard_error is not None and math.isfinite(e.standard_error)]
    return errors if len(errors) == len(estimates) else None


def _mean(estimates: Sequence[Estimate]) -> Estimate:
    values, errors = _values(estimates), _errors(estimates)
    if not values:
        return Estimate(None)
    error = math.hypot(*errors) / len(values) if errors is not None else None
    return Estimate(math.fsum(values) / len(values), error)


def _root_mean_square(estimates: Sequence[Estimate]) -> Estimate:
    values, errors = _values(estimates), _errors(estimates)
    if not values:
        return Estimate(None)
    pooled = math.hypot(*values) / math.sqrt(len(values))
    if errors is None or pooled == 0.0:
        return Estimate(pooled, None if errors is None else max(errors))
    # d pooled / d value_i = value_i / (n pooled)
    spread = math.hypot(*(v * e for v, e in zip(values, errors, strict=True)))
    return Estimate(pooled, spread / (len(values) * pooled))


def _largest(estimates: Sequence[Estimate]) -> Estimate:
    if not _values(estimates):
        return Estimate(None)
    return max(estimates, key=lambda e: e.value if e.value is not None else -math.inf)


def _psnr(rmse: Estimate) -> Estimate:
    """Peak 1: PSNR = -20 log10 RMSE. Not from the PSNRs: that of a picture without error is null."""
    if rmse.value is None or rmse.value <= 0.0:
        return Estimate(None)
    error = None if rmse.standard_error is None else 20.0 / math.log(10.0) * rmse.standard_error / rmse.value
    return Estimate(-20.0 * math.log10(rmse.value), error)


_POOLS: Mapping[str, Callable[[Sequence[Estimate]], Estimate]] = {
    "rmse": _root_mean_square,
    "max": _largest,
}


def efficiency(curve: Curve) -> float | None:
    """1 / (MSE * CPU seconds); None without both, or where either is 0."""
    rmse, seconds = curve.metrics.get("rmse", Estimate(None)).value, curve.cpu_seconds.value
    if rmse is None or seconds is None or not usable(rmse) or not usable(seconds):
        return None
    product = rmse * rmse * seconds
    return 1.0 / product if product > 0.0 else None


def pareto_front(points: Sequence[tuple[float, float]]) -> list[int]:
    """The indices of the points (cost, error) that no other point beats in both, by rising cost."""
    front: list[int] = []
    for i in sorted(range(len(points)), key=lambda i: points[i]):
        if not front or points[i][1] < points[front[-1]][1]:
            front.append(i)
    return front
