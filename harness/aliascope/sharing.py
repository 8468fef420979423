"""What may be read by others: text without the folder that is the user's home, and commands without what is secret.

Reports, tables, headers of pictures and logs are sent around. A path in them below the user's home begins with `~`, so
that it names nobody and a command with it still works on this machine; passwords and tokens are `***`.
"""

from __future__ import annotations

import dataclasses
import functools
import os
import re
import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

Record = TypeVar("Record")

MASK = "***"

_SECRET = r"[\w-]*(?:token|passw(?:or)?d|passphrase|secret|credential|(?:api|access|private|tls)[-_]?key)[\w-]*"
_MASKED = (
    # scheme://user:password@host: who it is goes as well.
    (re.compile(r"(?<=://)[^/\s@'\"]+@"), f"{MASK}@"),
    # name=value, "name": "value" and name: value, as in a query, a document or a header.
    (re.compile(rf"(?i)\b({_SECRET}[\"']?\s*[=:]\s*)(\"[^\"]*\"|'[^']*'|[^\s\"',;&#]+)"), rf"\g<1>{MASK}"),
    (re.compile(rf"(?i)(--{_SECRET}\s+)(\"[^\"]*\"|'[^']*'|[^\s\"',;]+)"), rf"\g<1>{MASK}"),
    (re.compile(r"(?i)\b((?:bearer|basic)\s+)[\w.~+/=-]{8,}"), rf"\g<1>{MASK}"),
    (re.compile(r"-----BEGIN [A-Z ]*PRIVATE KEY-----.*?(?:-----END [A-Z ]*PRIVATE KEY-----|$)", re.DOTALL), MASK),
)
_SECRET_OPTION = re.compile(rf"(?i)-{{1,2}}{_SECRET}")


def masked(text: str) -> str:
    """A text without passwords, tokens and keys, as far as their names or places give them away."""
    for pattern, instead in _MASKED:
        text = pattern.sub(instead, text)
    return text


def shared(text: str) -> str:
    """A text that others may read: `masked`, with the user's home as `~`."""
    found = _pattern(_homes())
    return masked(found.sub("~", text) if found is not None else text)


def command_line(words: Iterable[str]) -> str:
    """A command as it is pasted into a shell, and as others may read it: a home is left to the shell to fill in."""
    told: list[str] = []
    hidden = False
    for word in words:
        told.append(MASK if hidden else _word(masked(word)))
        hidden = _SECRET_OPTION.fullmatch(word) is not None
    return " ".join(told)


def shell_word(path: Path) -> str:
    """A path as one word of a command."""
    return _word(str(path))


def _word(word: str) -> str:
    """Quoted for the shell, but for the home: `~` where a word begins with it, else "$HOME"."""
    found = _pattern(_homes())
    at = found.search(word) if found is not None else None
    if at is None:
        return shlex.quote(word)
    before, after = word[: at.start()], word[at.end() :]
    if before:
        return shlex.quote(before) + '"$HOME"' + (_word(after) if after else "")
    # An unquoted slash ends what the shell takes for the name of a user.
    return "~" + ("/" + (_word(after[1:]) if after[1:] else "") if after else "")


def records_shared(value: Record) -> Record:
    """The same value, with every text in it `shared`: of records, mappings and sequences, in whatever depth."""
    return _walked(value)  # type: ignore[no-any-return]


def _walked(value: Any) -> Any:
    if isinstance(value, str):
        return shared(value)
    if isinstance(value, Mapping):
        return {_walked(key): _walked(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_walked(each) for each in value]
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        return tuple(_walked(each) for each in value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        changed = {
            each.name: new
            for each in dataclasses.fields(value)
            if each.init and (new := _walked(old := getattr(value, each.name))) is not old
        }
        return dataclasses.replace(value, **changed) if changed else value
    return value


def _homes() -> tuple[str, ...]:
    return _homes_of(os.environ.get("HOME"))


@functools.lru_cache(maxsize=8)
def _homes_of(stated: str | None) -> tuple[str, ...]:
    """The user's home, as it is stated and as it really lies, the longest first; none where that is the root."""
    try:
        home = Path(stated) if stated else Path.home()
    except RuntimeError:  # nobody knows this user
        return ()
    found = {os.path.normpath(home), os.path.realpath(home)} if home.is_absolute() else set()
    return tuple(sorted((each for each in found if each != "/"), key=len, reverse=True))


@functools.lru_cache(maxsize=8)
def _pattern(homes: tuple[str, ...]) -> re.Pattern[str] | None:
    """Where a home stands in a text: at the beginning of a path (after an option of a letter too, as in `+I/home/me`),
    and not as a part of a longer name."""
    if not homes:
        return None
    either = "|".join(map(re.escape, homes))
    return re.compile(rf"(?:(?<![\w.~-])|(?<=[-+]\w))(?:{either})(?![\w-]|\.\w)")
