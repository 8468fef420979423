"""The history of regression runs: what is kept, that nothing is lost, which steps are found, what is said of them."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import math
import multiprocessing
import os
import sqlite3
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import complaint
from commands import run as command
from history_runs import EDGE, MACHINE, OTHER, VERSIONS, kept, observed, run
from scipy.stats import binom
from scipy.stats import t as student

from aliascope import history
from aliascope.errors import InvalidInput, NotWritable
from aliascope.regression.records import CellName, Observed, Run
from aliascope.store import Store
from aliascope.studies import history as study
from aliascope.studies import history_text
from aliascope.studies.history import Answer, Step
from aliascope.studies.history_series import Asked, in_order

DISCS = CellName("discs", "povray", "am1:depth=3")

# --- what is kept -----------------------------------------------------------------------------------------------------


def test_a_run_comes_back_as_it_was(tmp_path: Path) -> None:
    seen = observed(
        EDGE, (0.03, 0.05, 0.04), (0.5, 9.0, 0.6), 100, {"primary": 100, "shadow": 7}, versions={"embree": "4"}
    )
    made = run(0, {EDGE: seen, DISCS: "no reference"})
    (back,) = kept(tmp_path, [made])
    assert (back.started, back.wall_seconds, back.revision) == (made.started, made.wall_seconds, made.revision)
    assert (back.machine, back.versions, back.command) == (made.machine, made.versions, made.command)
    assert not back.passed
    edge, discs = back.cells
    assert edge.name == EDGE
    assert (edge.passed, edge.problem, edge.pictures) == (True, "", 3)
    assert edge.rmse.value == pytest.approx(math.sqrt((0.03**2 + 0.05**2 + 0.04**2) / 3), rel=1e-15)
    assert edge.rmse_of_each == (0.03, 0.05, 0.04)
    assert edge.cpu_seconds == 0.6  # the median, not the mean
    assert edge.cpu_seconds_of_each == (0.5, 9.0, 0.6)
    assert (edge.samples, edge.rays, edge.versions) == (100.0, {"primary": 100.0, "shadow": 7.0}, {"embree": "4"})
    assert (discs.passed, discs.problem, discs.rmse.value, discs.samples) == (False, "no reference", None, None)


def test_an_error_is_of_all_draws_or_not_there(tmp_path: Path) -> None:
    """Shifted pictures have none, NaN is none."""
    (back,) = kept(tmp_path, [run(0, {EDGE: observed(EDGE, (0.03, None)), DISCS: observed(DISCS, (0.03, math.nan))})])
    edge, discs = back.cells
    assert (edge.rmse.value, edge.rmse.standard_error) == (0.03, None)
    assert discs.rmse.value is None
    assert discs.rmse_of_each == (0.03, None)


def test_what_was_drawn_has_a_hash(tmp_path: Path) -> None:
    cells = [observed(EDGE), observed(EDGE, digest="another"), observed(EDGE, first_seed=5)]
    one, scene, draws = (
        each.cells[0] for each in kept(tmp_path, [run(i, {EDGE: cell}) for i, cell in enumerate(cells)])
    )
    assert one.subject != scene.subject
    assert one.draws == scene.draws
    assert (one.subject, len(one.draws)) == (draws.subject, 16)
    assert one.draws != draws.draws


def append(path: Path, first: int) -> None:
    for i in range(20):
        history.add(path, run(first + i, {EDGE: observed(EDGE), DISCS: observed(DISCS)}))


def test_processes_that_append_at_once_lose_nothing(tmp_path: Path) -> None:
    """From the making of the file on."""
    path = tmp_path / "new" / "history.sqlite"
    context = multiprocessing.get_context("fork")
    processes = [context.Process(target=append, args=(path, first)) for first in (0, 100, 200)]
    for process in processes:
        process.start()
    for process in processes:
        process.join(120)
    assert [process.exitcode for process in processes] == [0, 0, 0]
    runs = history.load(path)
    assert [each.revision for each in runs] == [f"{first + i:012x}" for first in (0, 100, 200) for i in range(20)]
    assert all(len(each.cells) == 2 for each in runs)
    assert list(path.parent.iterdir()) == [path]  # one file to be copied: no journal is left


def die_within(path: Path) -> None:
    """Ends without a word when the cells are half written."""
    connect = sqlite3.connect

    class Dying(sqlite3.Connection):
        def executemany(self, *arguments: Any) -> sqlite3.Cursor:
            super().executemany(*arguments)
            os._exit(9)

    history.sqlite3.connect = lambda *a, **k: connect(*a, factory=Dying, **k)  # type: ignore[attr-defined]
    history.add(path, run(7, {EDGE: observed(EDGE)}))


def test_an_append_is_whole_or_not_there(tmp_path: Path) -> None:
    path = tmp_path / "history.sqlite"
    history.add(path, run(0, {EDGE: observed(EDGE)}))
    process = multiprocessing.get_context("fork").Process(target=die_within, args=(path,))
    process.start()
    process.join(60)
    assert process.exitcode == 9
    twice = dataclasses.replace(run(1, {EDGE: observed(EDGE)}), cells=run(1, {EDGE: observed(EDGE)}).cells * 2)
    with pytest.raises(sqlite3.IntegrityError):
        history.add(path, twice)
    assert [each.revision for each in history.load(path)] == [f"{0:012x}"]
    history.add(path, run(2, {EDGE: observed(EDGE)}))
    assert len(history.load(path)) == 2


def test_a_newer_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "history.sqlite"
    history.add(path, run(0, {}))
    with sqlite3.connect(path) as database:
        database.execute(f"PRAGMA user_version = {history.SCHEMA_VERSION + 1}")
    database.close()
    for act in (lambda: history.load(path), lambda: history.add(path, run(1, {}))):
        with pytest.raises(InvalidInput, match=f"schema {history.SCHEMA_VERSION + 1}, this version knows"):
            act()


def test_what_is_no_history_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "history.sqlite"
    with pytest.raises(InvalidInput, match="there is no history"):
        history.load(path)
    path.write_bytes(b"no database at all, but long enough to be one" * 100)
    with Store(tmp_path / "results.sqlite"):
        pass
    for other in (path, tmp_path / "results.sqlite"):
        for act in (lambda other=other: history.load(other), lambda other=other: history.add(other, run(1, {}))):
            with pytest.raises(InvalidInput, match="is not a history of regression runs"):
                act()
    with pytest.raises(NotWritable):
        history.add(path / "below-a-file" / "history.sqlite", run(1, {}))


# --- steps ------------------------------------------------------------------------------------------------------------


def steps(folder: Path, runs: Sequence[Run], asked: Asked | None = None) -> tuple[Step, ...]:
    return answered(folder, runs, asked).steps


def answered(folder: Path, runs: Sequence[Run], asked: Asked | None = None) -> Answer:
    return study.answer(kept(folder, runs), asked or Asked())


def of_errors(values: Sequence[float], **more: Any) -> list[Run]:
    """Runs of one mode whose two draws have these errors, times 1 and 2."""
    return [run(i, {EDGE: observed(EDGE, (value, 2.0 * value), **more)}) for i, value in enumerate(values)]


def test_one_other_figure_after_three_is_a_step_by_definition(tmp_path: Path) -> None:
    runs = of_errors([0.1, 0.1, 0.1, 0.1 * (1.0 + 1e-15)])
    (step,) = steps(tmp_path, runs)
    assert (step.series.metric, step.before, step.at, step.after, step.p_value) == ("rmse", 2, 3, 3, None)
    assert step.series.kind == "exact"
    assert steps(tmp_path, of_errors([0.1] * 4)) == ()
    assert steps(tmp_path, of_errors([0.1, 0.1, 0.1 * (1.0 + 1e-15)])) == ()  # two have not told that it is exact


def test_each_change_of_an_exact_figure_is_a_step(tmp_path: Path) -> None:
    found = steps(tmp_path, of_errors([0.1, 0.1, 0.1, 0.2, 0.3, 0.3, 0.3, 0.3]))
    assert [(step.at, round(step.ratio or 0.0, 12)) for step in found] == [(4, 1.5), (3, 2.0)]  # newest first


def test_figures_that_are_never_the_same_are_not_exact(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).normal(1.0, 0.01, 20)
    assert steps(tmp_path, of_errors((0.1 * noise).tolist())) == ()


def test_the_interval_is_over_draws(tmp_path: Path) -> None:
    """The delta method on the mean squares of pairs, by hand."""
    old, new = (0.1, 0.2, 0.3), (0.11, 0.2, 0.34)
    runs = [run(i, {EDGE: observed(EDGE, old if i < 3 else new, (1.0,) * 3)}) for i in range(4)]
    (step,) = steps(tmp_path, runs)
    a, b = (np.square(each) for each in (old, new))
    ratio = math.sqrt(b.mean() / a.mean())
    half = student.ppf(0.975, 2) * (b / b.mean() / 2.0 - a / a.mean() / 2.0).std(ddof=1) / math.sqrt(3)
    assert step.ratio == pytest.approx(ratio, rel=1e-12)
    assert step.interval == pytest.approx((ratio * math.exp(-half), ratio * math.exp(half)), rel=1e-12)


def test_samples_and_rays_are_exact_from_the_first(tmp_path: Path) -> None:
    cells = [observed(EDGE), observed(EDGE, samples=101, rays={"primary": 101, "shadow": 5})]
    found = steps(tmp_path, [run(i, {EDGE: cell}) for i, cell in enumerate(cells)])
    assert [step.series.metric for step in found] == ["samples", "rays-shadow"]
    assert found[0].ratio == pytest.approx(1.01)
    assert found[1].ratio is None  # from none


def test_rays_that_only_repeat_the_samples_are_no_series(tmp_path: Path) -> None:
    metrics = {one.metric for one in answered(tmp_path, [run(0, {EDGE: observed(EDGE)})]).series}
    assert metrics == {"rmse", "cpu-seconds", "samples"}


def test_machines_may_round_otherwise(tmp_path: Path) -> None:
    def on(machines: str, values: Sequence[float]) -> list[Run]:
        made = of_errors(values)
        return [
            dataclasses.replace(r, machine=OTHER if m == "B" else MACHINE) for m, r in zip(machines, made, strict=True)
        ]

    own, other = 0.1, 0.1 * (1.0 + 1e-5)
    assert steps(tmp_path, on("AAABAB", [own, own, own, other, own, other])) == ()
    (step,) = steps(tmp_path, on("AAAB", [own, own, own, 0.1 * (1.0 + 1.1e-3)]))  # more than rounding
    assert step.also == ("machine",)
    # A step that each machine sees is one step, and the runs of both narrow it.
    (step,) = steps(tmp_path, on("AAABBAB", [own, own, own, other, 0.2, 0.2 * (1.0 + 1e-6), 0.2]))
    assert (step.before, step.at) == (3, 4)
    # A change of the last digit on the machine's own figures is one.
    assert len(steps(tmp_path, on("AAABA", [own, own, own, other, other]))) == 1


def test_what_else_changed_is_said(tmp_path: Path) -> None:
    runs = of_errors([0.1, 0.1, 0.1, 0.2])
    (step,) = steps(tmp_path, [*runs[:3], dataclasses.replace(runs[3], versions={"embree": "4.0"})])
    assert step.also == ("embree 3.13.5 → 4.0",)
    other = run(3, {EDGE: observed(EDGE, (0.2, 0.4), digest="redrawn")}, machine={**MACHINE, "system": "Linux 6.2"})
    (step,) = steps(tmp_path, [*runs[:3], other])
    assert step.also == ("scene, size or filter", "system Linux 6.1 → Linux 6.2")


def test_other_seeds_give_other_errors_which_is_no_step(tmp_path: Path) -> None:
    draws = np.random.default_rng(5).normal(0.1, 0.01, (2, 16))

    def of(seeds: int, factor: float) -> Observed:
        return observed(EDGE, (factor * draws[seeds]).tolist(), (1.0,) * 16, first_seed=100 * seeds)

    def found(factor: float) -> tuple[Step, ...]:
        cells = [of(0, 1.0)] * 3 + [of(1, factor)] * 3
        return steps(tmp_path, [run(i, {EDGE: cell}) for i, cell in enumerate(cells)])

    assert found(1.0) == ()
    (step,) = found(1.2)  # of a standard error of 4 %
    assert step.also == ("seeds or shifts",)
    assert step.p_value is not None
    assert step.p_value < 0.01
    assert step.interval is not None
    assert 1.0 < step.interval[0] < (step.ratio or 0.0) < step.interval[1]


def timed(values: Sequence[float], machines: Sequence[Mapping[str, str]] | None = None) -> list[Run]:
    cells = [observed(EDGE, seconds=(value, value)) for value in values]
    machines = machines or [MACHINE] * len(values)
    return [run(i, {EDGE: cell}, machine=machines[i]) for i, cell in enumerate(cells)]


def test_a_time_that_goes_up_is_a_step(tmp_path: Path) -> None:
    noise = np.random.default_rng(2).normal(1.0, 0.02, 24)
    values = np.where(np.arange(24) < 14, 1.0, 1.3) * noise
    values[5] = 7.0  # once, the machine was busy
    (step,) = steps(tmp_path, timed(values.tolist()))
    assert (step.series.metric, step.series.machine) == ("cpu-seconds", "One, 2 cores")
    assert step.before < step.at <= step.after
    assert step.at == 14
    assert step.p_value is not None
    assert step.p_value < 0.01
    assert step.interval is not None
    assert step.interval[0] < 1.3 < step.interval[1]
    assert step.ratio == pytest.approx(1.3, abs=0.03)  # three standard errors of the noise's mean


def test_times_are_compared_on_one_machine_only(tmp_path: Path) -> None:
    noise = np.random.default_rng(3).normal(1.0, 0.02, 24)
    slow = np.where(np.arange(24) < 12, 1.0, 3.0) * noise
    machines = [MACHINE] * 12 + [OTHER] * 12
    assert steps(tmp_path, timed(slow.tolist(), machines)) == ()
    assert len(steps(tmp_path, timed(slow.tolist()))) == 1


def many(generator: np.random.Generator, runs: int, modes: int, factor: float) -> list[Run]:
    """Times of several modes, `factor` more from the half on."""
    names = [CellName("edge", "embree", f"uniform:n={i}") for i in range(1, modes + 1)]
    return [
        run(
            i,
            {
                name: observed(name, seconds=(t := (factor if 2 * i >= runs else 1.0) * generator.normal(1, 0.05), t))
                for name in names
            },
        )
        for i in range(runs)
    ]


def test_all_modes_together_tell_sooner(tmp_path: Path) -> None:
    """5 % more, which the noise of each mode is as large as."""
    found = steps(tmp_path, many(np.random.default_rng(4), 20, 12, 1.05))
    assert [(step.series.name.scene, step.series.name.mode) for step in found][:1] == [("all scenes", "all modes")]
    assert found[0].before < 10 <= found[0].after
    assert found[0].ratio == pytest.approx(1.05, abs=0.02)


def test_a_history_without_changes_shows_none(tmp_path: Path) -> None:
    """One in a hundred may; the limit is passed by those that do so once in 1,000."""
    generator = np.random.default_rng(6)
    names = [CellName("edge", "embree", f"uniform:n={i}") for i in range(1, 5)]
    template = kept(tmp_path, [run(i, {name: observed(name) for name in names}) for i in range(16)])
    alarms = 0
    for _ in range(100):
        busy = np.where(generator.random(16) < 0.1, 2.0, 1.0)
        runs = [
            dataclasses.replace(
                each,
                cells=tuple(
                    dataclasses.replace(cell, cpu_seconds=float(busy[i] * generator.lognormal(0.0, 0.05)))
                    for cell in each.cells
                ),
            )
            for i, each in enumerate(template)
        ]
        alarms += bool(study.answer(runs, Asked()).steps)
    assert alarms <= binom.ppf(0.999, 100, study.SIGNIFICANCE)


def test_runs_are_in_the_order_of_time_and_revision(tmp_path: Path) -> None:
    """A revision that is run again stands beside its first run; a tree with changes is another each time."""
    days = [(4, "bbb"), (2, "bbb"), (0, "aaa"), (5, "aaa"), (1, "aaa+"), (6, "aaa+"), (3, "unknown"), (7, "unknown")]
    runs = in_order(kept(tmp_path, [run(day, {}, revision=name) for day, name in days]))
    found = [(run.revision, int(run.started[8:10]) - 1) for run in runs]
    assert found == [
        *(("aaa", 0), ("aaa", 5), ("aaa+", 1), ("bbb", 2), ("bbb", 4)),
        *(("unknown", 3), ("aaa+", 6), ("unknown", 7)),
    ]


# --- what is said -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A history with steps in error and time, and a mode that failed once."""
    made = tmp_path_factory.mktemp("regress")
    noise = np.random.default_rng(7).normal(1.0, 0.02, 24)
    for i in range(24):
        edge = observed(EDGE, (0.1, 0.2) if i < 9 else (0.11, 0.21), (0.5, 0.5))
        time = (1.0 if i < 14 else 1.3) * float(noise[i])
        discs: Observed | str = observed(DISCS, (0.05, None), (time, time)) if i != 3 else "it <hung> & was ended"
        history.add(made / "history.sqlite", run(i, {EDGE: edge, DISCS: discs}, failed=(EDGE,) if i == 9 else ()))
    return made


def test_the_text_says_what_changed_where_and_by_how_much(folder: Path) -> None:
    lines = command("history", "-o", folder).stdout.splitlines()
    assert lines[0] == ("24 runs of 24 revisions on 1 machine, 2026-01-01 to 2026-01-24; 2 modes on 2 scenes; 2 steps.")
    at = [i for i, line in enumerate(lines) if line.startswith("between ")]
    assert lines[at[0]].endswith("1 step")
    assert "cpu-seconds  discs/povray/am1:depth=3" in lines[at[0] + 1]
    assert " p = " in lines[at[0] + 1]
    assert lines[at[1]] == f"between {8:012x} and {9:012x} (2026-01-09, 2026-01-10): 1 step"
    assert lines[at[1] + 1].split()[:2] == ["rmse", EDGE.text]
    assert "0.1581 → 0.1676  +6.0 % [" in lines[at[1] + 1]
    assert lines[at[1] + 1].endswith("exact")
    assert "with 0.01 as the chance of a false alarm in all together" in "\n".join(lines)
    assert lines[-1] == str(folder / "history.html")


def test_json_and_csv_have_all_figures(folder: Path) -> None:
    document = json.loads(command("history", "-o", folder, "--json").stdout)
    assert len(document["runs"]) == 24
    assert document["runs"][9]["failed_cells"] == [EDGE.text]
    time, error = document["steps"]
    assert (error["metric"], error["exact"], error["p_value"]) == ("rmse", True, None)
    assert error["before"] == {"run": 8, "revision": f"{8:012x}"}
    assert error["interval"][0] < error["ratio"] < error["interval"][1]
    assert (time["metric"], time["machine"], time["exact"]) == ("cpu-seconds", "One, 2 cores", False)
    points = sum(len(one["points"]) for one in document["series"])
    values = list(csv.DictReader(io.StringIO((folder / "history" / "values.csv").read_text())))
    assert len(values) == points == 24 * 3 + 23 * 3
    assert {float(row["value"]) for row in values if row["metric"] == "samples"} == {100.0}
    kept_steps = list(csv.DictReader(io.StringIO((folder / "history" / "steps.csv").read_text())))
    assert [row["metric"] for row in kept_steps] == ["cpu-seconds", "rmse"]
    assert float(kept_steps[1]["ratio"]) == error["ratio"]


def test_the_page_is_the_same_again_and_whole(folder: Path, tmp_path: Path) -> None:
    for out in (tmp_path / "one", tmp_path / "two"):
        command("history", "--from", folder / "history.sqlite", "-o", out)
    names = ["history.html", "history/edge.svg", "history/discs.svg", "history/values.csv", "history/steps.csv"]
    for name in names:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    text = (tmp_path / "one" / "history.html").read_text()
    assert "http://" not in text.replace("http://www.w3.org/", "")
    assert "https://" not in text
    assert not (tmp_path / "one" / "history.sqlite").exists()


def test_one_chooses_scene_renderer_mode_and_metric(folder: Path, tmp_path: Path) -> None:
    def chosen(*words: str) -> set[tuple[str, str]]:
        out = command("history", *words, "--from", folder / "history.sqlite", "-o", tmp_path, "--json").stdout
        return {(one["scene"], one["metric"]) for one in json.loads(out)["series"]}

    assert chosen("edge", "--metric", "rmse") == {("edge", "rmse")}
    assert chosen("-r", "pov*", "--metric", "s*") == {("discs", "samples")}
    assert chosen("-m", "am1:*", "--metric", "cpu-seconds") == {("discs", "cpu-seconds")}


def test_complaints(folder: Path, tmp_path: Path) -> None:
    assert "there is no history; aliascope regress makes one" in complaint("history", cwd=tmp_path, code=2)
    for words, said in (
        (["edgy"], 'unknown scene "edgy"; did you mean "edge"?'),
        (["-r", "povrat"], 'unknown renderer "povrat"; did you mean "povray"?'),
        (["-m", "am9"], 'unknown mode "am9"'),
        (["--metric", "rms"], 'unknown metric "rms"; did you mean "rmse"?'),
    ):
        assert said in complaint("history", *words, "-o", folder, code=2)
    history.add(tmp_path / "history.sqlite", run(0, {}))
    with sqlite3.connect(tmp_path / "history.sqlite") as database:
        database.execute("DELETE FROM run")
    database.close()
    assert "no runs yet" in complaint("history", "-o", tmp_path, code=2)


def test_figures_are_said_with_the_digits_that_they_need() -> None:
    assert history_text.percent(1.102) == "+10.2 %"
    assert history_text.percent(0.93) == "-7.0 %"
    assert history_text.percent(1.0 + 2e-6) == "+0.0002 %"
    assert history_text.percent(12.0) == "×12"
    assert history_text.figure(0.123456789, 0.12345) == "0.12346"
    assert history_text.figure(196608.0, 221184.0) == "196,608"


def test_one_run_is_a_history_too(tmp_path: Path) -> None:
    history.add(tmp_path / "history.sqlite", run(0, {EDGE: observed(EDGE)}))
    out = command("history", "-o", tmp_path).stdout
    assert out.startswith("1 run of 1 revision on 1 machine, 2026-01-01; 1 mode on 1 scene; no steps.")
    assert "too few runs" in out
    assert VERSIONS["embree"] in (tmp_path / "history.html").read_text()
