"""The frames that make up a picture of the mode `accumulate`: where in the pixel, when, and through which point of the
lens each looks.

A scene without a lens or without a shutter spends no dimension of the sampler on it. The dimensions in order: two of
the pixel, one of time, two of the lens. Haeberli and Akeley 1990, "The Accumulation Buffer", average pictures so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from aliascope import motion
from aliascope.geometry import Array
from aliascope.model import Scene
from aliascope.native import samplers
from aliascope.renderers.accumulation import lens_points, shutter_times
from aliascope.renderers.povray_modes import ACCUMULATE, FOCAL_BLUR, dimensions
from aliascope.specs import Spec

MOMENTS = 65
"""Evenly spaced moments of a shutter at which a scene is looked at before the times of its frames are known."""


APERTURE = 4.0
"""Of POV-Ray's camera, over the radius of the lens that acts (measured; its manual makes it the diameter, 2)."""

PICTURE_SHIFT = 1.0 / 32.0
"""Pixels to the right and down by which focal blur moves the picture (measured with an edge at all phases)."""


@dataclass(frozen=True)
class FocalBlur:
    """POV-Ray's own lens. aperture: over the radius of the scene's lens; the others as POV-Ray has them."""

    aperture: float
    samples: int
    confidence: float
    variance: float


@dataclass(frozen=True)
class LightGrid:
    """The points on an area light: side x side of them; the first level of adaptive sampling, "off" for all points;
    whether they are moved at random."""

    side: int = 8
    adaptive: str = "off"
    jitter: bool = False


@dataclass(frozen=True)
class Frames:
    """The frames that make a picture. shifts (n, 2): pixels to the right and down from the centres of the pixels;
    weights (n,); times (n,) in [0, 1], None for a scene that stands still; lens (n, 2): to the right and up from the
    middle of the lens, in the scene's units, None without a lens. blur: POV-Ray's own lens, in its place. grid: of each
    area light."""

    shifts: Array
    weights: Array
    times: Array | None = None
    lens: Array | None = None
    blur: FocalBlur | None = None
    grid: LightGrid = LightGrid()


def frames_of(mode: Spec, seed: int, scene: Scene) -> Frames:
    """One frame without a shift, or those of `accumulate`. Raises Unsupported for a count that the sampler lacks."""
    if mode.name == FOCAL_BLUR.name:
        compensated = mode.word("compensation") == "on"
        blur = FocalBlur(
            APERTURE if compensated else 2.0,
            mode.integer("blur_samples"),
            mode.real("confidence"),
            mode.real("variance"),
        )
        return Frames(
            np.full((1, 2), PICTURE_SHIFT if compensated else 0.0), np.ones(1), blur=blur, grid=light_grid(mode)
        )
    if mode.name != ACCUMULATE.name:
        return Frames(np.zeros((1, 2)), np.ones(1), grid=light_grid(mode))
    sampler, count, needs = mode.word("sampler"), mode.integer("n"), scene.needs()
    width = dimensions(needs)
    points = samplers.points(sampler, count, width, seed)
    return Frames(
        points[:, :2] - 0.5,
        samplers.weights(sampler, count, width),
        shutter_times(scene, points[:, 2]) if needs.shutter else None,
        lens_points(scene, points[:, width - 2 :]) if needs.lens else None,
        grid=light_grid(mode),
    )


def light_grid(mode: Spec) -> LightGrid:
    """What the mode says of area lights."""
    return LightGrid(int(mode.word("light_grid")), mode.word("light_adaptive"), mode.word("light_jitter") == "on")


def moments(scene: Scene, times: Array | None) -> Iterator[Scene]:
    """The scene at each of the times; as it stands without them."""
    if times is None:
        yield scene
        return
    for time in times.tolist():
        yield motion.at(scene, time)


def times_within(scene: Scene) -> Array | None:
    """MOMENTS times from the shutter's opening to its closing, or None for a scene that stands still."""
    if not scene.needs().shutter:
        return None
    assert scene.camera.shutter is not None
    return np.linspace(*scene.camera.shutter, MOMENTS)
