"""The commands: what they print, and their exit codes."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
from pathlib import Path

import fake_povray
import numpy as np
import pytest
from commands import COMMAND, complaint, environment, run, separately

from aliascope import places
from aliascope.cli.about import LISTED
from aliascope.image import read_header, read_image, write_exr
from aliascope.studies.lists import LISTS

# --- points, list, error, render, reference ---------------------------------------------------------------------------


def test_version_and_help() -> None:
    assert separately("--version").stdout == f"aliascope {places.own_version()}\n"
    for command in ("points", "list", "render", "error", "reference", "compare"):
        assert "Example: aliascope " + command in run(command, "--help").stdout


def test_points_are_csv_with_17_digits() -> None:
    lines = run("points", "halton", "-n", "4", "-d", "3").stdout.splitlines()
    assert lines[1] == "0.5,0.33333333333333331,0.20000000000000001"
    assert len(lines) == 4
    assert run("points", "sobol", "-n", "2", "--first", "2", "--weights").stdout == "0.25,0.75,0.5\n0.75,0.25,0.5\n"


def test_points_go_to_files(tmp_path: Path) -> None:
    run("points", "random", "-n", "50", "--seed", "3", "-o", tmp_path / "a.npy")
    run("points", "random", "-n", "50", "--seed", "3", "-o", tmp_path / "a.csv")
    table = np.load(tmp_path / "a.npy")
    assert np.array_equal(table, np.loadtxt(tmp_path / "a.csv", delimiter=","))
    run("points", "random", "-n", "50", "-o", tmp_path / "a.svg")
    run("points", "random", "-n", "50", "-o", tmp_path / "a.png")
    assert "<svg" in (tmp_path / "a.svg").read_text()
    assert read_image(tmp_path / "a.png").shape[2] in (3, 4)
    assert ".csv, .npy, .svg or .png" in complaint("points", "random", "-n", "5", "-o", tmp_path / "a.txt", code=2)
    assert "a.csv" in complaint("points", "random", "-n", "5", "-o", tmp_path / "no" / "a.csv", code=4)


def test_points_errors() -> None:
    assert 'did you mean "sobol"?' in complaint("points", "sobal", "-n", "4", code=2)
    assert "17 is no square" in complaint("points", "jittered", "-n", "17", code=2)
    assert "--pixel" in complaint("points", "random", "-n", "4", "--pixel", "3", code=2)
    run("points", "random", "-n", "0", code=2)
    run("points", "random", code=2)
    run("pionts", code=2)


def test_a_reader_that_goes_away_is_no_error() -> None:
    command = " ".join(COMMAND) + " points random -n 300000 | head -n 1"
    result = subprocess.run(["bash", "-o", "pipefail", "-c", command], capture_output=True, text=True, check=False)
    assert result.stderr == ""
    assert result.stdout.count("\n") == 1
    assert result.returncode == 128 + signal.SIGPIPE


def test_lists_are_the_registries() -> None:
    examples = {
        "scenes": "edge",
        "renderers": "osmesa",
        "modes": "am2",
        "samplers": "sobol",
        "measures": "star",
        "filters": "box",
        "weightings": "area",
        "metrics": "relative-mse",
        "integrands": "edge",
        "estimators": "student-t",
    }
    assert tuple(examples) == tuple(LISTS) == LISTED
    for what, expected in examples.items():
        entries = json.loads(run("list", what, "--json").stdout)[what]
        assert expected in {entry["name"] for entry in entries}
        assert expected in run("list", what).stdout
    assert 'did you mean "modes"?' in complaint("list", "mode", code=2)


def test_render_error_and_reference(tmp_path: Path) -> None:
    out = tmp_path / "edge.exr"
    document = json.loads(run("render", "edge", "-r", "embree", "-m", "uniform:n=16", "-o", out, "--json").stdout)
    assert (document["width"], document["height"], document["samples"]) == (128, 96, 128 * 96 * 16)
    assert document["rays"] == {"primary": 128 * 96 * 16}
    assert document["dimensions"] == 2
    assert not any(document["needs"].values())
    assert document["mode"] == "uniform"
    assert document["cpu_seconds"] > 0
    assert read_header(out)["mode"] == "uniform"
    reference = places.REFERENCES / "edge" / "128x96-box.exr"
    found = json.loads(run("error", out, reference, "--metric", "rmse,max", "--json").stdout)
    assert 0 < found["metrics"]["rmse"] < 0.02
    assert len(found["details"]["max-at"]) == 3
    equal = json.loads(run("error", reference, reference, "--json").stdout)
    assert equal["metrics"]["psnr"] is None
    assert "equal" in equal["details"]["psnr-reason"]

    run("reference", "edge", "-o", tmp_path / "references")
    run("reference", "edge", "--verify", "-o", tmp_path / "references")
    path = tmp_path / "references" / "edge" / "128x96-box.exr"
    pixels, header = read_image(path), read_header(path)
    pixels[40, 20, 1] += 1e-5
    write_exr(path, pixels, header)
    result = run("reference", "edge", "--verify", "-o", tmp_path / "references", code=1)
    assert "DOES NOT HOLD: pixel (20, 40) channel 1" in result.stdout
    assert "make it with" in complaint("reference", "discs", "--verify", "-o", tmp_path / "references", code=1)


def test_error_never_gives_a_number_for_what_is_none(tmp_path: Path) -> None:
    pixels = np.zeros((4, 5, 3), np.float32)
    write_exr(tmp_path / "zero.exr", pixels, {})
    write_exr(tmp_path / "small.exr", pixels[1:], {})
    pixels[2, 3, 1] = np.nan
    write_exr(tmp_path / "nan.exr", pixels, {}, finite=False)
    text = complaint("error", tmp_path / "nan.exr", tmp_path / "zero.exr", code=2)
    assert f"{tmp_path / 'nan.exr'} has 1 NaN and 0 infinite values, the first at x=3, y=2, channel 1" in text
    assert "5 x 3 pixels" in complaint("error", tmp_path / "small.exr", tmp_path / "zero.exr", code=2)
    assert "no such file" in complaint("error", tmp_path / "absent.exr", tmp_path / "zero.exr", code=2)


def test_render_errors(tmp_path: Path) -> None:
    out = tmp_path / "o.exr"
    render = ("render", "edge", "-o", out)
    to = ("render", "edge", "-r", "embree", "-m", "uniform", "-o")
    assert 'as .exr, not ".png"' in complaint(*to, tmp_path / "a.png", code=2)
    assert "no folder" in complaint(*to, tmp_path / "absent" / "a.exr", code=4)
    assert not list(tmp_path.iterdir())
    assert 'did you mean "edge"?' in complaint("render", "egde", "-r", "embree", "-m", "uniform", "-o", out, code=2)
    assert 'did you mean "embree"?' in complaint(*render, "-r", "embre", "-m", "uniform", code=2)
    assert 'did you mean "uniform"?' in complaint(*render, "-r", "embree", "-m", "unifrom", code=2)
    assert 'did you mean "sampler"?' in complaint(*render, "-r", "embree", "-m", "uniform:samler=halton", code=2)
    assert "WxH" in complaint(*render, "-r", "embree", "-m", "uniform", "--size", "12", code=2)
    assert "16384" in complaint(*render, "-r", "embree", "-m", "uniform", "--size", "99999x2", code=2)
    assert "is no square" in complaint(*render, "-r", "embree", "-m", "uniform:n=17,sampler=jittered", code=2)
    assert "4 samples" in complaint(*render, "-r", "osmesa", "-m", "msaa:n=16", code=2)
    (tmp_path / "file").write_text("")
    assert "file" in complaint(
        "render", "edge", "-r", "embree", "-m", "uniform", "-o", tmp_path / "file" / "a.exr", code=4
    )
    nowhere = environment(tmp_path / "empty", alone=True)
    assert "not installed" in complaint(*render, "-r", "povray", "-m", "none", code=3, env=nowhere)


def test_a_scene_that_a_renderer_cannot_draw(tmp_path: Path) -> None:
    scene = tmp_path / "lit.toml"
    text = (places.SCENES / "spheres.toml").read_text()
    scene.write_text(text + "\n[transport]\ndiffuse_bounces = 1\n")
    for name in ("povray", "osmesa"):
        message = complaint("render", scene, "-r", name, "-m", "none", "-o", tmp_path / "o.exr", code=2)
        assert "does not draw: diffuse bounces" in message


# --- doctor -----------------------------------------------------------------------------------------------------------


def test_doctor_measures_what_is_there(tmp_path: Path) -> None:
    document = json.loads(run("doctor", "--quick", "--json").stdout)
    for entry in document["renderers"]:
        assert entry["holds"]
        assert max(map(abs, entry["centre"])) < 0.005
        assert abs(entry["gain"] - 1) < 1e-4
        assert abs(entry["gamma"] - 1) < 1e-4
    assert run("doctor", "--quick").stdout.count("pictures can be compared") == 3
    without = json.loads(run("doctor", "--quick", "--json", env=environment(tmp_path, alone=True)).stdout)
    assert [entry["there"] for entry in without["renderers"]] == [True, False, True]


@pytest.mark.parametrize(
    ("spoil", "option"), [("", "File_Gamma=1.1"), ("sed -i '/^camera/ s/}$/translate 0.03*x }/' scene.pov;", "")]
)
def test_doctor_finds_a_picture_that_is_bent_or_moved(tmp_path: Path, spoil: str, option: str) -> None:
    """POV-Ray through a script that writes its file with a gamma, or moves its camera by 0.03 pixel."""
    real = shutil.which("povray")
    folder = fake_povray.install(tmp_path / "bin", f'[ -f scene.pov ] && {{ {spoil} :; }}; exec {real} "$@" {option}')
    result = run("doctor", "--quick", code=1, env=environment(folder))
    assert result.stdout.count("PICTURES CANNOT BE COMPARED") == 1
    assert result.stdout.count("pictures can be compared") == 2
