"""The command stability: what breaks, crashes, hangs, declines or is not there is in its map, and loses itself only."""

from __future__ import annotations

import csv
import functools
import io
import json
import math
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import complaint, run
from rich.console import Console

from aliascope.errors import InvalidInput
from aliascope.stability import running
from aliascope.stability.records import Cell, Probe, Reading
from aliascope.studies import stability, stability_files, stability_page, stability_text
from aliascope.studies.stability import Asked, Map

PACKAGE = "fake_probes"
SOUND = ("steady", "broken", "declining", "crashing")
"""The modules that end soon."""


def only(monkeypatch: pytest.MonkeyPatch, modules: Iterable[str]) -> None:
    """Has the command find these modules."""
    names = [f"{PACKAGE}.{module}" for module in modules]
    monkeypatch.setattr(running, "modules", lambda package: sorted(names))


def silent(what: str | None, done: int, total: int) -> None:
    pass


@pytest.fixture(scope="module")
def found() -> Map:
    """Everything that ends, and what does not load."""
    with pytest.MonkeyPatch.context() as patch:
        only(patch, (*SOUND, "unheard", "without_library"))
        return stability.run(Asked(processes=2, command="aliascope stability"), silent)


def cell(found: Map, component: str, extreme: str = "mean") -> Cell:
    (one,) = (each for each in found.cells if (each.component, each.extreme) == (component, extreme))
    return one


# --- what is found ----------------------------------------------------------------------------------------------------


def test_cells_stand_in_the_order_of_the_map(found: Map) -> None:
    assert [(each.kind, each.component, each.extreme) for each in found.cells] == [
        ("renderer", "embree", "far"),
        ("renderer", "osmesa", "far"),
        ("renderer", "povray", "far"),
        ("statistic", "beside", "mean"),
        ("statistic", "both", "scaled"),
        ("statistic", "careful", "mean"),
        ("statistic", "crashing", "mean"),
        ("statistic", "mean", "mean"),
        ("statistic", "mean", "zero-variance"),
        ("statistic", "none", "mean"),
        ("statistic", "ours", "mean"),
        ("statistic", "raising", "mean"),
        ("statistic", "variance", "mean"),
        ("metric", "rmse", "huge"),
    ]


def test_one_process_finds_the_same(found: Map, monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, reversed(("steady", "broken", "declining")))
    again = stability.run(Asked(processes=1), silent)

    def plain(each: Map) -> list[Any]:
        own = [c for c in each.cells if c.component not in ("crashing", "raising", "beside")]
        return [(c.component, c.status, [(r.at, r.error, r.refused) for r in c.readings]) for c in own]

    assert plain(again) == plain(found)


def test_what_breaks_is_ours_or_theirs(found: Map) -> None:
    assert [each.component for each in found.ours] == ["both", "none", "ours"]
    assert [each.component for each in found.broken if each.excused] == ["povray"]
    assert cell(found, "ours").breaks == (1e6,)
    assert cell(found, "both", "scaled").breaks == (1e-6, 1e6)
    none = cell(found, "none")
    assert (none.breaks_at, none.digits_lost, none.status) == (1e3, math.inf, "breaks")


def test_a_crash_loses_its_level_alone(found: Map) -> None:
    crashed = cell(found, "crashing")
    assert [(each.at, each.error) for each in crashed.readings] == [(1.0, 0.0), (1e3, 0.0), (1e6, None)]
    assert "SIGSEGV" in crashed.readings[-1].failed
    assert (crashed.status, crashed.failed_from) == ("failed", 1e6)
    assert cell(found, "beside").status == "keeps"


def test_an_exception_is_told_and_what_comes_after_measured(found: Map) -> None:
    raised = cell(found, "raising")
    assert raised.readings[1].failed.startswith("ZeroDivisionError: ")
    assert raised.readings[2].error == 0.0


def test_what_hangs_is_ended_and_its_level_known(monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, ["hanging"])
    hung = stability.run(Asked(processes=1, time_limit=0.5), silent)
    (one,) = hung.cells
    assert [(each.at, each.error) for each in one.readings] == [(1.0, 0.0), (1e3, None)]
    assert "was ended" in one.readings[1].failed
    assert hung.exit_code == 4


def test_what_declines_and_what_is_not_there(found: Map) -> None:
    careful = cell(found, "careful")
    assert (careful.status, careful.refused_from, careful.readings[-1].refused) == ("refuses", 1e6, "at most 1000")
    gone = cell(found, "osmesa", "far")
    assert (gone.status, gone.readings, gone.absent) == ("absent", (), "OSMesa is not there")
    assert found.absent == {"without_library": "libOSMesa.so.8 is not there"}
    assert list(found.lost) == ["unheard"]
    assert "no_such_module_of_anybody" in found.lost["unheard"]


def test_this_process_imports_no_module_of_probes(found: Map) -> None:
    assert not [name for name in sys.modules if name.startswith(f"{PACKAGE}.")]


# --- exit codes -------------------------------------------------------------------------------------------------------


def made(component: str = "c", error: float = 0.0, excused: bool = False, failed: str = "") -> Cell:
    readings = (Reading(1.0, None if failed else error, failed=failed),)
    return Cell(component, "statistic", "mean", "relative", "x", 1e-16, 1e-10, readings, excused=excused)


@pytest.mark.parametrize(
    ("cells", "lost", "code"),
    [
        ([made()], {}, 0),
        ([made(error=1.0)], {}, 1),
        ([made(error=1.0, excused=True)], {}, 0),
        ([made(failed="crashed")], {}, 4),
        ([made(failed="crashed", excused=True)], {}, 0),
        ([made(failed="crashed"), made("d", error=1.0)], {}, 4),
        ([made()], {"module": "did not load"}, 4),
    ],
)
def test_exit_codes(cells: list[Cell], lost: dict[str, str], code: int) -> None:
    assert Map(Asked(), "", 0.0, tuple(cells), lost, {}, {}).exit_code == code


def command(monkeypatch: pytest.MonkeyPatch, *modules: str) -> None:
    only(monkeypatch, modules)
    monkeypatch.setattr(stability, "Asked", functools.partial(Asked, package=PACKAGE))


def test_the_command_ends_with_1_where_ours_breaks(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    command(monkeypatch, "steady", "broken")
    told = run("stability", "ours", "povray", "mean", "-j", "1", "-o", tmp_path, code=1).stdout
    assert "breaks    ours, mean: from 10^6 on; the bound is 1e-10 relative, at worst: 1e-07 relative at 10^6" in told
    assert "excused    povray, far: from 10^6 on" in told
    assert "\x1b" not in told  # no terminal, no colours
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        *(".lock", "log.jsonl", "report.html", "stability.csv", "stability.json", "stability.md")
    ]


def test_the_command_ends_with_0_where_others_break(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    command(monkeypatch, "steady", "broken")
    printed = json.loads(
        run("stability", "--kind", "renderer", "--kind", "metric", "-j", "1", "-o", tmp_path, "--json").stdout
    )
    assert printed == json.loads((tmp_path / "stability.json").read_text())
    assert [(each["component"], each["text"]) for each in printed["cells"]] == [
        ("embree", "keeps"),
        ("povray", "10^6"),
        ("rmse", "keeps"),
    ]


def test_nothing_there_is_3(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    command(monkeypatch, "declining")
    assert complaint("stability", "osmesa", "-j", "1", "-o", tmp_path, code=3) == (
        "aliascope: nothing to measure is there: osmesa: OSMesa is not there"
    )


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["varianc"], 'aliascope: "varianc" matches no component, extreme or component/extreme; did you mean'),
        (["--group", "geometri"], 'aliascope: unknown group "geometri"; did you mean "geometry" or'),
        (["--kind", "renderers"], 'aliascope: unknown kind "renderers"; did you mean "renderer"?'),
        (["variance", "--quick"], "aliascope: no probe is all of what was asked for"),
    ],
)
def test_what_is_asked_wrongly_is_2(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, words: list[str], told: str
) -> None:
    command(monkeypatch, "steady")
    assert complaint("stability", *words, "-j", "1", "-o", tmp_path, code=2).startswith(told)


def test_quick_levels_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    only(monkeypatch, ["steady"])
    quick = stability.run(Asked(quick=True, groups=("statistics",), processes=1), silent)
    assert [(each.component, each.extreme, [r.at for r in each.readings]) for each in quick.cells] == [
        ("mean", "mean", [1.0]),
        ("mean", "zero-variance", [1.0]),
    ]


def test_probes_that_cannot_be_run_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def probe(**more: Any) -> Probe:
        asked = {"levels": (1.0,), "precision": 1e-16, "bound": 1e-10, "extreme": "mean", **more}
        return Probe("c", "statistic", unit="relative", against="x", measure=lambda at: 0.0, **asked)  # type: ignore[arg-type]

    for listed, told in (
        ([probe(extreme="mena")], "there is no extreme 'mena'"),
        ([probe(), probe()], "there are two of this name"),
        ([probe(levels=(math.inf,))], "its levels"),
        ([probe(levels=())], "its levels"),
        ([probe(levels=(np.int64(3),))], "its levels"),
        ([probe(precision=0.0)], "its precision"),
        ([probe(bound=math.nan)], "its precision"),
    ):
        module = type(sys)("listed_here")
        module.probes = lambda listed=listed: listed  # type: ignore[attr-defined]
        monkeypatch.setitem(sys.modules, "listed_here", module)
        running.probes_of.cache_clear()
        with pytest.raises(InvalidInput, match=told):
            running.probes_of("listed_here")
    with pytest.raises(InvalidInput, match=r"two modules have a probe 'c \| mean'"):
        running.joined([{"c | mean": probe()}, {"c | mean": probe()}])


# --- what is written --------------------------------------------------------------------------------------------------


def no_constant(name: str) -> None:
    raise AssertionError(name)


SCHEMA: dict[str, Any] = {
    "component": str,
    "kind": str,
    "extreme": str,
    "group": str,
    "status": ("keeps", "breaks", "refuses", "absent", "failed"),
    "text": str,
    "excused": bool,
    "unit": str,
    "against": str,
    "bound": float,
    "precision": float,
    "breaks": list,
    "refused_from": (float, None),
    "failed_from": (float, None),
    "digits_lost": (float, None),
    "reason": str,
    "note": str,
    "readings": list,
}
READING: dict[str, Any] = {
    "at": float,
    "error": (float, None),
    "outcome": ("kept", "broken", "refused", "failed"),
    "reason": str,
    "cpu_seconds": float,
}


def fits(value: Any, schema: Any) -> bool:
    if isinstance(schema, tuple):
        return any(fits(value, each) for each in schema)
    return isinstance(value, schema) if isinstance(schema, type) else value is schema or value == schema


def test_the_document_has_its_form(found: Map) -> None:
    text = json.dumps(stability_files.document(found), allow_nan=False)
    read = json.loads(text, parse_constant=no_constant)
    assert (read["holds"], read["quick"], read["command"]) == (False, False, "aliascope stability")
    assert read["counts"] == {"keeps": 6, "breaks": 4, "refuses": 1, "absent": 1, "failed": 2}
    assert [each["name"] for each in read["extremes"]] == ["far", "scaled", "mean", "zero-variance", "huge"]
    assert len(read["cells"]) == len(found.cells)
    for each in read["cells"]:
        assert set(each) == set(SCHEMA)
        assert not [key for key, schema in SCHEMA.items() if not fits(each[key], schema)], each
        for reading in each["readings"]:
            assert set(reading) == set(READING)
            assert not [key for key, schema in READING.items() if not fits(reading[key], schema)], reading
            assert bool(reading["reason"]) == (reading["error"] is None)
    none = next(each for each in read["cells"] if each["component"] == "none")
    assert (none["digits_lost"], none["reason"]) == (None, stability_files.NO_RESULT)


def test_the_csv_has_a_row_a_reading(found: Map) -> None:
    rows = list(csv.DictReader(io.StringIO(stability_files.table_csv(found))))
    assert len(rows) == sum(len(each.readings) for each in found.cells)
    by = {(row["component"], row["level"]): row for row in rows}
    ours = by["ours", "1000000.0"]
    assert (float(ours["error"]), ours["outcome"], ours["digits_lost"]) == (1e6 * 1e-13, "broken", "9.000")
    none = by["none", "1000.0"]
    assert (none["error"], none["outcome"], none["reason"]) == ("", "broken", stability_files.NO_RESULT)
    assert by["careful", "1000000.0"]["reason"] == "at most 1000"


def test_the_markdown_has_the_map(found: Map) -> None:
    text = stability_files.markdown(found)
    assert "| geometry | far | scaled |" in text
    assert "| `povray` | *10^6* |  |" in text
    assert "| `both` |  | **10^-6, 10^6** |" in text
    assert "| `careful` | refuses at 10^6 |" in text
    assert r"It is \| meant to." in text
    assert all(line.count("|") == 4 for line in text.splitlines() if line.startswith("| `both`"))


def shown(found: Map, **more: Any) -> str:
    out = io.StringIO()
    stability_text.show(found, Console(file=out, width=stability_text.WIDTH, highlight=False, **more))
    return out.getvalue()


def test_tables_fit_the_width(found: Map) -> None:
    many = [made(f"a-component-of-a-long-name:key={i}") for i in range(3)]
    wide = [
        Cell(each.component, "renderer", name, "u", "x", 1e-16, 1e-10, (Reading(1.0, None, "no"),))
        for each in many
        for name in [e.name for e in stability_text.EXTREMES.values() if e.group == "geometry"]
    ]
    text = shown(Map(Asked(), "", 0.0, tuple(wide), {}, {}, {}))
    tables = text.split("Coloured by")[0]
    assert max(map(len, tables.splitlines())) <= 100
    assert tables.count("refuses") == len(wide)
    heads = "".join(tables.split())
    assert all(f"{name}" in heads for name in ("far", "watertight", "shadow"))
    assert [line.split() for line in shown(found).splitlines() if line.startswith("osmesa ")] == [
        ["osmesa", "not", "there"]
    ]


def test_colours_hang_on_the_terminal_and_the_user(found: Map, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    assert "\x1b[1;7;31m" in shown(found, force_terminal=True)  # nothing left, reversed
    monkeypatch.setenv("NO_COLOR", "1")
    assert ";31m" not in shown(found, force_terminal=True)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1e9, "10^9"),
        (1e-12, "10^-12"),
        (100.0, "100"),
        (0.01, "0.01"),
        (0.0, "0"),
        (2.0**24, "2^24"),
        (2.0**24 + 1.0, "2^24+1"),
        (2.0**32 - 1.0, "2^32-1"),
        (2.0**53, "2^53"),
        (179.999, "180"),
        (65536.0, "2^16"),
        (-1e6, "-1e+06"),
        (1048583.0, "1.05e+06"),
    ],
)
def test_levels_are_said_as_powers(value: float, text: str) -> None:
    assert stability_text.level(value) == text


def test_the_page_says_what_the_map_does(found: Map) -> None:
    page = stability_page.page_of(found)
    assert [table.key for table in page.tables] == ["geometry", "statistics", "metrics"]
    assert [(heading, len(items)) for heading, _, items in page.lists] == [
        ("Failed", 3),
        ("What breaks, and is ours", 3),
        ("What breaks by the arithmetic of others, or without a safeguard", 1),
        ("What declines", 1),
        ("What is not there", 2),
    ]
    text = stability_page.html(found)
    assert "<b>10<sup>−6</sup>, 10<sup>6</sup></b>" in text
    assert "from 10<sup>6</sup> on" in text
    assert "https://" not in text.replace("http://www.w3.org/2000/svg", "")
