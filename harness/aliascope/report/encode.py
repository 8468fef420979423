"""Pictures in the page: float32, to the bit, in as few characters as deflate allows.

The body of an encoded picture is, before zlib (RFC 1950) and base64:

    byte 0       0 "planes", 1 "palette"
    bytes 1-4    number of colours in the palette, little-endian; 0 for planes
    planes       the words of the pixels, see `_planes`
    palette      the words of the distinct colours as planes, then one index a pixel: one byte each where there are at
                 most 256 colours, else all high bytes, then all low bytes

A picture of antialiased flat surfaces has few distinct colours (n + 1 with n samples a pixel), and is some 30 times
smaller as a palette; a noisy one falls back to planes. `pictures.js` is the other half.
"""

from __future__ import annotations

import base64
import hashlib
import struct
import zlib
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aliascope.records import Counts, Pixels

PLANES, PALETTE = 0, 1
LARGEST_PALETTE = 1 << 16
_SHIFTS = np.array([24, 16, 8, 0], np.uint32)


def encode_picture(pixels: Pixels) -> str:
    """The base64 text of a picture (height, width, 3) float32; `decode_picture` gives it back to the bit."""
    words = np.ascontiguousarray(pixels, dtype="<f4").view("<u4").reshape(-1, 3).astype(np.uint32)
    bodies = [struct.pack("<BI", PLANES, 0) + _planes(words)]
    colours, index = np.unique(words, axis=0, return_inverse=True)
    if len(colours) <= LARGEST_PALETTE:
        index = index.reshape(-1)
        indices = index.astype(np.uint8).tobytes()
        if len(colours) > 256:
            indices = (index >> 8).astype(np.uint8).tobytes() + indices
        bodies.append(struct.pack("<BI", PALETTE, len(colours)) + _planes(colours) + indices)
    return base64.b64encode(min((zlib.compress(body, 9) for body in bodies), key=len)).decode("ascii")


def decode_picture(text: str, width: int, height: int) -> Pixels:
    """The inverse of `encode_picture`. Raises ValueError for a text that is not a picture of this size."""
    body = zlib.decompress(base64.b64decode(text, validate=True))
    kind, count = struct.unpack_from("<BI", body)
    data = np.frombuffer(body, np.uint8, offset=5)
    total = width * height
    if kind == PLANES and len(data) == 12 * total:
        words = _unplanes(data)
    elif kind == PALETTE and len(data) == 12 * count + total * (1 if count <= 256 else 2):
        tail = data[12 * count :].astype(np.intp).reshape(-1, total)
        index = tail[0] if len(tail) == 1 else tail[0] * 256 + tail[1]
        words = _unplanes(data[: 12 * count])[index]
    else:
        raise ValueError(f"not a picture of {width} x {height} pixels")
    pixels: Pixels = words.astype("<u4").view("<f4").reshape(height, width, 3).astype(np.float32)
    return pixels


def _planes(words: NDArray[np.uint32]) -> bytes:
    """Words (n, 3) as bytes [significance][channel][n], highest first; green and blue as difference to red, mod 2^32.

    Bytes of one significance repeat where whole floats don't, and the channels of a grey picture are equal.
    """
    channels = words.T.copy()
    channels[1:] -= channels[0]
    return (channels >> _SHIFTS[:, np.newaxis, np.newaxis]).astype(np.uint8).tobytes()


def _unplanes(data: NDArray[np.uint8]) -> NDArray[np.uint32]:
    planes = data.astype(np.uint32).reshape(4, 3, -1)
    channels = (planes << _SHIFTS[:, np.newaxis, np.newaxis]).sum(axis=0, dtype=np.uint32)
    channels[1:] += channels[0]
    return np.ascontiguousarray(channels.T)


@dataclass
class PictureStore:
    """The pictures of a page; equal ones are stored once. `texts[id]` is the encoded picture."""

    texts: list[str] = field(default_factory=list)
    _known: dict[bytes, int] = field(default_factory=dict)

    def add(self, pixels: Pixels) -> int:
        """The number of a picture in the page."""
        digest = hashlib.sha256(repr(pixels.shape).encode() + np.ascontiguousarray(pixels).tobytes()).digest()
        if digest not in self._known:
            self._known[digest] = len(self.texts)
            self.texts.append(encode_picture(pixels))
        return self._known[digest]


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
