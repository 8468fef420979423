"""A sweep over a scene of the project's own kind (TOML, glTF): the settings of every renderer that draws it."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from aliascope import places, plan, references, renderers
from aliascope.errors import CheckFailed, InvalidInput, JobFailed, NotAvailable, Unsupported
from aliascope.model import Scene
from aliascope.records import Cost, Pixels, Rendering
from aliascope.references import Reference
from aliascope.references import files as reference_files
from aliascope.renderers.base import Request, lacks
from aliascope.renderers.process import TimeLimit
from aliascope.scene_io import SceneFile
from aliascope.specs import Spec
from aliascope.studies import sweep_pov
from aliascope.studies.converging import apart
from aliascope.studies.sweep_search import Candidate, Measured
from aliascope.workers import Task, Workers

COUNTS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)
SQUARES = (1, 4, 9, 16, 25, 36, 64, 100, 144, 256, 576, 1024)
"""Counts of patterns that have square numbers of samples alone."""
COARSE_COUNTS = (1, 4, 16, 64, 256)

SAMPLERS: Mapping[str, tuple[int, ...]] = {
    "random": COUNTS,
    "halton": COUNTS,
    "sobol,sampler.scramble=owen": COUNTS,
    "jittered": SQUARES,
    "multi-jittered": SQUARES,
    "regular": SQUARES,
}
ADAPTIVE_COUNTS = (16, 24, 32, 48, 64, 96, 128, 192, 256)
FRAMES = (1, 2, 4, 8, 16, 32, 64, 128, 256)
"""Of renderers that accumulate."""

LARGEST_PATIENCE = 0.55
"""Of the time there is, what a picture is given: its process is ended half as much later."""

CONVERGED = (64, 4096)
"""Samples of each replicate of a reference that is converged, at least and at most."""


@dataclass(frozen=True)
class SceneJudge:
    """The reference, and in words how it was made."""

    reference: Reference
    told: str


def make_judge(
    file: SceneFile, size: tuple[int, int], left: Callable[[], float], tell: Callable[[str], None], threads: int
) -> SceneJudge:
    """The kept reference of a scene of the project, else an exact one, else one that is converged within a third of the
    time. Raises Unsupported where there is none."""
    scene = file.scene
    if file.path.parent == places.SCENES and size == scene.view.size:
        try:
            return _judge(reference_files.load(places.REFERENCES, file.name, scene, size, "box"))
        except CheckFailed:
            pass  # of an earlier version of the scene
    tell("the reference")
    try:
        return _judge(references.make(scene, size))
    except references.Ambiguous:
        raise
    except Unsupported:
        pass
    with apart() as draw:
        return _judge(_converged(file, size, left, references.Plan(threads=threads, apart=draw)))


def _converged(file: SceneFile, size: tuple[int, int], left: Callable[[], float], plan: references.Plan) -> Reference:
    """One that takes a third of the time. Raises InvalidInput where that is too little."""
    scene, few = file.scene, replace(plan, samples=16, replicates=2)
    references.make(scene, size, "box", few)  # what is loaded and built for the first is not timed
    begun = time.monotonic()
    references.make(scene, size, "box", few)
    each = (time.monotonic() - begun) / (few.samples * few.replicates)  # seconds for a sample a pixel
    replicates = plan.replicates
    fitting = left() / 3.0 / max(each * replicates, 1e-9)
    if fitting < CONVERGED[0]:
        needed = sweep_pov.duration(1.2 * 3.0 * CONVERGED[0] * replicates * each)
        raise InvalidInput(
            f"{file.path}: the reference alone takes a third of --budget {needed}: give that, or a smaller --size"
        )
    samples = 2 ** math.floor(math.log2(min(fitting, CONVERGED[1])))
    return references.make(scene, size, "box", replace(plan, samples=samples))


def _judge(reference: Reference) -> SceneJudge:
    return SceneJudge(reference, reference.uncertainty)


def _modes(renderer: str, scene: Scene) -> Iterator[list[str]]:
    """The grid of a renderer's modes, a ladder of counts at a time."""
    match renderer:
        case "embree":
            for sampler, counts in SAMPLERS.items():
                yield [f"uniform:n={n},sampler={sampler}" for n in counts]
            for method in ("whitted", "kajiya", "mitchell"):
                yield [f"adaptive:method={method},n={n}" for n in ADAPTIVE_COUNTS]
        case "osmesa":
            yield ["none", "msaa:n=4", "msaa:n=8"]
            yield ["msaa:n=4,sample-shading=1"]
            for sampler in ("halton", "sobol,sampler.scramble=owen"):
                yield [f"accumulate:n={n},sampler={sampler}" for n in FRAMES]
            yield [f"accumulate:n={n},sampler=regular" for n in SQUARES if n <= FRAMES[-1]]
        case "povray":
            kind = plan.kind_of(scene)
            if kind != "plain":
                yield from ([mode] for mode in plan.POVRAY_FULL[kind])
                return
            yield ["none"]
            for method, depths in sweep_pov.DEPTHS.items():
                for threshold in sweep_pov.THRESHOLDS:
                    for jitter in (0, 1):
                        yield [f"{method}:depth={d},jitter={jitter},threshold={threshold}" for d in depths]
            yield [f"accumulate:n={n},sampler=sobol" for n in FRAMES]
        case _:  # one that was added: what its profile has
            yield from ([mode] for mode in plan.profile("quick").get(renderer, ()))


def ladders_of(scene: Scene) -> tuple[list[list[Candidate]], dict[str, str]]:
    """The ladders of counts of every renderer that is there and draws the scene; why the others do not."""
    found: list[list[Candidate]] = []
    missing: dict[str, str] = {}
    for name, renderer in renderers.RENDERERS.items():
        try:
            renderer.versions()
        except NotAvailable as error:
            missing[name] = str(error)
            continue
        own = []
        for ladder in _modes(name, scene):
            kept = []
            for mode in ladder:
                try:
                    spec = renderers.mode_of(renderer, mode)
                except Unsupported:  # a count that the pattern does not have
                    continue
                reason = lacks(renderer, scene, spec)
                if reason is None:
                    kept.append(Candidate(name, spec.text))
                else:
                    missing.setdefault(name, reason)
            if kept:
                own.append(list(dict.fromkeys(kept)))
        if own:
            missing.pop(name, None)
        found += own
    return found, missing


def render(
    file: SceneFile, candidate: Candidate, size: tuple[int, int], seed: int, least: float, last: float
) -> Rendering:
    """Runs in a worker process; until `last`, a time.monotonic(), which is that of the machine."""
    limit = last - time.monotonic()
    if limit <= 0.0:
        raise TimeLimit("there was no time left to begin it")
    renderer = renderers.find(candidate.renderer)
    mode = renderers.mode_of(renderer, candidate.mode)
    return renderer.render(Request(file.scene, *size, mode, seed, least_seconds=least, time_limit=limit))


class SceneProblem:
    """The settings of all renderers on one scene; see `sweep_search.Problem`. There are no cheap looks: most pictures
    take less time than it takes to ask for them."""

    looks = False

    def __init__(
        self,
        file: SceneFile,
        size: tuple[int, int],
        judge: SceneJudge,
        ladders: Sequence[Sequence[Candidate]],
        workers: Workers,
        abreast: int,
    ) -> None:
        self.abreast = abreast
        self._file, self._size, self._judge, self._workers = file, size, judge, workers
        self._ladders = ladders
        self._place = {c: (i, j) for i, ladder in enumerate(ladders) for j, c in enumerate(ladder)}
        self.pictures: dict[Candidate, Pixels] = {}
        self.costs: dict[Candidate, Cost] = {}
        self.quanta: dict[Candidate, float] = {}
        self.failed: dict[Candidate, str] = {}

    def everything(self) -> list[Candidate]:
        return list(self._place)

    def coarse(self) -> list[Candidate]:
        chosen = []
        for ladder in self._ladders:
            spec = sweep_pov.spec_of(ladder[0])
            if spec.name in ("am1", "am2"):
                if spec.real("threshold") in sweep_pov.COARSE_THRESHOLDS and spec.real("jitter") == 1.0:
                    chosen += [c for c in ladder if _depth(c) in sweep_pov.COARSE_DEPTHS[spec.name]]
            else:
                chosen += ladder if len(ladder) <= 3 else ladder[::3]
        return chosen

    def neighbours(self, candidate: Candidate) -> list[Candidate]:
        line, at = self._place[candidate]
        ladder = self._ladders[line]
        beside = [ladder[j] for j in (at - 1, at + 1) if 0 <= j < len(ladder)]
        spec = sweep_pov.spec_of(candidate)
        count = self.expected(candidate)
        for other in self._ladders:
            if other is ladder or other[0].renderer != candidate.renderer:
                continue
            if sweep_pov.spec_of(other[0]).name in ("am1", "am2") and not _one_step(spec, other[0]):
                continue
            beside.append(min(other, key=lambda c: abs(math.log(self.expected(c) / count))))
        return beside

    def expected(self, candidate: Candidate) -> float:
        spec = sweep_pov.spec_of(candidate)
        samples = next((spec.integer(key) for key in ("n", "blur_samples") if key in spec.values), 1)
        if spec.name in ("am1", "am2"):
            samples = 1 + (_depth(candidate) ** 2 if spec.name == "am1" else 4 ** (_depth(candidate) - 1))
        return 2e-7 * samples * self._size[0] * self._size[1]

    def measure(self, batch: Sequence[Candidate], look: bool, limit: float) -> dict[Candidate, Measured]:
        last = time.monotonic() + limit
        tasks = [(c, self._begin(c, 0, 0.0, last)) for c in batch]
        found = {}
        for candidate, task in tasks:
            try:
                found[candidate] = self._kept(candidate, task.result(), first=True)
            except TimeLimit:
                continue
            except (JobFailed, Unsupported) as error:
                if time.monotonic() < last:
                    self.failed[candidate] = str(error)
        return found

    def again(self, candidate: Candidate, draw: int, limit: float) -> Measured | None:
        if limit < 0.5:
            return None
        last = time.monotonic() + limit
        try:
            least = min(sweep_pov.LEAST_TIMED, 0.3 * limit)
            return self._kept(candidate, self._begin(candidate, draw, least, last).result(), first=draw == 0)
        except TimeLimit:
            return None
        except JobFailed as error:
            if time.monotonic() < last:
                self.failed[candidate] = str(error)
            return None

    def _begin(self, candidate: Candidate, seed: int, least: float, last: float) -> Task[Rendering]:
        seeded = renderers.find(candidate.renderer).seeded(sweep_pov.spec_of(candidate))
        # Embree and OSMesa look at the time between pictures alone: the process is ended soon after, if it must be.
        given = LARGEST_PATIENCE * min(max(0.05, last - time.monotonic()), 1e6)
        last = time.monotonic() + given
        return self._workers.begin(
            render,
            [self._file, candidate, self._size, seed if seeded else 0, least, last],
            given,
            {"scene": self._file.name, "renderer": candidate.renderer, "mode": candidate.mode, "seed": seed},
        )

    def _kept(self, candidate: Candidate, rendering: Rendering, first: bool) -> Measured:
        if first:
            self.pictures[candidate] = rendering.pixels
            self.costs[candidate] = rendering.cost
            self.quanta[candidate] = rendering.quantum
        off = rendering.pixels.astype(np.float64) - self._judge.reference.pixels
        return Measured(rendering.cost.cpu_seconds, float(np.sqrt((off**2).mean())))


def _depth(candidate: Candidate) -> int:
    return sweep_pov.spec_of(candidate).integer("depth")


def _one_step(spec: Spec, other: Candidate) -> bool:
    """Whether another ladder of +AM1 or +AM2 is one step in threshold, jitter or method away."""
    its = sweep_pov.spec_of(other)
    if spec.name not in ("am1", "am2"):
        return its.real("threshold") == sweep_pov.THRESHOLDS[-1]
    ladder = sweep_pov.THRESHOLDS
    steps = abs(ladder.index(its.real("threshold")) - ladder.index(spec.real("threshold")))
    return steps + (its.real("jitter") != spec.real("jitter")) + (its.name != spec.name) == 1


def processors() -> int:
    return len(os.sched_getaffinity(0))
