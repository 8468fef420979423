"""Lights with an area in the frames of `accumulate`: in each frame one is a single light at a point of it.

The mean over the frames is the integral over the light, of the product of shading and visibility, for which POV-Ray's
own `area_light` has the product of their means.

Where a light falls off, the cosine at its surface is that of a spotlight: POV-Ray's has cos^tightness of the angle to
its axis, and no other fall-off within `radius` (measured: at 90 degrees and a tightness of 1 its light is the cosine
to half a step of 16 bits, and 0 behind).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aliascope.geometry import Array, across
from aliascope.model import AnyLight, AreaLight, DirectionalLight, DiscLight, PointLight, SphereLight
from aliascope.native.warps import DISC, SPHERE
from aliascope.renderers.povray_limits import unit


@dataclass(frozen=True)
class LightPoints:
    """Points on a light, uniform by area. places, facing (n, 3): in the scene's coordinates, with the unit normals
    there. share: what the light's intensity is multiplied by. flat: all in one plane, all facing the same way."""

    places: Array
    facing: Array
    share: float
    flat: bool

    def only(self, index: int) -> LightPoints:
        """One of the points."""
        chosen = slice(index, index + 1)
        return LightPoints(self.places[chosen], self.facing[chosen], self.share, self.flat)


def points_on(light: AnyLight, u: Array) -> LightPoints | None:
    """The points of a light for places (n, 2) in the unit square; None for a light without an area.

    Those of a sphere are all over it: from each place half of them are hidden at least, behind their own horizon. So
    the mean over its whole surface, 4 pi r^2, of cosines clamped at 0, is the integral over what is seen; its
    intensity is per pi r^2.
    """
    match light:
        case AreaLight(corner=corner, edges=edges):
            normal = unit(np.cross(unit(edges[0]), unit(edges[1])))
            return _flat(np.array(corner) + u @ np.array(edges), normal)
        case DiscLight(centre=centre, normal=direction, radius=radius):
            normal = unit(direction)
            return _flat(np.array(centre) + radius * DISC.sample(u) @ np.array(across(normal)), normal)
        case SphereLight(centre=centre, radius=radius):
            facing = SPHERE.sample(u)
            return LightPoints(np.array(centre) + radius * facing, facing, 4.0, flat=False)
        case PointLight() | DirectionalLight():
            return None


def _flat(places: Array, normal: Array) -> LightPoints:
    return LightPoints(places, np.broadcast_to(normal, places.shape), 1.0, flat=True)
