"""Meshes of frames: against the same mesh standing still, against a translation, and against a closed form."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aliascope import motion, scene_io
from aliascope.errors import InvalidInput, Unsupported
from aliascope.model import Frames, LoadedMesh, Scene
from aliascope.native.tracer import Tracer
from aliascope.renderers import base, embree, mode_of, povray

Array = NDArray[np.float64]

SIZE = (24, 16)
GOING = Frames(type="frames", files=("later.ply",))  # of the names nothing depends on
MATERIALS = {
    "white": {"emission": (1.0, 1.0, 1.0)},
    "matt": {"emission": (0.05, 0.1, 0.15), "albedo": (0.9, 0.8, 0.7)},
    "rings": {
        "emission": (0.2, 0.1, 0.0),
        "albedo": (0.7, 0.8, 0.9),
        "pattern": {"type": "zone-plate", "scale": 0.019, "origin": (5.1, 6.2, 0.3)},
    },
    "tiles": {"emission": (0.6, 0.7, 0.8), "pattern": {"type": "checker", "scale": 0.41, "origin": (0.1, 0.2, 0.3)}},
}


def mesh_of(triangles: Array, frames: Array | None, material: str = "matt", going: Any = GOING) -> LoadedMesh:
    return LoadedMesh(material=material, sha256="", triangles=triangles, motion=going, frames=frames)


def scene_of(meshes: list[LoadedMesh], shutter: tuple[float, float] = (0.13, 0.91), lit: bool = True) -> Scene:
    """Seen along -z, one unit a pixel, y up from the lower border, before a wall that stands still."""
    middle = (SIZE[0] / 2, SIZE[1] / 2)
    scene = Scene.model_validate(
        {
            "title": "t",
            "shows": "s",
            "view": {"size": SIZE},
            "camera": {
                "type": "orthographic",
                "eye": (*middle, 50.0),
                "look_at": (*middle, 0.0),
                "height": float(SIZE[1]),
                "shutter": shutter,
            },
            "materials": MATERIALS,
            "surfaces": [{"type": "plane", "material": "matt", "point": (0, 0, -9), "normal": (0.1, 0.2, 1)}] * lit,
            "lights": [{"type": "directional", "direction": (0.4, -0.5, -1.0), "intensity": (1, 1, 1)}] * lit,
        }
    )
    return scene.model_copy(update={"surfaces": (*scene.surfaces, *meshes)})


def crumpled(count: int) -> tuple[Array, Array]:
    """40 triangles in the view that face all ways, and their frames, each of another shape."""
    random = np.random.default_rng(3)
    centres = random.uniform((2.0, 2.0, -3.0), (22.0, 14.0, 6.0), (40, 3))
    shape = random.normal(0.0, 2.0, (40, 3, 3)) + centres[:, np.newaxis]
    return shape, shape + np.cumsum(random.normal(0.0, 1.1, (count, 40, 3, 3)), axis=0)


def drawn(scene: Scene, samples: int = 64, seed: int = 3) -> Array:
    built = Tracer(scene, SIZE)
    assert built.dimensions == scene.needs().dimensions
    return built.render("sobol:scramble=owen", samples, seed)[0].astype(np.float64)


@pytest.mark.parametrize("count", [1, 2, 7])
@pytest.mark.parametrize("shutter", [(0.13, 0.91), (0.0, 1.0), (0.5, 6 / 7)])
def test_frames_of_a_translation_are_the_translation(count: int, shutter: tuple[float, float]) -> None:
    """With patterns, light and shadow; the bounds of the shutter lie on frames, between them, within a single one."""
    by = np.array([3.7, -2.9, 4.1])
    shape, _ = crumpled(1)
    times = np.arange(1, count + 1)[:, np.newaxis, np.newaxis, np.newaxis] / count
    going = [mesh_of(shape[i::3], shape[i::3] + times * by, name) for i, name in enumerate(("matt", "rings", "tiles"))]
    straight = [
        mesh.model_copy(update={"motion": motion.Translate(type="translate", by=tuple(by)), "frames": None})
        for mesh in going
    ]
    seen, wanted = (drawn(scene_of(meshes, shutter)) for meshes in (going, straight))
    assert wanted.std() > 0.15
    assert (
        np.abs(
            seen - drawn(scene_of([mesh.model_copy(update={"motion": None, "frames": None}) for mesh in going]))
        ).max()
        > 0.3
    )
    # All corners are those of the translation to float's rounding, so here and there a sample at an edge differs.
    assert np.abs(seen - wanted).max() <= 2.0 / 64.0
    assert np.mean(np.abs(seen - wanted)) < 2e-5


@pytest.mark.parametrize("count", [1, 3, 8])
def test_a_moment_is_the_still_picture(count: int) -> None:
    shape, later = crumpled(count)
    for time in (0.0, 0.37, 0.75, 1.0 - 1e-9):
        scene = scene_of([mesh_of(shape, later)], (time, time + 1e-9))
        seen, still = drawn(scene), drawn(motion.at(scene, time))
        assert np.abs(seen - still).max() <= 2.0 / 64.0
        assert np.mean(np.abs(seen - still)) < 1e-4


def test_a_moment_across_a_frame_is_the_still_picture() -> None:
    """The shortest that is drawn. Corners go by up to 5e-4 pixels in it: of 64 samples in a pixel few see that."""
    shape, later = crumpled(4)
    half = 0.5 / 1024.0 / 4.0 * (1.0 + 1e-9)
    scene = scene_of([mesh_of(shape, later)], (0.5 - half, 0.5 + half))
    seen, still = drawn(scene), drawn(motion.at(scene, 0.5))
    assert np.abs(seen - still).max() <= 2.0 / 64.0
    assert np.mean(np.abs(seen - still)) < 2e-4
    with pytest.raises(Unsupported, match="across a frame of a mesh"):
        drawn(scene_of([mesh_of(shape, later)], (0.5 - 0.99 * half, 0.5 + 0.99 * half)))


@pytest.mark.parametrize("count", [2, 5])
def test_the_picture_is_the_mean_of_still_pictures(count: int) -> None:
    shape, later = crumpled(count)
    scene = scene_of([mesh_of(shape, later)])
    seen = np.mean([drawn(scene, 256, seed) for seed in range(4)], axis=0)
    times = 0.13 + (0.91 - 0.13) * (np.arange(160) + 0.5) / 160
    still = np.mean([drawn(motion.at(scene, time), 8, seed) for seed, time in enumerate(times)], axis=0)
    assert seen.std() > 0.05
    assert np.sqrt(np.mean((seen - still) ** 2)) < 0.006  # measured: 0.0025 and 0.0031
    assert np.abs((seen - still).mean(axis=(0, 1))).max() < 1e-3


@pytest.mark.parametrize("shutter", [(0.0, 1.0), (0.1, 0.2), (0.21, 0.83), (0.25, 0.75)])
def test_an_edge_goes_from_frame_to_frame(shutter: tuple[float, float]) -> None:
    """A white sheet whose right edge is at 4, 15, 7, 20 and 3.5: each column's mean is the time that it covers it."""
    places = np.array([4.0, 15.0, 7.0, 20.0, 3.5])
    sheets = np.array(
        [
            [
                [(-90.0, -90.0, 0.0), (x, -90.0, 0.0), (x, 90.0, 0.0)],
                [(-90.0, -90.0, 0.0), (x, 90.0, 0.0), (-90, 90, 0)],
            ]
            for x in places
        ]
    )
    seen = drawn(scene_of([mesh_of(sheets[0], sheets[1:], "white")], shutter, lit=False), 1024)[:, :, 0]
    times = shutter[0] + (shutter[1] - shutter[0]) * (np.arange(200_000) + 0.5) / 200_000
    edge = np.interp(times, np.linspace(0.0, 1.0, 5), places)
    wanted = [np.clip(edge - column, 0.0, 1.0).mean() for column in range(SIZE[0])]
    assert np.abs(seen.mean(axis=0) - wanted).max() < 2e-3  # 16 rows of 1,024 samples: 1e-3 were measured


def test_meshes_with_the_same_frames_keep_their_own_triangles() -> None:
    """Their motion is one, as it names the same files; their order and that of what stands still are the scene's."""
    shape, later = crumpled(3)
    still = mesh_of(shape[30:], None, "tiles", None)
    scene = scene_of([mesh_of(shape[:13], later[:, :13]), still, mesh_of(shape[13:30], later[:, 13:30], "white")])
    others = (Frames(type="frames", files=(name,)) for name in "ab")
    apart = scene_of(
        [
            mesh_of(shape[:13], later[:, :13], going=next(others)),
            still,
            mesh_of(shape[13:30], later[:, 13:30], "white", next(others)),
        ]
    )
    assert np.mean(np.abs(drawn(scene) - drawn(apart))) < 1e-5  # Embree's structures differ, and with them roundings


def test_threads_change_no_bit() -> None:
    shape, later = crumpled(3)
    built = Tracer(scene_of([mesh_of(shape, later, "rings")]), (37, 27))
    one, three = (built.render("sobol:scramble=owen", 21, 4, threads)[0] for threads in (1, 3))
    assert np.array_equal(one, three)


PLY = """\
ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 {height} 0
3 0 1 2
"""
SCENE = """\
title = "t"
shows = "s"

[view]
size = [8, 6]

[camera]
type = "orthographic"
eye = [0.0, 0.0, 4.0]
look_at = [0.0, 0.0, 0.0]
height = 2.0
shutter = SHUTTER

[materials.paper]
emission = [1.0, 1.0, 1.0]
pattern = { type = "zone-plate", scale = 3.0 }

[[surfaces]]
type = "mesh"
material = "paper"
file = "a.ply"
motion = { type = "frames", files = ["b.ply"] }
"""


def loaded(folder: Path, shutter: str) -> Scene:
    for name, height in (("a", 1), ("b", 2)):
        (folder / f"{name}.ply").write_text(PLY.format(height=height))
    (folder / "scene.toml").write_text(SCENE.replace("SHUTTER", shutter))
    return scene_io.load_file(folder / "scene.toml").scene


def test_a_pattern_is_stretched_with_its_triangles(tmp_path: Path) -> None:
    """A height of 1 + t: at the end of time what was at height y is at 2 y."""
    scene = loaded(tmp_path, "[0.999999999, 1.0]")
    size = (64, 48)
    picture = Tracer(scene, size).render("regular", 1)[0][:, :, 0]
    x = (np.arange(64) + 0.5) / 64 * 8 / 3 - 4 / 3
    y = 1.0 - (np.arange(48) + 0.5) / 24
    x, y = np.meshgrid(x, y)
    inside = (x > 0) & (y > 0) & (x + y / 2 < 1)
    wanted = np.where(inside, (1 + np.cos(3.0 * (x**2 + (y / 2) ** 2))) / 2, 0.0)
    assert wanted[inside].std() > 0.2
    assert np.abs(picture - wanted).max() < 1e-6


def test_a_stretched_pattern_has_no_still(tmp_path: Path) -> None:
    assert loaded(tmp_path, "[0.0, 0.0]").surfaces[0].motion is None
    with pytest.raises(InvalidInput, match=r"scene\.toml:12: camera\.shutter: a pattern on a mesh"):
        loaded(tmp_path, "[0.5, 0.5]")
    scene = loaded(tmp_path, "[0.0, 0.5]")
    assert "mesh of frames" in scene.features()
    assert base.lacks(embree.RENDERER, scene, mode_of(embree.RENDERER, "uniform")) is None
    reason = base.lacks(povray.RENDERER, scene, mode_of(povray.RENDERER, "accumulate"))
    assert reason is not None
    assert "a pattern on a mesh that has changed its shape" in reason
