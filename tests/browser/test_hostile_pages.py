"""The pages of `sweep`, `knobs` and `regress` as these commands write them, of a scene, a folder and a renderer of
somebody else whose names are scripts."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from commands import run
from inline_workers import Inline
from playwright.sync_api import Page

from aliascope import image, plan
from aliascope.studies import knob_measures, regress_render, sweep, sweep_pov, sweep_scene, sweep_search
from browser.hostile_names import FILE_NAME, NAMES, check, scene_file

POV_NAME = "<iframe><script>hit(11)<b>`$(id)${hit(12)}{{7*7}}&lt"
"""POV-Ray takes no =, ;, ' and \" in the name of its scene, HTML the entity and the elements without them."""
POV = """#version 3.7; global_settings { assumed_gamma 1 }
camera { orthographic location <1, 1, -10> direction <0, 0, 1> right 2*x up 2*y }
plane { z, 1 pigment { checker rgb 0.9 rgb 0.1 scale 0.237 rotate 17*z } finish { ambient 1 diffuse 0 } }
"""
FAILS = "</script><img src=x onerror=hit(13)>"
LAST_WORDS = '"></code></script><script>hit(14)</script><img src=x onerror=hit(15)>${hit(16)}'
VERSION = '"></dd><script>hit(17)</script><img src=x onerror=hit(18)>&amp;'
MODES = (FILE_NAME, f"{FILE_NAME}:setting={FILE_NAME}", f"{FILE_NAME}:setting={FAILS}")
PROGRAM = """case "$3" in
  "</script>"*) cat "$1/last-words.txt" >&2; exit 3;;
  *) cp "$1/kept.exr" "$2";;
esac
"""


def renderer_file(folder: Path) -> Path:
    """A renderer whose modes, settings and version are scripts, and so is what it says when it fails."""
    (folder / "run.sh").write_text(PROGRAM)
    (folder / "last-words.txt").write_text(LAST_WORDS)
    (folder / "version.txt").write_text(VERSION)
    image.write_exr(folder / "kept.exr", np.full((16, 16, 3), 0.25, np.float32), {})
    words = ["sh", "{folder}/run.sh", "{folder}", "{out}", "{mode.setting}", "{scene.toml}", "{seed}"]
    path = folder / "fake.toml"
    path.write_text(
        f"""name = "fake"
title = {json.dumps(NAMES[2])}
command = {json.dumps(words)}
output = {{ format = "exr", values = "linear" }}
time = "cpu"
seeded = true
version = {{ command = ["cat", "{{folder}}/version.txt"], pattern = "(.*)" }}
[modes.{json.dumps(FILE_NAME)}.keys.setting]
type = "choice"
default = "plain"
choices = {json.dumps(["plain", FILE_NAME, FAILS])}
[profiles]
quick = {json.dumps(MODES)}
"""
    )
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One whose name is a script too: it stands in the commands that a page has for a shell."""
    made = tmp_path / '"><img src=x onerror=hit(19)>&gt;'
    made.mkdir()
    return made


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fewest settings and pictures, drawn in this process but for those of knobs, and no figures."""
    for module in (regress_render, sweep):
        monkeypatch.setattr(module, "Workers", Inline)
    monkeypatch.setattr(sweep_search, "MOST_REPEATS", 1)
    monkeypatch.setattr(sweep_pov, "LEAST_TIMED", 0.0)
    monkeypatch.setattr(sweep_pov, "THRESHOLDS", (0.3,))
    monkeypatch.setattr(sweep_pov, "DEPTHS", {"am1": (2,), "am2": (1,)})
    monkeypatch.setattr(sweep_scene, "SAMPLERS", {"regular": (1, 4)})
    monkeypatch.setattr(sweep_scene, "ADAPTIVE_COUNTS", ())
    monkeypatch.setattr(sweep_scene, "FRAMES", (1,))
    monkeypatch.setitem(plan.PROFILES, "knobs", {"embree": ("uniform:n=1", "uniform:n=4"), "fake": MODES})
    monkeypatch.setitem(plan.KINDS, "knobs", {})
    monkeypatch.setattr(knob_measures, "TURNS", ())
    for name in ("plot_svg", "spectrum_svg", "filters_svg"):
        monkeypatch.setattr(f"aliascope.report.{name}", lambda *_: "<svg xmlns='http://www.w3.org/2000/svg'/>")


def missing(shown: str, *names: str) -> list[str]:
    return [name for name in names if name not in shown]


@pytest.mark.parametrize("kind", ["toml", "pov"])
def test_the_page_of_a_sweep(page: Page, folder: Path, kind: str) -> None:
    if kind == "toml":
        scene, names = scene_file(folder), [FILE_NAME, NAMES[1], folder.name]
    else:
        scene, names = folder / f"{POV_NAME}.pov", [POV_NAME]
        scene.write_text(POV)
    run("sweep", scene, "--budget", "9m", "--size", "16x16", "-o", folder / "out")
    assert not missing(check(page, folder / "out" / "report.html"), *names)


def test_the_page_of_knobs(page: Page, folder: Path) -> None:
    words = ("-r", "embree", "-r", renderer_file(folder), "-o", folder / "out")
    run("knobs", scene_file(folder), *words, code=4)
    shown = check(page, folder / "out" / "report.html")
    turned = f"setting {FILE_NAME} against plain"
    assert not missing(shown, *NAMES[:3], turned, MODES[2], LAST_WORDS, VERSION, folder.name)


def test_the_page_of_a_regression_run(page: Page, folder: Path) -> None:
    scene = scene_file(folder)
    run("reference", scene, "-o", folder / "references")
    words = ("--references", folder / "references", "-o", folder / "out")
    run("regress", scene, "-r", renderer_file(folder), *words, code=4)
    shown = check(page, folder / "out" / "report.html")
    assert not missing(shown, *NAMES[:3], *MODES, LAST_WORDS, VERSION, folder.name)
