"""Disks: full, read-only, and with files that are not any more what was written."""

from __future__ import annotations

import contextlib
import itertools
import json
import shutil
import sqlite3
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

from commands import complaint, in_a_fork
from killed_compares import JOBS, PATIENCE, finish, pictures, problems, started, told
from small_disks import fill, limit_files, read_only, tmpfs

from aliascope import image

ARGUMENTS = ("compare", "edge", "-m", "uniform:n=1", "-m", "adaptive:method=kajiya,n=64", "-r", "embree")
PICTURES = 6


def whole(folder: Path) -> int:
    """How many pictures a database that is whole has."""
    with contextlib.closing(sqlite3.connect(folder / "results.sqlite")) as database:
        assert database.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        return int(database.execute("SELECT count(*) FROM job WHERE status = 'done'").fetchone()[0])


def full_at(target: str, number: int, disk: Path) -> Callable[[], object]:
    """What has a disk full before the call of this number of a function, in the process of a compare."""
    calls = itertools.count(1)
    real, _ = patch(target).get_original()

    def both(*arguments: Any, **named: Any) -> Any:
        if next(calls) == number:
            fill(disk, 0)
        return real(*arguments, **named)

    return lambda: patch(target, both).start()


def refused(folder: Path, *more: str, prepare: Callable[[], object] = bool) -> str:
    """The one line that a compare ends with; before it, that there is no log can be said."""
    code, text = told(folder, *more, arguments=ARGUMENTS, prepare=prepare)
    assert code == 4, text
    *notes, line = text.splitlines()
    assert all("goes on without a log" in note for note in notes), text
    assert line.startswith(f"aliascope: {folder}")
    assert "cannot be written" in line
    return line


def test_a_full_disk_ends_a_compare_with_one_line_and_loses_nothing(tmp_path: Path) -> None:
    with tmpfs(tmp_path / "disk", "1m") as mounted:
        if not mounted:  # the other way to the same, which the next test has too
            _short_files(tmp_path, 1 << 17)
            return
        disk = tmp_path / "disk"
        ballast, folder = disk / "ballast", tmp_path / "out"
        (disk / "out").mkdir()
        folder.symlink_to(disk / "out")  # what is said lies beside it, on a disk that has room
        fill(disk, 0)
        refused(folder)
        ballast.unlink()
        refused(folder, prepare=full_at("aliascope.pipeline._Run._finish", 3, disk))
        assert whole(folder) == 2
        ballast.unlink()
        refused(folder, "--resume", prepare=full_at("aliascope.studies.compare.write_report", 1, disk))
        assert whole(folder) == PICTURES
        ballast.unlink()
        larger = shutil.copytree(folder, tmp_path / "larger")
    _, text = told(larger, "--resume", "--json", arguments=ARGUMENTS)
    found = json.loads(text)
    assert (found["rendered"], found["reused"], found["changed"]) == (0, PICTURES, 0)
    assert problems(larger, pictures(larger)) == []


def test_files_that_may_not_grow_end_a_compare_with_one_line(tmp_path: Path) -> None:
    _short_files(tmp_path, 1 << 16)


def _short_files(tmp_path: Path, longest: int) -> None:
    """On a system that allows no mounting: the database is what first grows past this."""
    folder = tmp_path / "short"
    with started(folder, prepare=lambda: limit_files(longest)) as process:
        process.join(PATIENCE)
        assert process.exitcode == 4
    *notes, line = (tmp_path / "short.out").read_text().splitlines()
    assert all("goes on without a log" in note for note in notes)
    assert line.startswith(f"aliascope: {folder}/")
    assert "cannot be written" in line
    assert whole(folder) < JOBS
    assert finish(folder, "--resume")[0] == 0
    assert problems(folder, pictures(folder)) == []


def test_a_folder_that_nobody_can_write_to(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with read_only(tmp_path / "out") as folder:
        for out in (folder, folder / "new"):
            line = in_a_fork(partial(complaint, *ARGUMENTS, "-o", out, code=4))
            assert line.startswith(f"aliascope: {out}")
            assert "choose another folder with -o" in line


def flip(path: Path, beside: bytes) -> None:
    """Changes one bit of a file, some bytes after these: in a header, which leaves a picture that can be read."""
    data = bytearray(path.read_bytes())
    at = data.index(beside) + len(beside) + 16
    data[at] ^= 1
    path.write_bytes(data)
    image.read_image(path)


def test_files_that_have_rotted_are_made_again(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    small = (*ARGUMENTS, "--size", "16x12")
    assert json.loads(told(folder, "--json", arguments=small)[1])["changed"] == 0
    as_it_was = pictures(folder)
    counts, *_ = sorted(folder.rglob("*.counts.exr"))
    uniform, *_ = sorted(folder.rglob("uniform*.exr"))
    (reference,) = sorted((folder / "references").rglob("*.exr"))
    for path, beside in ((counts, b"cpu_seconds"), (uniform, b"cpu_seconds"), (reference, b"aliascope:error")):
        flip(path, beside)
    bytes_of_reference = reference.read_bytes()
    code, text = told(folder, "--resume", arguments=small)
    assert code == 0
    assert f"{PICTURES} pictures, {PICTURES - 2} of them from before, 2 made again, as their files were gone or" in text
    assert f"{reference}: was changed since it was made\n" in text
    logged = [json.loads(line) for line in (folder / "log.jsonl").read_text().splitlines()]
    assert {(each["file"], each["level"]) for each in logged if each["event"] == "changed"} == {
        (path.relative_to(folder).as_posix(), "info") for path in (counts, uniform)
    }
    assert reference.read_bytes() != bytes_of_reference
    assert problems(folder, as_it_was) == []

    # What has no hash, as earlier versions kept none, is read as they did.
    with contextlib.closing(sqlite3.connect(folder / "results.sqlite")) as database, database:
        database.execute("DELETE FROM file")
    flip(uniform, b"cpu_seconds")
    counts.write_bytes(counts.read_bytes()[:-100])
    found = json.loads(told(folder, "--resume", "--json", arguments=small)[1])
    assert (found["changed"], found["reused"]) == (1, PICTURES - 1)
