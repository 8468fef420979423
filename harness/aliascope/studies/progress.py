"""The progress bar, on standard error where that is a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from aliascope import logs
from aliascope.records import Job


@contextmanager
def progress_bar() -> Iterator[Callable[[Job | str | None, int, int], None]]:
    """Yields the function to tell what begins, and how many of how many are done. Silent where nobody watches."""
    console = Console(stderr=True)
    columns = (
        BarColumn(bar_width=24),
        MofNCompleteColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("{task.description}", markup=False),
    )
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal or not logs.has_room_for_progress()
    ) as bar:
        task = bar.add_task("", total=None)

        def tell(what: Job | str | None, done: int, total: int) -> None:
            text = f"{what.scene}  {what.renderer}  {what.mode}" if isinstance(what, Job) else what or ""
            if done == 0:  # other work than before, at another pace
                bar.reset(task)
            bar.update(task, completed=done, total=total, description=text)

        yield tell
