"""Files of others, read with a bound; and their words, as a terminal shows them."""

from __future__ import annotations

import os
import stat
import unicodedata
from pathlib import Path

from aliascope.errors import InvalidInput


def read_bytes(path: Path, most: int, what: str, shown: str | None = None) -> bytes:
    """What a file of at most `most` bytes holds: a file alone, no pipe and no device, which may never end. `what` it is
    and how it is `shown`, for errors. Raises InvalidInput."""
    shown = str(path) if shown is None else shown
    try:
        # A pipe that nobody writes into would not even open.
        opened = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            if stat.S_ISDIR(os.fstat(opened).st_mode):
                raise InvalidInput(f"{shown}: cannot be read: it is a folder")
            if not stat.S_ISREG(os.fstat(opened).st_mode):
                raise InvalidInput(f"{shown}: cannot be read: it is no file, but a pipe or a device")
            data = bytearray()
            while len(data) <= most and (piece := os.read(opened, min(1 << 24, most + 1 - len(data)))):
                data += piece
        finally:
            os.close(opened)
    except (OSError, ValueError) as error:  # ValueError: of a name with a NUL byte
        reason = error.strerror if isinstance(error, OSError) else "a name has no NUL byte"
        raise InvalidInput(f"{shown}: cannot be read: {reason}") from error
    if len(data) > most:
        raise InvalidInput(f"{shown}: a {what} file has at most {most >> 20} MiB")
    return bytes(data)


def shortened(text: str, most: int = 200) -> str:
    """A text of at most so many characters, its middle left out."""
    return text if len(text) <= most else f"{text[: most // 2]}...{text[-most // 4 :]}"


def steers(text: str) -> bool:
    """Whether a terminal would do something else than show it: it has control characters, or marks that turn the
    direction of writing, with which a name can look like another."""
    return any(map(_steers, text))


def as_shown(text: str) -> str:
    """A text with its control characters, and the marks that turn the direction of writing, as Python writes them."""
    return "".join(ascii(c)[1:-1] if _steers(c) else c for c in text)


def _steers(character: str) -> bool:
    return unicodedata.category(character) in ("Cc", "Cs", "Zl", "Zp") or unicodedata.bidirectional(character) in (
        *("LRE", "RLE", "LRO", "RLO", "PDF"),
        *("LRI", "RLI", "FSI", "PDI"),
    )
