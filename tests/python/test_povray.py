"""The POV-Ray renderer: that its pictures are of the scene, what they cost, and what it refuses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from povray_scenes import PLAIN, Array, mode, pixel_rays, render, render_all, scene_of

from aliascope.errors import SpecError, Unsupported
from aliascope.geometry import frame_of
from aliascope.model import Scene
from aliascope.records import Rendering
from aliascope.renderers import povray, povray_process, process
from aliascope.renderers.base import Request, lacks
from aliascope.renderers.povray import RENDERER
from aliascope.renderers.povray_limits import FARTHEST, NEAREST

QUANTUM = 1.0 / 65535.0
HALF_STEP = 0.5 * QUANTUM + 2.0**-24  # rounding to 16 bits, and of POV-Ray's colours to float32


# The pictures


def test_up_is_up_right_is_right_and_values_are_linear() -> None:
    """Three discs around known pixel centres, in a picture taller than wide; a gamma would change their values."""
    places = {"red": (-4.5, 7.5), "green": (2.5, 4.5), "blue": (-1.5, -6.5)}
    values = {"red": (0.9, 0.1, 0.0), "green": (0.0, 1.0, 0.3), "blue": (0.2, 0.0, 0.7)}
    scene = scene_of(
        [{"type": "disc", "material": m, "centre": (*p, 0), "radius": 0.4} for m, p in places.items()],
        {m: {"emission": v} for m, v in values.items()},
        size=(12, 20),
        background=(0.05, 0.06, 0.07),
    )
    expected = np.full((20, 12, 3), scene.view.background)
    expected[2, 1], expected[5, 8], expected[16, 4] = values["red"], values["green"], values["blue"]
    rendering = render(scene, "none")
    assert rendering.pixels.dtype == np.float32
    assert rendering.quantum == QUANTUM
    np.testing.assert_allclose(rendering.pixels, expected, rtol=0, atol=HALF_STEP)
    steps = rendering.pixels.astype(np.float64) * 65535.0
    # Values are whole steps of 1/65535 up to the rounding of float32: 65535 * 2^-25 < 0.002.
    np.testing.assert_allclose(steps, np.round(steps), rtol=0, atol=0.002)


def cast(scene: Scene) -> Array:
    """The scene at its pixel centres, by the textbook's intersections."""
    origins, directions = pixel_rays(frame_of(scene))
    nearest = np.full(origins.shape[:2], np.inf)
    picture = np.zeros(origins.shape) + scene.view.background
    for surface in scene.surfaces:
        if surface.type == "sphere":
            offset = origins - np.array(surface.centre)
            a, b = (directions**2).sum(-1), (directions * offset).sum(-1)
            root = np.sqrt(np.maximum(b * b - a * ((offset**2).sum(-1) - surface.radius**2), 0.0))
            t, hit = (-b - root) / a, root > 0.0
        elif surface.type == "disc":
            normal, centre = np.array(surface.normal), np.array(surface.centre)
            t = (centre - origins) @ normal / (directions @ normal)
            hit = np.linalg.norm(origins + t[..., None] * directions - centre, axis=-1) < surface.radius
        else:
            assert surface.type == "polygon"
            corners = [np.array(point) for point in surface.points]
            normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            t = (corners[0] - origins) @ normal / (directions @ normal)
            points = origins + t[..., None] * directions
            sides = [
                np.cross(after - corner, points - corner) @ normal > 0.0
                for corner, after in zip(corners, [*corners[1:], corners[0]], strict=True)
            ]
            hit = np.logical_and.reduce(sides)
        hit &= (t > 0.0) & (t < nearest)
        nearest[hit] = t[hit]
        picture[hit] = scene.materials[surface.material].emission
    return picture


@pytest.mark.parametrize(
    "kind", [{"type": "perspective", "vertical_fov_degrees": 43.7}, {"type": "orthographic", "height": 4.13}]
)
def test_every_pixel_of_an_oblique_view_is_the_ray_through_its_centre(kind: dict[str, Any]) -> None:
    """Spheres, discs and a quadrilateral (two triangles) over each other, and others behind the camera."""
    eye, look_at = np.array([2.1, 1.7, 3.9]), np.array([0.13, 0.21, -0.17])
    behind = tuple(eye + 2.0 * (eye - look_at))
    quadrilateral = [(-1.7, -1.1, 0.3), (1.9, -1.3, 0.3), (1.3, 0.9, 0.3), (-1.2, 0.7, 0.3)]
    values = {"a": (0.9, 0.2, 0.0), "b": (0.0, 0.8, 0.1), "c": (0.3, 0.0, 1.0), "d": (1.0, 1.0, 1.0)}
    scene = scene_of(
        [
            {"type": "polygon", "material": "a", "points": quadrilateral},
            {"type": "sphere", "material": "b", "centre": (0.73, 0.81, 0.11), "radius": 0.61},
            {"type": "disc", "material": "c", "centre": (-0.63, 0.47, 0.71), "normal": (0.4, 0.3, 0.9), "radius": 0.57},
            {"type": "sphere", "material": "d", "centre": behind, "radius": 2.0},
            {"type": "disc", "material": "d", "centre": behind, "normal": tuple(eye - look_at), "radius": 9.0},
        ],
        {name: {"emission": value} for name, value in values.items()},
        camera={"eye": tuple(eye), "look_at": tuple(look_at), "up": (0.1, 1.0, 0.05), **kind},
        size=(96, 64),
        background=(0.05, 0.1, 0.2),
    )
    expected = cast(scene)
    assert len(np.unique(expected.reshape(-1, 3), axis=0)) == 4  # a, b, c and the background are in view
    np.testing.assert_allclose(render(scene, "none").pixels, expected, rtol=0, atol=HALF_STEP)


def test_zone_plate_follows_its_formula() -> None:
    colours = np.array([[0.07, 0.06, 0.09], [0.93, 0.91, 0.86]])
    emission, origin, scale = np.array([1.0, 0.7, 0.9]), np.array([-3.137, -1.573, 0.4]), 0.0371
    scene = scene_of(
        [{"type": "polygon", "material": "rings", "points": [(-99, -99, 0), (99, -99, 0), (0, 99, 0)]}],
        {
            "rings": {
                "emission": tuple(emission),
                "pattern": {"type": "zone-plate", "scale": scale, "origin": tuple(origin), "colours": colours.tolist()},
            }
        },
        size=(48, 36),
    )
    x, y = np.meshgrid(np.arange(48) + 0.5 - 24.0, 18.0 - np.arange(36) - 0.5)
    phase = scale * ((x - origin[0]) ** 2 + (y - origin[1]) ** 2 + origin[2] ** 2)
    expected = emission * (colours[0] + (colours[1] - colours[0]) * ((1 + np.cos(phase)) / 2)[..., None])
    # 1e-7: what the pattern is cut by at 1; 4 * 2^-24: colours and their map are float32, four operations.
    np.testing.assert_allclose(render(scene, "none").pixels, expected, rtol=0, atol=HALF_STEP + 1e-7 + 2.0**-22)


RING = scene_of(
    [
        {"type": "disc", "material": "white", "centre": (0.313, -0.271, 0.1), "radius": 9.73},
        {"type": "sphere", "material": "dark", "centre": (1.71, 0.83, 2.0), "radius": 5.19},
    ],
    {"white": {"emission": (1, 0.8, 0.4)}, "dark": {"emission": (0.2, 0.4, 0.6)}},
    size=(32, 24),
)


def test_a_regular_grid_is_the_grid_of_am1_without_its_centre_ray() -> None:
    """+AM1 +R8 without threshold and jitter: 64 cell centres and the pixel's centre, which weigh alike."""
    grid, centre = render(RING, "regular:n=64"), render(RING, "none").pixels
    am1 = render(RING, "am1:depth=8,threshold=0,jitter=0").pixels
    # Colours are fifths, so whole steps of 1/65535: only the mean of am1 is rounded, by half a step, 7.6e-6. (Colours
    # between the steps are all rounded one way in the grid's samples, and the two then differ by up to a whole step.)
    np.testing.assert_allclose((64.0 * grid.pixels + centre) / 65.0, am1, rtol=0, atol=1e-5)
    assert np.abs(grid.pixels - am1).max() > 1e-3  # so the relation says something
    assert grid.cost.samples == 64 * 32 * 24
    assert grid.cost.samples_per_pixel == 64.0
    assert dict(grid.cost.rays) == {"camera": 64 * 32 * 24}


@pytest.mark.parametrize("steep", [False, True])
def test_an_edge_of_slope_one_in_eight_lies_where_it_is(steep: bool) -> None:
    """White fills one side of an edge that passes 3.137 pixels from the middle; its mean position is measured."""
    size, offset = 64, 3.137
    ends = [(-40.0, offset - 5.0), (40.0, offset + 5.0)]  # over the whole picture, 5 in 40
    outline = [*ends, (40.0, -40.0), (-40.0, -40.0)]
    scene = scene_of(
        [{"type": "polygon", "material": "white", "points": [(*(p[::-1] if steep else p), 0.0) for p in outline]}],
        {"white": {"emission": (1, 1, 1)}},
        size=(size, size),
    )
    pixels = render(scene, "am1:depth=9,threshold=0,jitter=0").pixels.astype(np.float64)[..., 0]
    # Columns (or rows) hold all phases of the edge, 8 columns a pixel; the mean of the edge over them is its offset.
    filled = pixels.sum(axis=1) if steep else pixels[::-1].sum(axis=0)
    # 81 cells of 1/9 pixel over 8 phases resolve 1/72 pixel, half of that is 0.007; 0.01 is what the design asks.
    assert abs(filled.mean() - size / 2 - offset) < 0.01
    # It must be the near side of the picture that is filled.
    assert (pixels[:, 0] if steep else pixels[-1]).min() == 1.0
    assert (pixels[:, -1] if steep else pixels[0]).max() == 0.0


def test_bright_scenes_come_unclipped_with_the_step_of_half_floats() -> None:
    scene = scene_of(
        [{"type": "disc", "material": "lamp", "centre": (0, 0, 0), "radius": 2.0}],
        {"lamp": {"emission": (3.3, 0.7, 40.1)}},
        size=(8, 8),
        background=(0.1, 0.2, 0.3),
    )
    rendering = render(scene, "none")
    assert rendering.quantum == 2.0**-5  # 40.1 lies in [32, 64), half floats have 10 bits after the first
    np.testing.assert_allclose(rendering.pixels[4, 4], (3.3, 0.7, 40.1), rtol=2.0**-11)  # half the last of 11 bits
    np.testing.assert_allclose(rendering.pixels[0, 0], (0.1, 0.2, 0.3), rtol=2.0**-11)


def test_a_scene_as_bright_or_as_dim_as_one_likes_has_the_same_picture() -> None:
    """Times 10^k, by linearity; within the step of 16 bits, or of half floats."""

    def shone(light: float, **keys: str) -> Rendering:
        lamp = {"type": "disc", "material": "lamp", "centre": (0.3, 0.2, 0), "radius": 2.6}
        scene = scene_of([lamp], {"lamp": {"emission": (0.9 * light, 0.5 * light, 0.1 * light)}}, size=(8, 8))
        return render(scene, "regular:" + ",".join(f"{key}={value}" for key, value in ({"n": "4"} | keys).items()))

    plain = shone(1.0).pixels.astype(np.float64)
    for light in (1e-30, 1e-9, 1e30):
        got = shone(light)
        assert 0.0 < got.quantum < 1e-3 * light
        np.testing.assert_allclose(got.pixels / light, plain, rtol=2.0**-11, atol=QUANTUM)
    assert shone(1e-9, exposure="off").pixels.max() == 0.0  # so that what is compensated is there to be compared
    assert "65504" in (RENDERER.unable(scene_of([], {}, background=(7e4, 0, 0)), mode("none:exposure=off")) or "")


@pytest.mark.parametrize("text", ["am1:depth=2,threshold=0.1", "am2:depth=3,threshold=0.1,jitter=0"])
@pytest.mark.parametrize("light", [0.02, 0.001])
def test_dim_light_keeps_the_threshold_of_antialiasing(text: str, light: float) -> None:
    """At an exposure it is higher, and where no contrast reaches it the first samples are all there are: the same
    samples as without an exposure, more exact."""
    lamp = {"type": "disc", "material": "lamp", "centre": (0.3, 0.2, 0), "radius": 2.6}
    scene = scene_of([lamp], {"lamp": {"emission": (light, 0.7 * light, 0.0)}}, size=(8, 8))
    exposed, plain = render(scene, text), render(scene, f"{text},exposure=off")
    assert exposed.quantum < plain.quantum / 16
    np.testing.assert_allclose(exposed.pixels, plain.pixels, rtol=0, atol=plain.quantum)
    if light == 0.02 or text.startswith("am2"):  # the first ray of +AM1 has its neighbours', beyond the border
        assert exposed.cost.samples == plain.cost.samples


# What it costs


def test_samples_are_all_rays_from_the_camera() -> None:
    rendering = render(RING, "am2:depth=3,threshold=0,jitter=0")
    # 5 x 5 samples a pixel; the corners are shared: 33 x 25 of them and those at the border of tiles (none: 32 x 24).
    assert rendering.cost.samples == 32 * 24 * (25 - 4) + 33 * 25
    assert rendering.cost.samples_per_pixel == rendering.cost.samples / (32 * 24)
    assert dict(rendering.cost.rays) == {"camera": rendering.cost.samples}
    assert rendering.cost.repeats == 1


def test_a_short_picture_is_timed_over_several_frames() -> None:
    once, timed = render(RING, "none"), render(RING, "none", least_seconds=0.1)
    assert once.cost.repeats == 1
    # 768 pixels take a millisecond; how many make 0.1 s is told from the first, which a busy machine may slow down.
    assert timed.cost.repeats > 5
    assert 0.0 < timed.cost.cpu_seconds < 0.1
    np.testing.assert_array_equal(once.pixels, timed.pixels)


def test_a_picture_longer_than_asked_for_is_timed_once() -> None:
    rendering = render(RING, "am2:depth=6,threshold=0", least_seconds=0.01)  # 1,089 rays a pixel
    assert rendering.cost.repeats == 1
    assert rendering.cost.cpu_seconds >= 0.01


def test_version_and_seeds() -> None:
    assert RENDERER.versions()["povray"].startswith("3.")
    assert not any(RENDERER.seeded(mode(name)) for name in RENDERER.modes)


# What it refuses


@pytest.mark.parametrize(
    "text", ["am1:threshold=1", "am2:threshold=-0.1", "am1:depth=10", "am2:depth=0", "am1:jitter=2"]
)
def test_modes_outside_their_range_are_refused_with_the_range(text: str) -> None:
    with pytest.raises(SpecError, match=r"outside \["):
        mode(text)


def test_canonical_modes() -> None:
    assert mode("am1:depth=3,threshold=0.1,jitter=1").text == "am1"
    assert mode("regular:n=64").text == "regular:n=64"


def test_a_grid_needs_a_square_number() -> None:
    with pytest.raises(Unsupported, match="16 and 25"):
        render(PLAIN, "regular:n=17")
    assert "16 and 25" in (RENDERER.unable(PLAIN, mode("regular:n=17")) or "")


def test_a_canvas_past_the_largest_is_refused() -> None:
    with pytest.raises(Unsupported, match="canvas"):
        RENDERER.render(Request(PLAIN, 1024, 1024, mode("regular:n=100")))


def with_surface(**surface: Any) -> Scene:
    return scene_of([{"material": "white", **surface}], {"white": {"emission": (1, 1, 1)}})


def through_the_lens(**surface: Any) -> Scene:
    """Seen along -z from the origin."""
    camera = {"type": "perspective", "eye": (0, 0, 0), "look_at": (0, 0, -1), "vertical_fov_degrees": 40.0}
    return scene_of([{"material": "white", **surface}], {"white": {"emission": (1, 1, 1)}}, camera)


TRIANGLE = {"type": "polygon", "points": [(0, 0, 0), (1, 0, 0), (0, 1, 0)]}


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (with_surface(**TRIANGLE), None),
        (with_surface(type="disc", centre=(0, 0, 9 - 2 * NEAREST), radius=1), None),
        (with_surface(type="disc", centre=(0, 0, 9 - 0.5 * NEAREST), radius=1), "nearer than"),
        (with_surface(type="disc", centre=(0, 0, 9), normal=(0, 1, 0.1), radius=1), None),  # cuts the plane of the eye
        (with_surface(type="disc", centre=(0, 0, -0.9 * FARTHEST), radius=1), None),
        (with_surface(type="disc", centre=(0, 0, -1.1 * FARTHEST), radius=1), "beyond"),
        (with_surface(type="disc", centre=(0, 0, 1.1 * FARTHEST), radius=1), None),  # behind the camera
        (with_surface(type="plane", point=(0, 0, 9 - 2 * NEAREST), normal=(0, 0, 1)), None),
        (with_surface(type="plane", point=(0, 0, 9 - 0.5 * NEAREST), normal=(0, 0, 1)), "nearer than"),
        (with_surface(type="plane", point=(0, 0, 9), normal=(0, 1, 0.1)), None),
        (through_the_lens(type="plane", point=(0, -1.1 * NEAREST, 0), normal=(0, 1, 0)), None),
        (through_the_lens(type="plane", point=(0, -0.1 * NEAREST, 0), normal=(0, 1, 0)), "nearer than"),
        (through_the_lens(type="plane", point=(0, -0.1 * NEAREST, 0), normal=(0, 1, -1)), None),  # and out of the view
        (with_surface(type="sphere", centre=(0, 0, 0), radius=1e-3), None),
        (with_surface(type="sphere", centre=(0, 0, 0), radius=1e-8), None),  # a hundred-millionth of a pixel
        (scene_of([], {}, background=(7e4, 0, 0)), None),
        (scene_of([], {"lamp": {"emission": (1, 0, 0)}}, background=(7e4, 0, 0)), "65504"),
        (scene_of([], {"lamp": {"emission": (2, 0, 0)}}, background=(7e4, 0, 0)), None),
    ],
)
def test_reasons_for_scenes_beyond_its_range(scene: Scene, reason: str | None) -> None:
    """As the scenes' coordinates are."""
    found = RENDERER.unable(scene, mode("none:recentre=0"))
    assert (reason in (found or "")) if reason else found is None


@pytest.mark.parametrize(("height", "radius", "lost"), [(8e-5, 1e-5, True), (8e-5, 1e-4, True), (0.08, 0.01, False)])
def test_a_small_world_loses_the_rims_of_its_spheres(height: float, radius: float, lost: bool) -> None:
    """Half chords under 1e-5 are lost: of a radius of 1e-4, 5e-7, which is 0.08 pixel at 8e-5 / 12 a pixel."""
    camera = {"type": "orthographic", "eye": (0, 0, 1), "look_at": (0, 0, 0), "height": height}
    sphere = {"type": "sphere", "material": "m", "centre": (0, 0, 0), "radius": radius}
    scene = scene_of([sphere], {"m": {}}, camera=camera)
    assert ("rim" in (RENDERER.unable(scene, mode("none")) or "")) == lost


def test_its_range_is_what_povray_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    """A disc or plane this side of each limit is there, one past it is not: the limits are the program's own."""
    limits = (1.01 * NEAREST, 0.99 * NEAREST, 0.99 * FARTHEST, 1.01 * FARTHEST)
    scenes = []
    distances = (*limits, *limits)
    for number, distance in enumerate(distances):
        disc = {"type": "disc", "centre": (0, 0, -distance), "radius": 4}
        scene = with_surface(
            **disc if number < 4 else {"type": "plane", "point": (0, 0, -distance), "normal": (0, 0, 1)}
        )
        camera = scene.camera.model_copy(update={"eye": (0.0, 0.0, 0.0), "look_at": (0.0, 0.0, -1.0)})
        scenes.append(scene.model_copy(update={"camera": camera}))
    as_they_are = "none:recentre=0"
    reasons = [RENDERER.unable(scene, mode(as_they_are)) for scene in scenes]
    monkeypatch.setattr(povray, "_lost_at_all", lambda *_: None)
    for distance, reason, rendering in zip(distances, reasons, render_all(scenes, as_they_are), strict=True):
        assert (rendering.pixels.max() == 1.0) == (reason is None)
        assert (reason is None) == (NEAREST < distance < FARTHEST)


def test_features_it_does_not_draw_are_named() -> None:
    light = {"type": "sphere", "centre": (0, 0, 1), "radius": 1.0, "intensity": (1, 1, 1)}
    lit = Scene.model_validate({**PLAIN.model_dump(), "lights": [light]})
    assert "sphere light" in (lacks(RENDERER, lit, mode("none")) or "")
    with pytest.raises(Unsupported, match="sphere light"):
        render(lit, "none")


def test_short_waits_change_no_bit_and_cpu_times_are_fine(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Without the library povray cuts its times off at whole milliseconds, and sleeps ten times as long as it works."""
    scene = RING
    with_it = render(scene, "am1:depth=3", least_seconds=0.02)
    monkeypatch.setattr(povray_process, "SHORT_WAITS", tmp_path / "none")
    without = render(scene, "am1:depth=3")
    np.testing.assert_array_equal(with_it.pixels, without.pixels)
    assert with_it.cost.samples == without.cost.samples
    assert without.cost.cpu_seconds * 1000.0 % 1.0 == pytest.approx(0.0, abs=1e-9)
    # Of one picture: its own time, but for what was cut off and the noise of a busy machine.
    assert 0.0 < with_it.cost.cpu_seconds < 10.0 * (without.cost.cpu_seconds + 0.001)


def test_short_waits_are_preloaded_from_any_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The loader splits the list of what is preloaded at blanks, and says on stderr what it does not find."""
    library = tmp_path / "a folder, \u00e9" / povray_process.SHORT_WAITS.name
    library.parent.mkdir()
    library.symlink_to(povray_process.SHORT_WAITS)
    monkeypatch.setattr(povray_process, "SHORT_WAITS", library)
    (tmp_path / "scene.pov").write_text("camera {}\n")
    for folders in (None, "/nowhere:/nor here"):
        if folders:
            monkeypatch.setenv("LD_LIBRARY_PATH", folders)
        printed = povray_process.run(
            povray_process.executable(), ["+Iscene.pov", "-F", "-D", "+W4", "+H3"], tmp_path, 30.0
        )
        assert povray_process.FINE_CLOCK in printed
        assert "cannot be preloaded" not in printed
        assert process.preloading(library)["LD_LIBRARY_PATH"] == ":".join(filter(None, (str(library.parent), folders)))
