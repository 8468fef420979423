"""The limits of readers, each at its edge: what is just allowed is read, and what is just past it is refused."""

from __future__ import annotations

import os
from pathlib import Path

import gltf_files
import numpy as np
import pytest
from test_scene_io import WHOLE

from aliascope import bounded, meshes, model, scene_io, toml_files
from aliascope.errors import InvalidInput

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
MESH = '\n[[surfaces]]\ntype = "mesh"\nmaterial = "paper"\nfile = "{}"\n'


def scene_with(folder: Path, *names: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(WHOLE + "".join(map(MESH.format, names)))
    return path


def refused(path: Path, match: str) -> str:
    with pytest.raises(InvalidInput, match=match) as caught:
        scene_io.load_file(path)
    return str(caught.value)


# --- files ------------------------------------------------------------------------------------------------------------


def test_a_file_is_read_to_its_limit_and_not_beyond(tmp_path: Path) -> None:
    path = tmp_path / "f"
    path.write_bytes(bytes(3 << 20))
    assert len(bounded.read_bytes(path, 3 << 20, "mesh")) == 3 << 20
    with pytest.raises(InvalidInput, match="a mesh file has at most 2 MiB"):
        bounded.read_bytes(path, (3 << 20) - 1, "mesh")


def test_a_file_that_grows_while_it_is_read_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def endless(_: int, count: int) -> bytes:
        asked.append(min(count, 40))
        assert sum(asked) <= 101
        return bytes(asked[-1])

    (tmp_path / "f").touch()
    with monkeypatch.context() as patched:
        patched.setattr(os, "read", endless)
        with pytest.raises(InvalidInput, match="has at most"):
            bounded.read_bytes(tmp_path / "f", 100, "mesh")
    assert asked == [40, 40, 21]


def test_what_is_no_file_is_told_apart(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="it is a folder"):
        bounded.read_bytes(tmp_path, 100, "mesh")
    with pytest.raises(InvalidInput, match="a name has no NUL byte"):
        bounded.read_bytes(tmp_path / "a\0b", 100, "mesh")


def test_each_mark_that_steers_is_known() -> None:
    """Control characters, separators of lines and paragraphs, and the marks that turn the direction of writing."""
    marks = "\0\x07\x1b\x7f\x85\x9b\u2028\u2029\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069\ud800"
    for mark in marks:
        assert bounded.steers(f"a{mark}b"), ascii(mark)
        assert bounded.as_shown(f"a{mark}b") == f"a{ascii(mark)[1:-1]}b"


# What a unit takes at the least in memory: of triangles their corners in double, read and placed, and of bytes a copy.
HELD = {
    "toml": (toml_files.LARGEST_FILE, 2),
    "mesh file": (meshes.LARGEST_FILE, 2),
    "mesh files": (meshes.LARGEST_FILES, 1),
    "triangles of a mesh": (meshes.MOST_TRIANGLES, 144),
    "triangles of a scene": (meshes.MOST_OF_A_SCENE, 72),
}


@pytest.mark.parametrize("what", HELD)
def test_what_is_let_through_fits_into_memory(what: str) -> None:
    most, size = HELD[what]
    assert most * size <= 2 << 30


# --- TOML -------------------------------------------------------------------------------------------------------------


def test_the_largest_toml_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = scene_with(tmp_path)
    monkeypatch.setattr(toml_files, "LARGEST_FILE", len(WHOLE))
    scene_io.load_file(path)
    monkeypatch.setattr(toml_files, "LARGEST_FILE", len(WHOLE) - 1)
    refused(path, "a scene file has at most 0 MiB")


def test_the_parts_of_a_key_are_counted(tmp_path: Path) -> None:
    """Dots in texts and comments part nothing, whatever the ends of lines."""
    path = tmp_path / "f.toml"
    dots = ".".join("a" * 40)
    taken = [f"{'a.' * 31}a = 1", f"x = '{dots}' # {dots}", f'x = "{dots}\\"{dots}"', f"'{dots}' = 1", f"# {dots}"]
    taken += [f"x = [1, # {dots}\n'{dots}']", f"""x = '''\n{dots}'{dots}'''""", f'x = """\n"{dots}\\"""{dots}"""']
    for text in taken:
        for end in ("\n", "\r\n"):
            path.write_bytes(f"{text}\n".replace("\n", end).encode())
            toml_files.read(path, "scene")
    for text in (
        f"{'a.' * 32}a = 1",
        f"[{'a.' * 32}a]",
        f"x = {{ {'a.' * 32}a = 1 }}",
        f"x = '' # '\n{'a.' * 32}a = 1",
    ):
        path.write_text(f"{text}\n")
        with pytest.raises(InvalidInput, match="a key has at most 32 parts"):
            toml_files.read(path, "scene")


LONG = "x" * 3000
TOLD = {
    "type": ('type = "disc"', f'type = "{LONG}"'),
    "key": ('type = "disc"', f'type = "disc"\n{LONG} = 1'),
    "value": ("centre = [0.1, 0.2, 0.0]", f'centre = [0.1, 0.2, "{LONG}"]'),
    "number": ("radius = 0.5", f"radius = -{'9' * 290}"),
    "beyond all doubles": ("radius = 0.5", f"radius = -0x{'f' * 3000}"),
    "whole number": ("size = [8, 6]", f"size = [{'9' * 30}, 6]"),
    "table": ("emission = [1.0, 1.0, 1.0]", f"[materials.{LONG[:900]}]\nemission = 3"),
    "twice": ('title = "t"', f"{LONG} = 1\n{LONG} = 2"),
    "again": ("[view]", f"[{LONG}]\n[{LONG}]\n[view]"),
}


@pytest.mark.parametrize("what", TOLD)
def test_what_is_wrong_is_told_in_short(tmp_path: Path, what: str) -> None:
    old, new = TOLD[what]
    path = tmp_path / "scene.toml"
    path.write_text(WHOLE.replace(old, new, 1))
    assert len(refused(path, f"{path}")) < 450 + len(str(path))


# --- scenes -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["..toml", "...toml", "."])
def test_a_scene_is_not_named_as_its_own_folder_or_the_one_above(tmp_path: Path, name: str) -> None:
    path = tmp_path / name if name != "." else Path(name)
    refused(path, "a scene is named as its file")


def test_what_the_meshes_of_a_scene_have_is_added_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.obj").write_text(OBJ)
    (tmp_path / "b.obj").write_text(OBJ)
    path = scene_with(tmp_path, "a.obj", "b.obj", "a.obj")
    monkeypatch.setattr(meshes, "MOST_OF_A_SCENE", 3)
    monkeypatch.setattr(meshes, "LARGEST_FILES", 2 * len(OBJ))
    scene_io.load_file(path)
    monkeypatch.setattr(meshes, "LARGEST_FILES", 2 * len(OBJ) - 1)
    refused(path, "have at most 0 MiB together")
    monkeypatch.setattr(meshes, "LARGEST_FILES", 2 * len(OBJ))
    monkeypatch.setattr(meshes, "MOST_OF_A_SCENE", 2)
    refused(path, "have at most 2 triangles")


def test_a_file_of_many_surfaces_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.obj").write_text(OBJ)
    seen: list[Path] = []
    load = meshes.load

    def counted(path: Path) -> object:
        seen.append(path)
        return load(path)

    monkeypatch.setattr(meshes, "load", counted)
    scene_io.load_file(scene_with(tmp_path, *["a.obj"] * 5))
    assert seen == [tmp_path / "a.obj"]


def test_the_squares_of_polygons_are_taken_to_their_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = scene_with(tmp_path)
    monkeypatch.setattr(model, "MOST_SQUARES", 9)
    scene_io.load_file(path)
    monkeypatch.setattr(model, "MOST_SQUARES", 8)
    refused(path, "add up to more than 8")


FRAMES = 'motion = { type = "frames", files = ["b.obj"] }\n'
SHUTTER = WHOLE.replace("[camera]", "[camera]\nshutter = [0.0, 1.0]")


def test_frames_are_of_a_mesh_and_of_one_number_of_triangles(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(OBJ)
    (tmp_path / "b.obj").write_text(OBJ + "f 3 2 1\n")
    path = tmp_path / "scene.toml"
    path.write_text(SHUTTER + MESH.format("a.obj") + FRAMES)
    refused(path, r'surfaces.motion: "b.obj" has 2 triangles and "a.obj" 1')
    path.write_text(SHUTTER + FRAMES)
    refused(path, 'surfaces.motion: only a mesh has "frames"')


def test_an_unknown_material_is_named_in_short(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(WHOLE + MESH.format("a.obj").replace('"paper"', f'"{"p" * 900}"'))
    assert len(refused(path, "unknown material")) < 400 + len(str(path))


def test_how_far_a_polygon_may_leave_its_plane(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    for height, taken in (("1e-10", True), ("1e-8", False)):
        corners = f"[1.0, 1.0, 0.0],\n  [0.0, 1.0, {height}],\n]"
        path.write_text(WHOLE.replace("[0.0, 1.0, 0.0],\n]", corners))
        if taken:
            scene_io.load_file(path)
        else:
            refused(path, "do not lie in one plane")


def test_a_polygon_that_crosses_itself_is_refused(tmp_path: Path) -> None:
    """Before it is cut into triangles, of which there may be none."""
    path = tmp_path / "scene.toml"
    path.write_text(WHOLE.replace("[0.0, 1.0, 0.0],\n]", "[0.2, 1.0, 0.0],\n  [0.5, -1.0, 0.0],\n]"))
    refused(path, "surfaces.points: the polygon crosses or touches itself")


# --- meshes -----------------------------------------------------------------------------------------------------------


def test_the_largest_mesh_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And its ending may be in capitals."""
    (tmp_path / "M.OBJ").write_text(OBJ.replace("1 0 0", "1e30 0 0").replace("0 1 0", "0 -1e30 0"))
    monkeypatch.setattr(meshes, "MOST_TRIANGLES", 1)
    monkeypatch.setattr(meshes, "LARGEST_FILE", (tmp_path / "M.OBJ").stat().st_size)
    scene_io.load_file(scene_with(tmp_path, "M.OBJ"))
    (tmp_path / "M.OBJ").write_text(OBJ.replace("1 0 0", "2e30 0 0"))
    refused(tmp_path / "scene.toml", "not finite or beyond 1e30")


def test_how_thin_a_triangle_may_be() -> None:
    heights = np.array([2e-12, 0.5e-12])
    triangles = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, height, 0.0]] for height in heights])
    assert meshes.without_area(triangles).tolist() == [False, True]
    assert meshes.without_area(triangles * 1e-20).tolist() == [False, True]


def test_what_a_parser_says_is_told_in_short(tmp_path: Path) -> None:
    head = "ply\nformat ascii 1.0\nelement vertex 1\nproperty {} x\nend_header\n0\n"
    (tmp_path / "m.ply").write_text(head.format("x" * 3000))
    assert len(refused(scene_with(tmp_path, "m.ply"), "is broken or empty")) < 250 + len(str(tmp_path))


def test_a_mesh_whose_nodes_lie_beyond_all_doubles_is_refused_without_a_warning(tmp_path: Path) -> None:
    found, data = gltf_files.one_mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]))
    found["nodes"] = [{"children": [1], "scale": [1e200] * 3}, {"mesh": 0, "scale": [1e200] * 3}]
    found["scenes"][0]["nodes"] = [0]
    gltf_files.glb(tmp_path / "m.glb", found, data)
    refused(scene_with(tmp_path, "m.glb"), "triangle 0 has a corner that is not finite or beyond 1e30")


@pytest.mark.parametrize("ending", [".glb", ".GLB"])
def test_a_glb_that_is_a_mesh_is_held_to_the_limits_of_a_scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    """Before trimesh makes anything of it."""
    found, data = gltf_files.one_mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]))
    found["nodes"][0]["children"] = [0]
    gltf_files.glb(tmp_path / f"m{ending}", found, data)
    monkeypatch.setattr(meshes, "load", lambda path: pytest.fail("is read"))
    refused(scene_with(tmp_path, f"m{ending}"), "has more than one parent")
    found["nodes"][0]["children"] = []
    gltf_files.glb(tmp_path / f"m{ending}", found, data)
    monkeypatch.setattr(meshes, "MOST_TRIANGLES", 0)
    refused(tmp_path / "scene.toml", "has more than 0 triangles")


# --- places -----------------------------------------------------------------------------------------------------------


def test_a_folder_whose_name_begins_alike_is_another(tmp_path: Path) -> None:
    for name in ("scene", "scene2"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "m.obj").write_text(OBJ)
    refused(scene_with(tmp_path / "scene", "../scene2/m.obj"), "leads out of the scene's folder")
    inside = tmp_path / "scene" / "m.obj"
    # A whole path would hold on this machine alone, wherever it leads.
    refused(scene_with(tmp_path / "scene", str(inside)), "leads out of the scene's folder")


def test_a_scene_in_a_folder_that_is_a_link_has_its_meshes(tmp_path: Path) -> None:
    (tmp_path / "scene").mkdir()
    (tmp_path / "scene" / "m.obj").write_text(OBJ)
    (tmp_path / "link").symlink_to(tmp_path / "scene")
    scene_with(tmp_path / "scene", "m.obj")
    scene_io.load_file(tmp_path / "link" / "scene.toml")


def test_names_that_lead_to_no_place_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("a\0.obj", "\ud800.obj"):
        with pytest.raises(InvalidInput, match="is no name of a file"):
            meshes.within(tmp_path, name)
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    with pytest.raises(InvalidInput, match="is no name of a file"):
        meshes.within(Path(), "m.obj")
