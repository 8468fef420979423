"""Filters at their extremes: their integral across an edge however hard, at all widths, and their response at any
frequency, against the same integrals of their definitions in mpmath.

Profiles that are cubics in pieces go by exact fractions; the others by closed forms.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath

from aliascope.native import filters
from aliascope.stability.records import Probe

DIGITS = 60
"""Of mpmath: transforms by parts lose a power of the frequency for each degree."""

BOUND = 1e-12
"""What filter.h and its users may count on, of a profile whose integral is 1."""

Number = Any
"""Of mpmath, which has no types."""

Piece = tuple[Fraction, Fraction, tuple[Fraction, ...]]
"""From, to, and coefficients by powers of x."""


def _cubic(b: Fraction, c: Fraction) -> list[Piece]:
    """Mitchell and Netravali 1988, eq. 8."""
    near = (6 - 2 * b, Fraction(0), -18 + 12 * b + 6 * c, 12 - 9 * b - 6 * c)
    far = (8 * b + 24 * c, -12 * b - 48 * c, 6 * b + 30 * c, -b - 6 * c)
    return [(Fraction(0), Fraction(1), near), (Fraction(1), Fraction(2), far)]


def _boxes() -> list[Piece]:
    """Boxes of 1, 1/2, 1/2 and 1/4 convolved: the sum over all choices of ends of +- (x + ends)_+^3, for x >= 0 as that
    of (ends - x)_+^3, since the profile is even."""
    terms: dict[Fraction, int] = {}
    for choice in range(16):
        signs = [1 if choice >> i & 1 else -1 for i in range(4)]
        place = sum(
            (s * w for s, w in zip(signs, (Fraction(1, 2), *[Fraction(1, 4)] * 2, Fraction(1, 8)), strict=True)),
            Fraction(0),
        )
        terms[place] = terms.get(place, 0) + signs[0] * signs[1] * signs[2] * signs[3]
    knots = sorted(place for place, factor in terms.items() if factor and place > 0)
    pieces = []
    for begin, end in zip([Fraction(0), *knots], knots, strict=False):
        of = [Fraction(0)] * 4
        for place, factor in terms.items():
            if place >= end:
                for power, coefficient in enumerate((place**3, -3 * place**2, 3 * place, Fraction(-1))):
                    of[power] += factor * coefficient
        pieces.append((begin, end, tuple(of)))
    return pieces


def _third(numerator: int = 1) -> Fraction:
    return Fraction(numerator, 3)


class _Pieces:
    """A profile that is a polynomial on each of its pieces, stretched to a radius."""

    def __init__(self, pieces: list[Piece], radius: Fraction | None = None) -> None:
        stretch = (radius or pieces[-1][1]) / pieces[-1][1]
        self.pieces = [
            (begin * stretch, end * stretch, tuple(a / stretch**k for k, a in enumerate(of)))
            for begin, end, of in pieces
        ]
        self._whole = 2 * self._to(self.pieces[-1][1])

    def _to(self, x: Fraction) -> Fraction:
        total = Fraction(0)
        for begin, end, of in self.pieces:
            high = min(max(x, begin), end)
            total += sum((a * (high ** (k + 1) - begin ** (k + 1)) / (k + 1) for k, a in enumerate(of)), Fraction(0))
        return total

    def integral(self, x: float) -> Number:
        """From minus infinity to x."""
        half = self._to(Fraction(abs(x))) / self._whole
        share = Fraction(1, 2) + (half if x >= 0 else -half)
        return mpmath.mpf(share.numerator) / share.denominator

    def response(self, frequency: float) -> Number:
        """By parts: p sin / w + p' cos / w^2 - p'' sin / w^3 - p''' cos / w^4, at the ends of the pieces."""
        turn, total = 2 * mpmath.pi * mpmath.mpf(frequency), mpmath.mpf(0)
        for begin, end, of in self.pieces:
            for x, sign in ((end, 1), (begin, -1)):
                derived, place = list(of), mpmath.mpf(x.numerator) / x.denominator
                for k in range(len(of)):
                    value = sum((a * x**j for j, a in enumerate(derived)), Fraction(0))
                    wave = mpmath.cos(turn * place) if k % 2 else mpmath.sin(turn * place)
                    turned = -wave if k % 4 > 1 else wave
                    total += sign * turned * value.numerator / value.denominator / turn ** (k + 1)
                    derived = [j * a for j, a in enumerate(derived)][1:]
        return 2 * total * self._whole.denominator / self._whole.numerator


class _Gaussian:
    """exp(-x^2 / (2 sigma^2)) up to its radius."""

    def __init__(self, sigma: float, radius: float) -> None:
        self.sigma, self.radius = sigma, radius

    def integral(self, x: float) -> Number:
        to = mpmath.mpf(min(abs(x), self.radius))
        half = mpmath.erf(to / self.sigma / mpmath.sqrt(2)) / mpmath.erf(
            mpmath.mpf(self.radius) / self.sigma / mpmath.sqrt(2)
        )
        return (1 + (half if x >= 0 else -half)) / 2

    def response(self, frequency: float) -> Number:
        """exp(-b^2) Re erf(a + i b) / erf(a), with the part that has no size by the complementary function of Faddeeva:
        exp(-b^2) erfc(a + i b) = exp(-a^2 - 2 i a b) w(i a - b), of which erfc itself would be beyond all numbers."""
        a = mpmath.mpf(self.radius) / self.sigma / mpmath.sqrt(2)
        b = mpmath.sqrt(2) * mpmath.pi * frequency * mpmath.mpf(self.sigma)
        rest = mpmath.exp(-b * b) * mpmath.erfc(mpmath.mpc(a, b))
        return (mpmath.exp(-b * b) - mpmath.re(rest)) / mpmath.erf(a)


class _Cosines:
    """The window of Blackman and Harris: a sum of cosines of k pi x / radius."""

    TERMS = ("0.35875", "0.48829", "0.14128", "0.01168")

    def __init__(self, radius: float) -> None:
        self.radius = radius

    def integral(self, x: float) -> Number:
        to, radius = mpmath.mpf(min(abs(x), self.radius)), mpmath.mpf(self.radius)
        terms = [mpmath.mpf(term) for term in self.TERMS]
        total = terms[0] * to
        for k in range(1, 4):
            total += terms[k] * radius / (k * mpmath.pi) * mpmath.sin(k * mpmath.pi * to / radius)
        half = total / (2 * terms[0] * radius)
        return mpmath.mpf(1) / 2 + (half if x >= 0 else -half)

    def response(self, frequency: float) -> Number:
        radius, terms = mpmath.mpf(self.radius), [mpmath.mpf(term) for term in self.TERMS]
        turn = 2 * mpmath.mpf(frequency) * radius
        total = mpmath.mpf(0)
        for k in range(4):
            total += terms[k] * radius * (mpmath.sincpi(turn - k) + mpmath.sincpi(turn + k))
        return total / (2 * terms[0] * radius)


class _Lanczos:
    """sin(pi x) sin(pi x / a) a / (pi x)^2 up to a: by the sine integral, since a product of sines is half a difference
    of 1 - cos(g x), and the integral of (1 - cos(g x)) / x^2 to x is g Si(g x) - (1 - cos(g x)) / x."""

    def __init__(self, lobes: int) -> None:
        self.lobes = lobes

    @staticmethod
    def _part(rate: Number, x: Number) -> Number:
        return rate * mpmath.si(rate * x) - (1 - mpmath.cos(rate * x)) / x if x else mpmath.mpf(0)

    def _to(self, x: Number, turn: Number) -> Number:
        """Of the profile times cos(turn x), from 0 to x; without the constant a / pi^2."""
        slow, fast = mpmath.pi * (1 - mpmath.mpf(1) / self.lobes), mpmath.pi * (1 + mpmath.mpf(1) / self.lobes)
        signs = (turn, -turn)
        return sum(self._part(fast + each, x) - self._part(slow + each, x) for each in signs) / 4

    def integral(self, x: float) -> Number:
        whole = 2 * self._to(mpmath.mpf(self.lobes), mpmath.mpf(0))
        half = self._to(mpmath.mpf(min(abs(x), self.lobes)), mpmath.mpf(0)) / whole
        return mpmath.mpf(1) / 2 + (half if x >= 0 else -half)

    def response(self, frequency: float) -> Number:
        end = mpmath.mpf(self.lobes)
        return self._to(end, 2 * mpmath.pi * mpmath.mpf(frequency)) / self._to(end, mpmath.mpf(0))


Profile = _Pieces | _Gaussian | _Cosines | _Lanczos

_LINE: list[Piece] = [(Fraction(0), Fraction(1), (Fraction(1), Fraction(-1)))]
_FLAT: list[Piece] = [(Fraction(0), Fraction(1), (Fraction(1),))]

FILTERS: dict[str, Callable[[float], Profile]] = {
    "box": lambda radius: _Pieces(_FLAT, Fraction(radius)),
    "tent": lambda radius: _Pieces(_LINE, Fraction(radius)),
    "gaussian": lambda radius: _Gaussian(0.5, radius),
    "gaussian:sigma=0.1": lambda radius: _Gaussian(0.1, radius),
    "gaussian:sigma=8": lambda radius: _Gaussian(8.0, radius),
    "mitchell": lambda radius: _Pieces(_cubic(_third(), _third()), Fraction(radius)),
    "mitchell:b=-2,c=2": lambda radius: _Pieces(_cubic(Fraction(-2), Fraction(2)), Fraction(radius)),
    "catmull-rom": lambda radius: _Pieces(_cubic(Fraction(0), Fraction(1, 2)), Fraction(radius)),
    "lanczos": lambda radius: _Lanczos(round(radius)),
    "blackman-harris": _Cosines,
    "multi-stage": lambda radius: _Pieces(_boxes(), Fraction(radius)),
}
"""By spec, the profile of a radius."""

WIDTHS = (0.5, 1.0, 2.0, 4.0, 8.0)
LOBES = (1.0, 2.0, 3.0, 5.0, 8.0)
CONTRASTS = tuple(10.0**k for k in (0, 2, 4, 6, 9, 12))
FREQUENCIES = (0.001, 0.25, 1.0, 10.0, 100.0, 1000.0)

PLACES = (-7.9, -2.3, -1.7, -1.1, -0.6, -0.37, -0.13, 0.0, 0.11, 0.43, 0.51, 0.93, 1.31, 1.9, 2.6, 5.3, 7.77)
"""Of an edge, in pixels from the middle of a filter."""


def _with_radius(spec: str, radius: float) -> str:
    key = f"lobes={round(radius)}" if spec == "lanczos" else f"radius={radius!r}"
    return f"{spec}{',' if ':' in spec else ':'}{key}"


def _width(spec: str, at: float) -> float:
    """The largest error of the integral up to an edge, and of the whole."""
    with mpmath.workdps(DIGITS):
        of, made = FILTERS[spec](at), filters.made(_with_radius(spec, at))
        errors = [abs(made.integral(-mpmath.inf, place) - of.integral(place)) for place in (*PLACES, 9.0)]
        return float(max(errors))


def _contrast(spec: str, at: float) -> float:
    """A pixel that an edge between `at` and 1 goes by; relative where it is more than 1. One that it does not reach has
    1 to the last digit."""
    with mpmath.workdps(DIGITS):
        made = filters.made(spec)
        of, errors = FILTERS[spec](made.radius), []
        for place in PLACES:
            found = 1.0 + (at - 1.0) * made.integral(-float("inf"), place)
            truth = 1 + (mpmath.mpf(at) - 1) * of.integral(place)
            errors.append(abs(found - truth) / max(1, abs(truth)))
        return float(max(errors))


def _response(spec: str, at: float) -> float:
    with mpmath.workdps(DIGITS):
        made = filters.made(spec)
        return float(abs(float(made.response(at)) - FILTERS[spec](made.radius).response(at)))


def probes() -> list[Probe]:
    def probe(
        spec: str,
        extreme: str,
        unit: str,
        levels: tuple[float, ...],
        measure: Callable[[str, float], float],
        note: str = "",
    ) -> Probe:
        quick = (levels[0], levels[-1])
        against = "mpmath, of the definition"
        of = functools.partial(measure, spec)
        return Probe(spec, "filter", extreme, unit, against, 2.0**-53, BOUND, levels, of, quick, note)

    found = []
    for spec in FILTERS:
        widths = LOBES if spec == "lanczos" else WIDTHS
        found += [
            probe(spec, "hard-edge", "relative, or of 1", CONTRASTS, _contrast),
            probe(spec, "filter-width", "of the integral, 1", widths, _width),
            probe(spec, "frequency", "of the response at 0, 1", FREQUENCIES, _response),
        ]
    return found
