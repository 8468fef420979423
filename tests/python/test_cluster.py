"""Jobs on a dask.distributed cluster: a scheduler and four workers, each a process of its own on this machine."""

from __future__ import annotations

import asyncio
import dataclasses
import json
import os
import pickle
import re
import signal
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from clusters import cluster_of, until
from commands import complaint, run
from test_external import fake

from aliascope import at_start, calibration, image, jobs, renderers, scene_io, workers
from aliascope.calibration import Beat, Effort
from aliascope.cluster import client as cluster_client
from aliascope.cluster import work
from aliascope.cluster.address import Tls
from aliascope.cluster.client import Cluster
from aliascope.errors import InvalidInput, JobFailed
from aliascope.pipeline import Options, render_job
from aliascope.records import Cost, Outcome
from aliascope.store import Store

distributed = pytest.importorskip("distributed")

MODES = (
    "uniform:n=4,sampler=random",
    "adaptive:method=whitted,n=9",
    "none",
    "msaa:n=4",
    "accumulate:n=4,sampler=random",
)
"""Seeded and deterministic ones of each renderer."""
JOBS = ("edge", "discs", *(word for mode in MODES for word in ("-m", mode)))


@dataclasses.dataclass(frozen=True)
class Running:
    """A cluster, and the file of a renderer that kills whoever runs it, which one of its workers has."""

    address: str
    crashing: Path


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    folder = tmp_path_factory.mktemp("cluster")
    crashing = fake(folder, "kill -KILL $PPID; sleep 60")
    with cluster_of(folder, ("-j", "3", "-r", crashing), ("--without", "osmesa")) as address:
        yield Running(address, crashing)
    assert "not osmesa: its worker was started without it" in (folder / "worker-1.log").read_text()


def kill_one_that_works(address: str, killed: list[str]) -> None:
    """kill -9 of a worker with a job, as soon as there is one."""
    with distributed.Client(address, set_as_default=False) as client:
        busy = until(lambda: [each for each, tasks in client.processing().items() if _jobs(tasks)], "no worker works")
        pid = client.run(os.getpid, workers=[busy[0]])[busy[0]]
        os.kill(pid, signal.SIGKILL)
        killed.append(busy[0])


def _jobs(keys: Any) -> list[str]:
    return [key for key in keys if "held" not in str(key)]


def pictures(folder: Path) -> dict[str, np.ndarray]:
    """By path, with the counts of adaptive modes."""
    found = sorted(folder.glob("images/**/*.exr"))
    read = {True: image.read_counts, False: image.read_image}
    return {str(path.relative_to(folder)): read[path.name.endswith(".counts.exr")](path) for path in found}


def test_a_cluster_draws_the_same_bits_though_a_worker_is_killed(cluster: Running, tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    killed: list[str] = []
    killer = threading.Thread(target=kill_one_that_works, args=(cluster.address, killed), daemon=True)
    killer.start()
    found = run("compare", *JOBS, "-o", there, "--cluster", cluster.address, "--json")
    killer.join()
    assert len(killed) == 1
    assert "4 workers on" in found.stderr
    told = json.loads(found.stdout)
    # OSMesa's too: none of them came to the worker that has no OSMesa, which would have refused it.
    assert (told["failed"], told["rendered"]) == (0, told["pictures"])
    local = json.loads(run("compare", *JOBS, "-o", here, "--json", "-j", "2").stdout)
    own, others = pictures(here), pictures(there)
    assert len(own) > told["pictures"] > 20  # with the counts of the samples
    assert own.keys() == others.keys()
    assert [path for path in own if not np.array_equal(own[path], others[path])] == []
    drawn = ("scene", "renderer", "mode", "samples", "rays", "metrics", "draws")
    assert [{name: row[name] for name in drawn} for row in told["rows"]] == [
        {name: row[name] for name in drawn} for row in local["rows"]
    ]
    # The scheduler has forgotten the jobs and the scenes.
    with distributed.Client(cluster.address, set_as_default=False) as client:
        until(lambda: client.run_on_scheduler(lambda dask_scheduler: not dask_scheduler.tasks), "tasks are left")

    machine = str(work.machine())
    page = (there / "report.html").read_text()
    assert f"{told['pictures']} pictures on {machine}" in page
    assert "A fixed job of" in told["noise"]["told"]
    with Store(there / "results.sqlite") as store:
        plan = jobs.make_plan([scene_io.load("edge")], {"embree": [MODES[0]]}, 3)
        done = store.done(job.key for job in plan.jobs)
    assert {outcome.machine for outcome in done.values()} == {machine}
    assert {outcome.processes for outcome in done.values()} <= {3, 4}  # three, while the killed one was away
    again = json.loads(run("compare", *JOBS, "-o", there, "--cluster", cluster.address, "--json").stdout)
    assert (again["rendered"], again["rows"]) == (0, told["rows"])


@pytest.fixture
def crashing(cluster: Running, monkeypatch: pytest.MonkeyPatch) -> str:
    """Its name; the renderers of a test are gone after it."""
    monkeypatch.setattr(renderers, "RENDERERS", dict(renderers.BUILT_IN))
    monkeypatch.setattr(at_start, "_STEPS", {})
    return renderers.find(str(cluster.crashing)).name


def test_a_job_that_ends_its_process_twice_has_failed(cluster: Running, crashing: str) -> None:
    plan = jobs.make_plan([scene_io.load("edge")], {crashing: ["plain"], "embree": ["uniform:n=1"]}, 1, (8, 6))
    with Cluster(cluster.address, Tls(), plan, lambda _: None) as there:
        tasks = {
            job.renderer: there.begin(render_job, [plan.files[job.scene], job, Options(least_seconds=0.0)], 60.0)
            for job in plan.jobs
        }
        with pytest.raises(JobFailed, match="its process ended by SIGKILL, on each of 2 workers"):
            tasks[crashing].result()
        assert tasks["embree"].result().rendering.pixels.shape == (6, 8, 3)


def test_a_job_that_no_worker_can_do_fails_at_once(cluster: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "renderer_versions", lambda name: {name: "0.0"})
    plan = jobs.make_plan([scene_io.load("edge")], {"embree": ["uniform:n=1"], "povray": ["none"]}, 1, (8, 6))
    told: list[str] = []
    with Cluster(cluster.address, Tls(), plan, told.append) as there:
        for job in plan.jobs:
            task = there.begin(render_job, [plan.files[job.scene], job, Options()], 60.0)
            with pytest.raises(JobFailed, match=rf"no worker can draw with {job.renderer}: .* where 0.0 is wanted"):
                task.result()
        assert set(there.without_worker()) == {"embree", "povray"}
    assert sum("gets no jobs of embree: it has embree" in line for line in told) == 4


# --- without a cluster ------------------------------------------------------------------------------------------------


def test_a_worker_with_other_versions_refuses() -> None:
    (job,) = jobs.make_plan([scene_io.load("edge")], {"embree": ["uniform:n=1"]}, 1, (8, 6)).jobs
    versions = {**jobs.renderer_versions("embree"), "code": "of tomorrow"}
    sent = work.Sent(job, Options(), True, versions, 60.0)
    other = dataclasses.replace(sent, versions={"embree": "9", "code": "x"})
    found = [pickle.loads(work.perform(b"", (), pickle.dumps(each))).error for each in (sent, other)]
    assert [type(error) for error in found] == [work.OtherVersions] * 2
    assert "has other code of ours" in str(found[0])
    assert re.search(r"has embree .* where 9 is wanted, other code", str(found[1]))


def test_a_worker_has_a_resource_for_what_it_can_draw() -> None:
    said = work.about(["osmesa"])
    assert said.absent["osmesa"] == "its worker was started without it"
    found = said.resources()
    for renderer, mode in (("embree", "uniform:n=1"), ("povray", "none")):
        spec = renderers.mode_of(renderers.find(renderer), mode)
        versions = jobs.versions_of(renderers.find(renderer), spec, renderers.find(renderer).versions())
        assert work.resource(renderer, versions) in found
    assert not any("osmesa" in name for name in found)
    assert work.of_document(json.loads(json.dumps(work.document(said)))) == said
    with pytest.raises(InvalidInput, match="unknown renderer"):
        work.about(["osmeza"])


@pytest.mark.parametrize("address", ["boss:8786", "tcp://boss", "tcp://boss:0", "http://boss:8786", "tcp://boss:99999"])
def test_an_address_that_cannot_be_read(address: str, tmp_path: Path) -> None:
    for words in (["worker", address], ["compare", "edge", "-o", tmp_path / "out", "--cluster", address]):
        assert "is no address of a scheduler: it is of the form tcp://HOST:8786" in complaint(*words, code=2)
    assert not (tmp_path / "out").exists()


def test_where_nobody_answers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster_client, "CONNECTING", 0.2)
    chosen = ("edge", "-m", "none", "--size", "16x12")
    words = ("compare", *chosen, "-o", tmp_path / "out", "--cluster", "tcp://127.0.0.1:1")
    # It is refused, or the time is over, on a busy machine.
    told = "no scheduler answers at tcp://127.0.0.1:1"
    assert told in (line := complaint(*words, code=3))
    assert "dask scheduler" in line

    async def in_a_loop() -> str:
        """As from a notebook, whose thread has a loop that runs."""
        return complaint(*words, code=3)

    with ThreadPoolExecutor(1) as thread:  # this one may have a loop already, that of the tests of pages
        assert told in thread.submit(lambda: asyncio.run(in_a_loop())).result()
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "pip install 'aliascope[cluster]'" in complaint(*words, code=3)
    assert not (tmp_path / "out" / "references").exists()  # which may take long


def test_explain_says_what_would_move(tmp_path: Path) -> None:
    words = ("compare", "edge", "discs", "-m", "uniform:n=1", "-m", "adaptive:method=whitted,n=9", "-o", tmp_path)
    told = json.loads(run(*words, "--explain", "--json").stdout)
    pixels = 128 * 96
    assert told["jobs"] == {"embree": 12}
    assert told["picture_bytes"] == 4 * pixels * (6 * 3 + 6 * 4)  # adaptive ones have the counts too
    assert told["scene_bytes"]["edge"] == len(pickle.dumps(scene_io.load("edge")))
    assert told["scene_bytes_a_worker"] == sum(told["scene_bytes"].values())
    assert told["request_bytes"] == 12 * told["request_bytes_a_job"]
    assert (told["jobs_of_known_cost"], told["without_worker"]) == (0, {})
    assert not (tmp_path / "results.sqlite").exists()
    with Store(tmp_path / "results.sqlite") as store:
        store.begin_run("", "", "", {}, {})
        plan = jobs.make_plan([scene_io.load("edge")], {"embree": ["uniform:n=1"]}, 1)
        cost = Cost(1, 1.0, {}, cpu_seconds=0.5, wall_seconds=1.0, repeats=3)
        store.put(Outcome(plan.jobs[0], "done", cost=cost, machine="node-a (x, 2 cores)"))
        assert store.done([plan.jobs[0].key])[plan.jobs[0].key].machine == "node-a (x, 2 cores)"
    lines = run(*words, "--explain").stdout.splitlines()
    assert lines[0] == "12 jobs of embree"
    assert "4.5 s of CPU time for the 3 jobs whose modes have been timed here before" in lines
    (tmp_path / "results.sqlite").write_text("no database, but long enough to be looked at" * 9)
    assert "choose another folder" in complaint(*words, "--explain", code=2)


def test_the_first_that_is_done_is_kept_first() -> None:
    futures: list[Future[int]] = [Future() for _ in range(3)]
    tasks = [workers.Task(future, 1.0) for future in futures]
    futures[1].set_result(5)
    assert workers.first_done(tasks) == 1
    assert workers.first_done(tasks[:1]) == 0  # one alone is not waited for
    futures[0].set_exception(OSError("gone"))
    assert workers.first_done(tasks) == 0


def test_times_of_unlike_machines_are_not_mixed_in_silence() -> None:
    def seen(*seconds: float) -> calibration.Elsewhere:
        found = calibration.Elsewhere()
        for number, each in enumerate(seconds):
            for _ in range(4):
                found.ran(f"node-{number}", Effort(1.0, 1.0, 1, 1.0), [Beat(each, each)])
        return found

    alike, unlike = seen(0.02, 0.021).noise(), seen(0.02, 0.03).noise()
    assert calibration.Elsewhere().noise() is None
    assert alike is not None
    assert unlike is not None
    assert (alike.loaded, unlike.loaded, unlike.runs) == (False, True, 8)
    assert "node-1 is 50 % slower than node-0" in unlike.told
    assert calibration.mixed(alike, {"a (x, 2 cores)": 3, "b (x, 2 cores)": 1}) is alike
    own = calibration.mixed(alike, {"": 3, "b (x, 2 cores)": 1})
    assert own is not None
    assert own.loaded
    assert own.told.startswith("The times of 2 unlike machines are mixed")


def test_what_is_kept_of_a_scene_goes_with_it() -> None:
    from aliascope import model

    asked: list[tuple[Any, ...]] = []

    @model.by_scene
    def told(scene: model.Scene, word: str = "") -> object:
        asked.append((id(scene), word))
        return scene if word == "itself" else len(asked)

    first, second = scene_io.load("edge").scene, scene_io.load("edge").scene
    assert [told(first), told(first), told(second), told(first, "x"), told(first)] == [1, 1, 2, 3, 1]
    assert told(second, "itself") is told(second, "itself") is second
    assert len(asked) == 4
    kept = told.__closure__
    assert kept is not None
    answers = next(cell.cell_contents for cell in kept if isinstance(cell.cell_contents, dict))
    assert set(answers) == {id(first), id(second)}
    number = id(second)
    del second
    assert number not in answers
