"""What a reference is, and what every method that makes one has in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame
from aliascope.model import Scene
from aliascope.records import Pixels
from aliascope.references.canvas import Canvas

EPSILON = float(np.finfo(np.float64).eps)
LARGEST_ERROR = 1e-9
"""An exact method whose error bound, relative to the brightest colour, comes out larger refuses the scene."""


class Ambiguous(Unsupported):
    """A scene whose picture hangs on a rounding: two surfaces at one depth. No reference of it has a meaning."""


@dataclass(frozen=True)
class Exact:
    """Pixels as a method computes them, (height, width, 3) float64 linear RGB, and a bound of their absolute error."""

    pixels: Array
    error: float


@dataclass(frozen=True)
class Reference:
    """The picture that others are judged by.

    `pixels` (height, width, 3) float32 is `exact` rounded, `exact` is float64. No value of an exact reference is
    farther than `error` from the truth. A converged one has a `standard_error`, of the shape of `pixels`, and its
    `error` is only what rounding adds to that; its `provenance` says how many samples, of which sampler and seeds,
    made it.
    """

    pixels: Pixels
    exact: Array
    error: float
    method: str
    standard_error: Array | None = None
    provenance: Mapping[str, str] = field(default_factory=dict)

    @property
    def standard_error_rms(self) -> float | None:
        """Over all pixels and channels; None for an exact reference."""
        return None if self.standard_error is None else float(np.sqrt((self.standard_error**2).mean()))

    @property
    def uncertainty(self) -> str:
        """For people: "exact (polygons), error below 1e-12", "converged, standard error 2e-05 (rms), ..."."""
        if self.standard_error is None:
            return f"exact ({self.method}), error below {self.error:.2g}"
        largest = float(self.standard_error.max())
        return f"{self.method}, standard error {self.standard_error_rms:.2g} (rms), {largest:.2g} at most"


@dataclass(frozen=True)
class Method:
    """A way to make references. `features` are those of `Scene.features` that it can draw, the cameras among them;
    `requires`, one that it is for: without it another method is simpler.

    `make` raises Unsupported where it meets a configuration that it has no exact answer for.
    """

    name: str
    title: str
    features: frozenset[str]
    make: Callable[[Scene, Frame], Exact]
    requires: str | None = None

    def cannot(self, scene: Scene) -> str | None:
        """Why the method can't draw the scene, as far as its features tell; None where it may."""
        lacking = sorted(scene.features() - self.features)
        if lacking:
            return f"has no answer for {', '.join(lacking)}"
        if self.requires is not None and self.requires not in scene.features():
            return f"is for scenes with {self.requires}"
        return None


def checked(canvas: Canvas, background: Array, error: float) -> Exact:
    """The result of a method, whose coverages, relative to the brightest colour, are in error by at most `error`.

    Raises Unsupported where that is more than a reference may have.
    """
    error += 4 * EPSILON * (canvas.surfaces + 1)  # a product and a sum for each surface
    if not error <= LARGEST_ERROR:
        raise Unsupported(
            f"rounding could move the pixels by {error:.1e} of the brightest colour: the coordinates are too large, or "
            "too far from the eye, for the size of a pixel"
        )
    pixels = canvas.over(background)
    return Exact(pixels=pixels, error=error * canvas.brightest)
