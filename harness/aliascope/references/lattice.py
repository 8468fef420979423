"""A checkerboard's mean toward the horizon, where squares without number fall into a pixel: by its borders alone.

Let s(a) = 1, -1 in turn on the unit intervals, so that a board is s(a) s(b), and g = c / w^3 the picture's area per
area of the plane, w the depth, which is affine in (a, b). With S_1, S_2, ... the iterated integrals of s without mean,

    integral of s(a) s(b) g over a region
        = sum over m from 1 to M of (-1)^(m-1)  integral along its border of S_m(a) s(b) (d/da)^(m-1) g db
          + (-1)^M  integral over the region of S_M(a) s(b) (d/da)^M g,

which is Boole's summation in a and Green's theorem. S_m(a) = (-1)^floor(a) E_m(a - floor(a)) / m!, E_m Euler's
polynomials (Borwein, Calkin and Manna 2009, "Euler-Boole summation revisited"), and |S_m| <= pi^(1-m) / 2. The last
integral is below

    pi^(1-M) / 2  (M+2)! / 2  (|dw/da| / w)^M  times the region's area on the picture:                              (1)

beyond a depth of DEEP squares it is nothing after a few terms, and a region that reaches to the horizon is no trouble:
g vanishes there. What is left are integrals along straight lines, on which a, b and w are affine: between two borders
of squares they are smooth, and Gauss-Legendre has them to the last digit. Where a line crosses many squares, the same
summation along it leaves one value for each row: see `_sum_rows`.

A line that goes on to the horizon is cut at a depth W. With r = da/db, what two rows of squares add to its integral, if
g were constant, is f(q) = integral over two units of t of S_1(r t + q) s(t) dt, where each pair of rows turns q by r
modulo 1 (in periods of S_1). As S_1 has no mean, nor has f, and from s(t + 1) = -s(t) follow |f| <= min(1, |r|) and a
total variation V <= 4 min(1, |r|). Over N = q_i pairs, q_i a denominator of a convergent of r, f sums to at most V
(Koksma's inequality for points k r, Denjoy 1932; Kuipers and Niederreiter 1974, chapter 2), and so, with Ostrowski's
expansion of any N,

    D(N) <= min(N max |f|, V sum over i of min(a_(i+1), N / q_i)),   a_i the partial quotients of r.               (2)

Abel's summation with g, which falls like 1/w^3, bounds what is beyond W: see `beyond`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import Unsupported
from aliascope.geometry import Array
from aliascope.references.result import EPSILON

Index = NDArray[np.int64]
DEEP = 64.0
"""A depth of so many times what it grows by in one square: from here on Boole's summation is used."""
MOST_TERMS = 8
MOST_PIECES = 400_000_000
LONG = 64.0
"""A line of more squares is summed row by row, where that is exact."""
ROWS_ERROR = 1e-14
BATCH = 2_000_000
"""Pieces of lines that are summed at a time."""
CHUNK = 8192
"""Rows of a line that are summed at a time: an even number."""
NEGLIGIBLE = 1e-11
CUT = 3e-11
"""Lines are followed toward the horizon until what is beyond is less than this, on each."""


def _euler_polynomials() -> Array:
    """E_m / m! for m = 1 to MOST_TERMS, coefficients from the highest power down, (MOST_TERMS, MOST_TERMS + 1)."""
    found: list[list[Fraction]] = []  # lowest power first
    for m in range(MOST_TERMS + 1):
        new = [Fraction(0)] * m + [Fraction(1)]
        for k, lower in enumerate(found):
            for power, coefficient in enumerate(lower):
                new[power] -= Fraction(math.comb(m, k), 2) * coefficient
        found.append(new)
    table = np.zeros((MOST_TERMS, MOST_TERMS + 1))
    for m in range(1, MOST_TERMS + 1):
        table[m - 1, -m - 1 :] = [float(c / math.factorial(m)) for c in reversed(found[m])]
    return table


EULER = _euler_polynomials()


@dataclass(frozen=True)
class Lines:
    """Straight lines on the board: at 0 <= t <= 1, (a, b, w) = start + t step; both (n, 3)."""

    start: Array
    step: Array

    def part(self, chosen: Index | slice) -> Lines:
        return Lines(self.start[chosen], self.step[chosen])


@dataclass(frozen=True)
class Slope:
    """What the area of the picture is per area of the board: c / w^3, w growing by `along_a` and `along_b` a square."""

    c: float
    along_a: float
    along_b: float

    @property
    def steepness(self) -> float:
        return math.hypot(self.along_a, self.along_b)

    def terms(self, depth: float, below: float) -> tuple[int, float]:
        """How many terms make the remainder, equation (1), at this depth less than `below`, and that remainder."""
        remainder = math.inf
        for m in range(1, MOST_TERMS + 1):
            share = abs(self.along_a) / depth
            remainder = math.pi ** (1 - m) / 2 * math.factorial(m + 2) / 2 * share**m
            if remainder <= below:
                return m, remainder
        return MOST_TERMS, remainder


def integrals(lines: Lines, slope: Slope) -> tuple[Array, Array]:
    """The border integral along each line, (n,), and a bound of its error; w is DEEP or deeper.

    A line that cannot add more than NEGLIGIBLE adds 0. Raises Unsupported where the lines cross too many squares.
    """
    end = lines.start + lines.step
    nearest = np.minimum(lines.start[:, 2], end[:, 2])
    most = 0.6 * abs(slope.c) * np.abs(lines.step[:, 1]) / nearest**3  # |S_1| <= 1/2, and the other terms
    value, error = np.zeros(len(most)), np.where(most <= NEGLIGIBLE, most, 0.0)
    heavy = np.nonzero(most > NEGLIGIBLE)[0]
    heavy = heavy[np.argsort(nearest[heavy])]
    many = np.abs(lines.step[heavy, :2]).sum(axis=1) + 3.0
    if float(many.sum()) > MOST_PIECES:
        raise Unsupported(f"the borders of the pixels cross {float(many.sum()):.1e} squares toward the horizon")
    # Coordinates within 16 eps of their size: S_1 s(b) then changes by that at a border of squares, twice a square.
    size = np.abs(lines.start[heavy]).max(axis=1) + np.abs(lines.step[heavy]).max(axis=1)
    error[heavy] = most[heavy] * (64 * EPSILON * size + 1e-14)
    by_rows = np.zeros(len(heavy), np.bool_)
    for place in np.nonzero(many > LONG)[0].tolist():
        number = heavy[place]
        terms, remainder = _row_terms(lines.start[number], lines.step[number], slope, ROWS_ERROR)
        if remainder <= ROWS_ERROR:
            value[number] = _sum_rows(lines.start[number], lines.step[number], terms)
            error[number] += remainder
            by_rows[place] = True
    heavy, many = heavy[~by_rows], many[~by_rows]
    for batch in _batches(many):
        chosen = heavy[batch]
        value[chosen] = _sum_pieces(lines.part(chosen), slope, float(nearest[chosen].min()))
    return value, error


def _batches(many: Array) -> Iterator[slice]:
    """Slices of about BATCH pieces, so that neighbours in depth go together."""
    if not len(many):
        return
    number = np.floor(np.cumsum(many) / BATCH).astype(np.int64)
    cuts = [0, *(np.nonzero(np.diff(number))[0] + 1).tolist(), len(many)]
    for first, last in itertools.pairwise(cuts):
        yield slice(first, last)


def _sum_pieces(lines: Lines, slope: Slope, nearest: float) -> Array:
    """The integrals by Gauss-Legendre on each piece that lies within one square."""
    line, low, high = _pieces(lines)
    middle = (low + high) / 2
    half = (high - low) / 2
    start, step = lines.start[line], lines.step[line]
    cell_a = np.floor(start[:, 0] + middle * step[:, 0])
    cell_b = np.floor(start[:, 1] + middle * step[:, 1])
    odd = (cell_a + cell_b) % 2.0
    terms, _ = slope.terms(nearest, 1e-17)
    # The piece's share of the depth is below 1.5 steepness / nearest; n nodes leave its power 2 n - m, and more for w.
    share = 1.5 * slope.steepness / nearest
    nodes = 7 if share > 2e-3 else 5 if share > 2e-4 else 3
    total = np.zeros(len(line))
    for place, weight in zip(*np.polynomial.legendre.leggauss(nodes), strict=True):
        t = middle + half * place
        fraction = start[:, 0] + t * step[:, 0] - cell_a
        inverse = 1.0 / (start[:, 2] + t * step[:, 2])
        total += weight * _integrand(fraction, inverse, slope, terms)
    total *= half * step[:, 1] * (1.0 - 2.0 * odd)
    return np.bincount(line, total, len(lines.start)).astype(np.float64)


def _integrand(fraction: Array, inverse: Array, slope: Slope, terms: int) -> Array:
    """The sum over m of (-1)^(m-1) E_m / m! (d/da)^(m-1) (c / w^3), w = 1 / `inverse`."""
    ratio = slope.along_a * inverse
    total = np.zeros_like(fraction)
    for m in range(terms, 0, -1):
        polynomial = np.polyval(EULER[m - 1, -m - 1 :], fraction)
        total = total * ratio + math.factorial(m + 1) / 2 * polynomial
    scaled: Array = slope.c * inverse**3 * total
    return scaled


def _pieces(lines: Lines) -> tuple[Index, Array, Array]:
    """Each line cut at the borders of squares: the line's number and the two ends (t) of every piece."""
    count = len(lines.start)
    number, times = [np.arange(count), np.arange(count)], [np.zeros(count), np.ones(count)]
    for axis in (0, 1):
        first, last = lines.start[:, axis], lines.start[:, axis] + lines.step[:, axis]
        low = np.floor(np.minimum(first, last)) + 1
        many = np.maximum(np.ceil(np.maximum(first, last)) - low, 0).astype(np.int64)
        line = np.repeat(np.arange(count), many)
        before = np.repeat(np.cumsum(many) - many, many)
        border = low[line] + (np.arange(len(line)) - before)
        number.append(line)
        times.append(np.clip((border - first[line]) / lines.step[line, axis], 0.0, 1.0))
    lines_, times_ = np.concatenate(number), np.concatenate(times)
    order = np.lexsort((times_, lines_))
    line, time = lines_[order], times_[order]
    same = line[1:] == line[:-1]
    return line[:-1][same], time[:-1][same], time[1:][same]


def _row_terms(start: Array, step: Array, slope: Slope, enough: float) -> tuple[list[float], float]:
    """k_2, k_3, ... of `_sum_rows`, until what is left out of a line's integral is below `enough`, and its bound."""
    if 0.0 in (step[0], step[1]):
        return [], math.inf
    ratio, growth = float(step[0] / step[1]), float(step[2] / step[1])
    nearest = min(float(start[2]), float(start[2] + step[2]))
    found, k, bound = [], 0.0, math.inf
    for m in range(1, MOST_TERMS):
        k = (slope.c * slope.along_a ** (m - 1) * math.factorial(m + 1) / 2 + (m + 1) * growth * k) / ratio
        # With k_2 to k_m, the integral of r k_(m+1) S_m w^-(m+2) is left, |S_m| <= pi^(1-m) / 2, and the terms of the
        # sum over m from here on, which are less than twice the first.
        left = abs(k * ratio) + 2 * abs(slope.c * slope.along_a**m) * math.factorial(m + 2) / 2 / nearest
        bound = left * 0.5 * math.pi ** (1 - m) * abs(float(step[1])) / nearest ** (m + 2)
        if bound <= enough:
            break
        found.append(k)
    return found, bound


def _sum_rows(start: Array, step: Array, terms: list[float]) -> float:
    """The integral along a line by Boole's summation in a once more, now along the line: with b its parameter and
    r = da/db, the terms h_m S_m(a) w^-(m+2) have the integral sum over m of k_m S_m(a) w^-(m+1) as long as s(b) stays,

        k_1 = 0,    k_(m+1) = (h_m + (m + 1) dw/db k_m) / r,

    by parts, again and again. So each border between two rows counts twice, with the sign of the row before it.
    """
    forward = 1.0 if step[1] > 0.0 else -1.0
    low, high = sorted((float(start[1]), float(start[1] + step[1])))
    first, last = math.floor(low) + 1, math.ceil(high)  # the borders between them, last not among them
    ends = np.array([low, high])
    rows = np.array([first - 1.0, last - 1.0])
    total = float(np.diff(_row_ends(ends, start, step, terms) * (1.0 - 2.0 * (rows % 2.0)))[0])
    for begin in range(first, last, CHUNK):
        borders = np.arange(begin, min(begin + CHUNK, last), dtype=np.float64)
        found = _row_ends(borders, start, step, terms)
        total += 2.0 * (1.0 if begin % 2 else -1.0) * float(found[::2].sum() - found[1::2].sum())
    return forward * total


def _row_ends(b: Array, start: Array, step: Array, terms: list[float]) -> Array:
    """The sum over m of k_m S_m(a) w^-(m+1) at the places b of a line."""
    t = (b - start[1]) * (1.0 / step[1])
    a, inverse = start[0] + t * step[0], 1.0 / (start[2] + t * step[2])
    cell = np.floor(a)
    a -= cell
    total = np.zeros_like(a)
    for number in range(len(terms), 0, -1):  # k_2 belongs to S_2
        polynomial = np.full_like(a, EULER[number, -number - 2])
        for coefficient in EULER[number, -number - 1 :].tolist():
            polynomial *= a
            polynomial += coefficient
        polynomial *= terms[number - 1]
        total *= inverse
        total += polynomial
    total *= inverse**2 * inverse
    cell *= 0.5
    odd = cell - np.floor(cell)
    signed: Array = total * (1.0 - 4.0 * odd)
    return signed


# --- lines that go on to the horizon ----------------------------------------------------------------------------------


def cut_depth(start_depth: float, across: float, down: float, slope: Slope) -> tuple[float, float]:
    """Where to cut a line on which a, b grow by `across`, `down` a unit of depth: (W, bound of what is beyond)."""
    depth = max(start_depth, DEEP * slope.steepness)
    quotients = convergents(across / down) if down else []
    bound = beyond(depth, across, down, slope, quotients)
    factor = 2.0
    while factor > 1.1:
        while bound > CUT:
            depth *= factor
            bound = beyond(depth, across, down, slope, quotients)
        factor = math.sqrt(factor)
        shorter = max(depth / factor, start_depth)
        at_shorter = beyond(shorter, across, down, slope, quotients)
        if at_shorter <= CUT:
            depth, bound = shorter, at_shorter
    return depth, bound


def beyond(depth: float, across: float, down: float, slope: Slope, quotients: list[tuple[int, float]]) -> float:
    """A bound of the border integral beyond a depth W: with G = c / w^3, D of equation (2) and N(w) pairs of rows to w,

    G(W)  (variation of g in a pair: |S_1| has the integral 1/2 there, and G falls by G(W) in all)
    + sum over i of D(N(2^(i+1) W)) (G(2^i W) - G(2^(i+1) W))  +  the terms from m = 2 on, each by its absolute value.
    """
    if down == 0.0:
        return 0.0
    ratio = abs(across / down)
    size = min(1.0, ratio)
    density = abs(slope.c) / depth**3
    total = 1.0
    pairs = 0.0
    for i in range(16):
        pairs = abs(down) * (2.0 ** (i + 1) - 1.0) * depth / 2 + 1
        total += 0.875 * 8.0**-i * _deviation(pairs, size, quotients)
    total += 8.0**-15 * size * pairs  # all i from 16 on, with N max |f|, a quarter of the one before each
    # m = 2: |S_2| <= 1 / (2 pi), |dg/da| = 3 |along_a| c / w^4; the rest is less than that again, for w is DEEP.
    total += abs(slope.along_a * down) / math.pi
    return density * total


def _deviation(pairs: float, size: float, quotients: list[tuple[int, float]]) -> float:
    """Equation (2): max |f| <= size, V <= 4 size."""
    return size * min(pairs, 4.0 * sum(min(quotient, pairs / q) for q, quotient in quotients if q <= pairs))


def convergents(ratio: float) -> list[tuple[int, float]]:
    """The denominators q_i of a number's convergents with the partial quotient a_(i+1) that follows, to q_i = 1e9."""
    rest = ratio - math.floor(ratio)
    exact = Fraction(rest)
    found: list[tuple[int, float]] = []
    before, q = 0, 1
    while q <= 10**9:
        if exact == 0:
            found.append((q, math.inf))
            break
        exact = 1 / exact
        quotient = math.floor(exact)
        found.append((q, float(quotient)))
        before, q = q, quotient * q + before
        exact -= quotient
    return found
