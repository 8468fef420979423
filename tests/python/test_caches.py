"""What is kept from run to run: where, how much at most, and that nothing is harmed when it goes."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from commands import complaint, run

from aliascope import caches, scratch
from aliascope.caches import Usage
from aliascope.errors import InvalidInput
from aliascope.folder_lock import locked
from aliascope.records import Cost, Job, Outcome
from aliascope.renderers import povray_file
from aliascope.store import Store
from aliascope.studies import keeping


@pytest.fixture(autouse=True)
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("ALIASCOPE_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(caches, "_used", set())
    return tmp_path / "cache"


def of_another(name: str, size: int, age: float) -> Path:
    """A file that another process wrote and used last so many seconds ago."""
    path = caches.folder("power") / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"x" * size)
    then = path.stat().st_mtime - age
    os.utime(path, (then, then))
    return path


def names() -> set[str]:
    return {path.name for path in caches.folder("power").iterdir()}


def test_where_they_are(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert caches.folder("power") == tmp_path / "cache" / "power"
    monkeypatch.setenv("ALIASCOPE_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert caches.root() == tmp_path / "xdg" / "aliascope"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative/is/ignored")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert caches.root() == tmp_path / "home" / ".cache" / "aliascope"


def test_a_user_without_a_home_keeps_no_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in (caches.VARIABLE, "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pwd.getpwuid", {}.__getitem__)  # which knows nobody
    assert caches.root() == Path(os.devnull) / ".cache" / "aliascope"
    scene = tmp_path / "scene.pov"
    scene.write_text("camera {}\nsphere { 0, 1 }\n")
    assert povray_file.open_file(scene).path == scene
    monkeypatch.setenv("HOME", "relative")
    assert caches.root().is_relative_to(os.devnull)


def test_the_one_that_was_used_longest_ago_goes_first() -> None:
    for name, age in (("old", 300.0), ("older", 400.0), ("new", 100.0), ("oldest-but-read", 500.0)):
        of_another(name, 1000, age)
    assert caches.read(caches.folder("power") / "oldest-but-read") == b"x" * 1000
    assert caches.set_limit(2500) == Usage(2, 2000)
    assert names() == {"new", "oldest-but-read"}
    of_another("in between", 1000, 50.0)
    assert caches.trim() == Usage(1, 1000)
    assert names() == {"in between", "oldest-but-read"}
    assert caches.limit() == 2500


def test_reading_counts_as_use_for_other_processes_too(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, age in (("read", 500.0), ("not", 400.0)):
        of_another(name, 1000, age)
    caches.read(caches.folder("power") / "read")
    monkeypatch.setattr(caches, "_used", set())
    caches.set_limit(1000)
    assert names() == {"read"}


def test_a_write_keeps_to_the_limit_and_a_run_keeps_what_it_uses() -> None:
    caches.set_limit(1000)
    of_another("other", 600, 10.0)
    for name in ("a", "b", "c"):
        caches.write(caches.folder("power") / name, b"y" * 600)
    assert names() == {"a", "b", "c"}  # 1800 bytes: in use until the run ends
    told = subprocess.run(
        [sys.executable, "-c", "from aliascope import caches; print(caches.trim())"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert told == "Usage(files=2, size=1200)\n"
    assert len(names()) == 1


def test_half_files_of_processes_that_are_gone_go() -> None:
    of_another(".a.1.part", 10, 2 * caches.ABANDONED)
    of_another(".b.2.part", 10, 1.0)
    caches.trim()
    assert names() == {".b.2.part"}


def test_a_file_that_is_open_stays_readable_when_it_goes() -> None:
    path = of_another("a", 1 << 20, 10.0)
    with path.open("rb") as file:
        begin = file.read(10)
        assert caches.empty(["power"]) == Usage(1, 1 << 20)
        assert not path.exists()
        assert begin + file.read() == b"x" * (1 << 20)
    assert caches.read(path) is None


WRITER = """
import sys
from aliascope import caches
for number in range(200):
    path = caches.folder("power") / f"{number % 7}"
    caches.write(path, bytes([number % 251]) * 3000)
    found = caches.read(caches.folder("power") / f"{(number * 3) % 7}")
    assert found is None or (len(found) == 3000 and len(set(found)) == 1), found
    if number % 10 == 0:
        caches._used.clear()
    if number % 50 == 0:
        caches.empty(["power"])
"""


def test_processes_side_by_side_see_whole_files_or_none() -> None:
    caches.set_limit(9000)
    both = [subprocess.Popen([sys.executable, "-c", WRITER], stderr=subprocess.PIPE) for _ in range(2)]
    for process in both:
        assert process.communicate(timeout=300)[1] == b""
        assert process.returncode == 0
    caches.trim()
    assert caches.usage("power").size <= 9000
    assert not [name for name in names() if name.endswith(".part")]


def test_threads_that_empty_while_others_write() -> None:
    stop = threading.Event()

    def empties() -> None:
        while not stop.is_set():
            caches.empty(["power"])

    thread = threading.Thread(target=empties)
    thread.start()
    try:
        for number in range(200):
            path = caches.folder("power") / "a"
            try:
                caches.write(path, b"z" * 100)
            except Exception as error:  # noqa: BLE001
                pytest.fail(f"write {number}: {error}")
            assert caches.read(path) in (None, b"z" * 100)
    finally:
        stop.set()
        thread.join()


@pytest.mark.parametrize(
    ("text", "size"), [("0", 0), ("200 B", 200), ("200MB", 200_000_000), ("1.5 GiB", 3 << 29), ("3kB", 3000)]
)
def test_sizes(text: str, size: int) -> None:
    assert caches.bytes_of(text) == size


@pytest.mark.parametrize("text", ["", "-1", "5", "500", "MB", "2 mb", "1e3", "0x10", "5 PB"])
def test_what_is_no_size(text: str) -> None:
    with pytest.raises(InvalidInput, match="is no size: a number with its unit"):
        caches.bytes_of(text)


def test_a_limit_file_that_is_broken_is_as_none(root: Path) -> None:
    root.mkdir()
    (root / "limit").write_bytes(b"\xff")
    assert caches.limit() == caches.LIMIT
    assert caches.told(caches.LIMIT) == "500 MB"


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_command_lists_empties_and_limits(root: Path) -> None:
    of_another("a", 700_000, 20.0)
    of_another("b", 600_000, 10.0)
    told = run("cache").stdout
    assert f"all of aliascope's own in {root}" in told
    assert "power: 2 files, 1.3 MB; what the hidden command power has rendered" in told
    assert "limit: 500 MB for all" in told
    assert "fonts: " in told
    assert "scratch: " in told
    found = json.loads(run("cache", "--limit", "1MB", "--json").stdout)
    assert found["removed"] == {"files": 1, "size": 700_000}
    assert found["limit"] == 1_000_000
    assert [each["name"] for each in found["caches"]] == list(keeping.NAMES)
    assert found["caches"][0]["usage"] == {"files": 1, "size": 600_000}
    assert run("cache", "--empty", "power").stdout.startswith("removed 1 file, 600 kB\n")
    assert caches.usage("power") == Usage(0, 0)
    assert "known: power, fonts, scratch, all" in complaint("cache", "--empty", "x", code=2)
    assert "is no size" in complaint("cache", "--limit", "much", code=2)
    assert "name it" in complaint("cache", "--prune", code=2)


def test_scratch_of_processes_that_are_gone_can_be_emptied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    (tmp_path / f"{scratch.PREFIX}povray-abc").mkdir()
    (tmp_path / f"{scratch.PREFIX}povray-abc" / "scene.pov").write_bytes(b"x" * 50)
    with scratch.scratch_folder("povray", "a test") as mine:
        (tmp_path / f"{scratch.PREFIX}povray-def").mkdir()
        (tmp_path / f"{scratch.PREFIX}povray-def" / "scene.pov").write_bytes(b"x" * 30)
        (mine / "kept").write_bytes(b"x")
        keeping.empty(["scratch"])
        assert (mine / "kept").is_file()
        assert [path.name for path in tmp_path.glob(f"{scratch.PREFIX}*")] == [mine.name]


def test_help_says_where_how_large_and_how_to_empty() -> None:
    told = " ".join(run("cache", "--help").stdout.split())
    assert "$ALIASCOPE_CACHE" in told
    assert "$XDG_CACHE_HOME" in told
    assert "500MB" in told
    assert "longest ago goes first" in told
    assert "--empty" in told
    assert "cache" in run("--help").stdout


# --- folders of results -----------------------------------------------------------------------------------------------


JOB = Job("k1" * 16, "edge", "edge.toml", "embree", "uniform:n=4", 16, 12, 0)
COST = Cost(1, 1.0, {}, 0.1, 0.1)


@pytest.fixture
def results(tmp_path: Path) -> Path:
    """Two runs: the second has made one of the two pictures of the first anew; and a picture that nothing names."""
    folder = tmp_path / "out"
    with Store(folder / "results.sqlite") as store:
        for run_, jobs in enumerate(
            [[JOB, replace(JOB, key="k2" * 16, seed=1)], [replace(JOB, key="k3" * 16)]], start=1
        ):
            store.begin_run(f"{run_}", "compare", "r", {}, {})
            for job in jobs:
                image = f"images/edge/{job.key[:2]}.exr"
                (folder / image).parent.mkdir(parents=True, exist_ok=True)
                (folder / image).write_bytes(b"x" * 1000)
                store.put(Outcome(job, "done", cost=COST, image=image), {image: "0"})
    (folder / "images" / "edge" / "k1.counts.exr").write_bytes(b"x" * 100)
    (folder / "images" / "edge" / "left.exr").write_bytes(b"x" * 10)
    return folder


def test_what_could_go_is_said_before_it_goes(results: Path) -> None:
    told = run("cache", results).stdout.splitlines()
    assert told == [
        f"{results}: 5 files, 3.11 kB of pictures",
        "  could go: 1 file, 10 B that no row of results.sqlite names",
        "  could go: 2 files, 1.1 kB of 1 row that a later run has made anew",
        "  with --prune they go",
    ]
    assert len(list(results.glob("images/**/*.exr"))) == 5
    assert run("cache", results, "--prune").stdout.splitlines()[1:] == [
        "  removed: 1 file, 10 B that no row of results.sqlite names",
        "  removed: 2 files, 1.1 kB of 1 row that a later run has made anew",
    ]
    assert {path.name for path in results.glob("images/**/*.exr")} == {"k2.exr", "k3.exr"}
    with sqlite3.connect(results / "results.sqlite") as database:
        assert {row[0][:2] for row in database.execute("SELECT key FROM job")} == {"k2", "k3"}
        assert {row[0] for row in database.execute("SELECT path FROM file")} == {
            "images/edge/k2.exr",
            "images/edge/k3.exr",
        }
    database.close()
    found = json.loads(run("cache", results, "--prune", "--json").stdout)["results"]
    assert (found["unnamed"]["files"], found["outdated"]["files"], found["rows"]) == (0, 0, 0)
    assert found["pictures"] == {"files": 2, "size": 2000}


def test_modes_and_scenes_that_no_later_run_has_made_stay(tmp_path: Path) -> None:
    """Results of several runs lie in one folder: the second was asked for another mode, the third for another scene,
    the fourth failed."""
    folder = tmp_path / "out"
    jobs = [JOB, replace(JOB, key="k2" * 16, mode="uniform:n=16"), replace(JOB, key="k3" * 16, scene="discs")]
    with Store(folder / "results.sqlite") as store:
        for number, job in enumerate(jobs, start=1):
            store.begin_run(f"{number}", "compare", "r", {}, {})
            image = f"images/{job.scene}/{job.key[:2]}.exr"
            (folder / image).parent.mkdir(parents=True, exist_ok=True)
            (folder / image).write_bytes(b"x")
            store.put(Outcome(job, "done", cost=COST, image=image), {image: "0"})
        store.begin_run("4", "compare", "r", {}, {})
        store.put(Outcome(replace(JOB, key="k4" * 16), "failed", "no more"))
    found = keeping.results(folder, prune=True)
    assert (found.rows, found.outdated.files, found.unnamed.files) == (0, 0, 0)
    assert len(list(folder.glob("images/**/*.exr"))) == 3
    assert "Scenes, modes and seeds that no later run has made stay" in " ".join(run("cache", "--help").stdout.split())


def test_nothing_is_pruned_beside_a_run_or_elsewhere(results: Path, tmp_path: Path) -> None:
    with locked(results):
        assert "is writing there" in complaint("cache", results, "--prune", code=4)
    assert len(list(results.glob("images/**/*.exr"))) == 5
    assert "has no results.sqlite" in complaint("cache", tmp_path, "--prune", code=2)
