"""The log of a run: what ran where, when, how long and why it failed; and what -v and -q say on standard error."""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest
from commands import COMMAND, run

from aliascope import logs, scene_io
from aliascope.cli.shared import say_notes
from aliascope.errors import InvalidInput, JobFailed
from aliascope.workers import Workers

SMALL = ["edge", "-r", "embree", "-m", "uniform:n=4", "--size", "16x12"]


@pytest.fixture(autouse=True)
def as_it_was() -> Iterator[None]:
    yield
    logs.end(None)
    logs.tell()


def lines_of(folder: Path, name: str = logs.FILE) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / name).read_text(encoding="utf-8").splitlines()]


def named(lines: list[dict[str, Any]], name: str) -> list[dict[str, Any]]:
    return [line for line in lines if line["event"] == name]


# --- tasks, which run in worker processes -----------------------------------------------------------------------------


def fine(number: int) -> int:
    logs.event(logging.DEBUG, "command", "povray +W3")
    logs.event(logging.INFO, "retry", "povray: starved: it is started again")
    return number + 1


def refuses() -> None:
    raise InvalidInput("no such thing")


def breaks() -> None:
    raise ValueError("a mistake of ours")


def dies() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def test_each_job_says_where_when_how_long_and_why_it_failed(tmp_path: Path) -> None:
    with logs.run(tmp_path, "aliascope x"), Workers(1) as workers:
        assert workers.begin(fine, [1], 60.0, {"scene": "edge", "seed": 3}).result() == 2
        with pytest.raises(InvalidInput, match="no such thing"):
            workers.begin(refuses, [], 60.0, {"scene": "a"}).result()
        with pytest.raises(ValueError, match="a mistake of ours"):
            workers.begin(breaks, [], 60.0, {"scene": "b"}).result()
        with pytest.raises(JobFailed, match="SIGKILL"):
            workers.begin(dies, [], 60.0, {"scene": "c"}).result()
        workers.begin(fine, [1], 60.0).result()  # about nothing: no job
    lines = lines_of(tmp_path)
    first, last = lines[0], lines[-1]
    assert (first["event"], last["event"], last["status"]) == ("run", "end", 0)
    assert first["command"] == "aliascope x"
    assert {"version", "revision", "machine", "host", "process", "python"} <= set(first)
    done, refused, wrong, died = named(lines, "job")
    assert (done["scene"], done["seed"], done["status"], done["host"]) == ("edge", 3, "done", os.uname().nodename)
    assert done["process"] != first["process"] == os.getpid()
    assert done["seconds"] >= 0.0
    assert done["began_monotonic"] <= done["monotonic"]
    assert datetime.fromisoformat(done["began"]) <= datetime.fromisoformat(done["time"])
    assert datetime.fromisoformat(done["began"]).utcoffset() is not None
    assert done["log"] == {"command": ["povray +W3"], "retry": ["povray: starved: it is started again"]}
    assert done["counts"] == {"command": 1, "retry": 1}
    assert (refused["status"], refused["why"], refused["kind"]) == ("failed", "no such thing", "InvalidInput")
    assert refused["process"] == done["process"]
    assert (wrong["status"], wrong["kind"]) == ("failed", "ValueError")
    assert died["why"] == "its process ended by SIGKILL"
    assert died["process"] not in (None, os.getpid())
    assert len({line["run"] for line in lines}) == 1


def test_a_second_run_goes_on_in_the_file(tmp_path: Path) -> None:
    for _ in range(2):
        with logs.run(tmp_path, "aliascope x"):
            pass
    assert [line["event"] for line in lines_of(tmp_path)] == ["run", "end", "run", "end"]


def test_a_run_that_ends_by_an_error_says_so(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput), logs.run(tmp_path, "x"):
        raise InvalidInput("no scene")
    assert {"status": 2, "why": "no scene"}.items() <= lines_of(tmp_path)[-1].items()


def test_a_folder_that_is_not_made_gets_no_log(tmp_path: Path) -> None:
    with logs.run(tmp_path / "out", "x"):
        logs.warn("a")
    assert not (tmp_path / "out").exists()
    with logs.run(tmp_path / "out", "x"):
        logs.warn("before")
        (tmp_path / "out").mkdir()
    assert [line["event"] for line in lines_of(tmp_path / "out")] == ["run", "warning", "end"]


def test_the_size_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(logs, "LARGEST", 20_000)
    with logs.run(tmp_path, "x"):
        for number in range(400):
            logs.event(logging.INFO, "job", "", number=number, why="y" * 50_000 if number % 100 == 0 else "z")
    paths = sorted(path.name for path in tmp_path.iterdir())
    assert paths == ["log.jsonl", "log.jsonl.1"]
    assert all(0 < (tmp_path / name).stat().st_size <= 20_000 for name in paths)
    kept = [line["number"] for name in reversed(paths) for line in lines_of(tmp_path, name) if "number" in line]
    assert kept == list(range(kept[0], 400))
    assert max(len(line.get("why", "")) for name in paths for line in lines_of(tmp_path, name)) <= logs.LONGEST_TEXT


WRITER = """
import logging, sys
from pathlib import Path
from aliascope import logs, scene_io
from aliascope.cli.shared import say_notes
logs.begin(Path(sys.argv[1]), "x")
number = 0
while True:
    logs.event(logging.INFO, "job", "", number=number, text="\\u00e4" * (number % 1500))
    number += 1
    if number == 50:
        print("there", flush=True)
"""


def test_lines_are_whole_after_a_kill(tmp_path: Path) -> None:
    for _ in range(3):
        with subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path)], stdout=subprocess.PIPE) as writer:
            assert writer.stdout is not None
            assert writer.stdout.readline() == b"there\n"
            writer.kill()
    assert (tmp_path / logs.FILE).read_bytes().endswith(b"\n")
    lines = lines_of(tmp_path)
    assert len(named(lines, "run")) == 3
    for process in {line["run"] for line in lines}:
        numbers = [line["number"] for line in lines if line["run"] == process and "number" in line]
        assert numbers == list(range(len(numbers)))
        assert len(numbers) >= 50


def test_a_line_that_was_torn_off_spoils_no_other(tmp_path: Path) -> None:
    (tmp_path / logs.FILE).write_bytes(b'{"event": "jo')
    with logs.run(tmp_path, "x"):
        pass
    torn, *rest = (tmp_path / logs.FILE).read_text().splitlines()
    assert torn == '{"event": "jo'
    assert [json.loads(line)["event"] for line in rest] == ["run", "end"]


def test_a_log_that_cannot_be_written_is_said_once_and_stops_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / logs.FILE).mkdir()
    logs.tell()
    with logs.run(tmp_path, "x"):
        logs.warn("a warning")
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 2
    assert told[0].endswith("log.jsonl: cannot be written: Is a directory; the run goes on without a log")
    assert told[1] == "a warning"


def test_a_full_disk_stops_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / logs.FILE).symlink_to("/dev/full")
    logs.tell()
    with logs.run(tmp_path, "x"):
        logs.warn("a warning")
    assert "No space left on device; the run goes on without a log" in capsys.readouterr().err


def test_nothing_secret_and_no_environment_is_logged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/somewhere/ada")
    monkeypatch.setenv("MY_TOKEN", "lovelace-1843")
    with logs.run(tmp_path, "aliascope compare"):
        why = "cannot reach tls://ada:lovelace@host with /somewhere/ada/key.pem"
        logs.event(logging.INFO, "job", "", why=why, more={"token=analytical": [("--password engine",)]})
        logs.warn("tcp://ada:lovelace@host")
    text = (tmp_path / logs.FILE).read_text()
    assert "tls://***@host with ~/key.pem" in text
    assert not [word for word in ("lovelace", "engine", "/somewhere", "1843", "PATH") if word in text]


# --- -v and -q --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("logs")


@pytest.mark.parametrize("words", [["-v", "compare"], ["compare", "--verbose"]])
def test_verbose_says_each_job_before_or_after_the_command(folder: Path, words: list[str]) -> None:
    out = folder / words[-1]
    result = run(*words, *SMALL, "-o", out, "--json")
    told = result.stderr.splitlines()
    assert len([line for line in told if line.startswith("done edge embree uniform:n=4 16x12 seed ")]) == 3
    assert all(" s, process " in line for line in told if line.startswith("done "))
    assert json.loads(result.stdout)["failed"] == 0
    events = [line["event"] for line in lines_of(out)]
    assert (events[0], events[1], events[-1]) == ("run", "plan", "end")
    jobs = [line for line in named(lines_of(out), "job") if "key" in line]
    assert sorted(line["seed"] for line in jobs) == [0, 1, 2]


def test_without_them_and_with_quiet_nothing_is_said(folder: Path) -> None:
    out = folder / "compare"
    assert run("compare", *SMALL, "-o", out).stderr == ""
    assert run("compare", *SMALL, "-o", out, "-q", terminal=True).stderr == ""
    assert run("--quiet", "compare", *SMALL, "-o", out, terminal=True).stderr == ""


def test_quiet_says_errors(tmp_path: Path) -> None:
    assert run("-q", "compare", "no-such-scene", code=2).stderr.startswith('aliascope: unknown scene "no-such-scene"')
    assert "give one of them" in run("list", "scenes", "-q", "-v", code=2).stderr


def test_notes_of_a_scene_are_warnings(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    file = scene_io.load("edge")
    monkeypatch.setattr(scene_io, "load_file", lambda path: replace(file, path=path, notes=("no texture is drawn",)))
    for quiet, told in ((False, "my/a.glb: no texture is drawn\n"), (True, "")):
        logs.tell(quiet=quiet)
        say_notes(["edge", "my/a.glb", "my/b.toml"])
        assert capsys.readouterr().err == told


def test_help_says_both() -> None:
    told = " ".join(run("--help").stdout.split())
    assert "-v, --verbose" in told
    assert "-q, --quiet" in told
    assert "before or after the command" in told


def test_an_interrupted_run_says_how_it_ended(tmp_path: Path) -> None:
    words = ["compare", "edge", "-r", "embree", "-m", "uniform:n=16777216", "-o", str(tmp_path), "-v"]
    with subprocess.Popen(
        [*COMMAND, *words],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a test run in the background ignores it
    ) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if line.endswith(b" pictures\n"):
                break
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=300)
    last = lines_of(tmp_path)[-1]
    assert (last["event"], last["status"]) == ("end", process.returncode)
    assert process.returncode not in (0, -signal.SIGINT)
