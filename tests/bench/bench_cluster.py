"""Jobs a second on a cluster of 1, 2 and 4 workers of this machine, the bytes that each job moves, and what the memory
of the scheduler and of the parent does meanwhile: `bench_cluster.py [JOBS]`."""

from __future__ import annotations

import json
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from aliascope import jobs, scene_io
from aliascope.cluster import work
from aliascope.cluster.address import Tls
from aliascope.cluster.client import Cluster
from aliascope.jobs import Plan
from aliascope.pipeline import Options, Timed, render_job
from aliascope.workers import Task, first_done

WORKERS = (1, 2, 4)
STARTING = 600.0


@contextmanager
def scheduler(folder: Path) -> Iterator[tuple[str, int]]:
    """Its address, and its process."""
    told = folder / "scheduler.json"
    words = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show", "--scheduler-file", str(told)]
    with _program("-m", "distributed.cli.dask_scheduler", *words) as process:
        _until(told.is_file)
        time.sleep(0.5)
        yield json.loads(told.read_text())["address"], process


@contextmanager
def _program(*words: str) -> Iterator[int]:
    process = subprocess.Popen([sys.executable, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process.pid
    finally:
        process.terminate()
        process.wait()


def _until(condition: object) -> None:
    begun = time.monotonic()
    while not condition():  # type: ignore[operator]
        if time.monotonic() - begun > STARTING:
            sys.exit("nothing began")
        time.sleep(0.1)


def megabytes(process: int | str) -> float:
    """What a process has in memory."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("VmRSS")).split()[1]) / 1e3


def cpu_seconds(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / 100.0


def run(there: Cluster, plan: Plan, count: int) -> list[int]:
    """Has so many of the jobs done; the bytes of what came back of each."""
    waiting: list[Task[Timed]] = []
    sizes: list[int] = []
    for job in plan.jobs[:count]:
        while len(waiting) >= there.window:
            sizes.append(len(pickle.dumps(waiting.pop(first_done(waiting)).result())))
        options = Options(least_seconds=0.0)
        waiting.append(there.begin(render_job, [plan.files[job.scene], job, options], options.time_limit))
    sizes += [len(pickle.dumps(task.result())) for task in waiting]
    return sizes


def main(count: int) -> None:
    plan = jobs.make_plan([scene_io.load("edge")], {"embree": ["uniform:n=1"]}, seeds=count)
    job, own = plan.jobs[0], jobs.renderer_versions("embree")
    sent = work.Sent(job, Options(), True, {**own, "code": jobs.code_of_kind("embree", True)}, 120.0)
    print(f"{count} jobs of {job.width} x {job.height} pixels, 1 sample each")
    print(
        f"  scene {len(pickle.dumps(plan.files['edge']))} bytes a worker, request {len(pickle.dumps(sent))} bytes a job"
    )
    print("  workers   jobs/s   bytes back a job   scheduler ms a job   MB of scheduler, parent: after 10 %, after all")
    for workers in WORKERS:
        with tempfile.TemporaryDirectory() as folder, scheduler(Path(folder)) as (address, process):
            words = ["-m", "aliascope.cli", "worker", address, "-j", str(workers), "--without", "povray"]
            with _program(*words, "--without", "osmesa"):
                _wait_for(address, workers)
                with Cluster(address, Tls(), plan, lambda _: None) as there:
                    run(there, plan, 4 * workers)  # each begins a process
                    before = cpu_seconds(process)
                    begun = time.perf_counter()
                    first = run(there, plan, count // 10)
                    early = megabytes(process), megabytes("self")
                    sizes = first + run(there, plan, count - count // 10)
                    spent = time.perf_counter() - begun
                    late = megabytes(process), megabytes("self")
                    scheduled = 1e3 * (cpu_seconds(process) - before) / len(sizes)
        told = ", ".join(f"{now:.0f}" for now in early) + "; " + ", ".join(f"{now:.0f}" for now in late)
        back = sum(sizes) / len(sizes)
        print(f"  {workers:7d} {len(sizes) / spent:8.1f} {back:18.0f} {scheduled:20.2f}   {told}", flush=True)


def _wait_for(address: str, workers: int) -> None:
    import distributed

    with distributed.Client(address, set_as_default=False) as client:
        client.wait_for_workers(workers, timeout=STARTING)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
