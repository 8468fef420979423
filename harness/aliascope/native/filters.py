"""Reconstruction filters of the C library, as functions of numpy arrays.

A filter is given by a profile in one dimension, even and of integral 1, x in pixels; the filter of a picture is the
product of the profile along x and along y. Specs: "name:key=value,...". All functions raise SpecError for an unknown
name, key or value.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aliascope.errors import InvalidInput
from aliascope.native import loading
from aliascope.native.loading import check, error_box, keys, module, text

MOST_FREQUENCY = 1000
"""In cycles a pixel, of `Filter.response`."""


def _library() -> Any:
    return module("_sampler", "the library libaliascope")


class Filter:
    """An immutable filter of the C library."""

    def __init__(self, spec: str) -> None:
        library = _library()
        encoded = library.ffi.new("char[]", spec.encode())
        desc = library.ffi.new("asc_filter_desc *", [library.ffi.sizeof("asc_filter_desc"), encoded])
        out, box = library.ffi.new("asc_filter **"), error_box(library.ffi)
        check(library, library.lib.asc_filter_create(desc, out, box), box)
        self.handle = library.ffi.gc(out[0], library.lib.asc_filter_destroy)
        self._library = library

    @property
    def spec(self) -> str:
        """The canonical spec."""
        library = self._library
        desc = library.ffi.new("asc_filter_desc *")
        check(library, library.lib.asc_filter_resolved(self.handle, desc))
        return text(library, desc.spec)

    @property
    def radius(self) -> float:
        """In pixels."""
        return float(self._library.lib.asc_filter_radius(self.handle))

    def evaluate(self, x: ArrayLike) -> NDArray[np.float64]:
        """The profile at x, of x's shape; zero for x < -radius and x >= radius. Raises InvalidInput for NaN."""
        if np.isnan(x).any():
            raise InvalidInput(f"position {int(np.isnan(x).argmax())} of those to evaluate {self.spec} at is nan")
        return self._mapped(self._library.lib.asc_filter_evaluate, x)

    def response(self, frequencies: ArrayLike) -> NDArray[np.float64]:
        """The profile's Fourier transform, real and even, at frequencies in cycles a pixel, within 1e-12.

        Raises InvalidInput beyond MOST_FREQUENCY either way, and for NaN.
        """
        outside = ~(np.abs(frequencies) <= MOST_FREQUENCY)  # as NaN is
        if outside.any():
            wrong = np.ravel(frequencies)[int(outside.argmax())]
            raise InvalidInput(
                f"the response of {self.spec} at {wrong} cycles a pixel: it is had up to {MOST_FREQUENCY}"
            )
        return self._mapped(self._library.lib.asc_filter_response, frequencies)

    def integral(self, a: float, b: float) -> float:
        """The profile's integral from a to b, within 1e-14. Either may be infinite. Raises InvalidInput for NaN."""
        if math.isnan(a) or math.isnan(b):
            raise InvalidInput(f"an integral of {self.spec} from {a} to {b}")
        made = self._library.ffi.new("double *")
        check(self._library, self._library.lib.asc_filter_integral(self.handle, a, b, made))
        return float(made[0])

    def _mapped(self, function: Any, x: ArrayLike) -> NDArray[np.float64]:
        given = np.ascontiguousarray(x, np.float64)
        made = np.empty_like(given)
        if given.size:
            buffer = self._library.ffi.from_buffer
            source, target = buffer("double[]", given.ravel()), buffer("double[]", made.reshape(-1))
            check(self._library, function(self.handle, source, given.size, target))
        return made.reshape(np.shape(x))


@functools.lru_cache(maxsize=256)
def made(spec: str) -> Filter:
    """The filter of a spec, made once."""
    return Filter(spec)


def canonical(spec: str) -> str:
    """The canonical form of a filter's spec: keys sorted, defaults left out."""
    return made(spec).spec


def settings(spec: str) -> dict[str, str]:
    """All keys of a canonical spec with their values, those left out too."""
    return loading.settings(_library(), "filter", spec)


def radius(spec: str) -> float:
    """Half the width of a filter, in pixels."""
    return made(spec).radius


def evaluate(spec: str, x: ArrayLike) -> NDArray[np.float64]:
    """A filter's profile at x, of x's shape.

    >>> evaluate("tent", [0.0, 0.25, 1.0]).tolist()
    [1.0, 0.75, 0.0]
    """
    return made(spec).evaluate(x)


def integral(spec: str, a: float, b: float) -> float:
    """The integral of a filter's profile from a to b, either of which may be infinite, within 1e-14."""
    return made(spec).integral(a, b)


def response(spec: str, frequencies: ArrayLike) -> NDArray[np.float64]:
    """The Fourier transform of a filter's profile, real and even, at frequencies in cycles a pixel, within 1e-12."""
    return made(spec).response(frequencies)


@dataclass(frozen=True)
class FilterInfo:
    """One line of `aliascope list filters`; parameters as "key=values: help (default value)"."""

    name: str
    title: str
    source: str
    parameters: tuple[str, ...]


def registered() -> list[FilterInfo]:
    """All filters that are registered."""
    library = _library()
    found = []
    for index in range(library.lib.asc_filter_count()):
        info = library.ffi.new("asc_filter_info *")
        check(library, library.lib.asc_filter_describe(index, info))
        name, title, source = (text(library, pointer) for pointer in (info.name, info.title, info.source))
        found.append(FilterInfo(name, title, source, keys(library, info)))
    return found
