"""A povray that does what a test wants: a shell script by that name, in a folder to be put first on the PATH."""

from __future__ import annotations

import shlex
import time
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # the name that its own documentation uses

STATISTICS = """
Pixels:               64   Samples:               0   Smpls/Pxl: 0.00
Rays:                 64   Saved:                 0   Max Level: 1/5
  Trace Time:       0 hours  0 minutes  0 seconds (0.003 seconds)
              using 1 thread(s) with 0.002 CPU-seconds total
"""
"""As POV-Ray 3.7.0.10 prints it, of a picture of 8x8 pixels."""


def install(folder: Path, body: str) -> Path:
    """Writes the script, whose commands are `body`, to folder/povray, and returns the folder."""
    folder.mkdir(exist_ok=True)
    script = folder / "povray"
    script.write_text(f"#!/bin/sh\n{body}\n")
    script.chmod(0o755)
    return folder


def leaving(picture: Path) -> str:
    """Commands that leave a copy of `picture`, print statistics, and end well."""
    return f"cp {shlex.quote(str(picture))} picture.png; printf '%s' {shlex.quote(STATISTICS)} >&2"


def leaving_frames(picture: Path, count: int, missing: int = 0, padding: int = 0) -> str:
    """Commands that do the same for so many frames, but for the picture of one, and print more bytes a frame."""
    source, text = shlex.quote(str(picture)), shlex.quote(STATISTICS)
    copy = f"cp {source} $(printf 'frame%0{len(str(count))}d.png' $i)"
    body = f"[ $i = {missing} ] || {copy}; printf '%s%{padding}s\\n' {text} ' ' >&2"
    return f"i=1; while [ $i -le {count} ]; do {body}; i=$((i+1)); done"


def write_png(path: Path, width: int, height: int, channels: int = 3) -> Path:
    """A grey 16-bit PNG."""
    out = oiio.ImageOutput.create(str(path))
    assert out is not None
    assert out.open(str(path), oiio.ImageSpec(width, height, channels, "uint16"))
    assert out.write_image(np.full((height, width, channels), 0.5, np.float32))
    assert out.close()
    return path


def recording_its_processes(record: Path) -> str:
    """Commands that start a second process, write both numbers to `record`, and hang for a minute."""
    quoted = shlex.quote(str(record))
    return f"sleep 60 & echo $$ $! > {quoted}.part; mv {quoted}.part {quoted}; wait"


def recorded(record: Path, patience: float = 5.0) -> list[int]:
    """The numbers in `record`, once it is there."""
    deadline = time.monotonic() + patience
    while not record.exists():
        assert time.monotonic() < deadline, "the fake povray did not start"
        time.sleep(0.02)
    return [int(word) for word in record.read_text().split()]


def alive(pid: int) -> bool:
    """Whether the process runs; one that is dead and not yet reaped by its parent does not."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state not in "ZX"


def ends(pid: int, patience: float = 5.0) -> bool:
    """Whether the process ends within so many seconds: a signal takes effect a moment after it was sent."""
    deadline = time.monotonic() + patience
    while alive(pid):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.02)
    return True
