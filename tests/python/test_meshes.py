"""Mesh files: what is read, and what is refused with file, line and reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from test_scene_io import WHOLE

from aliascope import api, meshes, scene_io
from aliascope.errors import InvalidInput
from aliascope.geometry import surfaces_of

TRIANGLES = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0.5], [0, 1, 0]]], float)
MESH = '\n[[surfaces]]\ntype = "mesh"\nmaterial = "paper"\nfile = "{}"\n'
LINE = WHOLE.count("\n") + 5


def scene_with(folder: Path, name: str) -> scene_io.SceneFile:
    path = folder / "scene.toml"
    path.write_text(WHOLE + MESH.format(name))
    return scene_io.load(str(path))


def written(path: Path, triangles: np.ndarray) -> Path:
    mesh = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=False)
    path.parent.mkdir(exist_ok=True)
    mesh.export(path)
    return path


@pytest.mark.parametrize("ending", [".ply", ".obj", ".stl", ".off", ".glb"])
def test_each_kind_of_file_gives_its_triangles(tmp_path: Path, ending: str) -> None:
    written(tmp_path / "sub" / f"m{ending}", TRIANGLES)
    surfaces = surfaces_of(scene_with(tmp_path, f"sub/m{ending}").scene)
    # The scene's own polygon is the first triangle. Text formats keep 8 digits.
    assert np.abs(surfaces.triangles[1:] - TRIANGLES).max() < 1e-7


def test_the_digest_knows_the_contents_of_the_file(tmp_path: Path) -> None:
    written(tmp_path / "m.ply", TRIANGLES)
    first = scene_with(tmp_path, "m.ply").scene.digest()
    assert scene_with(tmp_path, "m.ply").scene.digest() == first
    written(tmp_path / "m.ply", TRIANGLES + 0.125)
    assert scene_with(tmp_path, "m.ply").scene.digest() != first


def test_a_mesh_is_drawn_as_its_triangles(tmp_path: Path) -> None:
    written(tmp_path / "m.ply", TRIANGLES)
    whole = scene_with(tmp_path, "m.ply")
    polygons = "".join(
        f'\n[[surfaces]]\ntype = "polygon"\nmaterial = "paper"\npoints = {corners.tolist()}\n' for corners in TRIANGLES
    )
    (tmp_path / "other.toml").write_text(WHOLE + polygons)
    other = scene_io.load(str(tmp_path / "other.toml"))
    pictures = [api.render(file, "embree", "uniform:n=16").pixels for file in (whole, other)]
    assert np.array_equal(*pictures)


def complaint(folder: Path, name: str) -> str:
    with pytest.raises(InvalidInput) as caught:
        scene_with(folder, name)
    text = str(caught.value).removeprefix(str(folder) + "/")
    assert text.startswith(f"scene.toml:{LINE}: surfaces.file: ")
    assert text.isprintable()
    return text


def test_missing_empty_and_broken_files(tmp_path: Path) -> None:
    assert "No such file" in complaint(tmp_path, "absent.ply")
    (tmp_path / "empty.ply").write_bytes(b"")
    assert "broken or empty" in complaint(tmp_path, "empty.ply")
    whole = written(tmp_path / "whole.ply", np.tile(TRIANGLES, (50, 1, 1))).read_bytes()
    for size in (5, 100, len(whole) // 2, len(whole) - 3):
        (tmp_path / "cut.ply").write_bytes(whole[:size])
        assert "cut.ply" in complaint(tmp_path, "cut.ply")
    for ending in meshes.ENDINGS:
        (tmp_path / f"noise{ending}").write_bytes(np.random.default_rng(1).bytes(5000))
        assert "noise" in complaint(tmp_path, f"noise{ending}")
    (tmp_path / "points.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    assert "points.obj" in complaint(tmp_path, "points.obj")
    assert "a mesh is one of .obj, .ply" in complaint(tmp_path, "mesh.fbx")


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e38])
def test_corners_that_are_no_places(tmp_path: Path, value: float) -> None:
    triangles = TRIANGLES.copy()
    triangles[1, 2, 0] = value
    written(tmp_path / "m.ply", triangles)
    assert "triangle 1 has a corner that is not finite or beyond 1e30" in complaint(tmp_path, "m.ply")


def test_triangles_without_area(tmp_path: Path) -> None:
    for flat in ([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[1, 2, 3]] * 3):
        written(tmp_path / "m.ply", np.concatenate([TRIANGLES, [flat]]))
        assert "triangle 2 has no area; 1 such in all" in complaint(tmp_path, "m.ply")


def test_tiny_and_huge_meshes_have_area(tmp_path: Path) -> None:
    for scale in (1e-12, 1e12):
        written(tmp_path / "m.ply", TRIANGLES * scale)
        assert len(surfaces_of(scene_with(tmp_path, "m.ply").scene).triangles) == 3


def test_a_path_stays_in_the_scenes_folder(tmp_path: Path) -> None:
    written(tmp_path / "outside.ply", TRIANGLES)
    folder = tmp_path / "inside"
    folder.mkdir()
    (folder / "link.ply").symlink_to(tmp_path / "outside.ply")
    for name in ("../outside.ply", str(tmp_path / "outside.ply"), "link.ply", "sub/../../outside.ply"):
        assert "leads out of the scene's folder" in complaint(folder, name)


def test_too_many_triangles_and_too_large_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path / "m.ply", TRIANGLES)
    monkeypatch.setattr(meshes, "MOST_TRIANGLES", 1)
    assert "has 2 triangles, at most 1 are taken" in complaint(tmp_path, "m.ply")
    monkeypatch.setattr(meshes, "LARGEST_FILE", 10)
    assert "a mesh file has at most" in complaint(tmp_path, "m.ply")
