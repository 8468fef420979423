"""Generated: .venv/bin/python -m aliascope.studies.hardware_search, which says how."""

from __future__ import annotations

SETS: dict[tuple[str, int], tuple[str, tuple[int, ...]]] = {
    # (measure, points): how it was found, the cells of the 8 x 8 grid, by rows
    ("edge-rms", 1): ("exhaustive", (27,)),
    ("edge-rms", 2): ("exhaustive", (18, 45)),
    ("edge-rms", 4): ("exhaustive", (10, 22, 41, 53)),
    ("edge-rms", 8): ("exhaustive", (1, 14, 20, 25, 38, 43, 49, 62)),
    ("edge-rms", 16): (
        "descent from 100000 random sets, 20 of which end there",
        (1, 5, 11, 15, 16, 20, 26, 30, 33, 37, 43, 47, 48, 52, 58, 62),
    ),
    ("half-plane", 1): ("exhaustive", (27,)),
    ("half-plane", 2): ("exhaustive", (18, 45)),
    ("half-plane", 4): ("exhaustive", (0, 21, 42, 63)),
    ("half-plane", 8): ("exhaustive", (0, 12, 22, 26, 37, 41, 51, 63)),
    ("half-plane", 16): ("exhaustive", (2, 4, 9, 14, 20, 23, 24, 26, 37, 39, 40, 43, 49, 54, 59, 61)),
}
