"""Scenes moved away from the origin with their camera, and scaled as a whole: what is seen stays the same, but for the
rounding of the coordinates, which are doubles."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from aliascope.errors import InvalidInput
from aliascope.geometry import Array
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
