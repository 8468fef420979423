"""The same pictures by other instructions of the processor, as another machine would draw them.

Embree is made to use the instructions of 2000 (SSE2), by a library that stands before it (tests/c/embree_isa.c), and
llvmpipe vectors half as wide. Both are settled when a process begins, so other processes draw.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

from aliascope.errors import JobFailed
from aliascope.regression.observe import Target
from aliascope.regression.records import CellName, Observed
from aliascope.regression.verdict import Chances
from aliascope.renderers import osmesa, process
from aliascope.studies import power_pool
from aliascope.studies.power_null import alarms_of
from aliascope.studies.regress_suite import Cell

INSTRUCTIONS = "sse2"
VECTOR_BITS = "128"


@dataclass(frozen=True)
class Elsewhere:
    """Of the pictures that were drawn again by other instructions, how many have other bits; alarms of the run."""

    cells: int
    pictures: int
    other_bits: int
    alarms: tuple[str, ...]


@contextmanager
def instructions(shim: Path) -> Iterator[None]:
    """Processes that begin within this use the older instructions."""
    more = {"EMBREE_ISA": INSTRUCTIONS, "LP_NATIVE_VECTOR_WIDTH": VECTOR_BITS}
    with patch.dict(os.environ, more | process.preloading(shim.resolve())):
        yield


def observe(cell: Cell, target: Target, time_limit: float) -> Observed:
    """A cell with the draws of the suite, by older instructions. Runs in a worker process; raises JobFailed where that
    was not begun within `instructions`."""
    driver = osmesa.RENDERER.versions()["osmesa-driver"]
    if not hasattr(ctypes.CDLL(None), "rtcNewDevice") or f"{VECTOR_BITS} bits" not in driver:
        raise JobFailed(f"this process has the machine's own instructions: {driver}")
    return power_pool.observe(cell, target, time_limit)


def compared(base: Mapping[CellName, Observed], other: Mapping[CellName, Observed], chances: Chances) -> Elsewhere:
    """What a run says of the other pictures, these being blessed."""
    drawn = [
        one.sha256 != two.sha256
        for name, found in other.items()
        for one, two in zip(base[name].replicates, found.replicates, strict=True)
    ]
    alarms = tuple(
        f"{name.text}  {check.family}: {check.about}"
        for name, found in other.items()
        for check in alarms_of(found, base[name], chances)
    )
    return Elsewhere(len(other), len(drawn), sum(drawn), alarms)
