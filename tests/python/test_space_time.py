"""Patterns of space and time: what is measured of them, against other ways to the same; and the command."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import run
from scipy import stats
from scipy.spatial import cKDTree

from aliascope import scene_io
from aliascope.errors import InvalidInput
from aliascope.native.tracer import Tracer
from aliascope.records import Estimate
from aliascope.report.space_time_charts import RAMP, colour
from aliascope.studies import space_time
from aliascope.studies.space_time import Options, Pattern, Reference, Row
from aliascope.studies.space_time_command import Answer, Asked, verdicts

SCENE = """\
title = "t"
shows = "s"

[view]
size = [16, 12]
background = [0.1, 0.1, 0.1]

[camera]
type = "orthographic"
eye = [0.0, 0.0, 5.0]
look_at = [0.0, 0.0, 0.0]
height = 2.0
shutter = [0.0, 1.0]

[materials.paper]
emission = [0.9, 0.8, 0.6]

[[surfaces]]
type = "polygon"
material = "paper"
points = [[-0.9013, -0.6207, 0.0], [-0.1011, -0.7103, 0.0], [-0.4317, 0.5919, 0.0]]
motion = { type = "translate", by = [0.7313, 0.1519, 0.0] }
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scenes") / "moving.toml"
    path.write_text(SCENE)
    return path


# --- the pattern itself -----------------------------------------------------------------------------------------------


def test_neighbours_are_those_of_a_tree() -> None:
    random = np.random.default_rng(1)
    centre = random.random((20, 3))
    around = random.random((160, 3)) * [3.0, 3.0, 1.0] - [1.0, 1.0, 0.0]
    found = space_time.neighbours(centre, around)
    everything = np.concatenate([centre, around])
    _, index = cKDTree(everything[:, :2]).query(centre[:, :2], 2)
    other = everything[index[:, 1], 2]
    apart = np.minimum((centre[:, 2] - other) % 1.0, (other - centre[:, 2]) % 1.0)
    assert found.near == pytest.approx(4.0 * apart.mean(), rel=1e-12)
    assert found.moran == pytest.approx(12.0 * ((centre[:, 2] - 0.5) * (other - 0.5)).mean(), rel=1e-12)
    distances = np.hypot(*(centre[:, None, :2] - everything[:, :2]).T).T * math.sqrt(20.0)
    times = 4.0 * (0.5 - np.abs(np.abs(centre[:, None, 2] - everything[:, 2]) - 0.5))
    within = (distances >= 0.5) & (distances < 0.75)
    assert found.profile[2] == pytest.approx(times[within].mean(), rel=1e-12)


def test_neighbours_of_a_chequered_grid_are_as_far_apart_as_can_be() -> None:
    x, y = np.meshgrid(np.arange(-4, 8), np.arange(-4, 8))
    grid = np.stack([(x.ravel() + 0.5) / 4.0, (y.ravel() + 0.5) / 4.0, 0.5 * ((x + y).ravel() % 2)], axis=-1)
    inside = ((grid[:, :2] > 0.0) & (grid[:, :2] < 1.0)).all(axis=1)
    found = space_time.neighbours(grid[inside], grid[~inside])
    assert found.near == 2.0
    assert np.isnan(found.profile[0])
    assert found.profile[4] == 2.0  # at distance 1
    assert found.profile[5] == 0.0  # at sqrt 2


def test_independent_times_and_others() -> None:
    """Five standard errors of the mean over 200 realisations; the search of mitchell-spacetime and the decorrelated
    arrangement go beyond by far more."""
    options = Options(realisations=200)
    independent = space_time.measure_pattern(Pattern("random"), 16, options)
    for estimate, expected in ((independent.near, 1.0), (independent.moran, 0.0)):
        assert estimate.value is not None
        assert estimate.standard_error is not None
        assert abs(estimate.value - expected) < 5.0 * estimate.standard_error
    for pattern in (Pattern("mitchell-spacetime"), Pattern("jittered", "decorrelated")):
        near = space_time.measure_pattern(pattern, 16, options).near
        assert near.value is not None
        assert near.value - 5.0 * (near.standard_error or 0.0) > 1.07  # 16/15 within a pixel: no slot comes twice
    same = space_time.measure_pattern(Pattern("hammersley"), 16, options)
    assert same.near.standard_error is None
    assert space_time.interval(same.near, 1) is None


def test_intervals_are_students() -> None:
    values = [0.3, 0.5, 0.1, 0.7, 0.2]
    estimate = Estimate(float(np.mean(values)), float(stats.sem(values)))
    expected = stats.t.interval(0.95, 4, np.mean(values), stats.sem(values))
    assert space_time.interval(estimate, 5) == pytest.approx(expected, rel=1e-9)


# --- what goes with what ----------------------------------------------------------------------------------------------


def test_rank_correlations_are_spearmans() -> None:
    random = np.random.default_rng(2)
    x = random.integers(0, 6, 17).astype(float).tolist()  # with ties
    y = (random.random(17) + 0.2 * np.array(x)).tolist()
    found = space_time.rank_correlation(x, y)
    assert found is not None
    assert found.value == pytest.approx(stats.spearmanr(x, y).statistic, rel=1e-12)
    half = stats.norm.ppf(0.975) * math.sqrt((1.0 + found.value**2 / 2.0) / 14.0)
    assert np.arctanh(found.interval) == pytest.approx([np.arctanh(found.value) - half, np.arctanh(found.value) + half])
    assert space_time.rank_correlation(x[:4], y[:4]) is None
    assert space_time.rank_correlation([1.0] * 6, y[:6]) is None


def _row(sampler: str, arrangement: str, near: float, rmse: float, error: float = 0.001) -> Row:
    pattern, star = Pattern(sampler, arrangement), dict.fromkeys(space_time.PLANES, Estimate(rmse))
    return Row(pattern, 16, Estimate(near, 0.01), Estimate(0.0, 0.1), (), star, Estimate(rmse, error))


def test_the_same_points_are_compared_by_how_they_are_dealt_out() -> None:
    rows = [
        _row("jittered", "padded", 1.0, 0.10),
        _row("jittered", "decorrelated", 1.2, 0.08),
        _row("cook", "joint", 1.0, 0.101),
        _row("pan-diagonal", "joint", 1.1, 0.12),
        _row("random", "joint", 1.0, 0.3),
    ]
    found = {one.pattern.name: one for one in space_time.dealings(rows)}
    assert {name: one.verdict for name, one in found.items()} == {
        "jittered, decorrelated": "less",
        "cook": "alike",
        "pan-diagonal": "more",
    }
    one = found["jittered, decorrelated"]
    assert one.ratio == pytest.approx(0.8)
    half = stats.norm.ppf(0.975) * math.hypot(0.001 / 0.08, 0.001 / 0.10)
    assert one.interval == pytest.approx((0.8 * math.exp(-half), 0.8 * math.exp(half)))


@pytest.mark.parametrize(("slope", "words"), [(-1.0, "have less error"), (1.0, "have more error"), (0.0, "not tell")])
def test_the_verdict_is_whichever_way_it_comes_out(slope: float, words: str) -> None:
    errors = [0.1 + 0.01 * ((7 * i) % 11 if slope == 0.0 else slope * i) for i in range(11)]
    rows = tuple(_row(f"r{i}", "joint", 1.0 + 0.01 * i, error) for i, error in enumerate(errors))
    found = Answer(Asked((16,)), "s", "s", (4, 3), Reference(np.zeros((3, 4, 3)), 0.0), rows)
    assert words in verdicts(found)[0]


# --- the picture ------------------------------------------------------------------------------------------------------


def test_errors_of_pictures(scene: Path) -> None:
    file = scene_io.load(str(scene))
    tracer = Tracer(file.scene, file.scene.view.size)
    own = Reference(tracer.render("hammersley", 16)[0].astype(np.float64), 0.0)
    exactly = space_time.picture_error(tracer, own, Pattern("hammersley"), 16, Options())
    assert (exactly.value, exactly.standard_error) == (0.0, None)
    true = space_time.reference_of(tracer, lambda what, done, total: None)
    assert 0.0 < true.standard_error < 5e-4
    few, many = (space_time.picture_error(tracer, true, Pattern("random"), n, Options(pictures=40)) for n in (4, 64))
    assert few.value is not None
    assert many.value is not None
    # Independent samples: a quarter of the error; each figure to 2 or 3 %.
    assert few.value / many.value == pytest.approx(4.0, rel=0.12)


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_command(scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(space_time, "REPLICATE_SAMPLES", 64)
    common = ("space-time", "--scene", scene, "-n", "16", "--size", "8x6", "--realisations", "4", "--pictures", "3")
    found = json.loads(run(*common, "-o", tmp_path, "--json").stdout)
    assert json.loads((tmp_path / "space-time.json").read_text()) == found
    rows = {(row["sampler"], row["arrangement"]): row for row in found["patterns"]}
    assert len(rows) == len(space_time.PATTERNS)
    cook = rows["cook", "joint"]
    low, high = cook["rmse"]["interval"]
    assert low < cook["rmse"]["value"] < high
    assert set(cook["star"]) == {"xy", "xt", "yt", "xyt"}
    assert "orthogonal-array has s^3 points" in rows["orthogonal-array:strength=3", "joint"]["reason"]
    assert rows["halton", "joint"]["rmse"]["interval"] is None
    assert {one["verdict"] for one in found["dealings"]} <= {"less", "more", "alike"}
    table = list(csv.DictReader((tmp_path / "space-time.csv").read_text().splitlines()))
    assert [float(row["rmse"]) for row in table if row["sampler"] == "cook"] == [cook["rmse"]["value"]]
    page = (tmp_path / "space-time.html").read_text()
    assert "<script" not in page
    assert page.count('class="times"') == 5
    text = run(*common).stdout
    assert "16 samples" in text
    assert "sobol:scramble=owen, decorrelated" in text


def test_what_the_command_refuses(tmp_path: Path) -> None:
    still = tmp_path / "still.toml"
    still.write_text(SCENE.replace("shutter = [0.0, 1.0]\n", ""))
    assert "something must move" in run("space-time", "--scene", still, code=2).stderr
    run("space-time", "--scene", "no-such-scene", code=2)
    with pytest.raises(InvalidInput, match="two"):
        Asked(options=replace(Options(), pictures=1)).check()


def test_times_have_colours() -> None:
    assert colour(0.0) == "#{:02x}{:02x}{:02x}".format(*RAMP[0])
    assert colour(0.5) == "#{:02x}{:02x}{:02x}".format(*RAMP[2])
    assert colour(1.0 - 1e-9) == "#{:02x}{:02x}{:02x}".format(*RAMP[4])
