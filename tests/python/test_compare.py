"""The command compare: what it renders, keeps, tells, and does where something goes wrong."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fake_povray
import numpy as np
import pytest
from commands import COMMAND, complaint, environment, run

from aliascope import draws, places, plan, renderers
from aliascope.image import read_header, write_exr
from aliascope.studies import selection

QUICK = ("-m", "uniform:n=1", "-m", "none", "-m", "msaa:n=4")
"""One cheap mode of each renderer: of the tracer a picture a seed; "none" of POV-Ray and OSMesa, and "msaa", one for
each place of the film."""
SEEDS = plan.SEEDS["quick"]
PLACES = min(SEEDS, draws.MOST)


@pytest.fixture(autouse=True)
def quick_figures(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """The figures beside a report take more time than all else of a small comparison; test_report.py looks at them, and
    the test here that is marked."""
    if "figures" not in request.fixturenames:
        for name in ("plot_svg", "spectrum_svg", "filters_svg"):
            monkeypatch.setattr(f"aliascope.report.{name}", lambda *_: "<svg xmlns='http://www.w3.org/2000/svg'/>")


@pytest.fixture
def figures() -> None:
    """Has the figures drawn."""


def compare(folder: Path, *arguments: str, code: int = 0, **options: Any) -> dict[str, Any]:
    result = run("compare", *arguments, "-o", folder, "--json", code=code, **options)
    document = json.loads(result.stdout)
    assert isinstance(document, dict)
    return document


def test_a_second_compare_renders_nothing(tmp_path: Path) -> None:
    first = compare(tmp_path, "edge", "discs", *QUICK)
    pictures = 2 * (SEEDS + 3 * PLACES)
    assert (first["rendered"], first["reused"], first["failed"]) == (pictures, 0, 0)
    assert {(row["renderer"], row["mode"]) for row in first["rows"]} == {
        ("embree", "uniform:n=1"),
        ("povray", "none"),
        ("osmesa", "none"),
        ("osmesa", "msaa"),
    }
    assert all(row["metrics"]["rmse"] > 0 for row in first["rows"])
    second = compare(tmp_path, "edge", "discs", *QUICK, "--resume")
    assert (second["rendered"], second["reused"]) == (0, pictures)
    assert second["rows"] == first["rows"]

    with sqlite3.connect(tmp_path / "results.sqlite") as database:
        assert database.execute("PRAGMA user_version").fetchone() == (6,)
        revision, machine, versions = database.execute("SELECT revision, machine, versions FROM run").fetchone()
        rows = database.execute("SELECT image, seed, cpu_seconds, samples FROM job WHERE shift_right = 0").fetchall()
        moved = database.execute("SELECT image, shift_right, shift_down FROM job WHERE shift_right != 0").fetchall()
        (noise,) = database.execute("SELECT noise FROM run WHERE id = 1").fetchone()
    assert revision == places.revision()
    assert json.loads(machine) == places.machine()
    assert {"embree", "povray", "osmesa"} <= set(json.loads(versions))
    assert {(right, down) for _, right, down in moved} == {draws.shift_of(draw) for draw in range(1, PLACES)}
    for path, right, down in moved:
        header = read_header(tmp_path / path)
        assert header["shift"] == f"{right},{down}"
        assert f"--shift {right},{down}" in header["command"]
    assert first["trade"] == second["trade"]
    assert {mode["renderer"] for mode in first["trade"]["scenes"][0]["front"]} == {
        row["renderer"] for row in first["rows"]
    }
    assert first["noise"] == second["noise"] == json.loads(noise)
    assert first["noise"]["told"] in run("compare", "edge", "discs", *QUICK, "-o", tmp_path).stdout
    for path, seed, cpu_seconds, samples in rows:
        header = read_header(tmp_path / path)
        assert header["seed"] == str(seed)
        assert header["command"].startswith("aliascope render ")
        assert cpu_seconds >= 0
        assert samples > 0
    assert (
        "<title>compare, quick profile, chosen scenes and modes · aliascope</title>"
        in (tmp_path / "report.html").read_text()
    )
    assert (tmp_path / "results.csv").is_file()
    # Each renderer's conventions were measured once, and are in both reports.
    assert [probe["holds"] for probe in first["probes"]] == [True] * 3
    assert second["probes"] == first["probes"]

    # A metric that is new is measured of the pictures that are there.
    with sqlite3.connect(tmp_path / "results.sqlite") as database:
        database.execute("DELETE FROM metric WHERE name = 'mae'")
    third = compare(tmp_path, "edge", "discs", *QUICK)
    assert (third["rendered"], third["rows"]) == (0, first["rows"])

    # What is not there, is cut short, or is another picture, of the first seed or not, is made again.
    seeds = {seed: tmp_path / path for path, seed, *_ in rows}
    broken = [seeds.pop(0), seeds.pop(1)]
    rest = [path for path, *_ in rows if tmp_path / path not in broken]
    for path in broken:
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    (tmp_path / rest[0]).unlink()
    write_exr(tmp_path / rest[1], np.zeros((2, 3, 3), np.float32), {})
    fourth = compare(tmp_path, "edge", "discs", *QUICK, "--resume")
    assert (fourth["rendered"], fourth["failed"]) == (4, 0)
    assert [row["metrics"] for row in fourth["rows"]] == [row["metrics"] for row in first["rows"]]


def test_processes_side_by_side_make_the_same_pictures(tmp_path: Path) -> None:
    modes = ("edge", "-r", "embree", "-m", "uniform:n=4", "-m", "uniform:n=16,sampler=halton")
    one, two = (compare(tmp_path / processes, *modes, "-j", processes) for processes in ("1", "2"))
    assert [row["metrics"] for row in one["rows"]] == [row["metrics"] for row in two["rows"]]


def test_times_of_jobs_side_by_side_do_not_pass_for_those_of_jobs_alone(tmp_path: Path) -> None:
    modes = ("edge", "-r", "embree", "-m", "uniform:n=1")

    def report() -> str:
        return (tmp_path / "report.html").read_text()

    assert compare(tmp_path, *modes, "-j", "2")["rendered"] == SEEDS
    assert f"{SEEDS} of the pictures 2: those with more than 1 have inflated times" in report()
    assert compare(tmp_path, *modes, "-j", "3")["reused"] == SEEDS
    assert compare(tmp_path, *modes)["rendered"] == SEEDS
    assert "1: each picture was timed alone" in report()
    assert compare(tmp_path, *modes, "-j", "2")["reused"] == SEEDS
    assert "1: each picture was timed alone" in report()

    # A folder of the schema without that column is brought up to date; its pictures count as timed alone.
    with sqlite3.connect(tmp_path / "results.sqlite") as database:
        database.execute("ALTER TABLE job DROP COLUMN processes")
        for column in ("shift_right", "shift_down", "instructions"):
            database.execute(f"ALTER TABLE job DROP COLUMN {column}")
        database.execute("ALTER TABLE run DROP COLUMN noise")
        for table in ("probe", "file", "machine"):
            database.execute(f"DROP TABLE {table}")
        database.execute("PRAGMA user_version = 1")
    assert compare(tmp_path, *modes)["reused"] == SEEDS
    with sqlite3.connect(tmp_path / "results.sqlite") as database:
        assert database.execute("PRAGMA user_version").fetchone() == (6,)
        assert database.execute("SELECT DISTINCT processes FROM job").fetchall() == [(1,)]


def test_dry_run_and_choices(tmp_path: Path) -> None:
    def jobs(*arguments: str) -> list[dict[str, Any]]:
        found = json.loads(run("compare", *arguments, "--dry-run", "--json").stdout)["jobs"]
        assert isinstance(found, list)
        return found

    assert {job["scene"] for job in jobs("e*", "-r", "osmesa")} == {"edge"}
    assert {job["renderer"] for job in jobs("-r", "osmesa")} == {"osmesa"}
    assert {job["mode"] for job in jobs("edge", "-m", "am2*")} == {"am2", "am2:depth=4"}
    assert len(jobs("edge", "-m", "regular:n=9")) == PLACES
    for pattern, expected in (
        (
            "uniform:n=16*",
            {"uniform", *(f"uniform:sampler={name}" for name in ("random", "regular", "jittered", "halton"))},
        ),
        (
            "uniform:n=16,*",
            {"uniform", *(f"uniform:sampler={name}" for name in ("random", "regular", "jittered", "halton"))},
        ),
        ("am1:depth=3*", {"am1"}),  # the profile's own text
        ("am2:*threshold=0.1", {"am2", "am2:depth=4"}),  # with the defaults
        ("msaa:n=4*", {"msaa", "msaa:sample-shading=1"}),
        ("*owen, n=6?", {"uniform:n=64", "adaptive"}),  # as people read it
        ("uniform*owen*", {"uniform", *(f"uniform:n={n}" for n in (1, 4, 64, 256))}),
    ):
        assert {job["mode"] for job in jobs("edge", "-m", pattern)} == expected, pattern
    halton = {(job["renderer"], job["mode"]) for job in jobs("edge", "-m", "*halton*")}
    assert {mode for renderer, mode in halton if renderer == "osmesa"} == {
        "accumulate",
        "accumulate:n=4",
        "accumulate:n=64",
    }
    assert {renderer for renderer, _ in halton} == {"embree", "osmesa"}
    assert not (tmp_path / "results.sqlite").exists()
    for chosen, about in (
        (([], [], []), "quick profile"),
        ((["*"], [], ["*"]), "quick profile"),
        ((["e*"], [], []), "quick profile, chosen scenes"),
        (([], ["osmesa"], []), "quick profile, chosen modes"),
        ((["edge"], [], ["none"]), "quick profile, chosen scenes and modes"),
    ):
        assert selection.plan_of(*chosen, "quick", None).about == about
    for wrong, words in (
        (("egde",), 'did you mean "edge"?'),
        (("edge", "-r", "povrai"), 'did you mean "povray"?'),
        (("edge", "-m", "unifrom:n=4"), 'did you mean "uniform"?'),
        (("edge", "-m", "nine"), 'did you mean "none"?'),
        (("edge", "-m", "unifrom:n=16,*"), 'did you mean "uniform"?'),
        (("edge", "--profile", "quik"), 'did you mean "quick"?'),
        (("edge", "--resume", "-o", str(tmp_path / "absent")), "no results to resume"),
    ):
        assert words in complaint("compare", *wrong, code=2)


@pytest.mark.usefixtures("figures")
def test_a_renderer_that_is_absent_is_skipped_and_said_or_demanded(tmp_path: Path) -> None:
    nowhere = environment(tmp_path / "empty", alone=True)
    document = compare(tmp_path / "out", "edge", *QUICK, env=nowhere)
    assert "povray" in document["skipped"]
    figures = {path.name: path.stat().st_size for path in (tmp_path / "out" / "plots").glob("*.svg")}
    assert set(figures) == {"edge.svg", "edge-spectrum.svg", "filters.svg"}
    assert min(figures.values()) > 5_000
    assert document["rendered"] == SEEDS + 2 * PLACES
    text = run("compare", "edge", *QUICK, "-o", tmp_path / "out", env=nowhere).stdout
    assert "skipped povray: " in text
    assert "not installed" in complaint("compare", "edge", "-r", "povray", "-o", tmp_path / "o", code=3, env=nowhere)


# The worker that runs POV-Ray is its parent's parent's child: the script is started by it directly.
TROUBLE = {
    "am1:depth=2": ("kill -SEGV $$", "SIGSEGV"),
    "am1:depth=4": ("echo 'Parse Error: nonsense' >&2; exit 1", "Parse Error: nonsense"),
    "am1:depth=5": ("exec sleep 60", "had not ended after 2 s"),
    "am1:depth=6": ("kill -SEGV $PPID; sleep 1", "SIGSEGV"),
    "am1:depth=7": ("kill -KILL $PPID; sleep 1", "SIGKILL"),
}
"""What povray does in each mode: crashes, fails, hangs, takes its worker along, kills its worker."""


def test_jobs_that_fail_stop_no_other(tmp_path: Path) -> None:
    cases = "".join(f"*+R{mode[-1]}*) {body};; " for mode, (body, _) in TROUBLE.items())
    body = f'case "$*" in *version*) echo "POV-Ray 3.7.0.10" >&2; exit 0;; {cases}esac'
    path = environment(fake_povray.install(tmp_path / "bin", body))
    modes = ("-m", "uniform:n=1", "-m", "msaa:n=4", *(word for mode in TROUBLE for word in ("-m", mode)))
    arguments = ("edge", *modes, "--time-limit", "2")
    document = compare(tmp_path / "out", *arguments, code=4, env=path)
    assert (document["pictures"], document["failed"]) == (SEEDS + PLACES, PLACES * len(TROUBLE))
    report = (tmp_path / "out" / "report.html").read_text()
    failures = {failure["mode"]: failure for failure in document["failures"]}
    for mode, (_, words) in TROUBLE.items():
        assert words in failures[mode]["message"]
        command = failures[mode]["command"]
        assert command.startswith(f"aliascope render edge -r povray -m {mode} ")
        assert command.endswith(" --time-limit 2")
        assert words in report
    # What made no picture is not probed, and said before what is.
    probes = [(probe["renderer"], probe["holds"], probe["reason"]) for probe in document["probes"]]
    assert probes[0] == ("povray", False, "none of its pictures was made")
    assert set(probes[1:]) == {("embree", True, ""), ("osmesa", True, "")}
    # What failed is tried again, and only that.
    again = compare(tmp_path / "out", *arguments, code=4, env=path)
    assert (again["reused"], again["failed"]) == (SEEDS + PLACES, PLACES * len(TROUBLE))


def test_a_probe_that_hangs_stops_nothing(tmp_path: Path) -> None:
    """POV-Ray that hangs at the probe's antialiasing, and at nothing else."""
    real = shutil.which("povray")
    body = f'case "$*" in *+R9*) exec sleep 60;; *) exec {real} "$@";; esac'
    path = environment(fake_povray.install(tmp_path / "bin", body))
    arguments = ("edge", "-r", "povray", "-m", "none", "--time-limit", "12", "--size", "32x24")
    document = compare(tmp_path / "out", *arguments, env=path)
    assert (document["pictures"], document["failed"]) == (PLACES, 0)
    (probe,) = document["probes"]
    assert probe["reason"] == "its probe failed: povray had not ended after 12 s, its time limit, and was killed"
    assert probe["reason"] in (tmp_path / "out" / "report.html").read_text()
    # What failed is tried again; once it has figures, they are kept.
    for _ in range(2):
        document = compare(tmp_path / "out", *arguments[:-4], "--size", "32x24")
        (probe,) = document["probes"]
        assert probe["holds"]
    with sqlite3.connect(tmp_path / "out" / "results.sqlite") as database:
        assert database.execute("SELECT renderer, run FROM probe").fetchall() == [("povray", 2)]


def test_a_scene_that_nothing_draws_is_told_beside_those_that_are_drawn(tmp_path: Path) -> None:
    arguments = ("edge", "terrain", "-r", "osmesa", "-m", "none", "--size", "32x24")
    assert compare(tmp_path, *arguments)["rendered"] == PLACES
    assert "100352 triangles and 1 light" in (tmp_path / "report.html").read_text()
    rows = [line for line in (tmp_path / "results.csv").read_text().splitlines() if line.startswith("terrain,")]
    assert len(rows) == 1
    assert ',empty,"100352 triangles' in rows[0]


def test_folders_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    message = complaint("compare", "edge", *QUICK, "-o", tmp_path / "file" / "out", code=4)
    assert "choose another folder with -o" in message
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "results.sqlite").write_text("no database" * 100)
    assert "not a database" in complaint("compare", "edge", *QUICK, "-o", tmp_path / "out", code=2)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "images").write_text("")
    assert "choose another folder" in complaint("compare", "edge", *QUICK, "-o", tmp_path / "other", code=4)


def test_results_of_another_schema_are_refused(tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / "results.sqlite") as database:
        database.execute("PRAGMA user_version = 99")
    assert "schema 99" in complaint("compare", "edge", *QUICK, "-o", tmp_path, code=2)


SLOW_MODES = [f"uniform:n={n},sampler=regular" for n in (9216, 9409, 9604, 9801)]


def kept(folder: Path) -> int:
    """How many jobs, those of the slow modes aside, a compare that is running has finished."""
    path = folder / "results.sqlite"
    if not path.is_file():
        return 0
    database = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    try:
        slow = ",".join("?" * len(SLOW_MODES))
        query = f"SELECT count(*) FROM job WHERE status = 'done' AND mode NOT IN ({slow})"
        return int(database.execute(query, SLOW_MODES).fetchone()[0])
    except sqlite3.OperationalError:  # its tables are not there yet
        return 0
    finally:
        database.close()


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """What is started here hears of an interruption, even where these tests run in the background and do not."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_a_compare_that_was_stopped_keeps_what_it_has_and_goes_on(tmp_path: Path, how: signal.Signals) -> None:
    modes = [mode for mode in plan.QUICK["embree"] if mode.startswith(("uniform:n=1,", "uniform:n=4,"))]
    arguments = ("edge", "-r", "embree", *(word for mode in modes for word in ("-m", mode)))
    # Jobs run in an order that their keys decide. Slow ones among them keep the compare on its way where this test gets
    # too little time to see five pictures early.
    slow = [word for mode in SLOW_MODES for word in ("-m", mode)]
    command = [*COMMAND, "compare", *arguments, *slow, "-o", str(tmp_path)]
    with interruptible():
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while kept(tmp_path) < 5:
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.02)
    process.send_signal(how)
    _, errors = process.communicate(timeout=30)
    if how == signal.SIGINT:
        assert process.returncode == 130
        assert errors.startswith("aliascope: interrupted")
    had = kept(tmp_path)
    (tmp_path / "images" / ".cut-short.1.exr").write_bytes(b"\x76\x2f\x31\x01")
    document = compare(tmp_path, *arguments, "--resume")
    assert document["reused"] == had >= 5
    embree = renderers.find("embree")
    seeded = [embree.seeded(renderers.mode_of(embree, mode)) for mode in modes]
    assert document["rendered"] == sum(SEEDS if each else PLACES for each in seeded) - had
    assert not list(tmp_path.glob("images/**/.*"))


def test_a_users_scene_gets_its_reference_made_once(tmp_path: Path) -> None:
    scene = tmp_path / "mine.toml"
    text = (places.SCENES / "edge.toml").read_text()
    scene.write_text(text.replace("0.9412", "0.5"))
    arguments = ("compare", scene, "-m", "uniform:n=4", "--size", "40x30", "-o", tmp_path / "out", "--json")
    first = run(*arguments)
    assert first.stderr == ""
    assert json.loads(first.stdout)["rows"][0]["scene"] == "mine"
    (made,) = (tmp_path / "out" / "references").rglob("*.exr")
    stamp = made.stat().st_mtime_ns
    assert run(*arguments).stderr == ""
    assert made.stat().st_mtime_ns == stamp
    scene.write_text(text.replace("0.9412", "0.6"))
    assert "was made for another version of the scene" in run(*arguments).stderr
    assert made.stat().st_mtime_ns > stamp


def test_a_reference_that_is_made_tells_how_far_it_is(tmp_path: Path) -> None:
    """On a terminal alone: what is made, how many pictures of it, the standard error now and at the end."""
    scene = tmp_path / "mine.toml"
    scene.write_text((places.SCENES / "discs.toml").read_text())
    arguments = ("compare", scene, "-m", "uniform:n=1,filter=tent", "--size", "6x4", "-o")
    assert run(*arguments, tmp_path / "quiet").stderr == ""
    terminal = run(*arguments, tmp_path / "out", terminal=True, env={**os.environ, "TERM": "xterm", "COLUMNS": "200"})
    told = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", terminal.stderr)
    assert re.search(r"/32 left .*reference of mine, 6 x 4 pixels, filter tent: standard error \d\.\de-", told), told
    assert re.search(r"standard error (\S+), (\S+) at the end", told)
    assert "probing embree" in told


def test_each_filter_is_judged_by_its_own_reference(tmp_path: Path) -> None:
    scene = tmp_path / "mine.toml"
    scene.write_text((places.SCENES / "discs.toml").read_text())
    modes = [f"uniform:n=256,filter={name}" for name in ("box", "mitchell")]
    document = compare(
        tmp_path / "out", str(scene), *(word for mode in modes for word in ("-m", mode)), "--size", "16x12"
    )
    rmse = {row["scene"]: row["metrics"]["rmse"] for row in document["rows"]}
    assert set(rmse) == {"mine", "mine, mitchell"}
    # Judged by the other's reference, either would be 0.02 off or more.
    assert max(rmse.values()) < 0.004


def test_a_scene_that_nothing_draws(tmp_path: Path) -> None:
    scene = tmp_path / "lit.toml"
    text = (places.SCENES / "spheres.toml").read_text()
    scene.write_text(text + "\n[transport]\ndiffuse_bounces = 1\n")
    arguments = ("compare", scene, "-r", "povray", "-r", "osmesa", "-m", "none")
    message = complaint(*arguments, "-o", tmp_path / "out", code=2)
    assert "no mode draws it: POV-Ray here does not draw: diffuse bounces" in message
    # A dry run ends as the run would, and says which cells stay empty.
    assert complaint(*arguments, "-o", tmp_path / "out", "--dry-run", code=2) == message
    dry = run(*arguments, "--dry-run", code=2).stdout.splitlines()
    assert dry[0] == "0 pictures"
    assert {line.partition(": ")[0] for line in dry[1:]} == {"empty lit"}
    cells = json.loads(run(*arguments, "--dry-run", "--json", code=2).stdout)["empty"]
    assert {(cell["scene"], cell["renderer"], cell["mode"]) for cell in cells} == {
        ("lit", "povray", "none"),
        ("lit", "osmesa", "none"),
    }
    assert all("diffuse bounces" in cell["reason"] for cell in cells)
    assert f"{PLACES} pictures\n" in run("compare", "edge", "-r", "osmesa", "-m", "none", "--dry-run").stdout


def test_one_draw_says_that_its_uncertainty_is_not_known(tmp_path: Path) -> None:
    """Of a scene that no exact method draws, a mode without seeds has one picture."""
    scene = tmp_path / "mine.toml"
    scene.write_text((places.SCENES / "edge.toml").read_text())
    modes = ("-m", "uniform:n=1,filter=tent,sampler=regular", "-m", "uniform:n=1,filter=tent", "-m", "none")
    document = compare(tmp_path / "out", str(scene), *modes, "--size", "8x6")
    told = [(row["uncertainty"], row["standard_errors"]["rmse"]) for row in document["rows"]]
    assert [uncertainty for uncertainty, _ in told].count(f"over {PLACES} places of the film") == 2
    assert [uncertainty for uncertainty, _ in told].count(f"over {SEEDS} seeds") == 1
    assert [error for uncertainty, error in told if uncertainty == "not known: one picture"] == [None]
