"""Many jobs: of each a record is kept, and no picture. `make load` has 10,000."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "bench"))

import load

SIZE = (80, 60)
PICTURE_BYTES = 80 * 60 * 3 * 4


def test_what_is_held_does_not_grow_by_pictures() -> None:
    """By a fifth of one at most, in the parent and in its worker, from the 50th job to the 150th."""
    first, last = load.levels(151, [50, 150], SIZE, processes=1)
    assert (first.begun, last.begun) == (50, 150)
    assert first.parent > 0
    assert first.workers > 0
    assert max(load.growth(first, last)) < PICTURE_BYTES / 5
