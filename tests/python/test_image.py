"""Pictures on disk."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from aliascope.errors import InvalidInput, NotWritable
from aliascope.image import read_header, read_image, write_exr


def test_every_float_and_the_header_come_back(tmp_path: Path) -> None:
    pixels = np.random.default_rng(3).normal(0, 1e10, (5, 7, 3)).astype(np.float32)
    pixels[0, 0] = [np.nan, np.inf, 1e-42]
    header = {"scene": "edge", "mode": "uniform:n=4", "words": 'a "b" é'}
    write_exr(tmp_path / "new" / "a.exr", pixels, header)
    assert np.array_equal(read_image(tmp_path / "new" / "a.exr"), pixels, equal_nan=True)
    assert read_header(tmp_path / "new" / "a.exr") == header


def test_a_folder_that_cannot_be_written_is_said_and_nothing_is_left(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(NotWritable):
        write_exr(tmp_path / "file" / "a.exr", np.zeros((1, 1, 3), np.float32), {})
    (tmp_path / "taken.exr").mkdir()
    with pytest.raises(NotWritable):
        write_exr(tmp_path / "taken.exr", np.zeros((1, 1, 3), np.float32), {})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "taken.exr"]


def test_what_is_no_picture_is_said(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no such file"):
        read_image(tmp_path / "absent.exr")
    (tmp_path / "text.exr").write_text("not a picture")
    with pytest.raises(InvalidInput, match="not a picture"):
        read_image(tmp_path / "text.exr")
    whole = tmp_path / "whole.exr"
    write_exr(whole, np.ones((64, 64, 3), np.float32) * np.random.default_rng(1).random((64, 64, 1), np.float32), {})
    (tmp_path / "cut.exr").write_bytes(whole.read_bytes()[:900])
    with pytest.raises(InvalidInput, match=r"cut\.exr: "):
        read_image(tmp_path / "cut.exr")


def test_contents_reach_the_disk_before_the_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    monkeypatch.setattr("os.fsync", lambda number: done.append(f"sync {os.path.samestat(os.fstat(number), part())}"))
    replace = Path.replace
    monkeypatch.setattr(Path, "replace", lambda own, to: (done.append("replace"), replace(own, to))[1])

    def part() -> os.stat_result:
        (path,) = tmp_path.glob(".a.*.exr")
        return path.stat()

    write_exr(tmp_path / "a.exr", np.zeros((1, 1, 3), np.float32), {})
    assert done == ["sync True", "replace"]
