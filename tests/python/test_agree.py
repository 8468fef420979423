"""Do renderers agree? The tests of `aliascope agree` call what is alike alike, and find what is not."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import complaint, run
from inline_workers import Inline

from aliascope import scene_io
from aliascope.geometry import Array
from aliascope.model import Scene
from aliascope.records import Pixels
from aliascope.scene_io import SceneFile
from aliascope.studies import agree, agree_effects, agree_known
from aliascope.studies.agree_effects import FINE, boxed, variation
from aliascope.studies.agree_judge import Effect, Judgement, Side, judge

SIZE = (32, 24)
SAMPLES = 8
REPLICATES = 12


# --- chance -----------------------------------------------------------------------------------------------------------


def side(pictures: Array, samples: int = 32) -> Side:
    return Side("a", pictures, samples, np.zeros(pictures.shape[1:]))


def flaws(picture: Array) -> list[Effect]:
    return [Effect("gain", 1.0, "%", 0.01 * picture), Effect("offset", 1.0, "/255", np.full_like(picture, 1 / 255))]


def test_alike_renderers_are_called_different_as_often_as_is_said() -> None:
    """At a significance of 0.2: 300 runs of normal values with scatters of four decades. Bonferroni's limits are wide
    where tests depend on each other, so the rate is 0.2 at most and not much below; three of its deviations, 0.07."""
    rng = np.random.default_rng(1)
    scatter = 10.0 ** rng.uniform(-6, -2, (16, 16, 3))
    picture = rng.uniform(0.1, 0.9, (16, 16, 3))
    wrong = 0
    for _ in range(300):
        one, other = (side(picture + scatter * rng.standard_normal((16, 16, 16, 3)), n) for n in (32, 32))
        wrong += bool(judge(one, other, np.zeros_like(picture), flaws(picture), 1, 0.2).failed)
    assert 0.1 < wrong / 300 < 0.27


@pytest.mark.parametrize("shared", [True, False])
def test_counts_that_hardly_ever_change_are_no_disagreement(shared: bool) -> None:
    """A stratified pattern counts an area p with floor(N p + u) of its samples. Over 300 runs at 1e-3, four would be
    called wrong once in 4,000. With samples that all pixels share, u is one number; half of the areas lie within 0.03
    of a whole count, so that mostly all pictures have the same."""
    rng = np.random.default_rng(2)
    wrong = 0
    for _ in range(300):
        areas = (rng.integers(0, 32, (16, 16, 1)) + rng.uniform(-0.03, 0.03, (16, 16, 1))) / 32
        areas = np.clip(np.where(rng.random(areas.shape) < 0.5, areas, rng.random(areas.shape)), 0.0, 1.0)
        starts = rng.random((16, 1, 1, 1)) if shared else rng.random((16, 16, 16, 1))
        coarse = np.floor(32 * areas + starts) / 32
        fine = np.floor(256 * areas + rng.random((16, 16, 16, 1))) / 256
        sides = side(np.repeat(fine, 3, axis=3), 256), side(np.repeat(coarse, 3, axis=3), 32)
        wrong += bool(judge(*sides, np.ones((16, 16, 3)), flaws(np.repeat(areas, 3, axis=2)), 1).failed)
    assert wrong < 4


def test_limits_are_found_as_often_as_is_said() -> None:
    """An effect of the least amount is found 99 times in 100: 9 misses in 200 would be one run in 6,000."""
    rng = np.random.default_rng(3)
    picture = rng.uniform(0.1, 0.9, (16, 16, 3))
    gain = Effect("gain", 1.0, "%", 0.01 * picture)
    missed = 0
    for _ in range(200):
        one, other = (picture + 0.01 * rng.standard_normal((16, 16, 16, 3)) for _ in range(2))
        found = judge(side(one), side(other), np.zeros_like(picture), [gain], 1).found[0]
        changed = judge(side(one), side(other + found.least * gain.change), np.zeros_like(picture), [gain], 1)
        missed += not changed.failed
    assert missed < 9


def test_what_a_bound_explains_is_told_from_chance() -> None:
    """A gain of 1e-3 with a scatter of 1e-4: under a bound of 2e-3 of the values it agrees, and is said to be there."""
    rng = np.random.default_rng(4)
    picture = rng.uniform(0.1, 0.9, (16, 16, 3))
    one, other = (picture + 1e-4 * rng.standard_normal((16, 16, 16, 3)) for _ in range(2))
    for gain, bound in ((1.001, True), (1.0, False)):
        wide = dataclasses.replace(side(gain * other), bound=2e-3 * picture)
        found = judge(side(one), wide, np.zeros_like(picture), flaws(picture), 1)
        assert not found.failed
        assert found.found[0].granted is bound


def test_what_is_no_number_never_agrees() -> None:
    pictures = np.zeros((4, 8, 8, 3))
    broken = pictures.copy()
    broken[:, 3, 2, 1] = np.nan
    failed = judge(side(pictures), side(broken), np.zeros((8, 8, 3)), [], 1).failed
    assert failed[0].place == (3, 2, 1)
    assert not judge(side(pictures), side(pictures), np.zeros((8, 8, 3)), [], 1).failed


def test_a_bound_widens_every_kind_of_test_and_no_more() -> None:
    """Values that are all off by 1e-3, without scatter: they agree under a bound of 1.01e-3, and not of 0.99e-3."""
    pictures = np.full((4, 16, 16, 3), 0.5)
    for bound, agrees in ((1.01e-3, True), (0.99e-3, False)):
        other = dataclasses.replace(side(pictures + 1e-3), bound=np.full((16, 16, 3), bound))
        found = judge(side(pictures), other, np.ones((16, 16, 3)) * 0.0, flaws(pictures[0]), 1)
        assert {test.kind for test in found.failed} == (set() if agrees else {"pixel", "block", "picture", "effect"})


# --- effects ----------------------------------------------------------------------------------------------------------


def test_pictures_are_moved_and_widened_as_the_integral_would_be() -> None:
    """Of a quadratic, whose means over boxes are known: shifted by d, its mean at c is (c - d)^2 + s^2 / 12."""
    places = (np.arange(8 * FINE) + 0.5) / FINE
    within = places**2 + 1.0 / (12.0 * FINE**2)  # a fine pixel's mean
    fine = np.repeat(np.broadcast_to(within, (4 * FINE, 8 * FINE))[..., np.newaxis], 3, axis=2)
    centres = np.arange(8) + 0.5
    moved, wide = boxed(fine, right=-0.125)[1, 1:-1, 0], boxed(fine, side=1.125)[1, 1:-1, 0]
    assert np.allclose(moved, (centres[1:-1] - 0.125) ** 2 + 1 / 12, atol=1e-12)
    assert np.allclose(wide, centres[1:-1] ** 2 + 1.125**2 / 12, atol=1e-12)
    upright = boxed(fine.transpose(1, 0, 2), down=-0.125)
    assert np.allclose(upright[1:-1, 1, 0], moved, atol=1e-12)


def test_edges_that_are_displaced_stay_within_their_total_variation() -> None:
    """A sliver, dimmer than its ground, half of a pixel wide: both its edges in one pixel, moved apart by 1/16."""
    fine = np.full((4 * FINE, 4 * FINE, 3), 0.8)
    fine[:, FINE + 4 : FINE + 12] = 0.3
    wider = fine.copy()
    wider[:, FINE + 3 : FINE + 13] = 0.3
    change = np.abs(boxed(wider) - boxed(fine)).max(axis=2)
    granted = 1 / 16 * variation(fine, fine).min(axis=2)
    assert change[1, 1] == pytest.approx(0.5 * 2 / 16)
    assert np.all(change <= granted + 1e-12)
    assert granted[1, 1] < 1.13 * change[1, 1]  # a fine pixel more, above and below: 18 / 16
    assert not variation(fine, np.zeros_like(fine)).any()  # a pattern, within one outline


def lamp_scene(**camera: object) -> Scene:
    """A disc of 8 pixels a side before a lit plane, 16 x 12."""
    light = {"type": "area", "corner": (2, 1, 3), "edges": ((1, 0, 0.5), (0, 1, 0)), "intensity": (1, 1, 1)}
    eye = {"type": "perspective", "eye": (0, 0, 5), "look_at": (0, 0, 0), "vertical_fov_degrees": 40.0} | camera
    paper = {"type": "plane", "material": "paper", "point": (0, 0, -2), "normal": (0, 0, 1)}
    disc = {"type": "disc", "material": "paper", "centre": (0.1, 0.2, 0), "radius": 0.7}
    moving = disc | {"motion": {"type": "translate", "by": (1.0, 0.3, 0.0)}}
    return Scene.model_validate(
        {
            "title": "a lamp",
            "shows": "lens, shutter and light",
            "view": {"size": (16, 12)},
            "camera": eye,
            "materials": {"paper": {"albedo": (0.5, 0.6, 0.7)}},
            "surfaces": [paper, moving if "shutter" in camera else disc],
            "lights": [light],
        }
    )


@pytest.mark.parametrize(
    ("camera", "names"),
    [
        ({}, {"wider lights"}),
        ({"lens_radius": 0.3, "focus_distance": 6.5}, {"wider lens", "wider lights"}),
        ({"shutter": (0.1, 0.9)}, {"shorter shutter", "wider lights"}),
    ],
)
def test_a_scene_is_tried_with_flaws_of_what_it_has(camera: dict[str, object], names: set[str]) -> None:
    """Each changes the picture, and is found in one that was changed so with other samples."""
    of = lamp_scene(**camera)
    facts = agree_effects.facts_of(of, (16, 12), False)
    found = {effect.name: effect for effect in facts.effects}
    plain = {"gain", "offset", "moved right", "moved down", "wider pixel"}
    assert set(found) == plain | names
    assert facts.edges is None
    assert all(np.abs(found[name].change).max() > 1e-4 for name in names)
    assert facts.ranges.min() >= 0.0
    file = SceneFile("lamp", Path("lamp.toml"), of)
    changed = dict(agree_effects.changed_scenes(of))
    for name in names:
        other = dataclasses.replace(file, scene=changed[name])
        sides = [
            agree.side_of(each, "embree", made, None, agree.mode_of("embree", 32))
            for each, first in ((file, 10), (other, 50))
            for made in [
                [
                    agree.picture(each, "embree", agree.mode_of("embree", 32), (16, 12), first + i, 60.0)
                    for i in range(8)
                ]
            ]
        ]
        judged = judge(*sides, facts.ranges, facts.effects, 1)
        by_name = {each.effect.name: each for each in judged.found}
        assert by_name[name].value == pytest.approx(10.0, abs=5.0 * by_name[name].standard_error)


# --- renderers --------------------------------------------------------------------------------------------------------


def replicates(file: SceneFile, renderer: str, first: int = 0) -> list[tuple[Pixels, float]]:
    mode = agree.mode_of(renderer, SAMPLES)
    return [agree.picture(file, renderer, mode, SIZE, first + seed, 60.0) for seed in range(REPLICATES)]


@dataclasses.dataclass(frozen=True)
class Drawn:
    """A scene at SIZE, what is known of it, and the replicates of Embree and OSMesa."""

    file: SceneFile
    facts: agree_effects.Facts
    embree: Sequence[tuple[Pixels, float]]
    osmesa: Sequence[tuple[Pixels, float]]

    def judged(self, one: str, made: Sequence[tuple[Pixels, float]], other: str) -> Judgement:
        """Made by `one`, or as if, against the other renderer's own."""
        own = self.osmesa if other == "osmesa" else self.embree
        sides = [
            agree.side_of(self.file, name, each, self.facts.edges, agree.mode_of(name, SAMPLES))
            for name, each in ((one, made), (other, own))
        ]
        return judge(*sides, self.facts.ranges, self.facts.effects, 2)


@pytest.fixture(scope="module", params=["edge", "spheres"])
def drawn(request: pytest.FixtureRequest) -> Drawn:
    file = scene_io.load(request.param)
    facts = agree_effects.facts_of(file.scene, SIZE, True)
    return Drawn(file, facts, replicates(file, "embree", 1000), replicates(file, "osmesa", 2000))


def test_embree_and_osmesa_agree(drawn: Drawn) -> None:
    found = drawn.judged("embree", drawn.embree, "osmesa")
    assert not found.failed
    assert {each.effect.name for each in found.found} == {"gain", "offset", "moved right", "moved down", "wider pixel"}
    assert all(each.least < each.effect.amount and each.caught for each in found.found)


def moved(scene: Scene, right: float, down: float = 0.0) -> Scene:
    """The picture moved by so many pixels: an orthographic eye goes the other way, one with a perspective turns, which
    is the same near the middle of a narrow view."""
    camera = scene.camera
    eye, at = np.array(camera.eye), np.array(camera.look_at)
    across = np.cross(at - eye, camera.up)
    across /= np.linalg.norm(across)
    up = np.cross(across, at - eye) / np.linalg.norm(at - eye)
    angle = np.radians(camera.vertical_fov_degrees or 0.0)
    pixel = (camera.height or 2.0 * np.tan(angle / 2) * np.linalg.norm(at - eye)) / SIZE[1]
    step = pixel * (down * up - right * across)
    update = {"look_at": tuple((at + step).tolist())}
    if camera.height:
        update["eye"] = tuple((eye + step).tolist())
    return scene.model_copy(update={"camera": camera.model_copy(update=update)})


def test_a_renderer_that_is_a_thirtysecond_of_a_pixel_off_is_caught(drawn: Drawn) -> None:
    """And it is said which way, within a tenth of it."""
    off = dataclasses.replace(drawn.file, scene=moved(drawn.file.scene, 1 / 32))
    found = drawn.judged("embree", replicates(off, "embree"), "osmesa")
    assert found.failed
    shift = next(each for each in found.found if each.effect.name == "moved right")
    assert -shift.value == pytest.approx(1 / 32, rel=0.1, abs=4 * shift.standard_error)


Change = Callable[[Array], Array]


@pytest.mark.parametrize(
    ("change", "name", "amount"),
    [
        (lambda values: 0.99 * values, "gain", 1.0),
        (lambda values: values - 1 / 255, "offset", 1.0),
        (lambda values: 0.9 * values + 0.1 * np.roll(values, 1, axis=1), None, 0.0),
    ],
    ids=["dimmed", "darker", "blurred"],
)
def test_a_renderer_that_dims_or_blurs_is_caught(drawn: Drawn, change: Change, name: str | None, amount: float) -> None:
    made = [(change(pixels.astype(float)).astype(np.float32), 0.0) for pixels, _ in drawn.embree]
    found = drawn.judged("embree", made, "osmesa")
    assert found.failed
    if name:
        by_name = {each.effect.name: each for each in found.found}
        assert by_name[name].value == pytest.approx(amount, rel=0.05, abs=4 * by_name[name].standard_error)


def test_a_wider_pixel_is_caught_and_measured(drawn: Drawn) -> None:
    """By 10 %: the variance is that of four pictures moved by 0.132 across and down, sqrt((1.1^2 - 1) / 12). The shape
    of the blur is another, so the amount comes out between half of it and half as much again."""
    by = float(np.sqrt((1.1**2 - 1) / 12))
    scenes = [moved(drawn.file.scene, x, y) for x in (-by, by) for y in (-by, by)]
    four = [
        replicates(dataclasses.replace(drawn.file, scene=each), "embree", 3000 + 100 * i)
        for i, each in enumerate(scenes)
    ]
    made = [(np.mean([pixels for pixels, _ in each], axis=0), 0.0) for each in zip(*four, strict=True)]
    found = drawn.judged("embree", made, "osmesa")
    wider = next(each for each in found.found if each.effect.name == "wider pixel")
    assert found.failed
    assert 5.0 < -wider.value < 15.0


# --- the command ------------------------------------------------------------------------------------------------------


OPTIONS = ("--size", "24x16", "--samples", "4", "--replicates", "8")
TWO = ("-r", "embree", "-r", "osmesa")


@pytest.fixture
def inline(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(agree, "Workers", Inline)


@pytest.fixture
def dimmed(inline: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """OSMesa has 98 % of the light."""

    def picture(file: SceneFile, renderer: str, *others: Any) -> tuple[Pixels, float]:
        made, quantum = plain(file, renderer, *others)
        return (np.float32(0.98) * made if renderer == "osmesa" else made), quantum

    plain = agree.picture
    monkeypatch.setattr(agree, "picture", picture)


def test_the_command_says_what_agrees_and_what_it_would_have_found(inline: None, tmp_path: Path) -> None:
    out = tmp_path / "out"
    printed = json.loads(run("agree", "edge", "terrain", *TWO, *OPTIONS, "-o", out, "--json").stdout)
    assert printed == json.loads((out / "results.json").read_text())
    edge, terrain = printed["cells"]
    assert (edge["verdict"], terrain["verdict"], printed["holds"]) == ("agree", "empty", True)
    assert "no ray to trace" in terrain["reason"]
    assert set(edge["tests"]) == {"pixel", "block", "picture", "effect"}
    assert edge["tests"]["pixel"]["count"] == 24 * 16 * 3
    assert all(test["share"] <= 1.0 for test in edge["tests"].values())
    assert {power["effect"] for power in printed["power"]} == set(edge["effects"])
    page = (out / "report.html").read_text()
    assert "1 of 1 pairs agree" in page
    assert page.count("data:image/png") == 1
    assert "<script" not in page


def test_a_disagreement_ends_with_one_and_says_how_much(dimmed: None, tmp_path: Path) -> None:
    said = run("agree", "edge", *TWO, *OPTIONS, "-o", tmp_path, code=1).stdout
    assert "DIFFER" in said
    assert "osmesa has -2% +- " in said
    assert "0 of 1 pairs agree, 1 differ" in said
    assert "What differs" in (tmp_path / "report.html").read_text()


def test_a_known_disagreement_is_shown_and_holds_up_to_its_size(
    dimmed: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for most, code, verdict in ((0.05, 0, "differ as known"), (0.001, 1, "DIFFER")):
        known = agree_known.Known(
            frozenset({"osmesa", "embree"}), "a lamp is old", most, features=frozenset({"polygon"})
        )
        monkeypatch.setattr(agree_known, "KNOWN", (known,))
        said = run("agree", "edge", *TWO, *OPTIONS, "-o", tmp_path, code=code).stdout
        assert verdict in said
        assert "known: a lamp is old" in said
        assert "a lamp is old" in (tmp_path / "report.html").read_text()


def test_worker_processes_draw_the_same(inline: None, monkeypatch: pytest.MonkeyPatch) -> None:
    first = run("agree", "edge", *TWO, *OPTIONS, "--json").stdout
    monkeypatch.undo()
    assert run("agree", "edge", *TWO, *OPTIONS, "-j", "2", "--json").stdout == first


def test_povray_agrees_too(inline: None) -> None:
    """Sixteen bits are granted; 8 runs of 4 frames."""
    printed = json.loads(run("agree", "edge", "-r", "embree", "-r", "povray", *OPTIONS, "--json").stdout)
    assert printed["holds"]
    assert printed["cells"][0]["tests"]["pixel"]["limit"] > 0.5 / 65535


def test_no_two_renderers_share_a_seed() -> None:
    """Patterns are the same for all pixels, so they would have the same errors."""
    asked = [agree.Asked(replicates=1024, seed=seed) for seed in (0, 1, 2**19)]
    seeds = [seed for each in asked for name in agree.CONVERGING for seed in agree.seeds_of(name, each)]
    assert len(set(seeds)) == len(seeds) == 9 * 1024
    assert min(seeds) > 2**42  # references have theirs from 2^40 on
    assert max(seeds) < 2**64


def test_what_cannot_be_tested_is_refused() -> None:
    assert "two renderers or more" in complaint("agree", "edge", "-r", "embree", code=2)
    assert "16 times as wide" in complaint("agree", "edge", "--size", "2000x2000", code=2)
    assert "unknown renderer" in complaint("agree", "edge", "-r", "blender", "-r", "embree", code=2)
