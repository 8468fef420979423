"""Text files that are there whole or not at all, and files that grow line by line."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Sequence
from pathlib import Path

from aliascope.errors import NotWritable


def write_text(path: Path, text: str) -> Path:
    """Writes a text file whole or not at all, making its folder. Raises NotWritable."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        with contextlib.suppress(OSError):  # where the folder is none, neither is the file
            temporary.unlink()
    return path


def remove_unfinished(folder: Path) -> None:
    """Removes what a process that was killed in `write_text` left in this folder."""
    for path in folder.glob(".*"):
        if re.fullmatch(r"\..+\.\d+", path.name):
            path.unlink(missing_ok=True)


def append_lines(path: Path, lines: Sequence[str]) -> Path:
    """Appends lines in one write, so that two processes do not mix theirs, making the folder. Raises NotWritable."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
        try:
            os.write(file, "".join(f"{line}\n" for line in lines).encode())
        finally:
            os.close(file)
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error
    return path
