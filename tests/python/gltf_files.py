"""glTF files put together by hand, chunk by chunk, to be read by what is tested."""

from __future__ import annotations

import base64
import copy
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

CAMERA = {"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.5, "znear": 0.01}}


def view_of(document: dict[str, Any], data: bytearray, values: np.ndarray, stride: int | None = None) -> int:
    """Appends an array, one element a row, as an accessor with a view of its own; the accessor's number."""
    kinds = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
    rows = values.reshape(len(values), -1)
    packed = [row.tobytes() for row in rows]
    if stride:
        packed = [row.ljust(stride, b"\xff") for row in packed]
    data.extend(b"\xee" * (-len(data) % 4))
    view = {"buffer": 0, "byteOffset": len(data), "byteLength": sum(map(len, packed))}
    document.setdefault("bufferViews", []).append(view | ({"byteStride": stride} if stride else {}))
    data.extend(b"".join(packed))
    accessor = {
        "bufferView": len(document["bufferViews"]) - 1,
        "componentType": kinds[str(values.dtype)],
        "count": len(rows),
        "type": {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[rows.shape[1]],
    }
    document.setdefault("accessors", []).append(accessor)
    return len(document["accessors"]) - 1


def one_mesh(
    points: np.ndarray, indices: np.ndarray | None = None, node: dict[str, Any] | None = None, **more: Any
) -> tuple[dict[str, Any], bytearray]:
    """A document of one mesh under one node and one camera at (0.3, 0.2, 5), and its data. `more` are further keys of
    its primitive."""
    document: dict[str, Any] = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}]}
    data = bytearray()
    primitive = {"attributes": {"POSITION": view_of(document, data, points.astype(np.float32))}, **more}
    if indices is not None:
        primitive["indices"] = view_of(document, data, indices)
    document["meshes"] = [{"primitives": [primitive]}]
    document["nodes"] = [{"mesh": 0, **(node or {})}, {"camera": 0, "translation": [0.3, 0.2, 5.0]}]
    document["cameras"] = [copy.deepcopy(CAMERA)]
    return document, data


def glb(path: Path, document: dict[str, Any], data: bytes | bytearray = b"") -> Path:
    """Writes a .glb."""
    if data:
        document = {**document, "buffers": [{"byteLength": len(data)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if data:
        padded = bytes(data) + b"\0" * (-len(data) % 4)
        chunks += struct.pack("<II", len(padded), 0x004E4942) + padded
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)
    return path


def gltf(path: Path, document: dict[str, Any], data: bytes | bytearray, uri: str | None = None) -> Path:
    """Writes a .gltf, its data within it, or said to be at `uri`."""
    uri = uri or "data:application/octet-stream;base64," + base64.b64encode(bytes(data)).decode()
    path.write_text(json.dumps({**document, "buffers": [{"byteLength": len(data), "uri": uri}]}))
    return path
