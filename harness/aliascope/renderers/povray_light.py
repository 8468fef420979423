"""The lights of a scene for POV-Ray, and how bright they can make its picture.

POV-Ray's diffuse shading is pigment * diffuse * light colour * n.l, n turned toward the viewer, and a light on the
other side of the surface adds nothing unless the object says `double_illuminate`: the project's equation as it stands.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from aliascope.geometry import Array, Surfaces, surfaces_of
from aliascope.model import BLACK, AnyLight, Colour, Material, PointLight, Scene, Vector
from aliascope.renderers.povray_area_lights import LightPoints
from aliascope.renderers.povray_frames import Frames, moments
from aliascope.renderers.povray_limits import unit

FADE_SHARE = 1e-3
"""fade_distance f of a light, in its distance to the nearest surface: POV-Ray's fall-off is 2 / (1 + (d/f)^2), which is
2 f^2 / d^2 to within FADE_SHARE^2, a fifteenth of a step of 16 bits."""


IN_PLANE = 1e-9
"""Of its own extent, how far a surface may rise out of the plane of a light and still lie in it: by rounding."""


@dataclass(frozen=True)
class Lighting:
    """What the text of a lit scene needs to know of all of it.

    `peak`: the largest channel that the picture can have, linear; infinite where a light lies on a surface that it
    lights. `brightest`: the material that sends out the most, "" for the background. `fade_distances`: of each light,
    in the scene's units; they matter to those that fall off alone.
    """

    peak: float
    brightest: str
    fade_distances: tuple[float, ...]


def lighting_of(scene: Scene, frames: Frames | None = None) -> Lighting:
    """Bounds that need no picture: every light shines squarely on the nearest point of every surface, in the frames in
    which the scene is looked at; one for each of its lights with an area, from where it is in the frame."""
    times, lights = (frames.times, frames.lights) if frames else (None, ())
    if not any(light.falloff == "inverse-square" for light in scene.lights):
        times = None  # no distance matters
    found = []
    for number, moment in enumerate(moments(scene, times)):
        here = lights if times is None else tuple(points and points.only(number) for points in lights)
        found.append(_lighting_at(moment, here or (None,) * len(scene.lights)))
    fades = zip(*(each.fade_distances for each in found), strict=True)
    most = max(found, key=lambda each: each.peak)
    return Lighting(most.peak, most.brightest, tuple(min(each) for each in fades))


def _lighting_at(scene: Scene, lights: tuple[LightPoints | None, ...]) -> Lighting:
    names = tuple(dict.fromkeys(surface.material for surface in scene.surfaces))
    lit = np.array([scene.materials[name].albedo != BLACK for name in names], dtype=bool)
    received = np.zeros((len(names), 3))
    fades = []
    for light, points in zip(scene.lights, lights, strict=True):
        distances = np.ones(len(names))
        if light.falloff == "inverse-square":
            distances = _light_distances(surfaces_of(scene), light, points)
        nearest = float(distances[lit].min(initial=math.inf))
        fades.append(FADE_SHARE * nearest if 0.0 < nearest < math.inf else FADE_SHARE)
        with np.errstate(divide="ignore"):
            shares = np.where(lit, distances, 1.0)[:, np.newaxis] ** -2.0
        intensity = np.array(light.intensity) * (points.share if points else 1.0)
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
    sources = ("", *names)
    sent = np.vstack([scene.view.background, radiance]).max(axis=1)
    return Lighting(_brightest(scene, names, radiance), sources[int(sent.argmax())], tuple(fades))


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


def _light_distances(surfaces: Surfaces, light: AnyLight, points: LightPoints | None) -> Array:
    """The distance from a light, or from the nearest of its points, to the nearest surface of each material that it
    shines on, infinite where there is none; 1 where POV-Ray's own area light stands in its place."""
    if isinstance(light, PointLight):
        return _distances(surfaces, np.array(light.position))
    if points is None:
        return np.ones(len(surfaces.materials))
    if points.flat:
        surfaces = _in_front(surfaces, points.places[0], points.facing[0])
    surfaces = _around(surfaces, points.places)
    nearest: Array = np.min([_distances(surfaces, place) for place in points.places], axis=0)
    return nearest


def _in_front(surfaces: Surfaces, place: Array, facing: Array) -> Surfaces:
    """Those of the surfaces that are not wholly behind a plane, or in it."""

    def height(point: Array | Vector) -> Array:
        along: Array = (np.asarray(point) - place) @ facing
        return along

    def tilt(normal: Vector) -> float:
        """The sine of the angle to the plane."""
        return float(np.linalg.norm(np.cross(unit(normal), facing)))

    heights = height(surfaces.triangles).max(axis=-1)
    extents = np.abs(surfaces.triangles - place).max(axis=(1, 2), initial=0.0)
    there = heights > IN_PLANE * extents
    return replace(
        surfaces,
        triangles=surfaces.triangles[there],
        triangle_material=surfaces.triangle_material[there],
        discs=tuple(each for each in surfaces.discs if height(each[0]) + each[2] * tilt(each[1]) > IN_PLANE * each[2]),
        spheres=tuple(each for each in surfaces.spheres if height(each[0]) + each[1] > 0.0),
        planes=tuple(each for each in surfaces.planes if tilt(each[1]) > IN_PLANE or height(each[0]) > 0.0),
    )


def _around(surfaces: Surfaces, places: Array) -> Surfaces:
    """Without the triangles that are nearest to none of the places: those farther from the middle of the places than
    the nearest of their material, by more than the places are across."""
    middle = places.mean(axis=0)
    reach = float(np.linalg.norm(places - middle, axis=1).max())
    if len(places) == 1 or not len(surfaces.triangles):
        return surfaces
    away = distances_to_triangles(surfaces.triangles, middle)
    nearest = np.full(len(surfaces.materials), math.inf)
    np.minimum.at(nearest, surfaces.triangle_material, away)
    there = away <= nearest[surfaces.triangle_material] + 2.0 * reach * (1.0 + 1e-9)
    return replace(surfaces, triangles=surfaces.triangles[there], triangle_material=surfaces.triangle_material[there])


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
