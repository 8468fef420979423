"""The error pictures of a scene as signals: the radial spectrum of each, on the same rings."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput
from aliascope.records import ModeRow, Pixels, ReportData, SceneSection
from aliascope.spectrum import RadialSpectrum, radial_spectrum

MOST_RINGS = 72
"""Rings of a spectrum in the page: all those of a picture of up to 96 lines; of larger ones, neighbours are joined."""

DIGITS = 4
"""Significant digits of a power; its standard error is some 2 / sqrt(bins), over 1% in all but the largest pictures."""

EQUAL = "equals the reference: no error, no spectrum"
CONSTANT = "is off by the same everywhere: all of its error is at frequency 0"
SMALL = "is too small for a spectrum"
NOT_FINITE = "has values that are no numbers: no spectrum"


@dataclass(frozen=True)
class SceneSpectra:
    """The spectra of a scene's rows, in their order: the mean power density of each ring, or why there is none.

    `frequencies` and `bins` are those of RadialSpectrum, of rings that all rows share, see `joined`.
    """

    frequencies: tuple[float, ...]
    bins: tuple[int, ...]
    rows: tuple[tuple[float, ...] | str, ...]


def spectra_of(data: ReportData) -> list[SceneSpectra]:
    """The spectra of every scene. Raises InvalidInput where a picture has not its reference's size."""
    return [scene_spectra(scene) for scene in data.scenes]


def scene_spectra(scene: SceneSection) -> SceneSpectra:
    """The spectra of one scene. Raises InvalidInput where a picture has not its reference's size."""
    rings = joined(radial_spectrum(np.zeros(scene.reference.shape[:2])))
    return SceneSpectra(
        frequencies=tuple(float(f"{f:.6g}") for f in rings.frequencies),
        bins=tuple(int(count) for count in rings.bins),
        rows=tuple(_powers(row, scene) for row in scene.rows),
    )


def _powers(row: ModeRow, scene: SceneSection) -> tuple[float, ...] | str:
    check_size(row, scene)
    if not (np.isfinite(row.pixels).all() and np.isfinite(scene.reference).all()):
        return NOT_FINITE
    error = row.pixels.astype(np.float64) - scene.reference.astype(np.float64)
    if not error.any():
        return EQUAL
    power = joined(radial_spectrum(error)).power
    if not power.size:
        return SMALL
    if power.max() <= 1e-20 * np.square(error).max():  # the rounding of a mean that leaves nothing, (1e-16)^2 a pixel
        return CONSTANT
    return tuple(float(f"{value:.{DIGITS}g}") for value in power)


def check_size(row: ModeRow, scene: SceneSection) -> None:
    """Raises InvalidInput where a picture has not the size of its reference."""
    if row.pixels.shape != scene.reference.shape:
        raise InvalidInput(
            f"{scene.name}: {row.renderer} {row.mode}: the picture is {_size(row.pixels)}, "
            f"its reference {_size(scene.reference)}"
        )


def _size(pixels: Pixels) -> str:
    return " x ".join(str(side) for side in pixels.shape[1::-1] + pixels.shape[2:])


def joined(spectrum: RadialSpectrum, most: int = MOST_RINGS) -> RadialSpectrum:
    """A spectrum without frequency 0, in at most so many rings: each the mean of as many neighbours, by their bins.

    sum(bins * power) stays, but for that of frequency 0, which is 0 but for rounding. It is left out where it has a
    ring of its own: in a picture over twice as wide as high, or the other way, it shares one with waves along.
    """
    first = 1 if spectrum.bins[0] == 1 else 0
    count = len(spectrum.bins) - first
    starts = np.arange(0, count, -(-count // most) or 1)

    def total(values: NDArray[Any]) -> NDArray[Any]:
        return np.add.reduceat(values[first:], starts) if count else values[first:]

    bins = total(spectrum.bins)
    return RadialSpectrum(
        frequencies=total(spectrum.bins * spectrum.frequencies) / bins,
        power=total(spectrum.bins * spectrum.power) / bins,
        bins=bins,
    )


def spectra_json(spectra: SceneSpectra) -> dict[str, Any]:
    """For the page's scripts: `rows` has a list of powers for each row of the scene, or a sentence in its place."""
    return {
        "frequencies": list(spectra.frequencies),
        "bins": list(spectra.bins),
        "rows": [row if isinstance(row, str) else list(row) for row in spectra.rows],
    }


def spectra_csv(spectra: SceneSpectra, rows: Sequence[ModeRow]) -> str:
    """One line a ring, one column of power densities a row of the scene; empty where it has no spectrum."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["cycles_per_pixel", "bins", *(f"{row.renderer} {row.mode}" for row in rows)])
    for i, (frequency, bins) in enumerate(zip(spectra.frequencies, spectra.bins, strict=True)):
        writer.writerow([frequency, bins, *(None if isinstance(row, str) else row[i] for row in spectra.rows)])
    return out.getvalue()
