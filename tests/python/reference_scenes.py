"""What the tests of the references share: scenes in units of pixels, and a brute-force picture of any scene."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aliascope import scene_io
from aliascope.model import Scene
from aliascope.references import Reference, make

REPOSITORY = Path(__file__).resolve().parents[2]
SIZE = (12, 9)
BACKGROUND = (0.07, 0.11, 0.05)
COLOURS = {"red": (0.9, 0.2, 0.1), "green": (0.2, 0.8, 0.3), "blue": (0.1, 0.3, 0.95)}

Array = NDArray[np.float64]


def stored(name: str) -> Scene:
    """A scene of scenes/."""
    return scene_io.load(name).scene


@functools.cache
def reference_of(name: str) -> Reference:
    """The exact reference of a scene of scenes/, at its own size, made once."""
    of = stored(name)
    return make(of, of.view.size)


def scene(*surfaces: dict[str, object], size: tuple[int, int] = SIZE, **changes: object) -> Scene:
    """An orthographic scene whose unit is the pixel, seen along -z from z = 16. `changes` replace whole entries."""
    content: dict[str, object] = {
        "title": "a test",
        "shows": "what the test says",
        "view": {"size": size, "background": BACKGROUND},
        "camera": {"type": "orthographic", "eye": [0, 0, 16], "look_at": [0, 0, 0], "height": size[1]},
        "materials": {name: {"emission": colour} for name, colour in COLOURS.items()},
        "surfaces": surfaces,
    }
    return Scene.model_validate(content | changes)


def polygon(
    corners: Sequence[Sequence[float]], z: float = 0.0, material: str = "red", size: tuple[int, int] = SIZE
) -> dict[str, object]:
    """A polygon of corners in pixels (x to the right, y down), each with its own z or all at the same."""
    points = [[c[0] - size[0] / 2, size[1] / 2 - c[1], c[2] if len(c) > 2 else z] for c in corners]
    return {"type": "polygon", "material": material, "points": points}


def box(x0: float, y0: float, x1: float, y1: float, z: float = 0.0, material: str = "red") -> dict[str, object]:
    return polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], z, material)


def disc(x: float, y: float, radius: float, z: float = 0.0, material: str = "blue") -> dict[str, object]:
    return {"type": "disc", "material": material, "centre": [x - SIZE[0] / 2, SIZE[1] / 2 - y, z], "radius": radius}


def brute_force(scene: Scene, size: tuple[int, int], pixel: tuple[int, int], seed: int) -> tuple[Array, Array]:
    """The mean radiance over a pixel, (3,), and its standard error, of 1002528 rays.

    Two uniform points in each of 708 x 708 strata: what differs between the two is the variance within the stratum.
    """
    strata = 708
    rng = np.random.default_rng(seed)
    corner = np.indices((strata, strata)).reshape(2, -1).T[np.newaxis]
    places = (corner + rng.random((2, strata * strata, 2))) / strata + pixel
    first, second = (
        np.concatenate([radiance(scene, size, part) for part in np.array_split(half, 32)], axis=1) for half in places
    )
    variance = ((first - second) ** 2 / 4).sum(axis=1) / strata**4
    return (first.mean(axis=1) + second.mean(axis=1)) / 2, np.sqrt(variance)


def radiance(scene: Scene, size: tuple[int, int], places: Array) -> Array:
    """The radiance (3, n) along the rays through places (n, 2), in pixels: the emission of the nearest surface."""
    camera = scene.camera
    eye, up = np.array(camera.eye), np.array(camera.up)
    ahead = np.array(camera.look_at) - eye
    ahead = ahead / np.sqrt(ahead @ ahead)
    right = np.cross(ahead, up)
    right = right / np.sqrt(right @ right)
    above = np.cross(right, ahead)
    tall = camera.height if camera.height is not None else 2 * np.tan(np.radians(camera.vertical_fov_degrees) / 2)
    u = (places[:, 0] - size[0] / 2) * tall / size[1]
    v = (size[1] / 2 - places[:, 1]) * tall / size[1]
    across = [u * right[k] + v * above[k] for k in range(3)]
    perspective = camera.type == "perspective"
    origin = [eye[k] + (0.0 if perspective else across[k]) for k in range(3)]
    direction = [ahead[k] + (across[k] if perspective else 0.0) for k in range(3)]
    result = np.repeat(np.array(scene.view.background)[:, np.newaxis], len(places), axis=1)
    nearest = np.full(len(places), np.inf)
    for surface in scene.surfaces:
        plane = surface.type == "plane"
        if surface.type == "polygon":
            points = np.array(surface.points)
            normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
            base = points[0]
        else:
            normal, base = np.array(surface.normal), np.array(surface.point if plane else surface.centre)
        with np.errstate(divide="ignore", invalid="ignore"):
            time = sum((base[k] - origin[k]) * normal[k] for k in range(3)) / (
                sum(direction[k] * normal[k] for k in range(3))
            )
            hit = [origin[k] + time * direction[k] for k in range(3)]
        if surface.type == "polygon":
            inside = _in_polygon(hit, points, int(np.argmax(np.abs(normal))))
        elif plane:
            inside = np.ones(len(places), dtype=bool)
        else:
            inside = sum((hit[k] - base[k]) ** 2 for k in range(3)) < surface.radius**2
        seen = inside & (time > 0) & (time < nearest)
        if not seen.any():
            continue
        nearest[seen] = np.broadcast_to(time, seen.shape)[seen]
        material = scene.materials[surface.material]
        for channel, colour in enumerate(material.emission):
            if material.pattern is None:
                result[channel, seen] = colour
                continue
            low, high = (c[channel] for c in material.pattern.colours)
            if material.pattern.type == "checker":
                cells = [np.floor(material.pattern.scale * (hit[k] - material.pattern.origin[k])) for k in range(3)]
                odd = np.broadcast_to(sum(cells) % 2 == 1, seen.shape)
                result[channel, seen] = (colour * np.where(odd, high, low))[seen]
                continue
            phase = material.pattern.scale * sum((hit[k] - material.pattern.origin[k]) ** 2 for k in range(3))
            result[channel, seen] = (colour * (low + (high - low) * (1 + np.cos(phase)) / 2))[seen]
    return result


def _in_polygon(hit: Sequence[Array], points: Array, dropped: int) -> NDArray[np.bool_]:
    """Even-odd: how often a ray to the right within the polygon's plane crosses its edges."""
    kept = [axis for axis in range(3) if axis != dropped]
    x, y = hit[kept[0]], hit[kept[1]]
    inside = np.zeros(len(x), dtype=bool)
    for a, b in zip(points[:, kept], np.roll(points, -1, axis=0)[:, kept], strict=True):
        if a[1] != b[1]:
            inside ^= ((a[1] > y) != (b[1] > y)) & (x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1]))
    return inside
