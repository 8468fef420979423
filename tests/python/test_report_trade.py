"""The trade in the report: what the page's scripts read, and the tables beside it."""

from __future__ import annotations

import csv
import io
import json

import pytest

from aliascope.report.trade import TITLES, trade_csv, trade_json
from aliascope.trade.records import (
    Afford,
    Convergence,
    Efficiency,
    Interval,
    Knob,
    OnFront,
    Ratio,
    Reach,
    SceneTrade,
    Trade,
)

SECONDS = Interval(0.123456789, 0.11, None)
SCENE = SceneTrade(
    "edge",
    (OnFront("embree", "uniform:n=4", 0.98765), OnFront("povray", "none", 0.0)),
    (
        Reach("embree", "uniform", 0.05, SECONDS, "measured", "uniform:n=4", "uniform, n=4", 0.01),
        Reach("povray", "none", 0.01, None, "cannot", "none", "none", 0.3),
        Reach(
            "embree", "uniform", 0.01, Interval(1.0, None, None), "extrapolated", "uniform:n=4", "uniform, n=4", 0.02
        ),
    ),
    (Afford("embree", "uniform", 0.1, Interval(0.04, 0.03, 0.05), "between", "uniform:n=4", "uniform, n=4", 0.001),),
    (Reach("povray", "none", 0.00113, None, "cannot", "none", "none", 0.3),),
    (Convergence("embree", "uniform", Interval(-0.75, -0.8, -0.7), None, True, 5),),
    (Efficiency("embree", "uniform:n=4", Interval(1e5, 9e4, float("inf"))),),
)
TRADE = Trade(
    (SCENE,),
    (Ratio("povray", "am2, depth", Interval(7.0, 3.0, 16.0), None, ("edge", "disc, mitchell")),),
    ("embree", "uniform"),
    (Knob("povray", "am2", "depth", "4", "3", SECONDS, Interval(0.7, 0.6, 0.8), ("edge",), 3),),
)


def test_the_scripts_get_figures_by_target_and_name() -> None:
    found = trade_json(TRADE)
    json.dumps(found, allow_nan=False)
    scene = found["scenes"]["edge"]
    assert scene["front"] == {"embree uniform:n=4": 0.988, "povray none": 0.0}
    assert [target for target, _ in scene["reach"]] == [0.01, 0.05]
    assert scene["reach"][0][1][0] == ["povray", "none", None, "cannot", "none", "none", 0.3]
    assert scene["reach"][1][1][0][2] == [0.123457, 0.11, None]
    assert scene["efficiency"] == {"embree uniform:n=4": [1e5, 9e4, None]}
    assert found["ratios"] == [["povray", "am2, depth", [7.0, 3.0, 16.0], None, ["edge", "disc, mitchell"]]]
    assert found["knobs"][0]["scenes"] == 1


def test_the_tables_have_every_answer() -> None:
    tables = {name: list(csv.DictReader(io.StringIO(text))) for name, text in trade_csv(TRADE).items()}
    assert list(tables) == list(TITLES)
    reached = tables["trade-equal-error"]
    assert [row["cpu_seconds"] for row in reached] == ["0.123456789", "", "1.0", ""]
    assert [row["how"] for row in reached] == ["measured", "cannot", "extrapolated", "cannot"]
    assert tables["trade-ratios"][0]["scenes"] == "edge; disc, mitchell"
    assert tables["trade-ratios"][0]["error_ratio"] == ""
    assert tables["trade-ratios"][0]["base"] == "embree uniform"
    knob = tables["trade-knobs"][0]
    assert (knob["knob"], knob["setting"], knob["baseline"], knob["time_ratio_high"]) == ("depth", "4", "3", "")
    assert float(tables["trade-convergence"][0]["exponent_low"]) == pytest.approx(-0.8)


def test_tables_without_a_row_are_no_files() -> None:
    assert trade_csv(Trade((), (), None, ())) == {}
