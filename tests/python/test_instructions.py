"""Counting what a call does by the kernel's counters. Most machines of tests show no counter of instructions, so the
same is proven of a clock that most kernels count. Where one does not, there is nothing to be found."""

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


def assert_between(found: float | None, least: float, most: float) -> None:
    """Nothing is found where the kernel does not count the clock."""
    if allowed(TASK_CLOCK):
        assert found is not None
        assert least <= found <= most
    else:
        assert found is None


def test_what_is_inside_is_counted_and_nothing_else() -> None:
    """Nanoseconds of this thread's own: no fewer than its clock finds just inside, no more than just outside."""
    spin(0.02)
    outside = time.thread_time_ns()
    with counted(TASK_CLOCK) as found:
        assert found.value is None
        inside = time.thread_time_ns()
        spin(0.02)
        time.sleep(0.02)
        least = time.thread_time_ns() - inside
    most = time.thread_time_ns() - outside
    spin(0.02)
    assert_between(found.value, least, most)


def test_threads_that_are_started_meanwhile_count_too_and_others_do_not() -> None:
    """The other one, there before, runs while the count is on, and may not be in it."""
    took: dict[str, int] = {}

    def work(name: str, begin: threading.Event) -> None:
        begin.wait()
        begun = time.thread_time_ns()
        spin(0.04)
        took[name] = time.thread_time_ns() - begun

    def started(name: str, begin: threading.Event) -> threading.Thread:
        thread = threading.Thread(target=work, args=(name, begin))
        thread.start()
        return thread

    begin = threading.Event()
    other = started("other", begin)
    outside = time.process_time_ns()
    with counted(TASK_CLOCK) as found:
        own = [started(name, begin) for name in ("first", "second")]
        begin.set()
        for thread in [*own, other]:
            thread.join()
    most = time.process_time_ns() - outside - took["other"]
    assert_between(found.value, took["first"] + took["second"], most)


def test_what_cannot_be_counted_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    with counted(Event(0, 999)) as found:
        spin(0.001)
    assert found.value is None
    monkeypatch.setattr(instructions.platform, "machine", lambda: "abacus")
    with counted(TASK_CLOCK) as found:
        spin(0.001)
    assert found.value is None


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


@pytest.mark.parametrize(
    ("name", "mode", "module"), [("embree", "uniform:n=64", tracer), ("osmesa", "accumulate:n=16", raster)]
)
def test_renderers_count_their_rendering(name: str, mode: str, module: object, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the clock in place of instructions: of one picture no less than the CPU time that the renderer states, and
    no more than what the process took for all of it."""
    monkeypatch.setattr(module, "counted", lambda: counted(TASK_CLOCK))
    renderer = renderers.find(name)
    scene = scene_io.load("spheres").scene
    begun = time.process_time_ns()
    cost = renderer.render(Request(scene, 64, 48, renderers.mode_of(renderer, mode))).cost
    most = time.process_time_ns() - begun
    assert_between(cost.instructions, round(1e9 * cost.cpu_seconds), most)


@pytest.mark.parametrize(("name", "mode"), [("embree", "uniform:n=16"), ("osmesa", "accumulate:n=16")])
def test_instructions_are_the_same_each_time(name: str, mode: str) -> None:
    renderer = renderers.find(name)
    request = Request(scene_io.load("edge").scene, 64, 48, renderers.mode_of(renderer, mode), least_seconds=0.02)
    first, second = (renderer.render(request).cost.instructions for _ in range(2))
    assert (first is not None) == allowed(INSTRUCTIONS)
    assert second == (None if first is None else pytest.approx(first, rel=0.01))


def test_povray_states_none() -> None:
    """A process of its own, whose start, reading of the scene and writing of the picture nothing tells from tracing."""
    povray = renderers.find("povray")
    request = Request(scene_io.load("edge").scene, 16, 12, renderers.mode_of(povray, "none"))
    assert povray.render(request).cost.instructions is None
