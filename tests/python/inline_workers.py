"""Workers without processes: what a test replaces is replaced for them too."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any


@dataclasses.dataclass(frozen=True)
class Now:
    """A task that is done when it is asked for."""

    result: Callable[[], Any]


class Inline:
    """Workers that work here and now."""

    def __init__(self, processes: int) -> None:
        pass

    def __enter__(self) -> Inline:
        return self

    def __exit__(self, *of: object) -> None:
        pass

    def begin(self, task: Callable[..., Any], arguments: Sequence[Any], time_limit: float, about: object = None) -> Now:
        return Now(lambda: task(*arguments))
