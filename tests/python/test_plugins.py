"""A sampler of the user's, the user's way: install, copy the example, compile, load."""

from __future__ import annotations

import hashlib
import json
import math
import os
import shlex
import sqlite3
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import run, separately
from page_data import shown

from aliascope.image import read_header, read_image

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "csrc" / "plugins" / "kronecker.c"


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The prefix of `make install`."""
    prefix = tmp_path_factory.mktemp("prefix")
    subprocess.run(["make", "-C", ROOT, "--silent", "install", f"prefix={prefix}"], check=True, capture_output=True)
    return prefix


def compiled(folder: Path, prefix: Path, name: str, *changes: tuple[str, str]) -> Path:
    """The example, changed, as a plugin of this name."""
    text = EXAMPLE.read_text()
    for old, new in (('.name = "kronecker"', f'.name = "{name}"'), *changes):
        assert old in text
        text = text.replace(old, new)
    source = folder / f"{name}.c"
    source.write_text(text)
    environment = {**os.environ, "PKG_CONFIG_PATH": str(prefix / "lib" / "pkgconfig")}
    flags = subprocess.run(
        ["pkg-config", "--cflags", "aliascope"], capture_output=True, text=True, check=True, env=environment
    ).stdout.split()
    out = folder / f"{name}.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O2", source, "-o", out, *flags, "-lm"], check=True)
    return out


def test_a_plugin_is_in_every_list_table_and_plot(tmp_path: Path, installed: Path) -> None:
    plugin = compiled(tmp_path, installed, "mine")
    points = np.loadtxt(
        separately("points", "mine:shift=0.25", "-n", "50", "--plugin", plugin).stdout.splitlines(), delimiter=","
    )
    expected = (0.25 + np.arange(50)[:, np.newaxis] * np.sqrt([2.0, 3.0])) % 1.0
    assert np.abs(points - expected).max() < 1e-13  # 50 sqrt(3) < 87, half an ulp of which is 7e-15
    listed = json.loads(separately("--plugin", plugin, "list", "samplers", "--json").stdout)["samplers"]
    assert "mine" in {entry["name"] for entry in listed}

    out = tmp_path / "out"
    chosen = ("-m", "*sampler=mine*", "-m", "uniform:n=4,sampler=mine,sampler.shift=0.125")
    small = ("--size", "64x48")
    mine = ("-r", "embree", "-r", "osmesa", *chosen, *small)
    document = json.loads(separately("compare", "edge", *mine, "-o", out, f"--plugin={plugin}", "--json").stdout)
    modes = {row["mode"]: row["metrics"]["rmse"] for row in document["rows"]}
    assert set(modes) == {
        "uniform:sampler=mine",
        *(f"uniform:n={n},sampler=mine" for n in (1, 4, 64, 256)),
        "uniform:n=4,sampler=mine,sampler.shift=0.125",
        "accumulate:sampler=mine",
        *(f"accumulate:n={n},sampler=mine" for n in (4, 64)),
    }
    assert modes["uniform:n=256,sampler=mine"] < modes["uniform:n=4,sampler=mine"] / 4
    assert "sampler=mine" in json.dumps(shown((out / "report.html").read_text()))
    assert "sampler=mine" in (out / "results.csv").read_text()

    # Its provenance says which plugin, and the command that repeats a picture loads it.
    digest = hashlib.sha256(plugin.read_bytes()).hexdigest()
    with sqlite3.connect(out / "results.sqlite") as database:
        images = [path for (path,) in database.execute("SELECT image FROM job")]
        ((command, versions),) = database.execute("SELECT command, versions FROM run")
    assert (
        json.loads(versions)["plugin mine"] == f"{plugin} sha256 {digest} (behind a fence: its times have that in them)"
    )
    assert str(plugin) in command
    assert digest in (out / "report.html").read_text()
    for path in images:
        header = read_header(out / path)
        assert digest in header["versions"]
        words = shlex.split(header["command"])
        assert words[words.index("--plugin") + 1] == str(plugin)
    again = tmp_path / "again.exr"
    assert (words[0], words[words.index("-o") + 1]) == ("aliascope", "out.exr")
    separately(*words[1:], "-o", again)
    assert np.array_equal(read_image(again), read_image(out / path))

    # What names no sampler of the plugin is what it is without: its pictures are those that are there already.
    plain = (
        "compare",
        "edge",
        "-m",
        "uniform:n=4",
        "-m",
        "none",
        "-m",
        "accumulate:n=4",
        "--size",
        "64x48",
        "-o",
        out,
        "--json",
    )
    first = json.loads(run(*plain).stdout)
    second = json.loads(separately(*plain, "--plugin", plugin).stdout)
    assert first["reused"] == 0
    assert (second["rendered"], second["reused"]) == (0, first["rendered"])
    with sqlite3.connect(out / "results.sqlite") as database:
        plain_images = {path for (path,) in database.execute("SELECT image FROM job")} - set(images)
    assert not [path for path in plain_images if "plugin" in "".join(read_header(out / path).values())]

    # Another build of the same name is another sampler: its pictures are made again.
    (tmp_path / "again").mkdir()
    changed = compiled(tmp_path / "again", installed, "mine", ("{2, 3, 5,", "{3, 2, 5,"))
    again = json.loads(separately("compare", "edge", *mine, "-o", out, "--plugin", changed, "--json").stdout)
    assert (again["rendered"], again["reused"]) == (3 * len(modes), 0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((), "a sampler named"),
        (("abi_version == ASC_ABI_VERSION", "abi_version == 99"), "build it against this version's headers"),
        (("sizeof(asc_sampler_interface)", "8"), "too short or has gaps"),
        ((".fill = fill,", ""), "too short or has gaps"),
        (("ASC_PLUGIN_EXPORT const void *asc_plugin_interface", "const void *other"), "exports no"),
        (('"shift", ASC_REAL, NULL', '"shift", ASC_CHOICE, NULL'), "lacks its name, text or choices"),
    ],
)
def test_what_is_no_plugin_is_said(tmp_path: Path, installed: Path, change: tuple[str, str], words: str) -> None:
    name = "halton" if not change else "mine"
    changes = [change] if change else []
    if words == "exports no":
        changes.append(
            (
                "const void *asc_plugin_interface(uint32_t abi_version, const char *id) {",
                "const void *other(uint32_t abi_version, const char *id) {",
            )
        )
    plugin = compiled(tmp_path, installed, name, *changes)
    lines = run("list", "samplers", "--plugin", plugin, code=2).stderr.splitlines()
    assert len(lines) == 1
    assert words in lines[0]
    assert plugin.name in lines[0]


def test_missing_plugins_and_files_that_are_no_libraries(tmp_path: Path) -> None:
    (tmp_path / "text.so").write_text("no library")
    for path in (tmp_path / "absent.so", tmp_path / "text.so"):
        assert "cannot be loaded" in run("list", "samplers", "--plugin", path, code=2).stderr
    run("list", "samplers", "--plugin", code=2)


BAD = {"0": "1.0", "0.25": "-0.001", "0.5": "(0.0 / 0.0)", "0.75": "(1.0 / 0.0)"}
"""What is no value of a sampler, by the shift for which the plugin gives it."""


def test_values_outside_the_unit_interval_are_an_error(tmp_path: Path, installed: Path) -> None:
    choice = "".join(f"state->shift == {shift} ? {value} : " for shift, value in BAD.items()) + "0.5"
    plugin = compiled(tmp_path, installed, "wild", ("value >= 1.0 ? value - 1.0 : value", choice))
    for shift in BAD:
        points = separately("points", f"wild:shift={shift}", "-n", "4", "--plugin", plugin, code=4)
        assert "outside [0, 1)" in points.stderr
        assert "as number 0 of sample 0 of pixel (0, 0)" in points.stderr
    modes = [f"uniform:sampler=wild,sampler.shift={shift}" for shift in BAD] + ["uniform:n=1,sampler=regular"]
    words = [word for mode in modes for word in ("-m", mode)]
    out = separately("compare", "edge", *words, "-o", tmp_path / "out", "--plugin", plugin, "--json", code=4).stdout
    document: dict[str, Any] = json.loads(out)
    # Neither the plugin nor the regular grid has seeds: three draws each.
    assert (document["pictures"], document["failed"]) == (3, 3 * len(BAD))
    messages = [failure["message"] for failure in document["failures"]]
    assert all("the sampler wild" in each and "as number 0 of sample 0 of pixel (0, 0)" in each for each in messages)
    given = {float(each.split("outside [0, 1): ")[1].split()[0]) for each in messages}
    assert sum(map(math.isnan, given)) >= 1
    assert {-0.001, 1.0, math.inf} <= given
    command = document["failures"][0]["command"]
    assert command.endswith(f" --time-limit 120 --plugin {plugin}")
    assert "outside [0, 1)" in separately(*shlex.split(command)[1:], "-o", tmp_path / "o.exr", code=4).stderr


def test_weights_that_are_no_numbers_are_an_error(tmp_path: Path, installed: Path) -> None:
    weights = """static asc_status weights(const void *state, uint64_t first, size_t count, double *weights) {
  (void)state;
  for (size_t i = 0; i < count; i++) weights[i] = first + i == 5 ? 0.0 / 0.0 : 1.0 / 16.0;
  return ASC_OK;
}

static const asc_parameter"""
    changes = (
        ("static const asc_parameter", weights),
        (".fill = fill,", ".fill = fill, .weights = weights,"),
        ("ASC_TRAIT_SEQUENCE,", "ASC_TRAIT_WEIGHTED,"),
    )
    plugin = compiled(tmp_path, installed, "weighed", *changes)
    options = ("-m", "uniform:n=16,sampler=weighed", "-o", tmp_path / "o.exr", "--plugin", plugin)
    failed = separately("render", "edge", "-r", "embree", *options, code=4)
    assert "the sampler weighed gives sample 5 the weight" in failed.stderr
    assert not (tmp_path / "o.exr").exists()
