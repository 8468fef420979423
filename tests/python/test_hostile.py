"""Scenes, meshes, glTF, pictures and points of somebody else: what they may not reach, start, use up or hang."""

from __future__ import annotations

import base64
import json
import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gltf_files
import numpy as np
import OpenImageIO as oiio  # the name that its own documentation uses
import pytest
from commands import complaint
from hostile_files import read
from test_scene_io import WHOLE

from aliascope import bounded, errors, image, meshes, model, renderers, scene_io, specs, toml_files
from aliascope.gltf import document, reading
from aliascope.references import files as references
from aliascope.renderers import external_scenes, povray_sdl
from aliascope.renderers.base import Request
from aliascope.studies import point_files

MESH = '\n[[surfaces]]\ntype = "mesh"\nmaterial = "paper"\nfile = "{}"\n'
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
MODE = renderers.mode_of(renderers.find("embree"), "uniform")
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The scene's, beside one with a mesh, a buffer and a picture that are none of its business."""
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "mesh.obj").write_text(OBJ)
    (tmp_path / "other" / "data.bin").write_bytes(POINTS.tobytes())
    scene = tmp_path / "scene"
    scene.mkdir()
    (scene / "link.obj").symlink_to(tmp_path / "other" / "mesh.obj")
    (scene / "link.bin").symlink_to(tmp_path / "other" / "data.bin")
    (scene / "out").symlink_to(tmp_path / "other")
    (scene / "round.obj").symlink_to(scene / "round.obj")
    os.mkfifo(scene / "pipe.obj")
    (scene / "zero.obj").symlink_to("/dev/zero")
    return scene


def refused(kind: type[errors.AliascopeError], function: Callable[..., Any], *arguments: Any) -> str:
    with pytest.raises(kind) as caught:
        function(*arguments)
    return str(caught.value)


# --- places -----------------------------------------------------------------------------------------------------------

PLACES = {
    "../other/mesh.obj": "leads out of",
    "{other}/mesh.obj": "leads out of",
    "link.obj": "leads out of",
    "out/mesh.obj": "leads out of",
    "out/../other/mesh.obj": "leads out of",
    "zero.obj": "leads out of",
    "/dev/zero": "leads out of",
    "round.obj": "",
    "pipe.obj": "it is no file, but a pipe or a device",
    "..\\\\other\\\\mesh.obj": "No such file",
    "C:\\\\mesh.obj": "No such file",
    "file:///etc/passwd.obj": "No such file",
    "a\\u0000.obj": "is no name of a file",
    "https://example.org/mesh.obj": "No such file",
    "sub": "a mesh is one of",
}


@pytest.mark.parametrize("name", PLACES)
def test_a_mesh_lies_in_the_scenes_folder(folder: Path, name: str) -> None:
    (folder / "scene.toml").write_text(WHOLE + MESH.format(name.format(other=folder.parent / "other")))
    said = refused(errors.InvalidInput, scene_io.load_file, folder / "scene.toml")
    assert PLACES[name] in said
    assert f"scene.toml:{WHOLE.count(chr(10)) + 5}: surfaces.file" in said


URIS = {
    "../other/data.bin": "leads out of",
    "%2e%2e/other/data.bin": "leads out of",
    "%2E%2E%2Fother%2Fdata.bin": "leads out of",
    "%252e%252e/other/data.bin": "No such file",
    "{other}/data.bin": "leads out of",
    "file://{other}/data.bin": "which is no file beside it",
    "FILE:{other}/data.bin": "which is no file beside it",
    "http://127.0.0.1:9/data.bin": "which is no file beside it",
    "C:%5Cdata.bin": "which is no file beside it",
    "..%5Cother%5Cdata.bin": "No such file",
    "data.bin%00.png": "is no name of a file",
    "link.bin": "leads out of",
    "out/data.bin": "leads out of",
    "/dev/zero": "leads out of",
    "pipe.obj": "it is no file, but a pipe or a device",
    "data:application/octet-stream;base64,@@@": "is no base64",
    "data:,plain": "has 0 bytes",
}


@pytest.mark.parametrize("uri", URIS)
def test_a_buffer_lies_in_the_scenes_folder(folder: Path, uri: str) -> None:
    found, data = gltf_files.one_mesh(POINTS)
    found["buffers"] = [{"byteLength": len(data), "uri": uri.format(other=folder.parent / "other")}]
    (folder / "scene.gltf").write_text(json.dumps(found))
    assert URIS[uri] in refused(errors.InvalidInput, scene_io.load_file, folder / "scene.gltf")


def test_what_lies_beside_the_scene_is_read(folder: Path) -> None:
    """So that the refusals above are of the places."""
    (folder / "in").mkdir()
    (folder / "in" / "a b.obj").write_text(OBJ)
    (folder / "scene.toml").write_text(WHOLE + MESH.format("in/../in/a b.obj"))
    scene_io.load_file(folder / "scene.toml")
    found, data = gltf_files.one_mesh(POINTS)
    (folder / "in" / "a b.bin").write_bytes(data)
    found["buffers"] = [{"byteLength": len(data), "uri": "in/a%20b.bin"}]
    (folder / "scene.gltf").write_text(json.dumps(found))
    scene_io.load_file(folder / "scene.gltf")


def test_pipes_and_devices_are_no_files(tmp_path: Path) -> None:
    """None of these may wait for a writer that does not come, or read what does not end."""
    readers = {"toml": ("scene", "renderer"), "gltf": ("scene",), "glb": ("scene",), "pov": ("pov",)}
    readers |= {"exr": ("picture", "header"), "png": ("picture", "header"), "csv": ("points",), "npy": ("points",)}
    files = []
    for ending, kinds in readers.items():
        pipe, device = tmp_path / f"pipe.{ending}", tmp_path / f"device.{ending}"
        os.mkfifo(pipe)
        device.symlink_to("/dev/zero")
        files += [(kind, path) for kind in kinds for path in (pipe, device)]
    for said in read(files):
        assert "it is no file, but a pipe" in said


@pytest.mark.parametrize("name", ["...toml", "\x1b]0;x\x07.toml", "a\nb.toml", "\u202egnp.toml", "n" * 210])
def test_the_name_of_a_scene_is_no_other_folder_and_steers_no_terminal(tmp_path: Path, name: str) -> None:
    """Results and references lie in a folder of its name."""
    path = tmp_path / f"{name.removesuffix('.toml')}.toml"
    path.write_text(WHOLE)
    said = complaint("render", path, "-r", "embree", "-m", "uniform", "-o", tmp_path / "x.exr", code=2)
    assert "a scene is named as its file" in said
    assert said.isprintable()


@pytest.mark.parametrize("name", ["=cmd|' calc'!A0.toml", "+1.glb", "-1.toml", "@SUM(1).pov"])
def test_the_name_of_a_scene_is_no_formula(tmp_path: Path, name: str) -> None:
    """It stands in tables that are opened by spreadsheets."""
    path = tmp_path / name
    path.write_text(WHOLE)
    words = ("sweep", path, "--budget", "5s", "-o", tmp_path / "out")
    said = complaint(*words, code=2)
    assert f"a name that begins with {name[0]} for a formula: rename it" in said
    assert not (tmp_path / "out").exists()


def test_a_command_that_is_shown_is_quoted() -> None:
    """It is there to be copied into a shell."""
    scene = scene_io.load("edge").scene
    assert references.command_for("a; touch x", scene, (8, 8), "box").startswith("aliascope reference 'a; touch x' ")


# --- too much ---------------------------------------------------------------------------------------------------------


def toml(path: Path, text: str) -> tuple[str, Path]:
    path.write_text(text)
    return "scene", path


def gltf(path: Path, found: dict[str, Any], data: bytes | bytearray = b"") -> tuple[str, Path]:
    return "scene", gltf_files.glb(path, found, data)


def toml_cases(folder: Path) -> dict[str, tuple[tuple[str, Path], str]]:
    """By name a file, and what is said of it."""
    mesh = MESH.format("m.obj")
    (folder / "m.obj").write_text(OBJ)
    many = {
        "lists": (f"{WHOLE}\nx = {'[' * 200_000}", "hundreds deep"),
        "tables": (f"{WHOLE}\nx = {'{a=' * 100_000}", "hundreds deep"),
        "keys": (f"{'a.' * 500_000}a = 1\n", "1: a key has at most 32 parts"),
        "spaced": (f"x = 1\n{'a . ' * 500_000}a = 1\n", "2: a key has at most 32 parts"),
        "headers": (f"[{'a.' * 500_000}a]\n", "1: a key has at most 32 parts"),
        "quoted": ("[" + '"a".' * 100_000 + '"a"]\n', "1: a key has at most 32 parts"),
        "inline": (f"x = {{ {'a.' * 100_000}a = 1 }}\n", "1: a key has at most 32 parts"),
        "digits": (WHOLE.replace("size = [", f"size = [{'9' * 5000}, "), "integer"),
        "hexadecimal": (WHOLE.replace("size = [8, 6]", f"size = [0x{'f' * 500_000}, 6]"), "digits"),
        "title": (WHOLE.replace("title = ", f"title = '{'x' * 5_000_000}'\n#"), "at most 1000 characters"),
        "material": (WHOLE + MESH.format("m.obj").replace('"paper"', f'"{"x" * 2000}"'), "at most 1000 characters"),
        "unknown": (WHOLE + mesh.replace('"paper"', f'"{"p" * 900}"'), "unknown material"),
        "lights": (
            WHOLE + '\n[[lights]]\ntype="point"\nposition=[0,0,0]\nintensity=[1,1,1]\n' * 10_001,
            "at most 10000 items",
        ),
        "corners": (f'{WHOLE}{MESH.format("")}'.replace('file = ""', "points = [" + "[0.0,0.0,0.0]," * 20_001 + "]")
                    .replace('"mesh"', '"polygon"'), "at most 20000 items"),
        "frames": (
            WHOLE.replace("[camera]", "[camera]\nshutter = [0.0, 1.0]")
            + mesh + 'motion = { type = "frames", files = [' + '"m.obj",' * 129 + "] }\n",
            "at most 128 items",
        ),
        "escape": (WHOLE.replace("title = ", 'title = "\\u001b]0;pwned\\u0007"\n#'), "has control characters"),
        "key": (f'{WHOLE}\n"\\u001b[31m{"k" * 3000}" = 1\n', "unknown key"),
    }  # fmt: skip
    return {name: (toml(folder / f"{name}.toml", text), said) for name, (text, said) in many.items()}


def test_toml_that_is_too_much(tmp_path: Path) -> None:
    cases = toml_cases(tmp_path)
    for (name, (_, wanted)), said in zip(cases.items(), read([file for file, _ in cases.values()]), strict=True):
        assert said.startswith("InvalidInput"), (name, said[:300])
        assert wanted in said, (name, said[:300])
        assert len(said) < 1500, name


def nodes(count: int, children: Callable[[int], list[int]]) -> dict[str, Any]:
    found, _ = gltf_files.one_mesh(POINTS)
    return found | {"nodes": [{"children": children(i)} for i in range(count)], "scenes": [{"nodes": [0]}]}


def gltf_cases(folder: Path) -> dict[str, tuple[tuple[str, Path], str]]:
    plain, data = gltf_files.one_mesh(POINTS)

    def changed(**more: Any) -> dict[str, Any]:
        return {**json.loads(json.dumps(plain)), **more}

    accessor = {"componentType": 5126, "type": "VEC3", "count": document.MOST_ELEMENTS}
    primitive = {"attributes": {"POSITION": 1}}
    crowd = [{"mesh": 0} for _ in range(1000)]
    strip = changed(accessors=[plain["accessors"][0], accessor], meshes=[{"primitives": [primitive] * 2}])
    deep: Any = 1
    for _ in range(900):
        deep = [deep]
    many = {
        "doubling": (nodes(60, lambda i: [i + 1, i + 1] if i < 59 else []), "has more than one parent"),
        "cycle": (nodes(3, lambda i: [(i + 1) % 3]), "has more than one parent, or is its own"),
        "itself": (nodes(1, lambda i: [0]), "has more than one parent, or is its own"),
        "nowhere": (nodes(2, lambda i: [1 << 40]), "names node 1099511627776"),
        "chain": (nodes(100_000, lambda i: [i + 1] if i < 99_999 else []), "has no triangles"),
        "parts": (
            changed(
                nodes=crowd, scenes=[{"nodes": list(range(1000))}],
                meshes=[{"primitives": plain["meshes"][0]["primitives"] * 1000}],
            ),
            "draws more than 200000 parts",
        ),
        "triangles": (strip, "has more than 4000000 triangles"),
        "instances": (
            strip | {
                "meshes": [{"primitives": [{"attributes": {"POSITION": 1, "NORMAL": 1}, "indices": 0}]}],
                "nodes": crowd, "scenes": [{"nodes": list(range(1000))}],
            },
            "has more than 1200000000 positions and normals",
        ),
        "count": (changed(accessors=[{**accessor, "count": 1 << 40}]), "less than or equal to 12000000"),
        "view": (changed(bufferViews=[{"buffer": 0, "byteLength": 1 << 62}]), "more than its buffer holds"),
        "offset": (changed(bufferViews=[{"buffer": 0, "byteOffset": 1 << 63, "byteLength": 36}]), "than its buffer"),
        "extras": (changed(scenes=[{"nodes": [0], "extras": {"aliascope": deep}}]), "scene.extras.aliascope"),
        "nested": (changed(extras=[]), "read"),
        "names": (changed(materials=[{"name": "\x1b[31m" + "n" * 100_000}],
                          meshes=[{"primitives": [{**plain["meshes"][0]["primitives"][0], "material": 0}]}]), "read"),
    }  # fmt: skip
    cases = {name: (gltf(folder / f"{name}.glb", found, data), said) for name, (found, said) in many.items()}
    text = json.dumps(plain)
    raw = {
        "brackets": (text.replace("{", '{"extras": ' + "[" * 1_000_000 + "]" * 1_000_000 + ", ", 1), "not glTF"),
        "values": (text.replace("{", '{"extras": [' + "[]," * 10_100_000 + "0], ", 1), "more than 20000000 values"),
        "digits": (text.replace("{", '{"extras": ' + "9" * 10_000 + ", ", 1), "not glTF"),
    }
    for name, (contents, said) in raw.items():
        path = folder / f"{name}.gltf"
        path.write_text(contents)
        cases[name] = ("scene", path), said
    cut = folder / "cut.glb"
    cut.write_bytes(struct.pack("<III", document.MAGIC, 2, 0xFFFFFFFF) + b"x" * 100)
    cases["cut"] = ("scene", cut), "is cut off"
    return cases


def test_gltf_that_is_too_much(tmp_path: Path) -> None:
    cases = gltf_cases(tmp_path)
    for (name, (_, wanted)), said in zip(cases.items(), read([file for file, _ in cases.values()]), strict=True):
        assert wanted in said, (name, said[:300])
        assert "CRASH" not in said, (name, said[:300])
        assert len(said) < 1500, name


def test_a_data_uri_is_as_long_as_its_file_may_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of which the limit, 256 MiB, is small here."""
    monkeypatch.setattr(meshes, "LARGEST_FILE", 1 << 20)
    found, data = gltf_files.one_mesh(POINTS)
    uri = "data:application/octet-stream;base64," + base64.b64encode(bytes(1 << 20)).decode()
    found["buffers"] = [{"byteLength": len(data), "uri": uri}]
    (tmp_path / "scene.gltf").write_text(json.dumps(found))
    assert "at most 1 MiB" in refused(errors.InvalidInput, scene_io.load_file, tmp_path / "scene.gltf")
    # What lies beside it counts too, each time.
    (tmp_path / "data.bin").write_bytes(bytes(600 << 10))
    found["buffers"] = [{"byteLength": 600 << 10, "uri": "data.bin"}] * 2
    found["accessors"].append({**found["accessors"][0], "bufferView": 1})
    found["bufferViews"].append({**found["bufferViews"][0], "buffer": 1})
    found["meshes"][0]["primitives"].append({"attributes": {"POSITION": 1}})
    (tmp_path / "scene.gltf").write_text(json.dumps(found))
    assert "at most 1 MiB" in refused(errors.InvalidInput, scene_io.load_file, tmp_path / "scene.gltf")


def mesh_cases(folder: Path) -> dict[str, tuple[tuple[str, Path], str]]:
    plain, data = gltf_files.one_mesh(POINTS)
    doubling = nodes(40, lambda i: [i + 1, i + 1] if i < 39 else [])
    huge = {**plain, "accessors": [{"componentType": 5126, "type": "VEC3", "count": 1 << 31}]}
    header = "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
    faces = "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
    huge_faces = header.format("binary_little_endian", 0) + faces.format(10**15)
    written = {
        "claims.stl": bytes(80) + struct.pack("<I", 0xFFFFFFFF) + bytes(50),
        "claims.ply": (header.format("binary_little_endian", 10**15) + faces.format(10**15)).encode() + bytes(100),
        "faces.ply": huge_faces.encode() + bytes(100),
        "text.ply": (header.format("ascii", 10**15) + faces.format(10**15)).encode() + b"0 0 0\n",
        "claims.off": b"OFF\n1000000000000 1000000000000 0\n0 0 0\n",
        "index.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4000000000000\n",
        "huge.obj": b"v 1e400 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "material.obj": b"mtllib ../../../../etc/passwd\nusemtl root\n" + OBJ.encode() + b"f 1 1 1\n",
    }
    cases = {}
    for name, contents in written.items():
        (folder / name).write_bytes(contents)
        cases[name] = ""
    gltf_files.glb(folder / "doubling.glb", doubling, data)
    gltf_files.glb(folder / "huge.glb", huge, data)
    cases |= {"doubling.glb": "has more than one parent", "huge.glb": "less than or equal to 12000000"}
    return {name: (toml(folder / f"{name}.toml", WHOLE + MESH.format(name)), said) for name, said in cases.items()}


def test_meshes_that_claim_too_much(tmp_path: Path) -> None:
    cases = mesh_cases(tmp_path)
    for (name, (_, wanted)), said in zip(cases.items(), read([file for file, _ in cases.values()]), strict=True):
        assert said.startswith("InvalidInput"), (name, said[:300])
        assert wanted in said, (name, said[:300])


def test_meshes_of_a_scene_have_limits_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "m.obj").write_text(OBJ)
    path = tmp_path / "scene.toml"
    path.write_text(WHOLE + MESH.format("m.obj") * 5)
    assert len(scene_io.load_file(path).scene.surfaces) == 7
    monkeypatch.setattr(meshes, "MOST_OF_A_SCENE", 4)
    assert "at most 4 triangles, frames too" in refused(errors.InvalidInput, scene_io.load_file, path)
    monkeypatch.setattr(meshes, "MOST_OF_A_SCENE", 5)
    monkeypatch.setattr(meshes, "LARGEST_FILES", 4)
    assert "at most 0 MiB together" in refused(errors.InvalidInput, scene_io.load_file, path)
    monkeypatch.setattr(model, "MOST_SQUARES", 8)
    assert "add up to more than 8" in refused(errors.InvalidInput, scene_io.load_file, path)


# --- pictures ---------------------------------------------------------------------------------------------------------


def png(path: Path, width: int, height: int, rows: bytes = b"") -> Path:
    """Grey, of 8 bits, whose rows are compressed; the header says whatever it is to say."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + body)
    return path


def exr_of(path: Path, width: int, height: int) -> Path:
    """A real one whose header is changed afterwards to claim another size."""
    out = oiio.ImageOutput.create(str(path))
    assert out is not None
    assert out.open(str(path), oiio.ImageSpec(4, 4, 3, "float"))
    assert out.write_image(np.zeros((4, 4, 3), np.float32))
    assert out.close()
    window, claimed = struct.pack("<4i", 0, 0, 3, 3), struct.pack("<4i", 0, 0, width - 1, height - 1)
    path.write_bytes(path.read_bytes().replace(window, claimed))
    return path


def test_pictures_that_claim_too_much(tmp_path: Path) -> None:
    pictures = [
        png(tmp_path / "wide.png", 0x7FFFFFFF, 0x7FFFFFFF),
        png(tmp_path / "large.png", 30_000, 30_000),
        exr_of(tmp_path / "wide.exr", 1 << 30, 1 << 30),
        exr_of(tmp_path / "large.exr", 30_000, 30_000),
        exr_of(tmp_path / "tall.exr", 4, 1 << 30),
    ]
    (tmp_path / "claims.pfm").write_bytes(b"PF\n2000000000 2000000000\n-1.0\n" + bytes(64))
    (tmp_path / "claims.hdr").write_bytes(
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n" + bytes(64)
    )
    pictures += [tmp_path / "claims.pfm", tmp_path / "claims.hdr"]
    for path, said in zip(pictures, read([("picture", path) for path in pictures]), strict=True):
        assert said.startswith("InvalidInput"), (path, said)
    assert "at most 268435456 are read" in refused(errors.InvalidInput, image.read_image, tmp_path / "large.png")


def test_a_picture_that_swells_is_read_as_far_as_it_may(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """8 KiB that are 8 MiB unpacked, of which the header tells as much."""
    path = png(tmp_path / "swells.png", 2048, 4096, bytes(2049 * 4096))
    assert path.stat().st_size < 20_000
    assert image.read_image(path).shape == (4096, 2048, 1)
    monkeypatch.setattr(image, "LARGEST_PICTURE", 2048 * 4096 - 1)
    assert "says that it has 8388608 values" in refused(errors.InvalidInput, image.read_image, path)
    # And more rows than the header tells are not unpacked.
    more = png(tmp_path / "more.png", 8, 8, bytes(50_000_000))
    assert image.read_image(more).shape == (8, 8, 1)


# --- points, specs ----------------------------------------------------------------------------------------------------


def test_points_that_are_too_many(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "points.csv"
    path.write_text(",".join(["0.5"] * 10_001) + "\n")
    said = refused(errors.InvalidInput, point_files.read_points, str(path))
    assert "points.csv:1: has 10001 columns; points have at most 10000 dimensions" in said
    path.write_text("0.5," * (1 << 21))
    assert "points.csv:1: is too long a line" in refused(errors.InvalidInput, point_files.read_points, str(path))
    monkeypatch.setattr(point_files, "MOST_NUMBERS", 1000)
    path.write_text("0.5 0.5\n" * 501)
    np.save(tmp_path / "points.npy", np.full((501, 2), 0.5))
    for name in (path, tmp_path / "points.npy"):
        said = refused(errors.InvalidInput, point_files.read_points, str(name))
        assert "has more than 1000 numbers, the most that are read" in said


def test_npy_headers_that_claim_too_much(tmp_path: Path) -> None:
    def header(text: str, length: int | None = None) -> bytes:
        packed = text.encode()
        return b"\x93NUMPY\x02\x00" + struct.pack("<I", len(packed) if length is None else length) + packed

    shapes = ["(1000000000000, 2)", "(2, 1000000000000)", "(-1, 2)", "(2, 0)", "(" * 5000 + ")" * 5000]
    files = []
    for number, shape in enumerate(shapes):
        path = tmp_path / f"{number}.npy"
        path.write_bytes(header(f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n"))
        files.append(path)
    objects = tmp_path / "objects.npy"
    np.save(objects, np.array([[print]], object), allow_pickle=True)
    long = tmp_path / "long.npy"
    long.write_bytes(header("{", 0xFFFFFFFF))
    with (tmp_path / "sparse.npy").open("wb") as file:
        file.write(header("{", 0xFFFFFFFF))
        file.truncate(5 << 30)
    files += [objects, long, tmp_path / "sparse.npy"]
    for path, said in zip(files, read([("points", path) for path in files]), strict=True):
        assert said.startswith("InvalidInput"), (path, said)


@pytest.mark.parametrize(
    "text",
    [
        "uniform:" + "n=1," * 5000,
        "uniform:" + "sampler." * 5000 + "x=1",
        "x" * 5000,
        "uniform:n=" + "9" * 4090,
        "uniform:n=1e999",
        "adaptive:method.tolerance=nan",
    ],
)
def test_specs_that_are_too_much(text: str) -> None:
    said = refused(errors.SpecError, renderers.mode_of, renderers.find("embree"), text)
    assert len(text) <= specs.LONGEST or f"at most {specs.LONGEST} characters, not {len(text)}" in said


def test_near_misses_of_much(monkeypatch: pytest.MonkeyPatch) -> None:
    """Comparing words takes as long as the square of their length."""
    assert errors.near_misses("x" * 10_000_000, ["y" * 1_000_000]).startswith("; known: ")
    told = errors.near_misses("x", [f"material {n}" for n in range(200_000)])
    assert "and 199500 more" in told
    assert len(told) < 15_000


# --- words ------------------------------------------------------------------------------------------------------------

SCRIPTS = (
    '"};</script><script>alert(1)</script>',
    '*/ #include "/etc/passwd" /*\n#fopen F "x" write',
    "`id` $(id) ; id",
)


@pytest.mark.parametrize("words", SCRIPTS)
def test_words_of_a_scene_are_in_no_program(tmp_path: Path, words: str) -> None:
    """POV-Ray's language has numbers alone of a scene; a TOML file has its words as words. Shaders are texts of the
    rasteriser's, to which a scene's words do not go."""
    scene = scene_io.load("edge").scene
    names = {name: f"{words}{number}" for number, name in enumerate(scene.materials)}
    named = scene.model_copy(
        update={
            "title": words,
            "shows": words,
            "materials": {names[name]: each for name, each in scene.materials.items()},
            "surfaces": tuple(s.model_copy(update={"material": names[s.material]}) for s in scene.surfaces),
        }
    )
    assert povray_sdl.scene_text(named, (8, 6)) == povray_sdl.scene_text(scene, (8, 6))
    request = Request(named, 8, 6, MODE)
    external_scenes.FORMATS["scene.toml"].write(tmp_path / "scene.toml", request)
    again = scene_io.load_file(tmp_path / "scene.toml").scene
    assert (again.title, again.shows) == (words, words)
    assert set(again.materials) == set(named.materials)


def test_any_character_of_a_name_goes_to_another_program(tmp_path: Path) -> None:
    for words in ("\U0001f600 \x7f é", "a\tb\nc", '"""', "\\"):
        scene = scene_io.load("edge").scene.model_copy(update={"title": words})
        request = Request(scene, 8, 6, MODE)
        external_scenes.FORMATS["scene.toml"].write(tmp_path / "scene.toml", request)
        data, _ = toml_files.read(tmp_path / "scene.toml", "scene")
        assert data["title"] == words


@pytest.mark.parametrize("key", ["renderer", "plugin", "command", "include", "program", "script"])
def test_a_scene_names_no_program(tmp_path: Path, key: str) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(f'{key} = "/bin/sh"\n{WHOLE}')
    assert f'unknown key "{key}"' in refused(errors.InvalidInput, scene_io.load_file, path)


def test_what_steers_a_terminal_is_shown_escaped(tmp_path: Path) -> None:
    assert bounded.as_shown("a\x1b[31m\x9b\x7f\u202e\ud800é") == "a\\x1b[31m\\x9b\\x7f\\u202e\\ud800é"
    assert bounded.as_shown("plain, ± 10^-3 日本") == "plain, ± 10^-3 日本"
    found, data = gltf_files.one_mesh(POINTS, material=0)
    found["materials"] = [{"name": "\x1b[31mred\x07", "alphaMode": "BLEND"}]
    found["scenes"][0]["name"] = "\x1b]0;title\x07\ud800"
    read_ = reading.read(gltf_files.glb(tmp_path / "scene.glb", found, data))
    told = " ".join([read_.scene.title, read_.scene.shows, *read_.scene.materials, *read_.notes])
    assert told.isprintable()
    assert "\\x1b[31mred\\x07" in told
    line = complaint("render", "no\x1b[31msuch", "-r", "embree", "-m", "uniform", "-o", tmp_path / "x.exr", code=2)
    assert "no\\x1b[31msuch" in line
    assert line.isprintable()
