"""The rasteriser of the C library on OSMesa (llvmpipe)."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.model import Scene
from aliascope.native.instructions import counted
from aliascope.native.loading import check, error_box, module, said
from aliascope.native.scene import pack
from aliascope.records import Pixels

MULTISAMPLES = 4
"""GL_MAX_SAMPLES of llvmpipe: a pass has 1 sample a pixel, or this many."""

MOST_SHADOW_TESTS = 1024
"""RASTER_MOST_SHADOW_TESTS of raster.h: surfaces x lights of a scene with lights."""


_own_threads = 0
"""Of llvmpipe: 0 draws in the calling thread, whose time is what is measured."""


def use_own_threads(count: int) -> None:
    """Has llvmpipe draw in so many threads of its own. Only before anything else of this module in the process: Mesa
    looks once, when the first context is made."""
    global _own_threads
    _own_threads = count


_NEEDS = "OSMesa (Debian: libosmesa6)"


def _library() -> Any:
    os.environ["LP_NUM_THREADS"] = str(_own_threads)
    return module("_raster", _NEEDS)


def describe() -> tuple[str, str]:
    """GL_RENDERER and GL_VERSION: "llvmpipe (LLVM 15.0.6, 256 bits)", "4.5 (Core Profile) Mesa 22.3.6".

    Raises NotAvailable.
    """
    names = said("_raster", _NEEDS)
    if names is None:
        library = _library()
        text = library.ffi.new("char[]", 256)
        check(library, library.lib.raster_describe(text, len(text)))
        names = library.ffi.string(text).decode(errors="replace")
    renderer, _, version = names.partition("; ")
    return renderer, version


def sample_positions() -> NDArray[np.float64]:
    """The multisample pattern: (4, 2) float64 in [0, 1), from the left and top border of the pixel.

    Raises NotAvailable, and Unsupported where OSMesa has no multisampling (softpipe).
    """
    library, positions = _library(), np.empty((MULTISAMPLES, 2))
    box = error_box(library.ffi)
    check(library, library.lib.raster_sample_positions(library.ffi.from_buffer("double[]", positions), box), box)
    return positions


@dataclass(frozen=True)
class Limits:
    """What OpenGL says: GL_MAX_SAMPLES, the samples of a multisample buffer that was asked for 4, GL_SUBPIXEL_BITS."""

    max_samples: int
    samples: int
    subpixel_bits: int


def limits() -> Limits:
    """Of a context. Raises NotAvailable."""
    library = _library()
    found, box = library.ffi.new("raster_limits *"), error_box(library.ffi)
    check(library, library.lib.raster_ask_limits(found, box), box)
    return Limits(int(found.max_samples), int(found.samples), int(found.subpixel_bits))


@dataclass(frozen=True)
class Passes:
    """The passes of a picture, whose weighted sum it is.

    offsets: (n, 2) in [0, 1), where in the pixel each samples, from its left and top border; with 4 samples a pass
    their pattern is moved by offset - 0.5. weights: (n,), which should sum to 1. sample_shading: patterns, light and
    shadows for each of the 4, at its place, and not once a pixel. Of a scene that needs them, and of no other: times
    (n,); lens (n, 2), points of it to the right and up from its middle, in the scene's units; lights (n, lights with an
    area, 2) in [0, 1), which choose the point of each as tracer.h says.
    """

    offsets: NDArray[np.float64]
    weights: NDArray[np.float64]
    samples_per_pass: int = 1
    sample_shading: bool = False
    times: NDArray[np.float64] | None = None
    lens: NDArray[np.float64] | None = None
    lights: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class RasterCost:
    """Of one picture: all its samples; time of drawing, reading back and summing, on the CPU and by the clock; the
    instructions of that, where they can be counted."""

    samples: int
    cpu_seconds: float
    wall_seconds: float
    instructions: float | None = None


def _to_floats(ffi: Any, packed: Any) -> None:
    """Rounds the places of a packed scene to float: lengths and directions keep their digits."""

    def rounded(places: Any, count: int = 1) -> None:
        values = np.frombuffer(ffi.buffer(places, 24 * count), np.float64)
        values[:] = values.astype(np.float32)

    rounded(packed.view.eye)
    if packed.triangle_count:
        rounded(packed.vertices, 3 * packed.triangle_count)
    kinds = (("discs", "disc", "centre"), ("spheres", "sphere", "centre"), ("planes", "plane", "point"))
    for several, one, place in kinds:
        for i in range(getattr(packed, f"{one}_count")):
            rounded(getattr(getattr(packed, several)[i], place))
    for i in range(packed.material_count):
        rounded(packed.materials[i].pattern.origin)
    for i in range(packed.light_count):
        if packed.lights[i].kind != ffi.typeof("asc_light_kind").relements["ASC_LIGHT_DIRECTIONAL"]:
            rounded(packed.lights[i].place)
    for i in range(packed.motion_count):
        motion = packed.motions[i]
        rounded(motion.centre)
        if motion.frame_count:
            rounded(motion.frames, 3 * motion.frame_count * motion.frame_triangles)


class Raster:
    """A scene, loaded into a context of its own for one size of picture, which is moved by `shift` pixels to the right
    and down. floats: places are rounded to float as they stand, as they are in a program that hands its world
    coordinates to OpenGL. Raises NotAvailable, InvalidInput, and Unsupported where shadows need more than
    MOST_SHADOW_TESTS."""

    def __init__(
        self, scene: Scene, size: tuple[int, int], shift: tuple[float, float] = (0.0, 0.0), floats: bool = False
    ) -> None:
        library = _library()
        packed, keep = pack(library.ffi, scene, size, shift)
        if floats:
            _to_floats(library.ffi, packed)
        out, box = library.ffi.new("raster **"), error_box(library.ffi)
        check(library, library.lib.raster_create(packed, out, box), box)
        keep.clear()
        self._handle = library.ffi.gc(out[0], library.lib.raster_destroy)
        self._library, self._size, self._area_lights = library, size, scene.needs().area_lights

    def render(self, passes: Passes) -> tuple[Pixels, RasterCost]:
        """The weighted sum of the passes: (height, width, 3) float32, linear RGB. Raises InvalidInput for passes that
        are not those of the scene."""
        library, (width, height) = self._library, self._size
        desc, keep = library.ffi.new("raster_desc *"), []
        desc.struct_size, desc.samples_per_pass = library.ffi.sizeof("raster_desc"), passes.samples_per_pass
        desc.pass_count, desc.sample_shading = len(passes.weights), passes.sample_shading
        shapes = {"offsets": (2,), "weights": (), "times": (), "lens": (2,), "lights": (self._area_lights, 2)}
        for name, shape in shapes.items():
            given = getattr(passes, name)
            if given is None:
                continue
            if given.shape != (len(passes.weights), *shape):
                raise ValueError(f"{len(passes.weights)} weights and {name} of shape {given.shape}")
            keep.append(np.ascontiguousarray(given, np.float64))
            setattr(desc, name, library.ffi.from_buffer("double[]", keep[-1]))
        pixels = np.empty((height, width, 3), np.float32)
        cost, box = library.ffi.new("raster_cost *"), error_box(library.ffi)
        target = library.ffi.from_buffer("float[]", pixels)
        with counted() as instructions:
            status = library.lib.raster_render(self._handle, desc, target, cost, box)
        check(library, status, box)
        return pixels, RasterCost(cost.samples, cost.cpu_seconds, cost.wall_seconds, instructions.value)
