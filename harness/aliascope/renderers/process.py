"""Runs a program: in a folder, for a limited time, with a bounded part of what it prints kept.

No run outlives its time limit, its caller or its caller's process.
"""

from __future__ import annotations

import ctypes
import logging
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from aliascope import logs, sharing
from aliascope.errors import JobFailed, NotAvailable

KEPT_BYTES = 1 << 18
"""The end of what a program prints that is kept, unless its caller says otherwise."""

MESSAGE_LINES, MESSAGE_CHARACTERS = 3, 300
"""The most of the program's last lines that goes into an error."""

_CHECK_EVERY = 0.1
"""Seconds between looks at whether the program has ended while something else holds its pipe open, and at what it
leaves behind."""

_CHECK_CLOSED = 0.01
"""The same where it has closed its end, and nothing else would tell."""

_SIGNALLED = 128
"""What stands before a program ends with, and the signal's number, where a signal ended it."""

_PRCTL = ctypes.CDLL(None).prctl if sys.platform == "linux" else None
_PR_SET_PDEATHSIG = 1


class TimeLimit(JobFailed):
    """A program had not ended within its time limit."""


class TooMuch(JobFailed):
    """A program was killed for what it left behind while it ran."""


@dataclass(frozen=True)
class Held:
    """How a program is held, see `confinement`. `before`: words before its command, of programs that end as it does, or
    with 128 and the number of the signal that ended it. `in_child`: what its process does before it begins. `too_much`:
    asked while it runs: why it has to be killed, or None."""

    before: tuple[str, ...] = ()
    in_child: Callable[[], None] | None = None
    too_much: Callable[[], str | None] | None = None


FREE = Held()


@dataclass(frozen=True)
class Ended:
    """A program that has ended by itself: its exit status, that of a signal negative; the end of what it printed, on
    either stream; seconds of CPU time of it and of the processes that it waited for, and on the wall."""

    status: int
    text: str
    cpu_seconds: float
    wall_seconds: float


def run(
    command: Sequence[str],
    folder: Path,
    time_limit: float,
    environment: Mapping[str, str],
    most: int = KEPT_BYTES,
    held: Held = FREE,
) -> Ended:
    """Runs a program in `folder` until it ends.

    Raises TimeLimit where it has not ended after `time_limit` seconds on the wall, TooMuch where what holds it has it
    killed, and NotAvailable where it cannot be started. Afterwards no process of it is left.
    """
    logs.event(logging.DEBUG, "command", f"{sharing.command_line(command)} in {folder}")
    begun = time.monotonic()
    name = Path(command[0]).name
    process = _start(command, folder, environment, held)
    seconds = 0.0
    try:
        text, in_time, too_much = _collect(process, begun + time_limit, most, held)
    finally:
        seconds = _end(process)
    if too_much:
        raise TooMuch(f"{name} {too_much}, and was killed")
    if not in_time:
        raise TimeLimit(f"{name} had not ended after {time_limit:.3g} s, its time limit, and was killed")
    status = process.returncode
    if held.before and status > _SIGNALLED:
        status = _SIGNALLED - status
    return Ended(status, text, seconds, time.monotonic() - begun)


def preloading(library: Path) -> dict[str, str]:
    """What the environment of a program has so that it is started with the library, beside what this process's has.

    The loader splits LD_PRELOAD at blanks and knows no quotes. A library whose path has one is given by its name alone,
    and its folder in LD_LIBRARY_PATH, which is split at colons and semicolons.
    """
    before, folders = os.environ.get("LD_PRELOAD", ""), os.environ.get("LD_LIBRARY_PATH", "")
    if not any(each.isspace() for each in str(library)):
        return {"LD_PRELOAD": f"{before} {library}".strip()}
    return {
        "LD_PRELOAD": f"{before} {library.name}".strip(),
        "LD_LIBRARY_PATH": f"{library.parent}:{folders}".rstrip(":"),
    }


def complaint(name: str, ended: Ended, passed_over: Sequence[str] = ()) -> str:
    """How a program ended that failed, with its last lines but those to be passed over."""
    end = f"was killed by {_signal_name(-ended.status)}" if ended.status < 0 else f"exited with status {ended.status}"
    return f"{name} {end}: {last_lines(ended.text, passed_over)}"


def _start(command: Sequence[str], folder: Path, environment: Mapping[str, str], held: Held) -> subprocess.Popen[bytes]:
    def in_child() -> None:
        _die_with_parent()
        if held.in_child is not None:
            held.in_child()

    try:
        return subprocess.Popen(
            [*held.before, *command],
            cwd=folder,
            env=dict(environment),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            preexec_fn=in_child,
        )
    except OSError as error:
        raise NotAvailable(f"{command[0]} does not start: {error.strerror}") from error
    except subprocess.SubprocessError as error:
        raise NotAvailable(f"{command[0]} does not start: it cannot be confined here") from error


def _die_with_parent() -> None:
    """Runs in the child before the program: a worker that is killed in the middle of a job takes it along."""
    if _PRCTL is not None:
        _PRCTL(_PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)


def _end_of(process: subprocess.Popen[bytes]) -> os.waitid_result | None:
    """How the program has ended, if it has. It is not reaped, so that the number of its process group stays its own."""
    return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)


def _collect(process: subprocess.Popen[bytes], deadline: float, most: int, held: Held) -> tuple[str, bool, str | None]:
    """The last `most` bytes of what the program prints until it has ended or the deadline, a time.monotonic(), is past;
    whether it ended before that; and why it had to be ended, if it had to."""
    assert process.stdout is not None
    kept = bytearray()
    looked = time.monotonic()
    with selectors.DefaultSelector() as selector:
        os.set_blocking(process.stdout.fileno(), False)
        selector.register(process.stdout.fileno(), selectors.EVENT_READ)
        while True:
            # Looked at before reading: what a program that has ended had to say is in its pipe by now.
            ended, remaining = _end_of(process) is not None, deadline - time.monotonic()
            if not ended and remaining <= 0.0:
                return kept.decode("utf-8", "replace"), False, None
            if held.too_much is not None and (ended or time.monotonic() >= looked + _CHECK_EVERY):
                looked = time.monotonic()
                if reason := held.too_much():
                    return kept.decode("utf-8", "replace"), True, reason
            # With the pipe closed before the process has ended, nothing wakes this from its sleep when it has.
            longest = _CHECK_EVERY if selector.get_map() else _CHECK_CLOSED
            ready = selector.select(0.0 if ended else min(longest, remaining))
            for key, _ in ready:
                piece = os.read(key.fd, 1 << 16)
                kept.extend(piece)
                del kept[:-most]
                if not piece:
                    selector.unregister(key.fd)
            # Past the deadline something else keeps writing to the pipe.
            if ended and (not ready or remaining <= 0.0):
                return kept.decode("utf-8", "replace"), True, None


def _end(process: subprocess.Popen[bytes]) -> float:
    """Kills what is left of the program's process group, and reaps the program: its seconds of CPU time."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.stdout is not None:
        process.stdout.close()
    return usage.ru_utime + usage.ru_stime


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def last_lines(output: str, passed_over: Sequence[str] = ()) -> str:
    """The last lines of the output as one: programs wrap their messages."""
    lines = [line.strip() for line in output.splitlines() if line.strip() not in ("", *passed_over)]
    text = " ".join(lines[-MESSAGE_LINES:])[-MESSAGE_CHARACTERS:]
    return "".join(c if c.isprintable() else "?" for c in text) or "it printed nothing"
