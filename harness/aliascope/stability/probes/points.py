"""Discrepancies, empty boxes and discs, distances: of points at their extremes, against fractions of the very doubles.

`edge-mean` and `edge-rms` by draws are estimates, whose standard errors are far above any rounding: they have no row.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import partial

import mpmath
import numpy as np

from aliascope.native.discrepancy import measure
from aliascope.stability.exact import boxes, even, planes
from aliascope.stability.exact.sets import LEVELS, SETS, Table, torus
from aliascope.stability.records import NEVER, Probe

Exact = list[tuple[Fraction, Fraction]]
Truth = Callable[[Exact], object]

ROUNDING = 2.0**-53
BOUND = 1e-12
DIGITS = 40
MOST_QUICK = 64.0
"""Points of a test."""


def _fractions(points: Table) -> Exact:
    return [(Fraction(x), Fraction(y)) for x, y in points]


def number(value: object) -> mpmath.mpf:
    """A fraction or a number of mpmath's, as the latter."""
    return mpmath.mpf(value.numerator) / value.denominator if isinstance(value, (Fraction, int)) else value


def relative(found: float, truth: object) -> float:
    """The error of a double over the truth; of nothing, the error itself."""
    exact = number(truth)
    return float(abs(found - exact) / (abs(exact) if exact else 1))


def _root(square: object) -> mpmath.mpf:
    return mpmath.sqrt(number(square))


def _of_two_or_more(points: Exact, torus_too: bool) -> object:
    return _root(planes.least_square(points, torus_too)) if len(points) > 1 else 0


def _l2(name: str, points: Exact) -> object:
    return _root(boxes.l2_square(name, points))


TRUTHS: dict[str, Truth] = {
    "star": boxes.star,
    "star-bounds:gap=0": boxes.star,
    "box": boxes.box,
    "dispersion": boxes.empty_box,
    "dispersion:of=disc": lambda points: _root(planes.empty_disc_square(points)),
    "half-plane": planes.half_plane,
    "min-distance": partial(_of_two_or_more, torus_too=True),
    "min-distance:torus=0": partial(_of_two_or_more, torus_too=False),
    "edge-rms": lambda points: _root(boxes.edge_rms_square(points)),
    **{name: partial(_l2, name) for name in boxes.KERNELS},
}


def _measured(spec: str, truth: Truth, made: Callable[[float], Table], at: float) -> float:
    points = made(at)
    found = measure(spec, points)
    with mpmath.workdps(DIGITS):
        return relative(found.value, truth(_fractions(points)))


def _edge(made: Callable[[float], Table], at: float) -> float:
    """That of the edge which `edge-max` says it is met at; 1 where no edge has as much. Whether its search finds the
    worst edge is no matter of arithmetic."""
    points = made(at)
    found = measure("edge-max:draws=64", points, seed=1)
    line = (Fraction(found.witness[0]), Fraction(found.witness[1]), Fraction(found.witness[2]))
    fractions = _fractions(points)
    own = abs(planes.excess(line, fractions))
    with mpmath.workdps(DIGITS):
        return relative(found.value, own) if own <= planes.half_plane(fractions) else 1.0


def _t_value(made: Callable[[float], Table], at: float) -> float:
    points = made(at)
    return abs(measure("t-value", points).value - boxes.t_value(_fractions(points)))


def _of_even(name: str, at: float) -> float:
    points = even.lattice(int(at))
    found = measure(name, points)
    with mpmath.workdps(DIGITS):
        square = even.edge_rms_square(points) if name == "edge-rms" else even.l2_square(name, points)
        return relative(found.value, _root(square))


def _of_dimensions(name: str, at: float) -> float:
    """Three random points."""
    table = np.random.default_rng(3).random((3, int(at)))
    found = measure(name, table)
    with mpmath.workdps(DIGITS):
        return relative(
            found.value, _root(boxes.l2_square(name, [tuple(map(Fraction, row)) for row in table.tolist()]))
        )


def _quick(levels: tuple[float, ...]) -> tuple[float, ...]:
    """Two of them: in the middle, and the last that takes a moment."""
    return (levels[len(levels) // 2], max((at for at in levels if at <= MOST_QUICK), default=levels[-1]))


def _probe(component: str, extreme: str, run: Callable[[float], float], levels: tuple[float, ...]) -> Probe:
    unit, against, precision, bound = "relative", "fractions of the same doubles", ROUNDING, BOUND
    if component == "t-value":
        unit, precision, bound = "t", 1.0, 0.0
    if component == "edge-max":
        against = "fractions, of the edge that it names, and no more than any edge has"
    quick = _quick(levels) if component != "box" else levels[1:2]  # whose truth takes the longest
    declines = DECLINES.get((component, extreme), NEVER)
    return Probe(
        component, "measure", extreme, unit, against, precision, bound, levels, run, quick, refuses_from=declines
    )


DECLINES = {
    ("l2-extreme", "dimensions"): 1000.0,
    ("min-distance", "few-points"): 1.0,
    ("min-distance", "grid"): 1.0,
    ("min-distance:torus=0", "few-points"): 1.0,
    ("min-distance:torus=0", "grid"): 1.0,
}
"""From which level on: a square below all doubles; a single point, which has no other to be near to."""

NETS = {"coincident", "few-points", "grid"}
"""Extremes of which some sets have a power of two points, as nets do."""


def probes() -> list[Probe]:
    found = []
    for extreme, made in SETS.items():
        levels = LEVELS[extreme]
        found += [
            _probe(spec, extreme, partial(_measured, spec, truth, made), levels) for spec, truth in TRUTHS.items()
        ]
        found.append(_probe("edge-max", extreme, partial(_edge, made), levels))
        if extreme in NETS:
            dyadic = tuple(at for at in levels if math.log2(at).is_integer())
            found.append(_probe("t-value", extreme, partial(_t_value, made), dyadic))
    counts, dimensions = (13.0, 34.0, 144.0, 610.0, 1597.0), (1.0, 10.0, 100.0, 300.0, 1000.0)
    found += [_probe(name, "even", partial(_of_even, name), counts) for name in (*boxes.KERNELS, "edge-rms")]
    found += [_probe(name, "dimensions", partial(_of_dimensions, name), dimensions) for name in boxes.KERNELS]
    around = partial(_measured, "min-distance", TRUTHS["min-distance"], torus)
    found.append(_probe("min-distance", "across", around, LEVELS["border"]))
    return found
