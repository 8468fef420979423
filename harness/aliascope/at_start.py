"""What worker processes do before their first task, so that they know what their parent was told."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Step = tuple[Callable[..., object], tuple[Any, ...]]

_STEPS: dict[str, Step] = {}


def add(name: str, function: Callable[..., object], *arguments: Any) -> None:
    """Has workers that start from now on call a function of a module; a name that was used stands for the last."""
    _STEPS[name] = (function, arguments)


def steps() -> list[Step]:
    """All of them, in the order in which they came."""
    return list(_STEPS.values())
