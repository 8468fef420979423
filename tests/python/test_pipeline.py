"""Which code and which plugins a picture is kept under."""

from __future__ import annotations

import ast
import subprocess
from collections.abc import Sequence
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

import aliascope
from aliascope import jobs, pipeline, renderers, scene_io, workers
from aliascope.errors import JobFailed
from aliascope.metrics.base import Measured
from aliascope.pipeline import Timed
from aliascope.records import Cost, Rendering
from aliascope.renderers.base import Request
from aliascope.store import Store

PACKAGE = Path(aliascope.__file__).parent
HARMLESS = {"errors.py", "records.py"}
"""Imported by renderers, and free of anything that could change a picture: messages and frozen types."""


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
    assert not [name for name in povray if name.endswith(".so")]
    assert {"osmesa.py", "raster.py", "libaliascope-raster.so"} <= osmesa
    assert not osmesa & {"libaliascope.so", "libaliascope-tracer.so", "tracer.py"}
    assert "libaliascope.so" in names("osmesa", "accumulate") & names("povray", "accumulate")
    modes = (("embree", "uniform"), ("povray", "am1"), ("povray", "accumulate"), ("osmesa", "msaa"))
    found = {jobs.code_digest(name, renderers.mode_of(renderers.find(name), mode)) for name, mode in modes}
    assert len(found) == len(modes)


class Slow:
    """Workers whose tasks are not done when they are asked first, and what ran beside what."""

    def __init__(self) -> None:
        self.abreast: list[tuple[str, float, int]] = []
        """Of each job as it begins: renderer, least seconds, how many run with it."""
        self.running: list[object] = []

    def begin(self, task: object, arguments: Sequence[Any], time_limit: float) -> Running:
        _, job, options = arguments
        begun = Running(self)
        self.abreast.append((job.renderer, options.least_seconds, len(self.running)))
        return begun


class Running:
    def __init__(self, among: Slow) -> None:
        self.asked, self.among = 0, among
        among.running.append(self)

    def done(self) -> bool:
        self.asked += 1
        return self.asked > 1

    def result(self) -> Timed:
        self.among.running.remove(self)
        cost = Cost(samples=1, samples_per_pixel=1.0, rays={}, cpu_seconds=0.0, wall_seconds=0.0, repeats=1)
        return Timed(Rendering(np.zeros((9, 12, 3), np.float32), cost), 0.0)


def test_timed_jobs_run_alone_those_that_idle_side_by_side_and_nothing_is_measured_beside_the_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, slow = scene_io.load("edge"), Slow()
    beside: list[int] = []
    monkeypatch.setattr(pipeline.metrics, "METRICS", {"rmse": None})
    monkeypatch.setattr(
        pipeline.metrics, "measure", lambda *_: beside.append(len(slow.running)) or {"rmse": Measured(0.0)}
    )
    modes = {"povray": [f"regular:n={side * side}" for side in range(2, 8)], "embree": ["uniform:n=1,sampler=random"]}
    plan = jobs.make_plan([file], modes, seeds=4, size=(12, 9))
    with Store(tmp_path / "results.sqlite") as store:
        store.begin_run("", "", "", {}, {})
        judged = {("edge", "box"): np.zeros((9, 12, 3), np.float32)}
        options = pipeline.Options(least_seconds=0.2)
        outcomes, reused = pipeline.execute(
            plan, tmp_path, store, judged, options, lambda *_: None, cast(workers.Workers, slow)
        )
        kept = store.done(outcomes)
    assert reused == 0
    assert {name: [at for each, _, at in slow.abreast if each == name] for name in modes} == {
        "embree": [1, 1, 1, 1],
        "povray": [1, 2, 3, 4, 4, 4],
    }
    assert {(name, seconds) for name, seconds, _ in slow.abreast} == {("embree", 0.05), ("povray", 0.2)}
    assert len(beside) == len(plan.jobs) == len(kept)
    assert beside[:2] == [4, 4]  # those of Embree, while POV-Ray's are on their way
    assert all(set(outcome.metrics) == {"rmse"} for outcome in kept.values())


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
