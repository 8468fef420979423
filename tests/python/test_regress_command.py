"""`aliascope regress` as a user runs it, on a scene of 24 x 18 pixels with references of its own: each exit code, each
kind of failure seen to fail, and the commands that it tells.

Cells are rendered in this process, so that a renderer can be made wrong; worker processes draw the same (below).
"""

from __future__ import annotations

import dataclasses
import json
import re
import shlex
import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from commands import complaint, environment, run
from inline_workers import Inline

from aliascope import history, places, renderers
from aliascope.errors import JobFailed
from aliascope.records import Pixels, Rendering
from aliascope.regression import defects
from aliascope.renderers.base import Request
from aliascope.studies import regress_page, regress_render

SEEDED = "uniform:n=64,sampler=sobol,sampler.scramble=owen"
"""Judged by the reference."""
FIXED = "uniform:n=16,sampler=regular"
"""Judged by what was blessed."""
EMBREE = ("-r", "embree", "-m", SEEDED, "-m", FIXED)


def tiny(folder: Path, **change: str) -> None:
    """The scene `edge`, smaller."""
    text = (places.SCENES / "edge.toml").read_text().replace("size = [128, 96]", "size = [24, 18]")
    for old, new in change.items():
        assert old.replace("_", ".") in text
        text = text.replace(old.replace("_", "."), new)
    (folder / "tiny.toml").write_text(text)


@pytest.fixture(scope="module")
def blessed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the scene, its reference and blessed figures."""
    folder = tmp_path_factory.mktemp("blessed")
    tiny(folder)
    run("reference", "./tiny.toml", "-o", "refs", cwd=folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(regress_render, "Workers", Inline)
        said = run(*WORDS, "--bless", "*", "--reason", "first figures", cwd=folder).stdout
    assert "blessed 2 cells" in said
    return folder


WORDS = ("regress", "./tiny.toml", "--references", "refs", *EMBREE)


@pytest.fixture
def folder(blessed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(regress_render, "Workers", Inline)
    monkeypatch.setattr(regress_page, "write", lambda folder, *of: folder / "report.html")  # its plots take a second
    shutil.copytree(blessed, tmp_path, dirs_exist_ok=True)
    return tmp_path


def regressed(folder: Path, *more: str | Path, code: int = 0) -> str:
    return run(*WORDS, *more, code=code, cwd=folder).stdout


def make_wrong(monkeypatch: pytest.MonkeyPatch, change: Callable[[Pixels, Request], Pixels]) -> None:
    """Embree's pictures from here on."""
    kind = type(renderers.find("embree"))
    right = kind.render

    def render(self: Any, request: Request) -> Rendering:
        made = right(self, request)
        return dataclasses.replace(made, pixels=change(made.pixels, request))

    monkeypatch.setattr(kind, "render", render)


def brighter(pixels: Pixels, request: Request) -> Pixels:
    return pixels * np.float32(1.01)


def cell_of(said: str, mode: str) -> list[str]:
    """The lines of a cell."""
    blocks = [block.splitlines() for block in said.split("\n\n")]
    (found,) = [block for block in blocks if re.match(rf"\w+ +tiny/embree/{re.escape(mode)}$", block[0])]
    return found


def told(lines: Sequence[str], word: str) -> list[str]:
    """The words of a command that stands behind a word, without the program."""
    (command,) = [line.partition(f"{word}: ")[2] for line in lines if f"{word}: aliascope " in line]
    return shlex.split(command)[1:]


WRITE = regress_page.write
SHOWN = ("uniform:n=64", "uniform:sampler=regular")
"""The modes in canonical form, defaults left out."""


# --- passing ----------------------------------------------------------------------------------------------------------


def test_what_did_not_change_passes(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regress_page, "write", WRITE)
    said = regressed(folder, "-o", "out", "--junit", "j.xml", "--markdown", "m.md")
    for mode in SHOWN:
        lines = cell_of(said, mode)
        assert lines[0].startswith("passed ")
        assert len(lines) >= 10
        assert all(line.startswith("  ok ") for line in lines[1:])
    assert said.count("caught by") == 3
    assert "PASSED: 0 of 2 cells failed, 3 of 3 controls caught" in said
    assert said.splitlines()[-1] == "out/report.html"
    assert "<html" in (folder / "out" / "report.html").read_text()
    assert not json.loads((folder / "out" / "results.json").read_text())["skipped"]
    assert len(ElementTree.parse(folder / "j.xml").getroot().findall("testsuite/testcase")) == 5
    assert (folder / "m.md").read_text() == (folder / "out" / "summary.md").read_text()


def test_each_run_is_added_to_the_history_of_its_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    regressed(folder, "-o", "out")
    make_wrong(monkeypatch, brighter)
    regressed(folder, "-o", "out", code=1)
    runs = history.load(folder / "out" / "history.sqlite")
    assert [run.passed for run in runs] == [True, False]
    assert [cell.name.mode for cell in runs[1].cells] == list(SHOWN)


def test_quiet_says_controls_and_the_summary(folder: Path) -> None:
    quiet = regressed(folder, "-q").splitlines()
    assert not any(line.startswith(("passed", "  ok")) for line in quiet)
    assert sum(line.startswith("control") for line in quiet) == 3


def test_a_run_changes_nothing_that_was_blessed(folder: Path) -> None:
    def files() -> dict[Path, bytes]:
        return {path: path.read_bytes() for path in (folder / "refs").rglob("*") if path.is_file()}

    before = files()
    regressed(folder)
    assert files() == before


def test_one_document_and_nothing_else(folder: Path) -> None:
    document = json.loads(regressed(folder, "--json", "-o", "out"))
    assert document == json.loads((folder / "out" / "results.json").read_text())
    assert document["passed"]
    assert [cell["mode"] for cell in document["cells"]] == list(SHOWN)


def test_worker_processes_draw_the_same(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def drawn() -> list[str]:
        document = json.loads(regressed(folder, "--json", "-j", "1"))
        return [each["sha256"] for cell in document["cells"] for each in cell["observed"]["replicates"]]

    first = drawn()
    monkeypatch.undo()
    assert drawn() == first


# --- failures ---------------------------------------------------------------------------------------------------------


def test_a_gain_is_found_and_the_commands_that_are_told_work(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The mode that the reference judges cannot be blessed out of it; the other can, and fails when it is mended."""
    make_wrong(monkeypatch, brighter)
    said = regressed(folder, code=1)
    for mode in SHOWN:
        lines = cell_of(said, mode)
        assert lines[0].startswith("FAILED ")
        assert re.search(r"FAIL +gain +\S+ <= \S+ +% +-\d+ %", lines[1])
        assert any(re.search(r"worst pixel \(\d+, \d+\), \w+: [\d.]+, expected [\d.]+", line) for line in lines)
        alone = run(*told(lines, "again"), code=1, cwd=folder).stdout
        assert "1 of 1 cell failed" in alone
        assert cell_of(alone, mode)[1].split()[:2] == ["FAIL", "gain"]
    seeded = run(*told(cell_of(said, SHOWN[0]), "bless"), code=1, cwd=folder).stdout
    assert "STILL FAILS by its reference, which blessing does not change" in seeded
    assert "gain: " in seeded.partition("STILL FAILS")[2]
    fixed = run(*told(cell_of(said, SHOWN[1]), "bless"), cwd=folder).stdout
    assert re.search(r"gain +\S+ -> \S+", fixed)
    old, new = (re.findall(rf"{word} hash (\w+)", fixed)[0] for word in ("old", "new"))
    assert old != new
    assert re.search(r"rmse +[\d.]+ -> [\d.]+ +[+-][\d.]+ %", fixed)
    log = [json.loads(line) for line in (folder / "refs" / "blessings.jsonl").read_text().splitlines()]
    assert [line["cell"] for line in log[-2:]] == [f"tiny/embree/{mode}" for mode in SHOWN]
    assert (log[-1]["old"], log[-1]["new"], log[-1]["reason"]) == (old, new, "why this is right")
    again = regressed(folder, code=1)
    assert cell_of(again, SHOWN[0])[0].startswith("FAILED ")
    assert cell_of(again, SHOWN[1])[0].startswith("passed ")


def test_a_picture_with_holes_fails_and_is_not_blessed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def hole(pixels: Pixels, request: Request) -> Pixels:
        made = pixels.copy()
        made[3, 4] = np.nan
        return made

    make_wrong(monkeypatch, hole)
    monkeypatch.setattr(regress_page, "write", WRITE)
    document = json.loads(
        regressed(folder, "--json", code=1), parse_constant=lambda word: pytest.fail(f"{word} in the document")
    )
    (check,) = [each for each in document["cells"][0]["checks"] if each["about"] == "pixels that are no finite number"]
    assert (check["observed"], check["passed"]) == (16, False)
    before = (folder / "refs" / "tiny" / "blessed-embree.json").read_bytes()
    said = complaint(*WORDS, "--bless", "*", "--reason", "holes", code=1, cwd=folder)
    assert "cannot be blessed: 16 of its pixels" in said
    assert (folder / "refs" / "tiny" / "blessed-embree.json").read_bytes() == before


def test_figures_that_were_edited_are_refused_until_they_are_blessed(folder: Path) -> None:
    path = folder / "refs" / "tiny" / "blessed-embree.json"
    text = path.read_text()
    path.write_text(re.sub(r'("largest":)[\d.]+', r"\g<1>9.5", text, count=1))
    said = regressed(folder, code=1)
    for mode in SHOWN:  # of both cells of the file
        assert "were changed since they were blessed" in "".join(cell_of(said, mode))
    assert "version control, or bless them anew, as below" in " ".join(" ".join(cell_of(said, SHOWN[0])).split())
    (command,) = [line.strip() for line in said.splitlines() if line.strip().startswith("aliascope regress")]
    assert shlex.split(command)[1:] == told(cell_of(said, SHOWN[0]), "bless")  # the other cell's points there
    fixed = run(*shlex.split(command)[1:], cwd=folder).stdout
    assert "what was there cannot be compared" in fixed
    assert "old hash none" in fixed
    regressed(folder)


def test_blessed_figures_of_another_version_of_the_scene_are_refused(folder: Path) -> None:
    tiny(folder, **{"0_9412": "0.9312"})
    run("reference", "./tiny.toml", "-o", "refs", cwd=folder)
    said = regressed(folder, code=1)
    for mode in SHOWN:
        assert cell_of(said, mode)[1].strip() == "was blessed for another version of the scene"
    regressed(folder, "--bless", "*/regular", "--reason", "darker chalk", code=2)
    said = regressed(folder, "--bless", "tiny/embree/*", "--reason", "darker chalk")
    assert "blessed 2 cells" in said
    regressed(folder)


def test_missing_figures_fail_and_are_not_made(folder: Path) -> None:
    path = folder / "refs" / "tiny" / "blessed-embree.json"
    path.unlink()
    said = regressed(folder, code=1)
    lines = cell_of(said, SHOWN[0])
    assert "nothing was blessed of it" in lines[1]
    assert not path.exists()
    run(*told(lines, "bless"), cwd=folder)
    assert cell_of(regressed(folder, code=1), SHOWN[0])[0].startswith("passed ")


def test_a_missing_reference_fails_and_the_command_makes_it(folder: Path) -> None:
    path = folder / "refs" / "tiny" / "24x18-box.exr"
    path.unlink()
    said = regressed(folder, code=1)
    lines = cell_of(said, SHOWN[0])
    assert "no reference for tiny at 24x18" in lines[1]
    assert not path.exists()
    refused = complaint(*WORDS, "--bless", "*", "--reason", "none", code=1, cwd=folder)
    assert "nothing was blessed" in refused
    (command,) = [line.strip() for line in lines if line.strip().startswith("aliascope reference")]
    run(*shlex.split(command)[1:], cwd=folder)
    regressed(folder)


def test_a_control_that_is_not_caught_fails_the_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blind = dataclasses.replace(defects.CONTROLS[0], picture=lambda pixels, draw: pixels, request=None)
    monkeypatch.setattr(defects, "CONTROLS", (blind, *defects.CONTROLS[1:]))
    monkeypatch.setitem(defects.DEFECTS, blind.name, blind)
    said = regressed(folder, code=1)
    assert "NOT CAUGHT" in said
    assert "FAILED: 0 of 2 cells failed, 2 of 3 controls caught" in said


# --- the other exit codes ---------------------------------------------------------------------------------------------


def test_a_job_that_fails_ends_with_four_and_blesses_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def crash(pixels: Pixels, request: Request) -> Pixels:
        if "regular" in request.mode.text:
            raise JobFailed("its process ended by SIGSEGV")
        return pixels

    make_wrong(monkeypatch, crash)
    said = regressed(folder, code=4)
    assert cell_of(said, SHOWN[1])[:2] == [
        f"CRASHED  tiny/embree/{SHOWN[1]}",
        "         its process ended by SIGSEGV",
    ]
    assert cell_of(said, SHOWN[0])[0].startswith("passed ")
    before = (folder / "refs" / "blessings.jsonl").read_bytes()
    said = complaint(*WORDS, "--bless", "*", "--reason", "crash", code=4, cwd=folder)
    assert "nothing was blessed: tiny/embree/uniform:sampler=regular: its process ended by SIGSEGV" in said
    assert (folder / "refs" / "blessings.jsonl").read_bytes() == before


def test_a_renderer_that_is_not_there_is_skipped_unless_it_is_required(folder: Path, tmp_path: Path) -> None:
    alone = environment(tmp_path, alone=True)
    words = ("regress", "./tiny.toml", "--references", "refs", "-m", SEEDED)
    said = run(*words, "-r", "povray", "-r", "embree", env=alone, cwd=folder).stdout
    assert re.search(r"skipped  povray: \S", said)
    assert "1 skipped (povray)" in said
    assert "povray" in complaint(*words, "-r", "embree", "--require", "povray", code=3, env=alone, cwd=folder)
    assert "povray" in complaint("regress", "./tiny.toml", "-r", "povray", code=3, env=alone, cwd=folder)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((*WORDS, "--bless", "tiny/*"), "needs --reason TEXT"),
        ((*WORDS, "--bless", "tiny/*", "--reason", " "), "needs --reason TEXT"),
        ((*WORDS, "--reason", "why"), "name it with --bless PATTERN"),
        ((*WORDS, "--bless", "tiny/embre/*", "--reason", "why"), 'did you mean "tiny/embree/*"'),
        ((*WORDS, "--bless", "*", "--reason", "why", "--junit", "j.xml"), "--junit"),
        (("regress", "edge", "-r", "blender"), "unknown renderer"),
        (("regress", "edge", "--require", "blender"), "unknown renderer"),
        (("regress", "edge", "-m", "uniforn:n=4"), 'did you mean "uniform"'),
        (("regress", "nowhere"), "unknown scene"),
        (("regress", "terrain", "-r", "osmesa"), "nothing to test: terrain/osmesa/"),
    ],
)
def test_what_was_asked_wrongly_ends_with_two(folder: Path, words: Sequence[str], message: str) -> None:
    assert message in complaint(*words, code=2, cwd=folder)


def test_a_folder_that_cannot_be_written_is_said_before_anything_is_rendered(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_wrong(monkeypatch, lambda pixels, request: pytest.fail("rendered"))
    assert "choose another folder with -o" in complaint(*WORDS, "-o", "tiny.toml", code=4, cwd=folder)


def test_an_interrupted_run_is_no_failed_one(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(pixels: Pixels, request: Request) -> Pixels:
        raise KeyboardInterrupt

    make_wrong(monkeypatch, stop)
    assert "interrupted" in complaint(*WORDS, code=130, cwd=folder)


def test_what_a_run_was_given_stands_in_the_commands_that_it_tells(folder: Path) -> None:
    said = regressed(folder, "-m", "uniform:n=4,sampler=random", "--time-limit", "90", code=1)
    for word in ("again", "bless"):
        words = told(cell_of(said, "uniform:n=4,sampler=random"), word)
        assert words[:6] == ["regress", "./tiny.toml", "--references", "refs", "--time-limit", "90"]
        assert words[words.index("-m") + 1] == "uniform:n=4,sampler=random"


def test_make_knows_the_target() -> None:
    said = subprocess.run(
        ["make", "-n", "help"], cwd=places.REFERENCES.parent, capture_output=True, text=True, check=True
    )
    assert said.returncode == 0
    assert re.search(r"^## regress +\S", (places.REFERENCES.parent / "Makefile").read_text(), re.MULTILINE)
