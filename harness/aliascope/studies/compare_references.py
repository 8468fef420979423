"""What the pictures of a comparison are judged by: references of the project, and those that are made beside it."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Callable
from pathlib import Path

from aliascope import jobs, logs, places, references
from aliascope.draws import UNMOVED, text_of
from aliascope.errors import CheckFailed, JobFailed, Unsupported
from aliascope.jobs import Judged, Plan
from aliascope.pipeline import Progress, sha256_of
from aliascope.plan import FILTERS
from aliascope.references import Reference
from aliascope.references import files as reference_files
from aliascope.references.converged import Apart
from aliascope.store import Store
from aliascope.studies.converging import apart, converging


def references_of(
    plan: Plan,
    folder: Path,
    progress: Progress,
    tell: Callable[[str], None],
    store: Store | None = None,
    judged: dict[Judged, Reference] | None = None,
    lost: dict[tuple[str, str], JobFailed] | None = None,
) -> tuple[dict[Judged, Reference], Plan]:
    """What the pictures of a plan are judged by, and the plan without the pictures that are moved on the film where an
    exact method refuses: what would have to be converged for them costs more than they are worth. They are in `judged`
    as soon as they are there. A scene and filter whose reference cannot be made, since Embree crashes for instance, is
    told, and in `lost`. Raises what was wrong where that leaves nothing."""
    judged, lost = {} if judged is None else judged, {} if lost is None else lost
    with apart() as draw:
        for key, size in {jobs.judged_by(job): (job.width, job.height) for job in plan.jobs}.items():
            try:
                judged[key] = reference_of(plan, key, size, folder, progress, tell, store, draw)
            except Unsupported:
                if key[2] == UNMOVED:
                    raise
                plan = jobs.without(plan, key)
            except JobFailed as error:
                lost[key[:2]] = error
                tell(f"{key[0]}, filter {key[1]}: {error}; its pictures are not rendered, as nothing judges them")
            for each in [each for each in judged if each[:2] in lost]:  # elsewhere on the film, where a method is exact
                del judged[each]
    if lost and not judged:
        raise next(iter(lost.values()))
    return judged, plan


def reference_of(
    plan: Plan,
    key: Judged,
    size: tuple[int, int],
    folder: Path,
    progress: Progress,
    tell: Callable[[str], None],
    store: Store | None = None,
    draw: Apart | None = None,
) -> Reference:
    """The kept reference of a scene of the project at its own size, of a filter that the profiles judge. Any other is
    made now and kept in `folder`, its hash in the store: exact where there is a method, else converged. Raises
    Unsupported where one that is moved on the film has no exact method."""
    name, filter_, shift = key
    file = plan.files[name]
    kept = shift == UNMOVED or reference_files.path_of(places.REFERENCES, name, size, filter_, shift).is_file()
    if kept and file.path.parent == places.SCENES and size == file.scene.view.size and filter_ in ("box", *FILTERS):
        return reference_files.load(places.REFERENCES, name, file.scene, size, filter_, shift)
    path = reference_files.path_of(folder, name, size, filter_, shift)
    if path.is_file():
        try:
            _check_bytes(path, folder, store)
            found = reference_files.load(folder, name, file.scene, size, filter_, shift)
            _note(path, folder, store)
            return found
        except CheckFailed as error:  # of an earlier version of the scene, or not what was written
            tell(str(error).partition("; ")[0])
    what = f"reference of {name}, {size[0]} x {size[1]} pixels, filter {filter_}"
    if shift != UNMOVED:
        what += f", shifted by {text_of(shift)}"
    progress(what, 0, 1)
    begun = time.monotonic()
    converged = references.Plan(threads=len(os.sched_getaffinity(0)), tell=converging(what, progress), apart=draw)
    made = references.make(file.scene, size, filter_, converged if shift == UNMOVED else None, shift)
    _note(reference_files.save(folder, name, file.scene, size, filter_, made, shift), folder, store)
    seconds = time.monotonic() - begun
    text = f"{what}: {made.method}, {seconds:.1f} s"
    logs.event(logging.INFO, "reference", text, scene=name, filter=filter_, shift=shift, seconds=round(seconds, 3))
    return made


def _check_bytes(path: Path, folder: Path, store: Store | None) -> None:
    """Raises CheckFailed for a reference whose files are not what was written."""
    for each in reference_files.files_of(path):
        kept = store.file(str(each.relative_to(folder.parent))) if store is not None else None
        if kept is not None and sha256_of(each) != kept:
            raise CheckFailed(f"{each}: was changed since it was made; it is made again")


def _note(path: Path, folder: Path, store: Store | None) -> None:
    """Keeps the hashes of a reference that was made or checked."""
    if store is not None:
        found = reference_files.files_of(path)
        store.put_files({str(each.relative_to(folder.parent)): sha256_of(each) for each in found})
