"""A scene as the C structs of scene.h."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aliascope import motion
from aliascope.geometry import Surfaces, across, frame_of, surfaces_of
from aliascope.model import (
    AnyLight,
    AreaLight,
    Checker,
    DirectionalLight,
    DiscLight,
    Frames,
    Ggx,
    Material,
    Motion,
    Phong,
    PointLight,
    Rotate,
    Scene,
    SphereLight,
    ZonePlate,
)


def pack(
    ffi: Any, scene: Scene, size: tuple[int, int], shift: tuple[float, float] = (0.0, 0.0)
) -> tuple[Any, list[Any]]:
    """An `asc_scene *` and what must live as long as it is used. The scene has only what a renderer written in C draws.

    shift: pixels to the right and down by which the picture is moved on the film.
    Raises ValueError for a polygon that is not planar and simple.
    """
    scene = motion.stilled(scene)
    frame, surfaces = frame_of(scene, size), surfaces_of(scene)
    packed = ffi.new("asc_scene *")
    packed.struct_size = ffi.sizeof("asc_scene")
    view = packed.view
    projections = ffi.typeof("asc_projection").relements
    view.projection = projections["ASC_PERSPECTIVE" if frame.perspective else "ASC_ORTHOGRAPHIC"]
    view.width, view.height = frame.width, frame.height
    view.half_width, view.half_height = frame.half_width, frame.half_height
    view.shift = list(shift)
    for name in ("eye", "right", "up", "forward"):
        setattr(view, name, list(getattr(frame, name)))
    view.background = list(scene.view.background)
    if scene.needs().lens:
        view.lens_radius, view.focus_distance = scene.camera.lens_radius, scene.camera.focus_distance
        view.blades = scene.camera.blades

    materials = ffi.new("asc_material[]", max(len(surfaces.materials), 1))
    for target, name in zip(materials, surfaces.materials, strict=False):
        _pack_material(ffi, target, scene.materials[name])
    discs = ffi.new("asc_disc[]", [(centre, normal, radius, m) for centre, normal, radius, m in surfaces.discs])
    spheres = ffi.new("asc_sphere[]", [(centre, radius, m) for centre, radius, m in surfaces.spheres])
    planes = ffi.new("asc_plane[]", list(surfaces.planes))
    lights = ffi.new("asc_light[]", [_light(ffi, light) for light in scene.lights])
    vertices = np.ascontiguousarray(surfaces.triangles)
    triangle_material = np.ascontiguousarray(surfaces.triangle_material)
    packed.materials, packed.material_count = materials, len(surfaces.materials)
    packed.vertices = ffi.from_buffer("double[]", vertices)
    packed.triangle_material = ffi.from_buffer("uint32_t[]", triangle_material)
    packed.triangle_count = len(vertices)
    packed.discs, packed.disc_count = discs, len(surfaces.discs)
    packed.spheres, packed.sphere_count = spheres, len(surfaces.spheres)
    packed.planes, packed.plane_count = planes, len(surfaces.planes)
    packed.lights, packed.light_count = lights, len(scene.lights)
    packed.transport.mirror_bounces = scene.needs().mirror_bounces
    packed.transport.diffuse_bounces = scene.needs().diffuse_bounces
    keep = [materials, discs, spheres, planes, lights, vertices, triangle_material]
    if scene.needs().shutter:
        keep += _pack_motions(ffi, packed, scene, surfaces)
    return packed, keep


def _pack_motions(ffi: Any, packed: Any, scene: Scene, surfaces: Surfaces) -> list[Any]:
    camera, view = scene.camera, packed.view
    assert camera.shutter is not None  # or there would be no need
    view.shutter_open, view.shutter_close = camera.shutter
    responses = ffi.typeof("asc_response").relements
    view.response = responses["ASC_RESPONSE_BOX" if camera.response == "box" else "ASC_RESPONSE_TRIANGLE"]
    motions = ffi.new("asc_motion[]", [_motion(ffi, each) for each in surfaces.motions])
    packed.motions, packed.motion_count = motions, len(surfaces.motions)
    keep = [motions]
    for target, frames in zip(motions, surfaces.frames, strict=True):
        if frames is not None:
            corners = np.ascontiguousarray(frames)
            target.frames = ffi.from_buffer("double[]", corners)
            target.frame_count, target.frame_triangles = corners.shape[:2]
            keep.append(corners)
    for kind in ("triangle", "disc", "sphere", "plane"):
        of_kind = np.array(getattr(surfaces, f"{kind}_motion"), np.uint32)
        setattr(packed, f"{kind}_motion", ffi.from_buffer("uint32_t[]", of_kind))
        keep.append(of_kind)
    return keep


def _motion(ffi: Any, given: Motion) -> dict[str, Any]:
    kinds = ffi.typeof("asc_motion_kind").relements
    if isinstance(given, Frames):
        return {"kind": kinds["ASC_MOTION_FRAMES"]}
    if isinstance(given, Rotate):
        angle = math.radians(given.degrees)
        return {"kind": kinds["ASC_MOTION_ROTATE"], "axis": given.axis, "centre": given.centre, "angle": angle}
    return {"kind": kinds["ASC_MOTION_TRANSLATE"], "by": given.by}


def _light(ffi: Any, light: AnyLight) -> dict[str, Any]:
    kinds = ffi.typeof("asc_light_kind").relements
    inverse_square = int(light.falloff == "inverse-square")
    more: dict[str, Any] = {}
    match light:
        case PointLight(position=place):
            kind = kinds["ASC_LIGHT_POINT"]
        case DirectionalLight(direction=place):
            kind = kinds["ASC_LIGHT_DIRECTIONAL"]
        case AreaLight(corner=place, edges=edges):
            kind, more = kinds["ASC_LIGHT_PARALLELOGRAM"], {"edges": edges}
        case DiscLight(centre=place, normal=normal, radius=radius):
            first, second = across(np.array(normal) / np.linalg.norm(normal))
            kind, more = kinds["ASC_LIGHT_DISC"], {"edges": [(radius * first).tolist(), (radius * second).tolist()]}
        case SphereLight(centre=place, radius=radius):
            kind, more = kinds["ASC_LIGHT_SPHERE"], {"radius": radius}
    return {"kind": kind, "place": place, "intensity": light.intensity, "inverse_square": inverse_square, **more}


def _pack_material(ffi: Any, target: Any, material: Material) -> None:
    target.emission, target.albedo = list(material.emission), list(material.albedo)
    target.reflection = list(material.reflection)
    lobes = ffi.typeof("asc_lobe_kind").relements
    match material.gloss:
        case Phong(exponent=exponent):
            target.gloss.kind, target.gloss.exponent = lobes["ASC_LOBE_PHONG"], exponent
        case Ggx(roughness=roughness):
            target.gloss.kind, target.gloss.roughness = lobes["ASC_LOBE_GGX"], roughness
    kinds = ffi.typeof("asc_pattern_kind").relements
    names = {ZonePlate: "ASC_PATTERN_ZONE_PLATE", Checker: "ASC_PATTERN_CHECKER"}
    if material.pattern is None:
        target.pattern.kind = kinds["ASC_PATTERN_NONE"]
        return
    target.pattern.kind = kinds[names[type(material.pattern)]]
    target.pattern.scale, target.pattern.origin = material.pattern.scale, list(material.pattern.origin)
    target.pattern.low, target.pattern.high = (list(colour) for colour in material.pattern.colours)
