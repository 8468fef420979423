"""The project's own distribution ray tracer, on Embree."""

from __future__ import annotations

import time
from collections.abc import Mapping

from aliascope.errors import JobFailed
from aliascope.model import Scene
from aliascope.native import filters, samplers, tracer
from aliascope.records import Cost, Rendering
from aliascope.renderers.base import Request, filter_of
from aliascope.specs import Form, Key, Spec

UNIFORM = Form(
    "uniform",
    "the same number of samples in every pixel",
    (
        Key("n", "integer", 16, "samples a pixel", 1, 1 << 24, is_count=True),
        Key("sampler", "spec", "sobol:scramble=owen", "the pattern of a pixel", inner=samplers.canonical, named=True),
        Key("filter", "spec", "box", "the reconstruction filter", inner=filters.canonical),
    ),
)


class Embree:
    name = "embree"
    title = "Embree"
    native: tuple[str, ...] = ("tracer",)
    modes: Mapping[str, Form] = {UNIFORM.name: UNIFORM}
    draws = tracer.DRAWS
    probe_mode = "uniform:n=256,sampler=regular"
    single_mode = "uniform:n=1,sampler=regular"

    def versions(self) -> Mapping[str, str]:
        return {"embree": tracer.embree_version()}

    def unable(self, scene: Scene, mode: Spec) -> str | None:
        return samplers.refusal(mode.word("sampler"), mode.integer("n"), scene.needs().dimensions)

    def seeded(self, mode: Spec) -> bool:
        sampler, count = mode.word("sampler"), mode.integer("n")
        planar = samplers.refusal(sampler, count) is None  # patterns of space and time have three dimensions alone
        return samplers.randomised(sampler, count, 2 if planar else 3)

    def render(self, request: Request) -> Rendering:
        """The time limit is looked at between repeats only."""
        started = time.monotonic()
        built = tracer.Tracer(request.scene, (request.width, request.height))
        sampler, count = request.mode.word("sampler"), request.mode.integer("n")
        settings = (sampler, count, request.seed, request.threads, filter_of(request.mode))
        pixels, first = built.render(*settings)
        cpu_seconds, wall_seconds, repeats = first.cpu_seconds, first.wall_seconds, 1
        while cpu_seconds < request.least_seconds and time.monotonic() - started < request.time_limit:
            _, again = built.render(*settings)
            cpu_seconds, wall_seconds = cpu_seconds + again.cpu_seconds, wall_seconds + again.wall_seconds
            repeats += 1
        if time.monotonic() - started > request.time_limit:
            raise JobFailed(f"embree {request.mode.text} took more than {request.time_limit:g} s")
        cost = Cost(
            samples=first.samples,
            samples_per_pixel=float(count),
            rays={"primary": first.primary_rays} | ({"shadow": first.shadow_rays} if request.scene.lights else {}),
            cpu_seconds=cpu_seconds / repeats,
            wall_seconds=wall_seconds / repeats,
            repeats=repeats,
        )
        return Rendering(pixels, cost)


RENDERER = Embree()
