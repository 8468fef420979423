"""Genz's six families.

Genz, Testing multidimensional integration routines (1984). Each has a weight a_j > 0 a dimension, how hard it is, and a
place w_j in (0, 1). Their sum over the dimensions is the key `difficulty`; its defaults are those of Barthelmann, Novak
and Ritter, High dimensional polynomial interpolation on sparse grids (2000). With `draw=0` all a_j are equal and w_j is
0.3 + 0.4 frac(j / golden ratio), so that none lies on a grid; draw=1, 2, ... are Genz's: a_j and w_j uniform at random,
the a_j then scaled to their sum.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import Context, Decimal, localcontext

import numpy as np

from aliascope.integrands.base import Array, Factor, Function, Kind, Product
from aliascope.specs import Key, Spec

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def irrational_places(d: int) -> Array:
    """(d,) places in (0.3, 0.7), all different, none on a grid."""
    return np.array([0.3 + 0.4 * (j * GOLDEN % 1.0) for j in range(1, d + 1)])


@functools.lru_cache(maxsize=256)
def parameters(draw: int, difficulty: float, d: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The weights a and the places w, d of each."""
    if draw == 0:
        return (difficulty / d,) * d, tuple(map(float, irrational_places(d)))
    # The bits of PCG64 are the same in every version of numpy; what its distributions make of them is not promised.
    drawn = ((np.random.PCG64(draw).random_raw(2 * d) >> np.uint64(11)) + 0.5) * 2.0**-53
    weights, places = drawn[0::2], drawn[1::2]
    return tuple(map(float, weights * (difficulty / weights.sum()))), tuple(map(float, places))


@dataclass(frozen=True)
class _Oscillatory(Function):
    difficulty: float
    draw: int

    def _of(self, d: int) -> tuple[Array, float]:
        weights, places = parameters(self.draw, self.difficulty, d)
        return np.array(weights), 2.0 * math.pi * places[0]

    def evaluate(self, points: Array) -> Array:
        weights, phase = self._of(points.shape[1])
        values: Array = np.cos(phase + (points * weights).sum(axis=1))
        return values

    def exact(self, d: int) -> float:
        weights, phase = self._of(d)
        halves = [float(a) / 2.0 for a in weights]
        return math.cos(phase + math.fsum(halves)) * math.prod(math.sin(h) / h for h in halves)

    def variation(self, d: int) -> float | None:
        if d > 1:
            return None
        weights, phase = self._of(1)

        def travelled(angle: float) -> float:
            """The length of the way of the cosine from 0 to this angle."""
            turns, rest = divmod(angle, math.pi)
            return 2.0 * turns + 1.0 - math.cos(rest)

        return travelled(phase + weights[0]) - travelled(phase)

    def no_variation(self, d: int) -> str:
        return "finite, but without a closed form in more than one dimension"


@dataclass(frozen=True)
class _CornerPeak(Function):
    difficulty: float
    draw: int

    def _weights(self, d: int) -> tuple[float, ...]:
        return parameters(self.draw, self.difficulty, d)[0]

    def evaluate(self, points: Array) -> Array:
        d = points.shape[1]
        values: Array = (1.0 + (points * np.array(self._weights(d))).sum(axis=1)) ** -(d + 1.0)
        return values

    def exact(self, d: int) -> float:
        return corner_peak_integral(self._weights(d))

    def variation(self, d: int) -> float:
        # Its mixed derivative over a set u has the sign of (-1)^|u| everywhere, so Vitali's variations are alternating
        # sums over corners; of their sum only f(0) - f(1) is left.
        return 1.0 - math.pow(1.0 + math.fsum(self._weights(d)), -(d + 1.0))


@functools.lru_cache(maxsize=64)
def corner_peak_integral(weights: tuple[float, ...]) -> float:
    """The integral of (1 + a.x)^-(d+1): the sum over corners v of (-1)^|v| / (1 + a.v), over d! a_1 ... a_d.

    The sum cancels: for d = 16 and a_j = 0.01 some 60 digits, for which 120 are carried.
    """
    with localcontext(Context(prec=120)):
        exact = [Decimal(a) for a in weights]
        total = Decimal(0)
        for corner in itertools.product((0, 1), repeat=len(exact)):
            term = 1 / (1 + sum((a for a, at in zip(exact, corner, strict=True) if at), Decimal(0)))
            total += -term if sum(corner) % 2 else term
        return float(total / (math.factorial(len(exact)) * math.prod(exact, start=Decimal(1))))


def _product_peak(j: int, a: float, w: float) -> Factor:
    def value(x: Array) -> Array:
        values: Array = 1.0 / (a**-2.0 + (x - w) ** 2)
        return values

    ends = [1.0 / (a**-2.0 + (x - w) ** 2) for x in (0.0, 1.0)]
    return Factor(value, a * (math.atan(a * (1.0 - w)) + math.atan(a * w)), 2.0 * a * a - sum(ends), ends[1])


def _gaussian(j: int, a: float, w: float) -> Factor:
    def value(x: Array) -> Array:
        values: Array = np.exp(-((a * (x - w)) ** 2))
        return values

    ends = [math.exp(-((a * (x - w)) ** 2)) for x in (0.0, 1.0)]
    integral = math.sqrt(math.pi) / (2.0 * a) * (math.erf(a * (1.0 - w)) + math.erf(a * w))
    return Factor(value, integral, 2.0 - sum(ends), ends[1])


def _continuous(j: int, a: float, w: float) -> Factor:
    def value(x: Array) -> Array:
        values: Array = np.exp(-a * np.abs(x - w))
        return values

    ends = [math.exp(-a * w), math.exp(-a * (1.0 - w))]
    return Factor(value, -(math.expm1(-a * w) + math.expm1(-a * (1.0 - w))) / a, 2.0 - sum(ends), ends[1])


def _discontinuous(j: int, a: float, w: float) -> Factor:
    if j >= 2:
        return Factor(lambda x: np.exp(a * x), math.expm1(a) / a, math.expm1(a), math.exp(a))
    top = math.exp(a * w)
    return Factor(lambda x: np.where(x > w, 0.0, np.exp(a * x)), math.expm1(a * w) / a, 2.0 * top - 1.0, 0.0)


def _product(factor: Callable[[int, float, float], Factor]) -> Callable[[Spec], Function]:
    def make(spec: Spec) -> Function:
        def factors(d: int) -> list[Factor]:
            weights, places = parameters(spec.integer("draw"), spec.real("difficulty"), d)
            return [factor(j, a, w) for j, (a, w) in enumerate(zip(weights, places, strict=True))]

        return Product(factors)

    return make


def _kind(name: str, title: str, difficulty: float, make: Callable[[Spec], Function]) -> Kind:
    keys = (
        Key("difficulty", "real", difficulty, "the sum of the weights a_j", 1e-3, 1e3),
        Key("draw", "integer", 0, "0: equal weights, fixed places; else the seed they are drawn from", 0, 2**32 - 1),
    )
    source = "Genz 1984; Barthelmann, Novak and Ritter 2000"
    return Kind(name=name, title=title, source=source, keys=keys, smoothness="analytic", make=make)


KINDS = (
    _kind(
        "oscillatory",
        "Genz's cos(2 pi w_1 + sum of a_j x_j)",
        9.0,
        lambda spec: _Oscillatory(spec.real("difficulty"), spec.integer("draw")),
    ),
    _kind("product-peak", "Genz's product of 1 / (a_j^-2 + (x_j - w_j)^2)", 7.25, _product(_product_peak)),
    replace(
        _kind(
            "corner-peak",
            "Genz's (1 + sum of a_j x_j)^-(d + 1)",
            1.85,
            lambda spec: _CornerPeak(spec.real("difficulty"), spec.integer("draw")),
        ),
        most_dimensions=16,
    ),
    _kind("gaussian", "Genz's exp(-sum of a_j^2 (x_j - w_j)^2)", 7.03, _product(_gaussian)),
    replace(
        _kind("continuous", "Genz's exp(-sum of a_j |x_j - w_j|), with a crease", 20.4, _product(_continuous)),
        smoothness="kinked",
    ),
    replace(
        _kind(
            "discontinuous",
            "Genz's exp(sum of a_j x_j) where x_1 <= w_1 and x_2 <= w_2, else 0",
            4.3,
            _product(_discontinuous),
        ),
        smoothness="axis-parallel-jump",
    ),
)
