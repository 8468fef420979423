"""Light at its extremes in the renderers' pictures and in files of pictures: against the same picture at
a radiance of 1, by linearity, and against means by exact fractions where each sample's place is known."""

from __future__ import annotations

import functools
import math
import tempfile
from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope import renderers
from aliascope.image import read_image, write_exr
from aliascope.model import Scene
from aliascope.renderers.base import Request
from aliascope.stability.records import NEVER, Probe

Array = NDArray[np.float64]

FLOAT = 2.0**-24
"""What rounding to float32 does."""

OF_FLOAT = 1e-6
"""What may be asked of pictures in float32: rounding here and there."""

OF_FILES = 7.5e-4
"""A tenth of the RMSE, 0.0077, that 16 samples a pixel on a regular grid leave in the picture of `_lit`."""

MODES: Mapping[str, tuple[str, str]] = {
    "embree": ("embree", "uniform:n=16,sampler=regular"),
    "embree:film=float": ("embree", "uniform:film=float,filter=mitchell,n=16,sampler=regular"),
    "osmesa": ("osmesa", "accumulate:n=16,sampler=regular"),
    "povray": ("povray", "regular:n=16"),
    "povray:exposure=off": ("povray", "regular:exposure=off,n=16"),
}
"""The renderer and mode of each row."""

FIREFLY = 1e12
"""How bright one sample is that outshines others of 1."""

FIREFLY_OF_POVRAY = 6e4
"""The same, of what half floats hold."""

BRIGHTEST = 1e30
"""The most light that a scene may state."""

MOST_SIDE = {"povray": 128, "osmesa": 64}
"""Of the samples of a pixel, a grid, along each side: POV-Ray's mode ends there, and OSMesa's samples would be nearer
to each other than the places to which it rounds corners, 1/256 of a pixel."""

_POLYGON = "polygon"


def _scene(
    size: tuple[int, int], background: float, materials: Mapping[str, Any], *surfaces: Any, **more: Any
) -> Scene:
    """Seen orthographically, a unit a pixel, the origin in the middle; each surface a material and its corners."""
    polygons = [{"type": _POLYGON, "material": name, "points": points} for name, points in surfaces]
    camera = {"type": "orthographic", "eye": (0.0, 0.0, 9.0), "look_at": (0.0, 0.0, 0.0), "height": float(size[1])}
    view = {"size": size, "background": (background,) * 3}
    about = {"title": "light", "shows": "light", "view": view, "camera": camera}
    return Scene.model_validate(about | {"materials": materials, "surfaces": polygons} | more)


def _grey(radiance: float) -> dict[str, Any]:
    return {"emission": (radiance,) * 3}


def _rectangle(left: float, right: float, bottom: float, top: float) -> list[tuple[float, float, float]]:
    return [(left, bottom, 0.0), (right, bottom, 0.0), (right, top, 0.0), (left, top, 0.0)]


def _draw(row: str, scene: Scene, mode: str = "") -> Array:
    name, own = MODES[row]
    renderer = renderers.find(name)
    width, height = scene.view.size
    request = Request(scene, width, height, renderers.mode_of(renderer, mode or own))
    return renderer.render(request).pixels.astype(np.float64)


def _lit(light: float) -> Scene:
    """A lamp before a wall that a light shines on, aslant all of them, before a background a tenth as bright."""
    lamp = [(-5.7, -3.9, 0.0), (6.7, -2.3, 0.0), (0.9, 4.7, 0.0)]
    wall = [(-7.1, 1.3, -1.0), (-1.3, 2.5, -1.0), (-3.1, 5.6, -1.0)]
    materials = {"lamp": {"emission": (light, 0.5 * light, 0.25 * light)}, "wall": {"albedo": (0.8, 0.5, 0.2)}}
    point = {"type": "point", "position": (12.0, 30.0, 18.0), "intensity": (light,) * 3}
    return _scene((16, 12), 0.1 * light, materials, ("lamp", lamp), ("wall", wall), lights=[point])


@functools.lru_cache(maxsize=8)
def _plain(row: str) -> Array:
    return _draw(row, _lit(1.0))


def _scaled(row: str, at: float) -> float:
    """Of the brightest, which is 1 times `at`."""
    return float(np.abs(_draw(row, _lit(at)) / at - _plain(row)).max())


def _relative(found: Array, truth: Array) -> float:
    return float((np.abs(found - truth) / truth).max())


def _mixed(row: str, at: float) -> float:
    """Four pixels: one all of the brightness, one half, two of the dim light: 1, or less, so that no light is more than
    BRIGHTEST."""
    dim = min(1.0, BRIGHTEST / at)
    bright = at * dim
    scene = _scene((4, 2), dim, {"lamp": _grey(bright)}, ("lamp", _rectangle(-9.0, -0.5, -9.0, 9.0)))
    half = float((Fraction(bright) + Fraction(dim)) / 2)
    return _relative(_draw(row, scene)[:, :, 1], np.array([bright, half, dim, dim]))


def _alone(row: str, at: float) -> float:
    """Four pixels of a light beside nothing: one all of it, one half, and two that are 0 to the last bit."""
    scene = _scene((4, 2), 0.0, {"lamp": _grey(at)}, ("lamp", _rectangle(-9.0, -0.5, -9.0, 9.0)))
    found = _draw(row, scene)[:, :, 1]
    return math.inf if found[:, 2:].any() else _relative(found[:, :2], np.array([at, 0.5 * at]))


def _firefly(row: str, at: float) -> float:
    """Around one sample of a grid lies a square, half as wide as the samples are apart. Of more samples than a mode
    takes into a pixel, the pixel is a picture of several, and the mean of it is looked at."""
    side = math.isqrt(round(at))
    pixels = max(1, side // MOST_SIDE.get(row, side))
    light = FIREFLY_OF_POVRAY if row == "povray" else FIREFLY
    x, y, half = (0.5 * side // 1 + 0.5) / side - 0.5, 0.5 - 0.5 / side, 0.25 / side
    square = [(pixels * u, pixels * v, z) for u, v, z in _rectangle(x - half, x + half, y - half, y + half)]
    scene = _scene((pixels, pixels), 1.0, {"lamp": _grey(light)}, ("lamp", square))
    found = _draw(row, scene, _with_samples(row, side * side // pixels**2)).mean(axis=(0, 1))
    return _relative(found, np.array(float((Fraction(light) + side * side - 1) / (side * side))))


def _with_samples(row: str, samples: int) -> str:
    return MODES[row][1].replace("n=16", f"n={samples}")


def _beside(row: str, at: float) -> float:
    """Two pixels of 1, two as dim: what the files hold of the dim."""
    scene = _scene((4, 2), at, {"lamp": _grey(1.0)}, ("lamp", _rectangle(-9.0, 0.0, -9.0, 9.0)))
    return _relative(_draw(row, scene)[:, :, 1], np.array([1.0, 1.0, at, at]))


def _mitchell(x: Fraction) -> Fraction:
    """The filter of Mitchell and Netravali 1988 with B = C = 1/3."""
    t = abs(x)
    if t < 1:
        return (7 * t**3 - 12 * t**2 + Fraction(16, 3)) / 6
    return (Fraction(-7, 3) * t**3 + 12 * t**2 - 20 * t + Fraction(32, 3)) / 6 if t < 2 else Fraction(0)


def _hard_edge(row: str, at: float) -> float:
    """A vertical edge between `at` on the left and 1; what the film makes of the samples of a regular grid, 4 x 4,
    under Mitchell's filter (`film.h`): A + (1 - S) m. Relative to the value where that is more than 1."""
    width, edge = 12, 6
    scene = _scene((width, 3), 1.0, {"lamp": _grey(at)}, ("lamp", _rectangle(-99.0, 0.0, -9.0, 9.0)))
    mode = MODES[row][1] if "filter" in MODES[row][1] else "uniform:filter=mitchell,n=16,sampler=regular"
    found = _draw(row, scene, mode)[1, :, 0]
    places = [Fraction(2 * i + 1, 8) for i in range(-12, 4 * width + 12)]
    bright = Fraction(at)
    light = [bright if place < edge else Fraction(1) for place in places]
    down = sum((_mitchell(place - Fraction(1, 2)) for place in places), Fraction(0)) / 4
    errors = []
    for x in range(width):
        weights = [_mitchell(place - x - Fraction(1, 2)) / 4 for place in places]
        weighted = down * sum(map(Fraction.__mul__, weights, light), Fraction(0))
        truth = float(weighted + (1 - down * sum(weights)) * (bright if x < edge else 1))
        errors.append(abs(found[x] - truth) / max(1.0, abs(truth)))
    return float(max(errors))


def _file(at: float) -> float:
    """What comes back of values about `at`, of either sign: 0 for the same bits."""
    pixels = (at * np.random.default_rng(1).uniform(-1.0, 1.0, (9, 7, 3))).astype(np.float32)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.exr"
        write_exr(path, pixels, {})
        return 0.0 if read_image(path).tobytes() == pixels.tobytes() else math.inf


_BRIGHT = (10.0, 100.0, 1e4, 1e5, 1e10, 1e20, 1e30)
_CONTRASTS = (*_BRIGHT, 1e40, 1e50, 1e60)
_DIM = (0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-10, 1e-20, 1e-30)

_NOTES = {
    (
        "povray",
        "bright",
    ): "Up to 16 in 16 bits, else in half floats, whose step is 2^-11; times 2^-k so that they hold it.",
    ("povray", "dim"): "Times 2^k, so that the brightest has 15 bits or more of a PNG's 16.",
    ("povray:exposure=off", "bright"): "POV-Ray's half floats end at 65504.",
    ("povray:exposure=off", "dim"): "A step of POV-Ray's 16-bit PNG is 1.5e-5, and what is below half of it is black.",
    ("povray", "mixed"): "Half floats hold 65504 beside 1.",
    (
        "povray",
        "output",
    ): "A step of POV-Ray's 16-bit PNG is 1/65535 of the exposure, however dim a part of the picture is.",
    ("osmesa", "output"): "Drawn into RGBA32F and summed in double: nothing has 8 bits.",
    ("osmesa", "firefly"): "From 16,384 samples on of 4 to 256 pixels, of which it is the mean: in one pixel more than "
    "4,096 would be nearer to each other than llvmpipe's 8 bits of a pixel.",
    (
        "povray",
        "firefly",
    ): "From 65,536 samples on of 4 to 64 pixels, of which it is the mean: one has 16,384 at most.",
}


_REFUSES = {("povray", "mixed"): 1e5, ("povray:exposure=off", "mixed"): 1e5, ("povray:exposure=off", "bright"): 1e5}
"""From which level on."""

_EXPOSED = {("povray", "bright"), ("povray", "dim")}
"""What the exposure is for."""


def _probe(
    row: str, extreme: str, unit: str, against: str, levels: tuple[float, ...], measure: Callable[[str, float], float]
) -> Probe:
    files, coarse = row.startswith("povray"), row != "embree" and row != "osmesa"
    return Probe(
        row,
        "renderer",
        extreme,
        unit,
        against,
        0.5 / 65535.0 if files else FLOAT,
        OF_FILES if coarse else OF_FLOAT,
        levels,
        functools.partial(measure, row),
        levels[:1] + levels[-1:] if row == "embree" or (row, extreme) in _EXPOSED else (),
        _NOTES.get((row, extreme), ""),
        excused=row.endswith("exposure=off") or (row, extreme) == ("povray", "output"),
        refuses_from=_REFUSES.get((row, extreme), NEVER),
    )


def _of_rows() -> list[Probe]:
    linear, exact = "the picture of radiance 1, times the factor", "exact fractions"
    found = []
    for row in MODES:
        found += [
            _probe(row, "bright", "of the brightest", linear, _BRIGHT, _scaled),
            _probe(row, "dim", "of the brightest", linear, _DIM, _scaled),
        ]
        if row == "embree:film=float":
            continue
        found += [
            _probe(row, "mixed", "relative, of each pixel", exact, _CONTRASTS, _mixed),
            _probe(row, "alone", "relative, of each pixel", exact, _DIM, _alone),
            _probe(row, "output", "relative, of the dim", exact, _DIM, _beside),
        ]
    counts = tuple(4.0**k for k in range(2, 11))
    for row in ("embree", "osmesa", "povray"):
        found.append(_probe(row, "firefly", "relative", exact, counts, _firefly))
    contrasts = tuple(10.0**k for k in (0, 2, 4, 6, 9, 12))
    found += [
        _probe(row, "hard-edge", "relative, or of 1", exact, contrasts, _hard_edge)
        for row in ("embree", "embree:film=float")
    ]
    return found


def _of_files() -> list[Probe]:
    def probe(extreme: str, against: str, levels: tuple[float, ...], measure: Callable[[float], float]) -> Probe:
        return Probe("exr", "film", extreme, "bits", against, FLOAT, 0.0, levels, measure, levels[:1] + levels[-1:])

    return [
        probe("bright", "the same bits", (*_BRIGHT, 3.4e38), _file),
        probe("dim", "the same bits", (*_DIM, 1e-38, 1e-44), _file),
    ]


def probes() -> list[Probe]:
    return [*_of_rows(), *_of_files()]
