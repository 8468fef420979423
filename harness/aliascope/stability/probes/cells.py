"""Voronoi cells and the weights of uneven samples, against fractions and mpmath of the same doubles.

Samples are in the pixel's upper right quarter, half of a set of `exact.sets`, so that the smallest coordinates stay.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial

import mpmath

from aliascope.native import uneven
from aliascope.stability.exact import planes
from aliascope.stability.exact.sets import LEVELS, SETS, Table
from aliascope.stability.records import Probe

ROUNDING = 2.0**-53
BOUND = 1e-12
DIGITS = 40
NEIGHBOURS = 3
"""Of `inverse-density`, by default."""

Exact = list[tuple[Fraction, Fraction]]
Truth = Callable[[Exact], list[mpmath.mpf]]


def _rectangle(left: Fraction, right: Fraction) -> list[tuple[Fraction, Fraction]]:
    return [(left, left), (right, left), (right, right), (left, right)]


def _number(value: Fraction) -> mpmath.mpf:
    return mpmath.mpf(value.numerator) / value.denominator


def _shared(points: Exact, of_place: Callable[[tuple[Fraction, Fraction], Exact], mpmath.mpf]) -> list[mpmath.mpf]:
    """What belongs to a place, in equal parts to the points there."""
    places = sorted(set(points))
    found = {place: of_place(place, places) / points.count(place) for place in places}
    return [found[point] for point in points]


def _areas(points: Exact, left: Fraction, right: Fraction) -> list[mpmath.mpf]:
    bounds = _rectangle(left, right)
    return _shared(points, lambda own, others: _number(planes.area(planes.cell(own, others, bounds))))


def _under_tent(points: Exact) -> list[mpmath.mpf]:
    bounds = _rectangle(Fraction(-1), Fraction(1))
    return _shared(
        points, lambda own, others: _number(planes.tent_integral(planes.cell(own, others, bounds), Fraction(1)))
    )


def _quarter(radius: mpmath.mpf, a: mpmath.mpf, b: mpmath.mpf) -> mpmath.mpf:
    """The area of a quarter of a disc about the corner of a rectangle of sides a and b."""
    if a * a + b * b <= radius * radius:
        return a * b

    def under(x: mpmath.mpf) -> mpmath.mpf:
        return (x * mpmath.sqrt(radius * radius - x * x) + radius * radius * mpmath.asin(x / radius)) / 2

    width = min(a, radius)
    flat = mpmath.sqrt(radius * radius - b * b) if b < radius else mpmath.mpf(0)
    return min(b, radius) * flat + under(width) - under(flat)


def _inverse_density(points: Exact) -> list[mpmath.mpf]:
    """By the part within the pixel of the disc to the third nearest place."""

    def within(own: tuple[Fraction, Fraction], places: Exact) -> mpmath.mpf:
        away = sorted((own[0] - x) ** 2 + (own[1] - y) ** 2 for x, y in places)
        if len(away) == 1:
            return mpmath.mpf(1)
        radius = mpmath.sqrt(_number(away[min(NEIGHBOURS, len(away) - 1)]))
        sides = [[_number(Fraction(1, 2) + sign * value) for sign in (1, -1)] for value in own]
        return mpmath.fsum(_quarter(radius, a, b) for a in sides[0] for b in sides[1])

    return _shared(points, within)


def _error(found: Sequence[float], truth: list[mpmath.mpf], normalised: bool) -> float:
    """The largest, over the mean of all."""
    whole = mpmath.fsum(truth)
    over = whole if normalised else mpmath.mpf(1)
    pairs = zip(found, truth, strict=True)
    return float(max(abs(value - exact / over) for value, exact in pairs) * len(truth) / (whole / over))


def _voronoi(made: Callable[[float], Table], at: float) -> float:
    points = made(at)
    found = uneven.voronoi_areas(points, (0.0, 0.0, 1.0, 1.0))
    exact = [(Fraction(x), Fraction(y)) for x, y in points]
    with mpmath.workdps(DIGITS):
        return _error(found.tolist(), _areas(exact, Fraction(0), Fraction(1)), normalised=False)


def _weights(method: str, filter_: str | None, truth: Truth, made: Callable[[float], Table], at: float) -> float:
    points = [(0.5 * x, 0.5 * y) for x, y in made(at)]
    found = uneven.weights(points, method, filter_)
    exact = [(Fraction(x), Fraction(y)) for x, y in points]
    with mpmath.workdps(DIGITS):
        return _error(found.tolist(), truth(exact), normalised=True)


def _alike(points: Exact) -> list[mpmath.mpf]:
    return [mpmath.mpf(1)] * len(points)


WEIGHTS: dict[str, tuple[str, str | None, Truth]] = {
    "area": ("area", None, partial(_areas, left=Fraction(-1, 2), right=Fraction(1, 2))),
    "area:filter=tent": ("area", "tent", _under_tent),
    "inverse-density": ("inverse-density", None, _inverse_density),
    "average": ("average", None, _alike),
}


def _quick(levels: tuple[float, ...]) -> tuple[float, ...]:
    return (levels[len(levels) // 2], levels[-1])


READ_TO = 1e-15
"""Samples that are closer than 2^-51 of half the support are one (uneven.h): they share."""


def _probe(component: str, extreme: str, run: Callable[[float], float]) -> Probe:
    levels, note = LEVELS[extreme], ""
    if extreme == "close":
        levels = tuple(at for at in levels if at >= READ_TO)
        note = "Samples within 2^-52 of the support's width count as one, and share its weight."
    unit, against = "of the mean weight", "fractions of the same doubles"
    return Probe(component, "filter", extreme, unit, against, ROUNDING, BOUND, levels, run, _quick(levels), note)


def probes() -> list[Probe]:
    found = []
    for extreme, made in SETS.items():
        if extreme == "axis-lines":
            continue
        found.append(_probe("voronoi", extreme, partial(_voronoi, made)))
        for name, (method, filter_, truth) in WEIGHTS.items():
            found.append(_probe(name, extreme, partial(_weights, method, filter_, truth, made)))
    alike = partial(_weights, "multi-stage", None, _alike, SETS["coincident"])
    found.append(_probe("multi-stage", "coincident", alike))
    return found
