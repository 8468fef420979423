"""What comes and goes with the jobs of a cluster: plugins, what was logged, pictures, each once."""

from __future__ import annotations

import json
import os
import subprocess
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from clusters import cluster_of, until
from commands import COMMAND, checked, in_a_fork, run, separately
from test_external import fake, picture
from test_knobs import few  # noqa: F401  (a fixture)

from aliascope import at_start, jobs, renderers, scene_io
from aliascope.cluster import work
from aliascope.cluster.address import Tls
from aliascope.cluster.client import Cluster
from aliascope.errors import NotAvailable
from aliascope.image import read_image
from aliascope.native import samplers
from aliascope.pipeline import Options, render_job
from aliascope.workers import Task, first_done

distributed = pytest.importorskip("distributed")

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "csrc" / "plugins" / "kronecker.c"
SMALL = ("edge", "--size", "16x12")
WITH_PLUGIN = ("compare", *SMALL, "-r", "embree", "-m", "uniform:n=4,sampler=mine")


@dataclass(frozen=True)
class Running:
    """A cluster of two workers, a renderer that one of them has, which kills whoever runs it, and one that both have,
    which counts its pictures in a file."""

    address: str
    crashing: Path
    counting: Path
    counted: Path


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    folder = tmp_path_factory.mktemp("cluster")
    counted, kept = folder / "counted", picture(folder, np.full((6, 8, 3), 0.5))
    crashing = seeded(folder / "crashing", "kill -KILL $PPID; exit 1")
    counting = seeded(folder / "counting", f'echo $PPID >>"{counted}"; cp "{kept}" "$2"')
    with cluster_of(folder, ("-r", crashing, "-r", counting), ("-r", counting)) as address:
        yield Running(address, crashing, counting, counted)
    assert list((folder / "tmp").rglob("*plugins*")) == []


@pytest.fixture(autouse=True)
def _registry(monkeypatch: pytest.MonkeyPatch) -> None:
    """The renderers of a test are gone after it."""
    monkeypatch.setattr(renderers, "RENDERERS", dict(renderers.BUILT_IN))
    monkeypatch.setattr(at_start, "_STEPS", {})


def seeded(folder: Path, script: str) -> Path:
    """A renderer of this name, which gets a picture for each seed."""
    folder.mkdir()
    path = fake(folder, script)
    text = path.read_text().replace('"fake"', f'"{folder.name}"')
    path.write_text(text.replace("seeded = false", "seeded = true").replace('"{height}"', '"{height}", "{seed}"'))
    return path


# --- plugins ----------------------------------------------------------------------------------------------------------


def compiled(folder: Path, *words: str | Path, more: str = "") -> Path:
    """The example as a plugin "mine"."""
    source, out = folder / "mine.c", folder / "mine.so"
    source.write_text(EXAMPLE.read_text().replace('.name = "kronecker"', '.name = "mine"') + more)
    include = ROOT / "csrc" / "include"
    subprocess.run(["cc", "-shared", "-fPIC", "-O2", f"-I{include}", source, "-o", out, *words, "-lm"], check=True)
    return out


def test_a_plugin_comes_with_the_jobs(cluster: Running, tmp_path: Path) -> None:
    plugin, here, there = compiled(tmp_path), tmp_path / "here", tmp_path / "there"
    elsewhere = ("--cluster", cluster.address, "--plugin", plugin, "--json")
    told = json.loads(separately(*WITH_PLUGIN, "-o", there, *elsewhere).stdout)
    assert (told["failed"], told["rendered"]) == (0, 3)
    separately(*WITH_PLUGIN, "-o", here, "--plugin", plugin)
    paths = sorted(path.relative_to(here) for path in here.glob("images/**/*.exr"))
    assert len(paths) == 3
    assert all(np.array_equal(read_image(here / path), read_image(there / path)) for path in paths)


def test_a_plugin_that_a_worker_cannot_load_is_said_in_a_line(cluster: Running, tmp_path: Path) -> None:
    """One that rests on a library, which is found here alone."""
    (tmp_path / "helper.c").write_text("double helped(void) { return 1.0; }\n")
    library = tmp_path / "libhelper.so"
    subprocess.run(["cc", "-shared", "-fPIC", tmp_path / "helper.c", "-o", library], check=True)
    more = '\ndouble helped(void);\n__attribute__((visibility("default"))) double uses(void) { return helped(); }\n'
    plugin = compiled(tmp_path, f"-L{tmp_path}", "-lhelper", more=more)
    out = tmp_path / "out"
    words = [*COMMAND, *WITH_PLUGIN, "-o", out, "--cluster", cluster.address, "--plugin", plugin, "--json"]
    found = subprocess.run(
        list(map(str, words)),
        env={**os.environ, "LD_LIBRARY_PATH": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert json.loads(checked(found, 4).stdout)["failed"] == 3
    host = os.uname().nodename
    failed = [line for line in lines_of(out) if line["event"] == "job"]
    assert len(failed) == 3
    for line in failed:
        assert line["why"].startswith(f"a plugin cannot be loaded on {host}: mine.so: ")
        assert "libhelper.so" in line["why"]
        assert "tmp/aliascope" not in line["why"]  # where it lay for a while on that machine
    # The worker does other jobs after it, with its own plugins or none.
    told = run("compare", *SMALL, "-m", "uniform:n=1", "-o", out, "--cluster", cluster.address, "--json").stdout
    assert json.loads(told)["failed"] == 0


def _of_a_changed_file(path: Path) -> tuple[str, str]:
    """What is said of a plugin that is another when it is sent, and of one that arrives as another."""
    samplers.load_plugin(str(path))
    (sent,) = work.plugins_sent()
    try:
        work._written(replace(sent, contents=sent.contents + b"\0"))
    except work.Unsupported as error:
        arrived = str(error)
    new = path.with_name("new.so")
    new.write_bytes(sent.contents + b"\0")
    new.replace(path)
    try:
        work.plugins_sent()
    except NotAvailable as error:
        return str(error), arrived
    return "", arrived


def test_a_plugin_is_sent_as_it_was_loaded(tmp_path: Path) -> None:
    changed, arrived = in_a_fork(_of_a_changed_file, compiled(tmp_path))
    assert changed == "mine.so: the file of this plugin changed since it was loaded; begin anew"
    assert arrived == "the plugin mine.so did not arrive as it was sent"


# --- the log ----------------------------------------------------------------------------------------------------------


def lines_of(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "log.jsonl").read_text(encoding="utf-8").splitlines()]


def test_the_log_says_which_worker_did_what(cluster: Running, tmp_path: Path) -> None:
    words = ("compare", *SMALL, "-r", "povray", "-m", "none", "-m", "plain", "-r", cluster.crashing)
    run(*words, "-o", tmp_path, "--cluster", cluster.address, code=4)
    lines = lines_of(tmp_path)
    with distributed.Client(cluster.address, set_as_default=False) as client:
        processes = client.run(os.getpid)  # of the workers themselves, by their address
    drawn = [line for line in lines if line["event"] == "job" and line.get("renderer") == "povray"]
    assert {line["status"] for line in drawn} == {"done"}
    for line in drawn:
        assert (line["host"], line["worker"] in processes) == (os.uname().nodename, True)
        assert line["process"] not in processes.values()
        # What was logged in that process came back.
        assert line["counts"]["command"] == len(line["log"]["command"]) > 0
        assert "povray" in line["log"]["command"][0]
    crashed = [line for line in lines if line.get("renderer") == "crashing" and line["event"] in ("job", "retry")]
    assert Counter(line["event"] for line in crashed) == {"retry": 3, "job": 3}
    for line in crashed:
        assert (line["host"], line["worker"] in processes) == (os.uname().nodename, True)
        assert line["process"] not in processes.values()
        if line["event"] == "retry":
            assert line["text"] == f"its process ended by SIGKILL on {line['worker']}; it goes to a worker again"
        else:
            assert line["why"] == "its process ended by SIGKILL, on each of 2 workers"
            assert (line["status"], line["kind"]) == ("failed", "JobFailed")


# --- pictures ---------------------------------------------------------------------------------------------------------


def watch() -> Any:
    """What has a scheduler count how often each task ends, how many jobs it knows of at once, and what it hands on.

    Functions within functions go there by their code: the scheduler cannot import this file."""

    def begin(dask_scheduler: Any) -> None:
        from distributed.diagnostics.plugin import SchedulerPlugin

        class Watch(SchedulerPlugin):  # type: ignore[misc]
            name = "watch"

            def __init__(self) -> None:
                self.most, self.handed, self.ends = 0, 0, dict[str, int]()

            def transition(self, key: Any, start: str, finish: str, *_: Any, **__: Any) -> None:
                self.most = max(self.most, sum("held" not in str(each) for each in dask_scheduler.tasks))
                if finish == "memory":
                    self.ends[str(key)] = self.ends.get(str(key), 0) + 1

        watching, gather = Watch(), dask_scheduler.handlers["gather"]

        def counted(*words: Any, **named: Any) -> Any:
            watching.handed += 1
            return gather(*words, **named)

        dask_scheduler.handlers["gather"] = counted
        dask_scheduler.add_plugin(watching)

    return begin


def seen() -> Any:
    """What tells what it saw, and which tasks there are."""

    def told(dask_scheduler: Any) -> tuple[int, int, dict[str, int], list[str]]:
        found = dask_scheduler.plugins["watch"]
        return found.most, found.handed, dict(found.ends), [str(key) for key in dask_scheduler.tasks]

    return told


def test_each_job_is_done_once_and_its_picture_comes_here_alone(cluster: Running) -> None:
    name = renderers.find(str(cluster.counting)).name
    plan = jobs.make_plan([scene_io.load("edge")], {name: ["plain"], "embree": ["uniform:n=1"]}, 12, (8, 6))
    count = Counter(job.renderer for job in plan.jobs)
    assert set(count.values()) == {12}
    before = len(cluster.counted.read_text().split()) if cluster.counted.exists() else 0
    options = Options(least_seconds=0.0)
    with distributed.Client(cluster.address, set_as_default=False) as client:
        client.run_on_scheduler(watch())
        with Cluster(cluster.address, Tls(), plan, lambda _: None) as there:
            waiting: list[Task[Any]] = []
            came = 0
            for job in plan.jobs:  # as pipeline.execute does
                while len(waiting) >= there.window:
                    came += waiting.pop(first_done(waiting)).result().rendering.pixels.shape == (6, 8, 3)
                waiting.append(there.begin(render_job, [plan.files[job.scene], job, options], 60.0))
            came += sum(task.result().rendering.pixels.shape == (6, 8, 3) for task in waiting)
            assert came == len(plan.jobs)
            # A picture that is here is nowhere else, while the rest is still done.
            until(lambda: all("held" in key for key in client.run_on_scheduler(seen())[3]), "pictures are left")
            most, handed, ends, _ = client.run_on_scheduler(seen())
            assert 0 < most <= there.window
    assert handed == 0
    assert sorted(ends.values()) == [1] * (len(plan.jobs) + 1)  # and the scene
    assert len(cluster.counted.read_text().split()) == before + count[name]


@pytest.mark.usefixtures("few")
def test_knobs_are_turned_there_too(cluster: Running, tmp_path: Path) -> None:
    words = ("knobs", *SMALL, "-r", "embree", "-o", tmp_path, "--cluster", cluster.address, "--json")
    told = json.loads(run(*words).stdout)
    assert {"packet", "robust", "film", "filter"} <= {knob["knob"] for knob in told["knobs"]}
    drawn = [line for line in lines_of(tmp_path) if line["event"] == "job" and "seed" in line]
    assert len(drawn) > 12
    assert {line["status"] for line in drawn} == {"done"}
    assert all(line["worker"].startswith("tcp://127.0.0.1:") for line in drawn)


def test_a_worker_that_is_killed_comes_back(cluster: Running) -> None:
    with distributed.Client(cluster.address, set_as_default=False) as client:
        address, process = next(iter(client.run(os.getpid).items()))
        os.kill(process, 9)

        def others() -> bool:
            there = client.scheduler_info(n_workers=-1)["workers"]
            return address not in there and len(there) == 2

        until(others, "none came back")
