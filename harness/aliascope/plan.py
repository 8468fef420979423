"""Which pictures to make: profiles, the choice by pattern, and the key under which each picture is kept."""

from __future__ import annotations

import fnmatch
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence

from aliascope import knob_modes
from aliascope.draws import UNMOVED, text_of
from aliascope.errors import InvalidInput, near_misses
from aliascope.model import AreaLight, DiscLight, LoadedMesh, Scene, SphereLight
from aliascope.records import Job

COUNTS = (1, 4, 16, 64, 256)

HEAVY = 20_000
"""Triangles of meshes from which on a scene is heavy (`kind_of`)."""

FILTERS = ("mitchell",)
"""Filters other than the box that the full profile judges: each has its references in reference/."""


def _counts(form: str, counts: Iterable[int] = COUNTS) -> tuple[str, ...]:
    return tuple(form.format(n=n) for n in counts)


def _uniform(*patterns: str, counts: Iterable[int] = COUNTS) -> tuple[str, ...]:
    return tuple(mode for pattern in patterns for mode in _counts(f"uniform:n={{n}},sampler={pattern}", counts))


def _accumulate(*patterns: str, counts: Iterable[int]) -> tuple[str, ...]:
    return tuple(mode for pattern in patterns for mode in _counts(f"accumulate:n={{n}},sampler={pattern}", counts))


PLANAR = (
    *("multi-jittered", "correlated-multi-jittered", "n-rooks", "orthogonal-array", "pmj02", "r2", "gauss-legendre"),
    "hammersley,sampler.scramble=shift",
)
"""Patterns of a pixel's two dimensions that have 16, 64 and 256 points."""

_SEQUENTIAL = "batch=2,method.cells=4,method.margin=1.25,method.minimum=4,method.tolerance=0.04"
ADAPTIVE = (
    "adaptive:method=whitted,n=72",
    "adaptive:method=kajiya,n=64",
    "adaptive:method=mitchell,n=96",
    f"adaptive:method=student-t,method.{_SEQUENTIAL},n=64",
    f"adaptive:method=chi-squared,method.{_SEQUENTIAL},n=64",
)
"""Every method, with numbers that bring the pixels that an edge crosses to the error of 64 samples each on `edge` and
`siemens-star`, with at most a third of the samples (tests/python/test_adaptive.py)."""

POVRAY_QUICK: Mapping[str, tuple[str, ...]] = {
    "plain": (
        "none",
        "am1:depth=3",
        *(f"am2:depth={depth}" for depth in (3, 4)),
        *_counts("regular:n={n}", (16, 64)),
    ),
    "heavy": ("am2:depth=3", "regular:n=16"),
    "lens": (
        "focal-blur",
        *_counts("focal-blur:blur_samples={n},variance=0", (64, 256)),
        *_accumulate("sobol", counts=(16, 64)),
    ),
    "area light": (
        "none",
        "am1:depth=3",
        "am2:depth=3",
        "am2:depth=3,light_grid=4",
        *_accumulate("sobol", counts=(16, 64)),
    ),
    "frames": _accumulate("sobol", counts=(4, 16, 64)),
    "bounces": ("none",),
}
"""By kind of scene (`kind_of`), those that reach an error soonest: accumulate, at the lowest errors. Of a heavy scene
each run takes seconds, most of them to read it."""

_POVRAY_FULL_KINDS: Mapping[str, tuple[str, ...]] = {
    "plain": (
        "none",
        *(
            f"{method}:depth={depth},jitter={jitter},threshold={threshold}"
            for method, depths in (("am1", (2, 3, 5, 7, 9)), ("am2", (2, 3, 4, 5, 6)))
            for depth in depths
            for jitter in (0, 1)
            for threshold in (0, 0.03, 0.1, 0.3)
        ),
        *_counts("regular:n={n}", (4, 9, 16, 36, 64, 144, 256)),
        *_counts("accumulate:n={n},sampler=halton", (4, 16, 64)),
    ),
    "lens": (
        "focal-blur",
        *_counts("focal-blur:blur_samples={n},variance=0", (4, 7, 16, 19, 37, 64, 256)),
        *(f"focal-blur:blur_samples=256,confidence=0.95,variance={variance}" for variance in (1e-3, 1e-4, 1e-5)),
        "focal-blur:blur_samples=256,compensation=off,variance=0",
        *_accumulate("halton", "sobol", counts=COUNTS),
    ),
    "area light": (
        "none",
        *(f"none:light_grid={side}" for side in (2, 4, 16)),
        *(
            f"{method}:depth={depth},{more}"
            for method, depths in (("am1", (3, 5)), ("am2", (3, 4)))
            for depth in depths
            for more in ("jitter=1,threshold=0.1", "light_grid=4", "light_jitter=on", "light_adaptive=1,light_grid=16")
        ),
        "am2:depth=4,light_grid=16",
        *_counts("regular:n={n}", (4, 16)),
        *_accumulate("halton", "sobol", counts=COUNTS),
    ),
    "frames": _accumulate("halton", "sobol", counts=COUNTS),
    "bounces": ("none",),
}
POVRAY_FULL: Mapping[str, tuple[str, ...]] = {**_POVRAY_FULL_KINDS, "heavy": _POVRAY_FULL_KINDS["plain"]}


def _all(kinds: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    """The modes of every kind of scene, each once."""
    return tuple(dict.fromkeys(mode for modes in kinds.values() for mode in modes))


EMBREE_QUICK_SPREAD = (
    *_uniform("random", "jittered", counts=(4, 16, 64)),
    *_uniform("sobol,sampler.scramble=owen", counts=(4, 16, 64, 256)),
    "adaptive:method=kajiya,n=64",
    "adaptive:method=mitchell,n=96",
)
"""Of scenes whose samples have more than two dimensions: there `regular` has few counts, and gains nothing by them. A
line in a plot, and a rate, take three counts."""
EMBREE_QUICK = (*_uniform("regular", counts=(4, 16, 64)), *EMBREE_QUICK_SPREAD)
EMBREE_QUICK_BOUNCES = (
    *_uniform("random", "halton", counts=(1, 4, 16)),
    *_uniform("sobol,sampler.scramble=owen", counts=(1, 4, 16, 64)),
)
"""Of scenes whose samples cost ten times as much: those that finish in the time that the quick profile has."""

QUICK: Mapping[str, tuple[str, ...]] = {
    "embree": tuple(dict.fromkeys((*EMBREE_QUICK, *EMBREE_QUICK_BOUNCES))),
    "povray": _all(POVRAY_QUICK),
    "osmesa": (
        "none",
        "msaa:n=4",
        "msaa:n=4,sample-shading=1",
        "msaa:n=8",
        *_counts("accumulate:n={n},sampler=halton", (4, 16, 64)),
        "accumulate:n=16,sampler=regular",
    ),
}

FULL: Mapping[str, tuple[str, ...]] = {
    "embree": (
        *_uniform("random", "regular", "jittered", "halton", "halton,sampler.scramble=shift", counts=(*COUNTS, 1024)),
        *_uniform("sobol", "sobol,sampler.scramble=digit", counts=(*COUNTS, 1024)),
        *_uniform("sobol,sampler.scramble=owen", counts=(*COUNTS, 1024)),
        *_uniform(*PLANAR, counts=(16, 64, 256)),
        *_uniform(*(f"sobol,sampler.scramble=owen,filter={name}" for name in FILTERS), counts=(16, 64, 256)),
        *ADAPTIVE,
        *(f"adaptive:method={method},n={n}" for method in ("whitted", "kajiya", "mitchell") for n in (32, 128, 256)),
        "adaptive:method=kajiya,method.unbiased=1,n=128",
        "adaptive:method=mitchell,method.cells=1,method.margin=0,n=64",
        "adaptive:method=student-t,n=64",
        "adaptive:method=chi-squared,n=64",
    ),
    "povray": _all(POVRAY_FULL),
    "osmesa": (
        "none",
        "msaa:n=4",
        "msaa:n=4,sample-shading=1",
        "msaa:n=8",
        *_accumulate("halton", "regular", "sobol", "jittered", "random", counts=(4, 16, 64, 256)),
        *_accumulate("sobol,sampler.scramble=owen", counts=(4, 16, 64, 256)),
    ),
}

PROFILES: Mapping[str, Mapping[str, tuple[str, ...]]] = {"quick": QUICK, "full": FULL, "knobs": knob_modes.MODES}
KINDS: Mapping[str, Mapping[str, Mapping[str, tuple[str, ...]]]] = {
    "quick": {
        "povray": POVRAY_QUICK,
        "embree": {
            **dict.fromkeys(POVRAY_QUICK, EMBREE_QUICK_SPREAD),
            **dict.fromkeys(("plain", "heavy"), EMBREE_QUICK),
            "bounces": EMBREE_QUICK_BOUNCES,
        },
    },
    "full": {"povray": POVRAY_FULL},
    "knobs": knob_modes.KINDS,
}
"""By profile and renderer, the modes for each kind of scene (`kind_of`); a renderer that is not here has the same for
all. The cells of other modes are left out: they would be empty, or take long for what they show."""

SEEDS: Mapping[str, int] = {"quick": 3, "full": 16, "knobs": 3}
"""How many pictures, with seeds 0, 1, ..., a randomised mode gets in each profile; one without seeds gets as many, but
`draws.MOST` at most, each with the film in another place."""


def profile(name: str) -> Mapping[str, tuple[str, ...]]:
    """The modes of a profile, by renderer. Raises InvalidInput."""
    if name not in PROFILES:
        raise InvalidInput(f'unknown profile "{name}"{near_misses(name, PROFILES)}')
    return PROFILES[name]


def kind_of(scene: Scene) -> str:
    """What decides which modes a scene gets: "bounces" where light goes from surface to surface; "plain"; "lens" or
    "area light" where it has that alone; "frames" where POV-Ray draws it in frames only: for motion, a light that is
    none of its own, or more than one of these; "heavy" where a plain one has more than HEAVY triangles, which take
    POV-Ray a second or two to read, each time."""
    needs = scene.needs()
    if needs.diffuse_bounces:
        return "bounces"
    if not (needs.lens or needs.shutter or needs.area_lights):
        triangles = sum(len(each.triangles) for each in scene.surfaces if isinstance(each, LoadedMesh))
        return "heavy" if triangles > HEAVY else "plain"
    if needs.lens and not (needs.shutter or needs.area_lights or scene.camera.blades):
        return "lens"
    areas = [light for light in scene.lights if isinstance(light, AreaLight | DiscLight | SphereLight)]
    own = all(isinstance(light, AreaLight) and light.falloff == "none" for light in areas)
    return "area light" if own and not (needs.lens or needs.shutter) else "frames"


def with_samplers(modes: Mapping[str, tuple[str, ...]], names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """A profile with the modes of further samplers, those of plugins: in every renderer that takes one."""
    further = {
        "embree": _uniform(*names),
        "povray": _accumulate(*names, counts=(4, 16)),  # each frame takes a quarter of a second
        "osmesa": _accumulate(*names, counts=(4, 16, 64)),
    }
    return {renderer: (*own, *further.get(renderer, ())) for renderer, own in modes.items()}


def matching(patterns: Iterable[str], names: Iterable[str], what: str) -> list[str]:
    """The names that a pattern of the shell (*, ?, [abc]) matches, in their order. Raises InvalidInput for a pattern
    that matches none."""
    known = list(names)
    found: set[str] = set()
    for pattern in patterns:
        hits = fnmatch.filter(known, pattern)
        if not hits:
            raise InvalidInput(f'unknown {what} "{pattern}"{near_misses(pattern, known)}')
        found.update(hits)
    return [name for name in known if name in found]


def make_job(
    *,
    scene: str,
    scene_path: str,
    digest: str,
    renderer: str,
    mode: str,
    size: tuple[int, int],
    seed: int,
    versions: Mapping[str, str],
    shift: tuple[float, float] = UNMOVED,
) -> Job:
    """A job under the key of all that its picture depends on: the scene's digest, renderer and canonical mode, size,
    seed, the versions of what renders it, and the shift, where there is one."""
    contents: list[object] = [digest, renderer, mode, list(size), seed, dict(versions)]
    if shift != UNMOVED:
        contents.append(text_of(shift))
    key = hashlib.sha256(json.dumps(contents, sort_keys=True).encode()).hexdigest()[:32]
    return Job(key, scene, scene_path, renderer, mode, size[0], size[1], seed, shift)
