"""The files of a page: the sources that it is made of, and writing what it comes to."""

from __future__ import annotations

import base64
import contextlib
import hashlib
import os
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, StrictUndefined

from aliascope.errors import NotWritable


def environment() -> Environment:
    """That of all pages: escapes, and knows no silence about a missing value."""
    return Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)


def source(name: str) -> str:
    """The text of a file of this package."""
    return files("aliascope.report").joinpath(name).read_text(encoding="utf-8")


def digest(text: str) -> str:
    """What a content security policy knows an inline script or style by: nothing else on the page may run or load."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")


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
