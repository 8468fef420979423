"""The command line. Each command says what it does with an example; errors are one line and an exit code."""

from __future__ import annotations

import sys

# Each registers its commands.
from aliascope.cli import (
    about,
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
)
from aliascope.cli.shared import app
from aliascope.errors import AliascopeError, NotWritable

__all__ = [
    "about",
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
]


def _plugins_first(words: list[str]) -> list[str]:
    """The command line with each --plugin F.so before the command, where the option is declared."""
    first: list[str] = []
    rest: list[str] = []
    while words:
        word, *words = words
        if word == "--":
            return [*first, *rest, word, *words]
        if word == "--plugin" and words:
            first += [word, words.pop(0)]
        else:
            (first if word.startswith("--plugin=") else rest).append(word)
    return [*first, *rest]


def main() -> None:
    """Runs a command; ends with the exit code of the error's class, 2 for a command line that can't be read."""
    try:
        app(_plugins_first(sys.argv[1:]))
    except AliascopeError as problem:
        sys.exit(_complain(str(problem), problem.exit_code))
    except OSError as problem:
        sys.exit(_complain(str(problem), NotWritable.exit_code))


def _complain(message: str, code: int) -> int:
    print(f"aliascope: {' '.join(message.split())}", file=sys.stderr)
    return code
