"""The trade of speed for accuracy: fronts, times to errors, rates, ratios, knobs, and what is not known of them."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate, optimize, special, stats
from trade_rows import drawn, row, section

from aliascope.records import Estimate, ModeRow, SceneSection
from aliascope.trade import QUANTISATION, Trade, analyse, words
from aliascope.trade.front import undominated
from aliascope.trade.reach import crossing, families, to_error
from aliascope.trade.records import Interval, SceneTrade
from aliascope.trade.targets import few, series
from aliascope.trade.uncertainty import DRAWS, points, pooled, satterthwaite, student, trigamma_inverse

DRAWN = 4.0 / math.sqrt(DRAWS) * 0.5
"""Four standard errors of a probability from so many draws, at most."""

LOGS = st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), min_size=1, max_size=7)
"""Modes with few times and errors, so that some are equal."""


def exact(family: str, points: Sequence[tuple[int, float, float]], renderer: str = "embree") -> list[ModeRow]:
    """Modes (count, seconds, RMSE) with draws that do not differ."""
    return [row(family, n, [seconds] * 3, [error] * 3, renderer) for n, seconds, error in points]


def power(family: str, constant: float, exponent: float, seconds: float, renderer: str = "embree") -> list[ModeRow]:
    """A family that follows a power law in the number of its samples."""
    return exact(family, [(n, seconds * n, constant * n**exponent) for n in (4, 16, 64)], renderer)


def scene_of(rows: Sequence[ModeRow], name: str = "one") -> SceneTrade:
    (scene,) = analyse([section(name, rows)]).scenes
    return scene


# The front


@given(LOGS)
def test_the_front_is_that_of_its_definition(modes: list[tuple[int, int]]) -> None:
    times, errors = np.array(modes, dtype=np.float64).T[:, :, None]
    expected = [
        not any(t <= time and e <= error and (t < time or e < error) for t, e in modes) for time, error in modes
    ]
    assert undominated(times, errors)[:, 0].tolist() == expected


def test_the_front_over_scenes_is_that_of_their_means() -> None:
    """By hand: b is the slowest on both scenes and best on one alone; over both its mean square is the least. d, which
    one scene lacks, is not among them."""
    first = exact("a", [(1, 1.0, 0.3)]) + exact("b", [(1, 4.0, 0.1)]) + exact("c", [(1, 2.0, 0.4)])
    second = exact("a", [(1, 1.0, 0.3)]) + exact("b", [(1, 4.0, 0.25)]) + exact("c", [(1, 2.0, 0.2)])
    second += exact("d", [(1, 0.5, 0.01)])
    scenes = [section("one", first), section("two", second)]
    found = analyse(scenes, together=["one", "two"]).front
    # Root mean squares: a 0.3, b 0.19, c 0.32; so c is slower and worse than a.
    assert {each.mode: each.probability for each in found} == {
        first[0].mode: 1.0,
        first[1].mode: 1.0,
        first[2].mode: 0.0,
    }
    assert found[0].mode == first[0].mode  # the faster one first
    assert {each.mode for each in analyse(scenes, together=["two"]).front} == {each.mode for each in second}
    assert analyse(scenes).front == ()


def test_a_spread_known_from_two_wild_draws_overflows_nowhere() -> None:
    """Student's t of one degree of freedom has draws that, as exponents, are beyond doubles."""
    rows = [row("a", 4, [1e-9, 1e9], [1e-200, 1.0]), row("a", 8, [1e-9, 1e9], [1e-200, 1.0])]
    scenes = [section(name, rows) for name in ("one", "two")]
    assert all(0.0 <= each.probability <= 1.0 for each in analyse(scenes, together=["one", "two"]).front)


def test_the_probability_is_that_of_the_slower_one_being_faster() -> None:
    slow, fast = (
        replace(found, cpu_seconds=Estimate(value, interval=(value / 1.1, value * 1.1)))
        for found, value in zip(exact("uniform a", [(4, 1.0, 0.02), (5, 1.0, 0.01)]), (1.0, 1.05), strict=True)
    )
    front = {each.mode: each.probability for each in scene_of([slow, fast]).front}
    # The better one is always on it; the other one where it takes less.
    sigma = math.log(1.1) / stats.norm.ppf(0.975) * math.sqrt(2.0)
    assert front[fast.mode] == 1.0
    assert front[slow.mode] == pytest.approx(stats.norm.cdf(math.log(1.05) / sigma), abs=DRAWN)


def test_of_a_mode_without_any_spread_the_probability_is_not_known() -> None:
    bare, timed = row("uniform a", 4, [1.0], [0.02]), row("uniform a", 5, [2.0], [0.01])
    timed = replace(timed, cpu_seconds=Estimate(2.0, interval=(1.9, 2.1)))
    assert {each.mode: each.known for each in scene_of([bare, timed]).front} == {bare.mode: False, timed.mode: True}


def test_the_probability_with_times_and_errors_unsure_is_the_integral() -> None:
    # Both spreads are Student's with 30 degrees of freedom: two modes, 16 draws each, in one group.
    wave = np.resize([-1.0, 1.0], 16)
    a = row("uniform a", 4, np.exp(0.2 * wave).tolist(), (0.01 * np.exp(0.3 * wave)).tolist())
    b = row("uniform a", 5, (1.1 * np.exp(0.2 * wave)).tolist(), (0.0105 * np.exp(0.3 * wave)).tolist())
    (found,) = points([section("one", [a, b])])
    (time, error), (dof, same) = (
        (found.time_spread.standard_error[0], found.error_spread.standard_error[0]),
        (found.time_spread.freedom[0], found.error_spread.freedom[0]),
    )
    assert dof == same

    def slower(difference: float, scale: float) -> float:
        """That the second lies above the first, of which it is told that it does by `difference`."""
        inside = integrate.quad(
            lambda x: stats.t.pdf(x, dof) * stats.t.cdf(x + difference / scale, dof), -40.0, 40.0, limit=200
        )
        return float(inside[0])

    both = slower(found.time[1] - found.time[0], time) * slower(found.error[1] - found.error[0], error)
    front = {each.mode: each.probability for each in scene_of([a, b]).front}
    assert front[b.mode] == pytest.approx(1.0 - both, abs=DRAWN)


def test_what_the_reference_adds_moves_all_errors_together() -> None:
    modes = [
        row("uniform a", 4, [1.0] * 3, [0.0100] * 3, reference=0.002),
        row("uniform a", 5, [2.0] * 3, [0.0099] * 3, reference=0.00198),
    ]
    (found,) = points([section("one", modes)])
    assert found.shared == pytest.approx([0.2, 0.2])
    scene = scene_of(modes)
    assert all(each.probability == 1.0 for each in scene.front)
    for each in scene.efficiency:  # of MSE: twice the logarithm; the ends are quantiles of so many draws
        assert each.value.high == pytest.approx(each.value.value * math.exp(2.0 * 1.96 * 0.2), rel=0.1)


# Equal error, equal time


@given(LOGS, st.integers(-1, 13))
def test_a_time_to_an_error_is_on_the_lower_left_envelope(modes: list[tuple[int, int]], half: int) -> None:
    target = half / 2.0
    good = [(t, e) for t, e in sorted(modes) if not any(a <= t and b <= e and (a, b) != (t, e) for a, b in modes)]
    times, errors = np.array(sorted(set(good)), dtype=np.float64).T
    expected = math.inf if target < errors[-1] else float(np.interp(-target, -errors, times))
    along, across = np.array(sorted(modes), dtype=np.float64).T[:, :, None]
    assert crossing(along, across, target)[0] == pytest.approx(expected, abs=1e-12)


def test_between_modes_along_the_line_in_logarithms_and_the_mode_reaches_it() -> None:
    found = {reach.error: reach for reach in scene_of(power("uniform a", 0.1, -0.5, 1e-3)).equal_error}
    assert set(found) == {0.02}
    reach = found[0.02]
    assert (reach.how, reach.mode, reach.best) == ("between", "uniform:sampler=a:n=64", pytest.approx(0.0125))
    assert reach.seconds == Interval(*[pytest.approx(0.025)] * 3)


def test_times_go_the_other_way() -> None:
    found = {afford.seconds: afford for afford in scene_of(power("uniform a", 0.1, -0.5, 1e-3)).equal_time}
    afford = found[0.01]
    assert (afford.how, afford.mode, afford.fastest) == ("between", "uniform:sampler=a:n=4", pytest.approx(0.004))
    assert afford.error == Interval(*[pytest.approx(0.1 * 10.0**-0.5)] * 3)


def test_a_rate_that_is_known_is_followed_to_the_quantisation_and_no_further() -> None:
    modes = power("uniform a", 0.1, -0.5, 1e-3) + exact("uniform b", [(1, 100.0, 1e-4), (2, 200.0, 5e-5)])
    scene = scene_of(modes)
    (one,) = (reach for reach in scene.quantisation if reach.family == "uniform a")
    assert one.how == "extrapolated"
    assert one.seconds is not None
    assert one.seconds.value == pytest.approx(1e-3 * (0.1 / QUANTISATION) ** 2)
    reaches = {each.error: each for each in scene.equal_error if each.family == "uniform a"}
    affords = {each.seconds: each for each in scene.equal_time if each.family == "uniform a"}
    assert all((each.how == "cannot") == (error < QUANTISATION) for error, each in reaches.items() if error < 0.0125)
    assert affords[100.0].error == Interval(*[pytest.approx(QUANTISATION)] * 3)


def test_a_rate_and_the_mode_that_it_goes_on_from_are_unsure_together() -> None:
    wave = np.array([-0.1, 0.0, 0.1])
    modes = [
        row("uniform a", n, (n * np.exp(wave)).tolist(), (0.1 * n**-0.5 * np.exp(wave)).tolist())
        for n in (4, 16, 64, 256)
    ]
    (found,) = points([section("one", modes)])
    (family,) = families(found)
    assert to_error(family, QUANTISATION).how == "extrapolated"
    assert to_error(family, 0.99 * QUANTISATION).how == "cannot"
    answer = to_error(family, 0.003)
    assert answer.how == "extrapolated"
    assert answer.figures is not None
    errors, times = found.errors[family.own], found.times[family.own]
    # Nothing scatters about the line, so the fit anew to each draw says it all.
    slopes = np.polyfit(np.log([4, 16, 64, 256]), errors, 1)[0]
    np.testing.assert_allclose(answer.figures[1:], times[-1] + (math.log(0.003) - errors[-1]) / slopes)


def test_what_flattens_out_or_is_alone_cannot_and_says_its_best() -> None:
    flat = exact("uniform a", [(4**k, 1e-3 * 4**k, 0.02 + 0.1 * 4.0**-k) for k in range(5)])
    alone = exact("none", [(1, 1e-4, 0.1)], "osmesa")
    scene = scene_of(flat + alone)
    assert [(reach.how, reach.seconds) for reach in scene.quantisation] == [("cannot", None)] * 2
    assert [reach.best for reach in scene.quantisation] == [pytest.approx(0.02 + 0.1 / 256), pytest.approx(0.1)]
    # With time enough it has the best that it has.
    last = [afford for afford in scene.equal_time if afford.family == "uniform a"][-1]
    assert last.how in ("between", "measured")


def test_a_rate_that_bends_is_not_followed() -> None:
    bent = [(n, 1e-3 * n, 0.1 * math.exp(-0.8 * math.log(n) + 0.04 * math.log(n) ** 2)) for n in (1, 4, 16, 64, 256)]
    scene = scene_of(exact("uniform a", bent))
    assert [(found.curved, reach.how) for found, reach in zip(scene.convergence, scene.quantisation, strict=True)] == [
        (True, "cannot")
    ]


def test_an_error_of_zero_is_reached_by_its_mode_alone() -> None:
    modes = exact("uniform a", [(4, 1.0, 0.05), (16, 5.0, 0.0)]) + exact(
        "uniform b", [(4, 3.0, 0.02), (16, 9.0, 0.001)]
    )
    scene = scene_of(modes)
    found = {reach.error: reach for reach in scene.equal_error if reach.family == "uniform a"}
    assert found[0.01].seconds == Interval(*[pytest.approx(5.0)] * 3)
    assert found[0.01].mode == "uniform:sampler=a:n=16"
    json.dumps(words.document(analyse([section("one", modes)])), allow_nan=False)


def test_targets_are_round_and_tell_something() -> None:
    assert series(0.009, 0.2) == [0.01, 0.02, 0.05, 0.1, 0.2]
    assert few([1.0] * 9) == [0, 2, 4, 6, 8]
    scene = scene_of(power("uniform a", 0.1, -0.5, 1e-3) + power("uniform b", 0.19, -0.5, 1e-3))
    # From the error that both reach, 0.024, to the one that one of them reaches by its fastest mode alone, 0.095.
    assert {reach.error for reach in scene.equal_error} == {0.05}
    # From the shortest time of both, 0.004, to the longest, 0.064.
    assert {afford.seconds for afford in scene.equal_time} == {0.005, 0.01, 0.02, 0.05}


# What is not known


def test_spreads_are_pooled_as_much_as_they_are_alike() -> None:
    random = np.random.default_rng(1)
    for alike in (4.0, 20.0):
        # Variances from the prior itself: scaled inverse chi-squared, of which a thousand tell what it is.
        true = 0.01 * alike / random.chisquare(alike, 1000)
        logs = [math.sqrt(each) * random.standard_normal(5) for each in true]
        variance, freedom = pooled([own.tolist() for own in logs], ["one"] * 1000, ["one"] * 1000)
        own = np.array([np.var(each, ddof=1) for each in logs])
        found = float(freedom[0]) - 4.0
        assert found == pytest.approx(alike, rel=0.3)  # four times its standard error or so
        slope, intercept = np.polyfit(own, variance, 1)
        assert slope == pytest.approx(4.0 / freedom[0])
        assert intercept / (1.0 - slope) == pytest.approx(0.01, rel=0.15)


def test_a_single_draw_takes_the_spread_of_its_like_and_of_nothing_else() -> None:
    random = np.random.default_rng(2)
    seeded = [drawn(random, "uniform a", n, n * 1e-3, 0.1 * n**-0.5) for n in (1, 4, 16)]
    single = row("uniform b", 1, [0.1], [0.05])
    still = row("uniform c", 1, [0.1], [0.05], deterministic=True)
    other = row("none", 1, [0.1], [0.05], "osmesa")
    found = {each.mode: each.value for each in scene_of([*seeded, single, still, other]).efficiency}
    assert found[single.mode].low is not None
    assert found[still.mode].low is None
    assert found[other.mode].low is None
    least = 1.0 / (0.05**2 * 0.1)
    assert [found[mode.mode].value for mode in (single, still, other)] == [pytest.approx(least)] * 3


def test_the_interval_of_a_time_is_the_one_that_was_measured() -> None:
    modes = [
        replace(
            each, cpu_seconds=Estimate(each.cpu_seconds.value, interval=(0.5 * each.seconds[0], 2 * each.seconds[0]))
        )
        for each in exact("uniform a", [(4, 1.0, 0.05)])
    ]
    (found,) = scene_of(modes).quantisation
    assert found.seconds is None
    (efficiency,) = scene_of(modes).efficiency
    assert efficiency.value.low == pytest.approx(200.0, rel=0.05)  # of the quantiles of so many draws
    assert efficiency.value.high == pytest.approx(800.0, rel=0.05)


def test_the_prior_is_the_inverse_of_the_trigamma_function() -> None:
    for value in (0.01, 0.5, 3.0):
        root = optimize.brentq(lambda x, value=value: float(special.polygamma(1, x)) - value, 1e-3, 1e4)
        assert trigamma_inverse(value) == pytest.approx(root, rel=1e-6)


def test_standard_errors_add_with_the_degrees_of_freedom_that_they_have_together() -> None:
    # Two means of n values each: Welch's test, as scipy has it.
    random = np.random.default_rng(5)
    a, b = random.standard_normal(5), 3.0 * random.standard_normal(9)
    found = satterthwaite([stats.sem(a), stats.sem(b)], [4.0, 8.0])
    welch = stats.ttest_ind(a, b, equal_var=False)
    low, high = welch.confidence_interval()
    assert found[1] == pytest.approx(welch.df)
    told = student(float(a.mean() - b.mean()), *found)
    assert (told.low, told.high) == (pytest.approx(math.exp(low)), pytest.approx(math.exp(high)))
    assert satterthwaite([3.0, 4.0], [math.inf, math.inf]) == (5.0, math.inf)
    assert student(0.0, math.nan, 3.0) == Interval(1.0, None, None)
    assert student(0.0, 1e3, 3.0) == Interval(1.0, None, None)


# Rates


def test_rates_are_those_of_a_regression() -> None:
    random = np.random.default_rng(3)
    modes = [drawn(random, "uniform a", n, n * 1e-3, 0.1 * n**-0.5) for n in (4, 16, 64, 256)]
    (found,) = scene_of([replace(each, draws={}, seconds=()) for each in modes]).convergence
    errors = [each.metrics["rmse"].value or 0.0 for each in modes]
    fit = stats.linregress(np.log([4, 16, 64, 256]), np.log(errors))
    half = stats.t.ppf(0.975, 2) * fit.stderr
    assert (found.exponent.value, found.exponent.low, found.exponent.high) == (
        pytest.approx(fit.slope),
        pytest.approx(fit.slope - half),
        pytest.approx(fit.slope + half),
    )
    assert found.per_time is not None
    assert found.per_time.value == pytest.approx(
        stats.linregress(np.log([each.cpu_seconds.value or 0.0 for each in modes]), np.log(errors)).slope
    )


# Over scenes


def over(*factors: float) -> list[SceneSection]:
    """Scenes on which family b takes these factors of the time of a, which povray has with ten times the time."""
    return [
        section(
            f"scene {i}",
            [
                *power("uniform a", 0.1, -0.5, 1e-3),
                *power("uniform b", 0.1, -0.5, 1e-3 * factor),
                *(power("am1", 0.1, -0.5, 1e-2, "povray") if i else []),
            ],
        )
        for i, factor in enumerate(factors)
    ]


def test_ratios_are_geometric_means_with_students_interval() -> None:
    trade = analyse(over(2.0, 3.0, 4.0))
    assert trade.base == ("embree", "uniform a")
    found = {ratio.family: ratio for ratio in trade.ratios}
    logs = np.log([2.0, 3.0, 4.0])
    low, high = stats.t.interval(0.95, 2, logs.mean(), stats.sem(logs))
    assert found["uniform b"].time == Interval(*(pytest.approx(math.exp(each)) for each in (logs.mean(), low, high)))
    assert found["uniform b"].scenes == ("scene 0", "scene 1", "scene 2")
    assert found["uniform a"].time == Interval(1.0, 1.0, 1.0)
    assert found["am1"].scenes == ("scene 1", "scene 2")
    assert found["am1"].time == Interval(*[pytest.approx(10.0)] * 3)


def test_scenes_under_a_second_filter_are_not_counted_again() -> None:
    again = [replace(each, name=f"{each.name}, mitchell", filter="mitchell") for each in over(100.0, 100.0)]
    once, twice = analyse(over(2.0, 3.0)), analyse([*over(2.0, 3.0), *again])
    told, expected = (
        {each.family: (each.time and each.time.value, each.scenes) for each in trade.ratios} for trade in (twice, once)
    )
    assert told == expected
    assert len(twice.scenes) == 4


def test_a_family_that_only_overshoots_is_compared_next_to_its_modes() -> None:
    modes = power("uniform a", 0.1, -0.5, 1e-3) + exact("zones", [(1, 0.1, 0.001)]) + exact("zone", [(1, 1e-3, 0.2)])
    (found,) = (ratio for ratio in analyse([section("one", modes)]).ratios if ratio.family == "zones")
    assert found.time is not None
    assert found.time.value == pytest.approx(0.1 / 0.025)  # at 0.02, not at 0.05 and 0.1 too


# Knobs


def pov(method: str, depth: int, jitter: int) -> ModeRow:
    """depth doubles the time and divides the error by three, jitter off takes 0.8 of the time and 1.5 of the error, am2
    takes 1.25 of the time."""
    written = [f"depth={depth}" if depth != 3 else "", "jitter=0" if not jitter else ""]
    seconds = 2.0**depth * (1.0 if jitter else 0.8) * (1.25 if method == "am2" else 1.0)
    return row(
        method,
        depth,
        [seconds] * 3,
        [3.0**-depth * (1.0 if jitter else 1.5)] * 3,
        "povray",
        {"depth": str(depth), "jitter": str(jitter)},
        f"{method}:{','.join(filter(None, written))}".removesuffix(":"),
    )


def test_knobs_are_turned_one_at_a_time() -> None:
    modes = [pov(method, depth, jitter) for method in ("am1", "am2") for depth in (2, 3, 5) for jitter in (0, 1)]
    knobs = analyse([section("one", modes), section("two", modes[:6])]).knobs
    found = {(knob.form, knob.knob, knob.setting): knob for knob in knobs}
    assert len(found) == len(knobs) == 7
    expected = {
        ("am1", "depth", "2"): ("3", 0.5, 3.0, 4, 2),
        ("am1", "depth", "5"): ("3", 4.0, 1 / 9, 4, 2),
        ("am1", "jitter", "0"): ("1", 0.8, 1.5, 6, 2),
        ("am2", "depth", "2"): ("3", 0.5, 3.0, 2, 1),
        ("am2", "depth", "5"): ("3", 4.0, 1 / 9, 2, 1),
        ("am2", "jitter", "0"): ("1", 0.8, 1.5, 3, 1),
        ("am1, am2", "method", "am2"): ("am1", 1.25, 1.0, 6, 1),
    }
    for key, (baseline, time, error, pairs, scenes) in expected.items():
        knob = found[key]
        assert (knob.baseline, knob.pairs, len(knob.scenes)) == (baseline, pairs, scenes)
        assert knob.time == Interval(*[pytest.approx(time)] * 3)
        assert knob.error == Interval(*[pytest.approx(error)] * 3)


def test_inner_specs_are_turned_from_name_to_name_and_key_by_key() -> None:
    def mode(sampler: str, seconds: float, **inner: str) -> ModeRow:
        given_keys = ",".join([f"sampler={sampler}", *(f"sampler.{key}={value}" for key, value in inner.items())])
        whole = f"{sampler}:{','.join(f'{key}={value}' for key, value in inner.items())}".removesuffix(":")
        all_keys = {"n": "16", "sampler": sampler}
        if sampler == "sobol":
            all_keys["sampler.scramble"] = inner.get("scramble", "none")
        return row(f"uniform {whole}", 16, [seconds] * 3, [0.01] * 3, settings=all_keys, mode=f"uniform:{given_keys}")

    modes = [mode("random", 1.0), mode("sobol", 2.0), mode("sobol", 6.0, scramble="owen")]
    found = {(knob.knob, knob.setting): knob for knob in analyse([section("one", modes)]).knobs}
    assert {key: knob.baseline for key, knob in found.items()} == {
        ("sampler", "sobol"): "random",
        ("sampler.scramble", "owen"): "none",
    }
    assert found["sampler.scramble", "owen"].time.value == pytest.approx(3.0)


def test_the_default_of_a_mode_comes_before_that_of_its_inner_spec() -> None:
    def mode(text: str, seconds: float, scramble: str) -> ModeRow:
        keys = {"sampler": "sobol", "sampler.scramble": scramble, "zoom": "1"}
        return row("uniform", 16, [seconds] * 3, [0.01] * 3, settings=keys, mode=f"uniform:{text}zoom=1")

    modes = [mode("sampler=sobol,", 1.0, "none"), mode("", 2.0, "owen")]
    found = {knob.knob: knob for knob in analyse([section("one", modes)]).knobs}
    assert (found["sampler.scramble"].setting, found["sampler.scramble"].baseline) == ("none", "owen")


def test_filters_are_compared_over_their_sections() -> None:
    box = row("uniform", 4, [1.0] * 3, [0.02] * 3, settings={"filter": "box", "n": "4"}, mode="uniform:n=4")
    other = row(
        "uniform",
        4,
        [1.5] * 3,
        [0.01] * 3,
        settings={"filter": "mitchell", "n": "4"},
        mode="uniform:filter=mitchell,n=4",
    )
    (knob,) = analyse([section("edge", [box]), section("edge, mitchell", [other], "mitchell")]).knobs
    assert (knob.knob, knob.setting, knob.baseline, knob.scenes) == ("filter", "mitchell", "box", ("edge",))
    assert (knob.time.value, knob.error.value) == (pytest.approx(1.5), pytest.approx(0.5))


# All of it


@pytest.fixture(scope="module")
def rows() -> list[ModeRow]:
    random = np.random.default_rng(4)
    return [
        drawn(random, f"uniform {name}", n, n * seconds, constant * n**-0.5)
        for name, constant, seconds in (("a", 0.1, 1e-3), ("b", 0.15, 4e-4), ("c", 0.05, 9e-3))
        for n in (1, 4, 16, 64)
    ]


@settings(max_examples=10, deadline=None)
@given(st.randoms(use_true_random=False))
def test_the_order_of_rows_does_not_matter(rows: list[ModeRow], random: object) -> None:
    mixed = list(rows)
    random.shuffle(mixed)  # type: ignore[attr-defined]
    assert analyse([section("one", mixed)]) == analyse([section("one", rows)])


@settings(max_examples=10, deadline=None)
@given(st.sampled_from((1e-3, 0.1, 10.0, 1e4)))
def test_answers_scale_with_time(rows: list[ModeRow], factor: float) -> None:
    scaled = [
        replace(
            each,
            cpu_seconds=Estimate((each.cpu_seconds.value or 0.0) * factor),
            seconds=tuple(s * factor for s in each.seconds),
        )
        for each in rows
    ]
    own, other = scene_of(rows), scene_of(scaled)
    assert own.front == other.front
    for a, b in zip(own.equal_error, other.equal_error, strict=True):
        assert (a.how, a.mode, a.error) == (b.how, b.mode, b.error)
        assert (a.seconds is None) == (b.seconds is None)
        if a.seconds is not None and b.seconds is not None:
            assert b.seconds.value == pytest.approx(a.seconds.value * factor)
            assert b.seconds.high == pytest.approx((a.seconds.high or math.nan) * factor, nan_ok=True)
    for e, f in zip(own.equal_time, other.equal_time, strict=True):
        assert f.seconds == pytest.approx(e.seconds * factor)
        assert (e.how, e.mode) == (f.how, f.mode)


@settings(max_examples=10, deadline=None)
@given(st.floats(1.01, 100.0), st.floats(1.01, 100.0))
def test_a_mode_that_is_worse_in_both_changes_nothing_else(rows: list[ModeRow], slower: float, worse: float) -> None:
    # No draw of any mode is as slow or as bad as this one, which is of another renderer: its spread is its own.
    bad = row("none", 1, [10.0 * slower], [1.0 * worse], "osmesa")
    own, other = scene_of(rows), scene_of([*rows, bad])
    assert own.front == tuple(each for each in other.front if each.renderer != "osmesa")
    assert next(each for each in other.front if each.renderer == "osmesa").probability == 0.0
    assert own.quantisation == tuple(each for each in other.quantisation if each.renderer != "osmesa")
    assert own.convergence == other.convergence


def test_rows_without_an_error_or_a_time_are_left_out() -> None:
    modes = exact("uniform a", [(4, 0.0, 0.1), (16, 1.0, 0.1), (64, 1.0, 0.02)])
    modes[1] = replace(modes[1], metrics={"rmse": Estimate(math.inf)})
    bare = replace(modes[2], mode="bare", metrics={}, draws={})
    assert [each.mode for each in scene_of([*modes, bare]).front] == [modes[2].mode]
    assert analyse([]) == Trade((), (), None, ())
    assert scene_of([]) == SceneTrade("one", (), (), (), (), (), ())


# Words


def test_a_scene_in_words() -> None:
    modes = [
        *power("uniform a", 0.1, -0.5, 1e-3),
        *exact("am2", [(3, 1.9, 0.011)], "povray"),
        *exact("msaa", [(4, 1e-3, 0.034)], "osmesa"),
    ]
    trade = analyse([section("one", modes)])
    assert words.to_reach(trade.scenes[0], 0.02) == (
        "to reach RMSE 0.02: embree uniform a 25 ms [25, 25], osmesa msaa, n=4 cannot (best 0.034), "
        "povray am2, n=3 1.9 s [1.9, 1.9]"
    )
    assert words.within(trade.scenes[0], 0.02) == (
        "in 20 ms: embree uniform a 0.022 [0.022, 0.022], osmesa msaa, n=4 0.034 [0.034, 0.034], "
        "povray am2, n=3 cannot (fastest 1.9 s)"
    )
    told = words.lines(trade)
    assert any(line.startswith("to reach RMSE 0.02: ") for line in told)
    assert any("povray am2, n=3 cannot (fastest 1.9 s)" in line for line in told)


def test_all_scenes_in_words_and_as_a_document() -> None:
    scenes = over(2.0, 2.0)
    modes = [pov("am1", depth, 1) for depth in (3, 5)]
    trade = analyse([*scenes, section("three", modes)])
    told = words.lines(trade)
    assert told[0] == "against embree uniform a, at equal RMSE and at equal time:"
    assert "embree uniform b: time x 2 [2, 2], RMSE x 1.4 [1.4, 1.4] (2 scenes)" in told
    assert "povray am1 depth=5 against 3: time x 4 [4, 4], RMSE x 0.11 [0.11, 0.11] (1 scene)" in told
    assert "povray am1 n=64 against 4: time x 16 [16, 16], RMSE x 0.25 [0.25, 0.25] (1 scene)" in told
    assert words.reach_words(trade.scenes[0].quantisation[0]) == "embree uniform a 7.8 s [7.8, 7.8] (extrapolated)"
    document = json.loads(json.dumps(words.document(trade), allow_nan=False))
    assert document["base"] == {"renderer": "embree", "family": "uniform a"}
    assert [scene["scene"] for scene in document["scenes"]] == ["scene 0", "scene 1", "three"]


def test_the_same_seed_gives_the_same_figures(rows: list[ModeRow]) -> None:
    scenes = [section("one", rows)]
    assert analyse(scenes, seed=3) == analyse(scenes, seed=3) != analyse(scenes, seed=4)
