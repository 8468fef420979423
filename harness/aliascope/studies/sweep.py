"""`aliascope sweep`: which setting to use for a scene of one's own, found within a budget of time."""

from __future__ import annotations

import math
import os
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from aliascope import places, renderers, scene_io
from aliascope.errors import Interrupted, InvalidInput, JobFailed, NotWritable
from aliascope.geometry import Array
from aliascope.records import Cost, Estimate, Pixels
from aliascope.references import Reference
from aliascope.renderers import povray_file
from aliascope.renderers.povray_process import executable, version
from aliascope.scene_io import SceneFile
from aliascope.statistics import median_time, pooled_spread
from aliascope.studies import sweep_pov, sweep_scene
from aliascope.studies.compare import with_reference
from aliascope.studies.sweep_search import (
    Answer,
    Candidate,
    Found,
    Problem,
    Search,
    answer,
    front,
    near_front,
    ranked_alike,
    restricted,
)
from aliascope.trade.records import QUANTISATION
from aliascope.workers import Task, Workers

POV_SIZE = (320, 240)
"""Of pictures of a .pov file, which says nothing of it."""

LEAST_BUDGET = 5.0
"""Seconds."""
REPORT_SECONDS, REPORT_SECONDS_A_VALUE = 3.0, 6e-6
"""CPU seconds that a report takes, and those for each pixel of each picture in it: measured, and a third more; what
Python takes to begin is in the first."""
FEWEST_ROWS, MOST_ROWS = 6, 40
"""Settings in a report, as there is time; all are in --json."""
LARGEST_REPORT_SHARE = 0.3
"""Of the budget."""
EXHAUSTIVE = 7 * 24 * 3600.0
"""Seconds that the whole grid may take, where no budget is given."""

BLOCK = 16
"""Side, in pixels, of the parts of a picture from which it is told how its error hangs on what the picture shows."""

SUFFIXES = (".pov", ".toml", ".glb", ".gltf")


@dataclass(frozen=True)
class Asked:
    """What the command line says; `budget` in seconds, None for the default."""

    path: Path
    budget: float | None
    size: tuple[int, int] | None
    threads: int | None
    folder: Path
    exhaustive: bool
    begun: float = field(default_factory=time.monotonic)
    """When the budget began."""


@dataclass
class Swept:
    """What a sweep came to. `figures` has the CPU seconds and RMSE of each setting with a whole picture; `answers` the
    three settings of each renderer, under "" those of all; `notes` what is to be known, in sentences."""

    asked: Asked
    title: str
    size: tuple[int, int]
    budget: float
    reference: Reference
    reference_told: str
    found: Found
    figures: dict[Candidate, tuple[Estimate, Estimate]]
    pictures: Mapping[Candidate, Pixels]
    costs: Mapping[Candidate, Cost]
    failed: Mapping[Candidate, str]
    answers: dict[str, Answer]
    notes: list[str]
    versions: dict[str, str]
    quanta: Mapping[Candidate, float] = field(default_factory=dict)
    skipped: dict[str, str] = field(default_factory=dict)
    wall_seconds: float = 0.0
    rows: int = FEWEST_ROWS

    @property
    def is_pov(self) -> bool:
        return self.asked.path.suffix.lower() == ".pov"

    @property
    def front(self) -> list[Candidate]:
        return front(self.found.best_known())

    @property
    def limit(self) -> float:
        """The RMSE below which the reference can't tell settings apart: twice its own error."""
        return 2.0 * (self.reference.standard_error_rms or 0.0)


Tell = Callable[[str, int, int], None]
Say = Callable[..., None]


class Budget:
    """The time there is, of which some is kept for the report."""

    def __init__(self, seconds: float, begun: float) -> None:
        self.seconds, self.begun = seconds, begun
        self.kept = min(0.1 * seconds, 5.0)

    def left(self) -> float:
        """Seconds until the report has to be begun."""
        return self.begun + self.seconds - self.kept - time.monotonic()

    def keep_for(self, size: tuple[int, int]) -> None:
        """Keeps what a report of pictures of this size takes, on the machine as it is now."""
        wanted = REPORT_SECONDS + REPORT_SECONDS_A_VALUE * FEWEST_ROWS * size[0] * size[1]
        self.kept = min(1.6 * slowness() * wanted, LARGEST_REPORT_SHARE * self.seconds)

    def rows_of(self, size: tuple[int, int]) -> int:
        """How many settings there is time for in the report."""
        seconds = (self.left() + self.kept) / (1.6 * slowness()) - REPORT_SECONDS
        return min(max(FEWEST_ROWS, int(seconds / (REPORT_SECONDS_A_VALUE * size[0] * size[1]))), MOST_ROWS)


def slowness(seconds: float = 0.1) -> float:
    """Wall over CPU time of a loop of ours: above 1 where others have the processors."""
    begun, own = time.monotonic(), time.process_time()
    values = np.ones(4096)
    while time.process_time() - own < seconds:
        values = np.sqrt(values + 1.0)
    return max(1.0, (time.monotonic() - begun) / (time.process_time() - own))


def sweep(asked: Asked, tell: Tell) -> Swept:
    """Finds the settings. `tell` is told what is done, and how far it is.

    Raises InvalidInput, JobFailed, NotAvailable; Interrupted where there is nothing yet on Ctrl-C.
    """
    seconds = asked.budget or (EXHAUSTIVE if asked.exhaustive else 300.0)
    if seconds < LEAST_BUDGET:
        raise InvalidInput(f"--budget {sweep_pov.duration(seconds)}: a sweep takes {LEAST_BUDGET:g}s at least")
    check_file(asked.path)
    _check_folder(asked.folder)
    budget = Budget(seconds, asked.begun)

    def say(what: str, done: int = 0) -> None:
        tell(what, done, 0)

    work = _sweep_pov if asked.path.suffix.lower() == ".pov" else _sweep_scene
    abreast = asked.threads or len(os.sched_getaffinity(0))
    try:
        with Workers(abreast) as workers:
            try:
                swept = work(asked, budget, say, workers, abreast)
            except KeyboardInterrupt as error:
                raise Interrupted("interrupted before there was anything to say") from error
            if swept.found.interrupted:
                raise _Stopped(swept)
    except _Stopped as stopped:
        swept = stopped.swept
    swept.rows = budget.rows_of(swept.size)
    swept.wall_seconds = time.monotonic() - budget.begun
    return swept


class _Stopped(Exception):
    """Ends the worker processes at once."""

    def __init__(self, swept: Swept) -> None:
        super().__init__()
        self.swept = swept


def check_file(path: Path) -> None:
    """Raises InvalidInput for what is no scene."""
    if path.suffix.lower() not in SUFFIXES:
        hint = ": give the .pov file itself" if path.suffix.lower() == ".ini" else ""
        raise InvalidInput(f"{path}: a scene to sweep ends in {', '.join(SUFFIXES)}{hint}")
    if not path.is_file():
        raise InvalidInput(f"{path}: there is no such file")
    scene_io.check_name(path)


def _check_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".aliascope"
        probe.write_bytes(b"")
        probe.unlink()
    except OSError as error:
        raise NotWritable(f"{folder}: cannot be written: {error.strerror}; choose another folder with -o") from error


def _sweep_pov(asked: Asked, budget: Budget, say: Say, workers: Workers, abreast: int) -> Swept:
    size = asked.size or POV_SIZE
    sweep_pov.check_size(size)
    versions = {"povray": version(executable())}
    file = povray_file.open_file(asked.path)
    begun: list[Task[int]] = []
    prepared = sweep_pov.prepare(
        file, size, budget.seconds, budget.left, say, lambda: begun.extend(_waken(workers, abreast))
    )
    _await(begun)
    budget.keep_for(size)
    problem = sweep_pov.PovProblem(prepared, workers, abreast)
    found = _search(problem, budget.left, say, asked.exhaustive)
    judge = prepared.judge
    if prepared.parse_seconds > 0.2 * prepared.plain.statistics.cpu_seconds:
        prepared.notes.append(
            f"times are those of the trace alone; before it POV-Ray takes {prepared.parse_seconds:.2g} s to read the "
            "scene, the same with every setting"
        )
    quanta = dict.fromkeys(problem.pictures, 1.0 / 65535.0)
    swept = Swept(
        asked, asked.path.name, size, budget.seconds, judge.reference, judge.told(), found, {}, problem.pictures,
        problem.costs, problem.failed, {}, prepared.notes, versions, quanta,
    )  # fmt: skip
    return _concluded(swept)


def _sweep_scene(asked: Asked, budget: Budget, say: Say, workers: Workers, abreast: int) -> Swept:
    file = scene_of(asked.path)
    size = asked.size or file.scene.view.size
    sweep_pov.check_size(size)
    begun = _waken(workers, abreast)
    judge = sweep_scene.make_judge(file, size, budget.left, say, abreast)
    _await(begun)
    budget.keep_for(size)
    ladders, missing = sweep_scene.ladders_of(file.scene)
    if not ladders:
        raise InvalidInput(f"{asked.path}: nothing draws this scene: {'; '.join(missing.values())}")
    problem = sweep_scene.SceneProblem(file, size, judge, ladders, workers, abreast)
    found = _search(problem, budget.left, say, asked.exhaustive)
    versions: dict[str, str] = {}
    for name in dict.fromkeys(ladder[0].renderer for ladder in ladders):
        versions.update(renderers.find(name).versions())
    swept = Swept(
        asked, file.scene.title, size, budget.seconds, judge.reference, judge.told, found, {}, problem.pictures,
        problem.costs, problem.failed, {}, list(file.notes), versions, problem.quanta, missing,
    )  # fmt: skip
    return _concluded(swept)


def _waken(workers: Workers, abreast: int) -> list[Task[int]]:
    """Has the worker processes begin, and load what they need."""
    return [workers.begin(len, [[]], 60.0) for _ in range(abreast)]


def _await(begun: Sequence[Task[int]]) -> None:
    """Waits for them, so that the time that they take to begin is no picture's."""
    for task in begun:
        task.result()


def scene_of(path: Path) -> SceneFile:
    """A scene by its file, which may be of any format that is read."""
    return scene_io.load(str(path) if "/" in str(path) else f"./{path}")


def _search(problem: Problem, left: Callable[[], float], say: Say, exhaustive: bool) -> Found:
    found = Search(problem, left, QUANTISATION, say).run(exhaustive)
    if not found.whole:
        failed = getattr(problem, "failed", {})
        if found.interrupted:
            raise Interrupted("interrupted before there was anything to say")
        if failed:
            raise JobFailed(f"no picture was finished: {next(iter(failed.values()))}")
        raise InvalidInput("the reference used up the budget, and no picture was finished: give a larger --budget")
    return found


def _concluded(swept: Swept) -> Swept:
    """With figures, answers and notes."""
    found = swept.found
    spreads = {
        name: pooled_spread([[run.seconds for run in runs] for c, runs in found.runs.items() if c.renderer == name])
        for name in {c.renderer for c in found.whole}
    }
    for candidate, own in found.best_known().items():
        runs = found.runs.get(candidate, [])
        seconds = median_time([run.seconds for run in runs] or [own.seconds], spreads[candidate.renderer])
        error = Estimate(own.rmse, _error_spread(swept, candidate))
        swept.figures[candidate] = seconds, with_reference("rmse", error, swept.reference)
    swept.answers[""] = answer(found.best_known(), QUANTISATION)
    names = dict.fromkeys(candidate.renderer for candidate in found.whole)
    if len(names) > 1:
        for name in names:
            swept.answers[name] = answer(restricted(found, name).best_known(), QUANTISATION)
    swept.notes += _notes(swept)
    return swept


def _notes(swept: Swept) -> list[str]:
    found, notes = swept.found, []
    if swept.asked.budget is not None or not swept.asked.exhaustive:
        late = found.dropped_for_time
        if late:
            notes.append(f"{late} settings near the others were not tried for want of time: a larger --budget helps")
    if found.interrupted:
        notes.append("interrupted: what was found until then")
    if alike := ranked_alike(found):
        notes.append(
            "settings were first tried in pictures of half the size, which rank them as the whole ones do: Spearman "
            f"{alike[0]:.2f} for time, {alike[1]:.2f} for error"
        )
    if not any(len(found.runs.get(c, [])) >= 2 for c in (swept.answers[""].fast, swept.answers[""].final)):
        notes.append("there was no time to repeat the timed runs: times are of single runs beside others, and rough")
    final = swept.answers[""].final
    if swept.limit and found.best_known()[final].rmse < swept.limit:
        notes.append(
            f"errors below {swept.limit:.2g} are as good as the reference can tell: it is off by half of that itself"
        )
    return notes


def _error_spread(swept: Swept, candidate: Candidate) -> float | None:
    """The standard error of an RMSE: over seeds, where there are several that differ, else over the blocks of the
    picture, for one picture is one draw of how the pixels lie over the scene."""
    runs = swept.found.runs.get(candidate, [])
    if len(runs) >= 2 and len({run.rmse for run in runs}) >= 2:
        squares = [run.rmse**2 for run in runs]
        root = math.sqrt(statistics.fmean(squares))
        return statistics.stdev(squares) / math.sqrt(len(squares)) / (2.0 * root)
    if candidate not in swept.pictures:
        return None
    off = swept.pictures[candidate].astype(np.float64) - swept.reference.pixels
    return over_blocks((off**2).mean(axis=2))


def over_blocks(squares: Array) -> float | None:
    """The standard error of the root of the mean of squares (height, width), from the jackknife over blocks."""
    height, width = squares.shape
    rows, columns = np.arange(height) // BLOCK, np.arange(width) // BLOCK
    labels = (rows[:, None] * (width // BLOCK + 1) + columns).ravel()
    sums = np.bincount(labels, squares.ravel())
    counts = np.bincount(labels)
    sums, counts = sums[counts > 0], counts[counts > 0]
    n = len(sums)
    if n < 2:
        return None
    without = np.sqrt(np.maximum(0.0, (sums.sum() - sums) / (counts.sum() - counts)))
    return float(np.sqrt((n - 1) / n * ((without - without.mean()) ** 2).sum()))


def shown(swept: Swept, most: int) -> list[Candidate]:
    """The settings for the report: the answers, the front, then those near it and others over the whole range."""
    best = swept.found.best_known()
    named = [c for own in swept.answers.values() for c in (own.fast, own.balanced, own.final)]
    order = [*named, *swept.front, *near_front(best, (1.25, 1.03)), *best]
    kept = [c for c in dict.fromkeys(order) if c in swept.pictures][:most]
    return sorted(kept, key=lambda c: (c.renderer, best[c].seconds))


def machine() -> dict[str, str]:
    return places.machine()
