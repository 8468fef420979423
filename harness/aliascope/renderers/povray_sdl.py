"""A scene as text in POV-Ray's scene description language, and what of a scene POV-Ray's own constants cut off.

Coordinates go over unchanged, as doubles with all their digits; the camera is given by its vectors, which keeps the
world right-handed (`look_at` and `angle` would mirror it). Triangles are objects each, not a mesh: the vertices of a
mesh are float32 in POV-Ray.
"""

from __future__ import annotations

import math

import numpy as np

from aliascope.geometry import Array, Frame, frame_of, surfaces_of
from aliascope.model import Colour, Disc, Material, Polygon, Scene, Sphere, Vector

PATTERN_CEILING = 0.9999999
"""Pattern values wrap to 0 at 1, so they stop short of it, by less than a 16-bit step / 150."""

FARTHEST = 1e7
"""Hits farther than this along a ray do not exist (MAX_DISTANCE; measured: 9.9e6 is drawn, 1.01e7 is not)."""

NEAREST = 1e-4
"""Hits of discs and triangles nearer than this do not exist (measured: 1e-4 is drawn, 9.9e-5 is not)."""

LEAST_HALF_CHORD_SQUARED = 1e-10
"""A ray that cuts a sphere along a shorter half chord misses it (EPSILON in the sphere's code; measured: a sphere of
radius 1.1e-5 is drawn, one of 1e-5 is not)."""

RIM_TOLERANCE_PX = 0.001
"""The most by which the rim of a sphere may lie wrong: what the design allows a silhouette."""


def scene_text(scene: Scene, size: tuple[int, int]) -> str:
    """The SDL of a scene whose features the renderer draws. `size`: width, height in pixels, for the aspect.

    Raises ValueError for polygons that have no triangles (see `geometry.triangulate`).
    """
    surfaces = surfaces_of(scene)
    lines = [
        "#version 3.7;",
        "global_settings { assumed_gamma 1.0 }",
        _camera(frame_of(scene, size)),
        f"background {{ {_colour(scene.view.background)} }}",
    ]
    for number, name in enumerate(surfaces.materials):
        lines.append(f"#declare Material_{number} = {_texture(scene.materials[name])}")
    for corners, number in zip(surfaces.triangles, surfaces.triangle_material, strict=True):
        points = ", ".join(_vector(corner) for corner in corners)
        lines.append(f"triangle {{ {points} texture {{ Material_{number} }} }}")
    for centre, normal, radius, number in surfaces.discs:
        place = f"{_vector(centre)}, {_vector(_unit(normal))}, {_number(radius)}"
        lines.append(f"disc {{ {place} texture {{ Material_{number} }} }}")
    for centre, radius, number in surfaces.spheres:
        lines.append(f"sphere {{ {_vector(centre)}, {_number(radius)} texture {{ Material_{number} }} }}")
    return "\n".join(lines) + "\n"


def brightest(scene: Scene) -> float:
    """The largest channel that the picture of an unlit scene can have, linear."""
    peak = max(scene.view.background)
    for name in {surface.material for surface in scene.surfaces}:
        material = scene.materials[name]
        peak = max(peak, *(channel for colour in _pattern_colours(material) for channel in colour))
    return peak


def out_of_reach(scene: Scene) -> str | None:
    """Why POV-Ray would leave out a part of the scene without a word, or None. Its limits are in units of the world.

    Whole surfaces are looked at, within the view or not; a surface that runs from behind the camera to in front of it
    loses only a sliver to NEAREST and passes.
    """
    frame = frame_of(scene)
    # A perspective ray toward a corner of the picture is longer than the depth that it reaches.
    stretch = math.hypot(1.0, frame.half_width, frame.half_height) if frame.perspective else 1.0
    for surface in scene.surfaces:
        match surface:
            case Polygon(points=points):
                depths = (np.array(points) - frame.eye) @ frame.forward
                low, high = float(depths.min()), float(depths.max())
            case Disc(centre=centre, normal=normal, radius=radius):
                depth = float((np.array(centre) - frame.eye) @ frame.forward)
                tilt = min(1.0, abs(float(_unit(normal) @ frame.forward)))
                reach = radius * math.sqrt(1.0 - tilt * tilt)
                low, high = depth - reach, depth + reach
            case Sphere(centre=centre, radius=radius):
                depth = float((np.array(centre) - frame.eye) @ frame.forward)
                low, high = depth - radius, depth + radius
                reason = _rim_lost(frame, np.array(centre) - frame.eye, depth, radius)
                if reason:
                    return reason
            case _:
                continue
        if high * stretch > FARTHEST:
            return f"POV-Ray sees nothing beyond {FARTHEST:g} units, and a {surface.type} reaches {high * stretch:.3g}"
        if not isinstance(surface, Sphere) and high > 0.0 and (0.0 < low < NEAREST or high < NEAREST):
            return f"POV-Ray sees nothing nearer than {NEAREST:g} units, and a {surface.type} begins at {low:.3g}"
    return None


def _rim_lost(frame: Frame, offset: Array, depth: float, radius: float) -> str | None:
    """Why the rim of a sphere, `offset` from the eye, would lie more than RIM_TOLERANCE_PX off, or None."""
    distance = float(np.linalg.norm(offset))
    if depth + radius <= 0.0 or distance <= radius:
        return None
    # The square of the half chord is the difference of squares as large as distance^2, in doubles.
    half_chord_squared = LEAST_HALF_CHORD_SQUARED + distance * distance * 2.0**-52
    lost = radius - math.sqrt(max(0.0, radius * radius - half_chord_squared))
    pixel = frame.pixel * (distance if frame.perspective else 1.0)
    if lost <= RIM_TOLERANCE_PX * pixel:
        return None
    return (
        f"POV-Ray draws the rim of a sphere of radius {radius:g}, {distance:.3g} units away, {lost / pixel:.2g} "
        "pixels off: change the scale of the scene"
    )


def _camera(frame: Frame) -> str:
    kind = "perspective" if frame.perspective else "orthographic"
    return (
        f"camera {{ {kind} location {_vector(frame.eye)} direction {_vector(frame.forward)} "
        f"right {_vector(2.0 * frame.half_width * frame.right)} up {_vector(2.0 * frame.half_height * frame.up)} }}"
    )


def _texture(material: Material) -> str:
    """Emission alone, times the pattern: without lights the albedo adds nothing."""
    return f"texture {{ {_pigment(material)} finish {{ ambient 0 diffuse 0 emission 1 }} }}"


def _pigment(material: Material) -> str:
    colours = [_colour(colour) for colour in _pattern_colours(material)]
    pattern = material.pattern
    if pattern is None:
        return f"pigment {{ {colours[0]} }}"
    if pattern.type != "zone-plate":
        raise ValueError(f"a {pattern.type} has no pigment")
    squares = "+".join(f"pow({axis}-({_number(x)}),2)" for axis, x in zip("xyz", pattern.origin, strict=True))
    value = f"(1+cos({_number(pattern.scale)}*({squares})))/2"
    return (
        f"pigment {{ function {{ min({PATTERN_CEILING}, {value}) }} "
        f"color_map {{ [0 {colours[0]}] [1 {colours[1]}] }} }}"
    )


def _pattern_colours(material: Material) -> list[Colour]:
    """The emission, or the emission times each colour of the pattern."""
    red, green, blue = material.emission
    if material.pattern is None:
        return [material.emission]
    return [(red * r, green * g, blue * b) for r, g, b in material.pattern.colours]


def _unit(vector: Vector) -> Array:
    """The vector at length 1; scaled first, as the square of 1e200 has no double."""
    scaled = np.array(vector) / max(abs(x) for x in vector)
    unit: Array = scaled / np.linalg.norm(scaled)
    return unit


def _number(x: float) -> str:
    """The shortest decimal that reads back as the same double (at most 17 significant digits)."""
    return repr(float(x))


def _vector(vector: Vector | Array) -> str:
    return f"<{', '.join(_number(x) for x in vector)}>"


def _colour(colour: Colour) -> str:
    return f"rgb {_vector(colour)}"
