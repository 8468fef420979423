"""`aliascope discrepancy --orders` against known star discrepancies, and on figures whose order is known."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from commands import complaint, run
from matplotlib.image import imread
from scipy.optimize import curve_fit
from scipy.stats import linregress, t

import aliascope
from aliascope.errors import InvalidInput, Unsupported
from aliascope.native.samplers import registered
from aliascope.studies import orders as study
from aliascope.studies.orders import At, Orders, fits, measure_orders


@pytest.fixture(scope="module")
def planar() -> dict[str, Orders]:
    return {spec: measure_orders(spec, 2, 1, 8192) for spec in ("hammersley", "halton", "random")}


@pytest.fixture(scope="module")
def spatial() -> dict[str, Orders]:
    return {spec: measure_orders(spec, 3, 1, 1024 if spec == "halton" else 512) for spec in ("hammersley", "halton")}


def at(counts: list[int], star: list[float]) -> list[At]:
    return [At(n, value, None) for n, value in zip(counts, star, strict=True)]


COUNTS = [2**k for k in range(4, 15)]


def test_hammersleys_star_is_the_published_one(planar: dict[str, Orders]) -> None:
    """N D* = m/3 + 13/9 - (-1)^m 4/(9 N) at N = 2^m (Halton and Zaremba 1969)."""
    assert [one.n for one in planar["hammersley"].at] == [2**m for m in range(4, 14)]
    for one in planar["hammersley"].at:
        m = round(math.log2(one.n))
        expected = m / 3 + 13 / 9 - (-1) ** m * 4 / (9 * one.n)
        assert one.n * one.star == pytest.approx(expected, rel=1e-12)  # D* is rounded to double
        assert one.standard_error is None


def test_hammersley_in_the_plane_is_of_order_log_n(planar: dict[str, Orders]) -> None:
    """The formula's first term is log N / (3 log 2)."""
    found = planar["hammersley"]
    assert found.best.name == "log N / N"
    low, high = found.best.interval
    assert low < 1 / (3 * math.log(2)) < high
    assert found.best.c == pytest.approx(1 / (3 * math.log(2)), rel=0.02)
    assert found.best.c0 == pytest.approx(13 / 9, rel=0.02)
    assert found.fits[1].likelihood < 1e-9
    assert found.fits[2].likelihood < 1e-9


def test_ratios_of_hammersley_and_halton_are_bounded_and_randoms_grow(
    planar: dict[str, Orders], spatial: dict[str, Orders]
) -> None:
    """Over N D* / log^p N of the order that is proved: never above its first; of random it is tenfold at the end."""
    for orders, power in (
        (planar["hammersley"], 1),
        (planar["halton"], 2),
        (spatial["hammersley"], 2),
        (spatial["halton"], 3),
    ):
        ratios = orders.ratios(power)
        assert max(ratios) == ratios[0]
        level = orders.ratios(power, orders.fits[power - orders.d + 1].c0)[2:]
        assert max(level) < 2.5 * min(level)
    grown = planar["random"].ratios(1)
    assert grown[-1] > 5 * grown[0]
    assert grown == sorted(grown)


def test_halton_has_a_power_of_the_logarithm_more(planar: dict[str, Orders], spatial: dict[str, Orders]) -> None:
    assert planar["halton"].best.name == "log^2 N / N"
    assert spatial["hammersley"].best.name == "log^2 N / N"
    assert spatial["halton"].best.name == "log^3 N / N"


def test_random_points_are_told_apart(planar: dict[str, Orders]) -> None:
    found = planar["random"]
    assert found.realisations == 16
    assert found.best.name == "N^-r"
    low, high = found.best.interval
    assert low < 0.5 < high
    assert high - low < 0.1
    assert max(found.fits[0].likelihood, found.fits[1].likelihood) < 1e-4


def test_realisations_are_averaged(planar: dict[str, Orders]) -> None:
    seeds = [1 + number for number in range(16)]
    stars = [aliascope.discrepancy("random", "star", n=64, seed=seed).value for seed in seeds]
    found = next(one for one in planar["random"].at if one.n == 64)
    assert found.star == pytest.approx(np.mean(stars), rel=1e-14)
    assert found.standard_error == pytest.approx(np.std(stars, ddof=1) / 4, rel=1e-9)


# --- fits of what is known --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("d", "power"), [(1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (4, 3)])
@pytest.mark.parametrize(("c", "c0"), [(0.5, 1.0), (2.0, 0.25)])
def test_exact_orders_are_found_again(d: int, power: int, c: float, c0: float) -> None:
    star = [(c * math.log(n) ** power + c0) / n for n in COUNTS]
    found = fits(at(COUNTS, star), d)
    best = max(found, key=lambda fit: fit.likelihood)
    assert best.log_power == power
    assert (best.c, best.c0) == (pytest.approx(c, rel=1e-6), pytest.approx(c0, rel=1e-5))
    assert best.likelihood == 1.0
    assert best.residual < 1e-6


@pytest.mark.parametrize("rate", [0.4, 0.5, 0.66, 0.75])
@pytest.mark.parametrize("d", [1, 2, 3])
def test_exact_powers_are_found_again(rate: float, d: int) -> None:
    found = fits(at(COUNTS, [3.0 * n**-rate for n in COUNTS]), d)
    assert found[2].rate == pytest.approx(rate, rel=1e-12)
    assert found[2].c == pytest.approx(3.0, rel=1e-11)
    assert found[2].likelihood == 1.0
    assert max(found[0].likelihood, found[1].likelihood) < 1e-9


def test_fits_and_intervals_are_scipys() -> None:
    """Least squares of the logarithm by curve_fit and linregress, which have standard errors of their own."""
    rng = np.random.default_rng(4)
    n = np.array(COUNTS, float)
    noise = np.exp(0.05 * rng.standard_normal(len(n)))
    star = (0.3 * np.log(n) ** 2 + 2.0) / n * noise
    _, log_squared, power = fits(at(COUNTS, star.tolist()), 2)
    values, covariance = curve_fit(
        lambda n, c, c0: np.log((c * np.log(n) ** 2 + c0) / n), n, np.log(star), p0=(0.3, 2.0), xtol=1e-14
    )
    assert (log_squared.c, log_squared.c0) == (pytest.approx(values[0], rel=1e-5), pytest.approx(values[1], rel=1e-5))
    half = math.sqrt(covariance[0, 0]) * t.ppf(0.975, len(n) - 2)
    assert log_squared.interval == pytest.approx((values[0] - half, values[0] + half), rel=1e-4)
    line = linregress(np.log(n), np.log(star))
    half = line.stderr * t.ppf(0.975, len(n) - 2)
    assert power.rate == pytest.approx(-line.slope, rel=1e-12)
    assert power.interval == pytest.approx((-line.slope - half, -line.slope + half), rel=1e-10)
    # Akaike's criterion of the two, which have as many parameters each, by their residuals.
    squares = [(len(n) - 2) * fit.residual**2 for fit in (log_squared, power)]
    assert power.likelihood == pytest.approx((squares[0] / squares[1]) ** (len(n) / 2), rel=1e-9)


def test_a_parameter_more_has_to_earn_itself() -> None:
    """Akaike's criterion: m log(sum of squares) and 2 a parameter, by which a fit of one is e times as likely."""
    rng = np.random.default_rng(2)
    star = 3.0 * np.array(COUNTS) ** -0.5 * np.exp(0.1 * rng.standard_normal(len(COUNTS)))
    log_squared, power = fits(at(COUNTS, star.tolist()), 2)[1:]
    m = len(COUNTS)
    assert log_squared.c0 == 0.0
    squares = [(m - 1) * log_squared.residual**2, (m - 2) * power.residual**2]
    assert power.likelihood == 1.0
    assert log_squared.likelihood == pytest.approx(math.e * (squares[1] / squares[0]) ** (m / 2), rel=1e-9)


def test_a_lower_order_that_would_be_negative_is_none() -> None:
    n = np.array(COUNTS, float)
    first, second, _ = fits(at(COUNTS, (3.0 * n**-0.5).tolist()), 2)
    for fit, power in ((first, 1), (second, 2)):
        assert fit.c0 == 0.0
        expected = np.exp(np.mean(np.log(3.0 * n**0.5 / np.log(n) ** power)))
        assert fit.c == pytest.approx(expected, rel=1e-12)


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_table_and_the_picture(tmp_path: Path) -> None:
    lines = run("discrepancy", "hammersley", "--orders", "-n", "1024", "-o", tmp_path / "a.png").stdout.splitlines()
    assert lines[0] == "hammersley in 2 dimensions: star discrepancy D*, exact"
    assert lines[2].split()[:4] == ["16", "0.171875", "2.75", "0.9919"]
    assert lines[-1] == "described best by log N / N"
    assert imread(tmp_path / "a.png").shape == (1152, 896, 4)


def test_the_document_and_counts_that_a_pattern_has() -> None:
    found = json.loads(run("discrepancy", "lattice", "--orders", "-n", "1000", "--json").stdout)
    assert (found["sampler"], found["d"], found["realisations"]) == ("lattice", 2, 1)
    assert [row["n"] for row in found["points"]] == [21, 34, 89, 144, 377, 610]  # Fibonacci's
    row = found["points"][2]
    assert row["star"] == aliascope.discrepancy("lattice", "star", n=89).value
    assert row["n-star-over-log^2"] == pytest.approx(89 * row["star"] / math.log(89) ** 2, rel=1e-12)
    assert [fit["order"] for fit in found["fits"]] == ["log N / N", "log^2 N / N", "N^-r"]
    assert found["best"] == "log N / N"
    assert max(fit["relative_likelihood"] for fit in found["fits"]) == 1.0


def test_pictures_of_all_dimensions_are_the_same_each_time(tmp_path: Path) -> None:
    from aliascope.studies.order_picture import draw

    for d in (1, 4):
        known = [At(n, 2.0 / n, None if d == 1 else 0.1 / n) for n in COUNTS]
        orders = Orders("$x_1$", d, 0, d, tuple(known), fits(known, d))
        pictures = [tmp_path / f"{d}-{index}.svg" for index in range(2)]
        for path in pictures:
            draw(path, orders)
        assert pictures[0].read_bytes() == pictures[1].read_bytes()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("halton", "--measure", "star"), "neither --measure nor --projections"),
        (("./a.csv",), "--orders are those of a sampler"),
        (("halton", "-o", "a.csv"), "written as .svg or .png"),
    ],
)
def test_options_that_do_not_go_together(arguments: tuple[str, ...], says: str, tmp_path: Path) -> None:
    assert says in complaint("discrepancy", *arguments, "--orders", code=2, cwd=tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("spec", "d", "most", "realisations", "says"),
    [
        ("halton", 5, None, None, "1 to 4 dimensions, not 5"),
        ("halton", 2, None, 3, "is not randomised"),
        ("halton", 2, 255, None, "a fit takes 5"),
        ("standard-msaa", 2, None, None, "a fit takes 5"),
        ("haltn", 2, None, None, "did you mean"),
    ],
)
def test_what_has_no_orders(spec: str, d: int, most: int | None, realisations: int | None, says: str) -> None:
    with pytest.raises(InvalidInput, match=says):
        measure_orders(spec, d, 0, most, realisations)


def test_every_sampler_has_orders_or_says_why_not() -> None:
    reasons = {}
    for info in registered():
        try:
            found = measure_orders(info.name, 2, 0, 400, 1)
        except Unsupported as error:
            reasons[info.name] = str(error)
            continue
        assert all(math.isfinite(fit.residual) for fit in found.fits)
        json.dumps(study.document(found), allow_nan=False)
        assert study.lines(found)
    few = {"sgi-8x8": "has sets of", "standard-msaa": "has 1 of the numbers"}
    for name in ("cook", "pan-diagonal", "mitchell-spacetime"):
        few[name] = "three dimensions"
    assert set(reasons) == set(few)
    for name, text in few.items():
        assert text in reasons[name]
