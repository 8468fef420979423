"""Whether the intervals of the trade hold what they are of in 95 % of all comparisons, by simulation with known truths.

The modes follow power laws; MSE and times scatter about them by amounts that are not the same for all modes and that
the analysis is not told, and each mode has three draws.
"""

from __future__ import annotations

import math
from collections import defaultdict

import numpy as np
import pytest
from trade_rows import drawn, section

from aliascope.trade import QUANTISATION, analyse
from aliascope.trade.ratios import mean_ratio
from aliascope.trade.records import Interval, Trade

COUNTS = (4, 16, 64, 256)
LAWS = {"a": (0.1, 0.5, 1e-4), "b": (0.06, 0.7, 1.5e-4), "c": (0.1, 0.5, 2.8e-4)}
"""error = c n^-rate, time = seconds n: (c, rate, seconds)."""
SCENES = 400
OPEN = 0.07
"""The share of intervals that have an open end, and so are not judged, at most."""


class Tally:
    """How many intervals hold the truth, of how many; and how many are open."""

    def __init__(self) -> None:
        self.hits: dict[str, list[bool]] = defaultdict(list)
        self.open: dict[str, int] = defaultdict(int)

    def add(self, what: str, found: Interval | None, truth: float) -> None:
        if found is None or found.low is None or found.high is None:
            self.open[what] += 1
        else:
            # An end that is the truth but for roundings holds it: that of QUANTISATION.
            self.hits[what].append(found.low <= truth * (1.0 + 1e-9) and truth * (1.0 - 1e-9) <= found.high)

    def share(self, what: str) -> float:
        return sum(self.hits[what]) / len(self.hits[what])


def add_all(tally: Tally, trade: Trade) -> None:
    (scene,) = trade.scenes
    for reach in (*scene.equal_error, *scene.quantisation):
        c, rate, seconds = LAWS[reach.family.split()[-1]]
        if reach.how != "cannot":
            tally.add("time at an error", reach.seconds, seconds * max(COUNTS[0], (c / reach.error) ** (1.0 / rate)))
    for afford in scene.equal_time:
        c, rate, seconds = LAWS[afford.family.split()[-1]]
        if afford.how != "cannot":
            count = afford.seconds / seconds
            truth = c * (min(count, COUNTS[-1]) if afford.how == "measured" else count) ** -rate
            tally.add(
                "error at a time", afford.error, max(truth, QUANTISATION) if afford.how == "extrapolated" else truth
            )
    for found in scene.convergence:
        rate = LAWS[found.family.split()[-1]][1]
        for name, exponent in (("exponent", found.exponent), ("exponent against time", found.per_time)):
            assert exponent is not None
            assert exponent.low is not None
            assert exponent.high is not None
            tally.add(name, Interval(-exponent.value, -exponent.high, -exponent.low), rate)
    for each in scene.efficiency:
        form, count = each.mode.split(":n=")
        c, rate, seconds = LAWS[form.split("=")[-1]]
        tally.add("efficiency", each.value, float(count) ** (2.0 * rate - 1.0) / (c * c * seconds))
    for ratio in trade.ratios:
        # One law is another's but for its constants.
        if {ratio.family, trade.base[1] if trade.base else ""} == {"uniform a", "uniform c"}:
            cheaper = LAWS["c"][2] / LAWS["a"][2] * (LAWS["c"][0] / LAWS["a"][0]) ** 2
            worth = cheaper if ratio.family == "uniform c" else 1.0 / cheaper
            tally.add("ratio of times", ratio.time, worth)
            tally.add("ratio of errors", ratio.error, math.sqrt(worth))


@pytest.fixture(scope="module")
def tally() -> Tally:
    random, found = np.random.default_rng(1), Tally()
    for index in range(SCENES):
        rows = [
            drawn(random, f"uniform {name}", n, seconds * n, c * n**-rate)
            for name, (c, rate, seconds) in LAWS.items()
            for n in COUNTS
        ]
        add_all(found, analyse([section(f"scene {index}", rows)]))
    return found


@pytest.mark.parametrize(
    "what",
    [
        *("time at an error", "error at a time", "exponent", "exponent against time"),
        *("efficiency", "ratio of times", "ratio of errors"),
    ],
)
def test_intervals_hold_the_truth(tally: Tally, what: str) -> None:
    assert 0.93 <= tally.share(what) <= 0.97, f"{tally.share(what):.3f} of {len(tally.hits[what])}"
    assert tally.open[what] <= OPEN * len(tally.hits[what])


@pytest.mark.parametrize("scenes", [3, 7, 15])
def test_intervals_over_scenes_hold_for_the_kind_of_scene(scenes: int) -> None:
    random = np.random.default_rng(scenes)
    drawn_logs = math.log(3.0) + 0.7 * random.standard_normal((2000, scenes))
    found = [mean_ratio(logs) for logs in drawn_logs.tolist()]
    held = np.mean([one.low is not None and one.high is not None and one.low <= 3.0 <= one.high for one in found])
    assert 0.93 <= held <= 0.97
    # What the bootstrap's percentiles would hold: too little, the less the fewer the scenes.
    picks = random.integers(0, scenes, (400, scenes))
    ends = np.quantile(drawn_logs[:, picks].mean(axis=2), (0.025, 0.975), axis=1)
    assert np.mean((ends[0] <= math.log(3.0)) & (math.log(3.0) <= ends[1])) < (0.93 if scenes < 15 else 0.94)
