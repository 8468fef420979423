"""Ctrl-C in a compare, at each of its stages: a report of what is finished, one line, exit code 130, nothing left; and
what else wants its folder meanwhile."""

from __future__ import annotations

import csv
import itertools
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from commands import complaint, in_a_fork
from killed_compares import (
    JOBS,
    PATIENCE,
    finish,
    kept,
    leftovers,
    pictures,
    problems,
    started,
    undisturbed,
    workers_of,
)

from aliascope.folder_lock import locked
from aliascope.interrupts import Interrupts, deferred


def pausing(target: str, number: int, marker: Path) -> Callable[[], object]:
    """What has a function, in its call of this number, make a marker and wait until Ctrl-C; for the process that runs
    a compare."""

    def wait(calls: int) -> None:
        if calls == number:
            marker.write_text("")
            time.sleep(PATIENCE)

    return lambda: _before(target, wait)


def waiting(target: str, marker: Path) -> Callable[[], object]:
    """What has a function wait until a marker that it has made is removed."""

    def wait(calls: int) -> None:
        marker.write_text("")
        while marker.exists():
            time.sleep(0.02)

    return lambda: _before(target, wait)


def _before(target: str, function: Callable[[int], object]) -> None:
    calls = itertools.count(1)
    patched = patch(target)
    real, _ = patched.get_original()

    def both(*arguments: Any, **named: Any) -> Any:
        function(next(calls))
        return real(*arguments, **named)

    patch(target, both).start()


def until(condition: Callable[[], object], process: BaseProcess) -> None:
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert process.is_alive()
        assert time.monotonic() < deadline
        time.sleep(0.01)


def press(process: BaseProcess) -> None:
    """Ctrl-C, as a terminal has it: to all processes of the group."""
    assert process.pid is not None
    os.killpg(process.pid, signal.SIGINT)


def ended(process: BaseProcess) -> int:
    process.join(PATIENCE)
    assert process.exitcode is not None, "no end"
    assert process.pid is not None
    assert leftovers(process.pid) == []
    return process.exitcode


def told(folder: Path) -> list[str]:
    return (folder.parent / f"{folder.name}.out").read_text().splitlines()


STAGES = {
    "references": ("aliascope.references.make", 2, 0),
    "rendering": ("aliascope.pipeline._Run._finish", 3, 2),
    "measuring": ("aliascope.pipeline.measure_pictures", 2, None),
}
"""What is paused, in which of its calls, and how many pictures are finished then: of those that are measured, the ones
of a reference."""


@pytest.mark.parametrize("stage", STAGES)
def test_ctrl_c_leaves_a_report_of_what_is_finished(tmp_path: Path, stage: str) -> None:
    folder, marker = tmp_path / "out", tmp_path / "marker"
    target, number, finished = STAGES[stage]
    with started(folder, prepare=pausing(target, number, marker)) as process:
        until(marker.exists, process)
        if stage == "rendering":
            _refuses_others(folder, process)
        press(process)
        assert ended(process) == 130
    (line,) = told(folder)
    found = re.fullmatch(
        rf"aliascope: interrupted: (\d+) of {JOBS} pictures are finished, and in {folder}/report.html; "
        "the same command goes on from there",
        line,
    )
    assert found, line
    count = int(found[1])
    assert count == finished if finished is not None else 0 < count < JOBS
    report = (folder / "report.html").read_text()
    assert f"Interrupted: {count} of {JOBS} pictures were finished" in report
    with (folder / "results.csv").open(newline="") as file:
        assert sum(int(row["pictures"] or 0) for row in csv.DictReader(file)) == count
    assert sum(len(metrics) > 0 for _, metrics, _ in pictures(folder).values()) == count
    if stage == "measuring":
        assert kept(folder) == JOBS
        assert finish(folder, "--resume")[0] == 0
        assert problems(folder, pictures(folder)) == []
        assert "Interrupted" not in (folder / "report.html").read_text()


def _refuses_others(folder: Path, process: BaseProcess) -> None:
    """Every command that writes such a folder, at once and with a line that names it and who is there."""
    commands = (
        ("compare", "edge", "-m", "uniform:n=1"),
        ("compare", "edge", "-m", "uniform:n=1", "--resume"),
        ("knobs", "edge", "-r", "embree"),
        ("regress", "edge", "-r", "embree"),
        ("sweep", "scenes/edge.toml"),
        ("stability", "geometry:edge", "--quick"),
    )
    for words in commands:
        line = in_a_fork(partial(complaint, *words, "-o", folder, code=4))
        assert f"{folder}: process {process.pid} (" in line
        assert "is writing there: wait for it, or choose another folder with -o" in line


def slow_to_end_workers() -> None:
    """Those that begin have the time to look for what they share with a pool that is stopped."""
    _before("pebble.pool.process.stop_process", lambda _: time.sleep(1.0))


@pytest.mark.parametrize("prepare", [bool, slow_to_end_workers])
def test_ctrl_c_while_the_workers_begin_leaves_no_traceback(tmp_path: Path, prepare: Callable[[], object]) -> None:
    folder = tmp_path / "out"
    with started(folder, prepare=prepare) as process:
        until(lambda: workers_of(process.pid or 0), process)
        press(process)
        assert ended(process) == 130
    (line,) = told(folder)
    assert line.startswith(f"aliascope: interrupted: 0 of {JOBS} pictures")
    assert "Interrupted: 0 of" in (folder / "report.html").read_text()


def pressing_where_it_is_lost(calls: int) -> None:
    """Ctrl-C in a finaliser, which cannot raise anything."""

    class Pressing:
        def __del__(self) -> None:
            os.kill(os.getpid(), signal.SIGINT)
            signal.sigpending()  # handlers run between steps of Python

    if calls == 2:
        Pressing()


def test_ctrl_c_that_a_finaliser_loses_ends_a_compare(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    prepare = partial(_before, "aliascope.pipeline._Run._finish", pressing_where_it_is_lost)
    with started(folder, prepare=prepare) as process:
        assert ended(process) == 130
    (line,) = told(folder)
    assert line.startswith("aliascope: interrupted: ")
    assert 0 < kept(folder) < JOBS


def test_ctrl_c_while_the_report_is_written_and_a_second_one(tmp_path: Path) -> None:
    folder, marker = tmp_path / "out", tmp_path / "marker"
    right, _ = undisturbed(folder)
    (folder / "report.html").unlink()
    (tmp_path / "out.out").unlink()
    prepare = waiting("aliascope.studies.compare.write_report", marker)
    with started(folder, prepare=prepare) as process:
        until(marker.exists, process)
        press(process)
        time.sleep(0.1)
        assert process.is_alive()
        marker.unlink()
        assert ended(process) == 130
    (line,) = told(folder)
    assert f"interrupted: {JOBS} of {JOBS} pictures are finished" in line
    assert problems(folder, right) == []

    (tmp_path / "out.out").unlink()
    with started(folder, prepare=prepare) as process:
        until(marker.exists, process)
        press(process)
        time.sleep(0.1)  # two signals at once are one
        press(process)
        assert ended(process) == 130
    (line,) = told(folder)
    assert line.startswith(
        "aliascope: interrupted twice: ended at once; what was finished is kept, and the same command"
    )
    assert set(problems(folder, right)) <= {"left: results.sqlite-wal", "left: results.sqlite-shm"}


def test_a_run_that_ends_at_once_says_nothing_of_its_semaphores() -> None:
    """Another process removes them, with a warning, when the last that shares its error stream has ended."""
    script = """
import os, time
from aliascope.workers import Workers
Workers(1).begin(time.sleep, [0.0], 60.0).result()
os._exit(0)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=PATIENCE, check=True)
    assert done.stderr == ""


def test_a_lock_ends_with_its_process(tmp_path: Path) -> None:
    """However it ends; what it has written there is not believed."""
    pid = os.fork()
    if pid == 0:  # pragma: no cover - in the other process
        with locked(tmp_path):
            (tmp_path / "held").write_text("")
            time.sleep(PATIENCE)
        os._exit(0)
    deadline = time.monotonic() + PATIENCE
    while not (tmp_path / "held").exists():
        assert time.monotonic() < deadline
        time.sleep(0.01)
    with pytest.raises(Exception, match=f"process {pid} .*is writing there"), locked(tmp_path):
        pass
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    assert (tmp_path / ".lock").read_text().startswith(f"{pid} ")
    with locked(tmp_path):
        assert (tmp_path / ".lock").read_text().startswith(f"{os.getpid()} ")
    assert (tmp_path / ".lock").read_text() == ""


def test_ctrl_c_that_a_finaliser_has_to_lose_is_heard_later_without_a_word(monkeypatch: pytest.MonkeyPatch) -> None:
    lost: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda args: lost.append(args.exc_value))

    class Pressing:
        def __del__(self) -> None:
            os.kill(os.getpid(), signal.SIGINT)
            signal.sigpending()  # handlers run between steps of Python

    class Wrong:
        def __del__(self) -> None:
            raise ValueError("lost")

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with Interrupts() as interrupts:
            one = Pressing()
            del one
            assert (interrupts.pressed, lost) == (1, [])
            with pytest.raises(KeyboardInterrupt):
                interrupts.check()
            two = Wrong()
            del two
        assert [str(each) for each in lost] == ["lost"]
    finally:
        signal.signal(signal.SIGINT, before)


def test_ctrl_c_while_it_is_deferred_is_heard_at_the_end() -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    done = []

    def press_within() -> None:
        with deferred():
            os.kill(os.getpid(), signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
            done.append("to its end")

    try:
        with pytest.raises(KeyboardInterrupt):
            press_within()
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert done == ["to its end"]
