"""What flaws would do to a picture, how far the samples of a pixel range, and how long its edges are.

From pictures FINE times as wide and high. The one of the tracer with a sample a pixel has what a single sample sees;
that with several, averaged again, has the picture moved by a part of a pixel, and under a wider pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter

from aliascope import renderers
from aliascope.geometry import Array
from aliascope.model import AnyLight, AreaLight, DiscLight, Material, Scene, SphereLight, Vector
from aliascope.regression.defects import GAIN, OFFSET, SHIFT, WIDER
from aliascope.renderers.base import Request
from aliascope.studies.agree_judge import Effect

FINE = 16
SAMPLES = 16
"""Of a pixel of the fine picture."""
PAIRED = 4096
"""Of a pixel, where a scene and one that was changed are rendered with the same samples: noise in their difference
would make less of the flaw than there is."""
PASSES = 8
"""Fine pictures of single passes, for a scene of which each pass shows another lens point, time or point of a light."""


@dataclass(frozen=True)
class Facts:
    """Of a scene's picture, all (height, width, 3). ranges: of the values of single samples of a pixel; edges: the
    total variation across its outlines, value times pixels: outlines that are each displaced by up to d pixels change
    its mean by no more than d times that. None where nobody asked."""

    ranges: Array
    effects: tuple[Effect, ...]
    edges: Array | None


def facts_of(scene: Scene, size: tuple[int, int], displaced: bool) -> Facts:
    """Renders what there is to know of a scene at a size; `displaced`: the edges too, as OSMesa draws them. Raises
    NotAvailable, JobFailed."""
    single = _fine(scene, size, "embree", "uniform:n=1,sampler=random", 1)
    ranges = _ranges(single)
    fine = _fine(scene, size, "embree", f"uniform:n={SAMPLES},sampler=sobol,sampler.scramble=owen", 2)
    effects = (*_of_pictures(fine), *_of_scenes(scene, size))
    return Facts(ranges, effects, _edges(scene, size) if displaced else None)


def _picture(scene: Scene, size: tuple[int, int], renderer: str, mode: str, seed: int) -> Array:
    found = renderers.find(renderer)
    request = Request(scene, *size, renderers.mode_of(found, mode), seed)
    return found.render(request).pixels.astype(np.float64)


def _fine(scene: Scene, size: tuple[int, int], renderer: str, mode: str, seed: int) -> Array:
    return _picture(scene, (FINE * size[0], FINE * size[1]), renderer, mode, seed)


def _ranges(single: Array) -> Array:
    """Between the largest and the least sample of a pixel and its neighbours, whose details may reach into it."""
    height, width, _ = single.shape
    cells = single.reshape(height // FINE, FINE, width // FINE, FINE, 3)
    most, least = cells.max(axis=(1, 3)), cells.min(axis=(1, 3))
    found: Array = maximum_filter(most, (3, 3, 1)) + maximum_filter(-least, (3, 3, 1))
    return found


# --- flaws ------------------------------------------------------------------------------------------------------------


def _of_pictures(fine: Array) -> list[Effect]:
    """Those that a picture itself tells: of its values, its place, its pixels."""
    plain = boxed(fine)
    right = boxed(fine, right=-SHIFT) - boxed(fine, right=SHIFT)
    down = boxed(fine, down=-SHIFT) - boxed(fine, down=SHIFT)
    return [
        Effect("gain", 100.0 * GAIN, "%", GAIN * plain),
        Effect("offset", 255.0 * OFFSET, "/255", np.full_like(plain, OFFSET)),
        Effect("moved right", SHIFT, "px", right / 2.0),
        Effect("moved down", SHIFT, "px", down / 2.0),
        Effect("wider pixel", 100.0 * WIDER, "%", boxed(fine, side=1.0 + WIDER) - plain),
    ]


def boxed(fine: Array, right: float = 0.0, down: float = 0.0, side: float = 1.0) -> Array:
    """The means over boxes of so many pixels a side, moved from the pixels' own places; the border goes on as it is."""
    return np.ascontiguousarray(_boxed(_boxed(fine, 0, down, side), 1, right, side))


def _boxed(fine: Array, axis: int, shift: float, side: float) -> Array:
    values = np.moveaxis(fine, axis, 0)
    count = len(values) // FINE
    room = FINE
    values = np.pad(values, ((room, room), (0, 0), (0, 0)), mode="edge")
    sums = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    middles: Array = np.asarray(room + FINE * (np.arange(count) + 0.5 + shift))
    half = 0.5 * side * FINE
    means = (_between(sums, middles + half) - _between(sums, middles - half)) / (2.0 * half)
    return np.moveaxis(means, 0, axis)


def _between(sums: Array, places: Array) -> Array:
    """The sums up to places that are no whole numbers."""
    below = np.floor(places).astype(int)
    share = (places - below)[:, np.newaxis, np.newaxis]
    found: Array = (1.0 - share) * sums[below] + share * sums[below + 1]
    return found


def _of_scenes(scene: Scene, size: tuple[int, int]) -> list[Effect]:
    """Those of what only some scenes have: the scene changed, and rendered with the same samples."""
    changed = changed_scenes(scene)
    if not changed:
        return []
    mode = f"uniform:n={PAIRED},sampler=sobol,sampler.scramble=owen"
    plain = _picture(scene, size, "embree", mode, 3)
    return [
        Effect(name, 100.0 * WIDER, "%", _picture(other, size, "embree", mode, 3) - plain)
        for name, other in changed.items()
    ]


def changed_scenes(scene: Scene) -> dict[str, Scene]:
    """The scene with what it has beside its pixels made wider or shorter, each by itself, by the name of the flaw."""
    needs, camera = scene.needs(), scene.camera
    changed: dict[str, Scene] = {}
    if needs.lens:
        assert camera.lens_radius is not None
        lens = {"lens_radius": (1.0 + WIDER) * camera.lens_radius}
        changed["wider lens"] = scene.model_copy(update={"camera": camera.model_copy(update=lens)})
    if needs.shutter:
        assert camera.shutter is not None
        opening, closing = camera.shutter
        shutter = {"shutter": (opening, opening + (1.0 - WIDER) * (closing - opening))}
        changed["shorter shutter"] = scene.model_copy(update={"camera": camera.model_copy(update=shutter)})
    if needs.area_lights:
        changed["wider lights"] = scene.model_copy(update={"lights": tuple(map(_wider, scene.lights))})
    return changed


def _wider(light: AnyLight) -> AnyLight:
    """Each side and radius, about the middle; the intensity stays."""
    factor = 1.0 + WIDER
    if isinstance(light, DiscLight | SphereLight):
        return light.model_copy(update={"radius": factor * light.radius})
    if isinstance(light, AreaLight):
        first, second = light.edges
        corner = _sum(light.corner, _times(first, -0.5 * WIDER), _times(second, -0.5 * WIDER))
        return light.model_copy(update={"corner": corner, "edges": (_times(first, factor), _times(second, factor))})
    return light


def _times(vector: Vector, factor: float) -> Vector:
    x, y, z = vector
    return x * factor, y * factor, z * factor


def _sum(*vectors: Vector) -> Vector:
    x, y, z = (sum(each) for each in zip(*vectors, strict=True))
    return x, y, z


# --- edges ------------------------------------------------------------------------------------------------------------


def _edges(scene: Scene, size: tuple[int, int]) -> Array:
    """The mean over single passes of OSMesa: what the mean of passes blurs is sharp in each."""
    passes = PASSES if scene.needs().dimensions > 2 else 1
    mode, outlined = "accumulate:n=1,sampler=random", _outlined(scene)
    found = []
    for seed in range(passes):
        fine = _fine(scene, size, "osmesa", mode, seed)
        found.append(variation(fine, fine if outlined is None else _fine(outlined, size, "osmesa", mode, seed)))
    mean: Array = np.mean(found, axis=0)
    return mean


def _outlined(scene: Scene) -> Scene | None:
    """The scene with a colour of its own for each surface, and no patterns or lights: what the shader evaluates is not
    displaced, outlines alone are. None for one with a mesh, whose triangles have outlines within it."""
    if "mesh" in scene.features():
        return None
    colours = np.random.default_rng(0).uniform(0.25, 1.0, (len(scene.surfaces), 3)).tolist()
    materials = {f"surface {number}": Material(emission=tuple(each)) for number, each in enumerate(colours)}
    surfaces = tuple(
        surface.model_copy(update={"material": f"surface {number}"}) for number, surface in enumerate(scene.surfaces)
    )
    return scene.model_copy(update={"materials": materials, "surfaces": surfaces, "lights": ()})


def variation(fine: Array, outlined: Array) -> Array:
    """The total variation in each pixel and a fine pixel around it, value times pixels, across what are edges in
    `outlined`: the sum of the differences of fine neighbours across and down, which is that of a slanted edge or more,
    up to sqrt(2) times."""
    found = np.zeros_like(fine)
    for axis in (0, 1):
        ends = [(0, int(axis == 0)), (0, int(axis == 1)), (0, 0)]
        edge = (np.diff(outlined, axis=axis) != 0.0).any(axis=2, keepdims=True)
        found += np.pad(np.abs(np.diff(fine, axis=axis)) * edge, ends)
    side = 1.0 + 2.0 / FINE
    # A fine pixel's difference acts along its side, 1 / FINE; there are (side FINE)^2 of them in the box.
    return boxed(found, side=side) * side**2 * FINE
