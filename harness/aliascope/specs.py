"""Specs: `name` or `name:key=value,key=value`; inside, the keys of an inner spec are dotted.

A `Form` states which keys a name takes; `parse` checks a text against the forms and gives its one canonical form (keys
sorted, defaults left out). Samplers are parsed by the library's own registry.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from aliascope.errors import SpecError, near_misses

Value = int | float | str

LONGEST = 4096
"""Characters of a spec."""


@dataclass(frozen=True)
class Key:
    """One key of a form. kind "spec": the value is the canonical text of an inner spec, made by `inner`."""

    name: str
    kind: Literal["integer", "real", "choice", "spec"]
    default: Value
    text: str
    minimum: float = -math.inf
    maximum: float = math.inf
    choices: tuple[str, ...] = ()
    inner: Callable[[str], str] | None = None
    inner_settings: Callable[[str], Mapping[str, str]] | None = None
    """All keys of an inner spec with their values."""
    named: bool = False
    """The inner spec is part of a mode's name for people, also where it is the default."""
    is_count: bool = False
    """Modes that differ in this key alone are one family: a line in a plot of error against cost."""


@dataclass(frozen=True)
class Form:
    """What a spec of this name may say."""

    name: str
    text: str
    keys: tuple[Key, ...] = ()


@dataclass(frozen=True)
class Spec:
    """A parsed spec: every key has its value, `text` is the canonical form."""

    name: str
    values: Mapping[str, Value]
    text: str
    form: Form

    def integer(self, key: str) -> int:
        return int(self.values[key])

    def real(self, key: str) -> float:
        return float(self.values[key])

    def word(self, key: str) -> str:
        return str(self.values[key])


def join(name: str, pairs: Mapping[str, str]) -> str:
    """The text of a spec from its name and the texts of its keys, sorted."""
    tail = ",".join(f"{key}={value}" for key, value in sorted(pairs.items()))
    return f"{name}:{tail}" if tail else name


def split(text: str) -> tuple[str, dict[str, str]]:
    """The name and the `key=value` pairs of a spec, as they are written."""
    if len(text) > LONGEST:
        raise SpecError(f"a spec has at most {LONGEST} characters, not {len(text)}")
    name, colon, tail = text.strip().partition(":")
    pairs: dict[str, str] = {}
    for item in tail.split(",") if colon else ():
        key, equals, value = item.partition("=")
        if not (key and equals and value):
            raise SpecError(f'spec "{text}": "{item}" is not of the form key=value')
        if key in pairs:
            raise SpecError(f'spec "{text}": the key "{key}" stands twice')
        pairs[key] = value
    if not name:
        raise SpecError(f'spec "{text}" has no name')
    return name, pairs


def parse(text: str, forms: Mapping[str, Form], what: str) -> Spec:
    """Checks `text` against the forms. `what` names the kind in errors: "mode of povray"."""
    name, pairs = split(text)
    if name not in forms:
        raise SpecError(f'unknown {what} "{name}"{near_misses(name, forms)}')
    form = forms[name]
    inner: dict[str, dict[str, str]] = {key.name: {} for key in form.keys if key.kind == "spec"}
    for key in list(pairs):
        outer, dot, rest = key.partition(".")
        if dot and outer in inner:
            inner[outer][rest] = pairs.pop(key)
    known = [key.name for key in form.keys]
    for key in pairs:
        if key not in known:
            raise SpecError(f'{what} "{name}": unknown key "{key}"{near_misses(key, known) or "; it has none"}')
    values: dict[str, Value] = {}
    shown: dict[str, str] = {}
    for entry in form.keys:
        if entry.kind == "spec":
            assert entry.inner is not None
            whole = entry.inner(join(pairs.get(entry.name, str(entry.default)), inner[entry.name]))
            values[entry.name] = whole
            if whole != entry.default:
                base, under = split(whole)
                shown[entry.name] = base
                shown.update({f"{entry.name}.{key}": value for key, value in under.items()})
        elif entry.name in pairs:
            values[entry.name] = _value(entry, pairs[entry.name], f'{what} "{name}"')
            if values[entry.name] != entry.default:
                shown[entry.name] = _shown(values[entry.name])
        else:
            values[entry.name] = entry.default
    return Spec(name, values, join(name, shown), form)


def spelled_out(spec: Spec) -> str:
    """The text of a spec with its defaults: all keys, sorted; inner specs in their canonical form."""
    pairs: dict[str, str] = {}
    for key in spec.form.keys:
        if key.kind == "spec":
            base, under = split(spec.word(key.name))
            pairs[key.name] = base
            pairs.update({f"{key.name}.{name}": value for name, value in under.items()})
        else:
            pairs[key.name] = _shown(spec.values[key.name])
    return join(spec.name, pairs)


def settings(spec: Spec) -> dict[str, str]:
    """All keys of a spec with their values, those left out too; of inner specs the name and, dotted, their keys."""
    found: dict[str, str] = {}
    for key in spec.form.keys:
        if key.kind == "spec":
            word = spec.word(key.name)
            base, under = split(word)
            found[key.name] = base
            whole = key.inner_settings(word) if key.inner_settings is not None else under
            found.update({f"{key.name}.{name}": value for name, value in whole.items()})
        else:
            found[key.name] = _shown(spec.values[key.name])
    return found


def family(spec: Spec) -> str:
    """The name of a family of modes: the mode without its count; specs that are `named` always, others where they are
    not the default."""
    words = [spec.name]
    for key in spec.form.keys:
        value = spec.values[key.name]
        if key.named:
            words.append(str(value))
        elif not key.is_count and value != key.default:
            words.append(f"{key.name}={_shown(value)}")
    return " ".join(words)


def label(spec: Spec) -> str:
    """A mode for people: its family and its count, also where they are the defaults: "uniform halton, n=16"."""
    counts = [f"{key.name}={_shown(spec.values[key.name])}" for key in spec.form.keys if key.is_count]
    return ", ".join([family(spec), *counts])


def _shown(value: Value) -> str:
    """The shortest text that reads back as the same value."""
    if isinstance(value, float):
        return f"{value:g}" if float(f"{value:g}") == value else repr(value)
    return str(value)


def _value(key: Key, text: str, where: str) -> Value:
    if key.kind == "choice":
        if text not in key.choices:
            raise SpecError(f'{where}: {key.name}="{text}" is none of {", ".join(key.choices)}')
        return text
    try:
        number: Value = int(text) if key.kind == "integer" else float(text)
        within = key.minimum <= float(number) <= key.maximum
    except OverflowError:  # a whole number larger than any double
        within = False
    except ValueError:
        raise SpecError(f'{where}: {key.name}="{text}" is not {_article(key.kind)} number') from None
    if not within:
        raise SpecError(f"{where}: {key.name}={text} lies outside [{key.minimum:g}, {key.maximum:g}]")
    return number


def _article(kind: str) -> str:
    return "a whole" if kind == "integer" else "a"
