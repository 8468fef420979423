"""Steps in series: against scipy, all permutations and published results; false alarms and power by simulation."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.stats import binom, mannwhitneyu

from aliascope.geometry import Array
from aliascope.studies import change_points
from aliascope.studies.change_points import Measured, Ranks, Tails, by_errors, by_ranks, least_p_value

# Annual flow of the Nile at Aswan in 10^8 m^3, 1871 to 1970 (Cobb 1978, "The problem of the Nile", Biometrika 65).
NILE = [
    *(1120, 1160, 963, 1210, 1160, 1160, 813, 1230, 1370, 1140, 995, 935, 1110, 994, 1020, 960, 1180, 799, 958, 1140),
    *(1100, 1210, 1150, 1250, 1260, 1220, 1030, 1100, 774, 840, 874, 694, 940, 833, 701, 916, 692, 1020, 1050, 969),
    *(831, 726, 456, 824, 702, 1120, 1100, 832, 764, 821, 768, 845, 864, 862, 698, 845, 744, 796, 1040, 759),
    *(781, 865, 845, 944, 984, 897, 822, 1010, 771, 676, 649, 846, 812, 742, 801, 1040, 860, 874, 848, 890),
    *(744, 749, 838, 1050, 918, 986, 797, 923, 975, 815, 1020, 906, 901, 1170, 912, 746, 919, 718, 714, 740),
]
LEVEL = 0.01


def test_nile_changes_in_1898() -> None:
    """strucchange 1.5's own test output has: breakpoint at observation 28, the year 1898; Zeileis and others 2003,
    "Testing and dating of structural changes in practice", 95 % from 1895 to 1902, 25 to 32."""
    (change,) = by_ranks(NILE, LEVEL)
    assert change.at == 28
    assert 25 <= change.earliest <= 28 <= change.latest <= 32
    assert 1e-9 < change.p_value < 1e-6  # its OLS-based CUSUM test has 5.4e-8, its recursive one 7.5e-8
    assert abs(Ranks(np.array(NILE, float)).pettitt()).argmax() + 1 == 28


def test_the_statistic_of_errors_is_the_published_one() -> None:
    """sup.F = 75.93 of the same output: F of two means is z^2, where the standard errors are the residuals' own."""
    x = np.array(NILE, float)
    residuals = np.concatenate([x[:28] - x[:28].mean(), x[28:] - x[28:].mean()])
    errors = np.full(100, math.sqrt(float((residuals**2).sum()) / 98.0))
    known = np.full(100, 1e9)  # standard errors that are known, as F has them
    likelihood = Measured(x, errors, known).likelihood()
    assert likelihood.argmax() + 1 == 28
    assert likelihood.max() == pytest.approx(75.93, abs=0.005)
    (change,) = by_errors(NILE, errors.tolist(), known.tolist(), LEVEL)
    assert change.at == 28
    assert change.p_value < 2.22e-16 * 99 * 2  # its p-value, for all places, and two searches


@pytest.mark.parametrize("ties", [False, True])
def test_chances_of_rank_sums_are_exact(ties: bool) -> None:
    generator = np.random.default_rng(5)
    values = generator.permutation([1.0, 1.0, 2.0, 3.0, 3.0, 3.0, 7.0, 8.0] if ties else np.arange(8.0))
    ranks = Ranks(values)
    for m in range(1, 8):
        ways = np.array([sum(each) for each in itertools.combinations(ranks.ranks.tolist(), m)])
        for total in set(ways.tolist()):
            both = 2.0 * min((ways <= total).mean(), (ways >= total).mean())
            assert Tails.of(ranks.kind)(np.array([total]), m)[0] == pytest.approx(min(1.0, both), rel=1e-12)
        if not ties:
            expected = mannwhitneyu(values[:m], values[m:], method="exact").pvalue
            assert Tails.of(ranks.kind)(ranks.sums[m : m + 1], m)[0] == pytest.approx(expected, rel=1e-12)


def test_chances_of_many_are_those_of_scipy() -> None:
    values = np.random.default_rng(6).standard_normal(80)
    ranks = Ranks(values)
    for m in (1, 20, 40):
        expected = mannwhitneyu(values[:m], values[m:], method="asymptotic").pvalue
        assert Tails.of(ranks.kind)(ranks.sums[m : m + 1], m)[0] == pytest.approx(expected, rel=1e-9)


def test_p_values_of_splits_are_those_of_all_permutations() -> None:
    values = np.array([1.0, 3.0, 2.0, 5.0, 4.0, 6.0, 7.0])
    own = Ranks(values)
    least = min(Tails.of(own.kind)(own.sums[k : k + 1], k)[0] for k in range(1, 7))
    orders = [Ranks(np.array(order)) for order in itertools.permutations(values.tolist())]
    all_least = [min(Tails.of(o.kind)(o.sums[k : k + 1], k)[0] for k in range(1, 7)) for o in orders]
    exact = float(np.mean(np.array(all_least) <= least * (1.0 + 1e-12)))
    at, p = own.split(least)  # below the bound: by permutations
    assert p == pytest.approx(exact, abs=4.0 * math.sqrt(exact * (1.0 - exact) / 20000))  # of 20,000 permutations
    assert at in (3, 5)


def alarms(draw: str, n: int, runs: int, level: float) -> int:
    generator = np.random.default_rng(n)
    count = 0
    for _ in range(runs):
        if draw == "errors":
            errors = np.sqrt(generator.chisquare(15, n) / 15.0)  # of 16 replicates
            found = by_errors(generator.standard_normal(n).tolist(), errors.tolist(), [15.0] * n, level)
        else:
            found = by_ranks(getattr(generator, draw)(size=n).tolist(), level)
        count += bool(found)
    return count


@pytest.mark.parametrize("draw", ["standard_normal", "standard_cauchy", "errors"])
@pytest.mark.parametrize("n", [10, 24])
def test_false_alarms_are_as_rare_as_stated(draw: str, n: int) -> None:
    """At 5 %, to count some; the limit is passed by a test that holds its level once in 1,000."""
    assert alarms(draw, n, 400, 0.05) <= binom.ppf(0.999, 400, 0.05)


def found_steps(size: float, before: int, after: int, level: float, outliers: float = 0.0) -> tuple[int, int, int]:
    """Of 200 series with noise 1: how many show a step, how many of them where it is, how many more than one."""
    generator = np.random.default_rng(8)
    some = covered = several = 0
    for _ in range(200):
        x = generator.standard_normal(before + after)
        x[before:] += size
        x += (generator.random(before + after) < outliers) * 30.0
        changes = by_ranks(x.tolist(), level)
        some += bool(changes)
        covered += any(change.earliest <= before <= change.latest for change in changes)
        several += len(changes) > 1
    return some, covered, several


def test_power() -> None:
    some, covered, several = found_steps(2.0, 10, 10, LEVEL)
    assert some >= 120  # measured: 70 of 100
    assert covered >= 0.88 * some  # 95 of 100 are to be: three standard errors
    assert several <= 2
    some, _, several = found_steps(2.0, 20, 20, LEVEL)
    assert some >= 190
    assert several <= 6
    some, _, _ = found_steps(6.0, 12, 12, LEVEL, outliers=0.05)
    assert some >= 165  # measured: 89 of 100; three figures of 24 that stand out can hide it


def test_with_standard_errors_one_figure_after_is_enough() -> None:
    values = [1.00, 1.01, 0.99, 1.20]
    (change,) = by_errors(values, [0.01] * 4, [15.0] * 4, LEVEL)
    assert (change.at, change.earliest, change.latest) == (3, 3, 3)
    assert by_errors([1.00, 1.01, 0.99, 1.02], [0.01] * 4, [15.0] * 4, LEVEL) == []
    # Standard errors that are ten times too small say nothing: the figures' own scatter widens them.
    noise = np.random.default_rng(3).standard_normal(30)
    assert by_errors(noise.tolist(), [0.1] * 30, [15.0] * 30, LEVEL) == []


def stretched(length: int) -> Array:
    x = 1.0 + 0.03 * np.random.default_rng(4).standard_normal(30)
    x[10 : 10 + length] *= 1.5
    return x


def test_what_goes_away_again_is_found_but_no_outlier() -> None:
    changes = by_ranks(stretched(8).tolist(), LEVEL)
    assert [change.at for change in changes] == [10, 18]
    assert by_ranks(stretched(1).tolist(), LEVEL) == []


def test_several_steps_and_none_where_nothing_differs() -> None:
    x = np.repeat([1.0, 2.0, 3.0], 15) + 0.1 * np.random.default_rng(2).standard_normal(45)
    assert [change.at for change in by_ranks(x.tolist(), LEVEL)] == [15, 30]
    assert by_ranks([1.0] * 40, LEVEL) == []
    assert by_ranks([1.0], LEVEL) == by_ranks([1.0, 2.0], LEVEL) == []


def test_the_same_series_gives_the_same_answer() -> None:
    x = stretched(8).tolist()
    first = by_ranks(x, LEVEL)
    change_points._null_splits.cache_clear()
    change_points._null_stretches.cache_clear()
    assert by_ranks(x, LEVEL) == first


def test_tests_that_cannot_alarm_do_not_count() -> None:
    assert change_points.tested([0.0] * 4, 0.01) == (0.0025, 4)
    assert change_points.tested([], 0.01) == (0.01, 0)
    # Three that can reach 0.01 / 3 at best, and a hundred that cannot.
    level, count = change_points.tested([1e-4] * 3 + [0.02] * 100, 0.01)
    assert (level, count) == (pytest.approx(0.01 / 3), 3)


@pytest.mark.parametrize("n", [10, 20])
def test_the_least_p_value_is_reached(n: int) -> None:
    (change,) = by_ranks(list(range(n // 2)) + list(range(100, 100 + n // 2)), least_p_value(n) * 1.0001)
    assert change.at == n // 2
    assert change.p_value == pytest.approx(4.0 / math.comb(n, n // 2), rel=1e-9)  # two sides, two searches
    assert by_ranks(list(range(n // 2)) + list(range(100, 100 + n // 2)), least_p_value(n) * 0.999) == []
