"""Estimators of the C library: how many samples a pixel gets, and what is made of them."""

from __future__ import annotations

from typing import Any

from aliascope.native.loading import check, error_box, module
from aliascope.native.samplers import Sampler


def _library() -> Any:
    return module("_sampler", "the library libaliascope")


class Estimator:
    """An immutable estimator. sampler: the spec of its sampler; samples: N, the most that a pixel gets.

    Raises SpecError for an unknown name, key or value, Unsupported for a sampler that it cannot use.
    """

    def __init__(
        self,
        spec: str,
        sampler: str = "random",
        samples: int = 1024,
        dimensions: int = 2,
        channels: int = 1,
        seed: int = 0,
    ) -> None:
        library = _library()
        self.sampler = Sampler(sampler, samples, dimensions, seed)
        encoded, desc = library.ffi.new("char[]", spec.encode()), library.ffi.new("asc_estimator_desc *")
        desc.struct_size = library.ffi.sizeof("asc_estimator_desc")
        desc.spec, desc.sampler, desc.channels = encoded, self.sampler.handle, channels
        out, box = library.ffi.new("asc_estimator **"), error_box(library.ffi)
        check(library, library.lib.asc_estimator_create(desc, out, box), box)
        self.handle = library.ffi.gc(out[0], library.lib.asc_estimator_destroy)


def canonical(spec: str) -> str:
    """The canonical form of an estimator's spec. Raises SpecError."""
    library = _library()
    made, box = library.ffi.new("char[512]"), error_box(library.ffi)
    check(library, library.lib.asc_estimator_canonical(spec.encode(), made, 512, box), box)
    return str(library.ffi.string(made).decode())
