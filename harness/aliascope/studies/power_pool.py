"""Many replicates of one cell, kept: what repetitions of a regression run draw theirs from (`power_null`)."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from aliascope import jobs, places, renderers
from aliascope.geometry import Array
from aliascope.records import Cost, Pixels
from aliascope.regression.observe import Observer, Target, observed
from aliascope.regression.records import Draw, Observed
from aliascope.renderers.base import Request, filter_of
from aliascope.studies.power_drawn import drawn
from aliascope.studies.regress_suite import Cell

FIRST_SEED = 1 << 45
"""Of the pools: no other command has these."""

POOL, DEAR_POOL, FRAMES_POOL = 128, 64, 48
"""Replicates of a cell; of one where light goes from surface to surface; of POV-Ray's, each of them many frames."""


@dataclass(frozen=True)
class Pool:
    """`whole` is observed of all replicates; products: (K, K), of each two pictures less the mean of all, the mean over
    all values of their product: what the variance of any choice of them can be told from."""

    whole: Observed
    products: Array

    def chosen(self, numbers: Sequence[int]) -> Observed:
        """What would have been observed of these replicates alone, but for pictures."""
        few = self.products[np.ix_(numbers, numbers)]
        scatter = (float(np.trace(few)) - float(few.sum()) / len(numbers)) / (len(numbers) - 1)
        replicates = tuple(self.whole.replicates[number] for number in numbers)
        # The least standard error of a mean goes with the root of how many there are.
        fewer = (len(self.whole.replicates) / len(numbers)) ** 0.5
        floor = tuple(fewer * each for each in self.whole.floor_blocks)
        return replace(self.whole, replicates=replicates, scatter=scatter, floor_blocks=floor)


def pictures(cell: Cell, draws: Sequence[Draw], time_limit: float) -> tuple[list[tuple[Draw, Pixels, Cost]], float]:
    """One for each draw, in this process, with the step of the output."""
    made, quantum = [], 0.0
    for draw in draws:
        rendering = drawn(cell.name.renderer, request_of(cell, draw, time_limit))
        made.append((draw, rendering.pixels, rendering.cost))
        quantum = rendering.quantum
    return made, quantum


def request_of(cell: Cell, draw: Draw, time_limit: float) -> Request:
    """The request for one replicate of a cell."""
    scene = cell.file.scene
    return Request(scene, *scene.view.size, cell.spec, draw.seed, time_limit=time_limit, shift=draw.shift)


def observed_of(
    cell: Cell, target: Target, made: Sequence[tuple[Draw, Pixels, Cost]], quantum: float = 0.0
) -> Observed:
    """What is observed of these pictures, without the pictures. Raises CheckFailed for one of another size."""
    found = observed(
        cell.name,
        cell.judged,
        cell.file.scene.digest(),
        filter_of(cell.spec),
        target,
        [Observer(target).part(made, quantum)],
        {},
        together=cell.spec.name == "accumulate",
    )
    return replace(found, first=None, mean=None, p_values=None)


def observe(cell: Cell, target: Target, time_limit: float) -> Observed:
    """A cell with the draws of the suite. Runs in a worker process."""
    return observed_of(cell, target, *pictures(cell, cell.draws, time_limit))


def make(cell: Cell, target: Target, count: int, time_limit: float) -> Pool:
    """Renders a pool of so many replicates, with seeds of their own. Runs in a worker process."""
    draws = [Draw(seed=FIRST_SEED + number) for number in range(count)]
    made, quantum = pictures(cell, draws, time_limit)
    values = np.array([pixels.ravel() for _, pixels, _ in made], dtype=np.float64)
    values -= values.mean(axis=0)
    return Pool(observed_of(cell, target, made, quantum), values @ values.T / values.shape[1])


def key_of(cell: Cell, *what: object) -> str:
    """A hash of all that pictures of a cell, and what is kept of them, depend on; `what` says what was made of it."""
    here = Path(__file__).parents[1]
    code = [path.read_bytes() for path in sorted((here / "regression").glob("[ot]*.py"))]
    reference = [path.read_bytes() for path in sorted((places.REFERENCES / cell.name.scene).glob("*box.*exr"))]
    versions = sorted(renderers.find(cell.name.renderer).versions().items())
    stated = [
        cell.file.scene.digest(),
        repr(versions),
        cell.name.text,
        jobs.code_digest(cell.name.renderer, cell.spec),
        repr(what),
    ]
    digest = hashlib.sha256()
    for each in (*map(str.encode, stated), *code, *reference):
        digest.update(hashlib.sha256(each).digest())
    return digest.hexdigest()[:32]
