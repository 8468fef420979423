"""The modes of the POV-Ray renderer: what each takes, which options it becomes, where its samples lie."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from aliascope.errors import Unsupported
from aliascope.geometry import Array
from aliascope.model import LoadedMesh, Scene
from aliascope.native import samplers
from aliascope.specs import Form, Key, Spec

FRAME_SECONDS = 0.23
"""Seconds on the wall that a frame takes, however small it is: 120 of them took 27.4."""

TRIANGLE_SECONDS = 7e-6
"""Seconds that a frame takes for each triangle, to parse it and to bound it: the scene is read again for each frame."""

START_SECONDS = 0.5
"""Seconds on the wall before the first frame."""

ANTIALIAS_GAMMA = 2.5
"""povray compares colours to the power of 1/2.5 with its threshold; it averages them as they are."""

# povray refuses +A1 and more, and shows 0.999 to three digits.
_THRESHOLD = Key("threshold", "real", 0.1, "sum over RGB of the differences that calls for more samples", 0.0, 0.999)
_JITTER = Key(
    "jitter", "real", 1.0, "how far samples move, 1 for over their whole cell; 0 leaves them on the grid", 0.0, 1.0
)
_GRID_SIDE = Key("depth", "integer", 3, "side of the grid of samples within a pixel", 1, 9, is_count=True)
_LEVELS = Key(
    "depth", "integer", 3, "levels; (2^(depth-1)+1)^2 samples at most, 1 is corners alone", 1, 9, is_count=True
)

ACCUMULATE = Form(
    "accumulate",
    "n frames with one ray a pixel, moved by one sampling pattern for all pixels, and averaged. A frame takes "
    f"{FRAME_SECONDS:g} s on the wall, so n is bounded by the time limit too: about 2,600 in 600 s, 510 in 120 s",
    (
        Key("n", "integer", 16, "frames, the samples a pixel", 1, 4096, is_count=True),
        Key("sampler", "spec", "halton", "the pattern", inner=samplers.canonical, named=True),
    ),
)

FORMS = (
    Form("none", "one ray through the centre of each pixel (-A)"),
    Form(
        "am1",
        "a ray a pixel, compared with the left and the upper neighbour; where they differ, depth x depth more (+AM1)",
        (_GRID_SIDE, _THRESHOLD, _JITTER),
    ),
    Form(
        "am2",
        "the four corners of a pixel, and between them recursively where they differ (+AM2)",
        (_LEVELS, _THRESHOLD, _JITTER),
    ),
    Form(
        "regular",
        "n = k x k rays a pixel, on a regular grid: rendered k times larger and averaged",
        (Key("n", "integer", 16, "samples a pixel, a square number", 1, 1 << 14, is_count=True),),
    ),
    ACCUMULATE,
)


@dataclass(frozen=True)
class Frames:
    """The frames that make a picture. shifts (n, 2): pixels to the right and down from the centres of the pixels;
    weights (n,)."""

    shifts: Array
    weights: Array


def frames_of(mode: Spec, seed: int) -> Frames:
    """One frame without a shift, or those of `accumulate`. Raises Unsupported for a count that the sampler lacks."""
    if mode.name != ACCUMULATE.name:
        return Frames(np.zeros((1, 2)), np.ones(1))
    sampler, count = mode.word("sampler"), mode.integer("n")
    return Frames(samplers.points(sampler, count, 2, seed) - 0.5, samplers.weights(sampler, count, 2))


def frame_count(mode: Spec) -> int:
    return mode.integer("n") if mode.name == ACCUMULATE.name else 1


def grid_side(mode: Spec) -> int | None:
    """k of a regular grid of n = k x k samples, 1 for other modes, None where n is no square."""
    if mode.name != "regular":
        return 1
    n = mode.integer("n")
    side = math.isqrt(n)
    return side if side * side == n else None


def samples_per_pixel(mode: Spec) -> int:
    """Of the modes that hold all their samples at once, as pixels of a canvas or of frames; 1 for the others."""
    return mode.integer("n") if mode.name in ("regular", ACCUMULATE.name) else 1


def unable_mode(mode: Spec) -> str | None:
    """Why the mode has no such count, or None."""
    if grid_side(mode) is None:
        n = mode.integer("n")
        below = math.isqrt(n)
        return f"regular:n={n} is not a square number; the nearest are {below**2} and {(below + 1) ** 2}"
    if mode.name == ACCUMULATE.name:
        try:
            seeded(mode)
        except Unsupported as error:
            return str(error)
    return None


def too_long(scene: Scene, mode: Spec, time_limit: float) -> str | None:
    """Why the frames do not end within so many seconds, or None: what they take before a pixel is traced is known."""
    count = frame_count(mode)
    triangles = sum(len(surface.triangles) for surface in scene.surfaces if isinstance(surface, LoadedMesh))
    frame_seconds = FRAME_SECONDS + TRIANGLE_SECONDS * triangles
    most = int((time_limit - START_SECONDS) / frame_seconds)
    if count == 1 or count <= most:
        return None
    return (
        f"{mode.text}: {count} frames of POV-Ray take {START_SECONDS + frame_seconds * count:.0f} s or more, past the "
        f"time limit of {time_limit:g} s; at most {max(most, 1)} fit"
    )


def seeded(mode: Spec) -> bool:
    """Whether the sampler of `accumulate` is; POV-Ray's own jitter is a hash of the position."""
    return mode.name == ACCUMULATE.name and samplers.randomised(mode.word("sampler"), mode.integer("n"))


def antialiasing(mode: Spec, exposure: float) -> tuple[str, ...]:
    """The options of a mode, for a picture whose colours were divided by `exposure`: the threshold is, too.

    Numbers in fixed notation: povray does not understand +A1e-07.
    """
    if mode.name not in ("am1", "am2"):
        return ("-A",)
    jitter = mode.real("jitter")
    return (
        f"+{mode.name.upper()}",
        f"+A{_fixed(mode.real('threshold') * exposure ** (-1.0 / ANTIALIAS_GAMMA))}",
        f"+R{mode.integer('depth')}",
        f"+J{_fixed(jitter)}" if jitter > 0.0 else "-J",
    )


def _fixed(x: float) -> str:
    return np.format_float_positional(x, trim="0")
