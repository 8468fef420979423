"""Sums of as many samples as a pixel may get, and pictures of one pixel, one row or one column."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache

import numpy as np

from aliascope import renderers
from aliascope.model import Scene
from aliascope.native.tracer import Options, Tracer
from aliascope.renderers.base import Request
from aliascope.stability.records import Probe

COLOUR = (0.1, 0.7, 0.3)
"""Whose sums are no short binary numbers."""

SAMPLES = tuple(10.0**k for k in range(10))
WIDE_SAMPLES = SAMPLES[:7]
"""A sample that counts in sixteen pixels takes a hundred times as long."""

CHUNK = 1 << 20
SIZES = (1.0, 2.0, 1000.0, 16384.0)
BARS = 61
"""Across a row, each of a colour of its own: a prime, so that no bar's edge lies where pixels meet."""


def _scene(width: int, height: int, **more: object) -> Scene:
    """Pixels are units; the first has its corner at 0."""
    eye = [width / 2, height / 2, 5.0]
    camera = {"type": "orthographic", "height": float(height), "eye": eye, "look_at": [eye[0], eye[1], 0.0]}
    view = {"size": [width, height], "background": COLOUR}
    return Scene.model_validate({"title": "", "shows": "", "view": view, "camera": camera, "materials": {}, **more})


def _relative(values: np.ndarray) -> float:
    """Of the worst channel, against the colour that all samples have."""
    return max(
        float(abs(Fraction(float(value)) / Fraction(truth) - 1))
        for value, truth in zip(values.ravel(), COLOUR, strict=True)
    )


LIT: Mapping[str, object] = {
    "view": {"size": [1, 1]},
    "materials": {"paper": {"albedo": COLOUR}},
    "surfaces": [{"type": "plane", "material": "paper", "point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]}],
    "lights": [{"type": "directional", "direction": [0.0, 0.0, -1.0], "intensity": [1.0, 1.0, 1.0]}],
}
"""The same colour, of a surface: in doubles the tracer counts samples of the background instead of adding them."""


def _film(film: str, reconstruction: str) -> Callable[[float], float]:
    def measure(at: float) -> float:
        scene = _scene(1, 1, **LIT) if (film, reconstruction) == ("double", "box") else _scene(1, 1)
        made = Tracer(scene, (1, 1), options=Options(film=film))
        return _relative(made.render("r2", int(at), reconstruction=reconstruction)[0])

    return measure


def _pairwise(at: float) -> float:
    """In floats: numpy's sums of a chunk, and of chunks of equal size as soon as there are two."""
    full, rest = divmod(int(at), CHUNK)
    chunk = np.broadcast_to(np.array(COLOUR, np.float32), (CHUNK, 3))
    one = np.array([np.add.reduce(np.ascontiguousarray(chunk[:, c])) for c in range(3)])
    total = np.array([np.add.reduce(np.ascontiguousarray(chunk[:rest, c])) for c in range(3)], np.float32)
    while full:  # chunks are all alike, and so are the sums of pairs, of fours, ...
        if full & 1:
            total = total + one
        one = one + one
        full >>= 1
    return _relative((total.astype(np.float64) / int(at)).astype(np.float32))


def _sum(component: str, measure: Callable[[float], float], levels: tuple[float, ...], note: str) -> Probe:
    return Probe(
        component,
        "film",
        "sum",
        "relative",
        "the colour that all samples have",
        2.0**-24,
        1e-6,
        levels,
        measure,
        () if "float" in component else (1e3,),
        note,
        excused="float" in component,  # what doubles are the safeguard against
    )


@lru_cache(maxsize=8)
def _bars(length: int, upright: bool) -> tuple[Scene, np.ndarray]:
    """Bars side by side in a row of pixels, or one on the other in a column; and what the centres of the pixels see,
    from the left or from the bottom."""
    edges = [float(Fraction(length * bar, BARS)) for bar in range(BARS + 1)]
    numbers = [(2 * x + 1) * BARS // (2 * length) for x in range(length)]
    materials = {f"m{bar}": {"emission": [(bar + 1) / 64] * 3} for bar in range(BARS)}
    surfaces = []
    for bar, (low, high) in enumerate(itertools.pairwise(edges)):
        corners = [[low, -1.0], [high, -1.0], [high, 2.0], [low, 2.0]]
        points = [[*(corner[::-1] if upright else corner), 0.0] for corner in corners]
        surfaces.append({"type": "polygon", "material": f"m{bar}", "points": points})
    size = (1, length) if upright else (length, 1)
    return _scene(*size, materials=materials, surfaces=surfaces), (np.array(numbers) + 1) / 64


def _row_and_column(name: str) -> Callable[[float], float]:
    def measure(at: float) -> float:
        renderer, worst = renderers.find(name), 0.0
        for upright in (False, True):
            scene, truth = _bars(int(at), upright)
            mode = renderers.mode_of(renderer, renderer.single_mode)
            made = renderer.render(Request(scene, *scene.view.size, mode)).pixels
            along = made[::-1, 0] if upright else made[0]
            if along.shape != (int(at), 3):
                return math.inf
            worst = max(worst, float(np.abs(along - truth[:, None]).max()))
        return worst

    return measure


def probes() -> list[Probe]:
    carried = "Two floats a number; a sum of floats with Neumaier's one of losses stands still at 2^25 equal samples."
    stays = "A sum stands still once a sample is less than half its last place: at 2^24 equal ones at the latest."
    sums = [
        _sum("film=double", _film("double", "box"), SAMPLES, ""),
        _sum("film=float", _film("float", "box"), SAMPLES, stays),
        _sum("film=compensated", _film("compensated", "box"), SAMPLES, carried),
        _sum(
            "film=pairwise",
            _pairwise,
            SAMPLES,
            "Not a film of the tracer's: it would need a sum for each power of two.",
        ),
    ]
    wide = [
        _sum(f"film={film},filter=mitchell", _film(film, "mitchell"), WIDE_SAMPLES, note)
        for film, note in (("double", ""), ("float", stays), ("compensated", carried))
    ]
    pictures = [
        Probe(
            name,
            "renderer",
            "picture-size",
            "radiance",
            "the bar that each pixel's centre sees, in fractions",
            2.0**-24,
            1e-3,
            SIZES,
            _row_and_column(name),
            () if name == "povray" else (1.0, 1000.0),
        )
        for name in ("embree", "povray", "osmesa")
    ]
    return [*sums, *wide, *pictures]
