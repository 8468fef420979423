"""References: the pictures that renderings are judged by, made without a renderer where the scene allows it.

Another method is one file with a `METHOD` and its line in METHODS. The first that can draw the scene makes it.
"""

from __future__ import annotations

import numpy as np

from aliascope.errors import Unsupported
from aliascope.geometry import frame_of
from aliascope.model import Scene
from aliascope.references import checkerboard, discs, polygons, zone_plate
from aliascope.references.result import Method, Reference

__all__ = ["METHODS", "Method", "Reference", "make"]

METHODS: tuple[Method, ...] = (
    polygons.METHOD,
    discs.METHOD,
    zone_plate.METHOD,
    checkerboard.METHOD,
)


def make(scene: Scene, size: tuple[int, int], filter_: str = "box") -> Reference:
    """The exact picture of a scene: each pixel the mean of the radiance over its square, the box filter.

    size: (width, height) in pixels. Raises Unsupported, with the reason, where no method has an exact answer.
    """
    if filter_ != "box":
        raise Unsupported(f'no exact method has an answer for the filter "{filter_}": they all have the box filter')
    reasons = [(method, method.cannot(scene)) for method in METHODS]
    able = [method for method, reason in reasons if reason is None]
    if not able:
        why = "; ".join(f'"{method.name}" {reason}' for method, reason in reasons)
        raise Unsupported(f"the scene has no exact reference: {why}")
    method = able[0]
    result = method.make(scene, frame_of(scene, size))
    with np.errstate(over="ignore"):
        pixels = result.pixels.astype(np.float32)
    if not np.isfinite(pixels).all():
        raise Unsupported(f"the scene is as bright as {float(result.pixels.max()):.1e}: more than float32 holds")
    return Reference(pixels=pixels, exact=result.pixels, error=result.error, method=method.name)
