"""Joins the stages: plan, render in worker processes, measure, keep."""

from __future__ import annotations

import functools
import hashlib
import re
import shlex
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from aliascope import image, metrics, places, plan, renderers
from aliascope.errors import AliascopeError, InvalidInput, NotAvailable
from aliascope.native import samplers
from aliascope.native.samplers import Plugin
from aliascope.records import EmptyCell, Job, Outcome, Pixels, Rendering
from aliascope.renderers.base import LEAST_SECONDS, Renderer, Request, filter_of, lacks
from aliascope.scene_io import SceneFile
from aliascope.specs import Spec
from aliascope.store import Store
from aliascope.workers import Workers

References = Mapping[tuple[str, str], Pixels]
"""The pictures that others are judged by, by scene and filter."""

Progress = Callable[[Job | str | None, int, int], None]
"""Told of the job or other work that begins (None at the end), how many are done, and how many there are to do."""


@dataclass(frozen=True)
class Options:
    """How to run: processes side by side (timed jobs go one at a time: 1), seconds that one job may take."""

    processes: int = 1
    time_limit: float = 120.0
    least_seconds: float = LEAST_SECONDS


@dataclass(frozen=True)
class Plan:
    """Jobs in the order in which they run; cells that stay empty; renderers that are not there, with the reason."""

    jobs: tuple[Job, ...]
    empty: tuple[EmptyCell, ...]
    skipped: Mapping[str, str]
    files: Mapping[str, SceneFile]
    versions: Mapping[str, str]
    plugins: Mapping[str, str] = field(default_factory=dict)
    """Of the modes' samplers: path and hash by "plugin NAME"."""
    about: str = ""
    """What was chosen, for the title of a report: "quick profile, chosen scenes"."""


# --- plan -------------------------------------------------------------------------------------------------------------


COMMON = ("geometry.py", "image.py", "meshes.py", "model.py", "motion.py", "specs.py")
"""What the pictures of every renderer depend on, beside renderers/ and native/ without the files of other renderers."""

SAMPLER_LIBRARY = "libaliascope.so"


@functools.cache
def code_of(renderer: str, with_samplers: bool) -> tuple[Path, ...]:
    """The files whose code a picture of this renderer depends on; `with_samplers`: one of a mode with a sampler.

    A mode without one depends on no sampler of the library: of it, the rasteriser takes the text of errors alone.
    """
    here = Path(__file__).parent
    own = _own_files(here, renderer)
    others = {path for name in renderers.RENDERERS if name != renderer for path in _own_files(here, name)} - own
    libraries = set((here / "native" / "lib").glob("*.so"))
    if not with_samplers:
        libraries = {path for path in libraries if path.name != SAMPLER_LIBRARY}
    folders = {path for name in ("renderers", "native") for path in (here / name).glob("*.py")}
    registries = {path for path in folders if path.name == "__init__.py"}
    found = ({here / name for name in COMMON} | folders | libraries) - others - registries
    return tuple(sorted(found))


def _own_files(here: Path, renderer: str) -> set[Path]:
    native = renderers.find(renderer).native
    return {
        *(here / "renderers").glob(f"{renderer}*.py"),
        *(here / "native" / f"{name}.py" for name in native),
        *(here / "native" / "lib" / f"libaliascope-{name}.so" for name in native),
    }


@functools.cache
def _digest(paths: tuple[Path, ...]) -> str:
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def code_digest(renderer: str, mode: Spec) -> str:
    """A hash of the code that pictures of this mode depend on: when it changes, they are made again."""
    return _digest(code_of(renderer, any(key.kind == "spec" for key in mode.form.keys)))


def plugins_of(mode: Spec) -> dict[str, Plugin]:
    """The plugins whose samplers a mode names, by the sampler. Every word counts, a value of a key too: an inner spec
    may stand anywhere."""
    words = {word for value in mode.values.values() for word in re.split("[:,=]", str(value))}
    return {name: plugin for plugin in samplers.plugins() for name in plugin.samplers if name in words}


def plugin_versions(mode: Spec) -> dict[str, str]:
    """For provenance: path and hash of the plugins that a mode names, by "plugin NAME"."""
    return {f"plugin {name}": f"{plugin.path} sha256 {plugin.sha256}" for name, plugin in plugins_of(mode).items()}


def make_plan(
    files: Sequence[SceneFile],
    wanted: Mapping[str, Sequence[str]],
    seeds: int,
    size: tuple[int, int] | None = None,
    required: Sequence[str] = (),
) -> Plan:
    """The jobs of these scenes with these modes by renderer; a randomised mode gets `seeds` pictures.

    Raises NotAvailable for a `required` renderer that is not there, SpecError for a mode that can't be read.
    """
    jobs: list[Job] = []
    empty: list[EmptyCell] = []
    skipped: dict[str, str] = {}
    versions: dict[str, str] = {}
    plugins: dict[str, str] = {}
    for name, modes in wanted.items():
        renderer = renderers.find(name)
        specs = {spec.text: spec for spec in (renderers.mode_of(renderer, mode) for mode in modes)}
        try:
            own = dict(renderer.versions())
        except NotAvailable as error:
            if name in required:
                raise
            skipped[name] = str(error)
            continue
        versions.update(own)
        for spec in specs.values():
            plugins.update(plugin_versions(spec))
        for file in files:
            for spec in specs.values():
                reason = lacks(renderer, file.scene, spec)
                if reason:
                    empty.append(EmptyCell(file.name, name, spec.text, reason))
                else:
                    jobs += _jobs(file, renderer, spec, seeds, size, own)
    # By key, that is by chance: the time left can be told from the count, and no mode has the cold machine to itself.
    jobs.sort(key=lambda job: job.key)
    return Plan(tuple(jobs), tuple(empty), skipped, {file.name: file for file in files}, versions, plugins)


def _jobs(
    file: SceneFile,
    renderer: Renderer,
    spec: Spec,
    seeds: int,
    size: tuple[int, int] | None,
    versions: Mapping[str, str],
) -> Iterator[Job]:
    for seed in range(seeds if renderer.seeded(spec) else 1):
        yield plan.make_job(
            scene=file.name,
            scene_path=str(file.path),
            digest=file.scene.digest(),
            renderer=renderer.name,
            mode=spec.text,
            size=size or file.scene.view.size,
            seed=seed,
            versions={
                **versions,
                "code": code_digest(renderer.name, spec),
                **{f"plugin {name}": plugin.sha256 for name, plugin in plugins_of(spec).items()},
            },
        )


def judged_by(job: Job) -> tuple[str, str]:
    """Which reference judges a job: its scene's, of the filter that its mode has."""
    return job.scene, filter_of(mode_of(job))


def mode_of(job: Job) -> Spec:
    """The parsed mode of a job."""
    return renderers.mode_of(renderers.find(job.renderer), job.mode)


# --- run --------------------------------------------------------------------------------------------------------------


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


def provenance(job: Job, rendering: Rendering, versions: Mapping[str, str]) -> dict[str, str]:
    """The header of a picture's file."""
    shown = {**versions, **plugin_versions(mode_of(job))}
    return {
        "key": job.key,
        "scene": job.scene,
        "renderer": job.renderer,
        "mode": job.mode,
        "seed": str(job.seed),
        "samples": str(rendering.cost.samples),
        "cpu_seconds": f"{rendering.cost.cpu_seconds:.6g}",
        "versions": ", ".join(f"{name} {value}" for name, value in sorted(shown.items())),
        "revision": places.revision(),
        "command": repeat_command(job),
    }


def repeat_command(job: Job, time_limit: float = Request.time_limit) -> str:
    """The command that renders a job again, alone, with the plugins that its mode names."""
    scene = job.scene if Path(job.scene_path).parent == places.SCENES else job.scene_path
    words = ["aliascope", "render", scene, "-r", job.renderer, "-m", job.mode, "--seed", str(job.seed)]
    words += ["--size", f"{job.width}x{job.height}", "-o", "out.exr"]
    if time_limit != Request.time_limit:
        words += ["--time-limit", f"{time_limit:g}"]
    for path in dict.fromkeys(plugin.path for plugin in plugins_of(mode_of(job)).values()):
        words += ["--plugin", path]
    return shlex.join(words)


class Keeper:
    """Measures what comes back, and keeps picture and figures."""

    def __init__(self, folder: Path, store: Store, references: References, plan: Plan, processes: int) -> None:
        self._folder, self._store, self._references, self._plan = folder, store, references, plan
        self._processes = processes

    def keep(self, job: Job, result: Callable[[], Timed], submitted: float) -> Outcome:
        """The outcome of one job, kept; a job that fails is an outcome too."""
        try:
            timed = result()
            begun = time.perf_counter()
            measured = metrics.measure(timed.rendering.pixels, self._references[judged_by(job)])
            spent = time.perf_counter() - begun + timed.seconds
            path = image_path(job)
            header = provenance(job, timed.rendering, self._plan.versions)
            if timed.rendering.counts is not None:
                image.write_counts(self._folder / counts_path(path), timed.rendering.counts, header)
            image.write_exr(self._folder / path, timed.rendering.pixels, header)
            outcome = Outcome(
                job=job,
                status="done",
                cost=timed.rendering.cost,
                metrics={name: value.value for name, value in measured.items()},
                quantum=timed.rendering.quantum,
                image=path,
                harness_seconds=time.perf_counter() - submitted - spent,
                processes=self._processes,
            )
        except AliascopeError as error:
            outcome = Outcome(job=job, status="failed", message=str(error), processes=self._processes)
        self._store.put(outcome)
        return outcome

    def whole(self, outcome: Outcome) -> bool:
        """Whether the picture of a kept outcome is there, can be read, and has its size; its counts too, if any."""
        try:
            if mode_of(outcome.job).name == "adaptive":
                image.read_counts(self._folder / counts_path(outcome.image))
            return image.read_image(self._folder / outcome.image).shape == (outcome.job.height, outcome.job.width, 3)
        except InvalidInput:
            return False

    def measured_again(self, outcome: Outcome) -> Outcome:
        """A kept outcome with the metrics that there are now, of the picture that is there."""
        pixels = image.read_image(self._folder / outcome.image)
        values = metrics.measure(pixels, self._references[judged_by(outcome.job)])
        fresh = replace(outcome, metrics={name: value.value for name, value in values.items()})
        self._store.put(fresh)
        return fresh


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

    What was timed beside more jobs than run side by side now does not count: its time is not comparable.
    """
    image.remove_unfinished(folder / "images")
    keeper = Keeper(folder, store, references, plan, options.processes)
    kept = store.done(job.key for job in plan.jobs)
    outcomes = {
        key: outcome
        for key, outcome in kept.items()
        if outcome.processes <= options.processes and keeper.whole(outcome)
    }
    for key, outcome in outcomes.items():
        if set(outcome.metrics) != set(metrics.METRICS):
            outcomes[key] = keeper.measured_again(outcome)
    reused = len(outcomes)
    todo = [job for job in plan.jobs if job.key not in outcomes]
    if not todo:
        return outcomes, reused
    waiting: list[tuple[Job, Callable[[], Timed], float]] = []
    for job in [*todo, *[None] * options.processes]:
        if job is not None:
            progress(job, len(outcomes) - reused, len(todo))
            result = workers.begin(render_job, [plan.files[job.scene], job, options], options.time_limit)
            waiting.append((job, result, time.perf_counter()))
        if waiting and (job is None or len(waiting) >= options.processes):
            oldest, result, submitted = waiting.pop(0)
            outcomes[oldest.key] = keeper.keep(oldest, result, submitted)
    progress(None, len(todo), len(todo))
    return outcomes, reused
