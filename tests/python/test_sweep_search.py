"""The search of a sweep, on problems whose times and errors are formulas: what it finds, what it spends."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest

from aliascope.studies.sweep_search import (
    MOST_REPEATS,
    Answer,
    Candidate,
    Found,
    Measured,
    Search,
    answer,
    front,
    near_front,
    ranked_alike,
    restricted,
)


class Clock:
    """A clock that only pictures move on."""

    def __init__(self, seconds: float) -> None:
        self.now, self.seconds = 0.0, seconds

    def left(self) -> float:
        return self.seconds - self.now


class Grid:
    """Settings (method, depth, threshold): a picture takes 1 + depth^2 share(threshold) seconds, and its error falls as
    depth^-1.5 down to what the threshold leaves. Looks take a quarter."""

    abreast = 2
    looks = True
    methods = ("a", "b")
    depths = tuple(range(1, 10))
    thresholds = tuple(range(8))

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.whole: list[Candidate] = []
        self.looked: list[Candidate] = []

    @staticmethod
    def name(method: str, depth: int, threshold: int) -> Candidate:
        return Candidate("r", f"{method}:depth={depth},threshold={threshold}")

    @staticmethod
    def parts(candidate: Candidate) -> tuple[str, int, int]:
        method, _, rest = candidate.mode.partition(":")
        depth, threshold = (int(each.partition("=")[2]) for each in rest.split(","))
        return method, depth, threshold

    def everything(self) -> list[Candidate]:
        return [self.name(m, d, t) for m in self.methods for d in self.depths for t in self.thresholds]

    def coarse(self) -> list[Candidate]:
        return [self.name(m, d, t) for m in self.methods for d in (1, 3, 9) for t in (0, 4, 7)]

    def neighbours(self, candidate: Candidate) -> list[Candidate]:
        m, d, t = self.parts(candidate)
        beside = [(m, d + 1, t), (m, d - 1, t), (m, d, t + 1), (m, d, t - 1), ("b" if m == "a" else "a", d, t)]
        return [self.name(*each) for each in beside if each[1] in self.depths and each[2] in self.thresholds]

    def seconds(self, candidate: Candidate) -> float:
        m, d, t = self.parts(candidate)
        return 0.01 * (1.0 + d * d * 0.5**t * (1.0 if m == "a" else 3.0))

    def rmse(self, candidate: Candidate) -> float:
        m, d, t = self.parts(candidate)
        return math.hypot(0.1 * d**-1.5 * (1.0 if m == "a" else 1.02), 0.0004 * t**2)

    def expected(self, candidate: Candidate) -> float:
        return 3.0 * self.seconds(candidate)  # of the wrong size: the search learns it

    def measure(self, batch: Sequence[Candidate], look: bool, limit: float) -> dict[Candidate, Measured]:
        (self.looked if look else self.whole).extend(batch)
        found, spent = {}, 0.0
        for c in batch:
            own = self.seconds(c) * (0.25 if look else 1.0)
            spent += own / self.abreast
            if spent <= limit:
                found[c] = Measured(own, self.rmse(c) * (1.1 if look else 1.0))
        self.clock.now += min(spent, limit)
        return found

    def again(self, candidate: Candidate, draw: int, limit: float) -> Measured | None:
        own = self.seconds(candidate)
        self.clock.now += min(own, limit)
        return Measured(own * (1.0 + 0.01 * (-1) ** draw), self.rmse(candidate)) if own <= limit else None


def true_times(grid: Grid) -> dict[Candidate, Measured]:
    return {c: Measured(grid.seconds(c), grid.rmse(c)) for c in grid.everything()}


def test_what_is_recommended_is_what_the_whole_grid_has() -> None:
    clock = Clock(1000.0)
    grid = Grid(clock)
    found = Search(grid, clock.left, 0.006).run()
    truth = true_times(grid)
    own = answer(found.best_known(), 0.006)
    for chosen in (own.fast, own.balanced, own.final):
        best = min(m.seconds for m in truth.values() if m.rmse <= truth[chosen].rmse)
        assert truth[chosen].seconds <= 1.10 * best
    assert len(found.whole) < len(truth) / 2  # else it were no search
    assert set(front(found.best_known())) <= set(near_front(truth, (1.1, 1.0)))
    # Repeated until there was enough of them, though time was left.
    assert max(len(runs) for runs in found.runs.values()) == MOST_REPEATS
    assert len(found.runs[own.final]) >= 2


def test_the_whole_grid_is_measured_where_that_is_asked_for() -> None:
    clock = Clock(1e6)
    grid = Grid(clock)
    found = Search(grid, clock.left, 0.006).run(exhaustive=True)
    # But for what takes more than twice as long as one that is good enough.
    good = min(grid.seconds(c) for c in grid.everything() if grid.rmse(c) <= 0.006)
    assert {c for c in grid.everything() if grid.seconds(c) < 1.9 * good} <= set(found.whole)
    assert not found.looked


@pytest.mark.parametrize("seconds", [0.05, 0.3, 1.0, 3.0])
def test_it_ends_in_time_and_begins_with_the_cheap_ones(seconds: float) -> None:
    clock = Clock(seconds)
    grid = Grid(clock)
    found = Search(grid, clock.left, 0.001).run()
    assert clock.now <= seconds * (1.0 + 1e-9)
    if found.looked:
        order = [grid.seconds(c) for c in grid.looked[: Grid.abreast]]
        assert max(order) <= sorted(grid.seconds(c) for c in grid.coarse())[5]


def test_an_interrupt_leaves_what_was_found() -> None:
    clock = Clock(1000.0)

    class Stopped(Grid):
        def measure(self, batch: Sequence[Candidate], look: bool, limit: float) -> dict[Candidate, Measured]:
            if len(self.whole) > 3:
                raise KeyboardInterrupt
            return super().measure(batch, look, limit)

    found = Search(Stopped(clock), clock.left, 0.006).run()
    assert found.interrupted
    assert found.whole


A, B, C, D = (Candidate("r", name) for name in "abcd")


def test_a_front_has_what_nothing_beats_in_both() -> None:
    measured = {A: Measured(1, 9), B: Measured(2, 5), C: Measured(3, 6), D: Measured(4, 1)}
    assert front(measured) == [A, B, D]
    assert near_front(measured, (1.0, 1.0)) == [A, B, D]
    # C would be as fast as B at 1.5 times its speed, and as good at 1.2 times.
    assert near_front(measured, (1.51, 1.0)) == [A, B, C, D]
    assert near_front(measured, (1.49, 1.19)) == [A, B, D]


def test_the_three_answers_are_what_their_definitions_say() -> None:
    measured = {A: Measured(1.0, 0.09), B: Measured(1.9, 0.05), C: Measured(4.0, 0.01), D: Measured(40.0, 0.0096)}
    assert answer(measured, enough=0.001) == Answer(fast=B, balanced=C, final=C)  # D is within 5 % of C
    assert answer({**measured, D: Measured(40.0, 0.005)}, enough=0.001) == Answer(B, C, D)
    assert answer(measured, enough=0.06) == Answer(fast=B, balanced=B, final=B)
    assert answer({A: measured[A]}, enough=0.001) == Answer(A, A, A)


def test_median_of_times_and_root_mean_square_of_errors() -> None:
    runs = [Measured(1.0, 3.0), Measured(9.0, 4.0), Measured(2.0, 5.0)]
    found = Found(whole={A: Measured(7.0, 7.0)}, runs={A: runs})
    assert found.best_known()[A] == Measured(2.0, pytest.approx(math.sqrt(50.0 / 3.0)))


def test_ranks_are_compared_of_what_has_both() -> None:
    names = [Candidate("r", str(i)) for i in range(6)]
    looked = {c: Measured(i, 10.0 - i) for i, c in enumerate(names)}
    whole = {c: Measured(4.0 * i, float(i)) for i, c in enumerate(names)}
    assert ranked_alike(Found(looked=looked, whole=whole)) == pytest.approx((1.0, -1.0))
    assert ranked_alike(Found(looked=looked)) is None


def test_each_renderer_has_a_front_of_its_own() -> None:
    """One that is slower than another everywhere is searched as far: its users want to know too."""
    clock = Clock(1000.0)

    class Two(Grid):
        looks = False

        def everything(self) -> list[Candidate]:
            return [c for own in super().everything() for c in (own, Candidate("slow", own.mode))]

        def coarse(self) -> list[Candidate]:
            return [c for own in super().coarse() for c in (own, Candidate("slow", own.mode))]

        def neighbours(self, candidate: Candidate) -> list[Candidate]:
            return [Candidate(candidate.renderer, each.mode) for each in super().neighbours(candidate)]

        def seconds(self, candidate: Candidate) -> float:
            return super().seconds(candidate) * (50.0 if candidate.renderer == "slow" else 1.0)

    grid = Two(clock)
    found = Search(grid, clock.left, 0.006).run()
    both = [answer(restricted(found, name).best_known(), 0.006) for name in ("r", "slow")]
    assert [own.final.mode for own in both] == [both[0].final.mode] * 2
    assert both[0].final.renderer == "r"
    assert both[1].final.renderer == "slow"
