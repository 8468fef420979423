"""What a plan would move where on a cluster, and how much: `aliascope compare --explain`."""

from __future__ import annotations

import pickle
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from aliascope import store
from aliascope.cluster.work import Sent
from aliascope.jobs import Plan, has_sampler, mode_of
from aliascope.pipeline import Options
from aliascope.records import Job

FLOAT = 4
"""Bytes of a channel, and of a count."""


def document(plan: Plan, folder: Path, options: Options, unable: Mapping[str, str]) -> dict[str, Any]:
    """Bytes and CPU seconds of a plan. folder: where results may lie that know costs; unable: of a cluster, renderers
    that no worker can draw with, and why."""
    counts = Counter(job.renderer for job in plan.jobs)
    drawn = {job.scene for job in plan.jobs}
    scenes = {name: len(pickle.dumps(file)) for name, file in plan.files.items() if name in drawn}
    known = store.costs(folder / "results.sqlite")
    costs = [known.get((job.scene, job.renderer, job.mode)) for job in plan.jobs]
    told = [cost for cost in costs if cost is not None]
    request = len(_request(plan.jobs[0], options)) if plan.jobs else 0
    return {
        "jobs": dict(counts),
        "scene_bytes": scenes,
        "scene_bytes_a_worker": sum(scenes.values()),
        "request_bytes_a_job": request,
        "request_bytes": request * len(plan.jobs),
        "picture_bytes": sum(map(_picture, plan.jobs)),
        "cpu_seconds_known": sum(told),
        "jobs_of_known_cost": len(told),
        "without_worker": {name: {"jobs": counts[name], "reason": reason} for name, reason in unable.items()},
        "skipped": dict(plan.skipped),
        "empty_cells": len(plan.empty),
    }


def _request(job: Job, options: Options) -> bytes:
    versions = {"renderer": "0.0.0", "code": "0" * 16}
    return pickle.dumps(Sent(job, options, has_sampler(mode_of(job)), versions, 0.0))


def _picture(job: Job) -> int:
    """Three channels, and the counts of adaptive modes."""
    channels = 4 if mode_of(job).name == "adaptive" else 3
    return FLOAT * channels * job.width * job.height


def lines(told: Mapping[str, Any]) -> list[str]:
    """For a person."""
    jobs = sum(told["jobs"].values())
    found = [f"{count} jobs of {name}" for name, count in told["jobs"].items()]
    found.append(
        f"to each worker, once: {_bytes(told['scene_bytes_a_worker'])} of {len(told['scene_bytes'])} scenes at most; "
        f"with each job: {_bytes(told['request_bytes_a_job'])}, {_bytes(told['request_bytes'])} in all"
    )
    found.append(f"back, to this machine alone: {_bytes(told['picture_bytes'])} of {jobs} pictures")
    if told["jobs_of_known_cost"]:
        found.append(
            f"{told['cpu_seconds_known']:.3g} s of CPU time for the {told['jobs_of_known_cost']} jobs whose modes have "
            "been timed here before"
        )
    else:
        found.append("CPU time: not known, as no mode of these has been timed in this folder")
    found += [f"{why['jobs']} jobs would fail: {why['reason']}" for why in told["without_worker"].values()]
    found += [f"skipped {name}: {reason}" for name, reason in told["skipped"].items()]
    if told["empty_cells"]:
        found.append(f"{told['empty_cells']} cells stay empty, as nothing draws them: --dry-run says why")
    return found


def _bytes(count: float) -> str:
    units = ["B", "kB", "MB", "GB", "TB"]
    while count >= 1000.0 and len(units) > 1:
        count /= 1000.0
        del units[0]
    return f"{count:.3g} {units[0]}"
