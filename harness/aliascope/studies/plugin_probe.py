"""One check of a plugin, in a process that may crash or hang: python -m aliascope.studies.plugin_probe FD CHECK PATH
[SPEC]. The file FD gets, at NOTE_AT, what is being done, and at RESULT_AT, in the end, what came out, as JSON.

The plugin may be anybody's: the process is held as `plugin_fence` says before a line of the plugin runs."""

from __future__ import annotations

import ctypes
import json
import os
import signal
import sys
from pathlib import Path
from typing import Any

from aliascope.native import plugin_fence

NOTE_AT, NOTE_BYTES, RESULT_AT = 0, 400, 4096
TABLE = "table"
MEMORY_SHARE = 1 / 2
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


def main() -> None:
    file, check, path, *rest = sys.argv[1:]
    fd = int(file)

    def note(text: str) -> None:
        os.pwrite(fd, text.encode()[:NOTE_BYTES].ljust(NOTE_BYTES), NOTE_AT)

    ctypes.CDLL(None).prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)
    plugin_fence.hold(Path(path), plugin_fence.memory_limit(MEMORY_SHARE))
    note("while it was loaded")
    result = run_check(check, path, rest[0] if rest else None, note)
    note("at the end of the process")
    os.pwrite(fd, json.dumps(result).encode(), RESULT_AT)


if __name__ == "__main__":
    main()
