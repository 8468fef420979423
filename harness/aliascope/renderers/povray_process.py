"""Runs the program povray: found on the PATH, in a scratch folder, for a limited time; and reads what it prints.

The user's and the system's ini files have no say; see `process` for what else is held.
"""

from __future__ import annotations

import functools
import os
import re
import shutil
import time
from dataclasses import dataclass
from pathlib import Path

from aliascope.errors import JobFailed, NotAvailable
from aliascope.places import LIBRARIES
from aliascope.renderers import process
from aliascope.renderers.process import KEPT_BYTES, TimeLimit

KEPT_BYTES_A_FRAME = 1 << 13
"""A frame takes 3,000 bytes of statistics."""

VERSION_TIME_LIMIT = 30.0
"""Seconds; `povray --version` takes 0.05."""

STARVED = "Timed out waiting for worker thread startup"
"""What povray says on a machine that is too busy to start its threads in time: it gives up before it has begun."""
STARTS = 4
"""How often it is started then, at most."""

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


def run(
    path: str,
    arguments: list[str],
    folder: Path,
    time_limit: float,
    frames: int = 1,
    user_folder: Path | None = None,
) -> str:
    """Runs povray in `folder`, and returns the last KEPT_BYTES of what it prints, more where it renders many frames.
    Where it was STARVED, it is run again. The only ini file that it reads unasked is aliascope.ini in `folder`.
    `user_folder`: where it runs instead, for a user's own scene, which sees the user's home.

    Raises RunFailed where it fails or is killed, TimeLimit where it has not ended after `time_limit` seconds on the
    wall, and NotAvailable where it cannot be started. Afterwards no process of it is left.
    """
    preloaded = " ".join(
        filter(None, (os.environ.get("LD_PRELOAD"), str(SHORT_WAITS) if SHORT_WAITS.is_file() else ""))
    )
    ini = folder / "aliascope.ini"
    environment = {**os.environ, "POVINI": str(ini), "LC_ALL": "C", "LD_PRELOAD": preloaded}
    if user_folder is None:
        environment["HOME"] = str(folder)
    most = max(KEPT_BYTES, frames * KEPT_BYTES_A_FRAME)
    deadline = time.monotonic() + time_limit
    for _ in range(STARTS):
        try:
            ended = process.run(
                [path, *arguments], user_folder or folder, deadline - time.monotonic(), environment, most
            )
        except TimeLimit as error:
            raise TimeLimit(f"povray had not ended after {time_limit:.3g} s, its time limit, and was killed") from error
        if ended.status == 0:
            return ended.text
        if STARVED not in " ".join(ended.text.split()):
            break
    raise RunFailed(process.complaint("povray", ended, [FINE_CLOCK]), ended.text)


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
