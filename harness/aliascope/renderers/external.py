"""Any program as a renderer, as a TOML file describes it (`external_file`)."""

from __future__ import annotations

import functools
import hashlib
import math
import os
import re
import shutil
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from aliascope import image
from aliascope.errors import InvalidInput, JobFailed, NotAvailable, Unsupported
from aliascope.model import Scene
from aliascope.records import Cost, Pixels, Rendering
from aliascope.renderers import process
from aliascope.renderers.base import Request, lacks
from aliascope.renderers.external_file import PLACEHOLDER, File, placeholders, read
from aliascope.renderers.external_scenes import FORMATS
from aliascope.scratch import scratch_folder
from aliascope.specs import Form, Spec

VERSION_TIME_LIMIT = 60.0

MOST_WALL = 20.0
"""A program is run again for its time for so many times the CPU time that is wanted, on the wall: most of a run may be
its start, and what it says of its time may be 0."""

QUANTA = {"uint8": 1.0 / 255.0, "uint16": 1.0 / 65535.0, "half": 2.0**-11}
"""The steps between the values of a picture near 1, by how it is stored; of others 0."""

SRGB_SLOPE = 2.4 / 1.055
"""Of the sRGB curve at 1: by how much its steps are larger in linear values."""


class External:
    """A program as a renderer; see `aliascope.renderers.base.Renderer` for what its members promise."""

    native: tuple[str, ...] = ()
    absent: Mapping[str, str] = {}

    def __init__(self, file: File) -> None:
        self._file, contents = file, file.contents
        self.name, self.title = contents.name, contents.title
        self.modes: Mapping[str, Form] = file.forms
        said = frozenset.intersection(*(FORMATS[name].draws for name in file.formats))
        self.draws = said if contents.draws is None else said & frozenset(contents.draws)
        quick = contents.profiles.quick
        self.profiles: Mapping[str, tuple[str, ...]] = {"quick": quick, "full": contents.profiles.full or quick}
        self.probe_mode, self.single_mode = contents.probe or quick[-1], contents.single or quick[0]
        commands = [file.command_of(mode) for mode in self.modes]
        self.shifts = all(
            any(FORMATS[name].shifts for name in file.formats) or "shift.x" in placeholders(command)
            for command in commands
        )

    @property
    def path(self) -> Path:
        """Of the file that describes it."""
        return self._file.path

    def versions(self) -> Mapping[str, str]:
        """What the program states, the hash of the file and of those beside it that it names, and what is timed."""
        contents = self._file.contents
        for mode in self.modes:
            self._program(self._file.command_of(mode))
        found = {self.name: _version(self), f"{self.name} file": self._digest()}
        if contents.time == "cpu":
            found[f"{self.name} time"] = (
                "CPU time of the whole process, its start and the reading of the scene included"
            )
        return found

    def unable(self, scene: Scene, mode: Spec) -> str | None:
        """What the file of the scene has no form for."""
        return next(filter(None, (FORMATS[name].unable(scene) for name in self._file.formats)), None)

    def seeded(self, mode: Spec) -> bool:
        return self._file.seeded(mode.name)

    def render(self, request: Request) -> Rendering:
        """Runs the program, and again while its CPU time adds up to less than is wanted, but for MOST_WALL; the first
        picture is kept."""
        if reason := lacks(self, request.scene, request.mode):
            raise Unsupported(reason)
        if request.shift != Request.shift and not self.shifts:
            raise Unsupported(f"{self.title}: the film cannot be moved: there is no {{shift.x}} in its command")
        begun = time.monotonic()
        with scratch_folder(self.name, self.title) as folder:
            out = folder / f"out.{self._file.contents.output.format}"
            words = self._words(request, folder, out)
            try:
                for each in self._file.formats:
                    FORMATS[each].write(folder / each, request)
            except ValueError as error:
                raise InvalidInput(str(error)) from error
            runs = [self._run(words, folder, request.time_limit)]
            pixels, quantum = self._picture(out, (request.width, request.height))
            seconds = [self._seconds(runs[0])]
            longest = min(request.time_limit, MOST_WALL * request.least_seconds)
            while sum(seconds) < request.least_seconds:
                remaining = longest - (time.monotonic() - begun)
                if remaining < 2.0 * runs[0].wall_seconds:
                    break
                runs.append(self._run(words, folder, remaining))
                seconds.append(self._seconds(runs[-1]))
        samples, per_pixel = self._samples(request, runs[0].text)
        cost = Cost(
            samples=samples,
            samples_per_pixel=per_pixel,
            rays={},
            cpu_seconds=sum(seconds) / len(runs),
            wall_seconds=sum(run.wall_seconds for run in runs) / len(runs),
            repeats=len(runs),
        )
        return Rendering(pixels, cost, quantum)

    def _program(self, command: tuple[str, ...]) -> str:
        """The path of the program of a command. Raises NotAvailable."""
        first = _filled(command[0], self._places())
        path = shutil.which(first)
        if path is None:
            where = f"there is no {first}" if "/" in first else f"there is no {first} on the PATH"
            raise NotAvailable(f"{self.title} is not installed: {where} ({self._file.path})")
        return str(Path(path).absolute())

    def _places(self) -> dict[str, str]:
        return {"folder": str(self._file.path.parent.absolute()), "python": sys.executable}

    def _words(self, request: Request, folder: Path, out: Path) -> list[str]:
        """The command of a request."""
        mode = request.mode
        command = self._file.command_of(mode.name)
        values = {
            **self._places(),
            **{name: str(folder / name) for name in FORMATS},
            **{f"mode.{key}": _text(value) for key, value in mode.values.items()},
            "width": str(request.width),
            "height": str(request.height),
            "samples": str(_count(mode) or 1),
            "seed": str(request.seed),
            "threads": str(request.threads),
            "out": str(out),
            "mode": mode.name,
            "shift.x": repr(float(request.shift[0])),
            "shift.y": repr(float(request.shift[1])),
        }
        return [self._program(command), *(_filled(word, values) for word in command[1:])]

    def _run(self, words: list[str], folder: Path, time_limit: float) -> process.Ended:
        ended = process.run(words, folder, time_limit, os.environ)
        if ended.status != 0:
            raise JobFailed(process.complaint(Path(words[0]).name, ended))
        return ended

    def _picture(self, path: Path, size: tuple[int, int]) -> tuple[Pixels, float]:
        """The picture that was left, in linear values, and its step. Raises JobFailed."""
        try:
            with image.opened(path) as opened:
                stored = str(opened.spec().format)
            pixels = image.read_image(path)
        except InvalidInput as error:
            what = "left no picture" if not path.exists() else "left a broken picture: " + str(error).partition(": ")[2]
            raise JobFailed(f"{self.name} ended without an error but {what}") from error
        height, width, channels = pixels.shape
        if (width, height) != size or channels not in (3, 4):
            raise JobFailed(
                f"{self.name} left a picture of {width}x{height} pixels and {channels} channels "
                f"instead of {size[0]}x{size[1]} and 3"
            )
        pixels = np.ascontiguousarray(pixels[:, :, :3])
        if not np.isfinite(pixels).all():
            y, x, _ = np.argwhere(~np.isfinite(pixels))[0].tolist()
            raise JobFailed(f"{self.name} left a picture that is not finite, first at x = {x}, y = {y}")
        quantum = QUANTA.get(stored, 0.0)
        if self._file.contents.output.values == "srgb":
            return image.decode_srgb(pixels), SRGB_SLOPE * quantum
        return pixels, quantum

    def _seconds(self, ended: process.Ended) -> float:
        """What a run took, as the file says it is read."""
        pattern = self._file.contents.time
        if pattern == "cpu":
            return ended.cpu_seconds
        number, unit = self._number(pattern, ended.text, "time")
        return number * (1e-3 if unit == "ms" else 1.0)

    def _samples(self, request: Request, text: str) -> tuple[int, float]:
        """All samples of a picture, and those of a pixel: what the program prints, or the mode's count."""
        pixels = request.width * request.height
        if self._file.contents.samples is None:
            count = _count(request.mode) or 1
            return count * pixels, float(count)
        number, unit = self._number(self._file.contents.samples, text, "samples")
        return (round(number), number / pixels) if unit == "all" else (round(number * pixels), number)

    def _number(self, pattern: str, text: str, what: str) -> tuple[float, str]:
        """The last number of a pattern in what was printed, and the name of its group. Raises JobFailed."""
        found = [*re.finditer(pattern, text)]
        if not found:
            raise JobFailed(f"{self.name} printed no {what} as in its file: {process.last_lines(text)}")
        name, value = next((name, value) for name, value in found[-1].groupdict().items() if value is not None)
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not 0.0 <= number < math.inf:
            raise JobFailed(f'{self.name} printed {what} that are no number: "{value}"')
        return number, name

    def _digest(self) -> str:
        """Of the file, and of files in its folder that its commands name."""
        digest = hashlib.sha256(self._file.sha256.encode())
        words = {word for mode in self.modes for word in self._file.command_of(mode) if word.startswith("{folder}/")}
        for word in sorted(words):
            path = Path(_filled(word, self._places()))
            if path.is_file():
                digest.update(path.read_bytes())
        return digest.hexdigest()[:16]

    def stated_version(self) -> str:
        """What the program says of itself. Raises NotAvailable."""
        version = self._file.contents.version
        if version is None:
            return "unknown"
        words = [self._program(version.command), *(_filled(word, self._places()) for word in version.command[1:])]
        try:
            ended = process.run(words, self._file.path.parent.absolute(), VERSION_TIME_LIMIT, os.environ)
        except JobFailed as error:
            raise NotAvailable(f"{self.title} does not start: {error}") from None
        if ended.status != 0:
            raise NotAvailable(f"{self.title} does not start: {process.complaint(Path(words[0]).name, ended)}")
        found = re.search(version.pattern, ended.text)
        if found is None:
            raise NotAvailable(f"{self.title} does not state a version: {process.last_lines(ended.text)}")
        return found[1]


@functools.cache
def _version(renderer: External) -> str:
    return renderer.stated_version()


def load(path: str | Path) -> External:
    """The renderer that a TOML file describes. Raises InvalidInput."""
    return External(read(Path(path)))


def _filled(word: str, values: Mapping[str, str]) -> str:
    """A word of a command, each placeholder by its value; what is none stays as it is."""
    return PLACEHOLDER.sub(lambda found: values.get(found[1], found[0]), word)


def _count(mode: Spec) -> int | None:
    """The samples of a pixel that a mode states."""
    return next((mode.integer(key.name) for key in mode.form.keys if key.is_count), None)


def _text(value: int | float | str) -> str:
    return repr(value) if isinstance(value, float) else str(value)
