"""Worker processes: what crashes or hangs in one is that task's failure, and no other's."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, Future
from concurrent.futures import TimeoutError as FutureTimeout
from types import TracebackType
from typing import Any, Generic, TypeVar

import pebble
from pebble import ProcessExpired, ProcessPool

from aliascope import at_start
from aliascope.errors import JobFailed
from aliascope.native import samplers

Result = TypeVar("Result")

PIPE_PATIENCE = 600.0
"""Seconds that a process waits for its turn at the pipe to the parent before it ends itself. Pebble's 60 are too few
beside a parent that gets a hundredth of a busy machine."""


class Task(Generic[Result]):
    """What a worker process was given to do."""

    def __init__(self, future: Future[Result], limit: float) -> None:
        self._future, self._limit = future, limit

    def done(self) -> bool:
        """Whether it has ended, well or not."""
        return bool(self._future.done())

    def result(self) -> Result:
        """Waits for the result. Raises what the task raises, and JobFailed where its process ended or took too long."""
        try:
            return self._future.result()
        except FutureTimeout as error:
            raise JobFailed(f"gave nothing within {self._limit:g} s and was ended") from error
        except ProcessExpired as error:
            code = error.exitcode or 0
            how = f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
            raise JobFailed(f"its process ended {how}") from error
        except BrokenExecutor as error:  # they end before they begin anything: there is no task to lay it to
            raise JobFailed("the worker processes do not stay alive; is there too little memory?") from error


def patience(time_limit: float) -> float:
    """Seconds after which a task's process is ended from outside: renderers should have given up by themselves."""
    return time_limit + min(20.0, max(2.0, time_limit / 2.0))


class Workers:
    """Processes that a crash or a time limit of one task leaves standing; started afresh, not forked, since the parent
    has threads, and only once there is a task. Use as a context manager: what is not done when it ends by an exception
    is dropped."""

    def __init__(self, processes: int) -> None:
        self._pool = ProcessPool(
            max_workers=processes,
            context=multiprocessing.get_context("spawn"),
            initializer=_begin,
            initargs=([plugin.path for plugin in samplers.plugins()], at_start.steps()),
        )

    def __enter__(self) -> Workers:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self._pool.close()
        else:
            self._pool.stop()
        self._pool.join()

    def begin(self, task: Callable[..., Result], arguments: Sequence[Any], time_limit: float) -> Task[Result]:
        """Has `task` done, by the first process that is free, within `time_limit`, in seconds, and some patience."""
        limit = patience(time_limit)
        return Task(self._pool.schedule(task, args=arguments, timeout=limit), limit)


def _begin(plugins: list[str], steps: list[at_start.Step]) -> None:
    pebble.CONSTS.channel_lock_timeout = PIPE_PATIENCE
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle
    for plugin in plugins:
        samplers.load_plugin(plugin)
    for function, arguments in steps:
        function(*arguments)
