"""Lens, shutter, lights, gloss and bounces in scene files: what is needed is read off, what cannot be is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aliascope import motion, scene_io
from aliascope.errors import InvalidInput
from aliascope.model import LoadedMesh, Needs, Polygon, Scene, Sphere

WHOLE = """\
title = "t"
shows = "s"

[view]
size = [8, 6]

[camera]
type = "perspective"
eye = [0.0, 0.0, 4.0]
look_at = [0.0, 0.0, 0.0]
vertical_fov_degrees = 40.0
lens_radius = 0.05
focus_distance = 4.0
shutter = [0.25, 0.75]

[materials.paper]
albedo = [0.5, 0.5, 0.5]

[materials.steel]
reflection = [0.6, 0.7, 0.8]
gloss = { type = "ggx", roughness = 0.2 }

[[surfaces]]
type = "sphere"
material = "steel"
centre = [0.1, 0.2, 0.0]
radius = 0.5
motion = { type = "translate", by = [1.0, 2.0, 4.0] }

[[surfaces]]
type = "polygon"
material = "paper"
points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]

[[lights]]
type = "area"
corner = [0.0, 2.0, 0.0]
edges = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
intensity = [1.0, 1.0, 1.0]
"""


def load(folder: Path, text: str) -> Scene:
    path = folder / "scene.toml"
    path.write_text(text)
    return scene_io.load(str(path)).scene


def changed(*changes: tuple[str, str]) -> str:
    text = WHOLE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def test_what_a_scene_needs_is_read_off(tmp_path: Path) -> None:
    scene = load(tmp_path, WHOLE + "\n[transport]\ndiffuse_bounces = 3\n")
    assert scene.needs() == Needs(
        lens=True,
        shutter=True,
        area_lights=1,
        mirror=False,
        gloss=True,
        diffuse_bounces=3,
        mirror_bounces=8,
        emitters=0,
    )
    assert scene.features() == {
        *("perspective", "sphere", "polygon", "lens", "motion", "gloss", "diffuse bounces", "area light")
    }


@pytest.mark.parametrize(
    ("old", "new", "gone"),
    [
        ("lens_radius = 0.05", "lens_radius = 0.0", "lens"),
        ("shutter = [0.25, 0.75]", "shutter = [0.5, 0.5]", "motion"),
        ("shutter = [0.25, 0.75]\n", "", "motion"),
        ('reflection = [0.6, 0.7, 0.8]\ngloss = { type = "ggx", roughness = 0.2 }\n', "", "gloss"),
        ('material = "steel"', 'material = "paper"', "gloss"),
    ],
)
def test_what_has_no_effect_is_no_need(tmp_path: Path, old: str, new: str, gone: str) -> None:
    assert gone in load(tmp_path, WHOLE).features()
    assert gone not in load(tmp_path, changed((old, new))).features()


def test_under_a_shutter_that_is_an_instant_surfaces_stand_where_they_are_then(tmp_path: Path) -> None:
    scene = load(tmp_path, changed(("[0.25, 0.75]", "[0.5, 0.5]")))
    ball = scene.surfaces[0]
    assert isinstance(ball, Sphere)
    assert ball.motion is None
    assert ball.centre == pytest.approx((0.6, 1.2, 2.0))
    still = load(tmp_path, changed(("shutter = [0.25, 0.75]\n", ""))).surfaces[0]
    assert isinstance(still, Sphere)
    assert still.centre == (0.1, 0.2, 0.0)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("lens_radius = 0.05", "lens_radius = -1.0", "scene.toml:12: camera.lens_radius: must be at least 0"),
        (
            "focus_distance = 4.0",
            "focus_distance = 0.0",
            "scene.toml:13: camera.focus_distance: must be greater than 0",
        ),
        ("focus_distance = 4.0\n", "", "lens_radius and focus_distance come together"),
        ("lens_radius = 0.05", "lens_radius = nan", "scene.toml:12: camera.lens_radius: "),
        ("lens_radius = 0.05", "lens_radius = inf", "scene.toml:12: camera.lens_radius: must be at most 1e+30"),
        ("focus_distance = 4.0", "focus_distance = -4.0", "scene.toml:13: camera.focus_distance: must be greater"),
        ("focus_distance = 4.0", "focus_distance = nan", "scene.toml:13: camera.focus_distance: Input should be"),
        ("focus_distance = 4.0", "focus_distance = inf", "scene.toml:13: camera.focus_distance: Input should be"),
        ("focus_distance = 4.0", "focus_distance = 1e31", "scene.toml:13: camera.focus_distance: must be at most"),
        ("focus_distance = 4.0", "focus_distance = 4.0\nblades = 2", "scene.toml:7: camera: a lens has 3 blades"),
        ("focus_distance = 4.0", "focus_distance = 4.0\nblades = 65", "scene.toml:14: camera.blades: must be at most"),
        ("shutter = [0.25, 0.75]", "shutter = [0.25, nan]", "scene.toml:14: camera.shutter: Input should be a finite"),
        ("shutter = [0.25, 0.75]", "shutter = [-inf, 0.75]", "scene.toml:14: camera.shutter: Input should be a finite"),
        ("shutter = [0.25, 0.75]", "shutter = [0.25, 1.5]", "scene.toml:7: camera: shutter is [open, close] with 0"),
        ("by = [1.0, 2.0, 4.0]", "by = [1.0, nan, 4.0]", "scene.toml:28: surfaces.motion.by: Input should be a finite"),
        ("by = [1.0, 2.0, 4.0]", "by = [1.0, 2e30, 4.0]", "scene.toml:28: surfaces.motion.by: must be at most 1e+30"),
        ("intensity = [1.0", "intensity = [inf", "scene.toml:39: lights.intensity: Input should be a finite number"),
        ("intensity = [1.0", "intensity = [-1.0", "scene.toml:39: lights.intensity: must be at least 0"),
        ("roughness = 0.2", "roughness = nan", "scene.toml:21: materials.steel.gloss.roughness: "),
        ("reflection = [0.6", "reflection = [nan", "scene.toml:20: materials.steel.reflection: "),
        ("reflection = [0.6", "reflection = [-0.1", "scene.toml:20: materials.steel.reflection: must be at least 0"),
        ("shutter = [0.25, 0.75]", "shutter = [0.75, 0.25]", "shutter is [open, close] with 0 <= open <= close <= 1"),
        ("shutter = [0.25, 0.75]", "shutter = [-0.5, 0.25]", "shutter is [open, close] with 0 <= open <= close <= 1"),
        ("edges = [[1.0, 0.0, 0.0]", "edges = [[0.0, 0.0, 2.0]", "scene.toml:35: lights: edges must span an area"),
        ("edges = [[1.0, 0.0, 0.0]", "edges = [[0.0, 0.0, 0.0]", "scene.toml:35: lights: edges must span an area"),
        ("reflection = [0.6", "reflection = [1.6", "scene.toml:20: materials.steel.reflection: must be at most 1"),
        (
            "reflection = [0.6",
            "albedo = [0.5, 0.5, 0.5]\nreflection = [0.6",
            "albedo (times the pattern) and reflection",
        ),
        ("reflection = [0.6, 0.7, 0.8]\n", "", "gloss spreads a reflection, and there is none"),
        ("roughness = 0.2", "roughness = 0.0", "must be at least 0.001"),
        (
            '"translate", by = [1.0, 2.0, 4.0]',
            '"rotate", axis = [0.0, 0.0, 0.0], degrees = 9.0',
            "axis must not be zero",
        ),
        (
            '"translate", by = [1.0, 2.0, 4.0]',
            '"rotate", axis = [0.0, 1e-200, 0.0], degrees = 9.0',
            "axis must not be zero, nor shorter than 1e-100",
        ),
        (
            '"translate", by = [1.0, 2.0, 4.0]',
            '"frames", files = ["a.ply"]',
            "scene.toml:28: surfaces.motion: only a mesh",
        ),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, old: str, new: str, expected: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        load(tmp_path, changed((old, new)))
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


LIGHTS_WITHOUT_AREA = [
    (
        'type = "disc"\ncentre = [0.0, 2.0, 0.0]\nnormal = [0.0, 1.0, 0.0]\nradius = 0.0',
        39,
        "lights.radius: must be greater",
    ),
    (
        'type = "disc"\ncentre = [0.0, 2.0, 0.0]\nnormal = [0.0, 0.0, 0.0]\nradius = 1.0',
        35,
        "lights: normal must not be zero",
    ),
    ('type = "sphere"\ncentre = [0.0, 2.0, 0.0]\nradius = 0.0', 38, "lights.radius: must be greater than 0"),
    ('type = "sphere"\ncentre = [0.0, 2.0, 0.0]\nradius = -1.0', 38, "lights.radius: must be greater than 0"),
    ('type = "sphere"\ncentre = [0.0, 2.0, 0.0]\nradius = inf', 38, "lights.radius: Input should be a finite number"),
    ('type = "sphere"\ncentre = [0.0, nan, 0.0]\nradius = 1.0', 37, "lights.centre: Input should be a finite number"),
]


@pytest.mark.parametrize(("light", "line", "expected"), LIGHTS_WITHOUT_AREA)
def test_lights_that_cannot_be_are_refused(tmp_path: Path, light: str, line: int, expected: str) -> None:
    area = 'type = "area"\ncorner = [0.0, 2.0, 0.0]\nedges = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]'
    with pytest.raises(InvalidInput) as caught:
        load(tmp_path, changed((area, light)))
    assert f"scene.toml:{line}: {expected}" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_orthographic_camera_may_have_a_lens_of_radius_0_alone(tmp_path: Path) -> None:
    flat = ('type = "perspective"', 'type = "orthographic"'), ("vertical_fov_degrees = 40.0", "height = 3.0")
    with pytest.raises(InvalidInput, match=r"scene\.toml:7: camera: a lens is for a \"perspective\" camera"):
        load(tmp_path, changed(*flat))
    assert not load(tmp_path, changed(*flat, ("lens_radius = 0.05", "lens_radius = 0.0"))).needs().lens


def test_a_rotation_is_right_handed_about_its_axis() -> None:
    turn = {"type": "rotate", "axis": (1.0, -2.0, 0.5), "centre": (0.3, 0.1, -0.7), "degrees": 217.0}
    points = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    polygon = Polygon.model_validate({"type": "polygon", "material": "m", "points": points, "motion": turn})
    axis = np.array([1.0, -2.0, 0.5])
    for time in (0.0, 0.31, 1.0):
        rotation = Rotation.from_rotvec(axis / np.linalg.norm(axis) * math.radians(217.0) * time)
        centre = np.array([0.3, 0.1, -0.7])
        expected = rotation.apply(np.array(points) - centre) + centre
        found = motion.moved(polygon, time)
        assert isinstance(found, Polygon)
        assert np.allclose(found.points, expected, rtol=0.0, atol=1e-15)  # a few roundings of numbers near 1


TRIANGLE = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n" + (
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 {height} 0\n3 0 1 2\n"
)
MESH = 'type = "mesh"\nmaterial = "paper"\nfile = "a.ply"\nmotion = { type = "frames", files = ["b.ply", "c.ply"] }\n'


def test_a_mesh_of_frames_moves_along_straight_lines(tmp_path: Path) -> None:
    for name, height in (("a", 1), ("b", 2), ("c", 6)):
        (tmp_path / f"{name}.ply").write_text(TRIANGLE.format(height=height))
    scene = load(tmp_path, WHOLE + "\n[[surfaces]]\n" + MESH)
    mesh = scene.surfaces[-1]
    assert isinstance(mesh, LoadedMesh)
    for time, height in ((0.0, 1.0), (0.25, 1.5), (0.5, 2.0), (0.75, 4.0), (1.0, 6.0)):
        found = motion.moved(mesh, time)
        assert isinstance(found, LoadedMesh)
        assert found.triangles[0, 2, 1] == height
        assert found.frames is None
    other = (tmp_path / "c.ply").write_text(TRIANGLE.format(height=7))
    assert other
    assert load(tmp_path, WHOLE + "\n[[surfaces]]\n" + MESH).digest() != scene.digest()


def test_frames_of_other_sizes_are_refused(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.ply").write_text(TRIANGLE.format(height=1))
    two = TRIANGLE.format(height=1).replace("element face 1", "element face 2") + "3 0 2 1\n"
    (tmp_path / "c.ply").write_text(two)
    with pytest.raises(
        InvalidInput, match=r'scene\.toml:\d+: surfaces\.motion: "c\.ply" has 2 triangles and "a\.ply" 1'
    ):
        load(tmp_path, WHOLE + "\n[[surfaces]]\n" + MESH)
