"""What holds the process that a plugin of anybody's runs in, from before a line of the plugin runs.

Landlock has it read the plugin's folder, the system's libraries and Python's alone, and write nothing; seccomp has it
start no program and no process, open no socket, and reach no other process; limits hold its memory. Where the system
lacks one of them the others hold, and `told` says so.
"""

from __future__ import annotations

import os
import resource
import sys
from pathlib import Path

from aliascope import landlock, places, seccomp

LEAST_MEMORY = 1 << 30
LARGEST_FILE = 1 << 26
"""Of what it writes into files that it was given: what it says on standard error."""

_KEPT_VARIABLES = ("HOME", "LD_LIBRARY_PATH", "LANG", "LC_ALL", "PATH", "PYTHONPATH", "PYTHONHOME", "TZ")


def memory_limit(share: float) -> int:
    """Bytes of address space: this share of the machine's memory, and LEAST_MEMORY at least."""
    return max(LEAST_MEMORY, int(share * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")))


def environment() -> dict[str, str]:
    """That of a plugin's process: of this one's, which may hold secrets, what a process needs to begin."""
    return {name: os.environ[name] for name in _KEPT_VARIABLES if name in os.environ}


def hold(plugin: Path, memory: int) -> None:
    """Holds this process, which has one thread and needs no further file of Python's that it cannot read. A plugin in
    the home folder itself is read alone, without what is beside it. Raises OSError."""
    for which, most in (
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_FSIZE, LARGEST_FILE),
        (resource.RLIMIT_AS, memory),
    ):
        hard = resource.getrlimit(which)[1]
        within = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(which, (within, within))
    if landlock.abi():
        beside = plugin if _home().is_relative_to(plugin.parent) else plugin.parent
        own = (Path(sys.prefix), Path(sys.base_prefix), places.PACKAGE, Path("/proc/self"))
        rules = landlock.ruleset((*landlock.SYSTEM, *own, beside), landlock.DEVICES, programs=False)
        landlock.restrict(rules)
        os.close(rules)
    if seccomp.works():
        seccomp.restrict()


def _home() -> Path:
    try:
        return Path("~").expanduser().resolve()
    except RuntimeError:  # there is none
        return Path("/")


def told() -> str:
    """For people: one line."""
    files = "reads its folder and the system's libraries, writes nothing" if landlock.abi() else "files open to it"
    if seccomp.works():
        return f"{files}, no programs, no network, no other process"
    tcp = "no TCP" if landlock.closes_network() else "the network open to it"
    return f"{files}, {'no programs, ' if landlock.abi() else ''}{tcp}"
