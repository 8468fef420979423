"""Runs of regression as `aliascope regress` would hand them over, made up."""

from __future__ import annotations

import datetime
from collections.abc import Mapping, Sequence
from pathlib import Path

from aliascope import history
from aliascope.history import KeptRun
from aliascope.regression.records import CellName, CellVerdict, Check, Draw, Observed, Replicate, Run

MACHINE = {"processor": "One", "cores": "2", "system": "Linux 6.1"}
OTHER = {"processor": "Other", "cores": "8", "system": "Linux 6.1"}
VERSIONS = {"embree": "3.13.5"}
EDGE = CellName("edge", "embree", "uniform:n=16")
Drawn = Mapping[CellName, "Observed | str"]
__all__ = ["EDGE", "MACHINE", "OTHER", "kept", "observed", "run"]


def observed(
    name: CellName,
    errors: Sequence[float | None] = (0.01, 0.02),
    seconds: Sequence[float] = (0.5, 0.7),
    samples: int = 100,
    rays: Mapping[str, int] | None = None,
    first_seed: int = 0,
    digest: str = "scene",
    versions: Mapping[str, str] | None = None,
) -> Observed:
    """Of as many replicates as there are errors."""
    replicates = tuple(
        Replicate(
            Draw(first_seed + i),
            f"{i}",
            (),
            (),
            error,
            (),
            0.0,
            1.0,
            0,
            0.0,
            samples,
            rays or {"primary": samples},
            time,
        )
        for i, (error, time) in enumerate(zip(errors, seconds, strict=True))
    )
    return Observed(name, "reference", digest, (64, 48), "box", (), replicates, (), (), 0.0, versions or {})


def run(
    index: int,
    cells: Drawn,
    revision: str | None = None,
    machine: Mapping[str, str] = MACHINE,
    versions: Mapping[str, str] = VERSIONS,
    failed: Sequence[CellName] = (),
) -> Run:
    """The run of day `index`; a text for a cell is its problem."""
    started = datetime.datetime(2026, 1, 1, 12, tzinfo=datetime.UTC) + datetime.timedelta(days=index)
    verdicts = tuple(
        CellVerdict(name, problem=seen)
        if isinstance(seen, str)
        else CellVerdict(name, (Check(name, "cost", "samples", 1.0, 1.0, "", name not in failed),), observed=seen)
        for name, seen in cells.items()
    )
    name = revision if revision is not None else f"{index:012x}"
    return Run(started.isoformat(), 9.0, name, machine, versions, "aliascope regress", 0.001, 5, 2, verdicts, ())


def kept(folder: Path, runs: Sequence[Run]) -> tuple[KeptRun, ...]:
    """The runs, once written and read."""
    path = folder / "history.sqlite"
    path.unlink(missing_ok=True)
    for each in runs:
        history.add(path, each)
    return history.load(path)
