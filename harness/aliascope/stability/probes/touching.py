"""Faces in one place, faces that touch, and closed meshes from within: no sample goes between them."""

from __future__ import annotations

import functools
import math

import numpy as np

from aliascope.geometry import Array
from aliascope.model import Material, Scene, View
from aliascope.renderers import embree, mode_of, osmesa, povray
from aliascope.renderers.base import Renderer, Request
from aliascope.stability import geometry_scenes as scenes
from aliascope.stability.records import Probe
from aliascope.stability.subjects import BOUND, QUANTUM, SIZE, of_polygons, picture, rms

FACES = (2.0, 3.0, 11.0, 101.0, 1001.0)

BELOW, ABOVE = 0.25, 0.75
"""The emissions of a leaning face, and of what lies in it or touches it. What shines through is black."""

SIDE = 256
"""Of the pictures from within a mesh, in pixels."""


def probes() -> list[Probe]:
    rays = tuple(10.0**k for k in range(4, 9))
    return [
        *(_touching(each) for each in (embree.RENDERER, osmesa.RENDERER, povray.RENDERER)),
        _watertight(osmesa.RENDERER, "accumulate:n={n},sampler=r2", rays),
        _watertight(povray.RENDERER, "regular:n={n}", (*rays[:3], 4e6)),
    ]


# --- faces that touch -------------------------------------------------------------------------------------------------


def _touching(renderer: Renderer) -> Probe:
    return Probe(
        renderer.name,
        "renderer",
        "touching",
        "RMS of radiance",
        "one of the faces at each sample, and the nearer one beyond the line where they touch",
        QUANTUM,
        BOUND,
        FACES,
        functools.partial(_off, renderer),
        FACES[:1],
        "Which of the faces in one place is seen, no scene says: any is right.",
    )


def _off(renderer: Renderer, at: float) -> float:
    scene, truths = touching(round(at))
    seen = picture(renderer, renderer.single_mode, scene)
    return rms(np.min([np.abs(seen - truth[..., np.newaxis]).max(axis=-1) for truth in truths], axis=0))


def touching(faces: int) -> tuple[Scene, list[Array]]:
    """A leaning face; in it others, so that there are so many in one place; a face that rises from a line in it, and
    one that sinks from there. The samples (height, width) see one picture or the other, each for itself."""

    def leaning(left: float, right: float, rise: float = 0.0) -> list[tuple[float, float, float]]:
        """In the plane at the left, and so far before it at the right; all of these numbers are exact in float."""
        corners = ((left, -0.5, 0.0), (right, -0.5, rise), (right, 0.5, rise), (left, 0.5, 0.0))
        return [(x, y, 0.375 * x + 0.25 * y + lift) for x, y, lift in corners]

    whole = [(x, y, 0.375 * x + 0.25 * y) for x, y in ((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))]
    within = [(leaning(-1.25, -0.75), ABOVE)] * (faces - 1)
    rising, sinking = (leaning(-0.25, 0.25, 0.5), ABOVE), (leaning(0.75, 1.25, -0.5), ABOVE)
    before = (faces - 1) // 2
    scene = of_polygons([*within[:before], rising, (whole, BELOW), sinking, *within[before:]])
    lower = np.full(SIZE[::-1], BELOW)
    lower[4:12, 10:14] = ABOVE
    upper = lower.copy()
    upper[4:12, 2:6] = ABOVE
    return scene, [lower, upper]


# --- closed meshes ----------------------------------------------------------------------------------------------------


def _watertight(renderer: Renderer, mode: str, rays: tuple[float, ...]) -> Probe:
    return Probe(
        renderer.name,
        "renderer",
        "watertight",
        "samples that leave a closed mesh",
        "none do",
        1.0,
        0.5,
        rays,
        functools.partial(_lost, renderer, mode),
        rays[:1],
        "A rough ball of 6,912 triangles seen from within, before a lurid background.",
    )


def _lost(renderer: Renderer, mode: str, at: float) -> float:
    """Samples that see the background, the one thing that is red, of `at` samples or a few more."""
    side = min(SIDE, 2 ** round(math.log2(math.sqrt(at / 16.0))))
    count = math.ceil(math.sqrt(at) / side) ** 2
    ball = scenes.rough_ball(24)
    lurid = {"view": View(size=(side, side), background=(1.0, 0.0, 1.0))}
    leaf = {"materials": {**ball.materials, "white": Material(emission=(0.0, 0.5, 0.0))}}
    scene = ball.model_copy(update=lurid | leaf)
    made = renderer.render(Request(scene, side, side, mode_of(renderer, mode.format(n=count))))
    return float(np.rint(made.pixels[..., 0].astype(np.float64) * count).sum())
