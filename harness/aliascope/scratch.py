"""Scratch folders that do not stay behind: those of processes that were killed go when the next one is made.

A process holds each of its own by a lock of the kernel's, which ends with it.
"""

from __future__ import annotations

import contextlib
import fcntl
import functools
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from aliascope.errors import NotWritable

PREFIX = ".aliascope-scratch-"
"""Of nothing else, as what has it and is held by nobody is removed."""


@contextlib.contextmanager
def scratch_folder(kind: str, what: str) -> Iterator[Path]:
    """A folder of one's own below the system's for temporary files, with its `kind` in its name; `what` it is for, an
    error says. Raises NotWritable."""
    _remove_abandoned_once()
    while True:
        try:
            folder = Path(tempfile.mkdtemp(prefix=f"{PREFIX}{kind}-"))
        except OSError as error:
            raise NotWritable(f"no scratch folder for {what}: {error.strerror}") from error
        held = _hold(folder, fcntl.LOCK_EX)
        if held is not None or folder.exists():  # else another process found it in the moment before
            break
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if held is not None:  # there are file systems without locks
            os.close(held)


def remove_abandoned() -> None:
    """Removes the scratch folders that nobody holds."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        held = _hold(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if held is not None:
            shutil.rmtree(folder, ignore_errors=True)
            os.close(held)


_remove_abandoned_once = functools.cache(remove_abandoned)


def _hold(folder: Path, how: int) -> int | None:
    """The file that holds a folder; None for one that others hold, that is gone or not ours, or no folder."""
    try:
        file = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    except OSError:
        return None
    try:
        fcntl.flock(file, how)
        mine, now = os.fstat(file), folder.stat()
        if (mine.st_dev, mine.st_ino) == (now.st_dev, now.st_ino) and mine.st_uid == os.getuid():
            return file
    except OSError:
        pass
    os.close(file)
    return None
