"""`make power`: how often a regression run raises an alarm where nothing changed, and which defects it catches.

Both are measured, with the limits of the whole suite: repetitions of runs in which nothing changed (`power_null`), the
same pictures by other instructions of the processor (`power_machines`), and defects put in on purpose
(`power_defects`). What was rendered is kept in a cache (`caches`), so that a second run is quick.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from aliascope import caches, places, renderers, scene_io
from aliascope.errors import InvalidInput, NotAvailable
from aliascope.native import samplers
from aliascope.references import files as reference_files
from aliascope.regression.defects import DEFECTS
from aliascope.regression.observe import Target
from aliascope.regression.records import CellName, Observed
from aliascope.regression.verdict import SIGNIFICANCE, Chances, Tests, count, shared
from aliascope.renderers.base import filter_of
from aliascope.studies import power_caught, power_defects, power_machines, power_pool, regress_suite, selection
from aliascope.studies.power_caught import Caught
from aliascope.studies.power_defects import REPEATED, Injected
from aliascope.studies.power_kept import Kept
from aliascope.studies.power_machines import Elsewhere
from aliascope.studies.power_null import Null, alarms_of, blessed_of, repeated
from aliascope.studies.power_pool import DEAR_POOL, FRAMES_POOL, POOL, key_of
from aliascope.studies.regress_suite import OWEN, REPLICATES, Cell
from aliascope.workers import Task, Workers

Tell = Callable[[str | None, int, int], None]

TELLING: Mapping[str, tuple[str, ...]] = {
    "embree": (
        f"uniform:n=256,{OWEN}",
        f"uniform:n=64,{OWEN}",
        "adaptive:method=kajiya,n=64",
        "adaptive:method=mitchell,n=96",
    ),
    "povray": (f"accumulate:n=16,{OWEN}", "regular:n=16", "am2:depth=3", "focal-blur"),
    "osmesa": (f"accumulate:n=16,{OWEN}", "msaa:n=4"),
}
"""The modes of the suite that defects are put into, by renderer: those with the least noise, and one of each kind that
is judged by its blessed figures."""

TRIED_SECONDS = 100.0
"""CPU time for the repetitions of a cell; it has LEAST_TRIES whatever they take."""

LEAST_TRIES, MOST_TRIES = 2, 10
"""With fresh seeds, beside the one with those of the suite."""

RENDERED_EACH = 6
"""Times that a try renders a cell, about: without a defect, and with those that the renderer draws."""

CHUNK = 25
"""Null repetitions of one task."""

MOST_ALARMS = 4e-3
"""Of all null repetitions: so that of 1,000 the upper 95 % bound of their share is below 1 %."""


@dataclass(frozen=True)
class Asked:
    """No scenes or renderers: all. `shim`: the library that chooses Embree's instructions (`power_machines`), None for
    no pictures by others."""

    scenes: tuple[str, ...] = ()
    renderers: tuple[str, ...] = ()
    repetitions: int = 1000
    pool: int = POOL
    tries: int = MOST_TRIES
    processes: int = 2
    time_limit: float = 3600.0
    folder: Path = Path("aliascope-power")
    shim: Path | None = None


@dataclass(frozen=True)
class Answer:
    """What was measured. drawn: the scenes of each renderer; cells: of the suite, of which `seeded` take part in the
    repetitions, the others being the same every time; `calm`: whether none raises an alarm beside itself."""

    asked: Asked
    drawn: Mapping[str, tuple[str, ...]]
    cells: int
    seeded: int
    tests: int
    significance: float
    calm: bool
    null: Null
    elsewhere: Elsewhere | None
    caught: tuple[Caught, ...]
    versions: Mapping[str, str]

    @property
    def missed(self) -> tuple[tuple[str, str, str], ...]:
        """Scene, renderer and defect where no cell caught it each time."""
        best: dict[tuple[str, str, str], float] = {}
        for each in self.caught:
            key = each.scene, each.renderer, each.defect
            best[key] = max(best.get(key, 0.0), each.caught / each.tries)
        return tuple(key for key, share in best.items() if share < 1.0)

    @property
    def holds(self) -> bool:
        few = self.null.alarms <= MOST_ALARMS * self.null.repetitions
        return self.calm and few and not self.missed and not (self.elsewhere and self.elsewhere.alarms)


def answer(asked: Asked, tell: Tell) -> Answer:
    """Measures. Raises InvalidInput without the plugin of a defect, NotAvailable, CheckFailed for a reference that is
    missing, JobFailed."""
    if "dimension repeated" in DEFECTS and "repeats" not in {info.name for info in samplers.registered()}:
        raise InvalidInput(
            "the sampler that repeats a dimension is not loaded: add --trust-plugin .build/plugins/repeats.so"
        )
    names, versions = _renderers(asked)
    files = [scene_io.load(word) for word in selection.scenes_of(asked.scenes)]
    cells, _ = regress_suite.cells_of(files, names)
    with Workers(asked.processes) as workers:
        study = _Study(asked, cells, tell, workers)
        base = study.base()
        tests = sum((count(each, blessed_of(each)) for each in base.values()), Tests())
        chances = shared(tests)
        caught, null = study.caught(base, chances), study.null(chances)
    elsewhere = study.elsewhere(base, chances, asked.shim) if asked.shim is not None else None
    return Answer(
        asked=asked,
        drawn={name: tuple(dict.fromkeys(c.name.scene for c in cells if c.name.renderer == name)) for name in names},
        cells=len(cells),
        seeded=sum(map(_seeded, cells)),
        tests=tests.total,
        significance=SIGNIFICANCE,
        calm=not any(alarms_of(each, each, chances) for each in base.values()),
        null=null,
        elsewhere=elsewhere,
        caught=tuple(caught),
        versions=versions,
    )


def _renderers(asked: Asked) -> tuple[list[str], dict[str, str]]:
    """Those that are there, and their versions; one that was named must be."""
    names: list[str] = []
    versions: dict[str, str] = {}
    for name in asked.renderers or tuple(renderers.RENDERERS):
        try:
            versions.update(renderers.find(name).versions())
            names.append(name)
        except NotAvailable:
            if asked.renderers:
                raise
    return names, versions


def _seeded(cell: Cell) -> bool:
    return all(draw.shift == (0.0, 0.0) for draw in cell.draws)


@dataclass(frozen=True)
class _Work:
    """A task, and the key under which its result is kept."""

    key: str
    cell: Cell
    task: Callable[..., Any]
    arguments: Sequence[Any]


@dataclass(frozen=True)
class _Study:
    """The parts of one measurement, that share cells, processes, targets, and what was rendered before."""

    asked: Asked
    cells: Sequence[Cell]
    tell: Tell
    workers: Workers
    targets: dict[tuple[str, str], Target] = field(default_factory=dict)

    @property
    def kept(self) -> Kept:
        return Kept(caches.folder("power"))

    def target(self, cell: Cell) -> Target:
        """What its pictures should be, loaded once."""
        key = cell.name.scene, filter_of(cell.spec)
        if key not in self.targets:
            scene = cell.file.scene
            found = reference_files.load(places.REFERENCES, key[0], scene, scene.view.size, key[1])
            self.targets[key] = Target(found.exact, found.standard_error)
        return self.targets[key]

    def results(self, work: Sequence[_Work], what: str, others: Workers | None = None) -> list[Any]:
        """Those of all tasks, what is kept or else done now and then kept. `others`: the
        processes that do it all, in place of the study's own."""
        found = [self.kept.get(each.key) for each in work]
        missing = [number for number, each in enumerate(found) if each is None]
        begun: list[Task[Any]] = [
            (others or self.workers).begin(
                work[number].task,
                work[number].arguments,
                self.asked.time_limit,
                {"part": what, "cell": work[number].cell.name.text},
            )
            for number in missing
        ]
        for done, (number, task) in enumerate(zip(missing, begun, strict=True)):
            self.tell(f"{what}: {work[number].cell.name.text}", done, len(missing))
            found[number] = task.result()
            self.kept.put(work[number].key, found[number])
        self.tell(None, len(missing), len(missing))
        return found

    def base(self) -> dict[CellName, Observed]:
        """All cells with the draws of the suite."""
        work = [
            _Work(key_of(each, "base"), each, power_pool.observe, [each, self.target(each), self.asked.time_limit])
            for each in self.cells
        ]
        found = self.results(work, "as it is")
        return {each.name: seen for each, seen in zip(self.cells, found, strict=True)}

    def null(self, chances: Chances) -> Null:
        """Repetitions of the run, with other replicates."""
        seeded = [each for each in self.cells if _seeded(each)]
        pools = []
        for each in seeded:
            size = min(self.asked.pool, _pool_size(each))
            arguments = [each, self.target(each), size, self.asked.time_limit]
            pools.append(_Work(key_of(each, "pool", size), each, power_pool.make, arguments))
        self.results(pools, "pool")
        numbers = range(self.asked.repetitions)
        keys, folder = [each.key for each in pools], self.kept.folder
        found = Null(0, 0)
        tasks = [
            self.workers.begin(
                repeated, [folder, keys, chances, REPLICATES, numbers[first : first + CHUNK]], self.asked.time_limit
            )
            for first in range(0, len(numbers), CHUNK)
        ]
        for number, task in enumerate(tasks):
            self.tell("repetitions", number, len(tasks))
            found = found.joined(task.result())
        return found

    def elsewhere(self, base: Mapping[CellName, Observed], chances: Chances, shim: Path) -> Elsewhere:
        """All pictures of Embree and OSMesa by other instructions."""
        cells = [each for each in self.cells if each.name.renderer in ("embree", "osmesa")]
        work = [
            _Work(
                key_of(each, "elsewhere", power_machines.INSTRUCTIONS, power_machines.VECTOR_BITS),
                each,
                power_machines.observe,
                [each, self.target(each), self.asked.time_limit],
            )
            for each in cells
        ]
        with power_machines.instructions(shim), Workers(self.asked.processes) as others:
            found = self.results(work, "other instructions", others)
        other = {each.name: seen for each, seen in zip(cells, found, strict=True)}
        return power_machines.compared(base, other, chances)

    def caught(self, base: Mapping[CellName, Observed], chances: Chances) -> list[Caught]:
        """All defects, in the telling cells."""
        work: list[_Work] = []
        for each in _telling(self.cells):
            tries = 1 + _tries(each, base[each.name], self.asked.tries)
            for repetition in range(tries):
                names = tuple(DEFECTS) if repetition == 0 else REPEATED
                arguments = [each, self.target(each), names, repetition, self.asked.time_limit]
                work.append(
                    _Work(
                        key_of(each, "defects", repetition, power_defects.code()), each, power_defects.inject, arguments
                    )
                )
        found: list[Injected] = self.results(work, "defects")
        caught: list[Caught] = []
        for each in _telling(self.cells):
            own = [seen for one, seen in zip(work, found, strict=True) if one.cell is each]
            caught += power_caught.judged(each, own, chances)
        return caught


def _pool_size(cell: Cell) -> int:
    if cell.name.renderer == "povray":
        return FRAMES_POOL
    return DEAR_POOL if cell.file.scene.needs().diffuse_bounces else POOL


def _telling(cells: Sequence[Cell]) -> list[Cell]:
    """Those that defects are put into: where a scene has none of TELLING in a renderer, all."""
    chosen = []
    for cell in cells:
        renderer = renderers.find(cell.name.renderer)
        best = {renderers.mode_of(renderer, text).text for text in TELLING.get(renderer.name, ())}
        place = cell.name.scene, cell.name.renderer
        own = [each.spec.text for each in cells if (each.name.scene, each.name.renderer) == place]
        if cell.spec.text in best or not best.intersection(own):
            chosen.append(cell)
    return chosen


def _tries(cell: Cell, plain: Observed, most: int) -> int:
    """With fresh seeds: as many as there is time for, none where there is no seed."""
    if not _seeded(cell):
        return 0
    seconds = RENDERED_EACH * sum(replicate.cpu_seconds for replicate in plain.replicates)
    return min(most, max(LEAST_TRIES, int(TRIED_SECONDS / max(seconds, 1e-9))))
