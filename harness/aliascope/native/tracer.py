"""The tracer of the C library on Embree."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from aliascope.model import Scene
from aliascope.native import estimate, filters, samplers
from aliascope.native.instructions import Count, counted
from aliascope.native.loading import check, error_box, module, said
from aliascope.native.scene import pack
from aliascope.records import Counts, Pixels

DRAWS = frozenset(
    {
        *("orthographic", "perspective", "lens", "motion", "mesh of frames", "mirror", "gloss", "diffuse bounces"),
        *("polygon", "mesh", "disc", "sphere", "plane"),
        *("zone-plate", "checker"),
        *("point light", "directional light", "area light", "disc light", "sphere light"),
    }
)
"""The features of scenes that it draws."""


_NEEDS = "Embree 3 (Debian: libembree3-3)"


def _library() -> Any:
    return module("_tracer", _NEEDS)


def embree_version() -> str:
    """ "3.13.5", with which the library was compiled. Raises NotAvailable."""
    number = said("_tracer", _NEEDS)
    return _version(int(_library().lib.tracer_embree_version()) if number is None else int(number))


def _version(number: int) -> str:
    return f"{number // 10000}.{number // 100 % 100}.{number % 100}"


PACKETS = (16, 1, 4, 8)
"""Rays that Embree can trace together, the default first."""

FILMS = ("double", "float", "compensated")
"""In what the samples of a picture can be added up, the default first."""


@dataclass(frozen=True)
class Options:
    """What a tracer pays for safety and speed; tracer.h says what each changes.

    packet: one of PACKETS. robust: no ray passes between two triangles that share an edge. film: one of FILMS, of
    pictures with as many samples in every pixel. relative: the eye is subtracted from places in double, before they
    become float, and scenes of any size are traced in lengths that float holds. again: rays from the eye that meet
    nothing beside others that do are looked at again, whether they passed through a corner that triangles share.
    """

    packet: int = PACKETS[0]
    robust: bool = True
    film: str = FILMS[0]
    relative: bool = True
    again: bool = True


@dataclass(frozen=True)
class Kernel:
    """Of the Embree that is loaded: its version; the rays that are traced together; the largest packet that the
    machine's instructions hold, 4 (SSE), 8 (AVX) or 16 (AVX-512); whether no ray passes between triangles that share an
    edge."""

    version: str
    packet: int
    native: int
    robust: bool


@dataclass(frozen=True)
class TracerCost:
    """Of one picture: all samples, those beyond its border too, rays by kind; CPU time of the rendering threads,
    without `build_cpu_seconds`."""

    samples: int
    primary_rays: int
    cpu_seconds: float
    wall_seconds: float
    build_cpu_seconds: float
    shadow_rays: int
    reflection_rays: int
    bounce_rays: int
    instructions: float | None = None
    """Of the rendering threads, where they can be counted."""


class Tracer:
    """A scene, built for one size of picture, which is moved by `shift` pixels to the right and down. Raises
    NotAvailable, InvalidInput."""

    def __init__(
        self,
        scene: Scene,
        size: tuple[int, int],
        shift: tuple[float, float] = (0.0, 0.0),
        options: Options = Options(),  # frozen
    ) -> None:
        library = _library()
        packed, keep = pack(library.ffi, scene, size, shift)
        out, box = library.ffi.new("tracer **"), error_box(library.ffi)
        chosen = library.ffi.new("tracer_options *")
        chosen.struct_size = library.ffi.sizeof("tracer_options")
        chosen.packet, chosen.not_robust, chosen.film = options.packet, not options.robust, FILMS.index(options.film)
        chosen.not_relative, chosen.look_once = not options.relative, not options.again
        check(library, library.lib.tracer_create_with(packed, chosen, out, box), box)
        keep.clear()
        self._handle = library.ffi.gc(out[0], library.lib.tracer_destroy)
        self._library, self._size = library, size

    @property
    def dimensions(self) -> int:
        """How many numbers a sample has; tracer.h says which."""
        return int(self._library.lib.tracer_dimensions(self._handle))

    @property
    def groups(self) -> tuple[int, ...]:
        """How many of these numbers belong together, in their order."""
        library = self._library
        count = library.ffi.new("size_t *")
        library.lib.tracer_groups(self._handle, library.ffi.NULL, count)
        sizes = library.ffi.new("uint32_t[]", int(count[0]))
        library.lib.tracer_groups(self._handle, sizes, count)
        return tuple(sizes)

    @property
    def kernel(self) -> Kernel:
        """How it is traced."""
        found = self._library.ffi.new("tracer_kernel *")
        self._library.lib.tracer_describe(self._handle, found)
        return Kernel(_version(int(found.version)), int(found.packet), int(found.native), bool(found.robust))

    def render(
        self,
        sampler: str,
        samples: int,
        seed: int = 0,
        threads: int = 1,
        reconstruction: str = "box",
        arrangement: str = "joint",
    ) -> tuple[Pixels, TracerCost]:
        """The picture, (height, width, 3) float32 linear RGB, from `samples` points a pixel, whose groups of dimensions
        are so arranged.

        `reconstruction` is the spec of a filter; where it reaches past the pixel, pixels beyond the border are sampled
        too. Raises SpecError; Unsupported for a sampler that has not that many points, or dimensions.
        """
        library, (width, height) = self._library, self._size
        pattern = samplers.Sampler(sampler, samples, self.groups, seed, arrangement)
        profile = filters.made(reconstruction)
        desc = library.ffi.new("tracer_desc *")
        desc.struct_size, desc.threads = library.ffi.sizeof("tracer_desc"), threads
        desc.sampler = library.ffi.cast("asc_sampler *", pattern.handle)
        desc.filter = library.ffi.cast("asc_filter *", profile.handle)
        pixels = np.empty((height, width, 3), np.float32)
        cost, box = library.ffi.new("tracer_cost *"), error_box(library.ffi)
        target = library.ffi.from_buffer("float[]", pixels)
        with counted() as instructions:
            status = library.lib.tracer_render(self._handle, desc, target, cost, box)
        check(library, status, box)
        return pixels, _cost(cost, instructions)

    def render_adaptive(
        self,
        estimator: str,
        sampler: str,
        samples: int,
        seed: int = 0,
        threads: int = 1,
        arrangement: str = "joint",
    ) -> tuple[Pixels, Counts, TracerCost]:
        """The picture, and the samples of each pixel, at most `samples`, that the estimator of this spec took.

        Raises SpecError, Unsupported for a sampler that the estimator cannot use.
        """
        library, (width, height) = self._library, self._size
        made = estimate.Estimator(estimator, sampler, samples, self.groups, 3, seed, arrangement)
        desc = library.ffi.new("tracer_adaptive_desc *")
        desc.struct_size, desc.threads = library.ffi.sizeof("tracer_adaptive_desc"), threads
        desc.estimator = library.ffi.cast("asc_estimator *", made.handle)
        pixels, counts = np.empty((height, width, 3), np.float32), np.empty((height, width), np.uint32)
        cost, box = library.ffi.new("tracer_cost *"), error_box(library.ffi)
        buffer = library.ffi.from_buffer
        targets = buffer("float[]", pixels), buffer("uint32_t[]", counts)
        with counted() as instructions:
            status = library.lib.tracer_render_adaptive(self._handle, desc, *targets, cost, box)
        check(library, status, box)
        return pixels, counts, _cost(cost, instructions)


def _cost(cost: Any, instructions: Count) -> TracerCost:
    counted_there = {field.name: getattr(cost, field.name) for field in fields(TracerCost) if hasattr(cost, field.name)}
    return TracerCost(**counted_there, instructions=instructions.value)
