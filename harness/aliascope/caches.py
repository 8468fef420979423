"""What is kept from run to run so that it need not be made again: where, how much at most, and out with the oldest.

All of it lies in one folder, each cache in one of its own. What is there can be made again and may go at any time, also
while others read it: a file is written whole under its name, and one that is open stays readable when its name is gone.
Results of commands, `-o DIR`, are no caches: they are the user's.
"""

from __future__ import annotations

import contextlib
import os
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from aliascope.errors import InvalidInput, NotWritable

VARIABLE = "ALIASCOPE_CACHE"
LIMIT = 500_000_000
"""Bytes of all caches, unless the user says otherwise: ten revisions of what `make power` renders."""
LIMIT_FILE = "limit"
KNOWN = {"power": "what the hidden command power has rendered, for its repetitions: half an hour's work"}
"""The caches, and what is in each."""

PART = ".part"
"""How the names of files end that are half written."""
ABANDONED = 3600.0
"""Seconds after which a file that is only half written belongs to a process that is gone."""
_UNITS = {"B": 1, "kB": 10**3, "KB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}
_UNITS |= {"KiB": 1 << 10, "MiB": 1 << 20, "GiB": 1 << 30, "TiB": 1 << 40}

_used: set[Path] = set()
"""Files that this process has read or written: a run keeps what it uses until it ends."""


NO_HOME = Path(os.devnull)
"""Below which nobody can make a folder."""


@dataclass(frozen=True)
class Usage:
    """How many files there are, and their bytes."""

    files: int
    size: int


def root() -> Path:
    """The folder of all caches: $ALIASCOPE_CACHE, else aliascope in $XDG_CACHE_HOME, else in ~/.cache."""
    own = os.environ.get(VARIABLE)
    if own:
        return Path(own).expanduser().absolute()
    others = os.environ.get("XDG_CACHE_HOME", "")
    # XDG Base Directory Specification 0.8: a path that is relative is to be ignored.
    return (Path(others) if Path(others).is_absolute() else _home() / ".cache") / "aliascope"


def _home() -> Path:
    """The user's, or what can't hold a cache: in a container the number of a process may be that of no user."""
    try:
        home = Path.home()
    except RuntimeError:
        return NO_HOME
    return home if home.is_absolute() else NO_HOME


def folder(name: str) -> Path:
    """The folder of a cache, there or not."""
    return root() / name


def read(path: Path) -> bytes | None:
    """A file of a cache, which counts as used now; None where it is not there, or not any more."""
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise NotWritable(f"{path}: cannot be read: {error.strerror}; aliascope cache --empty removes it") from error
    _used.add(path)
    with contextlib.suppress(OSError):  # gone in this moment, or a folder that is read-only
        os.utime(path)
    return data


def write(path: Path, data: bytes) -> None:
    """Writes a file of a cache, whole or not at all, and removes the oldest of all caches beyond the limit. Raises
    NotWritable."""
    part = path.with_name(f".{path.name}.{os.getpid()}{PART}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(data)
        part.replace(path)
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}; set {VARIABLE} to another folder") from error
    finally:
        with contextlib.suppress(OSError):
            part.unlink()
    _used.add(path)
    trim()


def trim() -> Usage:
    """Removes files, the one that was used longest ago first, until what is left is within the limit; what this process
    has used stays. Returns what was removed."""
    most, removed = limit(), []
    found = sorted(_entries(), key=lambda each: (each[1].st_mtime_ns, each[0]))
    left = sum(status.st_size for _, status in found)
    for path, status in found:
        if _being_written(path, status):
            continue
        if (left > most or path.suffix == PART) and path not in _used and _remove(path):
            left -= status.st_size
            removed.append(status.st_size)
    return Usage(len(removed), sum(removed))


def empty(names: list[str]) -> Usage:
    """Removes all of these caches. Raises InvalidInput for a name that is none."""
    removed = []
    for name in names:
        check_name(name)
        found = _entries([name])
        removed += [status.st_size for path, status in found if not _being_written(path, status) and _remove(path)]
    return Usage(len(removed), sum(removed))


def usage(name: str) -> Usage:
    """What a cache has."""
    sizes = [status.st_size for _, status in _entries([name])]
    return Usage(len(sizes), sum(sizes))


def check_name(name: str) -> None:
    """Raises InvalidInput for what is no cache."""
    if name not in KNOWN:
        raise InvalidInput(f'there is no cache "{name}"; known: {", ".join(KNOWN)}')


def limit() -> int:
    """Bytes that all caches may have together: what was set, else LIMIT."""
    try:
        return bytes_of((root() / LIMIT_FILE).read_text(encoding="ascii").strip())
    except (OSError, UnicodeDecodeError, InvalidInput):
        return LIMIT


def set_limit(most: int) -> Usage:
    """Keeps how many bytes there may be from now on, and removes what is beyond. Raises NotWritable."""
    path = root() / LIMIT_FILE
    part = path.with_name(f".{LIMIT_FILE}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_text(f"{most} B\n", encoding="ascii")
        part.replace(path)
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error
    return trim()


def bytes_of(text: str) -> int:
    """A size as people write it: 200MB, 1.5 GiB, 0. Raises InvalidInput."""
    found = re.fullmatch(r"(\d{1,15}(?:\.\d{1,9})?) ?([kKMGT]i?B|B)|0", text.strip())
    if found is None or (found[2] or "B") not in _UNITS:
        raise InvalidInput(f'"{text}" is no size: a number with its unit, such as 200MB or 1.5GiB')
    return int(float(found[1]) * _UNITS[found[2]]) if found[1] else 0


def told(size: int) -> str:
    """A size for people."""
    for unit in ("TB", "GB", "MB", "kB"):
        if size >= _UNITS[unit]:
            return f"{size / _UNITS[unit]:.3g} {unit}"
    return f"{size} B"


def _entries(names: list[str] | None = None) -> Iterator[tuple[Path, os.stat_result]]:
    """The files of these caches, of all without names. What goes in between is left out."""
    for name in names or list(KNOWN):
        try:
            with os.scandir(folder(name)) as found:
                paths = [Path(each.path) for each in found if each.is_file(follow_symlinks=False)]
        except OSError:
            continue
        for path in paths:
            with contextlib.suppress(OSError):
                yield path, path.stat(follow_symlinks=False)


def _being_written(path: Path, status: os.stat_result) -> bool:
    return path.suffix == PART and time.time() - status.st_mtime < ABANDONED


def _remove(path: Path) -> bool:
    try:
        path.unlink()
    except OSError:  # another process was first
        return False
    return True
