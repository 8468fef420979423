"""Clusters of this machine: a scheduler and workers, each a process of its own, in a folder that has all they write."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

LIMIT = 300.0
"""Seconds that anything here may take on a machine however busy."""


def until(condition: Callable[[], Any], what: str) -> Any:
    """What a condition gives once it is true."""
    begun = time.monotonic()
    while not (found := condition()):
        assert time.monotonic() - begun < LIMIT, what
        time.sleep(0.05)
    return found


@contextlib.contextmanager
def cluster_of(
    folder: Path, *workers: Sequence[str | Path], scheduler: Sequence[str | Path] = (), tls: Sequence[str | Path] = ()
) -> Iterator[str]:
    """The address of a scheduler with these further options, while it and its workers are there: each with its options,
    and `tls`, and the log worker-0.log and so on in the folder."""
    temporary = folder / "tmp"
    temporary.mkdir()
    begun: list[subprocess.Popen[bytes]] = []

    def start(name: str, *words: str | Path) -> Path:
        log = folder / name
        with log.open("wb") as file:
            begun.append(
                subprocess.Popen(
                    [sys.executable, *map(str, words)],
                    stdout=file,
                    stderr=file,
                    cwd=folder,
                    env={**os.environ, "TMPDIR": str(temporary)},
                )
            )
        return log

    try:
        told = folder / "scheduler.json"
        where = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show", "--scheduler-file", told)
        start("scheduler.log", "-m", "distributed.cli.dask_scheduler", *where, *scheduler)
        address = until(lambda: told.is_file() and json.loads(told.read_text() or "{}").get("address"), "no scheduler")
        ours = ("-W", "error", "-m", "aliascope.cli", "worker", address)
        logs = [start(f"worker-{number}.log", *ours, *words, *tls) for number, words in enumerate(workers)]
        for log in logs:
            until(lambda log=log: "Ctrl-C ends" in log.read_text(), f"no worker: {log}")
        yield address
    finally:
        for process in reversed(begun):
            process.terminate()
        for process in begun:
            try:
                process.wait(60.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
