"""References that are converged beside a command: in a process of their own, and with what is told meanwhile."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from aliascope.errors import JobFailed
from aliascope.records import Pixels
from aliascope.references.converged import Apart
from aliascope.workers import Workers


@contextmanager
def apart() -> Iterator[Apart]:
    """Has what converges drawn by a process that begins with the first picture: where Embree crashes, it raises
    JobFailed."""
    with Workers(1, plugins=()) as workers:

        def draw(task: Callable[..., Pixels], arguments: Sequence[Any]) -> Pixels:
            try:
                answer = workers.begin(task, arguments, math.inf).answer()
            except JobFailed as error:
                raise JobFailed(f"the reference cannot be made: {error}") from error
            if answer.error is not None:
                raise answer.error
            pixels: Pixels = answer.result
            return pixels

        yield draw


def converging(what: str, tell: Callable[[str, int, int], None]) -> Callable[[int, int, float | None], None]:
    """What a reference that is converged is to tell: how far its pictures, and the standard error of their mean, have
    come, and what it comes to with all of them, as it falls with the root of their number."""

    def told(done: int, total: int, standard_error: float | None) -> None:
        text = ""
        if standard_error is not None:
            end = standard_error * math.sqrt(done / total)
            text = f": standard error {standard_error:.1e}, {end:.1e} at the end"
        tell(what + text, done, total)

    return told
