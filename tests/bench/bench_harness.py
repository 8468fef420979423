"""The harness's own wall time a job, beyond rendering and measuring: sending it to its worker, fetching the picture,
writing it as EXR, and keeping its figures."""

from __future__ import annotations

import statistics
import sys
import tempfile
from pathlib import Path

from aliascope import draws, jobs, pipeline, references, scene_io
from aliascope.store import Store
from aliascope.workers import Workers

JOBS = 300


def main() -> None:
    file = scene_io.load("edge")
    plan = jobs.make_plan([file], {"embree": ["uniform:n=1"]}, seeds=JOBS)
    pixels = {("edge", "box", draws.UNMOVED): references.make(file.scene, file.scene.view.size).pixels}
    with (
        tempfile.TemporaryDirectory() as folder,
        Store(Path(folder) / "results.sqlite") as store,
        Workers(1) as workers,
    ):
        store.begin_run("", "bench", "", {}, {})
        options = pipeline.Options(least_seconds=0.0)
        outcomes, _ = pipeline.execute(plan, Path(folder), store, pixels, options, lambda *_: None, workers)
    failed = [outcome.message for outcome in outcomes.values() if outcome.status != "done"]
    if failed:
        sys.exit(f"a job failed: {failed[0]}")
    # The first job of a worker waits for its interpreter to start.
    spent = sorted(1e3 * outcome.harness_seconds for outcome in list(outcomes.values())[1:])
    print(f"the harness's own time a job, {JOBS} jobs of one process")
    print(f"  median {statistics.median(spent):6.2f} ms   95 % below {spent[int(0.95 * len(spent))]:6.2f} ms")


if __name__ == "__main__":
    main()
