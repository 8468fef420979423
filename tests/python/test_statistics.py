"""Means, their errors, and rates: against SciPy and against power laws that are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.stats

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
