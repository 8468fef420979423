"""The harness's own wall time a job, beyond rendering and measuring: sending it to its worker, fetching the picture,
writing it as EXR, and keeping its figures; and the CPU time of measuring a picture by every metric."""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from aliascope import draws, jobs, metrics, pipeline, references, scene_io
from aliascope.store import Store
from aliascope.workers import Workers

JOBS = 300
PICTURES = 30


def jobs_of_one_process() -> None:
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


def measuring() -> None:
    """Of 128 x 96 pixels of noise; the first loads what the metrics need."""
    rng = np.random.default_rng(6)
    image, reference = (rng.random((96, 128, 3), dtype=np.float32) for _ in range(2))
    spent = []
    for _ in range(PICTURES + 1):
        begun = time.process_time()
        for metric in metrics.METRICS.values():
            metric(image, reference)
        spent.append(1e3 * (time.process_time() - begun))
    print(f"a picture of 128 x 96 pixels by {len(metrics.METRICS)} metrics, {PICTURES} times")
    print(f"  median {statistics.median(spent[1:]):6.2f} ms")


if __name__ == "__main__":
    jobs_of_one_process()
    measuring()
