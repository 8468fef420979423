"""`aliascope knobs`: what one setting of one key does to time and error, on few scenes, all other keys as they are.

The modes are those of the profile "knobs", rendered and measured as `aliascope compare` does; filters are turned too,
on one scene, each against a reference of its own that is made in passing. Measures of point sets are turned between
the exact and the bounded (`knob_measures`).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from aliascope import jobs, knob_modes, places, references
from aliascope import plan as plans
from aliascope.cluster.client import Cluster
from aliascope.draws import UNMOVED
from aliascope.errors import JobFailed
from aliascope.jobs import Plan
from aliascope.pipeline import Options, Progress
from aliascope.references import files as reference_files
from aliascope.studies import compare as comparing
from aliascope.studies import knob_measures, selection
from aliascope.studies.compare import Comparison
from aliascope.studies.converging import apart, converging
from aliascope.trade import analyse
from aliascope.trade.records import Knob

PROFILE = "knobs"

FILTER_SAMPLES = 256
"""Of a pixel in each of 32 pictures of a filter's reference: a sixteenth of what kept references have. Its standard
error is a fiftieth of the errors that it judges, and counts in their intervals."""


@dataclass(frozen=True)
class Turned:
    """What the knobs came to: those of modes, then of measures."""

    comparison: Comparison
    plan: Plan
    knobs: tuple[Knob, ...]


def plan_of(scenes: Sequence[str], chosen: Sequence[str], size: tuple[int, int] | None) -> Plan:
    """The pictures of the scenes, or of SCENES, by these renderers, or by all that are there."""
    made = selection.plan_of(scenes or knob_modes.SCENES, chosen, [], PROFILE, size)
    file = made.files.get(knob_modes.FILTER_SCENE)
    if "embree" in (chosen or ["embree"]) and file is not None and file.path.parent == places.SCENES:
        more = jobs.make_plan([file], {"embree": knob_modes.FILTERS}, plans.SEEDS[PROFILE], size)
        made = replace(made, jobs=tuple(sorted({*made.jobs, *more.jobs}, key=lambda job: job.key)))
    return replace(made, about=f"{PROFILE} profile")


def turn(
    plan: Plan,
    folder: Path,
    options: Options,
    command: str,
    progress: Progress,
    tell: Callable[[str], None],
    cluster: Cluster | None = None,
) -> Turned:
    """Renders, measures and writes the report, as `compare.compare`, which says what is raised. Measures of point sets
    are timed here, whatever the `cluster`."""
    comparing.check_drawn(plan)
    _make_filter_references(plan, folder / "references", progress)
    measures = knob_measures.knobs(knob_measures.TURNS, knob_measures.SETS, progress)
    result = comparing.compare(plan, folder, options, command, progress, tell, measures, cluster)
    return Turned(result, plan, (*analyse(result.data.scenes).knobs, *measures))


def _make_filter_references(plan: Plan, folder: Path, progress: Progress) -> None:
    """Those of FILTERS that are not kept and not there yet, from fewer samples than `compare` would take."""
    asked = {jobs.judged_by(job): (job.width, job.height) for job in plan.jobs}
    threads = len(os.sched_getaffinity(0))
    with apart() as draw:
        for (name, filter_, shift), size in sorted(asked.items()):
            path = reference_files.path_of(folder, name, size, filter_)
            if filter_ in ("box", *plans.FILTERS) or shift != UNMOVED or path.is_file():
                continue
            what = f"reference of {name}, {size[0]} x {size[1]} pixels, filter {filter_}"
            progress(what, 0, 1)
            converged = references.Plan(FILTER_SAMPLES, threads=threads, tell=converging(what, progress), apart=draw)
            scene = plan.files[name].scene
            with suppress(JobFailed):  # which is told of its pictures, if it does so again
                made = references.make(scene, size, filter_, converged)
                reference_files.save(folder, name, scene, size, filter_, made)
