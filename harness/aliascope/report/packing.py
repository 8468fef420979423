"""Pictures as bytes that deflate well, float32 to the bit. `unpack.js` is the other half of the page.

A pixel is coded by its ordinals: the bits of its floats as integers or, in the output of a renderer that has steps,
numbers of steps. What is stored is by how much they differ from what is known already: red from the reference at that
pixel, green and blue from red by the reference's differences, or from what `relations.py` says of the scene. A label a
pixel says which. Small differences have high bytes of 0, and bytes of one significance stand together.

    byte 0       0 labels, 1 palette; + 2 where colours are told from the reference; + 4 where there are steps
    8 bytes      the step, float64, where there are steps; all numbers are little-endian
    2 bytes      how many colours are in the palette, or stand for themselves under labels of their own
    colours      those, each as one pixel of the kind below, red told from the one before
    palette      then one index a pixel: one byte each where there are at most 256 colours, else all low bytes, then
                 all high ones
    labels       then the pixels, without those that are such a colour, or the reference's

Pixels are: their labels, one byte each (0 none, then lines, planes, colours; 255 the reference), the differences of
red, then of green and blue where neither a line nor a plane tells them, in four planes, highest byte first; then those
of green and blue on lines and of blue on planes, one byte each.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aliascope.records import Pixels
from aliascope.report.relations import NONE, Relations, words_of

Words = NDArray[np.int64]
Floats = NDArray[np.float64]

LABELS, PALETTE, FROM_REFERENCE, STEPS = 0, 1, 2, 4
LARGEST_PALETTE = 4096
SAME = 255
"""The label of a pixel that is the reference's."""
_MOST_OWN = 200
_LEAST_PIXELS = 6
"""That a colour must have to be stored as one: it costs up to 12 bytes."""
_NEAR = 63
"""Differences that fit into a byte, signed."""
_MOST_STEPS = 1 << 24
_LEVEL = 6
"""Of deflate: 9 saves 0.7 % more and takes seven times as long."""


@dataclass(frozen=True, eq=False)
class Known:
    """What both halves know of a scene before its pictures: the reference may be None, for itself and without one."""

    reference: Pixels | None = None
    relations: Relations = NONE


NOTHING = Known()


@dataclass(frozen=True)
class _Ordinals:
    """Between values and integers in their order: the floats' own bits, or numbers of steps."""

    step: float

    def of(self, values: NDArray[np.floating]) -> Words:
        if not self.step:
            with np.errstate(over="ignore", invalid="ignore"):
                return words_of(values.astype(np.float32))
        with np.errstate(over="ignore", invalid="ignore"):
            # half up, as Math.round has it
            whole = np.floor(np.nan_to_num(values.astype(np.float64)) / self.step + 0.5)
        return whole.clip(-_MOST_STEPS, _MOST_STEPS).astype(np.int64)

    def values(self, ordinals: Words) -> NDArray[np.float32]:
        if self.step:
            return (ordinals * self.step).astype(np.float32)
        return ordinals.astype("<i4").view("<f4").astype(np.float32)


def pack(pixels: Pixels, known: Known = NOTHING, step: float = 0.0) -> bytes:
    """The deflated bytes of a picture (height, width, 3) float32; `step`: of the renderer's output, 0 for float."""
    flat = np.ascontiguousarray(pixels, dtype=np.float32).reshape(-1, 3)
    ordinals = _ordinals_of(flat, step)
    words = words_of(flat)
    colours, index, counts = _distinct(words)
    bodies = []
    if len(colours) <= LARGEST_PALETTE:
        bodies.append(_palette(_values(colours), index, ordinals, known))
    if len(colours) > 256:
        own = np.sort(np.argsort(-counts, kind="stable")[:_MOST_OWN])
        own = own[counts[own] >= _LEAST_PIXELS]
        ways = (False, True) if known.reference is not None else (False,)
        bodies += [_labelled(flat, _values(colours[own]), own, index, ordinals, known, told) for told in ways]
    return min((zlib.compress(body, _LEVEL) for body in bodies), key=len)


def _distinct(words: Words) -> tuple[Words, Words, Words]:
    """The rows of (n, 3) words, each once and in order, which of them each row is, and how often each is there. As
    np.unique(axis=0), but by two sorts of numbers."""
    _, pairs = np.unique((words[:, 0] << 32) + words[:, 1], return_inverse=True)
    keys = (pairs.reshape(-1) << 32) + (words[:, 2] + (1 << 31))
    _, first, index, counts = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    return words[first], index.reshape(-1), counts


def _values(words: Words) -> NDArray[np.float32]:
    return _Ordinals(0.0).values(words)


def _ordinals_of(flat: NDArray[np.float32], step: float) -> _Ordinals:
    """In steps where these give the values back to the bit."""
    for candidate in (step, float(np.float32(step))):
        if candidate > 0.0:
            found = _Ordinals(candidate)
            if np.array_equal(words_of(found.values(found.of(flat))), words_of(flat)):
                return found
    return _Ordinals(0.0)


def _head(kind: int, ordinals: _Ordinals, colours: NDArray[np.float32], known: Known) -> bytes:
    kind += STEPS if ordinals.step else 0
    step = struct.pack("<d", ordinals.step) if ordinals.step else b""
    return struct.pack("<B", kind) + step + struct.pack("<H", len(colours)) + _pixels(colours, ordinals, known, None)


def _palette(colours: NDArray[np.float32], index: Words, ordinals: _Ordinals, known: Known) -> bytes:
    indices = index.astype(np.uint8).tobytes()
    if len(colours) > 256:
        indices += (index >> 8).astype(np.uint8).tobytes()
    return _head(PALETTE, ordinals, colours, known) + indices


def _labelled(
    flat: NDArray[np.float32],
    colours: NDArray[np.float32],
    own: Words,
    index: Words,
    ordinals: _Ordinals,
    known: Known,
    told: bool,
) -> bytes:
    relations = len(known.relations.lines) + len(known.relations.planes)
    labels = np.zeros(len(flat), np.uint8)
    if known.reference is not None:
        same = (words_of(flat) == words_of(known.reference.reshape(-1, 3))).all(axis=1)
        labels[same] = SAME
    place = np.full(int(index.max()) + 1, -1)
    place[own] = np.arange(len(own))
    its_own = place[index] >= 0
    labels[its_own] = 1 + relations + place[index][its_own]
    reference = known.reference.reshape(-1, 3) if told and known.reference is not None else None
    head = _head(LABELS + (FROM_REFERENCE if told else 0), ordinals, colours, known)
    return head + _pixels(flat, ordinals, known, reference, labels)


def _pixels(
    values: NDArray[np.float32],
    ordinals: _Ordinals,
    known: Known,
    reference: NDArray[np.float32] | None,
    labels: NDArray[np.uint8] | None = None,
) -> bytes:
    """Values (n, 3) as the text above has them; `labels` are of those that are told otherwise, in their place. Without
    labels, red is told from the value before."""
    inner = labels is not None
    labels = np.zeros(len(values), np.uint8) if labels is None else labels
    free = labels == 0
    k = ordinals.of(values)
    with np.errstate(invalid="ignore"):  # of signalling NaNs
        exact = values[free].astype(np.float64)
    labels[free], errors = _related(exact, k[free], ordinals, known.relations)
    before = k[:, 0].copy()
    if reference is not None:
        r = ordinals.of(reference)
        before -= r[:, 0]
        chroma = r[:, 1:] - r[:, :1]
    else:
        chroma = np.zeros((len(values), 2), np.int64)
        if not inner:
            before[1:] -= k[:-1, 0]
    lines = len(known.relations.lines)
    kind = np.where(labels[free] == 0, 0, np.where(labels[free] <= lines, 1, 2))
    rest = (k[:, 1:] - k[:, :1] - chroma)[free]
    far = [before[free], rest[kind != 1, 0], rest[kind == 0, 1]]
    near = np.concatenate([errors[kind == 1, 0], errors[kind > 0, 1]])
    return labels.tobytes() + b"".join(_planes(part) for part in far) + _zigzag(near).astype(np.uint8).tobytes()


def _related(values: Floats, k: Words, ordinals: _Ordinals, relations: Relations) -> tuple[NDArray[np.uint8], Words]:
    """The label of each value, and by how many steps green and blue differ from what its line or plane tells."""
    red, green = values[:, 0], values[:, 1]
    # What is computed from a NaN has bits that differ from machine to machine: none of it is told.
    best = np.where(np.isfinite(values).all(axis=1), _NEAR + 1, 0)
    labels = np.zeros(len(values), np.uint8)
    errors = np.zeros((len(values), 2), np.int64)
    with np.errstate(over="ignore", invalid="ignore"):
        for i, (g0, g1, b0, b1) in enumerate(relations.lines):
            off = k[:, 1:] - ordinals.of(np.stack([g0 + g1 * red, b0 + b1 * red], axis=1))
            _take(i + 1, np.abs(off).max(axis=1), off, best, labels, errors)
        on_line = labels > 0
        for i, (p0, p1, p2) in enumerate(relations.planes):
            off = np.zeros_like(errors)
            off[:, 1] = k[:, 2] - ordinals.of(p0 + p1 * red + p2 * green)
            miss = np.where(on_line, _NEAR + 1, np.abs(off[:, 1]))
            _take(i + 1 + len(relations.lines), miss, off, best, labels, errors)
    return labels, errors


def _take(label: int, miss: Words, off: Words, best: Words, labels: NDArray[np.uint8], errors: Words) -> None:
    better = miss < best
    best[better], labels[better], errors[better] = miss[better], label, off[better]


def _zigzag(values: Words) -> NDArray[np.uint32]:
    """0, -1, 1, -2, ... as 0, 1, 2, 3, ..., of differences mod 2^32."""
    signed = _wrapped(values)
    return np.where(signed >= 0, 2 * signed, -2 * signed - 1).astype(np.uint32)


def _planes(values: Words) -> bytes:
    found = _zigzag(values)
    return b"".join((found >> np.uint32(shift)).astype(np.uint8).tobytes() for shift in (24, 16, 8, 0))


# --- back -------------------------------------------------------------------------------------------------------------


class _Reader:
    """Takes bytes from the front. Raises ValueError where there are not as many."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, count: int) -> NDArray[np.uint8]:
        if self.at + count > len(self.data):
            raise ValueError("a packed picture ends too early")
        self.at += count
        return np.frombuffer(self.data, np.uint8, count, self.at - count)

    def signed(self, count: int, bytes_each: int) -> Words:
        """Differences in planes, highest byte first."""
        planes = self.take(count * bytes_each).reshape(bytes_each, count).astype(np.uint32)
        folded = np.zeros(count, np.uint32)
        for plane in planes:
            folded = (folded << np.uint32(8)) | plane
        found = folded.astype(np.int64)
        return np.where(found & 1, -(found >> 1) - 1, found >> 1)


def unpack(data: bytes, width: int, height: int, known: Known = NOTHING) -> Pixels:
    """The inverse of `pack`, given what that was given. Raises ValueError for what is not a picture of this size."""
    try:
        return _unpacked(_Reader(zlib.decompress(data)), width, height, known)
    except (ValueError, IndexError, struct.error, zlib.error) as error:
        raise ValueError(f"not a picture of {width} x {height} pixels: {error}") from error


def _unpacked(reader: _Reader, width: int, height: int, known: Known) -> Pixels:
    kind = int(reader.take(1)[0])
    ordinals = _Ordinals(struct.unpack("<d", reader.take(8).tobytes())[0] if kind & STEPS else 0.0)
    count = struct.unpack("<H", reader.take(2).tobytes())[0]
    colours = _read_pixels(reader, count, ordinals, known, None, None)
    total = width * height
    if kind & PALETTE:
        index = reader.take(total).astype(np.int64)
        if count > 256:
            index += reader.take(total).astype(np.int64) << 8
        flat = colours[index]
    else:
        reference = known.reference.reshape(-1, 3) if known.reference is not None else None
        flat = _read_pixels(reader, total, ordinals, known, reference, colours, bool(kind & FROM_REFERENCE))
    if reader.at != len(reader.data):
        raise ValueError(f"{len(reader.data) - reader.at} bytes are left over")
    return np.ascontiguousarray(flat.reshape(height, width, 3))


def _read_pixels(
    reader: _Reader,
    count: int,
    ordinals: _Ordinals,
    known: Known,
    reference: NDArray[np.float32] | None,
    colours: NDArray[np.float32] | None,
    told: bool = False,
) -> NDArray[np.float32]:
    lines, planes = known.relations.lines, known.relations.planes
    labels = reader.take(count).astype(np.int64)
    relations = len(lines) + len(planes)
    free = labels <= relations
    kinds = np.where(labels == 0, 0, np.where(labels <= len(lines), 1, 2))[free]
    red = reader.signed(int(free.sum()), 4)
    green_far = reader.signed(int((kinds != 1).sum()), 4)
    blue_far = reader.signed(int((kinds == 0).sum()), 4)
    green_near = reader.signed(int((kinds == 1).sum()), 1)
    blue_near = reader.signed(int((kinds > 0).sum()), 1)
    k = np.zeros((len(red), 3), np.int64)
    chroma = np.zeros((len(red), 2), np.int64)
    if told:
        if reference is None:
            raise ValueError("a picture that was told from a reference has none")
        r = ordinals.of(reference[free])
        red, chroma = red + r[:, 0], r[:, 1:] - r[:, :1]
    k[:, 0] = _wrapped(red if colours is not None else np.cumsum(red))
    with np.errstate(over="ignore", invalid="ignore"):
        reds = ordinals.values(k[:, 0]).astype(np.float64)
        on = kinds != 1
        k[on, 1] = _wrapped(green_far + k[on, 0] + chroma[on, 0])
        k[~on, 1] = green_near + _told(labels[free][~on], 1, lines[:, :2], reds[~on, np.newaxis], ordinals)
        greens = ordinals.values(k[:, 1]).astype(np.float64)
        on = kinds == 0
        k[on, 2] = _wrapped(blue_far + k[on, 0] + chroma[on, 1])
        blue = np.zeros(len(k), np.int64)
        by_line, by_plane = kinds == 1, kinds == 2
        blue[by_line] = _told(labels[free][by_line], 1, lines[:, 2:], reds[by_line, np.newaxis], ordinals)
        both = np.stack([reds, greens], axis=1)[by_plane]
        blue[by_plane] = _told(labels[free][by_plane], 1 + len(lines), planes, both, ordinals)
        k[~on, 2] = blue[~on] + blue_near
    found = np.empty((count, 3), np.float32)
    found[free] = ordinals.values(k)
    if colours is not None and reference is not None:
        found[labels == SAME] = reference[labels == SAME]
    own = ~free & (labels != SAME)
    if own.any():
        if colours is None or labels[own].max() > relations + len(colours):
            raise ValueError("a picture has a label of nothing")
        found[own] = colours[labels[own] - relations - 1]
    return found


def _told(labels: Words, first: int, relations: Floats, knowns: Floats, ordinals: _Ordinals) -> Words:
    """What each value's relation tells: its start, and a slope times each of what is known."""
    chosen = relations[labels - first]
    told = chosen[:, 0]
    for slope, value in zip(chosen.T[1:], knowns.T, strict=True):
        told = told + slope * value
    return ordinals.of(told)


def _wrapped(values: Words) -> Words:
    """Mod 2^32, signed."""
    return values.astype(np.uint64).astype(np.uint32).view(np.int32).astype(np.int64)
