"""Whether a file is a plugin, and whether its table is whole: the first check, before the library has it."""

from __future__ import annotations

import ctypes
import math
import os
import re
from typing import Any

from aliascope.errors import InvalidInput
from aliascope.native.probing import Probe, library
from aliascope.native.samplers import load_plugin
from aliascope.studies.plugin_subject import Broken, Finding

ENTRY = "asc_plugin_interface"
KEBAB = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
NEEDED = ("name", "title", "source", "create", "destroy", "fill")


class NoPlugin(Exception):
    """A file, or a spec, that there is nothing to check of: why, in one line."""


def table(path: str, spec: str | None) -> tuple[Finding, str]:
    """Loads the plugin; returns also the spec to check. Raises NoPlugin, Broken."""
    compiled = library()
    entry = _entry(path)
    interface_id, abi = _text(compiled.lib.ASC_SAMPLER_INTERFACE_ID), int(compiled.lib.ASC_ABI_VERSION)
    address = entry(abi, interface_id.encode())
    if not address:
        raise NoPlugin(f'has no "{interface_id}" for ABI version {abi}: build it against this version\'s headers')
    if entry(abi, b"asc.nothing/1"):
        raise Broken(f'{ENTRY} gives a table for the unknown id "asc.nothing/1"; give NULL')
    if entry(2**32 - 1, interface_id.encode()):
        raise Broken(f"{ENTRY} gives a table for the unknown ABI version {2**32 - 1}; give NULL")
    found = compiled.ffi.cast("asc_sampler_interface *", address)
    _check_fields(found)
    for index in range(found.parameter_count):
        _check_parameter(found.parameters[index], index)
    load(path)
    name = _text(found.name)
    wanted = spec or name
    _check_spec(wanted, name)
    return Finding(f'"{name}": {_text(found.title)} ({_text(found.source)})'), wanted


def _entry(path: str) -> Any:
    try:
        loaded = ctypes.CDLL(path, mode=os.RTLD_NOW | os.RTLD_LOCAL)
        entry = getattr(loaded, ENTRY)
    except AttributeError:
        raise NoPlugin(f"exports no {ENTRY}: it is no plugin") from None
    except OSError as error:
        raise NoPlugin(f"cannot be loaded: {str(error).removeprefix(f'{path}: ')}") from None
    entry.restype, entry.argtypes = ctypes.c_void_p, [ctypes.c_uint32, ctypes.c_char_p]
    return entry


def _text(pointer: Any) -> str:
    given = pointer if isinstance(pointer, bytes) else library().ffi.string(pointer)
    try:
        return str(given.decode())
    except UnicodeDecodeError:
        raise Broken(f"a text of the table is not UTF-8: {given!r}") from None


def _check_fields(found: Any) -> None:
    whole = library().ffi.sizeof("asc_sampler_interface")
    if found.struct_size < whole:
        raise Broken(f"struct_size is {found.struct_size}; say sizeof(asc_sampler_interface), which is {whole}")
    for field in NEEDED:
        if not getattr(found, field):
            raise Broken(f"the table has no `{field}`")
    if not KEBAB.fullmatch(_text(found.name)):
        raise Broken(f'the name "{_text(found.name)}" is not kebab-case: small letters, digits, single hyphens')
    for field in ("title", "source"):
        if not _text(getattr(found, field)).strip():
            raise Broken(f"the table's `{field}` is empty")
    if found.parameter_count and not found.parameters:
        raise Broken(f"parameter_count is {found.parameter_count}, and `parameters` is NULL")


def _check_parameter(parameter: Any, index: int) -> None:
    lib = library().lib
    if not parameter.name or not parameter.text:
        raise Broken(f"parameter {index} has no `{'text' if parameter.name else 'name'}`")
    name = _text(parameter.name)
    if not KEBAB.fullmatch(name):
        raise Broken(f'the name of parameter "{name}" is not kebab-case')
    if parameter.kind == lib.ASC_CHOICE:
        words = _text(parameter.choices).split("|") if parameter.choices else []
        if not all(words) or not words:
            raise Broken(f'parameter "{name}" is an ASC_CHOICE without its `choices`, such as "none|owen"')
        if not (0 <= parameter.fallback < len(words) and parameter.fallback == int(parameter.fallback)):
            raise Broken(f'parameter "{name}": the fallback {parameter.fallback:g} is no index of {len(words)} choices')
        return
    bounds = (parameter.minimum, parameter.fallback, parameter.maximum)
    if parameter.kind not in (lib.ASC_INTEGER, lib.ASC_REAL):
        raise Broken(f'parameter "{name}" is of the unknown kind {parameter.kind}')
    if not all(map(math.isfinite, bounds)) or not bounds[0] <= bounds[1] <= bounds[2]:
        raise Broken(
            f'parameter "{name}": not minimum <= fallback <= maximum, but {bounds[0]:g}, {bounds[1]:g}, {bounds[2]:g}'
        )


def load(path: str) -> None:
    """By the library, which has its own opinion: about names that are taken, for one. Raises Broken."""
    try:
        load_plugin(path, trusted=True)
    except InvalidInput as error:
        raise Broken(str(error).removeprefix(f"{path}: ")) from None


def _check_spec(spec: str, name: str) -> None:
    if spec.partition(":")[0] != name:
        raise NoPlugin(f'has the sampler "{name}"; the spec "{spec}" is of another')
    probe = Probe(spec, 1, 2)
    if probe.status in ("ASC_UNKNOWN_NAME", "ASC_UNKNOWN_KEY", "ASC_INVALID_VALUE"):
        raise NoPlugin(probe.message)
