"""Processes that plugins run in, begun here and ended with this one."""

from __future__ import annotations

import atexit
import fcntl
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from aliascope.errors import InvalidInput
from aliascope.native import loading, plugin_fence
from aliascope.native.plugin_host import SIGNALLED

TIME_LIMIT = 60.0
"""Seconds that a plugin may take for one answer: to be loaded, to make a sampler, for some thousands of points."""

MEMORY_SHARE = 1 / 8
"""Of the machine's memory: what a plugin may have in each process that uses it."""

MOST_THREADS = 64
_NO_OTHER_SIZE = fcntl.F_SEAL_SEAL | fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW
_ALL_OF_A_PROCESS = 2
"""CPUCLOCK_SCHED: the CPU clock of a process has its number and this, as clock_getcpuclockid(3) puts them together."""
_PATIENCE = 5.0
"""Seconds until a process whose socket has ended has ended too."""


class PluginProcess:
    """One plugin, in a process of its own behind a fence, its sampler registered like those of plugins that are loaded.
    Raises InvalidInput where the file is no plugin, also where it crashes or hangs as it is loaded."""

    def __init__(self, path: str) -> None:
        self.path = path
        self._words = tempfile.TemporaryFile()  # noqa: SIM115 (as long as there is a process)
        self._renewable = True
        try:
            self._begin()
        except BaseException:
            self._words.close()
            raise
        atexit.register(self.end)

    def renew(self) -> None:
        """Begins a process in place of one that has ended, as long as one can be begun."""
        if self._process.poll() is None or not self._renewable:
            return
        self._stop()
        try:
            self._begin()
        except InvalidInput:
            self._renewable = False

    def end(self) -> None:
        """Ends the process, and the plugin with it, for good."""
        self._stop()
        self._words.close()

    def _stop(self) -> None:
        with suppress(OSError):
            self._alive.shutdown(socket.SHUT_RDWR)  # the library has a copy of it
        self._alive.close()
        try:
            self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def seconds(self) -> float:
        """CPU seconds of the process, and of that in which the plugin is; 0 of one that has ended."""
        outer = self._process.pid
        total = 0.0
        with suppress(OSError):
            inner = Path(f"/proc/{outer}/task/{outer}/children").read_text().split()
            for process in (outer, *map(int, inner)):
                total += time.clock_gettime(~process << 3 | _ALL_OF_A_PROCESS)
        return total

    def ending(self) -> str | None:
        """How the plugin has ended, or None while it has not."""
        try:
            code = self._process.wait(_PATIENCE if self._alive_no_more() else 0.0)
        except subprocess.TimeoutExpired:
            return None
        if code == SIGNALLED + signal.SIGKILL:
            return f"had not answered within {TIME_LIMIT:g} s, and was ended"
        if code <= SIGNALLED:
            return f"ended its process with exit code {code}{self._last_words()}"
        try:
            name = signal.Signals(code - SIGNALLED).name
        except ValueError:
            name = f"signal {code - SIGNALLED}"
        limit = plugin_fence.memory_limit(MEMORY_SHARE) / 2**30
        return f"crashed with {name}{self._last_words()}; it may take {limit:.3g} GiB of memory"

    def _begin(self) -> None:
        compiled = loading.module("_sampler", "the library libaliascope")
        shared = os.memfd_create("aliascope-plugin", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        self._alive, theirs = socket.socketpair()
        try:
            os.ftruncate(shared, compiled.lib.asc_plugin_memory(min(MOST_THREADS, (os.cpu_count() or 1) + 2)))
            fcntl.fcntl(shared, fcntl.F_ADD_SEALS, _NO_OTHER_SIZE)
            self._process = self._started(shared, theirs.fileno())
            theirs.close()
            self._connect(compiled, shared)
        finally:
            theirs.close()
            os.close(shared)

    def _started(self, shared: int, alive: int) -> subprocess.Popen[bytes]:
        self._words.seek(0)
        self._words.truncate()
        memory = plugin_fence.memory_limit(MEMORY_SHARE)
        return subprocess.Popen(
            [
                *(sys.executable, "-P", "-m", "aliascope.native.plugin_host"),
                *map(str, (shared, alive, memory)),
                self.path,
            ],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._words,
            pass_fds=(shared, alive),
            process_group=0,
            env=plugin_fence.environment(),
        )

    def _connect(self, compiled: Any, shared: int) -> None:
        box = loading.error_box(compiled.ffi)
        path = os.fsencode(self.path)
        status = compiled.lib.asc_plugin_connect(shared, self._alive.fileno(), path, TIME_LIMIT, box)
        if status == compiled.lib.ASC_OK:
            return
        ended = self.ending()
        self._stop()
        if ended:
            raise InvalidInput(f"{self.path}: as it was loaded, the plugin {ended}")
        loading.check(compiled, status, box)

    def _alive_no_more(self) -> bool:
        """Whether the other end of the socket is closed, or this one shut down."""
        try:
            return self._alive.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) == b""
        except BlockingIOError:
            return False
        except OSError:
            return True

    def _last_words(self) -> str:
        """The last line that it printed on standard error, in brackets."""
        size = os.fstat(self._words.fileno()).st_size
        lines = os.pread(self._words.fileno(), 4096, max(0, size - 4096)).decode(errors="replace").strip().splitlines()
        words = "".join(c if c.isprintable() else " " for c in lines[-1])[-200:].strip() if lines else ""
        return f" ({words})" if words else ""


_processes: dict[str, PluginProcess] = {}


def begin(path: str) -> None:
    """Begins the process of a plugin. Raises InvalidInput."""
    _processes[path] = PluginProcess(path)


def renew() -> None:
    """Has those begin again that have ended, for what is asked of them from now on."""
    for each in _processes.values():
        each.renew()


def seconds() -> float:
    """All CPU seconds of the processes of plugins that run now."""
    return sum(each.seconds() for each in _processes.values())


def endings() -> Iterator[str]:
    """How plugins have ended, of those that have."""
    for each in _processes.values():
        if how := each.ending():
            yield f"{each.path}: the plugin {how}"


loading.plugin_endings.append(endings)
