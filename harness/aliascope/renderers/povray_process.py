"""Runs the program povray: found on the PATH, in a scratch folder, for a limited time; and reads what it prints.

The user's and the system's ini files have no say; see `process` for what else is held.
"""

from __future__ import annotations

import functools
import logging
import math
import os
import re
import shutil
import signal
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from aliascope import logs
from aliascope.errors import JobFailed, NotAvailable, NotWritable
from aliascope.places import LIBRARIES
from aliascope.renderers import confinement, process
from aliascope.renderers.confinement import Fence
from aliascope.renderers.process import KEPT_BYTES, TimeLimit

KEPT_BYTES_A_FRAME = 1 << 13
"""A frame takes 3,000 bytes of statistics."""

VERSION_TIME_LIMIT = 30.0
"""Seconds; `povray --version` takes 0.05."""

SETTINGS = Path("/etc/povray")
"""Of the system."""

STARVED = "Timed out waiting for worker thread startup"
"""What povray says on a machine that is too busy to start its threads in time: it gives up before it has begun."""
STARTS = 4
"""How often it is started then, at most."""

# What a scene prints itself stands among it: each part is bounded, so that nothing takes long to be told from it.
_STATISTICS = re.compile(
    r"Pixels:\s{0,40}(?P<pixels>\d{1,20})\s{1,40}Samples:\s{0,40}(?P<samples>\d{1,20}).{0,8000}?"
    r"Rays:\s{0,40}(?P<rays>\d{1,20}).{0,8000}?"
    r"Trace Time:.{0,200}?\((?P<wall>\d{1,9}(?:\.\d{1,9})?) seconds\)\s{0,40}using \d{1,9} thread\(s\) with "
    r"(?P<cpu>\d{1,9}(?:\.\d{1,9})?) CPU-seconds",
    re.DOTALL,
)

SHORT_WAITS = LIBRARIES / "libaliascope-waits.so"
"""Preloaded, so that a run of a small picture takes 0.03 s on the wall instead of 0.7, and states its CPU time to the
microsecond: see csrc/waits/short_waits.c."""
FINE_CLOCK = "aliascope: CPU seconds are milliseconds"
"""What that library adds to the output."""


CONF = """[File I/O Security]
restricted
[Shellout Security]
forbidden
[Permitted Paths]
"""
"""POV-Ray's own restrictions: no command of a scene's can be run. Those of files, in which its folder and the scratch
one are named, 3.7.0.10 reads and does not heed on Linux (measured: a scene includes /etc/passwd): `confinement` does
that."""

MORE_CPU_SECONDS = 60
"""Than its threads can take within the time limit."""

PASSED_ON = ("PATH", "TMPDIR", "LD_LIBRARY_PATH")
"""Of the environment, to a user's own scene."""


class RunFailed(JobFailed):
    """povray ended with an error; `output` is what it printed."""

    def __init__(self, message: str, output: str) -> None:
        super().__init__(message)
        self.output = output

    def __reduce__(self) -> tuple[type[RunFailed], tuple[str, str]]:  # it may come from a worker process
        return RunFailed, (str(self), self.output)


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
        raise NotAvailable(f"{path} does not state a version of POV-Ray: {process.last_lines(output, [FINE_CLOCK])}")
    return found[1]


@dataclass(frozen=True)
class Others:
    """Of a run of a scene that may be anybody's: the folder that it lies in, where POV-Ray runs; the folders of
    POV-Ray's own files; how many bytes it may leave in a file; and its threads."""

    folder: Path
    libraries: tuple[Path, ...]
    file_bytes: int
    threads: int

    def fence(self, scratch: Path, program: str, time_limit: float) -> Fence:
        program_folder = Path(program).resolve().parent
        return Fence(
            readable=(self.folder, SETTINGS, program_folder, LIBRARIES, *self.libraries),
            folder=scratch,
            file_bytes=self.file_bytes,
            folder_bytes=2 * self.file_bytes,
            memory_bytes=confinement.memory_limit(),
            cpu_seconds=math.ceil(self.threads * time_limit) + MORE_CPU_SECONDS,
        )


def run(
    path: str,
    arguments: list[str],
    folder: Path,
    time_limit: float,
    frames: int = 1,
    others: Others | None = None,
) -> str:
    """Runs povray in `folder`, and returns the last KEPT_BYTES of what it prints, more where it renders many frames.
    Where it was STARVED, it is run again. The only ini file that it reads unasked is aliascope.ini in `folder`.
    `others`: of a scene that is not ours, which is confined: `folder` is what it can write to, and its home.

    Raises RunFailed where it fails or is killed, TimeLimit where it has not ended after `time_limit` seconds on the
    wall, TooMuch where it leaves too much, and NotAvailable where it cannot be started. Afterwards no process of it is
    left.
    """
    preloaded = process.preloading(SHORT_WAITS) if SHORT_WAITS.is_file() else {}
    own = {"POVINI": str(folder / "aliascope.ini"), "LC_ALL": "C", "HOME": str(folder)}
    most = max(KEPT_BYTES, frames * KEPT_BYTES_A_FRAME)
    deadline = time.monotonic() + time_limit
    with ExitStack() as stack:
        if others is None:
            held = process.FREE
            environment = {**os.environ, **own, **preloaded}
        else:
            fence = others.fence(folder, path, time_limit)
            _write_conf(folder, fence)
            # What is preloaded is for povray, not for the program that confines it.
            held = stack.enter_context(confinement.held(fence, preloaded))
            environment = {name: os.environ[name] for name in PASSED_ON if name in os.environ} | own
        for _ in range(STARTS):
            left = deadline - time.monotonic()
            try:
                where = folder if others is None else others.folder
                ended = process.run([path, *arguments], where, left, environment, most, held)
            except TimeLimit as error:
                raise TimeLimit(
                    f"povray had not ended after {time_limit:.3g} s, its time limit, and was killed"
                ) from error
            if ended.status == 0:
                return ended.text
            if STARVED not in " ".join(ended.text.split()):
                break
            logs.event(logging.INFO, "retry", f"povray: {STARVED}: it is started again")
    message = process.complaint("povray", ended, [FINE_CLOCK])
    if others is not None:
        message = _limit_met(ended, fence) or message
    raise RunFailed(message, ended.text)


def _write_conf(home: Path, fence: Fence) -> None:
    path = home / ".povray" / "3.7" / "povray.conf"
    paths = [*(("read*", each) for each in fence.readable), ("read+write*", fence.folder)]
    # One with a quote, a semicolon or a line end in its name cannot be written there, and stays forbidden.
    lines = [f'{right} = "{each}"\n' for right, each in paths if not set('"\n;') & set(str(each))]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(CONF + "".join(lines))
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error


def _limit_met(ended: process.Ended, fence: Fence) -> str | None:
    """Which limit a scene that is not ours met, as far as its end tells."""
    if ended.status == -signal.SIGXFSZ:
        return f"povray wrote more than {fence.file_bytes >> 20} MiB into a file, the most that it may, and was killed"
    if ended.status == -signal.SIGXCPU:
        return f"povray took more than {fence.cpu_seconds} s of CPU time, the most that it may, and was killed"
    if "bad_alloc" in ended.text or re.search(r"out of memory", ended.text, re.IGNORECASE):
        return (
            f"povray asked for more than {fence.memory_bytes / (1 << 30):.3g} GiB of memory, the most that it may have"
        )
    return None


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
            sum(int(count) for count in re.findall(r"Reflected Rays:\s{0,40}(\d{1,20})", m[0])),
        )
        for m in _STATISTICS.finditer(output)
    ]
