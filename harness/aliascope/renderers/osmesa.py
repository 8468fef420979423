"""OSMesa: the rasteriser llvmpipe, with its multisampling or as an accumulation buffer."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import JobFailed, Unsupported
from aliascope.geometry import surfaces_of
from aliascope.model import Scene
from aliascope.native import raster, samplers
from aliascope.records import Cost, Rendering
from aliascope.renderers.base import Request
from aliascope.specs import Form, Key, Spec

CENTRE = (0.5, 0.5)

EIGHT = ((0.5 - 1 / 16, 0.5 - 3 / 16), (0.5 + 1 / 16, 0.5 + 3 / 16))
"""Two passes of the pattern of 4, (1/8, 3/8) pixel apart: half the diagonal of its cell, (1/2, 1/4) + (-1/4, 1/2).

Of the moves by sixteenths that give 8 rows and 8 columns it has the least error over half-planes of all directions:
rms .0513, where (1/8, 1/8) has .0568, the pattern of 4 alone .0777, and the standard pattern of 8 .0486.
"""

NONE = Form("none", "one sample at the centre of each pixel")
MSAA = Form(
    "msaa",
    "multisampling: coverage from n samples. Without sample-shading patterns, light and shadows are evaluated once a "
    "pixel and pass, at its centre, so that outlines gain, and a zone plate or the edge of a check or a shadow gains "
    "nothing; endless planes, discs and spheres are cut out at each sample in either case. "
    "n=8 is two passes of the pattern of 4, moved by (-1/16, -3/16) and (1/16, 3/16) pixel: 8 rows and 8 columns, "
    "two samples 1/16 pixel outside of the pixel",
    (
        Key("n", "integer", 4, "samples a pixel: 4 or 8", 1, 65536, is_count=True),
        Key("sample-shading", "integer", 0, "1: patterns, light and shadows for each sample, at its place", 0, 1),
    ),
)
ACCUMULATE = Form(
    "accumulate",
    "the accumulation buffer: n passes, moved by the first two dimensions of one sampling pattern for all pixels",
    (
        Key("n", "integer", 16, "passes", 1, 65536, is_count=True),
        Key("sampler", "spec", "halton", "the pattern", inner=samplers.canonical, named=True),
    ),
)


@dataclass(frozen=True)
class Passes:
    """offsets (n, 2) in [0, 1) from the left and top border of the pixel, weights (n,)."""

    offsets: NDArray[np.float64]
    weights: NDArray[np.float64]
    samples_per_pass: int
    sample_shading: bool = False


def passes_of(mode: Spec, seed: int = 0) -> Passes:
    """The passes that a mode draws. Raises Unsupported, SpecError."""
    if reason := _unable(mode):
        raise Unsupported(reason)
    if mode.name == ACCUMULATE.name:
        sampler, count = mode.word("sampler"), mode.integer("n")
        return Passes(samplers.points(sampler, count, 2, seed), samplers.weights(sampler, count, 2), 1)
    if mode.name == NONE.name:
        return Passes(np.array([CENTRE]), np.ones(1), 1)
    offsets = np.array([CENTRE] if mode.integer("n") == raster.MULTISAMPLES else EIGHT)
    weights = np.full(len(offsets), 1.0 / len(offsets))
    return Passes(offsets, weights, raster.MULTISAMPLES, bool(mode.integer("sample-shading")))


def _unable(mode: Spec) -> str | None:
    if mode.name == MSAA.name and mode.integer("n") not in (4, 8):
        return (
            f"{mode.text}: GL_MAX_SAMPLES of llvmpipe is {raster.MULTISAMPLES}, so a pixel has 4 samples, "
            f"or 8 in two passes; accumulate:n={mode.integer('n')} has any count"
        )
    if mode.name == ACCUMULATE.name:
        try:
            samplers.randomised(mode.word("sampler"), mode.integer("n"))
        except Unsupported as error:
            return str(error)
    return None


def _unshadowed(scene: Scene) -> str | None:
    """Why the shadows of a scene are not drawn: there would be too many tests a pixel."""
    if not scene.lights or not any(any(scene.materials[surface.material].albedo) for surface in scene.surfaces):
        return None
    surfaces, lights = surfaces_of(scene), len(scene.lights)
    counts = {
        "triangles": len(surfaces.triangles),
        "discs": len(surfaces.discs),
        "spheres": len(surfaces.spheres),
        "planes": len(surfaces.planes),
    }
    if sum(counts.values()) * lights <= raster.MOST_SHADOW_TESTS:
        return None
    held = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    return (
        f"{held} and {lights} light{'s' if lights > 1 else ''}: OSMesa has no ray to trace, and its shader tests every "
        f"surface for each light, {raster.MOST_SHADOW_TESTS} tests a pixel at most"
    )


class OSMesa:
    name = "osmesa"
    title = "OSMesa"
    native: tuple[str, ...] = ("raster",)
    modes: Mapping[str, Form] = {form.name: form for form in (NONE, MSAA, ACCUMULATE)}
    draws = frozenset(
        {"orthographic", "perspective", "polygon", "mesh", "disc", "sphere", "plane", "zone-plate", "checker"}
        | {"point light", "directional light"}
    )
    probe_mode = "accumulate:n=256,sampler=regular"
    single_mode = "none"
    idles = False

    def versions(self) -> Mapping[str, str]:
        renderer, version = raster.describe()
        return {"osmesa": version, "osmesa-driver": renderer}

    def unable(self, scene: Scene, mode: Spec) -> str | None:
        return _unable(mode) or _unshadowed(scene)

    def seeded(self, mode: Spec) -> bool:
        return mode.name == ACCUMULATE.name and samplers.randomised(mode.word("sampler"), mode.integer("n"))

    def render(self, request: Request) -> Rendering:
        """Draws in the calling thread; `threads` is not used. The time limit is looked at between repeats only."""
        started = time.monotonic()
        passes = passes_of(request.mode, request.seed)
        drawn = raster.Raster(request.scene, (request.width, request.height))
        cpu_seconds = wall_seconds = 0.0
        repeats = 0
        while repeats == 0 or cpu_seconds < request.least_seconds:
            pixels, cost = drawn.render(passes.offsets, passes.weights, passes.samples_per_pass, passes.sample_shading)
            cpu_seconds, wall_seconds = cpu_seconds + cost.cpu_seconds, wall_seconds + cost.wall_seconds
            repeats += 1
            if time.monotonic() - started > request.time_limit:
                raise JobFailed(f"osmesa {request.mode.text} took more than {request.time_limit:g} s")
        return Rendering(
            pixels,
            Cost(
                samples=cost.samples,
                samples_per_pixel=float(len(passes.weights) * passes.samples_per_pass),
                rays={},
                cpu_seconds=cpu_seconds / repeats,
                wall_seconds=wall_seconds / repeats,
                repeats=repeats,
            ),
        )


RENDERER = OSMesa()
