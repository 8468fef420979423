"""Surfaces whose outlines are blurred, by motion or by a lens, put together where that is exact.

A blurred surface covers a place for a share of the moments or of the lens's points: of all of them within its core, of
none beyond its reach. Two such shares multiply only where they are independent, which those of two surfaces under one
shutter or lens are not. So of two surfaces one lies beyond the other's reach or within the other's core, where every
moment and point sees the same behind it; then the picture is a sum of shares. All else is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame
from aliascope.model import Disc, Polygon, Scene
from aliascope.references.canvas import Canvas, Coverage
from aliascope.references.polygons import colour_of
from aliascope.references.projection import Outline
from aliascope.references.result import EPSILON

SLACK_PX = 1e-6
"""Reaches are larger by this and cores smaller, so that no rounding decides."""


@dataclass(frozen=True)
class Part:
    """What is seen of one surface of a layer, were there no other layer. core: where it covers at every moment."""

    outline: Outline
    coverage: Coverage
    core: shapely.Geometry


@dataclass(frozen=True)
class Layer:
    """Surfaces that are blurred alike. reach: beyond it none of them covers anything."""

    parts: tuple[Part, ...]
    reach: shapely.Geometry

    @property
    def label(self) -> str:
        return self.parts[0].outline.label

    def is_before(self, other: Outline) -> bool:
        """Whether all of it is nearer than a surface, or all farther. Raises Unsupported for neither."""
        nearness = [part.outline.nearness.value for part in self.parts]
        if min(nearness) > other.nearness.value:
            return True
        if max(nearness) < other.nearness.value:
            return False
        raise Unsupported(f"{self.label} and {other.label} lie at the same depth, or on both sides of each other")


def parallel(scene: Scene, frame: Frame, outline: Outline) -> float:
    """The depth of a surface. Raises Unsupported where it does not face the viewer."""
    surface = scene.surfaces[outline.number]
    assert isinstance(surface, Polygon | Disc)  # the methods' features hold this
    points = np.array(surface.points if isinstance(surface, Polygon) else (surface.centre,))
    relative = points - frame.eye
    depths = relative @ frame.forward
    if float(np.ptp(depths)) > 16 * EPSILON * float(np.linalg.norm(relative, axis=1).max()):
        raise Unsupported(f"{outline.label} is not parallel to the picture: its blur is not the same everywhere")
    return float(depths.mean())


def composed(layers: Sequence[Layer], frame: Frame) -> Canvas:
    """The layers on a canvas. Raises Unsupported where two of them blur over each other's borders."""
    picture = shapely.box(0.0, 0.0, frame.width, frame.height)
    reaches = [shapely.intersection(layer.reach, picture) for layer in layers]
    areas = {id(part): part.coverage.area.copy() for layer in layers for part in layer.parts}
    shown: list[Part] = []
    for layer, reach in zip(layers, reaches, strict=True):
        below, hidden = _below(layer, reach, [(b, r) for b, r in zip(layers, reaches, strict=True) if b is not layer])
        if hidden:
            continue
        shown += layer.parts
        if below is not None:
            for part in layer.parts:
                areas[id(below)] -= part.coverage.area
    canvas = Canvas(frame.width, frame.height)
    for part in shown:
        colour = colour_of(part.outline)
        canvas.add(Coverage(areas[id(part)], part.coverage.length), colour, float(colour.max()))
    return canvas


def _below(
    layer: Layer, reach: shapely.Geometry, others: Sequence[tuple[Layer, shapely.Geometry]]
) -> tuple[Part | None, bool]:
    """The nearest surface behind a layer, None for the background; and whether one in front hides it."""
    below: Part | None = None
    for other, other_reach in others:
        if not shapely.intersects(reach, other_reach):
            continue
        around = [part for part in other.parts if shapely.contains(part.core, reach)]
        if not around:
            if not any(shapely.contains(part.core, other_reach) for part in layer.parts):
                raise Unsupported(f"{layer.label} and {other.label} blur over each other's borders")
            continue
        part = around[0]
        if not layer.is_before(part.outline):
            return None, True
        if below is None or part.outline.nearness.value > below.outline.nearness.value:
            below = part
    return below, False


def touched(shape: shapely.Geometry, distance_px: float, frame: Frame) -> tuple[Array, Array]:
    """The columns and rows of the pixels that come within so many pixels of a shape, (n,) whole numbers."""
    rows, columns = np.indices((frame.height, frame.width)).reshape(2, -1)
    bounds = shapely.bounds(shape)
    low, high = bounds[:2] - distance_px - 1.0, bounds[2:] + distance_px + 1.0
    near = (columns > low[0] - 1) & (columns < high[0]) & (rows > low[1] - 1) & (rows < high[1])
    rows, columns = rows[near], columns[near]
    close = shapely.dwithin(shapely.box(columns, rows, columns + 1, rows + 1), shape, distance_px + SLACK_PX)
    return columns[close].astype(np.float64), rows[close].astype(np.float64)


def filled(region: shapely.Geometry, frame: Frame) -> Array:
    """1 where a region holds a pixel's centre, 0 elsewhere, (height, width): for pixels that its border is far from."""
    rows, columns = np.indices((frame.height, frame.width))
    inside: Array = shapely.contains_xy(region, columns + 0.5, rows + 0.5).astype(np.float64)
    return inside
