"""Polygons under area lights that nothing stands before: Lambert's formula, in the mean over each pixel.

A polygon of even radiance L, corners at r_1 ... r_n from a point, lights a surface there whose normal is n with

    E = L / 2 * sum over i of (angle between r_i and r_i+1) * n . (r_i x r_i+1) / |r_i x r_i+1|

(Lambert 1760, in Arvo 1994, "The Irradiance Jacobian for Partially Occluded Polyhedral Sources", eq. 1), once what lies
below the surface's horizon is cut off it. A light of the scene has L = pi * intensity / area, and the surface sends on
albedo / pi * E. Over a surface the result is smooth: it is integrated over what each pixel shows of it, cut into
triangles, by products of Gauss-Legendre rules of 5 and 9 nodes; where they disagree the triangle is cut in four.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame, plane_axes
from aliascope.model import AreaLight, Polygon, Scene
from aliascope.references.canvas import Canvas, Coverage
from aliascope.references.polygons import coverage, coverage_error, visible_regions
from aliascope.references.projection import Outline, outlines_of
from aliascope.references.result import EPSILON, Exact, Method, checked
from aliascope.references.visibility import depth_order

Index = NDArray[np.int64]
SHORT, LONG = 5, 9
TOLERANCE = 1e-13
LEVELS = 12
CHUNK = 1 << 12
TOUCH = 1e-12
"""Of the extent of the scene: surfaces that reach over a plane by less lie on it."""


@dataclass(frozen=True)
class Receiver:
    """A polygon's plane: a point and the unit normal (3,), turned to the viewer."""

    point: Array
    normal: Array

    def places(self, frame: Frame, picture: Array) -> Array:
        """The points (..., 3) of the plane that are seen at places (..., 2) on the picture, in pixels."""
        middle = frame.middle
        u = (picture[..., :1] - middle[0]) * frame.pixel * frame.right
        v = (middle[1] - picture[..., 1:]) * frame.pixel * frame.up
        if frame.perspective:
            direction = frame.forward + u + v
            distance = (self.point - frame.eye) @ self.normal / (direction @ self.normal)
            seen: Array = frame.eye + distance[..., np.newaxis] * direction
            return seen
        origin = frame.eye + u + v
        distance = (self.point - origin) @ self.normal / (frame.forward @ self.normal)
        return origin + distance[..., np.newaxis] * frame.forward

    def above(self, corners: Array) -> Array:
        """The part (m, 3) of a convex polygon (n, 3) above the plane; fewer than three corners are nothing."""
        height = (corners - self.point) @ self.normal
        kept: list[Array] = []
        for i, j in zip(range(len(corners)), [*range(1, len(corners)), 0], strict=True):
            if height[i] >= 0.0:
                kept.append(corners[i])
            if (height[i] >= 0.0) != (height[j] >= 0.0):
                share = height[i] / (height[i] - height[j])
                kept.append(corners[i] + share * (corners[j] - corners[i]))
        return np.array(kept).reshape(-1, 3)


def form_factor(places: Array, normal: Array, corners: Array) -> Array:
    """E / (pi L) at places (..., 3) of a surface with this normal, of a polygon (n, 3) wholly above its horizon."""
    total = np.zeros(places.shape[:-1])
    away = [corner - places for corner in corners]
    for one, other in zip(away, [*away[1:], away[0]], strict=True):
        across = np.cross(one, other)
        sine = np.linalg.norm(across, axis=-1)
        angle = np.arctan2(sine, (one * other).sum(-1))
        total += angle * (across @ normal) / np.where(sine > 0.0, sine, 1.0)
    factor: Array = np.abs(total) / (2.0 * np.pi)
    return factor


def corners_of(light: AreaLight) -> Array:
    corner, first, second = np.array(light.corner), *(np.array(edge) for edge in light.edges)
    return np.array([corner, corner + first, corner + first + second, corner + second])


def across_of(light: AreaLight) -> Array:
    """A normal (3,) on the side to which a light shines; its length is the light's area."""
    first, second = (np.array(edge) for edge in light.edges)
    normal: Array = np.cross(first, second)
    return normal


def _rule(n: int) -> tuple[Array, Array]:
    """Places (n^2, 2) in the triangle (0, 0), (1, 0), (0, 1) and weights, of which the sum is 1: Gauss-Legendre on the
    unit square, one side of it drawn together to a point."""
    x, w = np.polynomial.legendre.leggauss(n)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    one, other = (each.ravel() for each in np.meshgrid(x, x, indexing="ij"))
    weights = np.outer(w, w).ravel() * 2.0 * (1.0 - one)
    return np.column_stack([one, other * (1.0 - one)]), weights


def _integrals(
    receiver: Receiver, corners: Array, frame: Frame, triangles: Array, owner: Index, count: int
) -> tuple[Array, float]:
    """The integral of the form factor over the triangles (n, 3, 2), px, summed by owner: (count,), and a bound of its
    error in any of them. Raises Unsupported where it does not settle."""
    (few, few_weights), (many, many_weights) = _rule(SHORT), _rule(LONG)
    places, total, error = np.concatenate([few, many]), np.zeros(count), np.zeros(count)
    for _ in range(LEVELS):
        if not len(triangles):
            return total, float(error.max(initial=0.0))
        value, difference = np.empty(len(triangles)), np.empty(len(triangles))
        for start in range(0, len(triangles), CHUNK):
            part = triangles[start : start + CHUNK]
            first, side, other = part[:, 0], part[:, 1] - part[:, 0], part[:, 2] - part[:, 0]
            area = 0.5 * np.abs(side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0])
            at = first[:, np.newaxis] + places[:, :1] * side[:, np.newaxis] + places[:, 1:] * other[:, np.newaxis]
            found = form_factor(receiver.places(frame, at), receiver.normal, corners)
            value[start : start + CHUNK] = area * (found[:, len(few) :] @ many_weights)
            difference[start : start + CHUNK] = np.abs(
                area * (found[:, : len(few)] @ few_weights) - value[start : start + CHUNK]
            )
        settled = difference <= TOLERANCE
        np.add.at(total, owner[settled], value[settled])
        np.add.at(error, owner[settled], difference[settled])
        a, b, c = np.moveaxis(triangles[~settled], 1, 0)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        triangles = np.concatenate(
            [np.stack(each, axis=1) for each in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
        owner = np.tile(owner[~settled], 4)
    raise Unsupported("a light comes so near to a surface that its mean over a pixel does not settle")


def _triangles(region: shapely.Geometry, part: Coverage, frame: Frame) -> tuple[Array, Index]:
    """What each pixel shows of a region as triangles (n, 3, 2), and the number of the pixel of each (n,)."""
    whole = np.argwhere(part.area == 1.0)
    corner = whole[:, ::-1].astype(np.float64)
    squares = corner[:, np.newaxis] + np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    found = [squares[:, [0, 1, 2]], squares[:, [0, 2, 3]]]
    owners = [whole[:, 0] * frame.width + whole[:, 1]] * 2
    rows, columns = np.nonzero((part.area > 0.0) & (part.area < 1.0))
    pieces = shapely.intersection(region, shapely.box(columns, rows, columns + 1, rows + 1))
    cut = shapely.constrained_delaunay_triangles(pieces)
    parts, piece = shapely.get_parts(cut, return_index=True)
    if len(parts):
        found.append(shapely.get_coordinates(parts).reshape(len(parts), 4, 2)[:, :3])
        owners.append((rows * frame.width + columns)[piece])
    return np.concatenate(found), np.concatenate(owners)


def _refuse_blocked(scene: Scene, number: int, receiver: Receiver, light: AreaLight, label: str) -> None:
    """Raises Unsupported unless every other surface is seen to be clear of all ways from a surface to a light."""
    corners = corners_of(light)
    ways = np.concatenate([np.array(_polygon(scene, number).points), corners])
    slack = TOUCH * float(np.abs(ways).max())
    shining = across_of(light)
    for other in range(len(scene.surfaces)):
        if other == number:
            continue
        points = np.array(_polygon(scene, other).points)
        across = (ways - points[0]) @ plane_axes(points)[2]
        clear = (
            bool(((points - receiver.point) @ receiver.normal <= slack).all())
            or bool(((points - corners[0]) @ shining <= slack * float(np.linalg.norm(shining))).all())
            or bool((across <= slack).all() or (across >= -slack).all())
            or bool((points.max(axis=0) < ways.min(axis=0)).any() or (points.min(axis=0) > ways.max(axis=0)).any())
        )
        if not clear:
            raise Unsupported(
                f"surface {other + 1} may stand between {label} and a light: shadows have no exact method"
            )


def _polygon(scene: Scene, number: int) -> Polygon:
    surface = scene.surfaces[number]
    assert isinstance(surface, Polygon)  # the method's features hold this
    return surface


def _received(scene: Scene, outline: Outline, receiver: Receiver, light: AreaLight) -> tuple[Array, float] | None:
    """The corners (n, 3) of what a surface sees of a light, and a distance that they keep; or None for no light."""
    points, corners = np.array(_polygon(scene, outline.number).points), corners_of(light)
    shining = across_of(light)
    before = (points - corners[0]) @ (shining / np.linalg.norm(shining))
    slack = TOUCH * float(np.abs(np.concatenate([points, corners])).max())
    seen = receiver.above(corners)
    if len(seen) < 3 or float(before.max()) <= slack or not any(outline.material.albedo):
        return None
    if float(before.min()) < -slack:
        raise Unsupported(f"{outline.label} lies on both sides of a light's plane, which shines to one")
    _refuse_blocked(scene, outline.number, receiver, light, outline.label)
    gaps = [points.min(axis=0) - corners.max(axis=0), corners.min(axis=0) - points.max(axis=0)]
    height = float(((seen - receiver.point) @ receiver.normal).min())
    return seen, max(float(before.min()), height, *np.concatenate(gaps).tolist(), 0.0)


def _shaded(
    scene: Scene, outline: Outline, region: shapely.Geometry, part: Coverage, lights: Sequence[AreaLight], frame: Frame
) -> tuple[Array, float]:
    """The mean radiance (height, width, 3) of what each pixel shows of a surface, and a bound of its error."""
    points = np.array(_polygon(scene, outline.number).points)
    normal = plane_axes(points)[2]
    toward = frame.eye - points[0] if frame.perspective else -frame.forward
    receiver = Receiver(points[0], normal if float(normal @ toward) > 0.0 else -normal)
    radiance = np.broadcast_to(np.array(outline.material.emission), (*part.area.shape, 3)).copy()
    triangles, owner = _triangles(region, part, frame)
    error = 0.0
    for light in lights:
        received = _received(scene, outline, receiver, light)
        if received is None:
            continue
        corners, distance = received
        sums, missed = _integrals(receiver, corners, frame, triangles, owner, part.area.size)
        mean = sums.reshape(part.area.shape) / np.where(part.area > 0.0, part.area, 1.0)
        area = float(np.linalg.norm(across_of(light)))
        gain = np.pi * np.array(light.intensity) / area * np.array(outline.material.albedo)
        radiance += mean[:, :, np.newaxis] * gain
        # Angles and products of unit vectors: a few roundings at each of six edges at most; and the factor changes by
        # less than 4 over the distance to the light, while rounding moves places along their surface.
        moved = _moved(receiver, frame, points)
        error += float(gain.max()) * (missed + 64 * EPSILON + 4.0 * moved / max(distance, moved))
    return radiance, error


def _moved(receiver: Receiver, frame: Frame, points: Array) -> float:
    """How far rounding may have moved a place on a surface with these corners (n, 3)."""
    reach = float(np.linalg.norm(points - frame.eye, axis=1).max())
    toward = (receiver.point - frame.eye) / reach if frame.perspective else frame.forward
    return 16 * EPSILON * reach / abs(float(toward @ receiver.normal))


def make(scene: Scene, frame: Frame) -> Exact:
    """The mean radiance over each pixel. Raises Unsupported where a light may be hidden or is no Lambert emitter."""
    lights = [light for light in scene.lights if isinstance(light, AreaLight)]
    if any(light.falloff == "none" for light in lights):
        raise Unsupported('Lambert\'s formula is for lights with falloff = "inverse-square"')
    outlines = outlines_of(scene, frame)
    order = depth_order(outlines)
    canvas = Canvas(frame.width, frame.height)
    error = 0.0
    for outline, region in zip(outlines, visible_regions(outlines, order), strict=True):
        part = coverage(region, frame.width, frame.height)
        radiance, missed = _shaded(scene, outline, region, part, lights, frame)
        shown = radiance[part.area > 0.0]
        canvas.add(part, radiance, float(shown.max(initial=0.0)))
        error += missed
    brightest = max(canvas.brightest, float(np.max(scene.view.background))) or 1.0
    error = error / brightest + coverage_error(frame, outlines, order, canvas)
    return checked(canvas, np.array(scene.view.background), error)


METHOD = Method(
    name="irradiance",
    title="Lambert's formula for polygons under area lights",
    features=frozenset({"orthographic", "perspective", "polygon", "area light"}),
    make=make,
    requires="area light",
)
