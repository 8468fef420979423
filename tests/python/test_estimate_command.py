"""`aliascope estimate`: bias and coverage over 10^4 repetitions.

Seeds are fixed. What is random lies within four of its standard errors, but once in 16,000 times."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import pytest
from scipy import stats
from test_cli import complaint, run

from aliascope.errors import InvalidInput, Unsupported
from aliascope.native import estimate as native
from aliascope.studies import estimate as study
from aliascope.studies.estimate import Asked, Measured, document, lines, measure_all, parse_integrands
from aliascope.studies.estimate_page import headlines, short, write

REPETITIONS = 10_000
BRIGHT = "bright-feature:brightness=100"


@pytest.fixture(scope="module")
def asked() -> Asked:
    return Asked(parse_integrands(["product", "edge", BRIGHT], 2), None, None, 2, 1024, REPETITIONS, 0.95, 0)


ADAPTIVE = ("whitted", "kajiya", "mitchell")


@pytest.fixture(scope="module")
def measured(asked: Asked) -> list[Measured]:
    """Without those that look around a pixel, which take long: they have a test of their own."""
    alone = [info for info in native.registered() if info.name not in ADAPTIVE]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(native, "registered", lambda: alone)
        return measure_all(asked, lambda what, done, total: None)


def of(measured: list[Measured], integrand: str, start: str) -> Measured:
    return next(one for one in measured if one.integrand == integrand and one.estimator.startswith(start))


def test_coverage_of_a_smooth_integrand_from_256_samples(measured: list[Measured]) -> None:
    chance = math.sqrt(0.95 * 0.05 / REPETITIONS)
    few = [of(measured, "product", f"fixed:n={n}").coverage or 0.0 for n in (4, 16, 64)]
    # Lower, and by less and less: the values are not normal.
    assert few[0] < few[1] < few[2] < 0.95
    assert few[0] < 0.95 - 20 * chance
    for n in (256, 1024):
        row = of(measured, "product", f"fixed:n={n}")
        assert row.coverage == pytest.approx(0.95, abs=4 * chance)
        assert not row.biased


def test_fixed_counts_err_as_theory_has_it(measured: list[Measured]) -> None:
    # The variance of the bright feature is 100^2 * 0.01 * 0.99, that of the edge p (1 - p).
    for integrand, deviation in ((BRIGHT, math.sqrt(99.0)), ("edge", math.sqrt(0.572637 * (1 - 0.572637)))):
        for n in (4, 16, 64, 256, 1024):
            row = of(measured, integrand, f"fixed:n={n}")
            assert row.samples == n
            assert row.rmse == pytest.approx(deviation / math.sqrt(n), abs=4 * row.rmse_standard_error)
            assert abs(row.bias) < 4 * row.bias_standard_error


def test_the_coverage_on_the_bright_feature_is_that_of_the_binomial_law(measured: list[Measured]) -> None:
    """The interval depends on how many of n samples meet the feature alone."""
    for n in (4, 16, 64, 256):
        expected = 0.0
        for met in range(n + 1):
            mean, variance = 100.0 * met / n, 100.0**2 * met * (n - met) / (n * (n - 1.0))
            if abs(mean - 1.0) <= stats.t.ppf(0.975, n - 1) * math.sqrt(variance / n):
                expected += float(stats.binom.pmf(met, n, 0.01))
        row = of(measured, BRIGHT, f"fixed:n={n}")
        assert row.coverage == pytest.approx(expected, abs=4 * math.sqrt(expected * (1 - expected) / REPETITIONS))


def test_stopping_biases_and_fresh_samples_do_not(measured: list[Measured]) -> None:
    for name in ("student-t:tolerance", "chi-squared:tolerance"):
        row = of(measured, BRIGHT, name)
        # Where the first eight samples all miss, with probability 0.99^8, the estimate is 0.
        assert row.biased
        assert row.bias < -0.9
    cured = [one for one in measured if "unbiased=1" in one.estimator]
    assert len(cured) == 6
    assert not any(one.biased for one in cured)
    for one in cured:
        plain = of(measured, one.integrand, one.estimator.replace(",unbiased=1", ""))
        # Twice the samples. The pixels draw the same first ones, but may stop earlier: half of them are the most.
        assert one.samples == pytest.approx(2 * plain.samples, rel=0.01)


def test_the_bias_of_adaptive_sampling_and_its_cure() -> None:
    specs = [f"{name}:unbiased=1" for name in ADAPTIVE] + ["mitchell", "mitchell:cells=1,margin=0", "whitted"]
    asked = Asked(parse_integrands([BRIGHT], 2), tuple(specs), None, 2, 64, 2000, 0.95, 0)
    found = {one.estimator: one for one in measure_all(asked, lambda what, done, total: None)}
    for name in ADAPTIVE:
        assert not found[f"{name}:unbiased=1"].biased  # beyond four standard errors, of three estimates
    assert found["mitchell:cells=1,margin=0"].biased
    # What eight samples of a plain pixel miss in 92 % of all cases, 56 further ones cannot make good.
    assert found["mitchell:cells=1,margin=0"].bias < -0.5


def test_strata_and_sequences(measured: list[Measured]) -> None:
    for integrand in ("product", "edge"):
        collapsed, several = (of(measured, integrand, f"stratified:n={n}") for n in (16, 256))
        assert (collapsed.ratio or 1.0) < 0.5
        assert (collapsed.coverage or 0.0) > 0.96  # one sample a cell: the standard error is too large
        assert several.coverage == pytest.approx(0.95, abs=4 * math.sqrt(0.95 * 0.05 / REPETITIONS))
        owen = next(one for one in measured if one.integrand == integrand and one.sampler == "sobol:scramble=owen")
        assert owen.coverage == 1.0
        assert not owen.biased


def test_what_is_printed_and_written(measured: list[Measured], asked: Asked, tmp_path: Path) -> None:
    text = "\n".join(lines(asked, measured))
    assert "below" in text
    assert "not independent" in text
    page = write(tmp_path, asked, measured).read_text()
    assert page.count("<svg ") == 4  # three plots and the mark of the house
    assert "src=" not in page
    assert "Kirk and Arvo" in page
    with (tmp_path / "estimate.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(measured)
    assert float(rows[3]["bias"]) == measured[3].bias
    for name in ("product", "edge", "bright-feature-brightness-100"):
        assert (tmp_path / f"{name}.svg").stat().st_size > 5000
        assert (tmp_path / f"{name}.png").stat().st_size > 5000
    assert BRIGHT in headlines(asked, measured)[0]
    assert short(of(measured, BRIGHT, "fixed:n=4"), asked)
    assert not short(of(measured, "product", "fixed:n=256"), asked)


def test_the_document(asked: Asked, measured: list[Measured]) -> None:
    made = document(asked, measured)
    assert json.loads(json.dumps(made, allow_nan=False)) == made
    assert (made["repetitions"], made["confidence"]) == (REPETITIONS, 0.95)
    found = run("estimate", "linear", "--estimator", "fixed", "--estimator", "student-t:tolerance=0.2", "-d", "3",
                "-n", "64", "--repetitions", "500", "--seed", "5", "--json")  # fmt: skip
    results = json.loads(found.stdout)["results"]
    assert [one["estimator"] for one in results] == ["fixed", "student-t:tolerance=0.2"]
    assert results[0]["samples"] == 64
    assert results[1]["samples"] < 64
    rule = json.loads(run("estimate", "constant", "--estimator", "fixed", "--repetitions", "10", "--json").stdout)
    assert rule["results"][0]["coverage"] == 1.0
    assert rule["results"][0]["biased"] is False


def test_the_telling_set_fits_what_there_is() -> None:
    assert study.telling(8, 2, 0.304)[:2] == ["fixed:n=4", "student-t:tolerance=0.038"]
    for dimensions in (1, 3):
        made = study.telling(1024, dimensions, 0.0)
        assert "fixed:n=1024" in made
    assert [one.spec for one in parse_integrands([], 1)] == ["product", "gaussian", BRIGHT]


def test_what_cannot_be_estimated() -> None:
    assert "is not random" in complaint("estimate", "edge", "--sampler", "sobol", code=2)
    assert '"edgy"' in complaint("estimate", "edgy", code=2)
    with pytest.raises(Unsupported, match="dimension"):
        parse_integrands(["edge"], 3)
    for estimator, sampler, reason in (("student", None, "student-t"), ("student-t", "jittered", "no sequence")):
        with pytest.raises(InvalidInput, match=reason):
            measure_all(Asked(parse_integrands(["edge"], 2), (estimator,), sampler, 2, 64, 9, 0.9, 0), lambda *_: None)
