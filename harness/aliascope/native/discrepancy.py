"""Discrepancies of point sets by the C library, on numpy arrays.

Measures are named by specs, "name:key=value,...". All functions raise SpecError for an unknown name, key or value.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from aliascope.errors import InvalidInput, whole
from aliascope.native.loading import check, error_box, keys, module, text

CERTAINTIES = ("exact", "bounds", "estimated")


def _library() -> Any:
    return module("_sampler", "the library libaliascope")


@dataclass(frozen=True)
class Measured:
    """What a measure came to.

    certainty: "exact"; "bounds", the truth lies in [lower, upper]; "estimated", a mean over draws with its
    standard error. witness: where an extreme is met, as the measure's title says; closed: with the border counted in.
    """

    spec: str
    value: float
    certainty: str
    lower: float
    upper: float
    standard_error: float
    witness: tuple[float, ...]
    closed: bool

    @property
    def details(self) -> dict[str, Any]:
        """What there is beside the value, as `--json` has it: the certainty; and bounds, a standard error, where an
        extreme is met and whether its border is counted in, if the measure has them."""
        details: dict[str, Any] = {"certainty": self.certainty}
        if self.certainty == "bounds":
            details |= {"lower": self.lower, "upper": self.upper}
        if self.certainty == "estimated":
            details["standard_error"] = self.standard_error
        if self.witness:
            details |= {"witness": list(self.witness), "border": "closed" if self.closed else "open"}
        return details


def measure(spec: str, points: ArrayLike, seed: int = 0) -> Measured:
    """A measure of points, (n, dimensions) in [0, 1].

    Raises InvalidInput for no points or a value outside [0, 1], Unsupported for a count or dimension that the measure
    does not do.

    >>> measure("l2-star", [[0.5, 0.5]]).value
    0.24438131465200...
    """
    library = _library()
    given = np.ascontiguousarray(points, np.float64)
    if given.ndim != 2 or given.size == 0:
        raise InvalidInput(f"points are a table of n rows and d columns, not of shape {given.shape}")
    encoded = library.ffi.new("char[]", spec.encode())
    desc = library.ffi.new("asc_discrepancy_desc *")
    desc.struct_size = library.ffi.sizeof("asc_discrepancy_desc")
    desc.spec, desc.seed = encoded, whole(seed, "a seed", 0, 2**64 - 1)
    desc.points = library.ffi.from_buffer("double[]", given.reshape(-1))
    desc.count, desc.dimensions = given.shape
    made, box = library.ffi.new("asc_measurement *"), error_box(library.ffi)
    made.struct_size = library.ffi.sizeof("asc_measurement")
    check(library, library.lib.asc_discrepancy(desc, made, box), box)
    return Measured(
        spec=canonical(spec),
        value=made.value,
        certainty=CERTAINTIES[made.certainty],
        lower=made.lower,
        upper=made.upper,
        standard_error=made.standard_error,
        witness=tuple(made.witness[0 : made.witness_count]),
        closed=bool(made.closed),
    )


def canonical(spec: str) -> str:
    """The canonical form of a measure's spec: keys sorted, defaults left out."""
    library = _library()
    made, box = library.ffi.new("char[512]"), error_box(library.ffi)
    check(library, library.lib.asc_measure_canonical(spec.encode(), made, 512, box), box)
    return text(library, made)


@dataclass(frozen=True)
class MeasureInfo:
    """One line of `aliascope list measures`. Up to `quick_points` points in two dimensions it takes about a second."""

    name: str
    title: str
    source: str
    parameters: tuple[str, ...]
    least_dimensions: int
    most_dimensions: int
    quick_points: int


def registered() -> list[MeasureInfo]:
    """All measures that are registered."""
    library = _library()
    found = []
    for index in range(library.lib.asc_measure_count()):
        info = library.ffi.new("asc_measure_info *")
        check(library, library.lib.asc_measure_describe(index, info))
        found.append(
            MeasureInfo(
                name=text(library, info.name),
                title=text(library, info.title),
                source=text(library, info.source),
                parameters=keys(library, info),
                least_dimensions=info.least_dimensions,
                most_dimensions=info.most_dimensions,
                quick_points=info.quick_points,
            )
        )
    return found
