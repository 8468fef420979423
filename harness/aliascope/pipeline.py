"""Joins the stages: render in worker processes, keep, measure."""

from __future__ import annotations

import hashlib
import logging
import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, replace
from pathlib import Path

from aliascope import calibration, image, logs, metrics, places, renderers, sharing, text_files
from aliascope.calibration import Beat, Effort, Elsewhere, Watch
from aliascope.draws import UNMOVED, text_of
from aliascope.errors import AliascopeError, InvalidInput, JobFailed, NotFinite, NotWritable
from aliascope.jobs import Judged, Plan, judged_by, mode_of, plugin_versions, plugins_of
from aliascope.records import Job, Machine, Noise, Outcome, Pixels, Rendering
from aliascope.renderers.base import LEAST_SECONDS, Request
from aliascope.scene_io import SceneFile
from aliascope.scratch import remove_abandoned
from aliascope.store import Store
from aliascope.workers import Pool, Task, Workers, first_done

References = Mapping[Judged, Pixels]
"""The pictures that others are judged by."""

Progress = Callable[[Job | str | None, int, int], None]
"""Told of the job or other work that begins (None at the end), how many are done, and how many there are to do."""

MEASURED_AT_ONCE = 16
"""Pictures of one task of a process that measures."""
MEASURED_HERE = 48
"""Pictures that are measured sooner than processes that do it have begun."""
MEASURING_LIMIT = 600.0
"""Seconds that it may take to measure the pictures of a task."""


@dataclass(frozen=True)
class Options:
    """How to run: processes side by side (timed jobs go one at a time: 1), seconds that one job may take, and CPU
    seconds of a timed run, which is one picture, rendered again and again until it has lasted as long."""

    processes: int = 1
    time_limit: float = 120.0
    least_seconds: float = LEAST_SECONDS


@dataclass(frozen=True)
class Timed:
    """What a worker sends back: the picture, and what all of its repeats took of the process."""

    rendering: Rendering
    effort: Effort
    machine: Machine | None = None
    """Which did it, where it is none of ours; then `processes` ran side by side there, and the fixed job of calibration
    ran with these `beats` before it."""
    processes: int = 0
    beats: tuple[Beat, ...] = ()


def render_job(file: SceneFile, job: Job, options: Options) -> Timed:
    """Renders one job. Runs in a worker process."""
    renderer = renderers.find(job.renderer)
    ended = calibration.effort()
    request = Request(
        scene=file.scene,
        width=job.width,
        height=job.height,
        mode=renderers.mode_of(renderer, job.mode),
        seed=job.seed,
        least_seconds=options.least_seconds,
        time_limit=options.time_limit,
        shift=job.shift,
    )
    rendering = renderer.render(request)
    return Timed(rendering, ended())


def measure_beside(paths: Sequence[Path], reference: Pixels) -> list[dict[str, float | None]]:
    """As `measure_pictures`, in a worker process beside others: FLIP would have threads for all processors in each."""
    os.environ["OMP_NUM_THREADS"] = "1"  # which is looked at once, when the library is loaded
    return measure_pictures(paths, reference)


def measure_pictures(paths: Sequence[Path], reference: Pixels) -> list[dict[str, float | None]]:
    """The metrics of pictures that one reference judges."""
    measured = (
        metrics.measure(image.read_image(path), reference, names=(str(path), "the reference")) for path in paths
    )
    return [{name: value.value for name, value in values.items()} for values in measured]


def about(job: Job) -> logs.About:
    """What a log says of a job."""
    moved = {} if job.shift == UNMOVED else {"shift": job.shift}
    size = f"{job.width}x{job.height}"
    names = {"scene": job.scene, "renderer": job.renderer, "mode": job.mode, "size": size, "seed": job.seed}
    return {**names, **moved, "key": job.key}


def image_path(job: Job) -> str:
    """Where a job's picture lies in the output folder."""
    mode = job.mode.translate(str.maketrans(":,=/", "_,=_"))
    moved = "" if job.shift == UNMOVED else "@" + text_of(job.shift).replace(",", "_")
    return f"images/{job.scene}/{job.renderer}/{mode[:100]}-{job.seed}{moved}-{job.key[:8]}.exr"


def counts_path(picture: str) -> str:
    """Where the samples of the pixels of an adaptive mode lie, beside its picture."""
    return picture.removesuffix(".exr") + ".counts.exr"


def provenance(job: Job, rendering: Rendering, versions: Mapping[str, str]) -> dict[str, str]:
    """The header of a picture's file."""
    shown = {**versions, **plugin_versions(mode_of(job))}
    return {
        "key": job.key,
        "scene": job.scene,
        "renderer": job.renderer,
        "mode": job.mode,
        "seed": str(job.seed),
        **({} if job.shift == UNMOVED else {"shift": text_of(job.shift)}),
        "samples": str(rendering.cost.samples),
        "cpu_seconds": f"{rendering.cost.cpu_seconds:.6g}",
        "versions": ", ".join(f"{name} {value}" for name, value in sorted(shown.items())),
        "revision": places.revision(),
        "command": repeat_command(job),
    }


def scene_word(job: Job) -> str:
    """How a command names the scene of a job."""
    where = Path(job.scene_path).expanduser()
    return job.scene if where.parent == places.SCENES else str(where)


def repeat_command(job: Job, time_limit: float = Request.time_limit) -> str:
    """The command that renders a job again, alone, with the plugins that its mode names."""
    words = [
        "aliascope",
        "render",
        scene_word(job),
        "-r",
        renderers.word_of(job.renderer),
        "-m",
        job.mode,
        "--seed",
        str(job.seed),
    ]
    words += ["--size", f"{job.width}x{job.height}", "-o", "out.exr"]
    if job.shift != UNMOVED:
        words += ["--shift", text_of(job.shift)]
    if time_limit != Request.time_limit:
        words += ["--time-limit", f"{time_limit:g}"]
    for plugin in dict.fromkeys(plugins_of(mode_of(job)).values()):
        words += [plugin.option, plugin.path]
    return sharing.command_line(words)


class Keeper:
    """Keeps what comes back."""

    def __init__(self, folder: Path, store: Store, plan: Plan, processes: int) -> None:
        self._folder, self._store, self._plan, self._processes = folder, store, plan, processes

    def keep(self, job: Job, task: Task[Timed], submitted: float, saw: Callable[[Timed], None]) -> Outcome:
        """The outcome of one job, kept without metrics; a job that fails is an outcome too. Raises NotWritable."""
        try:
            timed = task.result()
        except AliascopeError as error:
            return self._failed(job, error)
        saw(timed)
        try:
            files = self._write(job, timed.rendering)
        except NotFinite as error:
            return self._failed(job, error)
        outcome = Outcome(
            job=job,
            status="done",
            cost=timed.rendering.cost,
            quantum=timed.rendering.quantum,
            image=image_path(job),
            harness_seconds=time.perf_counter() - submitted - timed.effort.wall,
            processes=timed.processes or self._processes,
            machine=str(timed.machine or ""),
        )
        self._store.put(outcome, files)
        return outcome

    def _failed(self, job: Job, error: AliascopeError) -> Outcome:
        why = sharing.shared(str(error))
        outcome = Outcome(job=job, status="failed", message=why, processes=self._processes)
        logs.event(logging.INFO, "failed", f"failed {job.key}", **about(job), why=why, again=repeat_command(job))
        self._store.put(outcome)
        return outcome

    def _write(self, job: Job, rendering: Rendering) -> dict[str, str]:
        """Writes the picture of a job, and its counts, if any; their hashes, by path."""
        path, header = image_path(job), provenance(job, rendering, self._plan.versions)
        written = [path]
        if rendering.counts is not None:
            written.append(counts_path(path))
            image.write_counts(self._folder / written[-1], rendering.counts, header)
        image.write_exr(self._folder / path, rendering.pixels, header)
        return {each: sha256_of(self._folder / each) for each in written}

    def path(self, outcome: Outcome) -> Path:
        """Where the picture of a kept outcome lies."""
        return self._folder / outcome.image

    def measured(self, outcome: Outcome, values: Mapping[str, float | None]) -> Outcome:
        """A kept outcome with its metrics."""
        self._store.put_metrics(outcome.job.key, values)
        return replace(outcome, metrics=values)

    def whole(self, outcome: Outcome) -> bool:
        """Whether the files of a kept outcome are what was written; logs which is not."""
        counts = [counts_path(outcome.image)] if mode_of(outcome.job).name == "adaptive" else []
        for path in (outcome.image, *counts):
            if (why := self._fault(path, outcome.job)) is not None:
                text = f"{path} {why}: it is made again"
                logs.event(logging.INFO, "changed", text, **about(outcome.job), file=path)
                return False
        return True

    def _fault(self, path: str, job: Job) -> str | None:
        """What is wrong with a file. Of one whose hash was not kept, as earlier versions did not: whether it can be
        read, and has its size."""
        place = self._folder / path
        kept = self._store.file(path)
        try:
            if kept is not None:
                return None if sha256_of(place) == kept else "is not what was written"
            size = image.read_image(place).shape[:2]
        except FileNotFoundError:
            return "is gone"
        except (InvalidInput, OSError):
            return "cannot be read"
        return None if size == (job.height, job.width) else "has another size"


def sha256_of(path: Path) -> str:
    """The hash of a file. Raises OSError."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@dataclass
class Kept:
    """What a folder has of a plan: outcomes by key, which become more while it is executed. `reused`: how many there
    were before; `changed`: pictures besides that were there and are not any more what was written. `rendered`: all of
    the plan was."""

    outcomes: dict[str, Outcome]
    reused: int
    changed: int
    rendered: bool = False


def kept_of(plan: Plan, folder: Path, store: Store, options: Options) -> Kept:
    """What a folder has of a plan already.

    What was timed beside more jobs than run side by side now does not count: its time is not comparable.
    """
    keeper = Keeper(folder, store, plan, options.processes)
    done = store.done(job.key for job in plan.jobs)
    comparable = [outcome for outcome in done.values() if outcome.processes <= options.processes]
    whole = {outcome.job.key: outcome for outcome in comparable if keeper.whole(outcome)}
    return Kept(whole, len(whole), len(comparable) - len(whole))


def remove_unfinished(folder: Path) -> None:
    """Removes what a process that was killed left half written in a folder of results, which nobody else writes to,
    and its scratch folders."""
    for name in ("images", "references"):
        image.remove_unfinished(folder / name)
    for each in (folder, folder / "plots"):
        text_files.remove_unfinished(each)
    remove_abandoned()


class _Run:
    """The jobs on their way. Nothing is measured beside a job that is timed."""

    def __init__(self, plan: Plan, options: Options, keeper: Keeper, outcomes: dict[str, Outcome]) -> None:
        self._plan, self._options, self._keeper, self.outcomes = plan, options, keeper, outcomes
        self._watch, self._elsewhere = Watch(), Elsewhere()

    def noise(self) -> Noise | None:
        """How steady what timed the jobs was."""
        return self._elsewhere.noise() or self._watch.noise()

    def render(self, jobs: Sequence[Job], workers: Pool, progress: Progress) -> None:
        """Has jobs rendered in their order, the fixed job of calibration between them; elsewhere it is run there."""
        waiting: list[tuple[Job, Task[Timed], float]] = []
        for number, job in enumerate(jobs):
            while len(waiting) >= workers.window:
                self._finish(*waiting.pop(first_done([task for _, task, _ in waiting])))
            if number % calibration.EVERY == 0 and not workers.elsewhere:
                self._calibrate(workers)
            progress(job, number, len(jobs))
            arguments = [self._plan.files[job.scene], job, self._options]
            task = workers.begin(render_job, arguments, self._options.time_limit, about(job))
            waiting.append((job, task, time.perf_counter()))
        while waiting:
            self._finish(*waiting.pop(first_done([task for _, task, _ in waiting])))
        if jobs and not workers.elsewhere:
            self._calibrate(workers)

    def _calibrate(self, workers: Pool) -> None:
        with suppress(JobFailed):  # its process ended: what is wrong will be told of a picture
            self._watch.beat(workers.begin(calibration.beat, [], self._options.time_limit).result())

    def _finish(self, job: Job, task: Task[Timed], submitted: float) -> None:
        self.outcomes[job.key] = self._keeper.keep(job, task, submitted, self._saw)

    def _saw(self, timed: Timed) -> None:
        if timed.machine is None:
            self._watch.ran(timed.effort)
        else:
            self._elsewhere.ran(timed.machine.name, timed.effort, timed.beats)

    def measure(self, references: References, workers: Workers | None, progress: Progress) -> None:
        """Measures what has not all metrics, by these workers where it is much."""
        by_reference: dict[Judged, list[Outcome]] = {}
        for outcome in self.outcomes.values():
            if outcome.status == "done" and set(outcome.metrics) != set(metrics.METRICS):
                by_reference.setdefault(judged_by(outcome.job), []).append(outcome)
        parts = [
            (judged, outcomes[first : first + MEASURED_AT_ONCE])
            for judged, outcomes in by_reference.items()
            for first in range(0, len(outcomes), MEASURED_AT_ONCE)
        ]
        total, done = sum(len(part) for _, part in parts), 0
        arguments = [([self._keeper.path(each) for each in part], references[judged]) for judged, part in parts]
        begun: list[Task[list[dict[str, float | None]]]] = []
        if workers is not None and total > MEASURED_HERE:
            begun = [
                workers.begin(measure_beside, each, MEASURING_LIMIT, {"scene": judged[0], "measures": len(each[0])})
                for (judged, _), each in zip(parts, arguments, strict=True)
            ]
        for number, (_, part) in enumerate(parts):
            progress("the measures of the pictures", done, total)
            values = begun[number].result() if begun else measure_pictures(*arguments[number])
            for outcome, found in zip(part, values, strict=True):
                self.outcomes[outcome.job.key] = self._keeper.measured(outcome, found)
            done += len(part)


def execute(
    plan: Plan,
    folder: Path,
    store: Store,
    references: References,
    options: Options,
    progress: Progress,
    workers: Pool,
    measurers: Workers | None = None,
    kept: Kept | None = None,
) -> tuple[dict[str, Outcome], int]:
    """Has the workers time what is not `kept`, by default what the store has, in the order of the plan, which is by
    chance, and then measured, by the `measurers` if there are any. Returns the outcomes by key, those of `kept`, and
    how many of them were there already. The store keeps how steady the machine was.

    Raises NotWritable, and whatever ends it early, with the outcomes until then in `kept`.
    """
    kept = kept_of(plan, folder, store, options) if kept is None else kept
    todo = [job for job in plan.jobs if job.key not in kept.outcomes]
    run = _Run(plan, options, Keeper(folder, store, plan, options.processes), kept.outcomes)
    try:
        run.render(todo, workers, progress)
        kept.rendered = True
    finally:
        with suppress(NotWritable) if not kept.rendered else nullcontext():  # what ended it says why
            store.put_noise(run.noise())
    run.measure(references, measurers, progress)
    if todo:
        progress(None, len(todo), len(todo))
    return run.outcomes, kept.reused


def measure_rest(
    plan: Plan,
    folder: Path,
    store: Store,
    references: References,
    options: Options,
    progress: Progress,
    measurers: Workers,
    kept: Kept,
) -> None:
    """Measures what was rendered until `execute` ended early."""
    run = _Run(plan, options, Keeper(folder, store, plan, options.processes), kept.outcomes)
    run.measure(references, measurers, progress)
