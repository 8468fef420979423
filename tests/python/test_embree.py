"""The tracer as a renderer: where its pixels are, and at which rate its error falls."""

from __future__ import annotations

import numpy as np
import pytest

from aliascope import api, places, references, scene_io
from aliascope.native import samplers
from aliascope.references import files as reference_files
from aliascope.renderers import embree, mode_of
from aliascope.statistics import rate

SEEDS = 16


def render(mode: str, seed: int, scene: str = "edge") -> np.ndarray:
    return api.render(scene, "embree", mode, seed=seed).pixels


def crossed() -> tuple[np.ndarray, np.ndarray]:
    """The reference of `edge`, and which of its pixels an edge crosses: those that hold more than one surface."""
    file = scene_io.load("edge")
    exact = references.make(file.scene, file.scene.view.size).exact
    flat = [np.array(file.scene.view.background)]
    flat += [np.array(material.emission) for material in file.scene.materials.values()]
    plain = np.zeros(exact.shape[:2], bool)
    for colour in flat:
        plain |= np.abs(exact - colour).max(axis=2) < 1e-9
    return exact, ~plain


def rmse_over_edges(sampler: str, count: int) -> float:
    exact, mask = crossed()
    squares = [(render(f"uniform:n={count},sampler={sampler}", seed)[mask] - exact[mask]) ** 2 for seed in range(SEEDS)]
    return float(np.sqrt(np.mean(squares)))


def test_owen_scrambled_sobol_reaches_its_accuracy_and_rate() -> None:
    counts = [4, 16, 64, 256]
    errors = [rmse_over_edges("sobol,sampler.scramble=owen", count) for count in counts]
    assert errors[-1] < 0.006
    fit = rate(counts, errors)
    assert fit is not None
    assert -1.1 < fit.exponent < -0.7


def test_random_sampling_falls_as_the_root() -> None:
    counts = [4, 16, 64, 256]
    fit = rate(counts, [rmse_over_edges("random", count) for count in counts])
    assert fit is not None
    # Some 400 pixels of 3 correlated channels, 16 seeds: each error to 1 / sqrt(2 * 6400) = 0.9 %, over a range of
    # log 64 the exponent to about 0.005; four of those.
    assert fit.exponent == pytest.approx(-0.5, abs=0.02)


def test_the_seed_matters_only_where_the_pattern_has_one() -> None:
    assert not np.array_equal(render("uniform:n=4", 1), render("uniform:n=4", 2))
    assert np.array_equal(render("uniform:n=4,sampler=halton", 1), render("uniform:n=4,sampler=halton", 2))
    for mode, seeded in (("uniform:n=4", True), ("uniform:n=4,sampler=halton", False)):
        assert embree.RENDERER.seeded(mode_of(embree.RENDERER, mode)) is seeded


def test_every_planar_sampler_renders() -> None:
    counts = {
        info.name: [n for n in (16, 8, 21) if not samplers.refusal(info.name, n)] for info in samplers.registered()
    }
    assert {name for name, able in counts.items() if not able} == {"cook", "pan-diagonal", "mitchell-spacetime"}
    for name, able in counts.items():
        if able:
            assert np.isfinite(render(f"uniform:n={able[0]},sampler={name}", 0, "discs")).all()


def test_repeats_add_up_to_a_tenth_of_a_second() -> None:
    cost = api.render("edge", "embree", "uniform:n=1", least_seconds=0.1).cost
    assert cost.repeats > 1
    assert cost.cpu_seconds * cost.repeats >= 0.1
    assert cost.samples == 128 * 96
    assert cost.rays == {"primary": 128 * 96}


def rmse_where_smooth(mode: str, filter_: str) -> float:
    """Of `zone-plate` round its centre, where a pixel holds a small part of a wave."""
    file = scene_io.load("zone-plate")
    reference = reference_files.load(places.REFERENCES, "zone-plate", file.scene, file.scene.view.size, filter_)
    centre = np.s_[30:66, 46:82]
    return float(np.sqrt(np.mean((render(mode, 0, "zone-plate")[centre] - reference.pixels[centre]) ** 2)))


def test_the_weights_of_a_quadrature_rule_count() -> None:
    """Gauss's 4 x 4 points are exact for polynomials to degree 7, a smooth pattern to float's precision (3e-8); with
    equal weights they would be worse than the regular grid's."""
    assert rmse_where_smooth("uniform:n=16,sampler=gauss-legendre", "box") < 2e-7
    assert rmse_where_smooth("uniform:n=16,sampler=regular", "box") > 1e-4


def test_weights_count_under_wide_filters() -> None:
    # The filter has kinks within a pixel, so a rule is no better than a grid of cells; 5e-5 is the reference's own.
    assert rmse_where_smooth("uniform:n=64,sampler=gauss-legendre,filter=mitchell", "mitchell") < 1e-3
