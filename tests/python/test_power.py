"""The measurement of both error rates: that repetitions are of runs, that defects are drawn as they say, that what is
missed is said."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import complaint, run
from scipy.stats import binomtest

from aliascope import places, references, renderers, scene_io
from aliascope.model import Scene
from aliascope.records import Pixels
from aliascope.references import files as reference_files
from aliascope.regression.defects import DEFECTS
from aliascope.regression.observe import Target
from aliascope.regression.records import CellName, Check, Draw, Observed
from aliascope.regression.verdict import Chances, count, shared
from aliascope.renderers.base import Request
from aliascope.scene_io import SceneFile
from aliascope.studies import power, power_caught, power_defects, power_null, power_pool, power_text, regress_suite
from aliascope.studies.power_caught import Caught
from aliascope.studies.power_drawn import drawn
from aliascope.studies.power_kept import Kept
from aliascope.studies.power_machines import Elsewhere, compared
from aliascope.studies.power_null import Null, alarms_of, blessed_of, repeated
from aliascope.studies.power_pool import Pool
from aliascope.studies.regress_suite import Cell, judged_by


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ALIASCOPE_CACHE", str(tmp_path / "cache"))


EDGE = 2.37
"""To the right of the middle, at column 10.37 of 16: 0.375 of a pixel is beyond it, and 0.3625 is not, which it becomes
when the samples are spread by 10 %."""


def scene() -> Scene:
    """White to the right of a vertical edge, grey to its left, orthographic; a unit is a pixel."""
    left, right = ((-20.0, EDGE), (EDGE, 20.0))
    return Scene.model_validate(
        {
            "title": "t",
            "shows": "s",
            "view": {"size": (16, 12)},
            "camera": {"type": "orthographic", "eye": (0, 0, 10), "look_at": (0, 0, 0), "height": 12.0},
            "materials": {"white": {"emission": (1.0, 1.0, 1.0)}, "grey": {"emission": (0.25, 0.25, 0.25)}},
            "surfaces": [
                {
                    "type": "polygon",
                    "material": material,
                    "points": [(first, -20.0, 0.0), (last, -20.0, 0.0), (last, 20.0, 0.0), (first, 20.0, 0.0)],
                }
                for material, (first, last) in (("grey", left), ("white", right))
            ],
        }
    )


SCENE = scene()
FILE = SceneFile("t", Path("t.toml"), SCENE)


def cell(renderer: str = "embree", mode: str = "uniform:n=16,sampler=random", count: int = 16) -> Cell:
    found = renderers.find(renderer)
    spec = renderers.mode_of(found, mode)
    draws = tuple(Draw(seed=seed) for seed in range(count))
    return Cell(CellName("t", renderer, spec.text), FILE, spec, judged_by(renderer, spec), draws)


@pytest.fixture(scope="module")
def target() -> Target:
    return Target(references.make(SCENE, SCENE.view.size).exact)


# --- defects that are drawn -------------------------------------------------------------------------------------------


def columns(pixels: Pixels) -> list[float]:
    """The share of white in each column; the rows are alike."""
    assert np.array_equal(pixels, np.broadcast_to(pixels[:1, :, :1], pixels.shape))
    return ((pixels[0, :, 0].astype(np.float64) - 0.25) / 0.75).tolist()


def shares(places: np.ndarray, weights: np.ndarray) -> list[float]:
    """Of white in each column, where samples at these places in the pixel count with these weights."""
    return [float((weights * (column + places > 8 + EDGE)).sum()) for column in range(16)]


@pytest.mark.parametrize(("renderer", "n"), [("osmesa", 256), ("povray", 16)])
def test_samples_are_spread_over_a_wider_pixel(renderer: str, n: int) -> None:
    """256 regular samples reach 31/64 to each side, 0.533 of a pixel when they are spread: into the next pixels."""
    mode = renderers.mode_of(renderers.find(renderer), f"accumulate:n={n},sampler=regular")
    side = int(n**0.5)
    places = (np.arange(side) + 0.5) / side
    for wider in (0.0, 0.1):
        made = drawn(renderer, Request(SCENE, 16, 12, mode), wider)
        expected = shares(0.5 + (1.0 + wider) * (places - 0.5), np.full(side, 1.0 / side))
        assert columns(made.pixels) == pytest.approx(expected, abs=1e-4)  # 16 bits of POV-Ray, each of 16 frames


def test_the_grid_of_povray_is_averaged_over_a_wider_pixel() -> None:
    mode = renderers.mode_of(renderers.find("povray"), "regular:n=16")
    made = drawn("povray", Request(SCENE, 16, 12, mode), 0.1)
    # 4.4 of the canvas's columns: 4, and 0.2 of the next to each side.
    places, weights = (np.arange(-1, 5) + 0.5) / 4, np.array([0.2, 1.0, 1.0, 1.0, 1.0, 0.2]) / 4.4
    assert columns(made.pixels) == pytest.approx(shares(places, weights), abs=1e-4)
    assert made.cost.samples == 16 * 12 * 16


# --- pools and repetitions --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pool(target: Target) -> Pool:
    return power_pool.make(cell(), target, 48, 60.0)


def test_a_choice_of_a_pool_is_what_would_have_been_observed_of_it(pool: Pool, target: Target) -> None:
    numbers = [3, 40, 11, 5]
    draws = [Draw(seed=power_pool.FIRST_SEED + number) for number in numbers]
    made, quantum = power_pool.pictures(cell(), draws, 60.0)
    alone, chosen = power_pool.observed_of(cell(), target, made, quantum), pool.chosen(numbers)
    assert [each.sha256 for each in chosen.replicates] == [each.sha256 for each in alone.replicates]
    assert chosen.scatter == pytest.approx(alone.scatter, rel=1e-9)
    assert chosen.floor_blocks == pytest.approx(alone.floor_blocks, rel=1e-12)
    assert chosen.known == alone.known
    assert all(a.coefficients == b.coefficients for a, b in zip(chosen.replicates, alone.replicates, strict=True))


def chances_of(pool: Pool) -> Chances:
    return shared(count(pool.whole, blessed_of(pool.whole)))


def test_repetitions_count_the_runs_with_an_alarm(pool: Pool, tmp_path: Path) -> None:
    chances = chances_of(pool)
    kept = Kept(tmp_path)
    kept.put("sound", pool)
    assert repeated(tmp_path, ["sound"], chances, 16, range(40)) == Null(40, 0)
    # A NaN in 12 of 48: all of the 16 are sound in 1 of 1,000 runs or so.
    ill = replace(pool.whole.replicates[0], not_finite=1)
    wrong = replace(pool, whole=replace(pool.whole, replicates=(*[ill] * 12, *pool.whole.replicates[12:])))
    kept.put("wrong", wrong)
    found = repeated(tmp_path, ["sound", "wrong"], chances, 16, range(40))
    assert found.repetitions == 40
    about = "t/embree/uniform:sampler=random  value: pixels that are no finite number"
    assert found.alarms >= 36
    assert found.by[about] == found.alarms
    halves = [repeated(tmp_path, ["sound", "wrong"], chances, 16, range(first, first + 20)) for first in (0, 20)]
    assert halves[0].joined(halves[1]) == found


def test_what_is_and_what_was_blessed_share_no_picture(
    pool: Pool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[set[str]] = []

    def alarms(now: Observed, then: Observed, chances: Chances) -> list[Check]:
        seen.extend({each.sha256 for each in found.replicates} for found in (now, then))
        return []

    monkeypatch.setattr(power_null, "alarms_of", alarms)
    Kept(tmp_path).put("one", pool)
    assert repeated(tmp_path, ["one"], chances_of(pool), 16, range(3)) == Null(3, 0)
    assert [len(one | other) for one, other in zip(seen[::2], seen[1::2], strict=True)] == [32, 32, 32]
    assert len(set().union(*seen)) > 40  # each repetition draws anew


@pytest.mark.parametrize(("alarms", "repetitions"), [(0, 1000), (4, 1000), (5, 1000), (3, 17)])
def test_the_bound_is_the_exact_one(alarms: int, repetitions: int) -> None:
    exact = binomtest(alarms, repetitions, alternative="less").proportion_ci(0.95, method="exact").high
    assert Null(repetitions, alarms).bound == pytest.approx(exact, rel=1e-9)
    assert Null(1000, 4).bound < 0.01 < Null(1000, 5).bound
    assert Null(3, 3).bound == 1.0


# --- what is caught ---------------------------------------------------------------------------------------------------


def test_defects_of_a_cell_are_caught_and_what_is_missed_is_said(target: Target, pool: Pool) -> None:
    # No sampler of that name is loaded: test_defects.py has it.
    names = [name for name in DEFECTS if name != "dimension repeated"]
    own = cell(mode="uniform:n=64,sampler=jittered")
    found = [power_defects.inject(own, target, names, number, 60.0) for number in (0, 1)]
    caught = {each.defect: each for each in power_caught.judged(own, found, chances_of(pool))}
    assert set(caught) == set(names) - {"wider samples"}
    # Along the edge nothing changes: a shift down cannot show, and does not.
    missed = {name for name, each in caught.items() if each.caught < each.tries}
    assert missed == {"shift down", "rows swapped"}
    assert caught["firefly"].tries == 2 + 2 * power_defects.PLACES
    assert caught["gain 1 %"].times is not None
    assert caught["gain 1 %"].times > 1.0
    assert "96" not in caught["transposed"].by
    assert caught["transposed"].by.startswith("the picture has 12 x 16 pixels")
    assert not caught["wider filter"].by.startswith("cost")


def test_of_several_tries_the_nearest_to_its_limit_is_told() -> None:
    def check(observed: float, limit: float, at_least: bool = False) -> Check:
        return Check(
            CellName("t", "embree", "m"), "effect", f"{observed}", observed, limit, "", False, at_least=at_least
        )

    # Of each try the check that is furthest beyond its limit: 5, 4 and infinitely many times, in turn.
    tries: list[list[Check] | str] = [
        [check(5.0, 1.0), check(2.0, 1.0)],
        [check(0.5, 2.0, True)],
        [check(1.0, 0.0)],
        [],
    ]
    found = power_caught._caught(cell(), "gain 1 %", tries)
    assert (found.tries, found.caught, found.times, found.by) == (4, 3, 4.0, "effect: 0.5")
    assert power_caught._caught(cell(), "gain 1 %", tries[2:3]).times is None


def test_a_cell_without_a_defect_is_calm(target: Target, pool: Pool) -> None:
    plain = power_pool.observe(cell(), target, 60.0)
    assert alarms_of(plain, plain, chances_of(pool)) == []


def test_pictures_of_other_bits_are_counted_and_judged(target: Target, pool: Pool) -> None:
    plain = power_pool.observe(cell(), target, 60.0)
    first = plain.replicates[0]
    other = replace(plain, replicates=(replace(first, sha256="0" * 64), *plain.replicates[1:]))
    chances = chances_of(pool)
    assert compared({plain.name: plain}, {plain.name: other}, chances) == Elsewhere(1, 16, 1, ())
    wrong = replace(plain, replicates=(replace(first, not_finite=2), *plain.replicates[1:]))
    assert len(compared({plain.name: plain}, {plain.name: wrong}, chances).alarms) == 1


# --- the answer -------------------------------------------------------------------------------------------------------


def answer_of(*caught: Caught, alarms: int = 0) -> power.Answer:
    drawn = {"embree": ("a", "b"), "osmesa": ("a",)}
    null, elsewhere = Null(1000, alarms, {"x": alarms} if alarms else {}), Elsewhere(5, 80, 3, ())
    return power.Answer(power.Asked(), drawn, 20, 11, 12, 1e-3, True, null, elsewhere, caught, {})


def of(scene: str, mode: str, times: float | None, caught: int = 11, renderer: str = "embree") -> Caught:
    return Caught(scene, renderer, mode, "gain 1 %", 11, caught, "effect: gain", times, 1e-9)


def test_the_table_says_of_each_scene_what_the_best_cell_caught() -> None:
    answer = answer_of(
        of("a", "one", 3.25), of("a", "other", None, 4), of("b", "one", 51.7), of("a", "o", None, 11, "osmesa")
    )
    assert answer.holds
    text = power_text.markdown(answer)
    assert (
        "| all values times 1.01 | 2 of 2 scenes, 22 of 22 times; 3.2 x on `a` | 1 of 1 scenes, 11 of 11 times |"
        in text
    )
    assert "0 of 1000 repetitions of the whole suite" in text
    assert "below 0.3 % of runs" in text
    assert "3 of 80 pictures of 5 cells have other bits: no alarm" in text


def test_what_is_missed_or_alarms_too_often_does_not_hold() -> None:
    missed = answer_of(of("a", "one", 3.0, 10), of("a", "other", None, 4), of("b", "one", 5.0))
    assert missed.missed == (("a", "embree", "gain 1 %"),)
    assert not missed.holds
    assert "MISSED  a  embree  gain 1 %" in power_text.lines(missed)
    assert answer_of(alarms=4).holds
    assert not answer_of(alarms=5).holds
    assert not replace(answer_of(), calm=False).holds
    assert not replace(answer_of(), elsewhere=Elsewhere(1, 16, 16, ("x",))).holds
    assert "  5 x  x" in power_text.lines(answer_of(alarms=5))


def test_each_scene_has_a_cell_in_each_renderer_that_draws_it() -> None:
    files = [scene_io.load(name) for name in ("edge", "depth-of-field", "soft-shadow", "terrain", "everything")]
    cells, _ = regress_suite.cells_of(files, list(renderers.RENDERERS))
    told = power._telling(cells)
    places = {(each.name.scene, each.name.renderer) for each in cells}
    assert {(each.name.scene, each.name.renderer) for each in told} == places
    assert len(told) < len(cells)
    # Of modes that are not in the table, all.
    others = [each for each in cells if each not in told]
    assert power._telling(others) == others


TINY = """
title = "t"
shows = "s"
[view]
size = [16, 12]
[camera]
type = "orthographic"
eye = [0.0, 0.0, 10.0]
look_at = [0.0, 0.0, 0.0]
height = 12.0
[materials.white]
emission = [1.0, 1.0, 1.0]
[[surfaces]]
type = "polygon"
material = "white"
points = [[-5.0, -4.0, 0.0], [6.0, -3.0, 0.0], [1.0, 5.0, 0.0]]
"""


def test_the_command_measures_writes_and_keeps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One cell of one renderer, as the whole suite takes half an hour."""
    (tmp_path / "tiny.toml").write_text(TINY)
    monkeypatch.setattr(places, "REFERENCES", tmp_path / "reference")
    file = scene_io.load(str(tmp_path / "tiny.toml"))
    reference = references.make(file.scene, file.scene.view.size)
    reference_files.save(places.REFERENCES, "tiny", file.scene, file.scene.view.size, "box", reference)
    modes = {"embree": {"plain": ("uniform:n=64,sampler=sobol,sampler.scramble=owen",)}}
    monkeypatch.setattr(regress_suite, "SUITE", modes)
    words = ("power", file.path, "-r", "embree", "-j", "1", "-o", tmp_path / "out", "--repetitions", "30")
    assert "--trust-plugin .build/plugins/repeats.so" in complaint(*words, code=2)
    wanted = {name: DEFECTS[name] for name in ("gain 1 %", "wider filter")}
    monkeypatch.setattr(power, "DEFECTS", wanted)
    monkeypatch.setattr(power, "REPEATED", tuple(wanted))
    found = run(*words, "--pool", "32", "--tries", "1").stdout.splitlines()
    assert found[0].startswith("0 of 30 repetitions of the suite on tiny alone")
    assert "The suite has 1 cells" in found[0]
    assert any(line.startswith("gain 1 %") and "1 of 1 scenes, 2 of 2 times" in line for line in found)
    assert found[-2:] == ["holds", str(tmp_path / "out" / "power.md")]
    document = json.loads((tmp_path / "out" / "power.json").read_text())
    assert document["holds"]
    assert document["null"]["repetitions"] == 30
    kept = {path: path.stat().st_ino for path in (tmp_path / "cache" / "power").iterdir()}
    assert len(kept) == 4  # as it is, a pool, two tries
    assert json.loads(run(*words, "--pool", "32", "--tries", "1", "--json").stdout) == document
    assert kept == {path: path.stat().st_ino for path in (tmp_path / "cache" / "power").iterdir()}  # not written again


def test_what_was_rendered_is_kept_whole(tmp_path: Path) -> None:
    kept = Kept(tmp_path / "new")
    assert kept.get("key") is None
    kept.put("key", {"a": 1})
    assert kept.get("key") == {"a": 1}
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["key.pickle"]
    (tmp_path / "new" / "key.pickle").write_bytes(b"")
    assert kept.get("key") is None
    one, other = (power_pool.key_of(cell(mode=mode), "pool", 48) for mode in ("uniform:n=4", "uniform:n=16"))
    assert len({one, other, power_pool.key_of(cell(mode="uniform:n=4"), "pool", 64)}) == 3
