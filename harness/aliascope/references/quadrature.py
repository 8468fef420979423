"""Integrals of functions that are smooth between known breaks, where they may go like a root of the distance.

Gauss-Legendre in s, with t = low + (high - low) s^2 (3 - 2 s): a root at an end becomes a power of s. Where rules of 10
and of 16 nodes disagree, the interval is halved; their difference bounds the error of the longer rule by far.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import Unsupported
from aliascope.geometry import Array

SHORT, LONG = 10, 16
TOLERANCE = 1e-13
LEVELS = 40
CHUNK = 1 << 15

Index = NDArray[np.int64]
Integrand = Callable[[Index, Array], Array]
"""Values (n, k) of the owners (n,) at the places (n, k)."""


def integrate(integrand: Integrand, breaks: Array) -> tuple[Array, float]:
    """The integral for each owner (n,) from the least to the largest of its breaks (n, m), and a bound of the errors.

    Raises Unsupported where it does not settle.
    """
    owners, count = breaks.shape
    breaks = np.sort(breaks, axis=1)
    owner = np.repeat(np.arange(owners), count - 1)
    low, high = breaks[:, :-1].ravel(), breaks[:, 1:].ravel()
    total, error = np.zeros(owners), np.zeros(owners)
    for _ in range(LEVELS):
        kept = high > low
        owner, low, high = owner[kept], low[kept], high[kept]
        if not len(owner):
            return total, float(error.max(initial=0.0))
        value, difference = _rules(integrand, owner, low, high)
        settled = difference <= TOLERANCE
        np.add.at(total, owner[settled], value[settled])
        np.add.at(error, owner[settled], difference[settled])
        owner, low, high = owner[~settled], low[~settled], high[~settled]
        middle = 0.5 * (low + high)
        owner = np.concatenate([owner, owner])
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    raise Unsupported("an integral over the lens does not settle")


def _rules(integrand: Integrand, owner: Index, low: Array, high: Array) -> tuple[Array, Array]:
    """The integral over each interval by the longer rule, and how far the shorter one lies from it."""
    nodes, weights = zip(*(_rule(n) for n in (SHORT, LONG)), strict=True)
    places, both = np.concatenate(nodes), np.concatenate(weights)
    value, difference = np.empty(len(owner)), np.empty(len(owner))
    for start in range(0, len(owner), CHUNK):
        part = slice(start, start + CHUNK)
        width = (high - low)[part, np.newaxis]
        terms = integrand(owner[part], low[part, np.newaxis] + width * places) * both * width
        value[part] = terms[:, SHORT:].sum(axis=1)
        difference[part] = np.abs(terms[:, :SHORT].sum(axis=1) - value[part])
    return value, difference


def _rule(n: int) -> tuple[Array, Array]:
    x, w = np.polynomial.legendre.leggauss(n)
    s = 0.5 * (x + 1.0)
    return s * s * (3.0 - 2.0 * s), 3.0 * s * (1.0 - s) * w  # 6 s (1 - s), over half the width of [-1, 1]
