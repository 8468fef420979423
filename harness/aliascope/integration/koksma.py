"""The theorem on total variation in numbers: |error| <= V(f) D*_N (Koksma 1942, Hlawka 1961).

V after Hardy and Krause, D*_N the exact star discrepancy. No pattern and no integrand of finite variation can break it,
so where a ratio is above 1 a variation, an integral or a discrepancy is wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

from aliascope.errors import CheckFailed
from aliascope.integrands import Integrand
from aliascope.integration.measuring import Pattern, estimate, realisation_seed
from aliascope.native.discrepancy import measure

MOST_POINTS = {1: 65536, 2: 65536, 3: 512, 4: 64}
"""N up to which the exact star discrepancy takes a moment, by dimension."""
REALISATIONS = 4


@dataclass(frozen=True)
class KoksmaHlawka:
    """Of the realisation whose error came nearest to its bound: |error|, D*_N, V(f) D*_N and their ratio."""

    n: int
    error: float
    star_discrepancy: float
    bound: float
    ratio: float


def koksma_hlawka(
    integrand: Integrand, pattern: Pattern, counts: list[int], seed: int
) -> tuple[tuple[KoksmaHlawka, ...], str | None]:
    """The bound at each of these N that are few enough, of up to four realisations; or the reason why there is none.

    Raises CheckFailed where an error is above its bound.
    """
    d, variation = pattern.d, integrand.variation(pattern.d)
    if variation is None:
        return (), f"variation {integrand.no_variation(d)}"
    if variation == 0.0:
        return (), "the variation is 0: every rule has this exactly"
    few = [n for n in counts if n <= MOST_POINTS.get(d, 0)]
    if not few:
        most = MOST_POINTS.get(d)
        why = f"of at most {most} points" if most else "in at most 4 dimensions"
        return (), f"the exact star discrepancy is to be had {why}"
    if pattern.is_weighted(few[0]):
        return (), "the star discrepancy is that of equal weights"
    found = []
    for n in few:
        realisations = REALISATIONS if pattern.is_random(n) else 1
        found.append(max((_one(integrand, pattern, n, seed, r, variation) for r in range(realisations)), key=_ratio))
    return tuple(found), None


def _ratio(one: KoksmaHlawka) -> float:
    return one.ratio


def _one(integrand: Integrand, pattern: Pattern, n: int, seed: int, index: int, variation: float) -> KoksmaHlawka:
    at, weights = pattern.realisation(n, realisation_seed(seed, n, index))
    value, size = estimate(integrand, at, weights)
    error = abs(value - integrand.exact(pattern.d))
    star = measure("star", at).value
    bound = variation * star
    # Rounding of the two integrals and of the discrepancy: 2^-44 is 500 units in the last place.
    if error > bound + 2.0**-44 * (size + bound):
        raise CheckFailed(
            f"{integrand.spec}, {pattern.spec}, {n} points: error {error:.6g} is above V D* = {variation:.6g} x "
            f"{star:.6g}, against Koksma and Hlawka's theorem; the variation, the integral or the points are wrong"
        )
    return KoksmaHlawka(n, error, star, bound, error / bound)
