"""What a regression run tests, and at which chance: against SciPy, least squares, and simulated noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.stats

from aliascope import renderers, scene_io
from aliascope.errors import CheckFailed, SpecError
from aliascope.geometry import Array
from aliascope.native import samplers
from aliascope.records import Cost
from aliascope.regression import verdict
from aliascope.regression.observe import Observer, Target, observed
from aliascope.regression.records import Blessed, CellName, Draw, Judged, Observed
from aliascope.regression.student import jackknife, student_test
from aliascope.regression.templates import BLOCK_MARGIN, BY_NAME, TEMPLATES, Basis, block_place, moved, names_of
from aliascope.regression.verdict import Chances, count, judge, shared
from aliascope.studies import regress_suite

NAMES = tuple(template.name for template in TEMPLATES)
SIZE = (48, 40)
NAME = CellName("made-up", "embree", "uniform:n=64")
MACHINE = {"processor": "one"}


def picture(
    right: float = 0.0, down: float = 0.0, across: float = 0.0, along: float = 0.0, correlation: float = 0.0
) -> Array:
    """A smooth picture whose changes have closed forms: waves, moved; damped as by a pixel's box that is wider `across`
    or `along` (relative), or whose x and y have a `correlation`."""
    y, x = np.meshgrid(np.arange(SIZE[1]) + 0.5, np.arange(SIZE[0]) + 0.5, indexing="ij")
    total = np.zeros((SIZE[1], SIZE[0], 3))
    wider = [((1 + each) ** 2 - 1) / 12 for each in (across, along)]
    for number, (u, v) in enumerate([(0.31, 0.17), (-0.23, 0.29), (0.05, -0.33), (0.11, 0.0)]):
        # Of a normal kernel with the change of variance that the box has: the transfer function is exp(-k C k / 2).
        change = wider[0] * u**2 + wider[1] * v**2 + 2 * correlation / 12 * u * v
        wave = np.exp(-change / 2) * np.cos(u * (x - right) + v * (y - down) + number)
        total += 0.1 * wave[..., np.newaxis] * np.array([1.0, 0.8, 0.6])
    return 0.5 + total


REFERENCE = picture()
BASIS = Basis(REFERENCE, NAMES)


def coefficient(name: str, changed: Array) -> float:
    return BASIS.coefficients(changed - REFERENCE)[NAMES.index(name)]


# --- templates --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_a_coefficient_is_the_weighted_least_squares_fit(name: str) -> None:
    rng = np.random.default_rng(1)
    difference = rng.normal(size=REFERENCE.shape)
    weights = np.sqrt(1.0 / (BASIS.brightest**2 + 0.1)).ravel()
    pattern = BY_NAME[name].pattern(REFERENCE).ravel()
    (fit,), *_ = np.linalg.lstsq((weights * pattern)[:, np.newaxis], weights * difference.ravel(), rcond=None)
    assert BASIS.coefficients(difference)[NAMES.index(name)] == pytest.approx(fit, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "changed", "amount"),
    [
        ("gain", 1.01 * REFERENCE, 1.0),
        ("offset of green", REFERENCE + np.array([0.0, 1 / 255, 0.0]), 1 / 255),
        ("moved right", picture(right=1 / 32), 1 / 32),
        ("moved down", picture(down=1 / 32), 1 / 32),
        ("wider across", picture(across=0.1), 10.0),
        ("wider across", picture(across=-0.1), -10.0),
        ("wider down", picture(along=0.1), 10.0),
        ("aslant", picture(correlation=0.3), 30.0),
    ],
)
def test_a_defect_is_found_in_its_unit(name: str, changed: Array, amount: float) -> None:
    # Central differences of these waves are 2 in 100 off, and more at the border. A box that is 10 % wider has a
    # variance that is 21 % larger, not 20.
    assert coefficient(name, changed) == pytest.approx(amount, rel=0.08)


def test_what_a_picture_of_one_colour_does_not_show_is_left_out() -> None:
    flat = np.full((20, 20, 3), 0.5)
    assert names_of(flat) == ("offset of red", "offset of green", "offset of blue", "gain")
    assert names_of(REFERENCE) == NAMES
    assert "gain" not in names_of(np.zeros((20, 20, 3)))


def test_known_standard_errors_are_those_of_simulated_noise() -> None:
    rng = np.random.default_rng(2)
    spread = 0.01 * rng.random(REFERENCE.shape)
    noise = [rng.normal(size=spread.shape) * spread for _ in range(600)]
    found = np.std([BASIS.coefficients(each) for each in noise], axis=0)
    np.testing.assert_allclose(found, BASIS.known(spread), rtol=0.15)  # 5 standard errors of 600 draws
    found = np.std([BASIS.blocks(each) for each in noise], axis=0)
    np.testing.assert_allclose(found, BASIS.known_blocks(spread), rtol=0.15)


def test_blocks_are_means_over_their_pixels() -> None:
    difference = np.random.default_rng(3).normal(size=REFERENCE.shape)
    blocks = np.array(BASIS.blocks(difference))
    assert len(blocks) == 9
    for number in range(9):
        x, y = block_place(number, SIZE)
        part = (slice(y, y + 16), slice(x, x + 16))
        scale = np.sqrt((BASIS.brightest[part] ** 2).mean() + 0.1)
        assert blocks[number] == pytest.approx(difference[part].mean() / scale)


def test_a_reference_moves_right_and_down() -> None:
    # Linear between pixels, of a wave of 0.3 a pixel: off by (0.3 / 2)^2 / 2 of 0.1 at most, three of them.
    found = moved(REFERENCE, (0.25, -0.4))[2:-2, 2:-2]
    np.testing.assert_allclose(found, picture(0.25, -0.4)[2:-2, 2:-2], atol=5e-3)
    assert moved(REFERENCE, (0.0, 0.0)) is REFERENCE


# --- observing --------------------------------------------------------------------------------------------------------

COST = Cost(
    samples=48 * 40 * 64,
    samples_per_pixel=64.0,
    rays={"primary": 122880, "shadow": 999},
    cpu_seconds=0.5,
    wall_seconds=0.5,
)


def made(
    seed: int = 0,
    noise: float = 0.01,
    judged: Judged = "reference",
    change: Callable[[Array], Array] = lambda pixels: pixels,
    parts: int = 1,
    draws: Sequence[Draw] = tuple(Draw(seed) for seed in range(16)),
    spread: Array | None = None,
    cost: Cost = COST,
) -> Observed:
    rng = np.random.default_rng(seed)
    pictures = [
        (draw, change(moved(REFERENCE, draw.shift) + noise * rng.normal(size=REFERENCE.shape)).astype("f4"), cost)
        for draw in draws
    ]
    observer = Observer(Target(REFERENCE, spread))
    size = len(pictures) // parts
    each = [observer.part(pictures[size * number : size * (number + 1)]) for number in range(parts)]
    return observed(NAME, judged, "digest", "box", Target(REFERENCE, spread), each, {})


def kept(seen: Observed) -> Blessed:
    plain = replace(seen, first=None, mean=None, p_values=None, worst=None)
    return Blessed(plain, "hash", "revision", MACHINE, "command", "reason", "2020-01-01T00:00:00+00:00")


@pytest.fixture(scope="module")
def plain() -> Observed:
    return made()


def test_parts_come_to_the_whole(plain: Observed) -> None:
    joined = made(parts=4)
    assert joined.replicates == plain.replicates
    assert joined.scatter == pytest.approx(plain.scatter, rel=1e-12)
    assert joined.scatter == pytest.approx(1e-4, rel=0.02)  # 0.01^2, of 16 x 5760 values
    np.testing.assert_allclose(joined.p_values, plain.p_values, rtol=1e-6)


def test_p_values_of_pixels_are_scipys(plain: Observed) -> None:
    rng = np.random.default_rng(0)
    pictures = np.array([(REFERENCE + 0.01 * rng.normal(size=REFERENCE.shape)).astype("f4") for _ in range(16)])
    theirs = scipy.stats.ttest_1samp(pictures.astype(float), REFERENCE, axis=0).pvalue
    assert plain.p_values is not None
    # Where one sample in 64, of those that differ as the pixels nearby do, is less than the noise.
    steady = theirs[np.abs(plain.p_values / theirs - 1) > 1e-3]
    assert len(steady) < 0.05 * theirs.size
    worst = plain.worst
    assert worst is not None
    assert worst.expected == pytest.approx(REFERENCE[worst.y, worst.x, worst.channel])


def test_a_picture_of_another_size_is_refused() -> None:
    with pytest.raises(CheckFailed, match="the picture has 40 x 48 pixels, its reference 48 x 40"):
        made(change=lambda pixels: pixels.transpose(1, 0, 2))


def test_a_value_that_is_no_number_is_counted() -> None:
    def broken(pixels: Array) -> Array:
        pixels[3, 4, 1], pixels[5, 6] = np.inf, np.nan
        return pixels

    found = made(change=broken)
    assert [replicate.not_finite for replicate in found.replicates] == [2] * 16
    assert np.isnan(found.replicates[0].coefficients).all()
    assert np.isfinite(found.scatter)


# --- tests ------------------------------------------------------------------------------------------------------------


def test_students_test_is_scipys() -> None:
    values = np.random.default_rng(4).normal(0.4, 1.0, size=(16, 50))
    values *= np.where(values.mean(axis=0) < 0, -1.0, 1.0)
    for margin in (0.0, 0.1, np.linspace(0.0, 0.2, 50)):
        ours = student_test(values, margin, 0.0, 0.01)
        theirs = scipy.stats.ttest_1samp(values, np.broadcast_to(margin, 50), axis=0)
        beyond = values.mean(axis=0) > margin
        np.testing.assert_allclose(ours.p_value[beyond], theirs.pvalue[beyond], rtol=1e-9)
        assert (ours.p_value[~beyond] == 1.0).all()
        np.testing.assert_array_equal(ours.share > 1.0, beyond & (theirs.pvalue < 0.01))
        assert (ours.share > 1.0).any()


def test_what_is_known_of_a_reference_enters_as_an_exact_variance() -> None:
    values = np.random.default_rng(5).normal(1.0, 1.0, size=(16, 1))
    ours = student_test(values, 0.0, 0.3, 0.01)
    theirs = scipy.stats.ttest_ind_from_stats(
        values.mean(), values.std(ddof=1), 16, 0.0, 0.3 * 1e5, 10**10, equal_var=False
    )
    assert ours.p_value[0] == pytest.approx(float(theirs.pvalue), rel=1e-6)


def test_paired_tests_are_scipys() -> None:
    then, now = made(1, judged="blessed"), made(2, judged="blessed")
    values = [np.array([each.coefficients for each in one.replicates]) for one in (now, then)]
    check = next(each for each in judge(now, kept(then), Chances(0.01, 0.01, 0.01)) if each.family == "effect")
    place = NAMES.index(check.about)
    sign = np.sign((values[0] - values[1])[:, place].mean())
    shifted = sign * values[1][:, place] + BY_NAME[check.about].margin
    theirs = scipy.stats.ttest_rel(sign * values[0][:, place], shifted)
    assert check.p_value == pytest.approx(float(theirs.pvalue) if theirs.statistic > 0 else 1.0, rel=1e-9)
    assert check.tests == len(NAMES)


def test_no_variance_leaves_the_margin_alone() -> None:
    values = np.array([[0.1, 0.1001, 0.0]] * 16)
    tested = student_test(values, 0.1, 0.0, 1e-9)
    np.testing.assert_array_equal(tested.share <= 1.0, [True, False, True])
    np.testing.assert_array_equal(tested.p_value, [1.0, 0.0, 1.0])
    # A pattern that counts a detail alike in all pictures is off by up to one sample in each.
    assert (student_test(values, 0.1, 0.0, 1e-3, floor=1e-4).share <= 1.0).all()


def test_shares_of_the_significance_come_to_the_whole() -> None:
    tests = verdict.Tests(180, 960, 25)
    chances = shared(tests, 0.01)
    parts = 180 * chances.effect, 960 * chances.block, 25 * chances.accuracy
    assert parts == pytest.approx((0.005, 0.0025, 0.0025))
    assert tests.total == 1165


def test_the_tests_that_are_counted_are_those_that_are_made(plain: Observed) -> None:
    for now, then in ((plain, None), (plain, kept(made(1))), (made(judged="blessed"), kept(made(1)))):
        checks = judge(now, then, Chances(0.01, 0.01, 0.01), MACHINE)
        made_tests = sum(check.tests for check in checks if check.p_value is not None)
        assert made_tests == count(now, then).total
    assert count(made(judged="blessed"), None).total == 0


def test_a_run_has_false_alarms_as_rarely_as_it_says() -> None:
    """Runs of 4 cells whose figures are noise alone, at a significance of 20 %: the tests within a cell are independent
    here, so that the chance of any alarm is nearly all of it."""
    rng = np.random.default_rng(6)
    seen = made(noise=0.0)
    runs, alarms, significance = 400, 0, 0.2
    for _ in range(runs):
        cells = [_noise(seen, rng) for _ in range(4)]
        chances = shared(sum((count(now, then) for now, then in cells), verdict.Tests()), significance)
        found = [check for now, then in cells for check in judge(now, then, chances) if check.p_value is not None]
        alarms += not all(check.passed for check in found)
    # Blocks and coefficients are tested two-sidedly with margins far below the noise: all of the chance but what
    # Bonferroni leaves, 1 - (1 - a / n)^n = 0.18, and accuracy, whose margin is 2 %.
    low, high = scipy.stats.binom.ppf([1e-3, 1 - 1e-3], runs, [0.75 * 0.18, 0.2])
    assert low <= alarms <= high


def _noise(seen: Observed, rng: np.random.Generator) -> tuple[Observed, Blessed]:
    def drawn() -> Observed:
        each = [
            replace(
                replicate,
                sha256=str(rng.random()),
                coefficients=tuple(1e3 * rng.normal(size=len(replicate.coefficients))),
                blocks=tuple(1e3 * rng.normal(size=len(replicate.blocks))),
                rmse=float(np.exp(10 * rng.normal())),
                rays={"primary": 122880, "shadow": int(1e6 * (1 + 0.1 * rng.normal()))},
            )
            for replicate in seen.replicates
        ]
        return replace(seen, replicates=tuple(each), judged="blessed", scatter=1.0)

    return drawn(), kept(drawn())


def changed(found: Observed, **what: Any) -> Observed:
    """With this in its first replicate."""
    return replace(found, replicates=(replace(found.replicates[0], **what), *found.replicates[1:]))


def gained(found: Observed) -> Observed:
    each = [
        replace(replicate, rmse=1.2 * (replicate.rmse or 0.0), block_squares=tuple(1.44 * square for square in squares))
        for replicate in found.replicates
        for squares in [replicate.block_squares]
    ]
    return replace(found, replicates=tuple(each))


SEEDS = tuple(Draw(seed) for seed in range(16))
SHIFTS = (Draw(), *(Draw(shift=(0.05 * number, 0.9 - 0.05 * number)) for number in range(1, 16)))
FAILS: list[tuple[str, str, Callable[[Observed], Observed]]] = [
    ("value", "pixels that are no finite number", lambda found: changed(found, not_finite=1)),
    ("value", "least value", lambda found: changed(found, least=-2.0)),
    ("value", "largest value", lambda found: changed(found, largest=10 * found.replicates[0].largest)),
    ("value", "outlier", lambda found: changed(found, outlier=9.0)),
    ("variance", "different pictures", lambda found: changed(found, sha256=found.replicates[1].sha256)),
    ("variance", "variance between replicates", lambda found: replace(found, scatter=0.2 * found.scatter)),
    ("accuracy", "error (RMSE)", gained),
    ("cost", "samples", lambda found: changed(found, samples=COST.samples + 1)),
    ("cost", "primary rays", lambda found: changed(found, rays={"primary": 1, "shadow": 999})),
    (
        "cost",
        "shadow rays",
        lambda found: replace(
            found,
            replicates=tuple(replace(each, rays={"primary": 122880, "shadow": 1010}) for each in found.replicates),
        ),
    ),
    ("cost", "bounce rays", lambda found: changed(found, rays={"primary": 122880, "shadow": 999, "bounce": 1})),
]


@pytest.mark.parametrize(("judged", "draws"), [("reference", SEEDS), ("blessed", SEEDS), ("blessed", SHIFTS)])
@pytest.mark.parametrize(("family", "about", "change"), FAILS, ids=[about for _, about, _ in FAILS])
def test_each_check_fails_by_what_it_is_for(
    judged: Judged, draws: Sequence[Draw], family: str, about: str, change: Callable[[Observed], Observed]
) -> None:
    found = _seen(judged, draws)
    chances = shared(verdict.Tests(1620, 8640, 250))
    assert all(check.passed for check in judge(found, kept(found), chances, MACHINE))
    failed = [check for check in judge(change(found), kept(found), chances, MACHINE) if not check.passed]
    assert [(check.family, check.about) for check in failed] == [(family, about)]


_MADE: dict[tuple[Judged, Sequence[Draw]], Observed] = {}


def _seen(judged: Judged, draws: Sequence[Draw]) -> Observed:
    key = judged, tuple(draws)
    if key not in _MADE:
        _MADE[key] = made(judged=judged, draws=draws)
    return _MADE[key]


def _with_coefficient(found: Observed, name: str, more: Array) -> Observed:
    """With so much more of a template in each replicate."""
    place = found.names.index(name)
    each = [
        replace(
            one, coefficients=(*one.coefficients[:place], one.coefficients[place] + add, *one.coefficients[place + 1 :])
        )
        for one, add in zip(found.replicates, more.tolist(), strict=True)
    ]
    return replace(found, replicates=tuple(each))


def test_what_noise_hides_beside_the_reference_is_seen_beside_the_blessed() -> None:
    chances = shared(verdict.Tests(1620, 8640, 250))
    noise = np.random.default_rng(5).normal(size=16)
    then = _with_coefficient(_seen("reference", SEEDS), "gain", 2.0 * (noise - noise.mean()))
    now = _with_coefficient(then, "gain", np.full(16, 1.0))
    failed = [check.about for check in judge(now, kept(then), chances) if not check.passed]
    assert failed == ["gain, beside the blessed"]
    assert all(check.passed for check in judge(now, None, chances))  # 1 % beside a standard error of 0.5 %
    counted = verdict.count(then, kept(then)), verdict.count(then, None)
    assert counted[0].effect == 2 * counted[1].effect == 2 * len(then.names)
    assert counted[0].block == 2 * counted[1].block


def test_a_mode_without_a_seed_draws_the_same_again_picture_by_picture() -> None:
    chances = shared(verdict.Tests(1620, 8640, 250))
    then = _seen("blessed", SHIFTS)
    about = "moved right, picture by picture"
    for amount, fine in ((1 / 65, True), (1 / 63, False), (np.nan, False)):
        # To and fro: the mean is 0, and Student's test finds nothing.
        now = _with_coefficient(then, "moved right", amount * np.array([1.0, -1.0] * 8))
        checks = {check.about: check for check in judge(now, kept(then), chances)}
        assert checks[about].passed is fine
        assert checks[about].limit == pytest.approx(1 / 64)
        assert checks[about].p_value is None
    snapping = replace(now, name=replace(now.name, renderer="osmesa"))
    assert not any("picture by picture" in check.about for check in judge(snapping, kept(then), chances))
    seeded = _seen("blessed", SEEDS)
    assert not any("picture by picture" in check.about for check in judge(seeded, kept(seeded), chances))


@pytest.mark.parametrize("judged", ["reference", "blessed"])
@pytest.mark.parametrize(
    ("about", "change"),
    [
        ("gain", lambda pixels: 1.01 * pixels),
        ("offset of blue", lambda pixels: pixels + np.array([0.0, 0.0, 1 / 255])),
        ("moved right", lambda pixels: pixels + picture(right=1 / 32) - REFERENCE),
        ("moved down", lambda pixels: pixels + picture(down=1 / 32) - REFERENCE),
    ],
)
def test_effects_are_caught_and_named(judged: Judged, about: str, change: Callable[[Array], Array]) -> None:
    then = kept(_seen(judged, SEEDS))
    chances = shared(verdict.Tests(1620, 8640, 250))
    found = {check.family: check for check in judge(made(7, judged=judged, change=change), then, chances)}
    assert not found["effect"].passed
    first = found["effect"].about.removesuffix(", beside the blessed")
    assert about in (first, *found["effect"].detail.split("limits: ")[-1].split(", "))
    assert found["effect"].p_value is not None
    assert found["effect"].p_value < chances.effect


def test_a_block_is_caught_and_named() -> None:
    def darker(pixels: Array) -> Array:
        pixels[16:32, 32:48] -= 0.01
        return pixels

    chances = shared(verdict.Tests(1620, 8640, 250))
    check = next(check for check in judge(made(change=darker), None, chances) if check.family == "block")
    assert (check.about, check.passed) == ("block of pixels from (32, 16)", False)
    assert check.observed > 10 * BLOCK_MARGIN


def test_without_what_was_blessed_the_reference_judges_alone(plain: Observed) -> None:
    chances = shared(count(plain, None))
    assert {check.family for check in judge(plain, None, chances)} == {"value", "effect", "block", "variance"}
    assert {check.family for check in judge(made(judged="blessed"), None, chances)} == {"value", "variance"}


def test_a_time_is_a_warning_and_of_one_machine_alone(plain: Observed) -> None:
    slow = replace(plain, replicates=tuple(replace(each, cpu_seconds=0.9) for each in plain.replicates))
    chances = shared(verdict.Tests(1, 1, 1))
    (check,) = (check for check in judge(slow, kept(plain), chances, MACHINE) if check.family == "time")
    assert (check.passed, check.warning) == (False, True)
    other = judge(slow, kept(plain), chances, {"processor": "another"})
    assert all(check.family != "time" for check in other)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"scene_digest": "other"}, "another version of the scene"),
        ({"size": (40, 48)}, "at 40x48, not 48x40"),
        ({"filter": "mitchell"}, "with the filter mitchell, not box"),
        ({"replicates": ()}, "other seeds or shifts"),
    ],
)
def test_what_is_not_comparable_is_refused(plain: Observed, change: dict[str, Any], reason: str) -> None:
    assert verdict.mismatch(kept(plain), "digest", SIZE, "box", SEEDS) == ""
    assert reason in verdict.mismatch(kept(replace(plain, **change)), "digest", SIZE, "box", SEEDS)


def test_accuracy_over_blocks_is_the_jackknifes() -> None:
    """Against resampling: the standard error of the logarithm of a ratio, over blocks drawn again and again."""
    rng = np.random.default_rng(8)
    then = rng.gamma(4.0, 1e-4, size=200)
    now = then * rng.gamma(20.0, 1 / 20.0, size=200)
    mean, error, freedom = jackknife(now, then)
    assert mean == pytest.approx(0.5 * np.log(now.sum() / then.sum()))
    assert freedom == 199
    picks = rng.integers(0, 200, size=(4000, 200))
    again = 0.5 * np.log(now[picks].sum(axis=1) / then[picks].sum(axis=1))
    assert error == pytest.approx(again.std(), rel=0.1)
    assert jackknife(then, then)[:2] == (0.0, 0.0)
    assert jackknife(np.zeros(4), np.zeros(4))[:2] == (0.0, 0.0)
    assert jackknife(np.array([1.0]), np.array([0.0]))[0] > 10


# --- the suite --------------------------------------------------------------------------------------------------------


def _biased(spec: str, count: int = 16, seeds: int = 4096) -> float:
    """How far, in standard errors of Student's test, the means of some integrands are off: those that see where in its
    cell of the pattern a point lies."""
    drawn = np.array([samplers.points(spec, count, 2, seed) for seed in range(seeds)])
    x, y = drawn[..., 0], drawn[..., 1]
    fine = [np.cos(2 * np.pi * (a * x + b * y)) for a, b in ((1, 0), (0, 1), (4, 0), (0, 4), (16, 0), (0, 16), (3, 5))]
    odd = [x - 0.5, y - 0.5, (x - 0.5) * (y - 0.5), (x < 0.3) - 0.3, (x + y < 0.45) - 0.45**2 / 2]
    means = np.array([value.mean(axis=1) for value in (*fine, *odd)])
    spread = means.std(axis=1, ddof=1) / np.sqrt(seeds)
    # A stratified pattern integrates some of them exactly.
    off = np.where(np.abs(means.mean(axis=1)) < 1e-6, 0.0, means.mean(axis=1))
    return float(np.abs(off / np.maximum(spread, 1e-12)).max())


UNBIASED_SPECS = [
    f"{name}:scramble={scramble}" if scramble else name
    for name, scrambles in regress_suite.UNBIASED.items()
    for scramble in sorted(scrambles)
]


@pytest.mark.parametrize("spec", UNBIASED_SPECS)
def test_samplers_that_the_reference_judges_are_without_bias(spec: str) -> None:
    # 12 integrands of 17 samplers: a t of 4.5 is beyond chance by 1e-3 for all of them together.
    assert _biased(spec) < 4.5


@pytest.mark.parametrize("spec", ["regular", "n-rooks:centred=1", "sobol", "hammersley", "standard-msaa"])
def test_those_with_a_bias_are_told(spec: str) -> None:
    assert _biased(spec, seeds=64) > 4.5


@pytest.mark.parametrize(
    ("mode", "judged"),
    [
        ("uniform:n=16,sampler=random", "reference"),
        ("uniform:n=64,sampler=sobol,sampler.scramble=owen", "reference"),
        ("uniform:n=16,sampler=sobol", "blessed"),
        ("uniform:n=16,sampler=n-rooks,sampler.centred=1", "blessed"),
        ("uniform:n=16,sampler=poisson-disk", "blessed"),
        ("adaptive:method=kajiya,n=64", "blessed"),
    ],
)
def test_by_what_a_mode_is_judged(mode: str, judged: Judged) -> None:
    assert regress_suite.judged_by("embree", renderers.mode_of(renderers.find("embree"), mode)) == judged


def test_draws_are_always_the_same_and_differ() -> None:
    embree = renderers.find("embree")
    seeded = regress_suite.draws_of(embree, renderers.mode_of(embree, "uniform:n=16,sampler=random"))
    assert [draw.seed for draw in seeded] == list(range(16))
    still = regress_suite.draws_of(embree, renderers.mode_of(embree, "uniform:n=16,sampler=regular"))
    assert still == regress_suite.draws_of(embree, renderers.mode_of(embree, "uniform:n=4,sampler=regular"))
    assert still[0] == Draw()
    assert len(set(still)) == 16
    assert all(0.0 <= side < 1.0 for draw in still for side in draw.shift)


@pytest.fixture(scope="module")
def files() -> list[scene_io.SceneFile]:
    return [scene_io.load(name) for name in scene_io.names()]


def test_every_scene_has_a_cell_of_each_renderer_that_draws_it(files: list[scene_io.SceneFile]) -> None:
    cells, empty = regress_suite.cells_of(files, list(renderers.RENDERERS))
    assert len({cell.name for cell in cells}) == len(cells)
    for file in files:
        for name in renderers.RENDERERS:
            own = [cell for cell in cells if (cell.name.scene, cell.name.renderer) == (file.name, name)]
            assert own or any((cell.scene, cell.renderer) == (file.name, name) for cell, _ in empty)
            if name == "embree":
                assert sum(cell.judged == "reference" for cell in own) >= 2
    assert [cell.name.text for cell in regress_suite.controls_of(cells)] == [
        "siemens-star/embree/uniform:n=64",
        "siemens-star/povray/regular",
        "siemens-star/osmesa/accumulate:sampler=sobol,sampler.scramble=owen",
    ]


def test_modes_are_chosen_by_pattern_or_named(files: list[scene_io.SceneFile]) -> None:
    edge = [file for file in files if file.name == "edge"]
    cells, _ = regress_suite.cells_of(edge, ["embree", "osmesa"], ["*random*", "accumulate:n=5,sampler=random"])
    found = [f"{cell.name.renderer}/{cell.name.mode}" for cell in cells]
    assert found == ["embree/uniform:sampler=random", "osmesa/accumulate:n=5,sampler=random"]
    with pytest.raises(SpecError, match='no mode "unifrom" of embree; did you mean "uniform"'):
        regress_suite.cells_of(edge, ["embree"], ["unifrom"])
    (control,) = regress_suite.controls_of(cells[:1])
    assert control is cells[0]
