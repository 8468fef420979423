"""Counting what a call does by the kernel's counters. Most machines of tests show no counter of instructions, so the
same is proven of a clock that every kernel counts; what is true of instructions is tested where there are any."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest

from aliascope import renderers, scene_io
from aliascope.native import instructions, raster, tracer
from aliascope.native.instructions import INSTRUCTIONS, TASK_CLOCK, Event, counted
from aliascope.renderers.base import Request


def spin(seconds: float) -> None:
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


def allowed(event: Event) -> bool:
    with counted(event) as found:
        spin(0.001)
    return found.value is not None


needs_clock = pytest.mark.skipif(not allowed(TASK_CLOCK), reason="the kernel allows no counting of events")
needs_instructions = pytest.mark.skipif(not allowed(INSTRUCTIONS), reason="there is no counter of instructions")


@needs_clock
def test_what_is_inside_is_counted_and_nothing_else() -> None:
    """Nanoseconds of this thread's own: within a millisecond and 5 % of what its clock says."""
    spin(0.02)
    with counted(TASK_CLOCK) as found:
        assert found.value is None
        begun = time.thread_time()
        spin(0.05)
        time.sleep(0.05)
        took = time.thread_time() - begun
    spin(0.02)
    assert found.value == pytest.approx(1e9 * took, rel=0.05, abs=1e6)


@needs_clock
def test_threads_that_are_started_meanwhile_count_too_and_others_do_not() -> None:
    stop = threading.Event()
    other = threading.Thread(target=lambda: [spin(0.001) for _ in iter(stop.is_set, True)])
    other.start()
    with counted(TASK_CLOCK) as found:
        begun = time.thread_time()
        threads = [threading.Thread(target=spin, args=(0.04,)) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        own = time.thread_time() - begun
    stop.set()
    other.join()
    assert found.value == pytest.approx(1e9 * (own + 0.08), rel=0.15)


def test_what_cannot_be_counted_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    with counted(Event(0, 999)) as found:
        spin(0.001)
    assert found.value is None
    monkeypatch.setattr(instructions.platform, "machine", lambda: "abacus")
    with counted(TASK_CLOCK) as found:
        spin(0.001)
    assert found.value is None


@needs_clock
def test_a_call_that_fails_leaves_no_counter_open() -> None:
    def failing() -> None:
        with counted(TASK_CLOCK):
            raise RuntimeError

    def last() -> int:
        with Path("/dev/null").open() as file:
            return file.fileno()

    before = last()
    for _ in range(3):
        with pytest.raises(RuntimeError):
            failing()
    assert last() == before


@needs_clock
@pytest.mark.parametrize(
    ("name", "mode", "module"), [("embree", "uniform:n=64", tracer), ("osmesa", "accumulate:n=16", raster)]
)
def test_renderers_count_their_rendering(name: str, mode: str, module: object, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the clock in place of instructions: what it counts is the CPU time that the renderer states, but for the
    sleep of the clock's reader; of a scene of 64 x 48 pixels within a fifth and a millisecond."""
    monkeypatch.setattr(module, "counted", lambda: counted(TASK_CLOCK))
    renderer = renderers.find(name)
    scene = scene_io.load("spheres").scene
    cost = renderer.render(Request(scene, 64, 48, renderers.mode_of(renderer, mode), least_seconds=0.05)).cost
    assert cost.instructions == pytest.approx(1e9 * cost.cpu_seconds, rel=0.2, abs=1e6)


@needs_instructions
@pytest.mark.parametrize(("name", "mode"), [("embree", "uniform:n=16"), ("osmesa", "accumulate:n=16")])
def test_instructions_are_the_same_each_time(name: str, mode: str) -> None:
    renderer = renderers.find(name)
    request = Request(scene_io.load("edge").scene, 64, 48, renderers.mode_of(renderer, mode), least_seconds=0.02)
    first, second = (renderer.render(request).cost.instructions for _ in range(2))
    assert first is not None
    assert second == pytest.approx(first, rel=0.01)


def test_povray_states_none() -> None:
    """A process of its own, whose start, reading of the scene and writing of the picture nothing tells from tracing."""
    povray = renderers.find("povray")
    request = Request(scene_io.load("edge").scene, 16, 12, renderers.mode_of(povray, "none"))
    assert povray.render(request).cost.instructions is None
