"""`aliascope integrate`: rates against theory, Koksma and Hlawka's theorem, exact sums, the command and its page."""

from __future__ import annotations

import csv
import json
import math
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import aliascope
from aliascope import integrands
from aliascope.cli.shared import app
from aliascope.errors import AliascopeError, CheckFailed, InvalidInput, SpecError, Unsupported
from aliascope.integration import Integration, counts, integrate
from aliascope.integration.measuring import Pattern, error_at, estimate
from aliascope.integration.theory import theory
from aliascope.native.discrepancy import measure
from aliascope.native.samplers import points, registered
from aliascope.report.lecture import formula
from aliascope.studies.integrate import expand


def run(*words: str) -> Any:
    return CliRunner().invoke(app, ["integrate", *words])


def result(integrand: str, sampler: str, d: int, **more: Any) -> Any:
    return integrate(integrand, [sampler], d, **more).results[0]


# --- rates ---------------------------------------------------------------------------------------------------------

# Theory's orders, one pair each. d = 3 is stratified by an orthogonal array of strength 3, of whose N = p^3 points each
# has a cell of its own.
ORDERS = (
    ("edge", "random", 2, -1 / 2),
    ("gaussian", "random", 8, -1 / 2),
    ("edge", "jittered", 2, -3 / 4),
    ("disc", "jittered", 2, -3 / 4),
    ("product", "jittered", 1, -3 / 2),
    ("product", "jittered", 2, -1.0),
    ("continuous:difficulty=3", "jittered", 2, -1.0),
    ("product", "orthogonal-array:jitter=jittered,strength=3", 3, -5 / 6),
    ("half-space", "orthogonal-array:jitter=jittered,strength=3", 3, -2 / 3),
    ("product", "n-rooks", 2, -1 / 2),
    ("linear", "n-rooks", 4, -3 / 2),
    ("product", "sobol:scramble=owen", 1, -3 / 2),
    ("edge", "sobol:scramble=owen", 2, -3 / 4),
    ("edge", "pmj02", 2, -3 / 4),
)


@pytest.mark.parametrize(("integrand", "sampler", "d", "exponent"), ORDERS)
def test_random_patterns_have_the_rate_of_theory(integrand: str, sampler: str, d: int, exponent: float) -> None:
    found = result(integrand, sampler, d, least_n=64, seed=1)
    assert found.theory is not None
    assert found.theory.exponent == pytest.approx(exponent)
    # Within twice the half of its 95 % interval, which is more than 4 standard errors: for 14 pairs p < 0.05, were the
    # seed free.
    half = (found.rate.interval[1] - found.rate.interval[0]) / 2.0
    assert found.rate.exponent == pytest.approx(exponent, abs=2.0 * half)
    assert half < 0.15


def test_owens_scrambling_gains_another_order() -> None:
    found = result("product", "sobol:scramble=owen", 2, least_n=64, most_n=16384, seed=2)
    expected = found.theory.rate_over([error.n for error in found.errors])
    # N^-3/2 (log N)^1/2 over this range of N.
    assert expected == pytest.approx(-1.5 + 0.5 / math.log(1024), abs=0.01)
    assert found.rate.interval[0] - 0.02 <= expected <= found.rate.interval[1] + 0.02
    assert found.rate.exponent < -1.3


@pytest.mark.parametrize("sampler", ["halton", "hammersley", "sobol", "zaremba", "larcher-pillichshammer", "lattice"])
def test_low_discrepancy_stays_below_its_bound(sampler: str) -> None:
    found = result("product", sampler, 2, most_n=65536)
    assert found.theory.kind == "bound"
    assert found.theory.exponent == -1
    # The error times N over its logarithms comes to a constant: at the largest N it is no more than a tenth above what
    # it was before.
    power = float(found.theory.logarithms)
    scaled = [error.rmse * error.n / math.log(error.n) ** power for error in found.errors]
    assert scaled[-1] <= 1.1 * max(scaled[:-1])
    assert found.rate.exponent < -0.7


@pytest.mark.parametrize(("d", "most"), [(1, 4096), (2, 4096), (3, 32768), (4, 65536)])
def test_grids_collapse_as_dimensions_grow(d: int, most: int) -> None:
    found = result("product:strength=0.5", "regular", d, least_n=3**d, most_n=most)
    assert found.theory.text == f"~ N^{Fraction(-2, d)}"
    # Their series has a next term, of twice the order, so a fit is off by some hundredths.
    assert found.rate.exponent == pytest.approx(-2.0 / d, abs=0.03)
    assert found.rate.interval[0] - 1e-3 <= -2.0 / d <= found.rate.interval[1] + 0.03


def test_quadrature_beats_random_in_few_dimensions_and_loses_in_many() -> None:
    def errors(d: int) -> list[float]:
        samplers = ["random", "regular"]
        found = integrate("product:strength=0.5", samplers, d, least_n=65536, most_n=65536, realisations=8)
        return [one.errors[0].rmse for one in found.results]

    random, grid = errors(2)
    assert grid < random / 100
    random, grid = errors(16)
    assert grid > 10 * random


def test_gauss_is_exact_to_rounding_and_left_out_of_the_fit() -> None:
    found = result("product", "gauss-legendre", 2)
    assert found.errors[-1].at_floor
    assert found.errors[-1].rmse < 1e-14
    assert found.rate is None or found.rate.most_n < found.errors[-1].n
    exact = result("constant:value=7", "halton", 3)
    assert exact.rate is None
    assert exact.reason == "exact but for rounding"
    assert exact.theory is None


def test_the_node_at_one_is_put_back() -> None:
    # Clenshaw and Curtis's outermost weight is about 1/N^2: with a node at 1 - 2^-24 the error would stay at 1e-10.
    assert error_at(integrands.parse("product"), Pattern("clenshaw-curtis", 1), 33, 2, 0).rmse < 1e-14
    nodes, _ = Pattern("clenshaw-curtis", 1).realisation(33, 0)
    assert nodes.max() == 1.0


def test_sums_lose_no_digits() -> None:
    rng = np.random.default_rng(3)
    at, weights = rng.random((5000, 1)), rng.random(5000) - 0.5
    function = integrands.parse("constant:value=1e15")
    exact = sum(Fraction(float(w)) for w in weights) * Fraction(1e15)
    # 2^-64 from each product of 5000, of the size of the terms; the sum itself rounds once.
    bound = 2.0**-64 * 5000 * 0.5e15 + abs(float(exact)) * 2.0**-53
    assert estimate(function, at, weights)[0] == pytest.approx(float(exact), abs=bound, rel=0.0)
    assert abs(float((weights * 1e15).sum()) - float(exact)) > 0.0


# --- numbers of points ---------------------------------------------------------------------------------------------


def test_every_pattern_has_the_numbers_it_can() -> None:
    assert counts("sobol", 2, 16, 256) == [16, 32, 64, 128, 256]
    assert counts("jittered", 2, 16, 256) == [16, 36, 64, 121, 256]
    assert counts("regular", 3, 8, 1000) == [8, 27, 64, 125, 216, 512, 1000]
    assert counts("lattice", 2, 10, 300) == [13, 34, 55, 144, 233]
    assert counts("standard-msaa", 2, 1, 4096) == [1, 2, 4, 8, 16]
    assert counts("cook", 2, 1, 4096) == []
    assert counts("random", 2, 100, 100) == [100]


def test_what_a_pattern_cannot_have_is_refused_with_its_reason() -> None:
    found = integrate("product", ["random", "zaremba"], 3, most_n=64)
    assert [one.sampler for one in found.results] == ["random"]
    assert found.refused == (("zaremba", "zaremba has two dimensions, not 3"),)


@pytest.mark.parametrize("integrand", ["product", "edge"])
def test_every_registered_sampler_integrates(integrand: str) -> None:
    found = integrate(integrand, expand(["*"]), 2, realisations=2, least_n=1, most_n=32)
    assert len(found.results) + len(found.refused) == len(registered())
    assert {spec for spec, _ in found.refused} == {"cook", "pan-diagonal", "mitchell-spacetime"}
    for one in found.results:
        assert all(math.isfinite(error.rmse) for error in one.errors)


def test_results_depend_on_the_seed_and_on_nothing_else() -> None:
    first, again = (result("edge", "jittered", 2, most_n=64, seed=5).errors for _ in range(2))
    assert first == again
    assert result("edge", "jittered", 2, most_n=64, seed=6).errors != first
    assert result("edge", "halton", 2, most_n=64, seed=6).errors == result("edge", "halton", 2, most_n=64).errors


def test_random_errors_are_the_variance_over_n() -> None:
    # V[F_N] = p (1 - p) / N for the indicator of an area p; 4 standard errors, p < 1e-4 each.
    found = result("edge", "random", 2, realisations=400, least_n=64, most_n=256, seed=7)
    p = integrands.parse("edge").exact(2)
    for error in found.errors:
        expected = math.sqrt(p * (1 - p) / error.n)
        assert error.rmse == pytest.approx(expected, abs=4 * error.standard_error)
        assert error.standard_error == pytest.approx(expected / math.sqrt(2 * 400), rel=0.2)


def test_shifts_make_fixed_patterns_random_and_spare_rules_and_random_ones() -> None:
    found = integrate("product", ["hammersley", "gauss-legendre", "random"], 2, most_n=64, shift=True)
    assert [one.shifted for one in found.results] == [True, False, False]
    assert [one.errors[0].realisations for one in found.results] == [64, 1, 64]
    plain = integrate("product", ["gauss-legendre", "random"], 2, most_n=64)
    assert [one.errors for one in found.results[1:]] == [one.errors for one in plain.results]
    # A shifted grid of one dimension has the error of its shift, h (u - 1/2), times f(1) - f(0) = e: its root mean
    # square is e h / sqrt 12, but for the next order in h = 1/64; 4 standard errors.
    error = result("product", "regular", 1, shift=True, realisations=400, least_n=64, most_n=64).errors[0]
    assert error.rmse == pytest.approx(math.e / 64 / math.sqrt(12), abs=4 * error.standard_error + 1e-4)
    assert theory("regular", integrands.parse("product"), 1, shifted=True) is None


# --- Koksma and Hlawka ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bounded() -> list[Integration]:
    names = ["linear", "product", "g-function", "gaussian", "product-peak", "corner-peak", "continuous", "step", "box"]
    names += ["discontinuous", "bright-feature:share=0.1", "oscillatory", "half-space"]
    samplers = ["random", "regular", "halton", "sobol:scramble=owen", "lattice"]
    found = []
    for d, most in ((1, 256), (2, 256), (3, 64)):
        known = [name for name in names if integrands.parse(name).variation(d) is not None]
        more = {"realisations": 2, "least_n": 1, "most_n": most, "variation": True}
        found += [integrate(name, samplers, d, **more) for name in known]
    return found


def test_no_error_is_above_its_bound(bounded: list[Integration]) -> None:
    ratios = [one.ratio for found in bounded for each in found.results for one in each.variation]
    assert len(ratios) > 500
    assert max(ratios) <= 1.0 + 1e-12  # rounding of a ratio that can be 1
    for found in bounded:
        for each in found.results:
            assert each.no_variation is None
            assert [one.n for one in each.variation] == [error.n for error in each.errors]


def test_the_bound_is_reached() -> None:
    # The indicator of [0, x), x where the star discrepancy is met: the error is the discrepancy, V is 1.
    at = points("random", 37, 1, seed=9)
    star = measure("star", at)
    position = float(star.witness[0]) + (1e-12 if star.closed else -1e-12)
    function = integrands.parse(f"step:position={position!r}")
    assert abs(function.evaluate(at).mean() - position) == pytest.approx(star.value, abs=1e-11)
    assert function.variation(1) == 1.0


def test_a_wrong_variation_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    right = integrands.Integrand.variation
    integrate("step", ["random"], 2, variation=True)
    monkeypatch.setattr(integrands.Integrand, "variation", lambda self, d=2: (right(self, d) or 0.0) / 2.0)
    with pytest.raises(CheckFailed, match=r"error .* is above V D\*"):
        integrate("step", ["random"], 2, variation=True)
    outcome = run("step", "--sampler", "random", "--variation")
    assert isinstance(outcome.exception, CheckFailed)
    assert outcome.exception.exit_code == 1


def test_where_there_is_no_bound_there_is_a_reason() -> None:
    def reason(integrand: str, sampler: str, d: int, **more: Any) -> str:
        found = result(integrand, sampler, d, variation=True, realisations=2, **more)
        assert found.variation == ()
        return str(found.no_variation)

    assert "infinite" in reason("edge", "random", 2, most_n=16)
    assert "variation is 0" in reason("constant", "random", 2, most_n=16)
    assert "4 dimensions" in reason("product", "random", 5, most_n=16)
    assert "at most 512 points" in reason("product", "random", 3, least_n=1024, most_n=1024)
    assert "equal weights" in reason("product", "gauss-legendre", 2, most_n=64)


# --- the command ---------------------------------------------------------------------------------------------------


def test_json_keeps_its_contract() -> None:
    outcome = run("product", "--sampler", "random", "--sampler", "gauss-legendre", "--most-n", "256", "--json")
    assert outcome.exit_code == 0
    document = json.loads(outcome.stdout, parse_constant=lambda name: pytest.fail(f"{name} in the document"))
    assert document["integrand"] == "product"
    assert document["d"] == 2
    assert document["exact"] == 1.0
    assert document["variation"] == pytest.approx(3 * math.e**2)
    random, gauss = document["results"]
    assert random["sampler"] == "random"
    low, high = random["rate_interval"]
    assert low < random["rate"] < high
    assert random["rate_range"] == [16, 256]
    assert [point["n"] for point in random["points"]] == [16, 32, 64, 128, 256]
    assert all(point["rmse"] > 0 and point["standard_error"] > 0 for point in random["points"])
    assert random["theory"]["rate"] == -0.5
    assert gauss["rate"] is None
    assert gauss["rate_interval"] is None
    assert "rounding" in gauss["rate_reason"]
    assert gauss["points"][0]["standard_error"] == 0.0


def test_the_table_and_the_files(tmp_path: Path) -> None:
    words = ("box", "--sampler", "random", "--sampler", "halt*", "--most-n", "64", "--variation", "--shift")
    outcome = run(*words, "-o", str(tmp_path / "made"))
    assert outcome.exit_code == 0
    assert "box, d = 2: integral 0.33339076; variation 4" in outcome.stdout
    assert re.search(r"^random +16 to 64 +-0\.\d\d  \[-\d", outcome.stdout, re.MULTILINE)
    assert re.search(r"^halton \+ shift +64 ( +0\.\d+){4}$", outcome.stdout, re.MULTILINE)
    rows = list(csv.DictReader((tmp_path / "made" / "convergence.csv").read_text().splitlines()))
    assert [row["n"] for row in rows] == ["16", "32", "64"] * 2
    assert all(float(row["koksma_hlawka_ratio"]) <= 1.0 for row in rows)
    svg = (tmp_path / "made" / "convergence.svg").read_text()
    assert svg.startswith("<?xml")
    assert run(*words, "-o", str(tmp_path / "again")).exit_code == 0
    assert (tmp_path / "again" / "convergence.svg").read_text() == svg


def test_without_samplers_a_telling_set_is_compared() -> None:
    document = json.loads(run("linear", "-d", "3", "--most-n", "64", "--realisations", "2", "--json").stdout)
    names = [entry["sampler"] for entry in document["results"]]
    assert {"random", "jittered", "halton", "hammersley", "sobol", "sobol:scramble=owen", "gauss-legendre"} <= set(
        names
    )
    assert document["refused"] == []


@pytest.mark.parametrize(
    ("words", "error", "message"),
    [
        (("gausian",), SpecError, 'unknown integrand "gausian"; did you mean "gaussian"?'),
        (("edge", "--sampler", "haltn"), SpecError, 'did you mean "halton"'),
        (("edge", "--sampler", "haltn*"), SpecError, 'no sampler is called "haltn*"; did you mean "halton"?'),
        (("edge", "--sampler", "halton:scrmble=owen"), SpecError, "scramble"),
        (("edge", "-d", "3"), Unsupported, "integrand edge: exists in 2 dimensions, not in 3"),
        (("product", "-d", "3", "--sampler", "zaremba"), Unsupported, "zaremba has two dimensions, not 3"),
        (("product", "--sampler", "standard-msaa", "--least-n", "64"), Unsupported, "16 points"),
        (("edge", "--least-n", "64", "--most-n", "32"), InvalidInput, "N from 64 to 32"),
        ((), InvalidInput, "INTEGRAND is missing"),
        (("--lecture",), InvalidInput, "-o DIR"),
        (("edge", "--lecture", "-o", "x"), InvalidInput, "its own integrands"),
    ],
)
def test_bad_input_is_told_what_to_do(words: tuple[str, ...], error: type[AliascopeError], message: str) -> None:
    outcome = run(*words)
    assert isinstance(outcome.exception, error)
    assert message in str(outcome.exception)
    assert outcome.exception.exit_code == 2


@pytest.mark.parametrize("words", [("edge", "--least-n", "0"), ("edge", "-d", "0"), ("edge", "--realisations", "1")])
def test_numbers_out_of_range_are_usage(words: tuple[str, ...]) -> None:
    assert run(*words).exit_code == 2


def test_from_python() -> None:
    found = aliascope.integrate("edge", ["random"], most_n=64)
    assert found.results[0].rate.exponent == pytest.approx(-0.5, abs=0.3)
    with pytest.raises(InvalidInput, match="realisations"):
        aliascope.integrate("edge", realisations=1)


# --- the page of the lecture ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def lecture(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    folder = tmp_path_factory.mktemp("lecture")
    outcome = run("--lecture", "--realisations", "2", "-o", str(folder), "--json")
    assert outcome.exit_code == 0
    return folder, json.loads(outcome.stdout)


def test_the_lecture_has_a_plot_a_page_and_the_table(lecture: tuple[Path, Any]) -> None:
    folder, document = lecture
    names = ["convergence", "stratified-sampling", "quasi-monte-carlo", "high-dimensional-sampling"]
    names += ["high-dimensional-edges", "total-variation"]
    assert list(document["figures"]) == names
    page = (folder / "lecture.html").read_text()
    for name in names:
        assert (folder / f"{name}.svg").stat().st_size > 10_000
        assert len((folder / f"{name}.csv").read_text().splitlines()) > 8
        assert f'id="{name}"' in page
        assert f'href="{name}.csv"' in page
    assert page.count('<th scope="row"') == 15
    ids = re.findall(r'\bid="([^"]*)"', page)
    assert len(ids) == len(set(ids))
    # Nothing is loaded: every address is a file beside it, a part of the page, or the name of a namespace.
    for address in re.findall(r'(?:href|src)="([^"]*)"', page):
        assert address.startswith("#") or (folder / address).is_file()
    assert "url(http" not in page


def test_dimensions_of_the_lecture_share_their_number_of_points(lecture: tuple[Path, Any]) -> None:
    _, document = lecture
    parts = document["figures"]["high-dimensional-sampling"]
    assert [part["d"] for part in parts] == [1, 2, 4, 8, 16]
    assert {point["n"] for part in parts for entry in part["results"] for point in entry["points"]} == {65536}


def test_formulas_of_the_page() -> None:
    assert str(formula("~ N^-3/4 and <= (log N)^2 N^-1")) == (
        "∼ N<sup>−3/4</sup> and ≤ (log N)<sup>2</sup> N<sup>−1</sup>"
    )
    assert (
        str(formula("near N^-3/2. N^(-2/d), D_N, quasi-Monte <b>"))
        == "near N<sup>−3/2</sup>. N<sup>−2/d</sup>, D<sub>N</sub>, quasi-Monte &lt;b&gt;"
    )
