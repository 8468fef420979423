"""Confinement of a program that works on somebody else's file: what it sees, and how much it may take.

Three means, the first that works here, which is tried once in a process and not believed:

- bubblewrap: it sees only what is listed, no network and no other process;
- Landlock: it can open only what is listed, and TCP is closed; and in a namespace of its own there is no network;
- neither: then limits on resources alone hold it, and `Protection.told` says so.

The limits, which are the kernel's (`setrlimit`), hold with each of them, and the folder that it writes into is watched.
"""

from __future__ import annotations

import ctypes
import functools
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from aliascope import landlock
from aliascope.landlock import DEVICES, SYSTEM
from aliascope.renderers.process import Held

LEAST_MEMORY, MOST_MEMORY = 1 << 30, 16 << 30
MEMORY_SHARE = 0.5
"""Of the machine's memory."""

MORE_PROCESSES = 256
"""Than the user has already, as the limit counts those of a user, not of a program; of root there is no such limit."""

MOST_FILES = 256
"""In the folder that the program writes into."""

PROBE_TIME_LIMIT = 20.0

_NEW_USER, _NEW_NETWORK = 0x10000000, 0x40000000
"""CLONE_NEWUSER, CLONE_NEWNET."""
_LIBC = ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None


@dataclass(frozen=True)
class Fence:
    """What a program may do: read below `readable`, write below `folder`, in files of `file_bytes` and
    `folder_bytes` together; with so much address space and CPU time."""

    readable: tuple[Path, ...]
    folder: Path
    file_bytes: int
    folder_bytes: int
    memory_bytes: int
    cpu_seconds: int


@dataclass(frozen=True)
class Protection:
    """What holds a program here."""

    by: Literal["bubblewrap", "Landlock", "limits alone"]
    network: bool
    """Whether it has a network of its own, which leads nowhere."""

    @property
    def files(self) -> bool:
        """Whether it is kept to the files that it may see."""
        return self.by != "limits alone"

    @property
    def told(self) -> str:
        """For people: one line."""
        if self.by == "bubblewrap":
            return (
                "bubblewrap: its folder and POV-Ray's to read, a scratch folder to write, no network, "
                "no other process in sight"
            )
        if self.by == "Landlock":
            tcp = "no TCP" if landlock.closes_network() else "the network is open to it"
            network = "no network" if self.network else tcp
            return f"Landlock: its folder and POV-Ray's to read, a scratch folder to write, {network}"
        network = "; it has no network" if self.network else ""
        return (
            "limits on time, memory and output alone: it can read and write what you can"
            f"{network} (install bubblewrap, or allow user namespaces)"
        )


@functools.cache
def protection() -> Protection:
    """What works here: tried on a program that reads a file which it may see, and one which it may not."""
    with tempfile.TemporaryDirectory(prefix="aliascope-probe-") as name:
        inside, outside = Path(name, "inside"), Path(name, "outside")
        for folder in (inside, outside):
            folder.mkdir()
            (folder / "file").write_text("")
        fence = Fence((), inside, 1 << 20, 1 << 20, LEAST_MEMORY, 60)
        if shutil.which("bwrap") and all(_works(Protection("bubblewrap", True), fence, outside)):
            return Protection("bubblewrap", True)
        network = _unshares_network()
        if landlock.abi() and all(_works(Protection("Landlock", network), fence, outside)):
            return Protection("Landlock", network)
        return Protection("limits alone", network)


def _works(by: Protection, fence: Fence, outside: Path) -> Iterator[bool]:
    """Whether what is inside can be read, what is outside not, and what is inside can be written."""
    yield _probe(by, fence, ["cat", str(fence.folder / "file")])
    yield not _probe(by, fence, ["cat", str(outside / "file")])
    yield _probe(by, fence, ["touch", str(fence.folder / "new")])
    yield not _probe(by, fence, ["touch", str(outside / "new")])


def _probe(by: Protection, fence: Fence, words: list[str]) -> bool:
    program = shutil.which(words[0], path="/usr/bin:/bin")
    if program is None:
        return False
    try:
        with _held(by, fence, {}) as held:
            command = [*held.before, program, *words[1:]]
            done = subprocess.run(
                command, capture_output=True, timeout=PROBE_TIME_LIMIT, preexec_fn=held.in_child, check=False
            )
    except (OSError, subprocess.SubprocessError):
        return False
    return done.returncode == 0


@contextmanager
def held(fence: Fence, environment: Mapping[str, str]) -> Iterator[Held]:
    """How a program is run behind a fence. `environment` is set for it inside of the fence alone."""
    with _held(protection(), fence, environment) as made:
        yield made


@contextmanager
def _held(by: Protection, fence: Fence, environment: Mapping[str, str]) -> Iterator[Held]:
    limits = _limits(fence)

    def limit() -> None:
        for which, most in limits:
            hard = resource.getrlimit(which)[1]
            within = most if hard == resource.RLIM_INFINITY else min(most, hard)
            resource.setrlimit(which, (within, within))

    if by.by == "bubblewrap":
        yield Held((*_bubblewrap(fence), *_settings(environment), "--"), limit, functools.partial(_too_much, fence))
        return
    before = ("/usr/bin/env", *(f"{name}={value}" for name, value in environment.items())) if environment else ()
    rules = -1
    if by.by == "Landlock":
        rules = landlock.ruleset((*SYSTEM, *fence.readable), (fence.folder, *DEVICES))

    def in_child() -> None:
        limit()
        if by.network:
            _unshare_network()
        if rules >= 0:
            landlock.restrict(rules)

    try:
        yield Held(before, in_child, functools.partial(_too_much, fence))
    finally:
        if rules >= 0:
            os.close(rules)


def _bubblewrap(fence: Fence) -> Iterator[str]:
    """The words before a command. Its root is an empty file system in memory, closed to writing at the end."""
    yield shutil.which("bwrap") or "bwrap"
    yield from ("--die-with-parent", "--unshare-all", "--cap-drop", "ALL")
    for path in (*SYSTEM, *fence.readable):
        # As a link where it is one, as /bin to usr/bin: what it leads to is there too.
        if path.is_symlink() and path in SYSTEM:
            yield from ("--symlink", str(path.readlink()), str(path))
        else:
            yield from ("--ro-bind-try", str(path), str(path))
    for path in DEVICES:
        yield from ("--dev-bind-try", str(path), str(path))
    yield from ("--bind", str(fence.folder), str(fence.folder), "--remount-ro", "/")


def _settings(environment: Mapping[str, str]) -> Iterator[str]:
    for name, value in environment.items():
        yield from ("--setenv", name, value)


def _limits(fence: Fence) -> list[tuple[int, int]]:
    return [
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_CPU, fence.cpu_seconds),
        (resource.RLIMIT_FSIZE, fence.file_bytes),
        (resource.RLIMIT_AS, fence.memory_bytes),
        (resource.RLIMIT_NPROC, _processes() + MORE_PROCESSES),
        (resource.RLIMIT_NOFILE, MOST_FILES),
    ]


@functools.cache
def _processes() -> int:
    """Of this user, with their threads."""
    count = 0
    for path in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if path.stat().st_uid == os.getuid():
                count += len(os.listdir(path / "task"))  # noqa: PTH208 (a count alone)
    return count


def memory_limit() -> int:
    """Bytes of address space that a program may have: MEMORY_SHARE of the machine's memory, or of what this process's
    group may have, within bounds."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    with suppress(OSError, ValueError):
        memory = min(memory, int(Path("/sys/fs/cgroup/memory.max").read_text()))
    return max(LEAST_MEMORY, min(MOST_MEMORY, int(MEMORY_SHARE * memory)))


def _too_much(fence: Fence) -> str | None:
    """Why a program has to end for what it leaves in its folder, if it has to."""
    count, size, waiting = 0, 0, [fence.folder]
    while waiting:
        with suppress(OSError), os.scandir(waiting.pop()) as entries:
            for entry in entries:
                count += 1
                if count > MOST_FILES:
                    return f"left more than {MOST_FILES} files in its scratch folder"
                with suppress(OSError):
                    size += entry.stat(follow_symlinks=False).st_blocks * 512
                    if entry.is_dir(follow_symlinks=False):
                        waiting.append(Path(entry.path))
    if size > fence.folder_bytes:
        return f"left more than {fence.folder_bytes >> 20} MiB in its scratch folder"
    return None


def _unshare_network() -> None:
    """Leaves the network, where that can be done."""
    if _LIBC is not None and _LIBC.unshare(_NEW_USER | _NEW_NETWORK):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def _unshares_network() -> bool:
    """Whether a process can."""
    try:
        done = subprocess.run(["/usr/bin/true"], timeout=PROBE_TIME_LIMIT, preexec_fn=_unshare_network, check=False)
    except (OSError, subprocess.SubprocessError):
        return False
    return done.returncode == 0
