"""What makes one picture of a mode another draw than the next: its seed, or, where it has none, where the film lies.

One picture of a deterministic pattern is one draw of its error: how large it is hangs on how the pixels happen to lie
over the scene. Draws with the film moved by a part of a pixel are as good as seeds.
"""

from __future__ import annotations

from aliascope.errors import InvalidInput

MOST = 3
"""Draws of a mode without seeds: the references of these shifts are kept."""

# The points of R2 (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences"), to four decimals.
_SHIFTS = ((0.0, 0.0), (-0.2451, -0.4302), (-0.4902, 0.1397))

UNMOVED = (0.0, 0.0)
LARGEST_SHIFT = 16.0
"""Pixels by which a picture is moved on the film at most."""


def checked(shift: tuple[float, float]) -> tuple[float, float]:
    """A shift, in pixels to the right and down. Raises InvalidInput beyond LARGEST_SHIFT, and for NaN."""
    if not all(abs(pixels) <= LARGEST_SHIFT for pixels in shift):  # nor is NaN
        raise InvalidInput(
            f"a shift of ({shift[0]:g}, {shift[1]:g}) pixels: each is from {-LARGEST_SHIFT:g} to {LARGEST_SHIFT:g}"
        )
    return shift


def text_of(shift: tuple[float, float]) -> str:
    """As `--shift RIGHT,DOWN` takes it, to the last bit; the sign of a zero does not count."""
    return ",".join(repr(float(pixels) + 0.0) for pixels in shift)


def shift_of(draw: int) -> tuple[float, float]:
    """Pixels to the right and down by which the film of a draw is moved, each in [-1/2, 1/2]; draw 0 is in its place.

    Raises IndexError from MOST on.
    """
    return _SHIFTS[draw]
