"""The map of what breaks at which extreme: that its probes find what is there, and that quick levels keep bounds."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from aliascope.errors import NotAvailable, Unsupported
from aliascope.stability.records import NEVER, Probe, Reading
from aliascope.stability.running import all_probes, run


def made(measure, levels=(1.0, 10.0, 100.0)) -> Probe:
    return Probe("c", "statistic", "mean", "relative", "nothing", 1e-3, 0.1, levels, measure, refuses_from=None)


def test_a_probe_breaks_where_its_bound_is_passed() -> None:
    cell = run(made(lambda at: at / 500.0))
    assert [each.error for each in cell.readings] == [0.002, 0.02, 0.2]
    assert cell.breaks_at == 100.0
    assert cell.refused_from is None
    assert cell.digits_lost == pytest.approx(math.log10(200.0))
    assert cell.lost(0.0) == cell.lost(1e-4) == 0.0


def test_refusals_and_results_that_are_none() -> None:
    def measure(at: float) -> float:
        if at > 10.0:
            raise Unsupported("no more than 10")
        return math.nan if at > 1.0 else 0.0

    cell = run(made(measure))
    assert [(each.error, each.refused) for each in cell.readings] == [
        (0.0, ""),
        (math.inf, ""),
        (None, "no more than 10"),
    ]
    assert (cell.breaks_at, cell.refused_from, cell.digits_lost) == (10.0, 100.0, math.inf)
    assert run(made(measure), [1000.0]).digits_lost is None
    assert run(made(measure), [1000.0]).readings[0] == Reading(1000.0, None, "no more than 10", pytest.approx(0, abs=1))


def test_both_ways_from_the_mildest_level() -> None:
    both = replace(made(lambda at: max(at, 1.0 / at) / 500.0, (0.001, 0.01, 0.1, 1.0, 10.0, 100.0)), extreme="scaled")
    cell = run(both)
    assert [each.at for each in cell.readings] == [1.0, 0.1, 10.0, 0.01, 100.0, 0.001]
    assert (cell.breaks, cell.breaks_at) == ((0.01, 100.0), 0.01)
    assert run(made(lambda at: at, (1.0, 0.1, 10.0))).breaks == (1.0,)
    assert run(made(lambda at: 0.0)).breaks == ()


def test_from_some_level_on_a_break_is_excused() -> None:
    probe = replace(made(lambda at: at / 50.0), excused_from=100.0)
    assert run(probe).excused is False  # at 10 already
    assert run(replace(probe, bound=0.5)).excused is True
    assert run(replace(probe, bound=5.0)).excused is False  # nothing to be excused


def test_declining_too_early_is_a_failure() -> None:
    def measure(at: float) -> float:
        if at > 1.0:
            raise Unsupported("no more than 1")
        return 0.0

    assert run(made(measure)).status == "refuses"
    assert run(replace(made(measure), refuses_from=10.0)).status == "refuses"
    for level in (100.0, NEVER):
        cell = run(replace(made(measure), refuses_from=level))
        assert (cell.status, cell.failed_from) == ("failed", 10.0)
        assert cell.readings[1].failed == "declined, which it may not here: no more than 1"


def test_what_nobody_foresaw_is_told() -> None:
    cell = run(made(lambda at: 0.0 / (at - 10.0)))
    assert [each.failed for each in cell.readings] == ["", "ZeroDivisionError: float division by zero", ""]
    assert (cell.status, cell.failed_from, cell.refused_from) == ("failed", 10.0, None)


def test_a_component_that_is_not_there_is_asked_once() -> None:
    asked = []

    def measure(at: float) -> float:
        asked.append(at)
        raise NotAvailable("no library")

    cell = run(made(measure))
    assert (cell.status, cell.absent, cell.readings, asked) == ("absent", "no library", (), [1.0])


def test_the_worst_reading_is_the_first_of_the_largest() -> None:
    cell = run(made(lambda at: min(at, 10.0)))
    assert cell.worst is not None
    assert (cell.worst.at, cell.digits_lost) == (10.0, pytest.approx(4.0))


QUICK = [pytest.param(probe, id=name) for name, probe in all_probes().items() if probe.quick]


@pytest.mark.parametrize("probe", QUICK)
def test_quick_levels_keep_their_bounds(probe: Probe) -> None:
    cell = run(probe, probe.quick)
    assert not cell.absent, cell.absent
    assert cell.failed_from is None or cell.excused, cell.readings
    assert cell.breaks_at is None or cell.excused, cell.readings
