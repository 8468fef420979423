"""One check of a plugin, in a process that may crash or hang: python -m aliascope.studies.plugin_probe FD CHECK PATH
[SPEC]. The file FD gets, at NOTE_AT, what is being done, and at RESULT_AT, in the end, what came out, as JSON.

The plugin may be anybody's: where the system has Landlock, the process can read the plugin's folder, its own libraries
and Python's alone, write nothing, start no program, and has no network, before a line of the plugin runs."""

from __future__ import annotations

import ctypes
import json
import os
import resource
import signal
import sys
from pathlib import Path
from typing import Any

from aliascope import landlock, places

NOTE_AT, NOTE_BYTES, RESULT_AT = 0, 400, 4096
TABLE = "table"
LARGEST_FILE = 1 << 26
LEAST_MEMORY = 1 << 30
_NEW_USER, _NEW_NETWORK = 0x10000000, 0x40000000  # CLONE_NEWUSER, CLONE_NEWNET of linux/sched.h
_SET_PARENT_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of linux/prctl.h


def run_check(check: str, path: str, spec: str | None, note: Any) -> dict[str, str]:
    """What came out: `status` is "ok", "failed", "skipped", or "no-plugin"; `text` says it in one line."""
    from aliascope.studies.plugin_contracts import CONTRACTS
    from aliascope.studies.plugin_subject import Broken, NothingToCheck, Subject
    from aliascope.studies.plugin_table import NoPlugin, load, table

    try:
        if check == TABLE:
            finding, spec = table(path, spec)
            return {"status": "ok", "text": finding.text, "spec": spec}
        load(path)
        finding = CONTRACTS[check](Subject(str(spec), note))
    except Broken as reason:
        return {"status": "failed", "text": str(reason)}
    except NothingToCheck as reason:
        return {"status": "skipped", "text": str(reason)}
    except NoPlugin as reason:
        return {"status": "no-plugin", "text": str(reason)}
    return {"status": "ok", "text": finding.text, "digest": finding.digest}


def confine(plugin: Path) -> None:
    """Limits hold everywhere: on memory, on files, on processes. A plugin in the home folder itself is read alone."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    for which, most in (
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_FSIZE, LARGEST_FILE),
        (resource.RLIMIT_AS, max(LEAST_MEMORY, memory)),
    ):
        hard = resource.getrlimit(which)[1]
        within = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(which, (within, within))
    ctypes.CDLL(None).unshare(_NEW_USER | _NEW_NETWORK)  # which not every system grants
    if not landlock.abi():
        return
    beside = plugin if Path("~").expanduser().resolve().is_relative_to(plugin.parent) else plugin.parent
    own = (Path(sys.prefix), Path(sys.base_prefix), places.PACKAGE, Path("/proc/self"))
    rules = landlock.ruleset((*landlock.SYSTEM, *own, beside), landlock.DEVICES, programs=False)
    landlock.restrict(rules)
    os.close(rules)


def main() -> None:
    file, check, path, *rest = sys.argv[1:]
    fd = int(file)

    def note(text: str) -> None:
        os.pwrite(fd, text.encode()[:NOTE_BYTES].ljust(NOTE_BYTES), NOTE_AT)

    confine(Path(path))
    ctypes.CDLL(None).prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)  # which another user namespace forgets
    note("while it was loaded")
    result = run_check(check, path, rest[0] if rest else None, note)
    note("at the end of the process")
    os.pwrite(fd, json.dumps(result).encode(), RESULT_AT)


if __name__ == "__main__":
    main()
