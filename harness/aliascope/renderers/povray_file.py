"""A user's own .pov file, rendered by POV-Ray as it is: in its folder, with its includes, with options alone.

Pictures come as 16-bit PNG, clipped to [0, 1] as a user's are. The rays of a regular grid are the pixels of a picture k
times as large; they come as half floats, which are not clipped, and are averaged as POV-Ray averages: in the scene's
own colours, whose gamma (`assumed_gamma`) is measured, not read.
"""

from __future__ import annotations

import functools
import math
import re
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aliascope.bounded import as_shown, read_bytes, steers
from aliascope.errors import InvalidInput, JobFailed
from aliascope.geometry import Array
from aliascope.image import opened, read_image, read_rows
from aliascope.records import Pixels
from aliascope.renderers import confinement
from aliascope.renderers.povray_modes import antialiasing
from aliascope.renderers.povray_process import Others, RunFailed, Statistics, executable, read_statistics, run
from aliascope.scratch import scratch_folder
from aliascope.specs import Spec

LARGEST_FILE = 64 << 20
"""Bytes of a scene's text, with the files beside it that it includes."""
MOST_TEXTS = 1000
"""Of those files."""

SYSTEM_INI = Path("/etc/povray/3.7/povray.ini")
"""Where POV-Ray's own include files are, for one that has its settings from the system."""

LEAST_LEFT, LEFT_A_PIXEL = 64 << 20, 64
"""Bytes that a scene may leave in a file: so many, and so many more for each pixel, of which POV-Ray needs 20."""

HALF_STEP = 2.0**-11
"""Between half floats, relative to the larger of two neighbouring powers of two."""

AS_WRITTEN = 0.004
"""RMS by which a PNG and linear light differ at least, where the PNG has the scene's colours as they are."""

SRGB = "srgb"
"""In place of the number of a gamma: the curve of sRGB."""

# Bounded, and whole where they do not end, so that no text takes longer than its length.
_COMMENTS = re.compile(r'/\*.*?(?:\*/|\Z)|//[^\n]*|"(?:\\.|[^"\\\n])*+(?:"|(?=\n)|\\?\Z)', re.DOTALL)
_INCLUDE = re.compile(r'#\s{0,40}include\s{1,40}"([^"\n]{1,4096})"')
_WRITES = re.compile(r"#\s{0,40}fopen\s{1,40}\w{1,200}\s{1,40}[^\n#]{0,400}?\b(?:write|append)\b|\bsave_file\b")
_MESSAGE = re.compile(r"File '(?P<file>[^']{1,4096})' line (?P<line>\d{1,9}): (?P<text>(?:Parse|Fatal) Error:.*)")
_SECONDS = re.compile(r"(?:Parse|Bounding|Photon) Time:.{0,200}?\((\d{1,9}(?:\.\d{1,9})?) seconds\)")
_NOT_FOUND = re.compile(r"could not find|cannot (?:open|find)|not permitted|no such file", re.IGNORECASE)


@dataclass(frozen=True)
class PovFile:
    """A scene of a user. `notes` are what has to be known of it before anything is measured."""

    path: Path
    libraries: tuple[str, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Drawn:
    """A picture (height, width, 3) float32 and what it cost; `parse_seconds` are of CPU, before the trace."""

    pixels: Pixels
    statistics: Statistics
    parse_seconds: float


@dataclass(frozen=True)
class Colours:
    """The colours that POV-Ray averages, against the values of its files: linear light to the power 1 / gamma.

    `as_written`: the file's text asks for no gamma at all (before `#version 3.7`), so that a PNG holds these colours
    themselves. `residual` is the RMSE with which this explains a picture that POV-Ray averaged.
    """

    gamma: float | str = 1.0
    as_written: bool = False
    residual: float = 0.0

    def averaged(self, light: Array) -> Array:
        """The colours that are averaged, of linear light."""
        if self.gamma == 1.0:
            return light
        size = np.abs(light)
        if self.gamma == SRGB:
            curve = np.where(size <= 0.0031308, 12.92 * size, 1.055 * size ** (1.0 / 2.4) - 0.055)
        else:
            curve = size ** (1.0 / float(self.gamma))
        return np.copysign(curve, light)

    def light(self, averaged: Array) -> Array:
        """Linear light, of the colours that are averaged."""
        if self.gamma == 1.0:
            return averaged
        size = np.abs(averaged)
        if self.gamma == SRGB:
            linear = np.where(size <= 0.04045, size / 12.92, ((size + 0.055) / 1.055) ** 2.4)
        else:
            linear = size ** float(self.gamma)
        return np.copysign(linear, averaged)

    def in_file(self, averaged: Array) -> Array:
        """What a PNG of a mode would hold, without rounding."""
        return np.clip(averaged if self.as_written else self.light(averaged), 0.0, 1.0)

    def told(self) -> str:
        """What is measured, in words; empty where it is linear light that was averaged as such."""
        gamma = "the curve of sRGB" if self.gamma == SRGB else f"gamma {self.gamma:.2g}"
        if self.as_written:
            return "the file asks for no gamma (assumed_gamma), so errors are of the values as POV-Ray writes them"
        if self.gamma == 1.0:
            return ""
        return (
            f"the scene's colours have {gamma} (measured), and POV-Ray averages them as they are, so the reference "
            "does; errors are of linear light"
        )


def open_file(path: Path) -> PovFile:
    """Looks at a scene before POV-Ray does. Raises InvalidInput where it is not there, writes files, or has no camera.

    What its text alone tells is looked for in the file, and in the files beside it that it includes.
    """
    _check_place(path)
    texts = _texts(path)
    for name, text in texts:
        code = _COMMENTS.sub(_blank, text)
        if found := _WRITES.search(code):
            line = code.count("\n", 0, found.start())
            written = " ".join(text.split("\n")[line].split())[:100]
            raise InvalidInput(
                f"{name}:{line + 1}: the scene writes files ({written}), which a sweep would do "
                "again for each of its pictures: take that out of a copy"
            )
    if not any("camera" in text.lower() for _, text in texts):
        raise InvalidInput(f"{path}: the scene has no camera")
    notes = []
    protection = confinement.protection()
    if not protection.files:
        notes.append(f"the scene, which is a program, was held by {protection.told}")
    if any(re.search(r"\b(?:clock|frame_number)\b", _COMMENTS.sub("", text)) for _, text in texts):
        notes.append("the scene moves with the clock: what was measured is its picture at clock 0")
    return PovFile(path.absolute(), library_paths(), tuple(notes))


def _blank(found: re.Match[str]) -> str:
    """A comment or a string with nothing in it, on as many lines."""
    return "\n" * found[0].count("\n") if found[0].startswith("/") else '""'


UNNAMEABLE = "\"'=;"
"""What POV-Ray cannot have in the name of a scene."""


def _check_place(path: Path) -> None:
    """Raises InvalidInput for a scene whose folder has the user's whole home in it: all of that could be read; and for
    one whose name would be more than a name in an ini file."""
    if steers(path.name) or any(each in path.name for each in UNNAMEABLE):
        raise InvalidInput(f"{as_shown(str(path))}: no name for an ini file, which sweep.ini is: rename the scene")
    folder = path.absolute().parent.resolve()
    try:
        home = Path.home().resolve()
    except RuntimeError:  # nobody knows this user, who has none
        home = Path("/")
    if home != Path("/") and home.is_relative_to(folder):
        raise InvalidInput(
            f"{path}: a .pov file is a program that can read all of the folder in which it lies, and {folder} has "
            "your home folder in it, or is that: move the scene into a folder of its own"
        )


def _texts(path: Path) -> list[tuple[Path, str]]:
    """The text of a scene, then those of the files beside it that it includes; those of POV-Ray's own are left out, and
    those that do not lie in its folder, which it cannot read."""
    folder = path.absolute().parent.resolve()
    waiting, seen, size = [path], {path.resolve()}, 0
    texts: list[tuple[Path, str]] = []
    while waiting:
        current = waiting.pop()
        data = read_bytes(current, LARGEST_FILE, "scene")
        size += len(data)
        if size > LARGEST_FILE or len(texts) >= MOST_TEXTS:
            raise InvalidInput(
                f"{path}: a scene and what it includes have at most {MOST_TEXTS} files and {LARGEST_FILE >> 20} MiB"
            )
        text = data.decode("latin-1")
        texts.append((current, text))
        for name in _INCLUDE.findall(text):
            # POV-Ray looks for all of them from the folder in which it runs.
            beside = folder / name
            with suppress(OSError, ValueError):  # a name that no file can have
                place = beside.resolve()
                if place.is_relative_to(folder) and place not in seen and place.is_file():
                    seen.add(place)
                    waiting.append(beside)
    return texts


@functools.cache
def library_paths() -> tuple[str, ...]:
    """The folders of POV-Ray's own include files, as the system's ini file names them."""
    try:
        text = SYSTEM_INI.read_text(encoding="latin-1")
    except OSError:
        return ()
    return tuple(re.findall(r'^\s*Library_Path\s*=\s*"?([^"\n;]+?)"?\s*(?:;.*)?$', text, re.MULTILINE | re.IGNORECASE))


def options_of(mode: Spec) -> tuple[str, ...]:
    """The options of a mode, as a user types them."""
    return antialiasing(mode, 1.0)


def draw(
    file: PovFile,
    size: tuple[int, int],
    options: Sequence[str],
    time_limit: float,
    threads: int = 1,
    unclipped: bool = False,
) -> Drawn:
    """One picture: linear light, where the scene has a gamma; `unclipped`: in half floats, of linear light always.

    Raises InvalidInput for a scene that POV-Ray does not understand, JobFailed, TimeLimit, NotAvailable.
    """
    with _run(file, size, options, time_limit, threads, unclipped) as (path, output):
        return Drawn(_whole(path, size), _last(output), _parse_seconds(output))


def grid(
    file: PovFile,
    size: tuple[int, int],
    side: int,
    parts: Sequence[int],
    colours: Colours,
    time_limit: float,
    threads: int,
) -> tuple[dict[int, Array], Pixels, float]:
    """Regular grids of rays: the mean of each pixel's side x side, and of the sparser grids that lie in it.

    parts: their sides, which divide `side` by an odd number. Returns the means (height, width, 3) by side, in the
    colours that POV-Ray averages, not clipped; the light of the rays through the pixels' centres, where `side` is odd,
    else empty; and the RMS of what the rounding of a ray to half floats does to a value that many rays share.
    """
    width, height = size
    means = {part: np.empty((height, width, 3)) for part in (side, *parts)}
    centres = np.empty((height, width, 3), np.float32) if side % 2 else np.empty((0, 0, 3), np.float32)
    rounded = 0.0
    canvas = (width * side, height * side)
    with _run(file, canvas, ("-A",), time_limit, threads, True) as (path, _), opened(path) as image:
        if (image.spec().width, image.spec().height) != canvas:
            raise JobFailed("povray left a picture of another size than it was asked for")
        for y in range(height):
            rays = read_rows(image, path, y * side, side)[..., :3].astype(np.float64)
            if not np.isfinite(rays).all():
                raise JobFailed("povray left colours that are no numbers")
            if side % 2:
                centres[y] = rays[side // 2, side // 2 :: side]
            shown = np.clip(rays, 2.0**-14, 1.0)
            rounded += float((2.0 ** (2.0 * np.floor(np.log2(shown)))).mean())
            averaged = colours.averaged(rays).reshape(side, width, side, 3)
            for part, mean in means.items():
                step = side // part
                mean[y] = averaged[step // 2 :: step, :, step // 2 :: step].mean(axis=(0, 2))
    # Steps of half floats are uniform; a part of a picture in one colour has one error for all of its rays.
    return means, centres, HALF_STEP * math.sqrt(rounded / height / 12.0)


@dataclass(frozen=True)
class Character:
    """What small pictures of a scene tell: its colours; the RMS difference of two pictures that should be the same, and
    that of rays through the same places in canvases of different sizes."""

    colours: Colours
    differs_by_run: float
    differs_by_size: float


def character_of(file: PovFile, size: tuple[int, int], time_limit: float, threads: int) -> Character:
    """Four small pictures of `size`, in which POV-Ray averages 3 x 3 rays and their centre, and the rays themselves."""
    last = time.monotonic() + time_limit

    def drawn(options: Sequence[str], more: int = 1, on: int = 1, unclipped: bool = True) -> Array:
        left = max(0.1, last - time.monotonic())
        shape = (size[0] * more, size[1] * more)
        return draw(file, shape, options, left, on, unclipped).pixels.astype(np.float64)

    light, again = drawn(("-A",)), drawn(("-A",), on=max(2, threads))
    written = drawn(("-A",), unclipped=False)
    rays = drawn(("-A",), more=3)
    averaged = drawn(("+AM1", "+A0.0", "+R3", "-J"))
    as_written = rms(written - np.clip(light, 0.0, 1.0)) > AS_WRITTEN
    colours = _colours(rays, averaged, as_written)
    return Character(
        colours,
        rms(np.clip(light, 0.0, 1.0) - np.clip(again, 0.0, 1.0)),
        rms(np.clip(light, 0.0, 1.0) - np.clip(rays[1::3, 1::3], 0.0, 1.0)),
    )


def rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


def _colours(rays: Array, averaged: Array, as_written: bool) -> Colours:
    """The gamma that makes an average of the rays what POV-Ray made of them."""
    height, width, _ = averaged.shape
    wanted = np.clip(averaged, 0.0, 1.0)

    def residual(gamma: float | str) -> float:
        colours = Colours(gamma)
        boxes = colours.averaged(rays).reshape(height, 3, width, 3, 3)
        mean = (9.0 * boxes.mean(axis=(1, 3)) + boxes[:, 1, :, 1]) / 10.0
        return rms(np.clip(colours.light(mean), 0.0, 1.0) - wanted)

    if as_written:
        return Colours(SRGB, True, residual(SRGB))
    from scipy.optimize import minimize_scalar  # takes a while to load

    fitted = minimize_scalar(lambda x: residual(math.exp(x)), bounds=(math.log(0.4), math.log(4.0)), method="bounded")
    choices: list[float | str] = [1.0, 2.2, SRGB, float(round(math.exp(fitted.x), 2))]
    least = min(residual(gamma) for gamma in choices)
    # The first that explains the picture as well as any, up to what half floats round.
    gamma = next(g for g in choices if residual(g) <= 1.1 * least + 0.25 * HALF_STEP)
    return Colours(gamma, False, residual(gamma))


@contextmanager
def _run(
    file: PovFile, size: tuple[int, int], options: Sequence[str], time_limit: float, threads: int, unclipped: bool
) -> Iterator[tuple[Path, str]]:
    """Runs POV-Ray, and gives the picture's path, while it is there, and what was printed."""
    with scratch_folder("sweep", "POV-Ray") as folder:
        (folder / "aliascope.ini").write_text("".join(f'Library_Path="{each}"\n' for each in file.libraries))
        picture = folder / ("picture.exr" if unclipped else "picture.png")
        arguments = [
            f"+I{file.path.name}",
            f"+O{picture}",
            "+FE" if unclipped else "+FN16",
            f"+W{size[0]}",
            f"+H{size[1]}",
            "+BS32",
            f"+WT{threads}",
            "-D",
            "-V",
            "File_Gamma=1.0",
            *options,
        ]
        try:
            output = run(executable(), arguments, folder, time_limit, others=_others(file, size, threads))
        except RunFailed as error:
            raise _told(file, error) from error
        yield picture, output


def _others(file: PovFile, size: tuple[int, int], threads: int) -> Others:
    """What may be read for a scene, and how much may be left: the picture, and what POV-Ray keeps of it meanwhile."""
    most = LEAST_LEFT + LEFT_A_PIXEL * size[0] * size[1]
    return Others(file.path.parent, tuple(map(Path, file.libraries)), most, threads)


def _told(file: PovFile, error: RunFailed) -> InvalidInput | JobFailed:
    """POV-Ray's own message, with its file and line, which it wraps."""
    joined = re.sub(r"\n ", " ", error.output)
    if found := _MESSAGE.search(joined):
        where, text = file.path.parent / found["file"], " ".join(found["text"].split())
        if "bad_alloc" in text:
            text = str(error)
        elif _NOT_FOUND.search(text):
            text += " (a scene reads what lies in its folder and below, and POV-Ray's own files)"
        return InvalidInput(f"{where}:{found['line']}: {text}")
    return JobFailed(f"{file.path}: {error}")


def _whole(path: Path, size: tuple[int, int]) -> Pixels:
    """Raises JobFailed for a picture that is missing, broken, or of another size."""
    try:
        pixels = read_image(path)
    except InvalidInput as error:
        raise JobFailed(f"povray ended without an error but left no whole picture: {error}") from error
    if pixels.shape != (size[1], size[0], 3):
        raise JobFailed(f"povray left a picture of the shape {pixels.shape} instead of {(size[1], size[0], 3)}")
    if not np.isfinite(pixels).all():
        raise JobFailed("povray left colours that are no numbers")
    return pixels


def _last(output: str) -> Statistics:
    found = read_statistics(output)
    if not found:
        raise JobFailed("povray printed no statistics of its picture")
    return found[-1]


def _parse_seconds(output: str) -> float:
    """Of the wall: what is not the trace, and is there for each picture alike (parsing, bounding, photons)."""
    return sum(float(seconds) for seconds in _SECONDS.findall(output))
