"""From pictures to what is kept of them: a picture to a `Replicate`, a cell's replicates to an `Observed`.

A worker summarises the pictures that it rendered (`Observer`, `Part`); parts of one cell are joined where all are there
(`observed`), so that no picture but the first has to travel.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.stats import t as student

from aliascope.agreement import welch
from aliascope.errors import CheckFailed
from aliascope.geometry import Array
from aliascope.records import Cost, Estimate, Pixels
from aliascope.regression.records import CellName, Draw, Judged, Observed, Replicate, WorstPixel
from aliascope.regression.templates import Basis, Surroundings, block_means, moved, names_of


@dataclass(frozen=True)
class Target:
    """What the pictures of a cell should be: (height, width, 3) float64, and the standard errors of its values, where
    it is a converged one."""

    reference: Array
    standard_error: Array | None = None

    @property
    def size(self) -> tuple[int, int]:
        return self.reference.shape[1], self.reference.shape[0]


@dataclass(frozen=True)
class Moments:
    """Of `count` pictures, value by value: the mean, and the sum of squared differences from it."""

    count: int
    mean: Array
    squares: Array

    def joined(self, other: Moments) -> Moments:
        """Of both together (Chan, Golub, LeVeque 1979)."""
        count = self.count + other.count
        apart = other.mean - self.mean
        return Moments(
            count,
            self.mean + apart * (other.count / count),
            self.squares + other.squares + apart**2 * (self.count * other.count / count),
        )

    @property
    def variance(self) -> Array:
        return self.squares / max(1, self.count - 1)


@dataclass(frozen=True)
class Part:
    """What is kept of some pictures of a cell: of each a replicate, and the moments of picture - reference.

    `first`: the first of them, if it is not shifted. `known`, `known_blocks`: as in `Observed`, were values
    independent."""

    replicates: tuple[Replicate, ...]
    moments: Moments
    first: Pixels | None
    quantum: float
    known: tuple[float, ...]
    known_blocks: tuple[float, ...]


class Observer:
    """Summarises pictures beside one target. Under a shift they are compared with the target moved as far."""

    def __init__(self, target: Target) -> None:
        self._target = target
        self._names = names_of(target.reference)
        self._basis = Basis(target.reference, self._names)
        self._surroundings = Surroundings(target.reference)

    def part(self, made: Sequence[tuple[Draw, Pixels, Cost]], quantum: float = 0.0) -> Part:
        """All that is kept of these pictures. Raises CheckFailed for one that has not the target's size."""
        replicates, differences = [], []
        for draw, pixels, cost in made:
            replicate, difference = self._replicate(draw, pixels, cost)
            replicates.append(replicate)
            differences.append(np.where(np.isfinite(difference), difference, 0.0))
        stacked = np.array(differences)
        # Around the first: equal pictures have no variance, not that of their rounding.
        apart = stacked - stacked[0]
        mean = apart.mean(axis=0)
        moments = Moments(len(stacked), stacked[0] + mean, ((apart - mean) ** 2).sum(axis=0))
        spread = self._target.standard_error
        none = np.zeros_like(self._target.reference)
        return Part(
            tuple(replicates),
            moments,
            made[0][1] if made[0][0].shift == (0.0, 0.0) else None,
            quantum,
            self._basis.known(none if spread is None else spread),
            self._basis.known_blocks(none if spread is None else spread),
        )

    def _replicate(self, draw: Draw, pixels: Pixels, cost: Cost) -> tuple[Replicate, Array]:
        """What is kept of a picture, and its difference from what it should be."""
        if pixels.shape != self._target.reference.shape:
            (height, width), (wide, high) = pixels.shape[:2], self._target.size
            raise CheckFailed(f"the picture has {width} x {height} pixels, its reference {wide} x {high}")
        values = pixels.astype(np.float64)
        shifted = draw.shift != (0.0, 0.0)
        basis, surroundings = self._basis, self._surroundings
        if shifted:
            reference = moved(self._target.reference, draw.shift)
            basis, surroundings = Basis(reference, self._names), Surroundings(reference)
        finite = np.isfinite(values)
        difference = np.where(finite, values, np.nan) - basis.reference
        squares = block_means(difference**2) if not shifted else np.empty(0)
        seen = values[finite]
        replicate = Replicate(
            draw=draw,
            sha256=digest(pixels),
            coefficients=basis.coefficients(difference),
            blocks=basis.blocks(difference),
            rmse=None if shifted else float(np.sqrt((difference**2).mean())),
            block_squares=tuple(squares.ravel().tolist()),
            least=float(seen.min(initial=np.inf)),
            largest=float(seen.max(initial=-np.inf)),
            not_finite=int((~finite).any(axis=2).sum()),
            outlier=surroundings.outlier(values),
            samples=cost.samples,
            rays=dict(cost.rays),
            cpu_seconds=cost.cpu_seconds,
        )
        return replicate, difference


def digest(pixels: Pixels) -> str:
    """SHA-256 of the pixels as little-endian float32, row by row."""
    return hashlib.sha256(np.ascontiguousarray(pixels, dtype="<f4").tobytes()).hexdigest()


def observed(
    name: CellName,
    judged: Judged,
    scene_digest: str,
    filter_: str,
    target: Target,
    parts: Sequence[Part],
    versions: Mapping[str, str],
    metrics: Mapping[str, Estimate] | None = None,
    together: bool = False,
) -> Observed:
    """All of a cell, from its parts in their order.

    together: all pixels have the same pattern of samples, and meet or miss alike. filter_: of its pictures; under
    another than the box pixels share samples, and what is known of the reference's noise counts for more, as it does
    for the pictures' own.
    """
    replicates = tuple(replicate for part in parts for replicate in part.replicates)
    moments = parts[0].moments
    for part in parts[1:]:
        moments = moments.joined(part.moments)
    samples = replicates[0].samples / (target.size[0] * target.size[1])
    floor = _floor(target.reference, samples, moments.count)
    factor = 1.0 if filter_ == "box" else _correlation(replicates, moments.variance, target.reference)
    unshifted = all(replicate.draw.shift == (0.0, 0.0) for replicate in replicates)
    first = parts[0].first
    mean, p_values, worst = None, None, None
    if unshifted:
        mean = target.reference + moments.mean
        p_values, worst = _by_pixel(target, moments, floor)
    elif first is not None:
        mean = first.astype(np.float64)
        worst = _furthest(target, mean)
    return Observed(
        name=name,
        judged=judged,
        scene_digest=scene_digest,
        size=target.size,
        filter=filter_,
        names=names_of(target.reference),
        replicates=replicates,
        known=tuple(factor**0.5 * each for each in parts[0].known),
        known_blocks=tuple(factor**0.5 * each for each in parts[0].known_blocks),
        scatter=float(moments.variance.mean()),
        versions=dict(versions),
        metrics=dict(metrics or {}),
        quantum=parts[0].quantum,
        floor_blocks=Basis(target.reference, ()).floor_blocks(floor, together),
        first=first,
        mean=mean,
        p_values=p_values,
        worst=worst,
    )


def _correlation(replicates: Sequence[Replicate], variance: Array, reference: Array) -> float:
    """How much more the means over blocks scatter than if values were independent, 1 or more."""
    basis = Basis(reference, ())
    together = np.array([replicate.blocks for replicate in replicates]).var(axis=0, ddof=1)
    apart = np.array(basis.known_blocks(np.sqrt(variance))) ** 2
    return max(1.0, float(np.nansum(together) / apart.sum())) if apart.sum() > 0.0 else 1.0


def _floor(reference: Array, samples: float, pictures: int) -> Array:
    """The least standard error of each value of the mean of so many pictures, of so many samples a pixel: that of one
    sample more or less in each, of those that see the least and the largest value nearby. A sliver that no sample met
    leaves no variance."""
    nearby = ndimage.maximum_filter(reference, (3, 3, 1)) - ndimage.minimum_filter(reference, (3, 3, 1))
    floor: Array = nearby / (samples * np.sqrt(pictures))
    return floor


def _by_pixel(target: Target, moments: Moments, floor: Array) -> tuple[Array, WorstPixel]:
    """Student's test of each value against the reference: two-sided p-values, for people to look at, and where the mean
    is furthest from the reference."""
    reference = target.reference
    own = np.maximum(moments.variance / moments.count, floor**2)
    known = np.zeros_like(own) if target.standard_error is None else target.standard_error**2
    spread = np.sqrt(own + known) + np.finfo(np.float32).eps * (1.0 + np.abs(reference))
    score = np.abs(moments.mean) / spread
    freedom = welch(own, known, max(1, moments.count - 1), np.inf)
    p_values = 2.0 * np.asarray(student.sf(score, freedom))
    return p_values, _pixel(score, reference + moments.mean, reference)


def _furthest(target: Target, picture: Array) -> WorstPixel:
    """Where one picture is furthest from the reference, relative to brightness."""
    brightest = Basis(target.reference, ()).brightest
    score = np.abs(picture - target.reference) / (brightest + 0.1)
    return _pixel(np.where(np.isfinite(score), score, np.inf), picture, target.reference)


def _pixel(score: Array, picture: Array, reference: Array) -> WorstPixel:
    row, column, channel = (int(i) for i in np.unravel_index(int(np.argmax(score)), score.shape))
    value, expected = (float(each[row, column, channel]) for each in (picture, reference))
    return WorstPixel(column, row, channel, value, expected)
