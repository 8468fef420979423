"""NaN and infinity, handed to all that take numbers: each is to refuse them, and to say which one it was."""

from __future__ import annotations

import contextlib
import functools
import math
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aliascope import metrics, renderers
from aliascope.image import write_exr
from aliascope.model import Scene
from aliascope.native import discrepancy, estimate, filters, warps
from aliascope.renderers.base import Request
from aliascope.stability import naming
from aliascope.stability.records import Kind, Probe

Array = NDArray[np.float64]
Acts = Sequence[tuple[Callable[[], object], str]]
"""What is tried, each with the pattern that its message is to have."""

BAD = (math.nan, math.inf, -math.inf)


def probes() -> list[Probe]:
    return [*_of_renderers(), *_of_plugins(), *_of_estimators(), *_of_pictures(), *_of_points(), *_of_numbers()]


# --- light ------------------------------------------------------------------------------------------------------------


def _of_renderers() -> list[Probe]:
    shown = {
        "embree": ("uniform:n=16,sampler=regular", r"pixel \(0, 0\)"),
        "embree:film=float": ("uniform:film=float,filter=mitchell,n=16,sampler=regular", r"pixel \(0, 0\)"),
        "osmesa": ("accumulate:n=16,sampler=regular", r"pixel \(0, 0\)"),
        "povray": ("regular:n=16", r'"lamp", in pixel \([0-{last}], [01]\)'),
        "povray:exposure=off": ("regular:exposure=off,n=16", r'"lamp", in pixel \([0-{last}], [01]\)'),
    }
    return [
        naming.probe(row, "renderer", "the pixel", functools.partial(_overflowing, row, mode, names), (1.0, 4.0))
        for row, (mode, names) in shown.items()
    ]


def _overflowing(row: str, mode: str, names: str, at: float) -> Acts:
    """Pixels of 1e40, 1e30 times the colour 1e10 of a pattern, `at` of them a row, from the left."""
    pattern = {"type": "checker", "scale": 0.01, "colours": ((1e10,) * 3, (1e10,) * 3)}
    corners = [(-2.0, -9.0, 0.0), (-2.0 + at, -9.0, 0.0), (-2.0 + at, 9.0, 0.0), (-2.0, 9.0, 0.0)]
    about = {
        "title": "glare",
        "shows": "glare",
        "view": {"size": (4, 2), "background": (1.0, 1.0, 1.0)},
        "camera": {"type": "orthographic", "eye": (0.0, 0.0, 9.0), "look_at": (0.0, 0.0, 0.0), "height": 2.0},
        "materials": {"lamp": {"emission": (1e30,) * 3, "pattern": pattern}},
        "surfaces": [{"type": "polygon", "material": "lamp", "points": corners}],
    }
    renderer = renderers.find(row.partition(":")[0])
    request = Request(Scene.model_validate(about), 4, 2, renderers.mode_of(renderer, mode))
    return [(lambda: renderer.render(request), names.replace("{last}", str(round(at) - 1)))]


# --- samples ----------------------------------------------------------------------------------------------------------


def _of_plugins() -> list[Probe]:
    """Samples that a plugin gives."""
    takers: dict[str, Kind] = {"sampler-plugin": "sampler"}
    takers |= {f"{name}:sampler=plugin": "renderer" for name in ("embree", "osmesa", "povray")}
    takers |= {f"{each.name}:sampler=plugin": "estimator" for each in estimate.registered()}
    return [
        Probe(
            component,
            kind,
            "not-finite",
            "none",
            "an error that names the sampler, the pixel and the sample",
            2.0**-53,
            0.0,
            (1.0, 100.0),
            functools.partial(naming.told_by_plugin, component),
            (1.0,),
            refuses_from=1.0,
        )
        for component, kind in takers.items()
    ]


FIRST = 21
"""The first value of an integrand that is none."""


def _of_estimators() -> list[Probe]:
    return [
        naming.probe(each.name, "estimator", "the pixel, the channel and the place", _by_estimator(each.name))
        for each in estimate.registered()
    ]


def _by_estimator(name: str) -> Callable[[float], Acts]:
    def acts(at: float) -> Acts:
        return [
            (
                functools.partial(_estimated, name, bad, round(at)),
                rf"pixel \(0, 0\): {_shown(bad)} in channel 1 .*at \(0\.",
            )
            for bad in ((math.nan,), (math.inf,), (-math.inf,), (math.inf, math.nan))
        ]

    return acts


def _shown(bad: Sequence[float]) -> str:
    return "-?nan" if math.isnan(bad[0]) else f"{bad[0]:g}"


def _estimated(name: str, bad: Sequence[float], count: int) -> object:
    """Of an integrand whose second channel has `count` values that are none, of each kind in turn."""
    asked = 0

    def integrand(points: Array) -> Array:
        nonlocal asked
        values = np.zeros((len(points), 2))
        values[::2, 1] = 1000.0
        numbers = np.arange(asked, asked + len(points)) - FIRST
        none = (numbers >= 0) & (numbers < count)
        values[none, 1] = np.array(bad)[numbers[none] % len(bad)]
        asked += len(points)
        return values

    sampler = "sobol" if name != "stratified" else "random"
    return estimate.Estimator(name, sampler, samples=256, channels=2).estimate(integrand)


# --- pictures ---------------------------------------------------------------------------------------------------------


def _of_pictures() -> list[Probe]:
    return [
        naming.probe("exr", "film", "the file, the pixel and the channel", _by_files),
        naming.probe("metrics", "metric", "the picture, the pixel and the channel", _by_metrics),
    ]


def _picture(bad: Sequence[float], at: float) -> NDArray[np.float32]:
    """16 x 16; from the second channel of pixel (5, 2) on, so many values are none."""
    pixels = np.full((16, 16, 3), 0.5, np.float32)
    first = 3 * (2 * 16 + 5) + 1
    pixels.flat[first : first + round(at)] = np.resize(np.array(bad, np.float32), round(at))
    return pixels


def _kinds(at: float) -> list[tuple[float, ...]]:
    """NaN alone, infinities alone, and where there is more than one, both beside each other."""
    return [
        (math.nan,),
        (math.inf,),
        (-math.inf,),
        *([(math.inf, math.nan), (math.nan, -math.inf)] if at > 1.0 else []),
    ]


def _by_files(at: float) -> Acts:
    """Nothing is written, wherever it is to be."""
    count = round(at)

    def write(bad: tuple[float, ...]) -> None:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            try:
                write_exr(Path("picture.exr"), _picture(bad, at), {})
            finally:
                if list(Path(folder).iterdir()):
                    raise naming.NotNamed("a file was left")

    where = r"the first at x=5, y=2, channel 1"
    return [
        (functools.partial(write, bad), rf"picture\.exr: .* {count} values .* {where} \({_shown(bad)}\)")
        for bad in _kinds(at)
    ]


def _by_metrics(at: float) -> Acts:
    """The picture, and the reference."""
    count, whole = round(at), np.full((16, 16, 3), 0.5, np.float32)
    acts: list[tuple[Callable[[], object], str]] = []
    for bad in _kinds(at):
        nans = int(np.isnan(_picture(bad, at)).sum())
        told = rf"{nans} NaN and {count - nans} infinite values, the first at x=5, y=2, channel 1"
        acts.append((functools.partial(metrics.measure, _picture(bad, at), whole), rf"the picture has {told}"))
        acts.append((functools.partial(metrics.measure, whole, _picture(bad, at)), rf"the reference has {told}"))
    return acts


# --- points and numbers -----------------------------------------------------------------------------------------------


def _of_points() -> list[Probe]:
    return [
        *(naming.probe(each.name, "measure", "the point", _by_measure(each.name)) for each in discrepancy.registered()),
        *(naming.probe(name, "sampler", "the row", _by_warp(name)) for name in WARPS),
        naming.probe("density", "sampler", "the column", _by_density),
    ]


def _by_measure(name: str) -> Callable[[float], Acts]:
    def acts(at: float) -> Acts:
        found = []
        for bad in BAD:
            points = np.random.default_rng(7).random((128, 2))
            points[3 : 3 + round(at), 1] = bad
            found.append((functools.partial(discrepancy.measure, name, points), rf"point 3 has {_shown((bad,))}"))
        return found

    return acts


WARPS = {
    "disc": warps.DISC,
    "cosine-hemisphere": warps.COSINE_HEMISPHERE,
    "uniform-hemisphere": warps.UNIFORM_HEMISPHERE,
    "sphere": warps.SPHERE,
    "triangle": warps.TRIANGLE,
}


def _by_warp(name: str) -> Callable[[float], Acts]:
    """There, and back."""

    def acts(at: float) -> Acts:
        found, warp = [], WARPS[name]
        for bad in BAD:
            places = np.full((128, 2), 0.5)
            points = warp.sample(places)
            for rows, act in ((places, warp.sample), (points, warp.inverse)):
                rows[3 : 3 + round(at), 1] = bad
                found.append((functools.partial(act, rows), r"row 3 "))
        return found

    return acts


def _by_density(at: float) -> Acts:
    found = []
    for bad in BAD:
        weights = np.ones((2, 128))
        weights[1, 3 : 3 + round(at)] = bad
        found.append((functools.partial(warps.Density, weights), rf"weight {_shown((bad,))} of row 1, column 3"))
    return found


def _of_numbers() -> list[Probe]:
    keys = {"gaussian": "sigma", "catmull-rom": "radius", "tent": "radius", "lanczos": "lobes"}
    return [
        naming.probe("variance", "statistic", "the value", _by_moments),
        *(
            naming.probe(name, "statistic", "the argument", functools.partial(_by_quantile, name), (1.0,))
            for name in ("normal-quantile", "student-t-quantile", "chi-squared-quantile")
        ),
        *(
            naming.probe(name, "filter", "the key", functools.partial(_by_key, name, key), (1.0,))
            for name, key in keys.items()
        ),
    ]


def _by_moments(at: float) -> Acts:
    values = np.ones(128)
    acts = []
    for bad in BAD:
        values = np.ones(128)
        values[3 : 3 + round(at)] = bad
        acts.append((functools.partial(estimate.Moments, values), rf"value 3 of 128 .*: {_shown((bad,))}"))
    return acts


def _by_quantile(name: str, at: float) -> Acts:
    call = f"{name.replace('-', '_')}"
    more = () if name == "normal-quantile" else (3.0,)
    function = getattr(estimate, call)
    return [(functools.partial(function, bad, *more), rf"{call}\({bad}[,)]") for bad in BAD]


def _by_key(name: str, key: str, at: float) -> Acts:
    return [(functools.partial(filters.made, f"{name}:{key}={bad}"), rf'"{name}": {key}="{bad}"') for bad in BAD]
