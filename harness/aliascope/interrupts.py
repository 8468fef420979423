"""Ctrl-C: pressed once, a run comes to an end with what there is; pressed twice, it ends at once."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Iterator
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
        self._hook = sys.unraisablehook

    def __enter__(self) -> Interrupts:
        main = threading.current_thread() is threading.main_thread()
        self._there = main and signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if self._there:
            signal.signal(signal.SIGINT, self._heard)
            self._hook, sys.unraisablehook = sys.unraisablehook, self._unraisable
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._there:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            sys.unraisablehook = self._hook

    def hold(self) -> None:
        """What is done from here on is done to its end: Ctrl-C is counted, and raises nothing."""
        self._held = True

    def check(self) -> None:
        """Raises KeyboardInterrupt where one was raised in a place that had to lose it, such as a finaliser."""
        if self.pressed and not self._held:
            raise KeyboardInterrupt

    def _unraisable(self, lost: sys.UnraisableHookArgs) -> None:
        """Tells what a finaliser could not raise, but for Ctrl-C, which `check` raises later."""
        if not isinstance(lost.exc_value, KeyboardInterrupt):
            self._hook(lost)

    def _heard(self, number: int, frame: FrameType | None) -> None:
        self.pressed += 1
        if self.pressed > 1:
            cursor = b"\x1b[?25h" if sys.stderr.isatty() else b""  # which a progress bar hides
            told = b"ended at once; what was finished is kept, and the same command goes on from there"
            os.write(2, cursor + b"aliascope: interrupted twice: " + told + b"\n")
            os._exit(ENDED)
        self.check()


@contextlib.contextmanager
def deferred() -> Iterator[None]:
    """Ctrl-C is heard when this is left, for what must not be done by halves. Processes and threads that begin in it
    do not hear of Ctrl-C; to block the signal is for them, and not enough for this thread: Python handles in its main
    thread what any thread of a library was given."""
    handler = signal.getsignal(signal.SIGINT)
    pressed: list[FrameType | None] = []
    here = callable(handler) and threading.current_thread() is threading.main_thread()
    if here:
        signal.signal(signal.SIGINT, lambda _, frame: pressed.append(frame))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if here:
            signal.signal(signal.SIGINT, handler)
    if callable(handler):
        for frame in pressed:
            handler(signal.SIGINT, frame)
