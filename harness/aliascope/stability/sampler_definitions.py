"""Points by their definitions alone, in exact fractions: none of the library's code, numbers or tables but scipy's of
Joe and Kuo's directions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import lru_cache
from importlib import resources
from math import isqrt

import mpmath
import numpy as np

DIGITS = 60
"""Decimal digits of numbers that are no fractions."""

Definition = Callable[[int, int, int], list[Fraction]]
"""(N, dimensions, index) -> the point."""


def as_stored(value: Fraction) -> Fraction:
    """A value as a sample can have it: those in [1 - 2^-25, 1], which are 1 as a float, are 1 - 2^-24."""
    return 1 - Fraction(1, 1 << 24) if value >= 1 - Fraction(1, 1 << 25) else value


@lru_cache(maxsize=8)
def primes(count: int) -> tuple[int, ...]:
    """The first."""
    found: list[int] = []
    candidate = 2
    while len(found) < count:
        if all(candidate % prime for prime in found if prime * prime <= candidate):
            found.append(candidate)
        candidate += 1
    return tuple(found)


def radical_inverse(base: int, index: int) -> Fraction:
    """The digits of an index in a base, mirrored at the point (van der Corput 1935)."""
    turned, denominator = 0, 1
    while index:
        index, digit = divmod(index, base)
        turned, denominator = turned * base + digit, denominator * base
    return Fraction(turned, denominator)


def halton(_: int, dimensions: int, index: int) -> list[Fraction]:
    return [radical_inverse(prime, index) for prime in primes(dimensions)]


def hammersley(n: int, dimensions: int, index: int) -> list[Fraction]:
    return [Fraction(index, n), *(halton(n, dimensions - 1, index) if dimensions > 1 else ())]


def zaremba(n: int, _: int, index: int) -> list[Fraction]:
    """The digits past the last are all 0, so every second of them is turned to 1: 1/2^m (1/4 + 1/16 + ...) or, where m
    is odd, twice that."""
    m = max(54, index.bit_length())
    m += m % 2
    turned = sum((((index >> j) + j) & 1) << (m - 1 - j) for j in range(m))
    return [Fraction(index, n), (turned + Fraction(1, 3)) / (1 << m)]


def zaremba_finite(n: int, _: int, index: int) -> list[Fraction]:
    m = max((n - 1).bit_length(), 1)
    return [Fraction(index, n), Fraction(sum((((index >> j) + j) & 1) << (m - 1 - j) for j in range(m)), 1 << m)]


def larcher_pillichshammer(n: int, _: int, index: int) -> list[Fraction]:
    y, v, rest = 0, 1 << 31, index
    while rest:
        if rest & 1:
            y ^= v
        rest >>= 1
        v |= v >> 1
    return [Fraction(index, n), Fraction(y, 1 << 32)]


@lru_cache(maxsize=1)
def _joe_kuo() -> tuple[list[int], list[list[int]]]:
    with resources.files("scipy.stats").joinpath("_sobol_direction_numbers.npz").open("rb") as file:
        numbers = np.load(file)
        return numbers["poly"].tolist(), numbers["vinit"].tolist()


@lru_cache(maxsize=2048)
def _directions(dimension: int) -> tuple[int, ...]:
    """32 of a dimension, in units of 2^-32 (Bratley and Fox 1988, eq. 1 to 3)."""
    polynomials, first = _joe_kuo()
    if dimension == 0:
        return tuple(1 << (31 - k) for k in range(32))
    polynomial = polynomials[dimension]
    degree = polynomial.bit_length() - 1
    m = first[dimension][:degree]
    for k in range(degree, 32):
        number = m[k - degree] ^ (m[k - degree] << degree)
        for j in range(1, degree):
            if polynomial >> (degree - j) & 1:
                number ^= m[k - j] << j
        m.append(number)
    return tuple(m[k] << (31 - k) for k in range(32))


def sobol(_: int, dimensions: int, index: int) -> list[Fraction]:
    """In natural order."""
    point = []
    for dimension in range(dimensions):
        value = 0
        for bit, direction in enumerate(_directions(dimension)):
            if index >> bit & 1:
                value ^= direction
        point.append(Fraction(value, 1 << 32))
    return point


@lru_cache(maxsize=16)
def _alphas(dimensions: int) -> tuple[int, ...]:
    """Powers of the inverse of the generalised golden ratio, in units of 2^-192."""
    with mpmath.workdps(DIGITS + dimensions // 3):
        ratio = mpmath.findroot(lambda g: g ** (dimensions + 1) - g - 1, 1 + mpmath.log(2) / (dimensions + 1))
        return tuple(int(mpmath.floor(mpmath.ldexp(ratio ** -(j + 1), 192))) for j in range(dimensions))


def r2(_: int, dimensions: int, index: int) -> list[Fraction]:
    whole = 1 << 192
    return [Fraction((whole // 2 + index * alpha) % whole, whole) for alpha in _alphas(dimensions)]


def fibonacci(n: int, _: int, index: int) -> list[Fraction]:
    last, number = 1, 1
    while number < n:
        last, number = number, last + number
    return [Fraction(index, n), Fraction(index * last % n, n)]


def _tensor(node: Callable[[int, int], Fraction]) -> Definition:
    """Of k^d points, the first dimension running fastest."""

    def point(n: int, dimensions: int, index: int) -> list[Fraction]:
        k = root(n, dimensions)
        return [node(k, index // k**dimension % k) for dimension in range(dimensions)]

    return point


def root(n: int, degree: int) -> int:
    """The whole number whose power this is, or the one above its root."""
    if degree == 2:
        return isqrt(n - 1) + 1
    guess = max(round(n ** (1 / degree)) - 1, 1)
    while guess**degree < n:
        guess += 1
    return int(guess)


def _centre(k: int, j: int) -> Fraction:
    return Fraction(2 * j + 1, 2 * k)


def _extremum(k: int, j: int) -> Fraction:
    """Of a Chebyshev polynomial."""
    if k == 1:
        return Fraction(1, 2)
    with mpmath.workdps(DIGITS):
        return _fraction(mpmath.sin(j * mpmath.pi / (2 * (k - 1))) ** 2)


@lru_cache(maxsize=64)
def _zero(k: int, j: int) -> Fraction:
    """Of a Legendre polynomial on [0, 1], by Newton's method and the recurrence."""
    with mpmath.workdps(DIGITS):
        x = -mpmath.cos(mpmath.pi * (j + mpmath.mpf(3) / 4) / (k + mpmath.mpf(1) / 2))
        for _ in range(8):
            below, value = mpmath.mpf(0), mpmath.mpf(1)
            for m in range(k):
                below, value = value, ((2 * m + 1) * x * value - m * below) / (m + 1)
            step = value * (x * x - 1) / (k * (x * value - below))
            x -= step
            if abs(step) < mpmath.mpf(10) ** -(DIGITS // 2):
                break
        return _fraction((1 + x) / 2)


def _fraction(value: mpmath.mpf) -> Fraction:
    return Fraction(int(mpmath.floor(mpmath.ldexp(value, 192))), 1 << 192)


regular = _tensor(_centre)
clenshaw_curtis = _tensor(_extremum)
gauss_legendre = _tensor(_zero)


def strata(values: Sequence[float], count: int) -> list[int]:
    """Which of `count` equal parts of [0, 1) each lies in: floor(count x) of the very doubles (of 2^-147 and more)."""
    return [int(value * 2.0**200) * count >> 200 for value in values]
