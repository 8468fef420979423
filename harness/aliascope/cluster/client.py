"""Sends jobs to a cluster, with the interface of `workers.Workers`."""

from __future__ import annotations

import asyncio
import hashlib
import logging
import pickle
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from types import TracebackType
from typing import Any, TypeVar

from aliascope import jobs, logs
from aliascope.cluster import address as addresses
from aliascope.cluster import work
from aliascope.cluster.address import Tls
from aliascope.errors import AliascopeError, JobFailed, NotAvailable
from aliascope.jobs import Plan
from aliascope.pipeline import Options, Timed, render_job
from aliascope.records import Job
from aliascope.scene_io import SceneFile
from aliascope.workers import ProcessEnded, Task, patience

Result = TypeVar("Result")

CONNECTING = 20.0
"""Seconds in which the scheduler has to answer."""
LOOK = 5.0
"""Seconds between two looks at which workers there are, while something is waited for."""
AWAY = 60.0
"""Seconds for which no worker that can do a job may be there, once there was one: a nanny starts an ended one again."""
ATTEMPTS = 2
"""Workers whose process a job may end before it has failed."""
AHEAD = 2
"""Jobs for each worker that are on their way at once: the one that it does, and the next. Whatever a plan has of jobs,
no more than these, and their pictures, are anywhere but here."""


@dataclass(frozen=True)
class _Worker:
    about: work.About
    resources: frozenset[str]


class Cluster:
    """The workers of a cluster, as `workers.Workers` has those of this machine. Use as a context manager: what is not
    done when it ends is dropped.

    Raises NotAvailable where there is no scheduler, or no worker of ours, InvalidInput for an address or TLS that can't
    be read. `tell` is given what a user has to know.
    """

    elsewhere = True

    def __init__(self, address: str, tls: Tls, plan: Plan, tell: Callable[[str], None]) -> None:
        self._address, self._plan, self._tell = addresses.checked(address, tls), plan, tell
        self._distributed = addresses.distributed()
        self._security = addresses.security(address, tls, self._distributed, "client")
        self._known: dict[str, _Worker] = {}
        self._looked = 0.0
        self._seen: dict[str, float] = {}
        self._scenes: dict[str, bytes] = {}
        self._held: dict[str, Any] = {}
        self._plugins: list[bytes] = []

    def _reach(self) -> None:
        """In a thread of its own: where this one has a loop that runs, as a notebook's has, no other can."""
        with ThreadPoolExecutor(1) as alone:
            reaching = addresses.reach(self._address, self._security, self._distributed, "client", CONNECTING)
            alone.submit(asyncio.run, reaching).result()

    def __enter__(self) -> Cluster:
        try:
            self._reach()
            self._client = self._distributed.Client(
                self._address,
                security=self._security,
                timeout=CONNECTING,
                set_as_default=False,
                direct_to_workers=True,  # pictures do not pass through the scheduler
                name="aliascope",
            )
        except (OSError, TimeoutError, ValueError, RuntimeError) as error:
            raise addresses.no_scheduler(self._address, error) from error
        self._loop = self._client.loop.asyncio_loop
        self._lock = asyncio.Lock()
        try:
            self._plugins = [pickle.dumps(each) for each in work.plugins_sent()]
            asyncio.run_coroutine_threadsafe(self._look(), self._loop).result()
            if not self._known:
                raise NotAvailable(
                    f"the scheduler at {self._address} has no worker of aliascope: on each machine, "
                    f"`aliascope worker {self._address}`"
                )
        except BaseException:
            self._client.close()
            raise
        self._say_who_does_what()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._held.clear()
        self._client.close()  # the scheduler drops what no client wants

    @property
    def window(self) -> int:
        """Jobs that are on their way at once."""
        return AHEAD * max(1, len(self._known))

    @property
    def processes(self) -> int:
        """Jobs that run side by side on one machine, at most."""
        return max(self._side_by_side().values())

    def _side_by_side(self) -> Counter[str]:
        return Counter(each.about.machine.identity for each in self._known.values())

    def machines(self) -> dict[str, int]:
        """The machines, and how many workers each has."""
        return dict(Counter(str(each.about.machine) for each in self._known.values()))

    def without_worker(self) -> dict[str, str]:
        """Of the plan's renderers those that no worker can draw with, and why."""
        kinds = {(job.renderer, jobs.has_sampler(jobs.mode_of(job))) for job in self._plan.jobs}
        found = {}
        for renderer, with_samplers in sorted(kinds):
            versions = self._versions(renderer, with_samplers)
            if not self._able(work.resource(renderer, versions)):
                found[renderer] = self._why_none(renderer, with_samplers, versions)
        return found

    def _say_who_does_what(self) -> None:
        for machine, count in self.machines().items():
            self._tell(f"{count} worker{'' if count == 1 else 's'} on {machine}")
        for renderer in dict.fromkeys(job.renderer for job in self._plan.jobs):
            versions = self._versions(renderer, True)
            for where, each in self._known.items():
                own = each.about.versions.get(renderer)
                if own is not None and own[work.kind_of(True)] != versions:
                    other = work.difference(own[work.kind_of(True)], versions)
                    self._tell(f"{where} on {each.about.machine.name} gets no jobs of {renderer}: it has {other}")

    # --- jobs ---------------------------------------------------------------------------------------------------------

    def begin(
        self,
        task: Callable[..., Result],
        arguments: Sequence[Any],
        time_limit: float,
        about: logs.About | None = None,
    ) -> Task[Result]:
        """As `workers.Workers.begin`; the one task that goes to a cluster is `pipeline.render_job`. Raises NotAvailable
        where the scheduler has gone."""
        if task is not render_job:
            raise TypeError(f"{task.__name__} is not done on a cluster")
        if self._client.status != "running":
            raise NotAvailable(
                f"the scheduler at {self._address} has gone; what was finished is kept, and the same command goes on"
            )
        file, job, options = arguments
        future: Future[logs.Answer] = asyncio.run_coroutine_threadsafe(
            self._carried(self._packed(file), job, options, time_limit, about or {}), self._loop
        )
        return Task(future, patience(time_limit), about=about)

    def _packed(self, file: SceneFile) -> bytes:
        if file.name not in self._scenes:
            self._scenes[file.name] = pickle.dumps(file, protocol=pickle.HIGHEST_PROTOCOL)
        return self._scenes[file.name]

    def _versions(self, renderer: str, with_samplers: bool) -> dict[str, str]:
        own = jobs.renderer_versions(renderer)
        return {**own, "code": jobs.code_of_kind(renderer, with_samplers)}

    async def _carried(self, scene: bytes, job: Job, options: Options, limit: float, about: logs.About) -> logs.Answer:
        """A job, done; again where a worker's process ended."""
        with_samplers = jobs.has_sampler(jobs.mode_of(job))
        versions = self._versions(job.renderer, with_samplers)
        need = work.resource(job.renderer, versions)
        packed = pickle.dumps(work.Sent(job, options, with_samplers, versions, limit))
        for attempt in range(1, ATTEMPTS + 1):
            await self._check_able(need, job.renderer, with_samplers, versions)
            future = self._submitted(need, scene, packed, f"{job.key}-{attempt}")
            try:
                answer = await self._result(future, need, job.renderer, with_samplers, versions)
            finally:
                future.release()
            if not isinstance(answer.error, ProcessEnded):
                break
            if attempt == ATTEMPTS:
                return replace(answer, error=JobFailed(f"{answer.error}, on each of {ATTEMPTS} workers"))
            text = f"{answer.error} on {answer.place.worker}; it goes to a worker again"
            logs.event(logging.INFO, "retry", text, **{**about, **answer.place.told()})
        if answer.error is not None:
            return answer
        timed: Timed = answer.result
        assert timed.machine is not None
        side_by_side = self._side_by_side()[timed.machine.identity]
        return replace(answer, result=replace(timed, processes=max(1, side_by_side)))

    def _submitted(self, need: str, scene: bytes, packed: bytes, name: str) -> Any:
        held = [self._held_once(each) for each in (scene, *self._plugins)]
        return self._client.submit(
            work.perform,
            held[0],
            held[1:],
            packed,
            key=f"aliascope-{name}-{self._client.id}",
            resources={need: 1},
            pure=False,
        )

    def _held_once(self, packed: bytes) -> Any:
        """What jobs depend on: it goes to one worker, and from there to each other that has a job for it, once. The
        scheduler has it too, and gives it anew where the workers that had it end."""
        import dask

        digest = hashlib.sha256(packed).hexdigest()
        if digest not in self._held:
            with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 TB"}):
                self._held[digest] = self._client.submit(
                    work.hold, packed, key=f"aliascope-held-{digest}", resources={work.ANY: 1}, priority=1
                )
        return self._held[digest]

    async def _result(
        self, future: Any, need: str, renderer: str, with_samplers: bool, versions: Mapping[str, str]
    ) -> logs.Answer:
        """Waits for it, as long as there is a worker that can do it. Raises AliascopeError."""
        gathered = asyncio.ensure_future(future.result())
        try:
            while not (await asyncio.wait({gathered}, timeout=LOOK))[0]:
                await self._check_able(need, renderer, with_samplers, versions)
            answer: logs.Answer = pickle.loads(gathered.result())
            return answer
        except AliascopeError:
            raise
        except self._distributed.KilledWorker as error:
            raise JobFailed(
                f"its workers ended, {error.allowed_failures + 1} of them: is there too little memory for it?"
            ) from error
        except Exception as error:  # whatever an unlike worker or the way there raises
            raise JobFailed(f"lost on the way: {type(error).__name__}: {' '.join(str(error).split())[:200]}") from error
        finally:
            gathered.cancel()

    # --- workers ------------------------------------------------------------------------------------------------------

    async def _look(self) -> None:
        """Which workers there are, asked of the scheduler at most every LOOK seconds."""
        async with self._lock:
            if self._looked and time.monotonic() - self._looked < LOOK:
                return
            told = await self._client.scheduler.identity(n_workers=-1)
            self._looked = time.monotonic()
            self._known = {}
            for where, worker in told["workers"].items():
                if work.ANY in worker:
                    about = work.of_document(worker[work.ANY])
                    self._known[where] = _Worker(about, frozenset(worker["resources"]))
            for need in {name for worker in self._known.values() for name in worker.resources}:
                self._seen[need] = self._looked

    def _able(self, need: str) -> bool:
        return any(need in worker.resources for worker in self._known.values())

    async def _check_able(self, need: str, renderer: str, with_samplers: bool, versions: Mapping[str, str]) -> None:
        """Waits for a worker that can do it, where there was one. Raises JobFailed where there is none."""
        while True:
            if not self._able(need) or time.monotonic() - self._looked > LOOK:
                try:
                    await self._look()
                except OSError as error:
                    raise JobFailed(f"the scheduler at {self._address} does not answer") from error
            if self._able(need):
                return
            if time.monotonic() - self._seen.get(need, -AWAY) >= AWAY:
                raise JobFailed(self._why_none(renderer, with_samplers, versions))
            await asyncio.sleep(LOOK / 10.0)

    def _why_none(self, renderer: str, with_samplers: bool, versions: Mapping[str, str]) -> str:
        kind, reasons = work.kind_of(with_samplers), []
        for worker in self._known.values():
            about = worker.about
            if renderer in about.versions:
                reasons.append(f"{about.machine.name} has {work.difference(about.versions[renderer][kind], versions)}")
            else:
                reasons.append(f"{about.machine.name}: {about.absent.get(renderer, 'it was not added with -r')}")
        told = "; ".join(dict.fromkeys(reasons)) or "all workers have ended"
        return f"no worker can draw with {renderer}: {told}"
