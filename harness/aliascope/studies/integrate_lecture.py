"""`aliascope integrate --lecture`: a plot for each page of the lecture (Hanrahan 2000, CS348B, lecture 7), and its last
page, the views of sampling, as a table of measured rates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from aliascope.integration import Convergence, ErrorAt, Integration, integrate
from aliascope.report.files import write_text
from aliascope.report.lecture import Cell, Figure, Page, Row, page_html
from aliascope.studies.integrate import document as integration_document
from aliascope.studies.integrate import table_csv
from aliascope.studies.integrate_plots import Guide, Line, convergence_svg, dimensions_svg, ratio_svg

Tell = Callable[[str, int, int], None]
SMOOTH, SMOOTH_IN_8 = "product", "product:strength=0.5"
VIEWS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("Signal processing", "blue noise: no power at low frequencies", ("poisson-disk", "blue-noise")),
    ("Statistical sampling", "variance, N^-1/2 in any dimension", ("random", "jittered", "n-rooks", "multi-jittered")),
    (
        "Quasi-Monte Carlo",
        "discrepancy",
        ("halton", "hammersley", "sobol", "sobol:scramble=owen", "larcher-pillichshammer", "lattice"),
    ),
    ("Numerical", "rules of integration, for smooth functions", ("regular", "gauss-legendre", "clenshaw-curtis")),
)
COLUMNS = (("edge", 2, "An edge"), (SMOOTH, 2, "Smooth"), (SMOOTH_IN_8, 8, "Smooth, d = 8"))
DIMENSIONS, AT_ONE_N = (1, 2, 4, 8, 16), 65536
"""65536 is a power of 65536, 256, 16, 4 and 2: a grid has that many points in each of these dimensions."""
BOUNDED = ("step", "linear", SMOOTH, "discontinuous")
_SLOW = ("blue-noise",)


@dataclass(frozen=True)
class Made:
    """Everything that was integrated: by the name of a figure, and the columns of the table."""

    figures: dict[str, list[Integration]]
    columns: list[Integration]
    realisations: int
    seed: int


def make(realisations: int, seed: int, tell: Tell) -> Made:
    """Integrates all of it. `tell` hears what begins, how many are done, and of how many."""
    plan = _plan()
    total = sum(len(parts) for parts in plan.values()) + len(COLUMNS)
    figures: dict[str, list[Integration]] = {}
    done = 0
    for name, parts in plan.items():
        figures[name] = []
        for integrand, samplers, d, more in parts:
            tell(f"{name}: {integrand}, d = {d}", done, total)
            figures[name].append(integrate(integrand, samplers, d, realisations=realisations, seed=seed, **more))
            done += 1
    columns = []
    for integrand, d, _ in COLUMNS:
        tell(f"views of sampling: {integrand}, d = {d}", done, total)
        columns.append(_column(integrand, d, realisations, seed))
        done += 1
    return Made(figures, columns, realisations, seed)


def _plan() -> dict[str, list[tuple[str, tuple[str, ...], int, dict[str, Any]]]]:
    """The integrations of each figure: integrand, samplers, d, and what `integrate` takes besides."""
    at_one = {"least_n": AT_ONE_N, "most_n": AT_ONE_N}
    smooth = ("random", "regular", "gauss-legendre", "sobol:scramble=owen")
    edges = ("random", "regular", "gauss-legendre", "sobol:scramble=owen")
    return {
        "convergence": [
            (integrand, ("random",), d, {}) for integrand, d in (("edge", 2), ("product", 2), ("gaussian", 8))
        ],
        "stratified-sampling": [
            ("edge", ("random", "jittered"), 2, {}),
            (SMOOTH, ("random", "jittered"), 2, {}),
        ],
        "quasi-monte-carlo": [
            (SMOOTH, ("random", "halton", "hammersley", "sobol", "sobol:scramble=owen", "lattice"), 2, {})
        ],
        "high-dimensional-sampling": [(SMOOTH_IN_8, smooth, d, at_one) for d in DIMENSIONS],
        "high-dimensional-edges": [("half-space", edges, d, at_one) for d in DIMENSIONS],
        "total-variation": [
            (integrand, ("random", "sobol"), 2, {"least_n": 4, "variation": True}) for integrand in BOUNDED
        ],
    }


def _column(integrand: str, d: int, realisations: int, seed: int) -> Integration:
    """All samplers of the views. Slow ones go to fewer points; rules of quadrature, which in eight dimensions have 1,
    256, 6561 and 65536 points, to more."""
    names = [name for _, _, members in VIEWS for name in members]
    rules = [name for name in VIEWS[-1][2] if d > 2]
    groups = [
        ([name for name in names if name not in (*_SLOW, *rules)], 4096),
        (list(_SLOW), 1024),
        (rules, AT_ONE_N),
    ]
    parts = [
        integrate(integrand, members, d, realisations=realisations, seed=seed, most_n=most)
        for members, most in groups
        if members
    ]
    return replace(
        parts[0],
        results=tuple(result for part in parts for result in part.results),
        refused=tuple(entry for part in parts for entry in part.refused),
    )


def _lines(parts: Sequence[Integration], with_integrand: bool) -> list[Line]:
    return [
        Line.of(result, f"{result.sampler}, {part.integrand.name}, d = {part.d}" if with_integrand else result.sampler)
        for part in parts
        for result in part.results
    ]


def _by_dimension(parts: Sequence[Integration]) -> list[Line]:
    """Relative error of each sampler, by dimension."""
    found: dict[str, list[tuple[float, ErrorAt, float]]] = {}
    for part in parts:
        for result in part.results:
            row = (float(part.d), result.errors[-1], part.integrand.exact(part.d))
            found.setdefault(result.sampler, []).append(row)
    return [Line.through(name, rows) for name, rows in found.items()]


def _ratios(parts: Sequence[Integration]) -> list[Line]:
    """A colour an integrand; the second sampler dashed."""
    found = []
    for colour, part in enumerate(parts):
        for index, result in enumerate(part.results):
            x, y = zip(*((float(one.n), one.ratio) for one in result.variation if one.ratio > 0.0), strict=True)
            line = Line(f"{part.integrand.name}, {result.sampler}", x, y, (0.0,) * len(x), (False,) * len(x))
            found.append(replace(line, colour=colour, dashed=index > 0))
    return found


def _worst(parts: Sequence[Integration]) -> float:
    return max(one.ratio for part in parts for result in part.results for one in result.variation)


def _ends(parts: Sequence[Integration]) -> str:
    """Of each sampler the relative error in the fewest dimensions and in the most."""
    return "; ".join(f"{line.label} {line.y[0]:.1e} and {line.y[-1]:.1e}" for line in _by_dimension(parts))


def figures_of(made: Made) -> list[Figure]:
    """The plots, in the order of the lecture, each with what was measured in words."""
    said = _texts(made.figures)
    return [Figure(name, *said[name], svg) for name, svg in _plots(made.figures).items()]


def _plots(parts: Mapping[str, Sequence[Integration]]) -> dict[str, str]:
    half, edge = Guide(-0.5, "N^-1/2", at=0.75), Guide(-0.75, "N^-3/4", 1, at=0.72)
    return {
        "convergence": convergence_svg("Random sampling", _lines(parts["convergence"], True), (half,)),
        "stratified-sampling": convergence_svg(
            "An edge through a pixel",
            _lines(parts["stratified-sampling"], True),
            (half, edge, Guide(-1.0, "N^-1", 3, at=0.3)),
        ),
        "quasi-monte-carlo": convergence_svg(
            "A smooth product, d = 2",
            _lines(parts["quasi-monte-carlo"], False),
            (half, Guide(-1.0, "N^-1", 3, at=0.75), Guide(-1.5, "N^-3/2", 4, at=0.5)),
        ),
        "high-dimensional-sampling": dimensions_svg(
            f"A smooth product, N = {AT_ONE_N}", _by_dimension(parts["high-dimensional-sampling"]), "relative error"
        ),
        "high-dimensional-edges": dimensions_svg(
            f"A half-space, N = {AT_ONE_N}", _by_dimension(parts["high-dimensional-edges"]), "relative error"
        ),
        "total-variation": ratio_svg("Error over its bound, d = 2", _ratios(parts["total-variation"])),
    }


def _texts(parts: Mapping[str, Sequence[Integration]]) -> dict[str, tuple[str, str]]:
    """The title and the text of each figure."""
    rates = {(p.integrand.spec, p.d, r.sampler): r for group in parts.values() for p in group for r in p.results}

    def rate(integrand: str, d: int, sampler: str) -> str:
        return _rate(rates[integrand, d, sampler])

    return {
        "convergence": (
            "Convergence",
            "The standard deviation of a mean of N independent samples falls with N^-1/2, whatever the integrand and "
            f"the dimension: measured {rate('edge', 2, 'random')} on an edge, {rate('gaussian', 8, 'random')} on a "
            "Gaussian in eight dimensions.",
        ),
        "stratified-sampling": (
            "Stratified sampling",
            "Of the N cells of a jittered pixel an edge crosses about N^1/2; only these have variance. So the variance "
            f"is of order N^-1.5, the error of order N^-3/4: measured {rate('edge', 2, 'jittered')}. Where the "
            f"integrand is smooth all cells gain, and it is N^-1: measured {rate('product', 2, 'jittered')}.",
        ),
        "quasi-monte-carlo": (
            "Quasi-Monte Carlo",
            f"Halton {rate('product', 2, 'halton')}, Hammersley {rate('product', 2, 'hammersley')}, Sobol "
            f"{rate('product', 2, 'sobol')}: near N^-1, with logarithms. Owen's scrambling makes it "
            f"{rate('product', 2, 'sobol:scramble=owen')}, near N^-3/2.",
        ),
        "high-dimensional-sampling": (
            "High-dimensional sampling",
            "All have the same number of points. A grid in d dimensions has N^(1/d) of them along an axis, and its "
            "error is of order N^(-2/d): in sixteen dimensions two along an axis. Random sampling does not know the "
            "dimension; its error grows only as the integrand's variance does.",
        ),
        "high-dimensional-edges": (
            "High-dimensional sampling, edges",
            "The same for the indicator of a half-space, which has no derivatives for a rule to use. Relative errors "
            f"in one dimension and in sixteen: {_ends(parts['high-dimensional-edges'])}.",
        ),
        "total-variation": (
            "Theorem on total variation",
            "No error is above V(f) D_N, the variation times the star discrepancy: the largest ratio of these is "
            f"{_worst(parts['total-variation']):.3f}. It comes near 1 where the integrand is a box like those that the "
            "discrepancy is made of.",
        ),
    }


def _rate(result: Convergence) -> str:
    rate = result.rate
    return f"N^{rate.exponent:.2f} [{rate.interval[0]:.2f}, {rate.interval[1]:.2f}]" if rate else str(result.reason)


def rows_of(made: Made) -> list[tuple[str, str, list[Row]]]:
    """The table: (view, what it says, a row a sampler)."""
    results = [{result.sampler: result for result in column.results} for column in made.columns]
    refused = [dict(column.refused) for column in made.columns]
    return [
        (
            view,
            text,
            [Row(name, [_cell(name, r, why) for r, why in zip(results, refused, strict=True)]) for name in names],
        )
        for view, text, names in VIEWS
    ]


def _cell(name: str, results: dict[str, Convergence], refused: dict[str, str]) -> Cell:
    if name not in results:
        return Cell(None, "", refused[name], "")
    found = results[name]
    theory = found.theory.text if found.theory else ""
    if found.rate is None:
        return Cell(None, "", found.reason or "", theory)
    low, high = found.rate.interval
    bent = ", bent" if found.rate.curved else ""
    return Cell(f"{found.rate.exponent:.2f}", f"{low:.2f} to {high:.2f}{bent}", "", theory)


def lines(made: Made) -> list[str]:
    """The table for a terminal."""
    heads = [f"{title} ({integrand})" for integrand, _, title in COLUMNS]
    rows = [["", *heads]]
    for view, text, members in rows_of(made):
        rows.append([f"{view}: {text}", *[""] * len(heads)])
        rows += [[f"  {row.sampler}", *(_cell_text(cell) for cell in row.cells)] for row in members]
    first = max(len(row[0]) for row in rows if row[1])
    widths = [max(len(row[c]) for row in rows) for c in range(1, len(heads) + 1)]
    return [
        (row[0].ljust(first) + "".join("  " + cell.ljust(w) for cell, w in zip(row[1:], widths, strict=True))).rstrip()
        for row in rows
    ]


def _cell_text(cell: Cell) -> str:
    found = f"{cell.rate} [{cell.interval}]" if cell.rate else "none"
    return f"{found}  {cell.theory}".rstrip()


def document(made: Made) -> dict[str, Any]:
    """What --json prints."""
    return {
        "realisations": made.realisations,
        "seed": made.seed,
        "figures": {name: [integration_document(part) for part in parts] for name, parts in made.figures.items()},
        "views": [integration_document(column) for column in made.columns],
    }


def write(folder: Path, made: Made) -> list[Path]:
    """Writes lecture.html, each plot as SVG and CSV, and views.csv; the page's path comes first."""
    figures = figures_of(made)
    page = Page(
        figures,
        rows_of(made),
        [
            (title, f"{part.integrand.spec}, d = {part.d}")
            for (_, _, title), part in zip(COLUMNS, made.columns, strict=True)
        ],
        made.realisations,
        made.seed,
    )
    paths = [write_text(folder / "lecture.html", page_html(page))]
    for figure in figures:
        paths.append(write_text(folder / f"{figure.name}.svg", figure.svg))
        paths.append(write_text(folder / f"{figure.name}.csv", table_csv(made.figures[figure.name])))
    paths.append(write_text(folder / "views.csv", table_csv(made.columns)))
    return paths
