"""POV-Ray 3.7: its own antialiasing methods 1 and 2, no antialiasing, and a regular grid of samples.

Scenes within [0, 1] come as 16-bit PNG, brighter ones as half-float EXR; the step of either is the picture's quantum.
Persistence of Vision Raytracer, https://www.povray.org; its reference manual, section 3.2.8.5 "Antialiasing options",
names the options; what they do was measured.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aliascope.errors import InvalidInput, JobFailed, NotWritable, Unsupported
from aliascope.image import read_image
from aliascope.model import LARGEST_AREA, Scene
from aliascope.records import Cost, Pixels, Rendering
from aliascope.renderers.base import Request, lacks
from aliascope.renderers.povray_process import Statistics, executable, read_statistics, run, version
from aliascope.renderers.povray_sdl import brightest, out_of_reach, scene_text
from aliascope.specs import Form, Key, Spec

MOST_FRAMES = 6
"""Frames that a run for the time alone renders at most: each takes 0.23 s on the wall, however small it is."""

CLOCK_STEP = 0.001
"""Seconds; the step of the times that povray prints."""

LARGEST_HALF = 65504.0
"""The largest half float."""

# povray refuses +A1 and more, and shows 0.999 to three digits.
_THRESHOLD = Key("threshold", "real", 0.1, "sum over RGB of the differences that calls for more samples", 0.0, 0.999)
_JITTER = Key(
    "jitter", "real", 1.0, "how far samples move, 1 for over their whole cell; 0 leaves them on the grid", 0.0, 1.0
)

_FORMS = (
    Form("none", "one ray through the centre of each pixel (-A)"),
    Form(
        "am1",
        "a ray a pixel, compared with the left and the upper neighbour; where they differ, depth x depth more (+AM1)",
        (
            Key("depth", "integer", 3, "side of the grid of samples within a pixel", 1, 9, is_count=True),
            _THRESHOLD,
            _JITTER,
        ),
    ),
    Form(
        "am2",
        "the four corners of a pixel, and between them recursively where they differ (+AM2)",
        (
            Key(
                "depth",
                "integer",
                3,
                "levels; (2^(depth-1)+1)^2 samples at most, 1 is corners alone",
                1,
                9,
                is_count=True,
            ),
            _THRESHOLD,
            _JITTER,
        ),
    ),
    Form(
        "regular",
        "n = k x k rays a pixel, on a regular grid: rendered k times larger and averaged",
        (Key("n", "integer", 16, "samples a pixel, a square number", 1, 1 << 14, is_count=True),),
    ),
)


@dataclass(frozen=True)
class _Output:
    """A file format: its option, its suffix, and the step between values at the brightest."""

    option: str
    suffix: str
    quantum: float


@dataclass(frozen=True)
class _Job:
    """One program run, but for its frames: the size is that of the canvas."""

    path: str
    folder: Path
    width: int
    height: int
    options: tuple[str, ...]
    output: _Output


class PovRay:
    """The renderer; see `aliascope.renderers.base.Renderer` for what its members promise."""

    name = "povray"
    title = "POV-Ray"
    modes: Mapping[str, Form] = {form.name: form for form in _FORMS}
    draws = frozenset({"orthographic", "perspective", "polygon", "disc", "sphere", "zone-plate"})

    def versions(self) -> Mapping[str, str]:
        """The version that the povray on the PATH states."""
        return {"povray": version(executable())}

    def unable(self, scene: Scene, mode: Spec) -> str | None:
        """Why the picture would not be this scene: a count that is no square, light or places beyond its range."""
        if _grid_side(mode) is None:
            n = mode.integer("n")
            below = math.isqrt(n)
            return f"regular:n={n} is not a square number; the nearest are {below**2} and {(below + 1) ** 2}"
        peak = brightest(scene)
        if peak > LARGEST_HALF:
            return f"POV-Ray's pictures end at {LARGEST_HALF:g}, and this one reaches {peak:g}"
        return out_of_reach(scene)

    def seeded(self, mode: Spec) -> bool:
        """Never: POV-Ray's jitter is a hash of the position."""
        return False

    def render(self, request: Request) -> Rendering:
        """Makes the picture, in one run of the program; a second run, for the time alone, where the first was short.

        `cpu_seconds` and `wall_seconds` are of tracing alone, as povray prints them, in steps of CLOCK_STEP; `repeats`
        counts the frames of both runs, their mean is the cost. The frames stop at MOST_FRAMES, so a small picture is
        known less well than `least_seconds` asks.
        """
        start = time.monotonic()
        size = (request.width, request.height)
        reason = lacks(self, request.scene, request.mode)
        if reason:
            raise Unsupported(reason)
        side = _grid_side(request.mode) or 1
        if side * side * size[0] * size[1] > LARGEST_AREA:
            raise Unsupported(
                f"{request.mode.text} at {size[0]}x{size[1]} needs a canvas of more than {LARGEST_AREA} pixels"
            )
        try:
            text = scene_text(request.scene, size)
        except ValueError as error:
            raise InvalidInput(str(error)) from error
        path = executable()
        try:
            scratch = tempfile.TemporaryDirectory(prefix="aliascope-povray-")
        except OSError as error:
            raise NotWritable(f"no scratch folder for POV-Ray: {error.strerror}") from error
        with scratch as name:
            folder = Path(name)
            options = (*_antialiasing(request.mode), f"+WT{request.threads}")
            job = _Job(path, folder, side * size[0], side * size[1], options, _output_for(request.scene))
            try:
                (folder / "scene.pov").write_text(text)
                (folder / "aliascope.ini").write_text("")  # in place of the system's, which turns the display on
            except OSError as error:
                raise NotWritable(f"{folder}: cannot be written: {error.strerror}") from error
            frames = _run(job, 1, request.time_limit)
            pixels = _box_averaged(_picture(job), side)
            if request.least_seconds > 0.0 and frames[0].cpu_seconds < request.least_seconds:
                wanted = math.ceil(request.least_seconds / max(frames[0].cpu_seconds, CLOCK_STEP)) - 1
                remaining = max(0.0, request.time_limit - (time.monotonic() - start))
                frames += _run(job, min(max(wanted, 1), MOST_FRAMES), remaining)
        return Rendering(pixels, _cost(frames, request.width * request.height), job.output.quantum)


RENDERER = PovRay()


def _grid_side(mode: Spec) -> int | None:
    """k of a regular grid of n = k x k samples, 1 for other modes, None where n is no square."""
    if mode.name != "regular":
        return 1
    n = mode.integer("n")
    side = math.isqrt(n)
    return side if side * side == n else None


def _antialiasing(mode: Spec) -> tuple[str, ...]:
    """The options of a mode. Numbers in fixed notation: povray does not understand +A1e-07."""
    if mode.name in ("none", "regular"):
        return ("-A",)
    jitter = mode.real("jitter")
    return (
        f"+{mode.name.upper()}",
        f"+A{_fixed(mode.real('threshold'))}",
        f"+R{mode.integer('depth')}",
        f"+J{_fixed(jitter)}" if jitter > 0.0 else "-J",
    )


def _fixed(x: float) -> str:
    return np.format_float_positional(x, trim="0")


def _output_for(scene: Scene) -> _Output:
    """PNG for scenes within [0, 1], which it clips to; else EXR, whose half floats have 11 significant bits."""
    peak = brightest(scene)
    if peak <= 1.0:
        return _Output("+FN16", "png", 1.0 / 65535.0)
    return _Output("+FE", "exr", 2.0 ** (math.floor(math.log2(peak)) - 10))


def _run(job: _Job, frames: int, time_limit: float) -> list[Statistics]:
    """Renders so many frames, all equal, and returns what povray says of each. One frame is named picture.<suffix>."""
    name = "picture" if frames == 1 else "frame"
    arguments = [
        "+Iscene.pov",
        f"+O{name}.{job.output.suffix}",
        job.output.option,
        f"+W{job.width}",
        f"+H{job.height}",
        "+BS32",  # the default, stated: what +AM1 draws depends on it
        "-D",
        "-V",
        "File_Gamma=1.0",
        *job.options,
        *(("+KFI1", f"+KFF{frames}") if frames > 1 else ()),
    ]
    statistics = read_statistics(run(job.path, arguments, job.folder, time_limit))
    if len(statistics) != frames:
        raise JobFailed(f"povray printed the statistics of {len(statistics)} pictures instead of {frames}")
    return statistics


def _picture(job: _Job) -> Pixels:
    """The picture that povray left, checked for its size. Raises JobFailed."""
    path = job.folder / f"picture.{job.output.suffix}"
    try:
        pixels = read_image(path)
    except InvalidInput as error:
        what = "left no picture" if not path.exists() else "left a broken picture: " + str(error).partition(": ")[2]
        raise JobFailed(f"povray ended without an error but {what}") from error
    height, width, channels = pixels.shape
    if (width, height, channels) != (job.width, job.height, 3):
        raise JobFailed(
            f"povray left a picture of {width}x{height} pixels and {channels} channels "
            f"instead of {job.width}x{job.height} and 3"
        )
    return pixels


def _box_averaged(pixels: Pixels, side: int) -> Pixels:
    """The means of side x side boxes, summed in double."""
    if side == 1:
        return pixels
    height, width, channels = pixels.shape
    boxes = pixels.reshape(height // side, side, width // side, side, channels)
    means: Pixels = boxes.mean(axis=(1, 3), dtype=np.float64).astype(np.float32)
    return means


def _cost(frames: list[Statistics], pixels: int) -> Cost:
    """The cost of one picture of so many pixels: the counts are the same in every frame, the times are averaged."""
    first = frames[0]
    samples = first.pixels + first.samples
    return Cost(
        samples=samples,
        samples_per_pixel=samples / pixels,
        rays={"camera": first.rays},
        cpu_seconds=sum(frame.cpu_seconds for frame in frames) / len(frames),
        wall_seconds=sum(frame.wall_seconds for frame in frames) / len(frames),
        repeats=len(frames),
    )
