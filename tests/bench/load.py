"""A compare of 10,000 small jobs keeps its memory level: what the parent and its workers hold as jobs are done.

The parent keeps a record of each job, and no picture. `make load` fails where either grows by more than its bound."""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aliascope import jobs, pipeline, scene_io
from aliascope.store import Store
from aliascope.workers import Workers

MODE = "uniform:n=1,sampler=random"

PARENT_BOUND = 4096.0
"""Bytes a job, of the record of what became of it (measured: 1,500)."""
WORKERS_BOUND = 512.0
"""Bytes a job, of all workers together, which have nothing to keep: less than the smallest picture."""


@dataclass(frozen=True)
class Level:
    """Bytes that are held, neither of files nor shared, when so many jobs have begun."""

    begun: int
    parent: int
    workers: int


def anonymous_bytes(process: str) -> int:
    """Of a process; 0 of one that has just ended."""
    try:
        lines = Path(f"/proc/{process}/status").read_text(encoding="utf-8").splitlines()
    except OSError:
        return 0
    return sum(int(line.split()[1]) * 1024 for line in lines if line.startswith("RssAnon"))


def _children() -> list[str]:
    return [
        child
        for thread in Path("/proc/self/task").iterdir()
        for child in (thread / "children").read_text(encoding="utf-8").split()
    ]


def levels(count: int, at: list[int], size: tuple[int, int], processes: int) -> list[Level]:
    """Renders one scene with so many seeds, and says what is held when these of the jobs begin."""
    plan = jobs.make_plan([scene_io.load("edge")], {"embree": [MODE]}, count, size)
    found: dict[int, Level] = {}

    def progress(_job: object, done: int, _all: int) -> None:
        if done in at and done not in found:
            found[done] = Level(done, anonymous_bytes("self"), sum(map(anonymous_bytes, _children())))

    black = np.zeros((size[1], size[0], 3), dtype=np.float32)  # what the pictures are judged by is all one here
    references = {jobs.judged_by(job): black for job in plan.jobs}
    options = pipeline.Options(processes, least_seconds=0.0)
    with (
        tempfile.TemporaryDirectory() as name,
        Workers(processes) as workers,
        Store(Path(name) / "results.sqlite") as store,
    ):
        store.begin_run("", "", "", {}, {})
        outcomes, _ = pipeline.execute(plan, Path(name), store, references, options, progress, workers)
    if sum(outcome.status == "done" for outcome in outcomes.values()) != count:
        raise RuntimeError("jobs are missing, or failed")
    return [found[begun] for begun in sorted(found)]


def growth(first: Level, last: Level) -> tuple[float, float]:
    """Bytes a job, of the parent and of the workers."""
    more = last.begun - first.begun
    return (last.parent - first.parent) / more, (last.workers - first.workers) / more


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=10_000)
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    shares = (0.1, 0.2, 0.5, 1.0)
    at = [min(round(share * given.jobs), given.jobs - 1) for share in shares]
    found = levels(given.jobs, at, (8, 6), given.processes)
    for level in found:
        print(f"{level.begun:7d} jobs: parent {level.parent / 2**20:.1f} MiB, workers {level.workers / 2**20:.1f} MiB")
    parent, workers = growth(found[1], found[-1])
    print(f"from {found[1].begun} on: {parent:.0f} bytes a job in the parent (at most {PARENT_BOUND:.0f}),")
    print(f"{workers:.0f} in the workers (at most {WORKERS_BOUND:.0f})")
    return 0 if parent < PARENT_BOUND and workers < WORKERS_BOUND else 1


if __name__ == "__main__":
    sys.exit(main())
