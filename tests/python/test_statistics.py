"""Means, their errors, and rates: against SciPy and against power laws that are known."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
import scipy.stats
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.stats import norm

from aliascope import statistics
from aliascope.records import Estimate


def test_mean_and_standard_error_are_scipys() -> None:
    values = np.random.default_rng(1).normal(3, 2, 50).tolist()
    found = statistics.mean(values)
    assert found.value == pytest.approx(np.mean(values))
    assert found.standard_error == pytest.approx(scipy.stats.sem(values))


def test_large_means_keep_their_digits() -> None:
    values = [1e12 + k for k in range(5)]
    found = statistics.mean(values)
    assert found.value == 1e12 + 2
    assert found.standard_error == pytest.approx(math.sqrt(2.5 / 5), rel=1e-12)


def test_one_value_has_no_error_and_none_has_no_mean() -> None:
    assert statistics.mean([2.0]).standard_error is None
    assert statistics.mean([]).value is None


def test_root_mean_square_has_the_error_that_repetition_shows() -> None:
    """Over 4,000 sets of 40 values the spread of the root is what its error says, within 5 % (1 / sqrt(8000) = 1 %)."""
    rng = np.random.default_rng(2)
    found = [statistics.root_mean_square(rng.gamma(4.0, 0.3, 40).tolist()) for _ in range(4000)]
    spread = np.std([estimate.value for estimate in found])
    stated = np.mean([estimate.standard_error for estimate in found])
    assert stated == pytest.approx(spread, rel=0.05)


def test_a_power_law_is_found() -> None:
    counts = [4, 16, 64, 256]
    fit = statistics.rate(counts, [0.3 * n**-0.75 for n in counts])
    assert fit is not None
    assert fit.exponent == pytest.approx(-0.75)
    assert fit.constant == pytest.approx(0.3)
    assert statistics.rate([4, 16], [1, 0.5]) is None
    assert statistics.rate([4, 16, 64], [0.0, 0.0, 0.0]) is None


def test_figures_are_told_apart_by_two_standard_errors_of_their_difference() -> None:
    """sqrt(3^2 + 4^2) = 5. That is 95 %: of equal normal figures 4.6 % are told apart (scipy), 20,000 pairs show it."""
    assert not statistics.told_apart(Estimate(100.0, 3.0), Estimate(110.0, 4.0))
    assert statistics.told_apart(Estimate(100.0, 3.0), Estimate(110.1, 4.0))
    assert not statistics.told_apart(Estimate(106.0, 3.0), Estimate(100.0))
    assert statistics.told_apart(Estimate(1.0), Estimate(1.1))
    assert not statistics.told_apart(Estimate(1.0), Estimate(1.0))
    assert statistics.told_apart(Estimate(None), Estimate(1.0, 9.0))
    pairs = np.random.default_rng(3).normal(0.0, (3.0, 4.0), (20_000, 2)).tolist()
    share = np.mean([statistics.told_apart(Estimate(a, 3.0), Estimate(b, 4.0)) for a, b in pairs])
    expected = 2 * scipy.stats.norm.sf(2.0)
    assert share == pytest.approx(expected, abs=4 * math.sqrt(expected / 20_000))


def test_fits_are_scipys_and_numpys() -> None:
    n = [16, 32, 64, 128, 256]
    errors = [0.5, 0.31, 0.17, 0.083, 0.06]
    free = statistics.fit_rate(n, errors, [0.0] * 5)
    line = scipy.stats.linregress(np.log(n), np.log(errors))
    assert free.exponent == pytest.approx(line.slope, rel=1e-12)
    half = float(scipy.stats.t.ppf(0.975, 3)) * line.stderr
    assert free.interval == pytest.approx((line.slope - half, line.slope + half), rel=1e-9)
    assert free.constant == pytest.approx(math.exp(line.intercept), rel=1e-12)
    spread = [0.2, 0.4, 0.3, 0.5, 0.1]
    weighted = statistics.fit_rate(n, errors, [s * e for s, e in zip(spread, errors, strict=True)])
    slope, covariance = np.polyfit(np.log(n), np.log(errors), 1, w=1 / np.array(spread), cov="unscaled")
    assert weighted.exponent == pytest.approx(slope[0], rel=1e-9)
    # The points lie nearer to the line than their errors say, so those count.
    half = float(scipy.stats.t.ppf(0.975, 3)) * math.sqrt(covariance[0, 0])
    assert weighted.interval[1] - weighted.interval[0] == pytest.approx(2 * half, rel=1e-9)


def test_intervals_cover_as_often_as_they_say() -> None:
    rng = np.random.default_rng(4)
    n = [2**k for k in range(4, 13)]
    held = 0
    for _ in range(1000):
        errors = [k**-0.75 * math.exp(0.09 * rng.standard_normal()) for k in n]
        found = statistics.fit_rate(n, errors, [0.09 * e for e in errors])
        held += found.interval[0] <= -0.75 <= found.interval[1]
    # At least 95 % less 4 binomial standard errors of 0.7 %; more, as the scatter only ever widens it.
    assert held >= 922


def test_a_bend_is_seen_and_widens_the_interval() -> None:
    n = [2**k for k in range(4, 15)]
    bent = statistics.fit_rate(n, [math.log(k) ** 2 / k for k in n], [0.0] * len(n))
    assert bent.curved
    # The local rates of (log N)^2 / N are -1 + 2 / log N.
    assert bent.interval[0] <= -1 + 2 / math.log(n[-1])
    assert bent.interval[1] >= -1 + 2 / math.log(64)
    assert bent.local < bent.exponent
    rough = [3.0 * k**-1.5 * (1.1 if i % 2 else 1.0) for i, k in enumerate(n)]
    assert not statistics.fit_rate(n, rough, [0.0] * len(n)).curved
    with pytest.raises(ValueError, match="three"):
        statistics.fit_rate([4, 8], [1.0, 0.5], [0.0, 0.0])


# Times


Noise = Callable[[np.random.Generator, tuple[int, int]], NDArray[np.float64]]


def calm(generator: np.random.Generator, shape: tuple[int, int]) -> NDArray[np.float64]:
    return generator.normal(0.0, 0.02, shape)


def jolted(generator: np.random.Generator, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Calm, but for one run in twenty, which something makes slower by a quarter or so."""
    jolts = np.where(generator.random(shape) < 0.05, np.abs(generator.normal(0.0, 0.3, shape)), 0.0)
    return calm(generator, shape) + jolts


def heavy(generator: np.random.Generator, shape: tuple[int, int]) -> NDArray[np.float64]:
    return 0.02 * generator.standard_t(4.0, shape) / math.sqrt(2.0)


@pytest.mark.parametrize(
    ("noise", "modes", "runs"),
    [
        *((noise, modes, 3) for noise in (calm, jolted, heavy) for modes in (1, 3, 40)),
        *((noise, 20, 16) for noise in (calm, jolted, heavy)),
        (calm, 40, 2),
    ],
)
def test_intervals_of_times_cover_what_they_say(noise: Noise, modes: int, runs: int) -> None:
    """Of 95 % intervals from three runs each, at least 94 % have the true time in them, whatever the modes and their
    number, and they are no wider than they have to be."""
    generator, covered, widths, wanted = np.random.default_rng(modes + runs), 0, [], 2400
    for _ in range(wanted // modes):
        times = np.exp(generator.uniform(-6.0, 1.0, modes))
        seconds = times[:, None] * np.exp(noise(generator, (modes, runs)))
        spread = statistics.pooled_spread(seconds.tolist())
        for time, each in zip(times, seconds, strict=True):
            found = statistics.median_time(each, spread)
            assert found.value == np.median(each)
            assert found.interval is not None
            low, high = found.interval
            covered += low <= time <= high
            widths.append(math.log(high / low))
    # Four standard deviations of a share of 94 % in 2,400 are 1.9 %.
    assert covered / (modes * (wanted // modes)) > 0.94 - 0.019
    if modes == 40:
        plain = 2.0 * 2.0 * 0.02 * (0.707 if runs == 2 else 0.67)
        assert float(np.median(widths)) < (1.1 if noise is calm else 1.5) * plain


def _second_moment(x: float, half: int) -> float:
    """x^2 times the density of the median of 2 half + 1 normal values."""
    ways = math.factorial(2 * half + 1) / math.factorial(half) ** 2
    return x * x * ways * float(norm.cdf(x) * norm.sf(x)) ** half * float(norm.pdf(x))


def test_the_standard_error_of_a_median_is_that_of_order_statistics() -> None:
    """By integration, of 3, 5, 7 and 9 values; of even numbers from 200,000 draws, within four of their own errors."""
    spread = statistics.Spread(0.001, 1e6)

    def told(n: int) -> float:
        error = statistics.median_time([1.0] * n, spread).standard_error
        assert error is not None
        return error / 0.001

    for n in (1, 3, 5, 7, 9):
        variance, _ = quad(_second_moment, -10.0, 10.0, args=((n - 1) // 2,))
        assert told(n) == pytest.approx(math.sqrt(variance), abs=6e-4)
    generator = np.random.default_rng(3)
    for n in (2, 4, 6, 8):
        drawn = np.median(generator.standard_normal((200_000, n)), axis=1).std()
        assert told(n) == pytest.approx(drawn, rel=4.0 / math.sqrt(400_000) + 1e-3)
    assert told(25) == pytest.approx(np.median(generator.standard_normal((100_000, 25)), axis=1).std(), rel=0.02)


def test_times_without_anything_to_pool() -> None:
    assert statistics.pooled_spread([[1.0], [2.0]]) is None
    assert statistics.pooled_spread([[0.0, 1.0], []]) is None
    assert statistics.median_time([3.0, 1.0, 2.0], None) == Estimate(2.0)
    assert statistics.median_time([0.0, 0.0], statistics.Spread(0.1, 4.0)) == Estimate(0.0)
    same = statistics.pooled_spread([[2.0, 2.0], [3.0, 3.0, 3.0]])
    assert same == statistics.Spread(0.0, 3.0)
    assert statistics.median_time([2.0, 2.0], same) == Estimate(2.0, 0.0, (2.0, 2.0))


def test_a_time_is_no_more_certain_than_the_machine_is_steady() -> None:
    """A machine that became 6 % slower from the first quarter to the last spreads runs by 8 % / sqrt(12) at least."""
    spread = statistics.pooled_spread([[2.0, 2.0, 2.0]], drift=-0.06)
    assert spread is not None
    found = statistics.median_time([2.0, 2.0, 2.0], spread)
    assert found.standard_error == pytest.approx(2.0 * 0.67 * 0.08 / math.sqrt(12.0))
    assert found.interval == pytest.approx([2.0 * math.exp(k * 1.96 * 0.67 * 0.08 / math.sqrt(12.0)) for k in (-1, 1)])
