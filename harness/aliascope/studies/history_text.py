"""What `aliascope history` says: lines, one JSON document, CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from typing import Any

from aliascope.history import KeptRun
from aliascope.report.document import number
from aliascope.studies.history import SIGNIFICANCE, Answer, Step
from aliascope.studies.history_series import ALL_SCENES, TIME, Series, machine_of, named

SHOWN = 8
"""Steps of one place that are listed; the files have all."""


def lines(answer: Answer) -> Iterable[str]:
    """The text for a terminal: steps, newest first, those of one place together, the largest first."""
    yield headline(answer) + "."
    for (before, after), steps in places(answer):
        yield ""
        yield f"{between(answer.runs, before, after)}: {_counted(len(steps), 'step')}"
        shown = [(step.series.metric, name_of(step.series, answer), size(step)) for step in steps[:SHOWN]]
        widths = [max(len(row[column]) for row in shown) for column in (0, 1)]
        for metric, name, told in shown:
            yield f"  {metric:{widths[0]}}  {name:{widths[1]}}  {told}"
        for cause in dict.fromkeys(cause for step in steps for cause in step.also):
            yield f"  also changed there: {cause}"
        if len(steps) > SHOWN:
            yield f"  and {len(steps) - SHOWN} more, in history/steps.csv"
    yield ""
    yield from tested(answer)


def headline(answer: Answer) -> str:
    """How many of what there are."""
    runs, cells = answer.runs, answer.cells
    started = [run.started[:10] for run in runs]
    days = min(started) if min(started) == max(started) else f"{min(started)} to {max(started)}"
    steps = _counted(len(answer.steps), "step") if answer.steps else "no steps"
    return (
        f"{_counted(len(runs), 'run')} of {_counted(len(answer.revisions), 'revision')} on "
        f"{_counted(len(answer.machines), 'machine')}, {days}; {_counted(len(cells), 'mode')} on "
        f"{_counted(len({name.scene for name in cells}), 'scene')}; {steps}"
    )


def tested(answer: Answer) -> Iterable[str]:
    """How steps are told from chance, in sentences."""
    yield (
        "Samples, rays, and errors that are the same from run to run are exact: any change of theirs is a step. "
        "Intervals are of 95 %; those of exact errors say what other seeds would have."
    )
    if answer.tests:
        count, were = _counted(answer.tests, "series", "series"), "was" if answer.tests == 1 else "were"
        yield (
            f"{count} of times, each on one machine, or of errors with other seeds {were} "
            f"tested for changes, with {SIGNIFICANCE:g} as the chance of a false alarm in all together."
        )
    if answer.untested:
        yield (
            f"{_counted(answer.untested, 'series', 'series')} of times {'has' if answer.untested == 1 else 'have'} too "
            "few runs on one machine to be tested."
        )


def places(answer: Answer) -> list[tuple[tuple[int, int], list[Step]]]:
    """The steps that lie between the same runs, newest first; in each place the largest first, whole renderers before
    their modes.

    Where a test can only say that steps of one figure of a renderer, all up or all down, lie in ranges that overlap,
    they are taken for one, which lies where all of the ranges are.
    """
    together: dict[tuple[object, ...], list[list[Step]]] = {}
    for step in sorted(answer.steps, key=lambda step: step.after):
        one = step.series
        up = step.new > step.old
        key = (
            (one.metric, one.name.renderer, one.machine, up) if step.p_value is not None else (step.before, step.after)
        )
        groups = together.setdefault(key, [])
        # In the order of their ends: the first of a group ends first.
        if groups and step.before < groups[-1][0].after:
            groups[-1].append(step)
        else:
            groups.append([step])
    found: dict[tuple[int, int], list[Step]] = {}
    for groups in together.values():
        for steps in groups:
            found.setdefault((max(step.before for step in steps), steps[0].after), []).extend(steps)
    for steps in found.values():
        steps.sort(key=lambda step: (step.series.name.scene != ALL_SCENES, -_amount(step)))
    return sorted(found.items(), key=lambda item: (-item[0][1], -item[0][0]))


def _amount(step: Step) -> float:
    return abs(math.log(step.ratio)) if step.ratio and step.ratio > 0.0 else math.inf


def between(runs: Sequence[KeptRun], before: int, after: int) -> str:
    """Where a step is: revisions, and their days."""
    old, new = runs[before], runs[after]
    if old.revision == new.revision:
        what = old.revision if named(old.revision) else f"source {old.revision}"
        return f"between two runs of {what} ({_minute(old)}, {_minute(new)})"
    return f"between {old.revision} and {new.revision} ({old.started[:10]}, {new.started[:10]})"


def _minute(run: KeptRun) -> str:
    return run.started[:16].replace("T", " ")


def name_of(series: Series, answer: Answer) -> str:
    """Scene, renderer and mode; the machine where there are several and it is of one."""
    machine = f" ({series.machine})" if series.machine and len(answer.machines) > 1 else ""
    return series.name.text + machine


def size(step: Step) -> str:
    """Old and new level, the change, its interval, and why it is one."""
    if step.series.name.scene == ALL_SCENES:  # the levels are relative as they are
        figures = ""
    else:
        figures = f"{figure(step.old, step.new)} → {figure(step.new, step.old)}  "
    why = "exact" if step.p_value is None else f"p = {step.p_value:.2g}"
    return f"{figures}{change(step)}  {why}"


def change(step: Step) -> str:
    """The relative change and its interval."""
    if step.ratio is None:
        return "new" if step.new else "gone"
    text = percent(step.ratio)
    return f"{text} [{percent(step.interval[0])}, {percent(step.interval[1])}]" if step.interval else text


def percent(ratio: float) -> str:
    """+10.2 %; ×12 from a factor of 10; as many digits as a small change takes."""
    if ratio >= 10.0 or ratio <= 0.1:
        return f"×{ratio:.3g}"
    value = 100.0 * (ratio - 1.0)
    if value == 0.0:
        return "0 %"
    digits = max(1, -math.floor(math.log10(abs(value)))) if abs(value) < 10.0 else 1
    return f"{value:+.{min(digits, 12)}f} %"


def figure(value: float, other: float) -> str:
    """A figure beside another with enough digits to tell them apart, four at least."""
    digits = 4
    while digits < 12 and value != other and f"{value:.{digits}g}" == f"{other:.{digits}g}":
        digits += 1
    whole = value == round(value) and abs(value) < 1e15
    return f"{value:,.0f}" if whole else f"{value:.{digits}g}"


def _counted(count: int, one: str, several: str | None = None) -> str:
    return f"{count:,} {one if count == 1 else several or one + 's'}"


# --- documents --------------------------------------------------------------------------------------------------------


def document(answer: Answer) -> dict[str, Any]:
    """What --json prints."""
    return {
        "runs": [_run(run) for run in answer.runs],
        "series": [
            {
                **_name(one),
                "kind": one.kind,
                "points": [
                    {"run": point.run, "value": number(point.value), "standard_error": number(point.standard_error)}
                    for point in one.points
                ],
            }
            for one in answer.series
        ],
        "steps": [_step(step, answer) for step in answer.steps],
        "significance": SIGNIFICANCE,
        "tests": answer.tests,
        "level": answer.level,
        "untested": answer.untested,
    }


def _run(run: KeptRun) -> dict[str, Any]:
    return {
        "started": run.started,
        "revision": run.revision,
        "machine": dict(run.machine),
        "versions": dict(run.versions),
        "command": run.command,
        "wall_seconds": number(run.wall_seconds),
        "passed": run.passed,
        "failed_cells": [cell.name.text for cell in run.cells if not cell.passed],
    }


def _name(one: Series) -> dict[str, Any]:
    name = one.name
    return {
        "scene": name.scene,
        "renderer": name.renderer,
        "mode": name.mode,
        "metric": one.metric,
        "machine": one.machine or None,
    }


def _step(step: Step, answer: Answer) -> dict[str, Any]:
    runs = answer.runs
    return {
        **_name(step.series),
        "before": {"run": step.before, "revision": runs[step.before].revision},
        "at": {"run": step.at, "revision": runs[step.at].revision},
        "after": {"run": step.after, "revision": runs[step.after].revision},
        "old": number(step.old),
        "new": number(step.new),
        "ratio": number(step.ratio),
        "interval": list(step.interval) if step.interval else None,
        "p_value": number(step.p_value),
        "exact": step.p_value is None,
        "also": list(step.also),
    }


def steps_csv(answer: Answer) -> str:
    """One row a step, newest first."""
    head = ("before", "after", "started_before", "started_after", "scene", "renderer", "mode", "metric", "machine")
    rows = []
    for step in answer.steps:
        old, new, one = answer.runs[step.before], answer.runs[step.after], step.series
        low, high = step.interval or (None, None)
        place = (old.revision, new.revision, old.started, new.started)
        rows.append(
            (
                *(*place, one.name.scene, one.name.renderer, one.name.mode, one.metric, one.machine),
                *(number(step.old), number(step.new), number(step.ratio), low, high, number(step.p_value)),
                "; ".join(step.also),
            )
        )
    figures = ("old", "new", "ratio", "ratio_low", "ratio_high", "p_value", "also_changed")
    return _csv((*head, *figures), rows)


def values_csv(answer: Answer) -> str:
    """One row a figure of a run, in the order of the runs."""
    head = ("started", "revision", "machine", "scene", "renderer", "mode", "metric", "value", "standard_error")
    rows = []
    for one in answer.series:
        for point in one.points:
            run = answer.runs[point.run]
            name = (one.name.scene, one.name.renderer, one.name.mode, one.metric)
            error = number(point.standard_error)
            rows.append((point.run, (run.started, run.revision, machine_of(run), *name, number(point.value), error)))
    rows.sort(key=lambda row: row[0])
    return _csv(head, [row for _, row in rows])


def _csv(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return out.getvalue()


def unit(metric: str) -> str:
    """What a metric is counted in, for an axis."""
    return {"rmse": "RMSE", TIME: "CPU seconds a picture", "samples": "samples a picture"}.get(
        metric, f"{metric.removeprefix('rays-')} rays a picture"
    )
