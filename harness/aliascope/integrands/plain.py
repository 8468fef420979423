"""Integrands of a formula a schoolbook has: constant, linear, products."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aliascope.integrands.base import Array, Factor, Function, Kind, Product
from aliascope.specs import Key, Spec


@dataclass(frozen=True)
class _Constant(Function):
    value: float

    def evaluate(self, points: Array) -> Array:
        return np.full(len(points), self.value)

    def exact(self, d: int) -> float:
        return self.value

    def variation(self, d: int) -> float:
        return 0.0


@dataclass(frozen=True)
class _Linear(Function):
    def evaluate(self, points: Array) -> Array:
        values: Array = points.mean(axis=1)
        return values

    def exact(self, d: int) -> float:
        return 0.5

    def variation(self, d: int) -> float:
        return 1.0  # 1/d for each coordinate alone; of two together, the mixed difference is 0


def _product(spec: Spec) -> Function:
    strength = spec.real("strength")

    def value(x: Array) -> Array:
        return 1.0 + strength * (x * np.exp(x) - 1.0)

    # x e^x rises from 0 to e and has the integral 1.
    factor = Factor(value, 1.0, strength * math.e, 1.0 + strength * (math.e - 1.0))
    return Product(lambda d: [factor] * d)


def _g_values(a: float) -> Callable[[Array], Array]:
    def value(x: Array) -> Array:
        return (np.abs(4.0 * x - 2.0) + a) / (1.0 + a)

    return value


def _g_function(spec: Spec) -> Function:
    weight = spec.real("weight")

    def factors(d: int) -> list[Factor]:
        made = []
        for j in range(1, d + 1):
            a = weight * (j - 1)
            made.append(Factor(_g_values(a), 1.0, 4.0 / (1.0 + a), (2.0 + a) / (1.0 + a)))
        return made

    return Product(factors)


KINDS = (
    Kind(
        name="constant",
        title="a constant",
        source="what every rule must have exactly",
        keys=(Key("value", "real", 1.0, "which", -1e300, 1e300),),
        smoothness="analytic",
        make=lambda spec: _Constant(spec.real("value")),
    ),
    Kind(
        name="linear",
        title="the mean of the coordinates",
        source="a ramp through a pixel",
        keys=(),
        smoothness="analytic",
        make=lambda spec: _Linear(),
    ),
    Kind(
        name="product",
        title="a smooth product of 1 + s (x_j e^x_j - 1)",
        source="after Owen 1997",
        keys=(Key("strength", "real", 1.0, "s, how far from constant", 0.0, 1.0),),
        smoothness="analytic",
        make=_product,
    ),
    Kind(
        name="g-function",
        title="the product of (|4 x_j - 2| + a_j) / (1 + a_j), a_j = (j - 1) weight",
        source="Sobol 1993; Saltelli and Sobol 1995",
        keys=(Key("weight", "real", 1.0, "how fast a_j grows", 0.0, 1e6),),
        smoothness="kinked",
        make=_g_function,
    ),
)
