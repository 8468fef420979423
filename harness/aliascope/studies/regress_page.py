"""The page of a regression run: its verdicts, and the pictures of `compare` with the p-values of each pixel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from aliascope import metrics, renderers
from aliascope.records import EmptyCell, Failure, ModeRow, ReportData, SceneSection
from aliascope.references import Reference
from aliascope.regression.records import CellVerdict, Observed, Run
from aliascope.report import write_report
from aliascope.scene_io import SceneFile
from aliascope.specs import family, label
from aliascope.statistics import mean
from aliascope.studies.compare import note_of


def write(
    folder: Path, run: Run, files: Mapping[str, SceneFile], references: Mapping[tuple[str, str], Reference]
) -> Path:
    """Writes report.html and its figures; returns the path of the page.

    files: by scene; references: by scene and filter, of those that were found. Raises NotWritable.
    """
    return write_report(folder, report_data(run, files, references), run)


def report_data(
    run: Run, files: Mapping[str, SceneFile], references: Mapping[tuple[str, str], Reference]
) -> ReportData:
    """What the page shows beside the verdicts: a section for each reference with pictures."""
    drawn: dict[tuple[str, str], list[CellVerdict]] = {}
    for cell in run.cells:
        if cell.observed is not None:
            drawn.setdefault((cell.name.scene, cell.observed.filter), []).append(cell)
    order = {name: number for number, name in enumerate(files)}
    keys = sorted((key for key in drawn if key in references), key=lambda key: (order[key[0]], key[1] != "box", key[1]))
    sections = tuple(_section(files[key[0]], key[1], references[key], drawn[key], run) for key in keys)
    return ReportData(
        title="aliascope regress",
        started=run.started,
        wall_seconds=run.wall_seconds,
        pictures=sum(len(cell.observed.replicates) for cell in run.cells if cell.observed is not None),
        reused=0,
        headlines=(),
        scenes=sections,
        failures=tuple(
            Failure(cell.name.scene, cell.name.renderer, cell.name.mode, cell.problem, cell.again)
            for cell in run.cells
            if cell.failed
        ),
        machine={**run.machine, "times": "of pictures that were drawn side by side: a hint, no measurement"},
        versions=run.versions,
        metrics=metrics.ABOUT,
        skipped=run.skipped,
        undrawn=tuple(cell for cell in _empty(run) if (cell.scene, "box") not in keys),
    )


def _section(
    file: SceneFile, filter_: str, reference: Reference, cells: Sequence[CellVerdict], run: Run
) -> SceneSection:
    box = filter_ == "box"
    rows = [_row(cell.observed) for cell in cells if cell.observed is not None and _shown(cell.observed, reference)]
    order = list(renderers.RENDERERS)
    rows.sort(key=lambda row: (order.index(row.renderer), row.family, row.samples_per_pixel))
    return SceneSection(
        name=file.name if box else f"{file.name}, {filter_}",
        title=file.scene.title if box else f"{file.scene.title}, filtered with {filter_}",
        shows=file.scene.shows,
        reference=reference.pixels,
        reference_note=note_of(reference),
        rows=tuple(rows),
        empty=tuple(cell for cell in _empty(run) if cell.scene == file.name) if box else (),
        filter=filter_,
    )


def _shown(observed: Observed, reference: Reference) -> bool:
    """Whether there is a picture that can stand beside the reference."""
    return observed.first is not None and observed.first.shape == reference.pixels.shape


def _row(observed: Observed) -> ModeRow:
    assert observed.first is not None
    name, replicates = observed.name, observed.replicates
    spec = renderers.mode_of(renderers.find(name.renderer), name.mode)
    return ModeRow(
        renderer=name.renderer,
        mode=name.mode,
        label=label(spec),
        family=family(spec),
        samples_per_pixel=replicates[0].samples / (observed.size[0] * observed.size[1]),
        cpu_seconds=mean([replicate.cpu_seconds for replicate in replicates]),
        metrics=observed.metrics,
        pictures=len(replicates),
        pixels=observed.first,
        quantum=observed.quantum,
        p_values=observed.p_values,
    )


def _empty(run: Run) -> tuple[EmptyCell, ...]:
    return tuple(EmptyCell(name.scene, name.renderer, name.mode, reason) for name, reason in run.empty)
