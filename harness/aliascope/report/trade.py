"""The trade of speed for accuracy, for the page's scripts and as CSV beside it."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from aliascope.records import ReportData
from aliascope.report.pool import in_common, rounded
from aliascope.trade import analyse
from aliascope.trade.records import QUANTISATION, Afford, Convergence, Interval, Knob, OnFront, Reach, SceneTrade, Trade

Json = Any


def trade_of(data: ReportData) -> Trade:
    """The analysis of a report's rows; the front over scenes is of those that the report pools."""
    return analyse(data.scenes, together=[scene.name for scene in in_common(data.scenes)])


def trade_json(trade: Trade) -> dict[str, Json]:
    """By scene, each figure as [value, low, high], None where it is not known; modes and families by their names."""
    return {
        "base": list(trade.base) if trade.base else None,
        "quantisation": rounded(QUANTISATION),
        "scenes": {scene.scene: _scene(scene) for scene in trade.scenes},
        "ratios": [[r.renderer, r.family, _figures(r.time), _figures(r.error), list(r.scenes)] for r in trade.ratios],
        "knobs": [_knob(knob) for knob in trade.knobs],
        "front": _front(trade.front),
    }


def _front(modes: Iterable[OnFront]) -> dict[str, float]:
    """Those that are known."""
    return {f"{one.renderer} {one.mode}": round(one.probability, 3) for one in modes if one.known}


def _scene(scene: SceneTrade) -> dict[str, Json]:
    return {
        "front": _front(scene.front),
        "reach": _by_target(scene.equal_error, lambda one: one.error, _reach),
        "afford": _by_target(scene.equal_time, lambda one: one.seconds, _afford),
        "quantisation": [_reach(one) for one in scene.quantisation],
        "convergence": [_rate(one) for one in scene.convergence],
        "efficiency": {f"{one.renderer} {one.mode}": _figures(one.value) for one in scene.efficiency},
    }


def _by_target(answers: Iterable[Any], target: Callable[[Any], float], as_json: Callable[[Any], Json]) -> list[Json]:
    """[target, answers] by rising target."""
    found: dict[float, list[Json]] = {}
    for one in answers:
        found.setdefault(target(one), []).append(as_json(one))
    return [[key, found[key]] for key in sorted(found)]


def _figures(interval: Interval | None) -> list[float | None] | None:
    return [rounded(x) for x in (interval.value, interval.low, interval.high)] if interval else None


def _reach(one: Reach) -> Json:
    return [one.renderer, one.family, _figures(one.seconds), one.how, one.mode, one.label, rounded(one.best)]


def _afford(one: Afford) -> Json:
    return [one.renderer, one.family, _figures(one.error), one.how, one.mode, one.label, rounded(one.fastest)]


def _rate(one: Convergence) -> Json:
    return [one.renderer, one.family, _figures(one.exponent), _figures(one.per_time), one.curved, one.modes]


def _knob(one: Knob) -> dict[str, Json]:
    return {
        "renderer": one.renderer,
        "form": one.form,
        "knob": one.knob,
        "setting": one.setting,
        "baseline": one.baseline,
        "time": _figures(one.time),
        "error": _figures(one.error),
        "scenes": len(one.scenes),
        "pairs": one.pairs,
        "kind": one.kind,
    }


# --- beside the page --------------------------------------------------------------------------------------------------

TITLES = {
    "trade-equal-error": "Time to an error",
    "trade-equal-time": "Error after a time",
    "trade-convergence": "Convergence",
    "trade-front": "Pareto front",
    "trade-ratios": "Ratios over scenes",
    "trade-knobs": "Knobs",
}
"""The names of the tables' files, which no plot of a scene has, and what they are."""

_KNOB = ("renderer", "form", "knob", "setting", "baseline")


def trade_csv(trade: Trade) -> dict[str, str]:
    """The text of each table of TITLES that has a row; empty where unknown."""
    tables = {**_of_scenes(trade.scenes), **_over_scenes(trade)}
    return {name: _csv(head, rows) for name, (head, rows) in tables.items() if rows}


_Table = tuple[Sequence[str], list[list[object]]]


def _of_scenes(scenes: Sequence[SceneTrade]) -> dict[str, _Table]:
    return {
        "trade-equal-error": (
            ["scene", "renderer", "family", "rmse", *_ends("cpu_seconds"), "how", "mode", "best_rmse"],
            [
                [scene.scene, r.renderer, r.family, r.error, *_cells(r.seconds), r.how, r.mode, r.best]
                for scene in scenes
                for r in (*scene.equal_error, *scene.quantisation)
            ],
        ),
        "trade-equal-time": (
            ["scene", "renderer", "family", "cpu_seconds", *_ends("rmse"), "how", "mode", "fastest_cpu_seconds"],
            [
                [scene.scene, a.renderer, a.family, a.seconds, *_cells(a.error), a.how, a.mode, a.fastest]
                for scene in scenes
                for a in scene.equal_time
            ],
        ),
        "trade-convergence": (
            ["scene", "renderer", "family", *_ends("exponent"), *_ends("per_time"), "curved", "modes"],
            [
                [scene.scene, c.renderer, c.family, *_cells(c.exponent), *_cells(c.per_time), int(c.curved), c.modes]
                for scene in scenes
                for c in scene.convergence
            ],
        ),
        "trade-front": (
            ["scene", "renderer", "mode", "probability"],
            [[scene.scene, f.renderer, f.mode, f.probability] for scene in scenes for f in scene.front],
        ),
    }


def _over_scenes(trade: Trade) -> dict[str, _Table]:
    base = " ".join(trade.base or ())
    return {
        "trade-ratios": (
            ["renderer", "family", "base", *_ends("time_ratio"), *_ends("error_ratio"), "scenes"],
            [
                [r.renderer, r.family, base, *_cells(r.time), *_cells(r.error), "; ".join(r.scenes)]
                for r in trade.ratios
            ],
        ),
        "trade-knobs": (
            [*_KNOB, *_ends("time_ratio"), *_ends("error_ratio"), "scenes", "pairs", "kind"],
            [
                [*(getattr(k, key) for key in _KNOB), *_cells(k.time), *_cells(k.error), *_coverage(k)]
                for k in trade.knobs
            ],
        ),
    }


def _ends(name: str) -> list[str]:
    return [name, f"{name}_low", f"{name}_high"]


def _cells(interval: Interval | None) -> list[object]:
    return [interval.value, interval.low, interval.high] if interval else [None, None, None]


def _coverage(knob: Knob) -> list[object]:
    return ["; ".join(knob.scenes), knob.pairs, knob.kind]


def _csv(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return out.getvalue()
