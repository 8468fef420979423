"""Linux's Landlock: a process gives up, for itself and all that it starts, the files that are not on a list.

It needs neither rights nor another program, and works in containers too. See the kernel's
Documentation/userspace-api/landlock.rst, from which the numbers below are, and `man 7 landlock`. A later version of it
(ABI) can forbid more.
"""

from __future__ import annotations

import ctypes
import functools
import os
import sys
from collections.abc import Sequence
from pathlib import Path

_CREATE, _ADD, _RESTRICT = 444, 445, 446
"""The numbers of its system calls, the same on all machines."""
_VERSION = 1
_PATH_BENEATH = 1
_NO_NEW_PRIVS = 38
"""PR_SET_NO_NEW_PRIVS, without which only root may restrict itself."""

_EXECUTE, _WRITE, _READ, _READ_FOLDER = 1, 2, 4, 8
_RIGHTS_OF_ABI = {1: 13, 2: 14, 3: 15, 5: 16}
"""How many rights to files there are, from an ABI on: bits from 0."""
_NETWORK_ABI = 4
_BIND_AND_CONNECT = 3
_SCOPE_ABI = 6
_SOCKETS_AND_SIGNALS = 3
"""Those of processes that are not held by the same rules."""
_OF_FILES = _EXECUTE | _WRITE | _READ | 1 << 14 | 1 << 15
"""Rights that a file can have by itself; the others are those of folders."""

_LIBC = ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None


class _Ruleset(ctypes.Structure):
    _fields_ = (("files", ctypes.c_uint64), ("network", ctypes.c_uint64), ("scoped", ctypes.c_uint64))


class _Beneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = (("allowed", ctypes.c_uint64), ("parent", ctypes.c_int32))


@functools.cache
def abi() -> int:
    """Its version here, from 1; 0 where there is none."""
    return max(0, _LIBC.syscall(_CREATE, None, ctypes.c_size_t(0), _VERSION)) if _LIBC else 0


def closes_network() -> bool:
    """Whether it can forbid TCP."""
    return abi() >= _NETWORK_ABI


SYSTEM = tuple(
    map(Path, ("/usr", "/lib", "/lib32", "/lib64", "/bin", "/sbin", "/etc/ld.so.cache", "/etc/alternatives"))
)
"""Programs, their libraries, and the data that come with them."""

DEVICES = (Path("/dev/null"), Path("/dev/urandom"))


def ruleset(readable: Sequence[Path], writable: Sequence[Path], *, programs: bool = True) -> int:
    """A file descriptor of rules, to be closed: what lies below `readable` can be read, and started where `programs`,
    below `writable` read and written, nothing else, no TCP, and no signal to a process outside. What is not there is
    passed over. Raises OSError."""
    assert _LIBC is not None
    rights = (1 << max(count for least, count in _RIGHTS_OF_ABI.items() if least <= abi())) - 1
    scoped = abi() >= _SCOPE_ABI
    rules = _Ruleset(rights, _BIND_AND_CONNECT if closes_network() else 0, _SOCKETS_AND_SIGNALS if scoped else 0)
    # A version takes the fields that it knows.
    size = 24 if scoped else 16 if closes_network() else 8
    made = int(_LIBC.syscall(_CREATE, ctypes.byref(rules), ctypes.c_size_t(size), 0))
    if made < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    try:
        reading = _READ | _READ_FOLDER | (_EXECUTE if programs else 0)
        for paths, allowed in ((readable, reading), (writable, rights & ~_EXECUTE)):
            for path in paths:
                _allow(made, path, allowed)
    except OSError:
        os.close(made)
        raise
    return made


def _allow(rules: int, path: Path, allowed: int) -> None:
    assert _LIBC is not None
    try:
        opened = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return
    try:
        rule = _Beneath(allowed if path.is_dir() else allowed & _OF_FILES, opened)
        if _LIBC.syscall(_ADD, rules, _PATH_BENEATH, ctypes.byref(rule), 0):
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()), str(path))
    finally:
        os.close(opened)


def restrict(rules: int) -> None:
    """Holds this process to the rules from now on. Raises OSError."""
    assert _LIBC is not None
    if _LIBC.prctl(_NO_NEW_PRIVS, 1, 0, 0, 0) or _LIBC.syscall(_RESTRICT, rules, 0):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
