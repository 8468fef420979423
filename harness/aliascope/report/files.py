"""The files of a page: the sources that it is made of, and writing what it comes to."""

from __future__ import annotations

import base64
import hashlib
from importlib.resources import files

from jinja2 import Environment, StrictUndefined

from aliascope.text_files import write_text

__all__ = ["digest", "environment", "source", "write_text"]


def environment() -> Environment:
    """That of all pages: escapes, and knows no silence about a missing value."""
    return Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)


def source(name: str) -> str:
    """The text of a file of this package."""
    return files("aliascope.report").joinpath(name).read_text(encoding="utf-8")


def digest(text: str) -> str:
    """What a content security policy knows an inline script or style by: nothing else on the page may run or load."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
