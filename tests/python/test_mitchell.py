"""Mitchell's table of random edges: its figures, the slopes, the half count, the search, samplers and hardware."""

from __future__ import annotations

import csv
import itertools
import json
import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import complaint, run, separately

from aliascope.errors import InvalidInput, SpecError
from aliascope.native import discrepancy, samplers
from aliascope.records import Estimate
from aliascope.report.teaching import spread_out
from aliascope.studies import hardware_search, mitchell, mitchell_hardware, mitchell_samplers, mitchell_search
from aliascope.studies.mitchell import COUNTS, Options, with_half_count
from aliascope.studies.realisations import STEP, Asked, measure_all

PUBLISHED = {  # the lecture's page "Low-Discrepancy Patterns", typed from it a second time
    "zaremba": [0.0504, 0.00478, 0.00111],
    "jittered": [0.0538, 0.00595, 0.00146],
    "poisson-disk": [0.0613, 0.00767, 0.00241],
    "n-rooks": [0.0637, 0.0123, 0.00488],
    "random": [0.0924, 0.0224, 0.00866],
}
REALISATIONS = 256  # a standard error of 1.9% where it is largest, at random points
SIGMAS = 4.5  # two-sided significance 7e-6 of each of some ten comparisons
PLUGIN = Path(__file__).parents[2] / ".build/plugins/kronecker.so"
Cells = dict[tuple[str, int], dict[str, Any]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("mitchell")


@pytest.fixture(scope="module")
def document(folder: Path) -> dict[str, Any]:
    result = run("mitchell", "--realisations", str(REALISATIONS), "--json", "-o", folder)
    found: dict[str, Any] = json.loads(result.stdout)
    return found


@pytest.fixture(scope="module")
def cells(document: dict[str, Any]) -> Cells:
    return {(cell["process"], cell["n"]): cell for cell in document["cells"]}


# --- the lecture's table ----------------------------------------------------------------------------------------------


def test_the_contract(document: dict[str, Any], cells: Cells) -> None:
    assert list(cells) == [(process, n) for process in PUBLISHED for n in COUNTS]
    for (process, n), cell in cells.items():
        assert cell["published"] == PUBLISHED[process][COUNTS.index(n)]
        assert cell["ratio"] == pytest.approx(cell["mean"] / cell["published"], rel=1e-15)
        assert cell["realisations"] == (1 if process == "zaremba" else REALISATIONS)
        assert (cell["standard_error"] == 0.0) == (process == "zaremba")
        assert cell["mean"] == cell["plain"]["mean"]
    assert document["half_count"] is False
    assert set(document["notes"]) == {"reproduced", "fitted", "unknown", "searched"}


def test_a_cell_is_the_root_mean_square_over_seeds(cells: Cells) -> None:
    """By seeds from 0, which `aliascope points --seed` has too; its error by the delta method."""
    values = [
        discrepancy.measure("edge-rms", samplers.points("n-rooks:corner=1", 16, 2, seed)).value
        for seed in range(REALISATIONS)
    ]
    squares = np.square(values)
    cell = cells["n-rooks", 16]
    assert cell["mean"] == pytest.approx(math.sqrt(squares.mean()), rel=1e-13)  # sums of 256, in another order
    error = squares.std(ddof=1) / math.sqrt(REALISATIONS) / (2.0 * cell["mean"])
    assert cell["standard_error"] == pytest.approx(error, rel=1e-11)


def test_random_and_jittered_have_their_closed_forms(cells: Cells) -> None:
    for process, exponent in (("random", -0.5), ("jittered", -0.75)):
        for n in COUNTS:
            cell = cells[process, n]
            assert cell["closed_form"] == pytest.approx(0.361042 * n**exponent, rel=2e-6)  # of six digits
            assert abs(cell["mean"] - cell["closed_form"]) < SIGMAS * cell["standard_error"]
    assert cells["zaremba", 16]["closed_form"] is None


def test_the_published_table_is_reproduced(cells: Cells) -> None:
    """Where there is a closed form, it is compared: that is without chance. The others' chance is 1% at these seeds."""

    def off(process: str, n: int, half_count: bool) -> float:
        cell = cells[process, n]
        value = cell["closed_form"] or cell["mean"]
        return abs((math.hypot(value, 0.5 / n) if half_count else value) / cell["published"] - 1.0)

    assert max(off("random", n, False) for n in COUNTS) < 0.07
    for process in ("zaremba", "jittered", "n-rooks"):
        assert max(off(process, n, False) for n in COUNTS[1:]) < 0.11
    for process in PUBLISHED:
        assert max(off(process, n, True) for n in COUNTS) < (0.15 if process == "poisson-disk" else 0.05)
    for n in COUNTS:
        assert sorted(PUBLISHED, key=lambda process: cells[process, n]["mean"]) == list(PUBLISHED)


def test_slopes(document: dict[str, Any], cells: Cells) -> None:
    for each in document["slopes"]:
        process = each["process"]
        found = np.polyfit(np.log(COUNTS), np.log([cells[process, n]["mean"] for n in COUNTS]), 1)[0]
        assert each["slope"] == pytest.approx(found, rel=1e-12)
        published = np.polyfit(np.log(COUNTS), np.log(PUBLISHED[process]), 1)[0]
        assert each["published"] == pytest.approx(published, rel=1e-12)
        if each["closed_form"]:
            assert abs(each["slope"] - each["closed_form"]) < SIGMAS * each["standard_error"]


def test_the_slope_has_the_error_that_its_figures_leave() -> None:
    """Against the spread over 2,000 drawn sets of figures, which is good to 1.6%: four of those."""
    estimates = [Estimate(1.0, 0.02), Estimate(0.2, 0.003), Estimate(0.1, 0.002)]
    random = np.random.default_rng(3)
    drawn = np.array([random.normal(each.value or 0.0, each.standard_error or 0.0, 2000) for each in estimates])
    spread = np.polyfit(np.log(COUNTS), np.log(drawn), 1)[0].std(ddof=1)
    assert mitchell.slope(COUNTS, estimates).standard_error == pytest.approx(spread, rel=4 * 0.016)


def test_half_count_is_shown_in_mean_and_ratio(cells: Cells) -> None:
    found = json.loads(run("mitchell", "--half-count", "--realisations", "2", "--json").stdout)
    assert found["half_count"] is True
    for cell in found["cells"]:
        plain = cell["plain"]["mean"]
        assert cell["mean"] == pytest.approx(math.sqrt(plain**2 + 1 / (4 * cell["n"] ** 2)), rel=1e-14)
        assert cell["ratio"] == pytest.approx(cell["mean"] / cell["published"], rel=1e-14)
        if cell["process"] == "zaremba":
            assert plain == cells["zaremba", cell["n"]]["mean"]
    # d sqrt(x^2 + c) = x / sqrt(x^2 + c) dx
    assert with_half_count(Estimate(3.0, 0.5), 1).standard_error == pytest.approx(0.5 * 3.0 / math.sqrt(9.25))


def test_realisations_go_on_until_the_standard_error_is_small() -> None:
    asked = [Asked("jittered", 16, "edge-rms", True, share, None) for share in (0.007, 0.02)]
    for one, found in zip(asked, measure_all(asked, 0, 2), strict=True):
        assert found.estimate.value is not None
        assert found.estimate.standard_error is not None
        assert found.estimate.standard_error < one.share * found.estimate.value
        assert len(found.values) % STEP == 0
    assert len(measure_all(asked[:1], 0, 1)[0].values) > 64  # so that the rule of going on was at work


def test_threads_change_nothing() -> None:
    options = [Options(realisations=33, columns=("edge-mean:draws=64",), threads=threads) for threads in (1, 3)]
    found = [
        mitchell.measured([mitchell.Cell("random", "random", 16, 16)], 0.5, each, None)[0].columns for each in options
    ]
    assert found[0] == found[1]
    adaptive = Asked("random", 16, "edge-rms", True, 0.03, None)
    assert measure_all([adaptive], 5, 1) == measure_all([adaptive], 5, 3)


def test_chosen_columns_are_means_over_realisations() -> None:
    options = Options(realisations=3, columns=("star", "half-plane"), threads=1)
    (cell,) = mitchell.measured([mitchell.Cell("random", "random", 16, 16)], 0.5, options)
    for spec in options.columns:
        values = [discrepancy.measure(spec, samplers.points("random", 16, 2, seed)).value for seed in range(3)]
        assert cell.columns[spec].estimate.value == pytest.approx(np.mean(values), rel=1e-14)
        assert cell.columns[spec].estimate.standard_error == pytest.approx(np.std(values, ddof=1) / math.sqrt(3))
    assert mitchell.columns_of(["star,edge-mean:draws=64,edges=chord"]) == ("star", "edge-mean:draws=64,edges=chord")
    with pytest.raises(InvalidInput, match="what the table shows"):
        mitchell.columns_of(["edge-rms"])
    with pytest.raises(SpecError, match="did you mean"):
        mitchell.columns_of(["sta"])


def test_help_has_an_example() -> None:
    assert "Example: aliascope mitchell" in run("mitchell", "--help").stdout


def test_one_realisation_has_no_error() -> None:
    text = run("mitchell", "--realisations", "1", "--column", "edge-max:draws=16").stdout
    assert "unknown" in text
    assert "edge-max:draws=16" in text


# --- what is written --------------------------------------------------------------------------------------------------


def test_files_have_the_figures(folder: Path, document: dict[str, Any], cells: Cells) -> None:
    assert json.loads((folder / "mitchell.json").read_text()) == document
    with (folder / "mitchell.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        cell = cells[row["process"], int(row["points"])]
        assert [float(row[key]) for key in ("mean", "standard_error", "published", "ratio")] == [
            cell[key] for key in ("mean", "standard_error", "published", "ratio")
        ]
    assert len(rows) == len(cells)
    for process, n in cells:
        points = np.loadtxt(folder / "points" / f"{process}-{n}.csv", delimiter=",")
        assert np.array_equal(points, samplers.points(cells[process, n]["generator"], n, 2, 0))
    for svg in (folder / "plots").glob("*.svg"):
        assert ElementTree.parse(svg).getroot().tag.endswith("svg")
    assert {path.name for path in (folder / "plots").iterdir()} == {
        *("mitchell.svg", "mitchell.csv", "points.svg"),
        *(f"spectra-{n}.{kind}" for n in (256, 1600) for kind in ("svg", "csv")),
    }


def test_labels_are_moved_apart_as_little_as_can_be() -> None:
    assert spread_out([3.0, 1.0, 1.5], 1.0, 0.0, 10.0) == pytest.approx([3.0, 0.75, 1.75])
    assert spread_out([9.9, 9.8], 1.0, 0.0, 10.0) == pytest.approx([10.0, 9.0])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--table", "lectur"], "did you mean"),
        (["--table", "hardware", "--realisations", "3"], "fixed sets"),
        (["--search", "--half-count"], "tries both"),
        (["--search", "--column", "star"], "statistics of its own"),
        (["--search", "--table", "samplers"], "leave --table out"),
        (["--column", "sta"], "did you mean"),
    ],
)
def test_refused(options: list[str], said: str) -> None:
    assert said in complaint("mitchell", *options, code=2)


def test_a_folder_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    assert "cannot be written" in complaint("mitchell", "--table", "hardware", "-o", tmp_path / "taken", code=4)


# --- the search -------------------------------------------------------------------------------------------------------


def test_the_search_finds_the_nearest(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(mitchell_search, "DRAWS", 64)
    monkeypatch.setattr(mitchell_search, "DRAWS_OF_ONE", 64)
    few = {name: made[:2] for name, made in mitchell_search.GENERATORS.items()}
    monkeypatch.setattr(mitchell_search, "GENERATORS", few)
    found = mitchell_search.search(3, 0, 2)
    assert len(found) == 4 * 4 * 2
    assert [each.misfit for each in found] == sorted(each.misfit for each in found)
    assert found == mitchell_search.search(3, 0, 1)
    for each in found:
        logs = {
            fit.generator: np.log([f.value or 0.0 for f in fit.figures]) - np.log(PUBLISHED[fit.process])
            for fit in each.fits
        }
        best = [min(made, key=lambda generator: float(np.square(logs[generator]).mean())) for made in few.values()]
        assert [fit.generator for fit in each.best] == best
        assert each.misfit == pytest.approx(np.sqrt(np.mean([np.square(logs[name]) for name in best])), rel=1e-12)
    (chosen,) = [each for each in found if (each.edges, each.statistic, each.half_count) == ("chord", "rms", True)]
    fit = next(fit for fit in chosen.fits if fit.generator == "jittered")
    values = [
        discrepancy.measure("edge-rms:edges=chord,draws=64", samplers.points("jittered", 256, 2, seed), seed).value
        for seed in range(3)
    ]
    assert fit.figures[1].value == pytest.approx(math.sqrt(np.square(values).mean() + 0.25 / 256**2), rel=1e-13)
    json.dumps(mitchell_search.document(found, 3, 0), allow_nan=False)
    assert "The nearest" in "\n".join(mitchell_search.lines(found, 3))


# --- samplers and hardware --------------------------------------------------------------------------------------------


def test_every_sampler_has_a_row_or_a_reason(folder: Path) -> None:
    arguments = ["--plugin", PLUGIN, "mitchell", "--table", "samplers", "--realisations", "2", "--json", "-o", folder]
    found = json.loads(separately(*arguments).stdout)["cells"]
    names = {cell["process"].split(":")[0] for cell in found}
    assert names == {info.name for info in samplers.registered()} | {"kronecker"}
    for cell in found:
        if "reason" in cell:
            assert (cell["mean"], cell["n"]) == (None, None)
        else:
            assert samplers.refusal(cell["process"], cell["n"]) is None if cell["process"] != "kronecker" else True
            assert cell["mean"] > 0.0
    at = {(cell["process"], cell.get("asked", cell["n"])): cell for cell in found if cell["mean"]}
    points = samplers.points("sobol", 256)
    assert at["sobol", 256]["mean"] == discrepancy.measure("edge-rms", points).value
    assert at["sobol", 256]["published"] is None
    assert (folder / "samplers.html").is_file()


def test_the_nearest_count_is_that_by_ratio() -> None:
    assert mitchell_samplers.nearest_count("lattice", 16) == (13, "")  # 16/13 < 21/16
    assert mitchell_samplers.nearest_count("orthogonal-array", 1600) == (1681, "")  # 41^2; 1600 = 40^2, no prime power
    assert mitchell_samplers.nearest_count("sgi-8x8", 16) == (8, "")
    n, reason = mitchell_samplers.nearest_count("sgi-8x8", 256)
    assert n is None
    assert "not of 256" in reason
    assert "weight" in mitchell_samplers.nearest_count("gauss-legendre", 16)[1]


def test_the_hardware_table() -> None:
    found = json.loads(run("mitchell", "--table", "hardware", "--json").stdout)["cells"]
    at = {(cell["process"], cell["n"]): cell for cell in found if cell["mean"] is not None}
    for n in (1, 2, 4, 8, 16):
        for process in ("standard-msaa", "8x8-edge-rms", "8x8-half-plane"):
            cell = at[process, n]
            points = np.array(cell["points"])
            assert len(np.unique(points, axis=0)) == n
            assert cell["mean"] == discrepancy.measure("edge-rms", points).value
            assert cell["columns"]["half-plane"]["mean"] == discrepancy.measure("half-plane", points).value
        if n < 16:
            known = discrepancy.measure("edge-rms", samplers.points("sgi-8x8", n)).value
            assert at["8x8-edge-rms", n]["mean"] == pytest.approx(known, rel=1e-12)
    assert at["regular", 4]["columns"]["half-plane"]["mean"] == pytest.approx(0.25)  # 1/(2k)


def test_half_count_in_the_other_tables_too(tmp_path: Path) -> None:
    text = run("mitchell", "--table", "hardware", "--half-count", "-o", tmp_path).stdout
    value = discrepancy.measure("edge-rms", samplers.points("regular", 4)).value
    shown = f"{math.hypot(value, 1 / 8):.4g}"
    for where in (text, (tmp_path / "hardware.html").read_text()):
        assert shown in where
        assert "half a count added" in where


@pytest.mark.parametrize("measure", ["edge-rms", "half-plane"])
def test_no_set_of_the_grid_is_better(measure: str) -> None:
    """Of two cells all sets; of more, sets that differ from the best in one cell, and random ones with few a row."""
    for n in (2, 4, 8, 16):
        best = mitchell_hardware.SETS[measure, n][1]
        least = discrepancy.measure(measure, hardware_search.centres(best)).value
        random = np.random.default_rng(n)
        others = itertools.combinations(range(64), 2) if n == 2 else _others(best, random)
        for cells in others:
            assert discrepancy.measure(measure, hardware_search.centres(cells)).value > least - 1e-12


def _others(best: tuple[int, ...], random: np.random.Generator) -> list[tuple[int, ...]]:
    n = len(best)
    free = [cell for cell in range(64) if cell not in best]
    found = [(*best[:i], other, *best[i + 1 :]) for i in range(n) for other in free[:: max(1, n // 4)]]
    for _ in range(300):
        columns = np.concatenate([random.permutation(8) for _ in range(max(1, n // 8))])[:n]
        found.append(tuple(int(8 * (i % 8) + x) for i, x in enumerate(columns)))
    return [cells for cells in found if len(set(cells)) == n]


def test_the_search_leaves_out_what_cannot_be_the_best() -> None:
    """Every set keeps the demands of its own discrepancy; and there are as many pairs of halves as matrices of zeros
    and ones with two a row and column (OEIS A001499)."""
    random = np.random.default_rng(8)
    made = 0
    while made < 20:
        columns = np.concatenate([random.permutation(8), random.permutation(8)])
        cells = {int(8 * (i % 8) + x) for i, x in enumerate(columns)}
        if len(cells) < 16:
            continue
        made += 1
        value = discrepancy.measure("half-plane", hardware_search.centres(cells)).value
        bits = hardware_search.mask(cells)
        for of, fewest, most in hardware_search.demands(16, value):
            assert fewest <= int(np.bitwise_count(bits & of)) <= most
    _, codes = hardware_search.half_sets()
    values, counts = np.unique(codes, return_counts=True)
    paired = dict(zip(values.tolist(), counts.tolist(), strict=True))
    whole = sum(2 * 3**x for x in range(8))
    assert sum(count * paired.get(whole - code, 0) for code, count in paired.items()) == 187_530_840


def test_descents_come_to_the_exhaustive_best_of_eight() -> None:
    value, cells, hits = hardware_search.best_edge_rms(8, 100)
    assert value == pytest.approx(discrepancy.measure("edge-rms", samplers.points("sgi-8x8", 8)).value, rel=1e-12)
    assert hits > 0
    assert cells == hardware_search.first_image(cells)
