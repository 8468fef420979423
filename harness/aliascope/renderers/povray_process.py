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
from aliascope.places import LIBRARIES

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

SHORT_WAITS = LIBRARIES / "libaliascope-waits.so"
"""Preloaded, so that a run of a small picture takes 0.03 s on the wall instead of 0.7, and states its CPU time to the
microsecond: see csrc/waits/short_waits.c."""
FINE_CLOCK = "aliascope: CPU seconds are milliseconds"
"""What that library adds to the output."""

_PRCTL = ctypes.CDLL(None).prctl if sys.platform == "linux" else None
_PR_SET_PDEATHSIG = 1


@dataclass(frozen=True)
class Statistics:
    """What povray prints of one frame.

    `pixels`: the rays through pixel centres (or corners: +AM2), those at the borders of tiles twice. `samples`: the
    rays that antialiasing added to them. `rays`: all of them, but for shadows; `reflected`: those from mirrors. The
    seconds are those of the trace alone; parsing and the writing of the file are not in them. povray states whole
    milliseconds of either, the rest cut off: those of CPU time are of microseconds with SHORT_WAITS.
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
    """Runs povray in `folder`, and returns the last KEPT_BYTES of what it prints, more where it renders many frames.
    Where it was STARVED, it is run again.

    Raises JobFailed where it fails, is killed, or has not ended after `time_limit` seconds on the wall, and
    NotAvailable where it cannot be started. Afterwards no process of it is left.
    """
    most = max(KEPT_BYTES, frames * KEPT_BYTES_A_FRAME)
    deadline = time.monotonic() + time_limit
    for _ in range(STARTS):
        process = _start(path, arguments, folder)
        try:
            text, in_time = _collect(process, deadline, most)
        finally:
            _end(process)
        if not in_time:
            raise JobFailed(f"povray had not ended after {time_limit:.3g} s, its time limit, and was killed")
        if process.returncode == 0:
            return text
        if STARVED not in " ".join(text.split()):
            break
    status = process.returncode
    end = f"was killed by {_signal_name(-status)}" if status < 0 else f"exited with status {status}"
    raise JobFailed(f"povray {end}: {_last_lines(text)}")


def _start(path: str, arguments: list[str], folder: Path) -> subprocess.Popen[bytes]:
    ini = folder / "aliascope.ini"
    preloaded = " ".join(
        filter(None, (os.environ.get("LD_PRELOAD"), str(SHORT_WAITS) if SHORT_WAITS.is_file() else ""))
    )
    environment = {**os.environ, "POVINI": str(ini), "HOME": str(folder), "LC_ALL": "C", "LD_PRELOAD": preloaded}
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
    unit = 1e-3 if FINE_CLOCK in output else 1.0
    return [
        Statistics(
            int(m["pixels"]),
            int(m["samples"]),
            int(m["rays"]),
            unit * float(m["cpu"]),
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


def _collect(process: subprocess.Popen[bytes], deadline: float, most: int) -> tuple[str, bool]:
    """The last `most` bytes of what the program prints until it has ended or the deadline, a time.monotonic(), is past;
    and whether it ended before that."""
    assert process.stdout is not None
    kept = bytearray()
    with selectors.DefaultSelector() as selector:
        os.set_blocking(process.stdout.fileno(), False)
        selector.register(process.stdout.fileno(), selectors.EVENT_READ)
        while True:
            # Looked at before reading: what a program that has ended had to say is in its pipe by now.
            ended, remaining = _end_of(process) is not None, deadline - time.monotonic()
            if not ended and remaining <= 0.0:
                return kept.decode("utf-8", "replace"), False
            # With the pipe closed before the process has ended, nothing wakes this from its sleep when it has.
            longest = _CHECK_EVERY if selector.get_map() else 0.01
            ready = selector.select(0.0 if ended else min(longest, remaining))
            for key, _ in ready:
                piece = os.read(key.fd, 1 << 16)
                kept.extend(piece)
                del kept[:-most]
                if not piece:
                    selector.unregister(key.fd)
            # Past the deadline something else keeps writing to the pipe.
            if ended and (not ready or remaining <= 0.0):
                return kept.decode("utf-8", "replace"), True


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
    lines = [line.strip() for line in output.splitlines() if line.strip() not in ("", FINE_CLOCK)]
    text = " ".join(lines[-MESSAGE_LINES:])[-MESSAGE_CHARACTERS:]
    return "".join(c if c.isprintable() else "?" for c in text) or "it printed nothing"
