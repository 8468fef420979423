"""POV-Ray 3.7: its own antialiasing methods 1 and 2, no antialiasing, a regular grid of samples, and any pattern of
samples as frames that are averaged.

Pictures come as 16-bit PNG: those brighter than 1, or all darker than DIM, at an exposure that brings them within
[0, 1], a power of two; those brighter than LARGEST_EXPOSURE as half-float EXR, at an exposure too where half floats end
before. The step of either is the picture's quantum. With `exposure=off` light is written as it is.
Persistence of Vision Raytracer, https://www.povray.org; its reference manual, section 3.2.8.5 "Antialiasing options",
names the options; what they do was measured.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from aliascope.errors import InvalidInput, JobFailed, NotWritable, Unsupported
from aliascope.geometry import Array
from aliascope.image import read_image
from aliascope.model import LARGEST_AREA, Scene, by_scene
from aliascope.motion import no_still
from aliascope.records import Cost, Pixels, Rendering
from aliascope.renderers.base import RECENTRE, Request, as_drawn, unable
from aliascope.renderers.povray_frames import Frames, frames_of, looked_at, moments, moved
from aliascope.renderers.povray_glare import LARGEST_HALF, too_bright
from aliascope.renderers.povray_light import Lighting, lighting_of
from aliascope.renderers.povray_limits import out_of_reach
from aliascope.renderers.povray_modes import (
    FORMS,
    allowed_exposure,
    antialiasing,
    exposed,
    grid_side,
    samples_per_pixel,
    seeded,
    too_long,
    unable_mode,
)
from aliascope.renderers.povray_process import Statistics, executable, read_statistics, run, version
from aliascope.renderers.povray_sdl import moving_texts, scene_text
from aliascope.scratch import scratch_folder
from aliascope.specs import Form, Spec

MOST_FRAMES = 500
"""Frames that a run for the time alone renders at most: each takes 0.01 s on the wall, however small it is."""

LEAST_SECONDS = 1e-4
"""CPU time that a frame is taken to last at least, when it is counted how many make a measurement."""

LARGEST_EXPOSURE = 16.0
"""Up to here the step of 16 bits is finer than that of half floats near 1: 2.4e-4 against 9.8e-4."""

DIM = 2.0**-5
"""Of a picture that is nowhere as bright, a step of 1/65535 is more than 2^-11 of the brightest, the most that half
floats round by."""


@dataclass(frozen=True)
class _Output:
    """A file format: its option, its suffix, what colours are divided by in it, and the step between values at the
    brightest."""

    option: str
    suffix: str
    exposure: float
    quantum: float


@dataclass(frozen=True)
class _Job:
    """One program run, but for its frames: the size is that of the canvas. tile: see PovRay."""

    path: str
    folder: Path
    width: int
    height: int
    options: tuple[str, ...]
    output: _Output
    tile: int


class PovRay:
    """The renderer; see `aliascope.renderers.base.Renderer` for what its members promise.

    tile: the side of the squares that it renders one after the other, in pixels, on which what +AM1 draws depends.
    """

    name = "povray"
    title = "POV-Ray"
    native: tuple[str, ...] = ("waits",)
    modes: Mapping[str, Form] = {form.name: form for form in FORMS}
    draws = frozenset(
        {
            *("orthographic", "perspective"),
            *("polygon", "mesh", "disc", "sphere", "plane"),
            *("zone-plate", "checker"),
            *("point light", "directional light", "area light", "disc light", "sphere light"),
            *("lens", "motion", "mesh of frames", "mirror"),
        }
    )
    probe_mode = "am1:depth=9,jitter=0,threshold=0"
    single_mode = "none"
    shifts = True
    absent: Mapping[str, str] = {
        "gloss": "POV-Ray 3.7 mirrors sharply; what blurs its mirrors is a bumpy surface, whose lobe has no formula",
        "diffuse bounces": "POV-Ray's radiosity interpolates between places, an error that more samples leave",
    }

    def __init__(self, tile: int = 32) -> None:
        self.tile = tile

    def versions(self) -> Mapping[str, str]:
        """The version that the povray on the PATH states."""
        return {"povray": version(executable())}

    def unable(self, scene: Scene, mode: Spec) -> str | None:
        """Why the picture would not be this scene: a count that the mode lacks, light or places beyond its range."""
        reason = unable_mode(mode, scene) or too_long(scene, mode, Request.time_limit)
        if reason:
            return reason
        if moving := no_still(scene):
            return f"POV-Ray here draws frames of still scenes: {moving}"
        scene = as_drawn(scene, mode)
        glare = too_bright(scene, _lighting(scene), exposed(mode), scene.view.size)
        return glare or _lost_at_all(scene, _recentred(mode))

    def seeded(self, mode: Spec) -> bool:
        """Only for a randomised sampler of `accumulate`: POV-Ray's own jitter is a hash of the position."""
        return seeded(mode)

    def render(self, request: Request) -> Rendering:
        """Makes the picture, in one run of the program; a second run, for the time alone, where the first was short.

        `cpu_seconds` and `wall_seconds` are of tracing alone, as povray prints them, summed over the frames of a
        picture; `repeats` counts the pictures of both runs, their mean is the cost. The second run has MOST_FRAMES at
        most. Instructions are not counted: those of the program would be of its start, of reading the scene and of
        writing the picture too, which nothing outside of it tells from tracing.
        """
        start = time.monotonic()
        size = (request.width, request.height)
        request = replace(request, scene=as_drawn(request.scene, request.mode))
        _check(self, request)
        frames = moved(frames_of(request.mode, request.seed, request.scene), request.shift)
        output = _output_for(request.scene, frames, request.mode, size)
        count, side = len(frames.weights), grid_side(request.mode) or 1
        path = executable()
        with scratch_folder("povray", "POV-Ray") as folder:
            options = (
                *antialiasing(request.mode, output.exposure),
                *_part(size, frames),
                f"+WT{1 if frames.grid.jitter else request.threads}",
            )
            width, height = (side * (n + abs(more)) for n, more in zip(size, frames.further, strict=True))
            job = _Job(path, folder, width, height, options, output, self.tile)
            _write(folder, request, output.exposure, frames)
            statistics = _run(job, count, request.time_limit)
            drawn = _cut_out(_weighted_mean(job, frames.weights), frames)
            pixels = _box_averaged(drawn, side, output.exposure)
            seconds = sum(frame.cpu_seconds for frame in statistics)
            if seconds < request.least_seconds and count <= MOST_FRAMES:
                wanted = math.ceil(request.least_seconds / max(seconds, LEAST_SECONDS)) - 1
                remaining = max(0.0, request.time_limit - (time.monotonic() - start))
                statistics += _run(job, count * min(max(wanted, 1), MOST_FRAMES // count), remaining, kept=False)
        cost = _cost(statistics, count, request.width * request.height, frames.blur is not None)
        return Rendering(pixels, cost, output.quantum)


RENDERER = PovRay()


@by_scene
def _lighting(scene: Scene) -> Lighting:
    """How bright a picture of the scene may be, in any mode."""
    return lighting_of(scene, looked_at(scene))


@by_scene
def _lost_at_all(scene: Scene, recentred: bool) -> str | None:
    """Why POV-Ray would leave out a part of the scene in some mode, or None."""
    return _lost(scene, looked_at(scene), recentred=recentred)


def _recentred(mode: Spec) -> bool:
    return bool(mode.integer(RECENTRE.name))


def _lost(scene: Scene, frames: Frames, wider: tuple[float, float] = (1.0, 1.0), recentred: bool = True) -> str | None:
    """Why POV-Ray would leave out a part of the scene in one of the frames, or None; see `out_of_reach`."""
    reasons = (out_of_reach(moment, wider, recentred) for moment in moments(scene, frames.times))
    return next(filter(None, reasons), None)


def _write(folder: Path, request: Request, exposure: float, frames: Frames) -> None:
    """Writes what povray reads. Raises InvalidInput for polygons that have no triangles, and NotWritable."""
    scene, size = request.scene, (request.width, request.height)
    try:
        (folder / "aliascope.ini").write_text("")  # in place of the system's, which turns the display on
        (folder / "scene.pov").write_text(scene_text(scene, size, exposure, frames, _recentred(request.mode)))
        for name, text in moving_texts(scene, exposure, frames, _recentred(request.mode)):
            (folder / name).write_text(text)
    except ValueError as error:
        raise InvalidInput(str(error)) from error
    except OSError as error:
        raise NotWritable(f"{folder}: cannot be written: {error.strerror}") from error


def _check(renderer: PovRay, request: Request) -> None:
    """Raises Unsupported for a request that cannot be met."""
    mode, size = request.mode, (request.width, request.height)
    reason = unable(renderer, request.scene, mode) or too_long(request.scene, mode, request.time_limit)
    if reason and size != request.scene.view.size:  # it names pixels
        view = request.scene.view.model_copy(update={"size": size})
        reason = unable(renderer, request.scene.model_copy(update={"view": view}), mode) or reason
    if reason:
        raise Unsupported(reason)
    if request.shift != Request.shift:
        wider, higher = (1.0 + 2.0 * abs(by) / pixels for by, pixels in zip(request.shift, size, strict=True))
        if reason := _lost(request.scene, looked_at(request.scene), (wider, higher), _recentred(mode)):
            raise Unsupported(reason)
    if samples_per_pixel(mode) * size[0] * size[1] > LARGEST_AREA:
        raise Unsupported(f"{mode.text} at {size[0]}x{size[1]} needs a canvas of more than {LARGEST_AREA} pixels")


def _output_for(scene: Scene, frames: Frames, mode: Spec, size: tuple[int, int]) -> _Output:
    """PNG, which clips to [0, 1], so at an exposure; past LARGEST_EXPOSURE EXR, whose half floats have 11 bits.

    Raises Unsupported where the frames come nearer to a light than those that were looked at before."""
    lighting = lighting_of(scene, frames)
    peak = lighting.peak
    if reason := too_bright(scene, lighting, exposed(mode), size):
        raise Unsupported(reason)
    binade = math.ceil(math.log2(peak)) if peak > 0.0 else 0
    exposure = 1.0
    if not exposed(mode):
        as_png = peak <= 1.0
    else:
        as_png = 2.0**binade <= LARGEST_EXPOSURE
        if as_png and (peak > 1.0 or 0.0 < peak < DIM):
            exposure = allowed_exposure(mode, 2.0**binade)
        elif peak > LARGEST_HALF:
            exposure = 2.0 ** (binade - 15)
    if as_png:
        return _Output("+FN16", "png", exposure, exposure / 65535.0)
    return _Output("+FE", "exr", exposure, 2.0 ** (math.floor(math.log2(peak)) - 10))


def _run(job: _Job, frames: int, time_limit: float, kept: bool = True) -> list[Statistics]:
    """Renders so many frames and returns what povray says of each; their files are those of `_names`, where they are
    kept."""
    output = [f"+O{'picture' if frames == 1 else 'frame'}.{job.output.suffix}", job.output.option]
    arguments = [
        "+Iscene.pov",
        *(output if kept else ["-F"]),
        f"+W{job.width}",
        f"+H{job.height}",
        f"+BS{job.tile}",
        "-D",
        "-V",
        "File_Gamma=1.0",
        *job.options,
        *(("+KFI1", f"+KFF{frames}") if frames > 1 else ()),
    ]
    statistics = read_statistics(run(job.path, arguments, job.folder, time_limit, frames))
    if len(statistics) != frames:
        raise JobFailed(f"povray printed the statistics of {len(statistics)} pictures instead of {frames}")
    return statistics


def _names(frames: int) -> list[str]:
    """povray numbers frames from 1, all with as many digits as the last."""
    return ["picture"] if frames == 1 else [f"frame{i:0{len(str(frames))}d}" for i in range(1, frames + 1)]


def _weighted_mean(job: _Job, weights: Array) -> Array | Pixels:
    """The frames that povray left, summed in double. Raises JobFailed for one that is missing or broken."""
    if len(weights) == 1 and weights[0] == 1.0:
        return _picture(job, *_names(1))
    mean = np.zeros((job.height, job.width, 3))
    for name, weight in zip(_names(len(weights)), weights, strict=True):
        mean += weight * _picture(job, name)
    return mean


def _picture(job: _Job, name: str) -> Pixels:
    """One picture that povray left, checked for its size. Raises JobFailed."""
    path = job.folder / f"{name}.{job.output.suffix}"
    try:
        pixels = read_image(path)
    except InvalidInput as error:
        what = f"left no {name}" if not path.exists() else f"left a broken {name}: " + str(error).partition(": ")[2]
        raise JobFailed(f"povray ended without an error but {what}") from error
    height, width, channels = pixels.shape
    if (width, height, channels) != (job.width, job.height, 3):
        raise JobFailed(
            f"povray left a {name} of {width}x{height} pixels and {channels} channels "
            f"instead of {job.width}x{job.height} and 3"
        )
    return pixels


def _part(size: tuple[int, int], frames: Frames) -> Iterator[str]:
    """The options that trace of a larger canvas the picture alone: its first or last column and row, from 1. An end of
    1 POV-Ray reads as a share, which is all of them: so it is stated as a share that ends between 1 and 2."""
    for pixels, more, axis in zip(size, frames.further, "CR", strict=True):
        if more > 0:
            yield f"+S{axis}{more + 1}"
        elif more < 0:
            yield f"+E{axis}{pixels if pixels > 1 else 1.5 / (1 - more)}"


def _cut_out(canvas: Array | Pixels, frames: Frames) -> Array | Pixels:
    """The picture, which is a part of its canvas."""
    columns, rows = (slice(more, None) if more >= 0 else slice(more) for more in frames.further)
    return canvas[rows, columns]


def _box_averaged(pixels: Array | Pixels, side: int, exposure: float) -> Pixels:
    """The means of side x side boxes, in double to the last, times the exposure."""
    height, width, channels = pixels.shape
    boxes = pixels.reshape(height // side, side, width // side, side, channels)
    means: Pixels = (exposure * boxes.mean(axis=(1, 3), dtype=np.float64)).astype(np.float32)
    return means


def _cost(statistics: list[Statistics], frames: int, pixels: int, blurred: bool) -> Cost:
    """The cost of one picture of so many frames and pixels, over as many pictures as there are statistics for.

    blurred: by POV-Ray's own lens, whose rays it does not count as samples.
    """
    repeats = len(statistics) // frames
    reflected = sum(frame.reflected for frame in statistics[:frames])
    seen = sum(frame.rays for frame in statistics[:frames]) - reflected
    samples = seen if blurred else sum(frame.pixels + frame.samples for frame in statistics[:frames])
    return Cost(
        samples=samples,
        samples_per_pixel=samples / pixels,
        rays={"camera": seen, **({"reflection": reflected} if reflected else {})},
        cpu_seconds=sum(frame.cpu_seconds for frame in statistics) / repeats,
        wall_seconds=sum(frame.wall_seconds for frame in statistics) / repeats,
        repeats=repeats,
    )
