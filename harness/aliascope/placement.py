"""Where a scene stands and how large it is: it can be moved and scaled as a whole, which no picture shows.

`moved` and `scaled` change each place and length, in double: what is seen stays the same, but for their rounding.
`placed` uses them for renderers whose arithmetic is best near the origin and at usual sizes: POV-Ray ends at 1e7 units
and sees nothing of what is smaller than 1e-5, and OpenGL's coordinates are float.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from aliascope.errors import InvalidInput
from aliascope.geometry import Array, Frame, frame_of, triangulate
from aliascope.model import (
    AnyLight,
    AnySurface,
    AreaLight,
    Camera,
    Colour,
    DirectionalLight,
    Disc,
    DiscLight,
    LoadedMesh,
    Material,
    Motion,
    Part,
    Plane,
    PointLight,
    Polygon,
    Rotate,
    Scene,
    Sphere,
    SphereLight,
    Translate,
    Vector,
    ZonePlate,
)


def moved(scene: Scene, by: Vector) -> Scene:
    """The scene with `by` added to each place in it: of camera, surfaces, motions, patterns and lights. Raises
    InvalidInput where the sums, rounded, make no scene: the eye falls on what it looks at, say."""
    return _changed(scene, _Change(1.0, np.array(by)))


def scaled(scene: Scene, by: float) -> Scene:
    """The scene with each length in it multiplied by `by`, 0 and places from the origin: those of its lens, its motions
    and its patterns too. Lights that fall off get by^2 of their intensity. Raises InvalidInput as above."""
    return _changed(scene, _Change(by, np.zeros(3)))


FAR = 2.0**10
"""A scene is far from the origin where its eye is so many times as far from it as from what is seen: three of the 16
digits of its coordinates are then spent on where it stands."""

SMALLEST, LARGEST = 2.0**-4, 2.0**23
"""Usual sizes (see `size_of`), in units. The largest is just below the 1e7 at which POV-Ray's world ends; a scene that
is larger keeps as much of what is near as can be."""

USUAL = 2.0**3
"""What a scene that is too small becomes, at least; twice that at most."""


def placed(scene: Scene) -> Scene:
    """The scene as renderers draw it best: the eye at the origin where the scene is far from it, and scaled by a power
    of two where it is smaller than SMALLEST or larger than LARGEST. The same object where neither is so, and where the
    numbers that it would have are none that a scene may have."""
    size = size_of(scene)
    if not 0.0 < size < math.inf:
        return scene
    try:
        eye = scene.camera.eye
        if max(map(abs, eye)) > FAR * size:
            x, y, z = eye
            scene = moved(_in_triangles(scene), (-x, -y, -z))
        scale = usual_scale(size)
        return scene if scale == 1.0 else scaled(scene, scale)
    except InvalidInput:
        return scene


def _in_triangles(scene: Scene) -> Scene:
    """With polygons cut up: what rounding far away has bent out of a plane no longer lies in one near the origin."""
    surfaces: list[AnySurface | LoadedMesh] = []
    for surface in scene.surfaces:
        if not isinstance(surface, Polygon) or len(surface.points) == 3:
            surfaces.append(surface)
            continue
        try:
            pieces = triangulate(surface)
        except ValueError:
            surfaces.append(surface)  # which whoever draws it refuses
            continue
        cut = (surface.model_copy(update={"points": tuple(map(tuple, corners))}) for corners in pieces.tolist())
        surfaces.extend(cut)
    return scene.model_copy(update={"surfaces": tuple(surfaces)})


def usual_scale(size: float) -> float:
    """The power of two that brings a size to what is usual; 1 where it is."""
    if size < SMALLEST:
        return 2.0 ** math.ceil(math.log2(USUAL) - math.log2(size))
    return 2.0 ** math.floor(math.log2(LARGEST) - math.log2(size)) if size > LARGEST else 1.0


def size_of(scene: Scene) -> float:
    """The largest depth of what has an end, in front of the eye or behind it, wherever its motion takes it; the height
    of the eye over endless planes; in an orthographic view half the height of the picture, and no planes. Lights do not
    count, nor how far things reach to the sides: what is larger than the picture is cut off by it."""
    frame = frame_of(scene)
    sizes = [0.0 if frame.perspective else frame.half_height]
    for surface in scene.surfaces:
        if not isinstance(surface, Plane):
            sizes.append(_depth(surface, frame))
        elif frame.perspective:
            upright = np.array(surface.normal) / max(map(abs, surface.normal))
            above = abs(float(upright @ (np.array(surface.point) - frame.eye)))
            sizes.append(above / float(np.linalg.norm(upright)))
    return max(sizes)


def _depth(surface: AnySurface | LoadedMesh, frame: Frame) -> float:
    places, radius = _places(surface)
    match surface.motion:
        case Translate(by=by):
            places = np.concatenate([places, places + by])
        case Rotate(centre=centre):
            about = np.array(centre)
            turned = float(np.abs(places - about).max(initial=0.0)) * math.sqrt(3.0)
            return abs(float((about - frame.eye) @ frame.forward)) + turned + radius
    return float(np.abs((places - frame.eye) @ frame.forward).max(initial=0.0)) + radius


def _places(surface: AnySurface | LoadedMesh) -> tuple[Array, float]:
    """Of a surface, at time 0 or in its frames: corners (n, 3), or its centre, and how far it reaches from that."""
    match surface:
        case LoadedMesh(triangles=triangles, frames=None):
            return triangles.reshape(-1, 3), 0.0
        case LoadedMesh(triangles=triangles, frames=frames):
            assert frames is not None  # or the case above
            return np.concatenate([triangles.reshape(-1, 3), frames.reshape(-1, 3)]), 0.0
        case Polygon(points=points):
            return np.array(points), 0.0
        case Sphere(centre=centre, radius=radius) | Disc(centre=centre, radius=radius):
            return np.array([centre]), radius
    return np.zeros((0, 3)), 0.0  # a mesh that was not read


@dataclass(frozen=True)
class _Change:
    """The place p becomes scale p + offset."""

    scale: float
    offset: Array

    def array(self, places: Array) -> Array:
        return self.scale * places + self.offset

    def place(self, place: Vector) -> Vector:
        return _vector(self.array(np.array(place)))

    def way(self, way: Vector) -> Vector:
        return _vector(self.scale * np.array(way))

    def length(self, length: float) -> float:
        return self.scale * length


def _vector(of: Array) -> Vector:
    x, y, z = of.tolist()
    return x, y, z


def _changed(scene: Scene, change: _Change) -> Scene:
    try:
        materials = {name: _material(each, change) for name, each in scene.materials.items()}
        update: dict[str, object] = {
            "camera": _camera(scene.camera, change),
            "materials": materials,
            "surfaces": tuple(_surface(each, change) for each in scene.surfaces),
            "lights": tuple(_light(each, change) for each in scene.lights),
        }
    except ValidationError as error:
        first = error.errors()[0]
        raise InvalidInput(f"{scene.title}: moved or scaled, it is no scene: {first['msg']}") from error
    return scene.model_copy(update=update)


P = TypeVar("P", bound=Part)


def _with(part: P, **update: Any) -> P:
    """With its validators run again."""
    return type(part)(**{**dict(part), **update})


def _camera(camera: Camera, change: _Change) -> Camera:
    lengths = {name: getattr(camera, name) for name in ("height", "lens_radius", "focus_distance")}
    update = {name: change.length(length) for name, length in lengths.items() if length is not None}
    return _with(camera, eye=change.place(camera.eye), look_at=change.place(camera.look_at), **update)


def _material(material: Material, change: _Change) -> Material:
    pattern = material.pattern
    if pattern is None:
        return material
    power = 2 if isinstance(pattern, ZonePlate) else 1  # its scale is of the square of a length
    again = _with(pattern, origin=change.place(pattern.origin), scale=pattern.scale / change.scale**power)
    return _with(material, pattern=again)


def _motion(motion: Motion | None, change: _Change) -> Motion | None:
    match motion:
        case Translate(by=by):
            return _with(motion, by=change.way(by))
        case Rotate(centre=centre):
            return _with(motion, centre=change.place(centre))
    return motion  # frames are moved with their mesh


def _surface(surface: AnySurface | LoadedMesh, change: _Change) -> AnySurface | LoadedMesh:
    update: dict[str, object] = {"motion": _motion(surface.motion, change)}
    match surface:
        case LoadedMesh(triangles=triangles, frames=frames):
            places = [change.array(each) for each in (triangles, frames) if each is not None]
            update["triangles"], update["frames"] = places[0], places[1] if len(places) > 1 else None
            update["sha256"] = hashlib.sha256(b"".join(each.tobytes() for each in places)).hexdigest()
        case Polygon(points=points):
            update["points"] = tuple(map(change.place, points))
        case Sphere(centre=centre, radius=radius) | Disc(centre=centre, radius=radius):
            update |= {"centre": change.place(centre), "radius": change.length(radius)}
        case Plane(point=point):
            update["point"] = change.place(point)
        case _:
            raise ValueError("a mesh is moved after it was read")
    return _with(surface, **update)


def _light(light: AnyLight, change: _Change) -> AnyLight:
    update: dict[str, object] = {}
    if light.falloff == "inverse-square":
        update["intensity"] = _times(light.intensity, change.scale**2)
    match light:
        case PointLight(position=position):
            update["position"] = change.place(position)
        case AreaLight(corner=corner, edges=edges):
            update |= {"corner": change.place(corner), "edges": tuple(map(change.way, edges))}
        case DiscLight(centre=centre, radius=radius) | SphereLight(centre=centre, radius=radius):
            update |= {"centre": change.place(centre), "radius": change.length(radius)}
        case DirectionalLight():
            pass
    return _with(light, **update)


def _times(colour: Colour, factor: float) -> Colour:
    red, green, blue = colour
    return factor * red, factor * green, factor * blue
