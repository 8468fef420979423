"""Knobs: pairs of modes that differ in one key alone, and what baseline each has."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aliascope import renderers
from aliascope.records import Estimate, ModeRow, SceneSection
from aliascope.renderers import embree, mode_of
from aliascope.specs import family, settings
from aliascope.trade import analyse
from aliascope.trade.records import Knob

PIXELS = np.zeros((1, 1, 3), np.float32)


def row(mode: str, seconds: float, rmse: float, renderer: str = "embree") -> ModeRow:
    """Of three draws that scatter by some percent."""
    spec = mode_of(renderers.find(renderer), mode)
    return ModeRow(
        renderer=renderer,
        mode=spec.text,
        label=spec.text,
        family=family(spec),
        samples_per_pixel=16.0,
        cpu_seconds=Estimate(seconds),
        metrics={"rmse": Estimate(rmse, 0.01 * rmse)},
        pictures=3,
        pixels=PIXELS,
        seconds=(0.97 * seconds, seconds, 1.02 * seconds),
        draws={"rmse": (0.98 * rmse, rmse, 1.02 * rmse)},
        settings=settings(spec),
    )


def section(name: str, *rows: ModeRow, filter_: str = "box") -> SceneSection:
    shown = name if filter_ == "box" else f"{name}, {filter_}"
    return SceneSection(shown, "", "", PIXELS, "", rows, (), filter_)


def knobs(*sections: SceneSection) -> dict[tuple[str, str, str, str], Knob]:
    return {(knob.form, knob.knob, knob.setting, knob.baseline): knob for knob in analyse(sections).knobs}


def test_a_key_is_turned_from_its_default_with_all_others_alike() -> None:
    found = knobs(
        section("a", row("uniform:n=64", 1.0, 0.1), row("uniform:n=64,packet=4", 2.0, 0.1)),
        section("b", row("uniform:n=64", 3.0, 0.4), row("uniform:n=64,packet=4", 24.0, 0.1)),
    )
    assert set(found) == {("uniform", "packet", "4", "16")}
    knob = found["uniform", "packet", "4", "16"]
    assert (knob.pairs, knob.scenes) == (2, ("a", "b"))
    assert knob.time.value == pytest.approx(math.sqrt(2.0 * 8.0))
    assert knob.error.value == pytest.approx(math.sqrt(1.0 * 0.25))
    assert knob.time.low is not None
    assert knob.time.low < knob.time.value < (knob.time.high or 0.0)


def test_modes_that_differ_in_two_keys_are_no_pair() -> None:
    assert not knobs(section("a", row("uniform:n=64", 1.0, 0.1), row("uniform:n=16,packet=4", 2.0, 0.1)))


def test_the_hash_of_owen_is_the_baseline_of_full_owen() -> None:
    """The default pattern is what its keys are turned from, not what its keys' own defaults make."""
    found = knobs(
        section(
            "a",
            row("uniform:n=64", 1.0, 0.1),
            row("uniform:n=64,sampler=sobol", 0.9, 0.2),
            row("uniform:n=64,sampler=sobol,sampler.scramble=owen-full", 2.0, 0.1),
        )
    )
    assert set(found) == {
        ("uniform, sobol", "sampler.scramble", "none", "owen"),
        ("uniform, sobol", "sampler.scramble", "owen-full", "owen"),
    }
    full = found["uniform, sobol", "sampler.scramble", "owen-full", "owen"]
    assert full.time.value == pytest.approx(2.0)
    assert full.error.value == pytest.approx(1.0)


def test_what_a_mode_leaves_out_comes_before_what_its_inner_spec_does() -> None:
    """Whatever the order of the settings."""
    for own, inner in (("1", "2"), ("2", "1")):
        left_out = replace(row("uniform", 1.0, 0.1), settings={"sampler": "s", "sampler.k": own})
        plain = replace(
            row("uniform", 2.0, 0.1), mode="uniform:sampler=s", settings={"sampler": "s", "sampler.k": inner}
        )
        assert set(knobs(section("a", left_out, plain))) == {("uniform, s", "sampler.k", inner, own)}


def test_keys_of_two_inner_specs_are_two_knobs() -> None:
    """Of kajiya a pixel has 4 samples at first, of student-t 8."""
    found = knobs(
        section(
            "a",
            row("adaptive:n=64", 1.0, 0.1),
            row("adaptive:n=64,method.minimum=8", 2.0, 0.1),
            row("adaptive:n=64,method=student-t", 3.0, 0.1),
            row("adaptive:n=64,method=student-t,method.minimum=4", 4.0, 0.1),
        )
    )
    assert set(found) == {
        ("adaptive", "method", "student-t", "kajiya"),
        ("adaptive, kajiya", "method.minimum", "8", "4"),
        ("adaptive, student-t", "method.minimum", "4", "8"),
    }


def test_filters_are_turned_over_their_sections() -> None:
    found = knobs(
        section("a", row("uniform:n=64", 1.0, 0.1)),
        section("a", row("uniform:n=64,filter=tent", 2.0, 0.05), filter_="tent"),
        section("a", row("uniform:n=64,filter=tent,filter.radius=2", 4.0, 0.01), filter_="tent:radius=2"),
    )
    assert set(found) == {("uniform", "filter", "tent", "box"), ("uniform, tent", "filter.radius", "2", "1")}
    assert found["uniform, tent", "filter.radius", "2", "1"].error.value == pytest.approx(0.2)


def test_forms_of_the_same_keys_are_a_knob_too() -> None:
    found = knobs(section("a", row("am1", 1.0, 0.1, "povray"), row("am2", 2.0, 0.05, "povray")))
    assert set(found) == {("am1, am2", "method", "am2", "am1")}


def test_every_option_of_the_tracer_is_a_key() -> None:
    assert {"packet", "robust", "relative", "again", "film"} <= set(settings(mode_of(embree.RENDERER, "uniform")))
