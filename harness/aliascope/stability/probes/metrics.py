"""Metrics of pictures at their extremes, against fractions and mpmath on the same float32 values.

FLIP is another's program, in float32: pictures of one colour have a figure that its paper gives in closed form.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

from aliascope import metrics
from aliascope.stability.records import Probe

Pixels = NDArray[np.float32]
Pair = tuple[Pixels, Pixels]
"""A picture and its reference."""

Number = Any
"""Of mpmath, which has no types."""

DIGITS = 60
SIDE = 16
TEN_DIGITS = 1e-10

OF_FLIP = 1e-4
"""FLIP is told to four places, and computed in float32."""


# --- pictures ---------------------------------------------------------------------------------------------------------


def _noise(seed: int, pixels: int = SIDE * SIDE) -> NDArray[np.float64]:
    side = math.isqrt(pixels)
    return np.random.default_rng(seed).uniform(0.1, 1.0, (side, side, 3))


def _equal(at: float) -> Pair:
    picture = _noise(1, round(at)).astype(np.float32)
    return picture, picture.copy()


def _over_black(at: float) -> Pair:
    return (at * _noise(1)).astype(np.float32), np.zeros((SIDE, SIDE, 3), np.float32)


def _of_size(at: float) -> Pair:
    """Two pictures about `at`, alike but for a hundredth."""
    reference = (at * _noise(2)).astype(np.float32)
    return (reference * (1.0 + 0.02 * (_noise(3) - 0.5))).astype(np.float32), reference


def _constant(at: float) -> Pair:
    reference = np.full((SIDE, SIDE, 3), 0.5, np.float32)
    return (reference + at).astype(np.float32), reference


def _colours(at: float) -> Pair:
    """Pictures of one colour each, about 0.3 and so much brighter, in unequal channels."""
    reference = np.array([0.31, 0.27, 0.35], np.float32)
    image = (reference + at * np.array([1.0, 0.7, 0.4])).astype(np.float32)
    return np.tile(image, (SIDE, SIDE, 1)), np.tile(reference, (SIDE, SIDE, 1))


# --- truths -----------------------------------------------------------------------------------------------------------


def _mpf(value: Fraction) -> Number:
    return mpmath.mpf(value.numerator) / value.denominator


def _errors(pair: Pair) -> list[Fraction]:
    image, reference = (list(map(Fraction, pixels.ravel().tolist())) for pixels in pair)
    return [a - r for a, r in zip(image, reference, strict=True)]


def _mean(values: list[Fraction]) -> Fraction:
    return sum(values, Fraction(0)) / len(values)


def _bias(pair: Pair) -> Number:
    return _mpf(_mean(_errors(pair)))


def _mae(pair: Pair) -> Number:
    return _mpf(_mean([abs(e) for e in _errors(pair)]))


def _mse(pair: Pair) -> Fraction:
    return _mean([e * e for e in _errors(pair)])


def _rmse(pair: Pair) -> Number:
    return mpmath.sqrt(_mpf(_mse(pair)))


def _psnr(pair: Pair) -> Number | None:
    error = _mse(pair)
    return -10 * mpmath.log10(_mpf(error)) if error else None


def _relative_mse(pair: Pair) -> Number:
    reference = map(Fraction, pair[1].ravel().tolist())
    terms = [_mpf(e) ** 2 / (_mpf(r) ** 2 + mpmath.mpf("0.01")) for e, r in zip(_errors(pair), reference, strict=True)]
    return mpmath.fsum(terms) / len(terms)


def _largest(pair: Pair) -> Number:
    return _mpf(max(map(abs, _errors(pair))))


def _p99(pair: Pair) -> Number:
    """Definition 7 of Hyndman and Fan 1996."""
    ordered = sorted(map(abs, _errors(pair)))
    place = Fraction(99, 100) * (len(ordered) - 1)
    below = int(place)
    return _mpf(ordered[below] + (place - below) * (ordered[min(below + 1, len(ordered) - 1)] - ordered[below]))


def _ssim(pair: Pair) -> Number:
    """Wang et al. 2004, eq. 13 to 16, window by window."""
    weights = [[mpmath.exp(-mpmath.mpf(x * x + y * y) / mpmath.mpf("4.5")) for x in range(-5, 6)] for y in range(-5, 6)]
    flat = [weight for row in weights for weight in row]
    whole = mpmath.fsum(flat)
    flat = [weight / whole for weight in flat]
    c1, c2 = mpmath.mpf("1e-4"), mpmath.mpf("9e-4")
    found = []
    for y in range(SIDE - 10):
        for x in range(SIDE - 10):
            for channel in range(3):
                a, r = (
                    [mpmath.mpf(v) for v in pixels[y : y + 11, x : x + 11, channel].ravel().tolist()] for pixels in pair
                )
                mean_a, mean_r = mpmath.fdot(flat, a), mpmath.fdot(flat, r)
                da, dr = [v - mean_a for v in a], [v - mean_r for v in r]
                heavy = [weight * v for weight, v in zip(flat, da, strict=True)]
                both, of_a = mpmath.fdot(heavy, dr), mpmath.fdot(heavy, da)
                of_r = mpmath.fsum(weight * v * v for weight, v in zip(flat, dr, strict=True))
                luminance = (2 * mean_a * mean_r + c1) / (mean_a**2 + mean_r**2 + c1)
                found.append(luminance * (2 * both + c2) / (of_a + of_r + c2))
    return mpmath.fsum(found) / len(found)


def _structure(pair: Pair) -> Number | None:
    """The ratio of `local_structure.py`, its sums in fractions."""
    errors = _errors(pair)
    if not any(errors):
        return None
    error = [[errors[3 * (SIDE * y + x) : 3 * (SIDE * y + x) + 3] for x in range(SIDE)] for y in range(SIDE)]
    blocks = squares = Fraction(0)
    for dy, dx in [(0, 1), (0, 2), *((dy, dx) for dy in (1, 2) for dx in range(-2, 3))]:
        sums: dict[tuple[int, int], Fraction] = {}
        for y in range(SIDE - dy):
            for x in range(max(0, -dx), SIDE - max(0, dx)):
                q = sum((a * b for a, b in zip(error[y][x], error[y + dy][x + dx], strict=True)), Fraction(0))
                squares += q * q
                block = (y // 8, (x - max(0, -dx)) // 8)  # blocks begin at the first pixel that has a partner
                sums[block] = sums.get(block, Fraction(0)) + q
        blocks += sum((each * each for each in sums.values()), Fraction(0))
    return _mpf((blocks / squares - 1) / 63)


def _lab(linear: list[Number]) -> list[Number]:
    """CIE L*a*b* of linear Rec. 709, white its own, by the matrix of FLIP, with a and b as Hunt has them."""
    rows = (
        ("10135552/24577794", "8788810/24577794", "4435075/24577794"),
        ("2613072/12288897", "8788810/12288897", "887015/12288897"),
        ("1425312/73733382", "8788810/73733382", "70074185/73733382"),
    )
    matrix = [[_mpf(Fraction(entry)) for entry in row] for row in rows]
    ratios = [mpmath.fdot(row, linear) / mpmath.fsum(row) for row in matrix]
    delta = mpmath.mpf(6) / 29
    x, y, z = (mpmath.cbrt(t) if t > delta**3 else t / (3 * delta**2) + mpmath.mpf(4) / 29 for t in ratios)
    light = 116 * y - 16
    return [light, light * 5 * (x - y), light * 2 * (y - z)]


def _hyab(one: list[Number], other: list[Number]) -> Number:
    first, second = _lab(one), _lab(other)
    across = mpmath.hypot(first[1] - second[1], first[2] - second[2])
    return (abs(first[0] - second[0]) + across) ** mpmath.mpf("0.7")


def _flip(pair: Pair) -> Number:
    """Of pictures of one colour, which no filter changes and which have no features: Andersson et al. 2020, 4.1.3."""
    image, reference = ([mpmath.mpf(min(1.0, max(0.0, v))) for v in pixels[0, 0].tolist()] for pixels in pair)
    one, none = mpmath.mpf(1), mpmath.mpf(0)
    most, error = _hyab([none, one, none], [none, none, one]), _hyab(reference, image)
    knee, height = mpmath.mpf("0.4") * most, mpmath.mpf("0.95")
    return error / knee * height if error < knee else height + (error - knee) / (most - knee) * (1 - height)


TRUTHS: dict[str, Callable[[Pair], Number | None]] = {
    "bias": _bias,
    "mae": _mae,
    "rmse": _rmse,
    "psnr": _psnr,
    "relative-mse": _relative_mse,
    "max": _largest,
    "p99": _p99,
    "ssim": _ssim,
    "structure": _structure,
}
ABSOLUTE = ("ssim", "structure", "flip")
"""Metrics on a scale of their own, about 1; the others' errors are relative."""


def _error(name: str, pictures: Callable[[float], Pair], truth: Callable[[Pair], Number | None], at: float) -> float:
    """Infinite for a figure that there is not, and for none without a reason or where there is one."""
    pair = pictures(at)
    measured = metrics.measure(*pair, [name])[name]
    with mpmath.workdps(DIGITS):
        exact = truth(pair)
        if measured.value is None or exact is None:
            told = measured.value is None and exact is None and f"{name}-reason" in measured.details
            return 0.0 if told else math.inf
        off = abs(mpmath.mpf(measured.value) - exact)
        if name == "psnr":
            return float(off / max(1, abs(exact)))
        return float(off) if name in ABSOLUTE or not exact else float(off / abs(exact))


def _unmoved(name: str) -> Callable[[Pair], Number | None]:
    """Of equal pictures."""

    def truth(pair: Pair) -> Number | None:
        return None if name in ("psnr", "structure") else mpmath.mpf(name == "ssim")

    return truth


_TINY = (1e-2, 1e-5, 1e-10, 1e-20, 1e-30, 1e-44)
_HUGE = (1e2, 1e5, 1e10, 1e20, 1e30, 3e38)
_SIZES = (121.0, 256.0, 4096.0)
_STEPS = (0.5, 1e-2, 1e-4, 1e-6, 1e-7)


def probes() -> list[Probe]:
    def probe(
        name: str,
        extreme: str,
        levels: tuple[float, ...],
        pictures: Callable[[float], Pair],
        truth: Callable[[Pair], Number | None],
    ) -> Probe:
        own = name != "flip"
        return Probe(
            name,
            "metric",
            extreme,
            "of 1" if name in ABSOLUTE else "dB, relative above 1" if name == "psnr" else "relative",
            "mpmath, of the same float32 values" if own else "mpmath, of the paper's formula for one colour",
            2.0**-53 if own else 2.0**-24,
            TEN_DIGITS if own else OF_FLIP,
            levels,
            functools.partial(_error, name, pictures, truth),
            levels[-1:] if name != "ssim" or extreme == "huge" else (),
            "" if own else "NVIDIA's package computes in float32, and shows no light above 1.",
            excused=not own,
        )

    found = []
    for name, truth in TRUTHS.items():
        found += [
            probe(name, "equal", _SIZES, _equal, _unmoved(name)),
            probe(name, "black-reference", _TINY, _over_black, truth),
            probe(name, "huge", _HUGE, _of_size, truth),
            probe(name, "tiny", _TINY, _of_size, truth),
            probe(name, "constant", _STEPS, _constant, truth),
        ]
    found += [
        probe("flip", "equal", _SIZES, _equal, _unmoved("flip")),
        probe(
            "flip", "black-reference", _TINY, lambda at: (_colours(at)[0], np.zeros((SIDE, SIDE, 3), np.float32)), _flip
        ),
        probe("flip", "huge", _HUGE, _colours, _flip),
        probe("flip", "constant", _STEPS, _colours, _flip),
    ]
    return found
