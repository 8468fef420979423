"""What is not known of the times and errors of a scene's modes.

A mode has few draws, three in the quick profile; from three alone a spread is known within a factor of six. So the
variances of the logarithms, over the draws of one mode, are drawn towards those of its like: each is the mean of its
own and of the common one, weighted by degrees of freedom, of which the common one has as many as the variances are
alike (Smyth 2004, "Linear models and empirical Bayes methods for assessing differential expression in microarray
experiments", sections 4 and 6). Student's t with the sum of both holds also for modes that are noisier than others.
Like each other are modes of one renderer on one scene; for errors, those with seeds and those without apart.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aliascope.records import Estimate, ModeRow, SceneSection
from aliascope.statistics import root_mean_square
from aliascope.trade.records import Interval

Array = NDArray[np.float64]

DRAWS = 2048
"""Of times and errors, as they could be: probabilities are known within 0.011, ends of intervals within 3 % of them."""


@dataclass(frozen=True)
class Spread:
    """The standard error of the logarithm of each mode's figure, its degrees of freedom; NaN where not known."""

    standard_error: Array
    freedom: Array


@dataclass(frozen=True)
class Points:
    """The modes of a scene that have a time and an error, as logarithms: `time` (n,) of CPU seconds, `error` of RMSE,
    -inf where it is 0. `shared` is the standard error that all errors have in common, through the reference. `key` is
    of the random numbers.

    `times` and `errors` (n, DRAWS) are what they could be; a mode of which the spread is not known stays as it is.
    """

    scene: str
    key: tuple[str, ...]
    rows: tuple[ModeRow, ...]
    time: Array
    error: Array
    time_spread: Spread
    error_spread: Spread
    shared: Array
    times: Array
    errors: Array

    def families(self) -> dict[tuple[str, str], NDArray[np.intp]]:
        """The modes of each renderer and family, by rising time, in a fixed order."""
        found: dict[tuple[str, str], list[int]] = {}
        for i in np.lexsort((self.error, self.time)):
            found.setdefault((self.rows[i].renderer, self.rows[i].family), []).append(int(i))
        return {key: np.array(found[key], dtype=np.intp) for key in sorted(found)}


def usable(row: ModeRow) -> bool:
    """Whether a mode has a time above 0 and an error."""
    time, error = row.cpu_seconds.value, row.metrics.get("rmse", Estimate(None)).value
    if time is None or error is None:
        return False
    return 0.0 < time < math.inf and 0.0 <= error < math.inf


def points(scenes: Sequence[SceneSection], seed: int = 0) -> list[Points]:
    """The modes of all scenes with what is not known of them, in a fixed order whatever that of the rows."""
    kept = [tuple(sorted(filter(usable, s.rows), key=lambda row: (row.renderer, row.mode))) for s in scenes]
    rows = [row for own in kept for row in own]
    names = [scene.name for scene, own in zip(scenes, kept, strict=True) for _ in own]
    time_spread = _of_times(rows, names)
    error_spread = _of_errors(rows, names)
    found, start = [], 0
    for scene, own in zip(scenes, kept, strict=True):
        part = slice(start, start + len(own))
        start += len(own)
        found.append(_drawn(scene.name, own, _part(time_spread, part), _part(error_spread, part), seed))
    return found


def _part(spread: Spread, part: slice) -> Spread:
    return Spread(spread.standard_error[part], spread.freedom[part])


def _of_times(rows: Sequence[ModeRow], scenes: Sequence[str]) -> Spread:
    """As the protocol for time found them, where it did: there the interval takes in how the machine drifted."""
    logs = [[math.log(value) for value in row.seconds if value > 0.0] for row in rows]
    groups = [(row.renderer, scene) for row, scene in zip(rows, scenes, strict=True)]
    variance, freedom = pooled(logs, groups, [row.renderer for row in rows])
    errors = np.sqrt(variance * np.array([_of_median(max(1, len(own))) for own in logs]))
    for i, row in enumerate(rows):
        if row.cpu_seconds.interval is not None:
            low, high = row.cpu_seconds.interval
            errors[i], freedom[i] = math.log(high / low) / (2.0 * _NORMAL), math.inf
    return Spread(errors, freedom)


_NORMAL = 1.959964
"""Half of the interval of 95 %, in standard errors of the normal distribution."""


def _of_median(count: int) -> float:
    """The variance of the median of so many normal values, over theirs: exact to a fiftieth for odd counts (Rider
    1960), too large for even ones."""
    return math.pi / (2.0 * count + math.pi - 2.0)


def _of_errors(rows: Sequence[ModeRow], scenes: Sequence[str]) -> Spread:
    logs = [_log_squares(row) for row in rows]
    groups = [(row.renderer, row.deterministic, scene) for row, scene in zip(rows, scenes, strict=True)]
    variance, freedom = pooled(logs, groups, [(row.renderer, row.deterministic) for row in rows])
    # Half of the logarithm of the mean of squares.
    return Spread(0.5 * np.sqrt(variance / np.array([max(1, len(own)) for own in logs])), freedom)


def _log_squares(row: ModeRow) -> list[float]:
    return [2.0 * math.log(value) for value in row.draws.get("rmse", ()) if value is not None and value > 0.0]


def pooled(
    logs: Sequence[Sequence[float]], groups: Sequence[Hashable], wider: Sequence[Hashable]
) -> tuple[Array, Array]:
    """The variance of one draw of each mode and its degrees of freedom, drawn towards that of the mode's group; NaN
    where none is known of the group nor of the `wider` one, of which groups are parts.

    How alike variances are within groups is found from all groups of a wider one together.
    """
    variance, freedom = np.full(len(logs), np.nan), np.full(len(logs), np.nan)
    own = np.array([float(np.var(values, ddof=1)) if len(values) > 1 else np.nan for values in logs])
    free = np.array([max(0, len(values) - 1) for values in logs], dtype=np.float64)
    for key in dict.fromkeys(wider):
        inside = [i for i, each in enumerate(wider) if each == key]
        known = [i for i in inside if free[i] > 0]
        if not known:
            continue
        members: dict[Hashable, list[int]] = {}
        for i in known:
            members.setdefault(groups[i], []).append(i)
        alike = _alikeness([(own[group], free[group]) for group in members.values()])
        everywhere = _common(own[known], free[known], alike)
        common = {name: _common(own[group], free[group], alike) for name, group in members.items()}
        for i in inside:
            prior, most = common.get(groups[i], everywhere)
            if math.isinf(alike) or not free[i]:
                variance[i], freedom[i] = prior, min(alike, most)
            else:
                variance[i] = (alike * prior + free[i] * own[i]) / (alike + free[i])
                freedom[i] = min(alike + free[i], most)
    return variance, freedom


_LEAST = 1e-18
"""Taken for the variance of draws that do not differ at all: those of roundings."""


_DIFFER = 0.8
"""The variance of the logarithms of true variances that is believed in before they are seen: factors of 2.5."""
_BELIEF = 12
"""As of so many modes."""


def _alikeness(groups: Sequence[tuple[Array, Array]]) -> float:
    """How alike the true variances within groups are, as degrees of freedom of the prior: infinite where they do not
    differ by more than their estimates do anyway. Few modes say little of that, so it starts from a belief."""
    from scipy.special import polygamma

    beyond, count = _DIFFER * _BELIEF, _BELIEF
    for variances, free in groups:
        if len(variances) > 1:
            moved = np.log(np.maximum(variances, _LEAST)) - _log_bias(free)
            beyond += float(((moved - moved.mean()) ** 2).sum() - (len(free) - 1) * polygamma(1, free / 2.0).mean())
            count += len(free) - 1
    return max(2.0, 2.0 * trigamma_inverse(beyond / count)) if beyond > 0.0 else math.inf


def _common(variances: Array, free: Array, alike: float) -> tuple[float, float]:
    """The variance that those of a group have in common, and the degrees of freedom that it is known with."""
    if math.isinf(alike) or len(variances) == 1:
        return max(float(np.average(variances, weights=free)), _LEAST), float(free.sum())
    from scipy.special import digamma

    moved = np.log(np.maximum(variances, _LEAST)) - _log_bias(free)
    return math.exp(float(moved.mean()) + float(digamma(alike / 2.0)) - math.log(alike / 2.0)), float(free.sum())


def _log_bias(free: Array) -> Array:
    """The mean of the logarithm of an estimated variance with so many degrees of freedom, over the true one."""
    from scipy.special import digamma

    found: Array = digamma(free / 2.0) - np.log(free / 2.0)
    return found


def trigamma_inverse(value: float) -> float:
    """x with trigamma(x) = value > 0, by Newton's method on 1 / trigamma (Smyth 2004, appendix)."""
    from scipy.special import polygamma

    x = 0.5 + 1.0 / value
    for _ in range(50):
        trigamma = float(polygamma(1, x))
        step = trigamma * (1.0 - trigamma / value) / float(polygamma(2, x))
        x += step
        if abs(step) < 1e-8 * x:
            break
    return x


def _drawn(scene: str, rows: tuple[ModeRow, ...], time_spread: Spread, error_spread: Spread, seed: int) -> Points:
    time = np.array([math.log(row.cpu_seconds.value or 0.0) for row in rows])
    rmse = np.array([row.metrics["rmse"].value or 0.0 for row in rows])
    with np.errstate(divide="ignore"):
        error = np.log(rmse)
    shared = np.array([_of_reference(row) for row in rows])
    key = (str(seed), scene)
    common = student_draws(key, (), 1.0, math.inf)
    names = [(row.renderer, row.mode) for row in rows]
    times = [
        value + student_draws(key, (*name, "time"), *own)
        for name, value, *own in zip(names, time, *_pair(time_spread), strict=True)
    ]
    errors = [
        value + student_draws(key, (*name, "error"), *own) + common * part
        for name, value, part, *own in zip(names, error, shared, *_pair(error_spread), strict=True)
    ]
    return Points(scene, key, rows, time, error, time_spread, error_spread, shared, _stacked(times), _stacked(errors))


def _pair(spread: Spread) -> tuple[list[float], list[float]]:
    return spread.standard_error.tolist(), spread.freedom.tolist()


def _stacked(found: list[Array]) -> Array:
    return np.stack(found) if found else np.empty((0, DRAWS))


def student_draws(key: Sequence[str], name: Sequence[str], standard_error: float, freedom: float) -> Array:
    """Student's t times a standard error, (DRAWS,), so that its quantiles are the ends of the interval; 0 where the
    error is NaN.

    The random numbers are the name's own: what one mode gets does not hang on which others there are.
    """
    if not standard_error > 0.0:
        return np.zeros(DRAWS)
    digest = hashlib.sha256("\n".join((*key, *name)).encode()).digest()
    random = np.random.Generator(np.random.SFC64(np.frombuffer(digest, dtype=np.uint32).tolist()))
    normal = random.standard_normal(DRAWS)
    if math.isinf(freedom):
        return standard_error * normal
    return standard_error * normal * np.sqrt(0.5 * freedom / random.standard_gamma(0.5 * freedom, DRAWS))


def _of_reference(row: ModeRow) -> float:
    """The standard error of the logarithm of RMSE that is left when that of the draws is taken off: the reference's."""
    rmse = row.metrics["rmse"]
    draws = [value for value in row.draws.get("rmse", ()) if value is not None]
    if not rmse.value or not rmse.standard_error or not draws:
        return 0.0
    own = root_mean_square(draws).standard_error or 0.0
    left = rmse.standard_error**2 - own**2
    # Equal but for roundings where the reference is exact.
    return math.sqrt(left) / rmse.value if left > 1e-9 * rmse.standard_error**2 else 0.0


def student(value: float, standard_error: float, freedom: float) -> Interval:
    """The exponential of a value, and of the ends of its interval by Student's t; ends None where the error is NaN, or
    so large that they say nothing."""
    from scipy.special import stdtrit

    half = float(stdtrit(freedom, 0.975)) * standard_error
    if not half < LARGEST:
        return Interval(math.exp(value), None, None)
    return Interval(math.exp(value), math.exp(value - half), math.exp(value + half))


LARGEST = 100.0
"""Half of an interval of a logarithm that is one; beyond lie ends that no float has."""


def satterthwaite(errors: Sequence[float], freedoms: Sequence[float]) -> tuple[float, float]:
    """The standard error of a sum of independent parts and its degrees of freedom (Satterthwaite 1946); NaN where one
    part is not known."""
    # In the power of two above the largest: without rounding, and no square is beyond a double.
    exponent = math.frexp(max(errors, default=0.0))[1]
    squares = [math.ldexp(error, -exponent) ** 2 for error in errors]
    total = math.fsum(squares)
    if math.isnan(total) or total == 0.0:
        return math.sqrt(total), math.inf
    shares = math.fsum(square * square / freedom for square, freedom in zip(squares, freedoms, strict=True))
    return math.ldexp(math.sqrt(total), exponent), total * total / shares if shares else math.inf


LARGEST_EXPONENT = 700.0
"""Of a double, nearly."""


def ends(figures: Array) -> tuple[float | None, float | None]:
    """Of the interval of 95 %, from logarithms (1 + DRAWS,); None at the end where the figure may not be reached, or is
    one that no float has."""
    low, high = (math.exp(end) if end < LARGEST_EXPONENT else None for end in quantiles(figures))
    return low, high


def quantiles(figures: Array) -> tuple[float, float]:
    """Of all but the first: those of 2.5 and 97.5 %, with as many of them beyond either."""
    count = len(figures) - 1
    beyond = round(0.025 * count)
    drawn = np.partition(figures[1:], (beyond, count - 1 - beyond))
    return float(drawn[beyond]), float(drawn[count - 1 - beyond])
