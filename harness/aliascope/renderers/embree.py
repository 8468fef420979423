"""The project's own distribution ray tracer, on Embree."""

from __future__ import annotations

import time
from collections.abc import Mapping

from aliascope.errors import JobFailed, SpecError, near_misses
from aliascope.model import Scene
from aliascope.native import estimate, filters, samplers, tracer
from aliascope.records import Cost, Counts, Pixels, Rendering
from aliascope.renderers.base import DIMENSIONS, Request, filter_of
from aliascope.specs import Form, Key, Spec

PACKET = Key(
    "packet",
    "choice",
    str(tracer.PACKETS[0]),
    "how many rays Embree traces together",
    choices=tuple(map(str, tracer.PACKETS)),
)
ROBUST = Key(
    "robust",
    "choice",
    "on",
    "whether no ray passes between triangles that share an edge",
    choices=("on", "off"),
)
RELATIVE = Key(
    "relative",
    "choice",
    "on",
    "whether the eye is subtracted from places before they are rounded to float",
    choices=("on", "off"),
)
AGAIN = Key(
    "again",
    "choice",
    "on",
    "whether rays that meet nothing, beside ones that do, are looked at again",
    choices=("on", "off"),
)
FILM = Key("film", "choice", tracer.FILMS[0], "in what samples are added up", choices=tracer.FILMS)


def _sampler(text: str) -> Key:
    canonical, settings = samplers.canonical, samplers.settings
    return Key("sampler", "spec", "sobol:scramble=owen", text, inner=canonical, inner_settings=settings, named=True)


def _filter(text: str) -> Key:
    return Key("filter", "spec", "box", text, inner=filters.canonical, inner_settings=filters.settings)


UNIFORM = Form(
    "uniform",
    "the same number of samples in every pixel",
    (
        Key("n", "integer", 16, "samples a pixel", 1, 1 << 24, is_count=True),
        _sampler("the pattern of a pixel"),
        _filter("the reconstruction filter"),
        DIMENSIONS,
        PACKET,
        ROBUST,
        RELATIVE,
        AGAIN,
        FILM,
    ),
)

METHODS = ("whitted", "kajiya", "mitchell", "student-t", "chi-squared")
"""The estimators of the library that decide pixel by pixel how many samples it gets."""


def _method(spec: str) -> str:
    name = spec.partition(":")[0]
    if name not in METHODS:
        raise SpecError(f'unknown method "{name}"{near_misses(name, METHODS)}')
    return estimate.canonical(spec)


ADAPTIVE = Form(
    "adaptive",
    "as many samples in a pixel as a method finds that it needs; box filter alone",
    (
        Key("n", "integer", 64, "the most samples of a pixel", 1, 1 << 24, is_count=True),
        Key(
            "method",
            "spec",
            "kajiya",
            f"{'|'.join(METHODS)}, with its keys",
            inner=_method,
            inner_settings=estimate.settings,
            named=True,
        ),
        _sampler("the sequence of a pixel"),
        _filter("the reconstruction filter: box"),
        DIMENSIONS,
        PACKET,
        ROBUST,
        RELATIVE,
        AGAIN,
    ),
)


class Embree:
    name = "embree"
    title = "Embree"
    native: tuple[str, ...] = ("tracer",)
    modes: Mapping[str, Form] = {form.name: form for form in (UNIFORM, ADAPTIVE)}
    draws = tracer.DRAWS
    probe_mode = "uniform:n=256,sampler=regular"
    single_mode = "uniform:n=1,sampler=regular"
    shifts = True
    absent: Mapping[str, str] = {}

    def versions(self) -> Mapping[str, str]:
        return {"embree": tracer.embree_version()}

    def unable(self, scene: Scene, mode: Spec) -> str | None:
        sampler, count, arrangement = mode.word("sampler"), mode.integer("n"), mode.word("dimensions")
        groups = scene.needs().groups
        reason = samplers.refusal(sampler, count, groups, arrangement)
        if reason or mode.name != ADAPTIVE.name:
            return reason
        if filter_of(mode) != "box":
            return f"adaptive modes have the box filter alone: {filter_of(mode)} would need every pixel's samples"
        if arrangement == "decorrelated":
            return "adaptive modes decide on the way: dimensions=decorrelated needs all samples of a pixel at once"
        return estimate.refusal(mode.word("method"), sampler, count, groups, 3, arrangement)

    def seeded(self, mode: Spec) -> bool:
        """Arranged groups are shuffled by the seed."""
        sampler, count = mode.word("sampler"), mode.integer("n")
        planar = samplers.refusal(sampler, count) is None  # patterns of space and time have three dimensions alone
        return mode.word("dimensions") != "joint" or samplers.randomised(sampler, count, 2 if planar else 3)

    def render(self, request: Request) -> Rendering:
        """The time limit is looked at between repeats only."""
        started = time.monotonic()
        built = tracer.Tracer(request.scene, (request.width, request.height), request.shift, _options(request.mode))
        pixels, counts, first = _draw(built, request)
        cpu_seconds, wall_seconds, repeats = first.cpu_seconds, first.wall_seconds, 1
        instructions = first.instructions
        while cpu_seconds < request.least_seconds and time.monotonic() - started < request.time_limit:
            again = _draw(built, request)[-1]
            cpu_seconds, wall_seconds = cpu_seconds + again.cpu_seconds, wall_seconds + again.wall_seconds
            instructions = again.instructions  # the first picture also warms up what is loaded when it is used
            repeats += 1
        if time.monotonic() - started > request.time_limit:
            raise JobFailed(f"embree {request.mode.text} took more than {request.time_limit:g} s")
        cost = Cost(
            samples=first.samples,
            samples_per_pixel=(
                float(request.mode.integer("n")) if counts is None else first.samples / (request.width * request.height)
            ),
            rays=_rays(request.scene, first),
            cpu_seconds=cpu_seconds / repeats,
            wall_seconds=wall_seconds / repeats,
            repeats=repeats,
            instructions=instructions,
        )
        return Rendering(pixels, cost, counts=counts)


def _options(mode: Spec) -> tracer.Options:
    film = mode.word(FILM.name) if FILM.name in mode.values else tracer.Options.film
    robust, relative, again = (mode.word(key.name) == "on" for key in (ROBUST, RELATIVE, AGAIN))
    return tracer.Options(int(mode.word(PACKET.name)), robust, film, relative, again)


def _rays(scene: Scene, cost: tracer.TracerCost) -> dict[str, int]:
    """By kind: those that the scene needs."""
    needs, rays = scene.needs(), {"primary": cost.primary_rays}
    if needs.mirror or needs.gloss:
        rays["reflection"] = cost.reflection_rays
    if needs.diffuse_bounces:
        rays["bounce"] = cost.bounce_rays
    if scene.lights or needs.emitters:
        rays["shadow"] = cost.shadow_rays
    return rays


def _draw(built: tracer.Tracer, request: Request) -> tuple[Pixels, Counts | None, tracer.TracerCost]:
    """One picture, and the samples of its pixels where they differ."""
    mode = request.mode
    common = (mode.word("sampler"), mode.integer("n"), request.seed, request.threads)
    arrangement = mode.word("dimensions")
    if mode.name == ADAPTIVE.name:
        return built.render_adaptive(mode.word("method"), *common, arrangement)
    pixels, cost = built.render(*common, filter_of(mode), arrangement)
    return pixels, None, cost


RENDERER = Embree()
