"""The benchmark of the order of times: what it counts, on times that are made up."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

_PATH = Path(__file__).parents[1] / "bench" / "bench_order.py"
_SPEC = importlib.util.spec_from_file_location("bench_order", _PATH)
assert _SPEC is not None
assert _SPEC.loader is not None
bench_order = importlib.util.module_from_spec(_SPEC)
sys.modules["bench_order"] = bench_order
_SPEC.loader.exec_module(bench_order)


def test_pairs_of_one_scene_whose_intervals_do_not_overlap_are_followed() -> None:
    def run(**modes: tuple[float, float]) -> dict[tuple[str, str, str], tuple[float, float]]:
        return {("edge", "embree", name): interval for name, interval in modes.items()}

    first = run(a=(1.0, 1.1), b=(1.2, 1.3), c=(1.25, 1.4), d=(5.0, 6.0))
    assert bench_order.orders(first, first) == bench_order.Orders(6, 5, 5, (), ())
    # b is now as fast as a, its middle before a's; c and b overlapped in the first run, so they may turn.
    second = run(a=(1.0, 1.1), b=(0.9, 1.15), c=(0.7, 0.8), d=(5.0, 6.0))
    found = bench_order.orders(first, second)
    assert (found.pairs, found.told, found.told_twice) == (6, 5, 4)
    assert found.turned == tuple(f"edge: embree a before embree {name}" for name in "bc")
    assert found.turned_twice == ("edge: embree a before embree c",)
    # Modes of two scenes are no pair, and one that the second run lacks is none.
    other = {("discs", *key[1:]): value for key, value in first.items()}
    assert bench_order.orders({**first, **other}, {**first, **other}).pairs == 12
    assert bench_order.orders(first, run(a=(1.0, 1.1))).pairs == 0


def test_rows_without_an_interval_are_left_out() -> None:
    rows = [
        {"scene": "s", "renderer": "r", "mode": name, "cpu_seconds_interval": interval}
        for name, interval in (("a", [1.0, 2.0]), ("b", None))
    ]
    assert bench_order.intervals({"rows": rows}) == {("s", "r", "a"): (1.0, 2.0)}
