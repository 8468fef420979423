"""What the fuzz targets in Python share: imports that atheris counts, files of any bytes, and what may come of them."""

from __future__ import annotations

import atexit
import contextlib
import functools
import os
import shutil
import sys
import tempfile
import warnings
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

COUNTED = ["aliascope", "tomllib", "trimesh"]
"""Packages whose branches guide the search: ours, and parsers that are Python."""

LONGEST_MESSAGE = 4100
"""Characters: those of `aliascope.errors`, and what is said of those left out."""


def counted(name: str) -> AbstractContextManager[object]:
    """What is imported within is counted where `name` is "__main__": a run, and no replay of kept inputs."""
    if name != "__main__":
        return contextlib.nullcontext()
    import atheris

    return atheris.instrument_imports(include=COUNTED)


def main(one_input: Callable[[bytes], None]) -> None:
    """Runs a target under libFuzzer, whose options are the program's."""
    import atheris

    warnings.filterwarnings("error", module="aliascope")  # what its arithmetic warns of was not foreseen
    program = os.environ.get("FUZZ_PROGRAM", sys.argv[0])  # what libFuzzer starts again where it minimises
    atheris.Setup([program, *sys.argv[1:]], one_input)
    atheris.Fuzz()


@functools.cache
def folder() -> Path:
    """One of this process alone, which goes when it ends."""
    made = Path(tempfile.mkdtemp(prefix="fuzz-"))
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    return made


def written(name: str, data: bytes) -> Path:
    path = folder() / name
    path.write_bytes(data)
    return path


def refused(error: Exception, named: str = "") -> None:
    """A message is one line, that ends, and names the file. Raises AssertionError."""
    text = str(error)
    assert text, "no message"
    assert len(text.splitlines()) == 1, f"more than a line: {text!r}"
    assert text.isprintable(), f"signs that are none to print: {text!r}"
    assert len(text) <= LONGEST_MESSAGE, f"{len(text)} characters: {text[:400]!r}"
    assert named in text, f"does not name {named}: {text!r}"
