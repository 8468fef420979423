"""Renders the cells of a regression run in worker processes, which send back what is kept of their pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from aliascope import jobs, metrics, renderers, statistics
from aliascope.errors import AliascopeError, CheckFailed, InvalidInput
from aliascope.records import Cost, Estimate, Pixels
from aliascope.regression import defects
from aliascope.regression.observe import Observer, Part, Target, observed
from aliascope.regression.records import Draw, Observed
from aliascope.renderers.base import Request, filter_of
from aliascope.scene_io import SceneFile
from aliascope.studies.regress_suite import Cell, kind_of
from aliascope.workers import Task, Workers

PART, DEAR_PART = 16, 4
"""Replicates of one task; fewer where each takes long, so that the pictures of one cell are shared."""

Tell = Callable[[str | None, int, int], None]


@dataclass(frozen=True)
class Problem:
    """Why there is nothing to judge of a cell; `failed`: it was rendering."""

    text: str
    failed: bool = False


@dataclass(frozen=True)
class Work:
    """A cell to render, with the name of a defect, or none."""

    cell: Cell
    defect: str
    target: Target


def render_part(
    file: SceneFile, renderer: str, mode: str, draws: Sequence[Draw], target: Target, defect: str, time_limit: float
) -> tuple[Part, dict[str, float]]:
    """Some replicates of a cell, and all metrics of the first, where that is not shifted. Runs in a worker process."""
    found = renderers.find(renderer)
    spec = renderers.mode_of(found, mode)
    wrong = defects.DEFECTS[defect] if defect else None
    made: list[tuple[Draw, Pixels, Cost]] = []
    quantum = 0.0
    for draw in draws:
        request = Request(
            file.scene, *target.size, spec, draw.seed, least_seconds=0.0, time_limit=time_limit, shift=draw.shift
        )
        rendering = found.render(wrong.request(request) if wrong and wrong.request else request)
        pixels = wrong.picture(rendering.pixels, draw) if wrong and wrong.picture else rendering.pixels
        made.append((draw, pixels, rendering.cost))
        quantum = rendering.quantum
    part = Observer(target).part(made, quantum)
    if part.first is None or defect:
        return part, {}
    try:
        measured = metrics.measure(part.first, target.reference.astype("float32"))
    except InvalidInput:  # a value that is no number, which is counted
        return part, {}
    return part, {name: value.value for name, value in measured.items() if value.value is not None}


def rendered(
    work: Sequence[Work], processes: int, time_limit: float, versions: Mapping[str, Mapping[str, str]], tell: Tell
) -> list[Observed | Problem]:
    """What came of each, in order. The longest begin first."""
    with Workers(processes) as workers:
        begun: dict[int, list[Task[tuple[Part, dict[str, float]]]]] = {}
        for number in sorted(range(len(work)), key=lambda number: -_weight(work[number])):
            each = work[number]
            name, more = each.cell.name, [each.target, each.defect, time_limit]
            about = {"scene": name.scene, "renderer": name.renderer, "mode": name.mode}
            if each.defect:
                about["defect"] = each.defect
            begun[number] = [
                workers.begin(
                    render_part,
                    [each.cell.file, name.renderer, name.mode, draws, *more],
                    time_limit,
                    {**about, "draws": len(draws)},
                )
                for draws in _shares(each)
            ]
        seen: dict[int, Observed | Problem] = {}
        for done, (number, tasks) in enumerate(begun.items()):
            name = work[number].cell.name
            tell(f"{name.scene}  {name.renderer}  {name.mode}", done, len(work))
            seen[number] = _observed(work[number], tasks, versions)
        tell(None, len(work), len(work))
    return [seen[number] for number in range(len(work))]


def _weight(work: Work) -> float:
    """Roughly what it takes, so that the longest begin first: light that bounces, and files that are long to read."""
    if kind_of(work.cell.file.scene) == "heavy":
        return 1000.0
    needs = work.cell.file.scene.needs()
    count = work.cell.spec.integer("n") if "n" in work.cell.spec.values else 16
    return count * (30.0 if needs.diffuse_bounces else 3.0 if needs.gloss else 1.0)


def _shares(work: Work) -> list[tuple[Draw, ...]]:
    """The draws of each task."""
    scene = work.cell.file.scene
    size = DEAR_PART if scene.needs().diffuse_bounces or kind_of(scene) == "heavy" else PART
    return [work.cell.draws[first : first + size] for first in range(0, len(work.cell.draws), size)]


def _observed(
    work: Work, tasks: Sequence[Task[tuple[Part, dict[str, float]]]], versions: Mapping[str, Mapping[str, str]]
) -> Observed | Problem:
    cell = work.cell
    made: list[tuple[Part, dict[str, float]]] = []
    problem: Problem | None = None
    for task in tasks:  # all of them are waited for
        try:
            made.append(task.result())
        except CheckFailed as error:
            problem = problem or Problem(str(error))
        except AliascopeError as error:
            problem = Problem(str(error), failed=True)
    if problem:
        return problem
    parts = [part for part, _ in made]
    measured = {name: Estimate(value) for name, value in made[0][1].items()}
    errors = [replicate.rmse for part in parts for replicate in part.replicates if replicate.rmse is not None]
    if len(errors) > 1:
        measured["rmse"] = statistics.mean(errors)
    return observed(
        cell.name,
        cell.judged,
        cell.file.scene.digest(),
        filter_of(cell.spec),
        work.target,
        parts,
        {
            **versions[cell.name.renderer],
            **jobs.plugin_versions(cell.spec),
            "code": jobs.code_digest(cell.name.renderer, cell.spec),
        },
        measured,
        together=cell.spec.name == "accumulate",
    )
