"""The POV-Ray renderer's lens and motion: frames through the points of a lens, frames at the times of a shutter."""

from __future__ import annotations

import hashlib
import math
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
import shapely
from povray_scenes import Array, mode, pixel_rays, render, render_all, scene_of
from scipy import integrate

from aliascope import motion, scene_io
from aliascope.geometry import frame_of
from aliascope.model import LoadedMesh, Scene
from aliascope.native import samplers
from aliascope.records import Rendering
from aliascope.renderers import povray
from aliascope.renderers.accumulation import lens_points, shutter_times
from aliascope.renderers.base import lacks
from aliascope.renderers.povray import RENDERER
from aliascope.renderers.povray_frames import Frames, frames_of
from aliascope.renderers.povray_sdl import scene_text

HALF_STEP = 0.5 / 65535.0 + 2.0**-24  # rounding to 16 bits, and of POV-Ray's colours to float32
WHITE = {"white": {"emission": (1, 1, 1)}}
RINGS = {"type": "zone-plate", "scale": 1.7, "origin": (-0.37, 0.53, 0.41)}


# Nothing for scenes that need nothing

SDL = {
    "comb": ("0af9aeb6bbafb7bb", "08c30a2220e49289"),
    "discs": ("5cd59b03869853b2", "4118b61a0a7736f5"),
    "edge": ("c578f4188150144f", "a7012e6c092ef17e"),
    "siemens-star": ("7dd946e60c45808c", "647fc013046248c7"),
    "zone-plate": ("12401ba519f1a345", "f234baeae4b57448"),
}
"""SHA-256 of the text of one frame and of four of halton, as they were before there were lenses and motion."""


@pytest.mark.parametrize("name", list(SDL))
def test_flat_scenes_have_the_text_that_they_had(name: str) -> None:
    scene = scene_io.load(name).scene
    frames = frames_of(mode("accumulate:n=4"), 0, scene)
    texts = (scene_text(scene, scene.view.size), scene_text(scene, scene.view.size, 1.0, frames))
    assert tuple(hashlib.sha256(text.encode()).hexdigest()[:16] for text in texts) == SDL[name]
    assert frames.times is None
    assert frames.lens is None


# The lens


def defocused(surfaces: list[dict[str, Any]], materials: dict[str, Any], **lens: Any) -> Scene:
    camera = {"type": "perspective", "eye": (0.3, 0.2, 4), "look_at": (0.1, 0.1, 0), "vertical_fov_degrees": 40.0}
    return scene_of(surfaces, materials, camera={**camera, **lens}, size=(24, 16))


def aperture(u: Array, radius: float, blades: int) -> Array:
    """Shirley and Chiu 1997 in their own words; for blades, a fan of triangles from the top,
    as tracer.h has it."""
    found = []
    for first, second in u:
        if blades:
            k = int(first * blades)
            ends = [math.pi / 2 - 2 * math.pi * (k + i) / blades for i in (0, 1)]
            f = first * blades - k
            p, q = (np.array([math.cos(end), math.sin(end)]) for end in ends)
            found.append(math.sqrt(second) * ((1 - f) * p + f * q))
            continue
        a, b = 2 * first - 1, 2 * second - 1
        r, angle = (a, math.pi / 4 * b / a) if abs(a) > abs(b) else (b, math.pi / 2 - math.pi / 4 * a / b if b else 0.0)
        found.append(r * np.array([math.cos(angle), math.sin(angle)]))
    return radius * np.array(found)


@pytest.mark.parametrize("blades", [0, 6])
def test_each_frame_looks_through_its_point_of_the_lens(blades: int) -> None:
    """Rings on an oblique plane, whose value along every ray a formula gives. Points without symmetry: a lens that is
    mirrored, or of half the radius, would show."""
    radius, focus = 0.3, 3.1
    scene = defocused(
        [{"type": "plane", "material": "rings", "point": (0, 0, 0.1), "normal": (0.1, 0.2, 1.0)}],
        {"rings": {"emission": (1, 1, 1), "pattern": RINGS}},
        lens_radius=radius,
        focus_distance=focus,
        blades=blades,
    )
    frame, normal, pictures = frame_of(scene), np.array((0.1, 0.2, 1.0)), []
    points = samplers.points("halton", 5, 4)
    for pixel, (lx, ly) in zip(points[:, :2], aperture(points[:, 2:], radius, blades), strict=True):
        eye, directions = pixel_rays(frame, tuple(pixel))
        origins = eye + lx * frame.right + ly * frame.up
        directions = eye + focus * directions - origins
        t = (np.array((0, 0, 0.1)) - origins) @ normal / (directions @ normal)
        away = origins + t[..., None] * directions - np.array((-0.37, 0.53, 0.41))
        pictures.append((1 + np.cos(1.7 * (away**2).sum(-1))) / 2)
    expected = np.mean(pictures, axis=0)
    # 1e-7 and 2^-22 as for the zone plate without a lens (PATTERN_CEILING, and POV-Ray's float32 colours).
    got = render(scene, "accumulate:n=5").pixels[..., 0]
    np.testing.assert_allclose(got, expected, rtol=0, atol=HALF_STEP + 1e-7 + 2.0**-22)


def disc_share(s: Array) -> Array:
    """The share of a unit disc where x < s."""
    s = np.clip(s, -1.0, 1.0)
    return np.asarray(1.0 - (np.arccos(s) - s * np.sqrt(1.0 - s * s)) / np.pi)


def half_plane(depth: float, **lens: Any) -> Scene:
    """White for x > 0 at a depth before a camera at the origin that looks along -z."""
    camera = {"type": "perspective", "eye": (0, 0, 0), "look_at": (0, 0, -1), "vertical_fov_degrees": 40.0}
    points = [(0, -99, -depth), (99, -99, -depth), (99, 99, -depth), (0, 99, -depth)]
    polygon = {"type": "polygon", "material": "white", "points": points}
    return scene_of([polygon], WHITE, camera={**camera, **lens}, size=(24, 4))


def test_a_defocused_half_plane_has_the_edge_of_its_disc() -> None:
    """The circle of confusion is radius |1/depth - 1/focus| on the picture plane at distance 1: 5 pixels here."""
    depth, focus = 8.0, 4.0
    pixel = 2 * math.tan(math.radians(20)) / 4
    radius = 5 * pixel / abs(1 / depth - 1 / focus)
    scene = half_plane(depth, lens_radius=radius, focus_distance=focus)
    edges = np.arange(25) - 12.0
    expected = [integrate.quad(lambda x: float(disc_share(np.array(x / 5))), a, a + 1)[0] for a in edges[:-1]]
    points = samplers.points("lattice", 32, 4)
    beyond = 5 * aperture(points[:, 2:], 1.0, 0)[:, 0]
    sampled = [(edge + points[:, 0] > beyond).mean() for edge in edges[:-1]]
    got = render(scene, "accumulate:n=32,sampler=lattice").pixels[..., 0]
    np.testing.assert_allclose(got, np.tile(sampled, (4, 1)), rtol=0, atol=HALF_STEP)
    # One sample in 32 is 0.031, and these points are off by that (0.0322 at most); a lens of half the radius by 0.1.
    np.testing.assert_allclose(got, np.tile(expected, (4, 1)), rtol=0, atol=0.04)


def test_what_is_in_focus_is_what_a_pinhole_sees() -> None:
    facing = {"type": "plane", "material": "rings", "point": (0.1, 0.1, 0), "normal": (0.2, 0.1, 4)}
    materials = {"rings": {"emission": (1, 1, 1), "pattern": RINGS}}
    focus = float(np.linalg.norm((0.2, 0.1, 4)))
    sharp = defocused([facing], materials)
    lens = defocused([facing], materials, lens_radius=0.5, focus_distance=focus)
    nearer = defocused([facing], materials, lens_radius=0.5, focus_distance=0.8 * focus)
    with ThreadPoolExecutor(3) as pool:
        pictures = list(pool.map(lambda scene: render(scene, "accumulate:n=4").pixels, (sharp, lens, nearer)))
    np.testing.assert_allclose(pictures[1], pictures[0], rtol=0, atol=1.0 / 65535.0)  # each value rounded by half
    assert np.abs(pictures[2] - pictures[0]).max() > 0.1


@pytest.mark.parametrize("blades", [3, 5, 6])
def test_a_lens_of_blades_is_filled_evenly(blades: int) -> None:
    scene = half_plane(8.0, lens_radius=2.0, focus_distance=4.0, blades=blades)
    points = lens_points(scene, samplers.points("sobol", 4096))
    angles = math.pi / 2 + 2 * math.pi * np.arange(blades) / blades
    outline = shapely.Polygon(2.0 * np.column_stack([np.cos(angles), np.sin(angles)]))
    assert shapely.contains_xy(outline.buffer(1e-9), points).all()
    for cut in (shapely.box(-3, 0.3, 3, 3), shapely.box(0.2, -3, 3, 3), shapely.box(-0.5, -0.7, 0.4, 0.6)):
        share = outline.intersection(cut).area / outline.area
        assert abs(shapely.contains_xy(cut, points).mean() - share) < 0.005  # 4096 points: 0.0029 was measured


# POV-Ray's own lens


def edge_profile(rendering: Rendering) -> tuple[float, float]:
    """The mean place of an edge along x, from the middle of the picture, and its standard deviation, in pixels."""
    mean = np.concatenate([[0.0], rendering.pixels[..., 0].astype(np.float64).mean(axis=0), [1.0]])
    steps, places = np.diff(mean), np.arange(len(mean) - 1) - (len(mean) - 2) / 2
    middle = float(steps @ places)
    return middle, math.sqrt(float(steps @ (places - middle) ** 2))


@pytest.fixture(scope="module")
def blurred() -> dict[str, Rendering]:
    """An edge whose circle of confusion has a radius of 8 pixels, and one in focus that leans over 8 pixels."""
    depth, size = 8.0, 64
    pixel = 2 * math.tan(math.radians(20)) / size
    camera = {"type": "perspective", "eye": (0, 0, 0), "look_at": (0, 0, -1), "vertical_fov_degrees": 40.0}
    lean = 8 * pixel * depth * 99 / (2 * math.tan(math.radians(20)) * depth)

    def scene(lean: float, focus: float, flip: bool) -> Scene:
        outline = [(-lean, -99.0), (990.0, -99.0), (990.0, 99.0), (lean, 99.0)]
        points = [(*(p[::-1] if flip else p), -depth) for p in outline]
        polygon = {"type": "polygon", "material": "white", "points": points}
        lens = {"lens_radius": 8 * pixel / (1 / 4.0 - 1 / depth), "focus_distance": focus}
        return scene_of([polygon], WHITE, camera={**camera, **lens}, size=(size, size))

    jobs = {
        "wide": (scene(0.0, 4.0, False), "focal-blur:blur_samples=400,variance=0"),
        "as documented": (scene(0.0, 4.0, False), "focal-blur:blur_samples=400,variance=0,compensation=off"),
        "stopped": (scene(0.0, 4.0, False), "focal-blur:blur_samples=400"),
        "right": (scene(lean, depth, False), "focal-blur:blur_samples=200,variance=0"),
        "up": (scene(lean, depth, True), "focal-blur:blur_samples=200,variance=0"),
        "right, as documented": (scene(lean, depth, False), "focal-blur:blur_samples=200,variance=0,compensation=off"),
        "up, as documented": (scene(lean, depth, True), "focal-blur:blur_samples=200,variance=0,compensation=off"),
    }
    with ThreadPoolExecutor(len(jobs)) as pool:
        return dict(zip(jobs, pool.map(lambda job: render(*job), jobs.values()), strict=True))


def test_the_circle_of_confusion_is_the_lenss_and_half_of_it_without_compensation(
    blurred: dict[str, Rendering],
) -> None:
    """A disc of radius r has a standard deviation of r / 2 along x, and the pixel adds a variance of 1/12."""
    for name, radius in (("wide", 8.0), ("as documented", 4.0)):
        spread = edge_profile(blurred[name])[1]
        # 400 points of the lens, moved alike for all pixels of a column: 1.1 % was measured.
        assert spread == pytest.approx(math.sqrt(radius**2 / 4 + 1 / 12), rel=0.02)


def test_the_picture_is_where_it_belongs_and_a_32nd_off_without_compensation(blurred: dict[str, Rendering]) -> None:
    """The pixels that are filled, over a leaning edge that has all phases: right of it, and above it."""
    off = {}
    for name in ("right", "up"):
        for key in (name, f"{name}, as documented"):
            filled = blurred[key].pixels[..., 0].astype(np.float64).sum(axis=1 if name == "right" else 0)
            off[key] = filled.mean() - 32.0
    # 0.005 at most was measured with either lean; POV-Ray's places within the pixel are a table's, jittered by a hash.
    assert abs(off["right"]) < 0.01
    assert abs(off["up"]) < 0.01
    assert off["right, as documented"] == pytest.approx(-1 / 32, abs=0.01)
    assert off["up, as documented"] == pytest.approx(1 / 32, abs=0.01)


def test_rays_through_the_lens_are_counted_and_stop_where_the_mean_is_sure(blurred: dict[str, Rendering]) -> None:
    assert blurred["wide"].cost.samples_per_pixel == 400.0
    assert 2.0 < blurred["stopped"].cost.samples_per_pixel < 100.0


def test_focal_blur_is_for_round_lenses_in_still_scenes() -> None:
    lens = half_plane(8.0, lens_radius=0.5, focus_distance=4.0)
    assert lacks(RENDERER, lens, mode("focal-blur")) is None
    assert "has none" in (lacks(RENDERER, half_plane(8.0), mode("focal-blur")) or "")
    bladed = half_plane(8.0, lens_radius=0.5, focus_distance=4.0, blades=5)
    assert "5 blades" in (lacks(RENDERER, bladed, mode("focal-blur")) or "")
    moving = lens.model_copy(update={"camera": lens.camera.model_copy(update={"shutter": (0.0, 1.0)})})
    go = {"type": "translate", "by": (1, 0, 0)}
    surfaces = tuple(type(s).model_validate({**s.model_dump(), "motion": go}) for s in lens.surfaces)
    assert "motion" in (lacks(RENDERER, moving.model_copy(update={"surfaces": surfaces}), mode("focal-blur")) or "")


# Motion


def moving_edge(response: str) -> Scene:
    """White for x > t' with t' from -4 to 4 pixels while the shutter is open, which is from 0.25 to 0.75."""
    points = [(-8, -9, 0), (99, -9, 0), (99, 9, 0), (-8, 9, 0)]
    edge = {"type": "polygon", "material": "white", "points": points}
    camera = {"type": "orthographic", "eye": (0, 0, 9), "look_at": (0, 0, 0), "height": 4.0}
    return scene_of(
        [{**edge, "motion": {"type": "translate", "by": (16, 0, 0)}}],
        WHITE,
        camera={**camera, "shutter": (0.25, 0.75), "response": response},
        size=(12, 4),
    )


@pytest.mark.parametrize("response", ["box", "triangle"])
def test_a_translating_edge_is_the_shutters_response(response: str) -> None:
    """A place is white for as long as the edge lies to its left: the integral of the response up to then."""

    def passed(x: float) -> float:
        share = min(max((x + 4) / 8, 0.0), 1.0)
        if response == "box":
            return share
        return 2 * share * share if share < 0.5 else 1 - 2 * (1 - share) ** 2

    expected = [integrate.quad(passed, a, a + 1, points=(0.0,) if a == 0 else None)[0] for a in np.arange(-6.0, 6.0)]
    got = render(moving_edge(response), "accumulate:n=32,sampler=lattice").pixels[..., 0]
    # One sample in 32 is 0.031: numpy counts 0.0313 and 0.0417 with the same points. The responses differ by 0.12.
    np.testing.assert_allclose(got, np.tile(expected, (4, 1)), rtol=0, atol=0.05)


def test_every_kind_of_surface_is_where_its_motion_takes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Frames at two times against the pictures of the scene as it stands then; one mesh stands still."""
    mesh = np.array([[(-3.0, -3.0, 1.0), (-1.0, -3.0, 1.0), (-2.0, -1.5, 1.0)]])
    turn = {"type": "rotate", "axis": (0.1, 0.2, 1.0), "centre": (0.5, 0.5, 0), "degrees": 70.0}
    go = {"type": "translate", "by": (1.5, -2.0, 0.5)}
    bends = {"type": "frames", "files": ("b.ply", "c.ply")}
    corners = [(-5, 1, 0), (-2, 1, 0), (-2, 5, 0), (-5, 4, 0)]
    scene = scene_of(
        [
            {"type": "sphere", "material": "b", "centre": (3, 3, 1), "radius": 1.5, "motion": go},
            {"type": "disc", "material": "c", "centre": (4, -2, 0), "radius": 1.7, "motion": turn},
            {"type": "polygon", "material": "a", "points": corners, "motion": turn},
            {"type": "plane", "material": "d", "point": (0, 0, -3), "normal": (0.1, 0, 1), "motion": go},
        ],
        {
            "a": {"emission": (0.9, 0.2, 0.0)},
            "b": {"emission": (0.0, 0.1, 0.1), "albedo": (0.1, 0.5, 0.2)},
            "c": {"emission": (0.3, 0.0, 1.0)},
            "d": {"albedo": (0.5, 0.5, 0.5), "pattern": {**RINGS, "scale": 0.1}},
        },
        lights=[{"type": "point", "position": (2, 5, 30), "intensity": (99, 99, 99), "falloff": "inverse-square"}],
    )
    shapes = (
        LoadedMesh(material="b", sha256="", triangles=mesh),
        LoadedMesh(material="c", sha256="", triangles=mesh + 2.5, motion=go),
        LoadedMesh(material="a", sha256="", triangles=mesh - 1.5, motion=bends, frames=np.stack([mesh, 1.3 * mesh])),
    )
    camera = scene.camera.model_copy(update={"shutter": (0.0, 1.0)})
    scene = scene.model_copy(update={"surfaces": scene.surfaces + shapes, "camera": camera})
    times, weights = np.array([0.3, 0.9]), np.array([0.25, 0.75])
    frames = Frames(np.zeros((2, 2)), weights, times)
    monkeypatch.setattr(povray, "frames_of", lambda *given: frames if given[0].name != "none" else frames_of(*given))
    first, second = render_all([motion.at(scene, time) for time in times])
    got = render(scene, "accumulate:n=2", least_seconds=0.02)
    assert got.cost.repeats > 1  # a run for the time goes round again: its files are there
    assert np.abs(first.pixels - second.pixels).max() > 0.3
    # Three roundings by half a step, of pictures whose exposure is 1, and 2e-6 of the light's own (see FADE_SHARE).
    expected = 0.25 * first.pixels + 0.75 * second.pixels
    np.testing.assert_allclose(got.pixels, expected, rtol=2e-6, atol=2 * first.quantum)


# What is refused


def test_times_and_lens_have_the_samplers_dimensions_after_the_pixels() -> None:
    both = half_plane(8.0, lens_radius=0.5, focus_distance=4.0)
    both = both.model_copy(
        update={
            "camera": both.camera.model_copy(update={"shutter": (0.5, 1.0)}),
            "surfaces": tuple(
                type(s).model_validate({**s.model_dump(), "motion": {"type": "translate", "by": (1, 0, 0)}})
                for s in both.surfaces
            ),
        }
    )
    frames, points = frames_of(mode("accumulate:n=8"), 0, both), samplers.points("halton", 8, 5)
    assert frames.times is not None
    assert frames.lens is not None
    np.testing.assert_array_equal(frames.shifts, points[:, :2] - 0.5)
    np.testing.assert_allclose(frames.times, 0.5 + 0.5 * points[:, 2], rtol=1e-15)
    np.testing.assert_allclose(frames.lens, aperture(points[:, 3:], 0.5, 0), rtol=0, atol=1e-14)
    np.testing.assert_allclose(shutter_times(moving_edge("triangle"), np.array([0.0, 0.5, 1.0])), [0.25, 0.5, 0.75])


def test_modes_of_one_moment_or_of_a_pinhole_are_empty_cells() -> None:
    lens = half_plane(8.0, lens_radius=0.5, focus_distance=4.0)
    for text in ("none", "am1", "am2", "regular"):
        assert "a lens" in (lacks(RENDERER, lens, mode(text)) or "")
        assert "draw motion" in (lacks(RENDERER, moving_edge("box"), mode(text)) or "")
    for scene in (lens, moving_edge("box")):
        assert lacks(RENDERER, scene, mode("accumulate")) is None
    assert "three dimensions" in (lacks(RENDERER, lens, mode("accumulate:n=16,sampler=cook")) or "")
    assert lacks(RENDERER, moving_edge("box"), mode("accumulate:n=16,sampler=cook")) is None
    assert RENDERER.seeded(mode("accumulate:n=16,sampler=cook"))
    assert "two dimensions" in (lacks(RENDERER, moving_edge("box"), mode("accumulate:n=16,sampler=zaremba")) or "")


def test_what_moves_out_of_povrays_reach_is_an_empty_cell() -> None:
    scene = moving_edge("box")
    away = {"type": "translate", "by": (0, 0, -4e7)}
    surface = type(scene.surfaces[0]).model_validate({**scene.surfaces[0].model_dump(), "motion": away})
    assert "beyond" in (
        lacks(RENDERER, scene.model_copy(update={"surfaces": (surface,)}), mode("accumulate:recentre=0")) or ""
    )


def test_a_checker_that_turns_is_an_empty_cell_and_one_that_slides_is_not() -> None:
    corners = [(-5, 1, 0), (-2, 1, 0), (-2, 5, 0)]
    checker = {"m": {"emission": (1, 1, 1), "pattern": {"type": "checker", "scale": 1.3}}}
    turn = {"type": "rotate", "axis": (0, 0, 1), "degrees": 40.0}
    slide = {"type": "translate", "by": (1, 0, 0)}
    for going, reason in ((turn, "a checker that has turned"), (slide, None)):
        scene = scene_of([{"type": "polygon", "material": "m", "points": corners, "motion": going}], checker)
        camera = scene.camera.model_copy(update={"shutter": (0.0, 1.0)})
        found = lacks(RENDERER, scene.model_copy(update={"camera": camera}), mode("accumulate"))
        assert found is None if reason is None else reason in (found or "")


def test_more_moving_triangles_than_can_be_written_are_an_empty_cell() -> None:
    mesh = LoadedMesh.model_validate(
        {
            "material": "white",
            "sha256": "",
            "triangles": np.tile(np.eye(3), (100_000, 1, 1)),
            "motion": {"type": "translate", "by": (1, 0, 0)},
        }
    )
    scene = moving_edge("box").model_copy(update={"surfaces": (mesh,)})
    assert "moving triangles" in (RENDERER.unable(scene, mode("accumulate:n=64")) or "")
