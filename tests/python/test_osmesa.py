"""The OSMesa renderer: its modes, that its pictures are of the scene, and what it refuses."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aliascope.errors import JobFailed, NotAvailable, SpecError, Unsupported
from aliascope.geometry import frame_of
from aliascope.model import Scene
from aliascope.native import raster, samplers
from aliascope.records import Rendering
from aliascope.renderers.base import Request, lacks
from aliascope.renderers.osmesa import RENDERER, passes_of
from aliascope.specs import Spec, parse

Array = NDArray[np.float64]


WHITE = {"white": {"emission": (1.0, 1.0, 1.0)}}


def mode(text: str) -> Spec:
    return parse(text, RENDERER.modes, "mode of osmesa")


def scene_of(surfaces: list[dict[str, Any]], materials: dict[str, Any] = WHITE, **changed: Any) -> Scene:
    """An orthographic scene of 16 x 12 pixels in which a unit is a pixel and (0, 0) the middle of the picture."""
    camera = {"type": "orthographic", "eye": (0, 0, 10), "look_at": (0, 0, 0), "height": 12.0}
    return Scene.model_validate(
        {
            "title": "t",
            "shows": "s",
            "view": {"size": (16, 12), "background": changed.get("background", (0.0, 0.0, 0.0))},
            "camera": changed.get("camera", camera),
            "materials": materials,
            "surfaces": [{"material": "white"} | surface for surface in surfaces],
        }
    )


def render(scene: Scene, text: str, **changed: Any) -> Rendering:
    return RENDERER.render(Request(scene, *scene.view.size, mode(text), **changed))


def disc(x: float, y: float, radius: float, **more: Any) -> dict[str, Any]:
    return {"type": "disc", "centre": (x, y, 0.0), "radius": radius} | more


# The modes


def test_modes_have_one_canonical_form() -> None:
    assert mode("none").text == "none"
    assert mode("msaa:n=4").text == "msaa"
    assert mode("msaa:n=8").text == "msaa:n=8"
    assert mode("msaa:sample-shading=0").text == "msaa"
    assert mode("msaa:sample-shading=1,n=8").text == "msaa:n=8,sample-shading=1"
    assert mode("accumulate:sampler=halton,n=16").text == "accumulate"
    scrambled = mode("accumulate:sampler=sobol,sampler.scramble=owen,n=4")
    assert scrambled.text == "accumulate:n=4,sampler=sobol,sampler.scramble=owen"
    for wrong in (
        "msaa:samples=4",
        "msaa:sample-shading=2",
        "none:sample-shading=1",
        "smaa",
        "accumulate:n=0",
        "accumulate:n=65537",
        "accumulate:sampler=haltn",
    ):
        with pytest.raises(SpecError):
            mode(wrong)


@pytest.mark.parametrize("n", [1, 2, 3, 5, 16])
def test_other_counts_of_multisamples_are_refused_with_the_reason(n: int) -> None:
    scene = scene_of([])
    assert "GL_MAX_SAMPLES of llvmpipe is 4" in str(lacks(RENDERER, scene, mode(f"msaa:n={n}")))
    with pytest.raises(Unsupported, match="GL_MAX_SAMPLES"):
        render(scene, f"msaa:n={n}")
    assert lacks(RENDERER, scene, mode("msaa:n=8")) is None


def test_a_count_that_the_pattern_cannot_have_is_an_empty_cell() -> None:
    scene = scene_of([])
    assert lacks(RENDERER, scene, mode("accumulate:n=5,sampler=regular"))
    assert lacks(RENDERER, scene, mode("accumulate:n=9,sampler=regular")) is None
    with pytest.raises(Unsupported):
        render(scene, "accumulate:n=5,sampler=regular")


def test_what_is_not_drawn_is_named() -> None:
    mirror = scene_of([disc(0, 0, 1)], {"white": {"reflection": (0.5, 0.5, 0.5)}})
    for text in ("none", "accumulate"):
        assert lacks(RENDERER, mirror, mode(text)) == "OSMesa here does not draw: mirror"


def test_only_a_randomised_accumulation_depends_on_the_seed() -> None:
    scene = scene_of([disc(0.3, 0.2, 3.37)])
    for text, seeded in (
        ("none", False),
        ("msaa:n=8", False),
        ("accumulate", False),
        ("accumulate:sampler=random", True),
    ):
        assert RENDERER.seeded(mode(text)) is seeded
        pictures = [render(scene, text, seed=seed).pixels for seed in (1, 2)]
        assert np.array_equal(pictures[0], pictures[1]) is not seeded
        assert np.array_equal(pictures[0], render(scene, text, seed=1).pixels)


def test_versions_name_the_driver() -> None:
    versions = RENDERER.versions()
    assert set(versions) == {"osmesa", "osmesa-driver"}
    assert "Mesa" in versions["osmesa"]
    render(scene_of([]), "none")
    assert os.environ["LP_NUM_THREADS"] == "0"


def test_a_library_that_does_not_load_is_said_to_be_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str, needs: str) -> None:
        raise NotAvailable(f"{needs} cannot be loaded")

    for loading in ("said", "module"):
        monkeypatch.setattr(raster, loading, missing)
    with pytest.raises(NotAvailable, match="libosmesa6"):
        RENDERER.versions()
    with pytest.raises(NotAvailable, match="libosmesa6"):
        render(scene_of([]), "none")


# Where samples lie


def seen_at(text: str, points: Array) -> Array:
    """The part of a pixel that each of these places in it, (n, 2), has: the picture of a small disc there, alone."""
    found = []
    for x, y in points:
        pixels = render(scene_of([disc(5 + x - 8, 6 - (7 + y), 0.02)]), text).pixels[..., 0]
        # Passes that are moved may look a little beyond the pixel.
        found.append(pixels.sum(dtype=np.float64))
    return np.array(found)


def test_none_samples_the_centre() -> None:
    np.testing.assert_array_equal(seen_at("none", np.array([[0.5, 0.5], [0.47, 0.5], [0.5, 0.53]])), [1.0, 0.0, 0.0])


def test_the_multisample_patterns_are_where_they_are_said_to_be() -> None:
    four = raster.sample_positions()
    np.testing.assert_array_equal(four, [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]])
    np.testing.assert_array_equal(seen_at("msaa", four), 0.25)
    passes = passes_of(mode("msaa:n=8"), scene_of([]))
    assert passes.samples_per_pass == 4
    eight = (four + passes.offsets[:, np.newaxis] - 0.5).reshape(8, 2)
    assert len({tuple(position) for position in eight}) == 8
    for axis in range(2):  # a row and a column for each: the sixteenths that are odd
        assert sorted(eight[:, axis] * 16 % 16) == [1, 3, 5, 7, 9, 11, 13, 15]
    np.testing.assert_array_equal(seen_at("msaa:n=8", eight), 0.125)
    assert np.all(np.abs(eight - 0.5) <= 0.5 + 1 / 16)


def test_an_accumulation_samples_where_its_pattern_says() -> None:
    text = "accumulate:n=4,sampler=halton"
    points = passes_of(mode(text), scene_of([])).offsets
    np.testing.assert_allclose(points[:, 0], [0, 1 / 2, 1 / 4, 3 / 4], rtol=0, atol=1e-15)
    np.testing.assert_array_equal(seen_at(text, points), 0.25)


def test_the_weights_of_a_quadrature_rule_are_used(monkeypatch: pytest.MonkeyPatch) -> None:
    weights = np.array([0.5, 0.25, -0.125, 0.375])
    monkeypatch.setattr(samplers, "weights", lambda *_: weights)
    text = "accumulate:n=4"
    # Exact: they are sums of few powers of two.
    np.testing.assert_array_equal(seen_at(text, passes_of(mode(text), scene_of([])).offsets), weights)


# The pictures


def test_up_is_up_right_is_right_and_values_are_linear() -> None:
    places = {"red": (-4.5, 3.5), "green": (2.5, 4.5), "blue": (-1.5, -5.5)}
    values = {"red": (0.9, 0.1, 0.0), "green": (0.0, 7.0, 0.3), "blue": (0.2, 0.0, 0.7)}
    scene = scene_of(
        [disc(x, y, 0.4, material=name) for name, (x, y) in places.items()],
        {name: {"emission": value} for name, value in values.items()},
        background=(0.05, 0.06, 0.07),
    )
    expected = np.full((12, 16, 3), scene.view.background)
    expected[2, 3], expected[1, 10], expected[11, 6] = values["red"], values["green"], values["blue"]
    rendering = render(scene, "none")
    assert rendering.pixels.dtype == np.float32
    assert rendering.quantum == 0.0
    np.testing.assert_array_equal(rendering.pixels, expected.astype(np.float32))


@pytest.mark.parametrize("along", [0, 1])
@pytest.mark.parametrize("text", ["accumulate:n=256", "accumulate:n=256,sampler=sobol", "msaa", "msaa:n=8"])
def test_an_edge_of_one_in_eight_is_where_it_is(along: int, text: str) -> None:
    """Over 16 phases. `along` 0: the edge runs along x and falls by 1 in 8; 1: along y."""
    errors = []
    for phase in range(16):
        at = 0.3137 + phase / 16  # below the middle, or right of it
        corners = [(-9.0, at - 9 / 8), (9.0, at + 9 / 8), (9.0, 40.0), (-9.0, 40.0)]
        points = [(x, -y, 0.0) if along == 0 else (y, x, 0.0) for x, y in corners]
        pixels = render(scene_of([{"type": "polygon", "points": points}]), text).pixels[..., 0]
        covered, across = pixels.sum(dtype=np.float64), (16, 12)[along]
        errors.append((12, 16)[along] / 2 - covered / across - at)
    # The bias of raster.c, .0014 at most, and the pattern's own: the mean of Halton's 256 points lies up to .007 from
    # the middle of the pixel, Sobol's .002 in x and in y. A hundredth of a pixel holds both.
    assert abs(np.mean(errors)) < 0.01


def test_a_zone_plate_follows_its_formula_at_the_pixel_centres() -> None:
    low, high, origin, scale = (0.07, 0.06, 0.09), (0.93, 0.91, 0.86), (-0.31, -0.16, 0.2), 98.43
    pattern = {"type": "zone-plate", "scale": scale, "origin": origin, "colours": (low, high)}
    size = 400.0
    floor = [(-size, -1.0, -size), (size, -1.0, -size), (size, -1.0, size), (-size, -1.0, size)]
    scene = scene_of(
        [{"type": "polygon", "points": floor}],
        {"white": {"emission": (1.0, 0.9, 0.8), "pattern": pattern}},
        camera={"type": "perspective", "eye": (0.2, 1, 2), "look_at": (0, -1, 0), "vertical_fov_degrees": 40.0},
    )
    frame = frame_of(scene)
    x, y = np.meshgrid(np.arange(16) + 0.5, np.arange(12) + 0.5)
    u, v = (2 * x / 16 - 1) * frame.half_width, (1 - 2 * y / 12) * frame.half_height
    direction = frame.forward + u[..., None] * frame.right + v[..., None] * frame.up
    point = frame.eye + (-2.0 / direction[..., 1])[..., None] * direction
    wave = (1 + np.cos(scale * ((point - origin) ** 2).sum(axis=-1))) / 2
    expected = np.array((1.0, 0.9, 0.8)) * (np.array(low) + (np.array(high) - np.array(low)) * wave[..., None])
    for text in ("none", "msaa"):  # multisampling evaluates it once a pixel, at the centre
        # Rounding of a few float operations on numbers up to 1, and of the driver's cosine.
        np.testing.assert_allclose(render(scene, text).pixels, expected, rtol=0, atol=1e-6)


def test_a_disc_of_a_quarter_pixel_has_its_area() -> None:
    scene = scene_of([disc(-2.683, 1.169, 0.25)])
    covered = render(scene, "accumulate:n=4096").pixels[..., 0].sum(dtype=np.float64)
    # Halton misses a convex area by about N^-3/4 of its perimeter: 1.57 x .002; 2.5 times that.
    assert abs(covered - np.pi / 16) < 0.008


# Cost


@pytest.mark.parametrize(("text", "count"), [("none", 1), ("msaa", 4), ("msaa:n=8", 8), ("accumulate:n=37", 37)])
def test_cost_counts_all_samples(text: str, count: int) -> None:
    cost = render(scene_of([disc(0, 0, 3)]), text).cost
    assert cost.samples == count * 16 * 12
    assert cost.samples_per_pixel == count
    assert cost.repeats == 1
    assert cost.rays == {}
    assert cost.cpu_seconds > 0
    assert cost.wall_seconds > 0


def test_rendering_repeats_for_a_steady_figure() -> None:
    scene = scene_of([disc(0, 0, 3)])
    cost = render(scene, "none", least_seconds=0.05).cost
    assert cost.repeats > 1
    assert cost.cpu_seconds * cost.repeats >= 0.05
    # One picture of so few pixels takes a small part of that.
    assert cost.cpu_seconds < 0.025


def test_a_job_past_its_time_limit_fails() -> None:
    with pytest.raises(JobFailed, match="more than"):
        render(scene_of([disc(0, 0, 3)]), "none", least_seconds=100.0, time_limit=0.2)


def test_size_and_aspect_follow_the_request() -> None:
    scene = scene_of([disc(0, 0, 1.01)])
    rendering = RENDERER.render(Request(scene, 40, 24, mode("none")))
    assert rendering.pixels.shape == (24, 40, 3)
    # Twice as many pixels a unit: a disc of radius 2.02 pixels about a corner of four holds 12 centres.
    assert rendering.pixels[..., 0].sum() == 12
