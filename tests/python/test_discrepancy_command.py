"""`aliascope discrepancy`: what it prints, draws and refuses."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import complaint, run
from discrepancy_sets import BELOW_ONE, EXTREMES, Points
from test_discrepancy_edges import exact_rms
from test_discrepancy_l2 import kernel_in_fractions
from test_discrepancy_others import distance_by_hand, largest_box
from test_discrepancy_planes import brute_box, brute_half_plane
from test_discrepancy_star import star_in_fractions

import aliascope
from aliascope import api
from aliascope.errors import InvalidInput, SpecError, Unsupported
from aliascope.native import discrepancy
from aliascope.studies import delta
from aliascope.studies.discrepancy import asked


def document(*arguments: str | Path) -> dict[str, object]:
    found: dict[str, object] = json.loads(run("discrepancy", *arguments, "--json").stdout)
    return found


def test_the_document() -> None:
    found = document("regular", "-n", "64", "--measure", "half-plane,edge-mean:draws=1000,edges=chord")
    assert (found["n"], found["d"]) == (64, 2)
    measures, details = found["measures"], found["details"]
    assert isinstance(measures, dict)
    assert isinstance(details, dict)
    assert measures["half-plane"] == pytest.approx(1 / 16, abs=1e-14)  # 1/(2k) of a centred k x k grid
    assert details["half-plane"]["certainty"] == "exact"
    assert details["edge-mean:draws=1000,edges=chord"]["standard_error"] > 0.0


def test_a_file_and_the_projections(tmp_path: Path) -> None:
    points = api.points("sobol", 64, 3)
    np.savetxt(tmp_path / "points.csv", points, delimiter=",", fmt="%.17g")
    rows = document(tmp_path / "points.csv", "--projections", "--measure", "star")["projections"]
    assert isinstance(rows, list)
    assert [row["dimensions"] for row in rows] == [[0, 1], [0, 2], [1, 2]]
    for row in rows:
        assert row["measures"]["star"] == discrepancy.measure("star", points[:, row["dimensions"]]).value
    text = run("discrepancy", tmp_path / "points.csv", "--measure", "l2-star").stdout
    assert text.startswith("l2-star  0.0")


def test_quick_measures_are_chosen_and_drawn(tmp_path: Path) -> None:
    measures = document("jittered", "-n", "16", "-o", tmp_path / "delta.png")["measures"]
    assert isinstance(measures, dict)
    assert {"star", "box", "half-plane", "edge-rms", "l2-star"} <= set(measures)
    assert (tmp_path / "delta.png").read_bytes().startswith(b"\x89PNG")


def test_a_quick_measure_that_cannot_be_had_is_none_with_its_reason() -> None:
    found = document("random", "-n", "15")
    measures, details = found["measures"], found["details"]
    assert isinstance(measures, dict)
    assert isinstance(details, dict)
    assert measures["t-value"] is None
    assert "power" in details["t-value"]["reason"]
    assert measures["star"] > 0.0
    assert "t-value" in run("discrepancy", "random", "-n", "15").stdout


def test_delta_is_its_definition() -> None:
    points = np.random.default_rng(4).random((50, 2))
    shown, at = delta.delta(points, 32), (np.arange(32) + 0.5) / 32
    for row in range(32):
        for column in range(32):
            inside = (points[:, 0] <= at[column]) & (points[:, 1] <= at[row])
            assert shown[row, column] == pytest.approx(inside.mean() - at[column] * at[row], abs=1e-15)


def test_a_comma_in_a_spec_parts_no_measures() -> None:
    assert asked(["star,edge-mean:draws=1000,edges=chord,box", "star"]) == [
        "star",
        "edge-mean:draws=1000,edges=chord",
        "box",
    ]


def by_hand(name: str, points: Points) -> float:
    """In fractions, or 50 digits, by the tests of each measure."""
    if name.startswith("l2-"):
        return math.sqrt(kernel_in_fractions(name, points))
    if name == "min-distance":
        return distance_by_hand(points, torus=True)
    if name == "edge-rms":
        return exact_rms(points)
    brute = {"star": star_in_fractions, "box": brute_box, "half-plane": brute_half_plane, "dispersion": largest_box}
    return float(brute[name](points))


SEVERAL = ["one point", "equal points", "on a level line", "on the left side", "on the border"]
SEVERAL += ["equal points in a corner", "just below one"]


@pytest.mark.parametrize("name", SEVERAL)
def test_the_extremes_by_every_measure(name: str, tmp_path: Path) -> None:
    points = EXTREMES[name]
    np.savetxt(tmp_path / "a.csv", points, delimiter=",", fmt="%.17g")
    found = document(tmp_path / "a.csv")
    measures: dict[str, float | None] = found["measures"]  # type: ignore[assignment]
    details: dict[str, Any] = found["details"]  # type: ignore[assignment]
    assert set(measures) == {info.name for info in discrepancy.registered()}
    missing = {spec for spec, value in measures.items() if value is None}
    assert missing == ({"min-distance"} if len(points) == 1 else {"t-value"})
    assert all(details[spec]["reason"] for spec in missing)
    if "t-value" not in missing:
        assert measures["t-value"] == 0
    star = float(star_in_fractions(points))
    bounds = details["star-bounds"]
    assert bounds["certainty"] == "bounds"
    assert measures["star-bounds"] == bounds["lower"]
    assert bounds["lower"] - 1e-15 <= star <= bounds["upper"]
    for spec in ("edge-mean", "edge-max"):
        assert 0.0 < measures[spec] <= 1.0  # type: ignore[operator]
    assert details["edge-mean"]["standard_error"] > 0.0
    for spec in set(measures) - missing - {"t-value", "star-bounds", "edge-mean", "edge-max"}:
        # Some roundings of values up to 1; 5e-15 of half-plane's and 1e-13 of l2's squares, as their own tests have it.
        assert measures[spec] == pytest.approx(by_hand(spec, points), rel=1e-12, abs=5e-15), spec
        assert details[spec]["certainty"] == "exact"


def test_a_point_below_one_is_written_and_read_exactly(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(f"{BELOW_ONE!r},{BELOW_ONE!r}\n")
    found = document(tmp_path / "a.csv", "--measure", "star,box,dispersion")
    assert found["measures"] == {"star": BELOW_ONE, "box": 1.0, "dispersion": BELOW_ONE}


# --- aliascope.discrepancy --------------------------------------------------------------------------------------------


def test_one_measure_of_an_array() -> None:
    found = aliascope.discrepancy(np.array([[0.5, 0.5]]), "star")
    assert (found.value, found.details) == (0.75, {"certainty": "exact", "witness": [0.5, 0.5], "border": "closed"})
    assert aliascope.discrepancy([[0, 1], [1, 1]], "star").value == 1.0
    drawn = aliascope.discrepancy([[0.5, 0.5]], "edge-mean:draws=100", seed=9)
    assert drawn == discrepancy.measure("edge-mean:draws=100", [[0.5, 0.5]], seed=9)
    assert drawn != aliascope.discrepancy([[0.5, 0.5]], "edge-mean:draws=100")
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.value = 1.0  # type: ignore[misc]


def test_several_measures_and_all_quick_ones_are_the_commands() -> None:
    points = aliascope.points("random", 15, seed=3)
    several = aliascope.discrepancy(points, ["star", "edge-mean:draws=1000,edges=chord"], seed=3)
    assert list(several) == ["star", "edge-mean:draws=1000,edges=chord"]
    assert several["star"] == discrepancy.measure("star", points)
    assert set(several["edge-mean:draws=1000,edges=chord"].details) == {"certainty", "standard_error"}
    quick = aliascope.discrepancy("random", n=15, seed=3)
    printed = document("random", "-n", "15", "--seed", "3")
    assert {spec: one.value for spec, one in quick.items()} == printed["measures"]
    assert {spec: one.details for spec, one in quick.items()} == printed["details"]
    assert quick["t-value"].value is None
    assert "power" in quick["t-value"].details["reason"]
    assert aliascope.discrepancy("sobol", "t-value", n=64, d=3).value == 1.0


@pytest.mark.parametrize(
    ("arguments", "options", "error", "says"),
    [
        (([[0.5, 1.5]], "star"), {}, InvalidInput, r"not in \[0, 1\]"),
        (([[0.5, math.nan]], "star"), {}, InvalidInput, r"not in \[0, 1\]"),
        (([0.5, 0.5], "star"), {}, InvalidInput, "shape"),
        (([[0.1, 0.2], [0.3]], "star"), {}, InvalidInput, "differ in length"),
        (([["a", "b"]], "star"), {}, InvalidInput, "real numbers"),
        (([[0.5, 0.5]], "sta"), {}, SpecError, "did you mean"),
        (([[0.5, 0.5, 0.5]], "half-plane"), {}, Unsupported, "in 2 dimensions"),
        (([[0.5, 0.5]], "star"), {"n": 1}, InvalidInput, "n is of a sampler"),
        (("sobol", "star"), {}, InvalidInput, "n is missing"),
        (("lattice", "star"), {"n": 12}, Unsupported, "Fibonacci"),
    ],
)
def test_what_has_no_discrepancy(arguments: Any, options: Any, error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        aliascope.discrepancy(*arguments, **options)


# --- what is refused --------------------------------------------------------------------------------------------------


def test_what_cannot_be_measured() -> None:
    assert "half-plane is of points in 2 dimensions" in complaint(
        "discrepancy", "sobol", "-n", "8", "-d", "3", "--measure", "half-plane", code=2
    )
    assert "did you mean" in complaint("discrepancy", "sobol", "-n", "8", "--measure", "sta", code=2)
