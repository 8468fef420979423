"""What of a scene POV-Ray's own constants cut off, and the scale of the world at which they cut off least.

Its constants are lengths in units of its world, so a lit scene, or one with an endless plane, goes over multiplied by a
power of two: every coordinate keeps all its digits, and the picture stays the same.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from aliascope.geometry import Array, Frame, frame_of
from aliascope.model import AnySurface, Disc, LoadedMesh, Plane, Polygon, Scene, Sphere, Vector

FARTHEST = 1e7
"""Hits farther than this along a ray do not exist (MAX_DISTANCE; measured: 9.9e6 is drawn, 1.01e7 is not)."""

NEAREST = 1e-4
"""Hits of discs, triangles and planes nearer than this do not exist (measured: 1e-4 is drawn, 9.9e-5 is not)."""

LEAST_HALF_CHORD_SQUARED = 1e-10
"""A ray that cuts a sphere along a shorter half chord misses it (EPSILON in the sphere's code; measured: a sphere of
radius 1.1e-5 is drawn, one of 1e-5 is not)."""

SHADOW_GAP = 1e-3
"""What blocks the light nearer than this to a lit point casts no shadow on it (measured: 1.1e-3 does, 9e-4 does not,
whatever the kind and the distance of the light)."""

LIT_EXTENT = 2.0**14
"""Units from the eye to the farthest corner of a lit scene, at most. A hit on the rim of a sphere is off by as much as
sqrt(2^-52) of its distance, 2.4e-4 here: below SHADOW_GAP, so no sphere shadows itself. The gap is then 6e-8 of the
extent."""

LIT_HEIGHT, UNLIT_HEIGHT = 64.0, 1.0
"""Units from the eye to the farthest endless plane, at most. A plane ends at FARTHEST, height / FARTHEST below its
horizon; with lights, the shadow gap weighs against that: 1.6e-5 of the height."""

RIM_TOLERANCE_PX = 0.001
"""The most by which the rim of a sphere may lie wrong: what the design allows a silhouette."""

HORIZON_TOLERANCE_PX = 0.02
"""The most by which the horizon of a plane may lie wrong; it is 0.0008 in a lit picture of 40 degrees and 96 rows."""


def unit(vector: Vector | Array) -> Array:
    """The vector at length 1; scaled first, as the square of 1e200 has no double."""
    scaled = np.array(vector) / max(abs(x) for x in vector)
    length_1: Array = scaled / np.linalg.norm(scaled)
    return length_1


def world_scale(scene: Scene, recentred: bool = True) -> float:
    """The power of two that the coordinates are multiplied by. It is 1 where they go over as they are, and without
    lights and planes."""
    if not recentred or not (scene.lights or any(isinstance(surface, Plane) for surface in scene.surfaces)):
        return 1.0
    frame = frame_of(scene)
    extent = height = 0.0
    for surface in scene.surfaces:
        if isinstance(surface, Plane):
            height = max(height, _height(surface, frame))
            if not frame.perspective:
                extent = max(extent, _plane_depths(surface, frame)[1])
        else:
            extent = max(extent, _extent(surface, frame))
    bounds = [(LIT_EXTENT if scene.lights else FARTHEST / 4.0, extent)]
    if frame.perspective:
        bounds.append((LIT_HEIGHT if scene.lights else UNLIT_HEIGHT, height))
    exponents = [math.log2(most) - math.log2(has) for most, has in bounds if 0.0 < has < math.inf]
    return 2.0 ** math.floor(min(exponents, default=0.0))


def out_of_reach(scene: Scene, wider: tuple[float, float] = (1.0, 1.0), recentred: bool = True) -> str | None:
    """Why POV-Ray would leave out a part of the scene without a word, or None. Lengths in it are as POV-Ray has them.

    wider: how many times as wide and as high as its picture what is seen may be, by a shift on the film. recentred:
    whether coordinates go over relative to the eye, and scaled.
    Whole surfaces are looked at, within the view or not; a surface that runs from behind the camera to in front of it
    loses only a sliver to NEAREST and passes.
    """
    frame, scale = frame_of(scene), world_scale(scene, recentred)
    # A perspective ray toward a corner of the picture is longer than the depth that it reaches.
    seen = replace(frame, half_width=wider[0] * frame.half_width, half_height=wider[1] * frame.half_height)
    stretch = math.hypot(1.0, seen.half_width, seen.half_height) if frame.perspective else 1.0
    for surface in scene.surfaces:
        if isinstance(surface, Plane) and frame.perspective:
            lost = scale * _height(surface, frame) / FARTHEST / frame.pixel
            if lost > HORIZON_TOLERANCE_PX:
                return f"POV-Ray draws the horizon of a plane {lost:.2g} pixels off: the angle of view is too small"
            nearest = scale * _nearest_of_plane(surface, seen)
            if nearest < NEAREST:
                return f"POV-Ray sees nothing nearer than {NEAREST:g} units, and a plane begins at {nearest:.3g}"
            continue
        if isinstance(surface, Sphere):
            reason = _rim_lost(frame, np.array(surface.centre) - frame.eye, surface.radius, scale)
            if reason:
                return reason
        low, high = (scale * depth for depth in _depths(surface, seen))
        # No ray to a surface that ends is longer than the way to its farthest point.
        farthest = high * stretch
        if frame.perspective and farthest > FARTHEST:
            farthest = min(farthest, scale * _extent(surface, frame))
        if farthest > FARTHEST:
            return f"POV-Ray sees nothing beyond {FARTHEST:g} units, and a {surface.type} reaches {farthest:.3g}"
        if isinstance(surface, Sphere):
            continue
        if high > 0.0 and (0.0 < low < NEAREST or high < NEAREST):
            return f"POV-Ray sees nothing nearer than {NEAREST:g} units, and a {surface.type} begins at {low:.3g}"
    return None


def _corners(surface: Polygon | LoadedMesh) -> Array:
    return surface.triangles.reshape(-1, 3) if isinstance(surface, LoadedMesh) else np.array(surface.points)


def _extent(surface: AnySurface | LoadedMesh, frame: Frame) -> float:
    """The distance from the eye within which a surface that ends lies."""
    match surface:
        case Polygon() | LoadedMesh():
            return float(np.linalg.norm(_corners(surface) - frame.eye, axis=1).max())
        case Disc(centre=centre, radius=radius) | Sphere(centre=centre, radius=radius):
            return float(np.linalg.norm(np.array(centre) - frame.eye)) + radius
    return 0.0


def _height(plane: Plane, frame: Frame) -> float:
    """The distance of an endless plane from the eye."""
    return abs(float(unit(plane.normal) @ (np.array(plane.point) - frame.eye)))


def _nearest_of_plane(plane: Plane, frame: Frame) -> float:
    """The way to an endless plane along the shortest ray of a perspective picture, or along one to a corner of it;
    infinite where none meets it, and where the eye lies in it."""
    normal = unit(plane.normal)
    offset = float(normal @ (np.array(plane.point) - frame.eye))
    if offset == 0.0:
        return math.inf
    most = 0.0
    for across, upward in ((0.0, 0.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)):
        way = frame.forward + across * frame.half_width * frame.right + upward * frame.half_height * frame.up
        most = max(most, float(normal @ way) * math.copysign(1.0, offset) / float(np.linalg.norm(way)))
    return abs(offset) / most if most > 0.0 else math.inf


def _depths(surface: AnySurface | LoadedMesh, frame: Frame) -> tuple[float, float]:
    """The least and the largest depth of a surface, negative behind the camera; of a plane, those that are in view."""
    match surface:
        case Polygon() | LoadedMesh():
            depths = (_corners(surface) - frame.eye) @ frame.forward
            return float(depths.min()), float(depths.max())
        case Disc(centre=centre, normal=normal, radius=radius):
            depth = float((np.array(centre) - frame.eye) @ frame.forward)
            tilt = min(1.0, abs(float(unit(normal) @ frame.forward)))
            reach = radius * math.sqrt(1.0 - tilt * tilt)
            return depth - reach, depth + reach
        case Sphere(centre=centre, radius=radius):
            depth = float((np.array(centre) - frame.eye) @ frame.forward)
            return depth - radius, depth + radius
        case Plane():
            return _plane_depths(surface, frame)
    return 0.0, 0.0


def _plane_depths(plane: Plane, frame: Frame) -> tuple[float, float]:
    """The depths of an endless plane at the corners of an orthographic picture; 0 where it is seen edge-on."""
    normal = unit(plane.normal)
    along = float(normal @ frame.forward)
    if along == 0.0:
        return 0.0, 0.0
    middle = float(normal @ (np.array(plane.point) - frame.eye)) / along
    across = abs(float(normal @ frame.right)) * frame.half_width + abs(float(normal @ frame.up)) * frame.half_height
    return middle - across / abs(along), middle + across / abs(along)


def _rim_lost(frame: Frame, offset: Array, radius: float, scale: float) -> str | None:
    """Why the rim of a sphere, `offset` from the eye, would lie more than RIM_TOLERANCE_PX off, or None."""
    distance = float(np.linalg.norm(offset))
    if float(offset @ frame.forward) + radius <= 0.0 or distance <= radius:
        return None
    # The square of the half chord is the difference of squares as large as distance^2, in doubles.
    half_chord_squared = LEAST_HALF_CHORD_SQUARED / scale**2 + distance * distance * 2.0**-52
    lost = radius - math.sqrt(max(0.0, radius * radius - half_chord_squared))
    pixel = frame.pixel * (distance if frame.perspective else 1.0)
    if lost <= RIM_TOLERANCE_PX * pixel:
        return None
    return (
        f"POV-Ray draws the rim of a sphere of radius {radius:g}, {distance:.3g} units away, {lost / pixel:.2g} "
        "pixels off: change the scale of the scene"
    )
