"""The runs of `aliascope regress`, one after another, in one SQLite file: what `aliascope history` reads.

Processes may append at once: each run is one transaction, whole or not there.
"""

from __future__ import annotations

import hashlib
import json
import math
import sqlite3
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any, TypeVar

from aliascope.errors import InvalidInput, NotWritable
from aliascope.records import Estimate
from aliascope.regression.records import CellName, CellVerdict, Observed, Run
from aliascope.statistics import root_mean_square

SCHEMA_VERSION = 1
_APPLICATION = 0x61736368
"""SQLite's application_id of a history: "asch", so that another database is not taken for one."""
_PATIENCE = 30.0
"""Seconds to wait for others that write."""

_SCHEMA = (
    """
CREATE TABLE run (
  id INTEGER PRIMARY KEY,
  started TEXT NOT NULL,            -- UTC, ISO 8601
  wall_seconds REAL NOT NULL,
  revision TEXT NOT NULL,           -- of the source tree, "+" where it has changes
  machine TEXT NOT NULL,            -- JSON
  versions TEXT NOT NULL,           -- JSON
  command TEXT NOT NULL,
  passed INTEGER NOT NULL
)""",
    """
CREATE TABLE cell (
  run INTEGER NOT NULL REFERENCES run (id),
  scene TEXT NOT NULL, renderer TEXT NOT NULL, mode TEXT NOT NULL,
  passed INTEGER NOT NULL,
  problem TEXT NOT NULL,            -- why there are no figures; empty where there are
  subject TEXT NOT NULL,            -- hash of what was drawn and judged: scene, size, filter
  draws TEXT NOT NULL,              -- hash of the seeds and shifts
  pictures INTEGER NOT NULL,
  rmse REAL, rmse_standard_error REAL,
  rmse_of_each TEXT NOT NULL,       -- JSON, of each replicate that has one
  samples INTEGER,                  -- of all pictures
  rays TEXT NOT NULL,               -- JSON, by kind, of all pictures
  cpu_seconds REAL,                 -- the median over pictures
  cpu_seconds_of_each TEXT NOT NULL, -- JSON
  versions TEXT NOT NULL,           -- JSON, of what rendered it
  PRIMARY KEY (run, scene, renderer, mode)
)""",
)


@dataclass(frozen=True)
class KeptCell:
    """A cell of a run. `rmse`: the root of the mean square over replicates and its standard error, None for a single
    one; `rmse_of_each` and `cpu_seconds_of_each` replicate; `samples` and `rays`, by kind, of a picture, the mean over
    `pictures`. `subject` and `draws` are hashes: of scene, size and filter, and of seeds and shifts. A cell that had
    nothing to measure has a `problem`, and None."""

    name: CellName
    passed: bool
    problem: str = ""
    subject: str = ""
    draws: str = ""
    pictures: int = 0
    rmse: Estimate = field(default_factory=lambda: Estimate(None))
    rmse_of_each: tuple[float | None, ...] = ()
    samples: float | None = None
    rays: Mapping[str, float] = field(default_factory=dict)
    cpu_seconds: float | None = None
    cpu_seconds_of_each: tuple[float, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class KeptRun:
    """A run as it was kept."""

    started: str
    wall_seconds: float
    revision: str
    machine: Mapping[str, str]
    versions: Mapping[str, str]
    command: str
    passed: bool
    cells: tuple[KeptCell, ...]


def add(path: Path, run: Run) -> None:
    """Appends a run, all of it or, by an exception, nothing; makes file and folder where they are not there.

    Raises NotWritable; InvalidInput for a file that is no history, or a newer version's.
    """
    rows = [_row(cell) for cell in run.cells]
    own = (run.started, run.wall_seconds, run.revision, _json(run.machine), _json(run.versions), run.command)

    def append() -> None:
        with closing(_open(path)) as database:
            database.execute("BEGIN IMMEDIATE")
            try:
                _open_schema(database, path)
                columns = "started, wall_seconds, revision, machine, versions, command, passed"
                cursor = database.execute(
                    f"INSERT INTO run ({columns}) VALUES (?, ?, ?, ?, ?, ?, ?)", (*own, run.passed)
                )
                marks = ", ".join("?" * 17)
                database.executemany(f"INSERT INTO cell VALUES ({marks})", [(cursor.lastrowid, *row) for row in rows])
                database.execute("COMMIT")
            except BaseException:
                database.execute("ROLLBACK")
                raise

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _patiently(append)
    except (OSError, sqlite3.OperationalError) as error:
        raise NotWritable(f"{path}: cannot be written: {error}; choose another folder with -o") from error
    except sqlite3.IntegrityError:  # a cell twice in the run: the file is as it was
        raise
    except sqlite3.DatabaseError as error:
        raise _no_history(path, error) from error


def load(path: Path) -> tuple[KeptRun, ...]:
    """All runs, in the order in which they began. Raises InvalidInput for no file, no history, or a newer version's."""
    if not path.is_file():
        raise InvalidInput(f"{path}: there is no history; aliascope regress makes one")

    def read() -> tuple[KeptRun, ...]:
        with closing(_open_to_read(path)) as database:
            database.row_factory = sqlite3.Row
            database.execute("BEGIN")  # runs and cells of one moment
            if _is_empty(database):  # an append that came to nothing has made it
                return ()
            _check_version(database, path)
            cells: dict[int, list[KeptCell]] = {}
            for row in database.execute("SELECT * FROM cell ORDER BY run, rowid"):
                cells.setdefault(row["run"], []).append(_kept_cell(row))
            runs = database.execute("SELECT * FROM run ORDER BY started, id").fetchall()
            return tuple(_kept_run(row, tuple(cells.get(row["id"], ()))) for row in runs)

    try:
        return _patiently(read)
    except (sqlite3.DatabaseError, json.JSONDecodeError) as error:
        raise _no_history(path, error) from error


# --- the file ---------------------------------------------------------------------------------------------------------

_Result = TypeVar("_Result")


def _patiently(act: Callable[[], _Result]) -> _Result:
    """Again while another process holds the file: SQLite does not wait by itself where WAL is being turned on."""
    until = time.monotonic() + _PATIENCE
    while True:
        try:
            return act()
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > until:
                raise
            time.sleep(0.02)


def _open(path: Path) -> sqlite3.Connection:
    database = sqlite3.connect(path, timeout=_PATIENCE, isolation_level=None)
    try:
        database.execute("PRAGMA journal_mode = WAL")
        database.execute("PRAGMA synchronous = FULL")  # a run that was reported is there after the power has failed
    except BaseException:
        database.close()
        raise
    return database


def _open_to_read(path: Path) -> sqlite3.Connection:
    """Also in a folder that cannot be written, where WAL's own files cannot be made."""
    address = path.resolve().as_uri()
    database = sqlite3.connect(f"{address}?mode=rw", uri=True, timeout=_PATIENCE, isolation_level=None)
    try:
        database.execute("SELECT 1 FROM sqlite_master").fetchone()
    except sqlite3.OperationalError as error:
        database.close()
        if "open" not in str(error) and "readonly" not in str(error):
            raise
        return sqlite3.connect(f"{address}?mode=ro&immutable=1", uri=True, isolation_level=None)
    return database


def _open_schema(database: sqlite3.Connection, path: Path) -> None:
    if _is_empty(database):
        for statement in _SCHEMA:
            database.execute(statement)
        database.execute(f"PRAGMA application_id = {_APPLICATION}")
        database.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")
    _check_version(database, path)


def _is_empty(database: sqlite3.Connection) -> bool:
    (version,) = database.execute("PRAGMA user_version").fetchone()
    (tables,) = database.execute("SELECT count(*) FROM sqlite_master").fetchone()
    return bool(version == 0 and tables == 0)


def _check_version(database: sqlite3.Connection, path: Path) -> None:
    (application,) = database.execute("PRAGMA application_id").fetchone()
    (version,) = database.execute("PRAGMA user_version").fetchone()
    if application != _APPLICATION:
        raise InvalidInput(f"{path}: is not a history of regression runs; aliascope regress -o DIR makes one")
    if version > SCHEMA_VERSION:
        raise InvalidInput(
            f"{path}: was written with schema {version}, this version knows {SCHEMA_VERSION}: use a newer aliascope, "
            "or begin another history with -o"
        )


def _no_history(path: Path, error: Exception) -> InvalidInput:
    return InvalidInput(f"{path}: is not a history of regression runs: {error}; move it away")


# --- rows -------------------------------------------------------------------------------------------------------------


def _json(value: Any) -> str:
    return json.dumps(value if isinstance(value, (list, tuple)) else dict(value), sort_keys=True)


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _digest(value: Any) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:16]


def _row(cell: CellVerdict) -> tuple[object, ...]:
    """All columns of a cell but the run."""
    name, seen = cell.name, cell.observed
    head = (name.scene, name.renderer, name.mode, cell.passed)
    if seen is None or not seen.replicates:
        return (*head, cell.problem or "was not rendered", "", "", 0, None, None, "[]", None, "{}", None, "[]", "{}")
    draws = _digest([[one.draw.seed, *one.draw.shift] for one in seen.replicates])
    subject = _digest([seen.scene_digest, *seen.size, seen.filter])
    errors = [_finite(one.rmse) for one in seen.replicates if one.rmse is not None]
    rmse = _rmse(errors)
    times = [one.cpu_seconds for one in seen.replicates]
    samples = sum(one.samples for one in seen.replicates)
    figures = (rmse.value, rmse.standard_error, _json(errors), samples, _json(_rays(seen)), median(times), _json(times))
    return (*head, cell.problem, subject, draws, len(seen.replicates), *figures, _json(seen.versions))


def _rmse(errors: Sequence[float | None]) -> Estimate:
    """None where a replicate has none: the rest would be of other draws than the runs before."""
    known = [error for error in errors if error is not None]
    return root_mean_square(known) if known and len(known) == len(errors) else Estimate(None)


def _rays(seen: Observed) -> dict[str, int]:
    kinds = dict.fromkeys(kind for one in seen.replicates for kind in one.rays)
    return {kind: sum(one.rays.get(kind, 0) for one in seen.replicates) for kind in kinds}


def _kept_cell(row: sqlite3.Row) -> KeptCell:
    pictures = row["pictures"]
    return KeptCell(
        name=CellName(row["scene"], row["renderer"], row["mode"]),
        passed=bool(row["passed"]),
        problem=row["problem"],
        subject=row["subject"],
        draws=row["draws"],
        pictures=pictures,
        rmse=Estimate(row["rmse"], row["rmse_standard_error"]),
        rmse_of_each=tuple(json.loads(row["rmse_of_each"])),
        samples=row["samples"] / pictures if pictures else None,
        rays={kind: count / pictures for kind, count in json.loads(row["rays"]).items()},
        cpu_seconds=row["cpu_seconds"],
        cpu_seconds_of_each=tuple(json.loads(row["cpu_seconds_of_each"])),
        versions=json.loads(row["versions"]),
    )


def _kept_run(row: sqlite3.Row, cells: tuple[KeptCell, ...]) -> KeptRun:
    return KeptRun(
        started=row["started"],
        wall_seconds=row["wall_seconds"],
        revision=row["revision"],
        machine=json.loads(row["machine"]),
        versions=json.loads(row["versions"]),
        command=row["command"],
        passed=bool(row["passed"]),
        cells=cells,
    )
