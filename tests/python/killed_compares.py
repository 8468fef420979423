"""Comparisons whose processes are killed at a moment that a seed draws, gone on from, and held against one that nobody
disturbed. `make faults` has 200 of them, test_faults_killed.py a few."""

from __future__ import annotations

import argparse
import contextlib
import itertools
import multiprocessing
import os
import random
import shutil
import signal
import sqlite3
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import cloudpickle
import numpy as np

from aliascope import cli, pipeline, scratch
from aliascope.image import read_image
from aliascope.store import SCHEMA_VERSION

# Forks of a process that has loaded what takes long to load, and nothing else: the threads of libraries in a process
# that has measured or written pictures are not in its forks, which would wait for them.
FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(
    ["aliascope.cli", "aliascope.studies.compare", "aliascope.studies.selection", "flip_evaluator", "skimage.metrics"]
)

ARGUMENTS = (*("compare", "edge", "-m", "adaptive:method=kajiya,n=64", "-m", "none", "--size", "16x12"),)
JOBS = 9
"""Three seeds, or three places of the film, of each mode; "none" is one of POV-Ray's and one of OSMesa's."""
VICTIMS = ("harness", "worker", "povray")
PATIENCE = 300.0
"""Seconds that a run of some seconds may take on a busy machine."""

Pictures = dict[str, tuple[dict[str, Any], list[tuple[str, float | None]], bytes]]


@dataclass(frozen=True)
class Moment:
    """CPU seconds of a run, all its processes together, after which who is killed: a machine that is busier than
    another time moves no moment."""

    seconds: float
    victim: str


def moments(count: int, seed: int, seconds: float) -> list[Moment]:
    """As many as `count`, in an order by chance: one in each of `count` equal parts of the run, the victims in turn."""
    chance = random.Random(seed)
    parts = list(range(count))
    chance.shuffle(parts)
    return [
        Moment((part + chance.random()) / count * seconds, VICTIMS[(seed + number) % len(VICTIMS)])
        for number, part in enumerate(parts)
    ]


@dataclass(frozen=True)
class Killed:
    """What a kill came to: `hit` is False where the run had ended before; the exit code of the run, and the pictures
    that the database had then."""

    moment: Moment
    hit: bool
    ended: int
    finished: int


# --- runs -------------------------------------------------------------------------------------------------------------


def _command(folder: Path, words: tuple[str | Path, ...], prepare: bytes) -> None:
    """Runs in one of FORKS; its workers begin as ever. Figures are not drawn, and pictures timed once: neither is what
    is looked at. prepare: a function, pickled."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    told = (folder.parent / f"{folder.name}.out").open("a")
    for stream in (1, 2):
        os.dup2(told.fileno(), stream)
    sys.stdout = sys.stderr = told  # pytest has others there
    _temporary(folder).mkdir(exist_ok=True)
    os.environ["TMPDIR"] = tempfile.tempdir = str(_temporary(folder))
    with contextlib.ExitStack() as stack:
        for name in ("plot_svg", "spectrum_svg", "filters_svg"):
            stack.enter_context(patch(f"aliascope.report.{name}", lambda *_: "<svg/>"))
        stack.enter_context(patch.object(sys, "argv", ["aliascope", *map(str, words), "-o", str(folder)]))
        stack.enter_context(patch.object(pipeline.Options.__init__, "__defaults__", (1, 120.0, 0.0)))
        cloudpickle.loads(prepare)()
        cli.main()


@contextlib.contextmanager
def started(
    folder: Path, *more: str | Path, arguments: Sequence[str] = ARGUMENTS, prepare: Callable[[], object] = bool
) -> Iterator[multiprocessing.process.BaseProcess]:
    """A compare on its way; in the end no process of it is left. `prepare` is called there before it begins."""
    process = FORKS.Process(target=_command, args=(folder, (*arguments, *more), cloudpickle.dumps(prepare)))
    process.start()
    try:
        yield process
    finally:
        if process.is_alive():
            process.kill()
        process.join()


def told(
    folder: Path, *more: str | Path, arguments: Sequence[str] = ARGUMENTS, prepare: Callable[[], object] = bool
) -> tuple[int, str]:
    """Runs a compare to its end: the exit code, and what it said."""
    said = folder.parent / f"{folder.name}.out"
    said.unlink(missing_ok=True)
    with started(folder, *more, arguments=arguments, prepare=prepare) as process:
        process.join(PATIENCE)
        assert process.exitcode is not None, "no end"
        assert process.pid is not None
        assert leftovers(process.pid) == []
        return process.exitcode, said.read_text()


def finish(folder: Path, *more: str) -> tuple[int, float]:
    """Runs a compare to its end: the exit code, and how many CPU seconds it took."""
    with started(folder, *more) as process:
        assert process.pid is not None
        seconds, deadline = 0.0, time.monotonic() + PATIENCE
        while process.is_alive() and time.monotonic() < deadline:
            seconds = max(seconds, cpu_seconds(process.pid))
            time.sleep(0.02)
        process.join(0.0)
        assert process.exitcode is not None, "no end"
        return process.exitcode, seconds


# --- processes --------------------------------------------------------------------------------------------------------


def children(pid: int) -> list[int]:
    """The processes that a process has started and that run."""
    found = []
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            with contextlib.suppress(OSError):
                found += [int(word) for word in (task / "children").read_text().split()]
    return found


def command_of(pid: int) -> str:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
    return ""


def cpu_seconds(pid: int) -> float:
    """Of a process and all that it has started."""
    own = 0
    with contextlib.suppress(OSError):
        own = sum(map(int, Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:15]))
    return own / os.sysconf("SC_CLK_TCK") + sum(map(cpu_seconds, children(pid)))


def session(pid: int) -> list[int]:
    """The processes of a session, also those whose parent has ended; none that has ended itself."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            with contextlib.suppress(OSError):
                state, _, _, of = (entry / "stat").read_text().rpartition(")")[2].split()[:4]
                if int(of) == pid and state not in "ZX":
                    found.append(int(entry.name))
    return found


def workers_of(pid: int) -> list[int]:
    return [child for child in children(pid) if "spawn_main" in command_of(child)]


def _victims(harness: int, victim: str) -> list[int]:
    if victim == "harness":
        return [harness]
    workers = workers_of(harness)
    if victim == "worker":
        return workers
    return [child for worker in workers for child in children(worker) if "povray" in command_of(child)]


def kill(process: multiprocessing.process.BaseProcess, moment: Moment, chance: random.Random) -> bool:
    """Kills the victim at its moment, or as soon as there is one after it; False where the run ended before."""
    assert process.pid is not None
    while cpu_seconds(process.pid) < moment.seconds and process.is_alive():
        time.sleep(0.002)
    time.sleep(chance.random() / os.sysconf("SC_CLK_TCK"))  # CPU time is counted in steps of this
    while process.is_alive():
        if found := _victims(process.pid, moment.victim):
            with contextlib.suppress(ProcessLookupError):
                os.kill(chance.choice(found), signal.SIGKILL)
                return True
        time.sleep(0.002)
    return False


# --- what is left -----------------------------------------------------------------------------------------------------


def pictures(folder: Path) -> Pictures:
    """What a folder holds of each job: its row but for times, its metrics, the bytes of the values of its picture."""
    with contextlib.closing(sqlite3.connect(folder / "results.sqlite")) as database:
        database.row_factory = sqlite3.Row
        found: Pictures = {}
        for row in database.execute("SELECT * FROM job"):
            assert row["key"] not in found
            kept = {name: row[name] for name in ("scene", "renderer", "mode", "seed", "status", "samples", "image")}
            metrics = database.execute("SELECT name, value FROM metric WHERE key = ? ORDER BY name", (row["key"],))
            there = folder / (row["image"] or "none")
            values = np.ascontiguousarray(read_image(there)).tobytes() if there.is_file() else b""
            found[row["key"]] = kept, [tuple(each) for each in metrics], values
    return found


def problems(folder: Path, right: Pictures) -> list[str]:
    """What is not as it is in a folder that nobody disturbed."""
    wrong = []
    with contextlib.closing(sqlite3.connect(folder / "results.sqlite")) as database:
        wrong += [text for (text,) in database.execute("PRAGMA integrity_check") if text != "ok"]
        wrong += [f"foreign key {row}" for row in database.execute("PRAGMA foreign_key_check")]
        if database.execute("PRAGMA user_version").fetchone() != (SCHEMA_VERSION,):
            wrong.append("the schema is another")
    found = pictures(folder)
    wrong += [f"job {key} is only in one of the two" for key in found.keys() ^ right.keys()]
    for key in found.keys() & right.keys():
        names = ("row", "metrics", "picture")
        differs = [name for name, mine, own in zip(names, found[key], right[key], strict=True) if mine != own]
        if differs:
            wrong.append(f"{right[key][0]['mode']}: another {' and '.join(differs)}")
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*.exr") if "images" in path.parts}
    known = {str(row["image"]) for row, _, _ in right.values()}
    known |= {pipeline.counts_path(str(row["image"])) for row, _, _ in right.values() if "adaptive" in row["mode"]}
    wrong += [f"file {name}" for name in files ^ known]
    hidden = [path for path in folder.rglob(".*") if path.name != ".lock"]
    wrong += [f"left: {path.relative_to(folder)}" for path in [*hidden, *folder.glob("*-wal"), *folder.glob("*-shm")]]
    if not (folder / "report.html").is_file() or not (folder / "results.csv").is_file():
        wrong.append("no report")
    return wrong


def leftovers(harness: int, within: float = 60.0) -> list[str]:
    """Processes of a run that has ended that are still there; those of a harness that was killed take a moment."""
    deadline = time.monotonic() + within
    while found := session(harness):
        if time.monotonic() > deadline:
            return [f"process {command_of(pid)}" for pid in found]
        time.sleep(0.01)
    return []


def unfinished(folder: Path) -> list[str]:
    """Pictures under their own names that cannot be read."""
    wrong = []
    for path in folder.rglob("*.exr"):
        if not path.name.startswith("."):
            try:
                read_image(path)
            except Exception as error:  # noqa: BLE001 - whatever it is, it is what is looked for
                wrong.append(f"half a picture: {error}")
    return wrong


def kept(folder: Path) -> int:
    """The pictures that a database has, as another process sees it."""
    path = folder / "results.sqlite"
    if not path.is_file():
        return 0
    with contextlib.closing(sqlite3.connect(path)) as database:
        try:
            return int(database.execute("SELECT count(*) FROM job WHERE status = 'done'").fetchone()[0])
        except sqlite3.OperationalError:  # its tables are not there yet
            return 0


def disturbed(folder: Path, asked: Sequence[Moment], right: Pictures, seed: int) -> tuple[list[Killed], list[str]]:
    """Kills at a moment, looks at what is left, and goes on, to be killed at the next one, until there is none: what
    the kills came to, and what is wrong."""
    chance, wrong, killed = random.Random(seed), list[str](), list[Killed]()
    for moment in asked:
        with started(folder, *_resume(folder)) as process:
            hit = kill(process, moment, chance)
            process.join(PATIENCE)
            assert process.pid is not None
            assert process.exitcode is not None, "no end"
        wrong += leftovers(process.pid)
        wrong += unfinished(folder)
        killed.append(Killed(moment, hit, process.exitcode, kept(folder)))
    code, _ = finish(folder, *_resume(folder))
    if code:
        wrong.append(f"going on ended with {code}: {(folder.parent / f'{folder.name}.out').read_text()[-500:]}")
    wrong += problems(folder, right)
    wrong += [f"scratch folder {path}" for path in abandoned(folder)]
    return killed, wrong


def _resume(folder: Path) -> tuple[str, ...]:
    return ("--resume",) if (folder / "results.sqlite").is_file() else ()


def abandoned(folder: Path) -> list[Path]:
    """The scratch folders of the runs in a folder that are still there."""
    return sorted(_temporary(folder).glob(f"{scratch.PREFIX}*"))


def _temporary(folder: Path) -> Path:
    """Where the runs in a folder have their temporary files, apart from those of others."""
    return folder.parent / f"{folder.name}.tmp"


# --- make faults ------------------------------------------------------------------------------------------------------


def undisturbed(folder: Path) -> tuple[Pictures, float]:
    """What a compare that nobody disturbs leaves, and the seconds that it takes."""
    code, seconds = finish(folder)
    assert code == 0, (folder.parent / f"{folder.name}.out").read_text()
    assert problems(folder, pictures(folder)) == []
    return pictures(folder), seconds


TOGETHER = 2
"""Kills of one folder: each of the run that goes on from the last one."""


def main() -> None:
    """make faults: prints a line a kill, then what they came to; ends with 1 where anything is wrong."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--kills", type=int, default=200)
    asked.add_argument("--seed", type=int, default=1)
    options = asked.parse_args()
    killed: list[Killed] = []
    wrong: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        right, seconds = undisturbed(folder / "right")
        rounds = itertools.count(options.seed)
        while sum(each.hit for each in killed) < options.kills:
            seed = next(rounds)
            found, problem = disturbed(folder / f"{seed}", moments(TOGETHER, seed, seconds), right, seed)
            for number, each in enumerate(found):
                print(
                    f"{len(killed) + number + 1:3}  {each.moment.victim:8} at {each.moment.seconds:5.2f} s"
                    f"{'' if each.hit else ', the run had ended'}: exit {each.ended}, {each.finished} pictures kept",
                    flush=True,
                )
            print(f"     gone on to the end: {'; '.join(problem) or 'as undisturbed'}", flush=True)
            killed += found
            wrong += problem
            shutil.rmtree(folder / f"{seed}")
    hits = [each for each in killed if each.hit]
    counts = ", ".join(f"{sum(each.moment.victim == victim for each in hits)} of {victim}" for victim in VICTIMS)
    middle = sum(0 < each.finished < JOBS for each in hits)
    print(f"{len(hits)} kills ({counts}), {middle} of them with some pictures and not all; {len(wrong)} things wrong")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
