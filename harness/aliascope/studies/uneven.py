"""`aliascope uneven`: how right each method of weighting is where samples crowd on one side of an edge."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope import statistics
from aliascope.errors import InvalidInput, NotWritable
from aliascope.native import filters, uneven
from aliascope.records import Estimate
from aliascope.studies.uneven_samples import CrowdedSamples, StoredSamples

Array = NDArray[np.float64]
Samples = CrowdedSamples | StoredSamples
REALISATIONS = 64
MOST_SAMPLES = 20_000_000
"""Of all realisations and methods together: half a minute to a minute."""
POSITIONS = 129
"""Of the edge, evenly from one border of the filter's support to the other; the middle one is the pixel's centre."""


@dataclass(frozen=True)
class Outcome:
    """A method's error, filtered value minus truth, for vertical edges at `positions`, 1 on their left.

    `rmse` over positions and realisations; `at_middle`: the mean error of the edge that the samples crowd beside.
    `mean` and `deviation` over realisations, at each position. `samples`, `weights`: of the first realisation.
    """

    method: str
    filter: str
    rmse: Estimate
    at_middle: Estimate
    positions: Array
    mean: Array
    deviation: Array
    samples: Array
    weights: Array


@dataclass(frozen=True)
class Study:
    """What came out for each method."""

    samples: Samples
    realisations: int
    outcomes: tuple[Outcome, ...]


def study(samples: Samples, methods: Sequence[str], under: str, realisations: int | None = None) -> Study:
    """Filters edges by these methods, all of them where none is named, with the filter `under`; one that is a filter of
    its own with that. `realisations`: if not given 64, or 1 of samples that are not randomised.

    Raises SpecError, InvalidInput, Unsupported, JobFailed.
    """
    if (realisations or 1) > 1 and not samples.randomised:
        raise InvalidInput(f"{samples.name} is not randomised: it has one realisation, not {realisations}")
    count = realisations or (REALISATIONS if samples.randomised else 1)
    chosen, own = filters.canonical(under), {info.name: info.filter for info in uneven.registered()}
    under_which: dict[str, str] = {}
    for method in (uneven.canonical(method) for method in methods or own):
        needed = own[method.split(":")[0]]
        under_which[method] = needed if needed and needed != chosen.split(":")[0] else chosen
    total = count * sum(samples.count(filters.radius(given)) for given in under_which.values())
    if total > MOST_SAMPLES:
        raise InvalidInput(
            f"{total} samples in all, with those that the filter reaches, would take minutes: "
            f"take {MOST_SAMPLES} or fewer, by -n or --realisations"
        )
    outcomes = tuple(_outcome(samples, count, method, given) for method, given in under_which.items())
    return Study(samples, count, outcomes)


def _outcome(samples: Samples, realisations: int, method: str, under: str) -> Outcome:
    radius = filters.radius(under)
    positions = radius * np.linspace(-1.0, 1.0, POSITIONS)
    truth = np.array([filters.integral(under, -radius, position) for position in positions])
    errors, first = [], None
    for index in range(realisations):
        points = samples.realisation(index, radius)
        weights = uneven.weights(points, method, under)
        first = first or (points, weights)
        order = np.argsort(points[:, 0])
        left = np.concatenate([[0.0], np.cumsum(weights[order])])
        errors.append(left[np.searchsorted(points[order, 0], positions)] - truth)
    every = np.array(errors)
    assert first is not None
    return Outcome(
        method=method,
        filter=under,
        rmse=statistics.root_mean_square(np.sqrt((every**2).mean(axis=1)).tolist()),
        at_middle=statistics.mean(every[:, POSITIONS // 2].tolist()),
        positions=positions,
        mean=every.mean(axis=0),
        deviation=every.std(axis=0),
        samples=first[0],
        weights=first[1],
    )


# --- what it says -----------------------------------------------------------------------------------------------------


def document(found: Study) -> dict[str, Any]:
    """What --json prints."""
    return {
        "source": found.samples.name,
        "n": found.samples.n,
        "crowd": found.samples.crowd,
        "realisations": found.realisations,
        "results": [
            {
                "method": one.method,
                "filter": one.filter,
                "rmse": one.rmse.value,
                "rmse_standard_error": one.rmse.standard_error,
                "error_at_middle": one.at_middle.value,
                "error_at_middle_standard_error": one.at_middle.standard_error,
                "edges": {"position": one.positions.tolist(), "mean_error": one.mean.tolist()},
            }
            for one in found.outcomes
        ],
    }


def lines(found: Study) -> list[str]:
    """A table: the error of each method, for edges anywhere and for the one in the middle."""
    times = f"{found.realisations} realisations" if found.realisations > 1 else "one realisation"
    width = max(len("weighting"), *(len(one.method) for one in found.outcomes))
    under = max(len("filter"), *(len(one.filter) for one in found.outcomes))
    return [
        f"{found.samples.title}; {times}",
        "error of a filtered edge from 0 to 1: RMS over its positions, and mean where it is in the middle",
        f"{'weighting':{width}}  {'filter':{under}}  {'RMS':22}  middle",
        *(
            f"{one.method:{width}}  {one.filter:{under}}  {_said(one.rmse, ''):22}  {_said(one.at_middle, '+')}"
            for one in found.outcomes
        ),
    ]


def _said(value: Estimate, sign: str) -> str:
    error = "" if value.standard_error is None else f" +- {value.standard_error:.1e}"
    return f"{value.value:{sign}.4f}{error}"


def write(found: Study, folder: Path) -> list[Path]:
    """Writes uneven.svg, uneven.png and uneven.csv; returns their paths. Raises NotWritable."""
    from aliascope.studies import uneven_pictures as pictures
    from aliascope.studies.point_pictures import save

    figure = pictures.figure(found.outcomes, found.samples.title)
    paths = [folder / f"uneven.{ending}" for ending in ("svg", "png", "csv")]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path in paths[:2]:
            save(figure, path)
        paths[2].write_text(_csv(found.outcomes), encoding="utf-8")
    except OSError as error:
        raise NotWritable(f"{folder}: cannot be written: {error.strerror}; choose another folder with -o") from error
    return paths


def _csv(outcomes: Sequence[Outcome]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["weighting", "filter", "edge_px", "mean_error", "standard_deviation"])
    for one in outcomes:
        for row in zip(one.positions.tolist(), one.mean.tolist(), one.deviation.tolist(), strict=True):
            writer.writerow([one.method, one.filter, *(f"{value:.9g}" for value in row)])
    return text.getvalue()
