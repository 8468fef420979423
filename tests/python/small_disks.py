"""Folders that are full or cannot be written, by whatever means the system allows."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path


def _done(*words: str | Path) -> bool:
    try:
        return subprocess.run(words, capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        return False


@contextlib.contextmanager
def tmpfs(folder: Path, size: str) -> Iterator[bool]:
    """A disk of this size mounted at a folder, which is made; False where mounting is refused."""
    folder.mkdir()
    mounted = _done("mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder)
    try:
        yield mounted
    finally:
        if mounted:
            assert _done("umount", folder)


def fill(folder: Path, left: int) -> Path:
    """A file that leaves so many bytes of a disk; the file."""
    ballast = folder / "ballast"
    free = os.statvfs(folder)
    ballast.write_bytes(bytes(max(0, free.f_bavail * free.f_frsize - left)))
    return ballast


def limit_files(longest: int) -> None:
    """Lets no file of this process grow past so many bytes: the next write fails, as on a full disk."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (longest, longest))


@contextlib.contextmanager
def read_only(folder: Path) -> Iterator[Path]:
    """The folder, which nobody can write to: by its permissions, by a mount, by an attribute, else a path below a
    file."""
    folder.chmod(0o555)
    undo: list[tuple[str | Path, ...]] = []
    if _writable(folder) and _done("mount", "--bind", folder, folder):
        undo = [("umount", folder)]
        _done("mount", "-o", "remount,ro,bind", folder)
    if _writable(folder) and _done("chattr", "+i", folder):
        undo.append(("chattr", "-i", folder))
    try:
        if _writable(folder):
            (folder / "file").write_text("")
            yield folder / "file" / "below"
        else:
            yield folder
    finally:
        for words in reversed(undo):
            assert _done(*words)
        folder.chmod(0o755)


def _writable(folder: Path) -> bool:
    try:
        (folder / "probe").write_text("")
        (folder / "probe").unlink()
    except OSError:
        return False
    return True
