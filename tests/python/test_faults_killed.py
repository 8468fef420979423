"""A compare whose processes are killed, and gone on from, leaves what one leaves that nobody disturbed."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
from killed_compares import VICTIMS, Pictures, disturbed, moments, pictures, problems, undisturbed

from aliascope.image import read_image, write_exr


@pytest.fixture(scope="module")
def right(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Pictures, float]:
    folder = tmp_path_factory.mktemp("right") / "out"
    return folder, *undisturbed(folder)


@pytest.mark.parametrize("seed", [1, 2])
def test_what_is_killed_three_times_comes_to_the_same(
    right: tuple[Path, Pictures, float], tmp_path: Path, seed: int
) -> None:
    """Three times, and gone on from each time; `make faults` does it 200 times."""
    _, pictures_of_right, seconds = right
    asked = moments(3, seed, seconds)
    assert {moment.victim for moment in asked} == set(VICTIMS)
    killed, wrong = disturbed(tmp_path / "out", asked, pictures_of_right, seed)
    assert [each.moment for each in killed] == asked
    assert wrong == []


def test_moments_are_spread_over_the_whole_run() -> None:
    asked = moments(200, 1, 10.0)
    assert sorted(int(moment.seconds / 0.05) for moment in asked) == list(range(200))
    assert {victim: sum(moment.victim == victim for moment in asked) for victim in VICTIMS} == {
        "harness": 66,
        "worker": 67,
        "povray": 67,
    }
    assert asked == moments(200, 1, 10.0) != moments(200, 2, 10.0)


def test_what_would_be_wrong_is_seen(right: tuple[Path, Pictures, float]) -> None:
    """The check above can fail: each thing that it looks for, put in."""
    folder, as_it_is, _ = right
    assert problems(folder, as_it_is) == []
    (key, (row, _, _)), *_ = as_it_is.items()
    path = folder / str(row["image"])
    values = read_image(path)
    try:
        write_exr(path, values * 2, {})
        assert problems(folder, as_it_is) == [f"{row['mode']}: another picture"]
        path.unlink()
        assert set(problems(folder, as_it_is)) == {f"{row['mode']}: another picture", f"file {row['image']}"}
    finally:
        write_exr(path, values, {})
    (folder / "images" / ".half.1.exr").write_bytes(b"half")
    assert problems(folder, as_it_is) == ["left: images/.half.1.exr", "file images/.half.1.exr"][::-1]
    (folder / "images" / ".half.1.exr").unlink()
    with sqlite3.connect(folder / "results.sqlite") as database:
        database.execute("UPDATE metric SET value = value + 1e-9 WHERE key = ? AND name = 'rmse'", (key,))
    database.close()
    assert problems(folder, as_it_is) == [f"{row['mode']}: another metrics"]
    with sqlite3.connect(folder / "results.sqlite") as database:
        database.execute("DELETE FROM job WHERE key = ?", (key,))
    database.close()
    assert f"job {key} is only in one of the two" in problems(folder, as_it_is)
    assert pictures(folder).keys() != as_it_is.keys()
