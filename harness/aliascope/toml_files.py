"""TOML files that people write: read, and what is wrong with them said with file, line and key."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from aliascope.bounded import read_bytes, shortened
from aliascope.errors import InvalidInput, near_misses

LARGEST_FILE = 64 << 20
MOST_PARTS = 32
"""Of a dotted key. Reading one takes as long as their square."""

Place = tuple[str | int, ...]
"""Of a table or key in a file: ("surfaces", 3, "points")."""

Fields = Callable[[Place], Sequence[str]]
"""The keys that may stand at a place."""


def read(path: Path, what: str) -> tuple[dict[str, Any], dict[Place, int]]:
    """The contents of a file, and the line of each key. `what` it holds, for errors. Raises InvalidInput."""
    try:
        text = read_bytes(path, LARGEST_FILE, what).decode("utf-8").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise InvalidInput(f"{path}: is not UTF-8 text") from error
    _check_keys(path, text)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"\(at line (\d+), column \d+\)", str(error))
        line = place[1] if place else str(text.count("\n") + 1)
        reason = re.sub(r" \(at .*\)$", "", str(error))
        raise InvalidInput(f"{path}:{line}: not TOML: {shortened(reason)}") from error
    except RecursionError as error:
        raise InvalidInput(f"{path}: not read: its lists and tables lie in each other hundreds deep") from error
    except ValueError as error:
        raise InvalidInput(f"{path}: not read: {shortened(str(error))}") from error
    return data, line_map(text)


def _check_keys(path: Path, text: str) -> None:
    """Raises InvalidInput for keys of more than MOST_PARTS, before they are read."""
    number = 1
    for piece in _BETWEEN.split(_TEXTS.sub(lambda found: '"' + "\n" * found[0].count("\n"), text)):
        if piece.count(".") >= MOST_PARTS:
            raise InvalidInput(f"{path}:{number}: a key has at most {MOST_PARTS} parts")
        number += piece == "\n"


def refused(
    path: Path,
    lines: Mapping[Place, int],
    error: ValidationError,
    what: str,
    fields: Fields,
    tags: Collection[str] = (),
) -> InvalidInput:
    """What pydantic found, in words: the first of it. `what` the file holds; `tags` of unions are not in the file."""
    # An unknown key first: most often it is a misspelling of the one that is missing.
    details = sorted(error.errors(include_url=False), key=lambda detail: detail["type"] != "extra_forbidden")
    more = f" (and {len(details) - 1} more)" if len(details) > 1 else ""
    return InvalidInput(_message(path, lines, details[0], what, fields, tags) + more)


_BOUNDS = {
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
}


def _message(
    path: Path, lines: Mapping[Place, int], detail: ErrorDetails, what: str, fields: Fields, tags: Collection[str]
) -> str:
    location = detail["loc"]
    shown = ".".join(str(part) for part in location if isinstance(part, str) and part not in tags) or what
    text = detail["msg"].removeprefix("Value error, ")
    if detail["type"] == "extra_forbidden":
        key = str(location[-1])
        text = f'unknown key "{shortened(key)}"{near_misses(key, fields(location[:-1]))}'
        shown = shown.rpartition(".")[0] or what
    elif detail["type"] == "union_tag_invalid":
        tag = str(detail.get("ctx", {}).get("tag"))
        expected = re.findall(r"'([^']*)'", str(detail.get("ctx", {}).get("expected_tags")))
        text = f'unknown type "{shortened(tag)}"{near_misses(tag, expected)}'
        location = (*location, "type")
    elif detail["type"] == "missing":
        text = f'the key "{location[-1]}" is missing'
    elif detail["type"] in _BOUNDS:
        words, bound = _BOUNDS[detail["type"]]
        text = f"must be {words} {detail['ctx'][bound]:g}, not {_value(detail['input'])}"
    elif "input" in detail and isinstance(detail["input"], str | int | float):
        text += f", not {_value(detail['input'])}"
    return f"{path}:{line_of(lines, location)}: {shortened(shown)}: {text}"


def _value(value: object) -> str:
    """As it is written, shortened."""
    if isinstance(value, str):
        return repr(shortened(value))
    # The digits of a large whole number are not made: that takes as long as their square.
    return f"{float(value):g}" if isinstance(value, int) and 64 < value.bit_length() < 1000 else _plain(value)


def _plain(value: object) -> str:
    large = isinstance(value, int) and value.bit_length() >= 1000
    return "a number of hundreds of digits" if large else repr(value)


def line_of(lines: Mapping[Place, int], location: Place) -> int:
    """The line of the deepest part of a location that the file has; tags of unions are not in the file."""
    found: Place = ()
    for part in location:
        if (*found, part) in lines:
            found = (*found, part)
    return lines.get(found, 1)


# --- lines of keys ----------------------------------------------------------------------------------------------------

_HEADER = re.compile(r"^\s*\[(\[)?\s*([^\[\]]+?)\s*\]\]?\s*(?:#.*)?$")
_PAIR = re.compile(r"^\s*((?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*'))*)\s*=")
_KEY_PART = re.compile(r"[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*'")
_TEXTS = re.compile(
    r"""\"\"\"(?:\\.|[^\\])*?(?:\"\"\"|\Z)|'{3}.*?(?:'{3}|\Z)|\"(?:\\.|[^\"\\\n])*+(?:\"|(?=\n)|\\?\Z)|"""
    r"'[^'\n]*+(?:'|(?=\n)|\Z)|#[^\n]*+",
    re.DOTALL,
)
_BETWEEN = re.compile(r"([\n=,\[\]{}])")
_STRINGS_AND_COMMENTS = re.compile(r"\"(?:\\.|[^\"\\])*\"|'[^']*'|#.*")


def line_map(text: str) -> dict[Place, int]:
    """The line of every table and key of a TOML file, from 1: ("surfaces", 3, "points") -> 41.

    tomllib keeps no positions. Keys within inline tables and values of many lines have the line of the key before
    their "=".
    """
    lines: dict[Place, int] = {}
    counts: dict[Place, int] = {}
    table: Place = ()
    depth = 0
    for number, line in enumerate(text.splitlines(), 1):
        if depth == 0:
            header, pair = _HEADER.match(line), _PAIR.match(line)
            if header:
                table = _table(_parts(header[2]), bool(header[1]), counts)
                for length in range(1, len(table) + 1):
                    lines.setdefault(table[:length], number)
                continue
            if pair:
                key = table
                for part in _parts(pair[1]):
                    key = (*key, part)
                    lines.setdefault(key, number)
        bare = _STRINGS_AND_COMMENTS.sub("", line)
        depth += sum(bare.count(opening) for opening in "[{") - sum(bare.count(closing) for closing in "]}")
        depth = max(depth, 0)
    return lines


def _parts(key: str) -> list[str]:
    return [part.strip("\"'") for part in _KEY_PART.findall(key)]


def _table(parts: list[str], is_array: bool, counts: dict[Place, int]) -> Place:
    """The path of a table from its header: the last element of each array of tables on the way."""
    path: Place = ()
    for position, part in enumerate(parts):
        path = (*path, part)
        if is_array and position == len(parts) - 1:
            counts[path] = counts.get(path, -1) + 1
        if path in counts:
            path = (*path, counts[path])
    return path
