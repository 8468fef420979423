"""How steady the machine is told to have been: from times that are made up, and from this process beside others."""

from __future__ import annotations

import multiprocessing
import time
from pathlib import Path

import pytest

from aliascope import calibration
from aliascope.calibration import Beat, Effort, Watch, busy_seconds, noise, waited_share


def beats(*seconds: float) -> list[Beat]:
    return [Beat(each, each) for each in seconds]


def test_a_quiet_machine() -> None:
    found = noise(beats(0.020, 0.020, 0.0202, 0.0202, 0.0202, 0.0202, 0.0204, 0.0204), [], 0.02)
    assert (found.runs, found.seconds, found.loaded) == (8, 0.0202, False)
    assert found.drift == pytest.approx(0.02)  # the last two over the first two
    assert found.slowest == pytest.approx(0.0204 / 0.0202)
    # Squares of 2, 2, 0, 0, 0, 0, 2, 2 steps of 1e-4 over seven, and the root of that.
    assert found.spread == pytest.approx((16.0 / 7.0) ** 0.5 * 1e-4 / 0.0202)
    assert found.told == (
        "The machine was quiet; others used 0.02 of its processors. A fixed job of 20.2 ms, run 8 times between the "
        "pictures, varied by 0.7 % and was 2.0 % slower at the end."
    )


@pytest.mark.parametrize(
    ("seconds", "others", "wall", "words"),
    [
        ([0.02] * 8, 0.5, 1.0, "others used 0.5 of its processors"),
        ([0.02] * 8, None, 1.4, "runs waited for a processor 28 % of their time"),
    ],
)
def test_a_loaded_machine_is_marked_with_the_reason(
    seconds: list[float], others: float | None, wall: float, words: str
) -> None:
    found = noise(beats(*seconds), [Effort(wall, 1.0, 1, 1.0)] * 10, others)
    assert found.loaded
    assert found.told.startswith(f"The machine was loaded, so that times are not to be trusted: {words}. A fixed job")


def test_a_machine_that_is_not_steady_is_told_and_is_not_loaded() -> None:
    found = noise(beats(*[0.02, 0.03] * 4), [Effort(1.0, 1.0, 1, 1.0)] * 10, 0.0)
    assert not found.loaded
    assert found.told.startswith(
        "The machine was quiet but not steady, which the intervals of times take in; others used 0.00 of its "
        "processors. A fixed job of 25 ms, run 8 times between the pictures, varied by 21.4 %"
    )


def test_what_runs_wait_for() -> None:
    assert waited_share([], []) == 0.0
    assert waited_share([Beat(0.5, 1.0)], []) == pytest.approx(0.5)
    # A run whose work another program did, as POV-Ray's, waited for that.
    assert waited_share([Beat(1.0, 1.0)], [Effort(5.0, 0.1, 1, 9.0)]) == 0.0
    assert waited_share([Beat(1.0, 1.0)], [Effort(1.0, 0.8, 1, 9.0)]) == pytest.approx(0.1)


def test_the_fixed_job_is_the_same_work_each_time() -> None:
    found = [calibration.beat() for _ in range(3)]
    assert all(0.001 < each.cpu < 1.0 for each in found)
    assert all(each.wall > 0.5 * each.cpu for each in found)


def test_what_the_processors_did(tmp_path: Path) -> None:
    stat = tmp_path / "stat"
    stat.write_text("cpu  100 20 30 9999 888 4 5 1 7 7\ncpu0 1 1 1 1 1 1 1 1 1 1\n")
    assert busy_seconds(stat) == pytest.approx(1.6)  # without idle and waiting for disks; guests are in user
    stat.write_text("cpu 1 2\n")
    assert busy_seconds(stat) is None
    assert busy_seconds(tmp_path / "absent") is None


def _spin(seconds: float) -> None:
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        pass


def test_what_others_used_is_told_and_our_own_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two runs of a process that works, one of which is said to be ours: of a clock of the machine that this test
    turns, as others work beside it."""
    clock = [100.0]
    monkeypatch.setattr(calibration, "busy_seconds", lambda: clock[0])
    monkeypatch.setattr(calibration, "LEAST_WATCHED", 0.0)
    before, own = time.perf_counter(), time.process_time()
    watch = Watch()
    time.sleep(0.1)
    # Two processes of ours took 3 and 4 seconds in all; the first told twice.
    for process, used in ((7, 1.0), (7, 3.0), (8, 4.0)):
        watch.ran(Effort(1.0, 1.0, process, used))
    clock[0] += 10.0
    others = watch.others()
    assert others is not None
    # What is left of 10 s, but for what this process itself took meanwhile, for each second of the watch.
    longest, most_own = time.perf_counter() - before, time.process_time() - own
    assert (3.0 - most_own) / longest <= others <= 3.0 / 0.1
    clock[0] = 100.0
    assert watch.others() == 0.0
    monkeypatch.setattr(calibration, "LEAST_WATCHED", 60.0)
    assert watch.others() is None


def test_an_effort_is_of_this_process_and_its_children() -> None:
    ended = calibration.effort()
    child = multiprocessing.get_context("spawn").Process(target=_spin, args=(0.2,))
    child.start()
    child.join()
    _spin(0.1)
    found = ended()
    assert found.wall > 0.3
    assert 0.0 < found.own <= found.wall
    # All that the process and its children ever took, so that of the child too.
    assert found.used > found.own
    assert Watch().noise() is None
