"""A compare whose processes are killed, and gone on from, leaves what one leaves that nobody disturbed."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from killed_compares import (
    VICTIMS,
    Pictures,
    disturbed,
    leftovers,
    moments,
    pictures,
    problems,
    session,
    undisturbed,
)

from aliascope import pipeline, scratch
from aliascope.image import read_image, write_exr


@pytest.fixture(scope="module")
def right(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Pictures, float]:
    folder = tmp_path_factory.mktemp("right") / "out"
    return folder, *undisturbed(folder)


@pytest.mark.parametrize("seed", [1, 2])
def test_what_is_killed_three_times_comes_to_the_same(
    right: tuple[Path, Pictures, float], tmp_path: Path, seed: int
) -> None:
    """Three times, and gone on from each time; `make faults` does it 200 times."""
    _, pictures_of_right, seconds = right
    asked = moments(3, seed, seconds)
    assert {moment.victim for moment in asked} == set(VICTIMS)
    killed, wrong = disturbed(tmp_path / "out", asked, pictures_of_right, seed)
    assert [each.moment for each in killed] == asked
    assert wrong == []


def test_processes_end_with_a_parent_that_is_killed_though_their_tasks_are_long() -> None:
    script = """
import os, time
from aliascope.workers import Workers
pool = Workers(1)
print(pool.begin(os.getpid, [], 600.0).result(), flush=True)
pool.begin(time.sleep, [600.0], 600.0)
time.sleep(600.0)
"""
    parent = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, start_new_session=True)
    assert parent.stdout is not None
    assert int(parent.stdout.readline()) in session(parent.pid)
    parent.kill()
    parent.wait()
    try:
        assert leftovers(parent.pid) == []
    finally:
        parent.stdout.close()
        for left in session(parent.pid):
            os.kill(left, signal.SIGKILL)


def test_a_run_removes_the_scratch_folders_of_one_that_was_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / f"{scratch.PREFIX}povray-abandoned").mkdir()
    (tmp_path / "another").mkdir()
    with scratch.scratch_folder("povray", "a test") as held:
        (tmp_path / f"{scratch.PREFIX}povray-abandoned").mkdir(exist_ok=True)
        pipeline.remove_unfinished(tmp_path / "results")
        assert sorted(tmp_path.iterdir()) == sorted([held, tmp_path / "another"])


def test_moments_are_spread_over_the_whole_run() -> None:
    asked = moments(200, 1, 10.0)
    assert sorted(int(moment.seconds / 0.05) for moment in asked) == list(range(200))
    assert {victim: sum(moment.victim == victim for moment in asked) for victim in VICTIMS} == {
        "harness": 66,
        "worker": 67,
        "povray": 67,
    }
    assert asked == moments(200, 1, 10.0) != moments(200, 2, 10.0)


def test_what_would_be_wrong_is_seen(right: tuple[Path, Pictures, float]) -> None:
    """The check above can fail: each thing that it looks for, put in."""
    folder, as_it_is, _ = right
    assert problems(folder, as_it_is) == []
    (key, (row, _, _)), *_ = as_it_is.items()
    path = folder / str(row["image"])
    values = read_image(path)
    try:
        write_exr(path, values * 2, {})
        assert problems(folder, as_it_is) == [f"{row['mode']}: another picture"]
        path.unlink()
        assert set(problems(folder, as_it_is)) == {f"{row['mode']}: another picture", f"file {row['image']}"}
    finally:
        write_exr(path, values, {})
    (folder / "images" / ".half.1.exr").write_bytes(b"half")
    assert problems(folder, as_it_is) == ["left: images/.half.1.exr", "file images/.half.1.exr"][::-1]
    (folder / "images" / ".half.1.exr").unlink()
    with sqlite3.connect(folder / "results.sqlite") as database:
        database.execute("UPDATE metric SET value = value + 1e-9 WHERE key = ? AND name = 'rmse'", (key,))
    database.close()
    assert problems(folder, as_it_is) == [f"{row['mode']}: another metrics"]
    with sqlite3.connect(folder / "results.sqlite") as database:
        database.execute("DELETE FROM job WHERE key = ?", (key,))
    database.close()
    assert f"job {key} is only in one of the two" in problems(folder, as_it_is)
    assert pictures(folder).keys() != as_it_is.keys()
