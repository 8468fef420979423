"""How far the renderers are right: measured limits, against which scenes are checked.

Each is a quantity of a scene, and the most of it with which a picture was still what it should be. Past it a renderer
leaves things out, or puts the wrong ones in front, without a word; so the cell stays empty, with the reason. Made with

    aliascope stability --group geometry 'povray*' 'osmesa*' 'embree*'

whose tables say where each breaks. What else POV-Ray leaves out, it refuses by itself: `povray_limits`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aliascope.geometry import Array, Frame, across, frame_of, plane_axes
from aliascope.model import AnySurface, Disc, LoadedMesh, Plane, Polygon, Scene, Sphere, by_scene
from aliascope.placement import size_of

EDGE_ON = 2.0**-50
"""A sine that is 0 but for rounding."""

LEAST_SINE = 1e-10
"""POV-Ray's EPSILON, of the cosine between ray and normal (measured: of triangles, discs and planes, what is seen from
6e-9 degrees above is there, from 5e-9 it is not)."""

SEEN = 0.02
"""Pixels of a surface that may be lost at its horizon, as `povray_limits` has it."""

MOST_FACES = 1000
"""Faces of which each is held against each other; of more, none is."""


@dataclass(frozen=True)
class Limit:
    """`of` measures a scene; past `most` the renderer is wrong. `reason` has the quantity and the limit as {has} and
    {most}. as_they_are: only where coordinates go over as they are (`recentre=0`, `relative=off`). extreme: the column
    of the map."""

    renderer: str
    extreme: str
    most: float
    of: Callable[[Scene], float]
    reason: str
    as_they_are: bool = False


def beyond(renderer: str, scene: Scene, as_they_are: bool) -> str | None:
    """Why a picture of the scene would not be right, or None."""
    for limit in LIMITS:
        if limit.renderer == renderer and (as_they_are or not limit.as_they_are):
            has = _has(scene, limit)
            if has > limit.most:
                return limit.reason.format(has=f"{has:.2g}", most=f"{limit.most:.2g}")
    return None


@by_scene
def _has(scene: Scene, limit: Limit) -> float:
    return limit.of(scene)


def _far_for_its_size(scene: Scene) -> float:
    """The largest coordinate over the size of the smallest thing that ends."""
    least, largest = math.inf, max(map(abs, scene.camera.eye))
    for surface in scene.surfaces:
        sizes, places = _sizes(surface)
        if (sizes > 0.0).any():
            sizes = sizes[sizes > 0.0]
            least, largest = min(least, float(sizes.min())), max(largest, float(np.abs(places).max()))
    return largest / least if 0.0 < least < math.inf else 0.0


def _sizes(surface: AnySurface | LoadedMesh) -> tuple[Array, Array]:
    """Of the parts of a surface: how large the box of each is (n,), and places (m, 3)."""
    match surface:
        case Polygon(points=points):
            corners = np.array([points])
        case LoadedMesh(triangles=corners):
            pass
        case Sphere(centre=centre, radius=radius) | Disc(centre=centre, radius=radius):
            return np.array([2.0 * radius]), np.array([centre])
        case _:
            corners = np.zeros((0, 3, 3))
    return (corners.max(axis=1) - corners.min(axis=1)).max(axis=-1, initial=0.0), corners.reshape(-1, 3)


def _rounded_pixels(scene: Scene) -> float:
    """By how many pixels rounding the largest coordinates to float moves something, at most."""
    frame, most = frame_of(scene), 0.0
    eye = max(map(abs, scene.camera.eye))
    for surface in scene.surfaces:
        places = _sizes(surface)[1]
        if len(places):
            # In perspective what is nearest moves most; nothing moves by more pixels than at the tenth of the depth.
            depths = np.abs((places - frame.eye) @ frame.forward)
            pixel = frame.pixel * (max(float(depths.min()), 0.1 * float(depths.max())) if frame.perspective else 1.0)
            largest = max(eye, float(np.abs(places).max()))
            most = max(most, 2.0**-25 * largest / pixel if pixel > 0.0 else 0.0)
    return most


def _shadow_gap_share(scene: Scene) -> float:
    """POV-Ray's shadow gap of a thousandth of a unit, over the size of a scene with lights."""
    size = size_of(scene)
    lit = bool(scene.lights) and any(any(scene.materials[surface.material].albedo) for surface in scene.surfaces)
    return 1e-3 / size if lit and size > 0.0 else 0.0


def _grazing(scene: Scene) -> float:
    """One over the least sine at which a ray meets a flat surface where something of it is seen; 0 where none is."""
    frame = frame_of(scene)
    if frame.perspective and SEEN * frame.pixel > LEAST_SINE:
        return 1.0 / (SEEN * frame.pixel)  # more than that is nowhere seen
    least = min((_least_sine(surface, frame) for surface in scene.surfaces), default=math.inf)
    return 1.0 / least


def _least_sine(surface: AnySurface | LoadedMesh, frame: Frame) -> float:
    """Infinite for what is not flat, for what is seen from its very edge, and where SEEN pixels hold all of it. In an
    orthographic view all rays meet a face at one sine; in perspective the least is its height over the eye by the
    distance of its farthest corner, and below SEEN pixels of it nothing is seen."""
    if isinstance(surface, Plane):
        return _least_sine_of_plane(surface, frame)
    faces = _faces(surface)
    if faces is None:
        return math.inf
    normals, places, reach = faces
    if frame.perspective:
        distances, sizes = reach(frame.eye)
        sines = np.maximum(np.abs(((places - frame.eye) * normals).sum(axis=-1)) / distances, SEEN * frame.pixel)
        seen = sizes > SEEN * frame.pixel * distances
    else:
        sines = np.abs(normals @ frame.forward)
        seen = (sines > EDGE_ON) & (sines * reach(frame.eye)[1] > SEEN * frame.pixel)
    return float(sines[seen].min(initial=math.inf))


def _least_sine_of_plane(plane: Plane, frame: Frame) -> float:
    """Over the picture; at its horizon, where there is one, what SEEN pixels hold is left."""
    normal = _units(plane.normal)[0]
    along = float(normal @ frame.forward)
    if not frame.perspective:
        return abs(along) if abs(along) > EDGE_ON else math.inf
    across_, upward = float(normal @ frame.right) * frame.half_width, float(normal @ frame.up) * frame.half_height
    corners = [along + i * across_ + j * upward for i in (-1.0, 1.0) for j in (-1.0, 1.0)]
    least = 0.0 if min(corners) < 0.0 < max(corners) else min(map(abs, corners))
    return max(least, SEEN * frame.pixel)


Reach = Callable[[Array], tuple[Array, Array]]


def _faces(surface: AnySurface | LoadedMesh) -> tuple[Array, Array, Reach] | None:
    """Of flat surfaces that end the unit normals (n, 3), a place on each (n, 3), and what tells how far each reaches
    from an eye, and how large it is (n,)."""
    match surface:
        case Polygon(points=points):
            corners = np.array([points])
            normals = plane_axes(corners[0])[2][np.newaxis]
        case LoadedMesh(triangles=corners):
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            lengths = np.linalg.norm(normals, axis=-1)
            corners, normals = corners[lengths > 0.0], normals[lengths > 0.0] / lengths[lengths > 0.0, np.newaxis]
        case Disc(centre=centre, normal=normal, radius=radius):
            place, size = np.array([centre]), np.array([2.0 * radius])
            return _units(normal), place, lambda eye: (np.linalg.norm(place - eye, axis=-1) + radius, size)
        case _:
            return None
    sizes = (corners.max(axis=1) - corners.min(axis=1)).max(axis=-1)
    return normals, corners[:, 0], lambda eye: (np.linalg.norm(corners - eye, axis=-1).max(axis=-1), sizes)


def _units(normal: tuple[float, float, float]) -> Array:
    scaled = np.array([normal]) / max(map(abs, normal))
    return np.asarray(scaled / np.linalg.norm(scaled))


@dataclass(frozen=True)
class _Face:
    """A flat surface that ends: its unit normal, a place on it, and its box in the picture, in u and v."""

    normal: Array
    place: Array
    low: Array
    high: Array
    depth: float


def _face(surface: AnySurface | LoadedMesh, frame: Frame) -> _Face | None:
    match surface:
        case Polygon(points=points):
            corners, normal = np.array(points), plane_axes(np.array(points))[2]
        case Disc(centre=centre, normal=stated, radius=radius):
            normal = _units(stated)[0]
            first, second = across(normal)
            sides = np.array([first + second, first - second, -first - second, second - first])
            corners = np.array(centre) + radius * sides
        case _:
            return None
    local = (corners - frame.eye) @ np.array([frame.right, frame.up, frame.forward]).T
    if frame.perspective:
        if local[:, 2].min() <= 0.0:
            return None  # reaches behind the eye: its box is all of the picture, and its depths are all there are
        local[:, :2] /= local[:, 2:]
    depth = float(local[:, 2].min())
    return _Face(normal, corners[0], local[:, :2].min(axis=0), local[:, :2].max(axis=0), depth)


def _narrowest_gap(scene: Scene) -> float:
    """One over the least gap between parallel faces, one before the other, in the depth that it has to be told apart
    in: that of the faces in perspective, else the range of all depths. 0 where there is none. What is less than 1e-12
    of it apart lies in one plane, but for rounding, and the scene does not say which is in front."""
    frame = frame_of(scene)
    faces = [face for surface in scene.surfaces if (face := _face(surface, frame))]
    if not 1 < len(faces) <= MOST_FACES:
        return 0.0
    normals, places = np.array([face.normal for face in faces]), np.array([face.place for face in faces])
    low, high = np.array([face.low for face in faces]), np.array([face.high for face in faces])
    depths = np.array([face.depth for face in faces])
    span = np.full(len(faces), float(depths.max() - depths.min()) + frame.half_height)
    scale = depths if frame.perspective else span
    most = 0.0
    for i in range(len(faces) - 1):
        rest = slice(i + 1, None)
        parallel = np.linalg.norm(np.cross(normals[rest], normals[i]), axis=-1) < 1e-9
        over = ((low[rest] < high[i]) & (high[rest] > low[i])).all(axis=-1)
        facing = abs(float(normals[i] @ frame.forward))
        gaps = np.abs((places[rest] - places[i]) @ normals[i]) / max(facing, 1e-3)
        shares = gaps[parallel & over] / scale[i]
        shares = shares[shares > 1e-12]
        if len(shares):
            most = max(most, 1.0 / float(shares.min()))
    return most


LIMITS: tuple[Limit, ...] = (
    Limit(
        "povray",
        "grazing",
        1.0 / LEAST_SINE,
        _grazing,
        "POV-Ray misses what a ray meets at a sine below 1e-10, and here one meets a surface at 1/{has}",
    ),
    Limit(
        "povray",
        "far",
        1e7,
        _far_for_its_size,
        "POV-Ray bounds surfaces by boxes of floats, and the largest coordinate is {has} times as large as the "
        "smallest of them, past {most}: take recentre=1",
        as_they_are=True,
    ),
    Limit(
        "povray",
        "shadow",
        1e-2,
        _shadow_gap_share,
        "POV-Ray throws no shadow from nearer than 1e-3 units, which is {has} of the scene, past {most}: "
        "take recentre=1",
        as_they_are=True,
    ),
    Limit(
        "osmesa",
        "far",
        0.07,
        _rounded_pixels,
        "coordinates as float are off by {has} pixels, past {most}: take recentre=1",
        as_they_are=True,
    ),
    Limit(
        "osmesa",
        "coplanar",
        2.0**22,
        _narrowest_gap,
        "OpenGL's depth is float, and one face lies before another by 1/{has} of the depth: below 1/{most} it cannot "
        "tell which is in front",
    ),
    Limit(
        "embree",
        "far",
        0.01,
        _rounded_pixels,
        "coordinates as float are off by {has} pixels, past {most}: take relative=on",
        as_they_are=True,
    ),
    Limit(
        "embree",
        "coplanar",
        2.0**22,
        _narrowest_gap,
        "Embree's distances are float, and one face lies before another by 1/{has} of the depth: below 1/{most} it "
        "cannot tell which is in front",
    ),
)
