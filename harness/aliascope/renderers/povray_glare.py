"""What is too bright for POV-Ray's files: the refusal, with what shines so and in which pixel."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from aliascope.geometry import Array, Frame, across, frame_of, surfaces_of
from aliascope.model import Scene
from aliascope.renderers.povray_light import Lighting, pattern_colours
from aliascope.renderers.povray_limits import unit

LARGEST_HALF = 65504.0
"""The largest half float."""

LARGEST_FLOAT = float(np.finfo(np.float32).max)

NEAREST = 1e-9
"""Of the farthest corner of a surface, how far ahead of the eye it is cut."""


def too_bright(scene: Scene, lighting: Lighting, exposed: bool, size: tuple[int, int]) -> str | None:
    """Why no file of POV-Ray's holds a picture that may be so bright, or None.

    An exposure brings any brightness within reach, but beside it half floats have no room for what is dimmer: a scene
    may be as much brighter than the faintest of its lights as half floats go beyond 1.
    """
    peak = lighting.peak
    most = min(LARGEST_FLOAT, LARGEST_HALF * max(1.0, _faintest(scene) if exposed else 1.0))
    if peak <= most:
        return None
    may = f"and this one may reach {peak:.6g}{_where(scene, lighting.brightest, size)}"
    if most == LARGEST_FLOAT:
        return f"pictures of float32 end at {LARGEST_FLOAT:.3g}, {may}"
    if most > LARGEST_HALF:
        return (
            f"POV-Ray's pictures hold light up to {LARGEST_HALF:g} times the faintest of the scene, so up to {most:g}, "
            f"{may}"
        )
    return f"POV-Ray's pictures end at {LARGEST_HALF:g}, {may}"


def _faintest(scene: Scene) -> float:
    """The largest channel of the faintest thing that shines at all."""
    patterned = (
        tuple(emitted * c for emitted, c in zip(material.emission, colour, strict=True))
        for material in scene.materials.values()
        for colour in pattern_colours(material)
    )
    shining = (max(each) for each in (scene.view.background, *patterned, *(light.intensity for light in scene.lights)))
    return min((most for most in shining if most > 0.0), default=1.0)


def _where(scene: Scene, material: str, size: tuple[int, int]) -> str:
    """The material that is the brightest, and a pixel that looks its way, where there is one; whether something else
    hides it there, is not asked."""
    if not material:
        return " in the background"
    frame = frame_of(scene, size)
    for corners in _outlines(scene, material, frame):
        pixel = _pixel(corners, frame)
        if pixel:
            return f' of "{material}", in pixel {pixel}'
    return f' of "{material}"'


def _outlines(scene: Scene, material: str, frame: Frame) -> Iterator[Array]:
    """Convex polygons (n, 3) that lie within the surfaces of a material: of a ball its inner square across the view, of
    a plane that around the point which the scene states."""
    surfaces = surfaces_of(scene)
    number = surfaces.materials.index(material)
    yield from surfaces.triangles[surfaces.triangle_material == number]
    round_about = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]) * np.sqrt(0.5)
    flat = [(centre, across(unit(normal)), radius) for centre, normal, radius, own in surfaces.discs if own == number]
    flat += [(centre, (frame.right, frame.up), radius) for centre, radius, own in surfaces.spheres if own == number]
    far = 1e9 * max(1.0, frame.half_height, float(np.abs(frame.eye).max()))
    flat += [(point, across(unit(normal)), far) for point, normal, own in surfaces.planes if own == number]
    for centre, axes, radius in flat:
        yield np.array(centre) + radius * round_about @ np.array(axes)


def _pixel(corners: Array, frame: Frame) -> tuple[int, int] | None:
    """One in which a convex polygon (n, 3) is seen, or None."""
    local = (corners - frame.eye) @ np.array([frame.right, frame.up, frame.forward]).T
    least = NEAREST * float(np.abs(local).max())
    along = (1.0, 0.0) if frame.perspective else (0.0, 1.0)
    # Each border of the view, as a x + b y + c z + d >= 0.
    borders = [(0.0, 0.0, 1.0, -least)]
    for sign in (1.0, -1.0):
        borders.append((sign, 0.0, along[0] * frame.half_width, along[1] * frame.half_width))
        borders.append((0.0, sign, along[0] * frame.half_height, along[1] * frame.half_height))
    for border in borders:
        local = _cut(local, np.array(border))
        if len(local) == 0:
            return None
    x, y, z = local.mean(axis=0)
    away = z if frame.perspective else 1.0
    right = 0.5 * (x / away / frame.half_width + 1.0) * frame.width
    down = 0.5 * (1.0 - y / away / frame.half_height) * frame.height
    return min(max(int(right), 0), frame.width - 1), min(max(int(down), 0), frame.height - 1)


def _cut(polygon: Array, border: Array) -> Array:
    """The part of a convex polygon on the inner side of a plane (Sutherland and Hodgman 1974)."""
    heights = polygon @ border[:3] + border[3]
    kept = []
    for i, (here, after) in enumerate(zip(heights, np.roll(heights, -1), strict=True)):
        if here >= 0.0:
            kept.append(polygon[i])
        if (here > 0.0 > after) or (here < 0.0 < after):
            kept.append(polygon[i] + here / (here - after) * (polygon[(i + 1) % len(polygon)] - polygon[i]))
    return np.array(kept).reshape(-1, 3)
