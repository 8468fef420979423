"""One picture, one reference: `aliascope render` and `aliascope reference`."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from aliascope import api, image, jobs, metrics, pipeline, plan, references, renderers, scene_io, sharing
from aliascope.draws import UNMOVED, text_of
from aliascope.errors import InvalidInput, NotWritable
from aliascope.native import filters
from aliascope.records import Rendering
from aliascope.references import files
from aliascope.renderers.base import LEAST_SECONDS, Request
from aliascope.studies.converging import apart, converging


def render_file(
    scene: str,
    renderer: str,
    mode: str,
    out: Path,
    seed: int,
    size: tuple[int, int] | None,
    threads: int,
    time_limit: float = Request.time_limit,
    counts: Path | None = None,
    dimensions: str | None = None,
    shift: tuple[float, float] = Request.shift,
) -> dict[str, Any]:
    """Renders to a file, and gives the figures of `aliascope render --json`; the samples of each pixel to `counts`.

    `dimensions`: their arrangement, where the mode does not say. Raises InvalidInput for a mode that takes none.
    """
    _check_out(out)
    if counts is not None:
        _check_out(counts)
    file = scene_io.load(scene)
    found = renderers.find(renderer)
    renderer = found.name
    if dimensions is not None:
        mode = renderers.arranged(found, mode, dimensions)
    spec = renderers.mode_of(found, mode)
    if dimensions is not None and "dimensions" not in spec.values:
        raise InvalidInput(f"--dimensions is for modes with a sampler: {spec.name} of {renderer} has none")
    if counts is not None and spec.name != "adaptive":
        raise InvalidInput(f"--counts is for adaptive modes: {spec.name} takes as many samples in every pixel")
    least = LEAST_SECONDS if threads == 1 else 0.0
    rendering = api.render(
        file,
        renderer,
        mode,
        size=size,
        seed=seed,
        threads=threads,
        least_seconds=least,
        time_limit=time_limit,
        shift=shift,
    )
    metrics.check_finite(rendering.pixels, "the picture")
    versions = found.versions()
    height, width, _ = rendering.pixels.shape
    job = plan.make_job(
        scene=file.name,
        scene_path=sharing.shared(str(file.path)),
        digest=file.scene.digest(),
        renderer=renderer,
        mode=spec.text,
        size=(width, height),
        seed=seed,
        versions=versions,
        shift=shift,
    )
    header = pipeline.provenance(job, rendering, versions)
    image.write_exr(out, rendering.pixels, header)
    if counts is not None and rendering.counts is not None:
        image.write_counts(counts, rendering.counts, header)
    cost = rendering.cost
    return {
        "scene": file.name,
        "renderer": renderer,
        "mode": spec.text,
        "seed": seed,
        "width": width,
        "height": height,
        "shift": list(shift),
        "samples": cost.samples,
        "samples_per_pixel": cost.samples_per_pixel,
        "counts": _counts(rendering, counts),
        "needs": file.scene.needs().model_dump(),
        "dimensions": file.scene.needs().dimensions,
        "rays": dict(cost.rays),
        "cpu_seconds": cost.cpu_seconds,
        "wall_seconds": cost.wall_seconds,
        "repeats": cost.repeats,
        "threads": threads,
        "quantum": rendering.quantum,
        "versions": {**versions, **jobs.plugin_versions(spec)},
        "image": str(out),
    }


def _counts(rendering: Rendering, path: Path | None) -> dict[str, Any] | None:
    """How the samples of the pixels differ; None where they do not."""
    if rendering.counts is None:
        return None
    least, most = int(rendering.counts.min()), int(rendering.counts.max())
    return {"least": least, "most": most, "image": str(path) if path else None}


def _check_out(out: Path) -> None:
    """Before a minute of rendering is spent. Raises InvalidInput, NotWritable."""
    if out.suffix.lower() != ".exr":
        raise InvalidInput(f'{out}: a picture is written as .exr, not "{out.suffix}"')
    if not out.parent.is_dir():
        raise NotWritable(f"{out}: cannot be written: there is no folder {out.parent}")


Tell = Callable[[str, int, int], None]
"""What is being made, and how many of how many pictures of it are done."""


def _nobody(what: str, done: int, total: int) -> None:
    """Tells nobody."""


def _processors() -> int:
    return len(os.sched_getaffinity(0))


def _moved(shift: tuple[float, float]) -> str:
    return "" if shift == UNMOVED else f" shifted by {text_of(shift)}"


def make_reference(
    scene: str,
    folder: Path,
    size: tuple[int, int] | None,
    filter_: str = "box",
    samples: int | None = None,
    tell: Tell = _nobody,
    shift: tuple[float, float] = UNMOVED,
) -> dict[str, Any]:
    """Makes and writes one reference: exact where the scene and the filter allow it, else converged."""
    file = scene_io.load(scene)
    wanted, filter_ = size or file.scene.view.size, filters.canonical(filter_)
    with apart() as draw:
        converged = references.Plan(
            samples=samples or references.Plan.samples,
            threads=_processors(),
            tell=converging(f"reference of {file.name}{_moved(shift)}, filter {filter_}", tell),
            apart=draw,
        )
        made = references.make(file.scene, wanted, filter_, converged, shift)
    path = files.save(folder, file.name, file.scene, wanted, filter_, made, shift)
    return {
        "scene": file.name,
        "path": str(path),
        "method": made.method,
        "filter": filter_,
        "shift": list(shift),
        "error": made.error,
        "standard_error": made.standard_error_rms,
        "holds": True,
        "text": f"{path}: {made.uncertainty}",
    }


def verify_reference(
    scene: str,
    folder: Path,
    size: tuple[int, int] | None,
    filter_: str = "box",
    samples: int | None = None,
    tell: Tell = _nobody,
    shift: tuple[float, float] = UNMOVED,
) -> dict[str, Any]:
    """Makes one reference again and compares it with the file; `samples`: of each replicate, for a converged one."""
    file = scene_io.load(scene)
    wanted, filter_ = size or file.scene.view.size, filters.canonical(filter_)
    with apart() as draw:
        check = dataclasses.replace(
            files.CHECK,
            samples=samples or files.CHECK.samples,
            threads=_processors(),
            tell=converging(f"reference of {file.name}{_moved(shift)}, filter {filter_}", tell),
            apart=draw,
        )
        found = files.verify(folder, file.name, file.scene, wanted, filter_, check, shift)
    verdict = "holds" if found.holds else f"DOES NOT HOLD: {found.reason}"
    return {
        "scene": file.name,
        "path": str(files.path_of(folder, file.name, wanted, filter_, shift)),
        "method": found.method,
        "filter": filter_,
        "shift": list(shift),
        "error": found.error,
        "holds": found.holds,
        "reason": found.reason,
        "max_difference": found.max_difference if found.max_difference == found.max_difference else None,
        "tolerance": found.tolerance,
        "text": f"{file.name}{_moved(shift)}: {verdict}; largest difference {found.max_difference:.2g} "
        + (f"({found.method}, error below {found.error:.2g})" if found.method != "converged" else "(converged)"),
    }
