"""The commands as a user runs them: what they print, and their exit codes.

They run in this process, which has loaded by then what each of them would load anew: their code is that of the program
from its command line on, and warnings are errors there too. `separately` starts the program itself, for what hangs on
the process: signals, pipes, plugins that are loaded.
"""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from unittest.mock import patch

from aliascope import cli

COMMAND = [sys.executable, "-W", "error", "-m", "aliascope.cli"]


class Terminal(io.StringIO):
    """What programs take for a terminal."""

    def isatty(self) -> bool:
        return True


def run(
    *arguments: str | Path,
    code: int = 0,
    env: Mapping[str, str] | None = None,
    cwd: Path | None = None,
    terminal: bool = False,
) -> subprocess.CompletedProcess[str]:
    """`env`: in place of the environment; `terminal`: standard error is one."""
    words = list(map(str, arguments))
    out, err = io.StringIO(), Terminal() if terminal else io.StringIO()
    with (
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        contextlib.chdir(cwd or Path.cwd()),
        patch.dict(os.environ, env or os.environ, clear=True),
        patch.object(sys, "argv", ["aliascope", *words]),
    ):
        ended: int | str | None = 0
        try:
            cli.main()
        except SystemExit as end:
            ended = end.code
    result = subprocess.CompletedProcess(words, ended or 0, out.getvalue(), err.getvalue())  # type: ignore[arg-type]
    return checked(result, code)


def separately(*arguments: str | Path, code: int = 0) -> subprocess.CompletedProcess[str]:
    command = [*COMMAND, *map(str, arguments)]
    return checked(subprocess.run(command, capture_output=True, text=True, timeout=300, check=False), code)


def checked(result: subprocess.CompletedProcess[str], code: int) -> subprocess.CompletedProcess[str]:
    assert result.returncode == code, result.stdout + result.stderr
    assert "Traceback" not in result.stderr
    return result


def complaint(*arguments: str | Path, code: int, env: Mapping[str, str] | None = None, cwd: Path | None = None) -> str:
    """The one line of an error."""
    lines = run(*arguments, code=code, env=env, cwd=cwd).stderr.splitlines()
    assert len(lines) == 1, lines
    assert lines[0].startswith("aliascope: ")
    return lines[0]
