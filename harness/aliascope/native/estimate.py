"""Estimates of integrals by the C library, on numpy arrays: moments, quantiles, strata, estimators.

An integrand is a function of points (count, dimensions) in [0, 1) that gives values (count, channels), or (count,) for
one channel; it is asked for many samples at once. Estimators are named by specs, "name:key=value,...".

>>> Estimator("fixed", "sobol", samples=1024).estimate(lambda x: x[:, 0] * x[:, 1]).means.ravel().round(3).tolist()
[0.249]
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aliascope.errors import AliascopeError, InvalidInput, NotFinite, Unsupported, whole
from aliascope.native import loading
from aliascope.native.loading import check, error_box, keys, module, text
from aliascope.native.samplers import Dimensions, Sampler

Array = NDArray[np.float64]
Integrand = Callable[[Array], ArrayLike]
Warping = Callable[[Array], tuple[Array, Array]]


def _library() -> Any:
    return module("_sampler", "the library libaliascope")


def _one(call: str, *arguments: float) -> float:
    library = _library()
    made = library.ffi.new("double *")
    try:
        check(library, getattr(library.lib, f"asc_{call}")(*arguments, made))
    except AliascopeError as error:
        raise type(error)(f"{call}({', '.join(map(str, arguments))}): {error}") from error
    return float(made[0])


def normal_quantile(p: float) -> float:
    """x with P(X <= x) = p of the standard normal law, within 1e-12, relative. Raises InvalidInput: p is in (0, 1).

    >>> normal_quantile(0.975)
    1.959963984540054...
    """
    return _one("normal_quantile", p)


def student_t_quantile(p: float, degrees: float) -> float:
    """That of Student's t with 1 to 1e12 degrees of freedom. Raises InvalidInput."""
    return _one("student_t_quantile", p, degrees)


def chi_squared_quantile(p: float, degrees: float, *, upper: bool = False) -> float:
    """That of chi-squared with 1 to 1e12 degrees of freedom; `upper`: x with P(X > x) = p. Raises InvalidInput."""
    return _one("chi_squared_upper_quantile" if upper else "chi_squared_quantile", p, degrees)


class Moments:
    """Count, mean and variance of values that come in any number of parts, by Welford's recurrence."""

    def __init__(self, values: ArrayLike = ()) -> None:
        self._library = _library()
        self.handle = self._library.ffi.new("asc_moments *")
        self.add(values)

    def add(self, values: ArrayLike) -> None:
        """Adds values of any shape, in order. Raises NotFinite, and adds none, where one is not finite, or too large
        to square."""
        library = self._library
        given = np.ascontiguousarray(values, np.float64).ravel()
        buffer = library.ffi.from_buffer("double[]", given)
        status = library.lib.asc_moments_add(self.handle, buffer, len(given))
        if status == library.lib.ASC_NUMERIC:
            broken = ~np.isfinite(given)
            number = int(np.argmax(broken if broken.any() else np.abs(given)))
            raise NotFinite(
                f"value {number} of {len(given)} is not a finite number, or too large to square: {given[number]:g}"
            )
        check(library, status)

    def merge(self, other: Moments) -> None:
        """Adds the values of another."""
        check(self._library, self._library.lib.asc_moments_merge(self.handle, other.handle))

    def _summary(self) -> Any:
        made = self._library.ffi.new("asc_moments_summary *")
        check(self._library, self._library.lib.asc_moments_summarise(self.handle, made))
        return made

    @property
    def count(self) -> int:
        return int(self.handle.count)

    @property
    def mean(self) -> float:
        """NaN without values."""
        return float(self._summary().mean)

    @property
    def variance(self) -> float:
        """Unbiased, of one value; NaN with fewer than two."""
        return float(self._summary().variance)

    @property
    def standard_error(self) -> float:
        """Of the mean; NaN with fewer than two."""
        return float(self._summary().standard_error)

    def interval(self, confidence: float = 0.95) -> tuple[float, float]:
        """Student's interval about the mean. Raises InvalidInput with fewer than two values."""
        library = self._library
        made = library.ffi.new("double[2]")
        check(library, library.lib.asc_moments_interval(self.handle, confidence, made, made + 1))
        return float(made[0]), float(made[1])


@dataclass(frozen=True)
class Stratified:
    """The mean over a domain in strata, its standard error and about how many degrees of freedom that has."""

    mean: float
    standard_error: float
    degrees: float


def stratify(strata: Sequence[Moments], sizes: Sequence[float] | None = None) -> Stratified:
    """The mean over strata of these sizes, all alike if not given; estimate.h has the formulas.

    Strata of one value are collapsed in pairs, in their order. Raises InvalidInput for an empty stratum.
    """
    library = _library()
    given = [1.0] * len(strata) if sizes is None else list(sizes)
    if len(given) != len(strata):
        raise InvalidInput(f"{len(strata)} strata have not {len(given)} sizes")
    table = library.ffi.new("asc_stratum[]", len(strata))
    for entry, stratum, size in zip(table, strata, given, strict=True):
        entry.size, entry.moments = size, stratum.handle[0]
    made = library.ffi.new("asc_stratified *")
    check(library, library.lib.asc_stratify(table, len(strata), made))
    return Stratified(made.mean, made.standard_error, made.degrees)


def importance(integrand: Integrand, warp: Warping) -> Integrand:
    """The integrand of u whose mean is the integral of `integrand`: its value at x over the density of x.

    warp: u (count, dimensions) to x and its densities (count,), such as those of a Density:
    `lambda u: (x := density.sample(u), density.pdf(x))`. Where the density is 0 the value is 0.
    """

    def values(u: Array) -> Array:
        points, pdf = warp(u)
        found = np.asarray(integrand(points), np.float64)
        table = found.reshape(len(u), -1)
        met = pdf > 0.0
        return np.where(met[:, None], table, 0.0) / np.where(met, pdf, 1.0)[:, None]

    return values


@dataclass(frozen=True)
class Estimates:
    """What came out for the pixels of a group: every pixel is an integral of its own over the unit cube.

    means, standard_errors: (rows, columns, channels), the latter NaN where the estimator states none; degrees: (rows,
    columns), of freedom that they have, for Student's t; counts: (rows, columns), samples that were spent on the pixel;
    spent: all samples.
    """

    means: Array
    standard_errors: Array
    degrees: Array
    counts: NDArray[np.uint64]
    spent: int


class _Call:
    """One estimate under way: what is asked, and what went wrong there."""

    def __init__(self, integrand: Integrand, dimensions: int, channels: int) -> None:
        self.integrand, self.dimensions, self.channels = integrand, dimensions, channels
        self.error: BaseException | None = None

    def answer(self, ffi: Any, count: int, points: Any, values: Any) -> None:
        # A copy: the memory is the library's, and the integrand may keep what it is given.
        given = np.frombuffer(ffi.buffer(points, 8 * count * self.dimensions)).reshape(count, self.dimensions).copy()
        found = np.asarray(self.integrand(given), np.float64)
        if found.shape != (count, self.channels) and not (self.channels == 1 and found.shape == (count,)):
            raise InvalidInput(
                f"the integrand gave values of shape {found.shape} for {count} points and {self.channels} channels"
            )
        np.frombuffer(ffi.buffer(values, 8 * count * self.channels))[:] = found.ravel()


@functools.cache
def _callback() -> Any:
    """The function that C calls. It may not raise: what the integrand raises is kept, and the estimate ended."""
    library = _library()

    def aliascope_integrand(context: Any, count: int, pixels: Any, points: Any, values: Any) -> int:
        call = library.ffi.from_handle(context)
        try:
            call.answer(library.ffi, count, points, values)
        except BaseException as error:  # noqa: BLE001  (raised again by `estimate`)
            call.error = error
            return int(library.lib.ASC_INVALID_ARGUMENT)
        return int(library.lib.ASC_OK)

    library.ffi.def_extern()(aliascope_integrand)
    return library.lib.aliascope_integrand


class Estimator:
    """An immutable estimator. sampler: the spec of its sampler; samples: N, the most that a pixel gets; dimensions and
    arrangement: as a Sampler has them.

    Raises SpecError for an unknown name, key or value, Unsupported for a sampler that it cannot use.
    """

    def __init__(
        self,
        spec: str,
        sampler: str = "random",
        samples: int = 1024,
        dimensions: Dimensions = 2,
        channels: int = 1,
        seed: int = 0,
        arrangement: str = "joint",
    ) -> None:
        library = self._library = _library()
        self.sampler = Sampler(sampler, samples, dimensions, seed, arrangement, sequential=True)
        self.channels = channels
        encoded, desc = library.ffi.new("char[]", spec.encode()), library.ffi.new("asc_estimator_desc *")
        desc.struct_size = library.ffi.sizeof("asc_estimator_desc")
        desc.spec, desc.sampler, desc.channels = encoded, self.sampler.handle, channels
        out, box = library.ffi.new("asc_estimator **"), error_box(library.ffi)
        check(library, library.lib.asc_estimator_create(desc, out, box), box)
        self.handle = library.ffi.gc(out[0], library.lib.asc_estimator_destroy)

    @property
    def spec(self) -> str:
        """The canonical spec."""
        library = self._library
        desc = library.ffi.new("asc_estimator_desc *")
        check(library, library.lib.asc_estimator_resolved(self.handle, desc))
        return text(library, desc.spec)

    @property
    def reach(self) -> int:
        """How many pixels outside a group it asks for."""
        return int(self._library.lib.asc_estimator_reach(self.handle))

    def estimate(self, integrand: Integrand, group: tuple[int, int, int, int] = (0, 0, 1, 1)) -> Estimates:
        """The estimates of all pixels of a group (x, y, columns, rows). Raises what the integrand raises; JobFailed
        where one of its values is not finite."""
        library = self._library
        x, y, columns, rows = group
        if min(columns, rows) < 1:
            raise InvalidInput(f"a group has one pixel or more, not {columns} x {rows}")
        for place in (x, y, x + columns - 1, y + rows - 1):
            whole(place, "a pixel's place", -(2**31), 2**31 - 1)
        means = np.empty((rows, columns, self.channels))
        made = Estimates(
            means, np.empty_like(means), np.empty((rows, columns)), np.empty((rows, columns), np.uint64), 0
        )
        buffer = functools.partial(library.ffi.from_buffer, "double[]")
        record = library.ffi.new("asc_estimates *")
        record.struct_size = library.ffi.sizeof("asc_estimates")
        record.means, record.standard_errors = buffer(made.means), buffer(made.standard_errors)
        record.degrees, record.counts = buffer(made.degrees), library.ffi.from_buffer("uint64_t[]", made.counts)
        call = _Call(integrand, self.sampler.dimensions, self.channels)
        context, box = library.ffi.new_handle(call), error_box(library.ffi)
        place = library.ffi.new("asc_group *", [x, y, columns, rows])
        status = library.lib.asc_estimate(self.handle, place, _callback(), context, record, box)
        if call.error is not None:
            raise call.error
        check(library, status, box)
        return Estimates(made.means, made.standard_errors, made.degrees, made.counts, int(record.spent))


def canonical(spec: str) -> str:
    """The canonical form of an estimator's spec: keys sorted, defaults left out. Raises SpecError."""
    library = _library()
    made, box = library.ffi.new("char[512]"), error_box(library.ffi)
    check(library, library.lib.asc_estimator_canonical(spec.encode(), made, 512, box), box)
    return text(library, made)


def settings(spec: str) -> dict[str, str]:
    """All keys of a canonical spec with their values, those left out too."""
    return loading.settings(_library(), "estimator", spec)


def refusal(
    spec: str,
    sampler: str,
    samples: int,
    dimensions: Dimensions = 2,
    channels: int = 1,
    arrangement: str = "joint",
) -> str | None:
    """Why an estimator cannot use this sampler, or None. Raises SpecError for values that do not go together."""
    try:
        Estimator(spec, sampler, samples, dimensions, channels, arrangement=arrangement)
    except Unsupported as error:
        return str(error)
    return None


@dataclass(frozen=True)
class EstimatorInfo:
    """One line of `aliascope list estimators`."""

    name: str
    title: str
    source: str
    parameters: tuple[str, ...]


def registered() -> list[EstimatorInfo]:
    """All estimators that are registered."""
    library = _library()
    found = []
    for index in range(library.lib.asc_estimator_count()):
        info = library.ffi.new("asc_estimator_info *")
        check(library, library.lib.asc_estimator_describe(index, info))
        name, title, source = (text(library, pointer) for pointer in (info.name, info.title, info.source))
        found.append(EstimatorInfo(name, title, source, keys(library, info)))
    return found
