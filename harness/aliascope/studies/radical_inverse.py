"""`aliascope radical-inverse`: the lecture's table of i, its digits, the digits reversed, and the fraction they make.

The lecture has 3/8 beside .001 for i = 4; .001 is 1/8.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

HEADINGS = ("i", "digits", "reversed", "fraction", "decimal")
_SYMBOLS = "0123456789abcdefghijklmnopqrstuvwxyz"


@dataclass(frozen=True)
class Row:
    """One line: i = d_m ... d_1 d_0 in the base, and 0.d_0 d_1 ... d_m, exact. `digits`: the most significant first."""

    i: int
    base: int
    digits: tuple[int, ...]
    fraction: Fraction

    @property
    def value(self) -> float:
        """The double nearest to the fraction."""
        return float(self.fraction)

    @property
    def document(self) -> dict[str, Any]:
        """What --json prints of it."""
        return {
            "i": self.i,
            "digits": list(self.digits),
            "reversed": list(self.digits[::-1]),
            "numerator": self.fraction.numerator,
            "denominator": self.fraction.denominator,
            "value": self.value,
        }

    @property
    def cells(self) -> tuple[str, ...]:
        """As HEADINGS has them; the fraction in lowest terms."""
        written, reverse = (_written(digits, self.base) for digits in (self.digits, self.digits[::-1]))
        return str(self.i), written, f".{reverse}", str(self.fraction), repr(self.value)


def _written(digits: tuple[int, ...], base: int) -> str:
    """Digits above 9 as letters while there are enough, then each as a decimal number, with colons between."""
    if base <= len(_SYMBOLS):
        return "".join(_SYMBOLS[digit] for digit in digits)
    return ":".join(map(str, digits))


def row(i: int, base: int) -> Row:
    """The radical inverse of i >= 0 in a base >= 2."""
    digits: list[int] = []
    rest = i
    while rest or not digits:
        rest, digit = divmod(rest, base)
        digits.append(digit)
    numerator = 0
    for digit in digits:
        numerator = numerator * base + digit
    return Row(i, base, tuple(digits[::-1]), Fraction(numerator, base ** len(digits)))


def table(base: int, n: int) -> list[Row]:
    """Of i from 1 to n."""
    return [row(i, base) for i in range(1, n + 1)]


def lines(rows: list[Row]) -> Iterator[str]:
    """The table as text, columns under their headings."""
    cells = [HEADINGS, *(each.cells for each in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for each in cells:
        yield "  ".join(f"{cell:<{width}}" for cell, width in zip(each, widths, strict=True)).rstrip()


def document(base: int, rows: list[Row]) -> dict[str, Any]:
    """What --json prints."""
    return {"base": base, "n": len(rows), "rows": [each.document for each in rows]}
