"""Linux's seccomp: a process gives up, for itself and its threads, calls of the kernel that it has no need of.

What is refused here is what lets a process reach others, or start some: programs, processes, sockets, signals, the
memory of others. Files are Landlock's to guard. Like that it needs neither rights nor another program. See the kernel's
Documentation/userspace-api/seccomp_filter.rst, and `man 2 seccomp`, for the numbers of the mode and the fields; those
of calls are from <asm/unistd.h>.
"""

from __future__ import annotations

import ctypes
import errno
import os
import platform
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

_SET_NO_NEW_PRIVS, _SET_SECCOMP, _GET_SECCOMP, _MODE_FILTER = 38, 22, 21, 2
_NUMBER_AT, _MACHINE_AT, _ARGUMENTS_AT = 0, 4, (16, 24)
"""In what a filter is given: the call's number, the machine's, the low halves of the first two arguments."""

_LOAD, _JUMP_EQUAL, _JUMP_AT_LEAST, _JUMP_BITS, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
"""Of the Berkeley packet filter, with words and constants."""
_ALLOW, _REFUSE = 0x7FFF0000, 0x00050000
_THREAD = 0x00010000
"""CLONE_THREAD."""
_OTHER_TABLE = 0x40000000
"""From here on are the calls of x86-64's x32, which are others for the same."""

_REFUSED = {
    "x86_64": {
        "processes and programs": (57, 58, 59, 322),  # fork, vfork, execve, execveat
        "sockets": (41, 53),  # socket, socketpair
        "signals to others": (62, 200, 129, 297, 424),  # kill, tkill, rt_sigqueueinfo, rt_tgsigqueueinfo, pidfd_send_
        "memory and files of others": (
            101,
            310,
            311,
            312,
            438,
            448,
        ),  # ptrace, process_vm_*, kcmp, pidfd_getfd, release
        "queues, keys and rings": (248, 249, 250, 240, 425, 426, 427, 321, 298, 323),
        # add_key, request_key, keyctl, mq_open, io_uring_*, bpf, perf_event_open, userfaultfd
        "memory and semaphores by a number": (29, 30, 64, 68),  # shmget, shmat, semget, msgget
        "namespaces": (272, 308, 165, 161, 155),  # unshare, setns, mount, chroot, pivot_root
        "turns of the processor": (141, 142, 144, 314, 251),  # setpriority, sched_set{param,scheduler,attr}, ioprio_set
    },
    "aarch64": {
        "processes and programs": (221, 281),
        "sockets": (198, 199),
        "signals to others": (129, 130, 138, 240, 424),
        "memory and files of others": (117, 270, 271, 272, 438, 448),
        "queues, keys and rings": (217, 218, 219, 180, 425, 426, 427, 280, 241, 282),
        "memory and semaphores by a number": (194, 196, 190, 186),
        "namespaces": (97, 268, 40, 51, 41),
        "turns of the processor": (140, 118, 119, 274, 30),
    },
}


@dataclass(frozen=True)
class _Machine:
    audit: int
    """As <linux/audit.h> numbers it."""
    clone: int
    of_one: tuple[int, ...]
    """tgkill, prlimit64, sched_setaffinity: of the process or thread that their first argument names, 0 the own."""
    fcntl: int
    prctl: int
    clone3: int = 435


_MACHINES = {
    "x86_64": _Machine(0xC000003E, 56, (234, 302, 203), 72, 157),
    "aarch64": _Machine(0xC00000B7, 220, (131, 261, 122), 25, 167),
}
_OWNERS = (8, 10, 15)
"""F_SETOWN, F_SETSIG, F_SETOWN_EX: who gets a signal, and which, when a file is ready."""
_SET_PARENT_DEATH_SIGNAL = 1
"""PR_SET_PDEATHSIG: it would outlive its parent."""


class _Step(ctypes.Structure):
    _fields_ = (("code", ctypes.c_uint16), ("yes", ctypes.c_uint8), ("no", ctypes.c_uint8), ("k", ctypes.c_uint32))


class _Program(ctypes.Structure):
    _fields_ = (("length", ctypes.c_uint16), ("steps", ctypes.POINTER(_Step)))


def works() -> bool:
    """Whether it can be had here."""
    if sys.platform != "linux" or platform.machine() not in _MACHINES or sys.maxsize < 1 << 32:
        return False
    return bool(ctypes.CDLL(None).prctl(_GET_SECCOMP, 0, 0, 0, 0) >= 0)


def restrict() -> None:
    """Has this thread, and those that it begins from now on, start no program and no process, open no socket, and
    reach no other process; such a call fails with EPERM. Raises OSError."""
    steps = [*_filter(platform.machine(), os.getpid())]
    array = (_Step * len(steps))(*(_Step(*step) for step in steps))
    program = _Program(len(steps), array)
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(_SET_NO_NEW_PRIVS, 1, 0, 0, 0) or libc.prctl(_SET_SECCOMP, _MODE_FILTER, ctypes.byref(program), 0, 0):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def _filter(name: str, own: int) -> Iterator[tuple[int, int, int, int]]:
    """(code, steps to pass over if so, if not, constant) of each step."""
    machine, refused, absent = _MACHINES[name], _REFUSE | errno.EPERM, _REFUSE | errno.ENOSYS
    yield _LOAD, 0, 0, _MACHINE_AT
    yield _JUMP_EQUAL, 1, 0, machine.audit
    yield _RETURN, 0, 0, refused
    yield _LOAD, 0, 0, _NUMBER_AT
    yield _JUMP_AT_LEAST, 0, 1, _OTHER_TABLE
    yield _RETURN, 0, 0, refused
    for number in sorted(number for numbers in _REFUSED[name].values() for number in numbers):
        yield _JUMP_EQUAL, 0, 1, number
        yield _RETURN, 0, 0, refused
    # What is asked for by a structure cannot be looked at: the C library then takes `clone`.
    yield _JUMP_EQUAL, 0, 1, machine.clone3
    yield _RETURN, 0, 0, absent
    yield _JUMP_EQUAL, 0, 4, machine.clone
    yield _LOAD, 0, 0, _ARGUMENTS_AT[0]
    yield _JUMP_BITS, 1, 0, _THREAD
    yield _RETURN, 0, 0, refused
    yield _RETURN, 0, 0, _ALLOW
    for number in machine.of_one:
        yield from _looking(number, 0, [(0, _ALLOW), (own, _ALLOW)], refused)
    yield from _looking(machine.prctl, 0, [(_SET_PARENT_DEATH_SIGNAL, refused)], _ALLOW)
    yield from _looking(machine.fcntl, 1, [(command, refused) for command in _OWNERS], _ALLOW)
    yield _RETURN, 0, 0, _ALLOW


def _looking(
    number: int, argument: int, answers: Sequence[tuple[int, int]], otherwise: int
) -> Iterator[tuple[int, int, int, int]]:
    """The steps for one call that depends on an argument: (value, answer) of each, else another answer."""
    yield _JUMP_EQUAL, 0, 2 + 2 * len(answers), number
    yield _LOAD, 0, 0, _ARGUMENTS_AT[argument]
    for value, answer in answers:
        yield _JUMP_EQUAL, 0, 1, value
        yield _RETURN, 0, 0, answer
    yield _RETURN, 0, 0, otherwise
