"""Contracts of a sampler's values: their range, and that they are the same whenever and wherever they are asked for."""

from __future__ import annotations

import hashlib
import itertools
import math
import threading
import time

import numpy as np
from numpy.typing import NDArray

from aliascope.native.probing import UNWRITTEN, Memory, Probe
from aliascope.studies.plugin_subject import PIXELS, Broken, Finding, Subject, same

SEEDS = (0, 5, 2**64 - 1)
TAIL = 8
"""How many of a sequence's last points are looked at."""


def in_range(subject: Subject) -> Finding:
    """Every value is written and lies in [0, 1), at the ends of seeds, pixels and indices."""
    values = 0
    for (n, d), seed in itertools.product(subject.sizes(), SEEDS):
        probe = subject.made(n, d, seed)
        spans = [(0, n)]
        if probe.sequence:
            end = probe.index_end()
            spans.append((max(end - TAIL, 0), min(TAIL, end)))
        for pixel, (first, count) in itertools.product(PIXELS, spans):
            points = subject.fill(probe, pixel, first, count)
            values += points.size
            wrong = (points.view(np.uint64) == UNWRITTEN) | ~((points >= 0) & (points < 1))
            if not wrong.any():
                continue
            row, column = (int(index[0]) for index in np.nonzero(wrong))
            where = subject.place(probe, pixel, first + row, 1, column, 1)
            raise Broken(f"{where}, seed {seed}: {_described(points[row, column])}")
    return Finding(f"{values} values")


def _described(value: np.float64) -> str:
    if value.view(np.uint64) == UNWRITTEN:
        return "the value is not written"
    return f"the value is {value:g}; values lie in [0, 1)"


def purity(subject: Subject) -> Finding:
    """The same call gives the same bits: again, after other calls, from a second sampler, in a second process."""
    digest = hashlib.sha256()
    count = 0
    for n, d in subject.sizes():
        probe, twin = subject.made(n, d, 3), subject.made(n, d, 3)
        first = subject.fill(probe, (2, 9), 0, n)
        where = subject.place(probe, (2, 9), 0, n, 0, d)
        if not same(first, subject.fill(probe, (2, 9), 0, n)):
            raise Broken(f"{where}: the same call gave other bits the second time")
        subject.fill(probe, (-7, 1), 0, n)
        if not same(first, subject.fill(probe, (2, 9), 0, n)):
            raise Broken(f"{where}: the same call gave other bits after one for another pixel")
        if not same(first, subject.fill(twin, (2, 9), 0, n)):
            raise Broken(f"{where}: two samplers that were made alike give different bits")
        weights = subject.weights(probe, 0, n)
        if not same(weights, subject.weights(twin, 0, n)):
            raise Broken(f"N = {n}: two samplers that were made alike give different weights")
        digest.update(first.tobytes() + weights.tobytes())
        count += 1
    return Finding(f"{count} sizes, again, from a second sampler and in a second process", digest.hexdigest())


def order(subject: Subject) -> Finding:
    """Any piece, in any order, has the bits of all at once."""
    pieces = 0
    for n, d in subject.sizes():
        probe = subject.made(n, d, 9)
        spans = [(0, n)]
        if probe.sequence:
            end = probe.index_end()
            spans.append((max(end - TAIL, 0), min(TAIL, end)))
        for begin, length in spans:
            whole = subject.fill(probe, (11, 7), begin, length)
            for first, count, first_dimension, columns in _pieces(length, d):
                piece = subject.fill(probe, (11, 7), begin + first, count, first_dimension, columns)
                if not same(piece, whole[first : first + count, first_dimension : first_dimension + columns]):
                    where = subject.place(probe, (11, 7), begin + first, count, first_dimension, columns)
                    raise Broken(
                        f"{where}: other bits than where samples {begin} to {begin + length - 1} are asked for"
                    )
                pieces += 1
    return Finding(f"{pieces} pieces, out of order")


def _pieces(n: int, d: int) -> list[tuple[int, int, int, int]]:
    """(first, count, first dimension, dimensions), in an order that goes to and fro."""
    step = next(prime for prime in (37, 41, 43, 47) if math.gcd(prime, n) == 1)
    singles = [(i * step + n - 1) % n for i in range(min(n, 64))]
    pieces = [(first, 1, 0, d) for first in singles]
    for column in reversed(range(d)):
        pieces += [(0, n, column, 1), (singles[column % len(singles)], 1, column, 1)]
    return [*pieces, (n // 2, n - n // 2, 0, d), (n // 3, n - n // 3, d // 3, d - d // 3), (0, -(-n // 2), 0, d)]


THREADS = 4
BUSY_SECONDS = 0.15


def threads(subject: Subject) -> Finding:
    """Four threads at once, each at its own pixel or piece, get the bits that one alone gets."""
    sizes = _large(subject)
    for n, d in sizes:
        probe = subject.made(n, d, 1)
        jobs = [((0, 0), 0, n), ((5, 6), 0, n), ((-3, 2), n // 3, n - n // 3), ((0, 0), n // 2, n - n // 2)]
        alone = [subject.fill(probe, *job) for job in jobs]
        subject.note(f"in fill from {THREADS} threads at once, N = {n}, D = {d}")
        done, wrong = _at_once(probe, jobs, alone)
        if wrong:
            raise Broken(f"N = {n}, D = {d}: {wrong} of {done} calls from {THREADS} threads at once gave other bits")
    return Finding(f"{THREADS} threads at once, N up to {sizes[-1][0]}")


def _large(subject: Subject) -> list[tuple[int, int]]:
    """A few sizes, one so large that calls overlap, where that takes no time."""
    sizes = [max(subject.sizes(), key=lambda size: size[0] * size[1])]
    probe = subject.made(*sizes[0])
    begin = time.perf_counter()
    subject.fill(probe, (0, 0), 0, probe.samples)
    if time.perf_counter() - begin < 2e-3 and subject.has(16384, sizes[0][1]):
        sizes.append((16384, sizes[0][1]))
    return sizes


def _at_once(
    probe: Probe, jobs: list[tuple[tuple[int, int], int, int]], alone: list[NDArray[np.float64]]
) -> tuple[int, int]:
    """How many calls were made, and how many of them gave other bits than alone."""
    done, wrong = [0] * len(jobs), [0] * len(jobs)
    start = threading.Barrier(len(jobs))
    end = time.perf_counter() + BUSY_SECONDS

    def work(number: int) -> None:
        memory = Memory(alone[number].size)
        expected = alone[number].tobytes()
        start.wait()
        while time.perf_counter() < end:
            buffer = memory.in_the_middle(alone[number].size)
            probe.fill(buffer, *jobs[number])
            wrong[number] += buffer.values.tobytes() != expected
            done[number] += 1

    workers = [threading.Thread(target=work, args=(number,)) for number in range(len(jobs))]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return sum(done), sum(wrong)
