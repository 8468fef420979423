"""The lights of a scene for POV-Ray, and how bright they can make its picture.

POV-Ray's diffuse shading is pigment * diffuse * light colour * n.l, n turned toward the viewer, and a light on the
other side of the surface adds nothing unless the object says `double_illuminate`: the project's equation as it stands.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from aliascope.geometry import Array, Surfaces, surfaces_of
from aliascope.model import BLACK, Colour, Material, PointLight, Scene
from aliascope.renderers.povray_frames import moments
from aliascope.renderers.povray_limits import unit

FADE_SHARE = 1e-3
"""fade_distance f of a light, in its distance to the nearest surface: POV-Ray's fall-off is 2 / (1 + (d/f)^2), which is
2 f^2 / d^2 to within FADE_SHARE^2, a fifteenth of a step of 16 bits."""


@dataclass(frozen=True)
class Lighting:
    """What the text of a lit scene needs to know of all of it.

    `peak`: the largest channel that the picture can have, linear; infinite where a light lies on a surface that it
    lights. `fade_distances`: of each light, in the scene's units; they matter to those that fall off alone.
    """

    peak: float
    fade_distances: tuple[float, ...]


def lighting_of(scene: Scene, times: Array | None = None) -> Lighting:
    """Bounds that need no picture: every light shines squarely on the nearest point of every surface, at the times at
    which the scene is looked at."""
    if not any(light.falloff == "inverse-square" for light in scene.lights):
        times = None  # no distance matters
    found = [_lighting_at(moment) for moment in moments(scene, times)]
    fades = zip(*(each.fade_distances for each in found), strict=True)
    return Lighting(max(each.peak for each in found), tuple(min(each) for each in fades))


def _lighting_at(scene: Scene) -> Lighting:
    names = tuple(dict.fromkeys(surface.material for surface in scene.surfaces))
    lit = np.array([scene.materials[name].albedo != BLACK for name in names], dtype=bool)
    received = np.zeros((len(names), 3))
    fades = []
    for light in scene.lights:
        distances = np.ones(len(names))
        if isinstance(light, PointLight) and light.falloff == "inverse-square":
            distances = _distances(surfaces_of(scene), np.array(light.position))
        nearest = float(distances[lit].min(initial=math.inf))
        fades.append(FADE_SHARE * nearest if 0.0 < nearest < math.inf else FADE_SHARE)
        with np.errstate(divide="ignore"):
            shares = np.where(lit, distances, 1.0)[:, np.newaxis] ** -2.0
        intensity = np.array(light.intensity)
        # 0 * inf is no light: of a light that lies on a surface, in a channel that it lacks.
        received += np.multiply(intensity, shares, where=intensity > 0.0, out=np.zeros_like(received))
    radiance = np.zeros((len(names), 3))
    for row, name, light_there in zip(radiance, names, received, strict=True):
        material = scene.materials[name]
        for channel in range(3):
            albedo, colour = material.albedo[channel], max(c[channel] for c in pattern_colours(material))
            if colour > 0.0:
                reflected = albedo * float(light_there[channel]) if albedo > 0.0 else 0.0
                row[channel] = colour * (material.emission[channel] + reflected)
    peak = _brightest(scene, names, radiance)
    return Lighting(peak, tuple(fades))


def _brightest(scene: Scene, names: tuple[str, ...], radiance: Array) -> float:
    """The largest channel of the background and of what surfaces of these materials send out, (n, 3), seen directly or
    over as many mirrors as the scene allows."""
    background = np.array(scene.view.background)
    direct = np.vstack([radiance, background])
    if not scene.needs().mirror:
        return float(direct.max())
    shares = np.vstack([[scene.materials[name].reflection for name in names], np.zeros(3)])
    brightest = direct.max(axis=0)
    for _ in range(scene.transport.mirror_bounces):
        # 0 * inf is no light here, too: of a material that does not mirror.
        mirrored = np.multiply(shares, brightest, where=shares > 0.0, out=np.zeros_like(shares))
        brightest = (direct + mirrored).max(axis=0)
    return float(brightest.max())


def pattern_colours(material: Material) -> tuple[Colour, ...]:
    """The colours that a material's emission and albedo are multiplied by: white where it has no pattern."""
    return material.pattern.colours if material.pattern else ((1.0, 1.0, 1.0),)


def _distances(surfaces: Surfaces, place: Array) -> Array:
    """The distance from a place to the nearest surface of each material, infinite where it has none."""
    nearest = np.full(len(surfaces.materials), math.inf)
    if len(surfaces.triangles):
        np.minimum.at(nearest, surfaces.triangle_material, distances_to_triangles(surfaces.triangles, place))
    for centre, normal, radius, number in surfaces.discs:
        away = place - np.array(centre)
        height = float(unit(normal) @ away)
        across = max(0.0, math.sqrt(max(0.0, float(away @ away) - height * height)) - radius)
        nearest[number] = min(nearest[number], math.hypot(height, across))
    for centre, radius, number in surfaces.spheres:
        nearest[number] = min(nearest[number], abs(float(np.linalg.norm(place - np.array(centre))) - radius))
    for point, normal, number in surfaces.planes:
        nearest[number] = min(nearest[number], abs(float(unit(normal) @ (place - np.array(point)))))
    return nearest


def distances_to_triangles(triangles: Array, place: Array) -> Array:
    """The distance from a place to each of the triangles (n, 3, 3): to its plane where the foot lies within, else to
    the nearest of its sides."""
    edges = np.roll(triangles, -1, axis=1) - triangles
    away = place - triangles
    normal = np.cross(edges[:, 0], edges[:, 1])
    along = np.clip((away * edges).sum(-1) / (edges * edges).sum(-1), 0.0, 1.0)
    to_sides = np.linalg.norm(away - along[..., np.newaxis] * edges, axis=-1).min(axis=1)
    within = ((np.cross(edges, away) * normal[:, np.newaxis]).sum(-1) >= 0.0).all(axis=1)
    to_plane = np.abs((away[:, 0] * normal).sum(-1)) / np.linalg.norm(normal, axis=-1)
    nearest: Array = np.where(within, to_plane, to_sides)
    return nearest
