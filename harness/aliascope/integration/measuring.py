"""The error of a pattern's estimate of an integral, at one number of points."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aliascope import statistics
from aliascope.integrands import Integrand
from aliascope.native.samplers import Sampler, points

Array = NDArray[np.float64]
_EPSILON = 2.0**-53
_LAST = 1.0 - 2.0**-24


@dataclass(frozen=True)
class Pattern:
    """A sampler's spec in d dimensions; `shift`: moved modulo 1 at random, unless it is random by itself or a rule of
    quadrature, whose nodes belong to their weights."""

    spec: str
    d: int
    shift: bool = False

    def is_shifted(self, n: int) -> bool:
        sampler = Sampler(self.spec, n, self.d)
        return self.shift and not sampler.randomised and not sampler.weighted

    def is_random(self, n: int) -> bool:
        """Whether there is more than one realisation."""
        return self.is_shifted(n) or Sampler(self.spec, n, self.d).randomised

    def is_weighted(self, n: int) -> bool:
        return Sampler(self.spec, n, self.d).weighted

    def realisation(self, n: int, seed: int) -> tuple[Array, Array]:
        """Points (n, d) and their weights (n,)."""
        sampler = Sampler(self.spec, n, self.d, seed)
        at = sampler.points(n)
        if sampler.weighted:
            # The library keeps its points below 1; the rule's own node there is 1.
            at = np.where(at == _LAST, 1.0, at)
        elif self.shift and not sampler.randomised:
            at = (at + points("random", 1, self.d, seed)) % 1.0
        return at, sampler.weights(n)


@dataclass(frozen=True)
class ErrorAt:
    """Of n points: the root of the mean squared error over realisations, with its standard error; of one realisation
    its |error|, exact, so that its standard error is 0.

    floor: below this an error is rounding, and says nothing of the pattern.
    """

    n: int
    rmse: float
    standard_error: float
    realisations: int
    floor: float

    @property
    def at_floor(self) -> bool:
        return self.rmse <= self.floor


def realisation_seed(seed: int, n: int, index: int) -> int:
    """The seed of a realisation: others for other N, so that errors at different N are independent."""
    return int(np.random.SeedSequence([seed, n, index]).generate_state(1, np.uint64)[0])


def estimate(integrand: Integrand, at: Array, weights: Array) -> tuple[float, float]:
    """The weighted sum of the values, and of their magnitudes. Products and sum are exact until the last rounding."""
    terms = integrand.evaluate(at) * weights.astype(np.longdouble)
    # A double holds the upper and the lower half of each extended product; fsum adds them all without error.
    upper = terms.astype(np.float64)
    lower = (terms - upper).astype(np.float64)
    return math.fsum(np.concatenate([upper, lower]).tolist()), float(np.abs(terms).sum())


def error_at(integrand: Integrand, pattern: Pattern, n: int, realisations: int, seed: int) -> ErrorAt:
    """The error of n points, over realisations where the pattern has more than one.

    The floor is 64 d times the rounding of one operation on the mean magnitude of the values: what the integrand, its
    integral and the points' coordinates may round away. Raises the sampler's errors.
    """
    d, exact = pattern.d, integrand.exact(pattern.d)
    errors, size = [], 0.0
    for index in range(realisations if pattern.is_random(n) else 1):
        found, magnitude = estimate(integrand, *pattern.realisation(n, realisation_seed(seed, n, index)))
        errors.append(found - exact)
        size = max(size, magnitude, abs(exact))
    floor = 64.0 * d * _EPSILON * size
    if len(errors) == 1:
        return ErrorAt(n, abs(errors[0]), 0.0, 1, floor)
    root = statistics.root_mean_square(errors)
    assert root.value is not None
    assert root.standard_error is not None
    return ErrorAt(n, root.value, root.standard_error, len(errors), floor)
