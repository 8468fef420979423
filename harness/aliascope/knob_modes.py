"""The modes that turn one key of a renderer's modes at a time, each about a setting in the middle of what is sensible.

The analysis pairs modes that differ in a single key (`trade.knobs`): so each key is here in two settings or more, all
others being those of the middle.
"""

from __future__ import annotations

from collections.abc import Mapping

Values = tuple[int | float | str, ...]


def _mode(form: str, pairs: Mapping[str, int | float | str]) -> str:
    return f"{form}:{','.join(f'{key}={value}' for key, value in pairs.items())}" if pairs else form


def _about(form: str, middle: Mapping[str, int | float | str], turns: Mapping[str, Values]) -> tuple[str, ...]:
    """The middle, and every mode that differs from it in one key."""
    turned = ({**middle, key: value} for key, values in turns.items() for value in values)
    return (_mode(form, middle), *(_mode(form, pairs) for pairs in turned))


_SAFETY: Mapping[str, Values] = {
    "packet": (1, 4, 8),
    "robust": ("off",),
    "relative": ("off",),
    "again": ("off",),
    "film": ("float", "compensated"),
}
"""What the tracer pays for safety, and for speed."""

_PATTERNS = (
    *("random", "jittered", "halton", "sobol"),
    *(f"sobol,sampler.scramble={scramble}" for scramble in ("shift", "digit", "owen-full")),
    *(f"halton,sampler.scramble={scramble}" for scramble in ("shift", "owen")),
)

_DECIDING: Mapping[str, Values] = {"method.confidence": (0.8, 0.99), "method.minimum": (4, 16), "method.batch": (4,)}
"""Of the sequential tests."""

_CONTRAST: Mapping[str, Values] = {"method.green": (0.15, 0.6), "method.margin": (0,), "method.unbiased": (1,)}

EMBREE_ADAPTIVE = (
    *_about(
        "adaptive",
        {"method": "kajiya", "n": 64},
        {**_CONTRAST, "n": (32, 256), "method.minimum": (8,), "method.cells": (1, 4), "method.node": (4, 16)},
    ),
    *_about(
        "adaptive", {"method": "kajiya", "method.criterion": "variance", "n": 64}, {"method.tolerance": (0.005, 0.08)}
    ),
    *_about(
        "adaptive",
        {"method": "kajiya", "n": 64},
        {"packet": (1, 4, 8), "robust": ("off",), "relative": ("off",), "again": ("off",)},
    )[1:],
    *_about(
        "adaptive",
        {"method": "mitchell", "n": 64},
        {**_CONTRAST, "method.minimum": (16,), "method.cells": (1,)},
    ),
    *_about("adaptive", {"method": "whitted", "n": 72}, {**_CONTRAST, "method.start": (2,)}),
    *_about("adaptive", {"method": "student-t", "n": 64}, {"method.tolerance": (0.01, 0.04), **_DECIDING}),
    *_about("adaptive", {"method": "chi-squared", "n": 64}, {"method.tolerance": (0.005, 0.02)}),
)

EMBREE = (
    *_about("uniform", {"n": 64}, {"n": (4, 16, 256), **_SAFETY, "sampler": _PATTERNS}),
    *_about("uniform", {"filter": "mitchell", "n": 64}, {"film": ("float", "compensated")}),
    *EMBREE_ADAPTIVE,
)
EMBREE_BOUNCES = _about("uniform", {"n": 16}, {"n": (4, 64), **_SAFETY, "sampler": ("random", "jittered")})
"""Of scenes whose samples cost ten times as much."""

_SEQUENCES = ("sobol", "sobol,sampler.scramble=owen", "random")
_PASSES = _about(
    "accumulate", {"n": 16}, {"n": (4, 64), "recentre": (0,), "sampler": (*_SEQUENCES, "regular", "jittered")}
)
_FRAMES = _about("accumulate", {"n": 16}, {"n": (4, 64), "sampler": _SEQUENCES})
"""Of samples with more than the pixel's two dimensions."""

_POVRAY_GRIDS = tuple(
    mode
    for form, depths in (("am1", (2, 5)), ("am2", (2, 4)))
    for mode in _about(form, {"depth": 3}, {"depth": depths, "threshold": (0, 0.03, 0.3), "jitter": (0,)})
)
"""The forms' defaults are the middle: threshold 0.1, jitter 1."""

_POVRAY_LIGHTS: Mapping[str, Values] = {
    "light_grid": (2, 4, 16),
    "light_adaptive": (0, 1, 2),
    "light_jitter": ("on",),
}

POVRAY: Mapping[str, tuple[str, ...]] = {
    "plain": (
        *_about("none", {}, {"exposure": ("off",)}),
        *_POVRAY_GRIDS,
        *_about("regular", {"n": 16}, {"n": (4, 64), "recentre": (0,)}),
    ),
    "lens": _about(
        "focal-blur",
        {"blur_samples": 64, "variance": 0.001},
        {
            "blur_samples": (16, 256),
            "variance": (0, 0.0001, 0.0078125),
            "confidence": (0.5, 0.99),
            "compensation": ("off",),
        },
    ),
    "area light": (
        *_about("am2", {"depth": 3}, {"depth": (2, 4), "threshold": (0, 0.3), "jitter": (0,), **_POVRAY_LIGHTS}),
        *_about("am1", {"depth": 3}, {"depth": (2, 5), "threshold": (0, 0.3), "jitter": (0,), "light_grid": (4,)}),
        *_about("none", {}, _POVRAY_LIGHTS),
    ),
    "frames": _FRAMES,
    "bounces": ("none",),
}

OSMESA = (
    *_about("none", {}, {"recentre": (0,)}),
    *(f"msaa:n={n}{shading}" for n in (4, 8) for shading in ("", ",sample-shading=1")),
    *_PASSES,
)

MODES: Mapping[str, tuple[str, ...]] = {
    "embree": tuple(dict.fromkeys((*EMBREE, *EMBREE_BOUNCES))),
    "povray": tuple(dict.fromkeys(mode for modes in POVRAY.values() for mode in modes)),
    "osmesa": OSMESA,
}
KINDS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "embree": {**dict.fromkeys(POVRAY, EMBREE), "bounces": EMBREE_BOUNCES},
    "povray": POVRAY,
    "osmesa": {**dict.fromkeys(POVRAY, _FRAMES), "plain": OSMESA},
}
"""By renderer, the modes for each kind of scene (`plan.kind_of`)."""

SCENES = ("edge", "zone-plate", "spheres", "depth-of-field", "soft-shadow")
"""On which `aliascope knobs` turns them: flat, with fine detail, lit, through a lens, and under a lamp with an area."""

FILTER_SCENE = "edge"
"""On which it turns filters too, each of which needs a reference of its own."""

FILTERS = (
    *_about("uniform", {"filter": "box", "n": 64}, {"filter.radius": (1,)})[1:],
    *_about("uniform", {"filter": "mitchell", "n": 64}, {"filter.radius": (1.5,)})[1:],
    *_about("uniform", {"filter": "tent", "n": 64}, {"filter.radius": (2,)}),
    *_about("uniform", {"filter": "gaussian", "n": 64}, {"filter.radius": (1, 2.5), "filter.sigma": (0.75,)}),
)
