"""`aliascope compare`: the same scenes by every renderer and mode, measured, kept, and told."""

from __future__ import annotations

import math
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from aliascope import image, jobs, metrics, pipeline, places, references, renderers, trade
from aliascope.errors import CheckFailed, Interrupted, NotWritable, Unsupported
from aliascope.jobs import Plan
from aliascope.pipeline import Options, Progress
from aliascope.plan import FILTERS
from aliascope.records import Estimate, Failure, ModeRow, Outcome, ReportData, SceneSection
from aliascope.references import Reference
from aliascope.references import files as reference_files
from aliascope.report import write_report
from aliascope.specs import family, label
from aliascope.statistics import mean, root_mean_square
from aliascope.store import Store
from aliascope.studies import probes
from aliascope.studies.headlines import headlines
from aliascope.studies.progress import converging
from aliascope.trade import words
from aliascope.workers import Workers


@dataclass(frozen=True)
class Comparison:
    """What a comparison came to."""

    report: Path
    data: ReportData
    rendered: int
    outcomes: Mapping[str, Outcome]


def compare(
    plan: Plan,
    folder: Path,
    options: Options,
    command: str,
    progress: Progress,
    tell: Callable[[str], None],
) -> Comparison:
    """Renders what `folder` does not have yet, and writes results and report there. `tell` is given what a user has to
    know, `progress` what takes time.

    Raises CheckFailed for a scene of the project without its reference, Unsupported for a scene that nothing draws,
    NotWritable for the folder.
    """
    begun, started = time.perf_counter(), datetime.now(UTC).isoformat(timespec="seconds")
    sizes = {jobs.judged_by(job): (job.width, job.height) for job in plan.jobs}
    check_drawn(plan)
    kept = folder / "references"
    judged = {key: reference_of(plan, key, size, kept, progress, tell) for key, size in sizes.items()}
    with Store(folder / "results.sqlite") as store:
        _check_writable(folder)
        versions = {**plan.versions, **plan.plugins}
        store.begin_run(started, command, places.revision(), places.machine(), versions)
        pixels = {key: reference.pixels for key, reference in judged.items()}
        try:
            with Workers(pipeline.side_by_side(options.processes)) as workers:
                outcomes, reused = pipeline.execute(plan, folder, store, pixels, options, progress, workers)
                probed = probes.of_those_that_drew(outcomes.values(), plan.skipped, store, options, progress, workers)
        except KeyboardInterrupt as error:
            raise Interrupted("interrupted; what was finished is kept, and the same command goes on from it") from error
    # The box first: it is what all three renderers have.
    order = sorted(judged, key=lambda key: (list(plan.files).index(key[0]), key[1] != "box", key[1]))
    sections = tuple(_section(plan, key, judged[key], outcomes, folder) for key in order)
    data = ReportData(
        title=f"aliascope compare, {plan.about}" if plan.about else "aliascope compare",
        started=started,
        wall_seconds=time.perf_counter() - begun,
        pictures=sum(outcome.status == "done" for outcome in outcomes.values()),
        reused=reused,
        headlines=headlines(sections),
        scenes=sections,
        failures=tuple(
            Failure(
                job.scene, job.renderer, job.mode, outcome.message, pipeline.repeat_command(job, options.time_limit)
            )
            for job, outcome in ((job, outcomes[job.key]) for job in plan.jobs)
            if outcome.status == "failed"
        ),
        machine={**places.machine(), "jobs side by side": _side_by_side(outcomes.values())},
        versions={"aliascope": f"{places.own_version()} ({places.revision()})", **versions},
        metrics=metrics.ABOUT,
        skipped=plan.skipped,
        undrawn=tuple(cell for cell in plan.empty if (cell.scene, "box") not in judged),
        probes=probed,
        probe_limits=probes.LIMITS,
    )
    return Comparison(write_report(folder, data), data, len(outcomes) - reused, outcomes)


def _side_by_side(outcomes: Iterable[Outcome]) -> str:
    """How far the times can be compared, for the report."""
    done = [outcome for outcome in outcomes if outcome.status == "done"]
    counts = Counter(outcome.processes for outcome in done)
    if set(counts) <= {1}:
        idle = {job.renderer for job in (outcome.job for outcome in done) if renderers.find(job.renderer).idles}
        beside = f", but for {pipeline.IDLE_ABREAST} at a time of {', '.join(sorted(idle))}, asleep for most of a run"
        return f"1: each picture was timed alone{beside if idle else ''}"
    told = ", ".join(f"{found} of the pictures {processes}" for processes, found in sorted(counts.items()))
    return f"{told}: those with more than 1 have inflated times; run again with -j 1 for times that can be compared"


def check_drawn(plan: Plan) -> None:
    """Raises Unsupported where nothing draws any of the scenes."""
    if plan.empty and not plan.jobs:
        cell = plan.empty[0]
        raise Unsupported(f"{cell.scene}: no mode draws it: {cell.reason}")


def _check_writable(folder: Path) -> None:
    try:
        (folder / "images").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise NotWritable(f"{folder}: cannot be written: {error.strerror}; choose another folder with -o") from error


def reference_of(
    plan: Plan,
    key: tuple[str, str],
    size: tuple[int, int],
    folder: Path,
    progress: Progress,
    tell: Callable[[str], None],
) -> Reference:
    """The kept reference of a scene of the project at its own size, of a filter that the profiles judge. Any other is
    made now and kept in `folder`: exact where there is a method, else converged."""
    name, filter_ = key
    file = plan.files[name]
    if file.path.parent == places.SCENES and size == file.scene.view.size and filter_ in ("box", *FILTERS):
        return reference_files.load(places.REFERENCES, name, file.scene, size, filter_)
    if reference_files.path_of(folder, name, size, filter_).is_file():
        try:
            return reference_files.load(folder, name, file.scene, size, filter_)
        except CheckFailed as error:  # of an earlier version of the scene
            tell(str(error).partition("; ")[0])
    what = f"reference of {name}, {size[0]} x {size[1]} pixels, filter {filter_}"
    progress(what, 0, 1)
    converged = references.Plan(threads=len(os.sched_getaffinity(0)), tell=converging(what, progress))
    made = references.make(file.scene, size, filter_, converged)
    reference_files.save(folder, name, file.scene, size, filter_, made)
    return made


def _section(
    plan: Plan, key: tuple[str, str], reference: Reference, outcomes: Mapping[str, Outcome], folder: Path
) -> SceneSection:
    """What one reference judged: a scene under one filter."""
    name, filter_ = key
    scene = plan.files[name].scene
    order = list(renderers.RENDERERS)
    groups: dict[tuple[str, str], list[Outcome]] = {}
    for job in sorted(plan.jobs, key=lambda job: job.seed):
        outcome = outcomes[job.key]
        if jobs.judged_by(job) == key and outcome.status == "done":
            groups.setdefault((job.renderer, job.mode), []).append(outcome)
    rows = [_row(group, folder, reference) for group in groups.values()]
    rows.sort(key=lambda row: (order.index(row.renderer), row.family, row.samples_per_pixel))
    box = filter_ == "box"
    return SceneSection(
        name=name if box else f"{name}, {filter_}",
        title=scene.title if box else f"{scene.title}, filtered with {filter_}",
        shows=scene.shows,
        reference=reference.pixels,
        reference_note=note_of(reference),
        rows=tuple(rows),
        empty=tuple(cell for cell in plan.empty if cell.scene == name) if box else (),
        filter=filter_,
    )


def note_of(reference: Reference) -> str:
    """How a reference was made and how exact it is, in a few words."""
    if reference.standard_error is None:
        return f"exact ({reference.method}), error below {reference.error:.1g}"
    spread = math.sqrt(float((reference.standard_error**2).mean()))
    return f"converged, standard error {spread:.1g} a pixel"


def _row(outcomes: Sequence[Outcome], folder: Path, reference: Reference) -> ModeRow:
    """One mode's pictures, the first seed's first."""
    first = outcomes[0]
    assert first.cost is not None
    spec = renderers.mode_of(renderers.find(first.job.renderer), first.job.mode)
    counts = folder / pipeline.counts_path(first.image)
    return ModeRow(
        renderer=first.job.renderer,
        mode=first.job.mode,
        label=label(spec),
        family=family(spec),
        samples_per_pixel=first.cost.samples_per_pixel,
        cpu_seconds=mean([outcome.cost.cpu_seconds for outcome in outcomes if outcome.cost]),
        metrics={name: with_reference(name, _estimate(name, outcomes), reference) for name in first.metrics},
        pictures=len(outcomes),
        pixels=image.read_image(folder / first.image),
        quantum=first.quantum,
        counts=image.read_counts(counts) if counts.is_file() else None,
    )


def _estimate(name: str, outcomes: Sequence[Outcome]) -> Estimate:
    """RMSE over seeds by the mean of squares, which is unbiased; the others by their mean."""
    values = [value for outcome in outcomes if (value := outcome.metrics[name]) is not None]
    if not values:
        return Estimate(None)
    return root_mean_square(values) if name == "rmse" else mean(values)


def with_reference(name: str, found: Estimate, reference: Reference) -> Estimate:
    """A figure with what is not known of its reference: a mean square error is too large by the mean square of the
    reference's standard errors, a mean error moves by that of their mean. Of other metrics it is not known."""
    spread = reference.standard_error_rms
    if not spread or not found.value:
        return found
    match name:
        case "rmse":
            own = spread**2 / (2.0 * found.value)
        case "psnr":
            own = 10.0 / math.log(10.0) * spread**2 * 10.0 ** (found.value / 10.0)
        case "bias":
            own = spread / math.sqrt(reference.pixels.size)
        case _:
            return found
    return Estimate(found.value, math.hypot(found.standard_error or 0.0, own))


def summary(result: Comparison, plan: Plan) -> dict[str, Any]:
    """The document of `aliascope compare --json`."""
    data = result.data
    return {
        "report": str(result.report),
        "pictures": data.pictures,
        "rendered": result.rendered,
        "reused": data.reused,
        "failed": len(data.failures),
        "wall_seconds": data.wall_seconds,
        "headlines": list(data.headlines),
        "skipped": dict(data.skipped),
        "empty": empty_cells(plan),
        "failures": [asdict(failure) for failure in data.failures],
        "probes": [asdict(probe) for probe in data.probes],
        "trade": words.document(trade.analyse(data.scenes)),
        "rows": [_row_document(scene.name, row) for scene in data.scenes for row in scene.rows],
    }


def _row_document(scene: str, row: ModeRow) -> dict[str, Any]:
    return {
        "scene": scene,
        "renderer": row.renderer,
        "mode": row.mode,
        "label": row.label,
        "samples_per_pixel": row.samples_per_pixel,
        "pictures": row.pictures,
        "cpu_seconds": row.cpu_seconds.value,
        "metrics": {name: estimate.value for name, estimate in row.metrics.items()},
        "standard_errors": {name: estimate.standard_error for name, estimate in row.metrics.items()},
    }


def empty_cells(plan: Plan) -> list[dict[str, str]]:
    """What is not drawn and why, for --json."""
    return [asdict(cell) for cell in plan.empty]


def empty_lines(plan: Plan) -> list[str]:
    """What is not drawn and why, for a person: a line a scene, renderer and reason."""
    reasons = {(cell.scene, cell.renderer, cell.reason) for cell in plan.empty}
    return [f"empty {scene}: {reason}" for scene, _, reason in sorted(reasons)]


def counted(pictures: int) -> str:
    return f"{pictures} picture{'' if pictures == 1 else 's'}"


def summary_lines(result: Comparison, plan: Plan) -> list[str]:
    """What a person reads at the end: failures, what is missing, the headlines, the path of the report."""
    data = result.data
    lines = [
        f"FAILED {failure.scene} {failure.renderer} {failure.mode}: {failure.message}\n  again: {failure.command}"
        for failure in data.failures
    ]
    lines += [f"skipped {name}: {reason}" for name, reason in data.skipped.items()]
    lines += [warning for probe in data.probes if (warning := probes.warning_of(probe))]
    lines += empty_lines(plan)
    lines += data.headlines
    kept = f", {data.reused} of them from before" if data.reused else ""
    lines.append(f"{counted(data.pictures)}{kept}, {len(data.failures)} failed, {data.wall_seconds:.0f} s")
    lines.append(str(result.report))
    return lines
