"""The tracer at the extremes of geometry, against the truth of its own samples, or the scenes' own references."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from aliascope import scene_io
from aliascope.geometry import Array
from aliascope.model import Scene, Vector
from aliascope.native.tracer import Options, Tracer
from aliascope.placement import moved, scaled
from aliascope.renderers.embree import RENDERER
from aliascope.stability import edges
from aliascope.stability import geometry_scenes as scenes
from aliascope.stability.per_sample import BOUND, ONE_SAMPLE, SAMPLER, SEED, Setting, Truth, mean_error
from aliascope.stability.records import NEVER, Probe

SCENES = ("edge", "siemens-star", "spheres")
SCENES_SIZE = (48, 36)
SCENES_COUNT = 16

AWAY: Vector = (1.0, -0.7, 0.3)
SWITCHED = "embree:relative=off"


def probes() -> list[Probe]:
    far, size = tuple(10.0**k for k in range(13)), tuple(10.0**k for k in range(-12, 13, 3))
    return [
        *_as_at_home("far", far, _far, (1e9,)),
        *_as_at_home("scaled", size, _scaled, (1e-9, 1e9)),
        *_depth_range(),
        *_and_switched(
            _per_sample("sliver", tuple(10.0**k for k in range(1, 13)), scenes.sliver, (1e6,)), scenes.sliver
        ),
        _per_sample("grazing", _small(0, 12), _grazing, (1e-6,)),
        *_and_switched(_per_sample("narrow", _small(-1, 6), _narrow, (1e-6,)), _narrow),
        _per_sample("wide", _small(-1, 3), lambda at: scenes.room(180.0 - at), (1e-3,)),
        _per_sample("shadow", tuple(10.0**k for k in range(-12, 13, 3)), _shadow, (1e-9, 1e9)),
        *_coplanar(),
        *edges.probes_of("embree", RENDERER, RENDERER.single_mode, {"on-samples": FLOATS}),
        *_dense(),
        *_watertight(),
    ]


def _small(first: int, last: int) -> tuple[float, ...]:
    return tuple(10.0**-k for k in range(first, last + 1))


def _per_sample(
    extreme: str,
    levels: tuple[float, ...],
    make: Callable[[float], tuple[Scene, Truth]],
    quick: tuple[float, ...],
    note: str = "",
) -> Probe:
    return Probe(
        "embree",
        "renderer",
        extreme,
        "mean error, of a radiance of 1",
        "the same samples, in double",
        ONE_SAMPLE,
        BOUND,
        levels,
        lambda at: mean_error(*make(at)),
        quick,
        note,
        refuses_from=NEVER,
    )


def _depth_range() -> list[Probe]:
    """A floor to so far away, a ball and a disc so large, all 1 under the eye."""
    grounds = (scenes.road, scenes.planet, scenes.horizon, scenes.plate)

    def measured(options: Options) -> Callable[[float], float]:
        return lambda at: max(mean_error(*make(at), options=options) for make in grounds)

    on, off = _and_switched(
        _per_sample("depth-range", tuple(10.0**k for k in range(13)), scenes.road, (1e6, 1e12)), scenes.road
    )
    return [
        replace(on, measure=measured(Options())),
        replace(off, measure=measured(Options(relative=False)), note=WHOLE),
    ]


WHOLE = "With the switch on, triangles are cut, and balls and discs met in double, where they are larger than far."


def _and_switched(probe: Probe, make: Callable[[float], tuple[Scene, Truth]]) -> list[Probe]:
    def measure(at: float) -> float:
        return mean_error(*make(at), options=Options(relative=False))

    note = "With the switch on, triangles are cut where they are longer than far, and depths count from the scene."
    return [probe, replace(probe, component=SWITCHED, measure=measure, quick=(), note=note, excused=True)]


def _narrow(degrees: float) -> tuple[Scene, Truth]:
    return scenes.ball_on_a_floor(scenes.narrow_camera(degrees))


def _coplanar() -> list[Probe]:
    def measure(gap: float) -> float:
        return max(mean_error(*scenes.one_before_another(gap, first)) for first in (False, True))

    return [replace(_per_sample("coplanar", _small(0, 12), _shadow, (1e-3,), COPLANAR), measure=measure, excused=True)]


def _grazing(short: float) -> tuple[Scene, Truth]:
    return scenes.grazed(short)


def _shadow(factor: float) -> tuple[Scene, Truth]:
    scene, truth = scenes.ball_on_a_floor(scenes.narrow_camera(40.0))
    return scaled(scene, factor), truth


COPLANAR = "Embree keeps the first of two faces whose distances round to the same float, 2^-23 of the distance apart."


# --- the project's own scenes, elsewhere ------------------------------------------------------------------------------


@lru_cache
def _home(name: str) -> tuple[Scene, Array]:
    """A scene, and its picture where it is."""
    scene = scene_io.load(name).scene
    return scene, _picture(scene, Options())


def _picture(scene: Scene, options: Options) -> Array:
    return Tracer(scene, SCENES_SIZE, options=options).render(SAMPLER, SCENES_COUNT, SEED)[0].astype(np.float64)


def _as_at_home(
    extreme: str, levels: tuple[float, ...], take: Callable[[Scene, float], Scene], quick: tuple[float, ...]
) -> list[Probe]:
    def measured(options: Options) -> Callable[[float], float]:
        def measure(at: float) -> float:
            worst = 0.0
            for name in SCENES:
                scene, home = _home(name)
                worst = max(worst, float(np.sqrt(np.mean((_picture(take(scene, at), options) - home) ** 2))))
            return worst

        return measure

    notes = {"far": "Of 10^12 coordinates are doubles to 10^-4: edges are elsewhere, by 1/350 of a pixel."}
    switched = "With the switch off the eye is subtracted from places that were rounded to float."
    return [
        Probe(
            component,
            "renderer",
            extreme,
            "RMS of radiance",
            f"the same pictures at home, of {', '.join(SCENES)}",
            2.0**-24,
            1e-3,
            levels,
            measured(options),
            quick if options.relative else (),
            notes.get(extreme, "") if options.relative else switched,
            excused=not options.relative,
            excused_from=1e12 if extreme == "far" else None,
            refuses_from=NEVER,
        )
        for component, options in (("embree", Options()), (SWITCHED, Options(relative=False)))
    ]


def _far(scene: Scene, by: float) -> Scene:
    x, y, z = AWAY
    return moved(scene, (by * x, by * y, by * z))


def _scaled(scene: Scene, by: float) -> Scene:
    return scaled(scene, by)


# --- edges through samples, many triangles, rays aimed at corners -----------------------------------------------------


FLOATS = "Corners are floats from the eye: an edge nearer to a sample than 2^-24 of its place may fall on it."


def _dense() -> list[Probe]:
    setting = Setting(size=(2, 2), count=16384)
    return [
        Probe(
            "embree",
            "renderer",
            "dense",
            "mean error, of a radiance of 1",
            "the same samples, in double",
            1.0 / (4 * 16384),
            1e-3,
            tuple(10.0**k for k in range(7)),
            lambda at: mean_error(*scenes.tiles(at), setting=setting),
            (1e3,),
        )
    ]


def _watertight() -> list[Probe]:
    """A picture of rays aimed at corners and edges, and random rays from within a ball."""

    def measured(options: Options) -> Callable[[float], float]:
        def measure(rays: float) -> float:
            aimed = min(AIMED_SIDE, round(math.sqrt(rays / 2.0)) // 2)
            random = (rays - (2.0 * aimed) ** 2) / BALL_SIDE**2
            lost = _lost(scenes.aimed_at(aimed), 2 * aimed, 1, "regular", options)
            return lost + _lost(scenes.rough_ball(24), BALL_SIDE, math.ceil(random), "random", options)

        return measure

    note = {
        "embree": "",
        "embree:again=off": "Embree's robust mode loses 2 in 100 rays aimed at corners, by roundings.",
        "embree:robust=off": "Without its robust mode Embree loses rays at edges too.",
    }
    switched = (Options(), Options(again=False), Options(robust=False))
    return [
        Probe(
            component,
            "renderer",
            "watertight",
            "rays lost",
            "all rays hit",
            1.0,
            0.5,
            tuple(10.0**k for k in range(4, 9 if options == Options() else 7)),
            measured(options),
            (1e4,) if options == Options() else (),
            note[component],
            excused=options != Options(),
        )
        for component, options in zip(note, switched, strict=True)
    ]


AIMED_SIDE = 128
BALL_SIDE = 64


def _lost(scene: Scene, side: int, count: int, sampler: str, options: Options) -> float:
    """How many of `count` rays a pixel see the black behind the white."""
    picture = Tracer(scene, (side, side), options=options).render(sampler, count, SEED)[0]
    return float(np.rint((1.0 - picture[..., 0].astype(np.float64)) * count).sum())
