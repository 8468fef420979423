"""Instructions that the processor carried out for a call, counted by its own counters through Linux's perf_event_open.

Of user space alone, of this thread and of those that it starts meanwhile. There is nothing to count where the kernel
does not allow it (/proc/sys/kernel/perf_event_paranoid above 2, most containers) or the machine shows no counters, as
most virtual ones.
"""

from __future__ import annotations

import ctypes
import fcntl
import os
import platform
import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

_NUMBERS = {"x86_64": 298, "aarch64": 241, "riscv64": 241, "ppc64le": 319, "s390x": 331}
"""Of the system call, by machine (Linux's tables of system calls)."""

# <linux/perf_event.h>: attr.size of its first version, the flags of attr, and the requests.
_ATTRIBUTES = 64
_DISABLED, _INHERIT, _NO_KERNEL, _NO_HYPERVISOR = 1 << 0, 1 << 1, 1 << 5, 1 << 6
_TIME_ENABLED, _TIME_RUNNING = 1 << 0, 1 << 1
_ENABLE, _DISABLE = 0x2400, 0x2401
_CLOSE_ON_EXEC = 1 << 3


@dataclass(frozen=True)
class Event:
    """What is counted: a type and number of the kernel's."""

    kind: int
    number: int


INSTRUCTIONS = Event(0, 1)
"""PERF_TYPE_HARDWARE, PERF_COUNT_HW_INSTRUCTIONS."""
TASK_CLOCK = Event(1, 1)
"""PERF_TYPE_SOFTWARE, PERF_COUNT_SW_TASK_CLOCK: nanoseconds that the threads ran, which every kernel counts."""


@dataclass
class Count:
    """How many there were, once the call has ended; None where they cannot be counted."""

    value: float | None = None


@contextmanager
def counted(event: Event = INSTRUCTIONS) -> Iterator[Count]:
    """Counts what is done inside. Where the processor has fewer counters than are in use, its share is scaled up."""
    found = Count()
    descriptor = _open(event)
    if descriptor is None:
        yield found
        return
    try:
        fcntl.ioctl(descriptor, _ENABLE, 0)
        yield found
        fcntl.ioctl(descriptor, _DISABLE, 0)
        value, enabled, running = struct.unpack("QQQ", os.read(descriptor, 24))
        if running:
            found.value = value * (enabled / running)
    finally:
        os.close(descriptor)


def _open(event: Event) -> int | None:
    number = _NUMBERS.get(platform.machine())
    if number is None:
        return None
    flags = _DISABLED | _INHERIT | _NO_KERNEL | _NO_HYPERVISOR
    # type, size, config, sample_period, sample_type, read_format, flags, wakeup_events, bp_type, config1
    shape = struct.pack(
        "IIQQQQQIIQ", event.kind, _ATTRIBUTES, event.number, 0, 0, _TIME_ENABLED | _TIME_RUNNING, flags, 0, 0, 0
    )
    with suppress(OSError, AttributeError):
        call = ctypes.CDLL(None, use_errno=True).syscall
        call.restype = ctypes.c_long
        here, any_processor, no_group = ctypes.c_long(0), ctypes.c_long(-1), ctypes.c_long(-1)
        attributes = ctypes.create_string_buffer(shape, _ATTRIBUTES)
        opened = call(ctypes.c_long(number), attributes, here, any_processor, no_group, ctypes.c_ulong(_CLOSE_ON_EXEC))
        return int(opened) if opened >= 0 else None
    return None
