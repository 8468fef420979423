"""Runs the program povray: found on the PATH, in a scratch folder, for a limited time; and reads what it prints.

What is held here: no run outlives its time limit, its caller or its caller's process; the user's and the system's ini
files have no say; whatever the program prints, a bounded part of it is kept.
"""

from __future__ import annotations

import ctypes
import functools
import os
import re
import selectors
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from aliascope.errors import JobFailed, NotAvailable

KEPT_BYTES = 1 << 18
"""The end of what the program prints that is kept, and more for many frames."""

KEPT_BYTES_A_FRAME = 1 << 13
"""A frame takes 3,000 bytes of statistics."""

MESSAGE_LINES, MESSAGE_CHARACTERS = 3, 300
"""The most of the program's last lines that goes into an error."""

VERSION_TIME_LIMIT = 30.0
"""Seconds; `povray --version` takes 0.05."""

STARVED = "Timed out waiting for worker thread startup"
"""What povray says on a machine that is too busy to start its threads in time: it gives up before it has begun."""
STARTS = 4
"""How often it is started then, at most."""

_CHECK_EVERY = 0.1
"""Seconds between looks at whether the program has ended while something else holds its pipe open."""

_STATISTICS = re.compile(
    r"Pixels:\s*(?P<pixels>\d+)\s+Samples:\s*(?P<samples>\d+).*?"
    r"Rays:\s*(?P<rays>\d+).*?"
    r"Trace Time:.*?\((?P<wall>[\d.]+) seconds\)\s*using \d+ thread\(s\) with (?P<cpu>[\d.]+) CPU-seconds",
    re.DOTALL,
)

_PRCTL = ctypes.CDLL(None).prctl if sys.platform == "linux" else None
_PR_SET_PDEATHSIG = 1


@dataclass(frozen=True)
class Statistics:
    """What povray prints of one frame.

    `pixels`: the rays through pixel centres (or corners: +AM2), those at the borders of tiles twice. `samples`: the
    rays that antialiasing added to them. `rays`: all of them, but for shadows; `reflected`: those from mirrors. The
    seconds are those of the trace alone, in whole milliseconds, so 0 for a few thousand pixels; parsing and the writing
    of the file are not in them.
    """

    pixels: int
    samples: int
    rays: int
    cpu_seconds: float
    wall_seconds: float
    reflected: int = 0


def executable() -> str:
    """The path of povray, looked for on the PATH at each call. Raises NotAvailable."""
    path = shutil.which("povray")
    if path is None:
        raise NotAvailable("POV-Ray is not installed: there is no povray on the PATH (Debian: apt install povray)")
    return str(Path(path).absolute())  # it is run in another folder


@functools.cache
def version(path: str) -> str:
    """The version that the program at `path` states, "3.7.0.10.unofficial". Raises NotAvailable."""
    try:
        output = run(path, ["--version"], Path("/"), VERSION_TIME_LIMIT)
    except JobFailed as error:
        raise NotAvailable(f"{path} does not start: {error}") from None
    found = re.search(r"POV-Ray (\d\S*)", output)
    if found is None:
        raise NotAvailable(f"{path} does not state a version of POV-Ray: {_last_lines(output)}")
    return found[1]


def run(path: str, arguments: list[str], folder: Path, time_limit: float, frames: int = 1) -> str:
    """One run of povray: see `run_all`."""
    return run_all(path, [arguments], folder, time_limit, frames)[0]


def run_all(path: str, runs: list[list[str]], folder: Path, time_limit: float, frames: int = 1) -> list[str]:
    """Runs povray in `folder` with each of these arguments, all at once, and returns the last KEPT_BYTES of what each
    prints, more where it renders many frames. Where it was STARVED, they are all run again.

    Raises JobFailed where one fails, is killed, or has not ended after `time_limit` seconds on the wall, and
    NotAvailable where it cannot be started. Afterwards no process of them is left.
    """
    most = max(KEPT_BYTES, frames * KEPT_BYTES_A_FRAME)
    deadline = time.monotonic() + time_limit
    for _ in range(STARTS):
        started, failed, in_time = _run_once(path, runs, folder, deadline, most)
        if failed is None or STARVED not in " ".join(failed.text.split()):
            break
    if not in_time:
        raise JobFailed(f"povray had not ended after {time_limit:.3g} s, its time limit, and was killed")
    if failed is not None:
        status = failed.process.returncode
        end = f"was killed by {_signal_name(-status)}" if status < 0 else f"exited with status {status}"
        raise JobFailed(f"povray {end}: {_last_lines(failed.text)}")
    return [each.text for each in started]


def _run_once(
    path: str, runs: list[list[str]], folder: Path, deadline: float, most: int
) -> tuple[list[_Running], _Running | None, bool]:
    """All of them, the first that failed, and whether they ended before the deadline."""
    started: list[_Running] = []
    try:
        # One by one: where one does not start, those before it are ended.
        started.extend(_Running(_start(path, arguments, folder), bytearray()) for arguments in runs)
        failed, in_time = _collect(started, deadline, most)
    finally:
        for each in started:
            _end(each.process)
    return started, failed, in_time


@dataclass(frozen=True)
class _Running:
    """A process, and the last of what it printed."""

    process: subprocess.Popen[bytes]
    kept: bytearray

    @property
    def text(self) -> str:
        return self.kept.decode("utf-8", "replace")


def _start(path: str, arguments: list[str], folder: Path) -> subprocess.Popen[bytes]:
    ini = folder / "aliascope.ini"
    environment = {**os.environ, "POVINI": str(ini), "HOME": str(folder), "LC_ALL": "C"}
    try:
        return subprocess.Popen(
            [path, *arguments],
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            preexec_fn=_die_with_parent,
        )
    except OSError as error:
        raise NotAvailable(f"{path} does not start: {error.strerror}") from error


def read_statistics(output: str) -> list[Statistics]:
    """The statistics of each frame, in order; empty where there are none."""
    return [
        Statistics(
            int(m["pixels"]),
            int(m["samples"]),
            int(m["rays"]),
            float(m["cpu"]),
            float(m["wall"]),
            sum(int(count) for count in re.findall(r"Reflected Rays:\s*(\d+)", m[0])),
        )
        for m in _STATISTICS.finditer(output)
    ]


def _die_with_parent() -> None:
    """Runs in the child before povray: a worker that is killed in the middle of a job takes its povray with it."""
    if _PRCTL is not None:
        _PRCTL(_PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)


def _end_of(process: subprocess.Popen[bytes]) -> os.waitid_result | None:
    """How the program has ended, if it has. It is not reaped, so that the number of its process group stays its own."""
    return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)


def _collect(started: list[_Running], deadline: float, most: int) -> tuple[_Running | None, bool]:
    """Keeps the last `most` bytes of what each prints, until all have ended, or one has failed, or the deadline, a
    time.monotonic(), is past. Returns the one that failed, and whether it ended before the deadline."""
    with selectors.DefaultSelector() as selector:
        for each in started:
            assert each.process.stdout is not None
            os.set_blocking(each.process.stdout.fileno(), False)
            selector.register(each.process.stdout.fileno(), selectors.EVENT_READ, each)
        while True:
            # Looked at before reading: what a program that has ended had to say is in its pipe by now.
            ends = [_end_of(each.process) for each in started]
            failed = [each for each, end in zip(started, ends, strict=True) if end and end.si_status != 0]
            ended, remaining = bool(failed) or all(ends), deadline - time.monotonic()
            if not ended and remaining <= 0.0:
                return None, False
            # With a pipe closed before its process has ended, nothing wakes this from its sleep when it has.
            longest = _CHECK_EVERY if len(selector.get_map()) == ends.count(None) else 0.01
            ready = selector.select(0.0 if ended else min(longest, remaining))
            for key, _ in ready:
                piece = os.read(key.fd, 1 << 16)
                key.data.kept.extend(piece)
                del key.data.kept[:-most]
                if not piece:
                    selector.unregister(key.fd)
            # Past the deadline something else keeps writing to the pipe.
            if ended and (not ready or remaining <= 0.0):
                return (failed[0] if failed else None), True


def _end(process: subprocess.Popen[bytes]) -> None:
    """Kills what is left of the program's process group, and reaps the program."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    if process.stdout is not None:
        process.stdout.close()


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _last_lines(output: str) -> str:
    """The last lines of the output as one: povray wraps its messages at 79 columns."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    text = " ".join(lines[-MESSAGE_LINES:])[-MESSAGE_CHARACTERS:]
    return "".join(c if c.isprintable() else "?" for c in text) or "it printed nothing"
