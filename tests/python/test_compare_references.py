"""Which reference judges the pictures of a comparison, and what is told while one is made."""

from __future__ import annotations

from pathlib import Path

import pytest

from aliascope import places, references
from aliascope.errors import CheckFailed
from aliascope.studies import selection
from aliascope.studies.compare import reference_of
from aliascope.studies.progress import converging


def test_the_standard_error_at_the_end_falls_with_the_root_of_the_count() -> None:
    told: list[object] = []
    tell = converging("it", lambda *what: told.append(what))
    tell(0, 16, None)
    tell(4, 16, 0.2)
    assert told == [("it", 0, 16), ("it: standard error 2.0e-01, 1.0e-01 at the end", 4, 16)]


def test_a_missing_reference_of_ours_is_said_and_never_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(places, "REFERENCES", tmp_path / "none")
    chosen = selection.plan_of(["edge"], ["embree"], ["uniform:n=4,filter=mitchell"], "quick", None)
    for filter_, option in (("box", ""), ("mitchell", " --filter mitchell")):
        with pytest.raises(CheckFailed, match=f"make it with: aliascope reference edge{option}"):
            reference_of(chosen, ("edge", filter_), (128, 96), tmp_path, lambda *_: None, print)
    assert not list(tmp_path.iterdir())


def test_the_reference_of_a_filter_that_no_profile_judges_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few, make, told = references.Plan(samples=4, replicates=2), references.make, list[object]()
    monkeypatch.setattr(references, "make", lambda scene, size, filter_, _: make(scene, size, filter_, few))
    chosen = selection.plan_of(["edge"], ["embree"], ["uniform:n=4,filter=tent"], "quick", None)
    for _ in range(2):
        made = reference_of(chosen, ("edge", "tent"), (128, 96), tmp_path, lambda *what: told.append(what), print)
        assert made.pixels.shape == (96, 128, 3)
    assert told == [("reference of edge, 128 x 96 pixels, filter tent", 0, 1)]
    assert (tmp_path / "edge" / "128x96-tent.exr").is_file()
