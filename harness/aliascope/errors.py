"""The exceptions of aliascope. Each is one line for a person: what is wrong, where, and what to do.

`exit_code` is what the command line ends with: 1 the check failed, 2 usage or invalid input, 3 a renderer or library
that was asked for is not there, 4 a job crashed, hung or could not be written.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

LONGEST_MESSAGE = 4000
"""Characters. What a file quotes of itself may be all of it."""


class AliascopeError(Exception):
    """The root of the tree; never raised itself."""

    exit_code = 4

    def __str__(self) -> str:
        return one_line(super().__str__())


def one_line(text: str) -> str:
    """A text in which what is not to be printed, such as a line's end in a name, is as Python writes it in a string. Of
    one that is longer than LONGEST_MESSAGE the middle is left out, and how much is said."""
    if len(text) > LONGEST_MESSAGE:
        half = LONGEST_MESSAGE // 2
        text = f"{text[:half]} [... {len(text) - 2 * half} characters ...] {text[-half:]}"
    if text.isprintable():
        return text
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode("ascii") for each in text)


class CheckFailed(AliascopeError):
    """A comparison came out wrong: a regression, a reference that is missing or does not hold."""

    exit_code = 1


class InvalidInput(AliascopeError):
    """A scene, spec, picture or argument that can't be used."""

    exit_code = 2


class SpecError(InvalidInput):
    """An unknown name or key of a spec, or a value outside its range."""


class Unsupported(InvalidInput):
    """A request that is well formed but does not exist: 17 samples of a 4 x 4 grid."""


class NotAvailable(AliascopeError):
    """A renderer or library that was asked for is not installed or does not start."""

    exit_code = 3


class JobFailed(AliascopeError):
    """A renderer crashed, hung, or left no picture."""


class NotFinite(JobFailed):
    """A result that is no finite number, such as a picture brighter than float32 holds."""


class NotWritable(AliascopeError):
    """A file or folder of results could not be written."""


class Interrupted(AliascopeError):
    """The user asked to stop."""

    exit_code = 130


def whole(value: int, what: str, least: int, most: int) -> int:
    """A whole number within its range, which C would otherwise take for another. Raises InvalidInput."""
    if not least <= value <= most:
        raise InvalidInput(f"{what} is from {least} to {_power(most)}, not {value}")
    return value


def _power(number: int) -> str:
    """As 2^64 - 1 where it is one less than a large power of two."""
    bits = number.bit_length()
    return f"2^{bits} - 1" if bits > 16 and number + 1 == 1 << bits else str(number)


_LONGEST_WORD, _MOST_WORDS = 200, 500


def near_misses(word: str, known: Iterable[str]) -> str:
    """The tail of an error about an unknown word: `; did you mean "x"?`, or the list of what is known."""
    names = sorted(set(known))
    # Of long words and many of them all this takes long, and is no help.
    comparable = len(word) <= _LONGEST_WORD and len(names) <= _MOST_WORDS
    close = difflib.get_close_matches(word, names, n=3, cutoff=0.6) if comparable else []
    if close:
        return "; did you mean " + " or ".join(f'"{name}"' for name in close) + "?"
    more = f" and {len(names) - _MOST_WORDS} more" if len(names) > _MOST_WORDS else ""
    return "; known: " + ", ".join(names[:_MOST_WORDS]) + more if names else ""
