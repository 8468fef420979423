"""What `aliascope doctor` asks of every renderer: where its pixels are, what becomes of a level, whether a picture
comes out the same again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from aliascope.studies.doctor_charts import PHASES, Chart, Edges, Levels
from aliascope.studies.doctor_findings import Figure, Finding, Inquiry, Shot, Shown, within

CENTRE_LIMIT = 0.005
"""Pixels that an edge may be found from its place."""

RESOLUTION = 0.5 / PHASES
"""Pixels: half of the step between two phases, the most that an edge can be misplaced by those between."""

THREADS = (2, 4)

WHITE = "white = 1"
"""The unit of levels and their differences."""

SHARES = (0.0123, 0.0521, 0.1173, 0.2619, 0.5037, 0.7871, 1.0)
"""Levels of a response, as shares of its peak."""

RAMP_START, RAMP_STEPS, STEPS_A_QUANTUM = 0.7031, 96, 8
"""A ramp of levels begins at this share of the peak, and takes so many steps, so many to a quantum."""


@dataclass(frozen=True)
class Placed:
    """How far right and down of its place an edge is found, in pixels, in the mean over all phases; and the standard
    error of these, were its error at each phase independent."""

    right: float
    down: float
    standard_error: float

    @property
    def text(self) -> str:
        return f"{self.right:+z.4f} right, {self.down:+z.4f} down"

    @property
    def values(self) -> dict[str, float]:
        return {"right": self.right, "down": self.down, "standard_error": self.standard_error}


def placed(chart: Edges, shown: Shown) -> Placed:
    """A pixel's values over all places of an edge sum to how far the picture of the edge lies from the last."""
    found, scatter = [], []
    for spread in chart.spreads(shown.pixels):
        by_phase = spread.reshape(-1, PHASES).sum(axis=0)
        errors = by_phase - (np.arange(PHASES) + 0.5) / PHASES - chart.cell // 4
        found.append(float(errors.mean()))
        scatter.append(float(errors.std()) / math.sqrt(PHASES))
    return Placed(found[0], found[1], max(scatter))


def centres(renderer: str, modes: Mapping[str, Edges]) -> Inquiry:
    """Of each mode, with the chart that it draws; those that take random samples should have enough of them."""
    name = "pixel centre"

    def judge(shown: Mapping[str, Shown]) -> Finding:
        found = {mode: placed(modes[mode], shown[mode]) for mode in modes}
        off = [mode for mode, each in found.items() if not within(max(abs(each.right), abs(each.down)), CENTRE_LIMIT)]
        means = (
            "Pictures of these modes lie upon each other and upon the references; none needs to be moved."
            if not off
            else f"{' and '.join(off)} draw everything off its place: each edge of theirs would count as an error."
        )
        return Finding(
            name,
            tuple(Figure(mode, each.text, each.values, "pixel") for mode, each in found.items()),
            f"edges within {CENTRE_LIMIT:g} pixel of their places; {PHASES} phases resolve {RESOLUTION:.3f} pixel",
            not off,
            means,
        )

    return Inquiry(name, {mode: Shot(renderer, mode, chart) for mode, chart in modes.items()}, judge)


# --- levels -----------------------------------------------------------------------------------------------------------


def _chart(peak: float, quantum: float) -> Levels:
    ramp = [RAMP_START * peak + quantum * i / STEPS_A_QUANTUM for i in range(RAMP_STEPS)]
    return Levels((*(share * peak for share in SHARES), *ramp))


def float32_step(level: float) -> float:
    """From one 32-bit float to the next, of this magnitude."""
    return float(np.spacing(np.float32(level)))


def levels(renderer: str, mode: str, formats: Mapping[str, tuple[float, float]]) -> tuple[Inquiry, Inquiry]:
    """The response and the quantum of each format: by its name the peak of a picture that has it, and its step near
    RAMP_START of that."""
    charts = {label: _chart(*each) for label, each in formats.items()}
    shots = {label: Shot(renderer, mode, chart) for label, chart in charts.items()}

    def response(shown: Mapping[str, Shown]) -> Finding:
        figures, holds = [], True
        for label, (peak, quantum) in formats.items():
            figure, good = _response(label, charts[label], shown[label], peak, quantum)
            figures.append(figure)
            holds = holds and good
        return Finding(
            "response",
            tuple(figures),
            "gain 1, gamma 1; levels come back within a step, the brightest too: nothing is clipped",
            holds,
            "The output is linear: values of different renderers are the same light, and can be subtracted."
            if holds
            else "The output is bent, scaled or clipped: every difference from another picture would be wrong by that.",
        )

    def quantum(shown: Mapping[str, Shown]) -> Finding:
        figures, holds = [], True
        for label, (peak, expected) in formats.items():
            figure, good = _quantum(label, charts[label], shown[label], peak, expected)
            figures.append(figure)
            holds = holds and good
        return Finding(
            "quantum of the output",
            tuple(figures),
            f"the steps of the formats: {', '.join(f'{expected:.4g}' for _, expected in formats.values())}",
            holds,
            "No error below half a step can be told from rounding; the report states the step beside errors."
            if holds
            else "The step is not the one that is stated beside errors: the floor of what can be told is another.",
        )

    return Inquiry("response", shots, response), Inquiry("quantum of the output", shots, quantum)


def _response(label: str, chart: Levels, shown: Shown, peak: float, quantum: float) -> tuple[Figure, bool]:
    given = peak * np.array(SHARES)
    seen = chart.shown(shown.pixels)[: len(SHARES)]
    # The same step is the larger a part of a level, the darker that is.
    gamma, intercept = np.polyfit(np.log(given / peak), np.log(np.maximum(seen / peak, 1e-9)), 1, w=given)
    gain, deviation = math.exp(float(intercept)), float(np.abs(seen - given).max())
    # Half a step by rounding; a whole one, since some round down. A float32 of the scene's level, and one of the sum.
    limit = quantum + 2.0 * float32_step(peak)
    values = {"gain": gain, "gamma": float(gamma), "deviation": deviation, "brightest_in": peak}
    text = f"gain {gain:.5f}, gamma {gamma:.5f}, off by {deviation:.1e}; {peak:g} comes back {seen[-1]:.6g}"
    return Figure(label, text, {**values, "brightest_out": float(seen[-1])}, WHITE), within(deviation, limit)


def _quantum(label: str, chart: Levels, shown: Shown, peak: float, expected: float) -> tuple[Figure, bool]:
    at = RAMP_START * peak
    ramp = np.unique(chart.shown(shown.pixels)[len(SHARES) :])
    steps = np.diff(ramp)
    least, widest = (float(steps.min()), float(steps.max())) if len(steps) else (math.nan, math.nan)
    # Steps are seen through a float32, of whose own each end may be off by half.
    near = min(float32_step(at), 0.25 * expected)
    as_stated = shown.quantum == 0.0 or within(shown.quantum - expected, 1e-3 * expected)
    return (
        Figure(
            label,
            f"{least:.4g} at {at:.4g} ({len(ramp)} levels seen, {widest:.4g} apart at most)",
            {"least": least, "widest": widest, "expected": expected, "stated": shown.quantum, "at": at},
            WHITE,
        ),
        within(least - expected, near) and within(widest - expected, near) and as_stated,
    )


# --- the same again ---------------------------------------------------------------------------------------------------


def difference(a: Shown, b: Shown) -> tuple[float, float]:
    """The root of the mean square, and the largest."""
    off = np.abs(a.pixels.astype(np.float64) - b.pixels)
    return float(np.sqrt((off * off).mean())), float(off.max())


def repeats(renderer: str, modes: Mapping[str, Chart], own_threads: bool = False, note: str = "") -> Inquiry:
    """Whether pictures are the same to the bit in a second run, and with other counts of threads: of the request, or
    llvmpipe's own. note: what is to be said beside."""
    counts = (1, *THREADS) if own_threads else THREADS
    others: dict[str, dict[str, int]] = {"a second run": {"again": 1}}
    others |= {
        f"{count} thread{'s' * (count > 1)}": {"own_threads" if own_threads else "threads": count} for count in counts
    }
    shots: dict[str, Shot] = {}
    for mode, chart in modes.items():
        shots[mode] = Shot(renderer, mode, chart)
        shots |= {f"{mode}, {label}": Shot(renderer, mode, chart, **what) for label, what in others.items()}

    def judge(shown: Mapping[str, Shown]) -> Finding:
        figures, bad = [], []
        for mode in modes:
            off = {label: difference(shown[mode], shown[f"{mode}, {label}"]) for label in others}
            differing = [
                f"{label}: rms {rms:.2g}, largest {most:.2g}" for label, (rms, most) in off.items() if most != 0.0
            ]
            bad += [mode] if differing else []
            values = {f"{label}, rms": rms for label, (rms, _) in off.items()}
            values |= {f"{label}, largest": most for label, (_, most) in off.items()}
            figures.append(Figure(mode, "; ".join(differing) or "the same bits", values, WHITE))
        threads = (
            f"llvmpipe in {', '.join(map(str, counts))} threads of its own"
            if own_threads
            else f"{' and '.join(map(str, counts))} threads"
        )
        return Finding(
            "repeatability",
            tuple(figures),
            f"the same bits in a second run, and with {threads}{note}",
            not bad,
            "A picture that is made again comes out the same, however many threads draw it."
            if not bad
            else f"Pictures of {' and '.join(bad)} differ from themselves: no smaller error of theirs can be told.",
        )

    return Inquiry("repeatability", shots, judge)
