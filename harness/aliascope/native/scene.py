"""A scene as the C structs of scene.h."""

from __future__ import annotations

from typing import Any

import numpy as np

from aliascope.geometry import frame_of, surfaces_of
from aliascope.model import Material, Scene, ZonePlate


def pack(ffi: Any, scene: Scene, size: tuple[int, int]) -> tuple[Any, list[Any]]:
    """An `asc_scene *` and what must live as long as it is used. The scene has only what a renderer written in C draws.

    Raises ValueError for a polygon that is not planar and simple.
    """
    frame, surfaces = frame_of(scene, size), surfaces_of(scene)
    packed = ffi.new("asc_scene *")
    packed.struct_size = ffi.sizeof("asc_scene")
    view = packed.view
    projections = ffi.typeof("asc_projection").relements
    view.projection = projections["ASC_PERSPECTIVE" if frame.perspective else "ASC_ORTHOGRAPHIC"]
    view.width, view.height = frame.width, frame.height
    view.half_width, view.half_height = frame.half_width, frame.half_height
    for name in ("eye", "right", "up", "forward"):
        setattr(view, name, list(getattr(frame, name)))
    view.background = list(scene.view.background)

    materials = ffi.new("asc_material[]", max(len(surfaces.materials), 1))
    for target, name in zip(materials, surfaces.materials, strict=False):
        _pack_material(ffi, target, scene.materials[name])
    discs = ffi.new("asc_disc[]", [(centre, normal, radius, m) for centre, normal, radius, m in surfaces.discs])
    spheres = ffi.new("asc_sphere[]", [(centre, radius, m) for centre, radius, m in surfaces.spheres])
    vertices = np.ascontiguousarray(surfaces.triangles)
    triangle_material = np.ascontiguousarray(surfaces.triangle_material)
    packed.materials, packed.material_count = materials, len(surfaces.materials)
    packed.vertices = ffi.from_buffer("double[]", vertices)
    packed.triangle_material = ffi.from_buffer("uint32_t[]", triangle_material)
    packed.triangle_count = len(vertices)
    packed.discs, packed.disc_count = discs, len(surfaces.discs)
    packed.spheres, packed.sphere_count = spheres, len(surfaces.spheres)
    return packed, [materials, discs, spheres, vertices, triangle_material]


def _pack_material(ffi: Any, target: Any, material: Material) -> None:
    target.emission = list(material.emission)
    kinds = ffi.typeof("asc_pattern_kind").relements
    match material.pattern:
        case ZonePlate(scale=scale, origin=origin, colours=(low, high)):
            target.pattern.kind = kinds["ASC_PATTERN_ZONE_PLATE"]
            target.pattern.scale, target.pattern.origin = scale, list(origin)
            target.pattern.low, target.pattern.high = list(low), list(high)
        case _:
            target.pattern.kind = kinds["ASC_PATTERN_NONE"]
