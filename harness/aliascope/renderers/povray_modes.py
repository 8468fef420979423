"""The modes of the POV-Ray renderer: what each takes, which options it becomes, where its samples lie."""

from __future__ import annotations

import math

import numpy as np

from aliascope.errors import Unsupported
from aliascope.model import AreaLight, DiscLight, LoadedMesh, Scene, SphereLight
from aliascope.native import samplers
from aliascope.renderers.base import DIMENSIONS, RECENTRE
from aliascope.specs import Form, Key, Spec

FRAME_SECONDS = 0.01
"""Seconds on the wall that a frame takes, however small it is: 20 of them took 0.2."""

TRIANGLE_SECONDS = 7e-6
"""Seconds that a frame takes for each triangle, to parse it and to bound it: the scene is read again for each frame."""

MOST_MOVED = 5_000_000
"""Triangles that are written again because they moved, over all frames: a gigabyte of text."""

ANTIALIAS_GAMMA = 2.5
"""povray compares colours to the power of 1/2.5 with its threshold; it averages them as they are."""

MOST_CONTRAST = 3.0
"""Between two colours within [0, 1], to any power, summed over RGB."""

_COMPARING = ("am1", "am2")
"""The modes that look for contrast."""

GROUPS = ((2,), (2, 1), (2, 2), (2, 1, 2))
"""Those that a sample can have, with a shutter and a lens or without, but for lights: see `Needs.groups`."""

# povray refuses +A1 and more, and shows 0.999 to three digits.
_THRESHOLD = Key("threshold", "real", 0.1, "sum over RGB of the differences that calls for more samples", 0.0, 0.999)
_JITTER = Key(
    "jitter", "real", 1.0, "how far samples move, 1 for over their whole cell; 0 leaves them on the grid", 0.0, 1.0
)
_GRID_SIDE = Key("depth", "integer", 3, "side of the grid of samples within a pixel", 1, 9, is_count=True)
_LEVELS = Key(
    "depth", "integer", 3, "levels; (2^(depth-1)+1)^2 samples at most, 1 is corners alone", 1, 9, is_count=True
)

_AREA_LIGHTS = (
    Key(
        "light_grid",
        "choice",
        "8",
        "side of the grid of points on an area light (a parallelogram that does not fall off). POV-Ray multiplies the "
        "mean of n . l by the mean visibility, so it is biased by their covariance, up to 0.0033 in a test: accumulate "
        "is not",
        choices=("2", "4", "8", "16"),
    ),
    Key(
        "light_adaptive",
        "choice",
        "off",
        "level of the grid that is looked at first, the rest where it is partly in shadow",
        choices=("off", "0", "1", "2", "3"),
    ),
    Key("light_jitter", "choice", "off", "moves the points of an area light, in one thread", choices=("off", "on")),
)
"""Of a 5 x 5, 9 x 9 or 17 x 17 grid POV-Ray weighs the border by half, of 32 x 32 it weighs points unevenly."""

EXPOSURE = Key(
    "exposure",
    "choice",
    "auto",
    "what light is divided by before POV-Ray sees it, and its picture multiplied by: auto, a power of two that brings "
    "a bright or a dim scene within the range of its files; off, nothing: what is dim is lost below 1/65535",
    choices=("auto", "off"),
)


def _sampler(spec: str) -> str:
    """The canonical form of a pattern, also of one in space and time alone, whose counts may be squares of 4. Raises
    SpecError, and Unsupported for a pattern that is neither."""
    try:
        return samplers.canonical(spec)
    except Unsupported:
        return samplers.Sampler(spec, 16, 3).spec


ACCUMULATE = Form(
    "accumulate",
    "n frames with one ray a pixel, moved by one sampling pattern for all pixels, and averaged; each at its own time, "
    "through its own point of the lens, lit by one point of each area light, where the scene asks for that. A frame "
    f"takes {FRAME_SECONDS:g} s on the wall, and more where the scene is large: n is bounded by the time limit too",
    (
        Key("n", "integer", 16, "frames, the samples a pixel", 1, 4096, is_count=True),
        Key("sampler", "spec", "halton", "the pattern", inner=_sampler, inner_settings=samplers.settings, named=True),
        DIMENSIONS,
        EXPOSURE,
        RECENTRE,
    ),
)

FOCAL_BLUR = Form(
    "focal-blur",
    "POV-Ray's own lens: rays through random points of it, until a test says that their mean is sure enough. It is "
    "round, and for scenes with a lens, whose radius and focus become its aperture and focal_point",
    (
        Key("blur_samples", "integer", 64, "rays a pixel at most; 4, 7, 19, 37 are lattices", 1, 4096, is_count=True),
        Key("confidence", "real", 0.9, "of the chi-squared test that stops the rays", 0.001, 0.999),
        Key("variance", "real", 1.0 / 128.0, "of the mean that is enough; 0 takes all the rays", 0.0, 1.0),
        Key(
            "compensation",
            "choice",
            "on",
            "of what POV-Ray 3.7 does: half the aperture, and pictures 1/32 pixel off; off: as its manual reads",
            choices=("on", "off"),
        ),
        EXPOSURE,
        *_AREA_LIGHTS,
        RECENTRE,
    ),
)

FORMS = (
    Form("none", "one ray through the centre of each pixel (-A)", (EXPOSURE, *_AREA_LIGHTS, RECENTRE)),
    Form(
        "am1",
        "a ray a pixel, compared with the left and the upper neighbour; where they differ, depth x depth more (+AM1)",
        (_GRID_SIDE, _THRESHOLD, _JITTER, EXPOSURE, *_AREA_LIGHTS, RECENTRE),
    ),
    Form(
        "am2",
        "the four corners of a pixel, and between them recursively where they differ (+AM2)",
        (_LEVELS, _THRESHOLD, _JITTER, EXPOSURE, *_AREA_LIGHTS, RECENTRE),
    ),
    Form(
        "regular",
        "n = k x k rays a pixel, on a regular grid: rendered k times larger and averaged",
        (
            Key("n", "integer", 16, "samples a pixel, a square number", 1, 1 << 14, is_count=True),
            EXPOSURE,
            *_AREA_LIGHTS,
            RECENTRE,
        ),
    ),
    ACCUMULATE,
    FOCAL_BLUR,
)


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


def unable_mode(mode: Spec, scene: Scene) -> str | None:
    """Why the mode has no such count, lacks what the scene needs, or has a key that nothing in the scene is for, or
    None."""
    if any(isinstance(light, SphereLight) and light.falloff == "none" for light in scene.lights):
        return (
            "a sphere light that does not fall off counts by the part of it that each place sees, and no light of "
            'POV-Ray\'s depends on that: with falloff = "inverse-square" accumulate draws it'
        )
    if grid_side(mode) is None:
        n = mode.integer("n")
        below = math.isqrt(n)
        return f"regular:n={n} is not a square number; the nearest are {below**2} and {(below + 1) ** 2}"
    if mode.name == ACCUMULATE.name:
        return samplers.refusal(mode.word("sampler"), mode.integer("n"), scene.needs().groups, mode.word("dimensions"))
    return _without_frames(mode, scene) or _lights_of_its_own(mode, scene)


def _without_frames(mode: Spec, scene: Scene) -> str | None:
    """Why the mode does not draw the scene's motion and lens, or None."""
    needs, blurs = scene.needs(), mode.name == FOCAL_BLUR.name
    if blurs and not needs.lens:
        return "focal-blur needs a lens, and this scene has none"
    missing = [name for name, lacking in (("motion", needs.shutter), ("a lens", needs.lens and not blurs)) if lacking]
    if missing:
        return f"{mode.name} of POV-Ray does not draw {' and '.join(missing)}: accumulate does"
    if blurs and scene.camera.blades >= 3:
        return f"the lens of POV-Ray's focal-blur is round, and this one has {scene.camera.blades} blades"
    return None


def _lights_of_its_own(mode: Spec, scene: Scene) -> str | None:
    """Why POV-Ray's `area_light` is not the scene's lights, or None."""
    if any(isinstance(light, SphereLight) for light in scene.lights):
        return "POV-Ray's area lights are flat, not spheres: accumulate draws these"
    if any(isinstance(light, DiscLight) for light in scene.lights):
        return (
            "POV-Ray's circular area lights are denser along their diagonals, which is wrong by up to 0.019 of the "
            "light in a penumbra, however many their points: accumulate draws discs"
        )
    lights = [light for light in scene.lights if isinstance(light, AreaLight)]
    if any(light.falloff != "none" for light in lights):
        return (
            "POV-Ray's area lights shine alike in all directions, and fall off from their centre: accumulate draws "
            "those that have a cosine"
        )
    asked = [key.name for key in _AREA_LIGHTS if mode.values[key.name] != key.default]
    if asked and not lights:
        return f"{mode.name}'s {' and '.join(asked)} are for area lights, and this scene has none"
    return None


def _triangles(scene: Scene, moving: bool = False) -> int:
    meshes = [surface for surface in scene.surfaces if isinstance(surface, LoadedMesh)]
    return sum(len(mesh.triangles) for mesh in meshes if mesh.motion is not None or not moving)


def too_long(scene: Scene, mode: Spec, time_limit: float) -> str | None:
    """Why the frames do not end within so many seconds, or None: what they take before a pixel is traced is known."""
    count = frame_count(mode)
    moving = _triangles(scene, moving=True)
    if scene.needs().shutter and count * moving > MOST_MOVED:
        return f"{mode.text}: {count} frames of {moving} moving triangles; at most {MOST_MOVED:g} are written in all"
    frame_seconds = FRAME_SECONDS + TRIANGLE_SECONDS * _triangles(scene)
    most = int(time_limit / frame_seconds)
    if count == 1 or count <= most:
        return None
    return (
        f"{mode.text}: {count} frames of POV-Ray take {frame_seconds * count:.0f} s or more, past the "
        f"time limit of {time_limit:g} s; at most {max(most, 1)} fit"
    )


def seeded(mode: Spec) -> bool:
    """Whether the sampler of `accumulate` is; POV-Ray's own jitter is a hash of the position.

    A pattern that is randomised is so in whichever dimensions it has points. Raises Unsupported for one without.
    """
    if mode.name != ACCUMULATE.name:
        return False
    if mode.word("dimensions") != "joint":
        return True  # the shuffling is
    sampler, count = mode.word("sampler"), mode.integer("n")
    refused = [samplers.refusal(sampler, count, width) for width in GROUPS]
    return samplers.randomised(sampler, count, GROUPS[refused.index(None)] if None in refused else GROUPS[0])


def exposed(mode: Spec) -> bool:
    """Whether light is divided by an exposure."""
    return mode.word(EXPOSURE.name) == "auto"


def allowed_exposure(mode: Spec, wanted: float) -> float:
    """The nearest exposure at or above this one, both powers of two, at which povray can be told the threshold."""
    if mode.name in _COMPARING and _THRESHOLD.maximum < _threshold(mode, wanted) <= MOST_CONTRAST:
        return float(2.0 ** math.ceil(ANTIALIAS_GAMMA * math.log2(mode.real("threshold") / _THRESHOLD.maximum)))
    return wanted


def antialiasing(mode: Spec, exposure: float) -> tuple[str, ...]:
    """The options of a mode, for a picture whose colours were divided by `exposure`: the threshold is, too.

    Numbers in fixed notation: povray does not understand +A1e-07. Where no two colours of the picture differ by as
    much as the threshold, the options are those that take the first samples alone.
    """
    if mode.name not in _COMPARING:
        return ("-A",)
    threshold, depth, jitter = _threshold(mode, exposure), mode.integer("depth"), mode.real("jitter")
    if threshold > MOST_CONTRAST:
        if mode.name == "am1":
            return ("-A",)
        threshold, depth = _THRESHOLD.maximum, 1
    return (
        f"+{mode.name.upper()}",
        f"+A{_fixed(threshold)}",
        f"+R{depth}",
        f"+J{_fixed(jitter)}" if jitter > 0.0 else "-J",
    )


def _threshold(mode: Spec, exposure: float) -> float:
    """That of a picture whose colours were divided by the exposure."""
    return float(mode.real("threshold") * exposure ** (-1.0 / ANTIALIAS_GAMMA))


def _fixed(x: float) -> str:
    return np.format_float_positional(x, trim="0")
