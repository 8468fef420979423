"""A compare that is killed at a moment that is chosen: in the middle of a file, a row, a schema, a report."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import signal
import sqlite3
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn
from unittest.mock import patch

import pytest
from killed_compares import PATIENCE, Pictures, kept, pictures, problems, started, told, unfinished

from aliascope import places, store
from aliascope.pipeline import sha256_of

ARGUMENTS = ("compare", "edge", "-r", "embree", "-m", "adaptive:method=kajiya,n=64", "--size", "16x12", "--json")
PICTURES = 3
"""Each with the counts of its samples: two files."""


def die(*_: object) -> NoReturn:
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError("it lives")


def before(target: str, number: int) -> Callable[[], object]:
    """Has a process die at the call of this number of a function."""

    def prepare() -> None:
        calls = itertools.count(1)
        real, _ = patch(target).get_original()
        patch(target, lambda *words, **named: die() if next(calls) == number else real(*words, **named)).start()

    return prepare


def in_a_row() -> None:
    """When the row of the second picture is there, and the hashes of its files are not."""
    real, calls = store.Store.put, itertools.count(1)

    class Deadly(dict[str, str]):
        items = die  # type: ignore[assignment]

    def put(self: store.Store, outcome: Any, files: Any = None) -> None:
        real(self, outcome, Deadly(files) if next(calls) == 2 else files)

    patch.object(store.Store, "put", put).start()


def in_the_schema() -> None:
    """When there are some of the tables."""
    real = sqlite3.connect

    def connect(*words: Any, **named: Any) -> sqlite3.Connection:
        database = real(*words, **named)
        database.create_function("die", 0, die)
        return database

    patch("sqlite3.connect", connect).start()
    patch.object(
        store, "_SCHEMA", store._SCHEMA.replace("CREATE TABLE metric", "SELECT die(); CREATE TABLE metric")
    ).start()


def in_the_report() -> None:
    """When half of it is written."""
    real = Path.write_text

    def write_text(self: Path, text: str, *words: Any, **named: Any) -> int:
        if "report.html" in self.name:
            real(self, text[: len(text) // 2], *words, **named)
            die()
        return real(self, text, *words, **named)

    patch.object(Path, "write_text", write_text).start()


MOMENTS: dict[str, tuple[Callable[[], object], int]] = {
    "schema": (in_the_schema, 0),
    "counts without their picture": (before("aliascope.image._sync", 4), 1),
    "files without their row": (before("aliascope.store.Store.put", 2), 1),
    "row": (in_a_row, 1),
    "measures": (before("aliascope.store.Store.put_metrics", 2), PICTURES),
    "report": (in_the_report, PICTURES),
}
"""What dies then, and how many pictures are kept."""


@pytest.fixture(scope="module")
def right(tmp_path_factory: pytest.TempPathFactory) -> Pictures:
    folder = tmp_path_factory.mktemp("right") / "out"
    assert told(folder, arguments=ARGUMENTS)[0] == 0
    return pictures(folder)


@pytest.mark.parametrize("moment", MOMENTS)
def test_what_is_killed_there_is_gone_on_from(right: Pictures, tmp_path: Path, moment: str) -> None:
    folder = tmp_path / "out"
    prepare, count = MOMENTS[moment]
    with started(folder, arguments=ARGUMENTS, prepare=prepare) as process:
        process.join(PATIENCE)
        assert process.exitcode == -signal.SIGKILL, (tmp_path / "out.out").read_text()
    assert unfinished(folder) == []
    assert not (folder / "report.html").exists()
    assert kept(folder) == count
    with contextlib.closing(sqlite3.connect(folder / "results.sqlite")) as database:
        hashes = database.execute("SELECT path, sha256 FROM file").fetchall() if count else []
    assert len([path for path, _ in hashes if path.startswith("images/")]) == 2 * count
    assert all(sha256_of(folder / path) == digest for path, digest in hashes)
    code, text = told(folder, "--resume", arguments=ARGUMENTS)
    assert code == 0, text
    document = json.loads(text)
    assert (document["reused"], document["rendered"], document["changed"]) == (count, PICTURES - count, 0)
    assert problems(folder, right) == []


def test_git_is_asked_without_a_lock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A git that is killed while it writes its index leaves a lock, and the repository is closed to its owner: it is
    not to write it."""

    def git(*words: str) -> None:
        own = ("-c", "user.name=a", "-c", "user.email=a@b")
        subprocess.run(["git", *own, *words], cwd=tmp_path, check=True, capture_output=True)

    git("init")
    (tmp_path / "file").write_text("text")
    git("add", "file")
    git("commit", "-m", "one")
    os.utime(tmp_path / "file", (1, 1))  # status would note that it is as it was
    before = (tmp_path / ".git" / "index").read_bytes()
    monkeypatch.setattr(places, "_ROOT", tmp_path.resolve())
    assert len(places.revision.__wrapped__()) == 12
    assert (tmp_path / ".git" / "index").read_bytes() == before
