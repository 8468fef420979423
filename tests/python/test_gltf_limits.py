"""The limits of glTF files, each at its edge: what is just allowed is read, and what is just past it is refused."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import gltf_files
import numpy as np
import pytest

from aliascope import bounded, meshes, scene_io
from aliascope.errors import InvalidInput
from aliascope.gltf import document, reading

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
CORNERS = np.array([0, 1, 2], np.uint8)
INFINITE = float("inf")
"""In the file 1e999, which Python's reader of JSON takes for that."""
LONG = "x" * 3000


def whole() -> tuple[dict[str, Any], bytearray]:
    """A triangle with a material, under a light and seen by a camera."""
    found, data = gltf_files.one_mesh(POINTS, CORNERS, material=0)
    found["materials"] = [{"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}]
    found["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 3}]}}
    found["nodes"][1]["extensions"] = {"KHR_lights_punctual": {"light": 0}}
    return found, data


def changed(where: str, value: Any) -> tuple[dict[str, Any], bytearray]:
    found, data = whole()
    place: Any = found
    *way, last = (int(part) if part.isdecimal() else part for part in where.split("."))
    for part in way:
        place = place[part]
    place[last] = value
    return found, data


def written(path: Path, found: dict[str, Any], data: bytes | bytearray) -> Path:
    gltf_files.gltf(path, found, data)
    path.write_text(path.read_text().replace("Infinity", "1e999"))
    return path


def refused(path: Path) -> str:
    with pytest.raises(InvalidInput) as caught:
        scene_io.load_file(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert len(str(caught.value)) < 450 + len(str(path))
    return str(caught.value)


# --- values -----------------------------------------------------------------------------------------------------------

LIGHT = "extensions.KHR_lights_punctual.lights.0"
SEEN = "nodes.1.extensions.KHR_lights_punctual"
FACTOR = "materials.0.pbrMetallicRoughness.baseColorFactor"
WRONG: list[tuple[str, Any, str]] = [
    # Python takes -1 for the last of a list, and False for 0.
    ("scenes.0.nodes", [-1], "scenes.0.nodes.0: "),
    ("nodes.0.mesh", -1, "nodes.0.mesh: "),
    ("nodes.0.mesh", "0", "nodes.0.mesh: "),
    ("nodes.0.mesh", False, "nodes.0.mesh: "),
    ("bufferViews.0.byteOffset", -1, "bufferViews.0.byteOffset: "),
    ("bufferViews.0.byteOffset", 10**6, "more than its buffer holds"),
    ("bufferViews.0.byteLength", 0, "bufferViews.0.byteLength: "),
    ("bufferViews.0.byteLength", 35, "more than its buffer holds"),
    ("bufferViews.0.byteStride", 3, "bufferViews.0.byteStride: "),
    ("bufferViews.0.byteStride", 253, "bufferViews.0.byteStride: "),
    ("bufferViews.0.byteStride", 16, "more than its buffer holds"),
    ("accessors.0.byteOffset", -1, "accessors.0.byteOffset: "),
    ("accessors.0.byteOffset", 4, "more than its buffer holds"),
    ("accessors.0.count", 0, "accessors.0.count: "),
    ("accessors.0.count", 12_000_001, "accessors.0.count: "),
    ("accessors.0.type", "VEC5", "accessors.0.type: "),
    ("accessors.0.type", "MAT4", "is MAT4, which is not read here"),
    ("meshes.0.primitives.0.mode", -1, "meshes.0.primitives.0.mode: "),
    ("nodes.0.matrix", [1.0] * 15, "nodes.0.matrix: "),
    ("nodes.0.matrix", [1.0] * 17, "nodes.0.matrix: "),
    ("nodes.0.matrix", [INFINITE] * 16, "nodes.0.matrix.0: "),
    ("nodes.0.translation", [0, INFINITE, 0], "nodes.0.translation.1: "),
    ("nodes.1.scale", [INFINITE, 1, 1], "nodes.1.scale.0: "),
    ("nodes.1.scale", [1e308, 1e308, 1e308], "no direction"),
    ("nodes.1.scale", [1, 1, 0], "no direction"),
    ("nodes.1.translation", [0, 1e308, 1e308], "eye.1: "),
    ("cameras.0.perspective.yfov", 0.0, "cameras.0.perspective.yfov: "),
    ("cameras.0.perspective.znear", 0.0, "cameras.0.perspective.znear: "),
    ("cameras.0.perspective.zfar", INFINITE, "cameras.0.perspective.zfar: "),
    ("cameras.0.perspective.aspectRatio", -1.0, "cameras.0.perspective.aspectRatio: "),
    ("cameras.0.perspective.aspectRatio", INFINITE, "cameras.0.perspective.aspectRatio: "),
    (FACTOR, [1.1, 0, 0, 1], "base_color_factor.0: "),
    (FACTOR, [-0.1, 0, 0, 1], "base_color_factor.0: "),
    ("materials.0.emissiveFactor", [0, 0, INFINITE], "emissiveFactor.2: "),
    (
        "materials.0.extensions",
        {"KHR_materials_emissive_strength": {"emissiveStrength": "7"}},
        "is not a number from 0",
    ),
    ("materials.0.extensions", {"KHR_materials_emissive_strength": {"emissiveStrength": -1}}, "is not a number from 0"),
    ("materials.0.extensions", {"KHR_materials_emissive_strength": {"emissiveStrength": 2e30}}, "is not a number from"),
    ("materials.0.extensions", {"KHR_materials_emissive_strength": {"emissiveStrength": LONG}}, "is not a number from"),
    (f"{LIGHT}.intensity", -1.0, "lights.0.intensity: "),
    (f"{LIGHT}.intensity", INFINITE, "lights.0.intensity: "),
    (f"{LIGHT}.intensity", 1e31, "intensity.0: "),
    (f"{LIGHT}.range", 0.0, "lights.0.range: "),
    (SEEN, {"light": -1}, "names no light"),
    (SEEN, {"light": True}, "names no light"),
    (SEEN, {"light": "0"}, "names no light"),
    (SEEN, [], "names no light"),
    ("extensions.KHR_lights_punctual.lights", 1, "names light 0, and has 0"),
    ("extensions.KHR_lights_punctual", [], "names light 0, and has 0"),
    ("asset.minVersion", "2.1", "is glTF 2.0; 2.0 is read"),
    ("asset.version", LONG, "; 2.0 is read"),
    ("extensionsRequired", [LONG], "which is not read here"),
    ("scenes.0.extras", {"aliascope": {"title": "t", "shows": "s", "view": {"size": [8, 6]}, LONG: 1}}, "aliascope"),
]


@pytest.mark.parametrize(("where", "value", "told"), WRONG, ids=[f"{w[0]}-{i}" for i, w in enumerate(WRONG)])
def test_each_bound(tmp_path: Path, where: str, value: Any, told: str) -> None:
    scene_io.load_file(written(tmp_path / "m.gltf", *whole()))
    text = refused(written(tmp_path / "m.gltf", *changed(where, value)))
    assert told in text.replace("baseColorFactor", "base_color_factor")


TAKEN: list[tuple[str, Any]] = [
    ("bufferViews.0.byteLength", 36),
    ("bufferViews.0.byteStride", 12),
    ("materials.0.extensions", {"KHR_materials_emissive_strength": {"emissiveStrength": 1e30}}),
    ("scenes.0.extras", [1]),
    ("scenes.0.extras", "aliascope"),
    ("cameras.0.perspective.aspectRatio", 1e-6),
    ("meshes.0.primitives.0.mode", 5),
    ("meshes.0.primitives.0.attributes", {"POSITION": 0, "NORMAL": 1}),
]


@pytest.mark.parametrize(("where", "value"), TAKEN, ids=[f"{w[0]}-{i}" for i, w in enumerate(TAKEN)])
def test_what_is_taken(tmp_path: Path, where: str, value: Any) -> None:
    scene_io.load_file(written(tmp_path / "m.gltf", *changed(where, value)))


def test_an_index_is_below_the_number_of_positions(tmp_path: Path) -> None:
    for kind, corner in ((np.uint8, 3), (np.int8, -1), (np.int16, -30_000)):
        found, data = gltf_files.one_mesh(POINTS, np.array([0, 1, corner], kind))
        assert "and there are 3 positions" in refused(written(tmp_path / "m.gltf", found, data))


# --- counts -----------------------------------------------------------------------------------------------------------


def test_the_limits_of_a_documents_lists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each is reached by the file as it is."""
    path = written(tmp_path / "m.gltf", *whole())
    text = path.read_bytes()
    values = sum(map(text.count, (b",", b"[", b"{")))
    monkeypatch.setattr(document, "MOST_VALUES", values)
    monkeypatch.setattr(reading, "MOST_PRIMITIVES", 1)
    monkeypatch.setattr(reading, "MOST_POSITIONS", 3)
    monkeypatch.setattr(meshes, "MOST_TRIANGLES", 1)
    monkeypatch.setattr(meshes, "LARGEST_FILE", len(text))
    scene_io.load_file(path)
    for module, name, told in (
        (document, "MOST_VALUES", f"more than {values - 1} values"),
        (reading, "MOST_PRIMITIVES", "more than 0 parts"),
        (reading, "MOST_POSITIONS", "more than 2 positions and normals"),
        (meshes, "MOST_TRIANGLES", "more than 0 triangles"),
        (meshes, "LARGEST_FILE", "at most 0 MiB"),
    ):
        with monkeypatch.context() as lowered:
            lowered.setattr(module, name, getattr(module, name) - 1)
            assert told in refused(path)


def test_normals_count_as_positions_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "MOST_POSITIONS", 5)
    path = written(tmp_path / "m.gltf", *changed("meshes.0.primitives.0.attributes", {"POSITION": 0, "NORMAL": 0}))
    assert "more than 5 positions and normals" in refused(path)


def test_how_many_nodes_a_document_has() -> None:
    """Of which so many need not be made here: the schema says it."""
    assert document.Root.model_json_schema()["properties"]["nodes"]["maxItems"] == 1_000_000


def test_extras_that_lie_in_each_other_too_deep(tmp_path: Path) -> None:
    """Tables, which take more of Python's stack than reading them did."""
    deep: Any = 1
    for _ in range(600):
        deep = {"a": deep}
    assert "scene.extras.aliascope" in refused(
        written(tmp_path / "m.gltf", *changed("scenes.0.extras", {"aliascope": deep}))
    )


# --- buffers ----------------------------------------------------------------------------------------------------------


def with_buffer(path: Path, uri: str | None, length: Any = 36) -> Path:
    found, data = gltf_files.one_mesh(POINTS)
    assert len(data) == 36
    found["buffers"] = [{"byteLength": length} | ({} if uri is None else {"uri": uri})]
    path.write_text(json.dumps(found))
    return path


def test_a_buffer_is_as_long_as_it_says(tmp_path: Path) -> None:
    head = "data:application/octet-stream;base64,"
    data = base64.b64encode(POINTS.tobytes() + bytes(100)).decode()
    path = tmp_path / "m.gltf"
    scene_io.load_file(with_buffer(path, head + data))
    assert "more than its buffer holds" in refused(with_buffer(path, head + data, 35))
    assert "buffer 0 has 136 bytes, not 137" in refused(with_buffer(path, head + data, 137))
    for wrong in (0, -1, "36", True):
        assert "buffers.0.byteLength: " in refused(with_buffer(path, head + data, wrong))
    assert "is no base64" in refused(with_buffer(path, head + data.replace("A", "A!", 1)))
    assert "is no base64" in refused(with_buffer(path, head + "é"))
    assert "has neither a uri nor a binary chunk" in refused(with_buffer(path, None))


def test_the_binary_chunk_is_the_first_buffer_alone(tmp_path: Path) -> None:
    found, data = gltf_files.one_mesh(POINTS)
    found["bufferViews"][0]["buffer"] = 1
    found["buffers"] = [{"byteLength": 36}, {"byteLength": 36}]
    text, binary = chunk(document.JSON_CHUNK, json.dumps(found).encode()), chunk(document.BINARY_CHUNK, bytes(data))
    assert "buffer 1 has neither a uri nor a binary chunk" in refused(glb(tmp_path / "m.glb", text, binary))


def test_a_buffer_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """However many accessors it has: each reading counts against the limit of all files."""
    (tmp_path / "m.bin").write_bytes(POINTS.tobytes())
    found, _ = gltf_files.one_mesh(POINTS)
    found["buffers"] = [{"byteLength": 36, "uri": "m.bin"}]
    found["accessors"] *= 5
    found["meshes"][0]["primitives"] = [{"attributes": {"POSITION": number}} for number in range(5)]
    path = tmp_path / "m.gltf"
    path.write_text(json.dumps(found))
    size = path.stat().st_size
    asked: list[int] = []

    def counted(path: Path, most: int, *rest: str) -> bytes:
        asked.append(most)
        return bounded.read_bytes(path, most, *rest)

    monkeypatch.setattr(document, "read_bytes", counted)
    monkeypatch.setattr(meshes, "LARGEST_FILE", size + 36)
    assert len(scene_io.load_file(path).scene.surfaces) == 5
    assert asked == [size + 36, 36]  # the file could have grown


@pytest.mark.parametrize(
    "uri",
    [LONG, f"../{LONG}", f"x:{LONG}", "\\ud800.bin", "a/" * 2000 + "b.bin", ""],
    ids=["word", "outside", "scheme", "half", "deep", "none"],
)
def test_names_that_are_none_are_told_in_short(tmp_path: Path, uri: str) -> None:
    path = with_buffer(tmp_path / "m.gltf", uri)
    path.write_text(path.read_text().replace("\\\\", "\\"))  # what JSON has for half a character
    refused(path)


# --- the container ----------------------------------------------------------------------------------------------------


def chunk(kind: int, text: bytes) -> bytes:
    return struct.pack("<II", len(text), kind) + text


def glb(path: Path, *chunks: bytes, version: int = 2, less: int = 0) -> Path:
    body = b"".join(chunks)
    path.write_bytes(struct.pack("<III", document.MAGIC, version, 12 + len(body) - less) + body)
    return path


def test_the_chunks_of_a_container(tmp_path: Path) -> None:
    found, data = gltf_files.one_mesh(POINTS)
    found["buffers"] = [{"byteLength": len(data)}]
    text, binary = chunk(document.JSON_CHUNK, json.dumps(found).encode()), chunk(document.BINARY_CHUNK, bytes(data))
    path = tmp_path / "m.glb"
    scene_io.load_file(glb(path, text, binary))
    # The first of a kind is it, others are passed over, and so is a rest that is no head of a chunk.
    scene_io.load_file(glb(path, chunk(7, b"x"), text, binary, chunk(document.JSON_CHUNK, b"{"), b"rest"))
    assert "no GLB of version 2" in refused(glb(path, text, binary, version=1))
    assert "is cut off" in refused(glb(path, text, binary, less=-1))
    assert "a chunk is longer than the file" in refused(glb(path, text, binary, less=1))
    assert "it has no JSON chunk" in refused(glb(path, binary))
    path.write_bytes(struct.pack("<III", document.MAGIC, 2, 12)[:11])
    assert "is cut off" in refused(path)


TEXTS = {"deep": "[" * 100_000, "word": f"{{{LONG}", "nan": '{"a": NaN}', "inf": '{"a": -Infinity}', "long": "9" * 5000}


@pytest.mark.parametrize("text", TEXTS)
def test_text_that_is_no_json_is_told_in_short(tmp_path: Path, text: str) -> None:
    (tmp_path / "m.gltf").write_text(TEXTS[text])
    assert "not glTF: " in refused(tmp_path / "m.gltf")


# --- what stops nothing -----------------------------------------------------------------------------------------------


def test_strips_and_normals_of_too_few(tmp_path: Path) -> None:
    for mode, count in ((4, 2), (5, 2), (5, 1), (6, 2), (6, 1)):
        found, data = gltf_files.one_mesh(POINTS, CORNERS[:count], mode=mode)
        found["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = gltf_files.view_of(found, data, POINTS)
        assert "has no triangles" in refused(written(tmp_path / "m.gltf", found, data))
    for normals in (POINTS[:1], np.array([1, 2, 3], np.float32)):
        found, data = gltf_files.one_mesh(POINTS, CORNERS)
        found["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = gltf_files.view_of(found, data, normals)
        assert not any("smooth" in note for note in scene_io.load_file(written(tmp_path / "m.gltf", found, data)).notes)


def test_a_camera_that_looks_away_looks_ahead_all_the_same(tmp_path: Path) -> None:
    """From (0.3, 0.2, 5), along +z, and in the plane of all there is."""
    camera = scene_io.load_file(written(tmp_path / "m.gltf", *changed("nodes.1.rotation", [0, 1, 0, 0]))).scene.camera
    assert camera.look_at == pytest.approx((0.3, 0.2, 6.0))
    camera = scene_io.load_file(written(tmp_path / "m.gltf", *changed("nodes.1.translation", [0, 0, 0]))).scene.camera
    assert camera.look_at == pytest.approx((0.0, 0.0, -1.0))


def test_words_of_a_file_are_short_and_steer_nothing(tmp_path: Path) -> None:
    found, data = whole()
    found["materials"][0] |= {"name": "\x1b" + LONG, "alphaMode": "BLEND", "extensions": {"\x1b" + LONG: 1}}
    found["scenes"][0]["name"] = "\x1b" + LONG
    read = scene_io.load_file(written(tmp_path / "m.gltf", found, data))
    for told in (read.scene.title, read.scene.shows, *read.notes, *read.scene.materials):
        assert told.isprintable()
        assert len(told) < 1500
    own = {"title": "\x1b" + "t" * 3000, "shows": "\x1b" + "s" * 30_000, "view": {"size": [8, 6]}}
    found["scenes"][0]["extras"] = {"aliascope": own}
    scene = scene_io.load_file(written(tmp_path / "m.gltf", found, data)).scene
    for told, most in ((scene.title, 1000), (scene.shows, 20_000)):
        assert told.isprintable()
        assert len(told) <= most
