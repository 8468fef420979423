"""One run at a time in a folder of results.

The lock is the kernel's (flock on FOLDER/.lock), so it ends with the process that holds it, however that ends. The
file stays, and says who holds it while somebody does.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from aliascope.errors import NotWritable

NAME = ".lock"

_NONE = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}
"""Of a file system that has no locks."""

_WRITTEN_WITHIN = 0.5
"""Seconds until a process that has the lock has written who it is."""


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Holds a folder, which is made. Raises NotWritable where another process holds it, or it cannot be written. On a
    file system that has no locks nothing is held."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file = os.open(folder / NAME, os.O_RDWR | os.O_CREAT, 0o666)  # not handed on to other programs
    except OSError as error:
        raise NotWritable(f"{folder}: cannot be written: {error.strerror}; choose another folder with -o") from error
    try:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno not in _NONE:
                raise NotWritable(
                    f"{folder}: {_holder(file)} is writing there: wait for it, or choose another folder with -o"
                ) from error
        _write(file, f"{os.getpid()} {socket.gethostname()} {_name()}\n")
        yield
        _write(file, "")
    finally:
        os.close(file)


def _name() -> str:
    """What runs, without its arguments: "aliascope compare"."""
    words = [word for word in sys.argv[1:] if not word.startswith("-")]
    return " ".join(["aliascope", *words[:1]]) if Path(sys.argv[0]).name in ("aliascope", "__main__.py") else "Python"


def _write(file: int, text: str) -> None:
    with contextlib.suppress(OSError):  # on a full disk the lock holds all the same
        os.ftruncate(file, 0)
        os.pwrite(file, text.encode(), 0)


def _holder(file: int) -> str:
    """Who holds the lock. What one that was killed has left there is not believed."""
    deadline = time.monotonic() + _WRITTEN_WITHIN
    while True:
        number, _, rest = os.pread(file, 4096, 0).decode(errors="replace").strip().partition(" ")
        host, _, name = rest.partition(" ")
        elsewhere = host != socket.gethostname()
        if number.isdecimal() and (elsewhere or Path(f"/proc/{number}").exists()):
            return f"process {number} ({name})" + (f" on {host}" if elsewhere else "")
        if time.monotonic() > deadline:
            return "another process"
        time.sleep(0.02)
