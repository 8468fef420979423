"""`aliascope plugin check`: whether a plugin's sampler keeps to the contracts of plugin.h and sampler.h.

Each check runs in a process of its own, so that a plugin that crashes, hangs or writes outside its buffer is a report,
and loses that check alone.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aliascope.errors import InvalidInput
from aliascope.studies.plugin_contracts import CONTRACTS
from aliascope.studies.plugin_probe import NOTE_AT, NOTE_BYTES, RESULT_AT, TABLE

CHECKS = (TABLE, *CONTRACTS)
TIME_LIMIT = 20.0
MOST_HANGS = 2
"""After so many checks that hung the others are not run: they would most likely hang too."""


@dataclass(frozen=True)
class Outcome:
    """Of one check. status: "ok", "failed", "skipped" (it asks nothing of this sampler), "not-run"."""

    name: str
    status: str
    text: str
    hung: bool = False

    @property
    def holds(self) -> bool:
        return self.status in ("ok", "skipped")


def check(path: Path | str, spec: str | None = None, time_limit: float = TIME_LIMIT) -> Iterator[Outcome]:
    """The outcomes of all checks of a plugin, in the order of CHECKS, each as soon as it is there.

    spec: which configuration of the sampler, "name:key=value"; its defaults if None. time_limit: seconds that a check
    may take. Raises InvalidInput for what is no plugin, or a spec that the plugin does not have.
    """
    file = Path(path).resolve()
    if not file.is_file():
        raise InvalidInput(f"{path}: there is no such file")
    first, result = _run(TABLE, file, spec, time_limit)
    if result.get("status") == "no-plugin":
        raise InvalidInput(f"{path}: {first.text}")
    yield first
    hangs = int(first.hung)
    for name in CONTRACTS:
        if not first.holds:
            yield Outcome(name, "not-run", f"the check `{TABLE}` failed")
        elif hangs == MOST_HANGS:
            yield Outcome(name, "not-run", f"{MOST_HANGS} checks before it hung")
        else:
            outcome = check_one(name, file, str(result["spec"]), time_limit)
            hangs += outcome.hung
            yield outcome


def check_one(name: str, file: Path, spec: str, time_limit: float = TIME_LIMIT) -> Outcome:
    """The outcome of one check but `table`, which is taken to hold."""
    outcome, result = _run(name, file, spec, time_limit)
    if not result.get("digest"):
        return outcome
    # What depends on an address, the time or unwritten memory is pure within a process, not from one to another.
    outcome, second = _run(name, file, spec, time_limit, fresh_memory=0xAA)
    if outcome.status == "ok" and second["digest"] != result["digest"]:
        return Outcome(name, "failed", "the same calls gave other bits in another process")
    return outcome


def _run(
    name: str, file: Path, spec: str | None, time_limit: float, fresh_memory: int = 0x55
) -> tuple[Outcome, dict[str, Any]]:
    """One check in its process; `fresh_memory` is the byte that memory from malloc is filled with (mallopt(3))."""
    with tempfile.TemporaryFile() as report, tempfile.TemporaryFile() as complaints:
        command = [sys.executable, "-P", "-m", "aliascope.studies.plugin_probe", str(report.fileno()), name, str(file)]
        process = subprocess.Popen(
            [*command, *([spec] if spec is not None else [])],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=complaints,
            pass_fds=(report.fileno(),),
            start_new_session=True,
            env={**os.environ, "MALLOC_PERTURB_": str(fresh_memory)},
        )
        hung = False
        try:
            process.wait(time_limit)
        except subprocess.TimeoutExpired:
            hung = True
        finally:
            _end(process)
        note = os.pread(report.fileno(), NOTE_BYTES, NOTE_AT).decode(errors="replace").strip()
        written = os.pread(report.fileno(), 1 << 20, RESULT_AT)
        last_words = _last_line(complaints.fileno())
    if hung:
        return Outcome(name, "failed", f"hung: no end within {time_limit:g} s, {note}", hung=True), {}
    if process.returncode < 0:
        return Outcome(name, "failed", _crash(-process.returncode, note, last_words)), {}
    if not written or process.returncode:
        text = f"ended its process with exit code {process.returncode}, {note}"
        return Outcome(name, "failed", f"{text} ({last_words})" if last_words else text), {}
    result = json.loads(written)
    return Outcome(name, result["status"], result["text"]), result


def _end(process: subprocess.Popen[bytes]) -> None:
    """With all that it has started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _last_line(fd: int) -> str:
    size = os.fstat(fd).st_size
    lines = os.pread(fd, 4096, max(0, size - 4096)).decode(errors="replace").strip().splitlines()
    return "".join(c if c.isprintable() else " " for c in lines[-1])[-200:].strip() if lines else ""


def _crash(number: int, note: str, last_words: str) -> str:
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = f"signal {number}"
    return f"crashed with {name} ({last_words or signal.strsignal(number) or 'unknown'}), {note}"


def document(path: Path | str, outcomes: list[Outcome]) -> dict[str, Any]:
    """For `aliascope plugin check --json`."""
    return {
        "plugin": str(path),
        "holds": all(outcome.holds for outcome in outcomes),
        "checks": [{"name": each.name, "status": each.status, "text": each.text} for each in outcomes],
    }


def line_of(outcome: Outcome) -> str:
    """The same for people, one check."""
    return f"{outcome.name:<14}{outcome.status.replace('-', ' '):<9}{outcome.text}"


def last_line(path: Path | str, outcomes: list[Outcome]) -> str:
    failed = [outcome.name for outcome in outcomes if outcome.status == "failed"]
    return f"{path}: {'does not hold: ' + ', '.join(failed) if failed else 'every contract holds'}"
