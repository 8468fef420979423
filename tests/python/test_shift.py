"""Pictures that are moved on the film: all that is seen goes to the right and down, by the same in every renderer."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from commands import complaint, run
from numpy.typing import NDArray

from aliascope import api, references, scene_io
from aliascope.errors import InvalidInput, Unsupported
from aliascope.geometry import frame_of
from aliascope.image import read_header, read_image
from aliascope.model import Scene
from aliascope.renderers import RENDERERS, mode_of
from aliascope.renderers.base import Request
from aliascope.renderers.povray_frames import frames_of, moved
from aliascope.renderers.povray_sdl import scene_text

Array = NDArray[np.float64]
Shift = tuple[float, float]

SIZE = (32, 24)
WHOLE = ((3, -2), (-16, 7))
PART = (0.25, -0.4)


def drawn(
    scene: str | Scene, renderer: str, mode: str, shift: Shift = (0.0, 0.0), size: tuple[int, int] = SIZE
) -> Array:
    of = scene_io.load(scene).scene if isinstance(scene, str) else scene
    found = RENDERERS[renderer]
    pixels = found.render(Request(of, *size, mode_of(found, mode), 5, shift=shift)).pixels
    return pixels.astype(np.float64)


def both(unmoved: Array, picture: Array, right: int, down: int) -> tuple[Array, Array]:
    """The part of the unmoved picture that the moved one still shows, and where it is there."""
    height, width = unmoved.shape[:2]
    return (
        unmoved[max(0, -down) : height - max(0, down), max(0, -right) : width - max(0, right)],
        picture[max(0, down) : height - max(0, -down), max(0, right) : width - max(0, -right)],
    )


# Whole pixels: the same samples, in other pixels

EMBREE = "uniform:n=16,sampler=halton"
OSMESA = "accumulate:n=8,sampler=halton"
FRAMES = "accumulate:n=3,sampler=halton"
CASES = [
    # Flat and orthographic; patterns and a horizon in perspective; lights and their shadows.
    *((scene, "embree", EMBREE) for scene in ("edge", "zone-plate", "checker-horizon", "spheres")),
    *((scene, "osmesa", OSMESA) for scene in ("edge", "discs", "zone-plate", "checker-horizon", "spheres")),
    ("spheres", "osmesa", "msaa:n=8,sample-shading=1"),
    ("edge", "povray", "none"),
    ("edge", "povray", "regular:n=4"),
    ("edge", "povray", "am2:jitter=0"),
    ("checker-horizon", "povray", "regular:n=4"),
    ("spheres", "povray", "am2:jitter=0"),
    # A lens, motion, a light with an area.
    *((scene, "embree", EMBREE) for scene in ("depth-of-field", "motion-blur", "soft-shadow")),
    *((scene, "osmesa", OSMESA) for scene in ("depth-of-field", "motion-blur", "soft-shadow")),
    *((scene, "povray", FRAMES) for scene in ("depth-of-field", "motion-blur")),
    ("soft-shadow", "povray", "none"),
    # What the tracer does otherwise: several pixels for a sample, as many samples as it takes, paths.
    ("checker-horizon", "embree", "uniform:n=4,sampler=halton,filter=mitchell"),
    ("spheres", "embree", "adaptive:method=kajiya,sampler=halton,n=64"),
    ("everything", "embree", "uniform:n=2,sampler=halton"),
]


@pytest.fixture(scope="module")
def in_place() -> dict[tuple[str, str, str], list[Array]]:
    """Of each case the unmoved picture and those that are moved; POV-Ray's runs sleep for most of their time."""
    shifts: tuple[Shift, ...] = ((0, 0), *WHOLE)
    with ThreadPoolExecutor(8) as pool:
        asleep = {case: [pool.submit(drawn, *case, shift) for shift in shifts] for case in CASES if case[1] == "povray"}
        made = {case: [drawn(*case, shift) for shift in shifts] for case in CASES if case[1] != "povray"}
        return made | {case: [each.result() for each in runs] for case, runs in asleep.items()}


@pytest.mark.parametrize("case", CASES, ids=" ".join)
def test_by_whole_pixels_the_picture_is_the_same_elsewhere(
    case: tuple[str, str, str], in_place: dict[tuple[str, str, str], list[Array]]
) -> None:
    """To the last bit or, where a coordinate rounds otherwise, but for single samples at edges: of OSMesa, whose
    corners go to the next of 1/256 pixel, at most one of 8 passes in 1 % of the pixels. Unmoved, they are far apart."""
    unmoved, *others = in_place[case]
    for shift, picture in zip(WHOLE, others, strict=True):
        was, now = both(unmoved, picture, *shift)
        assert was.max() > was.min()
        differs = np.abs(was - now).max(axis=-1)
        rounding = 1e-5 * was.max()  # of film coordinates to float32 before shading
        assert (differs > rounding).mean() <= 0.01
        assert differs.max() <= rounding + was.max() / 8.0
        assert np.abs(unmoved - picture).max() > 0.2 * unmoved.max()


# Parts of a pixel: against samples that were taken without a shift

FINE = 20
"""Samples a side of a pixel: PART is 5 and -8 of them."""


@pytest.fixture(scope="module")
def fine() -> dict[str, Array]:
    """One sample in the middle of each pixel of a finer picture."""
    size = (FINE * SIZE[0], FINE * SIZE[1])
    return {scene: drawn(scene, "embree", "uniform:n=1,sampler=regular", size=size) for scene in ("discs", "spheres")}


def averaged(fine: Array, right: int, down: int) -> Array:
    """The means over boxes that begin so many fine pixels further left and up; NaN where they leave the picture."""
    padded = np.full((fine.shape[0] + 2 * FINE, fine.shape[1] + 2 * FINE, 3), np.nan)
    padded[FINE:-FINE, FINE:-FINE] = fine
    there = padded[FINE - down : -FINE - down, FINE - right : -FINE - right]
    means: Array = there.reshape(SIZE[1], FINE, SIZE[0], FINE, 3).mean(axis=(1, 3))
    return means


@pytest.mark.parametrize("scene", ["discs", "spheres"])
@pytest.mark.parametrize(
    ("renderer", "mode", "most"),
    [
        ("embree", "uniform:n=400,sampler=regular", 1),
        # Corners at 1/256 pixel, discs and spheres in double: single samples of 400 at a rim.
        ("osmesa", "accumulate:n=400,sampler=regular", 4),
        ("povray", "regular:n=400", 4),
    ],
)
def test_a_part_of_a_pixel_takes_the_samples_of_a_finer_picture(
    renderer: str, mode: str, most: int, scene: str, fine: dict[str, Array]
) -> None:
    """The same 400 places; at a rim as many samples as `most` may fall to the other side by rounding."""
    picture = drawn(scene, renderer, mode, PART)
    expected = averaged(fine[scene], round(PART[0] * FINE), round(PART[1] * FINE))
    known = ~np.isnan(expected)
    assert known.mean() > 0.9
    step = picture.max() / FINE**2
    assert np.abs(picture - expected)[known].max() < (most + 0.5) * step
    mirrored = averaged(fine[scene], round(-PART[0] * FINE), round(-PART[1] * FINE))  # the other signs
    there = known & ~np.isnan(mirrored)
    assert np.abs(picture - mirrored)[there].max() > 30 * step


def test_orthographic_a_shift_is_a_move_of_the_eye() -> None:
    """Against the exact integral of a camera that was moved by hand; 0.008 as in the tests of the unmoved picture."""
    scene = scene_io.load("edge").scene
    frame = frame_of(scene, SIZE)
    by = frame.pixel * (-PART[0] * frame.right + PART[1] * frame.up)
    ends = {name: tuple(np.array(getattr(scene.camera, name)) + by) for name in ("eye", "look_at")}
    camera = scene.camera.model_copy(update=ends)
    exact = references.make(scene.model_copy(update={"camera": camera}), SIZE).exact
    for name, renderer in RENDERERS.items():
        picture = drawn(scene, name, renderer.probe_mode, PART)
        assert np.sqrt(np.mean((picture - exact) ** 2)) < 0.008, name
        assert np.sqrt(np.mean((drawn(scene, name, renderer.probe_mode) - exact) ** 2)) > 0.04, name


def test_all_that_is_seen_goes_to_the_right_and_down() -> None:
    """The middle of what is bright, in every renderer."""
    spot = {"type": "sphere", "material": "white", "centre": (0.1, 0.2, 0.0), "radius": 1.0}
    for kind in ({"type": "orthographic", "height": 6.0}, {"type": "perspective", "vertical_fov_degrees": 40.0}):
        scene = Scene.model_validate(
            {
                "title": "spot",
                "shows": "a ball",
                "view": {"size": SIZE},
                "camera": {"eye": (0, 0, 9), "look_at": (0, 0, 0), **kind},
                "materials": {"white": {"emission": (1, 1, 1)}},
                "surfaces": [spot],
            }
        )
        for name, renderer in RENDERERS.items():
            middles = []
            for shift in ((0.0, 0.0), (2.3, 1.7)):
                bright = drawn(scene, name, renderer.probe_mode, shift)[..., 0]
                y, x = np.indices(bright.shape)
                middles.append(np.array([(x * bright).sum(), (y * bright).sum()]) / bright.sum())
            assert np.allclose(middles[1] - middles[0], (2.3, 1.7), atol=0.02), (name, kind["type"])


# A lens

SQUARES = Scene.model_validate(
    {
        "title": "squares",
        "shows": "squares behind the focus",
        "view": {"size": (64, 48)},
        "camera": {
            "type": "perspective",
            "eye": (0, 0, 0),
            "look_at": (0, 0, -1),
            "vertical_fov_degrees": 70.0,
            "lens_radius": 0.2,
            "focus_distance": 2.0,
        },
        "materials": {"white": {"emission": (0.8, 0.8, 0.8)}},
        "surfaces": [
            {
                "type": "polygon",
                "material": "white",
                "points": [(x, y, -4), (x + 0.7, y, -4), (x + 0.7, y + 0.7, -4), (x, y + 0.7, -4)],
            }
            for x in range(-6, 6)
            for y in range(-6, 6)
        ],
    }
)


def profiles(picture: Array) -> Array:
    """The means of the columns, and those of the rows."""
    return np.concatenate([picture.mean(axis=(0, 2)), picture.mean(axis=(1, 2))])


@pytest.mark.parametrize("shift", [(0.25, 0.1), (-16.0, 13.7)])
def test_the_focus_of_povrays_own_lens_stays_where_it_is(shift: Shift) -> None:
    """The profiles of squares out of focus, of 512 random rays a pixel, against the tracer's: 0.0029 rms in
    place, 0.0026 and 0.0029 here, and 0.063 where 16 pixels turn the lens with the camera's direction."""
    picture = profiles(drawn(SQUARES, "povray", "focal-blur:blur_samples=512,variance=0", shift, (64, 48)))
    traced = profiles(drawn(SQUARES, "embree", "uniform:n=128", shift, (64, 48)))
    in_place = profiles(drawn(SQUARES, "embree", "uniform:n=16", size=(64, 48)))
    assert np.sqrt(np.mean((picture - traced) ** 2)) < 0.005
    assert np.sqrt(np.mean((in_place - traced) ** 2)) > 0.02


# No shift, and too much of it


@pytest.mark.parametrize("text", ["none", "accumulate:n=3", "focal-blur"])
def test_without_a_shift_povray_reads_the_same_text(text: str) -> None:
    mode = mode_of(RENDERERS["povray"], text)
    frames = frames_of(mode, 1, SQUARES)
    assert scene_text(SQUARES, SIZE, 1.0, moved(frames, (0.0, 0.0))) == scene_text(SQUARES, SIZE, 1.0, frames)
    assert scene_text(SQUARES, SIZE, 1.0, moved(frames, (0.25, 0.0))) != scene_text(SQUARES, SIZE, 1.0, frames)


@pytest.mark.parametrize("shift", [(16.001, 0.0), (0.0, -17.0), (float("nan"), 0.0), (0.0, float("inf"))])
def test_shifts_end_at_16_pixels(shift: Shift) -> None:
    with pytest.raises(InvalidInput, match="from -16 to 16"):
        api.render("edge", "embree", "uniform:n=1", shift=shift)


def test_what_a_shift_takes_out_of_povrays_reach_is_refused() -> None:
    """Something 6e6 away is 9.2e6 away at the corner of the picture, and 1.3e7 where it is moved by half its width:
    POV-Ray ends at 1e7."""
    far = {
        "type": "polygon",
        "material": "white",
        "points": [(-9e6, -9e6, -6e6), (9e6, -9e6, -6e6), (0, 9e6, -6e6)],
    }
    camera = SQUARES.camera.model_copy(update={"lens_radius": None, "focus_distance": None}).model_dump()
    scene = Scene.model_validate({**SQUARES.model_dump(), "surfaces": [far], "camera": camera})
    assert drawn(scene, "povray", "none", (1.0, 0.0)).max() > 0.7
    with pytest.raises(Unsupported, match="nothing beyond 1e"):
        drawn(scene, "povray", "none", (16.0, 0.0))


def test_the_command_moves_the_picture_and_its_file_says_so(tmp_path: Path) -> None:
    render = ("render", "edge", "-r", "embree", "-m", "uniform:n=4", "--size", "32x24", "-o")
    document = json.loads(run(*render, tmp_path / "moved.exr", "--shift", "-0.25,0.4", "--json").stdout)
    assert document["shift"] == [-0.25, 0.4]
    pixels = api.render("edge", "embree", "uniform:n=4", size=SIZE, shift=(-0.25, 0.4)).pixels
    assert np.array_equal(read_image(tmp_path / "moved.exr"), pixels)
    header = read_header(tmp_path / "moved.exr")
    assert header["shift"] == "-0.25,0.4"
    assert "--shift -0.25,0.4" in header["command"]
    run(*render, tmp_path / "still.exr")
    still = read_header(tmp_path / "still.exr")
    assert len({header["key"], still["key"]}) == 2
    assert "shift" not in still
    assert "--shift" not in still["command"]
    assert "--shift" in run("render", "--help").stdout
    assert "from -16 to 16" in complaint(*render, tmp_path / "a.exr", "--shift", "0,17", code=2)
    assert "RIGHT,DOWN" in complaint(*render, tmp_path / "a.exr", "--shift", "3", code=2)
    assert "RIGHT,DOWN" in complaint(*render, tmp_path / "a.exr", "--shift", "a,3", code=2)
