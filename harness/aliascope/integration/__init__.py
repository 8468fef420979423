"""Integration by sampling: how far from an integral that is known, at how many points, and how fast that falls."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from aliascope.errors import InvalidInput, Unsupported
from aliascope.integrands import Integrand, parse
from aliascope.integration.counts import counts
from aliascope.integration.koksma import KoksmaHlawka, koksma_hlawka
from aliascope.integration.measuring import ErrorAt, Pattern, error_at
from aliascope.integration.theory import Theory, theory
from aliascope.native import samplers
from aliascope.statistics import FittedRate, fit_rate

__all__ = [
    "LEAST_N",
    "MOST_N",
    "Convergence",
    "ErrorAt",
    "FittedRate",
    "Integration",
    "KoksmaHlawka",
    "Pattern",
    "Theory",
    "counts",
    "integrate",
]

LEAST_N, MOST_N, REALISATIONS = 16, 4096, 64
MOST_POINTS = 1 << 24
TELLING = (
    *("random", "regular", "jittered", "n-rooks", "poisson-disk", "halton", "hammersley", "sobol"),
    *("sobol:scramble=owen", "lattice", "gauss-legendre"),
)
"""The samplers that are compared where none is named."""


@dataclass(frozen=True)
class Convergence:
    """A sampler's errors, by rising n, their rate, or the reason why there is none; what theory says of it; and, where
    asked for, Koksma and Hlawka's bound, or the reason why there is none."""

    sampler: str
    shifted: bool
    errors: tuple[ErrorAt, ...]
    rate: FittedRate | None
    reason: str | None
    theory: Theory | None
    variation: tuple[KoksmaHlawka, ...] = ()
    no_variation: str | None = None


@dataclass(frozen=True)
class Integration:
    """What `integrate` found. refused: (sampler as it was given, why it is not among the results)."""

    integrand: Integrand
    d: int
    seed: int
    realisations: int
    results: tuple[Convergence, ...]
    refused: tuple[tuple[str, str], ...]


def integrate(
    integrand: str,
    sampler_specs: Iterable[str] | None = None,
    d: int = 2,
    *,
    realisations: int = REALISATIONS,
    least_n: int = LEAST_N,
    most_n: int = MOST_N,
    seed: int = 0,
    shift: bool = False,
    variation: bool = False,
    tell: Callable[[str, int, int], None] = lambda what, done, total: None,
) -> Integration:
    """The error of each sampler's estimate of an integral over [0, 1]^d, at one N an octave in [least_n, most_n].

    `integrand` and the samplers are specs; a telling set of samplers if none are given. `shift`: patterns that are not
    random are shifted modulo 1, at random; rules with weights are not, as their nodes belong to their weights.
    `variation`: Koksma and Hlawka's bound beside the error. `tell` hears of each sampler that begins.

    Raises SpecError; Unsupported where the integrand does not exist in d dimensions; InvalidInput for numbers out of
    range; CheckFailed where an error is above its bound, which is a theorem: then the variation is wrong.
    A sampler that has none of these N in d dimensions is refused, with the reason.
    """
    function = parse(integrand)
    reason = function.refusal(d)
    if reason:
        raise Unsupported(reason)
    if not 1 <= least_n <= most_n <= MOST_POINTS:
        raise InvalidInput(f"N from {least_n} to {most_n}: it is to be 1 <= least <= most <= {MOST_POINTS}")
    if not 2 <= realisations <= 1_000_000:
        raise InvalidInput(f"{realisations} realisations: 2 to 1000000, of which an error has its uncertainty")
    results: dict[str, Convergence] = {}
    refused = []
    wanted = list(dict.fromkeys(sampler_specs or TELLING))
    for done, spec in enumerate(wanted):
        tell(spec, done, len(wanted))
        numbers = counts(spec, d, least_n, most_n)
        if numbers:
            pattern = Pattern(samplers.Sampler(spec, numbers[0], d).spec, d, shift)
            results[pattern.spec] = _converge(function, pattern, numbers, realisations, seed, variation)
        else:
            refused.append((spec, _why_none(spec, d, least_n, most_n)))
    return Integration(function, d, seed, realisations, tuple(results.values()), tuple(refused))


def _converge(
    integrand: Integrand, pattern: Pattern, numbers: list[int], realisations: int, seed: int, variation: bool
) -> Convergence:
    errors = tuple(error_at(integrand, pattern, n, realisations, seed) for n in numbers)
    rate, reason = _rate(errors)
    bounds, no_bounds = koksma_hlawka(integrand, pattern, numbers, seed) if variation else ((), None)
    shifted = pattern.is_shifted(numbers[0])
    known = theory(pattern.spec, integrand, pattern.d, shifted)
    return Convergence(pattern.spec, shifted, errors, rate, reason, known, bounds, no_bounds)


def _why_none(spec: str, d: int, least: int, most: int) -> str:
    """The library's own words where it refuses both ends of the range."""
    return samplers.refusal(spec, most, d) or f"{spec}: has no set of {least} to {most} points in {d} dimensions"


def _rate(errors: tuple[ErrorAt, ...]) -> tuple[FittedRate | None, str | None]:
    """The rate through the errors that are not rounding."""
    used = [error for error in errors if not error.at_floor]
    if len(used) < 3:
        if len(used) < len(errors):
            return None, "exact but for rounding" if not used else "at the floor of rounding from the third N on"
        return None, f"{len(used)} number{'s' * (len(used) != 1)} of points, and a rate takes 3"
    return fit_rate([e.n for e in used], [e.rmse for e in used], [e.standard_error for e in used]), None
