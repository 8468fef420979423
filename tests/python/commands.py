"""The commands as a user runs them: what they print, and their exit codes.

They run in this process, which has loaded by then what each of them would load anew: their code is that of the program
from its command line on, and warnings are errors there too. `separately` starts the program itself, for what hangs on
the process: signals, pipes, plugins that are loaded, what is written past Python.
"""

from __future__ import annotations

import contextlib
import io
import multiprocessing
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, TypeVar
from unittest.mock import patch

from aliascope import cli, renderers

Result = TypeVar("Result")
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
    return checked(_unchecked(*arguments, env=env, cwd=cwd, terminal=terminal), code)


def _unchecked(
    *arguments: str | Path, env: Mapping[str, str] | None = None, cwd: Path | None = None, terminal: bool = False
) -> subprocess.CompletedProcess[str]:
    words = list(map(str, arguments))
    out, err = io.StringIO(), Terminal() if terminal else io.StringIO()
    with (
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        contextlib.chdir(cwd or Path.cwd()),
        patch.dict(os.environ, env or os.environ, clear=True),
        patch.object(sys, "argv", ["aliascope", *words]),
        patch.dict(renderers.RENDERERS),  # one that a command loads ends with it
    ):
        ended: int | str | None = 0
        try:
            cli.main()
        except SystemExit as end:
            ended = end.code
    return subprocess.CompletedProcess(words, ended or 0, out.getvalue(), err.getvalue())  # type: ignore[arg-type]


def separately(*arguments: str | Path, code: int = 0) -> subprocess.CompletedProcess[str]:
    command = [*COMMAND, *map(str, arguments)]
    return checked(subprocess.run(command, capture_output=True, text=True, timeout=300, check=False), code)


def in_a_fork(function: Callable[..., Result], *arguments: Any) -> Result:
    """What a function that starts no processes gives in one forked off this, quickly: what it needs is loaded."""
    fork = multiprocessing.get_context("fork")
    out, into = fork.Pipe(duplex=False)
    process = fork.Process(target=_send, args=(into, function, arguments))
    process.start()
    into.close()
    try:
        assert out.poll(300), "no end"
        found: Result = out.recv()
    finally:
        process.kill()
        process.join()
        process.close()
    return found


def _send(into: Connection, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    into.send(function(*arguments))


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


def environment(folder: Path, alone: bool = False) -> dict[str, str]:
    """This environment with a folder first on the PATH, or alone on it."""
    return {**os.environ, "PATH": str(folder) if alone else f"{folder}{os.pathsep}{os.environ['PATH']}"}
