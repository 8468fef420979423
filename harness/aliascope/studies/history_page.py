"""What `aliascope history` writes: history.html, and beside it in history/ the figures, the steps, a plot a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from aliascope.history import KeptRun
from aliascope.regression.records import CellName
from aliascope.report.document import number
from aliascope.report.history import Entry, HistoryPage, Place, history_page
from aliascope.report.plots import colours, svg_of
from aliascope.studies.history import SIGNIFICANCE, Answer, Step
from aliascope.studies.history_series import ALL_SCENES, TIME, Series, machine_of
from aliascope.studies.history_text import (
    between,
    change,
    figure,
    headline,
    percent,
    places,
    steps_csv,
    tested,
    values_csv,
)
from aliascope.text_files import write_text

FOLDER = "history"
DIGITS = 9
"""Of the figures in the page."""
LISTED = 12
"""Modes in the legend of a plot, those with the largest steps."""
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def write(folder: Path, answer: Answer) -> Path:
    """Writes the page and what lies beside it, returns the path of the page. Raises NotWritable."""
    write_text(folder / FOLDER / "values.csv", values_csv(answer))
    write_text(folder / FOLDER / "steps.csv", steps_csv(answer))
    for name in _scenes(answer):
        write_text(folder / FOLDER / f"{_stem(name)}.svg", plot(answer, name))
    return write_text(folder / "history.html", history_page(page_of(answer)))


def page_of(answer: Answer) -> HistoryPage:
    """The page."""
    names = _names(answer)
    rows = {name: i for i, name in enumerate(names)}
    found = places(answer)
    return HistoryPage(
        lead=headline(answer) + ".",
        facts=(f"{len(answer.runs)} run{'s' * (len(answer.runs) != 1)}", f"last {answer.runs[-1].started[:10]}"),
        places=tuple(
            Place(
                _capital(between(answer.runs, before, after)),
                tuple(_entry(step, rows, answer) for step in steps),
                tuple(dict.fromkeys(cause for step in steps for cause in step.also)),
            )
            for (before, after), steps in found
        ),
        notes=_notes(answer),
        runs=tuple(_run_row(run) for run in reversed(answer.runs)),
        files=(
            (f"{FOLDER}/values.csv", "every figure of every run"),
            (f"{FOLDER}/steps.csv", "every step"),
            *((f"{FOLDER}/{_stem(name)}.svg", name) for name in _scenes(answer)),
        ),
        data=_data(answer, names),
        renderers=list(dict.fromkeys(name.renderer for name in names)),
    )


def _names(answer: Answer) -> list[CellName]:
    """Of all series, scene by scene."""
    names = dict.fromkeys(one.name for one in answer.series)
    return sorted(names, key=lambda name: (name.scene != ALL_SCENES, name.scene, name.renderer, name.mode))


def _scenes(answer: Answer) -> list[str]:
    return list(dict.fromkeys(name.scene for name in _names(answer)))


def _stem(scene: str) -> str:
    """The name of a scene's plot: a scene may be a file of anybody's."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "-_.") else "-" for c in scene).strip(".") or "scene"


def _entry(step: Step, rows: Mapping[CellName, int], answer: Answer) -> Entry:
    one = step.series
    return Entry(
        row=rows[one.name],
        scene=one.name.scene,
        renderer=one.name.renderer,
        mode=one.name.mode,
        metric=one.metric,
        machine=one.machine if len(answer.machines) > 1 else "",
        levels="" if one.name.scene == ALL_SCENES else f"{figure(step.old, step.new)} → {figure(step.new, step.old)}",
        change=_size(step),
        interval=_minus(" to ".join(map(percent, step.interval))) if step.interval else "",
        why=_why(step),
        up=step.new > step.old,
    )


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _size(step: Step) -> str:
    return _minus(percent(step.ratio) if step.ratio is not None else change(step))


def _minus(text: str) -> str:
    return text.replace("-", "\u2212")


def _why(step: Step) -> str:
    if step.p_value is None:
        return "exact"
    digits, _, power = f"{step.p_value:.1e}".partition("e")
    if int(power) >= -3:
        return f"p\u00a0=\u00a0{step.p_value:.2g}"
    return f"p\u00a0=\u00a0{digits}\u202f×\u202f10{str(int(power)).translate(_SUPERSCRIPTS)}"


def _notes(answer: Answer) -> tuple[tuple[str, str], ...]:
    return (
        ("Steps", " ".join(tested(answer))),
        (
            "Exact figures",
            "An error counts as exact once three runs on one machine gave the same to the last digit. Figures of "
            "different machines are alike up to 1 in 1,000, as another instruction set may let a ray miss what it hit. "
            "A plus sign after a revision says that the source had changes.",
        ),
        (
            "Times",
            "The median over the pictures of a mode, compared on one machine alone, by ranks, so that one slow run is "
            "no step: of all places at which a series can be divided in two, or a stretch of it be taken out, the most "
            "telling one, its p-value for all places (Bonferroni, or by permutation); then each part again. "
            "All scenes: the median over all modes of a "
            f"renderer, each over its own median. All tests together have {SIGNIFICANCE:g}. Runs are taken for "
            "independent: a machine that was slow for a week looks like a step, in all modes.",
        ),
        (
            "Tinted ranges",
            "Where a step lies, in 95 % of cases; of exact figures, between two runs.",
        ),
    )


def _run_row(run: KeptRun) -> tuple[str, ...]:
    failed = sum(not cell.passed for cell in run.cells)
    passed = "yes" if run.passed else f"no, {failed} of {len(run.cells)} modes" if failed else "no"
    versions = ", ".join(f"{name} {version}" for name, version in run.versions.items())
    machine = ", ".join(filter(None, (machine_of(run), run.machine.get("system", ""))))
    return run.revision, run.started[:16].replace("T", " "), passed, machine, versions


# --- what the scripts read --------------------------------------------------------------------------------------------


def _data(answer: Answer, names: Sequence[CellName]) -> dict[str, Any]:
    machines = answer.machines
    failed: dict[CellName, list[int]] = {}
    for index, run in enumerate(answer.runs):
        for cell in run.cells:
            if not cell.passed:
                failed.setdefault(cell.name, []).append(index)
    series: dict[CellName, list[Series]] = {}
    for one in answer.series:
        series.setdefault(one.name, []).append(one)
    steps: dict[CellName, list[Step]] = {}
    for step in answer.steps:
        steps.setdefault(step.series.name, []).append(step)
    return {
        "runs": [
            {
                "revision": run.revision,
                "started": run.started,
                "machine": machines.index(machine_of(run)),
                "system": run.machine.get("system", "unknown"),
                "versions": dict(run.versions),
                "passed": run.passed,
            }
            for run in answer.runs
        ],
        "machines": machines,
        "metrics": list(dict.fromkeys(one.metric for one in answer.series)),
        "rows": [
            {
                "scene": name.scene,
                "renderer": name.renderer,
                "mode": name.mode,
                "figures": [_figures(one, machines) for one in series[name]],
                "steps": [_step(step, machines, answer) for step in steps.get(name, [])],
                "failed": failed.get(name, []),
            }
            for name in names
        ],
    }


def _figures(one: Series, machines: Sequence[str]) -> dict[str, Any]:
    points = [
        [point.run, _short(point.value), *([_short(point.standard_error)] if point.standard_error else [])]
        for point in one.points
    ]
    return {"metric": one.metric, "machine": _machine(one, machines), "kind": one.kind, "points": points}


def _short(value: float | None) -> float | None:
    found = number(value)
    if found is None or found == int(found):
        return found if found is None else int(found)
    return float(f"{found:.{DIGITS}g}")


def _machine(one: Series, machines: Sequence[str]) -> int | None:
    return machines.index(one.machine) if one.machine else None


def _step(step: Step, machines: Sequence[str], answer: Answer) -> dict[str, Any]:
    return {
        "metric": step.series.metric,
        "machine": _machine(step.series, machines),
        "before": step.before,
        "at": step.at,
        "after": step.after,
        "change": _size(step),
        "why": _why(step),
        "where": between(answer.runs, step.before, step.after),
        "up": step.new > step.old,
    }


# --- a plot a scene ---------------------------------------------------------------------------------------------------


def plot(answer: Answer, scene: str) -> str:
    """Errors above, times below, each over its first level, as SVG; what did not change is grey."""
    own = [one for one in answer.series if one.name.scene == scene]
    shown = [(metric, [one for one in own if one.metric == metric]) for metric in ("rmse", TIME)]
    shown = [(metric, series) for metric, series in shown if series] or [(own[0].metric, own)]
    palette = colours([one.name.renderer for one in own])

    def draw(page: Figure) -> None:
        panels = page.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (metric, series) in zip(panels, shown, strict=True):
            _draw(axes, answer, series, palette)
            axes.set_ylabel({"rmse": "RMSE", TIME: "CPU time"}.get(metric, metric) + " over its first level")
        panels[0].set_title(scene, loc="left", fontsize=9, fontweight="bold")
        _label_runs(panels[-1], answer.runs)
        found = [found for axes in panels for found in zip(*axes.get_legend_handles_labels(), strict=True)]
        if found:
            more = [Line2D([], [], linestyle="none", label=f"and {len(found) - LISTED} more")] * (len(found) > LISTED)
            page.legend(handles=[*(line for line, _ in found[:LISTED]), *more], loc="outside lower center", fontsize=6)

    return svg_of(draw, (7.0, 2.4 + 1.9 * len(shown)))


def _largest(answer: Answer) -> Callable[[Series], float]:
    """How large the largest step of a series is."""
    sizes: dict[Series, float] = {}
    for step in answer.steps:
        sizes[step.series] = max(sizes.get(step.series, 0.0), abs(math.log(step.ratio or math.e)))
    return lambda one: sizes.get(one, 0.0)


def _draw(axes: Axes, answer: Answer, series: Iterable[Series], palette: Mapping[str, str]) -> None:
    axes.grid(axis="y", linewidth=0.3, color="#dddddd")
    for one in sorted(series, key=_largest(answer), reverse=True):
        steps = sorted((step for step in answer.steps if step.series == one), key=lambda step: step.at)
        first = [point.value for point in one.points if not steps or point.run < steps[0].at]
        level = sorted(first)[len(first) // 2] if first else 0.0
        if not level:
            continue
        x, y = [point.run for point in one.points], [point.value / level for point in one.points]
        if not steps:
            axes.plot(x, y, color="#bbbbbb", linewidth=0.5, zorder=1, marker="." if len(x) == 1 else None, markersize=2)
            continue
        colour = palette.get(one.name.renderer, "#666666")
        axes.plot(x, y, color=colour, linewidth=0.9, marker=".", markersize=3, zorder=2)
        sizes = ", ".join(change(step) for step in steps)
        axes.lines[-1].set_label(f"{one.name.renderer} {one.name.mode}, {one.metric}: {sizes}")
        for step in steps:
            axes.axvline(step.at - 0.5, color=colour, linewidth=0.5, linestyle=(0, (3, 3)), zorder=1)
    low, high = axes.get_ylim()
    room = max(0.0, 0.02 - (high - low) / 2.0)
    axes.set_ylim(low - room, high + room)


def _label_runs(axes: Axes, runs: Sequence[KeptRun]) -> None:
    """Some ten revisions, the last among them."""
    every = max(1, math.ceil(len(runs) / 10))
    at = list(range(len(runs) - 1, -1, -every))
    axes.set_xticks(at, [f"{runs[i].revision[:7]}\n{runs[i].started[:10]}" for i in at], fontsize=6)
    axes.set_xlim(-0.5, len(runs) - 0.5)
