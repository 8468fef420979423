"""`aliascope radical-inverse` against the lecture, fractions, SciPy and the library's Halton points."""

from __future__ import annotations

import json
from fractions import Fraction

import numpy as np
import pytest
from commands import run
from scipy.stats import qmc

import aliascope
from aliascope.studies import radical_inverse as study

PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37)


def test_the_lectures_table() -> None:
    """But for 4, where the lecture has 3/8 beside .001."""
    rows = [line.split()[:4] for line in run("radical-inverse").stdout.splitlines()]
    assert rows == [
        ["i", "digits", "reversed", "fraction"],
        ["1", "1", ".1", "1/2"],
        ["2", "10", ".01", "1/4"],
        ["3", "11", ".11", "3/4"],
        ["4", "100", ".001", "1/8"],
        ["5", "101", ".101", "5/8"],
    ]


@pytest.mark.parametrize("base", [2, 3, 10, 16, 36, 37, 1000, 2**53])
def test_digits_and_fractions(base: int) -> None:
    indices = [1, 2, base - 1, base, base + 1, base * base - 1, 3 * base**3 + 5, 10**20]
    for found in (study.row(i, base) for i in indices):
        assert all(0 <= digit < base for digit in found.digits)
        assert found.digits[0] > 0
        places = range(len(found.digits))
        assert sum(digit * base**place for digit, place in zip(found.digits[::-1], places, strict=True)) == found.i
        expected = sum(Fraction(digit, base ** (place + 1)) for place, digit in enumerate(found.digits[::-1]))
        assert found.fraction == expected
        assert found.value == float(expected)
        i, digits, reverse, fraction, decimal = found.cells
        assert (int(i), Fraction(fraction), float(decimal)) == (found.i, expected, float(expected))
        if base <= 36:
            assert int(digits, base) == found.i
            assert reverse == "." + digits[::-1]
        else:
            assert tuple(map(int, digits.split(":"))) == found.digits
            assert tuple(map(int, reverse[1:].split(":"))) == found.digits[::-1]


def test_values_are_haltons() -> None:
    """SciPy adds digit by digit in double: a rounding each, of 11 at most. The library's are within 2 ulp, as
    radical_inverse.h says; none of these indices lies so near to 1 that its value is moved below it."""
    n = 2000
    scipys = qmc.Halton(len(PRIMES), scramble=False).random(n)
    ours = aliascope.points("halton", n, len(PRIMES))
    for dimension, base in enumerate(PRIMES):
        values = [row.value for row in study.table(base, n - 1)]
        assert np.abs(scipys[1:, dimension] - values).max() <= 12 * 2.0**-53
        assert (np.abs(ours[1:, dimension] - values) <= 2 * np.spacing(values)).all()
        if base == 2:
            assert values == ours[1:, dimension].tolist()


def test_the_document() -> None:
    found = json.loads(run("radical-inverse", "3", "-n", "7", "--json").stdout)
    assert (found["base"], found["n"], len(found["rows"])) == (3, 7, 7)
    assert found["rows"][4] == {
        "i": 5,
        "digits": [1, 2],
        "reversed": [2, 1],
        "numerator": 7,
        "denominator": 9,
        "value": 7 / 9,
    }


def test_columns_stand_under_their_headings() -> None:
    for base in (10, 40):
        lines = list(study.lines(study.table(base, 1700)))
        starts = [lines[0].index(name) for name in study.HEADINGS]
        for line in lines[1:]:
            assert all(line[start] != " " and line[:start].endswith(("  ", "")) for start in starts)
            assert len(line.split()) == 5


def test_what_is_no_base() -> None:
    for arguments in (("1",), ("2", "-n", "0")):
        result = run("radical-inverse", *arguments, code=2)
        assert result.stdout == ""
