"""Filtering of unevenly spread samples by the C library, on numpy arrays: weights, and areas of Voronoi cells.

Methods of weighting are named by specs, "name:key=value,...". All functions raise SpecError for an unknown name, key or
value.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aliascope.errors import InvalidInput
from aliascope.native.filters import made
from aliascope.native.loading import check, error_box, module


def _library() -> Any:
    return module("_sampler", "the library libaliascope")


def _pairs(points: ArrayLike) -> NDArray[np.float64]:
    """(n, 2), contiguous, n >= 1. Raises InvalidInput."""
    given = np.ascontiguousarray(points, np.float64)
    if given.ndim != 2 or given.shape[1] != 2 or not given.size:
        raise InvalidInput(f"samples are an array of shape (n, 2), n at least 1; this one is {given.shape}")
    return given


def weights(points: ArrayLike, method: str = "area", filter: str | None = None) -> NDArray[np.float64]:  # noqa: A002
    """The weights of samples, (n,) of sum 1: the filtered value is their sum with the samples' values.

    points: (n, 2), x and y in pixels from the pixel's centre, within the filter's radius either way. filter: a spec;
    without, the box over the pixel, or the method's own filter (see `registered`). Raises InvalidInput for a sample
    that is not there, Unsupported for a filter that the method does not take, JobFailed where the filter is zero at all
    samples.

    >>> weights([[-0.25, 0.0], [0.0, 0.0], [0.25, 0.0]]).tolist()
    [0.375, 0.25, 0.375]
    """
    library, given = _library(), _pairs(points)
    text, values = library.ffi.new("char[]", method.encode()), np.empty(len(given))
    desc, box = library.ffi.new("asc_uneven_desc *"), error_box(library.ffi)
    desc.struct_size = library.ffi.sizeof("asc_uneven_desc")
    desc.spec, desc.count = text, len(given)
    desc.filter = library.ffi.NULL if filter is None else made(filter).handle
    desc.points = buffer = library.ffi.from_buffer("double[]", given.reshape(-1))
    check(library, library.lib.asc_uneven_weights(desc, library.ffi.from_buffer("double[]", values), box), box)
    del buffer  # it had to last until here
    return values


def voronoi_areas(points: ArrayLike, bounds: tuple[float, float, float, float]) -> NDArray[np.float64]:
    """The areas of the Voronoi cells of points (n, 2), clipped to bounds (left, bottom, right, top): (n,).

    Points at the same place share their cell in equal parts. Raises InvalidInput for a point outside the bounds, or
    bounds without area.

    >>> voronoi_areas([[0.25, 0.5], [0.75, 0.5]], (0.0, 0.0, 1.0, 1.0)).tolist()
    [0.5, 0.5]
    """
    library, given = _library(), _pairs(points)
    areas, box = np.empty(len(given)), error_box(library.ffi)
    buffer = library.ffi.from_buffer
    source, target = buffer("double[]", given.reshape(-1)), buffer("double[]", areas)
    check(library, library.lib.asc_voronoi_areas(source, len(given), list(bounds), target, box), box)
    return areas


def canonical(spec: str) -> str:
    """The canonical form of a method's spec: keys sorted, defaults left out."""
    library = _library()
    text, box = library.ffi.new("char[512]"), error_box(library.ffi)
    check(library, library.lib.asc_weighting_canonical(spec.encode(), text, 512, box), box)
    return str(library.ffi.string(text).decode())


@dataclass(frozen=True)
class WeightingInfo:
    """One line of `aliascope list weightings`. `filter`: the only one that it takes; None: it takes any."""

    name: str
    title: str
    source: str
    parameters: tuple[str, ...]
    filter: str | None


def registered() -> list[WeightingInfo]:
    """All methods of weighting that are registered."""
    library = _library()

    def text(pointer: Any) -> str:
        return str(library.ffi.string(pointer).decode())

    found = []
    for index in range(library.lib.asc_weighting_count()):
        info = library.ffi.new("asc_weighting_info *")
        check(library, library.lib.asc_weighting_describe(index, info))
        entries = [info.parameters[number] for number in range(info.parameter_count)]
        parameters = tuple(
            f"{text(entry.name)}={entry.minimum:g}..{entry.maximum:g}: {text(entry.text)} (default {entry.fallback:g})"
            for entry in entries
        )
        own = text(info.filter) if info.filter else None
        found.append(WeightingInfo(text(info.name), text(info.title), text(info.source), parameters, own))
    return found
