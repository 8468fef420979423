"""What an integrand is: a function on the unit cube with a known integral, and where it is known, variation."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aliascope.errors import InvalidInput, Unsupported
from aliascope.specs import Form, Key, Spec

Array = NDArray[np.float64]
Smoothness = Literal["analytic", "kinked", "axis-parallel-jump", "jump"]
SMOOTHNESS: dict[Smoothness, str] = {
    "analytic": "all derivatives",
    "kinked": "continuous, its first derivatives jump",
    "axis-parallel-jump": "jumps, across faces parallel to the axes",
    "jump": "jumps, across a surface that is not parallel to the axes",
}


class Function(ABC):
    """A function on [0, 1]^d for every d that its kind exists in, its parameters chosen."""

    @abstractmethod
    def evaluate(self, points: Array) -> Array:
        """(n,) values at points (n, d)."""

    @abstractmethod
    def exact(self, d: int) -> float:
        """The integral over [0, 1]^d."""

    @abstractmethod
    def variation(self, d: int) -> float | None:
        """The variation after Hardy and Krause, anchored at (1, ..., 1); None if infinite or without a closed form."""

    def no_variation(self, d: int) -> str:
        """Why `variation` is None."""
        return ""


@dataclass(frozen=True)
class Kind:
    """What is registered under a name: how it is shown, where it exists, and how a spec makes a function of it."""

    name: str
    title: str
    source: str
    keys: tuple[Key, ...]
    smoothness: Smoothness
    make: Callable[[Spec], Function]
    least_dimensions: int = 1
    most_dimensions: int = 64

    @property
    def form(self) -> Form:
        return Form(self.name, self.title, self.keys)


@dataclass(frozen=True)
class Integrand:
    """An integrand that a spec names. `spec` is its canonical text."""

    spec: str
    kind: Kind
    function: Function

    @property
    def name(self) -> str:
        return self.kind.name

    @property
    def title(self) -> str:
        return self.kind.title

    @property
    def source(self) -> str:
        return self.kind.source

    @property
    def keys(self) -> tuple[Key, ...]:
        return self.kind.keys

    @property
    def smoothness(self) -> Smoothness:
        return self.kind.smoothness

    def refusal(self, d: int) -> str | None:
        """Why there is none in d dimensions, or None."""
        least, most = self.kind.least_dimensions, self.kind.most_dimensions
        if least <= d <= most:
            return None
        span = f"{least}" if least == most else f"{least} to {most}"
        return f"integrand {self.name}: exists in {span} dimension{'s' * (span != '1')}, not in {d}"

    def evaluate(self, points: ArrayLike) -> Array:
        """(n,) float64 values at points (n, d) in [0, 1]. Raises InvalidInput, Unsupported for d."""
        given = np.ascontiguousarray(points, dtype=np.float64)
        if given.ndim != 2:
            raise InvalidInput(f"points are a table of n rows and d columns, not of shape {given.shape}")
        self._check(given.shape[1])
        return self.function.evaluate(given)

    def exact(self, d: int = 2) -> float:
        """The integral over [0, 1]^d, in closed form. Raises Unsupported."""
        self._check(d)
        return self.function.exact(d)

    def variation(self, d: int = 2) -> float | None:
        """V(f) after Hardy and Krause: the sum, over every non-empty set of coordinates, of Vitali's variation of f in
        these with the others at 1. None where it is infinite or has no closed form. Raises Unsupported."""
        self._check(d)
        return self.function.variation(d)

    def no_variation(self, d: int = 2) -> str | None:
        """Why `variation` is None, or None where it is a number."""
        return None if self.variation(d) is not None else self.function.no_variation(d)

    def _check(self, d: int) -> None:
        reason = self.refusal(d)
        if reason:
            raise Unsupported(reason)


@dataclass(frozen=True)
class Factor:
    """A function g of one coordinate: its values, its integral over [0, 1], its total variation there, |g(1)|."""

    value: Callable[[Array], Array]
    integral: float
    variation: float
    at_one: float


@dataclass(frozen=True)
class Product(Function):
    """A product of functions of one coordinate each; `factors(d)` are those of d dimensions."""

    factors: Callable[[int], Sequence[Factor]]

    def evaluate(self, points: Array) -> Array:
        values = np.ones(len(points))
        for column, factor in zip(points.T, self.factors(points.shape[1]), strict=True):
            values *= factor.value(column)
        return values

    def exact(self, d: int) -> float:
        return math.prod(factor.integral for factor in self.factors(d))

    def variation(self, d: int) -> float:
        # Of a product, Vitali's variation over a set u is that of each factor in u times |g(1)| of the others; the sum
        # over all u but the empty one is the expanded product below.
        factors = self.factors(d)
        whole = math.prod(factor.variation + factor.at_one for factor in factors)
        return whole - math.prod(factor.at_one for factor in factors)
