"""Nodes and weights of quadrature against mpmath, in 60 digits, and against NumPy."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

from aliascope.errors import Unsupported
from aliascope.native import samplers

ULP = 2.0**-52  # relative: an ulp is between half of this and this
METHODS_MEET = (400, 401)  # points from which the fast methods are used
OUTER = (1, 2, 3, 9, 10, 11, 12, 14, 15, 16, 17, 18, 25)  # numbers from the end, on both sides of where methods meet


def rule(spec: str, n: int) -> tuple[np.ndarray, np.ndarray]:
    return samplers.points(spec, n, 1)[:, 0], samplers.weights(spec, n, 1)


def numbers(n: int) -> list[int]:
    """Which nodes of n to look at, from 1 at the lower end up to the middle."""
    return sorted({i for i in (*OUTER, n // 4, n // 3, (n + 1) // 2) if 1 <= i <= (n + 1) // 2})


def legendre(n: int, t: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """P_n and P_(n-1) at 1 - 2t: by recurrence, and for large n, where t is small, by the hypergeometric series."""
    if n < 20000:
        before, value = mp.mpf(1), 1 - 2 * t
        for j in range(1, n):
            before, value = value, ((2 * j + 1) * (1 - 2 * t) * value - j * before) / (j + 1)
        return value, before
    found = []
    for degree in (n, n - 1):
        term = total = mp.mpf(1)
        k = 0
        while abs(term) > mp.mpf(10) ** -45:
            term *= mp.mpf(k - degree) * (degree + 1 + k) / (k + 1) ** 2 * t
            total += term
            k += 1
        found.append(total)
    return found[0], found[1]


def gauss_node(n: int, i: int) -> tuple[mp.mpf, mp.mpf]:
    """Node and weight on [0, 1], by Newton's method."""
    theta = mp.pi * (4 * i - 1) / (4 * n + 2)
    t = mp.sin((theta + mp.cot(theta) / (8 * mp.mpf(n) ** 2)) / 2) ** 2
    for _ in range(7):
        value, before = legendre(n, t)
        slope = n * (before - (1 - 2 * t) * value) / (4 * t * (1 - t))
        t += value / slope / 2
    return t, 1 / (4 * t * (1 - t) * slope**2)


def clenshaw_curtis_node(n: int, j: int) -> tuple[mp.mpf, mp.mpf]:
    """Node j of n + 1 and weight, by the definition's sum."""
    theta = mp.pi * j / n
    cosines = (mp.cos(2 * m * theta) * (1 if 2 * m == n else 2) / (4 * m * m - 1) for m in range(1, n // 2 + 1))
    return mp.sin(theta / 2) ** 2, (1 - mp.fsum(cosines)) / n * (1 if j else mp.mpf("0.5"))


@pytest.mark.parametrize("n", [1, 2, 3, 4, 7, 64, *METHODS_MEET, 1000])
def test_gauss_legendre_is_mpmaths(n: int) -> None:
    nodes, weights = rule("gauss-legendre", n)
    with mp.workdps(60):
        for i in numbers(n):
            node, weight = gauss_node(n, i)
            assert abs(nodes[i - 1] - node) <= ULP * node
            assert abs(weights[i - 1] - weight) <= 2 * ULP * weight  # the bound that gauss_legendre.c states


@pytest.mark.parametrize("n", [2**17, 2**20])
def test_the_ends_of_the_largest_gauss_rules_are_mpmaths(n: int) -> None:
    nodes, weights = rule("gauss-legendre", n)
    with mp.workdps(60):
        for i in OUTER:
            node, weight = gauss_node(n, i)
            assert abs(nodes[i - 1] - node) <= 2 * ULP * node
            assert abs(weights[i - 1] - weight) <= 2 * ULP * weight


@pytest.mark.parametrize("n", [1, 2, 5, 30, 100, 200])
def test_gauss_legendre_is_numpys(n: int) -> None:
    """NumPy's own weights are off by up to 9 ulp of 1 here, as mpmath shows; the nodes of both are rounded once."""
    nodes, weights = rule("gauss-legendre", n)
    x, w = leggauss(n)
    assert np.abs(nodes - (x + 1) / 2).max() < 4 * ULP
    assert np.abs(weights - w / 2).max() < 16 * ULP


@pytest.mark.parametrize("n", [2, 3, 4, 5, 64, *METHODS_MEET, 402, 2001, 2002])
def test_clenshaw_curtis_is_mpmaths(n: int) -> None:
    nodes, weights = rule("clenshaw-curtis", n)
    with mp.workdps(60):
        for i in numbers(n):
            node, weight = clenshaw_curtis_node(n - 1, i - 1)
            assert abs(nodes[i - 1] - node) <= ULP * node
            assert abs(weights[i - 1] - weight) <= 2 * ULP * weight  # the bound that clenshaw_curtis.c states


def test_the_last_node_of_clenshaw_curtis_is_below_one() -> None:
    nodes, _ = rule("clenshaw-curtis", 9)
    assert nodes[0] == 0
    assert nodes[-1] == 1 - 2**-24


def test_a_smooth_integrand_converges_to_roundings() -> None:
    points = samplers.points("gauss-legendre", 12**2, 2)
    estimate = samplers.weights("gauss-legendre", 12**2, 2) @ np.exp(points.sum(axis=1))
    assert estimate == pytest.approx((np.e - 1) ** 2, rel=8 * ULP)  # 144 terms, summed pairwise


def test_counts_that_are_no_power_say_what_there_is() -> None:
    with pytest.raises(Unsupported, match=r"k\^3 points in 3 dimensions; 100 is not such a power"):
        samplers.points("gauss-legendre", 100, 3)
