"""Warps of the C library, on numpy arrays: points of the unit square to other domains, the way back, the density.

>>> DISC.sample([[0.5, 0.5], [1.0, 0.5]]).tolist()
[[0.0, 0.0], [1.0, 0.0]]
"""

from __future__ import annotations

import bisect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aliascope.errors import InvalidInput
from aliascope.native.loading import check, error_box, module


def _library() -> Any:
    return module("_sampler", "the library libaliascope")


def _rows(values: ArrayLike, columns: int) -> NDArray[np.float64]:
    """(n, columns), contiguous. Raises InvalidInput."""
    rows = np.ascontiguousarray(values, np.float64)
    if rows.ndim != 2 or rows.shape[1] != columns:
        raise InvalidInput(f"a warp takes an array of shape (n, {columns}); this one is {rows.shape}")
    nowhere = np.isnan(rows).any(axis=1)
    if nowhere.any():
        row = int(nowhere.argmax())
        raise InvalidInput(f"row {row} of what a warp is given is nowhere: {', '.join(map(str, rows[row].tolist()))}")
    return rows


def _mapped(call: Callable[[Any, int, Any], int], rows: NDArray[np.float64], columns: int) -> NDArray[np.float64]:
    made = np.empty((len(rows), columns))
    if len(rows):
        library = _library()
        given, out = (library.ffi.from_buffer("double[]", table) for table in (rows, made))
        status = call(given, len(rows), out)
        if status == library.lib.ASC_INVALID_ARGUMENT:
            # The first row outside: the one that ends the shortest table that is refused.
            row = bisect.bisect_left(range(len(rows)), True, key=lambda last: call(given, last + 1, out) != 0)
            where = ", ".join(map(str, rows[row].tolist()))
            raise InvalidInput(f"row {row} of what a warp is given is outside of its domain: {where}")
        check(library, status)
    return made


@dataclass(frozen=True)
class Warp:
    """A warp of closed form. Raises InvalidInput for a row outside the domain; warp.h says what each domain is."""

    name: str
    columns: int

    def _call(self, what: str) -> Any:
        return getattr(_library().lib, f"asc_{self.name}_{what}")

    def sample(self, u: ArrayLike) -> NDArray[np.float64]:
        """u: (n, 2) in [0, 1]; returns (n, columns)."""
        return _mapped(self._call("sample"), _rows(u, 2), self.columns)

    def inverse(self, points: ArrayLike) -> NDArray[np.float64]:
        """points: (n, columns); returns (n, 2) in [0, 1]."""
        return _mapped(self._call("inverse"), _rows(points, self.columns), 2)

    def pdf(self, points: ArrayLike) -> NDArray[np.float64]:
        """points: (n, columns); returns (n,), per unit of area or steradian. A triangle's is `triangle_pdf`."""
        return _mapped(self._call("pdf"), _rows(points, self.columns), 1).ravel()


DISC = Warp("disc", 2)
COSINE_HEMISPHERE = Warp("cosine_hemisphere", 3)
UNIFORM_HEMISPHERE = Warp("uniform_hemisphere", 3)
SPHERE = Warp("sphere", 3)
TRIANGLE = Warp("triangle", 3)


def triangle_pdf(vertices: ArrayLike) -> float:
    """One over the area of a triangle, of vertices (3, 3). Raises InvalidInput where it has none."""
    library = _library()
    rows = _rows(vertices, 3)
    if len(rows) != 3:
        raise InvalidInput(f"a triangle has three vertices, not {len(rows)}")
    made, box = library.ffi.new("double *"), error_box(library.ffi)
    check(library, library.lib.asc_triangle_pdf(library.ffi.from_buffer("double[]", rows), made, box), box)
    return float(made[0])


class Density:
    """A density that is constant in each cell of a regular grid over [0, 1) or [0, 1)^2.

    weights: (columns,) or (rows, columns), finite, not negative, not all zero. Points are (n, 1), x, or (n, 2), x and
    y: x runs along a row. Raises SpecError for weights that are no density, InvalidInput for other arrays.
    """

    def __init__(self, weights: ArrayLike) -> None:
        given = np.asarray(weights, np.float64, order="C")
        if given.ndim not in (1, 2) or not given.size:
            raise InvalidInput(f"the weights of a density are (columns,) or (rows, columns), not {given.shape}")
        library = _library()
        desc = library.ffi.new("asc_density_desc *")
        desc.struct_size = library.ffi.sizeof("asc_density_desc")
        desc.columns, desc.rows = given.shape[-1], given.shape[0] if given.ndim == 2 else 0
        values = library.ffi.from_buffer("double[]", given)
        desc.weights = values
        out, box = library.ffi.new("asc_density **"), error_box(library.ffi)
        check(library, library.lib.asc_density_create(desc, out, box), box)
        self._handle = library.ffi.gc(out[0], library.lib.asc_density_destroy)
        self.dimensions = given.ndim

    def _call(self, what: str) -> Callable[[Any, int, Any], int]:
        function = getattr(_library().lib, f"asc_density_{what}")
        return lambda rows, n, made: int(function(self._handle, rows, n, made))

    def sample(self, u: ArrayLike) -> NDArray[np.float64]:
        """u: (n, dimensions) in [0, 1]; returns as many points in [0, 1), none in a cell of weight 0."""
        return _mapped(self._call("sample"), _rows(u, self.dimensions), self.dimensions)

    def inverse(self, points: ArrayLike) -> NDArray[np.float64]:
        """The u of points. Raises InvalidInput for one where the density is 0."""
        return _mapped(self._call("inverse"), _rows(points, self.dimensions), self.dimensions)

    def pdf(self, points: ArrayLike) -> NDArray[np.float64]:
        """(n,): weight over mean weight; 0 outside [0, 1)."""
        return _mapped(self._call("pdf"), _rows(points, self.dimensions), 1).ravel()
