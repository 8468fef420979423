"""The TOML file that makes another program a renderer: what it may say, and what is wrong with it, by file and line."""

from __future__ import annotations

import hashlib
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from aliascope import toml_files
from aliascope.errors import InvalidInput, SpecError, near_misses
from aliascope.renderers.external_scenes import FORMATS
from aliascope.specs import Form, Key, parse

PLACEHOLDER = re.compile(r"\{([a-z]+(?:\.[a-z0-9_-]+)?)\}")
KNOWN = (
    *FORMATS,
    *("width", "height", "samples", "seed", "threads", "out", "mode", "shift.x", "shift.y", "folder", "python"),
)
"""And {mode.KEY} for each key of a mode."""

Word = Annotated[str, Field(min_length=1, max_length=4096)]
Command = Annotated[tuple[Word, ...], Field(min_length=1, max_length=256)]


class Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Output(Part):
    """`values`: what the picture's numbers are."""

    format: Literal["exr", "png"]
    values: Literal["linear", "srgb"]


class Version(Part):
    command: Command
    pattern: Word


class KeyOf(Part):
    """A key of a mode. `count`: it says how many samples a pixel has."""

    type: Literal["integer", "real", "choice"]
    default: int | float | str
    text: str = ""
    minimum: float = float("-inf")
    maximum: float = float("inf")
    choices: tuple[Word, ...] = ()
    count: bool = False


class Mode(Part):
    """`command`: in place of the file's."""

    text: str = ""
    command: Command | None = None
    seeded: bool | None = None
    keys: dict[str, KeyOf] = {}


class Profiles(Part):
    quick: Annotated[tuple[Word, ...], Field(min_length=1)]
    full: tuple[Word, ...] = ()


class Contents(Part):
    """All that a file may say; see CONTRIBUTING.md."""

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]{0,39}$")]
    title: Word
    command: Command
    output: Output
    time: Word
    samples: Word | None = None
    seeded: bool
    draws: tuple[Word, ...] | None = None
    version: Version | None = None
    probe: Word | None = None
    single: Word | None = None
    modes: Annotated[dict[str, Mode], Field(min_length=1)]
    profiles: Profiles


@dataclass(frozen=True)
class File:
    """A file that holds together: its modes as forms, and the scene's formats that its commands name."""

    path: Path
    contents: Contents
    forms: Mapping[str, Form]
    formats: tuple[str, ...]
    sha256: str

    def command_of(self, mode: str) -> Command:
        return self.contents.modes[mode].command or self.contents.command

    def seeded(self, mode: str) -> bool:
        own = self.contents.modes[mode].seeded
        return self.contents.seeded if own is None else own


def read(path: Path) -> File:
    """The file of a renderer. Raises InvalidInput, with its line."""
    data, lines = toml_files.read(path, "renderer")
    try:
        contents = Contents.model_validate(data)
    except ValidationError as error:
        raise toml_files.refused(path, lines, error, "renderer", _fields_at) from error
    for place, text in _problems(contents):
        shown = ".".join(str(part) for part in place if isinstance(part, str))
        raise InvalidInput(f"{path}:{toml_files.line_of(lines, place)}: {shown}: {text}")
    forms = {name: _form(name, mode) for name, mode in contents.modes.items()}
    for place, text in _specs(contents):
        try:
            parse(text, forms, f"mode of {contents.name}")
        except SpecError as error:
            raise InvalidInput(f"{path}:{toml_files.line_of(lines, place)}: {place[-1]}: {error}") from error
    commands = [contents.command, *(mode.command for mode in contents.modes.values() if mode.command)]
    named = {name for command in commands for name in placeholders(command)}
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    return File(path, contents, forms, tuple(name for name in FORMATS if name in named), digest)


def placeholders(command: Sequence[str]) -> list[str]:
    """The names that stand in braces in a command."""
    return [name for word in command for name in PLACEHOLDER.findall(word)]


def _problems(contents: Contents) -> Iterator[tuple[toml_files.Place, str]]:
    """What the parts of a file say against each other."""
    patterns: tuple[tuple[toml_files.Place, str | None, tuple[str, ...]], ...] = (
        (("time",), contents.time if contents.time != "cpu" else None, ("s", "ms")),
        (("samples",), contents.samples, ("all", "pixel")),
        (("version", "pattern"), contents.version.pattern if contents.version else None, ()),
    )
    for place, pattern, groups in patterns:
        if pattern is not None and (problem := _regular(pattern, groups)):
            yield place, problem
    for name, mode in contents.modes.items():
        for key, entry in mode.keys.items():
            if problem := _key_problem(key, entry):
                yield ("modes", name, "keys", key), problem
        counts = [key for key, entry in mode.keys.items() if entry.count]
        if len(counts) > 1:
            yield ("modes", name), f"one key is the count of samples, not {' and '.join(counts)}"
        place = ("modes", name, "command") if mode.command else ("command",)
        used = placeholders(mode.command or contents.command)
        yield from ((place, text) for text in _placeholder_problems(name, mode, used))
        seeded = contents.seeded if mode.seeded is None else mode.seeded
        if seeded != ("seed" in used):
            yield (
                place,
                f"{name} is {'' if seeded else 'not '}seeded, and its command has {'no' if seeded else 'a'} {{seed}}",
            )


def _placeholder_problems(name: str, mode: Mode, used: Sequence[str]) -> Iterator[str]:
    known = [*KNOWN, *(f"mode.{key}" for key in mode.keys)]
    for each in used:
        if each not in known:
            yield f"unknown placeholder {{{each}}} for the mode {name}{near_misses(each, known)}"
    if "out" not in used:
        yield "{out} is missing: the file in which the program leaves its picture"
    if not set(used) & set(FORMATS):
        yield f"no scene is in it: {', '.join(f'{{{each}}}' for each in FORMATS)}"
    if ("shift.x" in used) != ("shift.y" in used):
        yield "{shift.x} and {shift.y} come together"
    has_count = any(entry.count for entry in mode.keys.values())
    if "samples" in used and not has_count:
        yield f"{{samples}} is the key that is the count, and the mode {name} has none"
    for key, entry in mode.keys.items():
        if f"mode.{key}" not in used and not (entry.count and "samples" in used):
            yield f"the key {key} of the mode {name} changes nothing: {{mode.{key}}} is not in it"


def _regular(pattern: str, groups: Sequence[str]) -> str | None:
    """What is wrong with a regular expression that has one of these groups, or any one where there are none."""
    try:
        with warnings.catch_warnings(action="error"):  # of what another Python takes otherwise
            found = re.compile(pattern)
    except Warning as warning:
        return f"is ambiguous: {warning}; escape what is meant as it is"
    except (re.error, OverflowError, RecursionError) as error:
        return f"is no regular expression: {error}"
    if groups and len(set(groups) & set(found.groupindex)) != 1:
        return "has one group of these: " + ", ".join(f"(?P<{group}>...)" for group in groups)
    return None if groups or found.groups == 1 else "has one group, which is the version"


def _key_problem(name: str, entry: KeyOf) -> str | None:
    if not re.fullmatch(r"[a-z][a-z0-9_-]*", name):
        return "a key is of small letters, digits, - and _"
    if (entry.type == "choice") != bool(entry.choices):
        return 'choices are for the type "choice", and it needs them'
    if entry.type == "choice":
        return None if entry.default in entry.choices else f"default {entry.default!r} is none of its choices"
    whole = isinstance(entry.default, int) and not isinstance(entry.default, bool)
    if not (whole or (entry.type == "real" and isinstance(entry.default, float))):
        return f"default {entry.default!r} is not of the type {entry.type}"
    if entry.count and (entry.type != "integer" or entry.minimum < 1):
        return "a count is an integer with a minimum of 1 or more"
    within = entry.minimum <= float(entry.default) <= entry.maximum
    return None if within else f"default {entry.default!r} lies outside [{entry.minimum:g}, {entry.maximum:g}]"


def _form(name: str, mode: Mode) -> Form:
    keys = tuple(
        Key(
            key,
            entry.type,
            float(entry.default) if entry.type == "real" else entry.default,
            entry.text,
            entry.minimum,
            entry.maximum,
            entry.choices,
            named=entry.type == "choice",
            is_count=entry.count,
        )
        for key, entry in mode.keys.items()
    )
    return Form(name, mode.text, keys)


def _specs(contents: Contents) -> Iterator[tuple[toml_files.Place, str]]:
    """The modes that the file names."""
    for key in ("probe", "single"):
        if (text := getattr(contents, key)) is not None:
            yield (key,), text
    for key in ("quick", "full"):
        yield from ((("profiles", key), text) for text in getattr(contents.profiles, key))


def _fields_at(location: toml_files.Place) -> list[str]:
    """The keys that may stand at a location."""
    kind: type[BaseModel] = Contents
    for part in location:
        field = kind.model_fields.get(str(part))
        if field is None:  # the name of a mode or key, as its table has any
            continue
        words = [field.annotation, *get_args(field.annotation)]
        words += [inner for word in words for inner in get_args(word)]
        kind = next((word for word in words if isinstance(word, type) and issubclass(word, BaseModel)), kind)
    return list(kind.model_fields)
