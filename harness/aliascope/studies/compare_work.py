"""The work of a comparison, which may be interrupted at any time: what there is then is measured and can be told."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from aliascope import jobs, metrics, pipeline, sharing
from aliascope.cluster.client import Cluster
from aliascope.errors import JobFailed
from aliascope.interrupts import Interrupts
from aliascope.jobs import Judged, Plan
from aliascope.pipeline import Kept, Options, Progress
from aliascope.records import Job, Outcome, Probe
from aliascope.references import Reference
from aliascope.store import Store
from aliascope.studies import probes
from aliascope.studies.compare_references import references_of
from aliascope.workers import Workers


class Work:
    """What there is of a comparison so far: references, outcomes, probes. `plan` has the jobs that the outcomes are of
    once it is done or concluded."""

    def __init__(
        self,
        plan: Plan,
        folder: Path,
        options: Options,
        store: Store,
        progress: Progress,
        tell: Callable[[str], None],
        interrupts: Interrupts,
        cluster: Cluster | None = None,
    ) -> None:
        self.plan, self.folder, self.options, self.store = plan, folder, options, store
        self.judged: dict[Judged, Reference] = {}
        self._lost: dict[tuple[str, str], JobFailed] = {}
        self.kept = Kept({}, 0, 0)
        self.probed: tuple[Probe, ...] = ()
        self._progress, self._tell, self._interrupts, self._cluster = progress, tell, interrupts, cluster
        self._begun, self._wanted, self._interrupted = False, len(plan.jobs), False

    def do(self) -> None:
        """All of it. Raises what `compare` raises, and KeyboardInterrupt."""
        here = Workers(self.options.processes)
        with self._cluster or here as workers, Workers(len(os.sched_getaffinity(0))) as measurers:
            if workers.elsewhere:
                self.options = replace(self.options, processes=workers.processes)
            folder, watched, judged, lost = self.folder / "references", self._watched, self.judged, self._lost
            _, self.plan = references_of(self.plan, folder, watched, self._tell, self.store, judged, lost)
            pixels = {key: reference.pixels for key, reference in judged.items()}
            self._look()
            plan, store, options = self.plan, self.store, self.options
            pipeline.execute(plan, self.folder, store, pixels, options, self._watched, workers, measurers, self.kept)
            outcomes = self.kept.outcomes.values()
            probers = measurers if workers.elsewhere else workers
            self.probed = probes.of_those_that_drew(outcomes, plan.skipped, store, options, self._watched, probers)

    def conclude(self) -> None:
        """After an interruption: measures what is rendered and leaves out what is not, or was interrupted while it was
        measured."""
        self._interrupted = True
        self.plan = self._with(lambda job: jobs.judged_by(job) in self.judged or self._why_lost(job) is not None)
        if not self._begun:
            self._look()
        if not self.kept.rendered:
            pixels = {key: reference.pixels for key, reference in self.judged.items()}
            self._progress("interrupted: measuring what is finished; Ctrl-C again ends at once", 0, 1)
            with Workers(len(os.sched_getaffinity(0))) as measurers:
                pipeline.measure_rest(
                    self.plan, self.folder, self.store, pixels, self.options, self._progress, measurers, self.kept
                )
        self.kept.outcomes = {key: each for key, each in self.kept.outcomes.items() if _told(each)}
        there = self.kept.outcomes
        self.plan = self._with(lambda job: job.key in there)
        drawn = {jobs.judged_by(job)[:2] for job in self.plan.jobs}
        self.judged = {key: each for key, each in self.judged.items() if key[:2] in drawn}
        self.probed = probes.of_those_that_drew(
            there.values(), self.plan.skipped, self.store, self.options, self._progress, None
        )
        self._progress("interrupted: writing the report of what is finished; Ctrl-C again ends at once", 0, 1)

    def notes(self) -> tuple[str, ...]:
        """What the report says before all else."""
        if not self._interrupted:
            return ()
        done = sum(each.status == "done" for each in self.kept.outcomes.values())
        return (f"Interrupted: {done} of {self._wanted} pictures were finished, and are all that is told of here.",)

    def again(self, job: Job) -> str:
        """The command that does again, alone, what a job failed by: its picture, or the reference that it lost."""
        if self._why_lost(job) is None:
            return pipeline.repeat_command(job, self.options.time_limit)
        size, filter_ = f"{job.width}x{job.height}", jobs.judged_by(job)[1]
        words = ["aliascope", "reference", pipeline.scene_word(job), "--size", size, "--filter", filter_]
        return sharing.command_line([*words, "-o", "references"])

    def rendered(self) -> int:
        """How many jobs this run rendered, or tried to."""
        lost = sum(self._why_lost(job) is not None for job in self.plan.jobs)
        return len(self.kept.outcomes) - self.kept.reused - lost

    def _look(self) -> None:
        """What the folder has already, and what cannot be: the pictures that lost their reference. The store keeps them
        as they are, for a run that has it."""
        judged = self._with(lambda job: self._why_lost(job) is None)
        self.kept = pipeline.kept_of(judged, self.folder, self.store, self.options)
        for job in self.plan.jobs:
            if (why := self._why_lost(job)) is not None:
                self.kept.outcomes[job.key] = Outcome(job, "failed", sharing.shared(str(why)))
        self._begun = True

    def _with(self, wanted: Callable[[Job], bool]) -> Plan:
        return replace(self.plan, jobs=tuple(job for job in self.plan.jobs if wanted(job)))

    def _why_lost(self, job: Job) -> JobFailed | None:
        return self._lost.get(jobs.judged_by(job)[:2])

    def _watched(self, what: Job | str | None, done: int, total: int) -> None:
        self._interrupts.check()
        self._progress(what, done, total)


def _told(outcome: Outcome) -> bool:
    return outcome.status == "failed" or set(outcome.metrics) >= set(metrics.METRICS)
