"""Polygons and their images in a plane mirror: what is seen in it is what would stand behind it, turned inside out.

A ray that the mirror sends back meets what the unbroken ray would meet of the reflected scene. So each polygon before
the mirror comes with its image, which is seen through the mirror's outline as through a window and lies behind
everything on this side; the rest is `polygons`. What a mirror shows has the radiance emission + reflection * (what the
ray meets), the background where that is nothing.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import shapely

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame, plane_axes
from aliascope.model import BLACK, Material, Polygon, Scene
from aliascope.references.canvas import Canvas
from aliascope.references.polygons import colour_of, coverage_error, visible
from aliascope.references.projection import SLIVER_PX, Outline, outlines_of
from aliascope.references.result import Exact, Method, checked
from aliascope.references.visibility import Order, depth_order

TOUCH = 1e-12
"""Of the extent of the scene: what reaches through the mirror by less stands on it."""


def _mirror(scene: Scene) -> int:
    """The number of the only mirror. Raises Unsupported where there are more."""
    numbers = [i for i, each in enumerate(scene.surfaces) if scene.materials[each.material].reflection != BLACK]
    if len(numbers) > 1:
        raise Unsupported("mirrors that see each other: only a single one has an exact method")
    return numbers[0]


def _points(scene: Scene, number: int) -> Array:
    surface = scene.surfaces[number]
    assert isinstance(surface, Polygon)  # the method's features hold this
    return np.array(surface.points)


def _shown(material: Material, seen: tuple[float, ...]) -> Material:
    """What a mirror sends out that shows a radiance."""
    colours = zip(material.emission, material.reflection, seen, strict=True)
    return Material.model_validate({"emission": [own + share * radiance for own, share, radiance in colours]})


def _with_images(scene: Scene, frame: Frame, number: int) -> Scene:
    """The scene without its mirror, the images of all surfaces behind them. Raises Unsupported for a surface that is
    not wholly before the mirror."""
    mirror, material = _points(scene, number), scene.materials[scene.surfaces[number].material]
    normal = plane_axes(mirror)[2]
    toward = frame.eye - mirror[0] if frame.perspective else -frame.forward
    normal = normal if float(normal @ toward) > 0.0 else -normal
    materials = dict(scene.materials)
    real, images = [], []
    for i, surface in enumerate(scene.surfaces):
        if i == number:
            continue
        points = _points(scene, i)
        height = (points - mirror[0]) @ normal
        if float(height.min()) < -TOUCH * float(np.abs(points).max() + np.abs(mirror).max()):
            raise Unsupported(f"surface {i + 1} reaches behind the mirror")
        name = f"image of {surface.material}"
        materials[name] = _shown(material, scene.materials[surface.material].emission)
        reflected = points - 2.0 * height[:, np.newaxis] * normal
        real.append(surface)
        images.append(surface.model_copy(update={"material": name, "points": tuple(map(tuple, reflected.tolist()))}))
    return scene.model_copy(update={"materials": materials, "surfaces": (*real, *images)})


def make(scene: Scene, frame: Frame) -> Exact:
    """The mean radiance over each pixel. Raises Unsupported for more than one mirror, or what is behind it."""
    number = _mirror(scene)
    surface, background = scene.surfaces[number], np.array(scene.view.background)
    window = outlines_of(scene.model_copy(update={"surfaces": (surface,)}), frame)
    images_from = len(scene.surfaces) - 1
    found: list[Outline] = []
    for outline in outlines_of(_with_images(scene, frame, number), frame):
        region = outline.region
        if outline.number >= images_from:
            region = shapely.intersection(region, window[0].region) if window else shapely.Polygon()
        if region.area > SLIVER_PX * region.length:
            # Reflecting a point rounds it about as often as looking at it does.
            moved = 3.0 * outline.displacement_px
            found.append(dataclasses.replace(outline, region=region, displacement_px=moved))
    order = depth_order(found)
    for mirror in window:
        shown = _shown(scene.materials[surface.material], scene.view.background)
        found.append(dataclasses.replace(mirror, material=shown, number=2 * images_from))
        order = Order((*order.in_front, tuple(range(len(found) - 1))), order.displacement_px)
    canvas = Canvas(frame.width, frame.height)
    for outline, part in zip(found, visible(frame, found, order), strict=True):
        colour = colour_of(outline)
        canvas.add(part, colour, float(colour.max()))
    return checked(canvas, background, coverage_error(frame, found, order, canvas))


METHOD = Method(
    name="mirrored-polygons",
    title="areas of the visible parts of polygons and of their images in a mirror",
    features=frozenset({"orthographic", "perspective", "polygon", "mirror"}),
    make=make,
    requires="mirror",
)
