"""A scene as text in POV-Ray's scene description language.

Coordinates go over as doubles with all their digits, relative to the eye, as POV-Ray bounds its objects by boxes in
float32 (measured: a mesh of 4 units, 4e5 from the origin, has holes); and times a power of two where that brings its
constants out of the way (see `povray_limits`). The camera is given by its vectors, which keeps the world right-handed
(`look_at` and `angle` would mirror it). Triangles are objects each, not a mesh: the vertices of a mesh are float32 in
POV-Ray, and it is not faster. 100,000 triangles take 0.56 s to parse and 160 MB (a `mesh` 0.82 s and 230 MB), a million
7.5 s and 1.1 GB.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from aliascope.geometry import Array, Frame, Surfaces, frame_of, surfaces_of
from aliascope.model import BLACK, AreaLight, Colour, DirectionalLight, Material, PointLight, Scene, Vector
from aliascope.renderers.povray_area_lights import LightPoints
from aliascope.renderers.povray_frames import FocalBlur, Frames, LightGrid, moments
from aliascope.renderers.povray_light import lighting_of, pattern_colours
from aliascope.renderers.povray_limits import FARTHEST, unit, world_scale

PATTERN_CEILING = 0.9999999
"""Pattern values wrap to 0 at 1, so they stop short of it, by less than a 16-bit step / 150."""

LIGHT_DISTANCE = 3.0 * FARTHEST
"""Parallel rays start at the plane through their light, behind which there is light and no shadow: it stands farther
from the eye than all that can be seen."""

MOVING = "moving"
"""How the names of the files begin that hold what moves, one for each frame."""

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

    def from_eye(self, eye: Vector | Array, offset: Array) -> Array:
        """Where an offset (3,), in POV-Ray's units, leads from the eye; to the bit as it is where the eye is at 0."""
        at = self.place(eye)
        return at + offset if at.any() else offset


def scene_text(
    scene: Scene,
    size: tuple[int, int],
    exposure: float = 1.0,
    frames: Frames | None = None,
    recentred: bool = True,
) -> str:
    """The SDL of a scene whose features the renderer draws.

    size: width, height in pixels, for the aspect. exposure: what all light is divided by. frames: without them there is
    one, whose samples lie at the centres of the pixels. What moves is in a file for each frame: see `moving_texts`.
    recentred: whether coordinates go over relative to the eye, and scaled; else they are the scene's own.
    Raises ValueError for polygons that have no triangles (see `geometry.triangulate`).
    """
    frames = frames or Frames(np.zeros((1, 2)), np.ones(1))
    surfaces, world = surfaces_of(_standing(scene, frames)), world_of(scene, frames, recentred)
    names = tuple(dict.fromkeys(surface.material for surface in scene.surfaces))
    background = tuple(channel / exposure for channel in scene.view.background)
    lines = [
        "#version 3.7;",
        f"global_settings {{ assumed_gamma 1.0 adc_bailout 0{_trace_level(scene)} }}",
        *_camera(scene, frame_of(scene, size), world, frames, exposure),
        f"background {{ {_colour(background)} }}",
    ]
    for number, name in enumerate(names):
        lines.append(f"#declare Material_{number} = {_texture(scene.materials[name], exposure, world)}")
    if any(scene.materials[name].albedo != BLACK for name in names):
        lines += _lights(scene, exposure, world, frames)
    if frames.times is not None:
        count = len(frames.times)
        which = f"str({_frame_number(count)} + 1, 0, 0)" if count > 1 else '"1"'
        lines.append(f'#include concat("{MOVING}", {which}, ".inc")')
    return "\n".join([*lines, *_objects(surfaces, names, world)]) + "\n"


def moving_texts(scene: Scene, exposure: float, frames: Frames, recentred: bool = True) -> Iterator[tuple[str, str]]:
    """For each frame the name of a file, which the scene's text includes, and the text of what moves, where it is
    then; patterns that it takes along are materials of the frame's own."""
    if frames.times is None:
        return
    names = tuple(dict.fromkeys(surface.material for surface in scene.surfaces))
    world = world_of(scene, frames, recentred)
    moving = scene.model_copy(update={"surfaces": tuple(s for s in scene.surfaces if s.motion is not None)})
    for number, moment in enumerate(moments(moving, frames.times), 1):
        surfaces = surfaces_of(moment)
        carried = tuple(name for name in dict.fromkeys(surfaces.materials) if name not in names)
        lines = [
            f"#declare Material_{len(names) + i} = {_texture(moment.materials[name], exposure, world)}"
            for i, name in enumerate(carried)
        ]
        lines += _objects(surfaces, names + carried, world)
        yield f"{MOVING}{number}.inc", "\n".join(lines) + "\n"


def world_of(scene: Scene, frames: Frames, recentred: bool = True) -> World:
    """The same for all frames: at the scale that cuts off least of whichever has the most to lose; or the scene's."""
    if not recentred:
        return World(np.zeros(3), 1.0)
    return World(frame_of(scene).eye, min(world_scale(moment) for moment in moments(scene, frames.times)))


def _standing(scene: Scene, frames: Frames) -> Scene:
    """What stands still in all frames."""
    if frames.times is None:
        return scene
    return scene.model_copy(update={"surfaces": tuple(s for s in scene.surfaces if s.motion is None)})


def _objects(surfaces: Surfaces, names: tuple[str, ...], world: World) -> Iterable[str]:
    index = [names.index(name) for name in surfaces.materials]
    triangles = world.place(surfaces.triangles).reshape(-1, 9).tolist()
    for (a, b, c, d, e, f, g, h, i), number in zip(triangles, surfaces.triangle_material.tolist(), strict=True):
        corners = f"<{a!r},{b!r},{c!r}>,<{d!r},{e!r},{f!r}>,<{g!r},{h!r},{i!r}>"
        yield f"triangle {{ {corners} texture {{ Material_{index[number]} }} }}"
    for centre, normal, radius, number in surfaces.discs:
        place = f"{_vector(world.place(centre))}, {_vector(unit(normal))}, {_number(world.scale * radius)}"
        yield f"disc {{ {place} texture {{ Material_{index[number]} }} }}"
    for centre, radius, number in surfaces.spheres:
        place = f"{_vector(world.place(centre))}, {_number(world.scale * radius)}"
        yield f"sphere {{ {place} texture {{ Material_{index[number]} }} }}"
    for point, normal, number in surfaces.planes:
        upright = unit(normal)
        offset = float(upright @ world.place(point))
        yield f"plane {{ {_vector(upright)}, {_number(offset)} texture {{ Material_{index[number]} }} }}"


def _camera(scene: Scene, frame: Frame, world: World, frames: Frames, exposure: float) -> list[str]:
    """The camera; of several frames, the one of the frame's number.

    Through a point of the lens the camera looks from there, its picture skewed so that what is in focus stays.
    """
    axes = np.array([frame.right, frame.up])
    steps = frames.shifts * np.array([2.0 * frame.half_width / frame.width, -2.0 * frame.half_height / frame.height])
    if not frame.perspective:
        steps = world.scale * steps
    places = None
    if frames.lens is not None:
        assert scene.camera.focus_distance is not None
        steps = steps - frames.lens / scene.camera.focus_distance
        places = world.scale * frames.lens @ axes
    lines: list[str] = []
    shift = _chosen(lines, "Shift", np.array([right * frame.right + up * frame.up for right, up in steps]))
    direction = _vector(frame.forward)
    sides = 1.0 if frame.perspective else world.scale
    eye = world.place(frame.eye)
    away = f"{_vector(eye)} + " if eye.any() else ""
    if frame.perspective:
        location = "0" if places is None else _chosen(lines, "Lens", places)
        aim = f"perspective location {away}{location} direction {direction} + {shift}"
    else:
        aim = f"orthographic location {away}{shift} direction {direction}"
    wider, higher = (
        1.0 + abs(more) / count for more, count in zip(frames.further, (frame.width, frame.height), strict=True)
    )
    across = 2.0 * sides * wider * frame.half_width * frame.right
    upward = 2.0 * sides * higher * frame.half_height * frame.up
    aim += f" right {_vector(across)} up {_vector(upward)}"
    if frames.blur:
        aim += _focal_blur(scene, frame, world, frames.blur, exposure)
    lines.append(f"camera {{ {aim} }}")
    return lines


def _focal_blur(scene: Scene, frame: Frame, world: World, blur: FocalBlur, exposure: float) -> str:
    """The camera's statements; the variance is that of colours as POV-Ray sees them, divided by the exposure."""
    camera = scene.camera
    assert camera.lens_radius is not None
    assert camera.focus_distance is not None
    return (
        f" aperture {_number(world.scale * blur.aperture * camera.lens_radius)}"
        f" focal_point {_vector(world.from_eye(frame.eye, world.scale * camera.focus_distance * frame.forward))}"
        f" blur_samples {blur.samples} confidence {_number(blur.confidence)}"
        f" variance {_number(blur.variance / exposure**2)}"
    )


def _chosen(lines: list[str], name: str, vectors: Array) -> str:
    """The expression of a vector for each frame; of several, an array of that name is added to the lines."""
    texts = [_vector(vector) for vector in vectors]
    if len(texts) == 1:
        return texts[0]
    lines.append(f"#declare {name} = array[{len(texts)}] {{ {', '.join(texts)} }}")
    return f"{name}[{_frame_number(len(texts))}]"


def _frame_number(count: int) -> str:
    """The frame's number from 0, of several frames; a run for the time goes round again."""
    return f"mod(frame_number - 1, {count})"


def _lights(scene: Scene, exposure: float, world: World, frames: Frames) -> Iterable[str]:
    fades = lighting_of(scene, frames).fade_distances
    eye = world.place(scene.camera.eye)
    looked_from = _vector(eye) if eye.any() else "0"
    for number, (light, fade) in enumerate(zip(scene.lights, fades, strict=True)):
        lines: list[str] = []
        points = frames.lights[number] if frames.lights else None
        share, divisor, more = points.share if points else 1.0, 1.0, ""
        match light:
            case DirectionalLight(direction=direction):
                place = _vector(world.from_eye(scene.camera.eye, -LIGHT_DISTANCE * unit(direction)))
                more = f" parallel point_at {looked_from}"
            case PointLight(position=position):
                place = _vector(world.place(position))
            case AreaLight(corner=corner, edges=edges) if points is None:
                place = _vector(world.place(np.array(corner) + 0.5 * (np.array(edges[0]) + np.array(edges[1]))))
                more = _area_light(light, world, frames.grid)
            case _:
                if points is None:
                    raise ValueError(f"a {light.type} light has no text")
                place = _chosen(lines, f"Light_{number}", world.place(points.places))
                if light.falloff == "inverse-square":
                    more = _cosine(lines, number, place, points)
        if light.falloff == "inverse-square":
            divisor = 2.0 * fade * fade
            more += f" fade_power 2 fade_distance {_number(world.scale * fade)}"
        emitted = tuple(share * channel / divisor / exposure for channel in light.intensity)
        yield from lines
        yield f"light_source {{ {place}, {_colour(emitted)}{more} }}"


def _cosine(lines: list[str], number: int, place: str, points: LightPoints) -> str:
    """The statement that makes a light's rays weaker by the cosine, and leaves none behind: see
    `povray_area_lights`."""
    facing = _vector(points.facing[0]) if points.flat else _chosen(lines, f"Facing_{number}", points.facing)
    return f" spotlight radius 90 falloff 90 tightness 1 point_at {place} + {facing}"


def _area_light(light: AreaLight, world: World, grid: LightGrid) -> str:
    """The points of an area light lie on a grid whose border is the light's: at (side - 1) / side of its size they are
    the middles of side x side cells. Without `area_illumination` it would shine from its centre, but for shadows.
    With it POV-Ray multiplies the mean of n.l by that of visibility: off by their covariance (measured: 0.0033 where
    a light of 9 units is 12 away and half hidden)."""
    side = grid.side
    first, second = (_vector(world.scale * (side - 1.0) / side * np.array(edge)) for edge in light.edges)
    adaptive = "" if grid.adaptive == "off" else f" adaptive {grid.adaptive}"
    return f" area_light {first}, {second}, {side}, {side} area_illumination on{adaptive}{' jitter' * grid.jitter}"


def _trace_level(scene: Scene) -> str:
    """Nothing without mirrors. Of level 1 is what the eye sees itself: a ray past the last level brings no light."""
    return f" max_trace_level {scene.transport.mirror_bounces + 1}" if scene.needs().mirror else ""


def _texture(material: Material, exposure: float, world: World) -> str:
    """pattern * (emission + albedo * light) + mirrored, for which POV-Ray has pigment * (emission + diffuse * light) +
    mirrored.

    The pigment is the pattern times the albedo, so the finish has the emission divided by the albedo. A channel that
    emits has an albedo of LEAST_ALBEDO of its emission at least: that much light comes back from it too many.
    """
    emission = [channel / exposure for channel in material.emission]
    mirror = f" reflection {{ {_colour(material.reflection)} }}" if material.reflection != BLACK else ""
    if material.albedo == BLACK:
        return (
            f"texture {{ {_pigment(material, emission, world)} finish {{ ambient 0 diffuse 0 emission 1{mirror} }} }}"
        )
    albedo = [max(a, LEAST_ALBEDO * e) for a, e in zip(material.albedo, emission, strict=True)]
    ratios = [e / a if e > 0.0 else 0.0 for a, e in zip(albedo, emission, strict=True)]
    finish = f"finish {{ ambient 0 diffuse 1 emission {_colour(ratios)}{mirror} }}"
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
