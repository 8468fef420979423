"""Counting what a call does by the kernel's counters. Most machines of tests show no counter of instructions, so the
same is proven of what most kernels count. Where one does not, there is nothing to be found."""

from __future__ import annotations

import mmap
import os
import threading
import time
from pathlib import Path

import pytest

from aliascope import renderers, scene_io
from aliascope.native import instructions, raster, tracer
from aliascope.native.instructions import INSTRUCTIONS, TASK_CLOCK, Event, counted
from aliascope.renderers.base import Request

PAGE_FAULTS = Event(1, 2)
"""PERF_COUNT_SW_PAGE_FAULTS: the first touches of pages, which are as many whatever else the machine does."""
PAGES = 512


def touch(pages: int) -> None:
    """Pages of memory that were never touched before, one at a time."""
    with mmap.mmap(-1, pages * mmap.PAGESIZE, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS) as memory:
        memory.madvise(mmap.MADV_NOHUGEPAGE)
        for page in range(pages):
            memory[page * mmap.PAGESIZE] = 1


def allowed(event: Event) -> bool:
    with counted(event) as found:
        touch(1)
    return found.value is not None


def assert_touched(found: float | None, pages: int) -> None:
    """So many pages, and what little else is touched meanwhile; nothing where the kernel does not count them."""
    if allowed(PAGE_FAULTS):
        assert found is not None
        assert pages <= found < pages + PAGES
    else:
        assert found is None


def test_what_is_inside_is_counted_and_nothing_else() -> None:
    touch(4 * PAGES)
    with counted(PAGE_FAULTS) as found:
        assert found.value is None
        touch(2 * PAGES)
    touch(4 * PAGES)
    assert_touched(found.value, 2 * PAGES)


def test_threads_that_are_started_meanwhile_count_too_and_others_do_not() -> None:
    """The other one, there before, works while the count is on, and may not be in it."""

    def work(begin: threading.Event, pages: int) -> None:
        begin.wait()
        touch(pages)

    def started(begin: threading.Event, pages: int) -> threading.Thread:
        thread = threading.Thread(target=work, args=(begin, pages))
        thread.start()
        return thread

    begin = threading.Event()
    other = started(begin, 4 * PAGES)
    with counted(PAGE_FAULTS) as found:
        own = [started(begin, PAGES), started(begin, 2 * PAGES)]
        begin.set()
        for thread in [*own, other]:
            thread.join()
    assert_touched(found.value, 3 * PAGES)


def test_what_cannot_be_counted_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    with counted(Event(0, 999)) as found:
        touch(1)
    assert found.value is None
    monkeypatch.setattr(instructions.platform, "machine", lambda: "abacus")
    with counted(TASK_CLOCK) as found:
        touch(1)
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
    """With the clock in place of instructions. It runs in interrupts too, which the renderer's does not: of one picture
    it is no less than what that states, and no more than the processors had meanwhile."""
    monkeypatch.setattr(module, "counted", lambda: counted(TASK_CLOCK))
    renderer = renderers.find(name)
    scene = scene_io.load("spheres").scene
    begun = time.perf_counter()
    cost = renderer.render(Request(scene, 64, 48, renderers.mode_of(renderer, mode))).cost
    had = (time.perf_counter() - begun) * (os.cpu_count() or 1)
    if allowed(TASK_CLOCK):
        assert cost.instructions is not None
        assert cost.cpu_seconds <= 1e-9 * cost.instructions <= had
    else:
        assert cost.instructions is None


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
