"""The trade in words: lines for a terminal, sentences for a page, and a document for programs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any, TypeVar

from aliascope.trade.records import Afford, Interval, Knob, Ratio, Reach, SceneTrade, Trade

_Answer = TypeVar("_Answer", Reach, Afford)


def document(trade: Trade) -> dict[str, Any]:
    """All of it, as numbers, texts, lists and objects alone."""
    return {
        "scenes": [asdict(scene) for scene in trade.scenes],
        "base": {"renderer": trade.base[0], "family": trade.base[1]} if trade.base else None,
        "ratios": [asdict(ratio) for ratio in trade.ratios],
        "knobs": [asdict(knob) for knob in trade.knobs],
    }


def lines(trade: Trade) -> list[str]:
    """What a person reads: of one scene what each error and time comes to, of several the ratios over all of them."""
    if len(trade.scenes) == 1:
        scene = trade.scenes[0]
        errors = dict.fromkeys(reach.error for reach in scene.equal_error)
        times = dict.fromkeys(afford.seconds for afford in scene.equal_time)
        return [*(to_reach(scene, error) for error in errors), *(within(scene, seconds) for seconds in times)]
    told = [ratio for ratio in trade.ratios if (ratio.renderer, ratio.family) != trade.base]
    against = [f"against {' '.join(trade.base)}, at equal RMSE and at equal time:"] if trade.base and told else []
    return [*against, *map(ratio_line, told), *map(knob_line, trade.knobs)]


def to_reach(scene: SceneTrade, error: float) -> str:
    """What each renderer's soonest family takes: "to reach RMSE 0.01: embree uniform random 0.12 s [0.11, 0.13],
    osmesa msaa, n=8 cannot (best 0.034)"."""
    found = [reach for reach in scene.equal_error if reach.error == error]
    best = _by_renderer(found, lambda reach: (reach.seconds.value if reach.seconds else float("inf"), reach.best))
    return f"to reach RMSE {error:g}: {', '.join(map(reach_words, best))}"


def within(scene: SceneTrade, seconds: float) -> str:
    """What each renderer's best family comes to: "in 0.1 s: embree uniform random 0.012 [0.011, 0.013], povray am2,
    depth=3 cannot (fastest 0.19 s)"."""
    found = [afford for afford in scene.equal_time if afford.seconds == seconds]
    best = _by_renderer(found, lambda afford: (afford.error.value if afford.error else float("inf"), afford.fastest))
    return f"in {time_text(seconds)}: {', '.join(map(afford_words, best))}"


def _by_renderer(found: Sequence[_Answer], rank: Callable[[_Answer], tuple[float, float]]) -> list[_Answer]:
    """The best family of each renderer, in the order of renderers."""
    names = dict.fromkeys(each.renderer for each in found)
    return [min((each for each in found if each.renderer == name), key=rank) for name in names]


def reach_words(reach: Reach) -> str:
    """One family, at one error."""
    if reach.seconds is None:
        return f"{reach.renderer} {reach.label} cannot (best {digits(reach.best)})"
    extrapolated = " (extrapolated)" if reach.how == "extrapolated" else ""
    return f"{_name(reach)} {time_interval(reach.seconds)}{extrapolated}"


def afford_words(afford: Afford) -> str:
    """One family, at one time."""
    if afford.error is None:
        return f"{afford.renderer} {afford.label} cannot (fastest {time_text(afford.fastest)})"
    extrapolated = " (extrapolated)" if afford.how == "extrapolated" else ""
    return f"{_name(afford)} {interval_text(afford.error)}{extrapolated}"


def _name(answer: Reach | Afford) -> str:
    """The mode where the figure is its own, the family where it lies between modes or beyond them."""
    return f"{answer.renderer} {answer.label if answer.how == 'measured' else answer.family}"


def ratio_line(ratio: Ratio) -> str:
    """One family against the base: "povray am2: time x 6.9 [3.2, 15], RMSE x 6.6 [2.3, 19] (10 scenes)"."""
    time, error = (interval_text(found) if found else "not known" for found in (ratio.time, ratio.error))
    return f"{ratio.renderer} {ratio.family}: time x {time}, RMSE x {error} ({_count(ratio.scenes)})"


def knob_line(knob: Knob) -> str:
    """One setting: "povray am2 depth=4 against 3: time x 2.1 [1.7, 2.6], RMSE x 0.69 [0.52, 0.92] (10 scenes)"."""
    return (
        f"{knob.renderer} {knob.form} {knob.knob}={knob.setting} against {knob.baseline}: "
        f"time x {interval_text(knob.time)}, RMSE x {interval_text(knob.error)} ({_count(knob.scenes)})"
    )


def _count(scenes: Sequence[str]) -> str:
    return f"{len(scenes)} scene{'' if len(scenes) == 1 else 's'}"


def time_text(seconds: float) -> str:
    """A time with its unit, to two digits."""
    return f"{digits(seconds * 1e3)} ms" if seconds < 0.0995 else f"{digits(seconds)} s"


def time_interval(interval: Interval) -> str:
    """A time and its interval, in the unit of the time: "0.12 s [0.11, 0.13]"."""
    scale = 1e3 if interval.value < 0.0995 else 1.0
    return f"{time_text(interval.value)}{_ends(interval, scale)}"


def interval_text(interval: Interval) -> str:
    """A figure and its interval."""
    return f"{digits(interval.value)}{_ends(interval, 1.0)}"


def _ends(interval: Interval, scale: float) -> str:
    if interval.low is None and interval.high is None:
        return ""
    low, high = ("?" if end is None else digits(end * scale) for end in (interval.low, interval.high))
    return f" [{low}, {high}]"


def digits(value: float) -> str:
    """Two digits, and all those before the point."""
    return f"{value:.0f}" if value >= 99.5 else f"{value:.2g}"
