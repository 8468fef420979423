"""The results of comparisons: one SQLite file, written by one process, whole after each job."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from types import TracebackType

from aliascope.errors import InvalidInput, NotWritable
from aliascope.records import Cost, Job, Noise, Outcome, Probe

SCHEMA_VERSION = 4

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
{_PROBE}"""

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
}
"""What brings a schema to the next."""


class Store:
    """The results of one output folder. Use as a context manager; raises NotWritable, InvalidInput."""

    def __init__(self, path: Path) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._database = sqlite3.connect(path)
            self._database.execute("PRAGMA journal_mode = WAL")
            self._database.execute("PRAGMA synchronous = NORMAL")
            self._database.execute("PRAGMA foreign_keys = ON")
            self._open_schema(path)
        except (OSError, sqlite3.OperationalError) as error:
            raise NotWritable(f"{path}: cannot be written: {error}; choose another folder with -o") from error
        except sqlite3.DatabaseError as error:
            raise InvalidInput(f"{path}: is not a database of results: {error}; move it away") from error
        self._run = 0

    def _open_schema(self, path: Path) -> None:
        (version,) = self._database.execute("PRAGMA user_version").fetchone()
        if version == 0:
            with self._database:
                self._database.executescript(_SCHEMA)
                self._database.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")
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
        with self._database:
            cursor = self._database.execute(
                "INSERT INTO run (started, command, revision, machine, versions) VALUES (?, ?, ?, ?, ?)",
                (started, command, revision, json.dumps(dict(machine)), json.dumps(dict(versions))),
            )
        assert cursor.lastrowid is not None
        self._run = cursor.lastrowid

    def put(self, outcome: Outcome) -> None:
        """Keeps an outcome, in place of an earlier one of the same job."""
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
        try:
            with self._database:
                self._database.execute("DELETE FROM job WHERE key = ?", (job.key,))
                self._database.execute(f"INSERT INTO job VALUES ({', '.join('?' * len(row))})", row)
                self._database.executemany(
                    "INSERT INTO metric VALUES (?, ?, ?)",
                    [(job.key, name, value) for name, value in outcome.metrics.items()],
                )
        except sqlite3.OperationalError as error:
            raise NotWritable(f"results.sqlite: cannot be written: {error}") from error

    def put_metrics(self, key: str, metrics: Mapping[str, float | None]) -> None:
        """Keeps the metrics of a picture whose outcome is kept, in place of earlier ones."""
        try:
            with self._database:
                self._database.execute("DELETE FROM metric WHERE key = ?", (key,))
                self._database.executemany(
                    "INSERT INTO metric VALUES (?, ?, ?)", [(key, name, value) for name, value in metrics.items()]
                )
        except sqlite3.OperationalError as error:
            raise NotWritable(f"results.sqlite: cannot be written: {error}") from error

    def put_noise(self, noise: Noise | None) -> None:
        """Keeps how steady the machine was during this run."""
        if noise is None:
            return
        try:
            with self._database:
                self._database.execute("UPDATE run SET noise = ? WHERE id = ?", (json.dumps(asdict(noise)), self._run))
        except sqlite3.OperationalError as error:
            raise NotWritable(f"results.sqlite: cannot be written: {error}") from error

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
        try:
            with self._database:
                self._database.execute(
                    f"INSERT OR REPLACE INTO probe VALUES ({', '.join('?' * 10)})", (*row, probe.holds)
                )
        except sqlite3.OperationalError as error:
            raise NotWritable(f"results.sqlite: cannot be written: {error}") from error

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
        for key in keys:
            row = self._database.execute("SELECT * FROM job WHERE key = ? AND status = 'done'", (key,)).fetchone()
            if row is not None:
                metrics = self._database.execute("SELECT name, value FROM metric WHERE key = ?", (key,))
                found[key] = _outcome(row, dict(metrics))
        return found


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
