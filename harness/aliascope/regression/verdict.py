"""Whether a cell is as good as it was blessed: what was observed of it now, tested against what it should be.

Statistical tests share SIGNIFICANCE over the whole run, by SHARES, each share divided evenly by the number of its tests
(Bonferroni): so first all tests of a run are counted (`count`, `shared`), then each cell is judged (`judge`).

With c the coefficient of a template (`templates.py`) in each of K replicates - beside the reference, in a cell that is
judged by that; and in each cell the difference from the blessed replicate with the same draw - and a margin, which is
no regression:

    t = (|mean c| - margin) / sqrt(var c / K + known^2)

has at most Student's distribution, nearly, if the expectation lies within the margin, with Welch's degrees of freedom
(1947); `known` is what the reference's own noise makes of it. The samples of one picture are not independent, its
values share them: replicates are. Where all replicates have the same there is no variance, and the margin decides.

A well stratified pattern counts a detail with the same number of its N samples in all pictures, which then scatter less
than they are off. So the standard error of a block beside the reference is at least that of one sample more or less in
each picture (`floor_blocks`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from aliascope.geometry import Array
from aliascope.regression.records import Blessed, Check, Draw, Observed, Replicate
from aliascope.regression.student import Tested, jackknife, student_test
from aliascope.regression.templates import BLOCK_MARGIN, BY_NAME, block_place

SIGNIFICANCE = 1e-3
"""The chance that a run has any alarm where nothing changed, by its statistical tests."""

SHARES: Mapping[str, float] = {"effect": 0.5, "block": 0.25, "accuracy": 0.25}
"""Of SIGNIFICANCE, by family."""

WORSE = 0.02
"""An error that is larger by so much is no regression."""

EXACT = 5.0
"""Margins: half of the least defect that must be caught, for a mode that draws the same again."""

SNAPPING = frozenset({"osmesa"})
"""Renderers that put corners on a grid, and move all by some 1/1024 pixel, as other versions may do otherwise: with few
samples that is seen (on `comb`, without antialiasing, as 6.8 times what EXACT allows), and is no regression."""

COUNT_MARGIN = 1e-3
"""Samples and rays that hang on what rays hit may differ by so much: other instructions round other hits."""

ADAPTIVE = frozenset({"adaptive", "am1", "am2", "focal-blur"})
"""Modes whose samples hang on what rays hit."""

FIXED_RAYS = frozenset({"primary", "camera"})
"""Kinds of rays that go with samples; all others hang on what these hit."""

LEAST_SCATTER = 0.25
"""Of the blessed variance between replicates: less says that a seed is ignored in part."""

SLOWER = 1.5
LEAST_SECONDS = 0.02
"""Times below this, and ratios below that, tell nothing of a picture that was rendered beside others."""


@dataclass(frozen=True)
class Tests:
    """How many statistical tests there are, by family."""

    effect: int = 0
    block: int = 0
    accuracy: int = 0

    def __add__(self, other: Tests) -> Tests:
        return Tests(self.effect + other.effect, self.block + other.block, self.accuracy + other.accuracy)

    @property
    def total(self) -> int:
        return self.effect + self.block + self.accuracy


@dataclass(frozen=True)
class Chances:
    """Of one test of each family to give an alarm where nothing changed."""

    effect: float
    block: float
    accuracy: float


def count(observed: Observed, blessed: Blessed | None) -> Tests:
    """The statistical tests that `judge` makes of a cell."""
    times = len(_compared(observed, blessed))
    counted = 1 + len(_hanging(observed)) if blessed is not None else 0
    return Tests(effect=times * len(observed.names), block=times * len(observed.known_blocks), accuracy=counted)


def _compared(observed: Observed, blessed: Blessed | None) -> list[Blessed | None]:
    """What the pictures are compared with: the reference (None) where they are judged by that, and what was blessed, if
    there is that. The noise of a seed is in both pictures of a pair, and little of it in their difference."""
    reference: list[Blessed | None] = [None] if observed.judged == "reference" else []
    return reference + ([blessed] if blessed is not None else [])


def shared(tests: Tests, significance: float = SIGNIFICANCE) -> Chances:
    """The chance of each test, from how many the run has."""
    parts = (significance * SHARES[name] / max(1, getattr(tests, name)) for name in ("effect", "block", "accuracy"))
    return Chances(*parts)


def mismatch(blessed: Blessed, scene_digest: str, size: tuple[int, int], filter_: str, draws: Sequence[Draw]) -> str:
    """Why a blessed cell is not what a run is to be compared with, or nothing."""
    then = blessed.observed
    if then.scene_digest != scene_digest:
        return "was blessed for another version of the scene"
    if then.size != size:
        return f"was blessed at {then.size[0]}x{then.size[1]}, not {size[0]}x{size[1]}"
    if then.filter != filter_:
        return f"was blessed with the filter {then.filter}, not {filter_}"
    if tuple(replicate.draw for replicate in then.replicates) != tuple(draws):
        return "was blessed with other seeds or shifts"
    return ""


def judge(
    observed: Observed, blessed: Blessed | None, chances: Chances, machine: Mapping[str, str] | None = None
) -> tuple[Check, ...]:
    """All checks of a cell; without blessed figures those that need none. machine: where it ran, as `blessed` has it:
    times of another are not compared."""
    checks: list[Check | None] = [_not_finite(observed)]
    for other in _compared(observed, blessed):
        checks += [_effects(observed, other, chances.effect), _blocks(observed, other, chances.block)]
    checks.append(_distinct(observed, blessed))
    if blessed is None:
        return tuple(check for check in checks if check is not None)
    checks += [_exact(observed, blessed), *_values(observed, blessed), _scatter(observed, blessed)]
    checks += [_accuracy(observed, blessed, chances.accuracy), *_costs(observed, blessed, chances.accuracy)]
    if machine is not None and dict(machine) == dict(blessed.machine):
        checks.append(_time(observed, blessed))
    return tuple(check for check in checks if check is not None)


# --- effects and blocks -----------------------------------------------------------------------------------------------


def _paired(observed: Observed, other: Blessed | None, of: Callable[[Replicate], Sequence[float]]) -> Array:
    """(K, n): of each replicate, less what the blessed one with the same draw has, if there is one."""
    values: Array = np.array([of(replicate) for replicate in observed.replicates])
    if other is None:
        return values
    then: Array = np.array([of(replicate) for replicate in other.observed.replicates])
    return values - then


def _effects(observed: Observed, other: Blessed | None, chance: float) -> Check | None:
    if not observed.names:
        return None
    templates = [BY_NAME[name] for name in observed.names]
    known = np.array(observed.known) if other is None else 0.0
    values = _paired(observed, other, lambda replicate: replicate.coefficients)
    tested = student_test(values, np.array([template.margin for template in templates]), known, chance)
    worst = int(np.argmax(tested.share))
    beyond = [template.name for template, share in zip(templates, tested.share, strict=True) if not share <= 1.0]
    about = templates[worst].name + _beside(observed, other)
    return _worst(observed, tested, "effect", worst, about, templates[worst].unit, beyond)


def _blocks(observed: Observed, other: Blessed | None, chance: float) -> Check:
    known, floor = (
        np.array(each) if other is None and each else 0.0 for each in (observed.known_blocks, observed.floor_blocks)
    )
    values = _paired(observed, other, lambda replicate: replicate.blocks)
    tested = student_test(values, BLOCK_MARGIN, known, chance, floor)
    worst = int(np.argmax(tested.share))
    names = [f"({x}, {y})" for x, y in (block_place(number, observed.size) for number in range(len(tested.share)))]
    beyond = [name for name, share in zip(names, tested.share, strict=True) if not share <= 1.0]
    about = f"block of pixels from {names[worst]}{_beside(observed, other)}"
    return _worst(observed, tested, "block", worst, about, "", beyond)


def _beside(observed: Observed, other: Blessed | None) -> str:
    """To be told where a cell is compared with both."""
    return ", beside the blessed" if other is not None and observed.judged == "reference" else ""


def _exact(observed: Observed, blessed: Blessed) -> Check | None:
    """Modes without a seed draw the same again, but for what other instructions round: of no template does a picture
    change by EXACT margins, root mean square over the shifts. What moves few samples across an edge scatters too much
    over the shifts for Student's test; and as nothing is random there, nothing has to be tested for chance."""
    still = all(replicate.draw.shift == (0.0, 0.0) for replicate in observed.replicates)
    if still or not observed.names or observed.name.renderer in SNAPPING:
        return None
    templates = [BY_NAME[name] for name in observed.names]
    change = np.sqrt((_paired(observed, blessed, lambda replicate: replicate.coefficients) ** 2).mean(axis=0))
    limits = np.array([EXACT * template.margin for template in templates])
    share = np.where(np.isnan(change), np.inf, change / limits)
    worst = int(np.argmax(share))
    about = f"{templates[worst].name}, picture by picture"
    figures = float(change[worst]), float(limits[worst])
    return Check(observed.name, "value", about, *figures, templates[worst].unit, bool((share <= 1.0).all()))


def _worst(
    observed: Observed, tested: Tested, family: str, worst: int, about: str, unit: str, beyond: Sequence[str]
) -> Check:
    detail = f"mean {float(tested.mean[worst]):+.3g}, standard error {float(tested.standard_error[worst]):.2g}"
    if len(beyond) > 1:
        detail += f"; beyond their limits: {', '.join(beyond[:9])}" + (", ..." if len(beyond) > 9 else "")
    return Check(
        observed.name,
        "effect" if family == "effect" else "block",
        about,
        abs(float(tested.mean[worst])),
        float(tested.limit[worst]),
        unit,
        not beyond,
        p_value=float(tested.p_value[worst]),
        tests=len(tested.mean),
        detail=detail,
    )


# --- values and variance ----------------------------------------------------------------------------------------------
#
# The limits of values are wider than what fresh seeds make of a cell. Of the pools of `make power`, 128 replicates of
# each of the 69 seeded cells (64 where light bounces, 48 in POV-Ray), 16 were drawn for "now" and 16 for "blessed" 300
# times: no least value came to 0.03 of what is granted to it, no largest to 0.74, no outlier to 0.64. Where all pixels
# share their samples, values go in steps of one sample, and 16 pictures may all stand on one step: without the share of
# two samples the largest value alone failed 152 of 1,000 runs. Outliers have the longest tail: two of 64 pictures of
# `highlights`, 10^4 times as bright as the night behind, with random samples, had 3.3 times the median, and 3 times the
# largest of 16 was exceeded in 3 of 1,000 runs. A firefly is the largest value by far. The variance between replicates
# fell below half once in 69,000 times.


def _not_finite(observed: Observed) -> Check:
    many = sum(replicate.not_finite for replicate in observed.replicates)
    about = "pixels that are no finite number"
    return Check(observed.name, "value", about, float(many), 0.0, "pixels", many == 0)


def _values(observed: Observed, blessed: Blessed) -> list[Check]:
    """The range of the values, and how far the most outlying one stands from its surroundings, over all replicates."""
    now, then = observed.replicates, blessed.observed.replicates
    one = 1.0 / max(1.0, then[0].samples / math.prod(observed.size))
    least, most = least_limit(then, one), largest_limit(then, one)
    outlier, allowed = max(replicate.outlier for replicate in now), outlier_limit(then)
    low, high = min(replicate.least for replicate in now), max(replicate.largest for replicate in now)
    return [
        Check(observed.name, "value", "least value", low, least, "", low >= least, at_least=True),
        Check(observed.name, "value", "largest value", high, most, "", high <= most),
        Check(observed.name, "value", "outlier", outlier, allowed, "brightness nearby", outlier <= allowed),
    ]


def least_limit(then: Sequence[Replicate], one: float) -> float:
    """The least value that is no regression, from blessed replicates, with `one` sample's share of a pixel: two samples
    that see something else there are none."""
    return min(replicate.least for replicate in then) - max(0.02, 2.0 * one) * _range(then) - 0.001


def largest_limit(then: Sequence[Replicate], one: float) -> float:
    """The largest value that is no regression: noise makes it another one in each replicate."""
    largest = [replicate.largest for replicate in then]
    spread = 3.0 * (max(largest) - min(largest))
    return max(largest) + spread + max(0.05 * abs(max(largest)), 2.0 * one * _range(then)) + 0.01


def _range(then: Sequence[Replicate]) -> float:
    return max(replicate.largest for replicate in then) - min(replicate.least for replicate in then)


def outlier_limit(then: Sequence[Replicate]) -> float:
    """The most outlying value that is no regression."""
    return 5.0 * max(replicate.outlier for replicate in then) + 0.25


def _distinct(observed: Observed, blessed: Blessed | None) -> Check:
    """A seed changes a picture. A shift may leave it as it is where little is to be seen: what it changed when the cell
    was blessed it changes now."""
    needed = len(observed.replicates)
    if any(replicate.draw.shift != (0.0, 0.0) for replicate in observed.replicates):
        needed = max(2, len({replicate.sha256 for replicate in blessed.observed.replicates}) if blessed else 0)
    many = len({replicate.sha256 for replicate in observed.replicates})
    about = "different pictures"
    return Check(observed.name, "variance", about, float(many), float(needed), "", many >= needed, at_least=True)


def _scatter(observed: Observed, blessed: Blessed) -> Check:
    limit = LEAST_SCATTER * blessed.observed.scatter
    about = "variance between replicates"
    fine = observed.scatter >= limit
    return Check(observed.name, "variance", about, observed.scatter, limit, "", fine, at_least=True)


# --- accuracy ---------------------------------------------------------------------------------------------------------


def _accuracy(observed: Observed, blessed: Blessed, chance: float) -> Check:
    """Whether the root of the mean squared error is larger than that of the blessed pictures by more than WORSE."""
    pairs = list(zip(observed.replicates, blessed.observed.replicates, strict=True))
    errors = [(now.rmse, then.rmse) for now, then in pairs if now.rmse is not None and then.rmse is not None]
    if len(errors) == len(pairs):
        logs = np.array([_log_ratio(now, then) for now, then in errors])
        mean = float(logs[0] + (logs - logs[0]).mean())
        error, freedom = float((logs - logs[0]).std(ddof=1) / math.sqrt(len(logs))), len(logs) - 1
        how = f"of {len(logs)} pairs of pictures"
    else:
        now, then = (np.array(each.block_squares) for each in pairs[0])
        mean, error, freedom = jackknife(now, then)
        how = f"of {freedom + 1} blocks of a picture"
    allowed = math.log1p(WORSE)
    t = 0.0 if mean <= allowed else (mean - allowed) / error if error > 0.0 else math.inf
    limit = math.exp(allowed + float(student.isf(chance, freedom)) * error)
    half = float(student.isf(0.025, freedom)) * error
    detail = f"95 % interval {math.exp(mean - half):.4g} to {math.exp(mean + half):.4g}, {how}"
    ratio = math.exp(mean) if not math.isnan(mean) else math.nan
    return Check(
        observed.name,
        "accuracy",
        "error (RMSE)",
        ratio,
        limit,
        "x the blessed",
        ratio <= limit,
        p_value=float(student.sf(t, freedom)),
        detail=detail,
    )


def _log_ratio(now: float, then: float) -> float:
    """Of two errors; below what float32 can tell near 1 they are all alike."""
    least = 2.0**-24
    return math.log(max(now, least) / max(then, least)) if not math.isnan(now) else math.nan


# --- cost -------------------------------------------------------------------------------------------------------------


def _counts(observed: Observed) -> dict[str, list[int]]:
    """Samples, and rays by kind, of each replicate."""
    found = {"samples": [replicate.samples for replicate in observed.replicates]}
    for kind in observed.replicates[0].rays:
        found[f"{kind} rays"] = [replicate.rays.get(kind, 0) for replicate in observed.replicates]
    return found


def _hanging(observed: Observed) -> list[str]:
    """The counts that hang on what rays hit."""
    adaptive = observed.name.mode.partition(":")[0] in ADAPTIVE
    fixed = {"samples", *(f"{kind} rays" for kind in FIXED_RAYS)}
    return [name for name in _counts(observed) if adaptive or name not in fixed]


def _costs(observed: Observed, blessed: Blessed, chance: float) -> list[Check]:
    """Samples and rays: those that go with the mode exactly; others in the mean of the pairs, within COUNT_MARGIN."""
    now, then, hanging = _counts(observed), _counts(blessed.observed), _hanging(observed)
    checks = []
    for name, counts in now.items():
        blessed_counts = then.get(name, [0] * len(counts))
        if name in hanging and name in then:
            checks.append(_drift(observed, name, counts, blessed_counts, chance))
            continue
        apart = max(abs(one - other) for one, other in zip(counts, blessed_counts, strict=True))
        detail = f"{sum(counts)} in all, {sum(blessed_counts)} blessed"
        checks.append(
            Check(observed.name, "cost", name, float(apart), 0.0, "of a picture", apart == 0, detail=detail),
        )
    missing = [name for name in then if name not in now]
    checks += [
        Check(observed.name, "cost", name, float(max(then[name])), 0.0, "of a picture", False, detail="none now")
        for name in missing
    ]
    return checks


def _drift(observed: Observed, name: str, now: Sequence[int], then: Sequence[int], chance: float) -> Check:
    ratios = np.array([[(one - other) / max(1, other)] for one, other in zip(now, then, strict=True)])
    tested = student_test(ratios, COUNT_MARGIN, 0.0, chance)
    return Check(
        observed.name,
        "cost",
        name,
        100 * abs(float(tested.mean[0])),
        100 * float(tested.limit[0]),
        "% of the blessed",
        bool(tested.share[0] <= 1.0),
        p_value=float(tested.p_value[0]),
        detail=f"{sum(now)} in all, {sum(then)} blessed",
    )


def _time(observed: Observed, blessed: Blessed) -> Check | None:
    """CPU time, of a machine that works at other things too: a warning, no more."""
    now, then = (
        float(np.median([replicate.cpu_seconds for replicate in each.replicates]))
        for each in (observed, blessed.observed)
    )
    if max(now, then) < LEAST_SECONDS:
        return None
    ratio = now / max(then, LEAST_SECONDS)
    detail = f"median {now:.3g} s, {then:.3g} s blessed"
    fine = ratio <= SLOWER
    return Check(observed.name, "time", "CPU time", ratio, SLOWER, "x the blessed", fine, warning=True, detail=detail)
