"""The frames that make up a picture of the mode `accumulate`: where in the pixel, when, and through which point of the
lens each looks, and which point of each area light shines.

A scene without a lens or without a shutter spends no dimension of the sampler on it. The dimensions in order: two of
the pixel, one of time, two of the lens, two of each light with an area, as the scene states them. Haeberli and Akeley
1990, "The Accumulation Buffer", average pictures so.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from aliascope import motion
from aliascope.geometry import Array
from aliascope.model import AreaLight, DiscLight, Scene, SphereLight
from aliascope.native import samplers
from aliascope.renderers.accumulation import choices_of
from aliascope.renderers.povray_area_lights import LightPoints, points_on
from aliascope.renderers.povray_modes import ACCUMULATE, FOCAL_BLUR
from aliascope.specs import Spec

MOMENTS = 65
"""Frames with which a scene is looked at before its own are known: evenly spaced moments of the shutter, and points of
its lights."""

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
    middle of the lens, in the scene's units, None without a lens. blur: POV-Ray's own lens, in its place. lights: of
    each of the scene's lights its points, None of one without an area; where there are none here, area lights are
    POV-Ray's own, of this grid. further: columns and rows that the canvas has more than the picture, which lies at its
    right and its bottom where they are positive, at its left and its top where they are negative."""

    shifts: Array
    weights: Array
    times: Array | None = None
    lens: Array | None = None
    blur: FocalBlur | None = None
    grid: LightGrid = LightGrid()
    lights: tuple[LightPoints | None, ...] = ()
    further: tuple[int, int] = (0, 0)


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
    chosen = choices_of(scene, mode.word("sampler"), mode.integer("n"), seed, mode.word("dimensions"))
    return Frames(
        chosen.offsets - 0.5,
        chosen.weights,
        chosen.times,
        chosen.lens,
        lights=_light_points(scene, chosen.lights),
    )


def moved(frames: Frames, shift: tuple[float, float]) -> Frames:
    """The frames of a picture in which all that is seen is moved by so many pixels to the right and down.

    POV-Ray's own lens stands at a right angle to the direction of the camera, and its focus with it: the direction
    takes at most a quarter of a pixel, and the picture is a part of a larger canvas. An odd number of further columns
    moves it by half a pixel. Of a picture of 64 x 48 pixels and 70 degrees the direction alone made profiles wrong by
    0.063 rms at 16 pixels; so they are as right as in place.
    """
    if frames.blur is None:
        return replace(frames, shifts=frames.shifts - shift)
    further = (-round(2.0 * shift[0]), -round(2.0 * shift[1]))
    return replace(frames, shifts=frames.shifts - shift - 0.5 * np.array(further), further=further)


def _light_points(scene: Scene, u: Array | None) -> tuple[LightPoints | None, ...]:
    """u: (frames, lights with an area, 2), or None."""
    if u is None:
        return ()
    areas = iter(np.moveaxis(u, 1, 0))
    has_area = (AreaLight, DiscLight, SphereLight)
    return tuple(points_on(light, next(areas)) if isinstance(light, has_area) else None for light in scene.lights)


def looked_at(scene: Scene) -> Frames:
    """MOMENTS frames that stand for those of any mode: from the shutter's opening to its closing, with points all over
    the lights."""
    areas = scene.needs().area_lights
    times = None
    if scene.needs().shutter:
        assert scene.camera.shutter is not None
        times = np.linspace(*scene.camera.shutter, MOMENTS)
    u = samplers.points("halton", MOMENTS, 2 * areas).reshape(MOMENTS, areas, 2) if areas else None
    lights = _light_points(scene, u)
    return Frames(np.zeros((MOMENTS, 2)), np.full(MOMENTS, 1.0 / MOMENTS), times, lights=lights)


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
