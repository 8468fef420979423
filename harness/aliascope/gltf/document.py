"""A glTF file as it is stored: its JSON, validated, and the numbers in its buffers, each checked against its bounds
before anything is made of it."""

from __future__ import annotations

import base64
import binascii
import contextlib
import json
import struct
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.alias_generators import to_camel

from aliascope import meshes
from aliascope.bounded import read_bytes, shortened
from aliascope.errors import InvalidInput

ENDINGS = (".glb", ".gltf")

MAGIC, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942

MOST_ELEMENTS = 3 * meshes.MOST_TRIANGLES
"""Of an accessor: the corners of as many triangles as a mesh may have."""

MOST_NODES = 1_000_000

MOST_VALUES = 20_000_000
"""Of the JSON: numbers, words, lists and tables."""

READ_EXTENSIONS = ("KHR_lights_punctual", "KHR_mesh_quantization", "KHR_materials_", "KHR_texture_", "EXT_texture_")
"""What a file may require: the first two are read, and without the others its shapes are the same."""

Checked = TypeVar("Checked", bound=BaseModel)
Item = TypeVar("Item")

Index = Annotated[int, Field(strict=True, ge=0)]
Real = Annotated[float, Field(allow_inf_nan=False)]
Vector = tuple[Real, Real, Real]
Unit = Annotated[float, Field(ge=0.0, le=1.0)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
AboveZero = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


class Part(BaseModel):
    """Keys are as in the file, in camel case; those that do not matter here are passed over."""

    model_config = ConfigDict(frozen=True, extra="ignore", alias_generator=to_camel)


class Asset(Part):
    version: str
    min_version: str | None = None


class Buffer(Part):
    uri: str | None = None
    byte_length: Annotated[int, Field(strict=True, ge=1)]


class BufferView(Part):
    buffer: Index
    byte_offset: Index = 0
    byte_length: Annotated[int, Field(strict=True, ge=1)]
    byte_stride: Annotated[int, Field(strict=True, ge=4, le=252)] | None = None


class Accessor(Part):
    buffer_view: Index | None = None
    byte_offset: Index = 0
    component_type: Literal[5120, 5121, 5122, 5123, 5125, 5126]
    normalized: bool = False
    count: Annotated[int, Field(strict=True, ge=1, le=MOST_ELEMENTS)]
    type: Literal["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"]
    sparse: dict[str, Any] | None = None


class Primitive(Part):
    attributes: dict[str, Index]
    indices: Index | None = None
    material: Index | None = None
    mode: Annotated[int, Field(strict=True, ge=0, le=6)] = 4
    targets: list[Any] = []
    extensions: dict[str, Any] = {}


class Mesh(Part):
    primitives: Annotated[tuple[Primitive, ...], Field(min_length=1)]


class Node(Part):
    name: str = ""
    children: tuple[Index, ...] = ()
    matrix: Annotated[tuple[Real, ...], Field(min_length=16, max_length=16)] | None = None
    translation: Vector = (0.0, 0.0, 0.0)
    rotation: tuple[Real, Real, Real, Real] = (0.0, 0.0, 0.0, 1.0)
    scale: Vector = (1.0, 1.0, 1.0)
    mesh: Index | None = None
    camera: Index | None = None
    skin: Index | None = None
    extensions: dict[str, Any] = {}


class Perspective(Part):
    yfov: Annotated[float, Field(gt=0.0, lt=np.pi)]
    aspect_ratio: AboveZero | None = None
    znear: AboveZero
    zfar: AboveZero | None = None


class Orthographic(Part):
    xmag: Real
    ymag: Real
    znear: NotNegative
    zfar: AboveZero


class Camera(Part):
    type: Literal["perspective", "orthographic"]
    perspective: Perspective | None = None
    orthographic: Orthographic | None = None


class Surface(Part):
    """pbrMetallicRoughness."""

    base_color_factor: tuple[Unit, Unit, Unit, Unit] = (1.0, 1.0, 1.0, 1.0)
    base_color_texture: dict[str, Any] | None = None
    metallic_factor: Unit = 1.0
    metallic_roughness_texture: dict[str, Any] | None = None


class Material(Part):
    name: str = ""
    pbr_metallic_roughness: Surface = Surface()
    normal_texture: dict[str, Any] | None = None
    occlusion_texture: dict[str, Any] | None = None
    emissive_texture: dict[str, Any] | None = None
    emissive_factor: tuple[Unit, Unit, Unit] = (0.0, 0.0, 0.0)
    alpha_mode: Literal["OPAQUE", "MASK", "BLEND"] = "OPAQUE"
    extensions: dict[str, Any] = {}


class Light(Part):
    """Of KHR_lights_punctual."""

    type: Literal["point", "directional", "spot"]
    color: tuple[NotNegative, NotNegative, NotNegative] = (1.0, 1.0, 1.0)
    intensity: NotNegative = 1.0
    range: AboveZero | None = None


class Scene(Part):
    name: str = ""
    nodes: tuple[Index, ...] = ()
    extras: Any = None


class Root(Part):
    asset: Asset
    scene: Index | None = None
    scenes: tuple[Scene, ...] = ()
    nodes: Annotated[tuple[Node, ...], Field(max_length=MOST_NODES)] = ()
    meshes: tuple[Mesh, ...] = ()
    materials: tuple[Material, ...] = ()
    cameras: tuple[Camera, ...] = ()
    accessors: tuple[Accessor, ...] = ()
    buffer_views: tuple[BufferView, ...] = ()
    buffers: tuple[Buffer, ...] = ()
    animations: list[Any] = []
    extensions: dict[str, Any] = {}
    extensions_required: tuple[str, ...] = ()


_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Document:
    """An open file; `root` is what its JSON says. Raises InvalidInput, naming the file, where it cannot be read."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._read = 0
        data = self._file(path)
        self._binary: bytes | None = None
        text = data
        if data[:4] == struct.pack("<I", MAGIC):
            text, self._binary = self._chunks(data)
        self.root = self.checked(Root, self._json(text), "")
        if not self.root.asset.version.startswith("2.") or (self.root.asset.min_version or "2.0") != "2.0":
            raise self.problem(f"is glTF {shortened(self.root.asset.version)}; 2.0 is read")
        for name in self.root.extensions_required:
            if not name.startswith(READ_EXTENSIONS):
                raise self.problem(f"requires {shortened(name)}, which is not read here; export it without")
        self._buffers: dict[int, bytes] = {}

    def problem(self, text: str) -> InvalidInput:
        return InvalidInput(f"{self.path}: {text}")

    def checked(self, kind: type[Checked], value: Any, where: str) -> Checked:
        """A part of the JSON as one of these classes, or other strict models. `where` it is, for errors."""
        try:
            return kind.model_validate(value)
        except ValidationError as error:
            detail = error.errors(include_url=False)[0]
            place = ".".join(str(part) for part in (where, *detail["loc"]) if part != "")
            told = shortened(place) or "the file"
            raise self.problem(f"{told}: {detail['msg']}") from error

    def item(self, items: tuple[Item, ...], index: int, what: str) -> Item:
        """One of a list of the file by its number there."""
        if index >= len(items):
            raise self.problem(f"names {what} {index}, and has {len(items)}")
        return items[index]

    def numbers(self, index: int) -> NDArray[Any]:
        """What an accessor names: (count, components), its own type, or float64 of normalised integers."""
        accessor = self.item(self.root.accessors, index, "accessor")
        if accessor.sparse is not None or accessor.type not in _COMPONENTS:
            what = "sparse" if accessor.sparse is not None else accessor.type
            raise self.problem(f"accessor {index} is {what}, which is not read here")
        kind, components = np.dtype(_TYPES[accessor.component_type]), _COMPONENTS[accessor.type]
        if accessor.buffer_view is None:
            return np.zeros((accessor.count, components), kind)
        view = self.item(self.root.buffer_views, accessor.buffer_view, "bufferView")
        buffer = self._buffer(view.buffer)
        size = components * kind.itemsize
        stride = view.byte_stride or size
        end = accessor.byte_offset + stride * (accessor.count - 1) + size
        if end > view.byte_length or view.byte_offset + view.byte_length > len(buffer):
            raise self.problem(f"accessor {index} has {accessor.count} elements, more than its buffer holds")
        found: NDArray[Any] = np.ndarray(
            (accessor.count, components),
            kind,
            buffer,
            view.byte_offset + accessor.byte_offset,
            (stride, kind.itemsize),
        )
        if accessor.normalized and kind.kind in "iu":
            return np.maximum(found / float(np.iinfo(kind).max), -1.0)
        return found

    def _file(self, path: Path) -> bytes:
        """All files together have at most as many bytes as a mesh may have."""
        beside = "" if path == self.path else f': "{shortened(path.name)}"'
        size = 0
        with contextlib.suppress(OSError):  # of a name that no file can have; what is wrong the reading says
            size = path.stat().st_size
        if self._read + size > meshes.LARGEST_FILE:
            raise self.problem(f"a glTF scene has at most {meshes.LARGEST_FILE >> 20} MiB")
        data = read_bytes(path, meshes.LARGEST_FILE - self._read, "glTF", f"{self.path}{beside}")
        self._read += len(data)
        return data

    def _chunks(self, data: bytes) -> tuple[bytes, bytes | None]:
        """The JSON and the binary chunk of a GLB container."""
        version, length = struct.unpack("<II", data[4:12]) if len(data) >= 12 else (0, 0)
        if version != 2 or length > len(data):
            raise self.problem(f"is cut off, or no GLB of version 2: {len(data)} bytes of {length}")
        found: dict[int, bytes] = {}
        place = 12
        while place + 8 <= length:
            size, kind = struct.unpack("<II", data[place : place + 8])
            if place + 8 + size > length:
                raise self.problem("is broken: a chunk is longer than the file")
            found.setdefault(kind, data[place + 8 : place + 8 + size])
            place += 8 + size
        if JSON_CHUNK not in found:
            raise self.problem("is broken: it has no JSON chunk")
        return found[JSON_CHUNK], found.get(BINARY_CHUNK)

    def _json(self, text: bytes) -> Any:
        def refused(word: str) -> Any:
            raise ValueError(f"{word} is no JSON")

        if text.count(b",") + text.count(b"[") + text.count(b"{") > MOST_VALUES:
            raise self.problem(f"has more than {MOST_VALUES} values in its JSON, which are the most that are taken")
        try:
            return json.loads(text.decode("utf-8-sig"), parse_constant=refused)
        except (ValueError, RecursionError) as error:
            raise self.problem(f"not glTF: {' '.join(str(error).split())[:120]}") from error

    def _buffer(self, index: int) -> bytes:
        if index not in self._buffers:
            buffer = self.item(self.root.buffers, index, "buffer")
            if buffer.uri is None:
                if index != 0 or self._binary is None:
                    raise self.problem(f"buffer {index} has neither a uri nor a binary chunk")
                data = self._binary
            elif buffer.uri.startswith("data:"):
                try:
                    data = base64.b64decode(buffer.uri.partition(";base64,")[2], validate=True)
                except (binascii.Error, ValueError) as error:
                    raise self.problem(f"buffer {index} is no base64: {error}") from error
            else:
                data = self._beside(index, unquote(buffer.uri))
            if len(data) < buffer.byte_length:
                raise self.problem(f"buffer {index} has {len(data)} bytes, not {buffer.byte_length}")
            self._buffers[index] = data[: buffer.byte_length]
        return self._buffers[index]

    def _beside(self, index: int, name: str) -> bytes:
        """The file of a buffer, in the scene's folder or below."""
        if ":" in name.partition("/")[0]:
            raise self.problem(f'buffer {index} is at "{shortened(name)}", which is no file beside it')
        try:
            path = meshes.within(self.path.parent, name)
        except InvalidInput as error:
            raise self.problem(f"buffer {index}: {error}") from error
        return self._file(path)
