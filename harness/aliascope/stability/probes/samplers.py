"""Every sampler at extreme counts: one sample, late indices, a prime number of points, a thousand dimensions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isqrt

from aliascope.stability import sampler_checks as checks
from aliascope.stability import sampler_definitions as definitions
from aliascope.stability.records import Probe
from aliascope.stability.sampler_refusals import refuses_from

BLOCK = 256
"""Points that are looked at of a large N: the last; of those held against fractions, which are slow, 8."""

LATE = tuple(float((1 << bits) + more) for bits in (24, 31, 32, 53) for more in (-1, 0, 1) if bits < 53 or more < 1)
"""Indices; 2^53 - 1 is the last that the library has, and 2^53 + 1 is no double."""

PRIMES = (2.0, 3.0, 7.0, 97.0, 1009.0, 65537.0)
DIMENSIONS = (1.0, 2.0, 3.0, 10.0, 100.0, 1000.0)

Count = Callable[[int], int]


@dataclass(frozen=True)
class Row:
    """A pattern in one of its forms. `fit`: the least N that it has from a number on, None of sequences, which have all
    indices whatever N is. `n`: a count for many dimensions. `late`, `primes`: where indices and sets can be afforded.
    `looks`: at how many points; `whole`: the check needs all N. `exact`: its error is a distance."""

    spec: str
    check: checks.Check
    against: str
    fit: Count | None = None
    dimensions: int = 2
    n: int = 64
    late: tuple[float, ...] = LATE
    many: tuple[float, ...] = DIMENSIONS
    primes: tuple[float, ...] = PRIMES
    looks: int = BLOCK
    whole: bool = False
    exact: bool = False
    note: str = ""


def _any(n: int) -> int:
    return n


def _square(n: int) -> int:
    return (isqrt(n - 1) + 1) ** 2


def _prime_square(n: int) -> int:
    root = isqrt(n - 1) + 1
    while any(root % divisor == 0 for divisor in range(2, isqrt(root) + 1)):
        root += 1
    return max(root, 2) ** 2


def _pan_diagonal_square(n: int) -> int:
    root = isqrt(n - 1) + 1
    while root in (2, 3) or root % 4 == 2:
        root += 1
    return root**2


def _fibonacci(n: int) -> int:
    last, number = 1, 1
    while number < n:
        last, number = number, last + number
    return number


def _at_most(most: int) -> Count:
    """Powers of two."""
    return lambda n: 1 << (n - 1).bit_length() if n <= most else n


_STRATA = "strata of the very doubles, in integers"
_INVERSE = "radical inverses in fractions"
_WHOLE = (1023.0, 16383.0, float(1 << 24))
_FEW = (15.0, 16.0, float(1 << 24))
_TABLE = "made whole in memory: its last point is of as many as it can have in seconds"

_EXACT = (
    Row("regular", checks.defined(definitions.regular), "(j + 1/2) / k in fractions", _square, exact=True),
    Row("halton", checks.defined(definitions.halton), _INVERSE, exact=True),
    Row("hammersley", checks.defined(definitions.hammersley), _INVERSE, _any, exact=True),
    Row("zaremba", checks.defined(definitions.zaremba), "its digits in fractions", _any, exact=True),
    Row(
        "zaremba:digits=finite",
        checks.defined(definitions.zaremba_finite),
        "its digits in fractions",
        _any,
        exact=True,
    ),
    Row(
        "larcher-pillichshammer",
        checks.defined(definitions.larcher_pillichshammer),
        "its digits in fractions",
        _any,
        exact=True,
    ),
    Row("sobol", checks.defined(definitions.sobol), "SciPy's directions in integers", exact=True),
    Row("r2", checks.defined(definitions.r2), "mpmath to 60 digits", exact=True),
    Row(
        "lattice",
        checks.rank_one,
        "Fibonacci numbers, and multiples of a generator, in fractions",
        _fibonacci,
        n=55,
        exact=True,
    ),
    Row(
        "gauss-legendre",
        checks.defined(definitions.gauss_legendre),
        "mpmath to 60 digits",
        _square,
        late=(65535.0, float((1 << 24) - 1)),
        exact=True,
        note="Late nodes are what mpmath takes long for: the rule itself has all k x k points up to 2^53.",
    ),
    Row("clenshaw-curtis", checks.defined(definitions.clenshaw_curtis), "mpmath to 60 digits", _square, exact=True),
    Row("sgi-8x8", checks.multiples(16), "the hardware's grid", _at_most(8), n=8, late=(7.0, *LATE[:1]), exact=True),
    Row(
        "standard-msaa",
        checks.multiples(16),
        "the hardware's grid",
        _at_most(16),
        n=16,
        late=(15.0, *LATE[:1]),
        exact=True,
    ),
)

_SCRAMBLED = (
    *(
        Row(f"halton:scramble={scramble}", checks.digital(0), "one point in each b-adic interval, in integers")
        for scramble in ("digit", "owen")
    ),
    Row("halton:scramble=shift", checks.moved(definitions.halton), f"{_INVERSE}, moved", exact=True),
    *(
        Row(
            f"hammersley:scramble={scramble}", checks.digital(1), "one point in each b-adic interval, in integers", _any
        )
        for scramble in ("digit", "owen")
    ),
    Row("hammersley:scramble=shift", checks.moved(definitions.hammersley), f"{_INVERSE}, moved", _any, exact=True),
    *(
        Row(f"sobol:scramble={scramble}", checks.net, "one point in each elementary interval, in integers")
        for scramble in ("digit", "owen", "owen-full")
    ),
    Row("sobol:scramble=shift", checks.moved(definitions.sobol), "SciPy's directions, moved", exact=True),
    Row("pmj02", checks.net_in_pairs, "one point in each elementary interval, in integers"),
)

_STRATIFIED = (
    Row("jittered", checks.stratified(checks.in_pairs), _STRATA, _square),
    Row("n-rooks", checks.stratified(checks.in_each_axis), _STRATA, _any),
    Row("latin-square", checks.stratified(checks.latin), _STRATA, _any),
    Row("n-queens", checks.stratified(checks.in_each_axis), _STRATA, _any, n=16, late=_WHOLE),
    Row("multi-jittered", checks.stratified(checks.in_pairs_and_axes), _STRATA, _square),
    Row("correlated-multi-jittered", checks.stratified(checks.in_pairs_and_axes), _STRATA, _square),
    Row(
        "orthogonal-array",
        checks.stratified(checks.in_all_pairs),
        _STRATA,
        _prime_square,
        n=121,
        many=(2.0, 3.0, 12.0, 100.0),
    ),
    Row("cook", checks.stratified(checks.in_space_and_time), _STRATA, lambda n: max(n, 16), 3, 16, _FEW),
    Row("pan-diagonal", checks.stratified(checks.in_space_and_time), _STRATA, _pan_diagonal_square, 3),
    Row("mitchell-spacetime", checks.stratified(checks.in_space_and_time), _STRATA, _square, 3, late=_WHOLE),
)

_FREE = (
    Row("random", checks.unrepeated, "no short period, mean and variance"),
    Row(
        "poisson-disk",
        checks.apart(0.95 * 0.525),
        "the distance that all points keep",
        _any,
        late=(1023.0, 16383.0, float(1 << 24)),
        whole=True,
        note=_TABLE,
    ),
    Row(
        "blue-noise", checks.apart(0.0), "no two points are the same", _any, n=16, late=_WHOLE, whole=True, note=_TABLE
    ),
    Row(
        "best-candidate",
        checks.as_one_by_one,
        "the same points one by one",
        n=16,
        late=(1023.0, 4095.0, float(1 << 17)),
        primes=PRIMES[:-1],
        looks=2,
        note="Each point needs all before it: a sequence that ends at 2^17.",
    ),
)

ROWS = (*_EXACT, *_SCRAMBLED, *_STRATIFIED, *_FREE)


def _measure(row: Row, n: int, dimensions: int, first: int, count: int) -> float:
    return checks.error_of(checks.draw(row.spec, n, dimensions, first, count), row.check)


def _few(row: Row) -> Callable[[float], float]:
    return lambda at: _measure(row, int(at), row.dimensions, 0, int(at))


def _prime(row: Row) -> Callable[[float], float]:
    """All of up to 1,009 points, of more the last."""

    def measure(at: float) -> float:
        n = int(at)
        count = n if n <= 1009 or row.whole else BLOCK
        return _measure(row, n, row.dimensions, n - count, count)

    return measure


def _late(row: Row) -> Callable[[float], float]:
    """The points up to the index: of a sequence, or the last of the least set that has it."""

    def measure(at: float) -> float:
        end = int(at) + 1
        n = row.n
        if row.fit:
            end = n = row.fit(end)
        count = n if row.whole else min(8 if row.exact else row.looks, end)
        return _measure(row, n, row.dimensions, end - count, count)

    return measure


def _many(row: Row) -> Callable[[float], float]:
    def measure(at: float) -> float:
        return _measure(row, row.n, int(at), 0, row.n)

    return measure


def _probe(row: Row, extreme: str, levels: tuple[float, ...], measure: Callable[[float], float], quick: float) -> Probe:
    return Probe(
        row.spec,
        "sampler",
        extreme,
        "distance in the unit square" if row.exact else "share of points",
        row.against,
        2.0**-53,
        1e-15 if row.exact else 0.0,
        levels,
        measure,
        (quick,),
        row.note,
        refuses_from=refuses_from(row.spec, extreme),
    )


def probes() -> list[Probe]:
    found = []
    for row in ROWS:
        found += [
            _probe(row, "one-sample", (1.0, 2.0, 3.0, 4.0), _few(row), 1.0),
            _probe(row, "prime", row.primes, _prime(row), 97.0),
            _probe(row, "index", row.late, _late(row), row.late[0]),
            _probe(row, "dimensions", row.many, _many(row), 3.0),
        ]
    return found
