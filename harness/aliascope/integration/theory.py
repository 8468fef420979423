"""The rate at which theory lets the error of a pattern fall, where there is theory for the pattern and the integrand.

A bound ("<=") holds for every set of points, or for the root mean square where the pattern is random; an order ("~") is
also reached. Constants are left out of both. Where nothing is proved there is no entry, and the table has a blank.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np

from aliascope import specs
from aliascope.integrands import Integrand

_ADDITIVE = ("constant", "linear", "step")
"""Integrands that are sums of functions of one coordinate."""


@dataclass(frozen=True)
class Theory:
    """error ~ or <= N^exponent (log N)^logarithms; exponent None where it falls faster than every power of N."""

    kind: Literal["order", "bound"]
    exponent: Fraction | None
    logarithms: Fraction
    source: str

    @property
    def text(self) -> str:
        """As "~ N^-3/4" or "<= (log N)^2 N^-1"."""
        if self.exponent is None:
            return "faster than any power"
        log = "" if self.logarithms == 0 else "log N " if self.logarithms == 1 else f"(log N)^{self.logarithms} "
        return f"{'~' if self.kind == 'order' else '<='} {log}N^{self.exponent}"

    def rate_over(self, counts: list[int]) -> float | None:
        """The slope of a line through this law at these N, with its logarithms: what a fit over them would find."""
        if self.exponent is None or len(counts) < 2 or counts[0] < 2:
            return None
        x = np.log(np.array(counts, dtype=np.float64))
        return float(np.polyfit(x, float(self.exponent) * x + float(self.logarithms) * np.log(x), 1)[0])


@dataclass(frozen=True)
class _Case:
    """A pattern with its keys, an integrand, d."""

    keys: Mapping[str, str]
    integrand: Integrand
    d: int

    @property
    def finite_variation(self) -> bool:
        return self.integrand.smoothness != "jump" or self.d == 1

    @property
    def smooth(self) -> bool:
        """Continuous and of bounded slope: enough for everything that is stratified."""
        return self.integrand.smoothness in ("analytic", "kinked")

    @property
    def additive(self) -> bool:
        return self.d == 1 or self.integrand.name in _ADDITIVE


def _order(exponent: Fraction | int, source: str, logarithms: Fraction | int = 0) -> Theory:
    return Theory("order", Fraction(exponent), Fraction(logarithms), source)


def _bound(exponent: Fraction | int, source: str, logarithms: Fraction | int = 0) -> Theory:
    return Theory("bound", Fraction(exponent), Fraction(logarithms), source)


def _random(case: _Case) -> Theory:
    return _order(Fraction(-1, 2), "V[F_N] = V[Y]/N; Hanrahan 2000, CS348B, Convergence")


def _stratified(case: _Case) -> Theory:
    """One point in each of N cubes of side N^(-1/d). Within a cube a bounded slope leaves a variance of N^(-2/d); a
    jump leaves one of 1, but in N^(1-1/d) of the cubes only."""
    source = "Hanrahan 2000, CS348B, Stratified Sampling; Mitchell 1996"
    if case.smooth:
        return _order(Fraction(-1, 2) - Fraction(1, case.d), source)
    return _order(Fraction(-1, 2) - Fraction(1, 2 * case.d), source)


def _jittered(case: _Case) -> Theory | None:
    return _stratified(case) if case.d <= 2 else None  # padded beyond: planes are stratified, not the whole


def _n_rooks(case: _Case) -> Theory | None:
    """What is a sum over the coordinates is stratified in each; the rest is as with independent points."""
    if case.keys:
        return None
    source = "Stein 1987"
    if case.additive:
        return _order(Fraction(-3, 2) if case.smooth else Fraction(-1), source)
    return _order(Fraction(-1, 2), source)


def _orthogonal_array(case: _Case) -> Theory | None:
    strength = int(case.keys.get("strength", "2"))
    return _stratified(case) if case.d == strength and case.keys.get("jitter") == "jittered" else None


def _grid(case: _Case) -> Theory:
    """A product of midpoint rules: two orders in the side of a cell where f is continuous, with a crease as well; one
    where it jumps, as a bound, since the errors along an oblique edge cancel in part."""
    source = "Davis and Rabinowitz 1984; Hanrahan 2000, CS348B, High-dimensional Sampling"
    if case.smooth:
        return _order(Fraction(-2, case.d), source)
    return _bound(Fraction(-1, case.d), source)


def _quadrature(case: _Case) -> Theory:
    """Gauss's and Clenshaw and Curtis's rules: geometric in N^(1/d) for analytic functions, like a grid for others."""
    if case.integrand.smoothness == "analytic":
        return Theory("bound", None, Fraction(0), "Trefethen 2008")
    source = "Davis and Rabinowitz 1984"
    return _bound(Fraction(-2, case.d) if case.smooth else Fraction(-1, case.d), source)


def _low_discrepancy(logarithms: Callable[[int], int]) -> Callable[[_Case], Theory]:
    """Koksma and Hlawka's bound with the discrepancy's order; for convex shapes its d-th root (Hlawka 1964)."""

    def theory(case: _Case) -> Theory:
        power = logarithms(case.d)
        if case.finite_variation:
            return _bound(-1, "Niederreiter 1992, Theorems 2.11, 3.6, 3.8, 4.10", power)
        return _bound(Fraction(-1, case.d), "Niederreiter 1992, Theorem 1.6", Fraction(power, case.d))

    return theory


_sequence = _low_discrepancy(lambda d: d)
_set = _low_discrepancy(lambda d: d - 1)


def _scrambled_net(case: _Case) -> Theory:
    if case.smooth:
        return _bound(Fraction(-3, 2), "Owen 1997; Yue and Mao 1999", Fraction(case.d - 1, 2))
    if case.finite_variation:
        return _set(case)
    return _bound(Fraction(-1, 2) - Fraction(1, 2 * case.d), "He and Wang 2015")


def _sobol(case: _Case) -> Theory:
    return _scrambled_net(case) if case.keys.get("scramble") == "owen" else _set(case)


def _pmj02(case: _Case) -> Theory | None:
    return _scrambled_net(case) if case.d <= 2 else None


def _planar_set(case: _Case) -> Theory | None:
    return _set(case) if case.d == 2 else None


def _poisson_disk(case: _Case) -> Theory | None:
    if case.keys or case.d != 2 or not case.smooth:
        return None
    return _bound(Fraction(-1, 2), "Pilleboue et al. 2015")


def _r2(case: _Case) -> Theory | None:
    return _sequence(case) if case.d == 1 else None  # the golden ratio's multiples; no proof in more dimensions


_THEORIES: Mapping[str, Callable[[_Case], Theory | None]] = {
    "random": _random,
    "jittered": _jittered,
    "n-rooks": _n_rooks,
    "orthogonal-array": _orthogonal_array,
    "regular": _grid,
    "gauss-legendre": _quadrature,
    "clenshaw-curtis": _quadrature,
    "halton": _sequence,
    "hammersley": _set,
    "sobol": _sobol,
    "pmj02": _pmj02,
    "zaremba": _planar_set,
    "larcher-pillichshammer": _planar_set,
    "lattice": _planar_set,
    "poisson-disk": _poisson_disk,
    "r2": _r2,
}
_SHIFT_KEEPS = ("halton", "hammersley", "sobol", "zaremba", "larcher-pillichshammer", "lattice", "r2")
"""A shift modulo 1 leaves a box in at most 2^d boxes, so the order of a discrepancy stays."""


def theory(sampler: str, integrand: Integrand, d: int, shifted: bool = False) -> Theory | None:
    """What theory gives for a sampler's spec, or None. Nothing of constants, which every pattern has exactly."""
    name, keys = specs.split(sampler)
    if name not in _THEORIES or integrand.name == "constant" or (shifted and name not in _SHIFT_KEEPS):
        return None
    return _THEORIES[name](_Case(keys, integrand, d))
