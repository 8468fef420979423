"""References: the pictures that renderings are judged by, made without a renderer where the scene allows it.

Another method is one file with a `METHOD` and its line in METHODS. The first that has an answer for the scene makes it.
Where none has, and for every filter but the box, a reference is converged: `converged`.
"""

from __future__ import annotations

import numpy as np

from aliascope.draws import UNMOVED, checked
from aliascope.errors import Unsupported
from aliascope.geometry import frame_of
from aliascope.model import Scene
from aliascope.references import (
    checkerboard,
    converged,
    defocus,
    discs,
    irradiance,
    mirrored,
    moving,
    polygons,
    zone_plate,
)
from aliascope.references.converged import Plan
from aliascope.references.result import Ambiguous, Method, Reference

__all__ = ["METHODS", "Ambiguous", "Method", "Plan", "Reference", "make", "may_be_exact"]

METHODS: tuple[Method, ...] = (
    polygons.METHOD,
    discs.METHOD,
    zone_plate.METHOD,
    checkerboard.METHOD,
    mirrored.METHOD,
    moving.METHOD,
    defocus.METHOD,
    irradiance.METHOD,
)


def make(
    scene: Scene,
    size: tuple[int, int],
    filter_: str = "box",
    plan: Plan | None = None,
    shift: tuple[float, float] = UNMOVED,
) -> Reference:
    """The picture of a scene, each pixel the mean of the radiance under the filter: over its square, for the box.

    size: (width, height) in pixels; filter_: a canonical spec; shift: pixels to the right and down by which all that is
    seen is moved on the film. Exact where there is a method for it, else converged by the plan. Raises Unsupported,
    with the reason, where no method has an exact answer and there is no plan, or the tracer does not draw the scene;
    Ambiguous where no answer is right; InvalidInput for a shift beyond `draws.LARGEST_SHIFT`.
    """
    checked(shift)
    try:
        return _exact(scene, size, filter_, shift)
    except Ambiguous:
        raise
    except Unsupported:
        if plan is None:
            raise
    return converged.make(scene, size, filter_, plan, shift)


def may_be_exact(scene: Scene, filter_: str) -> bool:
    """Whether a method has an exact answer for the features of a scene. It may still refuse the scene itself."""
    return filter_ == "box" and any(method.cannot(scene) is None for method in METHODS)


def _exact(scene: Scene, size: tuple[int, int], filter_: str, shift: tuple[float, float]) -> Reference:
    if filter_ != "box":
        raise Unsupported(f'no exact method has an answer for the filter "{filter_}": they all have the box filter')
    reasons = [(method, method.cannot(scene)) for method in METHODS]
    able = [method for method, reason in reasons if reason is None]
    if not able:
        why = "; ".join(f'"{method.name}" {reason}' for method, reason in reasons)
        raise Unsupported(f"the scene has no exact reference: {why}")
    refusals: dict[str, None] = {}
    for method in able:
        try:
            result = method.make(scene, frame_of(scene, size, shift))
            break
        except Ambiguous:
            raise
        except Unsupported as refusal:
            refusals[str(refusal)] = None
    else:
        raise Unsupported("; ".join(refusals))
    with np.errstate(over="ignore"):
        pixels = result.pixels.astype(np.float32)
    if not np.isfinite(pixels).all():
        raise Unsupported(f"the scene is as bright as {float(result.pixels.max()):.1e}: more than float32 holds")
    return Reference(pixels=pixels, exact=result.pixels, error=result.error, method=method.name)
