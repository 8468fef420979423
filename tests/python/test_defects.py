"""The defects that a regression run has to catch: that each does what it says, in each renderer that can have it."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import in_a_fork

from aliascope import renderers
from aliascope.model import Scene
from aliascope.native import samplers
from aliascope.records import Pixels
from aliascope.regression import defects
from aliascope.regression.defects import ALL, CONTROLS, DEFECTS, Defect, firefly, not_a_number
from aliascope.regression.records import Draw
from aliascope.renderers.base import Request

ROOT = Path(__file__).resolve().parents[2]
PICTURE: Pixels = np.random.default_rng(1).uniform(-0.1, 2.0, (6, 9, 3)).astype(np.float32)
LATER = Draw(3, (0.25, 0.5))


def scene_of(points: list[tuple[float, float]]) -> Scene:
    """A white polygon on black, orthographic, 16 x 12 pixels; a unit is a pixel, (0, 0) the middle of the picture."""
    return Scene.model_validate(
        {
            "title": "t",
            "shows": "s",
            "view": {"size": (16, 12)},
            "camera": {"type": "orthographic", "eye": (0, 0, 10), "look_at": (0, 0, 0), "height": 12.0},
            "materials": {"white": {"emission": (1.0, 1.0, 1.0)}},
            "surfaces": [{"type": "polygon", "material": "white", "points": [(*point, 0.0) for point in points]}],
        }
    )


BLANK = scene_of([(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)])


def request(renderer: str, mode: str, scene: Scene = BLANK, seed: int = 0, **more: Any) -> Request:
    parsed = renderers.mode_of(renderers.find(renderer), mode)
    return Request(scene, *scene.view.size, parsed, seed, **more)


def changed(name: str, draw: Draw = LATER, pixels: Pixels = PICTURE) -> Pixels:
    picture = DEFECTS[name].picture
    assert picture is not None
    before = pixels.copy()
    found = picture(pixels, draw)
    assert np.array_equal(before, pixels)  # what was rendered stays
    assert found.dtype == np.float32
    return found


def test_a_defect_of_the_whole_picture_is_as_large_as_it_says() -> None:
    exact = PICTURE.astype(np.float64)
    assert np.allclose(changed("gain 1 %"), 1.01 * exact, rtol=2e-7, atol=0.0)  # the roundings of factor and product
    assert np.allclose(changed("offset 1/255") - exact, 1.0 / 255.0, rtol=0.0, atol=2e-7)  # of values up to 2
    encoded = changed("gamma 2.2")
    assert np.allclose(np.sign(encoded) * np.abs(encoded, dtype=np.float64) ** 2.2, exact, rtol=2e-6, atol=1e-7)
    assert float(changed("gamma 2.2", pixels=np.full_like(PICTURE, 0.5))[0, 0, 0]) == pytest.approx(0.7297, abs=1e-4)


def test_rows_are_swapped_and_squares_transposed() -> None:
    assert np.array_equal(changed("rows swapped")[0], PICTURE[5])
    assert np.array_equal(changed("rows swapped")[5], PICTURE[0])
    whole = changed("transposed")
    assert whole.shape == (9, 6, 3)
    assert np.array_equal(whole[8, 2], PICTURE[2, 8])
    square = changed("square transposed")
    assert square.shape == PICTURE.shape
    assert np.array_equal(square[1, 1 + 4], PICTURE[4, 1 + 1])  # 6 x 6 of 9 columns begin at column 1
    assert np.array_equal(square[:, [0, 7, 8]], PICTURE[:, [0, 7, 8]])


@pytest.mark.parametrize("name", ["one NaN", "firefly"])
def test_a_single_pixel_is_wrong_in_the_first_replicate_alone(name: str) -> None:
    assert np.array_equal(changed(name), PICTURE)
    found = changed(name, Draw())
    wrong = (found != PICTURE).any(axis=2)
    assert wrong.sum() == 1
    value = found[wrong][0]
    assert np.isnan(value).all() if name == "one NaN" else value.tolist() == [np.float32(10.0) * PICTURE.max()] * 3


def test_a_single_pixel_goes_where_it_is_put() -> None:
    for defect in (firefly(7.0, (0.999, 0.0)), not_a_number((0.999, 0.0))):
        assert defect.picture is not None
        wrong = defect.picture(PICTURE, Draw()) != PICTURE
        assert np.argwhere(wrong.any(axis=2)).tolist() == [[0, 8]]
    assert firefly(7.0, (1.0, 1.0)).picture(PICTURE, Draw())[5, 8, 0] == 70.0  # type: ignore[misc]


def of_request(name: str, asked: Request) -> Request:
    change = DEFECTS[name].request
    assert change is not None
    found = change(asked)
    assert isinstance(found, Request)
    return found


def test_a_wider_filter_is_the_same_mode_with_a_radius() -> None:
    text = "uniform:n=64,sampler=jittered"
    wide = of_request("wider filter", request("embree", text, seed=5))
    assert wide.mode.text == "uniform:filter=box,filter.radius=0.55,n=64,sampler=jittered"
    assert wide.seed == 5
    assert DEFECTS["wider filter"].applies(BLANK, "embree", renderers.mode_of(renderers.find("embree"), text))


def test_defects_apply_where_there_is_what_they_break() -> None:
    cases = {
        ("embree", "uniform:n=16"): {"wider filter", "dimension repeated"},
        ("embree", "uniform:n=16,filter=mitchell"): {"dimension repeated"},
        ("embree", "uniform:n=16,sampler=pmj02"): {"wider filter"},
        ("embree", "adaptive:n=16"): {"dimension repeated"},
        ("povray", "none"): set(),
        ("povray", "am1:depth=3"): set(),
        ("povray", "focal-blur"): set(),
        ("povray", "regular:n=16"): {"wider samples"},
        ("povray", "accumulate:n=4"): {"wider samples", "dimension repeated"},
        ("osmesa", "msaa:n=4"): set(),
        ("osmesa", "accumulate:n=16,sampler=halton"): {"wider samples", "dimension repeated"},
    }
    special = {"wider filter", "wider samples", "dimension repeated"}
    for (renderer, text), expected in cases.items():
        mode = renderers.mode_of(renderers.find(renderer), text)
        found = {each.name for each in ALL if each.applies(BLANK, renderer, mode)}
        assert found & special == expected, text
        assert found - special == set(DEFECTS) - special, text
    assert all(DEFECTS[name].absent for name in special)


def test_shifts_add_to_those_of_the_replicate() -> None:
    asked = request("povray", "none", shift=(0.25, -0.5))
    assert of_request("shift right", asked).shift == (0.28125, -0.5)
    assert of_request("shift down", asked).shift == (0.25, -0.46875)
    assert of_request("seed ignored", asked).shift == (0.0, 0.0)


def test_a_seed_that_is_ignored_gives_one_picture() -> None:
    asked = [request("embree", "uniform:n=4,sampler=random", seed=seed) for seed in (1, 2)]
    embree = renderers.find("embree")
    same = [embree.render(of_request("seed ignored", each)).pixels for each in asked]
    other = [embree.render(each).pixels for each in asked]
    assert np.array_equal(*same)
    assert not np.array_equal(*other)


@pytest.fixture(scope="module")
def plugin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The defective sampler, compiled."""
    out = tmp_path_factory.mktemp("plugin") / "repeats.so"
    source, library = ROOT / "csrc" / "plugins" / "repeats.c", ROOT / "harness" / "aliascope" / "native" / "lib"
    flags = ["-shared", "-fPIC", "-O1", "-std=c11", f"-I{ROOT / 'csrc' / 'include'}", f"-L{library}"]
    subprocess.run(["cc", *flags, source, "-o", out, "-laliascope"], check=True)
    return out


def _repeated(path: Path) -> list[str]:
    """What is wrong with the defective copies, in a process that may load them. 1024 points: 32^2 for jittered, 4^5 for
    regular."""
    samplers.load_plugin(str(path))
    wrong = []
    for spec, of in defects.REPEATS.items():
        copy, own = (samplers.Sampler(each, 1024, (2, 1, 2), 9) for each in (f"repeats:of={of}", spec))
        points, sound = (each.points(1024, 0, (3, 4)) for each in (copy, own))
        if not (np.array_equal(points[:, 1], sound[:, 0]) and np.array_equal(points[:, 0], sound[:, 0])):
            wrong.append(f"{spec}: dimension 1 is not dimension 0")
        if not np.array_equal(points[:, 2:], sound[:, 2:]) or copy.randomised != own.randomised:
            wrong.append(f"{spec}: more than dimension 1 is another")
    return wrong


def test_the_defective_sampler_repeats_dimension_0_and_nothing_else(plugin: Path) -> None:
    assert in_a_fork(_repeated, plugin) == []


def test_controls_are_of_values_of_places_and_of_a_single_value() -> None:
    assert [each.name for each in CONTROLS] == ["gain 1 %", "shift right", "firefly"]
    assert all(isinstance(each, Defect) and each.text for each in ALL)
    assert len(DEFECTS) == len(ALL) == 14
