"""Pictures in the page: float32, to the bit, in as few characters as deflate allows; and what is drawn from them.

`packing.py` makes bytes of a picture, which stand here as text: 13 bits in two characters, of the 91 that print and
mean nothing to HTML. 100 bytes are 124 characters, where base64 has 136.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aliascope.records import Counts, Pixels
from aliascope.report.packing import NOTHING, Known, pack, unpack

ALPHABET = bytes(code for code in range(33, 127) if chr(code) not in "&<>")
"""91 characters: 91^2 is just over 2^13, and 91 over 2^6."""
_VALUES = np.full(256, 255, np.uint8)
_VALUES[list(ALPHABET)] = np.arange(91)


def to_text(data: bytes) -> str:
    """Bytes as characters of ALPHABET: each 13 bits as two, the last 6 or fewer as one."""
    bits = np.unpackbits(np.frombuffer(data, np.uint8))
    spare = len(bits) % 13
    single = 0 < spare <= 6
    missing = 6 - spare if single else -len(bits) % 13
    bits = np.concatenate([bits, np.zeros(missing, np.uint8)])
    pairs = _numbers(bits[: len(bits) - 6] if single else bits, 13)
    values = np.stack([pairs // 91, pairs % 91], axis=1).reshape(-1)
    if single:
        values = np.concatenate([values, _numbers(bits[-6:], 6)])
    return np.frombuffer(ALPHABET, np.uint8)[values].tobytes().decode("ascii")


def from_text(text: str) -> bytes:
    """The inverse of `to_text`. Raises ValueError for what is not such a text."""
    values = _VALUES[np.frombuffer(text.encode("utf-8"), np.uint8)].astype(np.int64)
    pairs = values[: len(values) // 2 * 2].reshape(-1, 2) @ np.array([91, 1])
    last = values[len(values) // 2 * 2 :]
    if (values == 255).any() or (pairs >= 1 << 13).any() or (last >= 1 << 6).any():
        raise ValueError("not the text of a picture")
    bits = np.concatenate([_bits(pairs, 13), _bits(last, 6)])
    return np.packbits(bits[: len(bits) // 8 * 8]).tobytes()


def _numbers(bits: NDArray[np.uint8], width: int) -> NDArray[np.int64]:
    weights = 1 << np.arange(width - 1, -1, -1)
    return bits.reshape(-1, width).astype(np.int64) @ weights


def _bits(numbers: NDArray[np.int64], width: int) -> NDArray[np.uint8]:
    return (numbers[:, np.newaxis] >> np.arange(width - 1, -1, -1) & 1).astype(np.uint8).reshape(-1)


def encode_picture(pixels: Pixels, known: Known = NOTHING, step: float = 0.0) -> str:
    """The text of a picture (height, width, 3) float32; `decode_picture` gives it back to the bit. `step` is that of
    the renderer's output, 0 for float."""
    return to_text(pack(pixels, known, step))


def decode_picture(text: str, width: int, height: int, known: Known = NOTHING) -> Pixels:
    """The inverse of `encode_picture`. Raises ValueError for a text that is not a picture of this size."""
    return unpack(from_text(text), width, height, known)


@dataclass
class PictureStore:
    """The pictures of a page; equal ones of a scene are stored once. `texts[id]` is the encoded picture."""

    texts: list[str] = field(default_factory=list)
    _places: dict[tuple[bytes, Known], int] = field(default_factory=dict)

    def add(self, pixels: Pixels, known: Known = NOTHING, step: float = 0.0) -> int:
        """The number of a picture in the page, which is told by what is known of its scene, see `encode_picture`."""
        digest = hashlib.sha256(repr(pixels.shape).encode() + np.ascontiguousarray(pixels).tobytes()).digest()
        key = (digest, known)
        if key not in self._places:
            self._places[key] = len(self.texts)
            self.texts.append(encode_picture(pixels, known, step))
        return self._places[key]


def counts_picture(counts: Counts) -> Pixels:
    """The samples of each pixel as a picture of three equal channels; float is exact up to 2^24."""
    return np.repeat(counts.astype(np.float32)[..., np.newaxis], 3, axis=2)


MOST_SURPRISING = 25.4
"""Powers of ten below which p-values are not told apart: 255 steps of a tenth."""


def surprise_picture(p_values: NDArray[np.float64]) -> Pixels:
    """-log10 of the least p-value of each pixel's channels (height, width, 3), to a tenth, so that the picture is
    small; NaN where one is."""
    least = np.maximum(p_values.min(axis=2), 10.0**-MOST_SURPRISING)
    tenths: NDArray[np.float64] = np.abs(np.round(-10.0 * np.log10(least))) / 10.0
    return np.repeat(tenths.astype(np.float32)[..., np.newaxis], 3, axis=2)


def error_map(pixels: Pixels, reference: Pixels) -> NDArray[np.float64]:
    """Signed error (height, width): the mean over the channels of picture - reference. NaN if not finite."""
    with np.errstate(invalid="ignore", over="ignore"):
        error: NDArray[np.float64] = (pixels.astype(np.float64) - reference.astype(np.float64)).mean(axis=2)
    return np.where(np.isfinite(error), error, np.nan)


def error_scale(errors: list[NDArray[np.float64]]) -> float:
    """The end of a scene's error scale: the median over its pictures of the 99th percentile of |error|, rounded up to
    1, 2 or 5 times a power of ten. One for all pictures of the scene, so that their maps can be compared."""
    tops = [float(np.nanpercentile(np.abs(error), 99)) for error in errors if np.isfinite(error).any()]
    visible = [top for top in tops if top > 0.0]
    if not visible:
        largest = max((float(np.nanmax(np.abs(e))) for e in errors if np.isfinite(e).any()), default=0.0)
        visible = [largest] if largest > 0.0 else [0.01]
    return round_up(float(np.median(visible)))


def round_up(value: float) -> float:
    """The least of 1, 2 or 5 times a power of ten that is not below a positive value."""
    exponent = int(np.floor(np.log10(value)))
    for step in (1, 2, 5, 10):
        # float() of the decimal literal, since 2 * 10.0**-3 is not the nearest double to 0.002
        candidate = float(f"{step}e{exponent}")
        if candidate >= value * (1.0 - 1e-12):  # a rounding of log10 may not lift 0.1 to 0.2
            return candidate
    raise AssertionError("unreachable: 10 ** (exponent + 1) exceeds the value")


def worst_pixel(error: NDArray[np.float64]) -> tuple[int, int]:
    """(x, y) of the largest |error|; the first pixel that is not finite, where there is one."""
    size = np.where(np.isnan(error), np.inf, np.abs(error))
    y, x = np.unravel_index(int(np.argmax(size)), size.shape)
    return int(x), int(y)
