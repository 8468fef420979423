"""Scenes as glTF for other programs: what they hold, and that they come back as they were."""

from __future__ import annotations

import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from aliascope import api, scene_io
from aliascope.geometry import frame_of, surfaces_of
from aliascope.gltf import writing
from aliascope.gltf.document import Document
from aliascope.model import Camera, DirectionalLight, Disc, Material, PointLight, Scene, Sphere, View

SIZE = (64, 48)


def written(path: Path, scene: Scene) -> scene_io.SceneFile:
    assert writing.no_form(scene, SIZE) is None
    writing.write(path / "s.glb", scene, SIZE)
    return scene_io.load(str(path / "s.glb"))


def round_scene(surface: Disc | Sphere, **camera: Any) -> Scene:
    kind = camera or {"type": "orthographic", "eye": (0.0, 0.0, 50.0), "look_at": (0.0, 0.0, 0.0), "height": 4.8}
    lights = (
        PointLight(type="point", position=(3.0, 4.0, 9.0), intensity=(90.0, 50.0, 40.0), falloff="inverse-square"),
        DirectionalLight(type="directional", direction=(0.3, -0.7, -0.4), intensity=(0.5, 0.25, 0.125)),
    )
    return Scene(
        title="Round",
        shows="One surface.",
        view=View(size=SIZE, background=(0.1, 0.2, 0.3)),
        camera=Camera(**kind),
        materials={"m": Material(albedo=(0.5, 0.25, 0.75), emission=(0.0, 3.0, 0.5))},
        surfaces=(surface,),
        lights=lights,
    )


@pytest.mark.parametrize("name", ["edge", "siemens-star", "comb"])
def test_scenes_of_polygons_come_back_to_the_bit(tmp_path: Path, name: str) -> None:
    """Their pictures: positions are float32 there, as in the tracer."""
    file = scene_io.load(name)
    pictures = [
        api.render(each, "embree", "uniform:n=16,sampler=regular", size=SIZE).pixels
        for each in (file, written(tmp_path, file.scene))
    ]
    assert np.array_equal(*pictures)


def test_camera_light_material_and_view_come_back(tmp_path: Path) -> None:
    eye, look_at = (1.0, 2.0, 9.0), (0.1, 0.2, 0.3)
    camera = {"type": "perspective", "eye": eye, "look_at": look_at, "vertical_fov_degrees": 33.0}
    scene = round_scene(Sphere(type="sphere", material="m", centre=(0.3, 0.1, 0.2), radius=0.9), **camera)
    found = written(tmp_path, scene).scene
    assert (found.view, found.title, found.shows) == (scene.view, scene.title, scene.shows)
    frames = frame_of(found), frame_of(scene)
    for name in ("eye", "right", "up", "forward", "half_width", "half_height"):
        assert getattr(frames[0], name) == pytest.approx(getattr(frames[1], name), abs=1e-14), name
    (material,) = found.materials.values()
    assert material.albedo == (0.5, 0.25, 0.75)
    assert material.emission == pytest.approx((0.0, 3.0, 0.5), abs=1e-15)
    lamp, sun = found.lights
    assert isinstance(lamp, PointLight)
    assert (lamp.position, lamp.falloff) == ((3.0, 4.0, 9.0), "inverse-square")
    assert lamp.intensity == pytest.approx((90.0, 50.0, 40.0), rel=1e-15)
    assert isinstance(sun, DirectionalLight)
    assert np.cross(sun.direction, (0.3, -0.7, -0.4)) == pytest.approx([0, 0, 0], abs=1e-15)
    assert np.dot(sun.direction, (0.3, -0.7, -0.4)) > 0.0


@pytest.mark.parametrize("radius", [0.02, 0.4, 2.3])
@pytest.mark.parametrize("kind", ["disc", "sphere"])
def test_outlines_are_within_a_thousandth_of_a_pixel(tmp_path: Path, kind: str, radius: float) -> None:
    """Seen along z at 10 pixels a unit: how far the outline of all triangles lies from the circle."""
    shape: Disc | Sphere = Sphere(type="sphere", material="m", centre=(0.1, 0.2, 0.3), radius=radius)
    if kind == "disc":
        shape = Disc(type="disc", material="m", centre=(0.1, 0.2, 0.3), radius=radius)
    triangles = surfaces_of(written(tmp_path, round_scene(shape)).scene).triangles
    flat = (triangles - [0.1, 0.2, 0.3])[:, :, :2]
    angles = np.linspace(0.0, 2.0 * math.pi, 61)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    corners = flat.reshape(-1, 2)
    outer = corners[np.linalg.norm(corners, axis=1) > 0.99 * radius]
    # Both are convex: their reach in a direction is that of the farthest corner.
    reach = (outer @ directions).max(axis=0)
    assert np.abs(reach - radius).max() * 10.0 < writing.SILHOUETTE
    if kind == "disc":  # the middles of its sides lie within
        sides = np.linalg.norm((flat[:, 1] + flat[:, 2]) / 2.0, axis=1)
        assert np.abs(sides - radius).max() * 10.0 < writing.SILHOUETTE


def test_a_ball_looks_as_it_did(tmp_path: Path) -> None:
    scene = round_scene(Sphere(type="sphere", material="m", centre=(0.1, 0.2, 0.3), radius=1.7))
    first, second = (
        api.render(each, "embree", "uniform:n=64,sampler=regular", size=SIZE).pixels
        for each in (scene_io.SceneFile("s", tmp_path, scene), written(tmp_path, scene))
    )
    assert np.abs(first - second).mean() < 1e-4  # facets have their own normals here
    assert first.std() > 0.1


def test_another_program_reads_it(tmp_path: Path) -> None:
    """trimesh, which has nothing of ours: the triangles in their place, wound outward."""
    scene = round_scene(Sphere(type="sphere", material="m", centre=(5.0, -7.0, 0.5), radius=0.5))
    ours = surfaces_of(written(tmp_path, scene).scene).triangles
    theirs = trimesh.load_scene(tmp_path / "s.glb", process=False)
    (mesh,) = theirs.dump()
    assert np.abs(np.asarray(mesh.triangles) - ours).max() < 1e-6
    outward = np.einsum("ij,ij->i", mesh.face_normals, mesh.triangles_center - [5.0, -7.0, 0.5])
    assert (outward > 0.0).all()


def test_spheres_have_their_exact_normals(tmp_path: Path) -> None:
    written(tmp_path, round_scene(Sphere(type="sphere", material="m", centre=(5.0, -7.0, 0.5), radius=0.5)))
    file = Document(tmp_path / "s.glb")
    (primitive,) = file.root.meshes[0].primitives
    points, normals = (file.numbers(primitive.attributes[name]).astype(float) for name in ("POSITION", "NORMAL"))
    out = np.linalg.norm(points, axis=1)  # the node takes the middle to its place
    assert np.ptp(out) < 1e-6
    assert np.abs(points / out[:, np.newaxis] - normals).max() < 1e-6  # float32


def test_the_file_is_as_the_format_has_it(tmp_path: Path) -> None:
    """Lengths, alignment, the bounds of positions."""
    written(tmp_path, round_scene(Disc(type="disc", material="m", centre=(9.0, 8.0, 7.0), radius=2.0)))
    data = (tmp_path / "s.glb").read_bytes()
    magic, version, length, size, kind = struct.unpack("<IIIII", data[:20])
    assert (magic, version, length, kind, size % 4) == (0x46546C67, 2, len(data), 0x4E4F534A, 0)
    document = json.loads(data[20 : 20 + size])
    position = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    start = 28 + size + document["bufferViews"][position["bufferView"]]["byteOffset"]
    points = np.frombuffer(data, "<f4", 3 * position["count"], start).reshape(-1, 3)
    assert position["min"] == points.min(axis=0).tolist()
    assert position["max"] == points.max(axis=0).tolist()
    assert all(view["byteOffset"] % 4 == 0 for view in document["bufferViews"])


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("zone-plate", "zone-plate"),
        ("checker-horizon", "checker, plane"),
        ("depth-of-field", "lens"),
        ("motion-blur", "motion"),
        ("soft-shadow", "area light"),
        ("glossy", "gloss, mirror"),
        ("cornell-box", "diffuse bounces"),
        ("spheres", "a point light without fall-off"),
    ],
)
def test_what_has_no_form_is_said(name: str, told: str) -> None:
    assert told in (writing.no_form(scene_io.load(name).scene) or "")


def test_a_ball_about_the_camera_has_no_form() -> None:
    camera = {"type": "perspective", "eye": (0.0, 0.0, 0.5), "look_at": (0.0, 0.0, 0.0), "vertical_fov_degrees": 33.0}
    ball = Sphere(type="sphere", material="m", centre=(0.0, 0.0, 0.0), radius=1.0)
    assert "reaches the camera" in (writing.no_form(round_scene(ball, **camera)) or "")
    near = Sphere(type="sphere", material="m", centre=(0.0, 0.0, 0.0), radius=0.49999)
    assert "triangles, more than" in (writing.no_form(round_scene(near, **camera)) or "")
