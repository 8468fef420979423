"""References of pictures that are moved on the film: by whole pixels and by parts of one, in files and as a command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from commands import complaint, run
from numpy.typing import NDArray
from reference_scenes import SIZE, box, disc, polygon, scene, stored

from aliascope import api, draws
from aliascope.errors import CheckFailed, InvalidInput
from aliascope.geometry import frame_of
from aliascope.image import read_header, read_image, write_exr
from aliascope.model import Scene
from aliascope.references import METHODS, Plan, Reference, converged, files, make
from aliascope.references.projection import to_picture

Array = NDArray[np.float64]
Shift = tuple[float, float]

WHOLE = ((3, -2), (-5, 4))
FINE = 4
"""Fine pixels a side of a pixel, of the pictures that parts of a pixel are compared with."""
PART = (0.25, -0.5)
PLAN = Plan(samples=64, replicates=16, threads=1)

PERSPECTIVE = {
    "type": "perspective",
    "eye": [0.9, 1.1, 16.0],
    "look_at": [0.3, -0.4, 0.0],
    "vertical_fov_degrees": 32.0,
}
FACING = PERSPECTIVE | {"eye": [0.9, 1.1, 16.0], "look_at": [0.9, 1.1, 0.0]}
"""Along -z, but not through the middle of what is there."""
FLAT = {"type": "orthographic", "eye": [0, 0, 16], "look_at": [0, 0, 0], "height": SIZE[1]}
COLOURS = {
    "red": {"emission": [0.9, 0.2, 0.1]},
    "green": {"emission": [0.2, 0.8, 0.3]},
    "blue": {"emission": [0, 0, 1]},
}
SHAPES = (
    polygon([(0.4, 0.3), (8.1, 1.9), (9.3, 7.7), (2.2, 8.4)], -1.0, "green"),
    polygon([(2.3, 1.2), (5.7, 2.1), (5.1, 5.9), (3.3, 3.4)]),
)
TILTED = polygon([(1.3, 1.2, 0.4), (10.7, 2.1, -1.6), (9.1, 7.9, -2.0)])
RINGS = COLOURS | {
    "red": {
        "emission": [1, 1, 1],
        "pattern": {
            "type": "zone-plate",
            "scale": 0.5,
            "origin": [-1.1, 0.3, 0],
            "colours": [[0, 0, 0], [1, 0.8, 0.6]],
        },
    }
}
SQUARES = {
    "red": {
        "emission": [1, 1, 1],
        "pattern": {
            "type": "checker",
            "scale": 0.7,
            "origin": [0.1, 0.3, 0.2],
            "colours": [[0.1, 0, 0], [1, 0.8, 0.6]],
        },
    }
}
LIT = {"red": {"albedo": [0.7, 0.6, 0.5], "emission": [0.02, 0.03, 0.01]}}
MIRRORS = COLOURS | {"water": {"emission": [0.03, 0.05, 0.02], "reflection": [0.6, 0.7, 0.8]}}
WATER = {
    "type": "polygon",
    "material": "water",
    "points": [[-4, -2, -3], [4.2, -2, -3.1], [4.9, -2, 3], [-4.3, -2, 3.4]],
}
GROUND = {"type": "plane", "material": "red", "point": [0, -2, 0], "normal": [0, 1, 0]}
LIGHT = {
    "type": "area",
    "corner": [-1.2, -1.1, 6.1],
    "edges": [[0.0, 2.1, 0.1], [2.3, 0.2, 0.0]],
    "intensity": [25.0, 24.0, 13.0],
    "falloff": "inverse-square",
}


def sliding(surface: dict[str, object]) -> dict[str, object]:
    return surface | {"motion": {"type": "translate", "by": [2.7, -1.3, 0.0]}}


SHUTTER = {"shutter": [0.1, 0.8], "response": "triangle"}
LENS = {"lens_radius": 0.6, "focus_distance": 12.0}
SCENES: dict[str, Scene] = {
    "polygons": scene(*SHAPES),
    "polygons, perspective": scene(TILTED, camera=PERSPECTIVE),
    "discs": scene(disc(4.3, 3.9, 3.2), disc(4.9, 4.4, 1.1, 1.0, "red")),
    "discs, perspective": scene(disc(4.3, 3.9, 3.2), disc(9.9, 6.4, 1.1, 1.0, "red"), camera=FACING),
    "zone-plate": scene(box(-30, -30, 40, 40), materials=RINGS),
    "zone-plate, perspective": scene(box(-30, -30, 40, 40), camera=FACING, materials=RINGS),
    "checkerboard": scene(
        GROUND, camera=FLAT | {"eye": [5, 9, 16]}, materials=SQUARES, view={"size": SIZE, "background": [0, 0, 0.2]}
    ),
    "checkerboard, perspective": scene(GROUND, camera=PERSPECTIVE | {"look_at": [0.3, 0.9, 0]}, materials=SQUARES),
    "mirrored-polygons": scene(WATER, *SHAPES[1:], camera=PERSPECTIVE, materials=MIRRORS),
    "moving-polygons": scene(SHAPES[0], sliding(box(4.3, 3.9, 5.1, 4.8)), camera=FLAT | SHUTTER),
    "moving-polygons, perspective": scene(sliding(SHAPES[1]), camera=FACING | SHUTTER),
    "defocus": scene(disc(3.3, 3.4, 1.7), polygon([(7, 1), (10, 2), (8.4, 7)], -3.0), camera=FACING | LENS),
    "irradiance": scene(TILTED, camera=FLAT, materials=LIT, lights=[LIGHT]),
    "irradiance, perspective": scene(TILTED, camera=PERSPECTIVE, materials=LIT, lights=[LIGHT]),
}
"""By the method that draws them: all of them, seen from both kinds of camera where a method has both."""


def method_of(name: str) -> str:
    return name.partition(",")[0]


def both(unmoved: Array, picture: Array, right: int, down: int) -> tuple[Array, Array]:
    """The part of the unmoved picture that the moved one still shows, and where it is there."""
    height, width = unmoved.shape[:2]
    return (
        unmoved[max(0, -down) : height - max(0, down), max(0, -right) : width - max(0, right)],
        picture[max(0, down) : height - max(0, -down), max(0, right) : width - max(0, -right)],
    )


def regrouped(fine: Array, shift: Shift) -> tuple[Array, tuple[slice, slice]]:
    """The means over FINE x FINE pixels of a finer picture in its place, from where a shift puts the pixels' corners;
    and of which pixels: those that lie within the picture whole."""
    means, kept = fine, []
    for axis, by in ((0, shift[1]), (1, shift[0])):
        whole = fine.shape[axis] // FINE
        corners = np.arange(whole) * FINE - round(by * FINE)
        inside = (corners >= 0) & (corners + FINE <= fine.shape[axis])
        places = corners[inside][:, np.newaxis] + np.arange(FINE)
        means = np.take(means, places, axis=axis).mean(axis=axis + 1)
        kept.append(slice(int(np.argmax(inside)), whole - int(np.argmax(inside[::-1]))))
    return means, (kept[0], kept[1])


@pytest.fixture(scope="module")
def in_place() -> dict[str, Reference]:
    return {name: make(of, SIZE) for name, of in SCENES.items()}


def test_there_is_a_scene_of_every_method(in_place: dict[str, Reference]) -> None:
    assert {name: found.method for name, found in in_place.items()} == {name: method_of(name) for name in SCENES}
    assert set(map(method_of, SCENES)) == {method.name for method in METHODS}


@pytest.mark.parametrize("name", SCENES)
def test_by_whole_pixels_the_picture_is_the_same_elsewhere(name: str, in_place: dict[str, Reference]) -> None:
    """Within both error bounds, which the picture itself leaves by far."""
    unmoved = in_place[name]
    for shift in WHOLE:
        found = make(SCENES[name], SIZE, shift=shift)
        assert found.method == unmoved.method
        was, now = both(unmoved.exact, found.exact, *shift)
        assert was.size > 0.2 * unmoved.exact.size
        assert np.abs(was - now).max() <= unmoved.error + found.error
        assert np.abs(unmoved.exact - found.exact).max() > 0.05 * unmoved.exact.max()


@pytest.mark.parametrize("name", SCENES)
def test_a_part_of_a_pixel_is_the_mean_of_a_finer_picture_in_its_place(name: str) -> None:
    """Within both error bounds; with the other sign, and as much down as right, it is another picture."""
    fine = make(SCENES[name], (FINE * SIZE[0], FINE * SIZE[1]))
    found = make(SCENES[name], SIZE, shift=PART)
    expected, kept = regrouped(fine.exact, PART)
    assert expected.shape == (SIZE[1] - 1, SIZE[0] - 1, 3)
    assert np.abs(found.exact[kept] - expected).max() <= found.error + fine.error
    for wrong in ((-PART[0], PART[1]), (PART[0], -PART[1]), PART[::-1]):
        other, there = regrouped(fine.exact, wrong)
        inner = slice(1, -1), slice(1, -1)
        padded = np.full((*SIZE[::-1], 3), np.nan)
        padded[there] = other
        assert np.abs(found.exact - padded)[inner].max() > 1e6 * found.error


def test_error_bounds_count_the_shift() -> None:
    """Places are sums of the shift too: each rounds by an ulp of the largest of them, and the bound has 8 of these."""
    corners = np.array([[0.0, 0.0, 0.0]])
    near, far = (to_picture(frame_of(SCENES["polygons"], SIZE, shift), corners) for shift in ((0.0, 0.0), (-1.5, 16.0)))
    assert np.array_equal(far[0] - near[0], [[-1.5, 16.0]])
    assert far[2] - near[2] == pytest.approx(8 * 2.0**-52 * ((SIZE[1] + 16.0) - SIZE[0]), rel=1e-9, abs=0.0)


@pytest.mark.parametrize("shift", [(16.001, 0.0), (0.0, -17.0), (float("nan"), 0.0), (0.0, float("inf"))])
def test_shifts_end_at_16_pixels(shift: Shift) -> None:
    with pytest.raises(InvalidInput, match="from -16 to 16"):
        make(SCENES["polygons"], SIZE, shift=shift)


# Converged

VIEW = (24, 18)


def test_converged_by_whole_pixels_within_standard_errors() -> None:
    """Under a filter that reaches past the pixel as well. Two independent estimates with 15 degrees of freedom each:
    one of 1296 values beyond 7 standard errors of the difference has a chance below 1e-4."""
    for filter_ in ("box", "mitchell"):
        unmoved = converged.make(stored("spheres"), VIEW, filter_, PLAN)
        found = make(stored("spheres"), VIEW, filter_, PLAN, WHOLE[0])
        assert found.method == "converged"
        assert unmoved.standard_error is not None
        assert found.standard_error is not None
        was, now = both(unmoved.exact, found.exact, *WHOLE[0])
        error = np.hypot(*both(unmoved.standard_error, found.standard_error, *WHOLE[0]))
        assert np.all(np.abs(was - now) <= 7 * error + 20 / (64 * 16))  # what all samples may miss
        assert np.sqrt(np.mean((was - now) ** 2)) < 2 * np.sqrt(np.mean(error**2))
        assert np.sqrt(np.mean((unmoved.exact - found.exact) ** 2)) > 20 * np.sqrt(np.mean(error**2))


@pytest.mark.parametrize("name", ["spheres", "soft-shadow"])
def test_converged_by_a_part_of_a_pixel_within_standard_errors(name: str) -> None:
    """Against the means of a finer picture, whose pixels are independent: 7 standard errors as above."""
    plan = Plan(samples=16, replicates=16, threads=1)
    fine = converged.make(stored(name), (FINE * VIEW[0], FINE * VIEW[1]), "box", plan)
    found = make(stored(name), VIEW, "box", Plan(samples=256, replicates=16, threads=1), PART)
    assert fine.standard_error is not None
    assert found.standard_error is not None
    expected, kept = regrouped(fine.exact, PART)
    variance = regrouped(fine.standard_error**2, PART)[0] / FINE**2
    error = np.sqrt(variance + found.standard_error[kept] ** 2)
    assert np.all(np.abs(found.exact[kept] - expected) <= 7 * error + 20 / (256 * 16))
    assert np.sqrt(np.mean((found.exact[kept] - expected) ** 2)) < 1.5 * np.sqrt(np.mean(error**2))
    wrong, there = regrouped(fine.exact, (-PART[0], PART[1]))
    assert np.sqrt(np.mean((found.exact[there] - wrong)[:, 1:-1] ** 2)) > 10 * np.sqrt(np.mean(error**2))


# Files

AWAY = (-0.2451, 0.125)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    files.save(tmp_path, "shapes", SCENES["polygons"], SIZE, "box", make(SCENES["polygons"], SIZE, shift=AWAY), AWAY)
    return tmp_path


def test_a_file_is_named_by_its_shift_and_says_it(folder: Path) -> None:
    of = SCENES["polygons"]
    path = folder / "shapes" / "12x9-box@-0.2451,0.125.exr"
    assert files.path_of(folder, "shapes", SIZE, "box", AWAY) == path
    header = read_header(path)
    assert header["shift"] == "-0.2451,0.125"
    assert header["command"] == "aliascope reference shapes --shift -0.2451,0.125"
    loaded = files.load(folder, "shapes", of, SIZE, "box", AWAY)
    assert np.array_equal(loaded.pixels, make(of, SIZE, shift=AWAY).pixels)
    assert files.verify(folder, "shapes", of, SIZE, "box", shift=AWAY).holds
    in_its_place = files.save(folder, "shapes", of, SIZE, "box", make(of, SIZE), (-0.0, 0.0))
    assert in_its_place.name == "12x9-box.exr"
    assert "shift" not in read_header(in_its_place)
    assert files.path_of(folder, "shapes", SIZE, "box", (-0.0, 0.5)).name == "12x9-box@0.0,0.5.exr"


def test_a_missing_one_says_how_to_make_it(folder: Path) -> None:
    for use in (files.load, files.verify):
        with pytest.raises(CheckFailed, match=r"filter mitchell, shifted by 0\.5,-0\.25 pixels .*: make it with: "):
            use(folder, "shapes", SCENES["polygons"], SIZE, "mitchell", shift=(0.5, -0.25))
        with pytest.raises(CheckFailed, match=r"aliascope reference shapes --shift 0\.5,-0\.25$"):
            use(folder, "shapes", SCENES["polygons"], SIZE, "box", shift=(0.5, -0.25))


@pytest.mark.parametrize("stated", ["-0.2451,0.1250001", "0.125,-0.2451", "", "0.0,0.0"])
def test_another_shift_in_the_header_is_refused(folder: Path, stated: str) -> None:
    path = files.path_of(folder, "shapes", SIZE, "box", AWAY)
    write_exr(path, read_image(path), read_header(path) | {"shift": stated})
    for use in (files.load, files.verify):
        with pytest.raises(CheckFailed, match=r"pixels, not -0\.2451,0\.125; make it again with: .* --shift -0\.2451,"):
            use(folder, "shapes", SCENES["polygons"], SIZE, "box", shift=AWAY)


def test_a_shifted_one_does_not_pass_for_one_in_its_place_nor_the_other_way(folder: Path) -> None:
    of, away = SCENES["polygons"], files.path_of(folder, "shapes", SIZE, "box", AWAY)
    here = files.path_of(folder, "shapes", SIZE, "box")
    away.rename(here)
    for use in (files.load, files.verify):
        with pytest.raises(CheckFailed, match=r"is shifted by -0\.2451,0\.125 pixels, not 0\.0,0\.0; .* shapes$"):
            use(folder, "shapes", of, SIZE, "box")
    files.save(folder, "shapes", of, SIZE, "box", make(of, SIZE))
    here.rename(away)
    with pytest.raises(CheckFailed, match=r"is shifted by 0\.0,0\.0 pixels, not -0\.2451,0\.125"):
        files.load(folder, "shapes", of, SIZE, "box", AWAY)


def test_pixels_of_another_shift_do_not_hold(folder: Path) -> None:
    """Under a header that says the right one."""
    of = SCENES["polygons"]
    files.save(folder, "shapes", of, SIZE, "box", make(of, SIZE), AWAY)
    assert "differs by" in files.verify(folder, "shapes", of, SIZE, "box", shift=AWAY).reason


def test_a_converged_one_has_its_standard_error_beside_it(tmp_path: Path) -> None:
    of, few = stored("spheres"), Plan(samples=16, replicates=8, threads=1)
    check = Plan(samples=16, replicates=8, sampler="jittered", first_seed=1 << 41, threads=1)
    made = make(of, VIEW, "box", few, AWAY)
    path = files.save(tmp_path, "spheres", of, VIEW, "box", made, AWAY)
    assert path.with_name("24x18-box@-0.2451,0.125.standard-error.exr").is_file()
    assert read_header(path)["command"] == "aliascope reference spheres --size 24x18 --shift -0.2451,0.125 --samples 16"
    assert files.load(tmp_path, "spheres", of, VIEW, "box", AWAY).standard_error is not None
    assert files.verify(tmp_path, "spheres", of, VIEW, "box", check, AWAY).holds
    files.save(tmp_path, "spheres", of, VIEW, "box", converged.make(of, VIEW, "box", few), AWAY)
    assert not files.verify(tmp_path, "spheres", of, VIEW, "box", check, AWAY).holds


# The command


def test_the_command_makes_one_shift_or_those_of_all_draws(tmp_path: Path) -> None:
    at = ("reference", "edge", "--size", "24x18", "-o", tmp_path)
    run(*at, "--shift", "0.25,-0.4")
    assert [path.name for path in tmp_path.rglob("*.exr")] == ["24x18-box@0.25,-0.4.exr"]
    assert "edge shifted by 0.25,-0.4: holds" in run(*at, "--shift", "0.25,-0.4", "--verify").stdout
    assert "reference edge --size 24x18 --shift -0.2451,-0.4302" in complaint(
        *at, "--shift", "-0.2451,-0.4302", "--verify", code=1
    )
    document = json.loads(run(*at, "--draws", "--json").stdout)
    shifts = [draws.shift_of(draw) for draw in range(draws.MOST)]

    def moved(shift: Shift) -> Reference:
        return make(stored("edge"), (24, 18), shift=shift)

    assert [tuple(each["shift"]) for each in document["references"]] == shifts
    for shift in shifts:
        loaded = files.load(tmp_path, "edge", stored("edge"), (24, 18), "box", shift)
        assert np.array_equal(loaded.pixels, moved(shift).pixels)
    assert np.array_equal(api.reference("edge", size=(24, 18), shift=shifts[1]).pixels, moved(shifts[1]).pixels)
    held = run(*at, "--draws", "--verify").stdout.splitlines()
    assert [line.partition(":")[0] for line in held] == [
        "edge",
        *(f"edge shifted by {draws.text_of(shift)}" for shift in shifts[1:]),
    ]


def test_the_command_refuses_what_is_no_shift(tmp_path: Path) -> None:
    at = ("reference", "edge", "-o", tmp_path)
    assert "not both" in complaint(*at, "--draws", "--shift", "0,1", code=2)
    for text in ("3", "a,3", "1,2,3"):
        assert "RIGHT,DOWN" in complaint(*at, "--shift", text, code=2)
    for verify in ((), ("--verify",)):
        assert "from -16 to 16" in complaint(*at, "--shift", "0,17", *verify, code=2)
    assert not list(tmp_path.rglob("*.exr"))
