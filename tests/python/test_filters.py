"""Reconstruction filters: profiles against the papers' formulas, the tracer's pictures against a splat here."""

from __future__ import annotations

import itertools
import math
import operator
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad

from aliascope import api, scene_io
from aliascope.errors import InvalidInput, SpecError
from aliascope.native import filters, samplers
from aliascope.native.tracer import Tracer
from aliascope.renderers import embree, mode_of
from aliascope.renderers.base import filter_of

EPSILON = float(np.finfo(float).eps)


def cubic(t: mpmath.mpf, b: mpmath.mpf, c: mpmath.mpf) -> mpmath.mpf:
    """Mitchell and Netravali 1988, as the paper has it."""
    if t < 1:
        return ((12 - 9 * b - 6 * c) * t**3 + (-18 + 12 * b + 6 * c) * t**2 + (6 - 2 * b)) / 6
    return ((-b - 6 * c) * t**3 + (6 * b + 30 * c) * t**2 + (-12 * b - 48 * c) * t + (8 * b + 24 * c)) / 6


def harris(t: mpmath.mpf) -> mpmath.mpf:
    terms = ("0.35875", "0.48829", "0.14128", "0.01168")
    return mpmath.fsum(mpmath.mpf(a) * mpmath.cospi(k * t) for k, a in enumerate(terms))


def boxes(t: mpmath.mpf, widths: tuple[float, ...]) -> mpmath.mpf:
    """Convolved: the n-fold integral of the product of their differences, powers of the distance to each knot."""
    knots = [
        (math.prod(signs), sum(map(operator.mul, signs, widths)) / 2) for signs in itertools.product((1, -1), repeat=4)
    ]
    return mpmath.fsum(sign * max(mpmath.mpf(knot) - t, 0) ** 3 for sign, knot in knots)


THIRD = mpmath.mpf(1) / 3
FORMULAS: dict[str, tuple[Callable[[mpmath.mpf], mpmath.mpf], float]] = {
    "box": (lambda t: mpmath.mpf(1), 0.5),
    "box:radius=1.3": (lambda t: mpmath.mpf(1), 1.3),
    "tent": (lambda t: 1 - t, 1),
    "tent:radius=2.5": (lambda t: 1 - t / 2.5, 2.5),
    "gaussian": (lambda t: mpmath.exp(-2 * t**2), 1.5),
    "gaussian:radius=4,sigma=0.75": (lambda t: mpmath.exp(-(t**2) / (2 * mpmath.mpf(0.75) ** 2)), 4),
    "mitchell": (lambda t: cubic(t, THIRD, THIRD), 2),
    "mitchell:b=1.5,c=-0.25": (lambda t: cubic(t, mpmath.mpf(1.5), mpmath.mpf(-0.25)), 2),
    "mitchell:radius=3": (lambda t: cubic(2 * t / 3, THIRD, THIRD), 3),
    "catmull-rom": (lambda t: cubic(t, mpmath.mpf(0), mpmath.mpf(1) / 2), 2),
    "lanczos": (lambda t: mpmath.sincpi(t) * mpmath.sincpi(t / 3), 3),
    "lanczos:lobes=2": (lambda t: mpmath.sincpi(t) * mpmath.sincpi(t / 2), 2),
    "blackman-harris": (lambda t: harris(2 * t / 3), 1.5),
    "multi-stage": (lambda t: boxes(t, (1.0, 0.5, 0.5, 0.25)), 1.125),
}
"""Each as a function of the distance, not normalised, and its radius."""


def pieces_of(spec: str) -> int:
    """Into how many equal parts the radius is cut so that a formula is smooth on each."""
    return 9 if spec.startswith("multi-stage") else 6


def total(spec: str) -> mpmath.mpf:
    """The integral of a formula, by mpmath with 30 digits."""
    formula, radius = FORMULAS[spec]
    with mpmath.workdps(30):
        return 2 * mpmath.quad(formula, mpmath.linspace(0, mpmath.mpf(radius), pieces_of(spec) + 1))


def test_every_filter_has_a_formula_here() -> None:
    assert {info.name for info in filters.registered()} <= set(FORMULAS)
    assert all(info.title and info.source and info.parameters for info in filters.registered())
    assert "lobes=1..8" in next(info.parameters[0] for info in filters.registered() if info.name == "lanczos")


@pytest.mark.parametrize("spec", FORMULAS)
def test_profiles_are_the_formulas_divided_by_their_integrals(spec: str) -> None:
    formula, radius = FORMULAS[spec]
    assert filters.radius(spec) == radius
    x = np.linspace(0, radius, 501)[:-1]
    whole = total(spec)
    expected = np.array([float(formula(mpmath.mpf(float(t))) / whole) for t in x])
    # Values up to 2 (the notch filter's cubics add terms up to 21 / 6), of some ten roundings each.
    assert np.abs(filters.evaluate(spec, x) - expected).max() < 20 * EPSILON
    assert np.array_equal(filters.evaluate(spec, -x), filters.evaluate(spec, x))
    assert not filters.evaluate(spec, [radius, -radius - 1e-9, 1e9, -np.inf]).any()


@pytest.mark.parametrize("spec", FORMULAS)
def test_integrals(spec: str) -> None:
    formula, radius = FORMULAS[spec]
    assert filters.integral(spec, -np.inf, np.inf) == pytest.approx(1, abs=1e-14)  # the header's bound
    # The profile as it is evaluated, by another quadrature; 1e-13 is what quad reaches in double.
    knots = np.linspace(-radius, radius, 2 * pieces_of(spec) + 1)
    pieces = [
        quad(lambda t: float(filters.evaluate(spec, t)), a, b, epsabs=1e-15)[0] for a, b in itertools.pairwise(knots)
    ]
    assert sum(pieces) == pytest.approx(1, abs=1e-13)
    rng = np.random.default_rng(5)
    for a, b in rng.uniform(-1.2 * radius, 1.2 * radius, (12, 2)):
        low, high = sorted((max(-radius, min(radius, a)), max(-radius, min(radius, b))))
        inner = [knot for knot in np.linspace(-radius, radius, 2 * pieces_of(spec) + 1) if low < knot < high]
        with mpmath.workdps(30):
            exact = mpmath.quad(lambda t: formula(abs(t)), [low, *inner, high]) / total(spec)
        assert filters.integral(spec, a, b) == pytest.approx(float(exact) * (1 if a < b else -1), abs=1e-14)


@pytest.mark.parametrize("spec", FORMULAS)
def test_responses(spec: str) -> None:
    _, radius = FORMULAS[spec]
    assert filters.response(spec, 0.0) == pytest.approx(1, abs=1e-14)
    for frequency in (0.21, 0.5, 1.0, 3.7, 40.3):
        # Simpson's rule: a step turns by 2 pi 40.3 radius / (6 * 2^14), 0.01 radians at most, and the error is the
        # fourth power of that / 180 of the integral, 6e-11 / 180; half of it, and rounding, come to 1e-12.
        knots = np.linspace(0, radius, 7)
        exact = 0.0
        for a, b in itertools.pairwise(knots):
            x = np.linspace(a, b, (1 << 14) + 1)
            x[-1] = np.nextafter(b, 0)  # the last value of a profile that ends in a step
            weights = np.ones(x.size)
            weights[1:-1:2], weights[2:-1:2] = 4, 2
            height = filters.evaluate(spec, x)
            exact += 2 * (weights * height * np.cos(2 * np.pi * frequency * x)).sum() * (b - a) / (3 << 14)
        assert filters.response(spec, frequency) == pytest.approx(exact, abs=1e-11)
    assert np.array_equal(filters.response(spec, [-0.3, -7.0]), filters.response(spec, [0.3, 7.0]))


def test_responses_of_the_polynomials_have_closed_forms() -> None:
    f = np.linspace(0, 1000, 333)
    assert np.abs(filters.response("box", f) - np.sinc(f)).max() < 1e-12  # the header's bound, and below
    assert np.abs(filters.response("tent", f) - np.sinc(f) ** 2).max() < 1e-12
    assert np.abs(filters.response("mitchell:b=1,c=0", f) - np.sinc(f) ** 4).max() < 1e-12  # the cubic B-spline
    with pytest.raises(InvalidInput):
        filters.response("box", 1000.1)


def test_shapes() -> None:
    assert filters.evaluate("tent", 0.5).shape == ()
    assert filters.evaluate("tent", np.zeros((3, 0))).shape == (3, 0)
    grid = np.linspace(-1, 1, 12).reshape(3, 4)
    assert np.allclose(filters.evaluate("tent", grid.T), 1 - np.abs(grid.T), rtol=0, atol=2 * EPSILON)


def test_specs_inside_a_mode() -> None:
    for text, canonical, name in (
        ("uniform:filter=box", "uniform", "box"),
        ("uniform:filter=box,filter.radius=0.50", "uniform", "box"),
        ("uniform:filter.radius=2", "uniform:filter=box,filter.radius=2", "box:radius=2"),
        (
            "uniform:n=16,sampler=sobol,sampler.scramble=owen,filter=mitchell,filter.b=0.3333",
            "uniform:filter=mitchell,filter.b=0.3333",
            "mitchell:b=0.3333",
        ),
    ):
        mode = mode_of(embree.RENDERER, text)
        assert mode.text == canonical
        assert filter_of(mode) == name
    with pytest.raises(SpecError, match='unknown filter "mitchel"; did you mean "mitchell"'):
        mode_of(embree.RENDERER, "uniform:filter=mitchel")
    with pytest.raises(SpecError, match='filter "lanczos": unknown key "lobe"; did you mean "lobes"'):
        mode_of(embree.RENDERER, "uniform:filter=lanczos,filter.lobe=3")


# --- pictures ---------------------------------------------------------------------------------------------------------

SIZE = (21, 18)
SCENE = scene_io.load("zone-plate").scene


def radiance(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(..., 3): the scene's colour at picture positions, by its own formula; the plate reaches far past the borders."""
    pattern = SCENE.materials["rings"].pattern
    assert pattern is not None
    width, height = SIZE
    world_x, world_y = (2 * x - width) / height, 1 - 2 * y / height
    squared = (world_x - pattern.origin[0]) ** 2 + (world_y - pattern.origin[1]) ** 2
    mix = 0.5 + 0.5 * np.cos(pattern.scale * squared)[..., None]
    low, high = (np.array(colour) for colour in pattern.colours)
    made: np.ndarray = low + (high - low) * mix
    return made


def splat(spec: str, sampler: str, samples: int, seed: int) -> np.ndarray:
    """A + (1 - S) m of film.h, sample by sample, with the formulas above for weights."""
    formula, radius = FORMULAS[spec]
    width, height = SIZE
    border = int(np.ceil(radius + 0.5)) - 1
    scale = float(1 / total(spec))
    pattern = samplers.Sampler(sampler, samples, 2, seed)
    table: dict[float, float] = {}

    def weight(t: float) -> float:
        if not -radius <= t < radius:
            return 0.0
        if t not in table:
            table[t] = scale * float(formula(mpmath.mpf(abs(t))))
        return table[t]

    weighted, weights = np.zeros((height, width, 3)), np.zeros((height, width, 1))
    plain = np.zeros((height, width, 3))
    for pixel_y in range(-border, height + border):
        for pixel_x in range(-border, width + border):
            points = pattern.points(samples, 0, (pixel_x, pixel_y)) + np.array([pixel_x, pixel_y])
            for (x, y), colour in zip(points, radiance(points[:, 0], points[:, 1]), strict=True):
                columns = range(max(0, pixel_x - border), min(width, pixel_x + border + 1))
                rows = range(max(0, pixel_y - border), min(height, pixel_y + border + 1))
                if not columns or not rows:
                    continue
                across = np.array([weight(x - column - 0.5) for column in columns])
                down = np.array([weight(y - row - 0.5) for row in rows])
                both = (down[:, None] * across)[..., None]
                weighted[rows.start : rows.stop, columns.start : columns.stop] += both * colour
                weights[rows.start : rows.stop, columns.start : columns.stop] += both
                if 0 <= pixel_x < width and 0 <= pixel_y < height:
                    plain[pixel_y, pixel_x] += colour
    made: np.ndarray = (weighted + (1 - weights / samples) * plain) / samples
    return made


@pytest.mark.parametrize("spec", [spec for spec in FORMULAS if spec != "box"])
def test_pictures_equal_a_splat_of_the_same_samples(spec: str) -> None:
    drawn, cost = Tracer(SCENE, SIZE).render("sobol:scramble=owen", 2, 9, 1, spec)
    # The pattern is evaluated in double, with a phase of up to 200 radians: 1e-12; pictures are float, 1e-7.
    assert np.abs(drawn - splat(spec, "sobol:scramble=owen", 2, 9)).max() < 1e-6
    border = int(np.ceil(filters.radius(spec) + 0.5)) - 1
    assert cost.samples == 2 * (SIZE[0] + 2 * border) * (SIZE[1] + 2 * border)


@pytest.mark.parametrize("spec", FORMULAS)
def test_threads_do_not_change_a_bit(spec: str) -> None:
    built = Tracer(SCENE, (131, 75))
    one = built.render("sobol:scramble=owen", 3, 1, 1, spec)[0]
    for threads in (2, 5):
        assert np.array_equal(one, built.render("sobol:scramble=owen", 3, 1, threads, spec)[0])


def test_wide_pictures_go_through_in_bands() -> None:
    """16384 pixels wide, so that the cells of a band hold some rows of tiles alone: the middle is that of a narrower
    picture, which is one band."""
    width, height = 16384, 80
    drawn, _ = Tracer(SCENE, (width, height)).render("halton", 1, 0, 2, "lanczos")
    assert np.isfinite(drawn).all()
    narrow, _ = Tracer(SCENE, (width // 64, height)).render("halton", 1, 0, 1, "lanczos")
    left = (width - width // 64) // 2
    assert left % 16 == 0  # the same pixels share packets and tiles
    inner = drawn[:, left : left + width // 64]
    # halton is the same in every pixel. Positions with 14 bits less before the point leave 1e-10 of the phase.
    assert np.abs(inner - narrow).max() < 1e-6


def test_modes_render_with_their_filter() -> None:
    mode = "uniform:n=4,filter=mitchell"
    rendering = api.render("edge", "embree", mode)
    width, height = scene_io.load("edge").scene.view.size
    assert rendering.cost.samples == 4 * (width + 4) * (height + 4)
    assert rendering.cost.rays == {"primary": rendering.cost.samples}
    box = api.render("edge", "embree", "uniform:n=4")
    assert not np.array_equal(rendering.pixels, box.pixels)
    assert mode_of(embree.RENDERER, mode).text == "uniform:filter=mitchell,n=4"
