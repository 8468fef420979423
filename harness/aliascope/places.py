"""Where the project's own scenes, references and libraries lie, and from which revision and machine results come.

In the source tree, which `make` installs by reference, they lie where they are edited; an installed package has its
own, in `data` beside its modules, as the build put them there (`harness/build_package.py`). Nothing else decides.
"""

from __future__ import annotations

import functools
import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

from aliascope.errors import InvalidInput

PACKAGE = Path(__file__).resolve().parent
_PACKED = PACKAGE / "data"
INSTALLED = _PACKED.is_dir()
"""Whether this is a package that was built and installed, not the source tree."""
_ROOT = _PACKED if INSTALLED else PACKAGE.parents[1]

SCENES = _ROOT / "scenes"
REFERENCES = _ROOT / "reference"
LIBRARIES = PACKAGE / "native" / "lib"
REVISION = _ROOT / "revision"
"""Of an installed package, and of a source distribution: which revision of the repository it was made from."""


def kept_in(folder: Path | None, option: str) -> Path:
    """The folder that references and blessed figures are to be written to: one that was given, else the source tree's.

    Raises InvalidInput for an installed package's: the next installation would throw away what is written there.
    """
    if INSTALLED and (folder is None or folder.resolve() == REFERENCES):
        raise InvalidInput(
            f"the references of an installed aliascope stay as they are: name a folder of yours with {option} DIR"
        )
    return folder or REFERENCES


@functools.cache
def revision() -> str:
    """The git revision of the source tree, with "+" where it has changes, or what was written when it was packed;
    "unknown" outside a repository."""
    try:
        if REVISION.is_file():
            return REVISION.read_text(encoding="utf-8").strip()
        # The repository of somebody else may lie around it.
        if Path(_git("rev-parse", "--show-toplevel")) != _ROOT:
            return "unknown"
        commit = _git("rev-parse", "--short=12", "HEAD")
        return commit + ("+" if _git("status", "--porcelain", "--untracked-files=no") else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def _git(*arguments: str) -> str:
    # Without the lock that status takes to write what it found to the index: killed meanwhile, it would leave it there.
    command = ["git", "--no-optional-locks", "-C", str(_ROOT), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


@functools.cache
def machine() -> dict[str, str]:
    """Processor, number of cores, system."""
    processor = platform.processor()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        names = [line.partition(":")[2] for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        processor = names[0].strip() if names else processor
    return {
        "processor": processor or platform.machine(),
        "cores": str(len(os.sched_getaffinity(0))),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
    }


def own_version() -> str:
    return version("aliascope")
