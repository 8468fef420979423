"""What makes one picture of a mode another draw than the next: its seed, or, where it has none, where the film lies.

One picture of a deterministic pattern is one draw of its error: how large it is hangs on how the pixels happen to lie
over the scene. Draws with the film moved by a part of a pixel are as good as seeds.
"""

from __future__ import annotations

MOST = 3
"""Draws of a mode without seeds: the references of these shifts are kept."""

# The points of R2 (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences"), to four decimals.
_SHIFTS = ((0.0, 0.0), (-0.2451, -0.4302), (-0.4902, 0.1397))


def shift_of(draw: int) -> tuple[float, float]:
    """Pixels to the right and down by which the film of a draw is moved, each in [-1/2, 1/2]; draw 0 is in its place.

    Raises IndexError from MOST on.
    """
    return _SHIFTS[draw]
