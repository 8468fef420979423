"""Integrands: their integrals and variations against numerical integration and sums over grids, their specs."""

from __future__ import annotations

import itertools
import json
import math

import mpmath
import numpy as np
import pytest
from scipy import integrate as scipy_integrate

from aliascope import integrands
from aliascope.errors import InvalidInput, SpecError, Unsupported
from aliascope.integrands.genz import corner_peak_integral, parameters
from aliascope.integrands.shapes import half_space_volume

# Each kind, with and without its keys, and the dimensions in which its integral is compared.
SPECS = (
    *("constant:value=-2.5", "linear", "product", "product:strength=0.3", "g-function", "g-function:weight=2"),
    *("oscillatory", "oscillatory:draw=3", "product-peak", "product-peak:draw=4", "corner-peak", "corner-peak:draw=5"),
    *("gaussian", "gaussian:draw=6", "continuous", "continuous:draw=7", "discontinuous", "discontinuous:draw=8"),
    *("edge", "edge:angle=-123,offset=0.4", "half-space", "half-space:position=0.9", "disc", "disc:radius=0.45"),
    *("step", "step:position=1", "box", "box:high=1,low=0.3", "bright-feature:share=0.3,background=0.5,brightness=40"),
)


def dimensions(integrand: integrands.Integrand, most: int) -> range:
    return range(integrand.kind.least_dimensions, min(integrand.kind.most_dimensions, most) + 1)


def test_every_kind_is_in_the_list_of_this_test() -> None:
    assert {spec.partition(":")[0] for spec in SPECS} == set(integrands.KINDS)


def over_a_line(f, breaks: list[float]) -> mpmath.mpf:
    """The integral of a function of one variable over [0, 1], by mpmath's tanh-sinh rule between the breaks."""
    edges = sorted({0.0, 1.0, *(b for b in breaks if 0.0 < b < 1.0)})
    return mpmath.quad(f, edges)


GENZ_FACTORS = {
    "product-peak": lambda j, a, w: lambda x: 1 / (1 / mpmath.mpf(a) ** 2 + (x - w) ** 2),
    "gaussian": lambda j, a, w: lambda x: mpmath.exp(-(mpmath.mpf(a) ** 2) * (x - w) ** 2),
    "continuous": lambda j, a, w: lambda x: mpmath.exp(-a * abs(x - w)),
    "discontinuous": lambda j, a, w: lambda x: mpmath.exp(a * x) if j > 1 or x <= w else mpmath.mpf(0),
}


@pytest.mark.parametrize("name", GENZ_FACTORS)
@pytest.mark.parametrize(("draw", "d"), [(0, 1), (0, 5), (9, 2), (9, 12)])
def test_genz_products_against_mpmath(name: str, draw: int, d: int) -> None:
    integrand = integrands.parse(f"{name}:draw={draw}")
    difficulty = float(integrand.keys[0].default)
    weights, places = parameters(draw, difficulty, d)
    factors = [GENZ_FACTORS[name](j, a, w) for j, (a, w) in enumerate(zip(weights, places, strict=True))]
    expected = mpmath.mpf(1)
    for factor, place in zip(factors, places, strict=True):
        expected *= over_a_line(factor, [place])
    # d factors, each right to a few units in the last place of a double.
    assert integrand.exact(d) == pytest.approx(float(expected), rel=1e-12)
    at = np.random.default_rng(1).random((20, d))
    values = [float(mpmath.fprod(f(float(x)) for f, x in zip(factors, row, strict=True))) for row in at]
    assert integrand.evaluate(at) == pytest.approx(values, rel=1e-12, abs=0.0)


@pytest.mark.parametrize(("draw", "d"), [(0, 1), (0, 6), (2, 2), (2, 10)])
def test_oscillatory_against_mpmath(draw: int, d: int) -> None:
    weights, places = parameters(draw, 9.0, d)
    # The real part of a product of integrals of exp(i a x) over lines, each by mpmath.
    product = mpmath.expj(2 * mpmath.pi * mpmath.mpf(places[0]))
    for a in weights:
        product *= mpmath.quad(lambda x, a=a: mpmath.expj(a * x), [0, 1])
    # Of a cosine that cancels: an absolute bound.
    assert integrands.parse(f"oscillatory:draw={draw}").exact(d) == pytest.approx(float(product.real), abs=1e-14)


@pytest.mark.parametrize(("draw", "d"), [(0, 1), (0, 3), (0, 16), (2, 4), (2, 9)])
def test_corner_peak_against_mpmath(draw: int, d: int) -> None:
    # 1/s^(d+1) = the integral of t^d e^(-ts) over t, over d!: what is left over x is a product. Nothing cancels.
    weights = parameters(draw, 1.85, d)[0]

    def over_time(t: mpmath.mpf) -> mpmath.mpf:
        return mpmath.exp(-t) * mpmath.fprod(-mpmath.expm1(-a * t) / a for a in weights)

    expected = mpmath.quad(over_time, [0, 1, 5, 20, 60, 200]) / mpmath.factorial(d)
    assert corner_peak_integral(weights) == pytest.approx(float(expected), rel=1e-12)
    assert integrands.parse(f"corner-peak:draw={draw}").exact(d) == corner_peak_integral(weights)


def test_half_spaces_against_lower_dimensions() -> None:
    # A volume is the integral of the volumes of its slices: scipy's rule between the kinks of that polynomial.
    normal, threshold = (1.1, 0.7, 1.9), 1.7
    kinks = [(threshold - s) / 1.9 for s in (0.0, 0.7, 1.1, 1.8)]
    inner = [k for k in kinks if 0.0 < k < 1.0]

    def slice_area(z: float) -> float:
        left = threshold - 1.9 * z
        return half_space_volume((1.1, 0.7), left) if left > 0 else 0.0

    expected, _ = scipy_integrate.quad(slice_area, 0.0, 1.0, points=inner, epsabs=1e-13, epsrel=1e-13)
    assert half_space_volume(normal, threshold) == pytest.approx(expected, abs=1e-12)
    # The mean of half a cube that is cut through its centre, and Irwin and Hall's sum of twelve.
    assert half_space_volume((0.3,) * 16, 2.4) == pytest.approx(0.5, abs=1e-15)
    hall = math.fsum((-1) ** k * math.comb(12, k) * float(5 - k) ** 12 for k in range(5)) / math.factorial(12)
    assert half_space_volume((1.0,) * 12, 5.0) == pytest.approx(hall, rel=1e-10)


def test_edges_and_discs_against_slices() -> None:
    for spec in ("edge", "edge:angle=-123,offset=0.4", "edge:angle=45,offset=-0.9", "edge:angle=200,offset=1"):
        edge = integrands.parse(spec)
        turn, offset = math.radians(float(edge.function.angle)), float(edge.function.offset)  # type: ignore[attr-defined]

        def covered(y: float, turn: float = turn, offset: float = offset) -> float:
            at = 0.5 + (offset - math.sin(turn) * (y - 0.5)) / math.cos(turn)
            return min(max(at if math.cos(turn) > 0 else 1.0 - at, 0.0), 1.0)

        ends = [0.5 + (offset - math.cos(turn) * (x - 0.5)) / math.sin(turn) for x in (0.0, 1.0)]
        inner = [y for y in ends if 0.0 < y < 1.0] or None
        expected, _ = scipy_integrate.quad(covered, 0.0, 1.0, points=inner, epsabs=1e-14)
        assert edge.exact(2) == pytest.approx(expected, abs=1e-13)
    for d in (1, 2, 3, 6):
        # Balls by slices: V_d = 2 V_(d-1) times the integral of cos^d.
        expected = 2.0 * 0.4
        for k in range(2, d + 1):
            expected *= 2.0 * 0.4 * float(mpmath.quad(lambda t, k=k: mpmath.cos(t) ** k, [0, mpmath.pi / 2]))
        assert integrands.parse("disc").exact(d) == pytest.approx(expected, rel=1e-13)


def largest(integrand: integrands.Integrand, d: int) -> float:
    return float(np.abs(integrand.evaluate(np.random.default_rng(0).random((1000, d)))).max())


@pytest.mark.parametrize("spec", SPECS)
def test_integrals_are_those_of_the_values(spec: str) -> None:
    # Formula and values may each be right and not belong together. Scrambled Sobol points of scipy, 16 times: the mean
    # within six of its standard errors (two-sided, 16 values: p < 3e-5), or of rounding.
    from scipy.stats import qmc

    integrand = integrands.parse(spec)
    for d in dimensions(integrand, 4):
        means = [
            integrand.evaluate(qmc.Sobol(d, rng=np.random.default_rng(seed)).random_base2(11)).mean()
            for seed in range(16)
        ]
        error = np.std(means, ddof=1) / 4.0
        # scipy's points have 30 bits, so they are 2^-31 too low; and where a jump lies along an axis, all 16 sets may
        # have the one point of a cell on the same side of it.
        floor = (2.0**-10 if "jump" in integrand.smoothness else 2.0**-28) * largest(integrand, d)
        assert np.mean(means) == pytest.approx(integrand.exact(d), abs=6.0 * error + floor)


def grid_variation(integrand: integrands.Integrand, d: int, side: int) -> float:
    """The definition: over every face at 1, the sum of the mixed differences of a grid's cells, in magnitude."""
    axis = np.linspace(0.0, 1.0, side + 1)
    total = 0.0
    for size in range(1, d + 1):
        for chosen in itertools.combinations(range(d), size):
            grids = np.meshgrid(*([axis] * size), indexing="ij")
            at = np.ones((axis.size**size, d))
            for column, grid in zip(chosen, grids, strict=True):
                at[:, column] = grid.ravel()
            values = integrand.evaluate(at).reshape((axis.size,) * size)
            for k in range(size):
                values = np.diff(values, axis=k)
            total += float(np.abs(values).sum())
    return total


@pytest.mark.parametrize("spec", SPECS)
def test_variations_against_the_definition_on_a_grid(spec: str) -> None:
    integrand = integrands.parse(spec)
    for d in dimensions(integrand, 3):
        variation = integrand.variation(d)
        side = (4096, 512, 64)[d - 1]
        on_grid = grid_variation(integrand, d, side)
        if variation is None:
            assert integrand.no_variation(d)
            continue
        assert integrand.no_variation(d) is None
        # A grid sees no more than there is, but for the rounding of 2^18 differences. What it misses lies in the cells
        # about a turn: of second order where that is smooth; of first at a crease, or where a slope ends in a jump.
        assert on_grid <= variation * (1.0 + 1e-12) + 2.0**18 * 2.0**-52
        steep = integrand.name in ("continuous", "discontinuous")
        assert on_grid >= variation * (1.0 - ((2e-3, 0.02, 0.15)[d - 1] if steep else 1e-3))


def test_infinite_variation_grows_with_the_grid() -> None:
    edge = integrands.parse("edge")
    assert edge.variation(2) is None
    assert grid_variation(edge, 2, 256) > 1.8 * grid_variation(edge, 2, 128)
    assert "infinite" in str(edge.no_variation(2))
    assert "closed form" in str(integrands.parse("oscillatory").no_variation(2))


def test_drawn_parameters_stay() -> None:
    # Golden values: what PCG64's bits make; a result with draw=1 is to mean the same in ten years.
    weights, places = parameters(1, 9.0, 2)
    assert weights + places == pytest.approx(GOLDEN_PARAMETERS, abs=1e-15)
    assert math.fsum(weights) == pytest.approx(9.0, rel=1e-15)
    for d in (1, 7):
        weights, places = parameters(5, 3.0, d)
        assert len(weights) == len(places) == d
        assert all(0.0 < w < 1.0 for w in places)
        assert all(a > 0.0 for a in weights)


GOLDEN_PARAMETERS = (7.022143865608428, 1.977856134391571, 0.9504636963259354, 0.948649447137244)


def test_a_feature_is_as_large_as_its_share() -> None:
    feature = integrands.parse("bright-feature:share=0.04,brightness=25")
    axis = (np.arange(500) + 0.5) / 500
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    assert feature.exact(2) == 1.0
    assert feature.evaluate(grid).mean() == pytest.approx(1.0, abs=25 * 4 * 0.2 / 500)  # a row of cells along its rim


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("gausian", 'unknown integrand "gausian"; did you mean "gaussian"?'),
        ("zzz", "known: box, bright-feature"),
        ("gaussian:dificulty=3", 'unknown key "dificulty"; did you mean "difficulty"?'),
        ("linear:slope=1", 'unknown key "slope"; it has none'),
        ("disc:radius=0.6", r"radius=0.6 lies outside \[0.001, 0.45\]"),
        ("disc:radius=round", 'radius="round" is not a number'),
        ("box:low=0.6,high=0.4", "low=0.6 is not below high=0.4"),
        ("edge:angle=90", "parallel to an axis"),
        ("step:position", "not of the form key=value"),
    ],
)
def test_bad_specs(spec: str, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        integrands.parse(spec)


def test_specs_have_one_canonical_form() -> None:
    assert integrands.parse("gaussian:draw=0,difficulty=7.03").spec == "gaussian"
    assert integrands.parse("box:low=0.1,high=0.5").spec == "box:high=0.5,low=0.1"


def test_dimensions_and_shapes_are_checked() -> None:
    edge = integrands.parse("edge")
    with pytest.raises(Unsupported, match="edge: exists in 2 dimensions, not in 3"):
        edge.exact(3)
    with pytest.raises(Unsupported, match="corner-peak: exists in 1 to 16 dimensions, not in 17"):
        integrands.parse("corner-peak").evaluate(np.zeros((3, 17)))
    with pytest.raises(InvalidInput, match="table of n rows"):
        edge.evaluate(np.zeros(4))
    assert edge.evaluate(np.zeros((0, 2))).shape == (0,)


def test_the_list_command() -> None:
    from typer.testing import CliRunner

    from aliascope.cli.shared import app

    document = json.loads(CliRunner().invoke(app, ["list", "integrands", "--json"]).stdout)
    assert [entry["name"] for entry in document["integrands"]] == list(integrands.KINDS)
    for entry in document["integrands"]:
        assert entry["title"]
        assert entry["source"]
        assert entry["dimensions"].startswith("d = ")
