"""Refusals that say what is wrong: values that are no numbers, and whether the message names the one that is.

The sampler `not-finite` is loaded by a child of its own, as it stays loaded in a process, whose lists of samplers have
it from then on.
"""

from __future__ import annotations

import functools
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from aliascope.errors import AliascopeError, NotAvailable, Unsupported
from aliascope.stability.records import Kind, Probe

PLUGIN = Path(__file__).parents[1] / "native" / "not_finite.so"
"""What `make` builds of csrc/plugins/not_finite.c."""

SECONDS = 300.0
"""After which a child hangs."""

VALUES: Mapping[str, float] = {"nan": float("nan"), "inf": float("inf")}


class NotNamed(Exception):
    """A message that does not say which value is none."""


def refused(act: Callable[[], object], names: str) -> str:
    """The message with which `act` is refused. Raises NotNamed where the pattern `names` is not in it, and where there
    is no refusal."""
    try:
        given = act()
    except NotAvailable:
        raise
    except AliascopeError as refusal:
        return checked(str(refusal), names)
    raise NotNamed(f"not refused: {given!r:.80}")


def checked(message: str, names: str) -> str:
    if re.search(names, message):
        return message
    raise NotNamed(f"the message does not name it (no /{names}/): {message}")


def naming(acts: Callable[[float], Sequence[tuple[Callable[[], object], str]]], at: float) -> float:
    """All of them are refused, and all messages name what they should: refused with the first message. Raises NotNamed
    otherwise."""
    messages = [refused(act, names) for act, names in acts(at)]
    raise Unsupported(messages[0])


def probe(
    component: str,
    kind: Kind,
    names: str,
    acts: Callable[[float], Sequence[tuple[Callable[[], object], str]]],
    levels: tuple[float, ...] = (1.0, 100.0),
    quick: tuple[float, ...] = (1.0,),
) -> Probe:
    """A cell that counts only where the messages name `names`. acts: at a level, what is tried, with what has to be in
    its message."""
    against = f"an error that names {names}"
    measure = functools.partial(naming, acts)
    return Probe(
        component, kind, "not-finite", "none", against, 2.0**-53, 0.0, levels, measure, quick, refuses_from=levels[0]
    )


# --- a sampler that is a plugin ---------------------------------------------------------------------------------------


def told_by_plugin(component: str, at: float) -> float:
    """As `naming`, of what takes samples from the plugin, NaN and infinite ones. Raises NotAvailable where the plugin
    is not built."""
    if not PLUGIN.is_file():
        raise NotAvailable(f"{PLUGIN.name}, a sampler whose numbers are none, is not built: run make")
    messages = _children(at)[component]
    for message, names in messages:
        checked(message, names)
    raise Unsupported(messages[0][0])


@functools.cache
def _children(at: float) -> Mapping[str, list[tuple[str, str]]]:
    """By component, messages and what has to be in them, of all at once: a child takes longer to start than they."""
    command = [sys.executable, "-m", "aliascope.stability.plugged", str(PLUGIN), str(round(at))]
    paths = [str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    child = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False, env=environment)
    if child.returncode:
        raise RuntimeError(f"the process with the plugin ended with {child.returncode}: {child.stderr[-300:]}")
    found = json.loads(child.stdout)
    return {name: [(message, names) for message, names in each] for name, each in found.items()}
