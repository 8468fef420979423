"""The tracer's options as keys of modes: what a packet's width, its switches and a float film change."""

from __future__ import annotations

import numpy as np
import pytest

from aliascope import api, scene_io
from aliascope.errors import InvalidInput, SpecError
from aliascope.native.tracer import Options, Tracer
from aliascope.placement import moved
from aliascope.renderers import embree, mode_of
from aliascope.specs import family, label
from aliascope.stability.geometry_scenes import aimed_at

SIZE = (64, 48)


def render(mode: str, scene: str) -> np.ndarray:
    return api.render(scene, "embree", mode, size=SIZE, seed=5).pixels


def test_defaults_leave_specs_and_labels_as_they_were() -> None:
    spec = mode_of(embree.RENDERER, "uniform:n=64,packet=16,robust=on,relative=on,again=on,film=double")
    assert spec.text == "uniform:n=64"
    assert (family(spec), label(spec)) == ("uniform sobol:scramble=owen", "uniform sobol:scramble=owen, n=64")
    assert mode_of(embree.RENDERER, "adaptive:packet=16,robust=on,relative=on,again=on").text == "adaptive"


def test_each_option_is_a_family_of_its_own() -> None:
    spec = mode_of(embree.RENDERER, "uniform:robust=off,again=off,n=16,packet=4,film=float,relative=off")
    assert spec.text == "uniform:again=off,film=float,packet=4,relative=off,robust=off"
    assert family(spec) == "uniform sobol:scramble=owen packet=4 robust=off relative=off again=off film=float"


@pytest.mark.parametrize(
    "mode",
    [
        "uniform:packet=2",
        "uniform:packet=on",
        "uniform:robust=1",
        "uniform:film=half",
        "adaptive:film=float",
        "uniform:again=1",
    ],
)
def test_options_that_there_are_not_are_refused(mode: str) -> None:
    with pytest.raises(SpecError):
        mode_of(embree.RENDERER, mode)


def test_the_library_refuses_them_too() -> None:
    with pytest.raises(InvalidInput, match="packets of 3 rays"):
        Tracer(scene_io.load("edge").scene, SIZE, options=Options(packet=3))


def test_modes_become_options() -> None:
    for mode, options in (
        ("uniform", Options()),
        ("uniform:packet=4,robust=off,film=float", Options(4, False, "float")),
        ("uniform:film=compensated", Options(film="compensated")),
        ("adaptive:packet=1,robust=off", Options(1, False)),
        ("uniform:relative=off", Options(relative=False)),
        ("adaptive:again=off", Options(again=False)),
    ):
        assert embree._options(mode_of(embree.RENDERER, mode)) == options


def test_options_reach_the_kernel() -> None:
    for packet in (1, 4, 8, 16):
        for robust in (True, False):
            kernel = Tracer(scene_io.load("edge").scene, SIZE, options=Options(packet, robust)).kernel
            assert (kernel.packet, kernel.robust) == (packet, robust)


def test_switches_reach_the_tracer() -> None:
    """Far from the origin the one, for rays through corners the other: those that are lost are black."""
    home = scene_io.load("edge").scene
    far = moved(home, (1e9, 1e9, 1e9))
    here, there, lost_there = (
        Tracer(scene, SIZE, options=Options(relative=on)).render("regular", 1)[0]
        for scene, on in ((home, True), (far, True), (far, False))
    )
    assert np.array_equal(here, there)
    assert np.abs(here - lost_there).mean() > 0.1
    aimed = aimed_at(32)
    lost = [
        int((Tracer(aimed, (64, 64), options=Options(again=on)).render("regular", 1)[0] == 0.0).all(axis=2).sum())
        for on in (True, False)
    ]
    assert lost[0] == 0 < lost[1]


@pytest.mark.parametrize("form", ["uniform:n=16", "adaptive:n=64"])
def test_packets_and_the_robust_mode_differ_at_edges_alone(form: str) -> None:
    """On 3,072 pixels of 16 samples or more only those count that lie within 2^-20 or so of one of some hundred pixels
    of edges: none is to be expected, and one sample changes one value by up to 1/16 in three channels. Everywhere else
    values are the same to float32."""
    plain = render(form, "spheres")
    for option in ("packet=1", "packet=4", "packet=8", "robust=off", "relative=off", "again=off"):
        apart = np.abs(render(f"{form},{option}", "spheres") - plain).max(axis=2)
        assert (apart > 1e-5).sum() <= 2, option


def test_a_float_film_differs_in_last_bits() -> None:
    """64 numbers that are not negative: off by at most 63 * 2^-24 of their sum (Higham 2002, section 4.2), the rounding
    of the mean to float32 beside it; with mitchell, whose weights' magnitudes add up to less than 1.7, 25 pixels."""
    for mode, bound in (
        ("uniform:n=64", 64 * 2.0**-24),
        ("uniform:n=64,filter=mitchell", 1.7 * 25 * 64 * 2.0**-24),
    ):
        double, single = render(mode, "spheres"), render(f"{mode},film=float", "spheres")
        assert not np.array_equal(double, single)
        largest = float(double.max())
        scale = double if mode == "uniform:n=64" else np.full_like(double, largest)
        assert (np.abs(single - double) <= bound * scale).all()


def test_a_compensated_film_is_as_near_as_double() -> None:
    """Each sample is rounded to float, and the mean: 2 * 2^-24, and as much again of what the double's mean is; no more
    with more samples."""
    for n in (64, 4096):
        double, kept = render(f"uniform:n={n}", "spheres"), render(f"uniform:n={n},film=compensated", "spheres")
        assert (np.abs(kept - double) <= 3 * 2.0**-24 * double).all()
    double, kept = (render(f"uniform:n=64,filter=mitchell{film}", "spheres") for film in ("", ",film=compensated"))
    assert (np.abs(kept - double) <= 1.7 * 3 * 2.0**-24 * float(double.max())).all()


@pytest.mark.parametrize("film", ["float", "compensated"])
def test_one_sample_is_the_same_in_any_film(film: str) -> None:
    assert np.array_equal(render("uniform:n=1", "spheres"), render(f"uniform:n=1,film={film}", "spheres"))
