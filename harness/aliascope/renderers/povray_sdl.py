"""A scene as text in POV-Ray's scene description language.

Coordinates go over as doubles with all their digits, relative to the eye, as POV-Ray bounds its objects by boxes in
float32 (measured: a mesh of 4 units, 4e5 from the origin, has holes); and times a power of two where that brings its
constants out of the way (see `povray_limits`). The camera is given by its vectors, which keeps the world right-handed
(`look_at` and `angle` would mirror it). Triangles are objects each, not a mesh: the vertices of a mesh are float32 in
POV-Ray, and it is not faster. 100,000 triangles take 0.56 s to parse and 160 MB (a `mesh` 0.82 s and 230 MB), a million
7.5 s and 1.1 GB.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from aliascope.geometry import Array, Frame, Surfaces, frame_of, surfaces_of
from aliascope.model import BLACK, Colour, DirectionalLight, Material, PointLight, Scene, Vector
from aliascope.renderers.povray_light import lighting_of, pattern_colours
from aliascope.renderers.povray_limits import FARTHEST, unit, world_scale

PATTERN_CEILING = 0.9999999
"""Pattern values wrap to 0 at 1, so they stop short of it, by less than a 16-bit step / 150."""

LIGHT_DISTANCE = 3.0 * FARTHEST
"""Parallel rays start at the plane through their light, behind which there is light and no shadow: it stands farther
from the eye than all that can be seen."""

LEAST_ALBEDO = 2.0**-40
"""Of the emission: see `_texture`."""


@dataclass(frozen=True)
class World:
    """POV-Ray's coordinates: those of the scene, relative to the eye, times the scale."""

    eye: Array
    scale: float

    def place(self, point: Vector | Array) -> Array:
        """(..., 3) in the scene's coordinates to POV-Ray's."""
        placed: Array = self.scale * (np.asarray(point) - self.eye)
        return placed


def scene_text(scene: Scene, size: tuple[int, int], exposure: float = 1.0, shifts: Array | None = None) -> str:
    """The SDL of a scene whose features the renderer draws.

    size: width, height in pixels, for the aspect. exposure: what all light is divided by. shifts: (n, 2) pixels to the
    right and down by which the sample of each of n frames lies off the centres of the pixels, which is where all lie
    without them. Raises ValueError for polygons that have no triangles (see `geometry.triangulate`).
    """
    surfaces, world = surfaces_of(scene), World(frame_of(scene).eye, world_scale(scene))
    background = tuple(channel / exposure for channel in scene.view.background)
    lines = [
        "#version 3.7;",
        "global_settings { assumed_gamma 1.0 adc_bailout 0 }",
        *_camera(frame_of(scene, size), world.scale, np.zeros((1, 2)) if shifts is None else shifts),
        f"background {{ {_colour(background)} }}",
    ]
    for number, name in enumerate(surfaces.materials):
        lines.append(f"#declare Material_{number} = {_texture(scene.materials[name], exposure, world)}")
    if any(scene.materials[name].albedo != BLACK for name in surfaces.materials):
        lines += _lights(scene, exposure, world)
    return "\n".join([*lines, *_objects(surfaces, world)]) + "\n"


def _objects(surfaces: Surfaces, world: World) -> Iterable[str]:
    triangles = world.place(surfaces.triangles).reshape(-1, 9).tolist()
    for (a, b, c, d, e, f, g, h, i), number in zip(triangles, surfaces.triangle_material.tolist(), strict=True):
        corners = f"<{a!r},{b!r},{c!r}>,<{d!r},{e!r},{f!r}>,<{g!r},{h!r},{i!r}>"
        yield f"triangle {{ {corners} texture {{ Material_{number} }} }}"
    for centre, normal, radius, number in surfaces.discs:
        place = f"{_vector(world.place(centre))}, {_vector(unit(normal))}, {_number(world.scale * radius)}"
        yield f"disc {{ {place} texture {{ Material_{number} }} }}"
    for centre, radius, number in surfaces.spheres:
        place = f"{_vector(world.place(centre))}, {_number(world.scale * radius)}"
        yield f"sphere {{ {place} texture {{ Material_{number} }} }}"
    for point, normal, number in surfaces.planes:
        upright = unit(normal)
        offset = float(upright @ world.place(point))
        yield f"plane {{ {_vector(upright)}, {_number(offset)} texture {{ Material_{number} }} }}"


def _camera(frame: Frame, scale: float, shifts: Array) -> list[str]:
    """The camera; of several shifts, the one of the frame's number (from 1; a run for the time goes round again)."""
    steps = shifts * np.array([2.0 * frame.half_width / frame.width, -2.0 * frame.half_height / frame.height])
    if not frame.perspective:
        steps = scale * steps
    moved = [_vector(right * frame.right + up * frame.up) for right, up in steps]
    lines = []
    shift = moved[0]
    if len(moved) > 1:
        lines.append(f"#declare Shift = array[{len(moved)}] {{ {', '.join(moved)} }}")
        shift = f"Shift[mod(frame_number - 1, {len(moved)})]"
    direction = _vector(frame.forward)
    sides = 1.0 if frame.perspective else scale
    if frame.perspective:
        aim = f"perspective location 0 direction {direction} + {shift}"
    else:
        aim = f"orthographic location {shift} direction {direction}"
    across, upward = 2.0 * sides * frame.half_width * frame.right, 2.0 * sides * frame.half_height * frame.up
    lines.append(f"camera {{ {aim} right {_vector(across)} up {_vector(upward)} }}")
    return lines


def _lights(scene: Scene, exposure: float, world: World) -> Iterable[str]:
    for light, fade in zip(scene.lights, lighting_of(scene).fade_distances, strict=True):
        colour, more = light.intensity, ""
        match light:
            case DirectionalLight(direction=direction):
                place = -LIGHT_DISTANCE * unit(direction)
                more = " parallel point_at 0"
            case PointLight(position=position):
                place = world.place(position)
            case _:
                raise ValueError(f"a {light.type} light has no text")
        if light.falloff == "inverse-square":
            red, green, blue = colour
            share = 2.0 * fade * fade
            colour = (red / share, green / share, blue / share)
            more = f" fade_power 2 fade_distance {_number(world.scale * fade)}"
        emitted = tuple(channel / exposure for channel in colour)
        yield f"light_source {{ {_vector(place)}, {_colour(emitted)}{more} }}"


def _texture(material: Material, exposure: float, world: World) -> str:
    """pattern * (emission + albedo * light), for which POV-Ray has pigment * (emission + diffuse * light).

    The pigment is the pattern times the albedo, so the finish has the emission divided by the albedo. A channel that
    emits has an albedo of LEAST_ALBEDO of its emission at least: that much light comes back from it too many.
    """
    emission = [channel / exposure for channel in material.emission]
    if material.albedo == BLACK:
        return f"texture {{ {_pigment(material, emission, world)} finish {{ ambient 0 diffuse 0 emission 1 }} }}"
    albedo = [max(a, LEAST_ALBEDO * e) for a, e in zip(material.albedo, emission, strict=True)]
    ratios = [e / a if e > 0.0 else 0.0 for a, e in zip(albedo, emission, strict=True)]
    finish = f"finish {{ ambient 0 diffuse 1 emission {_colour(ratios)} }}"
    return f"texture {{ {_pigment(material, albedo, world)} {finish} }}"


def _pigment(material: Material, factor: Iterable[float], world: World) -> str:
    """The pattern, or white, times a colour. It is stated in the scene's coordinates and then moved to POV-Ray's."""
    tint = np.array(tuple(factor))
    colours = [_colour(tint * np.array(colour)) for colour in pattern_colours(material)]
    pattern = material.pattern
    if pattern is None:
        return f"pigment {{ {colours[0]} }}"
    if pattern.type == "checker":
        body = f"checker {', '.join(colours)} scale {_number(1.0 / pattern.scale)} translate {_vector(pattern.origin)}"
    else:
        squares = "+".join(f"pow({axis}-({_number(x)}),2)" for axis, x in zip("xyz", pattern.origin, strict=True))
        value = f"(1+cos({_number(pattern.scale)}*({squares})))/2"
        body = f"function {{ min({PATTERN_CEILING}, {value}) }} color_map {{ [0 {colours[0]}] [1 {colours[1]}] }}"
    return f"pigment {{ {body} scale {_number(world.scale)} translate {_vector(world.place((0.0, 0.0, 0.0)))} }}"


def _number(x: float) -> str:
    """The shortest decimal that reads back as the same double (at most 17 significant digits)."""
    return repr(float(x))


def _vector(vector: Vector | Array) -> str:
    return f"<{', '.join(_number(x) for x in vector)}>"


def _colour(colour: Colour | Array | Iterable[float]) -> str:
    return f"rgb <{', '.join(_number(x) for x in colour)}>"
