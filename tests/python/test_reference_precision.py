"""Converged references are finer than what they judge: a standard error below a fifth of the best mode's error. Those
of moved pictures are as fine, and of the pictures that are moved as far."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from reference_scenes import REPOSITORY, stored

from aliascope import draws, plan
from aliascope.native import tracer
from aliascope.records import Pixels
from aliascope.references import Reference, files

BEST = "sobol:scramble=owen", 256
"""Of the quick profile: no mode of any renderer takes more samples, no pattern in it errs less at 256."""
LEAST_RATIO = 5.0
SCENES = sorted(path.stem for path in (REPOSITORY / "scenes").glob("*.toml"))
MOVED = [draws.shift_of(draw) for draw in range(1, draws.MOST)]


def converged() -> list[tuple[str, str]]:
    """Scene and filter of every reference in its place that has standard errors."""
    names = sorted((REPOSITORY / "reference").glob("*/128x96-*.standard-error.exr"))
    found = [
        (path.parent.name, path.name.removeprefix("128x96-").removesuffix(".standard-error.exr")) for path in names
    ]
    return [(name, filter_) for name, filter_ in found if "@" not in filter_]


def kept(name: str, filter_: str = "box", shift: tuple[float, float] = draws.UNMOVED) -> Reference:
    of = stored(name)
    return files.load(REPOSITORY / "reference", name, of, of.view.size, filter_, shift)


@functools.cache
def least_error(name: str, filter_: str) -> float:
    """The root mean square error of the best mode's picture in its place."""
    of = stored(name)
    pixels, _ = tracer.Tracer(of, of.view.size).render(*BEST, 0, 2, filter_)
    return rms(pixels, kept(name, filter_))


def rms(pixels: Pixels, reference: Reference) -> float:
    return float(np.sqrt(((pixels.astype(np.float64) - reference.exact) ** 2).mean()))


def test_the_best_mode_is_in_the_profile() -> None:
    assert f"uniform:n={BEST[1]},sampler=sobol,sampler.scramble=owen" in plan.QUICK["embree"]
    assert len(converged()) >= 10


@pytest.mark.parametrize(("name", "filter_"), converged())
def test_standard_errors_are_below_a_fifth_of_the_least_error(name: str, filter_: str) -> None:
    reference = kept(name, filter_)
    assert reference.standard_error_rms is not None
    assert reference.standard_error_rms * LEAST_RATIO < least_error(name, filter_)


@pytest.mark.parametrize("name", SCENES)
def test_those_of_moved_pictures_are_as_fine(name: str) -> None:
    in_its_place = kept(name)
    for shift in MOVED:
        reference = kept(name, shift=shift)
        assert (reference.method, reference.provenance) == (in_its_place.method, in_its_place.provenance)
        if reference.standard_error_rms is not None:
            assert reference.standard_error_rms * LEAST_RATIO < least_error(name, "box")


@pytest.mark.parametrize("name", SCENES)
def test_they_are_of_pictures_that_are_moved_as_far(name: str) -> None:
    """Two pictures of 16 jittered samples have independent errors without a bias. So their distances from the reference
    are, in the mean square, what half the square of their distance from each other is, but for the errors' correlation:
    a few percent, and up to a quarter in `cornell-box`, where ten pixels at the lamp's rim have half of the mean square
    (0.22 here with 16 samples, -0.09 with 64). The other references lie farther."""
    of = stored(name)
    references = [kept(name), *(kept(name, shift=shift) for shift in MOVED)]
    for number, shift in enumerate(MOVED, 1):
        drawn = tracer.Tracer(of, of.view.size, shift)
        one, other = (drawn.render("jittered", 16, seed, 2)[0] for seed in (1, 2))
        noise = float(np.sqrt(((one - other).astype(np.float64) ** 2).mean() / 2))
        errors = [float(np.hypot(rms(one, each), rms(other, each)) / np.sqrt(2.0)) for each in references]
        assert errors[number] == pytest.approx(noise, rel=0.15)
        assert min(errors[:number] + errors[number + 1 :]) > 1.5 * errors[number]
