"""A scene as a .glb file for other programs.

Polygons and meshes are their triangles; discs and spheres are tessellated, within SILHOUETTE pixels of their outline at
the size of the picture, spheres with their exact normals. Positions are float32 about the middle of the scene, which a
node moves to its place in double. Materials are matt: no metal, no specular reflection. Lights have their intensities
as they are: the scenes' shading equation has no factor 1/pi, so that a program which multiplies by albedo / pi
takes pi times as much. The title, the size of the picture and its background are in the scene's extras, for `reading`.
"""

from __future__ import annotations

import json
import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope import meshes
from aliascope.errors import NotWritable
from aliascope.geometry import Array, Frame, across, frame_of, surfaces_of
from aliascope.gltf.document import BINARY_CHUNK, JSON_CHUNK, MAGIC
from aliascope.model import DirectionalLight, Disc, Material, PointLight, Scene, Sphere

SILHOUETTE = 0.001
"""Pixels by which an outline lies off its place at most."""

FORMS = frozenset(
    {"perspective", "orthographic", "polygon", "mesh", "disc", "sphere", "point light", "directional light"}
)
"""The features of scenes that glTF has words for."""


@dataclass(frozen=True)
class Shape:
    """Triangles of one material: corners (n, 3), faces (m, 3), and the normals of the corners where they are not the
    faces' own."""

    material: str
    corners: Array
    faces: NDArray[np.int64]
    normals: Array | None = None


def no_form(scene: Scene, size: tuple[int, int] | None = None) -> str | None:
    """Why glTF has no form for a scene at this size, or None."""
    missing = sorted(scene.features() - FORMS)
    if missing:
        return f"glTF has no form for: {', '.join(missing)}"
    if any(isinstance(light, PointLight) and light.falloff == "none" for light in scene.lights):
        return "glTF has no form for: a point light without fall-off"
    frame = frame_of(scene, size)
    triangles = 0
    for surface in scene.surfaces:
        if isinstance(surface, Disc | Sphere):
            radius = _radius_in_pixels(frame, surface)
            if radius is None:
                return "glTF has no form for: a disc or sphere that reaches the camera"
            triangles += _sides(surface, radius) ** 2 if isinstance(surface, Sphere) else _sides(surface, radius)
    if triangles > meshes.MOST_TRIANGLES:
        return f"its discs and spheres would be {triangles} triangles, more than {meshes.MOST_TRIANGLES}"
    return None


def write(path: Path, scene: Scene, size: tuple[int, int] | None = None) -> None:
    """Writes a scene that has a form (`no_form`). `size`: of the picture, in pixels, the scene's own unless said.

    Raises NotWritable, and ValueError for a polygon that has no triangles.
    """
    width, height = size or scene.view.size
    frame = frame_of(scene, (width, height))
    shapes = _shapes(scene, frame)
    corners = np.concatenate([shape.corners for shape in shapes]) if shapes else frame.eye[np.newaxis]
    bounds = np.stack([corners.min(axis=0), corners.max(axis=0)])
    names = list(dict.fromkeys(shape.material for shape in shapes))
    data, middle = _Data(), bounds.mean(axis=0)
    primitives = [{**data.primitive(shape, middle), "material": names.index(shape.material)} for shape in shapes]
    lights = [_light(light) for light in scene.lights]
    own = {"title": scene.title, "shows": scene.shows, "view": {**scene.view.model_dump(), "size": (width, height)}}
    nodes: list[dict[str, Any]] = [{"camera": 0, "matrix": _matrix(frame.right, frame.up, -frame.forward, frame.eye)}]
    nodes += [
        {**place, "extensions": {"KHR_lights_punctual": {"light": number}}} for number, (_, place) in enumerate(lights)
    ]
    if primitives:
        nodes.append({"mesh": 0, "translation": middle.tolist()})
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "aliascope"},
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_specular"],
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes))), "extras": {"aliascope": own}}],
        "nodes": nodes,
        "cameras": [_camera(scene, frame, bounds)],
    }
    if lights:
        document["extensions"] = {"KHR_lights_punctual": {"lights": [light for light, _ in lights]}}
    if primitives:
        document["meshes"] = [{"primitives": primitives}]
        document["materials"] = [_material(name, scene.materials[name]) for name in names]
        document |= {
            "accessors": data.accessors,
            "bufferViews": data.views,
            "buffers": [{"byteLength": len(data.data)}],
        }
    _write_chunks(path, document, bytes(data.data))


def _write_chunks(path: Path, document: dict[str, Any], data: bytes) -> None:
    text = json.dumps(document, allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), JSON_CHUNK) + text
    if data:
        chunks += struct.pack("<II", len(data), BINARY_CHUNK) + data
    try:
        path.write_bytes(struct.pack("<III", MAGIC, 2, 12 + len(chunks)) + chunks)
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error


class _Data:
    """The binary chunk as it grows, and what names its parts. All parts are of four bytes a number."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def primitive(self, shape: Shape, middle: Array) -> dict[str, Any]:
        corners = (shape.corners - middle).astype("<f4")
        limits = {"min": corners.min(axis=0).tolist(), "max": corners.max(axis=0).tolist()}
        attributes = {"POSITION": self._add(corners, 5126, "VEC3", limits)}
        if shape.normals is not None:
            attributes["NORMAL"] = self._add(shape.normals.astype("<f4"), 5126, "VEC3", {})
        indices = self._add(shape.faces.astype("<u4").reshape(-1, 1), 5125, "SCALAR", {})
        return {"attributes": attributes, "indices": indices}

    def _add(self, values: NDArray[Any], component: int, kind: str, more: dict[str, Any]) -> int:
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes})
        self.data += values.tobytes()
        view = len(self.views) - 1
        self.accessors.append(
            {"bufferView": view, "componentType": component, "count": len(values), "type": kind, **more}
        )
        return len(self.accessors) - 1


def _camera(scene: Scene, frame: Frame, bounds: Array) -> dict[str, Any]:
    """Nothing lies nearer than the near plane, or farther than the far one."""
    corners = np.stack(np.meshgrid(*bounds.T, indexing="ij"), axis=-1).reshape(-1, 3)
    distances = (corners - frame.eye) @ frame.forward
    farthest = max(1.0, float(distances.max()))
    aspect = frame.width / frame.height
    if frame.perspective:
        assert scene.camera.vertical_fov_degrees is not None
        lens = {
            "yfov": math.radians(scene.camera.vertical_fov_degrees),
            "aspectRatio": aspect,
            "znear": max(float(distances.min()) / 2.0, 1e-4 * farthest),
        }
        return {"type": "perspective", "perspective": lens}
    half = frame.half_height
    lens = {"xmag": half * aspect, "ymag": half, "znear": 0.0, "zfar": 2.0 * farthest}
    return {"type": "orthographic", "orthographic": lens}


def _material(name: str, material: Material) -> dict[str, Any]:
    strength = max(1.0, *material.emission)
    extensions: dict[str, Any] = {"KHR_materials_specular": {"specularFactor": 0.0}}
    if strength > 1.0:
        extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
    return {
        "name": name,
        "doubleSided": True,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*material.albedo, 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        },
        "emissiveFactor": [channel / strength for channel in material.emission],
        "extensions": extensions,
    }


def _light(light: object) -> tuple[dict[str, Any], dict[str, Any]]:
    """A light, and where its node is. Intensities beyond 1 are the intensity's, the colour has the rest."""
    assert isinstance(light, PointLight | DirectionalLight)
    strength = max(1.0, *light.intensity)
    entry = {"type": light.type, "color": [channel / strength for channel in light.intensity], "intensity": strength}
    if isinstance(light, PointLight):
        return entry, {"translation": list(light.position)}
    back = -np.array(light.direction) / np.linalg.norm(light.direction)
    first, second = across(back)
    return entry, {"matrix": _matrix(first, second, back, np.zeros(3))}


def _matrix(x: Array, y: Array, z: Array, place: Array) -> list[float]:
    """Of a node with these axes, at this place: by columns."""
    return [*x.tolist(), 0.0, *y.tolist(), 0.0, *z.tolist(), 0.0, *place.tolist(), 1.0]


# --- shapes -----------------------------------------------------------------------------------------------------------


def _shapes(scene: Scene, frame: Frame) -> list[Shape]:
    """All surfaces; the triangles of one material are one shape."""
    found = surfaces_of(scene)
    shapes = []
    for number, name in enumerate(found.materials):
        triangles = found.triangles[found.triangle_material == number]
        if len(triangles):
            faces = np.arange(3 * len(triangles)).reshape(-1, 3)
            shapes.append(Shape(name, triangles.reshape(-1, 3), faces))
    for surface in scene.surfaces:
        if isinstance(surface, Disc | Sphere):
            radius = _radius_in_pixels(frame, surface)
            assert radius is not None  # no_form says so
            sides = _sides(surface, radius)
            shapes.append(_disc(surface, sides) if isinstance(surface, Disc) else _sphere(surface, sides))
    return shapes


def _radius_in_pixels(frame: Frame, surface: Disc | Sphere) -> float | None:
    """How large a radius is seen at most; None where the surface reaches the eye."""
    if not frame.perspective:
        return surface.radius / frame.pixel
    nearest = float(np.linalg.norm(np.subtract(surface.centre, frame.eye))) - surface.radius
    ahead = float(np.subtract(surface.centre, frame.eye) @ frame.forward) - surface.radius
    if nearest <= 0.0:
        return None
    # What is aside of the view, or behind, is not seen larger than by its distance.
    return surface.radius / (max(ahead, 0.1 * nearest) * frame.pixel)


def _sides(surface: Disc | Sphere, radius: float) -> int:
    """Around a disc or the equator of a sphere. Outlines of corners halfway out and of sides halfway in leave a disc by
    half of radius * (1 - cos(pi / n)) at most, a sphere by that of the diagonals of its cells, sqrt(2) longer."""
    largest = 2.0 * SILHOUETTE / max(radius, 2.0 * SILHOUETTE)
    diagonal = math.sqrt(2.0) if isinstance(surface, Sphere) else 1.0
    sides = max(12, math.ceil(diagonal * math.pi / math.acos(1.0 - min(largest, 0.1))))
    return sides + sides % 2


def _outwards(half_angle: float) -> float:
    """By how much corners are moved out, so that they are as far outside as the middles of sides are inside."""
    return 2.0 / (1.0 + math.cos(half_angle))


def _disc(disc: Disc, sides: int) -> Shape:
    normal = np.array(disc.normal) / np.linalg.norm(disc.normal)
    first, second = across(normal)
    angles = 2.0 * math.pi * np.arange(sides) / sides
    radius = disc.radius * _outwards(math.pi / sides)
    around = radius * (np.cos(angles)[:, np.newaxis] * first + np.sin(angles)[:, np.newaxis] * second)
    corners = np.concatenate([np.zeros((1, 3)), around]) + np.array(disc.centre)
    after = np.roll(np.arange(sides), -1)
    faces = np.stack([np.zeros(sides, np.int64), 1 + np.arange(sides), 1 + after], axis=1)
    return Shape(disc.material, corners, faces)


def _sphere(sphere: Sphere, sides: int) -> Shape:
    """Meridians and half as many circles of latitude, a pole above and one below."""
    rings = sides // 2
    polar = math.pi * np.arange(1, rings) / rings
    angles = 2.0 * math.pi * np.arange(sides) / sides
    out, up = np.sin(polar)[:, np.newaxis], np.cos(polar)[:, np.newaxis]
    bands = np.stack([out * np.cos(angles), np.broadcast_to(up, (rings - 1, sides)), out * np.sin(angles)], axis=-1)
    poles = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    normals = np.concatenate([bands.reshape(-1, 3), poles])
    here, after = np.arange(sides), np.roll(np.arange(sides), -1)
    top, bottom = (rings - 1) * sides, (rings - 1) * sides + 1
    last = (rings - 2) * sides
    faces = [np.stack([np.full(sides, top), after, here], axis=1)]
    for ring in range(rings - 2):
        above, below = ring * sides, (ring + 1) * sides
        faces.append(np.stack([above + here, above + after, below + after], axis=1))
        faces.append(np.stack([above + here, below + after, below + here], axis=1))
    faces.append(np.stack([np.full(sides, bottom), last + here, last + after], axis=1))
    radius = sphere.radius * _outwards(math.sqrt(2.0) * math.pi / sides)
    corners = np.array(sphere.centre) + radius * normals
    return Shape(sphere.material, corners, np.concatenate(faces), normals)
