"""Renderings with a defect that neither a request nor the picture can be given: the samples of a pixel are spread over
a square that is wider than the pixel."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import patch

import numpy as np

from aliascope import renderers
from aliascope.errors import Unsupported
from aliascope.geometry import Array
from aliascope.model import Scene
from aliascope.native import raster
from aliascope.records import Pixels, Rendering
from aliascope.renderers import povray
from aliascope.renderers.base import Request
from aliascope.renderers.osmesa import passes_of
from aliascope.renderers.povray_frames import Frames, frames_of
from aliascope.renderers.povray_modes import grid_side
from aliascope.specs import Spec


def drawn(renderer: str, request: Request, wider: float = 0.0) -> Rendering:
    """What the renderer draws; `wider`: with the samples of a pixel spread so much wider about its centre, 0.1 for
    10 %. Raises Unsupported for a mode whose samples are not drawn one by one."""
    found = renderers.find(renderer)
    if wider == 0.0:
        return found.render(request)
    if renderer == "osmesa" and request.mode.name == "accumulate":
        return replace(found.render(request), pixels=_passes(request, wider))
    if renderer == "povray" and request.mode.name == "accumulate":
        return _frames(request, wider)
    if renderer == "povray" and request.mode.name == "regular":
        return replace(found.render(request), pixels=_canvas(request, wider))
    raise Unsupported(f"{renderer} {request.mode.text} has no samples that can be spread")


def _passes(request: Request, wider: float) -> Pixels:
    """A pass that samples beyond the pixel is one of the picture moved by a pixel."""
    scene, size = request.scene, (request.width, request.height)
    passes = passes_of(request.mode, scene, request.seed)
    wide = 0.5 + (1.0 + wider) * (passes.offsets - 0.5)
    pixels = np.floor(wide)
    total = np.zeros((size[1], size[0], 3))
    for right, down in np.unique(pixels, axis=0).tolist():
        own = (pixels == (right, down)).all(axis=1)
        part = replace(
            passes,
            offsets=np.minimum(wide[own] - (right, down), np.nextafter(1.0, 0.0)),
            weights=passes.weights[own],
            times=None if passes.times is None else passes.times[own],
            lens=None if passes.lens is None else passes.lens[own],
            lights=None if passes.lights is None else passes.lights[own],
        )
        shift = (request.shift[0] - right, request.shift[1] - down)
        total += raster.Raster(scene, size, shift).render(part)[0]
    return total.astype(np.float32)


def _frames(request: Request, wider: float) -> Rendering:
    """The shifts of POV-Ray's frames are this package's own: for this one picture they are others."""

    def spread(mode: Spec, seed: int, scene: Scene) -> Frames:
        frames = frames_of(mode, seed, scene)
        return replace(frames, shifts=(1.0 + wider) * frames.shifts)

    with patch.object(povray, "frames_of", spread):
        return povray.RENDERER.render(request)


def _canvas(request: Request, wider: float) -> Pixels:
    """Of the larger canvas whose pixels are the samples, means over boxes that reach into the neighbours."""
    side = grid_side(request.mode)
    assert side is not None
    canvas = replace(
        request,
        width=side * request.width,
        height=side * request.height,
        mode=renderers.mode_of(povray.RENDERER, "none"),
        shift=(side * request.shift[0], side * request.shift[1]),
    )
    samples = povray.RENDERER.render(canvas).pixels.astype(np.float64)
    return np.ascontiguousarray(_wide_means(_wide_means(samples, side, wider, 0), side, wider, 1)).astype(np.float32)


def _wide_means(samples: Array, side: int, wider: float, axis: int) -> Array:
    """Along one axis; a sample counts by the share of its own width that lies in the box. Beyond the border the canvas
    goes on as it is there."""
    values = np.moveaxis(samples, axis, 0)
    padded = np.concatenate([values[:1]] * side + [values] + [values[-1:]] * side)
    places = np.arange(-side, 2 * side) + 0.5 - 0.5 * side
    half = 0.5 * side * (1.0 + wider)
    shares = np.clip(half + 0.5 - np.abs(places), 0.0, 1.0)
    shares /= shares.sum()
    count = len(values) // side
    found = sum(share * padded[number::side][:count] for number, share in enumerate(shares.tolist()) if share)
    return np.moveaxis(np.asarray(found), 0, axis)
