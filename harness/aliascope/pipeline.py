"""Joins the stages: render in worker processes, keep, measure."""

from __future__ import annotations

import os
import shlex
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from aliascope import calibration, image, metrics, places, renderers
from aliascope.calibration import Effort, Watch
from aliascope.draws import UNMOVED, text_of
from aliascope.errors import AliascopeError, InvalidInput, JobFailed
from aliascope.jobs import Judged, Plan, judged_by, mode_of, plugin_versions, plugins_of
from aliascope.records import Job, Outcome, Pixels, Rendering
from aliascope.renderers.base import LEAST_SECONDS, Request
from aliascope.scene_io import SceneFile
from aliascope.store import Store
from aliascope.workers import Task, Workers

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


def repeat_command(job: Job, time_limit: float = Request.time_limit) -> str:
    """The command that renders a job again, alone, with the plugins that its mode names."""
    scene = job.scene if Path(job.scene_path).parent == places.SCENES else job.scene_path
    words = [
        "aliascope",
        "render",
        scene,
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
    for path in dict.fromkeys(plugin.path for plugin in plugins_of(mode_of(job)).values()):
        words += ["--plugin", path]
    return shlex.join(words)


class Keeper:
    """Keeps what comes back."""

    def __init__(self, folder: Path, store: Store, plan: Plan, processes: int) -> None:
        self._folder, self._store, self._plan, self._processes = folder, store, plan, processes

    def keep(self, job: Job, task: Task[Timed], submitted: float, watch: Watch) -> Outcome:
        """The outcome of one job, kept without metrics; a job that fails is an outcome too."""
        try:
            timed = task.result()
            watch.ran(timed.effort)
            path = image_path(job)
            header = provenance(job, timed.rendering, self._plan.versions)
            if timed.rendering.counts is not None:
                image.write_counts(self._folder / counts_path(path), timed.rendering.counts, header)
            image.write_exr(self._folder / path, timed.rendering.pixels, header)
            outcome = Outcome(
                job=job,
                status="done",
                cost=timed.rendering.cost,
                quantum=timed.rendering.quantum,
                image=path,
                harness_seconds=time.perf_counter() - submitted - timed.effort.wall,
                processes=self._processes,
            )
        except AliascopeError as error:
            outcome = Outcome(job=job, status="failed", message=str(error), processes=self._processes)
        self._store.put(outcome)
        return outcome

    def path(self, outcome: Outcome) -> Path:
        """Where the picture of a kept outcome lies."""
        return self._folder / outcome.image

    def measured(self, outcome: Outcome, values: Mapping[str, float | None]) -> Outcome:
        """A kept outcome with its metrics."""
        self._store.put_metrics(outcome.job.key, values)
        return replace(outcome, metrics=values)

    def whole(self, outcome: Outcome) -> bool:
        """Whether the picture of a kept outcome is there, can be read, and has its size; its counts too, if any."""
        try:
            if mode_of(outcome.job).name == "adaptive":
                image.read_counts(self._folder / counts_path(outcome.image))
            return image.read_image(self.path(outcome)).shape == (outcome.job.height, outcome.job.width, 3)
        except InvalidInput:
            return False


class _Run:
    """The jobs on their way. Nothing is measured beside a job that is timed."""

    def __init__(self, plan: Plan, options: Options, keeper: Keeper, outcomes: dict[str, Outcome]) -> None:
        self._plan, self._options, self._keeper, self.outcomes = plan, options, keeper, outcomes
        self.watch = Watch()

    def render(self, jobs: Sequence[Job], workers: Workers, progress: Progress) -> None:
        """Has jobs rendered in their order, the fixed job of calibration between them."""
        waiting: deque[tuple[Job, Task[Timed], float]] = deque()
        for number, job in enumerate(jobs):
            if len(waiting) == self._options.processes:
                self._finish(*waiting.popleft())
            if number % calibration.EVERY == 0:
                self._calibrate(workers)
            progress(job, number, len(jobs))
            arguments = [self._plan.files[job.scene], job, self._options]
            task = workers.begin(render_job, arguments, self._options.time_limit)
            waiting.append((job, task, time.perf_counter()))
        for job, task, submitted in waiting:
            self._finish(job, task, submitted)
        if jobs:
            self._calibrate(workers)

    def _calibrate(self, workers: Workers) -> None:
        with suppress(JobFailed):  # its process ended: what is wrong will be told of a picture
            self.watch.beat(workers.begin(calibration.beat, [], self._options.time_limit).result())

    def _finish(self, job: Job, task: Task[Timed], submitted: float) -> None:
        self.outcomes[job.key] = self._keeper.keep(job, task, submitted, self.watch)

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
            begun = [workers.begin(measure_beside, each, MEASURING_LIMIT) for each in arguments]
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
    workers: Workers,
    measurers: Workers | None = None,
) -> tuple[dict[str, Outcome], int]:
    """Has the workers time what the store does not have, in the order of the plan, which is by chance, and then
    measured, by the `measurers` if there are any. Returns the outcomes by key, and how many of them were there already.
    The store keeps how steady the machine was.

    What was timed beside more jobs than run side by side now does not count: its time is not comparable.
    """
    image.remove_unfinished(folder / "images")
    keeper = Keeper(folder, store, plan, options.processes)
    done = store.done(job.key for job in plan.jobs)
    kept = {
        key: outcome
        for key, outcome in done.items()
        if outcome.processes <= options.processes and keeper.whole(outcome)
    }
    reused, todo = len(kept), [job for job in plan.jobs if job.key not in kept]
    run = _Run(plan, options, keeper, kept)
    try:
        run.render(todo, workers, progress)
    finally:
        store.put_noise(run.watch.noise())
    run.measure(references, measurers, progress)
    if todo:
        progress(None, len(todo), len(todo))
    return run.outcomes, reused
