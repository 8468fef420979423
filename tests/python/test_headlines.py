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
    assert second == (
        "In the tracer the error falls with the samples a pixel as (fit ± standard error): N^-0.500 ± <0.001 (random)."
    )


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
    assert "mean over 2 scenes" in headlines(scenes)[1]
    assert "mean over" not in headlines([scenes[0], filtered])[1]


def power_law(family: str, exponent: float) -> list[ModeRow]:
    return [row("embree", family, n, 0.05 * n**exponent, 1e-3 * n) for n in (4, 16, 64)]


def test_an_exponent_has_the_standard_error_of_its_fit_or_over_scenes() -> None:
    # ln e = 0, -1.4, -1.6 at ln n = 0, ln 4, ln 16: slope -0.8 / ln 4, residuals 0.2, -0.4, 0.2 and one degree of
    # freedom, so a standard error of sqrt(0.24 / 2) / ln 4 = 0.2499.
    rows = [row("embree", "uniform u", n, float(np.exp(e)), n) for n, e in ((1, 0.0), (4, -1.4), (16, -1.6))]
    text = headlines([section("one", *rows)])[-1]
    assert text.endswith("as (fit ± standard error): N^-0.58 ± 0.25 (u).")
    # -0.5, -0.6, -0.7: a standard deviation of 0.1, over sqrt(3).
    scenes = [section(f"{e}", *power_law("uniform u", e), *power_law("uniform v", -1.0)) for e in (-0.5, -0.6, -0.7)]
    assert headlines(scenes)[-1].endswith(
        "as (mean over 3 scenes ± standard error): N^-1.000 ± <0.001 (v); N^-0.60 ± 0.06 (u)."
    )
    lacking = section("more", *power_law("uniform u", -0.6))
    assert "(mean over 3 to 4 scenes ± standard error)" in headlines([*scenes, lacking])[-1]


def timed(label: str, seconds: float, error: float | None, rmse: Estimate | None = None) -> ModeRow:
    mode = replace(row("embree", label, 16, 0.1, 0.0), cpu_seconds=Estimate(seconds, error))
    return replace(mode, metrics={"rmse": rmse}) if rmse else mode


def test_what_cannot_be_told_from_the_best_is_named() -> None:
    """Within two standard errors of the difference: sqrt(3^2 + 4^2) = 5 here, so up to 10 above 100."""
    best = timed("a", 0.100, 0.003)

    def told(*others: ModeRow) -> str:
        return headlines([section("one", best, *others)])[0].partition("the scene one: ")[2]

    assert told(timed("b", 0.1099, 0.004)) == "embree 0.1 ± 0.003 s (a, n=16; b, n=16 within its uncertainty)."
    assert told(timed("b", 0.1101, 0.004)) == "embree 0.1 ± 0.003 s (a, n=16)."
    more = told(timed("b", 0.109, 0.004), timed("c", 0.101, None), timed("d", 0.108, 0.004), timed("e", 0.107, None))
    assert more == "embree 0.1 ± 0.003 s (a, n=16; c, n=16 and 2 more within its uncertainty)."
    # Of modes that cannot, the errors are compared; what is not known counts as none.
    first, second = (
        replace(timed(name, 1.0, None, rmse), renderer="povray")
        for name, rmse in (("f", Estimate(0.3, 0.01)), ("g", Estimate(0.31)))
    )
    assert told(first, second).endswith(
        "povray cannot (its best is 0.3 ± 0.01, f, n=16; g, n=16 within its uncertainty)."
    )
    assert "uncertainty" not in told(replace(first, metrics={"rmse": Estimate(0.3)}), second)


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
