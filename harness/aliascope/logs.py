"""What happens in a run, a line each: JSON in the folder of its results, and on standard error as far as is asked for.

Everything goes through the logger "aliascope" of Python's logging, so that a program that uses this package hears it
with handlers of its own. Worker processes write nothing: what is logged there comes back with the task's result, and
the process that gave the task writes it down, a line at a time and each in one write.
"""

from __future__ import annotations

import json
import logging
import logging.handlers
import os
import socket
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from io import TextIOWrapper
from pathlib import Path
from typing import Any

from aliascope import places, sharing
from aliascope.errors import AliascopeError

LOGGER = logging.getLogger("aliascope")
LOGGER.addHandler(logging.NullHandler())

FILE = "log.jsonl"
LARGEST = 32 << 20
"""Bytes of a log; then it becomes log.jsonl.1, in place of an earlier one, and another is begun. A job takes 400."""
LONGEST_TEXT = 2000
"""Characters of one text in a line."""
MOST_COMMANDS, MOST_WARNINGS = 4, 10
"""Of one task that are told."""
_HELD = 200
"""Lines that wait for the folder to be made."""
_BUFFER = 1 << 20
"""Bytes: a line is in it whole, and leaves it in one write."""

About = Mapping[str, object]
"""What a task is about: scene, renderer, mode, seed and the like."""


def event(level: int, name: str, text: str = "", /, **fields: object) -> None:
    """Logs what happened: a name for machines, a text for people, and fields, JSON's types alone."""
    LOGGER.log(level, text or name, extra={"event": name, "fields": fields, "monotonic": time.monotonic()})


def warn(text: str) -> None:
    """Logs what a user has to know."""
    event(logging.WARNING, "warning", text)


# --- where a task runs ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Place:
    """Where and when a task ran: UTC, the monotonic clock of that machine in seconds, and seconds on the wall. worker:
    the address of a cluster's worker whose process it was, if it was one's."""

    host: str
    process: int
    began: str
    began_monotonic: float
    seconds: float
    worker: str = ""

    def told(self) -> dict[str, object]:
        """For a line of the log."""
        return {name: value for name, value in vars(self).items() if value != ""}


@dataclass(frozen=True)
class Answer:
    """What a task sends back: its result or its error, where it ran, and what was logged there."""

    result: Any
    error: AliascopeError | None
    place: Place
    records: tuple[tuple[str, str], ...] = ()
    """The names and texts of events."""
    counts: Mapping[str, int] = field(default_factory=dict)
    """How many events of each name there were."""


class _Gathered(logging.Handler):
    """Keeps the first few records of each name, and counts all."""

    def __init__(self) -> None:
        super().__init__(logging.DEBUG)
        self.records: list[tuple[str, str]] = []
        self.counts: dict[str, int] = {}

    def emit(self, record: logging.LogRecord) -> None:
        name = getattr(record, "event", "warning")
        self.counts[name] = self.counts.get(name, 0) + 1
        if self.counts[name] <= (MOST_COMMANDS if name == "command" else MOST_WARNINGS):
            self.records.append((name, record.getMessage()[:LONGEST_TEXT]))


def there(task: Callable[..., Any], *arguments: Any) -> Answer:
    """Does a task in a worker process. An error of ours comes back with the rest; any other is raised."""
    gathered = _Gathered()
    level, began, begun = LOGGER.level, _now(), time.monotonic()
    LOGGER.addHandler(gathered)
    LOGGER.setLevel(logging.DEBUG)
    result, error = None, None
    try:
        result = task(*arguments)
    except AliascopeError as problem:
        error = problem
    finally:
        LOGGER.removeHandler(gathered)
        LOGGER.setLevel(level)
    place = Place(socket.gethostname(), os.getpid(), began, round(begun, 6), round(time.monotonic() - begun, 6))
    return Answer(result, error, place, tuple(gathered.records), gathered.counts)


def ended(about: About, answer: Answer | None, error: BaseException | None) -> None:
    """Logs that a task has ended: with an answer, or without one by the error of its process."""
    problem = error if answer is None else answer.error
    fields: dict[str, object] = {**about, "status": "done" if problem is None else "failed"}
    text = " ".join(_worded(name, each) for name, each in about.items() if name != "key")
    if answer is not None:
        fields |= answer.place.told()
        text += f": {answer.place.seconds:.2f} s, process {answer.place.process}"
        text += f" of {answer.place.worker} on {answer.place.host}" if answer.place.worker else ""
    if problem is not None:
        fields |= {"why": str(problem) or type(problem).__name__, "kind": type(problem).__name__}
        text += f": {fields['why']}"
    if answer is not None and answer.records:
        texts = {name: [text for each, text in answer.records if each == name] for name, _ in answer.records}
        fields |= {"log": texts, "counts": dict(answer.counts)}
        text += "".join(f"\n  {each}" for each in texts.get("command", ()))
    event(logging.INFO, "job", f"{fields['status']} {text}", **fields)


def _worded(name: str, value: object) -> str:
    """A field for people: what is a number says of what."""
    if isinstance(value, str):
        return value
    return f"{name} " + (",".join(map(str, value)) if isinstance(value, list | tuple) else str(value))


# --- the file ---------------------------------------------------------------------------------------------------------


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _plain(value: object) -> object:
    """As JSON has it, and as others may read it."""
    if isinstance(value, str):
        return sharing.shared(value[: 10 * LONGEST_TEXT])[:LONGEST_TEXT]
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, float):
        return value if abs(value) < float("inf") else str(value)
    return _plain(str(value))


class _Lines(logging.Formatter):
    """A record as a line of JSON, with the run that it belongs to."""

    def __init__(self, run: str) -> None:
        super().__init__()
        self._run = run

    def format(self, record: logging.LogRecord) -> str:
        name = getattr(record, "event", "message")
        fields = getattr(record, "fields", {})
        text = record.getMessage()
        line = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "monotonic": round(getattr(record, "monotonic", time.monotonic()), 6),
            "run": self._run,
            "level": record.levelname.lower(),
            "event": name,
            **({} if name in ("job", text) else {"text": _plain(text)}),
            **{key: _plain(each) for key, each in fields.items()},
        }
        if record.exc_info:
            line["trace"] = _plain(self.formatException(record.exc_info))
        return json.dumps(line, allow_nan=False)


class _File(logging.handlers.RotatingFileHandler):
    """The log of a folder, once that is there. A log that cannot be written is said once, and stops no run."""

    def __init__(self, folder: Path, run: str) -> None:
        super().__init__(folder / FILE, maxBytes=LARGEST, backupCount=1, encoding="utf-8", delay=True)
        self._folder = folder
        self._waiting: list[logging.LogRecord] = []
        self.setFormatter(_Lines(run))

    def _open(self) -> TextIOWrapper:
        path = Path(self.baseFilename)
        opened = path.open("a", buffering=_BUFFER, encoding="utf-8")
        with suppress(OSError):
            if _torn(path):  # by a loss of power, or a disk that was full
                opened.write("\n")
        return opened

    def emit(self, record: logging.LogRecord) -> None:
        if self.stream is None and not self._folder.is_dir():
            self._waiting = [*self._waiting, record][:_HELD]
            return
        waiting, self._waiting = self._waiting, []
        for each in (*waiting, record):
            super().emit(each)

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802  (logging's name)
        problem = sys.exc_info()[1]
        LOGGER.removeHandler(self)
        with suppress(OSError, ValueError):  # what is in its buffer cannot be written either
            self.close()
        # A folder that takes no files at all is told by the command itself.
        if self._folder.is_dir() and os.access(self._folder, os.W_OK):
            why = getattr(problem, "strerror", None) or problem
            warn(f"{self.baseFilename}: cannot be written: {why}; the run goes on without a log")


def _torn(path: Path) -> bool:
    """Whether the last line of a file has no end."""
    with path.open("rb") as file:
        if file.seek(0, os.SEEK_END) == 0:
            return False
        file.seek(-1, os.SEEK_END)
        return file.read(1) != b"\n"


# --- standard error ---------------------------------------------------------------------------------------------------


class _StandardError(logging.Handler):
    """Says on standard error, as it is at the time, what is important enough."""

    def emit(self, record: logging.LogRecord) -> None:
        if getattr(record, "event", "") not in ("run", "end"):
            print(sharing.masked(record.getMessage()), file=sys.stderr)


_told = _StandardError(logging.WARNING)


def tell(verbose: bool = False, quiet: bool = False) -> None:
    """What standard error is told from now on: warnings; with `verbose` all that happens; with `quiet` errors alone."""
    _told.setLevel(logging.DEBUG if verbose else logging.ERROR if quiet else logging.WARNING)
    if _told not in LOGGER.handlers:
        LOGGER.addHandler(_told)
    LOGGER.setLevel(logging.DEBUG if verbose else logging.INFO)


def is_quiet() -> bool:
    """Whether nothing but errors is told."""
    return _told.level == logging.ERROR


def has_room_for_progress() -> bool:
    """Whether a bar may be drawn on standard error: between lines it would be in their way, and quiet is quiet."""
    return _told.level == logging.WARNING


# --- a run ------------------------------------------------------------------------------------------------------------

_file: _File | None = None


def begin(folder: Path | None, command: str, **fields: object) -> None:
    """Begins the log of a run in the folder of its results, which others may make later; None: there is none."""
    global _file
    end(None)
    if folder is None:
        return
    began = datetime.now(UTC)
    _file = _File(folder.absolute(), f"{began:%Y%m%dT%H%M%S}-{os.getpid()}")
    LOGGER.addHandler(_file)
    if LOGGER.getEffectiveLevel() > logging.INFO:
        LOGGER.setLevel(logging.INFO)
    about = {"version": places.own_version(), "revision": places.revision(), "machine": places.machine()}
    where = {"host": socket.gethostname(), "process": os.getpid(), "python": sys.version.partition(" ")[0]}
    event(logging.INFO, "run", "", command=command, **about, **where, **fields)


def end(code: int | None, why: str = "") -> None:
    """Ends the log of a run with the command's exit code. Without one the log of a run before is closed."""
    global _file
    if _file is None:
        return
    if code is not None:
        event(logging.INFO, "end", status=code, **({"why": why} if why else {}))
    LOGGER.removeHandler(_file)
    with suppress(OSError, ValueError):
        _file.close()
    _file = None


@contextmanager
def run(folder: Path | None, command: str, **fields: object) -> Iterator[None]:
    """The log of a run, for programs that use this package."""
    begin(folder, command, **fields)
    try:
        yield
    except BaseException as problem:
        end(getattr(problem, "exit_code", 1), str(problem) or type(problem).__name__)
        raise
    end(0)
