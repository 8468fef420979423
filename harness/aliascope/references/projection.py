"""Surfaces as they lie on the picture: outlines in pixels, and how near each is at each place.

A planar polygon stays a polygon under an orthographic and under a perspective camera, and a quantity that grows toward
the viewer is affine over the picture: -depth under the orthographic camera, 1/depth under the perspective one
(Blinn 1992, "Hyperbolic interpolation"). So the nearer of two planes over a region is told by the region's corners.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame, plane_axes
from aliascope.model import Disc, Material, Polygon, Scene
from aliascope.references.result import EPSILON

SLIVER_PX = 1e-11
"""What is thinner than this has no area: a polygon seen from its edge, the overlap of two neighbours."""
CIRCLE_CORNERS = 64
LARGEST_RADIUS_PX = 1e8
"""The closed form of circles squares whole pixels in 64-bit integers."""


@dataclass(frozen=True)
class Nearness:
    """-depth or 1/depth over the picture: `value` at `origin` (px), and its `gradient` per pixel.

    `rounding` and `rounding_per_px` bound its error at the origin and per pixel of distance from it.
    """

    origin: Array
    value: float
    gradient: Array
    rounding: float
    rounding_per_px: float

    def at(self, places: Array) -> tuple[Array, Array]:
        """The nearness at places (n, 2), in pixels, and the bound of its rounding, both (n,)."""
        offset = places - self.origin
        distance = np.hypot(offset[:, 0], offset[:, 1])
        return self.value + offset @ self.gradient, self.rounding + self.rounding_per_px * distance


@dataclass(frozen=True)
class Circle:
    """A disc that faces the viewer, in pixels."""

    x: float
    y: float
    radius: float


@dataclass(frozen=True)
class Outline:
    """A surface on the picture.

    `region` in pixels, x to the right, y down, cut to the part of the plane that matters; of a disc a polygon around
    its `circle`. `displacement_px` bounds how far rounding moved its outline. `number` counts the scene's surfaces.
    """

    number: int
    label: str
    material: Material
    region: shapely.Geometry
    nearness: Nearness
    displacement_px: float
    circle: Circle | None = None


def to_picture(frame: Frame, points: Array) -> tuple[Array, Array, float]:
    """Points (n, 3) as places (n, 2) in pixels, their depths (n,), and a bound of the rounding of the places (px).

    The points lie in front of the eye.
    """
    relative = points - frame.eye
    reach = float(np.linalg.norm(relative, axis=1).max())
    u, v, depth = relative @ frame.right, relative @ frame.up, relative @ frame.forward
    # A dot product of three terms, axes that are normalised to 2 eps, and the scaling: under 8 eps of the reach.
    rounding = 8 * EPSILON * reach
    if frame.perspective:
        u, v = u / depth, v / depth
        rounding *= (1.0 + float(np.hypot(u, v).max())) / float(depth.min())
    middle = frame.middle
    places = np.column_stack([middle[0] + u / frame.pixel, middle[1] - v / frame.pixel])
    return places, depth, rounding / frame.pixel + 8 * EPSILON * max(frame.spans)


def outlines_of(scene: Scene, frame: Frame, margin_px: float = 0.0) -> list[Outline]:
    """The polygons and discs that reach into the picture, or within so many pixels of it, in the order of the scene.

    Raises Unsupported for a surface that has no exact outline.
    """
    circles: dict[int, tuple[Circle, Nearness, float]] = {}
    for i, surface in enumerate(scene.surfaces):
        if isinstance(surface, Disc) and _in_front(frame, np.array([surface.centre]), _label(scene, i)):
            circles[i] = _circle(frame, surface, _label(scene, i))
    picture = shapely.box(-margin_px, -margin_px, frame.width + margin_px, frame.height + margin_px)
    seen = {i: c for i, c in circles.items() if shapely.distance(picture, shapely.Point(c[0].x, c[0].y)) < c[0].radius}
    # Discs that the border of the picture cuts are compared whole with what is before and behind them.
    area = _around(picture, [circle for circle, _, _ in seen.values()])
    found: list[Outline] = []
    for i, surface in enumerate(scene.surfaces):
        if i in seen:
            circle, nearness, displacement = seen[i]
            label, material = _label(scene, i), scene.materials[surface.material]
            found.append(Outline(i, label, material, _polygon_around(circle), nearness, displacement, circle))
        elif isinstance(surface, Polygon):
            outline = _polygon(frame, surface, i, scene, area)
            if outline is not None:
                found.append(outline)
    return found


def _label(scene: Scene, index: int) -> str:
    surface = scene.surfaces[index]
    return f'surface {index + 1} ({surface.type} of "{surface.material}")'


def _in_front(frame: Frame, points: Array, label: str) -> bool:
    depth = (points - frame.eye) @ frame.forward
    if float(depth.max()) <= 0.0:
        return False
    if float(depth.min()) <= 0.0:
        raise Unsupported(f"{label} reaches behind the eye")
    return True


def _polygon(frame: Frame, surface: Polygon, number: int, scene: Scene, area: shapely.Geometry) -> Outline | None:
    label, material = _label(scene, number), scene.materials[surface.material]
    points = np.array(surface.points)
    if not _in_front(frame, points, label):
        return None
    try:
        nearness = _nearness(frame, points)
    except ValueError as error:
        raise Unsupported(f"{label}: {error}") from error
    places, _, displacement = to_picture(frame, points)
    region = shapely.Polygon(places)
    if nearness is None or region.area <= SLIVER_PX * region.length:
        return None  # seen from its edge
    if not region.is_valid:
        raise Unsupported(f"{label} crosses or touches itself: {shapely.is_valid_reason(region)}")
    region = shapely.intersection(region, area)
    if region.area <= SLIVER_PX * region.length:
        return None
    return Outline(number, label, material, region, nearness, displacement)


def _nearness(frame: Frame, points: Array) -> Nearness | None:
    """The nearness of the plane through the points; None for a plane that is seen from its edge."""
    _, _, normal = plane_axes(points)
    relative = points - points[0]
    extent = float(np.abs(relative).max())
    deviation = float(np.abs(relative @ normal).max())
    if deviation > 1e-9 * extent:  # the same bound as geometry.triangulate has
        raise ValueError("its points do not lie in one plane")
    following = np.roll(relative, -1, axis=0)
    twice_area = float(np.linalg.norm(np.cross(relative, following).sum(axis=0)))
    perimeter = float(np.linalg.norm(following - relative, axis=1).sum())
    normal_error = 4 * EPSILON * perimeter**2 / twice_area  # Newell's sum: its terms are at most perimeter^2
    places, depth, displacement = to_picture(frame, points[:1])
    first = float(depth[0])
    across = np.array([normal @ frame.right, -(normal @ frame.up)]) * frame.pixel
    reach = float(np.linalg.norm(points - frame.eye, axis=1).max())
    if frame.perspective:
        # n . (p - eye) = n . (p0 - eye) on the plane, p - eye = depth (forward + u right + v up): 1/depth is affine.
        facing, span = float(normal @ (points[0] - frame.eye)), reach
        value, unit = 1.0 / first, 1.0 / first**2
    else:
        facing, span = float(normal @ frame.forward), 1.0
        value, unit = -first, 1.0
    if abs(facing) <= 4 * normal_error * span:
        return None
    gradient = across / facing
    slope = float(np.linalg.norm(gradient))
    rounding = 8 * EPSILON * reach * unit + deviation * abs(value if frame.perspective else 1.0) / abs(facing)
    per_px = normal_error * (frame.pixel + slope * span) / abs(facing) + 4 * EPSILON * slope
    return Nearness(places[0], value, gradient, rounding + slope * displacement, per_px)


def _circle(frame: Frame, surface: Disc, label: str) -> tuple[Circle, Nearness, float]:
    normal = np.array(surface.normal)
    normal = normal / np.linalg.norm(normal)
    # A tilt this small narrows the disc by its square, 1e-24: nothing.
    if float(np.linalg.norm(np.cross(normal, frame.forward))) > 1e-12:
        raise Unsupported(f"{label} does not face the viewer: the area of an ellipse in a pixel has no exact method")
    places, depths, displacement = to_picture(frame, np.array([surface.centre]))
    depth = float(depths[0])
    radius = surface.radius / frame.pixel / (depth if frame.perspective else 1.0)
    if radius > LARGEST_RADIUS_PX or float(np.abs(places).max()) > LARGEST_RADIUS_PX:
        raise Unsupported(f"{label} is larger, or farther away, than {LARGEST_RADIUS_PX:.0e} pixels")
    reach = float(np.linalg.norm(np.array(surface.centre) - frame.eye))
    rounding = 8 * EPSILON * reach / (depth**2 if frame.perspective else 1.0)
    nearness = Nearness(places[0], 1.0 / depth if frame.perspective else -depth, np.zeros(2), rounding, 0.0)
    x, y = (float(c) for c in places[0])
    return Circle(x, y, radius), nearness, displacement + 8 * EPSILON * radius * (reach / depth)


def _polygon_around(circle: Circle) -> shapely.Geometry:
    radius = circle.radius / math.cos(math.pi / CIRCLE_CORNERS)
    angle = 2 * math.pi * np.arange(CIRCLE_CORNERS) / CIRCLE_CORNERS
    return shapely.Polygon(np.column_stack([circle.x + radius * np.cos(angle), circle.y + radius * np.sin(angle)]))


def _around(picture: shapely.Geometry, circles: Sequence[Circle]) -> shapely.Geometry:
    bounds = np.array([picture.bounds] + [_polygon_around(circle).bounds for circle in circles])
    return shapely.box(*bounds[:, :2].min(axis=0), *bounds[:, 2:].max(axis=0))
