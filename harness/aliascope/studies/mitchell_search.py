"""`aliascope mitchell --search`: which edges, statistic and generators come nearest to the published table.

The grid. Edges: the four ways of `edges=` of the edge measures. Statistic, over DRAWS edges of each realisation: the
root of the mean of squares over edges and realisations ("rms"), the mean over realisations of the roots over edges
("mean of rms"), the mean of the magnitudes ("mean"), the mean of the largest magnitude ("max"). With the half count's
1/(4 N^2) added to the square or without. Generators: GENERATORS, for each process the one that fits best. Nearness: the
root mean square of log(measured / published) over the cells.

Sets that are not randomised have one realisation, and DRAWS_OF_ONE edges but for "max", which grows with their number.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from aliascope import statistics
from aliascope.native import samplers
from aliascope.records import Estimate
from aliascope.studies.mitchell import COUNTS, PROCESSES, with_half_count
from aliascope.studies.mitchell_text import WIDTH, aligned
from aliascope.studies.realisations import STEP, Tell, realisation

EDGES = ("isotropic", "angle-offset", "two-points", "chord")
STATISTICS = ("rms", "mean of rms", "mean", "max")
DRAWS = 4096
DRAWS_OF_ONE = 1 << 18
REALISATIONS = 128
GENERATORS = {
    "zaremba": ("zaremba", "zaremba:digits=finite", "hammersley", "larcher-pillichshammer"),
    "jittered": ("jittered", "multi-jittered"),
    "poisson-disk": (
        *(f"poisson-disk:radius={radius}" for radius in (0.6, 0.7, 0.75, 0.8, 0.85, 0.9)),
        *(f"poisson-disk:radius={radius},toroidal=0" for radius in (0.6, 0.7, 0.75)),
        "best-candidate",
    ),
    "n-rooks": ("n-rooks", "n-rooks:centred=1", "n-rooks:corner=1"),
    "random": ("random",),
}


@dataclass(frozen=True)
class Fit:
    """A generator under some edges and a statistic: its figures at COUNTS, and their ratios to the published ones."""

    process: str
    generator: str
    figures: tuple[Estimate, ...]
    ratios: tuple[float, ...]

    @property
    def misfits(self) -> list[float]:
        """log(measured / published)."""
        return [math.log(ratio) for ratio in self.ratios]


@dataclass(frozen=True)
class Combination:
    """Edges, statistic, half count or not; `fits`: of every generator, `best`: the nearest of each process."""

    edges: str
    statistic: str
    half_count: bool
    fits: tuple[Fit, ...]
    best: tuple[Fit, ...]

    @property
    def misfit(self) -> float:
        """Over all fifteen cells."""
        return _root_mean_square([misfit for fit in self.best for misfit in fit.misfits])

    @property
    def misfit_without_poisson_disk(self) -> float:
        """Over the other twelve."""
        return _root_mean_square(
            [misfit for fit in self.best if fit.process != "poisson-disk" for misfit in fit.misfits]
        )

    @property
    def worst(self) -> tuple[Fit, int]:
        """The cell that is farthest off, by its fit and its count's index."""
        cells = [(fit, i) for fit in self.best for i in range(len(COUNTS))]
        return max(cells, key=lambda cell: abs(cell[0].misfits[cell[1]]))


def _root_mean_square(values: Sequence[float]) -> float:
    return math.sqrt(math.fsum(value * value for value in values) / len(values))


def search(count: int | None, seed: int, threads: int, tell: Tell | None = None) -> list[Combination]:
    """Every combination of the grid, the nearest first; `count`: realisations, REALISATIONS where not said."""
    sets = [(generator, n) for n in reversed(COUNTS) for made in GENERATORS.values() for generator in made]
    pieces = [
        (generator, n, piece)
        for generator, n in sets
        for piece in _pieces((count or REALISATIONS) if samplers.randomised(generator, n) else 1)
    ]
    values: dict[Key, list[float]] = {}
    pool = ThreadPoolExecutor(threads)
    try:
        made = pool.map(lambda entry: _measured(entry[0], entry[1], entry[2], seed), pieces)
        for done, ((generator, n, _), rows) in enumerate(zip(pieces, made, strict=True)):
            if tell:
                tell(f"{generator}, {n} points", done, len(pieces))
            for i, (edges, measure) in enumerate(MEASURED):
                values.setdefault((edges, measure, generator, n), []).extend(row[i] for row in rows)
    finally:
        pool.shutdown(cancel_futures=True)
    combinations = [
        _combination(values, edges, statistic, half_count)
        for edges in EDGES
        for statistic in STATISTICS
        for half_count in (False, True)
    ]
    return sorted(combinations, key=lambda each: each.misfit)


MEASURED = tuple((edges, measure) for edges in EDGES for measure in ("edge-rms", "edge-mean", "edge-max"))
Key = tuple[str, str, str, int]
"""Edges, measure, generator, count."""


def _pieces(count: int) -> list[range]:
    return [range(begin, min(begin + STEP, count)) for begin in range(0, count, STEP)]


def _measured(generator: str, n: int, piece: range, seed: int) -> list[list[float]]:
    """MEASURED, of each realisation."""
    draws = DRAWS if samplers.randomised(generator, n) else DRAWS_OF_ONE
    specs = [
        f"{measure}:draws={DRAWS if measure == 'edge-max' else draws},edges={edges}" for edges, measure in MEASURED
    ]
    return [[found.value for found in realisation(generator, n, specs, seed + index)] for index in piece]


def _combination(found: Mapping[Key, Sequence[float]], edges: str, statistic: str, half_count: bool) -> Combination:
    measure = {"mean": "edge-mean", "max": "edge-max"}.get(statistic, "edge-rms")
    published = {process.name: process.published for process in PROCESSES}
    fits = []
    for process, generators in GENERATORS.items():
        for generator in generators:
            figures = []
            for n in COUNTS:
                values = found[edges, measure, generator, n]
                estimate = statistics.root_mean_square(values) if statistic == "rms" else statistics.mean(values)
                figures.append(with_half_count(estimate, n) if half_count else estimate)
            ratios = [(f.value or math.nan) / p for f, p in zip(figures, published[process], strict=True)]
            fits.append(Fit(process, generator, tuple(figures), tuple(ratios)))
    best = [
        min((fit for fit in fits if fit.process == process), key=lambda fit: _root_mean_square(fit.misfits))
        for process in GENERATORS
    ]
    return Combination(edges, statistic, half_count, tuple(fits), tuple(best))


def lines(combinations: Sequence[Combination], count: int | None) -> list[str]:
    """Every combination, then every generator under the nearest one."""
    rows = [["edges", "statistic", "half count", "misfit", "but Poisson-disk", "worst cell", "", ""]]
    for each in combinations:
        fit, i = each.worst
        rows.append(
            [
                each.edges,
                each.statistic,
                "1/(4 N^2)" if each.half_count else "none",
                f"{each.misfit:.3f}",
                f"{each.misfit_without_poisson_disk:.3f}",
                fit.generator,
                f"{COUNTS[i]:,}",
                f"{fit.ratios[i]:.3f}",
            ]
        )
    first = combinations[0]
    text = (
        f"Misfit: the root mean square of log(measured / published) over the cells, {count or REALISATIONS} "
        f"realisations and {DRAWS:,} edges of each; for every process the generator that fits best. The worst cell "
        "with its ratio."
    )
    nearest = (
        f"The nearest: {first.edges} edges, {first.statistic}, {'with' if first.half_count else 'without'} the half "
        f"count, and these generators (*), measured over published:"
    )
    fits = [["generator", *(f"{n:,}" for n in COUNTS), "+-", "misfit", ""]]
    for fit in first.fits:
        error = max((f.standard_error or 0.0) / (f.value or math.inf) for f in fit.figures)
        row = [fit.generator, *(f"{ratio:.3f}" for ratio in fit.ratios), f"{error:.3f}"]
        fits.append([*row, f"{_root_mean_square(fit.misfits):.3f}", "*" if fit in first.best else ""])
    return [*aligned(rows, 3), "", *textwrap.wrap(text, WIDTH), "", *textwrap.wrap(nearest, WIDTH), *aligned(fits)]


def document(combinations: Sequence[Combination], count: int | None, seed: int) -> dict[str, Any]:
    """What --json prints."""
    return {
        "search": [_combination_document(each) for each in combinations],
        "realisations": count or REALISATIONS,
        "draws": DRAWS,
        "seed": seed,
        "counts": list(COUNTS),
    }


def _combination_document(each: Combination) -> dict[str, Any]:
    return {
        "edges": each.edges,
        "statistic": each.statistic,
        "half_count": each.half_count,
        "misfit": each.misfit,
        "misfit_without_poisson_disk": each.misfit_without_poisson_disk,
        "generators": {fit.process: fit.generator for fit in each.best},
        "fits": [
            {
                "process": fit.process,
                "generator": fit.generator,
                "means": [figure.value for figure in fit.figures],
                "standard_errors": [figure.standard_error for figure in fit.figures],
                "ratios": list(fit.ratios),
            }
            for fit in each.fits
        ],
    }
