"""Scenes for the tests of the POV-Ray renderer, and shorthand to render them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.geometry import Frame, frame_of, surfaces_of
from aliascope.model import Checker, Scene
from aliascope.records import Rendering
from aliascope.renderers.base import Request
from aliascope.renderers.povray import RENDERER
from aliascope.specs import Spec, parse

Array = NDArray[np.float64]


def mode(text: str) -> Spec:
    return parse(text, RENDERER.modes, "mode of povray")


def scene_of(
    surfaces: list[dict[str, Any]],
    materials: dict[str, dict[str, Any]],
    camera: dict[str, Any] | None = None,
    size: tuple[int, int] = (16, 12),
    background: tuple[float, float, float] = (0.0, 0.0, 0.0),
    lights: list[dict[str, Any]] | None = None,
) -> Scene:
    """A scene; without a camera, one unit is one pixel, and the origin is the middle of the picture."""
    return Scene.model_validate(
        {
            "title": "test",
            "shows": "test",
            "view": {"size": size, "background": background},
            "camera": camera
            or {"type": "orthographic", "eye": (0, 0, 9), "look_at": (0, 0, 0), "height": float(size[1])},
            "materials": materials,
            "surfaces": surfaces,
            "lights": lights or [],
        }
    )


def pixel_rays(frame: Frame, offset: tuple[float, float] = (0.5, 0.5)) -> tuple[Array, Array]:
    """Origins and directions (height, width, 3) of the rays at an offset from the left and top border of each pixel."""
    x, y = np.meshgrid(np.arange(frame.width) + offset[0], np.arange(frame.height) + offset[1])
    u = (2 * x / frame.width - 1) * frame.half_width
    v = (1 - 2 * y / frame.height) * frame.half_height
    across = u[..., None] * frame.right + v[..., None] * frame.up
    still = np.zeros_like(across)
    if frame.perspective:
        return still + frame.eye, across + frame.forward
    return frame.eye + across, still + frame.forward


def render(scene: Scene, text: str, **options: Any) -> Rendering:
    return RENDERER.render(Request(scene, *scene.view.size, mode(text), **options))


def render_all(scenes: list[Scene], text: str = "none") -> list[Rendering]:
    """All at once: a run of POV-Ray sleeps for most of its 0.7 s."""
    with ThreadPoolExecutor(len(scenes)) as pool:
        return list(pool.map(lambda scene: render(scene, text), scenes))


PLAIN = scene_of(
    [{"type": "disc", "material": "white", "centre": (0, 0, 0), "radius": 2.0}],
    {"white": {"emission": (1, 1, 1)}},
    size=(8, 8),
    background=(0.25, 0.25, 0.25),
)


# An evaluator of its own: every ray against every surface, by the textbook, in double


def hits(scene: Scene, origins: Array, directions: Array) -> list[tuple[Array, Array, str]]:
    """Of each surface: the parameter of the first hit past 1e-7, infinite for none; its normals; its material."""
    surfaces, found = surfaces_of(scene), []
    flat = [(c, n, ("disc", c, r), m) for c, n, r, m in surfaces.discs]
    flat += [(p, n, ("plane",), m) for p, n, m in surfaces.planes]
    for corners, m in zip(surfaces.triangles, surfaces.triangle_material, strict=True):
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        flat.append((corners[0], normal, ("triangle", corners), int(m)))
    for point, direction, outline, m in flat:
        normal = np.array(direction) / np.linalg.norm(direction)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (np.array(point) - origins) @ normal / (directions @ normal)
            places = origins + t[..., None] * directions
        inside = np.isfinite(t)
        if outline[0] == "disc":
            inside &= np.linalg.norm(np.where(inside[..., None], places, 0) - outline[1], axis=-1) < outline[2]
        elif outline[0] == "triangle":
            for i in range(3):
                side = outline[1][(i + 1) % 3] - outline[1][i]
                inside &= np.cross(side, np.where(inside[..., None], places, 0) - outline[1][i]) @ normal >= 0.0
        found.append((np.where(inside & (t > 1e-7), t, np.inf), np.broadcast_to(normal, directions.shape), m))
    for centre, radius, m in surfaces.spheres:
        offset = origins - np.array(centre)
        a, b = (directions**2).sum(-1), (directions * offset).sum(-1)
        root = np.sqrt(np.maximum(b * b - a * ((offset**2).sum(-1) - radius**2), -0.0))
        near, far = (-b - root) / a, (-b + root) / a
        t = np.where(root > 0.0, np.where(near > 1e-7, near, np.where(far > 1e-7, far, np.inf)), np.inf)
        found.append((t, (offset + np.where(np.isfinite(t), t, 0)[..., None] * directions) / radius, m))
    return [(t, normals, surfaces.materials[m]) for t, normals, m in found]


def pattern(scene: Scene, name: str, points: Array) -> Array:
    made = scene.materials[name].pattern
    if made is None:
        return np.ones_like(points)
    away = points - np.array(made.origin)
    if isinstance(made, Checker):
        return np.array(made.colours)[(np.floor(made.scale * away).sum(-1) % 2).astype(int)]
    low, high = np.array(made.colours)
    return low + (high - low) * ((1 + np.cos(made.scale * (away**2).sum(-1))) / 2)[..., None]


def evaluate(scene: Scene) -> Array:
    """pattern (emission + albedo sum of intensity max(0, n.l) visibility) at the pixel centres."""
    origins, directions = pixel_rays(frame_of(scene))
    nearest, normals = np.full(origins.shape[:2], np.inf), np.zeros(origins.shape)
    names = np.full(origins.shape[:2], "", object)
    for t, upright, name in hits(scene, origins, directions):
        closer = t < nearest
        nearest[closer], normals[closer], names[closer] = t[closer], upright[closer], name
    seen = np.isfinite(nearest)
    points = origins + np.where(seen, nearest, 0.0)[..., None] * directions
    normals *= -np.sign((normals * directions).sum(-1))[..., None]
    light_there = np.zeros(origins.shape)
    for light in scene.lights:
        if light.type == "point":
            toward = np.array(light.position) - points
            distance = np.linalg.norm(toward, axis=-1)
            toward = toward / distance[..., None]
        else:
            assert light.type == "directional"
            toward = np.broadcast_to(-np.array(light.direction) / np.linalg.norm(light.direction), points.shape)
            distance = np.full(seen.shape, np.inf)
        # 1e-9 off the surface, which is past its rounding and far below a pixel.
        blocked = [t < distance for t, _, _ in hits(scene, points + 1e-9 * normals, toward)]
        share = np.maximum(0.0, (normals * toward).sum(-1)) * ~np.logical_or.reduce(blocked)
        if light.falloff == "inverse-square":
            share = share / distance**2
        light_there += share[..., None] * np.array(light.intensity)
    picture = np.zeros(origins.shape) + scene.view.background
    for name, material in scene.materials.items():
        radiance = np.array(material.emission) + np.array(material.albedo) * light_there
        where = seen & (names == name)
        picture[where] = (pattern(scene, name, points) * radiance)[where]
    return picture
