"""Scenes at extremes of geometry whose pictures are known: for any renderer that draws them.

Pictures of a grid of 16 samples a pixel are held against exact areas. Their error is at least that of 16 exact samples,
which is their precision, and a tenth more is their bound. Pictures of one sample a pixel are held against what the
exact ray meets; their bound is a tenth of the RMSE of 0.01 that 16 samples a pixel have on usual scenes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import Unsupported
from aliascope.geometry import Array, frame_of
from aliascope.model import LoadedMesh, Scene
from aliascope.placement import moved, scaled
from aliascope.renderers.base import Renderer, Request, unable
from aliascope.specs import parse
from aliascope.stability import areas
from aliascope.stability.areas import Point

SIZE = (24, 16)
HEIGHT = 2.0
"""Of orthographic pictures, in units: 8 pixels a unit, so that picture places are exact."""
SIDE = 4
"""Of the grid of samples in a pixel."""
Long = NDArray[np.longdouble]

QUANTUM = 1.0 / 65535.0
BOUND = 1e-3


@dataclass(frozen=True)
class Subject:
    """A scene, and the picture that it has, (height, width, 3): means over pixels, of which exact samples have the RMS
    error `own`; or, where that is None, what is seen at their middles."""

    scene: Scene
    truth: Array
    own: float | None = None


def rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


MATT = "matt"


def _scene(camera: Mapping[str, Any], surfaces: Sequence[Mapping[str, Any]], **more: Any) -> Scene:
    """Materials are named by their emission, where no others are given."""
    names = sorted({str(surface["material"]) for surface in surfaces} - {MATT})
    materials = {name: {"emission": (float(name),) * 3} for name in names}
    contents = {
        "title": "extreme",
        "shows": "what breaks",
        "view": {"size": SIZE},
        "camera": camera,
        "materials": materials,
        "surfaces": surfaces,
    }
    return Scene.model_validate({**contents, **more})


ABOVE = {"type": "orthographic", "eye": (0.0, 0.0, 4.0), "look_at": (0.0, 0.0, 0.0), "height": HEIGHT}


def _seen(points: Sequence[Sequence[float]]) -> list[Point]:
    """Where ABOVE has points in the picture."""
    per_unit = Fraction(SIZE[1]) / Fraction(HEIGHT)
    half = (Fraction(SIZE[0], 2), Fraction(SIZE[1], 2))
    return [(half[0] + per_unit * Fraction(x), half[1] - per_unit * Fraction(y)) for x, y, *_ in points]


def _flat(scene: Scene, outlines: Sequence[tuple[Sequence[Point], float]]) -> Subject:
    """A scene of convex polygons that do not overlap, with their emissions."""
    truth, drawn = np.zeros(SIZE[::-1]), np.zeros(SIZE[::-1])
    for outline, emission in outlines:
        truth += emission * areas.coverage(outline, SIZE)
        drawn += emission * areas.samples(outline, SIZE, SIDE)
    return Subject(scene, np.repeat(truth[..., np.newaxis], 3, axis=2), own=rms(drawn - truth))


def _polygon(points: Sequence[Sequence[float]], emission: float) -> dict[str, Any]:
    return {"type": "polygon", "material": str(emission), "points": points}


def of_polygons(polygons: Sequence[tuple[Sequence[Sequence[float]], float]], camera: Any = ABOVE) -> Scene:
    return _scene(camera, [_polygon(points, emission) for points, emission in polygons])


EDGES = (
    ([(-1.2437, -0.8119, 0.0), (-0.4361, -0.8119, 0.0), (-0.4361, 0.1742, 0.0), (-1.2437, 0.0609, 0.0)], 0.9),
    ([(-0.3713, -0.7127, 0.0), (0.3391, -0.7127, 0.0), (0.3391, 0.1373, 0.0), (-0.3713, 0.6114, 0.0)], 0.5),
    ([(0.4519, -0.8831, 0.0), (1.0743, -0.8831, 0.0), (1.2471, 0.7429, 0.0), (0.4519, 0.7429, 0.0)], 0.7),
)
"""Those of the scene `edge`."""


def _home() -> Subject:
    return _flat(of_polygons(EDGES), [(_seen(points), emission) for points, emission in EDGES])


def far(at: float) -> Subject:
    home = _home()
    return Subject(moved(home.scene, (at, -0.3 * at, 0.7 * at)), home.truth, own=home.own)


def resized(at: float) -> Subject:
    home = _home()
    return Subject(scaled(home.scene, at), home.truth, own=home.own)


def sliver(at: float) -> Subject:
    """A triangle `at` times as long as the half unit that its base is wide, aslant across the middle of the picture."""
    length = 0.5 * at
    # Its axis goes through (0.02, 0.03); the tip is to the right, and the base half the length to the left.
    points = [
        (0.02 + 0.5 * length, 0.03 + 0.05 * length, 0.0),
        (0.02 - 0.5 * length, 0.28 - 0.05 * length, 0.0),
        (0.02 - 0.5 * length, -0.22 - 0.05 * length, 0.0),
    ]
    return _flat(of_polygons([(points, 0.9)]), [(_seen(points), 0.9)])


def depth_range(at: float) -> Subject:
    """Eight columns, each of two faces that overlap, the one behind the other by a thousandth of the depth; the depths
    go from 1 to `at`. The nearer face is listed first in every other column."""
    degrees = 40.0
    half_height = math.tan(math.radians(degrees) / 2.0)
    half_width = half_height * SIZE[0] / SIZE[1]
    truth = np.zeros(SIZE[::-1])
    polygons = []
    for column in range(8):
        depth = at ** (column / 7.0)
        pair = []
        for emission, rows, z in ((0.75, (5, 16), depth), (0.25, (0, 11), depth * 1.001)):
            x = [z * half_width * (2.0 * pixel / SIZE[0] - 1.0) for pixel in (3 * column, 3 * column + 3)]
            y = [z * half_height * (1.0 - 2.0 * pixel / SIZE[1]) for pixel in rows]
            pair.append(([(x[0], y[0], -z), (x[1], y[0], -z), (x[1], y[1], -z), (x[0], y[1], -z)], emission))
        polygons += pair if column % 2 else pair[::-1]
        truth[:11, 3 * column : 3 * column + 3] = 0.25
        truth[5:, 3 * column : 3 * column + 3] = 0.75
    camera = {
        "type": "perspective",
        "eye": (0.0, 0.0, 0.0),
        "look_at": (0.0, 0.0, -1.0),
        "vertical_fov_degrees": degrees,
    }
    return Subject(of_polygons(polygons, camera), np.repeat(truth[..., np.newaxis], 3, axis=2))


def coplanar(at: float) -> Subject:
    """A leaning face; in front of it by `at` two more, listed before it and after it, and one behind it by as much."""

    def leaning(left: float, right: float, low: float, high: float, lift: float) -> list[tuple[float, float, float]]:
        corners = ((left, low), (right, low), (right, high), (left, high))
        return [(x, y, 0.375 * x + 0.25 * y + lift) for x, y in corners]

    whole = (leaning(-2.0, 2.0, -2.0, 2.0, 0.0), 0.25)
    before, after = ((leaning(left, left + 0.5, -0.5, 0.5, at), 0.75) for left in (-1.25, -0.25))
    behind = (leaning(0.75, 1.25, -0.5, 0.5, -at), 0.75)
    truth = np.full(SIZE[::-1], 0.25)
    for left in (2, 10):
        truth[4:12, left : left + 4] = 0.75
    scene = of_polygons([before, whole, after, behind])
    return Subject(scene, np.repeat(truth[..., np.newaxis], 3, axis=2))


def grazing(at: float) -> Subject:
    """A floor, seen from `at` degrees above it, so long that it is seen 8 pixels high."""
    sine, cosine = math.sin(math.radians(at)), math.cos(math.radians(at))
    outline = [(-1.13, -0.53), (1.21, -0.41), (1.09, 0.57), (-1.03, 0.49)]
    floor = [(x, 0.0, -y / sine) for x, y in outline]
    away = 4.0 + 1.0 / sine
    camera = {**ABOVE, "eye": (0.0, away * sine, away * cosine)}
    return _flat(of_polygons([(floor, 0.9)], camera), [(_seen(outline), 0.9)])


def _angle_of_view(degrees: float) -> Subject:
    """The edges, from where they are seen as by ABOVE."""
    away = 1.0 / math.tan(math.radians(degrees) / 2.0)
    camera = {
        "type": "perspective",
        "eye": (0.0, 0.0, away),
        "look_at": (0.0, 0.0, 0.0),
        "vertical_fov_degrees": degrees,
    }
    return _flat(of_polygons(EDGES, camera), [(_seen(points), emission) for points, emission in EDGES])


def narrow(at: float) -> Subject:
    return _angle_of_view(at)


def wide(at: float) -> Subject:
    return _angle_of_view(180.0 - at)


def dense(at: float) -> Subject:
    """A square of the size of a pixel, cut into about `at` triangles."""
    side = max(1, round(math.sqrt(0.5 * at)))
    low, high = np.array([0.0037, 0.0071]), np.array([0.1287, 0.1321])
    x, y = (np.linspace(a, b, side + 1) for a, b in zip(low, high, strict=True))
    corner = np.stack(np.broadcast_arrays(x[np.newaxis, :], y[:, np.newaxis], 0.0), axis=-1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    triangles = np.concatenate([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3, 3)
    scene = of_polygons([([(5.0, 5.0, 0.0), (6.0, 5.0, 0.0), (6.0, 6.0, 0.0)], 0.9)])
    mesh = LoadedMesh(material="0.9", sha256=f"dense {side}", triangles=triangles)
    square = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    return _flat(scene.with_meshes({0: mesh}), [(_seen([(float(u), float(v)) for u, v in square]), 0.9)])


LAMP = np.array([2.0, 3.0, 2.0], dtype=np.longdouble)
BALL, RADIUS = np.array([0.0, 0.5, 0.0], dtype=np.longdouble), np.longdouble(0.5)
PLATE, LEFT, RIGHT, BACK, FRONT = 0.25, -1.21, -0.63, 0.37, 1.02
"""Of a plate that hovers over the floor: its height, and where it ends."""
ALBEDO, BACKGROUND = 0.8, 0.05
LOOKING = {
    "type": "perspective",
    "eye": (0.3, 1.6, 4.0),
    "look_at": (0.0, 0.4, 0.0),
    "vertical_fov_degrees": 40.0,
}


def shadow(at: float) -> Subject:
    """A ball that touches a floor and a plate that hovers over it, under a lamp, all of it scaled."""
    floor = [(-2.0, 0.0, -2.0), (2.0, 0.0, -2.0), (2.0, 0.0, 2.0), (-2.0, 0.0, 2.0)]
    plate = [(x, PLATE, z) for x, z in ((LEFT, BACK), (RIGHT, BACK), (RIGHT, FRONT), (LEFT, FRONT))]
    surfaces = [
        {"type": "polygon", "material": MATT, "points": floor},
        {"type": "polygon", "material": MATT, "points": plate},
        {"type": "sphere", "material": MATT, "centre": BALL.tolist(), "radius": float(RADIUS)},
    ]
    scene = _scene(
        LOOKING,
        surfaces,
        view={"size": SIZE, "background": (BACKGROUND,) * 3},
        materials={MATT: {"albedo": (ALBEDO,) * 3}},
        lights=[{"type": "point", "position": LAMP.tolist(), "intensity": (1.0, 1.0, 1.0)}],
    )
    return Subject(scaled(scene, at), np.repeat(_lit(scene)[..., np.newaxis], 3, axis=2))


def _lit(scene: Scene) -> Array:
    """What rays through the middles of the pixels see of the ball, the plate and the floor, in long double."""
    frame = frame_of(scene)
    u = (2.0 * (np.arange(SIZE[0], dtype=np.longdouble) + 0.5) / SIZE[0] - 1.0) * frame.half_width
    v = (1.0 - 2.0 * (np.arange(SIZE[1], dtype=np.longdouble) + 0.5) / SIZE[1]) * frame.half_height
    aim = frame.forward + u[np.newaxis, :, np.newaxis] * frame.right + v[:, np.newaxis, np.newaxis] * frame.up
    way: Long = aim.astype(np.longdouble)
    eye: Long = np.broadcast_to(frame.eye, way.shape).astype(np.longdouble)
    ways = np.stack([_ball(eye, way), _plate(eye, way), _level(eye, way, 0.0, (-2.0, 2.0, -2.0, 2.0))])
    nearest, what = ways.min(axis=0), ways.argmin(axis=0)
    seen = np.isfinite(nearest)
    place = eye + np.where(seen, nearest, 0.0)[..., np.newaxis] * way
    normal = np.where((what == 0)[..., np.newaxis], (place - BALL) / RADIUS, [0.0, 1.0, 0.0])
    light = (LAMP - place).astype(np.longdouble)
    cosine = (light * normal).sum(-1) / np.sqrt((light * light).sum(-1))
    blocked = ((_ball(place, light) < 1.0) & (what != 0)) | ((_plate(place, light) < 1.0) & (what != 1))
    lit = np.where(blocked, 0.0, ALBEDO * np.maximum(cosine, 0.0))
    return np.where(seen, lit, BACKGROUND).astype(np.float64)


def _ball(start: Long, way: Long) -> Long:
    """How far along a way the ball is met first, in front of its start; infinite where it is not."""
    offset = start - BALL
    a, b, c = (way * way).sum(-1), (way * offset).sum(-1), (offset * offset).sum(-1) - RADIUS * RADIUS
    square = b * b - a * c
    near = (-b - np.sqrt(np.maximum(square, 0.0))) / a
    return np.where((square > 0.0) & (near > 0.0), near, np.inf)


def _plate(start: Long, way: Long) -> Long:
    return _level(start, way, PLATE, (LEFT, RIGHT, BACK, FRONT))


def _level(start: Long, way: Long, height: float, ends: tuple[float, float, float, float]) -> Long:
    """As `_ball`, of a rectangle that lies flat."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = (height - start[..., 1]) / way[..., 1]
        x, z = (start[..., axis] + found * way[..., axis] for axis in (0, 2))
        on = (found > 0.0) & (x >= ends[0]) & (x <= ends[1]) & (z >= ends[2]) & (z <= ends[3])
    return np.where(on, found, np.inf)


def picture(renderer: Renderer, mode: str, scene: Scene) -> Array:
    """Also past the renderer's measured limits: they are what is measured. Raises Unsupported, JobFailed."""
    spec = parse(mode, renderer.modes, f"mode of {renderer.name}")
    if reason := unable(renderer, scene, spec):
        raise Unsupported(reason)
    return renderer.render(Request(scene, *SIZE, spec)).pixels.astype(np.float64)
