"""Loading the libraries when they are first used, and turning their statuses into exceptions."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable, Iterator
from typing import Any

from aliascope import places
from aliascope.errors import (
    AliascopeError,
    InvalidInput,
    JobFailed,
    NotAvailable,
    NotFinite,
    SpecError,
    Unsupported,
    one_line,
)
from aliascope.native import alone

_EXCEPTIONS: dict[str, type[AliascopeError]] = {
    "INVALID_ARGUMENT": InvalidInput,
    "UNKNOWN_NAME": SpecError,
    "UNKNOWN_KEY": SpecError,
    "INVALID_VALUE": SpecError,
    "UNSUPPORTED": Unsupported,
    "UNAVAILABLE": NotAvailable,
    "PLUGIN": InvalidInput,
    "NUMERIC": NotFinite,
}


plugin_endings: list[Callable[[], Iterator[str]]] = []
"""Who knows how processes of plugins have ended."""


@functools.cache
def module(name: str, needs: str) -> Any:
    """The compiled module `_sampler`, `_tracer` or `_raster`. Raises NotAvailable, naming what it `needs`, also where
    that crashes a process which tries it."""
    if name != "_sampler":
        _tried(name, needs)
    try:
        return importlib.import_module(f"aliascope.native.{name}")
    except ImportError as error:
        raise _absent(needs, str(error)) from error


def said(name: str, needs: str) -> str | None:
    """What the library that `_tracer` or `_raster` needs says of itself, without being loaded here; None where it has
    to be. Raises NotAvailable."""
    trial = _tried(name, needs)
    if trial is not None and trial.declines:
        raise NotAvailable(trial.declines)
    return None if trial is None else trial.said


def _tried(name: str, needs: str) -> alone.Trial | None:
    trial = alone.tried(name)
    if trial is not None and trial.absent:
        raise _absent(needs, trial.absent)
    return trial


def _absent(needs: str, reason: str) -> NotAvailable:
    remedy = "install it" if places.INSTALLED else "install it and run make"
    return NotAvailable(f"{needs} cannot be loaded ({reason}); {remedy}")


def error_box(ffi: Any) -> Any:
    """An asc_error to hand to a call."""
    return ffi.new("asc_error *")


def check(compiled: Any, status: int, box: Any = None) -> None:
    """Raises the exception of a status, with the message in `box` where the call left one; ASC_OK passes."""
    if status == compiled.lib.ASC_OK:
        return
    text = compiled.ffi.string(box.text).decode(errors="replace") if box is not None else ""
    name = str(compiled.ffi.typeof("asc_status").elements.get(status, "")).removeprefix("ASC_")
    said = text or compiled.ffi.string(compiled.lib.asc_status_text(status)).decode()
    if name == "ENDED":
        said = ": ".join([said, *(how for ask in plugin_endings for how in ask())])
    raise _EXCEPTIONS.get(name, JobFailed)(said)


def text(compiled: Any, pointer: Any) -> str:
    """A string of the library's, which may be a plugin's."""
    return one_line(str(compiled.ffi.string(pointer).decode(errors="replace")))


def keys(compiled: Any, info: Any) -> tuple[str, ...]:
    """The keys of a spec, as lists show them: "key=values: help (default value)"."""

    def key(entry: Any) -> str:
        values = text(compiled, entry.choices) if entry.choices else f"{entry.minimum:g}..{entry.maximum:g}"
        fallback = _fallback(compiled, entry)
        return f"{text(compiled, entry.name)}={values}: {text(compiled, entry.text)} (default {fallback})"

    return tuple(key(info.parameters[number]) for number in range(info.parameter_count))


def settings(compiled: Any, kind: str, spec: str) -> dict[str, str]:
    """All keys of a canonical spec of a "sampler", "filter" or "estimator" with their values, those left out too."""
    name, _, tail = spec.partition(":")
    given = dict(item.split("=", 1) for item in tail.split(",") if item)
    for index in range(getattr(compiled.lib, f"asc_{kind}_count")()):
        info = compiled.ffi.new(f"asc_{kind}_info *")
        check(compiled, getattr(compiled.lib, f"asc_{kind}_describe")(index, info))
        if text(compiled, info.name) == name:
            entries = (info.parameters[number] for number in range(info.parameter_count))
            return {text(compiled, entry.name): _fallback(compiled, entry) for entry in entries} | given
    return given


def _fallback(compiled: Any, entry: Any) -> str:
    """The default of a key, as a spec states it."""
    return text(compiled, entry.choices).split("|")[int(entry.fallback)] if entry.choices else f"{entry.fallback:g}"
