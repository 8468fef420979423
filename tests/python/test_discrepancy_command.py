"""`aliascope discrepancy`: what it prints, draws and refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from commands import complaint, run

from aliascope import api
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


def test_what_cannot_be_measured() -> None:
    assert "half-plane is of points in 2 dimensions" in complaint(
        "discrepancy", "sobol", "-n", "8", "-d", "3", "--measure", "half-plane", code=2
    )
    assert "did you mean" in complaint("discrepancy", "sobol", "-n", "8", "--measure", "sta", code=2)
