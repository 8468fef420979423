"""The command line. Each command says what it does with an example; errors are one line and an exit code."""

from __future__ import annotations

import sys

from aliascope import logs
from aliascope.bounded import as_shown

# Each registers its commands.
from aliascope.cli import (
    about,
    caching,
    comparing,
    estimating,
    filtering,
    history,
    integrating,
    knobs,
    pictures,
    plugins,
    powering,
    regressing,
    sampling,
    stability,
    sweeping,
    teaching,
    working,
)
from aliascope.cli.shared import app
from aliascope.errors import AliascopeError, NotWritable

__all__ = [
    "about",
    "caching",
    "comparing",
    "estimating",
    "filtering",
    "history",
    "integrating",
    "knobs",
    "main",
    "pictures",
    "plugins",
    "powering",
    "regressing",
    "sampling",
    "stability",
    "sweeping",
    "teaching",
    "working",
]


ALONE = ("-v", "--verbose", "-q", "--quiet")
"""The options of all commands that have no value."""

OF_PLUGINS = ("--plugin", "--trust-plugin")
"""Those that have one."""


def _common_first(words: list[str]) -> list[str]:
    """The command line with the options of all commands, of plugins, -v and -q, before the command, where they are
    declared."""
    first: list[str] = []
    rest: list[str] = []
    while words:
        word, *words = words
        if word == "--":
            return [*first, *rest, word, *words]
        if word in OF_PLUGINS and words:
            first += [word, words.pop(0)]
        else:
            (first if word in ALONE or word.partition("=")[0] in OF_PLUGINS else rest).append(word)
    return [*first, *rest]


def main() -> None:
    """Runs a command; ends with the exit code of the error's class, 2 for a command line that can't be read."""
    code, why = 1, ""
    try:
        app(_common_first(sys.argv[1:]))
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else 0 if ended.code is None else 1
    except AliascopeError as problem:
        code, why = _complain(str(problem), problem.exit_code), str(problem)
    except OSError as problem:
        code, why = _complain(str(problem), NotWritable.exit_code), str(problem)
    except BaseException as problem:
        why = f"{type(problem).__name__}: {problem}"
        raise
    finally:
        logs.end(code, why)
    sys.exit(code)


def _complain(message: str, code: int) -> int:
    print(f"aliascope: {as_shown(' '.join(message.split()))}", file=sys.stderr)
    return code
