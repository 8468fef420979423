"""Sampling patterns of the C library, as numpy arrays."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput, JobFailed, NotFinite, SpecError, Unsupported, near_misses, whole
from aliascope.native import loading, plugin_process
from aliascope.native.loading import check, error_box, keys, module, text


def _library() -> Any:
    return module("_sampler", "the library libaliascope")


Dimensions = int | Sequence[int]
"""How many, or the sizes of the groups that they come in: (2, 1, 2) for the pixel, the time and the lens."""

ARRANGEMENTS = ("joint", "padded", "decorrelated")
"""How groups of dimensions go together; sampler.h, asc_arrangement, says what each is."""


class Sampler:
    """An immutable sampler of the C library.

    spec: "name:key=value,..."; samples: N, the points of one pixel; dimensions: how many, or in which groups; seed: 0
    to 2^64 - 1; arrangement: of the groups. sequential: a sequence stays one when it is padded.
    Raises SpecError for an unknown name, key or value, Unsupported for a count that the pattern cannot have.
    """

    def __init__(
        self,
        spec: str,
        samples: int = 1,
        dimensions: Dimensions = 2,
        seed: int = 0,
        arrangement: str = "joint",
        *,
        sequential: bool = False,
    ) -> None:
        library = _library()
        encoded = library.ffi.new("char[]", spec.encode())
        whole(samples, "a number of samples", 0, 2**64 - 1)
        whole(seed, "a seed", 0, 2**64 - 1)
        groups = (dimensions,) if isinstance(dimensions, int) else tuple(dimensions)
        if arrangement not in ARRANGEMENTS:
            raise SpecError(
                f'unknown arrangement of dimensions "{arrangement}"{near_misses(arrangement, ARRANGEMENTS)}'
            )
        for size in groups:
            whole(size, "a number of dimensions", 1, 2**32 - 1)
        sizes = library.ffi.new("uint32_t[]", groups)
        desc = library.ffi.new("asc_arrangement_desc *")
        desc.struct_size = library.ffi.sizeof("asc_arrangement_desc")
        desc.spec, desc.samples, desc.seed, desc.sequential = encoded, samples, seed, sequential
        desc.groups, desc.group_count = sizes, len(groups)
        desc.arrangement = getattr(library.lib, f"ASC_ARRANGEMENT_{arrangement.upper()}")
        out, box = library.ffi.new("asc_sampler **"), error_box(library.ffi)
        plugin_process.renew()
        check(library, library.lib.asc_sampler_arrange(desc, out, box), box)
        self.handle = library.ffi.gc(out[0], library.lib.asc_sampler_destroy)
        self.dimensions = sum(groups)
        self._library = library

    def points(self, count: int, first: int = 0, pixel: tuple[int, int] = (0, 0)) -> NDArray[np.float64]:
        """Samples [first, first + count) of a pixel: (count, dimensions) float64 in [0, 1). Raises JobFailed where a
        plugin's are not."""
        library = self._library
        whole(first, "an index", 0, 2**64 - 1)
        for place in pixel:
            whole(place, "a pixel's place", -(2**31), 2**31 - 1)
        made = np.empty((whole(count, "a number of points", 0, 2**53), self.dimensions))
        span = library.ffi.new("asc_range *", [*pixel, first, count, 0, self.dimensions])
        status = library.lib.asc_sampler_fill(self.handle, span, library.ffi.from_buffer("double[]", made))
        if status == library.lib.ASC_UNSUPPORTED:
            raise Unsupported(f"{self.spec} has no points {first} to {first + count - 1}: its indices end before")
        if status == library.lib.ASC_OUT_OF_RANGE:
            sample, dimension = (int(i) for i in np.argwhere(~((made >= 0.0) & (made < 1.0)))[0])
            raise JobFailed(
                f"the sampler {self.spec} gave a value outside [0, 1): {made[sample, dimension]:g} as number "
                f"{dimension} of sample {first + sample} of pixel {pixel}"
            )
        check(library, status)
        return made

    def weights(self, count: int, first: int = 0) -> NDArray[np.float64]:
        """(count,) float64: those of a quadrature rule, else 1/N. Raises NotFinite where a plugin's are not."""
        library = self._library
        whole(first, "an index", 0, 2**64 - 1)
        made = np.empty(whole(count, "a number of points", 0, 2**53))
        buffer = library.ffi.from_buffer("double[]", made)
        status = library.lib.asc_sampler_weights(self.handle, first, count, buffer)
        if status == library.lib.ASC_NUMERIC:
            sample = int(np.argmin(np.isfinite(made)))
            raise NotFinite(f"the sampler {self.spec} gives sample {first + sample} the weight {made[sample]:g}")
        check(library, status)
        return made

    @property
    def spec(self) -> str:
        """The canonical spec."""
        library = self._library
        desc = library.ffi.new("asc_sampler_desc *")
        check(library, library.lib.asc_sampler_resolved(self.handle, desc))
        return text(library, desc.spec)

    @property
    def randomised(self) -> bool:
        """Whether the points depend on seed and pixel."""
        library = self._library
        return bool(library.lib.asc_sampler_traits(self.handle) & library.lib.ASC_TRAIT_RANDOMISED)

    @property
    def weighted(self) -> bool:
        """Whether this is a rule of quadrature, whose points have weights other than 1/N."""
        library = self._library
        return bool(library.lib.asc_sampler_traits(self.handle) & library.lib.ASC_TRAIT_WEIGHTED)


def canonical(spec: str) -> str:
    """The canonical form of a sampler's spec. Raises SpecError."""
    try:
        return Sampler(spec).spec
    except Unsupported:  # a pattern of space and time, which has three dimensions alone; Cook's has 16 points alone
        return Sampler(spec, 16, 3).spec


def settings(spec: str) -> dict[str, str]:
    """All keys of a canonical spec with their values, those left out too."""
    return loading.settings(_library(), "sampler", spec)


def points(
    spec: str,
    n: int,
    dimensions: Dimensions = 2,
    seed: int = 0,
    pixel: tuple[int, int] = (0, 0),
    first: int = 0,
    arrangement: str = "joint",
) -> NDArray[np.float64]:
    """n points of one pixel, (n, dimensions) float64 in [0, 1), those of index `first` to first + n - 1.

    `dimensions`: how many, or the sizes of their groups, which the arrangement puts together.

    A pattern that is no sequence has N = n points, so for it `first` is 0. Raises SpecError; Unsupported for a count,
    dimension or index that the pattern does not have.

    >>> points("sobol", 4).tolist()
    [[0.0, 0.0], [0.5, 0.5], [0.25, 0.75], [0.75, 0.25]]
    """
    return Sampler(spec, n, dimensions, seed, arrangement).points(n, first, pixel)


def weights(spec: str, n: int, dimensions: Dimensions = 2, arrangement: str = "joint") -> NDArray[np.float64]:
    """The weights of n points, (n,) float64."""
    return Sampler(spec, n, dimensions, arrangement=arrangement).weights(n)


def randomised(spec: str, n: int, dimensions: Dimensions = 2, arrangement: str = "joint") -> bool:
    """Whether this pattern depends on seed and pixel."""
    return Sampler(spec, n, dimensions, arrangement=arrangement).randomised


def refusal(spec: str, n: int, dimensions: Dimensions = 2, arrangement: str = "joint") -> str | None:
    """Why a pattern has no n points, or None."""
    try:
        Sampler(spec, n, dimensions, arrangement=arrangement)
    except Unsupported as error:
        return str(error)
    return None


@dataclass(frozen=True)
class Plugin:
    """A plugin that is loaded: its resolved path, the SHA-256 of the file, the names of the samplers it registered, and
    whether it runs in this process, trusted, not behind a fence in its own."""

    path: str
    sha256: str
    samplers: tuple[str, ...]
    trusted: bool

    @property
    def version(self) -> str:
        """What its points and their times depend on."""
        return f"{self.sha256}, trusted" if self.trusted else self.sha256

    @property
    def where(self) -> str:
        """Where it runs, and what that does to its times, for people."""
        return "trusted" if self.trusted else "behind a fence: its times have that in them"

    @property
    def option(self) -> str:
        """Of the command line, before the path."""
        return "--trust-plugin" if self.trusted else "--plugin"


_plugins: dict[str, Plugin] = {}


def load_plugin(path: str, *, trusted: bool = False) -> None:
    """Registers the sampler of a plugin, which runs in a process of its own behind a fence, as `plugin_fence` says; a
    trusted one in this process, with all that this may do. One that is loaded already stays. Raises InvalidInput."""
    resolved = str(Path(path).resolve())
    if resolved in _plugins:
        if _plugins[resolved].trusted != trusted:
            raise InvalidInput(f"{path}: give it with --plugin or with --trust-plugin, not with both")
        return
    library, box = _library(), error_box(_library().ffi)
    known = library.lib.asc_sampler_count()
    if trusted:
        check(library, library.lib.asc_plugin_load(os.fsencode(resolved), box), box)
    else:
        plugin_process.begin(resolved)
    names = tuple(info.name for info in registered()[known:])
    _plugins[resolved] = Plugin(resolved, hashlib.sha256(Path(resolved).read_bytes()).hexdigest(), names, trusted)


def plugins() -> tuple[Plugin, ...]:
    """The plugins that are loaded, in the order of loading."""
    return tuple(_plugins.values())


@dataclass(frozen=True)
class SamplerInfo:
    """One line of `aliascope list samplers`; parameters as "key=values: help (default value)"."""

    name: str
    title: str
    source: str
    parameters: tuple[str, ...]
    plugged_in: bool


def registered() -> list[SamplerInfo]:
    """All samplers that are registered, built-in ones first."""
    library = _library()
    found = []
    for index in range(library.lib.asc_sampler_count()):
        info = library.ffi.new("asc_sampler_info *")
        check(library, library.lib.asc_sampler_describe(index, info))
        name, title, source = (text(library, pointer) for pointer in (info.name, info.title, info.source))
        found.append(SamplerInfo(name, title, source, keys(library, info), bool(info.plugged_in)))
    return found
