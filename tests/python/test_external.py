"""Renderers of others: from a TOML file, and from the entry point of a package."""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import run

from aliascope import api, at_start, image, jobs, renderers, scene_io
from aliascope.errors import InvalidInput, JobFailed, NotAvailable, Unsupported
from aliascope.renderers import external, external_file
from aliascope.studies import probes, selection

OURS = Path(__file__).parents[1] / "renderers"

FILE = """name = "fake"
title = "Fake"
command = [{command}]
output = {{ format = "{format}", values = "{values}" }}
time = "{time}"
seeded = false
[modes.plain]
[profiles]
quick = ["plain"]
"""


@pytest.fixture(autouse=True)
def _registry(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a test adds is gone after it."""
    monkeypatch.setattr(renderers, "RENDERERS", dict(renderers.BUILT_IN))
    monkeypatch.setattr(at_start, "_STEPS", {})


def fake(
    folder: Path, script: str, suffix: str = "exr", values: str = "linear", time: str = "cpu", more: str = ""
) -> Path:
    """A renderer that runs a shell script, $1 the scene and $2 the picture."""
    (folder / "run.sh").write_text(script)
    words = ["sh", "{folder}/run.sh", "{scene.glb}", "{out}", "{width}", "{height}"]
    text = FILE.format(command=", ".join(f'"{word}"' for word in words), format=suffix, values=values, time=time)
    path = folder / "fake.toml"
    path.write_text(more + text)
    return path


def picture(folder: Path, pixels: np.ndarray, name: str = "kept.exr") -> Path:
    image.write_exr(folder / name, pixels.astype(np.float32), {}, finite=False)
    return folder / name


def drawn(path: Path, scene: str = "edge", size: tuple[int, int] = (8, 6), **more: Any) -> Any:
    return api.render(scene, str(path), "plain", size=size, **more)


# --- pictures ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.25, -0.4)])
def test_povray_as_any_program_gives_the_picture_of_povray(shift: tuple[float, float]) -> None:
    """The same program on the same scene: the same bits."""
    path = str(OURS / "povray-plain.toml")
    for scene in ("edge", "spheres", "checker-horizon"):
        found = api.render(scene, path, "none", size=(32, 24), shift=shift)
        ours = api.render(scene, "povray", "none", size=(32, 24), shift=shift)
        assert np.array_equal(found.pixels, ours.pixels), scene
        assert found.cost.samples == 32 * 24
        assert found.quantum == ours.quantum
    assert api.render("edge", path, "am2:depth=3", size=(32, 24)).pixels.std() > 0.1


def test_its_probe_finds_the_centre_and_the_gain() -> None:
    probe = probes.measure(renderers.find(str(OURS / "povray-plain.toml")))
    assert probe.gain == pytest.approx(1.0, abs=1e-3)
    assert probe.gamma == pytest.approx(1.0, abs=1e-3)


def test_a_comparison_has_a_row_for_it(tmp_path: Path) -> None:
    """From the command line to the report, in worker processes, which know it too."""
    path = OURS / "povray-plain.toml"
    words = ["-r", path, "-m", "none"]
    out = tmp_path / "out"
    assert json.loads(run("compare", "edge", *words, "--size", "16x12", "-o", out, "--json").stdout)["failed"] == 0
    found = json.loads(run("compare", "edge", "cornell-box", *words, "--dry-run", "--json").stdout)
    assert any(cell["renderer"] == "povray-plain" and "diffuse bounces" in cell["reason"] for cell in found["empty"])
    page = (tmp_path / "out" / "report.html").read_text()
    assert "povray-plain" in page


def test_draws_of_the_film_are_for_those_that_move_it(tmp_path: Path) -> None:
    file = scene_io.load("edge")
    path = fake(tmp_path, "exit 0")
    with pytest.raises(Unsupported, match="cannot be moved"):
        drawn(path, shift=(0.25, 0.0))
    for name, mode, count in ((path, "plain", 1), (OURS / "povray-plain.toml", "none", 3)):
        plan = jobs.make_plan([file], {renderers.find(str(name)).name: [mode]}, 3)
        assert len(plan.jobs) == count


def test_scenes_that_gltf_cannot_say_are_empty_cells(tmp_path: Path) -> None:
    plan = selection.plan_of(["spheres", "edge"], [str(fake(tmp_path, "exit 0"))], [], "quick", None)
    assert {job.scene for job in plan.jobs} == {"edge"}
    assert [cell.reason for cell in plan.empty] == ["glTF has no form for: a point light without fall-off"]


def test_the_toml_of_a_scene_is_the_scene(tmp_path: Path) -> None:
    """Written and read again by a program: the reader of scene files, in a process of its own."""
    path = fake(tmp_path, "")
    path.write_text(path.read_text().replace("{scene.glb}", "{scene.toml}"))
    (tmp_path / "run.sh").write_text(f'cp "$1" {tmp_path}/kept.toml; cp "$(dirname "$1")"/*.obj {tmp_path}/ || true')
    for scene in ("everything", "motion-blur", "glossy"):
        file = scene_io.load(scene)
        with pytest.raises(JobFailed, match="left no picture"):
            drawn(path, scene, size=file.scene.view.size)
        read = scene_io.load(str(tmp_path / "kept.toml")).scene
        pictures = [
            api.render(scene_io.SceneFile("x", path, each), "embree", "uniform:n=1", size=(16, 12)).pixels
            for each in (file.scene, read)
        ]
        assert np.array_equal(*pictures)


@pytest.mark.parametrize(("values", "expected"), [("linear", 0.5), ("srgb", 0.2140411)])
def test_values_are_read_as_the_file_says(tmp_path: Path, values: str, expected: float) -> None:
    kept = picture(tmp_path, np.full((6, 8, 4), 0.5))
    found = drawn(fake(tmp_path, f'cp {kept} "$2"', values=values))
    assert found.pixels.shape == (6, 8, 3)
    assert found.pixels == pytest.approx(expected, rel=1e-6)
    assert found.quantum == 0.0


def test_time_and_samples_are_what_it_prints(tmp_path: Path) -> None:
    kept = picture(tmp_path, np.zeros((6, 8, 3)))
    script = f'cp {kept} "$2"; echo "took 9 ms, then 250 ms; rays 96"'
    path = fake(tmp_path, script, time="(?P<ms>[0-9]+) ms", more='samples = "rays (?P<all>[0-9]+)"\n')
    cost = drawn(path).cost
    assert (cost.cpu_seconds, cost.samples, cost.samples_per_pixel) == (0.25, 96, 2.0)
    assert drawn(path, least_seconds=0.6).cost.repeats == 3


def test_the_whole_process_is_timed_where_it_says_nothing(tmp_path: Path) -> None:
    kept = picture(tmp_path, np.zeros((6, 8, 3)))
    path = fake(
        tmp_path, f'{sys.executable} -c "while __import__(\'time\').process_time() < 0.3: pass"; cp {kept} "$2"'
    )
    cost = drawn(path).cost
    assert 0.3 <= cost.cpu_seconds < 3.0
    assert "start" in renderers.find("fake").versions()["fake time"]


# --- what programs do wrong -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("script", "told"),
    [
        ("exit 3", "exited with status 3"),
        ("echo no such scene >&2; exit 1", "no such scene"),
        ("kill -SEGV $$", "killed by SIGSEGV"),
        ("exit 0", "left no picture"),
        ('echo text > "$2"', "left a broken picture"),
        ('cp {wide} "$2"', "16x6 pixels and 3 channels instead of 8x6"),
        ('cp {grey} "$2"', "8x6 pixels and 1 channels"),
        ('cp {nan} "$2"', "not finite, first at x = 3, y = 2"),
    ],
)
def test_a_program_that_fails_is_a_failed_job(tmp_path: Path, script: str, told: str) -> None:
    broken = np.zeros((6, 8, 3))
    broken[2, 3, 1] = np.nan
    kept = {
        "wide": picture(tmp_path, np.zeros((6, 16, 3)), "wide.exr"),
        "grey": picture(tmp_path, np.zeros((6, 8, 1)), "grey.exr"),
        "nan": picture(tmp_path, broken, "nan.exr"),
    }
    with pytest.raises(JobFailed, match=told):
        drawn(fake(tmp_path, script.format(**kept)))


def test_a_program_that_hangs_is_killed_with_its_children(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    with pytest.raises(JobFailed, match=r"had not ended after 0\.5 s"):
        drawn(fake(tmp_path, f"(sleep 2; touch {mark}) & sleep 60"), time_limit=0.5)
    with pytest.raises(JobFailed, match="had not ended"):
        drawn(fake(tmp_path, "yes 0123456789"), time_limit=0.5)
    assert not mark.exists()


def test_what_it_does_not_print_is_a_failed_job(tmp_path: Path) -> None:
    kept = picture(tmp_path, np.zeros((6, 8, 3)))
    for words in ("nothing", "took - s"):
        with pytest.raises(JobFailed, match="time"):
            drawn(fake(tmp_path, f'cp {kept} "$2"; echo {words}', time="took (?P<s>[0-9-]+) s"))


def test_a_program_that_is_not_there_ends_with_3(tmp_path: Path) -> None:
    path = fake(tmp_path, "")
    path.write_text(path.read_text().replace('"sh"', '"no-such-program"'))
    out = run("render", "edge", "-r", path, "-m", "plain", "-o", tmp_path / "a.exr", code=3)
    assert "there is no no-such-program on the PATH" in out.stderr
    assert len(out.stderr.splitlines()) == 1
    run("compare", "edge", "-r", path, "-o", tmp_path / "out", code=3)


# --- the file ---------------------------------------------------------------------------------------------------------

WHOLE = (OURS / "mitsuba.toml").read_text()


def test_ours_are_read() -> None:
    for path in OURS.glob("*.toml"):
        made = external.load(path)
        assert made.profiles["full"]
        assert made.draws >= {"polygon", "orthographic"}


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('name = "mitsuba"', 'name = "My renderer"', ":2: name: "),
        ("seeded = true", "seeds = true", 'unknown key "seeds"; did you mean "seeded"?'),
        ("seeded = true", "seeded = false", "path is not seeded, and its command has a {seed}"),
        ('"{seed}"', '"0"', "path is seeded, and its command has no {seed}"),
        ("{mode.sampler}", "{mode.sample}", "unknown placeholder {mode.sample}"),
        ("{mode.sampler}", "random", "the key sampler of the mode path changes nothing"),
        ("{samples}", "{sample}", 'did you mean "samples"'),
        ("{out}", "out.exr", "{out} is missing"),
        ("{scene.glb}", "scene.glb", "no scene is in it"),
        ('"{width}"', '"{shift.x}"', "come together"),
        ('format = "exr"', 'format = "gif"', ":8: output.format"),
        ("(?P<s>", "(", "has one group of these"),
        ("(?P<s>", "(?P<s", "is no regular expression"),
        (r"Mitsuba (\S+)", r"Mitsuba \S+", "which is the version"),
        ('default = "independent"', 'default = "random"', "none of its choices"),
        ("default = 16", "default = 0", "outside [1, "),
        ("minimum = 1\n", "", "a minimum of 1 or more"),
        ('probe = "path:', 'probe = "paths:', ':13: probe: unknown mode of mitsuba "paths"'),
        ('"path:n=4"', '"path:m=4"', 'unknown key "m"'),
        ("[profiles]", "[profile]", 'unknown key "profile"; did you mean "profiles"'),
        ("[modes.path]", "[modes.path", "not TOML"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_with_its_line(tmp_path: Path, old: str, new: str, told: str) -> None:
    assert old in WHOLE
    path = tmp_path / "r.toml"
    path.write_text(WHOLE.replace(old, new, 1))
    with pytest.raises(InvalidInput) as caught:
        external_file.read(path)
    assert str(caught.value).startswith(f"{path}:")
    assert told in str(caught.value)


def test_names_are_used_once(tmp_path: Path) -> None:
    first = fake(tmp_path, "")
    renderers.find(str(first))
    assert renderers.find(str(first)) is renderers.find("fake")
    (tmp_path / "sub").mkdir()
    with pytest.raises(InvalidInput, match='named "fake" already'):
        renderers.find(str(fake(tmp_path / "sub", "")))
    first.write_text(first.read_text().replace('"fake"', '"embree"'))
    with pytest.raises(InvalidInput, match='named "embree" already'):
        renderers.find(str(first))
    assert (
        "cannot be read" in run("render", "edge", "-r", tmp_path / "none.toml", "-m", "x", "-o", "a.exr", code=2).stderr
    )


def test_its_key_changes_with_its_files(tmp_path: Path) -> None:
    path = fake(tmp_path, "exit 0")
    first = external.load(path).versions()["fake file"]
    (tmp_path / "run.sh").write_text("exit 1")
    assert external.load(path).versions()["fake file"] != first
    path.write_text(path.read_text() + "# more\n")
    assert external.load(path).versions()["fake file"] != first


# --- entry points -----------------------------------------------------------------------------------------------------

MODULE = """
from aliascope.renderers.embree import Embree
class Mine(Embree):
    name = "mine"
    title = "Mine"
    profiles = {"quick": ("uniform:n=1",)}
    def versions(self):
        return {"mine": "1.2"}
RENDERER = Mine()
class Half:
    name = "half"
    modes = {}
def raises():
    raise RuntimeError("out of order")
"""


@pytest.fixture
def _site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An installed package, with its dist-info, in a folder of its own."""
    (tmp_path / "its_renderers.py").write_text(MODULE)
    info = tmp_path / "its_renderers-1.2.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: its-renderers\nVersion: 1.2\n")
    points = ["mine = its_renderers:RENDERER", "half = its_renderers:Half", "raising = its_renderers:raises"]
    points += ["missing = no_such_module:X", "other = its_renderers:Mine", "embree = its_renderers:RENDERER"]
    (info / "entry_points.txt").write_text("[aliascope.renderers]\n" + "\n".join(points) + "\n")
    monkeypatch.syspath_prepend(tmp_path)
    importlib.invalidate_caches()
    yield
    sys.modules.pop("its_renderers", None)


@pytest.mark.usefixtures("_site")
def test_an_installed_package_adds_its_renderer() -> None:
    assert type(renderers.find("embree")).__name__ == "Embree"  # ours keep their names
    pictures = [api.render("edge", name, "uniform:n=4", size=(16, 12)).pixels for name in ("mine", "embree")]
    assert np.array_equal(*pictures)
    plan = selection.plan_of(["edge"], ["mine"], [], "quick", (16, 12))
    assert {(job.renderer, job.mode) for job in plan.jobs} == {("mine", "uniform:n=1")}
    assert plan.versions["mine"] == "1.2"


@pytest.mark.usefixtures("_site")
@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("half", "is no renderer: it has no title, draws"),
        ("raising", "RuntimeError: out of order"),
        ("missing", "ModuleNotFoundError"),
        ("other", 'calls itself "mine"'),
    ],
)
def test_a_broken_one_is_not_there_and_says_why(tmp_path: Path, name: str, told: str) -> None:
    with pytest.raises(NotAvailable, match=told):
        renderers.find(name)
    assert told in run("compare", "edge", "-r", name, "-o", tmp_path / "out", code=3).stderr
    listed = {entry["name"]: entry for entry in json.loads(run("list", "renderers", "--json").stdout)["renderers"]}
    assert "not there: " in listed[name]["version"]
    assert told in listed[name]["version"]
    assert listed["mine"]["version"] == "mine 1.2"


@pytest.mark.usefixtures("_site")
def test_names_of_both_are_near_misses() -> None:
    with pytest.raises(InvalidInput, match='did you mean "mine"'):
        renderers.find("mien")
