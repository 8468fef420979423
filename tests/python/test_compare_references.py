"""Which reference judges the pictures of a comparison, and what is told while one is made."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aliascope import draws, metrics, places, references
from aliascope.errors import CheckFailed, Unsupported
from aliascope.jobs import Plan
from aliascope.records import Estimate
from aliascope.references import Reference
from aliascope.studies import selection
from aliascope.studies.compare import with_reference
from aliascope.studies.compare_references import reference_of, references_of
from aliascope.studies.converging import converging


def test_the_standard_error_at_the_end_falls_with_the_root_of_the_count() -> None:
    told: list[object] = []
    tell = converging("it", lambda *what: told.append(what))
    tell(0, 16, None)
    tell(4, 16, 0.2)
    assert told == [("it", 0, 16), ("it: standard error 2.0e-01, 1.0e-01 at the end", 4, 16)]


def test_figures_have_what_their_reference_adds_to_them() -> None:
    """An error of 0.02 seen from references that are off by 0.005: what they add to the mean square is what is told."""
    rng = np.random.default_rng(7)
    picture = 0.5 + rng.normal(0.0, 0.02, (96, 128, 3))
    rmse, bias = math.sqrt(((picture - 0.5) ** 2).mean()), float((picture - 0.5).mean())
    seen = []
    for _ in range(16):
        pixels = (0.5 + rng.normal(0.0, 0.005, picture.shape)).astype(np.float32)
        reference = references.Reference(
            pixels, pixels.astype(np.float64), 0.0, "converged", np.full(picture.shape, 5e-3)
        )
        seen.append({name: value.value for name, value in metrics.measure(picture.astype(np.float32), pixels).items()})
    told = {name: with_reference(name, Estimate(value), reference).standard_error for name, value in seen[0].items()}
    assert np.mean([each["rmse"] for each in seen]) - rmse == pytest.approx(told["rmse"], rel=0.1)
    assert math.sqrt(np.mean([(each["bias"] - bias) ** 2 for each in seen])) == pytest.approx(told["bias"], rel=0.6)
    decibels = -20.0 * math.log10(rmse) - np.mean([each["psnr"] for each in seen])
    assert decibels == pytest.approx(told["psnr"], rel=0.1)
    assert told["max"] is None
    over_seeds = with_reference("rmse", Estimate(0.02, 3.0), reference).standard_error
    assert over_seeds == pytest.approx(math.hypot(3.0, 0.005**2 / 0.04))
    exact = references.Reference(pixels, pixels.astype(np.float64), 0.0, "polygons")
    assert with_reference("rmse", Estimate(0.02), exact) == Estimate(0.02)


def test_a_missing_reference_of_ours_is_said_and_never_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(places, "REFERENCES", tmp_path / "none")
    chosen = selection.plan_of(["edge"], ["embree"], ["uniform:n=4,filter=mitchell"], "quick", None)
    for filter_, option in (("box", ""), ("mitchell", " --filter mitchell")):
        with pytest.raises(CheckFailed, match=f"make it with: aliascope reference edge{option}"):
            reference_of(chosen, ("edge", filter_, draws.UNMOVED), (128, 96), tmp_path, lambda *_: None, print)
    assert not list(tmp_path.iterdir())


def test_the_reference_of_a_filter_that_no_profile_judges_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few, make, told = references.Plan(samples=4, replicates=2), references.make, list[object]()
    monkeypatch.setattr(references, "make", lambda scene, size, filter_, *_: make(scene, size, filter_, few))
    chosen = selection.plan_of(["edge"], ["embree"], ["uniform:n=4,filter=tent"], "quick", None)
    for _ in range(2):
        made = reference_of(
            chosen, ("edge", "tent", draws.UNMOVED), (128, 96), tmp_path, lambda *what: told.append(what), print
        )
        assert made.pixels.shape == (96, 128, 3)
    assert told == [("reference of edge, 128 x 96 pixels, filter tent", 0, 1)]
    assert (tmp_path / "edge" / "128x96-tent.exr").is_file()


def test_draws_end_where_no_reference_is_moved_as_far(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a method has no exact answer for, its features or the scene itself, would have to be converged."""

    def shifts(plan: Plan) -> set[tuple[float, float]]:
        return {job.shift for job in plan.jobs}

    three = {draws.shift_of(draw) for draw in range(draws.MOST)}
    assert shifts(selection.plan_of(["edge"], ["povray"], ["none"], "quick", None)) == three
    assert shifts(selection.plan_of(["edge"], ["povray"], ["none"], "quick", (40, 30))) == three
    # Seeds take no place, and no exact method has another filter.
    for mode in ("uniform:n=4", "uniform:n=4,sampler=regular,filter=tent"):
        assert shifts(selection.plan_of(["edge"], ["embree"], [mode], "quick", None)) == {draws.UNMOVED}
    # A scene of ours without an exact method has those that are kept, at its own size alone.
    monkeypatch.setattr(references, "may_be_exact", lambda *_: False)
    assert shifts(selection.plan_of(["edge"], ["povray"], ["none"], "quick", None)) == three
    assert shifts(selection.plan_of(["edge"], ["povray"], ["none"], "quick", (40, 30))) == {draws.UNMOVED}
    monkeypatch.undo()

    make = references.make

    def refuses(*given: Any) -> Reference:
        if given[4] == draws.shift_of(2):
            raise Unsupported("no")
        return make(*given)

    chosen = selection.plan_of(["edge"], ["povray"], ["none"], "quick", (40, 30))
    monkeypatch.setattr(references, "make", refuses)
    judged, left = references_of(chosen, tmp_path, lambda *_: None, print)
    assert {shift for _, _, shift in judged} == shifts(left) == three - {draws.shift_of(2)}
    assert len(chosen.jobs) == draws.MOST
    # That of a picture in its place is made or the reason is told.
    monkeypatch.setattr(references, "make", lambda *_: refuses(None, None, None, None, draws.shift_of(2)))
    with pytest.raises(Unsupported):
        references_of(chosen, tmp_path / "other", lambda *_: None, print)
