"""The worker that `aliascope worker` starts: dask's, in a process that a nanny starts again where it ends."""

from __future__ import annotations

import asyncio
import contextlib
import signal
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from aliascope import at_start
from aliascope.cluster import work
from aliascope.cluster.address import Tls, checked, distributed, no_scheduler, reach, security

STARTING = 60.0
"""Seconds in which a scheduler has to answer."""


def serve(
    address: str,
    count: int,
    tls: Tls,
    tell: Callable[[str], None],
    without: Sequence[str] = (),
    memory: str = "auto",
    scratch: Path | None = None,
) -> None:
    """Serves until it is interrupted or the scheduler ends. Raises NotAvailable where there is no scheduler."""
    checked(address, tls)
    dask_distributed = distributed()
    shown = security(address, tls, dask_distributed, "worker")
    said = work.about(without)
    for name, versions in said.versions.items():
        of_it = ", ".join(f"{what} {value}" for what, value in versions[work.kind_of(False)].items() if what != "code")
        tell(f"{name}: {of_it}")
    for name, reason in said.absent.items():
        tell(f"not {name}: {reason}")
    import dask

    # A worker has processes of its own, which daemons may not.
    with dask.config.set({"distributed.worker.daemon": False}):
        asyncio.run(_serve(dask_distributed, address, count, shown, tell, said, without, memory, scratch))


async def _serve(
    dask_distributed: Any,
    address: str,
    count: int,
    shown: Any,
    tell: Callable[[str], None],
    said: work.About,
    without: Sequence[str],
    memory: str,
    scratch: Path | None,
) -> None:
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    options: dict[str, Any] = {
        "nthreads": 1,
        "resources": said.resources(),
        "memory_limit": memory,
        "security": shown,
        "death_timeout": STARTING,
        "startup_information": {work.ANY: _About(work.document(said), at_start.steps(), without)},
    }
    if scratch is not None:
        options["local_directory"] = str(scratch)
    async with contextlib.AsyncExitStack() as stack:
        try:
            await reach(address, shown, dask_distributed, "worker", STARTING)
            made = [dask_distributed.Nanny(address, **options) for _ in range(count)]
            nannies = await asyncio.gather(*(stack.enter_async_context(nanny) for nanny in made))
        except (OSError, TimeoutError, ValueError, RuntimeError) as error:
            raise no_scheduler(address, error) from error
        tell(f"{count} worker{'' if count == 1 else 's'} of {said.machine} at {address}; Ctrl-C ends")
        waits = [asyncio.ensure_future(nanny.finished()) for nanny in nannies]
        waits.append(asyncio.ensure_future(ended.wait()))
        await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        for wait in waits:
            wait.cancel()


class _About:
    """What a worker's process does when it starts: it learns of the renderers of files, and says what it can do."""

    def __init__(self, document: Mapping[str, Any], steps: list[at_start.Step], without: Sequence[str]) -> None:
        self._document, self._steps, self._without = document, steps, without

    async def __call__(self, worker: object) -> Mapping[str, Any]:
        for function, arguments in self._steps:
            function(*arguments)
        work.leave_out(self._without)
        return self._document
