"""What ties the channels of a scene's pictures together, so that one tells the others almost to the bit.

Light on one material is `a + b L` in each channel, a line in RGB; two lights of different colours make a plane; an edge
between two flat colours is a line. A picture of samples of those has its pixels on the same lines and planes, but for
the rounding of each channel. They are sought in some pictures of a scene, and kept once for all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aliascope.records import Pixels

Floats = NDArray[np.float64]
Words = NDArray[np.int64]

MOST_LINES, MOST_PLANES = 12, 8
LEAST_SHARE = 0.01
"""Of the colours looked at, which a line or plane must have: it costs four or three numbers, and a label a pixel."""
_PICTURES = 6
_COLOURS = 6000
_CANDIDATES = 256
_REFINED = 8
"""Of the candidates, those that are refined before the best is taken: close points lay a poor line."""
_REACH = 5
"""Pixels between those that a candidate is laid through: neighbours are mostly of one material."""
_TOLERANCES = (512, 256, 48, 24)
"""In steps of float32: what a candidate is judged by, then those of its refinements by least squares."""


@dataclass(frozen=True)
class Relations:
    """`lines` (k, 4): green = l0 + l1 red, blue = l2 + l3 red. `planes` (m, 3): blue = p0 + p1 red + p2 green."""

    lines: Floats
    planes: Floats


NONE = Relations(np.zeros((0, 4)), np.zeros((0, 3)))


def words_of(values: NDArray[np.floating]) -> Words:
    """The bits of float32 values as signed integers: for positive ones in the order of the values."""
    return np.ascontiguousarray(values, dtype="<f4").view("<i4").astype(np.int64)


def find_relations(pictures: Sequence[Pixels]) -> Relations:
    """The lines and planes that the pictures of a scene, all of one size, have many of their colours on."""
    rng = np.random.default_rng(0)
    step = max(1, -(-len(pictures) // _PICTURES))
    stack = np.stack(list(pictures[::step])) if pictures else np.zeros((0, 1, 1, 3), np.float32)
    flat = stack.reshape(-1, 3)
    colours = np.unique(flat[np.isfinite(flat).all(axis=1)], axis=0)
    colours = colours[np.abs(colours).max(axis=1) < 1e6] if len(colours) else colours
    if len(colours) < 64:
        return NONE  # few enough to be stored as they are
    if len(colours) > _COLOURS:
        colours = colours[rng.choice(len(colours), _COLOURS, replace=False)]
    rest = colours.astype(np.float64)
    lines, rest = _search(rest, stack, 2, MOST_LINES, rng)
    planes, _ = _search(rest, stack, 3, MOST_PLANES, rng)
    return Relations(np.array(lines).reshape(-1, 4), np.array(planes).reshape(-1, 3))


def _search(
    rest: Floats, stack: Pixels, points: int, most: int, rng: np.random.Generator
) -> tuple[list[Floats], Floats]:
    """The best relation through so many points, again and again on the colours that the ones before left."""
    through, off = (_line_through, line_errors) if points == 2 else (_plane_through, plane_errors)
    least = max(32.0, LEAST_SHARE * len(rest))
    found: list[Floats] = []
    while len(found) < most and len(rest) >= least:
        sample = rest if len(rest) <= 1500 else rest[rng.choice(len(rest), 1500, replace=False)]
        candidates = through(_neighbours(stack, points, rng))
        if not len(candidates):
            break
        held = (off(candidates, sample) <= _TOLERANCES[0]).sum(axis=1)
        promising = np.argsort(-held, kind="stable")[:_REFINED]
        refined = np.array([_refined(candidates[i], sample, points, off) for i in promising])
        kept = (off(refined, sample) <= _TOLERANCES[-1]).sum(axis=1)
        best = _refined(refined[int(kept.argmax())], rest, points, off)
        inside = off(best[np.newaxis], rest)[0] <= _TOLERANCES[-1]
        if inside.sum() < least:
            break
        found.append(best)
        rest = rest[~inside]
    return found, rest


def _neighbours(stack: Pixels, points: int, rng: np.random.Generator) -> Floats:
    """(candidates, points, 3) colours, each group from near one place of one picture."""
    count, height, width = stack.shape[:3]
    picture = rng.integers(count, size=(_CANDIDATES, 1))
    y = rng.integers(height, size=(_CANDIDATES, 1)) + rng.integers(-_REACH, _REACH + 1, (_CANDIDATES, points))
    x = rng.integers(width, size=(_CANDIDATES, 1)) + rng.integers(-_REACH, _REACH + 1, (_CANDIDATES, points))
    chosen: Floats = stack[picture, y.clip(0, height - 1), x.clip(0, width - 1)].astype(np.float64)
    return chosen[np.isfinite(chosen).all(axis=(1, 2))]


def _line_through(groups: Floats) -> Floats:
    first, second = groups[:, 0], groups[:, 1]
    apart = second - first
    usable = np.abs(apart[:, 0]) > 1e-3
    first, apart = first[usable], apart[usable]
    slopes = apart[:, 1:] / apart[:, :1]
    starts = first[:, 1:] - slopes * first[:, :1]
    return np.stack([starts[:, 0], slopes[:, 0], starts[:, 1], slopes[:, 1]], axis=1)


def _plane_through(groups: Floats) -> Floats:
    matrix = np.concatenate([np.ones((*groups.shape[:2], 1)), groups[:, :, :2]], axis=2)
    usable = np.abs(np.linalg.det(matrix)) > 1e-6
    solved: Floats = np.linalg.solve(matrix[usable], groups[usable][:, :, 2:])[:, :, 0]
    return solved


def _refined(relation: Floats, colours: Floats, points: int, off: Callable[[Floats, Floats], Words]) -> Floats:
    """The relation by least squares over what it holds, in ever narrower limits."""
    for tolerance in _TOLERANCES[:-1]:
        held = colours[off(relation[np.newaxis], colours)[0] <= tolerance]
        if len(held) < 8:
            break
        centre = held.mean(axis=0)  # without it, the squares would cancel
        known, sought = (held - centre)[:, : points - 1], (held - centre)[:, points - 1 :]
        slopes = np.linalg.lstsq(known, sought, rcond=None)[0]
        starts = centre[points - 1 :] - centre[: points - 1] @ slopes
        relation = np.concatenate([starts[np.newaxis], slopes]).T.reshape(-1)
    return relation


def line_errors(lines: Floats, colours: Floats) -> Words:
    """(k, n): by how many steps of float32 each line misses green or blue of each colour, whichever is more."""
    red = colours[:, 0]
    green = lines[:, :1] + lines[:, 1:2] * red
    blue = lines[:, 2:3] + lines[:, 3:4] * red
    return np.maximum(_apart(green, colours[:, 1]), _apart(blue, colours[:, 2]))


def plane_errors(planes: Floats, colours: Floats) -> Words:
    """(m, n): by how many steps of float32 each plane misses blue."""
    return _apart(planes[:, :1] + planes[:, 1:2] * colours[:, 0] + planes[:, 2:3] * colours[:, 1], colours[:, 2])


def _apart(predicted: Floats, values: Floats) -> Words:
    with np.errstate(over="ignore", invalid="ignore"):
        apart: Words = np.abs(words_of(predicted.astype(np.float32)) - words_of(values))
    return apart
