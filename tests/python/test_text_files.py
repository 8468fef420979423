"""Text files: written whole or not at all, and grown line by line."""

from __future__ import annotations

from pathlib import Path

import pytest

from aliascope.errors import NotWritable
from aliascope.text_files import append_lines, remove_unfinished, write_text


def test_what_cannot_be_written_is_said_and_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("there")
    for path in (tmp_path / "folder", tmp_path / "file" / "below"):
        with pytest.raises(NotWritable, match=f"{path}: cannot be written: "):
            write_text(path, "x")
        with pytest.raises(NotWritable, match=f"{path}: cannot be written: "):
            append_lines(path, ["x"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder"]
    assert (tmp_path / "file").read_text() == "there"


def test_lines_are_appended(tmp_path: Path) -> None:
    path = tmp_path / "new" / "log"
    append_lines(path, ["a", "b"])
    append_lines(path, ["c"])
    assert path.read_text() == "a\nb\nc\n"


def test_what_is_unfinished_goes_and_all_else_stays(tmp_path: Path) -> None:
    for name in (".report.html.123", ".git", ".a.toml", "a.123", ".hidden.12x"):
        (tmp_path / name).write_text("x")
    remove_unfinished(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".a.toml", ".git", ".hidden.12x", "a.123"]
