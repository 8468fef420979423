"""Blessed figures on disk: what was saved is loaded, what was edited is refused, and the log says what changed."""

from __future__ import annotations

import dataclasses
import json
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from regress_runs import BLOCKS, EDGE, STAR, observed

from aliascope import places, renderers, scene_io
from aliascope.errors import CheckFailed, NotWritable
from aliascope.regression import blessed
from aliascope.regression.records import Blessed, CellName
from aliascope.regression.verdict import mismatch
from aliascope.renderers.base import filter_of
from aliascope.studies import regress_suite


def made(name: CellName = EDGE, seeded: bool = True, scale: float = 1.0, reason: str = "as planned") -> Blessed:
    return blessed.bless(observed(name, seeded, scale), reason, "aliascope regress --bless '*'")


OTHER = dataclasses.replace(EDGE, mode="uniform:n=16,sampler=random")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    blessed.save(tmp_path, [made(), made(OTHER, scale=2.0), made(STAR, False)])
    return tmp_path


@pytest.mark.parametrize(("name", "seeded"), [(EDGE, True), (STAR, False)])
def test_what_was_saved_is_loaded(folder: Path, name: CellName, seeded: bool) -> None:
    """To the digits that a file keeps; saved again it is the same bytes, and loaded again the same to the bit."""
    saved, loaded = made(name, seeded), blessed.load(folder, name.scene, name.renderer)[name.mode]
    one, other = saved.observed, loaded.observed
    for field in dataclasses.fields(one):
        if field.name not in ("replicates", "metrics", "scatter", "quantum"):
            assert getattr(one, field.name) == getattr(other, field.name), field.name
    assert other.scatter == pytest.approx(one.scatter, rel=1e-8)
    assert other.quantum == one.quantum
    assert other.metrics["rmse"].value == pytest.approx(0.0123456789123, rel=1e-8)
    assert other.metrics["psnr"].value is None
    for first, second in zip(one.replicates, other.replicates, strict=True):
        same = ("draw", "sha256", "samples", "rays", "not_finite")
        assert [getattr(first, key) for key in same] == [getattr(second, key) for key in same]
        assert second.coefficients == pytest.approx(first.coefficients, rel=1e-8)
        # Half of the step of 1e-7, and what the sum of two roundings adds.
        assert second.blocks == pytest.approx(first.blocks, abs=0.51e-7)
        assert second.block_squares == pytest.approx(first.block_squares, rel=1e-4)
        assert (second.rmse is None) == (first.rmse is None)
        assert second.rmse is None or second.rmse == pytest.approx(first.rmse, rel=1e-8)
        for key in ("least", "largest", "outlier"):
            assert getattr(second, key) == pytest.approx(getattr(first, key), rel=1e-8), key
    assert (saved.sha256, saved.reason, saved.command) == (loaded.sha256, loaded.reason, loaded.command)
    before = blessed.path_of(folder, name.scene, name.renderer).read_bytes()
    blessed.save(folder, [loaded])
    assert blessed.path_of(folder, name.scene, name.renderer).read_bytes() == before
    assert blessed.load(folder, name.scene, name.renderer)[name.mode] == loaded


def test_a_cell_takes_so_many_bytes(folder: Path) -> None:
    """A replicate of 128 x 96 pixels a line; 15 scenes with 12 modes each have room in 4 MB."""
    path = blessed.path_of(folder, "edge", "embree")
    lines = path.read_text().splitlines()
    assert sum(line.startswith("  {") for line in lines) == 2 * 16
    seeded, shifted = (blessed.path_of(folder, each.scene, each.renderer).stat().st_size for each in (EDGE, STAR))
    assert seeded / 2 < 4e6 / (15 * 12)
    assert shifted < seeded / 2
    assert len(made().observed.replicates[0].blocks) == BLOCKS


def test_blessing_one_mode_leaves_the_others_as_they_are(folder: Path) -> None:
    before = blessed.load(folder, "edge", "embree")
    blessed.save(folder, [made(OTHER, scale=3.0, reason="brighter")])
    after = blessed.load(folder, "edge", "embree")
    assert after[EDGE.mode] == before[EDGE.mode]
    assert after[OTHER.mode].reason == "brighter"
    assert after[OTHER.mode].sha256 != before[OTHER.mode].sha256
    assert blessed.load(folder, "edge", "osmesa") == {}


def change(path: Path, what: Callable[[dict[str, Any]], None]) -> None:
    document = json.loads(path.read_text())
    what(document["modes"])
    path.write_text(json.dumps(document))


def widen(modes: dict[str, Any]) -> None:
    modes[EDGE.mode]["replicates"][3]["coefficients"][3] += 1e-3


def swap(modes: dict[str, Any]) -> None:
    modes[EDGE.mode], modes[OTHER.mode] = modes[OTHER.mode], modes[EDGE.mode]


def other_scene(modes: dict[str, Any]) -> None:
    modes[EDGE.mode]["scene_digest"] = "00" * 32


def no_digest(modes: dict[str, Any]) -> None:
    del modes[EDGE.mode]["digest"]


@pytest.mark.parametrize("edit", [widen, swap, other_scene, no_digest])
def test_what_was_edited_is_refused_until_it_is_blessed_anew(
    folder: Path, edit: Callable[[dict[str, Any]], None]
) -> None:
    path = blessed.path_of(folder, "edge", "embree")
    change(path, edit)
    with pytest.raises(CheckFailed) as failure:
        blessed.load(folder, "edge", "embree")
    assert "were changed since they were blessed" in str(failure.value)
    words = shlex.split(str(failure.value).rpartition("anew: ")[2])
    assert words[:5] == ["aliascope", "regress", "edge", "--references", str(folder)]
    assert words[words.index("--bless") + 1] == f"edge/embree/{words[words.index('-m') + 1]}"
    blessed.save(folder, [made()] if edit is not swap else [made(), made(OTHER)])
    assert blessed.load(folder, "edge", "embree")[EDGE.mode].observed.scene_digest == "5c" * 32


def test_an_edited_entry_is_not_blessed_by_blessing_another(folder: Path) -> None:
    change(blessed.path_of(folder, "edge", "embree"), widen)
    blessed.save(folder, [made(OTHER)])
    with pytest.raises(CheckFailed, match=r"sampler.scramble=owen.* were changed since"):
        blessed.load(folder, "edge", "embree")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        '{"format": 1}',
        '{"format": 1, "scene": "discs", "renderer": "embree", "modes": {}}',
        "<<<<<<< HEAD\n{}",
        '{"format": 1, "scene": "edge", "renderer": "embree", "modes": {"none": {}, "none": {}}}',
    ],
)
def test_a_file_that_is_none_is_refused_and_kept(folder: Path, text: str) -> None:
    path = blessed.path_of(folder, "edge", "embree")
    path.write_text(text)
    for work in (lambda: blessed.load(folder, "edge", "embree"), lambda: blessed.save(folder, [made()])):
        with pytest.raises(CheckFailed, match=r"cannot be read as the blessed figures of embree on edge.*--bless"):
            work()
    assert path.read_text() == text


def test_a_file_of_a_later_version_is_refused(folder: Path) -> None:
    path = blessed.path_of(folder, "edge", "embree")
    path.write_text(path.read_text().replace('"format": 1', '"format": 2'))
    with pytest.raises(CheckFailed, match="has format 2, this version reads 1"):
        blessed.load(folder, "edge", "embree")


def test_the_command_names_the_file_of_a_scene_and_is_short_for_ours() -> None:
    setting = blessed.Setting()
    assert blessed.commands.again(EDGE, "", setting) == (
        "aliascope regress edge -r embree -m uniform:n=64,sampler=sobol,sampler.scramble=owen"
    )
    assert shlex.split(blessed.commands.again(EDGE, "my scenes/edge.toml", setting))[2] == "my scenes/edge.toml"


def test_pictures_with_holes_are_not_blessed() -> None:
    cell = observed(EDGE)
    broken = dataclasses.replace(cell.replicates[2], not_finite=3)
    cell = dataclasses.replace(cell, replicates=(*cell.replicates[:2], broken, *cell.replicates[3:]))
    with pytest.raises(CheckFailed, match="cannot be blessed: 3 of its pixels"):
        blessed.bless(cell, "because", "")


def test_the_log_says_what_changed(tmp_path: Path) -> None:
    first, second = made(), made(scale=2.0, reason='a "better" filter\nreally')
    blessed.log(tmp_path, first, None)
    path = blessed.log(tmp_path, second, first)
    assert path == tmp_path / "blessings.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert [line["old"] for line in lines] == [None, first.sha256]
    assert [line["new"] for line in lines] == [first.sha256, second.sha256]
    assert lines[1]["reason"] == 'a "better" filter\nreally'
    assert lines[1]["cell"] == EDGE.text
    assert lines[1]["when"] == second.blessed_on
    assert lines[0]["changes"]["gain"][0] is None
    assert lines[1]["changes"]["gain"][1] == pytest.approx(2 * lines[1]["changes"]["gain"][0], rel=1e-6)
    assert {"rmse", "scatter", "samples", "primary rays", "cpu seconds"} <= set(lines[1]["changes"])


def test_hashes_tell_pictures_and_their_order_apart() -> None:
    cell = observed(EDGE).replicates
    assert len({blessed.fingerprint(each) for each in (cell, cell[::-1], cell[:-1])}) == 3


def test_what_cannot_be_written_is_said(tmp_path: Path) -> None:
    (tmp_path / "edge").write_text("a file, no folder")
    with pytest.raises((NotWritable, CheckFailed)):
        blessed.save(tmp_path, [made()])
    (tmp_path / "blessings.jsonl").mkdir()
    with pytest.raises(NotWritable, match="cannot be written"):
        blessed.log(tmp_path, made(), None)


def test_every_cell_of_the_suite_is_blessed_for_the_scenes_as_they_are() -> None:
    files = [scene_io.load(name) for name in scene_io.names()]
    cells, _ = regress_suite.cells_of(files, list(renderers.RENDERERS))
    found = {}
    for cell in cells:
        key = cell.name.scene, cell.name.renderer
        if key not in found:
            found[key] = blessed.load(places.REFERENCES, *key)
        kept = found[key][cell.name.mode]
        assert not mismatch(kept, cell.file.scene.digest(), cell.file.scene.view.size, filter_of(cell.spec), cell.draws)
        assert kept.observed.judged == cell.judged
    assert {name for modes in found.values() for name in modes} == {cell.name.mode for cell in cells}


def test_no_scene_is_named_as_the_log() -> None:
    assert blessed.LOG not in scene_io.names()
