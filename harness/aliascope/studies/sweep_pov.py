"""A sweep over a user's .pov file: its reference, and the grid of POV-Ray's antialiasing settings."""

from __future__ import annotations

import functools
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from aliascope import renderers
from aliascope.errors import InvalidInput, JobFailed, Unsupported
from aliascope.geometry import Array
from aliascope.records import Cost, Pixels
from aliascope.references import Reference
from aliascope.renderers import povray_file
from aliascope.renderers.povray_file import Character, Drawn, PovFile, rms
from aliascope.renderers.process import TimeLimit
from aliascope.specs import Spec
from aliascope.studies.sweep_search import Candidate, Measured
from aliascope.workers import Task, Workers

SIDES = (27, 21, 15)
"""Of the reference's grid of rays: odd, so that one goes through the pixel's centre, and with grids in it whose sides
are a third and less. LEAST_SIDE where there is time for no more."""
LEAST_SIDE = 12
PARTS = {27: (9, 3), 21: (7, 3), 15: (5, 3), 12: (4,)}
"""Sides of the grids within it that its error is found from."""

REFERENCE_SHARE, LARGEST_REFERENCE_SHARE = 0.2, 0.55
"""Of the budget for the reference, as foretold: of any side, and of the least."""

LARGEST_CANVAS = 150_000_000
"""Rays of a reference. POV-Ray keeps 20 bytes for each in a file."""

THRESHOLDS = (0.0, 0.003, 0.01, 0.03, 0.1, 0.2, 0.3, 0.6)
DEPTHS: Mapping[str, tuple[int, ...]] = {"am1": (2, 3, 4, 5, 6, 7, 8, 9), "am2": (1, 2, 3, 4, 5)}
"""One more level of +AM2 has 1,089 samples a pixel, more than the reference."""

COARSE_THRESHOLDS = (0.0, 0.03, 0.3)
COARSE_DEPTHS: Mapping[str, tuple[int, ...]] = {"am1": (2, 3, 5, 9), "am2": (2, 3, 4)}

LEAST_TIMED = 0.1
"""Seconds of CPU that a timed run lasts, in one picture or several."""

SMALL = 8
"""The pictures that a scene is first looked at in have a side of one part in so many."""


@dataclass(frozen=True)
class Judge:
    """The reference. `mean` are the colours that POV-Ray averages, not clipped; `error` the RMS that the reference may
    be off, of which `of_grid` is that of the grid, `rounding` that of half floats, and `of_size` what the scene draws
    otherwise in a canvas of another size."""

    side: int
    mean: Array
    pixels: Pixels
    error: float
    of_grid: float
    rounding: float
    of_size: float
    slope: float

    @property
    def reference(self) -> Reference:
        return Reference(
            pixels=self.pixels,
            exact=self.pixels.astype(np.float64),
            error=0.0,
            method=f"regular grid of {self.side} x {self.side} rays a pixel",
            standard_error=np.full(self.pixels.shape, self.error),
        )

    def told(self) -> str:
        return (
            f"regular grid of {self.side} x {self.side} rays a pixel, averaged unclipped; off by {self.error:.2g} "
            f"(RMS), as told by the sparser grids in it, whose errors fall as side^-{self.slope:.2g}"
        )


@dataclass
class Prepared:
    """A scene that is ready to be swept. `plain_seconds` is the CPU time without antialiasing, `parse_seconds` what
    comes before the trace of each picture, `notes` what is to be known."""

    file: PovFile
    size: tuple[int, int]
    character: Character
    plain: Drawn
    judge: Judge
    parse_seconds: float
    notes: list[str] = field(default_factory=list)


Tell = Callable[[str], None]
Made = TypeVar("Made")


def prepare(
    file: PovFile,
    size: tuple[int, int],
    budget: float,
    left: Callable[[], float],
    tell: Tell,
    begin: Callable[[], None],
) -> Prepared:
    """Looks at a scene in small pictures, and makes its reference. `left`: seconds of the budget; `begin` is called
    when nothing is timed any more but by POV-Ray itself.

    Raises InvalidInput for a scene that cannot be understood, or not be done within the budget at this size.
    """
    threads = len(os.sched_getaffinity(0))
    tell("a small picture")
    small = (max(16, size[0] // SMALL), max(12, size[1] // SMALL))
    begun = time.monotonic()
    first = _within(file, lambda: povray_file.draw(file, small, ("-A",), 0.3 * left()), size, budget)
    wall = time.monotonic() - begun
    ratio = size[0] * size[1] / (small[0] * small[1])
    # Half of what is foretold from so little: it is to find what is out of reach, the whole picture decides.
    _check(size, budget, wall + 0.5 * first.statistics.wall_seconds * ratio * LEAST_SIDE**2 / threads)
    tell("its colours")
    quarter = (max(16, size[0] // 7), max(12, size[1] // 7))
    character = _within(file, lambda: povray_file.character_of(file, quarter, 0.3 * left(), threads), size, budget)
    tell("the picture without antialiasing")
    plain = _within(file, lambda: povray_file.draw(file, size, ("-A",), 0.3 * left()), size, budget)
    spent = plain.statistics
    pace = max(1.0, spent.wall_seconds / max(spent.cpu_seconds, 1e-3)) * spent.cpu_seconds / threads

    def foretold(side: int) -> float:
        """Seconds on the wall of a reference: trace, then the canvas written and read."""
        return plain.parse_seconds + side**2 * (pace + 1.5e-7 * size[0] * size[1])

    fitting = [
        side
        for side in SIDES
        if foretold(side) <= REFERENCE_SHARE * budget and side**2 * size[0] * size[1] <= LARGEST_CANVAS
    ]
    side = fitting[0] if fitting else LEAST_SIDE
    if not fitting:
        _check(size, budget, foretold(side))
    begin()
    judge = None
    if side != LEAST_SIDE:
        tell(f"the reference, {side} x {side} rays a pixel")
        with suppress(TimeLimit):  # the machine has slowed down: then fewer rays have to do
            judge = make_judge(file, size, side, character, plain, 0.4 * left(), threads)
    if judge is None:
        tell(f"the reference, {LEAST_SIDE} x {LEAST_SIDE} rays a pixel")
        least = functools.partial(make_judge, file, size, LEAST_SIDE, character, plain, 0.65 * left(), threads)
        judge = _within(file, least, size, budget)
    return Prepared(file, size, character, plain, judge, plain.parse_seconds, _notes(file, character, judge))


def _within(file: PovFile, work: Callable[[], Made], size: tuple[int, int], budget: float) -> Made:
    """What the work gives. Raises InvalidInput where it takes too long."""
    try:
        return work()
    except TimeLimit as error:
        raise InvalidInput(
            f"{file.path}: one of the pictures that a reference needs took too long for a budget of {duration(budget)} "
            f"at {size[0]}x{size[1]}: choose a smaller --size, or a larger --budget; "
            "or the scene has no end"
        ) from error


def _check(size: tuple[int, int], budget: float, foretold: float) -> None:
    """Raises InvalidInput where the least reference is out of reach, with what would do."""
    width, height = size
    rays = LEAST_SIDE**2 * width * height
    if rays > LARGEST_CANVAS:
        scale = math.sqrt(LARGEST_CANVAS / rays)
        raise InvalidInput(
            f"--size {width}x{height}: the reference would have {rays:.2g} rays, and more than {LARGEST_CANVAS:.2g} "
            f"are too many: up to --size {math.floor(width * scale)}x{math.floor(height * scale)} can be done"
        )
    if foretold > LARGEST_REFERENCE_SHARE * budget:
        scale = min(0.9, math.sqrt(0.8 * LARGEST_REFERENCE_SHARE * budget / foretold))
        smaller = f"{max(1, round(width * scale))}x{max(1, round(height * scale))}"
        needed = duration(math.ceil(1.25 * foretold / LARGEST_REFERENCE_SHARE / 30.0) * 30.0)
        raise InvalidInput(
            f"the reference alone ({LEAST_SIDE} x {LEAST_SIDE} rays a pixel) takes about {duration(foretold)} at "
            f"{width}x{height}, too long for a budget of {duration(budget)}: --budget {needed}, or --size {smaller}"
        )


def make_judge(
    file: PovFile,
    size: tuple[int, int],
    side: int,
    character: Character,
    plain: Drawn,
    time_limit: float,
    threads: int,
) -> Judge:
    """Renders the reference's grid, and finds how far it may be off."""
    colours = character.colours
    means, centres, rounding = povray_file.grid(file, size, side, PARTS[side], colours, time_limit, threads)
    pictures = {part: colours.in_file(mean) for part, mean in means.items()}
    of_grid, slope = grid_error(pictures, side)
    of_size = character.differs_by_size
    if centres.size:
        seen = colours.in_file(colours.averaged(centres.astype(np.float64)))
        of_size = lasting(seen - plain.pixels)
    else:
        of_size = 0.0 if of_size < 2e-3 else of_size / side
    return Judge(
        side,
        means[side],
        pictures[side].astype(np.float32),
        math.hypot(of_grid, rounding, of_size),
        of_grid,
        rounding,
        of_size,
        slope,
    )


def grid_error(pictures: Mapping[int, Array], side: int) -> tuple[float, float]:
    """The RMS error of a regular grid of side x side rays, from those of sparser grids; and the power of the side that
    they fall with.

    If a grid's error is C side^-p, independent of the others', the mean square difference of grids k and K is
    C^2 (k^-2p + K^-2p). p is between 1, an edge along the grid, and 3/2, an edge across it, whose rows err
    independently; where two differences tell, it is what they tell within that, else 1, the worse.
    """
    differences = {part: rms(picture - pictures[side]) for part, picture in pictures.items() if part != side}
    parts = sorted(differences, reverse=True)
    nearest = parts[0]
    slope, error = 1.0, 0.0
    for _ in range(8):  # what the grid itself is off is in the differences too; this settles within four rounds
        if len(parts) > 1 and min(differences.values()) > error:
            own = [math.sqrt(differences[part] ** 2 - error**2) for part in parts[:2]]
            slope = math.log(own[1] / own[0]) / math.log(nearest / parts[1])
            slope = min(max(slope, 1.0), 1.5)
        error = differences[nearest] / math.sqrt((side / nearest) ** (2.0 * slope) + 1.0)
    return error, slope


def lasting(difference: Array, block: int = 8) -> float:
    """The RMS of what a difference of two pictures has in blocks of pixels, beyond what noise of pixels leaves there.

    Rays jittered by a hash of their pixel differ in canvases of different sizes, and that averages out; what does not
    is another scene."""
    height, width = (n // block * block for n in difference.shape[:2])
    if not height or not width:
        return 0.0
    cut = difference[:height, :width]
    blocks = cut.reshape(height // block, block, width // block, block, 3).mean(axis=(1, 3))
    noise = rms(cut) / block
    return math.sqrt(max(0.0, rms(blocks) ** 2 - (1.5 * noise) ** 2))


def _notes(file: PovFile, character: Character, judge: Judge) -> list[str]:
    notes = list(file.notes)
    if told := character.colours.told():
        notes.append(told)
    if character.differs_by_run > 1e-4:
        notes.append(
            f"two pictures of the same setting differ by {character.differs_by_run:.2g} (RMS): the scene has "
            "randomness that hangs on the run (radiosity, photons, jittered lights in several threads), and no setting "
            "gets below that"
        )
    if judge.of_size > 1e-3:
        notes.append(
            f"the scene is drawn otherwise in a larger canvas, by {judge.of_size:.2g} (RMS): it asks for the size of "
            "its picture, or has radiosity; the reference is no better than that, which is in its error"
        )
    elif character.differs_by_size > 2e-3:
        notes.append(
            f"rays have randomness of their own, {character.differs_by_size:.2g} (RMS; area lights with jitter, focal "
            "blur, media): antialiasing averages it as well, and the reference's part of it is in its error"
        )
    return notes


def duration(seconds: float) -> str:
    """As --budget takes it: "90s", "5m", "1h", rounded up to what is said."""
    if seconds < 120:
        return f"{math.ceil(seconds)}s"
    return f"{math.ceil(seconds / 60)}m" if seconds < 2 * 3600 else f"{math.ceil(seconds / 3600)}h"


@functools.cache
def spec_of(candidate: Candidate) -> Spec:
    return renderers.mode_of(renderers.find(candidate.renderer), candidate.mode)


def _candidate(method: str, depth: int, threshold: float, jitter: int) -> Candidate:
    text = f"{method}:depth={depth},jitter={jitter},threshold={threshold}"
    return Candidate("povray", renderers.mode_of(renderers.find("povray"), text).text)


NONE = Candidate("povray", "none")


class PovProblem:
    """The grid of POV-Ray's settings on one scene; see `sweep_search.Problem`."""

    def __init__(self, prepared: Prepared, workers: Workers, abreast: int) -> None:
        self.abreast = abreast
        self._prepared, self._workers = prepared, workers
        width, height = prepared.size
        trace = max(prepared.plain.statistics.cpu_seconds, 1e-3)
        # A look is of every second pixel each way, whose reference is in the whole one. Not where parsing is the most.
        even = width % 2 == 0 and height % 2 == 0 and min(width, height) >= 32
        self.looks = even and prepared.parse_seconds + 0.04 + trace / 4.0 < 0.6 * (prepared.parse_seconds + trace)
        self._small = prepared.judge.mean.reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3)) if even else None
        self._contrast = _contrast(prepared)
        self.pictures: dict[Candidate, Pixels] = {}
        self.costs: dict[Candidate, Cost] = {}
        self.failed: dict[Candidate, str] = {}

    def everything(self) -> list[Candidate]:
        grid = [
            _candidate(method, depth, threshold, jitter)
            for method, depths in DEPTHS.items()
            for depth in depths
            for threshold in THRESHOLDS
            for jitter in (0, 1)
            if not (method == "am2" and depth == 1 and threshold != THRESHOLDS[-1])  # corners alone: never compared
        ]
        return [NONE, *grid]

    def coarse(self) -> list[Candidate]:
        grid = [
            _candidate(method, depth, threshold, 1)
            for method, depths in COARSE_DEPTHS.items()
            for depth in depths
            for threshold in COARSE_THRESHOLDS
        ]
        return [NONE, _candidate("am2", 1, THRESHOLDS[-1], 1), *grid]

    def neighbours(self, candidate: Candidate) -> list[Candidate]:
        spec = spec_of(candidate)
        if spec.name == "none":
            return [_candidate("am1", 2, THRESHOLDS[-1], 1), _candidate("am2", 1, THRESHOLDS[-1], 1)]
        depth, threshold, jitter = spec.integer("depth"), spec.real("threshold"), round(spec.real("jitter"))
        beside = [
            *((spec.name, round(each), threshold, jitter) for each in _steps(DEPTHS[spec.name], depth)),
            *((spec.name, depth, each, jitter) for each in _steps(THRESHOLDS, threshold)),
            (spec.name, depth, threshold, 1 - jitter),
            *((other, each, threshold, jitter) for other, each in _other_method(spec.name, depth)),
        ]
        grid = set(self.everything())
        found = (_candidate(*each) for each in beside)
        return [each for each in dict.fromkeys(found) if each in grid]

    def expected(self, candidate: Candidate) -> float:
        plain = max(self._prepared.plain.statistics.cpu_seconds, 1e-4)
        spec = spec_of(candidate)
        if spec.name == "none":
            return plain
        share = float((self._contrast >= spec.real("threshold")).mean())
        depth = spec.integer("depth")
        samples = depth**2 if spec.name == "am1" else 4 ** (depth - 1)
        return plain * (1.0 + share * samples)

    def measure(self, batch: Sequence[Candidate], look: bool, limit: float) -> dict[Candidate, Measured]:
        width, height = self._prepared.size
        size = (width // 2, height // 2) if look else (width, height)
        last = time.monotonic() + limit
        tasks = [(c, self._begin(c, size, last)) for c in batch]
        found: dict[Candidate, Measured] = {}
        for candidate, task in tasks:
            try:
                drawn = task.result()
            except TimeLimit:
                continue
            except JobFailed as error:
                if time.monotonic() < last:
                    self.failed[candidate] = str(error)
                continue
            if not look:
                self._keep(candidate, drawn)
            found[candidate] = Measured(drawn.statistics.cpu_seconds, self._rmse(drawn.pixels, look))
        return found

    def again(self, candidate: Candidate, draw: int, limit: float) -> Measured | None:
        last = time.monotonic() + limit
        seconds: list[float] = []
        while math.fsum(seconds) < LEAST_TIMED and len(seconds) < 10:
            if time.monotonic() >= last:
                break
            try:
                drawn = self._begin(candidate, self._prepared.size, last).result()
            except JobFailed:
                break
            seconds.append(drawn.statistics.cpu_seconds)
            self._keep(candidate, drawn)
        if not seconds:
            return None
        return Measured(math.fsum(seconds) / len(seconds), self._rmse(self.pictures[candidate], False))

    def _begin(self, candidate: Candidate, size: tuple[int, int], last: float) -> Task[Drawn]:
        limit = max(0.05, last - time.monotonic())
        about = {"scene": self._prepared.file.path.name, "renderer": candidate.renderer, "mode": candidate.mode}
        arguments = [self._prepared.file, size, candidate, last]
        return self._workers.begin(draw_until, arguments, limit, {**about, "size": f"{size[0]}x{size[1]}"})

    def _rmse(self, pixels: Pixels, look: bool) -> float:
        judge = self._prepared.judge
        if not look:
            return rms(pixels.astype(np.float64) - judge.pixels)
        assert self._small is not None
        return rms(pixels - self._prepared.character.colours.in_file(self._small))

    def _keep(self, candidate: Candidate, drawn: Drawn) -> None:
        statistics = drawn.statistics
        samples = statistics.pixels + statistics.samples
        self.pictures[candidate] = drawn.pixels
        self.costs[candidate] = Cost(
            samples=samples,
            samples_per_pixel=samples / (self._prepared.size[0] * self._prepared.size[1]),
            rays={"camera": statistics.rays - statistics.reflected, "reflection": statistics.reflected},
            cpu_seconds=statistics.cpu_seconds,
            wall_seconds=statistics.wall_seconds,
        )


def draw_until(file: PovFile, size: tuple[int, int], candidate: Candidate, last: float) -> Drawn:
    """Runs in a worker process, on one thread. Raises TimeLimit at `last`, a time.monotonic(), which is that of the
    machine: what waits for its turn has no more time for that."""
    limit = last - time.monotonic()
    if limit <= 0.0:
        raise TimeLimit("there was no time left to begin it")
    return povray_file.draw(file, size, povray_file.options_of(spec_of(candidate)), limit)


def _steps(ladder: Sequence[float], value: float) -> list[float]:
    """The rungs beside one."""
    at = min(range(len(ladder)), key=lambda i: abs(ladder[i] - value))
    return [ladder[i] for i in (at - 1, at + 1) if 0 <= i < len(ladder)]


def _other_method(method: str, depth: int) -> list[tuple[str, int]]:
    """The other method, at the depths with about as many samples."""
    side = depth if method == "am1" else 2 ** (depth - 1)
    if method == "am1":
        return [("am2", each) for each in DEPTHS["am2"] if 0.6 <= 2 ** (each - 1) / side <= 1.7]
    return [("am1", each) for each in DEPTHS["am1"] if 0.7 <= each / side <= 1.5]


def _contrast(prepared: Prepared) -> Array:
    """What +AM1 compares with its threshold: the largest difference of a pixel from its neighbours, summed over
    colours, of the picture without antialiasing."""
    colours = np.clip(prepared.plain.pixels.astype(np.float64), 0.0, 1.0) ** (1.0 / 2.5)
    across = np.abs(np.diff(colours, axis=1)).sum(axis=2)
    down = np.abs(np.diff(colours, axis=0)).sum(axis=2)
    most = np.zeros(colours.shape[:2])
    for part, difference in (
        (most[:, 1:], across),
        (most[:, :-1], across),
        (most[1:], down),
        (most[:-1], down),
    ):
        np.maximum(part, difference, out=part)
    return most


def check_size(size: tuple[int, int]) -> None:
    """Raises Unsupported for pictures in which nothing can be told."""
    if min(size) < 16:
        raise Unsupported(f"--size {size[0]}x{size[1]}: a sweep is of pictures of 16x16 pixels or more")
