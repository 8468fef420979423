"""`aliascope points`: points as a table or a drawing, their statistics, or their spectrum."""

from __future__ import annotations

import dataclasses
import io
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope import point_sets, statistics
from aliascope.errors import InvalidInput, NotWritable, Unsupported
from aliascope.records import Estimate
from aliascope.studies.point_source import PointSource

Array = NDArray[np.float64]
DRAWN = (".svg", ".png")
REALISATIONS = 10
"""Of a randomised pattern's spectrum, where it is not said."""
MOST_POINTS = {"statistics": 1_000_000, "spectrum": 10_000_000}
"""Of all realisations together: one to two minutes."""


@dataclass(frozen=True)
class Asked:
    """The options that say what of the points is wanted. None: not said."""

    weights: bool = False
    statistics: bool = False
    spectrum: bool = False
    dimensions: str | None = None
    realisations: int | None = None
    cut_off: int | None = None
    base: int | None = None
    out: Path | None = None

    def check(self) -> None:
        """Raises InvalidInput for options that do not go together, and files that nothing is written as."""
        averaged = self.statistics or self.spectrum
        for wrong, text in (
            (self.statistics and self.spectrum, "--statistics and --spectrum: one at a time"),
            (self.statistics and self.out is not None, "--statistics are no file; --json gives all of them"),
            (self.weights and averaged, "--weights are a column of the points, not of their statistics or spectrum"),
            (self.realisations is not None and not averaged, "--realisations needs --statistics or --spectrum"),
            (self.cut_off is not None and not self.spectrum, "--cut-off needs --spectrum"),
            (self.base is not None and not self.statistics, "--base needs --statistics"),
        ):
            if wrong:
                raise InvalidInput(text)
        if self.out is not None and self.out.suffix.lower() not in (".csv", ".npy", *DRAWN):
            raise InvalidInput(f'{self.out}: points are written as .csv, .npy, .svg or .png, not "{self.out.suffix}"')


def answer(asked: Asked, source: PointSource) -> Table | Statistics | Spectrum:
    """What was asked for of these points. Raises InvalidInput, Unsupported."""
    asked.check()
    if asked.statistics:
        of = _averaged("statistics", source, asked)
        return _statistics(of, 2 if asked.base is None else asked.base)
    if asked.spectrum:
        of = _averaged("spectrum", source, asked)
        return Spectrum(of, point_sets.point_spectrum(of, asked.cut_off))
    return Table(source, _dimensions(asked.dimensions, source.d, source.d), asked.weights)


def _dimensions(text: str | None, d: int, default: int) -> list[int]:
    """The dimensions of "A,B,...", or the first `default` there are."""
    if text is None:
        return list(range(min(d, default)))
    try:
        chosen = [int(part) for part in text.split(",")]
    except ValueError:
        raise InvalidInput(f'--dimensions "{text}" is not of the form A,B') from None
    if not all(0 <= dimension < d for dimension in chosen) or len(set(chosen)) < len(chosen):
        raise InvalidInput(f"--dimensions {text}: each once, of 0 to {d - 1}; -d says how many there are")
    return chosen


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error


# --- the points themselves --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Table:
    """Points, with a last column of weights if asked for."""

    source: PointSource
    dimensions: list[int]
    weights: bool

    def _chunks(self) -> Iterator[Array]:
        columns = [*self.dimensions, self.source.d] if self.weights else self.dimensions
        for rows in self.source.chunks(self.weights):
            yield rows[:, columns]

    def texts(self) -> Iterator[str]:
        """CSV, no header, 17 significant digits, in pieces."""
        for rows in self._chunks():
            text = io.StringIO()
            np.savetxt(text, rows, fmt="%.17g", delimiter=",")
            yield text.getvalue()

    def document(self) -> dict[str, Any]:
        """What --json prints."""
        return {**self.source.document, "points": np.concatenate(list(self._chunks())).tolist()}

    def write(self, path: Path) -> None:
        """Writes .csv or .npy, or draws the first two dimensions as .svg or .png, a third or the weights as colour.

        Raises Unsupported where there is but one, NotWritable.
        """
        ending = path.suffix.lower()
        if ending in DRAWN and len(self.dimensions) < 2:
            raise Unsupported("a drawing of points needs two dimensions")
        values = np.concatenate(list(self._chunks()))
        if ending in DRAWN:
            from aliascope.studies import point_pictures as pictures

            figure = pictures.points_figure(values, self.source.name, self.dimensions, self.weights)
            with _writing(path):
                pictures.save(figure, path)
            return
        with _writing(path):
            if ending == ".csv":
                np.savetxt(path, values, fmt="%.17g", delimiter=",")
            else:
                np.save(path, np.ascontiguousarray(values))


# --- realisations -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Averaged:
    """Realisations of a source, in some of its dimensions, to be averaged."""

    source: PointSource
    dimensions: list[int]
    realisations: int

    def __iter__(self) -> Iterator[Array]:
        for index in range(self.realisations):
            yield self.source.realisation(index)[:, self.dimensions]

    @property
    def text(self) -> str:
        """Such as "64 points, dimensions 0 and 1, mean of 10 realisations"."""
        n, names = self.source.n, ", ".join(map(str, self.dimensions))
        text = f"{n} point{'s' * (n != 1)}, dimension{'s' * (len(self.dimensions) != 1)} {names}"
        if self.realisations > 1:
            return f"{text}; mean of {self.realisations} realisations"
        return f"{text}; one realisation" + ("" if self.source.randomised else " (not randomised)")

    def document(self, of: str, values: dict[str, Any], details: dict[str, Any]) -> dict[str, Any]:
        """What --json prints."""
        counted = {"dimensions": self.dimensions, "realisations": self.realisations}
        return {**self.source.document, of: values, "details": {**counted, "text": self.text, **details}}


def _averaged(of: str, source: PointSource, asked: Asked) -> Averaged:
    """The realisations for "statistics" (one if not said) or a "spectrum" (ten).

    A pattern that is not randomised has one realisation, and more can't be asked for.
    """
    if not source.randomised and (asked.realisations or 1) > 1:
        raise InvalidInput(f"{source.name} is not randomised: it has one realisation, not {asked.realisations}")
    default = REALISATIONS if of == "spectrum" and source.randomised else 1
    count = default if asked.realisations is None else asked.realisations
    if source.n * count > MOST_POINTS[of]:
        raise InvalidInput(
            f"--{of} of {count} x {source.n} points would take minutes: take {MOST_POINTS[of]} or fewer in all, "
            "by -n or --realisations"
        )
    return Averaged(source, _dimensions(asked.dimensions, source.d, 2), count)


# --- statistics -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Statistics:
    """The means of the statistics by name, and why one is missing."""

    of: Averaged
    base: int
    values: dict[str, Estimate]
    reasons: dict[str, str]

    def document(self) -> dict[str, Any]:
        """What --json prints."""
        details: dict[str, Any] = {"base": self.base, "reasons": self.reasons}
        if self.of.realisations > 1:
            details["standard-errors"] = {name: each.standard_error for name, each in self.values.items()}
        return self.of.document("statistics", {name: each.value for name, each in self.values.items()}, details)

    def texts(self) -> Iterator[str]:
        """The same as a table, line by line."""
        yield f"{self.of.source.name}: {self.of.text}\n"
        for name, each in self.values.items():
            value = "none" if each.value is None else f"{each.value:.6g}"
            error = "" if each.standard_error is None else f" +- {each.standard_error:.1e}"
            yield f"{name:<32}{value:>12}{error}  {self._remark(name, each.value)}".rstrip() + "\n"

    def write(self, path: Path) -> None:
        """Raises InvalidInput: they are no file."""
        raise InvalidInput(f"{path}: statistics are not written to a file")

    def _remark(self, name: str, value: float | None) -> str:
        n, s = self.of.source.n, len(self.of.dimensions)
        if value is None:
            return self.reasons[name]
        if name == "minimum-distance-share":
            return f"of the densest packing's {point_sets.densest_distance(n, s):.6g}"
        if name.startswith("voronoi"):
            return f"{value * n:.4g} / n"
        if name == "t-value" and self.of.realisations == 1:
            return f"a ({value:.0f}, {round(math.log(n, self.base))}, {s})-net in base {self.base}"
        return ""


def _statistics(of: Averaged, base: int) -> Statistics:
    """Mean and standard error of each statistic over the realisations."""
    each = [point_sets.point_statistics(points, base) for points in of]
    names = [field.name for field in dataclasses.fields(point_sets.PointStatistics) if field.name != "reasons"]
    reasons = {name.replace("_", "-"): text for one in each for name, text in one.reasons.items()}
    values = {}
    for name in names:
        found = [value for one in each if (value := getattr(one, name)) is not None]
        values[name.replace("_", "-")] = statistics.mean(found) if len(found) == len(each) else Estimate(None)
    return Statistics(of, base, values, reasons)


# --- spectrum ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Spectrum:
    """A mean spectrum of two dimensions."""

    of: Averaged
    spectrum: point_sets.PointSpectrum

    def document(self) -> dict[str, Any]:
        """What --json prints; null for what a ring does not have."""
        found = self.spectrum
        columns = {
            "frequency": found.frequencies.tolist(),
            "power": found.radial_power.tolist(),
            "anisotropy": [None if math.isnan(value) else value for value in found.anisotropy.tolist()],
            "standard-error": None if found.standard_error is None else found.standard_error.tolist(),
        }
        return self.of.document("spectrum", columns, {"anisotropy-unit": "dB"})

    def texts(self) -> Iterator[str]:
        """CSV with the names of the columns above; no anisotropy is an empty field."""
        yield "frequency,power,anisotropy\n"
        found = self.spectrum
        for frequency, power, ratio in zip(found.frequencies, found.radial_power, found.anisotropy, strict=True):
            yield f"{frequency},{power:.17g},{'' if math.isnan(ratio) else f'{ratio:.17g}'}\n"

    def write(self, path: Path) -> None:
        """Writes `texts` as .csv, the two-dimensional power as .npy, or draws both as .svg or .png.

        Raises NotWritable.
        """
        ending = path.suffix.lower()
        if ending in DRAWN:
            from aliascope.studies import point_pictures as pictures

            figure = pictures.spectrum_figure(self.spectrum, self.of.source.name, self.of.text, self.of.dimensions)
            with _writing(path):
                pictures.save(figure, path)
            return
        with _writing(path):
            if ending == ".csv":
                path.write_text("".join(self.texts()), encoding="utf-8")
            else:
                np.save(path, self.spectrum.power)
