"""The search of a sweep: which settings are near the Pareto front of error against time, found within a limited time.

A coarse set over the whole range is looked at first, the cheap ones before the others. Settings beside those near the
front follow, in each knob, until there are none that could be on it. Where the problem has cheap looks (smaller
pictures), this is done with them, and only what may still be near the front gets its whole picture; from there on
whole pictures alone decide. What time is left goes to repeats, in turn, of those near the front (successive halving:
Jamieson and Talwalkar 2016, "Non-stochastic Best Arm Identification and Hyperparameter Optimization", with the
closeness to the front in place of the rank).
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import median
from typing import Protocol

LOOK_SLACK = (1.4, 1.25)
"""How much slower, and how much worse, than what beats it a setting may look in a cheap look without being dropped."""
WHOLE_SLACK = (1.25, 1.03)
"""The same of whole pictures, whose errors are known but whose times were taken once, beside others."""
TIMED_SLACK = (1.1, 1.0)
"""The same of those that get repeats."""

COARSE_SHARE, LOOK_SHARE, WHOLE_SHARE = 0.3, 0.4, 0.7
"""Of the time for the search, when the coarse set, the looks, and the whole pictures end."""

BATCH = 4
"""Settings measured between two looks at the front, a process."""
MOST_REPEATS = 9
"""Timed runs of a setting."""


@dataclass(frozen=True)
class Candidate:
    """A setting: a renderer and the canonical spec of a mode of it."""

    renderer: str
    mode: str


@dataclass(frozen=True)
class Measured:
    """CPU seconds and RMSE of a picture of a setting."""

    seconds: float
    rmse: float


class Problem(Protocol):
    """What is searched. `looks`: whether there are cheap looks; `abreast`: how many pictures are made at a time."""

    looks: bool
    abreast: int

    def everything(self) -> Sequence[Candidate]:
        """The whole grid."""

    def coarse(self) -> Sequence[Candidate]:
        """Some of it, over the whole range."""

    def neighbours(self, candidate: Candidate) -> Sequence[Candidate]:
        """Those one step away in one knob."""

    def expected(self, candidate: Candidate) -> float:
        """CPU seconds that a whole picture takes, from what is known beforehand."""

    def measure(self, batch: Sequence[Candidate], look: bool, limit: float) -> Mapping[Candidate, Measured]:
        """Makes pictures, side by side, in at most `limit` seconds on the wall; what was not finished is not there."""

    def again(self, candidate: Candidate, draw: int, limit: float) -> Measured | None:
        """A timed run, alone, of at least 0.1 s where that is shorter than `limit`; None where it was not finished."""


@dataclass
class Found:
    """What a search has come to. `looked` and `whole` are by setting; `runs` the timed runs, alone, of some. `dropped`
    got no whole picture; `too_slow` could not be finished in the time there was."""

    looked: dict[Candidate, Measured] = field(default_factory=dict)
    whole: dict[Candidate, Measured] = field(default_factory=dict)
    runs: dict[Candidate, list[Measured]] = field(default_factory=dict)
    too_slow: set[Candidate] = field(default_factory=set)
    interrupted: bool = False

    @property
    def dropped_for_time(self) -> int:
        """How many were wanted and not finished."""
        return len(self.too_slow - set(self.whole))

    @property
    def dropped(self) -> set[Candidate]:
        return set(self.looked) - set(self.whole)

    def best_known(self) -> dict[Candidate, Measured]:
        """Each whole picture with its time: the median of the timed runs, where there are any, and the root of the mean
        of their squared errors."""
        best = dict(self.whole)
        for candidate, runs in self.runs.items():
            squares = [run.rmse**2 for run in runs]
            best[candidate] = Measured(
                median(run.seconds for run in runs), math.sqrt(math.fsum(squares) / len(squares))
            )
        return best


def front(measured: Mapping[Candidate, Measured]) -> list[Candidate]:
    """Those that none is both faster and better than, the fastest first."""
    ordered = sorted(measured, key=lambda c: (measured[c].seconds, measured[c].rmse, c.renderer, c.mode))
    found: list[Candidate] = []
    for candidate in ordered:
        if not found or measured[candidate].rmse < measured[found[-1]].rmse:
            found.append(candidate)
    return found


def near_front(measured: Mapping[Candidate, Measured], slack: tuple[float, float]) -> list[Candidate]:
    """Those that would be on the front if they were so many times as fast and as good, the fastest first."""
    best = [measured[candidate] for candidate in front(measured)]
    return sorted(
        (
            c
            for c, own in measured.items()
            if not any(b.seconds * slack[0] < own.seconds and b.rmse * slack[1] < own.rmse for b in best)
        ),
        key=lambda c: measured[c].seconds,
    )


def of_each(measured: Mapping[Candidate, Measured], slack: tuple[float, float] | None = None) -> list[Candidate]:
    """The fronts of the renderers, each by itself, or what is near them."""
    found: list[Candidate] = []
    for name in dict.fromkeys(candidate.renderer for candidate in measured):
        own = {c: m for c, m in measured.items() if c.renderer == name}
        found += front(own) if slack is None else near_front(own, slack)
    return found


@dataclass
class Search:
    """One search. `left`: seconds until it has to end; `enough`: an error that nobody needs to go below; `tell` is
    given what is done now."""

    problem: Problem
    left: Callable[[], float]
    enough: float
    tell: Callable[[str, int], None] = lambda what, count: None

    def __post_init__(self) -> None:
        self.found = Found()
        self._total = self.left()
        self._pace, self._overhead = 1.0, 0.0  # wall seconds for each of CPU, and for each picture beside these
        self._ratios: dict[str, list[float]] = {}

    def run(self, exhaustive: bool = False) -> Found:
        """Searches until nothing is left to do, or no time. On Ctrl-C it ends with what it has."""
        try:
            if exhaustive:
                self._all(self.problem.everything(), look=False, share=WHOLE_SHARE)
            else:
                if self.problem.looks:
                    self._all(self.problem.coarse(), look=True, share=COARSE_SHARE)
                    self._spread(look=True, share=LOOK_SHARE)
                    self._all(of_each(self.found.looked, LOOK_SLACK), look=False, share=WHOLE_SHARE, spread=True)
                else:
                    self._all(self.problem.coarse(), look=False, share=COARSE_SHARE)
                self._spread(look=False, share=WHOLE_SHARE)
            self._repeat()
        except KeyboardInterrupt:
            self.found.interrupted = True
        return self.found

    def _seen(self, look: bool) -> dict[Candidate, Measured]:
        return self.found.looked if look else self.found.whole

    def _remaining(self, share: float) -> float:
        """Seconds until this share of the time is used."""
        return self.left() - (1.0 - share) * self._total

    def expected(self, candidate: Candidate) -> float:
        """CPU seconds of a whole picture: from its cheap look, else as foretold, by how wrong that was with others of
        its kind."""
        if candidate in self.found.whole:
            return self.found.whole[candidate].seconds
        if candidate in self.found.looked:
            return self.found.looked[candidate].seconds * self._look_scale()
        kind = _kind(candidate)
        ratios = self._ratios.get(kind) or [ratio for each in self._ratios.values() for ratio in each]
        return self.problem.expected(candidate) * (median(ratios) if ratios else 1.0)

    def _all(self, candidates: Iterable[Candidate], look: bool, share: float, spread: bool = False) -> None:
        """Measures all of these while there is time, cheap ones first; `spread`: from over the whole range instead,
        so that both ends are known should the time run out."""
        todo = [c for c in candidates if c not in self._seen(look) and c not in self.found.too_slow]
        while todo and self._remaining(share) > 0.0:
            todo.sort(key=lambda c: (self.expected(c), c.renderer, c.mode))
            batch = todo[:: max(1, len(todo) // self._batch)][: self._batch] if spread else todo[: self._batch]
            self._measure(batch, look, share)
            todo = [c for c in todo if c not in batch and not self._pointless(c)]

    @property
    def _batch(self) -> int:
        return BATCH * self.problem.abreast

    def _spread(self, look: bool, share: float) -> None:
        """Goes on to the neighbours of those near the front, until there are no new ones."""
        slack = LOOK_SLACK if look else WHOLE_SLACK
        while self._remaining(share) > 0.0:
            seen = self._seen(look)
            near = of_each(seen, slack)
            beside = dict.fromkeys(n for c in near for n in self.problem.neighbours(c))
            new = [c for c in beside if c not in seen and c not in self.found.too_slow and not self._pointless(c)]
            if not look:  # what a look dropped stays dropped
                near_looked = set(of_each(self.found.looked, LOOK_SLACK))
                new = [c for c in new if c not in self.found.looked or c in near_looked]
            if not new:
                return
            new.sort(key=lambda c: (self.expected(c), c.renderer, c.mode))
            # From over the whole range: should the time run out, no part of the front has been left as it was.
            self._measure(new[:: max(1, len(new) // self._batch)][: self._batch], look, share)

    def _pointless(self, candidate: Candidate) -> bool:
        """Whether it takes so much longer than one of its renderer that is good enough that nobody would want it."""
        whole = self.found.whole.items()
        enough = [own.seconds for c, own in whole if c.renderer == candidate.renderer and own.rmse <= self.enough]
        return bool(enough) and self.expected(candidate) > 2.0 * min(enough)

    def _measure(self, batch: Sequence[Candidate], look: bool, share: float) -> None:
        remaining = self._remaining(share)
        foretold = {c: self.expected(c) for c in batch}
        # What is not likely to be finished in the time there is, is not begun.
        fitting = [c for c in batch if self._wall(foretold[c] * (0.25 if look else 1.0)) <= remaining]
        self.found.too_slow.update(set(batch) - set(fitting))
        if not fitting:
            return
        self.tell("looks" if look else "whole pictures", len(self._seen(look)))
        before = self.left()
        measured = self.problem.measure(fitting, look, remaining)
        wall = before - self.left()
        for candidate, own in measured.items():
            self._seen(look)[candidate] = own
            scale = self._look_scale() if look else 1.0
            self._ratios.setdefault(_kind(candidate), []).append(
                own.seconds * scale / max(self.problem.expected(candidate), 1e-9)
            )
        self.found.too_slow.update(c for c in fitting if c not in measured)
        if measured:
            each, spent = wall * self.problem.abreast / len(fitting), sum(m.seconds for m in measured.values())
            self._learn(each, spent / len(measured))

    def _learn(self, wall: float, seconds: float) -> None:
        """What a picture takes on the wall, of what it takes of CPU: where that is most of it, it tells the pace."""
        if seconds > 0.3 * wall:
            self._pace = max(1.0, wall / seconds)
        else:
            self._overhead = wall - seconds

    def _wall(self, seconds: float) -> float:
        return self._overhead + self._pace * seconds

    def _look_scale(self) -> float:
        """How many times as long as its look a whole picture takes."""
        both = [
            self.found.whole[c].seconds / own.seconds
            for c, own in self.found.looked.items()
            if c in self.found.whole and own.seconds > 0.0
        ]
        return median(both) if both else 4.0

    def _repeat(self) -> None:
        """Timed runs, alone and in turn, in an order by chance, of those near the front."""
        order = random.Random(0)
        for draw in range(MOST_REPEATS):
            near = of_each(self.found.best_known(), WHOLE_SLACK if draw == 0 else TIMED_SLACK)
            near = [c for c in near if not self._pointless(c) or c in self.found.runs]
            order.shuffle(near)
            on_front = set(of_each(self.found.best_known()))
            near.sort(key=lambda c: c not in on_front)  # first, should the time run out
            ran = 0
            for candidate in near:
                if self._wall(self.found.best_known()[candidate].seconds) > self.left():
                    continue
                self.tell(f"timed runs, round {draw + 1}", ran)
                run = self.problem.again(candidate, draw, self.left())
                if run is not None:
                    self.found.runs.setdefault(candidate, []).append(run)
                    ran += 1
            if not ran:
                return


def _kind(candidate: Candidate) -> str:
    return f"{candidate.renderer} {candidate.mode.partition(':')[0]}"


def ranked_alike(found: Found) -> tuple[float, float] | None:
    """How alike looks and whole pictures rank what has both: Spearman's coefficients of time and of error; None for
    fewer than five."""
    both = [c for c in found.whole if c in found.looked]
    if len(both) < 5:
        return None
    from scipy.stats import spearmanr  # takes a second to load

    def alike(of: Callable[[Measured], float]) -> float:
        return float(spearmanr([of(found.looked[c]) for c in both], [of(found.whole[c]) for c in both]).statistic)

    return alike(lambda m: m.seconds), alike(lambda m: m.rmse)


@dataclass(frozen=True)
class Answer:
    """The three settings. `fast`: the best that takes at most twice as long as the fastest of all. `final`: the fastest
    whose RMSE is at most that of 8 bits, or, where none is that good, within 5 % of the least there is. `balanced`: of
    those on the front from fast to final, the most efficient, by the least product of time and mean square error: from
    there on, halving the error costs more than four times the time."""

    fast: Candidate
    balanced: Candidate
    final: Candidate


FAST_TIMES, FINAL_NEAR = 2.0, 1.05


def answer(measured: Mapping[Candidate, Measured], enough: float) -> Answer:
    """The three settings of what was measured, of which there is one at least."""
    on_front = front(measured)
    least = measured[on_front[-1]].rmse
    final = next(c for c in on_front if measured[c].rmse <= max(enough, FINAL_NEAR * least))
    upto = on_front[: on_front.index(final) + 1]
    quick = FAST_TIMES * measured[on_front[0]].seconds
    fast = [c for c in upto if measured[c].seconds <= quick][-1]
    between = upto[upto.index(fast) :]
    balanced = min(between, key=lambda c: measured[c].seconds * measured[c].rmse ** 2)
    return Answer(fast, balanced, final)


def restricted(found: Found, renderer: str) -> Found:
    """What was found of one renderer."""
    return replace(
        found,
        looked={c: m for c, m in found.looked.items() if c.renderer == renderer},
        whole={c: m for c, m in found.whole.items() if c.renderer == renderer},
        runs={c: m for c, m in found.runs.items() if c.renderer == renderer},
    )
