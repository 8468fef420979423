"""`aliascope compare`: the same scenes by every renderer and mode, measured, kept, and told."""

from __future__ import annotations

import logging
import math
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from typing import Any

from aliascope import calibration, image, jobs, logs, metrics, pipeline, places, renderers, trade
from aliascope.cluster.client import Cluster
from aliascope.draws import UNMOVED
from aliascope.errors import Interrupted, NotWritable, Unsupported
from aliascope.interrupts import Interrupts
from aliascope.jobs import Judged, Plan
from aliascope.native import samplers
from aliascope.pipeline import Options, Progress
from aliascope.records import Estimate, Failure, Job, ModeRow, Noise, Outcome, ReportData, SceneSection
from aliascope.references import Reference
from aliascope.report import write_report
from aliascope.specs import family, label, settings
from aliascope.statistics import Spread, mean, median_time, pooled_spread, root_mean_square
from aliascope.store import Store
from aliascope.studies import compare_work, probes
from aliascope.studies.headlines import headlines
from aliascope.trade import words
from aliascope.trade.records import Knob


@dataclass(frozen=True)
class Comparison:
    """What a comparison came to."""

    report: Path
    data: ReportData
    rendered: int
    outcomes: Mapping[str, Outcome]
    changed: int
    """Pictures that were there, and were made again as their files were gone or not what was written."""


def compare(
    plan: Plan,
    folder: Path,
    options: Options,
    command: str,
    progress: Progress,
    tell: Callable[[str], None],
    measures: Sequence[Knob] = (),
    cluster: Cluster | None = None,
) -> Comparison:
    """Renders what `folder` does not have yet, and writes results and report there. `tell` is given what a user has to
    know, `progress` what takes time. `measures` are shown with the knobs of the modes. The folder is `locked`.
    The jobs run on the `cluster`, if there is one, else here.

    Raises CheckFailed for a scene of the project without its reference, Unsupported for a scene that nothing draws,
    NotWritable for the folder; Interrupted on Ctrl-C, once there is a report of what was finished.
    """
    check_drawn(plan)
    counts = {"pictures": len(plan.jobs), "empty": len(plan.empty)}
    versions = {**plan.versions, **plan.plugins}
    skipped = dict(plan.skipped)
    logs.event(logging.INFO, "plan", counted(len(plan.jobs)), **counts, skipped=skipped, versions=versions)
    for plugin in samplers.plugins():
        if not plugin.trusted and any(f"plugin {name}" in plan.plugins for name in plugin.samplers):
            tell(f"{plugin.path} runs {plugin.where}; --trust-plugin is for one of yours, at its full speed")
    begun, started = time.perf_counter(), datetime.now(UTC).isoformat(timespec="seconds")
    _check_writable(folder)
    pipeline.remove_unfinished(folder)
    with Store(folder / "results.sqlite") as store, Interrupts() as interrupts:
        store.begin_run(started, command, places.revision(), places.machine(), versions)
        work = compare_work.Work(plan, folder, options, store, progress, tell, interrupts, cluster)
        try:
            work.do()
            interrupts.hold()
        except KeyboardInterrupt:
            work.conclude()
        result = _report(work, begun, started, versions, measures)
    if interrupts.pressed:
        raise Interrupted(
            f"interrupted: {result.data.pictures} of {counted(len(plan.jobs))} are finished, and in {result.report}; "
            "the same command goes on from there"
        )
    return result


def _report(
    work: compare_work.Work,
    begun: float,
    started: str,
    versions: Mapping[str, str],
    measures: Sequence[Knob],
) -> Comparison:
    """Writes what there is."""
    plan, judged, folder = work.plan, work.judged, work.folder
    # As they were planned, not as they came: the last digits of sums hang on their order.
    outcomes = {job.key: work.kept.outcomes[job.key] for job in plan.jobs}
    noise = calibration.mixed(work.store.noise(outcomes), _machines(outcomes.values()))
    # The box first: it is what all three renderers have.
    order = sorted(
        {key[:2] for key in judged}, key=lambda key: (list(plan.files).index(key[0]), key[1] != "box", key[1])
    )
    spreads = spreads_of(outcomes.values(), noise)
    sections = tuple(_section(plan, key, judged, outcomes, folder, spreads) for key in order)
    data = ReportData(
        title=f"aliascope compare, {plan.about}" if plan.about else "aliascope compare",
        started=started,
        wall_seconds=time.perf_counter() - begun,
        pictures=sum(outcome.status == "done" for outcome in outcomes.values()),
        reused=work.kept.reused,
        headlines=(*work.notes(), *headlines(sections)),
        scenes=sections,
        failures=tuple(
            Failure(
                job.scene,
                job.renderer,
                job.mode,
                outcome.message,
                work.again(job),
            )
            for job, outcome in ((job, outcomes[job.key]) for job in plan.jobs)
            if outcome.status == "failed"
        ),
        machine={
            **places.machine(),
            **_machines_told(outcomes.values()),
            "jobs side by side": _side_by_side(outcomes.values()),
        },
        versions={"aliascope": f"{places.own_version()} ({places.revision()})", **versions},
        metrics=metrics.ABOUT,
        skipped=plan.skipped,
        undrawn=tuple(cell for cell in plan.empty if (cell.scene, "box") not in order),
        probes=work.probed,
        probe_limits=probes.LIMITS,
        noise=noise,
    )
    report = write_report(folder, data, measures=measures)
    return Comparison(report, data, work.rendered(), outcomes, work.kept.changed)


def _side_by_side(outcomes: Iterable[Outcome]) -> str:
    """How far the times can be compared, for the report."""
    done = [outcome for outcome in outcomes if outcome.status == "done"]
    counts = Counter(outcome.processes for outcome in done)
    if set(counts) <= {1}:
        return "1: each picture was timed alone"
    told = ", ".join(f"{found} of the pictures {processes}" for processes, found in sorted(counts.items()))
    return f"{told}: those with more than 1 have inflated times; run again with -j 1 for times that can be compared"


def _machines(outcomes: Iterable[Outcome]) -> Counter[str]:
    """How many pictures each machine timed; the run's own is ""."""
    return Counter(outcome.machine for outcome in outcomes if outcome.status == "done")


def _machines_told(outcomes: Iterable[Outcome]) -> dict[str, str]:
    """For the report, where not all pictures were timed on the machine that writes it."""
    counts = _machines(outcomes)
    if set(counts) <= {""}:
        return {}
    told = [f"{counted(count)} on {name or 'this one'}" for name, count in sorted(counts.items())]
    return {"pictures timed": "; ".join(told)}


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


def spreads_of(outcomes: Iterable[Outcome], noise: Noise | None) -> dict[str, Spread | None]:
    """How timed runs of one picture differ, by renderer: pooled over its modes and scenes."""
    times: dict[str, dict[tuple[str, str], list[float]]] = {}
    for outcome in outcomes:
        if outcome.cost is not None:
            modes = times.setdefault(outcome.job.renderer, {})
            modes.setdefault((outcome.job.scene, outcome.job.mode), []).append(outcome.cost.cpu_seconds)
    drift = noise.drift if noise is not None else 0.0
    return {name: pooled_spread(list(modes.values()), drift) for name, modes in times.items()}


def _section(
    plan: Plan,
    key: tuple[str, str],
    judged: Mapping[Judged, Reference],
    outcomes: Mapping[str, Outcome],
    folder: Path,
    spreads: Mapping[str, Spread | None],
) -> SceneSection:
    """A scene under one filter. The reference that it shows is the one in place."""
    name, filter_ = key
    scene = plan.files[name].scene
    order = list(renderers.RENDERERS)
    groups: dict[tuple[str, str], list[Outcome]] = {}
    for job in sorted(plan.jobs, key=_draw_of):
        outcome = outcomes[job.key]
        if jobs.judged_by(job)[:2] == key and outcome.status == "done":
            groups.setdefault((job.renderer, job.mode), []).append(outcome)
    own = {shift: found for (*where, shift), found in judged.items() if tuple(where) == key}
    rows = [_row(group, folder, own, spreads[group[0].job.renderer]) for group in groups.values()]
    rows.sort(key=lambda row: (order.index(row.renderer), row.family, row.samples_per_pixel))
    box = filter_ == "box"
    return SceneSection(
        name=name if box else f"{name}, {filter_}",
        title=scene.title if box else f"{scene.title}, filtered with {filter_}",
        shows=scene.shows,
        reference=own[UNMOVED].pixels,
        reference_note=note_of(own[UNMOVED]),
        rows=tuple(rows),
        empty=tuple(cell for cell in plan.empty if cell.scene == name) if box else (),
        filter=filter_,
    )


def _draw_of(job: Job) -> tuple[int, bool, tuple[float, float]]:
    """In order of draws: by seed, or the film in its place and then elsewhere."""
    return job.seed, job.shift != UNMOVED, job.shift


def note_of(reference: Reference) -> str:
    """How a reference was made and how exact it is, in a few words."""
    if reference.standard_error is None:
        return f"exact ({reference.method}), error below {reference.error:.1g}"
    spread = math.sqrt(float((reference.standard_error**2).mean()))
    return f"converged, standard error {spread:.1g} a pixel"


def _row(
    outcomes: Sequence[Outcome], folder: Path, judged: Mapping[tuple[float, float], Reference], spread: Spread | None
) -> ModeRow:
    """One mode's pictures, the first draw's first. judged: the references, by how far they are moved."""
    first = outcomes[0]
    costs = [outcome.cost for outcome in outcomes if outcome.cost is not None]
    renderer = renderers.find(first.job.renderer)
    spec = renderers.mode_of(renderer, first.job.mode)
    counts = folder / pipeline.counts_path(first.image)
    seconds = tuple(cost.cpu_seconds for cost in costs)
    instructions = [cost.instructions for cost in costs if cost.instructions is not None]
    return ModeRow(
        renderer=first.job.renderer,
        mode=first.job.mode,
        label=label(spec),
        family=family(spec),
        samples_per_pixel=costs[0].samples_per_pixel,
        cpu_seconds=median_time(seconds, spread),
        metrics={name: _metric(name, outcomes, judged) for name in first.metrics},
        pictures=len(outcomes),
        pixels=image.read_image(folder / first.image),
        quantum=first.quantum,
        counts=image.read_counts(counts) if counts.is_file() else None,
        seconds=seconds,
        draws={name: tuple(outcome.metrics[name] for outcome in outcomes) for name in first.metrics},
        deterministic=not renderer.seeded(spec),
        samples=costs[0].samples,
        rays=costs[0].rays,
        instructions=median(instructions) if instructions else None,
        settings=settings(spec),
    )


def _metric(name: str, outcomes: Sequence[Outcome], judged: Mapping[tuple[float, float], Reference]) -> Estimate:
    """A metric over the draws, with what is not known of the reference: of draws in several places, the least exact.
    Of one draw the uncertainty is not known, whatever is known of its reference."""
    found = _estimate(name, outcomes)
    if len(outcomes) < 2:
        return found
    used = [judged[shift] for shift in dict.fromkeys(outcome.job.shift for outcome in outcomes)]
    return with_reference(name, found, max(used, key=lambda each: each.standard_error_rms or 0.0))


def _estimate(name: str, outcomes: Sequence[Outcome]) -> Estimate:
    """RMSE over draws by the mean of squares, which is unbiased; the others by their mean."""
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
        "changed": result.changed,
        "failed": len(data.failures),
        "wall_seconds": data.wall_seconds,
        "headlines": list(data.headlines),
        "skipped": dict(data.skipped),
        "empty": empty_cells(plan),
        "failures": [asdict(failure) for failure in data.failures],
        "probes": [asdict(probe) for probe in data.probes],
        "noise": None if data.noise is None else asdict(data.noise),
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
        "deterministic": row.deterministic,
        "uncertainty": uncertainty_of(row),
        "cpu_seconds": row.cpu_seconds.value,
        "cpu_seconds_standard_error": row.cpu_seconds.standard_error,
        "cpu_seconds_interval": row.cpu_seconds.interval,
        "seconds": list(row.seconds),
        "samples": row.samples,
        "rays": dict(row.rays),
        "instructions": row.instructions,
        "settings": dict(row.settings),
        "metrics": {name: estimate.value for name, estimate in row.metrics.items()},
        "standard_errors": {name: estimate.standard_error for name, estimate in row.metrics.items()},
        "draws": {name: list(values) for name, values in row.draws.items()},
    }


def uncertainty_of(row: ModeRow) -> str:
    """Over what the standard errors of a row's metrics are."""
    if row.pictures < 2:
        return "not known: one picture"
    return f"over {row.pictures} {'places of the film' if row.deterministic else 'seeds'}"


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
    if result.changed:
        kept += f", {result.changed} made again, as their files were gone or had changed"
    if data.noise is not None:
        lines.append(data.noise.told)
    lines.append(f"{counted(data.pictures)}{kept}, {len(data.failures)} failed, {data.wall_seconds:.0f} s")
    lines.append(str(result.report))
    return lines
