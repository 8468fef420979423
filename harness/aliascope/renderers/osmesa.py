"""OSMesa: the rasteriser llvmpipe, with its multisampling or as an accumulation buffer (Haeberli and Akeley 1990)."""

from __future__ import annotations

import time
from collections.abc import Mapping

import numpy as np

from aliascope.errors import JobFailed, Unsupported
from aliascope.geometry import surfaces_of
from aliascope.model import Frames, Scene
from aliascope.native import raster, samplers
from aliascope.native.raster import Passes
from aliascope.records import Cost, Rendering
from aliascope.renderers.accumulation import choices_of
from aliascope.renderers.base import DIMENSIONS, RECENTRE, Request, as_drawn
from aliascope.specs import Form, Key, Spec

CENTRE = (0.5, 0.5)

EIGHT = ((0.5 - 1 / 16, 0.5 - 3 / 16), (0.5 + 1 / 16, 0.5 + 3 / 16))
"""Two passes of the pattern of 4, (1/8, 3/8) pixel apart: half the diagonal of its cell, (1/2, 1/4) + (-1/4, 1/2).

Of the moves by sixteenths that give 8 rows and 8 columns it has the least error over half-planes of all directions:
rms .0513, where (1/8, 1/8) has .0568, the pattern of 4 alone .0777, and the standard pattern of 8 .0486.
"""

NONE = Form("none", "one sample at the centre of each pixel", (RECENTRE,))
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
        RECENTRE,
    ),
)
ACCUMULATE = Form(
    "accumulate",
    "the accumulation buffer: n passes, moved by one sampling pattern for all pixels; each at its own time, through "
    "its own point of the lens and lit by its own point of each light with an area, where the scene asks for that",
    (
        Key("n", "integer", 16, "passes", 1, 65536, is_count=True),
        Key(
            "sampler",
            "spec",
            "halton",
            "the pattern",
            inner=samplers.canonical,
            inner_settings=samplers.settings,
            named=True,
        ),
        DIMENSIONS,
        RECENTRE,
    ),
)


def passes_of(mode: Spec, scene: Scene, seed: int = 0) -> Passes:
    """The passes that a mode draws of a scene. Raises Unsupported, SpecError."""
    if reason := _unable(mode, scene):
        raise Unsupported(reason)
    if mode.name == ACCUMULATE.name:
        chosen = choices_of(scene, mode.word("sampler"), mode.integer("n"), seed, mode.word("dimensions"))
        return Passes(chosen.offsets, chosen.weights, times=chosen.times, lens=chosen.lens, lights=chosen.lights)
    if mode.name == NONE.name:
        return Passes(np.array([CENTRE]), np.ones(1))
    offsets = np.array([CENTRE] if mode.integer("n") == raster.MULTISAMPLES else EIGHT)
    weights = np.full(len(offsets), 1.0 / len(offsets))
    return Passes(offsets, weights, raster.MULTISAMPLES, bool(mode.integer("sample-shading")))


def _unable(mode: Spec, scene: Scene) -> str | None:
    needs = scene.needs()
    if mode.name == ACCUMULATE.name:
        return samplers.refusal(mode.word("sampler"), mode.integer("n"), needs.groups, mode.word("dimensions"))
    asked = {"a lens": needs.lens, "motion": needs.shutter, "lights with an area": needs.area_lights > 0}
    if any(asked.values()):
        missing = " and ".join(name for name, there in asked.items() if there)
        return f"{mode.name} of OSMesa does not draw {missing}: accumulate does, a sum over passes"
    if mode.name == MSAA.name and mode.integer("n") not in (4, 8):
        return (
            f"{mode.text}: GL_MAX_SAMPLES of llvmpipe is {raster.MULTISAMPLES}, so a pixel has 4 samples, "
            f"or 8 in two passes; accumulate:n={mode.integer('n')} has any count"
        )
    return None


def _stretched(scene: Scene) -> str | None:
    """Why what changes its shape is not drawn: its pattern would be stretched."""
    if not scene.needs().shutter:
        return None
    for surface in scene.surfaces:
        if isinstance(surface.motion, Frames) and scene.materials[surface.material].pattern:
            return "a mesh of frames stretches its pattern, which OSMesa does not draw"
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
        | {"point light", "directional light", "area light", "disc light", "sphere light", "lens", "motion"}
        | {"mesh of frames"}
    )
    probe_mode = "accumulate:n=256,sampler=regular"
    single_mode = "none"
    shifts = True
    absent: Mapping[str, str] = {}

    def versions(self) -> Mapping[str, str]:
        renderer, version = raster.describe()
        return {"osmesa": version, "osmesa-driver": renderer}

    def unable(self, scene: Scene, mode: Spec) -> str | None:
        return _unable(mode, scene) or _stretched(scene) or _unshadowed(scene)

    def seeded(self, mode: Spec) -> bool:
        if mode.name != ACCUMULATE.name:
            return False
        sampler, count = mode.word("sampler"), mode.integer("n")
        planar = samplers.refusal(sampler, count) is None  # patterns of space and time have three dimensions alone
        return mode.word("dimensions") != "joint" or samplers.randomised(sampler, count, 2 if planar else 3)

    def render(self, request: Request) -> Rendering:
        """Draws in the calling thread; `threads` is not used. The time limit is looked at between repeats only."""
        started = time.monotonic()
        scene = as_drawn(request.scene, request.mode)
        passes = passes_of(request.mode, scene, request.seed)
        as_they_are = not request.mode.integer(RECENTRE.name)
        drawn = raster.Raster(scene, (request.width, request.height), request.shift, as_they_are)
        cpu_seconds = wall_seconds = 0.0
        repeats = 0
        while repeats == 0 or cpu_seconds < request.least_seconds:
            pixels, cost = drawn.render(passes)
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
                instructions=cost.instructions,  # of the last: the first compiles the shaders
            ),
        )


RENDERER = OSMesa()
