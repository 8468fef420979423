"""Samplers under test: the library's calls as they are, statuses and all, into memory whose edges are watched."""

from __future__ import annotations

import ctypes
import mmap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.native.loading import error_box, module

UNWRITTEN = 0x7FF8DEADBEEF0001
"""The bits of a value that nobody has written: a NaN of no arithmetic."""
CANARY = 0xA5
SLACK = 1 << 16
"""Bytes to either side of a buffer that a stray write is seen in."""
GUARD = 1 << 24
"""Bytes beyond, of address space alone, that no process may touch."""


def library() -> Any:
    return module("_sampler", "the library libaliascope")


class Memory:
    """Room for `values` doubles between two ranges of pages that no process may touch."""

    def __init__(self, values: int) -> None:
        page = mmap.PAGESIZE
        inner = -(-(8 * values + 2 * SLACK) // page) * page
        self._map = mmap.mmap(-1, inner + 2 * GUARD)
        self._begin = ctypes.addressof(ctypes.c_char.from_buffer(self._map)) + GUARD
        self._end = self._begin + inner
        protect = ctypes.CDLL(None, use_errno=True).mprotect
        protect.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int]
        for guard in (self._begin - GUARD, self._end):
            if protect(guard, GUARD, 0):
                raise OSError(ctypes.get_errno(), "mprotect")

    def in_the_middle(self, values: int) -> Buffer:
        """With SLACK bytes to either side."""
        return Buffer(self._begin + SLACK, values, SLACK, SLACK)

    def at_the_end(self, values: int) -> Buffer:
        """Its last byte is the last before pages that no process may touch."""
        return Buffer(self._end - 8 * values, values, SLACK, 0)

    def at_the_start(self, values: int) -> Buffer:
        """Its first byte is the first after pages that no process may touch."""
        return Buffer(self._begin, values, 0, SLACK)


class Buffer:
    """Doubles at an address, unwritten, with canaries around them."""

    def __init__(self, address: int, values: int, before: int, after: int) -> None:
        self.pointer = library().ffi.cast("double *", address)
        self._before, self._after = _bytes(address - before, before), _bytes(address + 8 * values, after)
        self._before[:], self._after[:] = CANARY, CANARY
        self._values = _bytes(address, 8 * values).view(np.float64)
        self._values.view(np.uint64)[:] = UNWRITTEN

    @property
    def values(self) -> NDArray[np.float64]:
        """A copy."""
        return self._values.copy()

    def stray_before(self) -> int:
        """How far before the start something was written, in bytes; 0 for nowhere."""
        hits = np.flatnonzero(self._before != CANARY)
        return int(len(self._before) - hits[0]) if len(hits) else 0

    def stray_after(self) -> int:
        """How far past the end something was written, in bytes; 0 for nowhere."""
        hits = np.flatnonzero(self._after != CANARY)
        return int(hits[-1]) + 1 if len(hits) else 0


def _bytes(address: int, count: int) -> NDArray[np.uint8]:
    return np.ctypeslib.as_array((ctypes.c_uint8 * count).from_address(address))


def status_name(status: int) -> str:
    """Such as "ASC_UNSUPPORTED"; an unknown one as its number."""
    return str(library().ffi.typeof("asc_status").elements.get(status, f"status {status}"))


class Probe:
    """What creation of a sampler gave: `status`, `message`, and, where the status is ASC_OK, the sampler."""

    def __init__(self, spec: str, samples: int, dimensions: int, seed: int = 0, *, error: bool = True) -> None:
        compiled = library()
        self.samples, self.dimensions = samples, dimensions
        text = compiled.ffi.new("char[]", spec.encode())
        desc = compiled.ffi.new("asc_sampler_desc *", [0, text, samples, dimensions, seed])
        desc.struct_size = compiled.ffi.sizeof("asc_sampler_desc")
        out, box = compiled.ffi.new("asc_sampler **"), error_box(compiled.ffi) if error else compiled.ffi.NULL
        self.status = status_name(compiled.lib.asc_sampler_create(desc, out, box))
        self.message = compiled.ffi.string(box.text).decode(errors="replace") if error else ""
        self._handle = compiled.ffi.gc(out[0], compiled.lib.asc_sampler_destroy) if self.made else compiled.ffi.NULL
        traits = int(compiled.lib.asc_sampler_traits(self._handle))
        self.randomised = bool(traits & compiled.lib.ASC_TRAIT_RANDOMISED)
        self.sequence = bool(traits & compiled.lib.ASC_TRAIT_SEQUENCE)
        self.weighted = bool(traits & compiled.lib.ASC_TRAIT_WEIGHTED)
        known = compiled.lib.ASC_TRAIT_RANDOMISED | compiled.lib.ASC_TRAIT_SEQUENCE | compiled.lib.ASC_TRAIT_WEIGHTED
        self.unknown_traits = traits & ~int(known)

    @property
    def made(self) -> bool:
        return self.status == "ASC_OK"

    def destroy(self) -> None:
        """Now, and not when Python comes to it."""
        if self.made:
            library().ffi.release(self._handle)

    def fill(
        self,
        out: Buffer | None,
        pixel: tuple[int, int],
        first: int,
        count: int,
        first_dimension: int = 0,
        dimension_count: int | None = None,
    ) -> str:
        """asc_sampler_fill to a buffer of count x dimension_count values; the status by name."""
        compiled = library()
        columns = self.dimensions - first_dimension if dimension_count is None else dimension_count
        span = compiled.ffi.new("asc_range *", [*pixel, first, count, first_dimension, columns])
        target = out.pointer if out is not None else compiled.ffi.new("double *")
        return status_name(compiled.lib.asc_sampler_fill(self._handle, span, target))

    def weights(self, out: Buffer, first: int, count: int) -> str:
        """asc_sampler_weights to a buffer of `count` values; the status by name."""
        return status_name(library().lib.asc_sampler_weights(self._handle, first, count, out.pointer))

    def index_end(self) -> int:
        """One past the last index that can be asked for: a range of no samples may begin there, and no later."""
        low, high = 0, 1 << 64
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.fill(None, (0, 0), middle, 0) == "ASC_OK" else (low, middle)
        return low
