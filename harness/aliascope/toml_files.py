"""TOML files that people write: read, and what is wrong with them said with file, line and key."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from aliascope.errors import InvalidInput, near_misses

LARGEST_FILE = 64 << 20

Place = tuple[str | int, ...]
"""Of a table or key in a file: ("surfaces", 3, "points")."""

Fields = Callable[[Place], Sequence[str]]
"""The keys that may stand at a place."""


def read(path: Path, what: str) -> tuple[dict[str, Any], dict[Place, int]]:
    """The contents of a file, and the line of each key. `what` it holds, for errors. Raises InvalidInput."""
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise InvalidInput(f"{path}: a {what} file has at most {LARGEST_FILE >> 20} MiB")
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InvalidInput(f"{path}: is not UTF-8 text") from error
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"\(at line (\d+), column \d+\)", str(error))
        line = place[1] if place else str(text.count("\n") + 1)
        reason = re.sub(r" \(at .*\)$", "", str(error))
        raise InvalidInput(f"{path}:{line}: not TOML: {reason}") from error
    return data, line_map(text)


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
        text = f'unknown key "{key}"{near_misses(key, fields(location[:-1]))}'
        shown = shown.rpartition(".")[0] or what
    elif detail["type"] == "union_tag_invalid":
        tag = str(detail.get("ctx", {}).get("tag"))
        expected = re.findall(r"'([^']*)'", str(detail.get("ctx", {}).get("expected_tags")))
        text = f'unknown type "{tag}"{near_misses(tag, expected)}'
        location = (*location, "type")
    elif detail["type"] == "missing":
        text = f'the key "{location[-1]}" is missing'
    elif detail["type"] in _BOUNDS:
        words, bound = _BOUNDS[detail["type"]]
        text = f"must be {words} {detail['ctx'][bound]:g}, not {detail['input']!r}"
    elif "input" in detail and isinstance(detail["input"], str | int | float):
        text += f", not {detail['input']!r}"
    return f"{path}:{line_of(lines, location)}: {shown}: {text}"


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
