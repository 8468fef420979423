"""glTF files as scenes: their triangles, materials, cameras and lights; what is not drawn, and what is refused."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from commands import run
from gltf_files import glb, gltf, one_mesh, view_of

from aliascope import api, jobs, scene_io
from aliascope.errors import InvalidInput
from aliascope.geometry import surfaces_of
from aliascope.model import LoadedMesh, Scene

POINTS = np.array([[0.0, 0.0, 0.0], [1.25, 0.0, 0.0], [1.0, 1.5, 0.5], [-0.25, 1.0, 0.0]])
CORNERS = np.array([0, 1, 2, 0, 2, 3], np.uint16)
TRIANGLES = POINTS[CORNERS].reshape(-1, 3, 3)


def scene_of(path: Path) -> Scene:
    return scene_io.load(str(path)).scene


def triangles_of(path: Path) -> np.ndarray:
    return surfaces_of(scene_of(path)).triangles


def box(folder: Path, **more: Any) -> Path:
    """A file of two triangles, with further keys of its document."""
    document, data = one_mesh(POINTS, CORNERS)
    return glb(folder / "box.glb", {**document, **more}, data)


# --- triangles --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.uint32])
def test_indices_of_each_type_choose_the_corners(tmp_path: Path, kind: type) -> None:
    path = glb(tmp_path / "m.glb", *one_mesh(POINTS, CORNERS.astype(kind)))
    assert np.array_equal(triangles_of(path), TRIANGLES)


@pytest.mark.parametrize(("mode", "corners"), [(5, [0, 1, 3, 2]), (6, [0, 1, 2, 3])])
def test_strips_and_fans_are_their_triangles(tmp_path: Path, mode: int, corners: list[int]) -> None:
    found = triangles_of(glb(tmp_path / "m.glb", *one_mesh(POINTS[corners], mode=mode)))
    expected = {5: [[0, 1, 3], [1, 3, 2]], 6: [[0, 1, 2], [0, 2, 3]]}[mode]
    assert np.array_equal(found, POINTS[expected])


def test_triangles_need_no_indices_and_buffers_may_be_interleaved(tmp_path: Path) -> None:
    document, data = one_mesh(POINTS)
    document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = view_of(
        document, data, TRIANGLES.reshape(-1, 3).astype(np.float32), stride=20
    )
    assert np.array_equal(triangles_of(glb(tmp_path / "m.glb", document, data)), TRIANGLES)


def test_normalised_integers_are_fractions(tmp_path: Path) -> None:
    document, data = one_mesh(POINTS)
    whole = np.array([[0, 0, 0], [32767, 0, 0], [0, -32768, 0]], np.int16)
    number = view_of(document, data, whole, stride=8)
    document["accessors"][number]["normalized"] = True
    document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = number
    document["extensionsRequired"] = ["KHR_mesh_quantization"]
    found = triangles_of(glb(tmp_path / "m.glb", document, data))
    assert np.array_equal(found, [[[0, 0, 0], [1, 0, 0], [0, -1, 0]]])


def test_nodes_place_their_meshes(tmp_path: Path) -> None:
    """A quarter turn about y takes x to -z; scale comes before it, translation after, and a parent's after all."""
    half = math.sqrt(0.5)
    document, data = one_mesh(POINTS, CORNERS, {"scale": [2, 3, -4], "rotation": [0, half, 0, half]})
    document["nodes"][0]["translation"] = [10, 20, 30]
    document["nodes"].append(
        {
            "children": [0],
            "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1],
        }  # columns: a quarter turn about z
    )
    document["scenes"] = [{"nodes": [2, 1]}]
    x, y, z = np.moveaxis(TRIANGLES, -1, 0)
    placed = np.stack([-4 * z + 10, 3 * y + 20, -2 * x + 30], axis=-1)
    above = np.stack([-placed[..., 1] + 5, placed[..., 0] + 6, placed[..., 2] + 7], axis=-1)
    assert np.allclose(triangles_of(glb(tmp_path / "m.glb", document, data)), above, rtol=0, atol=1e-13)


def test_only_the_scene_that_the_file_names_is_drawn(tmp_path: Path) -> None:
    document, data = one_mesh(POINTS, CORNERS)
    document["nodes"].append({"mesh": 0, "translation": [9, 9, 9]})
    document["scenes"] = [{"nodes": [2]}, {"nodes": [0, 1]}]
    assert np.array_equal(triangles_of(glb(tmp_path / "m.glb", {**document, "scene": 1}, data)), TRIANGLES)
    both = {key: value for key, value in document.items() if key not in ("scene", "scenes")}
    assert len(triangles_of(glb(tmp_path / "n.glb", both, data))) == 4  # no scenes: all nodes


def test_buffers_may_be_within_the_text_or_beside_it(tmp_path: Path) -> None:
    document, data = one_mesh(POINTS, CORNERS)
    (tmp_path / "my data.bin").write_bytes(data)
    for uri in (None, "my%20data.bin"):
        assert np.array_equal(triangles_of(gltf(tmp_path / "m.gltf", document, data, uri)), TRIANGLES)


def test_what_trimesh_writes_is_read_as_trimesh_reads_it(tmp_path: Path) -> None:
    """Two solids in a tree of nodes, by a program that is not ours."""
    made = trimesh.Scene()
    turned = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0.1, 0.2, 0.3])
    made.add_geometry(trimesh.creation.icosphere(2, 0.7), "ball", transform=turned)
    made.add_geometry(trimesh.creation.box((1, 2, 3)), "box", parent_node_name="ball", transform=np.diag([1, 2, 1, 1]))
    made.export(tmp_path / "m.glb")
    theirs = trimesh.load_scene(tmp_path / "m.glb", process=False).to_mesh().triangles
    ours = triangles_of(tmp_path / "m.glb")
    assert len(ours) == 320 + 12
    ordered = [each[np.lexsort(np.round(each.reshape(-1, 9), 6).T)] for each in (ours, np.asarray(theirs))]
    assert np.abs(ordered[0] - ordered[1]).max() < 1e-6  # trimesh keeps the nodes' numbers as they are in the file


def test_triangles_without_area_are_left_out_and_said(tmp_path: Path) -> None:
    file = scene_io.load(str(glb(tmp_path / "m.glb", *one_mesh(POINTS, np.array([0, 1, 2, 1, 1, 3], np.uint16)))))
    assert np.array_equal(surfaces_of(file.scene).triangles, TRIANGLES[:1])
    assert "triangles without area are left out" in file.notes


# --- the same picture as a TOML scene's -------------------------------------------------------------------------------

LIT = """
title = "Two balls"
shows = "The same triangles."
[view]
size = [48, 32]
[camera]
type = "perspective"
eye = [0.3, 0.2, 5.0]
look_at = [0.3, 0.2, 0.0]
vertical_fov_degrees = {fov!r}
[materials.a]
albedo = [0.75, 0.5, 0.25]
emission = [0.125, 0.0, 1.5]
[[surfaces]]
type = "mesh"
material = "a"
file = "ball.ply"
[[lights]]
type = "point"
position = [2.0, 3.0, 4.0]
intensity = [8.0, 4.0, 2.0]
falloff = "inverse-square"
[[lights]]
type = "directional"
direction = [0.0, 0.0, -1.0]
intensity = [0.5, 0.5, 0.5]
"""


def lit(folder: Path) -> tuple[Path, Path]:
    """A ball with a material and two lights, as glTF and as TOML."""
    ball = trimesh.creation.icosphere(2, 1.0)
    points = ball.vertices.astype(np.float32)
    document, data = one_mesh(points, ball.faces.reshape(-1).astype(np.uint32), material=0)
    document["materials"] = [
        {
            "name": "clay",
            "pbrMetallicRoughness": {"baseColorFactor": [0.75, 0.5, 0.25, 1.0], "metallicFactor": 0.0},
            "emissiveFactor": [1.0 / 12.0, 0.0, 1.0],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 1.5}},
        }
    ]
    lights = [
        {"type": "point", "color": [1.0, 0.5, 0.25], "intensity": 8.0},
        {"type": "directional", "intensity": 0.5},
    ]
    document["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    document["nodes"] += [
        {"translation": [2, 3, 4], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"extensions": {"KHR_lights_punctual": {"light": 1}}},
    ]
    document["scenes"][0]["nodes"] += [2, 3]
    path = glb(folder / "ball.glb", document, data)
    trimesh.Trimesh(points.astype(np.float64), ball.faces, process=False).export(folder / "ball.ply")
    (folder / "twin.toml").write_text(LIT.format(fov=math.degrees(0.7)))
    return path, folder / "twin.toml"


def test_its_picture_is_that_of_the_same_triangles_in_a_toml_scene(tmp_path: Path) -> None:
    first, second = (scene_io.load(str(path)) for path in lit(tmp_path))
    assert first.notes == ()
    assert first.scene.view.size == (360, 240)
    pictures = [api.render(file, "embree", "uniform:n=4", size=(48, 32)).pixels for file in (first, second)]
    assert pictures[0].std() > 0.1
    assert np.abs(pictures[0] - pictures[1]).max() < 2e-6 * pictures[0].max()  # 1.5/12 and 0.125 differ by rounding
    none = [api.render(file, "povray", "none", size=(48, 32)).pixels for file in (first, second)]
    assert np.array_equal(*none)


def test_every_command_takes_it_where_it_takes_toml(tmp_path: Path) -> None:
    path = box(tmp_path)
    out = run("render", path, "-r", "embree", "-m", "uniform:n=1", "--size", "24x16", "-o", tmp_path / "a.exr")
    assert f"{path}: it has no light" in out.stderr
    assert (tmp_path / "a.exr").is_file()
    found = json.loads(run("compare", path, "-r", "embree", "-m", "uniform:n=4", "--dry-run", "--json").stdout)
    assert {job["scene"] for job in found["jobs"]} == {"box"}
    assert "directional one from behind the camera was added" in scene_io.load(str(path)).scene.shows  # of the report


def test_the_digest_is_that_of_what_is_drawn(tmp_path: Path) -> None:
    document, data = one_mesh(POINTS, CORNERS)
    first = scene_of(glb(tmp_path / "a.glb", document, data)).digest()
    assert scene_of(gltf(tmp_path / "b.gltf", document, data)).digest() == first
    document["nodes"][0]["translation"] = [0.125, 0, 0]
    assert scene_of(glb(tmp_path / "c.glb", document, data)).digest() != first
    plan = jobs.make_plan([scene_io.load(str(tmp_path / "a.glb"))], {"embree": ["uniform:n=1"]}, 1)
    assert len(plan.jobs) == 1


# --- camera, lights, materials ----------------------------------------------------------------------------------------


def test_an_orthographic_camera_and_its_place(tmp_path: Path) -> None:
    document, data = one_mesh(POINTS, CORNERS)
    document["cameras"] = [
        {"type": "orthographic", "orthographic": {"xmag": 3.0, "ymag": 1.5, "znear": 0.0, "zfar": 99.0}}
    ]
    half = math.sqrt(0.5)
    document["nodes"][1] = {"camera": 0, "translation": [5, 0, 0], "rotation": [0, half, 0, half], "scale": [2, 2, 2]}
    scene = scene_of(glb(tmp_path / "m.glb", document, data))
    assert (scene.camera.type, scene.camera.height, scene.view.size) == ("orthographic", 3.0, (480, 240))
    forward = np.subtract(scene.camera.look_at, scene.camera.eye)
    assert np.allclose(forward / np.linalg.norm(forward), [-1, 0, 0], atol=1e-15)
    assert scene.camera.eye == (5.0, 0.0, 0.0)


def test_a_file_without_camera_and_light_gets_both_and_says_so(tmp_path: Path) -> None:
    document, data = one_mesh(POINTS * 7.0 + 100.0, CORNERS)
    del document["nodes"][1]
    document["scenes"] = [{"nodes": [0]}]
    file = scene_io.load(str(glb(tmp_path / "m.glb", document, data)))
    assert len(file.notes) == 2
    assert "no camera" in file.notes[0]
    assert "no light" in file.notes[1]
    pixels = api.render(file, "embree", "uniform:n=1", size=(64, 48)).pixels
    seen = (pixels > 0.0).any(axis=2)
    assert 0.1 < seen.mean() < 0.9
    assert not seen[[0, -1]].any()  # whole within the picture
    assert not seen[:, [0, -1]].any()


def test_what_is_not_lit_gets_no_light(tmp_path: Path) -> None:
    document, data = one_mesh(POINTS, CORNERS, material=0)
    colour = {"baseColorFactor": [0.5, 0.25, 0.125, 1.0]}
    document["materials"] = [{"pbrMetallicRoughness": colour, "extensions": {"KHR_materials_unlit": {}}}]
    file = scene_io.load(str(glb(tmp_path / "m.glb", document, data)))
    assert file.notes == ()
    assert file.scene.lights == ()
    assert file.scene.materials["0"].emission == (0.5, 0.25, 0.125)


UNDRAWN = {
    "textures": {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]},
    "metal": {"materials": [{}]},
    "opaque": {"materials": [{"alphaMode": "BLEND"}]},
    "KHR_materials_transmission": {"materials": [{"extensions": {"KHR_materials_transmission": {}}}]},
    "animations": {"animations": [{}]},
}


@pytest.mark.parametrize("what", UNDRAWN)
def test_what_is_not_drawn_is_said(tmp_path: Path, what: str) -> None:
    document, data = one_mesh(POINTS, CORNERS, material=0)
    plain = {"materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}}]}
    path = glb(tmp_path / "m.glb", {**document, **plain, **UNDRAWN[what]}, data)
    assert any(what in note for note in scene_io.load(str(path)).notes)
    path = glb(tmp_path / "n.glb", {**document, **plain}, data)
    assert not any(what in note for note in scene_io.load(str(path)).notes)


def test_smooth_normals_spots_skins_and_lines_are_said(tmp_path: Path) -> None:
    document, data = one_mesh(POINTS, CORNERS)
    primitive = document["meshes"][0]["primitives"][0]
    primitive["attributes"]["NORMAL"] = view_of(document, data, POINTS.astype(np.float32))
    primitive["attributes"]["COLOR_0"] = 0
    document["meshes"][0]["primitives"].append({**primitive, "mode": 1})
    document["nodes"][0] |= {"skin": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}
    document["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}}]}}
    told = " ".join(scene_io.load(str(glb(tmp_path / "m.glb", document, data))).notes)
    for word in ("smooth normals", "colours of corners", "lines", "skins", "spot lights", "no light that is drawn"):
        assert word in told


# --- what is refused --------------------------------------------------------------------------------------------------


def refused(path: Path) -> str:
    with pytest.raises(InvalidInput) as caught:
        scene_io.load(str(path))
    assert str(caught.value).startswith(f"{path}: ")
    return str(caught.value)


@pytest.mark.parametrize(
    "uri", ["../m.bin", "/etc/passwd", "%2e%2e/m.bin", "https://example.org/m.bin", "file:///m.bin"]
)
def test_buffers_out_of_its_folder_are_refused(tmp_path: Path, uri: str) -> None:
    (tmp_path / "sub").mkdir()
    document, data = one_mesh(POINTS, CORNERS)
    (tmp_path / "m.bin").write_bytes(data)
    text = refused(gltf(tmp_path / "sub" / "m.gltf", document, data, uri))
    assert "leads out of" in text or "no file beside it" in text


def test_a_link_out_of_its_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    document, data = one_mesh(POINTS, CORNERS)
    (tmp_path / "m.bin").write_bytes(data)
    (tmp_path / "sub" / "m.bin").symlink_to(tmp_path / "m.bin")
    assert "leads out of" in refused(gltf(tmp_path / "sub" / "m.gltf", document, data, "m.bin"))


def _break(document: dict[str, Any], path: str, value: Any) -> None:
    *way, last = path.split(".")
    place: Any = document
    for part in way:
        place = place[int(part) if part.isdecimal() else part]
    place[int(last) if last.isdecimal() else last] = value


@pytest.mark.parametrize(
    ("where", "value", "told"),
    [
        ("accessors.0.count", 4_000_000, "more than its buffer holds"),
        ("accessors.0.count", 10**12, "accessors.0.count"),
        ("accessors.0.count", -1, "accessors.0.count"),
        ("accessors.0.byteOffset", 10**9, "more than its buffer holds"),
        ("accessors.0.sparse", {"count": 1}, "sparse"),
        ("accessors.0.type", "VEC4", "more than its buffer holds"),
        ("accessors.0.componentType", 5124, "accessors.0.componentType"),
        ("accessors.1.componentType", 5126, "more than its buffer holds"),
        ("bufferViews.0.byteLength", 10**9, "more than its buffer holds"),
        ("bufferViews.0.buffer", 7, "names buffer 7"),
        ("meshes.0.primitives.0.attributes.POSITION", 9, "names accessor 9"),
        ("meshes.0.primitives.0.attributes.POSITION", 1, "three components"),
        ("meshes.0.primitives.0.material", 0, "names material 0"),
        ("meshes.0.primitives.0.mode", 7, "mode"),
        ("meshes.0.primitives", [], "meshes.0.primitives"),
        ("nodes.0.mesh", 1, "names mesh 1"),
        ("nodes.0.children", [0], "more than one parent"),
        ("nodes.0.translation", [1e300, 0, 0], "beyond 1e30"),
        ("nodes.0.scale", [1e300, 1e300, 1e300], "beyond 1e30"),
        ("nodes.1.scale", [0, 0, 0], "no direction"),
        ("nodes.1.camera", 3, "names camera 3"),
        ("nodes.1.extensions", {"KHR_lights_punctual": {"light": 5}}, "names light 5"),
        ("nodes.1.extensions", {"KHR_lights_punctual": {}}, "names no light"),
        ("cameras.0.perspective.yfov", 4.0, "yfov"),
        ("cameras.0.perspective.aspectRatio", 1e6, "size"),
        ("cameras.0.type", "orthographic", "does not say how"),
        ("scenes.0.nodes", [99], "names node 99"),
        ("asset.version", "1.0", "glTF 1.0"),
        ("extensionsRequired", ["KHR_draco_mesh_compression"], "KHR_draco_mesh_compression"),
        ("scenes.0.extras", {"aliascope": {"title": 3}}, "scene.extras.aliascope"),
    ],
)
def test_hostile_documents_are_refused_by_name(tmp_path: Path, where: str, value: Any, told: str) -> None:
    document, data = one_mesh(POINTS, CORNERS)
    _break(document, where, value)
    assert told in refused(glb(tmp_path / "m.glb", document, data))


def test_an_index_beyond_the_corners_is_refused(tmp_path: Path) -> None:
    assert "an index is 4" in refused(glb(tmp_path / "m.glb", *one_mesh(POINTS, np.array([0, 1, 4], np.uint8))))


def test_a_corner_that_is_not_finite_is_refused(tmp_path: Path) -> None:
    points = POINTS.copy()
    points[2, 1] = math.nan
    assert "not finite" in refused(glb(tmp_path / "m.glb", *one_mesh(points, CORNERS)))


def test_instances_are_counted_before_they_are_made(tmp_path: Path) -> None:
    """50 nodes with a mesh of 1,000,000 triangles each."""
    document, data = one_mesh(POINTS, np.zeros(3_000_000, np.uint8))
    document["nodes"] = [{"mesh": 0}] * 50
    document["scenes"] = [{"nodes": list(range(50))}]
    assert "more than 4000000 triangles" in refused(glb(tmp_path / "m.glb", document, data))


def test_broken_files_are_refused(tmp_path: Path) -> None:
    whole = box(tmp_path).read_bytes()
    for name, data in {
        "cut": whole[:-40],
        "head": whole[:10],
        "chunk": whole[:12] + b"\xff" + whole[13:],
        "empty": b"",
        "text": b"{",
        "deep": b"[" * 100_000,
        "infinite": b'{"asset": {"version": "2.0"}, "x": Infinity}',
        "latin": b'{"asset": "\xe9"}',
        "nothing": b'{"asset": {"version": "2.0"}}',
    }.items():
        path = tmp_path / f"{name}.glb"
        path.write_bytes(data)
        refused(path)
    assert "No such file" in refused(tmp_path / "missing.glb")
    folder = tmp_path / "folder.glb"
    folder.mkdir()
    refused(folder)


def test_a_bad_file_ends_the_command_with_2(tmp_path: Path) -> None:
    path = tmp_path / "m.glb"
    path.write_bytes(b"glTF")
    out = run("render", path, "-r", "embree", "-m", "uniform:n=1", "-o", tmp_path / "a.exr", code=2)
    assert len(out.stderr.splitlines()) == 1
    shutil.copy(path, tmp_path / "upper.GLB")
    assert "cut off" in run("compare", tmp_path / "upper.GLB", "-o", tmp_path / "o", code=2).stderr


def test_each_surface_is_a_mesh_in_world_coordinates(tmp_path: Path) -> None:
    surfaces = scene_of(box(tmp_path)).surfaces
    assert all(isinstance(surface, LoadedMesh) for surface in surfaces)
    assert len(surfaces) == 1
