"""`aliascope regress` on a renderer of somebody else's, as the workflow that a project can copy runs it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from commands import run
from inline_workers import Inline

from aliascope import at_start, image, places, renderers, scene_io
from aliascope.studies import regress_page, regress_render, regress_suite

ROOT = Path(__file__).resolve().parents[2]
WORKFLOW = ROOT / "tests" / "renderers" / "regress-workflow.yml"

MINE = """name = "mine"
title = "Mine"
command = ["sh", "{folder}/run.sh", "{scene.glb}", "{folder}/{seed}.exr", "{out}"]
output = { format = "exr", values = "linear" }
time = 'in (?P<s>[0-9.]+) s'
seeded = true
[modes.plain]
[profiles]
quick = ["plain"]
"""
SCENE, RENDERER, KEPT = "tiny.toml", "renderer/mine.toml", "antialiasing"


def draw(folder: Path, gain: float = 1.0) -> None:
    """The pictures that the renderer "draws": the reference with noise, by seed."""
    reference = image.read_image(folder / KEPT / "tiny" / "24x18-box.exr")
    for seed in range(16):
        noise = np.random.Generator(np.random.PCG64(seed)).normal(0.0, 0.02, reference.shape)
        pixels = (gain * (reference + noise)).astype(np.float32)
        image.write_exr(folder / "renderer" / f"{seed}.exr", pixels, {})


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One's own: a renderer, a scene, its reference, what was blessed of it."""
    folder = tmp_path_factory.mktemp("project")
    text = (places.SCENES / "edge.toml").read_text().replace("size = [128, 96]", "size = [24, 18]")
    (folder / SCENE).write_text(text)
    (folder / "renderer").mkdir()
    (folder / RENDERER).write_text(MINE)
    (folder / "renderer" / "run.sh").write_text('test -s "$1" && cp "$2" "$3" && echo "in 0.25 s"\n')
    (folder / "renderer" / "Makefile").write_text("all:\n\t@echo built\n")
    run("reference", f"./{SCENE}", "-o", KEPT, cwd=folder)
    draw(folder)
    with pytest.MonkeyPatch.context() as patch:
        _alone(patch)
        words = ["-r", RENDERER, "--references", KEPT, "--bless", "*", "--reason", "as of today"]
        said = run("regress", f"./{SCENE}", *words, cwd=folder).stdout
    assert "blessed  tiny/mine/plain" in said
    assert (folder / KEPT / "tiny" / "blessed-mine.json").is_file()
    return folder


def _alone(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(renderers, "RENDERERS", dict(renderers.BUILT_IN))
    patch.setattr(at_start, "_STEPS", {})
    patch.setattr(regress_render, "Workers", Inline)
    patch.setattr(regress_page, "write", lambda folder, *of: folder / "report.html")  # its plots take a second


def regressed(project: Path, patch: pytest.MonkeyPatch, *more: str, code: int = 0) -> Any:
    _alone(patch)
    return run("regress", f"./{SCENE}", "-r", RENDERER, "--references", KEPT, *more, code=code, cwd=project)


def steps() -> dict[str, str]:
    """What the workflow runs, by name; other steps are actions of the system that runs it."""
    document = yaml.safe_load(WORKFLOW.read_text())
    assert set(document) == {"name", True, "env", "jobs"}  # `on` is a truth value to YAML 1.1
    (job,) = document["jobs"].values()
    assert all(("run" in step) != ("uses" in step) for step in job["steps"])
    return {step["name"]: step["run"] for step in job["steps"] if "run" in step}


def test_the_steps_of_the_workflow(project: Path, tmp_path: Path) -> None:
    """All that installs nothing, as a runner runs them, in worker processes."""
    folder = tmp_path / "checkout"
    shutil.copytree(project, folder)
    program = tmp_path / "bin" / "aliascope"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m aliascope.cli "$@"\n')
    program.chmod(0o755)
    environment = {
        **os.environ,
        **{name: str(value) for name, value in yaml.safe_load(WORKFLOW.read_text())["env"].items()},
        "SCENES": f"./{SCENE}",
        "PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}",
        "GITHUB_STEP_SUMMARY": str(tmp_path / "shown.md"),
    }
    assert environment["RENDERER"] == RENDERER
    assert environment["REFERENCES"] == KEPT
    ran = []
    for name, script in steps().items():
        if not name.startswith("Install"):
            result = subprocess.run(
                ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script],
                cwd=folder,
                env=environment,
                capture_output=True,
                text=True,
                timeout=600,
                check=False,
            )
            assert result.returncode == 0, result.stdout + result.stderr
            ran.append(result.stdout)
    assert "built\n" in ran[0]
    assert "2 of 2 controls caught" in ran[1]
    suites = list(ET.parse(folder / "junit.xml").iter("testsuite"))
    assert suites
    assert {suite.get("failures") for suite in suites} == {"0"}
    assert "mine" in (tmp_path / "shown.md").read_text()
    assert {"report.html", "history.sqlite", "results.json"} <= {path.name for path in (folder / "results").iterdir()}


def test_a_renderer_that_became_brighter_fails_and_the_commands_name_its_file(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "project"
    shutil.copytree(project, folder)
    draw(folder, gain=1.01)
    said = regressed(folder, monkeypatch, "-o", "out", code=1).stdout
    assert "\nFAILED: " in said
    told = [line for line in said.splitlines() if "aliascope regress" in line]
    assert told
    assert all(f"--references {KEPT} -r {RENDERER} -m plain" in line for line in told)


def test_one_that_is_required_and_not_there_ends_with_3(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "project"
    shutil.copytree(project, folder)
    text = MINE.replace('"sh"', '"{folder}/not-built"')
    (folder / RENDERER).write_text(text)
    complaint = regressed(folder, monkeypatch, "--require", RENDERER, "-o", "out", code=3).stderr
    assert "Mine is not installed: there is no" in complaint


def test_one_whose_pictures_are_all_one_has_an_empty_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(renderers, "RENDERERS", dict(renderers.BUILT_IN))
    monkeypatch.setattr(at_start, "_STEPS", {})
    path = tmp_path / "mine.toml"
    path.write_text(MINE.replace("{seed}", "0").replace("seeded = true", "seeded = false"))
    found = renderers.find(str(path))
    cells, empty = regress_suite.cells_of([scene_io.load("edge")], [found.name])
    assert cells == []
    assert [(name.text, reason.partition(":")[0]) for name, reason in empty] == [
        ("edge/mine/plain", "it has no seed, and its film cannot be moved")
    ]
