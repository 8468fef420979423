"""A glTF file as a scene.

All triangles of the file's scene are drawn where its nodes put them, each node's as one mesh in world coordinates.
A material's base colour is the albedo, its emissive factor times KHR_materials_emissive_strength the emission; with
KHR_materials_unlit the base colour is the emission. The first camera that the nodes have is the camera; where they have
none, one is fitted to the bounds. Lights are those of KHR_lights_punctual, their intensities as they are in the scenes'
shading equation, which has no factor 1/pi: points fall off by the square of the distance, directional lights do not.
Where there are none, and a surface that would be lit, a directional light comes from behind the camera.

What a file asks for beyond that is not drawn, and `notes` say so, a sentence each. The size of the picture, which
glTF has no word for, and its background are in the extras of the file's scene, if `aliascope` wrote it (`writing`);
else HEIGHT rows by the camera's aspect ratio, on black.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, ValidationError

from aliascope import meshes, model
from aliascope.bounded import as_shown, shortened
from aliascope.geometry import Array
from aliascope.gltf import document
from aliascope.gltf.document import Document, Node, Primitive

Corners = NDArray[np.int64]

HEIGHT = 240
"""Rows of a picture whose file does not say."""

ASPECT = 4.0 / 3.0
"""Of a picture whose file does not say."""

FITTED_FOV_DEGREES = 40.0
FITTED_FORWARD = (-0.4417, -0.3371, -0.8313)
"""A camera that is fitted looks this way, from the front, which in glTF is +z, somewhat from the right and above."""

LIGHT_BESIDE = (0.2819, -0.4733, 1.0)
"""The light that is added travels so far to the camera's right, up and forward."""

MOST_PRIMITIVES = 200_000
"""That the nodes draw: a mesh counts for each node that has it."""

MOST_POSITIONS = 100 * document.MOST_ELEMENTS
"""And normals, counted so too."""

TRIANGLES, STRIP = 4, 5
DRAWN = (TRIANGLES, STRIP, 6)


@dataclass(frozen=True)
class Read:
    """A scene, and what of its file is not drawn."""

    scene: model.Scene
    notes: tuple[str, ...]


class Own(BaseModel):
    """What `writing` adds to the extras of a file's scene. A file that has it has its own lights, or none."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    title: str
    shows: str
    view: model.View


@dataclass
class _Placed:
    """What the nodes put into the world."""

    primitives: list[tuple[Primitive, Array]] = field(default_factory=list)
    cameras: list[tuple[int, Array]] = field(default_factory=list)
    lights: list[tuple[int, Array]] = field(default_factory=list)


@np.errstate(over="ignore", invalid="ignore")  # what is not finite is refused by name
def read(path: Path) -> Read:
    """The scene of a .glb or .gltf file. Raises InvalidInput, with the file's name."""
    opened = Document(path)
    notes: dict[str, None] = {}
    roots, found = _roots(opened)
    own = _own(opened, found)
    placed = _placed(opened, roots, notes)
    surfaces, materials = _surfaces(opened, placed, notes)
    corners = np.concatenate([surface.triangles.reshape(-1, 3) for surface in surfaces])
    bounds = np.stack([corners.min(axis=0), corners.max(axis=0)])
    if opened.root.animations:
        notes["its animations are not played: all is where the nodes are at rest"] = None
    try:
        camera, aspect = _camera(opened, placed, bounds, notes)
        view = own.view if own else model.View(size=(max(1, round(HEIGHT * aspect)), HEIGHT))
        lights = _lights(opened, placed, notes)
        if not lights and own is None and any(any(each.albedo) for each in materials.values()):
            lights = [_added(camera)]
            notes["it has no light that is drawn here: a directional one from behind the camera was added"] = None
        shows = "; ".join(["Read from a glTF file", *notes]) + "."
        scene = model.Scene(
            title=as_shown(shortened(own.title if own else found.name or path.stem, model.LONGEST_TITLE)),
            shows=as_shown(shortened(own.shows if own else shows, model.LONGEST_TEXT)),
            view=view,
            camera=camera,
            materials=materials,
            lights=tuple(lights),
        )
    except ValidationError as error:
        detail = error.errors(include_url=False)[0]
        raise opened.problem(f"{'.'.join(map(str, detail['loc'])) or 'scene'}: {detail['msg']}") from error
    return Read(scene.model_copy(update={"surfaces": tuple(surfaces)}), tuple(notes))


def _own(opened: Document, found: document.Scene) -> Own | None:
    extras = found.extras.get("aliascope") if isinstance(found.extras, dict) else None
    try:
        return None if extras is None else opened.checked(Own, _tuples(extras), "scene.extras.aliascope")
    except RecursionError as error:
        raise opened.problem("scene.extras.aliascope: its lists lie in each other hundreds deep") from error


def _tuples(value: Any) -> Any:
    """JSON with its lists as tuples, as strict models take them."""
    if isinstance(value, dict):
        return {key: _tuples(each) for key, each in value.items()}
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _roots(opened: Document) -> tuple[tuple[int, ...], document.Scene]:
    """The nodes at the top of the file's scene: the one that it names, its first, or all that are no one's children."""
    root = opened.root
    if root.scenes:
        found = opened.item(root.scenes, root.scene or 0, "scene")
        return found.nodes, found
    children = {child for node in root.nodes for child in node.children}
    return tuple(index for index in range(len(root.nodes)) if index not in children), document.Scene()


def _placed(opened: Document, roots: tuple[int, ...], notes: dict[str, None]) -> _Placed:
    """Goes through the tree of nodes; each has one parent at most, so that none is met twice."""
    placed, seen = _Placed(), set[int]()
    waiting = [(index, np.eye(4)) for index in reversed(roots)]
    while waiting:
        index, above = waiting.pop()
        if index in seen:
            raise opened.problem(f"is broken: node {index} has more than one parent, or is its own")
        seen.add(index)
        node = opened.item(opened.root.nodes, index, "node")
        matrix = above @ _matrix(node)
        waiting += [(child, matrix) for child in reversed(node.children)]
        if node.mesh is not None:
            mesh = opened.item(opened.root.meshes, node.mesh, "mesh")
            placed.primitives += [(primitive, matrix) for primitive in mesh.primitives]
            if len(placed.primitives) > MOST_PRIMITIVES:
                raise opened.problem(f"draws more than {MOST_PRIMITIVES} parts of meshes, which are the most")
            if node.skin is not None:
                notes["its skins are not applied: meshes have the shape in which they are stored"] = None
            if any(primitive.targets for primitive in mesh.primitives):
                notes["its morph targets are not applied: meshes have the shape in which they are stored"] = None
        if node.camera is not None:
            placed.cameras.append((node.camera, matrix))
        light = node.extensions.get("KHR_lights_punctual")
        if light is not None:
            number = light.get("light") if isinstance(light, dict) else None
            if not isinstance(number, int) or isinstance(number, bool) or number < 0:
                raise opened.problem(f"node {index}: KHR_lights_punctual names no light")
            placed.lights.append((number, matrix))
    return placed


def _matrix(node: Node) -> Array:
    """A node's transform in double, of column vectors."""
    if node.matrix is not None:
        return np.array(node.matrix).reshape(4, 4).T
    x, y, z, w = np.array(node.rotation) / (math.hypot(*node.rotation) or 1.0)
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turned * np.array(node.scale), node.translation
    return matrix


# --- surfaces ---------------------------------------------------------------------------------------------------------


def _surfaces(
    opened: Document, placed: _Placed, notes: dict[str, None]
) -> tuple[list[model.LoadedMesh], dict[str, model.Material]]:
    """The meshes in world coordinates, and the materials that they have, by name."""
    surfaces: list[model.LoadedMesh] = []
    materials: dict[str, model.Material] = {}
    _check_counts(opened, placed)
    for primitive, matrix in placed.primitives:
        if primitive.mode not in DRAWN:
            notes["its points and lines are not drawn"] = None
            continue
        triangles = _triangles(opened, primitive, matrix, notes)
        name, material = _material(opened, primitive, notes)
        if len(triangles):
            materials[name] = material
            digest = hashlib.sha256(np.ascontiguousarray(triangles).tobytes()).hexdigest()
            surfaces.append(model.LoadedMesh(material=name, sha256=digest, triangles=triangles))
    if not surfaces:
        raise opened.problem("has no triangles")
    return surfaces, materials


def _check_counts(opened: Document, placed: _Placed) -> None:
    """Raises InvalidInput for more than is taken, before any of it is made."""
    triangles = positions = 0
    for primitive, _ in placed.primitives:
        triangles += _count(opened, primitive)
        numbers = [primitive.attributes.get(name) for name in ("POSITION", "NORMAL")]
        positions += sum(opened.item(opened.root.accessors, n, "accessor").count for n in numbers if n is not None)
    if triangles > meshes.MOST_TRIANGLES:
        raise opened.problem(f"has more than {meshes.MOST_TRIANGLES} triangles, which are the most that are taken")
    if positions > MOST_POSITIONS:
        raise opened.problem(
            f"has more than {MOST_POSITIONS} positions and normals, counted for each time they are used"
        )


@np.errstate(over="ignore", invalid="ignore")
def check(path: Path) -> None:
    """Raises InvalidInput for a file that `read` would not take for the number of things in it, or its nodes."""
    opened = Document(path)
    _check_counts(opened, _placed(opened, _roots(opened)[0], {}))


def _count(opened: Document, primitive: Primitive) -> int:
    """The triangles of a primitive, those without area too, before any is made."""
    corners = primitive.attributes.get("POSITION") if primitive.indices is None else primitive.indices
    if corners is None or primitive.mode not in DRAWN:
        return 0
    count = opened.item(opened.root.accessors, corners, "accessor").count
    return count // 3 if primitive.mode == TRIANGLES else max(0, count - 2)


def _triangles(opened: Document, primitive: Primitive, matrix: Array, notes: dict[str, None]) -> Array:
    """(n, 3, 3) in world coordinates, without those that have no area."""
    if "POSITION" not in primitive.attributes:
        return np.zeros((0, 3, 3))
    points = opened.numbers(primitive.attributes["POSITION"])
    if points.shape[1] != 3:
        raise opened.problem("a POSITION has not three components")
    if primitive.indices is None:
        corners: Corners = np.arange(len(points))
    else:
        corners = opened.numbers(primitive.indices)[:, 0].astype(np.int64)
        if corners.min() < 0 or corners.max() >= len(points):
            raise opened.problem(f"an index is {corners.max()}, and there are {len(points)} positions")
    faces = _faces(corners, primitive.mode)
    placed = points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    triangles: Array = placed[faces]
    if not (np.abs(triangles) <= model.LARGEST_COORDINATE).all():
        raise opened.problem("a corner is not finite or beyond 1e30")
    flat = meshes.without_area(triangles)
    if flat.any():
        notes["triangles without area are left out"] = None
    if "NORMAL" in primitive.attributes and _smooth(opened, primitive, faces):
        notes["smooth normals are not used: each triangle is shaded by its own"] = None
    if "COLOR_0" in primitive.attributes:
        notes["colours of corners are not drawn: materials alone are"] = None
    return triangles[~flat]


def _faces(corners: Corners, mode: int) -> Corners:
    """The corners of each triangle, (n, 3); whatever is left over makes none."""
    if mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if len(corners) < 3:
        return corners[:0].reshape(0, 3)
    first = corners[:-2] if mode == STRIP else np.full(len(corners) - 2, corners[0])
    return np.stack([first, corners[1:-1], corners[2:]], axis=1)


def _smooth(opened: Document, primitive: Primitive, faces: Corners) -> bool:
    """Whether the normals at a triangle's corners differ by more than a thousandth."""
    normals = opened.numbers(primitive.attributes["NORMAL"])
    if len(faces) == 0 or faces.max() >= len(normals) or normals.shape[1] != 3:
        return False
    at_corners = normals[faces]
    return bool((np.ptp(at_corners, axis=1) > 1e-3).any())


def _material(opened: Document, primitive: Primitive, notes: dict[str, None]) -> tuple[str, model.Material]:
    """A material under its number and its name, which others may share."""
    if primitive.material is None:
        return "default", model.Material(albedo=(1.0, 1.0, 1.0))
    found = opened.item(opened.root.materials, primitive.material, "material")
    called = as_shown(shortened(found.name))
    name = f"{primitive.material} {called}".strip()
    told = f'material "{called or primitive.material}"'
    surface = found.pbr_metallic_roughness
    textures = (surface.base_color_texture, surface.metallic_roughness_texture, found.normal_texture)
    if any(texture is not None for texture in (*textures, found.emissive_texture, found.occlusion_texture)):
        notes[f"the textures of {told} are not drawn: its plain colours are"] = None
    if found.alpha_mode != "OPAQUE":
        notes[f"{told} is drawn as opaque"] = None
    colour = surface.base_color_factor[:3]
    strength = 1.0
    for key, value in found.extensions.items():
        if key == "KHR_materials_emissive_strength" and isinstance(value, dict):
            strength = value.get("emissiveStrength", 1.0)
        elif key == "KHR_materials_specular" and isinstance(value, dict) and value.get("specularFactor") == 0:
            pass  # matt, as all is
        elif key != "KHR_materials_unlit":
            notes[f"{as_shown(shortened(key))} of {told} is not drawn"] = None
    if not isinstance(strength, int | float) or not 0.0 <= strength <= model.LARGEST_COORDINATE:
        raise opened.problem(f"{told}: emissiveStrength {shortened(ascii(strength))} is not a number from 0")
    if "KHR_materials_unlit" in found.extensions:
        return name, model.Material(emission=colour)
    if surface.metallic_factor > 0.0:
        notes["metal is not drawn: all surfaces are matt"] = None
    red, green, blue = found.emissive_factor
    return name, model.Material(albedo=colour, emission=(red * strength, green * strength, blue * strength))


# --- camera and lights ------------------------------------------------------------------------------------------------


def _camera(opened: Document, placed: _Placed, bounds: Array, notes: dict[str, None]) -> tuple[model.Camera, float]:
    """The camera, and the aspect ratio of its picture."""
    if not placed.cameras:
        notes["it has no camera: one was fitted to its bounds"] = None
        return _fitted(bounds), ASPECT
    if len(placed.cameras) > 1:
        notes["it has several cameras: the first is taken"] = None
    index, matrix = placed.cameras[0]
    found = opened.item(opened.root.cameras, index, "camera")
    eye, forward, up = matrix[:3, 3], -_direction(opened, matrix, 2), _direction(opened, matrix, 1)
    distances = _corners(bounds) @ forward - eye @ forward
    ahead = float(distances.max())
    look_at = eye + forward * (ahead if 0.0 < ahead < model.LARGEST_COORDINATE else 1.0)
    kind, where, upward = found.type, (_vector(eye), _vector(look_at)), _vector(up)
    lens = found.perspective if found.type == "perspective" else found.orthographic
    if lens is None:
        raise opened.problem(f"camera {index} is {found.type} and does not say how")
    if (lens.zfar is not None and lens.zfar < ahead) or lens.znear > max(0.0, float(distances.min())):
        notes["the camera's near and far planes cut nothing off"] = None
    fov, height, aspect = None, None, ASPECT
    if isinstance(lens, document.Perspective):
        fov, aspect = math.degrees(lens.yfov), lens.aspect_ratio or ASPECT
    else:
        height, width = 2.0 * abs(lens.ymag), 2.0 * abs(lens.xmag)
        aspect = width / height if height else ASPECT
    camera = model.Camera(type=kind, eye=where[0], look_at=where[1], up=upward, height=height, vertical_fov_degrees=fov)
    return camera, aspect


def _fitted(bounds: Array) -> model.Camera:
    """A camera that sees the sphere about the bounds whole."""
    middle, radius = bounds.mean(axis=0), float(np.linalg.norm(bounds[1] - bounds[0])) / 2.0
    forward = np.array(FITTED_FORWARD) / np.linalg.norm(FITTED_FORWARD)
    eye = middle - forward * 1.05 * radius / math.sin(math.radians(FITTED_FOV_DEGREES) / 2.0)
    return model.Camera(
        type="perspective", eye=_vector(eye), look_at=_vector(middle), vertical_fov_degrees=FITTED_FOV_DEGREES
    )


def _lights(opened: Document, placed: _Placed, notes: dict[str, None]) -> list[model.AnyLight]:
    extension = opened.root.extensions.get("KHR_lights_punctual", {})
    listed = extension.get("lights", []) if isinstance(extension, dict) else []
    lights: list[model.AnyLight] = []
    for index, matrix in placed.lights:
        entry = opened.item(tuple(listed) if isinstance(listed, list) else (), index, "light")
        found = opened.checked(document.Light, entry, f"lights.{index}")
        red, green, blue = found.color
        intensity = (red * found.intensity, green * found.intensity, blue * found.intensity)
        if found.type == "spot":
            notes["its spot lights are not drawn"] = None
        elif found.type == "directional":
            way = -_direction(opened, matrix, 2)
            lights.append(model.DirectionalLight(type="directional", direction=_vector(way), intensity=intensity))
        else:
            if found.range is not None:
                notes["the ranges of its lights are not heeded: they reach everywhere"] = None
            lights.append(
                model.PointLight(
                    type="point", position=_vector(matrix[:3, 3]), intensity=intensity, falloff="inverse-square"
                )
            )
    return lights


def _added(camera: model.Camera) -> model.DirectionalLight:
    """A light from behind the camera, from its left and above."""
    forward = np.subtract(camera.look_at, camera.eye)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, camera.up)
    right /= np.linalg.norm(right)
    beside, above, ahead = LIGHT_BESIDE
    direction = beside * right + above * np.cross(right, forward) + ahead * forward
    return model.DirectionalLight(type="directional", direction=_vector(direction), intensity=(1.0, 1.0, 1.0))


def _direction(opened: Document, matrix: Array, axis: int) -> Array:
    """Where an axis of a node points in the world, of length 1."""
    column: Array = matrix[:3, axis]
    length = float(np.linalg.norm(column))
    if not 0.0 < length < math.inf:
        raise opened.problem("a node with a camera or light has no direction: its matrix is singular or not finite")
    return column / length


def _corners(bounds: Array) -> Array:
    """The eight of a box."""
    return np.stack(np.meshgrid(*bounds.T, indexing="ij"), axis=-1).reshape(-1, 3)


def _vector(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
