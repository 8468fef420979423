"""`aliascope mitchell --table hardware`: what one pixel of multisampling hardware can do, with up to 16 samples."""

from __future__ import annotations

from aliascope.native import discrepancy, samplers
from aliascope.records import Estimate
from aliascope.studies.hardware_search import centres
from aliascope.studies.hardware_sets import SETS
from aliascope.studies.mitchell import MEASURE, Cell, Column, Options, Table

COUNTS = (1, 2, 4, 8, 16)
SAMPLERS = ("regular", "standard-msaa")
HALF_PLANE = "half-plane"


def hardware_table(options: Options) -> Table:
    """The ordered grid, the standard locations, and the best on the 8 x 8 grid for either measure.

    All are fixed, so the figures are exact; each has its half-plane discrepancy beside.
    """
    cells = [_of_sampler(name, n, options) for name in SAMPLERS for n in COUNTS]
    for measure in (MEASURE, HALF_PLANE):
        for n in COUNTS:
            how, chosen = SETS[measure, n]
            places = centres(chosen).tolist()
            cells.append(_measured(f"8x8-{measure}", how, n, places, options))
    return Table("hardware", options, tuple(cells))


def _of_sampler(name: str, n: int, options: Options) -> Cell:
    reason = samplers.refusal(name, n)
    if reason:
        return Cell(name, name, n, reason=reason)
    return _measured(name, name, n, samplers.points(name, n).tolist(), options)


def _measured(process: str, generator: str, n: int, places: list[list[float]], options: Options) -> Cell:
    columns = {}
    for spec in dict.fromkeys((HALF_PLANE, *options.columns)):
        found = discrepancy.measure(spec, places, options.seed)
        error = found.standard_error if found.certainty == "estimated" else 0.0
        columns[spec] = Column(spec, Estimate(found.value, error), 1)
    plain = Estimate(discrepancy.measure(MEASURE, places).value, 0.0)
    points = tuple((x, y) for x, y in places)
    return Cell(process, generator, n, n, plain, 1, columns=columns, points=points)
