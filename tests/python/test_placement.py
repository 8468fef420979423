"""Where scenes stand: they are drawn near the origin and at usual sizes, and what does so already is left as it is."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aliascope import placement, scene_io
from aliascope.geometry import frame_of, triangulate
from aliascope.model import Polygon, Scene, Translate
from aliascope.placement import FAR, LARGEST, SMALLEST, moved, placed, scaled, size_of
from aliascope.renderers import base, mode_of, osmesa, povray
from aliascope.renderers.povray_frames import frames_of
from aliascope.renderers.povray_limits import FARTHEST
from aliascope.renderers.povray_sdl import moving_texts, scene_text

AWAY = (1e9, -3e8, 7e8)
SIZE = (24, 18)


def picture(renderer: base.Renderer, scene: Scene, text: str) -> np.ndarray:
    request = base.Request(scene, *SIZE, mode_of(renderer, text))
    return renderer.render(request).pixels.astype(np.float64)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt((values**2).mean()))


@pytest.mark.parametrize("name", scene_io.names())
def test_usual_scenes_are_left_as_they_are(name: str) -> None:
    """The very object: no bit of their pictures, nor of their text, can change. Far or of another size they come back
    to where the same numbers are, but for the rounding of the sums."""
    scene = scene_io.load(name).scene
    assert placed(scene) is scene
    there = placed(moved(scene, AWAY))
    assert there.camera.eye == (0.0, 0.0, 0.0)
    assert placed(there) is there
    # The eye's distance to anything is what it was, to the rounding of 1e9: 2^-23.
    assert size_of(there) == pytest.approx(size_of(scene), abs=1e-6)
    for power in (-40, 30):
        again = placed(scaled(scene, 2.0**power))
        assert SMALLEST <= size_of(again) <= LARGEST
        assert placed(again) is again
        back = 2.0 ** round(np.log2(size_of(scene) / size_of(again)))
        if name != "terrain":  # whose digest has that of the corners, or of their file
            assert scaled(again, back).digest() == scene.digest()


def test_the_thresholds() -> None:
    assert (FAR, SMALLEST, LARGEST) == (1024.0, 0.0625, 8388608.0)
    scene = scene_io.load("edge").scene  # seen along z, all of it 4 units away
    assert size_of(scene) == 4.0
    for distance, stays in ((0.99 * 4.0 * FAR, True), (1.01 * 4.0 * FAR, False)):
        there = moved(scene, (distance, 0.0, 0.0))
        assert (placed(there) is there) == stays
    for size, stays in ((1.01 * SMALLEST, True), (0.99 * SMALLEST, False), (0.99 * LARGEST, True)):
        there = scaled(scene, size / 4.0)
        assert (placed(there) is there) == stays
    assert size_of(placed(scaled(scene, 1.01 * LARGEST / 4.0))) == pytest.approx(1.01 * LARGEST / 2.0)
    assert LARGEST < FARTHEST


def test_what_reaches_to_the_sides_does_not_count() -> None:
    """A floor that is cut off by the picture anyway must not make all else small."""
    scene = scene_io.load("edge").scene
    wide = scene.surfaces[0].model_copy(update={"points": ((-1e9, 0.0, 0.0), (1e9, 0.0, 0.0), (0.0, 1e9, 0.0))})
    there = scene.model_copy(update={"surfaces": (*scene.surfaces, wide)})
    assert placed(there) is there


def test_where_motion_takes_things_counts() -> None:
    scene = scene_io.load("edge").scene
    away = scene.surfaces[0].model_copy(update={"motion": Translate(type="translate", by=(0.0, 0.0, -100.0))})
    assert size_of(scene.model_copy(update={"surfaces": (away,)})) == 104.0


def test_numbers_that_no_scene_may_have_leave_it_as_it_is() -> None:
    """1e-14 of the size, its light is 2^98 times as strong at the usual one: past the largest number."""
    scene = scene_io.load("spheres").scene
    lamp = scene.lights[0].model_copy(update={"falloff": "inverse-square", "intensity": (1e5, 0.0, 0.0)})
    bright = scene.model_copy(update={"lights": (lamp,)})
    tiny = placement.scaled(bright, 1e-14).model_copy(update={"lights": (lamp,)})
    assert placed(tiny) is tiny


ACCUMULATE = "accumulate:n=2,sampler=sobol"
CASES = [
    ("edge", "none"),
    ("spheres", "none"),
    ("checker-horizon", "none"),
    ("zone-plate", "none"),
    ("depth-of-field", ACCUMULATE),
    ("motion-blur", ACCUMULATE),
    ("soft-shadow", ACCUMULATE),
]
"""Patterns, a lens, what moves, lights with and without an area."""


def as_they_are(renderer: base.Renderer, name: str) -> bool:
    """POV-Ray meets an endless plane and finds its squares in double, and bounds it by no box of floats."""
    return renderer is osmesa.RENDERER or name != "checker-horizon"


@pytest.mark.parametrize(("name", "mode"), CASES)
@pytest.mark.parametrize("renderer", [povray.RENDERER, osmesa.RENDERER], ids=["povray", "osmesa"])
def test_a_scene_far_away_looks_the_same(renderer: base.Renderer, name: str, mode: str) -> None:
    """Moved by a billion units, coordinates are rounded to 1.2e-7: 1e-5 of a pixel. An edge goes through a sample of
    some 900 with a chance of 1e-2, and no step is higher than 0.9: 0.03 rms; so none has. Without, nothing is left."""
    scene = scene_io.load(name).scene
    there = moved(scene, AWAY)
    still = picture(renderer, scene, mode)
    assert rms(picture(renderer, there, mode) - still) < 1e-4
    more = "," if ":" in mode else ":"
    lost = rms(picture(renderer, there, f"{mode}{more}recentre=0") - still) if as_they_are(renderer, name) else 1.0
    assert lost > 0.05


@pytest.mark.parametrize(("name", "mode"), [CASES[1], CASES[2], CASES[3], CASES[4], CASES[5]])
def test_a_tiny_scene_and_a_huge_one_look_the_same(name: str, mode: str) -> None:
    """By powers of two, to the bit. As its coordinates are POV-Ray would draw none of them."""
    scene = scene_io.load(name).scene
    more = "," if ":" in mode else ":"
    for renderer in (povray.RENDERER, osmesa.RENDERER):
        still = picture(renderer, scene, mode)
        for power in (-40, 40):
            there = scaled(scene, 2.0**power)
            np.testing.assert_array_equal(picture(renderer, there, mode), still)
            if renderer is povray.RENDERER:
                reason = base.lacks(renderer, there, mode_of(renderer, f"{mode}{more}recentre=0"))
                assert "POV-Ray" in (reason or "")


def test_light_that_falls_off_goes_along() -> None:
    scene = scene_io.load("spheres").scene
    lamp = scene.lights[0].model_copy(update={"falloff": "inverse-square", "intensity": (9.0, 8.0, 7.0)})
    scene = scene.model_copy(update={"lights": (lamp, scene.lights[1])})
    for renderer in (povray.RENDERER, osmesa.RENDERER):
        still = picture(renderer, scene, "none")
        assert still.max() > 0.3
        for power in (-30, 30):
            # POV-Ray's colours are float, and its fall-off goes by a distance that is scaled: within steps of 16 bits.
            assert np.abs(picture(renderer, scaled(scene, 2.0**power), "none") - still).max() < 3.0 / 65535.0


@pytest.mark.parametrize("kind", ["disc", "sphere"])
def test_lights_with_a_radius_grow_with_their_scene(kind: str) -> None:
    lamp = {"type": kind, "centre": (1.0, 2.0, 3.0), "radius": 0.25, "intensity": (1.0, 1.0, 1.0)}
    if kind == "disc":
        lamp["normal"] = (0.0, -1.0, 0.0)
    scene = scene_io.load("spheres").scene
    scene = Scene.model_validate({**scene.model_dump(exclude={"lights"}), "lights": [lamp]})
    (light,) = scaled(scene, 8.0).lights
    assert light.model_dump()["centre"] == (8.0, 16.0, 24.0)
    assert light.model_dump()["radius"] == 2.0


def test_as_they_are_coordinates_are_those_of_the_scene() -> None:
    """Each corner of the edges stands in the text as it does in the file; recentred, none that is off the axes does."""
    scene = scene_io.load("edge").scene
    there = moved(scene, (512.0, 256.0, 128.0))
    frames = frames_of(mode_of(povray.RENDERER, "none"), 0, there)
    text = scene_text(there, SIZE, 1.0, frames, recentred=False)
    corners = {tuple(map(repr, corner)) for surface in there.surfaces for corner in surface.points}  # type: ignore[union-attr]
    found = re.findall(r"<([^<>]*)>", "\n".join(line for line in text.splitlines() if line.startswith("triangle")))
    assert {tuple(each.split(",")) for each in found} == corners
    assert "location <512.0, 256.0, 132.0> + <" in text
    assert "<512." not in scene_text(there, SIZE, 1.0, frames)


def test_as_they_are_a_picture_near_the_origin_is_the_same() -> None:
    """The key changes where the numbers are, and not what is drawn: also of what moves, and through a lens."""
    for name, mode in (CASES[1], CASES[4], CASES[5], CASES[6]):
        scene = scene_io.load(name).scene
        more = "," if ":" in mode else ":"
        assert (
            rms(picture(povray.RENDERER, scene, f"{mode}{more}recentre=0") - picture(povray.RENDERER, scene, mode))
            < 2e-3
        )
    lens = scene_io.load("depth-of-field").scene
    still, there = (
        picture(povray.RENDERER, lens, f"focal-blur:blur_samples=37,variance=0,recentre={recentre}")
        for recentre in (1, 0)
    )
    # The same lattice of 37 rays in each pixel, but for rounding; focused as from the origin it is 0.086 rms.
    assert rms(still - there) < 0.01
    moving = scene_io.load("motion-blur").scene
    frames = frames_of(mode_of(povray.RENDERER, ACCUMULATE), 0, moving)
    texts = [dict(moving_texts(moving, 1.0, frames, recentred)) for recentred in (False, True)]
    assert texts[0].keys() == texts[1].keys()
    assert texts[0] != texts[1]


def test_rounding_far_away_leaves_polygons_drawable() -> None:
    """A board that leans, a billion units away: its four corners do not lie in one plane to more than 1e-7 units. So
    much is rounding there, and none at the origin."""
    scene = scene_io.load("soft-shadow").scene
    there = moved(scene, AWAY)
    for surface in there.surfaces:
        assert isinstance(surface, Polygon)
        assert len(triangulate(surface)) == len(surface.points) - 2
    bent = (each.model_copy(update={"points": relative(each, AWAY)}) for each in there.surfaces)  # type: ignore[arg-type]
    assert any(not planar(each) for each in bent if isinstance(each, Polygon))


def planar(polygon: Polygon) -> bool:
    try:
        return len(triangulate(polygon)) > 0
    except ValueError:
        return False


def relative(surface: Polygon, to: tuple[float, float, float]) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(a - b for a, b in zip(point, to, strict=True)) for point in surface.points)


POWERS = st.floats(-12.0, 12.0)
DIRECTION = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(scale=POWERS, distance=POWERS, direction=DIRECTION, name=st.sampled_from(["edge", "spheres", "everything"]))
def test_wherever_a_scene_is_its_picture_has_it_in_its_place(
    scale: float, distance: float, direction: tuple[float, float, float], name: str
) -> None:
    """Scaled by 10^scale, then moved by up to 10^distance of its own units: at home again, what is drawn has the places
    that it had, seen from the eye and over its size, but for what the sums have rounded away."""
    home = scene_io.load(name).scene
    size = 10.0**scale
    away = tuple(size * 10.0**distance * each for each in direction)
    there = placed(moved(scaled(home, size), away))
    assert placed(there) is there
    assert SMALLEST <= size_of(there) <= LARGEST
    rounding = 1e-14 + 2.0**-50 * 10.0**distance
    np.testing.assert_allclose(seen_from_the_eye(there), seen_from_the_eye(home), rtol=0.0, atol=200.0 * rounding)


def seen_from_the_eye(scene: Scene) -> np.ndarray:
    """Over the size of the scene: the least and the most of corners and centres along right, up and forward, the radii,
    and where lights are."""
    frame, places, radii = frame_of(scene), [], []
    for surface in (*scene.surfaces, *scene.lights):
        radii.append(getattr(surface, "radius", 0.0))
        if isinstance(surface, Polygon):
            places += surface.points
        else:
            places += [getattr(surface, name) for name in ("centre", "position", "corner") if hasattr(surface, name)]
    axes = np.array([frame.right, frame.up, frame.forward])
    local = (np.array(places) - frame.eye) @ axes.T
    return np.array([*local.min(axis=0), *local.max(axis=0), sum(radii)]) / size_of(scene)
