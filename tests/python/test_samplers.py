"""The sampler library from Python, against SciPy, which others wrote."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import scipy.stats
from scipy.stats import qmc

from aliascope.errors import SpecError, Unsupported
from aliascope.native import discrepancy, samplers

RANDOMISED = ["random", "jittered", "n-rooks"] + [
    f"{name}:scramble={scramble}"
    for name in ("halton", "hammersley", "sobol")
    for scramble in ("shift", "digit", "owen")
]
RANDOMISED.append("sobol:scramble=owen-full")


def test_sobol_is_scipys_in_all_its_dimensions() -> None:
    n, d = 1024, 1024
    ours = samplers.points("sobol", n, d)
    theirs = qmc.Sobol(d, scramble=False, bits=32).random(n)
    order = np.arange(n) ^ (np.arange(n) >> 1)  # SciPy's is the Gray code's order
    assert np.array_equal(ours[order], theirs)


def test_halton_is_scipys() -> None:
    ours = samplers.points("halton", 3000, 200)
    theirs = qmc.Halton(200, scramble=False).random(3000)
    assert np.abs(ours - theirs).max() < 8 * np.finfo(float).eps  # SciPy adds up to 12 digits, half an ulp each


def test_hammersley_is_i_over_n_and_scipys_halton() -> None:
    n = 1500
    ours = samplers.points("hammersley", n, 100)
    theirs = qmc.Halton(99, scramble=False).random(n)
    assert np.array_equal(ours[:, 0], np.arange(n) / n)
    assert np.abs(ours[:, 1:] - theirs).max() < 8 * np.finfo(float).eps  # as above


@pytest.mark.parametrize("scramble", ["digit", "owen"])
def test_scrambled_halton_keeps_its_discrepancy(scramble: str) -> None:
    """The centred discrepancy (Hickernell 1998, computed by SciPy) of 729 points, averaged over 20 pixels, lies below
    that of the unscrambled sequence in eight dimensions, and below a third of that of random points."""
    n, d = 729, 8

    def mean(spec: str) -> float:
        sampler = samplers.Sampler(spec, n, d, seed=2)
        return float(np.mean([qmc.discrepancy(sampler.points(n, 0, (x, 0))) for x in range(20)]))

    scrambled = mean(f"halton:scramble={scramble}")
    assert scrambled < mean("halton")
    assert scrambled < mean("random") / 3


def test_n_rooks_is_a_latin_hypercube() -> None:
    points = samplers.points("n-rooks", 101, 6)
    assert np.array_equal(np.sort(np.floor(points * 101), axis=0), np.tile(np.arange(101.0), (6, 1)).T)


def test_halton_at_its_last_index_is_the_digits_reversed() -> None:
    index = 2**53 - 1
    expected, place = Fraction(0), Fraction(1, 3)
    while index:
        index, digit = divmod(index, 3)
        expected += digit * place
        place /= 3
    value = samplers.points("halton", 1, 2, first=2**53 - 1)[0, 1]
    assert value == pytest.approx(float(expected), rel=2 * np.finfo(float).eps)  # the bound that halton.c states


@pytest.mark.parametrize("spec", RANDOMISED)
def test_marginals_and_pairs_are_uniform(spec: str) -> None:
    """Chi-squared over 4,096 pixels, a point of each, its index turning: a stratum's point is uniform over them all.
    Significance 1e-5 for each of 7 tests of 12 patterns, so 8e-4 in all."""
    sampler = samplers.Sampler(spec, 16, 4, seed=8)
    drawn = np.array([sampler.points(1, x % 16, (x, -x))[0] for x in range(4096)])
    for dimension in range(4):
        counts = np.histogram(drawn[:, dimension], bins=32, range=(0, 1))[0]
        assert scipy.stats.chisquare(counts).pvalue > 1e-5
    for a, b in ((0, 1), (1, 2), (0, 3)):
        counts = np.histogram2d(drawn[:, a], drawn[:, b], bins=8, range=((0, 1), (0, 1)))[0].ravel()
        assert scipy.stats.chisquare(counts).pvalue > 1e-5


@pytest.mark.parametrize("spec", RANDOMISED)
def test_estimates_are_unbiased(spec: str) -> None:
    """The mean over 4,000 pixels of an estimate of a known integral lies within 4.5 standard errors: 7e-6 a side."""
    sampler = samplers.Sampler(spec, 16, 2, seed=3)
    points = np.array([sampler.points(16, 0, (x, 7)) for x in range(4000)])
    for values, integral in (
        (points[:, :, 0] * points[:, :, 1] ** 2, 1 / 6),
        ((points[:, :, 0] + 0.35 * points[:, :, 1] < 0.6).astype(float), 0.6 - 0.175),
    ):
        estimates = values.mean(axis=1)
        error = estimates.std(ddof=1) / np.sqrt(len(estimates))
        assert abs(estimates.mean() - integral) < 4.5 * error


def test_pixels_are_not_correlated_at_any_distance() -> None:
    """The correlation of 4,096 first points with those of pixels at some distance: below 5 / sqrt(4096)."""
    sampler = samplers.Sampler("sobol:scramble=owen", 16, 2, seed=1)

    def first(dx: int, dy: int) -> np.ndarray:
        return np.array([sampler.points(1, 0, (x + dx, 3 * x + dy))[0, 0] for x in range(4096)])

    base = first(0, 0)
    for dx, dy in ((1, 0), (0, 1), (256, 0), (0, 256), (65536, 0)):
        assert abs(np.corrcoef(base, first(dx, dy))[0, 1]) < 5 / 64


def test_canonical_specs() -> None:
    assert samplers.canonical("sobol:scramble=none") == "sobol"
    assert samplers.canonical("halton:scramble=shift") == "halton:scramble=shift"


def test_what_cannot_be_is_said() -> None:
    with pytest.raises(SpecError, match='did you mean "jittered"'):
        samplers.points("jitered", 4)
    with pytest.raises(Unsupported, match="17 is no square"):
        samplers.points("jittered", 17)
    with pytest.raises(Unsupported):
        samplers.points("sobol", 1, first=2**32)
    with pytest.raises(Unsupported):
        samplers.points("regular", 16, first=1)


def test_the_registry_lists_titles_and_sources() -> None:
    found = {info.name: info for info in samplers.registered()}
    assert set(found) >= {"random", "regular", "jittered", "halton", "sobol"}
    assert all(info.title and info.source for info in found.values())
    assert found["sobol"].parameters[0].startswith("scramble=none|shift|digit|owen|owen-full: ")


def test_weights() -> None:
    assert samplers.weights("halton", 8).tolist() == [0.125] * 8


def test_full_owen_scrambling_keeps_nets_and_has_the_variance_of_the_hash() -> None:
    """Variance is of pairs of points, and the hash flips pairs of digits as independently. Two variances of 2,000 means
    each, as large a kurtosis as theirs: the logarithm of the ratio within 5 standard errors, four times."""
    for count, d in ((64, 3), (256, 5)):
        t = discrepancy.measure("t-value", samplers.points("sobol", count, d)).value
        for seed in range(3):
            scrambled = samplers.points("sobol:scramble=owen-full", count, d, seed)
            assert discrepancy.measure("t-value", scrambled).value == t

    def corner(x: np.ndarray) -> np.ndarray:
        return (x[:, 0] + 0.7 * x[:, 1] < 0.81).astype(float)

    def smooth(x: np.ndarray) -> np.ndarray:
        return np.asarray(np.exp(x[:, 0] * x[:, 1]) * np.cos(3.0 * x[:, 1]))

    for integrand in (corner, smooth):
        for count in (8, 32):
            spread, error = [], 0.0
            for scramble in ("owen", "owen-full"):
                means = np.array(
                    [
                        integrand(samplers.points(f"sobol:scramble={scramble}", count, 2, seed)).mean()
                        for seed in range(2000)
                    ]
                )
                spread.append(means.var(ddof=1))
                error += (scipy.stats.kurtosis(means, fisher=False) - 1.0) / len(means)
            assert abs(np.log(spread[1] / spread[0])) < 5.0 * np.sqrt(error)
