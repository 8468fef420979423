"""Runs readers on files of others as a user's program would: in a process with little memory that has to end."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

MEMORY = 6 << 30
"""Bytes of address space, of which the libraries take 1.5 GiB; each limit of a reader is well below the rest."""
TIME_LIMIT = 400.0
"""Seconds on the wall for all files together, on a busy machine."""

_PROGRAM = """
import json, resource, sys, time
resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[1]),) * 2)
from pathlib import Path
from aliascope import errors, image, meshes, scene_io
from aliascope.references import files
from aliascope.renderers import external_file, povray_file
from aliascope.studies import point_files
READERS = {
    "scene": lambda path: scene_io.load_file(Path(path)),
    "picture": lambda path: image.read_image(Path(path)),
    "header": lambda path: image.read_header(Path(path)),
    "points": point_files.read_points,
    "renderer": lambda path: external_file.read(Path(path)),
    "pov": lambda path: povray_file.open_file(Path(path)),
}
for line in sys.stdin:
    kind, path = json.loads(line)
    begun = time.monotonic()
    try:
        READERS[kind](path)
        told = "read"
    except errors.AliascopeError as error:
        told = f"{type(error).__name__}: {error}"
    except BaseException as error:
        told = f"CRASH {type(error).__name__}: {str(error)[:200]}"
    print(json.dumps([told, time.monotonic() - begun]), flush=True)
"""


def read(files: Sequence[tuple[str, Path | str]], memory: int = MEMORY) -> list[str]:
    """What becomes of each file, by the kind of its reader: "read", or the class and the text of its error."""
    lines = "".join(json.dumps([kind, str(path)]) + "\n" for kind, path in files)
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM, str(memory)],
        input=lines,
        capture_output=True,
        text=True,
        timeout=TIME_LIMIT,
        check=False,
    )
    told = [json.loads(line)[0] for line in done.stdout.splitlines()]
    assert len(told) == len(files), f"after {told[-1:]} of {files[len(told)]}: {done.returncode} {done.stderr[-2000:]}"
    return told
