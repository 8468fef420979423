"""`aliascope agree`: whether the renderers' converged pictures of a scene are the same picture.

Each renderer makes `replicates` pictures of a scene by a pattern that is random with a mean without bias, all with
seeds of their own; `agree_judge` tests the means of each two renderers against each other.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from aliascope import plan, renderers, scene_io
from aliascope.errors import InvalidInput, NotAvailable
from aliascope.geometry import Array
from aliascope.model import LARGEST_AREA, LARGEST_SIDE
from aliascope.records import Pixels
from aliascope.renderers.base import Request, lacks
from aliascope.scene_io import SceneFile
from aliascope.specs import Spec, join, split
from aliascope.studies import agree_effects, agree_known, selection
from aliascope.studies.agree_effects import FINE, Facts
from aliascope.studies.agree_judge import Judgement, Side, judge
from aliascope.studies.agree_known import FLOAT32, Known
from aliascope.workers import Task, Workers

SAMPLER = "sobol,sampler.scramble=owen"
"""Owen's scrambling makes each point uniform, so that the mean has no bias at any count."""

FASTER = 8
"""Times as many samples as POV-Ray, each of whose frames takes 0.23 s, however small it is, the others take."""

CONVERGING: Mapping[str, tuple[str, int]] = {
    "embree": ("uniform", FASTER),
    "povray": ("accumulate", 1),
    "osmesa": ("accumulate", FASTER),
}
"""The mode of each renderer that goes to the integral, and how many times --samples it takes."""

FIRST_SEED = 1 << 44
APART = 1 << 20
"""Between the seeds of renderers: replicates are fewer."""

Tell = Callable[[str | None, int, int], None]


@dataclass(frozen=True)
class Asked:
    """The options of the command; no scenes or renderers: all."""

    scenes: tuple[str, ...] = ()
    renderers: tuple[str, ...] = ()
    size: tuple[int, int] = (64, 48)
    samples: int = 32
    replicates: int = 16
    seed: int = 0
    processes: int = 8
    time_limit: float = 600.0

    def check(self) -> None:
        """Raises InvalidInput."""
        fine = [FINE * side for side in self.size]
        if max(fine) > LARGEST_SIDE or math.prod(fine) > LARGEST_AREA:
            raise InvalidInput(
                f"--size {self.size[0]}x{self.size[1]}: effects are found in pictures {FINE} times as wide and high, "
                f"which are at most {LARGEST_SIDE} pixels a side and {LARGEST_AREA} in all"
            )


@dataclass(frozen=True)
class Cell:
    """A pair of renderers on a scene. `verdict`: "agree", "known" (they differ, by no more than a reason accounts for),
    "differ", or "empty", with the `reason` why one does not draw it. `known`: what is known of the pair there, whether
    it showed or not."""

    scene: str
    one: str
    other: str
    verdict: str
    reason: str = ""
    judgement: Judgement | None = None
    known: tuple[Known, ...] = ()


@dataclass(frozen=True)
class Answer:
    """All cells of a run, and renderers that are not there, with the reason."""

    asked: Asked
    cells: tuple[Cell, ...]
    skipped: Mapping[str, str]
    modes: Mapping[str, str]

    @property
    def holds(self) -> bool:
        return all(cell.verdict != "differ" for cell in self.cells)

    @property
    def tested(self) -> list[Cell]:
        return [cell for cell in self.cells if cell.judgement is not None]


@dataclass(frozen=True)
class _Sought:
    """What a run makes: scenes, the renderers that draw each, or the reason why not."""

    files: tuple[SceneFile, ...]
    names: tuple[str, ...]
    refused: Mapping[tuple[str, str], str]

    def pairs(self, file: SceneFile) -> list[tuple[str, str]]:
        return list(itertools.combinations(self.able(file), 2))

    def able(self, file: SceneFile) -> list[str]:
        return [name for name in self.names if (file.name, name) not in self.refused]


def mode_of(renderer: str, samples: int) -> str:
    """The mode that goes to the integral, of --samples; of a renderer that is none of ours, that of its probe."""
    if renderer in CONVERGING:
        name, factor = CONVERGING[renderer]
        return f"{name}:n={factor * samples},sampler={SAMPLER}"
    found = renderers.find(renderer)
    name, pairs = split(found.probe_mode)
    count = _count_of(renderers.mode_of(found, found.probe_mode))
    if count is None:
        raise InvalidInput(f"{renderer}: its probe's mode, {found.probe_mode}, has no count of samples to converge by")
    return join(name, {**pairs, count: str(FASTER * samples)})


def _count_of(mode: Spec) -> str | None:
    """The key that is the samples of a pixel."""
    return next((key.name for key in mode.form.keys if key.is_count), None)


def _factor(renderer: str) -> int:
    return CONVERGING[renderer][1] if renderer in CONVERGING else FASTER


def answer(asked: Asked, tell: Tell) -> Answer:
    """Renders and tests. Raises InvalidInput, NotAvailable for a renderer that was named, JobFailed."""
    asked.check()
    names, skipped = _chosen(asked)
    modes = {name: mode_of(name, asked.samples) for name in names}
    files = tuple(scene_io.load(name) for name in selection.scenes_of(asked.scenes))
    selection.check_names(files)
    refused = {
        (file.name, name): reason for file in files for name in names if (reason := _refusal(file, name, modes[name]))
    }
    sought = _Sought(files, names, refused)
    with Workers(asked.processes) as workers:
        facts, sides = _rendered(asked, sought, modes, workers, tell)
    cells: list[Cell] = []
    pairs = sum(len(sought.pairs(file)) for file in files)
    for file in files:
        for one, other in itertools.combinations(names, 2):
            reasons = [refused[file.name, name] for name in (one, other) if (file.name, name) in refused]
            if reasons:
                cells.append(Cell(file.name, one, other, "empty", "; ".join(reasons)))
                continue
            fact = facts[file.name]
            found = judge(sides[file.name, one], sides[file.name, other], fact.ranges, fact.effects, pairs)
            known = agree_known.known_of(file.name, file.scene, one, other)
            cells.append(Cell(file.name, one, other, verdict(found, known), "", found, known))
    return Answer(asked, tuple(cells), skipped, modes)


def _refusal(file: SceneFile, renderer: str, mode: str) -> str | None:
    found = renderers.find(renderer)
    return lacks(found, file.scene, renderers.mode_of(found, mode))


def verdict(judgement: Judgement, known: Sequence[Known]) -> str:
    """What a judgement comes to beside what is known. Coefficients of effects are no values: what is known must
    account for the values, blocks and pictures beyond their limits."""
    if not judgement.failed:
        return "agree"
    most = max((each.most for each in known), default=0.0)
    beyond = [
        float(np.abs(tests.difference)[~(tests.share <= 1.0)].max(initial=0.0))
        for tests in judgement.tests
        if tests.kind != "effect"
    ]
    return "known" if known and max(beyond) <= most else "differ"


def _chosen(asked: Asked) -> tuple[tuple[str, ...], dict[str, str]]:
    """The renderers that take part, in the order of their list, and those that are not there."""
    named = renderers.named(asked.renderers)
    known = [*CONVERGING, *(name for name in named if name in renderers.RENDERERS and name not in CONVERGING)]
    wanted = plan.matching(named, known, "renderer") if named else list(CONVERGING)
    if len(wanted) < 2:
        raise InvalidInput(f"{wanted[0]} alone: two renderers or more can agree; name another with -r, or none at all")
    names, skipped = [], {}
    for name in wanted:
        try:
            renderers.find(name).versions()
        except NotAvailable as error:
            if asked.renderers:
                raise
            skipped[name] = str(error)
            continue
        names.append(name)
    if len(names) < 2:
        missing = "; ".join(f"{name}: {reason}" for name, reason in skipped.items())
        raise NotAvailable(f"two renderers or more can agree, and too few are there: {missing}")
    return tuple(names), skipped


# --- pictures ---------------------------------------------------------------------------------------------------------


def picture(
    file: SceneFile, renderer: str, mode: str, size: tuple[int, int], seed: int, time_limit: float
) -> tuple[Pixels, float]:
    """One replicate, and the step of the renderer's output. Runs in a worker process."""
    found = renderers.find(renderer)
    request = Request(file.scene, *size, renderers.mode_of(found, mode), seed, time_limit=time_limit)
    made = found.render(request)
    return made.pixels, made.quantum


def _rendered(
    asked: Asked, sought: _Sought, modes: Mapping[str, str], workers: Workers, tell: Tell
) -> tuple[dict[str, Facts], dict[tuple[str, str], Side]]:
    """Everything that the tests need, by scene, and by scene and renderer."""
    files = [file for file in sought.files if sought.pairs(file)]
    begun: dict[tuple[str, str], list[Task[tuple[Pixels, float]]]] = {}
    # POV-Ray's frames wait more than they work: these first, the others beside them.
    for name in sorted(sought.names, key=_factor):
        for file in files:
            if name in sought.able(file):
                seeds = seeds_of(name, asked)
                begun[file.name, name] = [
                    workers.begin(
                        picture,
                        [file, name, modes[name], asked.size, seed, asked.time_limit],
                        asked.time_limit,
                        {"scene": file.name, "renderer": name, "mode": modes[name], "seed": seed},
                    )
                    for seed in seeds
                ]
    thought = {
        file.name: workers.begin(
            agree_effects.facts_of,
            [file.scene, asked.size, "osmesa" in sought.able(file) and agree_known.displaced("osmesa", file.scene) > 0],
            asked.time_limit,
            {"scene": file.name, "facts": "effects"},
        )
        for file in files
    }
    done, total = 0, sum(map(len, begun.values())) + len(thought)
    made: dict[tuple[str, str], list[tuple[Pixels, float]]] = {}
    for (scene, name), results in begun.items():
        made[scene, name] = []
        for each in results:
            tell(f"{scene}  {name}", done, total)
            made[scene, name].append(each.result())
            done += 1
    facts: dict[str, Facts] = {}
    for scene, found in thought.items():
        tell(f"{scene}  effects", done, total)
        facts[scene] = found.result()
        done += 1
    tell(None, total, total)
    sides = {
        (file.name, name): side_of(file, name, made[file.name, name], facts[file.name].edges, modes[name])
        for file in files
        for name in sought.able(file)
    }
    return facts, sides


def seeds_of(renderer: str, asked: Asked) -> range:
    """No two renderers share one, and no other command has them."""
    first = FIRST_SEED + (asked.seed << 24) + APART * list(renderers.RENDERERS).index(renderer)
    return range(first, first + asked.replicates)


def side_of(
    file: SceneFile, renderer: str, made: Sequence[tuple[Pixels, float]], edges: Array | None, mode: str
) -> Side:
    """A renderer's replicates with what they may all be off by."""
    pictures = np.array([pixels for pixels, _ in made], dtype=np.float64)
    if not np.isfinite(pictures).all():
        raise InvalidInput(f"{file.name}: {renderer} drew values that are no numbers")
    spec = renderers.mode_of(renderers.find(renderer), mode)
    samples = spec.integer(_count_of(spec) or "n")
    rounded = 1 if renderer in renderers.BUILT_IN else samples  # others may sum in float32, as Mitsuba does
    bound = rounded * FLOAT32 * np.abs(pictures).max(axis=0) + 0.5 * made[0][1]
    if edges is not None:
        bound = bound + agree_known.displaced(renderer, file.scene) * edges
    return Side(renderer, pictures, samples, bound)
