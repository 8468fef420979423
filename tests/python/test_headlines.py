"""The sentences at the top of the report: computed, and right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aliascope.records import Estimate, ModeRow, SceneSection
from aliascope.studies.headlines import headlines

PIXELS = np.zeros((2, 2, 3), np.float32)


def row(renderer: str, family: str, count: int, rmse: float, seconds: float) -> ModeRow:
    return ModeRow(
        renderer=renderer,
        mode=f"{family}:n={count}",
        label=f"{family}, n={count}",
        family=family,
        samples_per_pixel=count,
        cpu_seconds=Estimate(seconds),
        metrics={"rmse": Estimate(rmse, 0.0)},
        pictures=1,
        pixels=PIXELS,
    )


def section(name: str, *rows: ModeRow) -> SceneSection:
    return SceneSection(name, name, "", PIXELS, "exact", rows)


def tracer(scale: float) -> list[ModeRow]:
    return [row("embree", "uniform random", n, scale * n**-0.5, 1e-3 * n) for n in (4, 16, 64)]


def test_the_fastest_that_reaches_the_target_is_named_and_who_cannot() -> None:
    scene = section("one", *tracer(0.05), row("povray", "am1", 3, 0.009, 2.5), row("osmesa", "msaa", 4, 0.034, 0.001))
    first, second = headlines([scene])
    assert first == (
        "CPU time a picture to reach an RMSE of 0.01 over the scene one: embree 64 ms (uniform random, n=64); "
        "povray 2.5 s (am1, n=3); osmesa cannot (its best is 0.034, msaa, n=4)."
    )
    assert second == "In the tracer the error falls with the samples a pixel as: N^-0.50 (random)."


def test_scenes_are_joined_by_the_mean_square_and_only_those_that_all_drew_count() -> None:
    both = [row("povray", "am1", 3, error, 1.0) for error in (0.002, 0.016)]  # root of the mean square: 0.0114
    scenes = [
        section("a", *tracer(0.1), both[0]),
        section("b", *tracer(0.1), both[1]),
        section("c", row("embree", "uniform random", 64, 0.5, 1.0)),
    ]
    (first, *_) = headlines(scenes)
    assert first.startswith("CPU time a picture to reach an RMSE of 0.02 over 2 scenes: embree 64 ms")
    assert "povray 1 s (am1, n=3)" in first


def test_a_scene_under_another_filter_is_no_scene_more() -> None:
    scenes = [section("a", *tracer(0.05)), section("b", *tracer(0.05))]
    rows = [replace(mode, family="uniform random mitchell") for mode in tracer(0.5)]
    filtered = replace(section("a, mitchell", *rows), filter="mitchell")
    assert headlines([*scenes, filtered]) == headlines(scenes)
    assert len(headlines(scenes)) == 2
    assert "mean over scenes" not in headlines([scenes[0], filtered])[1]


def test_figures_have_their_uncertainty() -> None:
    fast = replace(row("embree", "u", 16, 0.1, 0.0), cpu_seconds=Estimate(0.00212, 0.00031))
    slow = replace(row("povray", "am1", 3, 0.3, 123.4), metrics={"rmse": Estimate(0.3, 0.012)})
    (first, *_) = headlines([section("one", fast, slow)])
    assert first.endswith("embree 2.1 ± 0.3 ms (u, n=16); povray cannot (its best is 0.3 ± 0.01, am1, n=3).")
    (first, *_) = headlines([section("one", replace(slow, cpu_seconds=Estimate(123.4, 2.0)), row("a", "b", 1, 0.2, 1))])
    assert "a 1 s (b, n=1)" in first
    assert "povray cannot" in first
    (first, *_) = headlines([section("one", row("povray", "am1", 3, 0.1, 123.4))])
    assert "povray 123 s" in first


def test_no_time_of_zero_is_named() -> None:
    scene = section("one", row("embree", "uniform random", 16, 0.1, 2e-3), row("povray", "none", 1, 0.15, 0.0))
    assert headlines([scene])[0] == (
        "CPU time a picture to reach an RMSE of 0.1 over the scene one: embree 2 ms (uniform random, n=16); "
        "povray cannot (its best is 0.15, none, n=1)."
    )
    (first, *_) = headlines([section("one", row("embree", "u", 16, 0.2, 2e-3), row("povray", "none", 1, 0.15, 0.0))])
    assert first.endswith("embree 2 ms (u, n=16); povray less time than it can tell (none, n=1).")


def test_nothing_is_said_of_nothing() -> None:
    assert headlines([]) == ()
    assert headlines([section("a", row("osmesa", "none", 1, 0.9, 1.0))]) == ()
