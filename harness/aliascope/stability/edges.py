"""Edges so near to samples that arithmetic decides on which side they are: by how far an edge is drawn off, at least.

Two faces share an edge; a picture has one sample in the middle of each pixel. A sample that sees the wrong one of them
says that the edge lies beyond it: the largest distance of such a sample is what the edge is off, at least.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from functools import partial

import numpy as np

from aliascope.geometry import Array
from aliascope.model import Scene
from aliascope.renderers.base import Renderer
from aliascope.stability.records import NEVER, Probe
from aliascope.stability.subjects import QUANTUM, SIZE, of_polygons, picture

PIXELS = 8.0
"""In a unit; the eye looks at the corner of four pixels, so that all places of samples are exact."""

BELOW, ABOVE = 0.25, 0.75
"""The emissions of the two faces."""

OFF = 1e-3
"""Pixels that an edge may be off, as outlines of OSMesa's discs and spheres may."""

FLOAT = 2.0**-24 * max(SIZE) / 2
"""Pixels by which rounding the places of this picture to float moves them."""

Edge = tuple[Scene, Array]
"""A scene, and how far each sample lies from its edge, in pixels, (height, width): above 0 on the side of BELOW."""


def _samples() -> tuple[Array, Array]:
    """u and v of the middles of pixels, (height, width)."""
    width, height = SIZE
    right, down = np.arange(width) + 0.5, np.arange(height)[:, np.newaxis] + 0.5
    u, v = np.broadcast_arrays((right - width / 2) / PIXELS, (height / 2 - down) / PIXELS)
    return u, v


def near_axis(slope: float) -> Edge:
    """An edge of that slope through the row of samples below the middle, between the samples 11 and 12 of it."""
    u, v = _samples()
    through = -0.5 / PIXELS
    return _faces(through - 3.0 * slope, through + 3.0 * slope), (through - v + slope * u) * PIXELS


def near_diagonal(more: float) -> Edge:
    """An edge of slope 1 + `more` through the middle, and so among the samples of the diagonal."""
    u, v = _samples()
    slope = 1.0 + more
    return _faces(-3.0 * slope, 3.0 * slope), (u - v + (slope - 1.0) * u) * PIXELS / math.hypot(1.0, slope)


def on_samples(away: float) -> Edge:
    """A vertical edge so many pixels to the right of the middles of column 12."""
    u, _ = _samples()
    at = (0.5 + away) / PIXELS
    left = [(-3.0, -5.0, 0.0), (at, -5.0, 0.0), (at, 5.0, 0.0), (-3.0, 5.0, 0.0)]
    right = [(at, -5.0, 0.0), (3.0, -5.0, 0.0), (3.0, 5.0, 0.0), (at, 5.0, 0.0)]
    return of_polygons([(left, BELOW), (right, ABOVE)]), (0.5 / PIXELS - u) * PIXELS + away


def _faces(left: float, right: float) -> Scene:
    """Below and above the line from (-3, left) to (3, right)."""
    low = [(-3.0, -5.0, 0.0), (3.0, -5.0, 0.0), (3.0, right, 0.0), (-3.0, left, 0.0)]
    high = [(-3.0, left, 0.0), (3.0, right, 0.0), (3.0, 5.0, 0.0), (-3.0, 5.0, 0.0)]
    return of_polygons([(low, BELOW), (high, ABOVE)])


def off(seen: Array, distances: Array) -> float:
    """By how many pixels the edge is off in a picture, at least; infinite where a sample sees neither face."""
    below, above = (np.abs(seen - emission).max(axis=-1) < 2.0 * QUANTUM for emission in (BELOW, ABOVE))
    if not (below | above).all():
        return math.inf
    wrong = np.where(below, distances < 0.0, distances > 0.0)
    return float(np.abs(distances[wrong]).max(initial=0.0))


_LEVELS = tuple(10.0**-k for k in range(1, 13))
_EDGES: Mapping[str, tuple[Callable[[float], Edge], tuple[float, ...], tuple[float, ...]]] = {
    "near-axis": (near_axis, _LEVELS, (1e-2, 1e-6)),
    "near-diagonal": (near_diagonal, _LEVELS, (1e-2, 1e-6)),
    "on-samples": (on_samples, (*_LEVELS, 0.0), (1e-2, 1e-6, 0.0)),
}


def probes_of(
    component: str,
    renderer: Renderer,
    mode: str,
    notes: Mapping[str, str],
    excused: Collection[str] = (),
    quick: bool = True,
) -> list[Probe]:
    """Of a renderer in a mode of one sample, in the middle of each pixel."""
    return [
        Probe(
            component,
            "renderer",
            extreme,
            "pixels that an edge is off",
            "on which side of the edge each sample lies",
            FLOAT,
            OFF,
            levels,
            partial(_measured, renderer, mode, make),
            few if quick else (),
            notes.get(extreme, ""),
            extreme in excused,
            refuses_from=NEVER,
        )
        for extreme, (make, levels, few) in _EDGES.items()
    ]


def _measured(renderer: Renderer, mode: str, make: Callable[[float], Edge], at: float) -> float:
    scene, distances = make(at)
    return off(picture(renderer, mode, scene), distances)
