"""Scene files: what is read, and that every error names file, line and key."""

from __future__ import annotations

from pathlib import Path

import pytest

from aliascope import scene_io, toml_files
from aliascope.errors import InvalidInput

WHOLE = """\
title = "t"
shows = "s"

[view]
size = [8, 6]

[camera]
type = "orthographic"
eye = [0.0, 0.0, 4.0]
look_at = [0.0, 0.0, 0.0]
height = 2.0

[materials.paper]
emission = [1.0, 1.0, 1.0]

[[surfaces]]
type = "disc"
material = "paper"
centre = [0.1, 0.2, 0.0]
radius = 0.5

[[surfaces]]
type = "polygon"
material = "paper"
points = [
  [0.0, 0.0, 0.0],   # a comment with ] and "
  [1.0, 0.0, 0.0],
  [0.0, 1.0, 0.0],
]
"""


def load(folder: Path, text: str) -> scene_io.SceneFile:
    path = folder / "scene.toml"
    path.write_text(text)
    return scene_io.load(str(path))


def complaint(folder: Path, old: str, new: str) -> str:
    assert old in WHOLE
    with pytest.raises(InvalidInput) as caught:
        load(folder, WHOLE.replace(old, new, 1))
    text = str(caught.value).removeprefix(str(folder) + "/")
    assert "\n" not in text
    return text


def test_a_whole_scene_is_read(tmp_path: Path) -> None:
    file = load(tmp_path, WHOLE)
    assert file.name == "scene"
    assert file.scene.view.size == (8, 6)
    assert file.scene.features() == {"orthographic", "disc", "polygon"}


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("size = [8, 6]", "sise = [8, 6]", 'scene.toml:5: view: unknown key "sise"; did you mean "size"?'),
        ("size = [8, 6]", "size = [8, 20000]", "scene.toml:5: view.size: must be at most 16384, not 20000"),
        ("size = [8, 6]", "size = [16384, 16384]", "a picture has at most 67108864 pixels"),
        ("size = [8, 6]", "size = [8, 0]", "must be at least 1"),
        ("radius = 0.5", "radius = nan", "scene.toml:20: surfaces.radius: Input should be a finite number"),
        ("radius = 0.5", "radius = -0.5", "scene.toml:20: surfaces.radius: must be greater than 0"),
        ("radius = 0.5", "radius = 1e31", "scene.toml:20: surfaces.radius: must be at most 1e+30"),
        ("radius = 0.5", "", 'scene.toml:16: surfaces.radius: the key "radius" is missing'),
        ('type = "disc"', 'type = "disk"', 'scene.toml:17: surfaces: unknown type "disk"; did you mean "disc"?'),
        ('material = "paper"\ncentre', 'material = "papier"\ncentre', "scene.toml:18: surfaces.material: unknown mat"),
        ("[0.0, 1.0, 0.0],\n]", "[2.0, 0.0, 0.0],\n]", "scene.toml:25: surfaces.points: the polygon has no area"),
        ("height = 2.0", "", 'camera: an "orthographic" camera has height'),
        ("look_at = [0.0, 0.0, 0.0]", "look_at = [0.0, 0.0, 4.0]", "eye and look_at must differ"),
        ("look_at = [0.0, 0.0, 0.0]", "look_at = [0.0, 1.0, 4.0]", "up must not be zero or along the line of sight"),
        (
            "emission = [1.0, 1.0, 1.0]",
            "albedo = [1.5, 0, 0]",
            "scene.toml:14: materials.paper.albedo: must be at most 1, not 1.5",
        ),
        ('type = "orthographic"', 'type = "isometric"', "scene.toml:8: camera.type: "),
        ("height = 2.0", "height = 0.0", "scene.toml:11: camera.height: must be greater than 0"),
        ("[view]", "[view", "scene.toml:4: not TOML"),
        ('title = "t"', "", 'scene.toml:1: title: the key "title" is missing'),
    ],
)
def test_errors_name_file_line_and_key(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert expected in complaint(tmp_path, old, new)


@pytest.mark.parametrize(
    ("angle", "words"),
    [
        ("0.0", "must be greater than 0"),
        ("180.0", "must be less than 180"),
        ("-3.0", "greater"),
        ("nan", ""),
        ("inf", ""),
    ],
)
def test_angles_that_see_nothing_or_everything(tmp_path: Path, angle: str, words: str) -> None:
    text = WHOLE.replace('type = "orthographic"', 'type = "perspective"')
    with pytest.raises(InvalidInput, match=rf"scene\.toml:11: camera\.vertical_fov_degrees: .*{words}"):
        load(tmp_path, text.replace("height = 2.0", f"vertical_fov_degrees = {angle}"))
    assert load(tmp_path, text.replace("height = 2.0", "vertical_fov_degrees = 179.9")).scene.camera


def test_more_than_one_error_is_counted(tmp_path: Path) -> None:
    assert complaint(tmp_path, "size = [8, 6]", "siez = 3").endswith("(and 1 more)")


def test_a_polygon_out_of_its_plane_is_refused(tmp_path: Path) -> None:
    text = complaint(tmp_path, "[0.0, 1.0, 0.0],\n]", "[1.0, 1.0, 0.0],\n[0.0, 1.0, 0.01],\n]")
    assert "do not lie in one plane" in text


def test_unknown_scenes_have_near_misses() -> None:
    with pytest.raises(InvalidInput, match='unknown scene "zoneplate"; did you mean "zone-plate"'):
        scene_io.load("zoneplate")


def test_missing_files_and_bytes_that_are_no_text(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="No such file"):
        scene_io.load(str(tmp_path / "absent.toml"))
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(InvalidInput, match="not UTF-8"):
        scene_io.load(str(tmp_path / "bytes.toml"))


def test_lines_of_nested_tables_and_dotted_keys() -> None:
    lines = toml_files.line_map('a.b = 1\n[c]\nd = """x"""\n[[e]]\nf = 1\n[e.g]\nh = 2\n[[e]]\nf = 3\n"q r" = 4\n')
    assert lines[("a", "b")] == 1
    assert lines[("c", "d")] == 3
    assert lines[("e", 0, "f")] == 5
    assert lines[("e", 0, "g", "h")] == 7
    assert lines[("e", 1, "f")] == 9
    assert lines[("e", 1, "q r")] == 10


@pytest.mark.parametrize("name", scene_io.names())
def test_our_scenes_are_whole_and_their_digest_ignores_words(name: str) -> None:
    scene = scene_io.load(name).scene
    assert scene.digest() == scene.model_copy(update={"title": "other"}).digest()
    moved = scene.camera.model_copy(update={"eye": (0.0, 0.0, 4.5)})
    assert scene.digest() != scene.model_copy(update={"camera": moved}).digest()


@pytest.mark.parametrize(
    ("stated", "wrong", "line", "key"),
    [
        ("height = 2.0", 'height = "2.0"', 11, "camera.height"),
        ("height = 2.0", "height = true", 11, "camera.height"),
        ("eye = [0.0, 0.0, 4.0]", 'eye = [0.0, "0.0", 4.0]', 9, "camera.eye"),
        ("height = 2.0", 'height = 2.0\nblades = "6"', 12, "camera.blades"),
        ("emission = [1.0, 1.0, 1.0]", 'emission = [1.0, 1.0, "1.0"]', 14, "materials.paper.emission"),
    ],
)
def test_a_string_is_no_number(tmp_path: Path, stated: str, wrong: str, line: int, key: str) -> None:
    path = tmp_path / "a.toml"
    assert WHOLE.count(stated) == 1
    path.write_text(WHOLE.replace(stated, wrong))
    with pytest.raises(InvalidInput, match=rf"a\.toml:{line}: {key}: "):
        scene_io.load_file(path)


def test_a_whole_number_is_a_number(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text(WHOLE.replace("height = 2.0", "height = 2").replace("4.0]", "4]"))
    assert scene_io.load_file(path).scene.camera.height == 2.0
