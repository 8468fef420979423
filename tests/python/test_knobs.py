"""The command knobs: which keys it turns, its table, its files, and measures between exact and bounded."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path

import pytest
from commands import complaint, run

from aliascope import knob_modes, plan, renderers
from aliascope.native import discrepancy, samplers
from aliascope.renderers import mode_of
from aliascope.specs import settings
from aliascope.studies import knob_measures, knob_text, knobs
from aliascope.trade.records import Interval, Knob

SIZE = ("--size", "16x12")


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few modes, of which one has a filter whose reference has to be made; few measures; no figures."""
    modes = {
        "embree": ("uniform:n=16", "uniform:n=16,packet=1", "uniform:n=16,robust=off", "uniform:n=16,film=float"),
        "osmesa": ("msaa", "msaa:n=8"),
    }
    monkeypatch.setitem(plan.PROFILES, "knobs", modes)  # type: ignore[arg-type]
    monkeypatch.setitem(plan.KINDS, "knobs", {})  # type: ignore[arg-type]
    monkeypatch.setattr(knob_modes, "FILTERS", ("uniform:n=16,filter=tent", "uniform:n=16,filter=tent,filter.radius=2"))
    monkeypatch.setattr(knobs, "FILTER_SAMPLES", 64)
    monkeypatch.setattr(knob_measures, "TURNS", knob_measures.TURNS[:1])
    monkeypatch.setattr(knob_measures, "SETS", ("random 0", "random 1"))
    for name in ("plot_svg", "spectrum_svg", "filters_svg"):
        monkeypatch.setattr(f"aliascope.report.{name}", lambda *_: "<svg xmlns='http://www.w3.org/2000/svg'/>")


@pytest.mark.usefixtures("few")
def test_it_turns_renders_and_tells(tmp_path: Path) -> None:
    document = json.loads(run("knobs", "edge", *SIZE, "-o", tmp_path, "--json").stdout)
    found = {(knob["form"], knob["knob"], knob["setting"]): knob for knob in document["knobs"]}
    assert set(found) == {
        ("uniform", "packet", "1"),
        ("uniform", "robust", "off"),
        ("uniform", "film", "float"),
        ("uniform", "filter", "tent"),
        ("uniform, tent", "filter.radius", "2"),
        ("msaa", "n", "8"),
        ("1024 points, d=2", "star", "star-bounds:gap=0.01"),
    }
    assert document["failed"] == 0
    assert Path(document["report"]) == tmp_path / "report.html"
    # The same rays but for edges, the same sums but for roundings: the same error.
    for key in (("uniform", "packet", "1"), ("uniform", "film", "float")):
        assert found[key]["error"]["value"] == pytest.approx(1.0, abs=1e-3)
    # A tent blurs, and its samples are shared: it is nearer to its own reference than the box.
    assert found["uniform, tent", "filter.radius", "2"]["error"]["value"] < 1.0
    assert found["uniform, tent", "filter.radius", "2"]["time"]["value"] > 1.0
    assert {knob["kind"] for knob in document["knobs"]} == {"mode", "measure"}
    rows = list(csv.DictReader(io.StringIO((tmp_path / "knobs.csv").read_text())))
    assert [row["setting"] for row in rows] == [knob["setting"] for knob in document["knobs"]]
    assert float(rows[0]["time"]) == document["knobs"][0]["time"]["value"]
    assert len((tmp_path / "knobs.md").read_text().splitlines()) == 2 + len(rows)

    again = run("knobs", "edge", *SIZE, "-o", tmp_path).stdout
    assert "of them from before, 0 failed" in again
    assert knob_text.NOTE in again
    assert all(knob["setting"] in again for knob in document["knobs"])
    assert "RMSE of" not in again  # no headline: those of compare are about other modes


@pytest.mark.usefixtures("few")
def test_what_cannot_be_is_refused(tmp_path: Path) -> None:
    assert "egde" in complaint("knobs", "egde", "-o", tmp_path, code=2)
    assert "povary" in complaint("knobs", "edge", "-r", "povary", "-o", tmp_path, code=2)


def test_every_knob_is_turned_and_every_mode_draws_its_scenes() -> None:
    made = knobs.plan_of([], [], None)
    assert not made.empty
    assert {job.scene for job in made.jobs} == set(knob_modes.SCENES)
    assert {job.scene for job in made.jobs if "filter.radius" in job.mode} == {knob_modes.FILTER_SCENE}
    turned: dict[tuple[str, str], set[str]] = {}
    for job in made.jobs:
        spec = mode_of(renderers.find(job.renderer), job.mode)
        for key, value in settings(spec).items():
            turned.setdefault((job.renderer, key), set()).add(value)
    for key in ("threshold", "depth", "jitter", "confidence", "variance", "compensation", "light_grid"):
        assert len(turned["povray", key]) >= 2, key
    for key in ("packet", "robust", "film", "filter", "filter.radius", "filter.sigma", "sampler", "n"):
        assert len(turned["embree", key]) >= 2, key
    for key in ("method.tolerance", "method.green", "method.confidence", "method.minimum", "method.margin"):
        assert len(turned["embree", key]) >= 2, key
    assert turned["embree", "film"] == {"double", "float", "compensated"}
    assert {"owen", "owen-full", "none", "shift", "digit"} <= turned["embree", "sampler.scramble"]
    assert len(turned["osmesa", "sample-shading"]) == 2
    assert len(turned["osmesa", "recentre"]) == len(turned["povray", "recentre"]) == 2
    assert {"am1", "am2"} <= {job.mode.partition(":")[0] for job in made.jobs if job.renderer == "povray"}


def test_every_mode_of_the_profile_differs_from_another_in_one_key() -> None:
    """What differs from none in a single key turns nothing: but for `none`, of which there is one."""
    for renderer, modes in knob_modes.MODES.items():
        specs = [mode_of(renderers.find(renderer), mode) for mode in modes]
        for spec in specs:
            own = settings(spec)
            alone = all(spec is other or spec.name != other.name or _apart(own, settings(other)) > 1 for other in specs)
            assert not alone or not own, spec.text


def _apart(own: dict[str, str], other: dict[str, str]) -> int:
    """How many keys differ; an inner spec of another name counts once."""
    renamed = {
        key
        for key in own
        if own[key] != other.get(key, own[key]) and any(k.startswith(f"{key}.") for k in {*own, *other})
    }
    keys = {key for key in {*own, *other} if own.get(key) != other.get(key)}
    return len({key.partition(".")[0] if key.partition(".")[0] in renamed else key for key in keys})


def test_widths_of_bounds_hold_the_exact_value() -> None:
    """Of every turn, on a set: bounds hold it, and so does the interval of draws, within 5 standard errors."""
    for turn in knob_measures.TURNS:
        points = samplers.points("random", turn.points, turn.dimensions, 3)
        exact = discrepancy.measure(turn.exact, points)
        other = discrepancy.measure(turn.other, points)
        width = turn.width(other, exact.value)
        assert exact.certainty == "exact"
        assert width > 0.0
        if other.certainty == "estimated":
            assert abs(other.value - exact.value) < 5.0 * other.standard_error
            assert width == pytest.approx(3.92 * other.standard_error / exact.value)
        elif turn.exact == "star":
            assert other.lower <= exact.value <= other.upper
            assert width == pytest.approx((other.upper - other.lower) / exact.value)
            assert other.upper - other.lower <= float(turn.other.partition("=")[2])
        else:
            assert width == pytest.approx(1.0 - other.value / exact.value)


def test_a_lower_bound_that_is_met_is_off_by_a_rounding() -> None:
    points = samplers.points("random", 16, 2, 0)
    exact = discrepancy.measure("half-plane", points)
    assert 0.0 < knob_measures._below(exact, exact.value) < 1e-15


def test_measures_are_told_over_sets() -> None:
    told: list[str] = []
    turn = knob_measures.Turn(2, 64, "star", "star-bounds:gap=0.05", knob_measures._between)
    sets = ("random 0", "random 1", "sobol:scramble=owen 0")
    (knob,) = knob_measures.knobs((turn,), sets, lambda what, *_: told.append(str(what)))
    logs = []
    for name in sets:
        points = samplers.points(name.split()[0], 64, 2, int(name.split()[1]))
        bounds = discrepancy.measure(turn.other, points)
        logs.append(math.log((bounds.upper - bounds.lower) / discrepancy.measure("star", points).value))
    assert knob.error.value == pytest.approx(math.exp(math.fsum(logs) / 3))
    assert (knob.kind, knob.pairs, knob.scenes, knob.baseline) == ("measure", 3, sets, "star")
    assert knob.time.value > 0.0
    assert told[-1] == "None"


def test_a_table_leaves_out_what_stands_above() -> None:
    def made(form: str, knob: str, setting: str) -> Knob:
        return Knob("embree", form, knob, setting, "16", Interval(2.0, 1.5, 2.5), Interval(1.0, None, None), ("a",), 1)

    rows = knob_text.table([made("uniform", "packet", "1"), made("uniform", "packet", "4"), made("adaptive", "n", "4")])
    assert rows[1].split() == [*("embree", "uniform", "packet", "1", "16", "2", "[1.5,", "2.5]", "1", "1,", "1")]
    assert rows[2].split()[0] == "4"
    assert rows[3].split()[:2] == ["adaptive", "n"]
    assert rows[1].index("16") == rows[2].index("16") == rows[3].index("16")
    markdown = knob_text.markdown([made("uniform", "packet", "1")])
    assert markdown[2] == "| embree | uniform | packet | 1 | 16 | 2 [1.5, 2.5] | 1 | 1, 1 |"
