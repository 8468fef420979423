"""The results of comparisons: one SQLite file, written by one process, whole after each job."""

from __future__ import annotations

import contextlib
import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from types import TracebackType

from aliascope.errors import InvalidInput, NotWritable
from aliascope.records import Cost, Job, Noise, Outcome, Probe

SCHEMA_VERSION = 6

_PROBE = """
CREATE TABLE probe (
  key TEXT PRIMARY KEY,             -- hash of all that its figures depend on
  run INTEGER NOT NULL REFERENCES run (id),
  renderer TEXT NOT NULL, mode TEXT NOT NULL,
  right_pixels REAL NOT NULL, down_pixels REAL NOT NULL,
  gain REAL NOT NULL, gamma REAL NOT NULL, deviation REAL NOT NULL,
  holds INTEGER NOT NULL
);
"""

_FILE = """
CREATE TABLE file (
  path TEXT PRIMARY KEY,            -- of a picture, its counts or a reference, relative to the folder
  sha256 TEXT NOT NULL              -- of its bytes as they were written
);
"""

_MACHINE = """
CREATE TABLE machine (
  key TEXT PRIMARY KEY REFERENCES job (key) ON DELETE CASCADE,
  name TEXT NOT NULL                -- which timed the job, where it was not that of its run
);
"""

_SCHEMA = f"""
CREATE TABLE run (
  id INTEGER PRIMARY KEY,
  started TEXT NOT NULL,            -- UTC, ISO 8601
  command TEXT NOT NULL,
  revision TEXT NOT NULL,           -- of the source tree, "+" where it has changes
  machine TEXT NOT NULL,            -- JSON
  versions TEXT NOT NULL,           -- JSON
  noise TEXT                        -- JSON: how steady the machine was; NULL where nothing was timed
);
CREATE TABLE job (
  key TEXT PRIMARY KEY,             -- hash of all that the picture depends on
  run INTEGER NOT NULL REFERENCES run (id),
  scene TEXT NOT NULL, scene_path TEXT NOT NULL,
  renderer TEXT NOT NULL, mode TEXT NOT NULL,
  width INTEGER NOT NULL, height INTEGER NOT NULL,
  seed INTEGER NOT NULL,
  status TEXT NOT NULL CHECK (status IN ('done', 'failed')),
  message TEXT NOT NULL,
  samples INTEGER, samples_per_pixel REAL,
  rays TEXT,                        -- JSON, by kind
  cpu_seconds REAL, wall_seconds REAL, repeats INTEGER,
  quantum REAL,
  image TEXT,                       -- relative to the folder
  harness_seconds REAL,
  processes INTEGER NOT NULL DEFAULT 1, -- that ran side by side: with more than one, times are inflated
  shift_right REAL NOT NULL DEFAULT 0, shift_down REAL NOT NULL DEFAULT 0, -- of the film, in pixels
  instructions REAL                 -- of the rendering of one picture; NULL where they cannot be counted
);
CREATE TABLE metric (
  key TEXT NOT NULL REFERENCES job (key) ON DELETE CASCADE,
  name TEXT NOT NULL,
  value REAL,                       -- NULL: the metric has none for this picture
  PRIMARY KEY (key, name)
);
{_PROBE}{_FILE}{_MACHINE}"""

_STEPS = {
    # Jobs that schema 1 kept count as timed alone, the default of -j. They may not have been: it did not note that.
    1: ("ALTER TABLE job ADD COLUMN processes INTEGER NOT NULL DEFAULT 1",),
    2: (_PROBE,),
    # Schema 3 had no pictures that were moved.
    3: (
        "ALTER TABLE run ADD COLUMN noise TEXT",
        "ALTER TABLE job ADD COLUMN shift_right REAL NOT NULL DEFAULT 0",
        "ALTER TABLE job ADD COLUMN shift_down REAL NOT NULL DEFAULT 0",
        "ALTER TABLE job ADD COLUMN instructions REAL",
    ),
    4: (_FILE,),
    5: (_MACHINE,),
}
"""What brings a schema to the next."""


@contextlib.contextmanager
def _told(path: Path) -> Iterator[None]:
    """What goes wrong with a database, as one line of ours."""
    try:
        yield
    except (OSError, sqlite3.OperationalError) as error:
        raise NotWritable(f"{path}: cannot be written: {error}; choose another folder with -o") from error
    except sqlite3.DatabaseError as error:
        raise InvalidInput(f"{path}: is not a database of results: {error}; move it away") from error


class Store:
    """The results of one output folder. Use as a context manager; raises NotWritable, InvalidInput."""

    def __init__(self, path: Path) -> None:
        self._path, self._run = path, 0
        with _told(path), contextlib.ExitStack() as opened:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._database = opened.enter_context(contextlib.closing(sqlite3.connect(path)))
            self._database.execute("PRAGMA journal_mode = WAL")
            self._database.execute("PRAGMA synchronous = NORMAL")
            self._database.execute("PRAGMA foreign_keys = ON")
            self._open_schema(path)
            opened.pop_all()  # it stays open: only where it cannot be used is it closed here

    def _open_schema(self, path: Path) -> None:
        (version,) = self._database.execute("PRAGMA user_version").fetchone()
        if version == 0:
            # At once: half a schema of a process that was killed here could not be gone on from.
            self._database.executescript(f"BEGIN; {_SCHEMA} PRAGMA user_version = {SCHEMA_VERSION}; COMMIT;")
        elif version in _STEPS:
            with self._database:
                self._database.execute("BEGIN")  # or a column could be there and the version not
                for step in range(version, SCHEMA_VERSION):
                    for statement in _STEPS[step]:
                        self._database.execute(statement)
                self._database.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")
        elif version != SCHEMA_VERSION:
            raise InvalidInput(
                f"{path}: was written with schema {version}, this version has {SCHEMA_VERSION}; "
                "choose another folder with -o"
            )

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._database.close()

    def begin_run(
        self, started: str, command: str, revision: str, machine: Mapping[str, str], versions: Mapping[str, str]
    ) -> None:
        """Notes who makes the results that follow."""
        with self._transaction():
            cursor = self._database.execute(
                "INSERT INTO run (started, command, revision, machine, versions) VALUES (?, ?, ?, ?, ?)",
                (started, command, revision, json.dumps(dict(machine)), json.dumps(dict(versions))),
            )
        assert cursor.lastrowid is not None
        self._run = cursor.lastrowid

    @contextlib.contextmanager
    def _transaction(self) -> Iterator[None]:
        """All of what is written in here or nothing. Raises NotWritable, and InvalidInput for a broken database."""
        with _told(self._path), self._database:
            yield

    def put(self, outcome: Outcome, files: Mapping[str, str] | None = None) -> None:
        """Keeps an outcome, in place of an earlier one of the same job, with the hashes of its files."""
        job, cost = outcome.job, outcome.cost
        figures: tuple[object, ...] = (None,) * 6
        instructions = cost.instructions if cost is not None else None
        if cost is not None:
            rays = json.dumps(dict(cost.rays))
            figures = (cost.samples, cost.samples_per_pixel, rays, cost.cpu_seconds, cost.wall_seconds, cost.repeats)
        row = (
            *(job.key, self._run, job.scene, job.scene_path, job.renderer, job.mode, job.width, job.height, job.seed),
            *(outcome.status, outcome.message, *figures),
            *(outcome.quantum, outcome.image, outcome.harness_seconds, outcome.processes, *job.shift, instructions),
        )
        with self._transaction():
            self._database.execute("DELETE FROM job WHERE key = ?", (job.key,))
            self._database.execute(f"INSERT INTO job VALUES ({', '.join('?' * len(row))})", row)
            self._database.executemany(
                "INSERT INTO metric VALUES (?, ?, ?)",
                [(job.key, name, value) for name, value in outcome.metrics.items()],
            )
            if outcome.machine:
                self._database.execute("INSERT INTO machine VALUES (?, ?)", (job.key, outcome.machine))
            self._database.executemany("INSERT OR REPLACE INTO file VALUES (?, ?)", (files or {}).items())

    def put_files(self, files: Mapping[str, str]) -> None:
        """Keeps the hashes of files, by path."""
        with self._transaction():
            self._database.executemany("INSERT OR REPLACE INTO file VALUES (?, ?)", files.items())

    def file(self, path: str) -> str | None:
        """The hash of a file as it was written; None for one that an earlier schema, or nobody, noted."""
        with _told(self._path):
            row = self._database.execute("SELECT sha256 FROM file WHERE path = ?", (path,)).fetchone()
        return None if row is None else str(row[0])

    def outdated(self) -> dict[str, str]:
        """The rows of pictures that a later run has made anew, which had other code or another version of the scene:
        the path of each picture, "" for none, by key."""
        same = " AND ".join(
            f"later.{column} = job.{column}"
            for column in ("scene", "renderer", "mode", "width", "height", "seed", "shift_right", "shift_down")
        )
        later = f"SELECT 1 FROM job AS later WHERE {same} AND later.run > job.run AND later.status = 'done'"
        rows = self._database.execute(f"SELECT key, image FROM job WHERE EXISTS ({later})")
        return {row[0]: row[1] or "" for row in rows}

    def images(self, but: Iterable[str] = ()) -> set[str]:
        """The paths of all pictures but those of these rows."""
        left_out = set(but)
        rows = self._database.execute("SELECT key, image FROM job")
        return {row[1] for row in rows if row[0] not in left_out and row[1]}

    def remove(self, keys: Iterable[str], files: Iterable[str]) -> None:
        """Removes rows, and what is known of files."""
        with self._transaction():
            self._database.executemany("DELETE FROM job WHERE key = ?", [(key,) for key in keys])
            self._database.executemany("DELETE FROM file WHERE path = ?", [(path,) for path in files])

    def put_metrics(self, key: str, metrics: Mapping[str, float | None]) -> None:
        """Keeps the metrics of a picture whose outcome is kept, in place of earlier ones."""
        with self._transaction():
            self._database.execute("DELETE FROM metric WHERE key = ?", (key,))
            self._database.executemany(
                "INSERT INTO metric VALUES (?, ?, ?)", [(key, name, value) for name, value in metrics.items()]
            )

    def put_noise(self, noise: Noise | None) -> None:
        """Keeps how steady the machine was during this run."""
        if noise is None:
            return
        with self._transaction():
            self._database.execute("UPDATE run SET noise = ? WHERE id = ?", (json.dumps(asdict(noise)), self._run))

    def noise(self, keys: Iterable[str]) -> Noise | None:
        """How steady the machine was when the pictures of these keys were timed: of the last run that timed some of
        them, or of the last one on a loaded machine. None where no run has told."""
        runs = {
            row[0]
            for key in keys
            for row in self._database.execute("SELECT run FROM job WHERE key = ? AND status = 'done'", (key,))
        }
        found: list[Noise] = []
        for run in sorted(runs):
            (text,) = self._database.execute("SELECT noise FROM run WHERE id = ?", (run,)).fetchone()
            if text is not None:
                found.append(Noise(**json.loads(text)))
        return next((each for each in reversed(found) if each.loaded), found[-1] if found else None)

    def put_probe(self, key: str, probe: Probe) -> None:
        """Keeps the figures of a probe. One without figures is not kept, so it is tried again."""
        if probe.centre is None:
            return
        row = (key, self._run, probe.renderer, probe.mode, *probe.centre, probe.gain, probe.gamma, probe.deviation)
        with self._transaction():
            self._database.execute(f"INSERT OR REPLACE INTO probe VALUES ({', '.join('?' * 10)})", (*row, probe.holds))

    def probe(self, key: str) -> Probe | None:
        """The probe that was kept under a key."""
        columns = "renderer, mode, right_pixels, down_pixels, gain, gamma, deviation, holds"
        row = self._database.execute(f"SELECT {columns} FROM probe WHERE key = ?", (key,)).fetchone()
        if row is None:
            return None
        renderer, mode, right, down, gain, gamma, deviation, holds = row
        return Probe(renderer, mode, bool(holds), (right, down), gain, gamma, deviation)

    def done(self, keys: Iterable[str]) -> dict[str, Outcome]:
        """The finished outcomes among these keys; failed ones are not among them, so they are tried again."""
        found: dict[str, Outcome] = {}
        self._database.row_factory = sqlite3.Row
        with _told(self._path):
            for key in keys:
                row = self._database.execute("SELECT * FROM job WHERE key = ? AND status = 'done'", (key,)).fetchone()
                if row is not None:
                    metrics = self._database.execute("SELECT name, value FROM metric WHERE key = ?", (key,))
                    machine = self._database.execute("SELECT name FROM machine WHERE key = ?", (key,)).fetchone()
                    found[key] = replace(_outcome(row, dict(metrics)), machine=machine[0] if machine else "")
        return found


def costs(path: Path) -> dict[tuple[str, str, str], float]:
    """CPU seconds that a job took, all of its repeats, in the mean: by scene, renderer and mode, of the results in a
    file; empty where there are none. Nothing is written."""
    if not path.is_file():
        return {}
    asked = "SELECT scene, renderer, mode, AVG(cpu_seconds * repeats) FROM job WHERE status = 'done' GROUP BY 1, 2, 3"
    try:
        with contextlib.closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as database:
            return {(scene, renderer, mode): seconds for scene, renderer, mode, seconds in database.execute(asked)}
    except sqlite3.Error as error:
        raise InvalidInput(f"{path}: cannot be read: {error}; choose another folder with -o") from error


def _outcome(row: sqlite3.Row, metrics: Mapping[str, float | None]) -> Outcome:
    names = ("key", "scene", "scene_path", "renderer", "mode", "width", "height", "seed")
    cost = Cost(
        samples=row["samples"],
        samples_per_pixel=row["samples_per_pixel"],
        rays=json.loads(row["rays"]),
        cpu_seconds=row["cpu_seconds"],
        wall_seconds=row["wall_seconds"],
        repeats=row["repeats"],
        instructions=row["instructions"],
    )
    return Outcome(
        job=Job(**{name: row[name] for name in names}, shift=(row["shift_right"], row["shift_down"])),
        status=row["status"],
        message=row["message"],
        cost=cost,
        metrics=metrics,
        quantum=row["quantum"],
        image=row["image"],
        harness_seconds=row["harness_seconds"],
        processes=row["processes"],
    )
