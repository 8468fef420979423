"""Which code and which plugins a picture is kept under."""

from __future__ import annotations

import ast
import subprocess
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

import aliascope
from aliascope import draws, jobs, pipeline, renderers, scene_io, workers
from aliascope.calibration import Beat, Effort
from aliascope.errors import JobFailed
from aliascope.metrics.base import Measured
from aliascope.pipeline import Timed
from aliascope.records import Cost, Rendering
from aliascope.renderers.base import Request
from aliascope.store import Store

PACKAGE = Path(aliascope.__file__).parent
HARMLESS = {
    "errors.py",
    "records.py",
    "draws.py",
    "places.py",
    "scratch.py",
    "logs.py",
    "sharing.py",
    "bounded.py",
    "landlock.py",
    "seccomp.py",
}
"""Imported by renderers, and free of anything that could change a picture: messages, frozen types, how far a film may
be moved, where files lie, folders for a moment, what is logged, files that are read whole or refused, and which a
process gives up."""


def imported(path: Path) -> set[Path]:
    """The files of the package that a file imports, those in a function too."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.update({node.module, *(f"{node.module}.{alias.name}" for alias in node.names)})
    files = {PACKAGE.parent / (name.replace(".", "/") + ".py") for name in names if name.startswith("aliascope.")}
    return {file for file in files if file.is_file()}


@pytest.mark.parametrize("name", list(renderers.RENDERERS))
def test_the_code_of_a_renderer_is_all_that_it_imports(name: str) -> None:
    """A file that is left out would leave pictures of an earlier version in the report."""
    waiting, seen = [PACKAGE / "renderers" / f"{name}.py"], set()
    while waiting:
        path = waiting.pop()
        if path not in seen:
            seen.add(path)
            waiting += imported(path)
    assert len(seen) > 5
    code = set(jobs.code_of(name, True))
    assert {path.name for path in seen - code} <= HARMLESS
    # What changes a scene after its digest was taken from the file: the triangles of its meshes.
    assert PACKAGE / "meshes.py" in code


def test_the_rasteriser_takes_nothing_from_the_samplers() -> None:
    """It is why a mode without a sampler does not depend on their library."""
    library = PACKAGE / "native" / "lib" / "libaliascope-raster.so"
    text = subprocess.run(["nm", "-D", "--undefined-only", library], capture_output=True, text=True, check=True).stdout
    assert {word for word in text.split() if word.startswith("asc_")} == {"asc_fail"}


def test_pictures_do_not_depend_on_the_code_of_another_renderer() -> None:
    def names(renderer: str, mode: str) -> set[str]:
        with_samplers = any(key.kind == "spec" for key in renderers.mode_of(renderers.find(renderer), mode).form.keys)
        return {path.name for path in jobs.code_of(renderer, with_samplers)}

    embree, povray, osmesa = names("embree", "uniform"), names("povray", "am1"), names("osmesa", "msaa")
    assert {"embree.py", "tracer.py", "libaliascope-tracer.so", "libaliascope.so"} <= embree
    assert not embree & {"osmesa.py", "raster.py", "libaliascope-raster.so", "povray.py", "povray_sdl.py"}
    assert {"povray.py", "povray_sdl.py"} <= povray
    assert {name for name in povray if name.endswith(".so")} == {"libaliascope-waits.so"}
    assert {"osmesa.py", "raster.py", "libaliascope-raster.so"} <= osmesa
    assert not osmesa & {"libaliascope.so", "libaliascope-tracer.so", "tracer.py"}
    assert "libaliascope.so" in names("osmesa", "accumulate") & names("povray", "accumulate")
    modes = (("embree", "uniform"), ("povray", "am1"), ("povray", "accumulate"), ("osmesa", "msaa"))
    found = {jobs.code_digest(name, renderers.mode_of(renderers.find(name), mode)) for name, mode in modes}
    assert len(found) == len(modes)


class Slow:
    """Workers whose tasks are done when their results are asked for, and what they were given."""

    elsewhere, window, processes = False, 1, 1

    def __init__(self) -> None:
        self.begun: list[tuple[str, float]] = []
        """In order: the renderer of a job or the name of another task, and how many tasks ran with it."""
        self.least: set[float] = set()
        self.running: list[object] = []

    def begin(
        self, task: Callable[..., Any], arguments: Sequence[Any], time_limit: float, about: object = None
    ) -> Running:
        name = task.__name__
        if name == "render_job":
            name = arguments[1].renderer
            self.least.add(arguments[2].least_seconds)
        self.begun.append((name, len(self.running)))
        return Running(self, name, task, arguments)


class Running:
    def __init__(self, among: Slow, name: str, task: Callable[..., Any], arguments: Sequence[Any]) -> None:
        self.among, self.name, self.task, self.arguments = among, name, task, arguments
        among.running.append(self)

    def result(self) -> Any:
        self.among.running.remove(self)
        if self.name == "beat":
            return Beat(0.02, 0.02)
        if self.name == "measure_beside":
            return self.task(*self.arguments)
        cost = Cost(samples=1, samples_per_pixel=1.0, rays={}, cpu_seconds=0.0, wall_seconds=0.0, repeats=1)
        return Timed(Rendering(np.zeros((9, 12, 3), np.float32), cost), Effort(0.0, 0.0, 1, 0.0))


def test_timed_jobs_run_alone_in_one_order_by_chance_and_are_measured_after_all_of_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, timing, measuring = scene_io.load("edge"), Slow(), Slow()
    beside: list[int] = []
    monkeypatch.setattr(pipeline, "MEASURED_HERE", 0)
    monkeypatch.setenv("OMP_NUM_THREADS", "1")  # which is set for the rest of the process
    monkeypatch.setattr(pipeline.metrics, "METRICS", {"rmse": None})
    monkeypatch.setattr(
        pipeline.metrics, "measure", lambda *_, **__: beside.append(len(timing.running)) or {"rmse": Measured(0.5)}
    )
    modes = {"povray": [f"regular:n={side * side}" for side in range(2, 8)], "embree": ["uniform:n=1,sampler=random"]}
    plan = jobs.make_plan([file], modes, seeds=4, size=(12, 9))
    assert len(plan.jobs) == 6 * draws.MOST + 4
    with Store(tmp_path / "results.sqlite") as store:
        store.begin_run("", "", "", {}, {})
        judged = {jobs.judged_by(job): np.zeros((9, 12, 3), np.float32) for job in plan.jobs}
        assert set(judged) == {("edge", "box", draws.shift_of(draw)) for draw in range(draws.MOST)}
        options = pipeline.Options(least_seconds=0.2)
        outcomes, reused = pipeline.execute(
            plan,
            tmp_path,
            store,
            judged,
            options,
            lambda *_: None,
            cast(workers.Workers, timing),
            cast(workers.Workers, measuring),
        )
        kept, noise = store.done(outcomes), store.noise(outcomes)
    assert reused == 0
    assert {at for _, at in timing.begun} == {0}
    rendered = [name for name, _ in timing.begun if name != "beat"]
    assert rendered == [job.renderer for job in sorted(plan.jobs, key=lambda job: job.key)]
    assert timing.least == {0.2}
    # The fixed job comes first, after every ten, and last.
    assert [number for number, (name, _) in enumerate(timing.begun) if name == "beat"] == [0, 11, 22, 25]
    assert noise is not None
    assert (noise.runs, noise.seconds, noise.spread, noise.loaded) == (4, 0.02, 0.0, False)
    assert beside == [0] * len(plan.jobs)
    assert len(measuring.begun) == draws.MOST
    assert len(kept) == len(plan.jobs)
    assert all(outcome.metrics == {"rmse": 0.5} for outcome in kept.values())
    assert {outcome.job for outcome in kept.values()} == set(plan.jobs)


def test_worker_processes_that_do_not_start_are_a_failed_job() -> None:
    task: Future[None] = Future()
    task.set_exception(BrokenProcessPool("All workers expired"))
    with pytest.raises(JobFailed, match="do not stay alive"):
        workers.Task(task, 1.0).result()


def test_a_process_is_ended_not_long_after_its_time_limit() -> None:
    assert [workers.patience(seconds) for seconds in (0.1, 2.0, 10.0, 120.0)] == [2.1, 4.0, 15.0, 140.0]


@pytest.mark.parametrize("name", ["embree", "osmesa"])
def test_a_time_limit_that_has_passed_is_a_failed_job(name: str) -> None:
    scene = scene_io.load("edge").scene
    renderer = renderers.find(name)
    mode = renderers.mode_of(renderer, "uniform:n=1" if name == "embree" else "none")
    with pytest.raises(JobFailed, match="took more than 1e-06 s"):
        renderer.render(Request(scene, 8, 6, mode, least_seconds=60.0, time_limit=1e-6))
