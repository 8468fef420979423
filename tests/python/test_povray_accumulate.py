"""The POV-Ray renderer's mode `accumulate`: frames whose samples follow a pattern, averaged."""

from __future__ import annotations

import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import fake_povray
import numpy as np
import pytest
from povray_scenes import PLAIN, Array, mode, pixel_rays, render, scene_of

from aliascope.errors import JobFailed, SpecError, Unsupported
from aliascope.geometry import frame_of
from aliascope.model import LARGEST_AREA, LoadedMesh
from aliascope.native import samplers
from aliascope.renderers import povray
from aliascope.renderers.base import Request
from aliascope.renderers.povray import RENDERER
from aliascope.renderers.povray_frames import Frames
from aliascope.renderers.povray_modes import FRAME_SECONDS

HALF_STEP = 0.5 / 65535.0 + 2.0**-24  # rounding to 16 bits, and of POV-Ray's colours to float32

CAMERAS = {
    "perspective": {
        "type": "perspective",
        "eye": (2.1, 1.7, 3.9),
        "look_at": (0.1, 0.2, 0),
        "vertical_fov_degrees": 43.7,
    },
    "orthographic": {"type": "orthographic", "eye": (2.1, 1.7, 3.9), "look_at": (0.1, 0.2, 0), "height": 3.13},
}
COLOURS = np.array([[0.07, 0.06, 0.09], [0.93, 0.91, 0.86]])


def rings(camera: str, size: tuple[int, int] = (24, 16)) -> Any:
    """A zone plate over the whole picture, whose value at each place a formula gives."""
    pattern = {"type": "zone-plate", "scale": 1.7, "origin": (-0.37, 0.53, 0.41), "colours": COLOURS.tolist()}
    return scene_of(
        [{"type": "plane", "material": "rings", "point": (0, 0, 0.1), "normal": (0.1, 0.2, 1.0)}],
        {"rings": {"emission": (1, 1, 1), "pattern": pattern}},
        camera=CAMERAS[camera],
        size=size,
    )


def evaluate(scene: Any, offset: tuple[float, float]) -> Array:
    origins, directions = pixel_rays(frame_of(scene), offset)
    normal = np.array(scene.surfaces[0].normal)
    t = (np.array(scene.surfaces[0].point) - origins) @ normal / (directions @ normal)
    away = origins + t[..., None] * directions - np.array((-0.37, 0.53, 0.41))
    return COLOURS[0] + (COLOURS[1] - COLOURS[0]) * ((1 + np.cos(1.7 * (away**2).sum(-1))) / 2)[..., None]


@pytest.mark.parametrize("camera", list(CAMERAS))
def test_frames_lie_where_the_sampler_says(camera: str) -> None:
    """Three points without symmetry: a shift the wrong way, or of half a pixel, would show."""
    scene = rings(camera)
    expected = np.mean([evaluate(scene, tuple(point)) for point in samplers.points("halton", 3)], axis=0)
    rendering = render(scene, "accumulate:n=3")
    assert np.abs(expected - evaluate(scene, (0.5, 0.5))).max() > 0.01
    # Of three values each is rounded by half a step; 1e-7 and 2^-22: see the zone plate's own test.
    np.testing.assert_allclose(rendering.pixels, expected, rtol=0, atol=HALF_STEP + 1e-7 + 2.0**-22)
    assert rendering.cost.samples == 3 * 24 * 16
    assert rendering.cost.samples_per_pixel == 3.0
    assert dict(rendering.cost.rays) == {"camera": 3 * 24 * 16}
    assert rendering.cost.repeats == 1


def test_weights_are_the_samplers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a quadrature rule: (1/6, 2/3, 1/6) along x."""
    scene, places, weights = rings("perspective"), [0.1, 0.5, 0.9], np.array([1, 4, 1]) / 6
    frames = Frames(np.array([[x - 0.5, 0.0] for x in places]), weights)
    monkeypatch.setattr(povray, "frames_of", lambda *_: frames)
    expected = sum(w * evaluate(scene, (x, 0.5)) for x, w in zip(places, weights, strict=True))
    np.testing.assert_allclose(render(scene, "accumulate:n=3").pixels, expected, rtol=0, atol=HALF_STEP + 4e-7)


@pytest.fixture
def counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A povray that writes a line to the file for each of its runs and goes on as the real one."""
    real = shutil.which("povray")
    assert real, "POV-Ray is not installed"
    folder = fake_povray.install(tmp_path / "bin", f'echo run >> {tmp_path}/runs; exec {real} "$@"')
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    return tmp_path / "runs"


def test_a_regular_pattern_is_the_regular_grid(counted: Path) -> None:
    scene = rings("perspective", (16, 12))
    accumulated = render(scene, "accumulate:n=16,sampler=regular")
    assert counted.read_text() == "run\n"
    # Both average 16 values that were rounded by half a step each, from places that differ by rounding.
    grid = render(scene, "regular:n=16")
    np.testing.assert_allclose(accumulated.pixels, grid.pixels, rtol=0, atol=1.0 / 65535.0)
    assert accumulated.cost.samples == grid.cost.samples
    assert accumulated.quantum == grid.quantum


def test_few_frames_are_timed_again_and_averaged(counted: Path) -> None:
    scene = rings("perspective", (8, 6))
    timed = render(scene, "accumulate:n=2", least_seconds=0.01)
    assert counted.read_text() == "run\n" * 2
    assert timed.cost.repeats > 2
    assert timed.cost.samples == 2 * 48
    expected = np.mean([evaluate(scene, tuple(point)) for point in samplers.points("halton", 2)], axis=0)
    np.testing.assert_allclose(timed.pixels, expected, rtol=0, atol=HALF_STEP + 4e-7)


def test_one_frame_has_its_shift_too() -> None:
    scene = rings("orthographic")
    expected = evaluate(scene, tuple(samplers.points("halton", 1)[0]))  # the corner of the pixel
    np.testing.assert_allclose(render(scene, "accumulate:n=1").pixels, expected, rtol=0, atol=HALF_STEP + 4e-7)


def test_seeds_are_those_of_the_sampler() -> None:
    assert not RENDERER.seeded(mode("accumulate"))
    assert RENDERER.seeded(mode("accumulate:sampler=random"))
    scene = rings("orthographic", (8, 6))
    with ThreadPoolExecutor(3) as pool:
        first, again, other = pool.map(lambda s: render(scene, "accumulate:n=2,sampler=random", seed=s), (1, 1, 2))
    assert np.abs(first.pixels - other.pixels).max() > 1e-3
    np.testing.assert_array_equal(first.pixels, again.pixels)


# What it refuses, and what fails


def test_canonical_modes_and_their_range() -> None:
    assert mode("accumulate:sampler=halton,n=16").text == "accumulate"
    assert mode("accumulate:n=4,sampler=sobol").text == "accumulate:n=4,sampler=sobol"
    for wrong in ("accumulate:n=0", "accumulate:n=4097", "accumulate:sampler=haltn"):
        with pytest.raises(SpecError):
            mode(wrong)


def test_a_count_that_the_sampler_cannot_have_is_an_empty_cell() -> None:
    text = "accumulate:n=5,sampler=regular"
    assert RENDERER.unable(PLAIN, mode(text))
    with pytest.raises(Unsupported):
        render(PLAIN, text)


def test_more_frames_than_the_time_limit_allows_are_refused_before_they_start() -> None:
    assert RENDERER.unable(PLAIN, mode("accumulate:n=4096")) is None  # 41 s
    with pytest.raises(Unsupported, match="at most 300 fit"):
        render(PLAIN, "accumulate:n=512", time_limit=3.0)
    assert Request.time_limit > 4096 * FRAME_SECONDS
    mesh = LoadedMesh(material="white", sha256="", triangles=np.tile(np.eye(3), (100_000, 1, 1)))
    large = PLAIN.model_copy(update={"surfaces": (mesh,)})
    assert "at most 845 fit" in (RENDERER.unable(large, mode("accumulate:n=2048")) or "")  # 0.71 s a frame


def test_more_samples_than_the_largest_canvas_are_refused() -> None:
    with pytest.raises(Unsupported, match=str(LARGEST_AREA)):
        RENDERER.render(Request(PLAIN, 1024, 1024, mode("accumulate:n=100")))


def test_a_missing_frame_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    picture = fake_povray.write_png(tmp_path / "good.png", 8, 8)
    folder = fake_povray.install(tmp_path / "bin", fake_povray.leaving_frames(picture, 12, missing=7))
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    with pytest.raises(JobFailed, match="left no frame07"):
        render(PLAIN, "accumulate:n=12")
    fake_povray.install(tmp_path / "bin", fake_povray.leaving_frames(picture, 13))
    with pytest.raises(JobFailed, match="of 13 pictures instead of 12"):
        render(PLAIN, "accumulate:n=12")
    fake_povray.install(tmp_path / "bin", fake_povray.leaving_frames(picture, 12))
    rendering = render(PLAIN, "accumulate:n=12")
    assert rendering.cost.cpu_seconds == pytest.approx(12 * 0.002)  # what the fake says of each frame
    assert rendering.cost.wall_seconds == pytest.approx(12 * 0.003)
    np.testing.assert_allclose(rendering.pixels, 32768 / 65535, rtol=0, atol=1e-7)


def test_the_statistics_of_many_frames_are_all_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """300 frames that print 3,000 bytes each, as povray's do: more than KEPT_BYTES."""
    picture = fake_povray.write_png(tmp_path / "good.png", 8, 8)
    folder = fake_povray.install(tmp_path / "bin", fake_povray.leaving_frames(picture, 300, padding=2800))
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    assert render(PLAIN, "accumulate:n=300").cost.samples == 300 * 64
