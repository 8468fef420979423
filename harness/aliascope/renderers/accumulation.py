"""Pictures that are the mean of passes over all pixels: what each pass chooses by one sampling pattern.

Haeberli and Akeley 1990, "The Accumulation Buffer". A pass has one place in the pixel, one time, one point of the lens
and one of each light with an area, by the dimensions of one point of the pattern, in that order; tracer.h has the same
and says how a point is chosen. A scene spends no dimension on what it does not need.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from aliascope.geometry import Array
from aliascope.model import Scene
from aliascope.native import samplers
from aliascope.native.warps import DISC


@dataclass(frozen=True)
class Choices:
    """What n passes choose. offsets (n, 2) in [0, 1): from the left and top border of the pixel; weights (n,); times
    (n,) in [0, 1], None for a scene that stands still; lens (n, 2): to the right and up from the middle of the lens, in
    the scene's units, None without a lens; lights (n, lights with an area, 2) in [0, 1), None without one."""

    offsets: Array
    weights: Array
    times: Array | None = None
    lens: Array | None = None
    lights: Array | None = None


def choices_of(scene: Scene, sampler: str, count: int, seed: int, arrangement: str) -> Choices:
    """Those of a scene whose needs a mean of passes meets; `arrangement`, of its groups of dimensions. Raises
    Unsupported for a pattern without so many points or dimensions, SpecError."""
    needs = scene.needs()
    points = samplers.points(sampler, count, needs.groups, seed, arrangement=arrangement)
    lens = 2 + needs.shutter
    lights = lens + 2 * needs.lens
    return Choices(
        points[:, :2],
        samplers.weights(sampler, count, needs.groups, arrangement),
        shutter_times(scene, points[:, 2]) if needs.shutter else None,
        lens_points(scene, points[:, lens:lights]) if needs.lens else None,
        points[:, lights:].reshape(count, needs.area_lights, 2) if needs.area_lights else None,
    )


def shutter_times(scene: Scene, u: Array) -> Array:
    """The times (n,) at which the shutter's response has let the shares u (n,) of all its light through."""
    assert scene.camera.shutter is not None
    opening, closing = scene.camera.shutter
    if scene.camera.response == "triangle":
        u = np.where(u < 0.5, np.sqrt(0.5 * u), 1.0 - np.sqrt(0.5 * (1.0 - u)))
    times: Array = opening + (closing - opening) * u
    return times


def lens_points(scene: Scene, u: Array) -> Array:
    """Points (n, 2) spread evenly over the aperture: the disc of the lens, by the concentric map, or the regular
    polygon inscribed in it with a corner upward, a triangle for each blade."""
    radius, blades = scene.camera.lens_radius, scene.camera.blades
    assert radius is not None
    if blades < 3:
        return radius * DISC.sample(u)
    place = blades * u[:, 0]
    blade = np.minimum(np.floor(place), blades - 1.0)
    angles = 2.0 * math.pi / blades * (blade[:, np.newaxis] + np.array([0.0, 1.0]))
    corners = np.stack([np.sin(angles), np.cos(angles)], axis=-1)
    # Of a triangle with a corner in the middle: the square root spreads the distance from it, evenly over the area.
    along, reach = (place - blade)[:, np.newaxis], np.sqrt(u[:, 1:])
    points: Array = radius * reach * ((1.0 - along) * corners[:, 0] + along * corners[:, 1])
    return points
