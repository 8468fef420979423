"""Ctrl-C: pressed once, a run comes to an end with what there is; pressed twice, it ends at once."""

from __future__ import annotations

import os
import signal
import sys
import threading
from types import FrameType, TracebackType

ENDED = 130
"""The exit code of a program that was interrupted: 128 + SIGINT."""


class Interrupts:
    """While this is entered, the first Ctrl-C raises KeyboardInterrupt in the main thread, until `hold`; the second
    ends the process, and so its workers. Where Ctrl-C is not Python's to handle, as in a shell's background or in
    another thread, nothing changes. `pressed`: how often it was."""

    def __init__(self) -> None:
        self.pressed = 0
        self._held = self._there = False

    def __enter__(self) -> Interrupts:
        main = threading.current_thread() is threading.main_thread()
        self._there = main and signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if self._there:
            signal.signal(signal.SIGINT, self._heard)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._there:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def hold(self) -> None:
        """What is done from here on is done to its end: Ctrl-C is counted, and raises nothing."""
        self._held = True

    def check(self) -> None:
        """Raises KeyboardInterrupt where one was raised in a place that had to lose it, such as a finaliser."""
        if self.pressed and not self._held:
            raise KeyboardInterrupt

    def _heard(self, number: int, frame: FrameType | None) -> None:
        self.pressed += 1
        if self.pressed > 1:
            cursor = b"\x1b[?25h" if sys.stderr.isatty() else b""  # which a progress bar hides
            os.write(2, cursor + b"aliascope: interrupted twice: ended at once; what was finished is kept\n")
            os._exit(ENDED)
        self.check()
