"""Libraries and readers of others that crash: in a worker the job is lost and no other, elsewhere they are tried in a
process of their own first, and count as not there."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from commands import separately
from crashing import crash_the_first_reader, crashing_calls, crashing_when_loaded
from killed_compares import told

from aliascope import at_start, draws, places, plan
from aliascope.native import alone

SMALL = ("--size", "16x12", "--json")
SEEDS = plan.SEEDS["quick"]
PLACES = min(SEEDS, draws.MOST)


def environment_with(**variables: str) -> Callable[[], object]:
    """For the processes that a compare starts; itself has begun by then."""
    return lambda: os.environ.update(variables)


def test_libraries_that_crash_when_they_are_loaded_are_skipped(tmp_path: Path) -> None:
    folder = tmp_path / "libraries"
    folder.mkdir()
    crashing_when_loaded(folder, "raster", "raise(SIGSEGV);")
    crashing_when_loaded(folder, "tracer", "abort();")
    modes = ("-m", "none", "-m", "uniform:n=1")
    code, text = told(
        tmp_path / "out",
        arguments=("compare", "edge", *modes, *SMALL),
        prepare=environment_with(LD_LIBRARY_PATH=str(folder)),
    )
    document = json.loads(text)
    assert (code, document["pictures"], document["failed"]) == (0, PLACES, 0)
    skipped = document["skipped"]
    assert "OSMesa (Debian: libosmesa6) cannot be loaded (a process that tries it ends by SIGSEGV)" in skipped["osmesa"]
    assert (
        "Embree 3 (Debian: libembree3-3) cannot be loaded (a process that tries it ends by SIGABRT)"
        in (skipped["embree"])
    )


def test_commands_beside_such_a_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever asks in its own process for what there is, or draws there."""
    crashing_when_loaded(tmp_path, "raster", "_exit(7);")
    monkeypatch.setenv("LD_LIBRARY_PATH", str(tmp_path))
    reason = "cannot be loaded (a process that tries it ends with exit code 7)"
    said = json.loads(separately("doctor", "--quick", "--json").stdout)
    entries = {entry["name"]: entry for entry in said["renderers"]}
    assert reason in entries["osmesa"]["reason"]
    assert {name for name, entry in entries.items() if entry["there"] and entry["holds"]} == {"embree", "povray"}
    assert reason in separately("list", "renderers").stdout
    words = ("render", "edge", "-r", "osmesa", "-m", "none", "-o", tmp_path / "out.exr")
    (line,) = separately(*words, code=3).stderr.splitlines()
    assert line.startswith("aliascope: OSMesa (Debian: libosmesa6)")
    assert reason in line


def test_doctor_outlives_a_renderer_that_crashes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LD_PRELOAD", str(crashing_calls(tmp_path)))
    found = json.loads(separately("doctor", "--quick", "--json", code=1).stdout)
    reasons = {entry["name"]: entry.get("reason") for entry in found["renderers"]}
    assert reasons == dict.fromkeys(("embree", "osmesa"), "its process ended by SIGSEGV") | {"povray": None}


def test_a_job_that_crashes_in_a_library_or_a_reader_loses_itself_alone(tmp_path: Path) -> None:
    calls = crashing_calls(tmp_path)

    def prepare() -> None:
        os.environ["LD_PRELOAD"] = str(calls)
        at_start.add("crash", crash_the_first_reader, tmp_path / "reader-crashed")

    modes = ("-m", "none", "-m", "uniform:n=16")
    code, text = told(tmp_path / "out", arguments=("compare", "edge", *modes, *SMALL), prepare=prepare)
    document = json.loads(text)
    assert code == 4
    assert sorted((each["renderer"], each["message"]) for each in document["failures"]) == [
        (name, "its process ended by SIGSEGV") for name in ("embree", "osmesa", "povray")
    ]
    assert {row["renderer"]: row["pictures"] for row in document["rows"]} == {
        "embree": SEEDS - 1,
        "osmesa": PLACES - 1,
        "povray": PLACES - 1,
    }
    assert not [probe for probe in document["probes"] if not probe["holds"]]


def test_a_reference_that_crashes_loses_its_own_pictures_alone(tmp_path: Path) -> None:
    """In `knobs` too, which is content with fewer samples, and then with those of compare."""
    calls, folder = crashing_calls(tmp_path), tmp_path / "out"
    modes = ("-r", "embree", "-m", "uniform", "-m", "uniform:filter=tent")

    def ran() -> tuple[int, dict[str, Any]]:
        prepare = environment_with(LD_PRELOAD=str(calls))
        code, text = told(folder, arguments=("compare", "edge", *modes, *SMALL), prepare=prepare)
        return code, json.loads(text.splitlines()[-1])  # after what is told meanwhile

    code, document = ran()
    found = [(row["scene"], row["mode"], row["pictures"]) for row in document["rows"]]
    assert (code, found) == (4, [("edge", "uniform", SEEDS)])
    assert (document["pictures"], document["rendered"], document["failed"]) == (SEEDS, SEEDS, SEEDS)
    assert {(each["mode"], each["message"]) for each in document["failures"]} == {
        ("uniform:filter=tent", "the reference cannot be made: its process ended by SIGSEGV")
    }
    assert {each["command"] for each in document["failures"]} == {
        "aliascope reference edge --size 16x12 --filter tent -o references"
    }
    code, document = ran()  # the library crashes once
    assert (code, document["rendered"], document["reused"], document["failed"]) == (0, SEEDS, SEEDS, 0)
    (tmp_path / "embree-crashed").rmdir()
    shutil.rmtree(folder / "references")
    code, document = ran()
    assert (code, document["pictures"], document["rendered"], document["failed"]) == (4, SEEDS, 0, SEEDS)
    code, document = ran()  # what there was is there
    assert (code, document["rendered"], document["reused"], document["failed"]) == (0, 0, 2 * SEEDS, 0)


@pytest.mark.parametrize("words", ["compare {} -r embree", f"sweep {places.SCENES}/{{}}.toml", "reference {}"])
def test_a_crash_where_there_is_one_reference_alone_is_one_line(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LD_PRELOAD", str(crashing_calls(tmp_path)))
    command = words.format("spheres").split()
    lines = separately(*command, "--size", "16x16", "-o", tmp_path / "out", code=4).stderr.splitlines()
    assert lines[-1] == "aliascope: the reference cannot be made: its process ended by SIGSEGV"
    assert (tmp_path / "embree-crashed").is_dir()


def test_a_library_that_hangs_is_not_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    crashing_when_loaded(tmp_path, "raster", "for (;;) pause();")
    monkeypatch.setenv("LD_LIBRARY_PATH", str(tmp_path))
    monkeypatch.setattr(alone, "LIMIT", 1.0)
    trial = alone._tried.__wrapped__("_raster")
    assert trial == alone.Trial(absent="a process that tries it has not ended within 1 s")
