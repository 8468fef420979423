"""Worker processes: what crashes or hangs in one is that task's failure, and no other's."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from concurrent.futures import TimeoutError as FutureTimeout
from multiprocessing import connection, resource_tracker
from types import SimpleNamespace, TracebackType
from typing import Any, Generic, Protocol, TypeVar

import pebble
import pebble.pool.process
from pebble import ProcessExpired, ProcessPool
from pebble.pool.base_pool import PoolStatus

from aliascope import at_start, logs
from aliascope.errors import JobFailed
from aliascope.interrupts import deferred
from aliascope.native import alone, samplers

Result = TypeVar("Result")

PIPE_PATIENCE = 600.0
"""Seconds that a process waits for its turn at the pipe to the parent before it ends itself. Pebble's 60 are too few
beside a parent that gets a hundredth of a busy machine."""

# Pebble takes the time of a task from the clock on the wall, which may be set while it runs.
pebble.pool.process.time = SimpleNamespace(time=time.monotonic, sleep=time.sleep)  # type: ignore[attr-defined,assignment]


RENEWALS = 4
"""How often in a row processes that end before they begin anything are started afresh."""
LOOK_EVERY = 1.0
"""Seconds between looks at whether the processes that are waited for are there."""


class ProcessEnded(JobFailed):
    """The process that did a task ended: by a signal, or by itself."""


class Task(Generic[Result]):
    """What a worker process was given to do. again: gives it to new ones, where the old have ended before they began
    it, or None where they are there. Its end is logged, where it is said what it is `about`."""

    def __init__(
        self,
        future: Future[logs.Answer],
        limit: float,
        again: Callable[[Future[logs.Answer]], Future[logs.Answer] | None] | None = None,
        about: logs.About | None = None,
    ) -> None:
        self._future, self._limit, self._again, self._about = future, limit, again, about
        future.add_done_callback(self._log)

    def done(self) -> bool:
        """Whether it has ended, well or not."""
        return bool(self._future.done())

    def result(self) -> Result:
        """Waits for the result. Raises what the task raises, and JobFailed where its process ended or took too long."""
        answer = self.answer()
        if answer.error is not None:
            raise answer.error
        result: Result = answer.result
        return result

    def answer(self) -> logs.Answer:
        """As `result`, with where it was done and what was logged there; an error of ours is in it."""
        while True:
            try:
                return self._future.result(LOOK_EVERY if self._again else None)
            except FutureTimeout as error:
                if self._future.done():
                    raise self._without_answer(error) from error
                self._renew()
            except ProcessExpired as error:
                raise self._without_answer(error) from error
            except BrokenExecutor as error:  # they ended before they began anything: there is no task to lay it to
                if not self._renew():
                    raise self._without_answer(error) from error

    def future(self) -> Future[logs.Answer]:
        """To wait for one of several."""
        return self._future

    def renew(self) -> None:
        """Has it begun anew where nobody does it. Raises JobFailed where that is in vain."""
        if not self.done():
            self._renew()

    def _renew(self) -> bool:
        future = self._again(self._future) if self._again else None
        if future is not None:
            self._future = future
            future.add_done_callback(self._log)
            logs.event(logging.INFO, "retry", "worker processes that had ended were replaced", **(self._about or {}))
        return future is not None

    def _without_answer(self, error: BaseException) -> JobFailed:
        """What became of its process."""
        if isinstance(error, FutureTimeout):
            return JobFailed(f"gave nothing within {self._limit:g} s and was ended")
        if isinstance(error, ProcessExpired):
            code = error.exitcode or 0
            how = f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
            return ProcessEnded(f"its process ended {how}")
        return JobFailed(_NONE_LIVES)

    def _log(self, future: Future[logs.Answer]) -> None:
        """Runs in a thread of the pool, when the task has ended; one that was not begun may be given again."""
        if self._about is None or future.cancelled():
            return
        error = future.exception()
        if error is None:
            logs.ended(self._about, future.result(), None)
        elif not isinstance(error, BrokenExecutor):
            process = {"process": error.pid} if isinstance(error, ProcessExpired) else {}
            known = isinstance(error, FutureTimeout | ProcessExpired)
            logs.ended({**self._about, **process}, None, self._without_answer(error) if known else error)


_NONE_LIVES = "the worker processes do not stay alive; is there too little memory?"


def first_done(tasks: Sequence[Task[Any]]) -> int:
    """Which of them has ended, the first that is found; waits for it. One alone is not waited for."""
    if len(tasks) == 1:
        return 0
    while True:
        for number, task in enumerate(tasks):
            if task.done():
                return number
        wait([task.future() for task in tasks], LOOK_EVERY, FIRST_COMPLETED)
        for number, task in enumerate(tasks):
            try:
                task.renew()
            except JobFailed:  # which its result raises too
                return number


def patience(time_limit: float) -> float:
    """Seconds after which a task's process is ended from outside: renderers should have given up by themselves."""
    return time_limit + min(20.0, max(2.0, time_limit / 2.0))


class Pool(Protocol):
    """What does tasks: processes here, or machines elsewhere (`cluster.client`)."""

    elsewhere: bool
    """Whether other machines do them."""

    @property
    def window(self) -> int:
        """How many jobs are on their way at once."""
        ...

    @property
    def processes(self) -> int:
        """How many run side by side on one machine, at most."""
        ...

    def begin(
        self,
        task: Callable[..., Result],
        arguments: Sequence[Any],
        time_limit: float,
        about: logs.About | None = None,
    ) -> Task[Result]:
        """Has a task done within `time_limit`, in seconds, and some patience. Its end is logged, where it is said what
        it is `about`."""
        ...


class Workers:
    """Processes that a crash or a time limit of one task leaves standing; started afresh, not forked, since the parent
    has threads, and only once there is a task. Use as a context manager: what is not done when it ends by an exception
    is dropped. plugins: in place of those that are loaded here."""

    elsewhere = False

    def __init__(self, processes: int, plugins: Sequence[samplers.Plugin] | None = None) -> None:
        self.window = self.processes = processes
        self._plugins = list(samplers.plugins() if plugins is None else plugins)
        _begin_tracker()
        self._renewals = 0
        self._pool = self._new_pool()

    def _new_pool(self) -> ProcessPool:
        return ProcessPool(
            max_workers=self.processes,
            context=multiprocessing.get_context("spawn"),
            initializer=_begin,
            initargs=(self._plugins, at_start.steps()),
        )

    def __enter__(self) -> Workers:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            try:
                self._pool.close()
                self._join()
                return
            except KeyboardInterrupt:
                self._stop()
                raise
        self._stop()

    def _stop(self) -> None:
        self._pool.stop()
        self._join()

    def _join(self) -> None:
        # Pebble removes the names of the semaphores before it ends the processes: one that begins right then, in place
        # of one that crashed for instance, would look for them, and complain.
        channel = self._pool._pool_manager.worker_manager.workers_channel
        names = None if channel is None else (channel.mutex.reader_mutex, channel.mutex.writer_mutex)
        self._pool.join()
        del names

    def begin(
        self, task: Callable[..., Result], arguments: Sequence[Any], time_limit: float, about: logs.About | None = None
    ) -> Task[Result]:
        """Has `task` done, by the first process that is free, within `time_limit`, in seconds, and some patience.
        `about`: what the log says of it; None for what is no job. Raises JobFailed where the processes do not stay
        alive."""
        limit = patience(time_limit)
        given = self._pool

        def again(future: Future[logs.Answer]) -> Future[logs.Answer] | None:
            nonlocal given
            if given is self._pool and not _broken(given):
                return None
            given = self._pool  # broken, or another task had it renewed
            future = self._schedule(task, arguments, limit)
            given = self._pool
            return future

        return Task(self._schedule(task, arguments, limit), limit, again, about)

    def _schedule(self, task: Callable[..., Any], arguments: Sequence[Any], limit: float) -> Future[logs.Answer]:
        if _broken(self._pool):
            self._renewals += 1
            if self._renewals > RENEWALS:
                raise JobFailed(_NONE_LIVES)
            self._stop()
            self._pool = self._new_pool()
        # The threads of the pool begin here, and start the processes: Ctrl-C is the parent's to handle.
        with deferred():
            future: Future[logs.Answer] = self._pool.schedule(logs.there, args=[task, *arguments], timeout=limit)
        future.add_done_callback(self._ended)
        return future

    def _ended(self, future: Future[Any]) -> None:
        if not future.cancelled() and not isinstance(future.exception(), BrokenExecutor):
            self._renewals = 0


def _begin_tracker() -> None:
    """Begins what removes the names of semaphores that a run leaves when it is ended at once: without the warning that
    it did. By this thread: it lets Ctrl-C through to the thread that begins it."""
    before = list(sys.warnoptions)
    sys.warnoptions.append("ignore:resource_tracker:UserWarning")
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions[:] = before


def _broken(pool: ProcessPool) -> bool:
    """Whether its processes ended while none of them had a task: pebble gives up then."""
    return bool(pool._context.status == PoolStatus.ERROR)


def _begin(plugins: list[samplers.Plugin], steps: list[at_start.Step]) -> None:
    pebble.CONSTS.channel_lock_timeout = PIPE_PATIENCE
    alone.load_at_once()
    threading.Thread(target=_end_with_parent, daemon=True).start()
    for plugin in plugins:
        samplers.load_plugin(plugin.path, trusted=plugin.trusted)
    for function, arguments in steps:
        function(*arguments)


def _end_with_parent() -> None:
    """A parent that is killed takes its processes along, with the programs that they run."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os.kill(os.getpid(), signal.SIGKILL)
