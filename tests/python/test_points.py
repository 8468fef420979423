"""The command `aliascope points`: statistics, spectra, files of points, and pictures."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import complaint, run
from matplotlib.figure import Figure
from matplotlib.image import imread

import aliascope
from aliascope.studies import point_pictures as pictures


def document(*arguments: str | Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(run("points", *arguments, "--json").stdout)
    return found


# --- statistics -------------------------------------------------------------------------------------------------------


def test_statistics_are_those_of_the_points() -> None:
    found = document("jittered", "-n", "64", "--seed", "5", "--statistics")
    expected = aliascope.point_statistics(aliascope.points("jittered", 64, seed=5))
    assert (found["sampler"], found["n"], found["d"], found["seed"]) == ("jittered", 64, 2, 5)
    assert found["statistics"] == {
        "minimum-distance": expected.minimum_distance,
        "minimum-distance-share": expected.minimum_distance_share,
        "minimum-distance-plain": expected.minimum_distance_plain,
        "voronoi-area-mean": expected.voronoi_area_mean,
        "voronoi-area-standard-deviation": expected.voronoi_area_standard_deviation,
        "voronoi-area-minimum": expected.voronoi_area_minimum,
        "voronoi-area-maximum": expected.voronoi_area_maximum,
        "t-value": expected.t_value,
    }
    details = found["details"]
    assert (details["dimensions"], details["realisations"], details["reasons"]) == ([0, 1], 1, {})
    assert "standard-errors" not in details


def test_statistics_are_averaged_over_seeds_that_follow() -> None:
    found = document("jittered", "-n", "16", "--seed", str(2**64 - 2), "--statistics", "--realisations", "3")
    seeds = (2**64 - 2, 2**64 - 1, 0)
    each = [aliascope.discrepancy("jittered", "min-distance", n=16, seed=seed).value for seed in seeds]
    assert found["statistics"]["minimum-distance"] == pytest.approx(np.mean(each), rel=1e-12)
    error = found["details"]["standard-errors"]["minimum-distance"]
    assert error == pytest.approx(np.std(each, ddof=1) / np.sqrt(3), rel=1e-9)


def test_statistics_of_some_dimensions_and_another_base() -> None:
    found = document("halton", "-n", "27", "-d", "5", "--statistics", "--dimensions", "1", "--base", "3")
    assert found["statistics"]["t-value"] == 0
    assert found["statistics"]["voronoi-area-mean"] is None
    assert "two dimensions" in found["details"]["reasons"]["voronoi-area-mean"]
    assert (found["d"], found["details"]["dimensions"], found["details"]["base"]) == (5, [1], 3)
    three = document("sobol", "-n", "64", "-d", "5", "--statistics", "--dimensions", "0,1,4")["statistics"]
    assert three["t-value"] == aliascope.point_statistics(aliascope.points("sobol", 64, 5)[:, [0, 1, 4]]).t_value
    assert document("sobol", "-n", "64", "-d", "5", "--statistics")["details"]["dimensions"] == [0, 1]
    assert document("sobol", "-n", "64", "-d", "1", "--statistics")["statistics"]["t-value"] == 0


def test_the_table_of_statistics() -> None:
    lines = run("points", "sobol", "-n", "256", "--statistics").stdout.splitlines()
    assert lines[0] == "sobol: 256 points, dimensions 0, 1; one realisation (not randomised)"
    rows = {line.split()[0]: line for line in lines[1:]}
    assert len(rows) == 8
    assert rows["t-value"].endswith("0  a (0, 8, 2)-net in base 2")
    assert rows["voronoi-area-mean"].split()[1] == "0.00390625"
    assert "of the densest packing's 0.0671606" in rows["minimum-distance-share"]
    lines = run("points", "random", "-n", "5", "--statistics", "--realisations", "2").stdout.splitlines()
    assert lines[0] == "random: 5 points, dimensions 0, 1; mean of 2 realisations"
    assert " +- " in lines[1]
    assert lines[-1].split(maxsplit=2) == ["t-value", "none", "a net in base 2 has a power of 2 points; these are 5"]
    lines = run("points", "random", "-n", "1", "--statistics").stdout.splitlines()
    assert lines[0] == "random: 1 point, dimensions 0, 1; one realisation"
    assert lines[1].endswith("min-distance is of two points or more; this is one")


# --- spectrum ---------------------------------------------------------------------------------------------------------


def test_the_spectrum_as_csv_json_and_files(tmp_path: Path) -> None:
    expected = aliascope.point_spectrum([aliascope.points("jittered", 64, seed=seed) for seed in range(3, 13)])
    command = ("jittered", "-n", "64", "--seed", "3", "--spectrum")
    text = run("points", *command).stdout
    assert text.startswith("frequency,power,anisotropy\n1,")
    table = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1)
    assert np.array_equal(table, np.column_stack([expected.frequencies, expected.radial_power, expected.anisotropy]))
    found = document(*command)
    assert found["details"]["realisations"] == 10
    assert found["spectrum"]["power"] == expected.radial_power.tolist()
    assert expected.standard_error is not None
    assert found["spectrum"]["standard-error"] == expected.standard_error.tolist()
    assert run("points", *command, "-o", tmp_path / "a.csv").stdout == ""
    assert (tmp_path / "a.csv").read_text() == text
    run("points", *command, "-o", tmp_path / "a.npy")
    assert np.array_equal(np.load(tmp_path / "a.npy"), expected.power)


def test_one_realisation_of_what_is_not_randomised() -> None:
    found = document("regular", "-n", "16", "--spectrum", "--cut-off", "8")
    assert found["details"]["realisations"] == 1
    assert found["details"]["text"].endswith("one realisation (not randomised)")
    assert found["spectrum"]["frequency"] == list(range(1, 9))
    assert found["spectrum"]["power"][:3] == [0.0, 0.0, 0.0]
    assert found["spectrum"]["anisotropy"][:3] == [None, None, None]
    assert found["spectrum"]["standard-error"] is None
    lines = run("points", "regular", "-n", "16", "--spectrum").stdout.splitlines()
    assert lines[1] == "1,0,"
    assert "has one realisation, not 2" in complaint(
        "points", "sobol", "-n", "16", "--spectrum", "--realisations", "2", code=2
    )


def test_a_spectrum_of_other_dimensions() -> None:
    found = document("sobol", "-n", "32", "-d", "4", "--spectrum", "--dimensions", "3,1")
    expected = aliascope.point_spectrum(aliascope.points("sobol", 32, 4)[:, [3, 1]])
    assert found["spectrum"]["power"] == expected.radial_power.tolist()


# --- files of points --------------------------------------------------------------------------------------------------


def test_points_of_a_file(tmp_path: Path) -> None:
    points = aliascope.points("halton", 16, 3)
    np.savetxt(tmp_path / "a.csv", points, delimiter=",", fmt="%.17g")
    np.save(tmp_path / "a.npy", points)
    expected = document("halton", "-n", "16", "-d", "3", "--statistics")["statistics"]
    for name in ("a.csv", "a.npy"):
        found = document(tmp_path / name, "--statistics")
        assert found["file"] == str(tmp_path / name)
        assert (found["n"], found["d"], found["statistics"]) == (16, 3, expected)
    part = document(tmp_path / "a.npy", "-n", "4", "--first", "2", "-d", "2")
    assert part["points"] == points[2:6, :2].tolist()
    assert "not randomised" in document(tmp_path / "a.npy", "--spectrum")["details"]["text"]
    bare = run("points", "a.csv", "--dimensions", "2,0", cwd=tmp_path).stdout
    assert np.array_equal(np.loadtxt(io.StringIO(bare), delimiter=","), points[:, [2, 0]])


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a.csv", "0.1,0.2\n0.3\n", "a.csv:2: has 1 column"),
        ("a.npy", "no array", "is no .npy file"),
        ("b.csv", None, "cannot be read"),
    ],
)
def test_files_that_hold_no_points(tmp_path: Path, name: str, content: str | None, says: str) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content.encode("utf-8", "surrogateescape"))
    assert says in complaint("points", tmp_path / name, code=2)


def test_statistics_are_of_a_torus_without_its_far_border(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("0.1,0.2\n0.5,1.0\n")
    assert document(tmp_path / "a.csv")["points"] == [[0.1, 0.2], [0.5, 1.0]]
    for option in ("--statistics", "--spectrum"):
        assert "point 1 is not in [0, 1): 0.5, 1" in complaint("points", tmp_path / "a.csv", option, code=2)


def test_points_that_a_file_does_not_have(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", aliascope.points("halton", 16, 3))
    for options in (("-n", "17"), ("--first", "16"), ("-d", "4"), ("-n", "1", "--first", "16")):
        assert "has 16 points of 3 dimensions" in complaint("points", tmp_path / "a.npy", *options, code=2)
    assert "a file has none" in complaint("points", tmp_path / "a.npy", "--weights", code=2)


# --- options ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--statistics", "--spectrum"), "one at a time"),
        (("--statistics", "-o", "a.csv"), "--json"),
        (("--statistics", "--weights"), "--weights"),
        (("--realisations", "3"), "--realisations needs"),
        (("--statistics", "--cut-off", "3"), "--cut-off needs"),
        (("--spectrum", "--base", "3"), "--base needs"),
        (("--spectrum", "-o", "a.jpg"), ".csv, .npy, .svg or .png"),
        (("--statistics", "--dimensions", "0;1"), "A,B"),
        (("--statistics", "--dimensions", "0,2"), "of 0 to 1"),
        (("--statistics", "--dimensions", "1,1"), "each once"),
        (("--statistics", "--dimensions", "-1,1"), "of 0 to 1"),
        (("--spectrum", "--dimensions", "0"), "two dimensions"),
        (("--statistics", "-n", "101", "--realisations", "10000"), "1000000 or fewer"),
        (("--spectrum", "-n", "1001", "--realisations", "10000"), "10000000 or fewer"),
    ],
)
def test_options_that_make_no_sense(options: tuple[str, ...], says: str, tmp_path: Path) -> None:
    assert says in complaint("points", "random", "-n", "16", *options, code=2, cwd=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_sampler_needs_n() -> None:
    assert "-n is missing" in complaint("points", "random", code=2)
    assert "two points" not in complaint("points", "jittered", "-n", "12", "--statistics", code=2)


def test_json_comes_beside_a_file(tmp_path: Path) -> None:
    assert len(document("random", "-n", "5", "-o", tmp_path / "a.npy")["points"]) == 5
    assert np.load(tmp_path / "a.npy").shape == (5, 2)


def test_a_reader_that_has_enough_of_a_spectrum() -> None:
    command = f"{sys.executable} -m aliascope.cli points random -n 65536 --realisations 1 --spectrum | head -n 1"
    result = subprocess.run(command, shell=True, capture_output=True, text=True, check=True, timeout=120)
    assert (result.stdout, result.stderr) == ("frequency,power,anisotropy\n", "")


# --- pictures ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [("-d", "2"), ("-d", "3"), ("-d", "2", "--weights"), ("--spectrum",)])
def test_pictures_are_the_same_each_time(options: tuple[str, ...], tmp_path: Path) -> None:
    run("points", "jittered", "-n", "16", *options, "-o", tmp_path / "a.svg")
    time.sleep(max(0.0, 1.0 - time.time() % 1.0))  # a date would be another
    run("points", "jittered", "-n", "16", *options, "-o", tmp_path / "b.svg")
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert "<dc:date>" not in (tmp_path / "a.svg").read_text()


def test_a_drawing_has_its_points_where_they_are() -> None:
    values = aliascope.points("jittered", 16, 3)
    figure = pictures.points_figure(values, "jittered", [0, 1, 4], False)
    axes, bar = figure.axes
    dots = axes.collections[0]
    assert np.array_equal(np.asarray(dots.get_offsets()), values[:, :2])
    assert np.array_equal(np.asarray(dots.get_array()), values[:, 2])
    assert dots.get_clim() == (0.0, 1.0)
    assert bar.get_ylabel() == "dimension 4"
    assert len(axes.lines) == 6  # the borders of 4 x 4 strata
    assert len(pictures.points_figure(values[:15], "halton", [0, 1], False).axes) == 1


def test_weights_colour_a_drawing() -> None:
    values = np.column_stack([aliascope.points("random", 5), [0.1, 0.2, 0.3, 0.2, 0.2]])
    figure = pictures.points_figure(values, "random", [0, 1], True)
    assert figure.axes[1].get_ylabel() == "weight"
    assert np.array_equal(np.asarray(figure.axes[0].collections[0].get_array()), values[:, 2])


def test_a_spectrums_drawing_shows_its_figures() -> None:
    found = aliascope.point_spectrum([aliascope.points("jittered", 64, seed=seed) for seed in range(4)])
    figure = pictures.spectrum_figure(found, "jittered", "64 points", [0, 1])
    plane, radial, anisotropy = figure.axes[:3]
    assert np.array_equal(np.asarray(plane.images[0].get_array()), found.power)
    assert plane.images[0].origin == "lower"
    curves = [line for line in radial.lines if len(line.get_xdata()) == 32]
    assert np.array_equal(np.asarray(curves[0].get_ydata()), found.radial_power)
    curves = [line for line in anisotropy.lines if len(line.get_xdata()) == 32]
    assert np.array_equal(np.asarray(curves[0].get_ydata()), found.anisotropy)
    assert anisotropy.lines[0].get_ydata()[0] == pytest.approx(-10 * np.log10(4))


def test_rings_without_neighbours_are_dots() -> None:
    grid = aliascope.points("regular", 64)
    figure = pictures.spectrum_figure(aliascope.point_spectrum(grid), "regular", "", [0, 1])
    dots = next(line for line in figure.axes[2].lines if line.get_marker() == ".")
    assert 8 in dots.get_xdata()
    assert 24 not in dots.get_xdata()


@pytest.mark.parametrize("n", [1, 2, 4, 30000])
def test_drawings_of_few_and_many(n: int, tmp_path: Path) -> None:
    path = tmp_path / "$x_1$.png"
    figure = pictures.points_figure(aliascope.points("random", n), "$x_1$ 点" * 20, [0, 1], False)
    assert figure.axes[0].collections[0].get_rasterized() == (n == 30000)  # 10 megabytes of SVG else
    pictures.save(figure, path)
    assert imread(path).shape == (832, 800, 4)
    figure = pictures.spectrum_figure(aliascope.point_spectrum(aliascope.points("random", n), 16), "", "", [0, 1])
    assert isinstance(figure, Figure)
    pictures.save(figure, path)
    assert imread(path).shape == (1280, 832, 4)


def test_a_drawing_that_cannot_be(tmp_path: Path) -> None:
    assert "two dimensions" in complaint("points", "random", "-n", "4", "-d", "1", "-o", tmp_path / "a.svg", code=2)
    missing = tmp_path / "no" / "a.svg"
    assert "cannot be written" in complaint("points", "random", "-n", "4", "--spectrum", "-o", missing, code=4)
