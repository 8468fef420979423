"""Surfaces at a moment: what moves has a place for each time from 0 to 1."""

from __future__ import annotations

import math

import numpy as np

from aliascope.errors import InvalidInput
from aliascope.geometry import Array
from aliascope.model import (
    AnySurface,
    Checker,
    Disc,
    Frames,
    LoadedMesh,
    Mesh,
    Motion,
    Plane,
    Polygon,
    Rotate,
    Scene,
    Sphere,
    Translate,
    ZonePlate,
)


def transform(motion: Translate | Rotate, time: float) -> tuple[Array, Array]:
    """The matrix (3, 3) and the offset (3,) with which a motion takes a point from its place at time 0 to that at
    `time`: matrix @ point + offset."""
    if isinstance(motion, Translate):
        return np.eye(3), time * np.array(motion.by)
    x, y, z = np.array(motion.axis) / np.linalg.norm(motion.axis)
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = math.radians(motion.degrees) * time
    # Rodrigues' formula; 1 - cos without its cancellation at small angles.
    matrix = np.eye(3) + math.sin(angle) * across + 2.0 * math.sin(0.5 * angle) ** 2 * (across @ across)
    centre = np.array(motion.centre)
    return matrix, centre - matrix @ centre


def moved(surface: AnySurface | LoadedMesh, time: float) -> AnySurface | LoadedMesh:
    """The surface as it is at a time from 0 to 1, standing still; at time 0, to the bit as it is stated. A Mesh that
    was not read yet cannot be moved."""
    if surface.motion is None:
        return surface
    if time == 0.0:
        return surface.model_copy(
            update={"motion": None} | ({"frames": None} if isinstance(surface, LoadedMesh) else {})
        )
    if isinstance(surface.motion, Frames):
        assert isinstance(surface, LoadedMesh)
        assert surface.frames is not None
        return surface.model_copy(update={"motion": None, "frames": None, "triangles": between(surface, time)})
    matrix, offset = transform(surface.motion, time)

    def place(point: tuple[float, float, float]) -> tuple[float, ...]:
        return tuple((matrix @ point + offset).tolist())

    def turned(direction: tuple[float, float, float]) -> tuple[float, ...]:
        return tuple((matrix @ direction).tolist())

    update: dict[str, object]
    match surface:
        case Polygon():
            update = {"points": tuple(map(place, surface.points))}
        case LoadedMesh():
            update = {"triangles": surface.triangles @ matrix.T + offset}
        case Sphere():
            update = {"centre": place(surface.centre)}
        case Disc():
            update = {"centre": place(surface.centre), "normal": turned(surface.normal)}
        case Plane():
            update = {"point": place(surface.point), "normal": turned(surface.normal)}
        case Mesh():
            raise ValueError("a mesh is moved after it was read")
    return surface.model_copy(update={"motion": None} | update)


def between(mesh: LoadedMesh, time: float) -> Array:
    """The triangles (n, 3, 3) of a mesh of frames at a time from 0 to 1."""
    assert mesh.frames is not None
    steps = len(mesh.frames)
    before = min(int(time * steps), steps - 1)
    share = time * steps - before
    first = mesh.triangles if before == 0 else mesh.frames[before - 1]
    return np.asarray((1.0 - share) * first + share * mesh.frames[before])


def stilled(scene: Scene) -> Scene:
    """The scene as it is when its shutter opens, where that is an instant or there is none; else as given."""
    if scene.needs().shutter or not any(surface.motion for surface in scene.surfaces):
        return scene
    return at(scene, scene.camera.shutter[0] if scene.camera.shutter else 0.0)


TURNED_CHECKER = (
    "a checker that has turned has no still scene: its squares lie along the axes; "
    "open the shutter for a while, or take a zone plate"
)

STRETCHED_PATTERN = (
    "a pattern on a mesh that has changed its shape has no still scene: it is stretched with its triangles; "
    "open the shutter for a while, or take a material without a pattern"
)


def no_still(scene: Scene) -> str | None:
    """Why `at` cannot say what the scene is at a moment, or None."""
    for surface in scene.surfaces:
        pattern = scene.materials[surface.material].pattern
        if isinstance(surface.motion, Rotate) and isinstance(pattern, Checker):
            return TURNED_CHECKER
        if isinstance(surface.motion, Frames) and pattern:
            return STRETCHED_PATTERN
    return None


def at(scene: Scene, time: float) -> Scene:
    """The scene at a moment: nothing moves, and the shutter is an instant, which is no need. Patterns have gone with
    their surfaces. Raises InvalidInput for a checker that has turned, and a pattern on a mesh that has changed its
    shape."""
    camera = scene.camera.model_copy(update={"shutter": None, "response": "box"})
    materials, surfaces = dict(scene.materials), []
    for number, surface in enumerate(scene.surfaces):
        material, still = scene.materials[surface.material], moved(surface, time)
        if material.pattern and surface.motion and time != 0.0:
            name = f"{surface.material} of surface {number}"
            materials[name] = material.model_copy(update={"pattern": _carried(material.pattern, surface.motion, time)})
            still = still.model_copy(update={"material": name})
        surfaces.append(still)
    return scene.model_copy(update={"camera": camera, "materials": materials, "surfaces": tuple(surfaces)})


def _carried(pattern: ZonePlate | Checker, motion: Motion, time: float) -> ZonePlate | Checker:
    """The pattern where the surface that it rides on has taken it."""
    if isinstance(motion, Frames):
        raise InvalidInput(STRETCHED_PATTERN)
    if isinstance(pattern, Checker) and isinstance(motion, Rotate) and math.radians(motion.degrees) * time != 0.0:
        raise InvalidInput(TURNED_CHECKER)
    matrix, offset = transform(motion, time)
    return pattern.model_copy(update={"origin": tuple((matrix @ pattern.origin + offset).tolist())})
