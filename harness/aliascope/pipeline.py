"""Joins the stages: render in worker processes, keep, measure."""

from __future__ import annotations

import shlex
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from aliascope import draws, image, metrics, places, renderers
from aliascope.errors import AliascopeError, InvalidInput
from aliascope.jobs import Plan, judged_by, mode_of, plugin_versions, plugins_of
from aliascope.records import Job, Outcome, Pixels, Rendering
from aliascope.renderers.base import LEAST_SECONDS, Request
from aliascope.scene_io import SceneFile
from aliascope.store import Store
from aliascope.workers import Task, Workers

References = Mapping[tuple[str, str], Pixels]
"""The pictures that others are judged by, by scene and filter."""

Progress = Callable[[Job | str | None, int, int], None]
"""Told of the job or other work that begins (None at the end), how many are done, and how many there are to do."""

IDLE_ABREAST = 4
"""Jobs of a renderer that idles (`Renderer.idles`) that run side by side."""


@dataclass(frozen=True)
class Options:
    """How to run: processes side by side (timed jobs go one at a time: 1), seconds that one job may take, and that the
    pictures of a scene and mode, its seeds together, are rendered for at least."""

    processes: int = 1
    time_limit: float = 120.0
    least_seconds: float = LEAST_SECONDS


@dataclass(frozen=True)
class Timed:
    """What a worker sends back, and how long it rendered by the clock on the wall, repeats and all."""

    rendering: Rendering
    seconds: float


def render_job(file: SceneFile, job: Job, options: Options) -> Timed:
    """Renders one job. Runs in a worker process."""
    renderer = renderers.find(job.renderer)
    begun = time.perf_counter()
    request = Request(
        scene=file.scene,
        width=job.width,
        height=job.height,
        mode=renderers.mode_of(renderer, job.mode),
        seed=job.seed,
        least_seconds=options.least_seconds,
        time_limit=options.time_limit,
    )
    rendering = renderer.render(request)
    return Timed(rendering, time.perf_counter() - begun)


def image_path(job: Job) -> str:
    """Where a job's picture lies in the output folder."""
    mode = job.mode.translate(str.maketrans(":,=/", "_,=_"))
    return f"images/{job.scene}/{job.renderer}/{mode[:100]}-{job.seed}-{job.key[:8]}.exr"


def counts_path(picture: str) -> str:
    """Where the samples of the pixels of an adaptive mode lie, beside its picture."""
    return picture.removesuffix(".exr") + ".counts.exr"


def provenance(
    job: Job, rendering: Rendering, versions: Mapping[str, str], shift: tuple[float, float] = Request.shift
) -> dict[str, str]:
    """The header of a picture's file. A picture that was moved on the film says by how much, and has not the job's key,
    which is that of the picture in its place."""
    shown = {**versions, **plugin_versions(mode_of(job))}
    moved = shift != Request.shift
    return {
        **({"shift": draws.text_of(shift)} if moved else {"key": job.key}),
        "scene": job.scene,
        "renderer": job.renderer,
        "mode": job.mode,
        "seed": str(job.seed),
        "samples": str(rendering.cost.samples),
        "cpu_seconds": f"{rendering.cost.cpu_seconds:.6g}",
        "versions": ", ".join(f"{name} {value}" for name, value in sorted(shown.items())),
        "revision": places.revision(),
        "command": repeat_command(job, shift=shift),
    }


def repeat_command(job: Job, time_limit: float = Request.time_limit, shift: tuple[float, float] = Request.shift) -> str:
    """The command that renders a job again, alone, with the plugins that its mode names."""
    scene = job.scene if Path(job.scene_path).parent == places.SCENES else job.scene_path
    words = ["aliascope", "render", scene, "-r", job.renderer, "-m", job.mode, "--seed", str(job.seed)]
    words += ["--size", f"{job.width}x{job.height}", "-o", "out.exr"]
    if shift != Request.shift:
        words += ["--shift", draws.text_of(shift)]
    if time_limit != Request.time_limit:
        words += ["--time-limit", f"{time_limit:g}"]
    for path in dict.fromkeys(plugin.path for plugin in plugins_of(mode_of(job)).values()):
        words += ["--plugin", path]
    return shlex.join(words)


class Keeper:
    """Keeps what comes back, and measures it."""

    def __init__(self, folder: Path, store: Store, references: References, plan: Plan, processes: int) -> None:
        self._folder, self._store, self._references, self._plan = folder, store, references, plan
        self._processes = processes

    def keep(self, job: Job, task: Task[Timed], submitted: float) -> Outcome:
        """The outcome of one job, kept without metrics; a job that fails is an outcome too."""
        try:
            timed = task.result()
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
                harness_seconds=time.perf_counter() - submitted - timed.seconds,
                processes=self._processes,
            )
        except AliascopeError as error:
            outcome = Outcome(job=job, status="failed", message=str(error), processes=self._processes)
        self._store.put(outcome)
        return outcome

    def measure(self, outcome: Outcome) -> Outcome:
        """A kept outcome with the metrics that there are, of the picture that lies in the folder."""
        pixels = image.read_image(self._folder / outcome.image)
        values = metrics.measure(pixels, self._references[judged_by(outcome.job)])
        measured = replace(outcome, metrics={name: value.value for name, value in values.items()})
        self._store.put(measured)
        return measured

    def whole(self, outcome: Outcome) -> bool:
        """Whether the picture of a kept outcome is there, can be read, and has its size; its counts too, if any."""
        try:
            if mode_of(outcome.job).name == "adaptive":
                image.read_counts(self._folder / counts_path(outcome.image))
            return image.read_image(self._folder / outcome.image).shape == (outcome.job.height, outcome.job.width, 3)
        except InvalidInput:
            return False


def side_by_side(processes: int) -> int:
    """How many worker processes there are for so many timed jobs at a time: those of a renderer that idles run
    IDLE_ABREAST at least."""
    return max(processes, IDLE_ABREAST)


def _cell(job: Job) -> tuple[str, str, str]:
    """What the pictures of several seeds share, and their time."""
    return job.scene, job.renderer, job.mode


class _Run:
    """The jobs on their way. Nothing is measured beside a job that is timed alone; what waits to be measured is what
    there is to do beside the others."""

    def __init__(self, plan: Plan, options: Options, keeper: Keeper, workers: Workers) -> None:
        self._plan, self._options, self._keeper, self._workers = plan, options, keeper, workers
        self._pictures = Counter(_cell(job) for job in plan.jobs)
        self.outcomes: dict[str, Outcome] = {}
        self._unmeasured: deque[str] = deque()

    def add(self, outcome: Outcome) -> None:
        """An outcome that is kept."""
        self.outcomes[outcome.job.key] = outcome
        if outcome.status == "done" and set(outcome.metrics) != set(metrics.METRICS):
            self._unmeasured.append(outcome.job.key)

    def render(self, jobs: Iterable[Job], abreast: int, alone: bool, progress: Callable[[Job], None]) -> None:
        """Has jobs rendered, so many side by side."""
        waiting: deque[tuple[Job, Task[Timed], float]] = deque()
        for job in jobs:
            if len(waiting) == abreast:
                self._finish(*waiting.popleft(), alone)
            progress(job)
            least = self._options.least_seconds / self._pictures[_cell(job)]
            arguments = [self._plan.files[job.scene], job, replace(self._options, least_seconds=least)]
            task = self._workers.begin(render_job, arguments, self._options.time_limit)
            waiting.append((job, task, time.perf_counter()))
        for job, task, submitted in waiting:
            self._finish(job, task, submitted, alone)

    def _finish(self, job: Job, task: Task[Timed], submitted: float, alone: bool) -> None:
        while self._unmeasured and not alone and not task.done():
            self._measure_one()
        self.add(self._keeper.keep(job, task, submitted))

    def _measure_one(self) -> None:
        key = self._unmeasured.popleft()
        self.outcomes[key] = self._keeper.measure(self.outcomes[key])

    def measure(self, progress: Progress) -> None:
        """Measures what is left."""
        left = len(self._unmeasured)
        while self._unmeasured:
            progress("the measures of the pictures", left - len(self._unmeasured), left)
            self._measure_one()


def execute(
    plan: Plan,
    folder: Path,
    store: Store,
    references: References,
    options: Options,
    progress: Progress,
    workers: Workers,
) -> tuple[dict[str, Outcome], int]:
    """Has the workers render what the store does not have. Returns the outcomes by key, and how many of them were there
    already.

    What was timed beside more jobs than run side by side now does not count: its time is not comparable. Jobs of
    renderers that idle come last, by themselves: beside them others would not be timed alone.
    """
    image.remove_unfinished(folder / "images")
    keeper = Keeper(folder, store, references, plan, options.processes)
    run = _Run(plan, options, keeper, workers)
    for outcome in store.done(job.key for job in plan.jobs).values():
        if outcome.processes <= options.processes and keeper.whole(outcome):
            run.add(outcome)
    reused = len(run.outcomes)
    todo = [job for job in plan.jobs if job.key not in run.outcomes]

    def begins(job: Job) -> None:
        progress(job, len(run.outcomes) - reused, len(todo))

    for idles in (False, True):
        jobs = [job for job in todo if renderers.find(job.renderer).idles == idles]
        abreast = side_by_side(options.processes) if idles else options.processes
        run.render(jobs, abreast, alone=abreast == 1, progress=begins)
    run.measure(progress)
    if todo:
        progress(None, len(todo), len(todo))
    return run.outcomes, reused
