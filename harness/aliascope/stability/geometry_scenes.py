"""Small scenes for the extremes of geometry, each with the truth of what a ray sees, in double or exact."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from aliascope.geometry import Array, frame_of
from aliascope.model import (
    AnySurface,
    Camera,
    Checker,
    DirectionalLight,
    Disc,
    LoadedMesh,
    Material,
    Polygon,
    Scene,
    Sphere,
    Vector,
    View,
)
from aliascope.stability.per_sample import SIZE, Truth

WHITE = Material(emission=(1.0, 1.0, 1.0))
MATERIALS = {"white": WHITE, "black": Material(), "chalk": Material(albedo=(1.0, 1.0, 1.0))}
SUN = (0.36, -0.8, -0.48)
"""The way of its light, of length 1."""


def orthographic(height: float, distance: float = 10.0) -> Camera:
    """Sees x to the right and y up, from `distance` along z."""
    return Camera(type="orthographic", eye=(0.0, 0.0, distance), look_at=(0.0, 0.0, 0.0), height=height)


def perspective(degrees: float, eye: Vector = (0.0, 0.0, 0.0), look_at: Vector = (0.0, 0.0, -1.0)) -> Camera:
    return Camera(type="perspective", eye=eye, look_at=look_at, vertical_fov_degrees=degrees)


def made(camera: Camera, surfaces: Sequence[AnySurface | LoadedMesh], lit: bool = False, **more: Material) -> Scene:
    sun = (DirectionalLight(type="directional", intensity=(1.0, 1.0, 1.0), direction=SUN),) if lit else ()
    scene = Scene(
        title="A probe", shows="a probe", view=View(size=SIZE), camera=camera, materials=MATERIALS | more, lights=sun
    )
    return scene.model_copy(update={"surfaces": tuple(surfaces)})


def polygon(material: str, *points: Sequence[float]) -> Polygon:
    return Polygon(type="polygon", material=material, points=tuple((x, y, z) for x, y, z in points))


def mesh(material: str, triangles: Array) -> LoadedMesh:
    return LoadedMesh(material=material, sha256="", triangles=triangles)


def sliver(length: float) -> tuple[Scene, Truth]:
    """A triangle across the picture, at 30 degrees: `length` long, 1 wide at its end and so 1/2 in the middle."""
    along, up = np.array([math.cos(math.pi / 6), 0.5, 0.0]), np.array([-0.5, math.cos(math.pi / 6), 0.0])
    corners = [-0.5 * length * along, 0.5 * (length * along - up), 0.5 * (length * along + up)]

    def truth(u: Array, v: Array) -> Array:
        inside = np.ones(u.shape, bool)
        for a, b in ((0, 1), (1, 2), (2, 0)):
            (ax, ay, _), (bx, by, _) = corners[a], corners[b]
            inside &= (bx - ax) * (v - ay) - (by - ay) * (u - ax) > 0.0
        return np.asarray(inside * 1.0)

    return made(orthographic(4.0), [polygon("white", *corners)]), truth


def road(far: float) -> tuple[Scene, Truth]:
    """A floor under the eye, from 1/2 to `far` ahead and as far to the left, 1/4 to the right; the sun lights it."""
    points = ((-far, -1.0, -0.5), (0.25, -1.0, -0.5), (0.25, -1.0, -far), (-far, -1.0, -far))

    def truth(u: Array, v: Array) -> Array:
        ahead = np.where(v < 0.0, -1.0 / np.where(v < 0.0, v, -1.0), 0.0)
        seen = (ahead > 0.5) & (ahead < far) & (u * ahead < 0.25) & (u * ahead > -far)
        return np.asarray(seen * -SUN[1])

    return made(perspective(90.0), [polygon("chalk", *points)], lit=True), truth


def planet(radius: float) -> tuple[Scene, Truth]:
    """A ball whose top is 1 under the eye, under the sun."""
    ball = Sphere(type="sphere", material="chalk", centre=(0.0, -1.0 - radius, 0.0), radius=radius)

    def truth(u: Array, v: Array) -> Array:
        """In the precision of np.longdouble; the nearer root as the quotient by the farther, which cancels nothing."""
        size, way = np.longdouble(radius), np.stack([u, v, -np.ones(u.shape)]).astype(np.longdouble)
        centre = np.array([0.0, -1.0 - size, 0.0]).reshape(3, 1, 1, 1)
        toward = (way * centre).sum(axis=0)
        inside = toward**2 - (way * way).sum(axis=0) * (2.0 * size + 1.0)
        far = toward + np.sqrt(np.maximum(inside, 0.0))
        seen = (inside > 0.0) & (toward > 0.0)
        normal = ((2.0 * size + 1.0) / np.where(seen, far, 1.0) * way - centre) / size
        cosine = -(normal * np.array(SUN).reshape(3, 1, 1, 1)).sum(axis=0)
        return np.asarray(np.where(seen, np.maximum(cosine, 0.0), 0.0), np.float64)

    return made(perspective(90.0), [ball], lit=True), truth


def horizon(radius: float) -> tuple[Scene, Truth]:
    """The same through a window of which the dip of its horizon is an eighth of the height, or less."""
    scene, truth = planet(radius)
    narrow = 2.0 * math.degrees(math.atan(4.0 * math.sqrt(2.0 / radius)))
    return scene.model_copy(update={"camera": perspective(min(narrow, 90.0))}), truth


def plate(radius: float) -> tuple[Scene, Truth]:
    """A disc whose plane is 1 under the eye, tilted, and whose centre is to one side; under the sun."""
    centre, normal = (0.5 * radius, -1.0 - 0.0625 * radius, 0.25 * radius), (0.125, 1.0, 0.0)
    disc = Disc(type="disc", material="chalk", centre=centre, normal=normal, radius=radius)

    def truth(u: Array, v: Array) -> Array:
        way = np.stack([u, v, -np.ones(u.shape)]).astype(np.longdouble)
        along = (way * np.array(normal).reshape(3, 1, 1, 1)).sum(axis=0)
        ahead = -1.0 / np.where(along < 0.0, along, -1.0)
        away = ahead * way - np.array(centre).reshape(3, 1, 1, 1)
        seen = (along < 0.0) & ((away * away).sum(axis=0) < np.longdouble(radius) ** 2)
        return np.asarray(seen * -np.dot(normal, SUN) / np.linalg.norm(normal), np.float64)

    return made(perspective(90.0), [disc], lit=True), truth


def grazed(elevation: float) -> tuple[Scene, Truth]:
    """A plate from -1 to 1 in x and z, of checks 1/4 wide, seen from `elevation` degrees above its plane, so near that
    it fills five sixths of the picture."""
    sine, cosine = math.sin(math.radians(elevation)), math.cos(math.radians(elevation))
    camera = Camera(
        type="orthographic", eye=(0.0, 10.0 * sine, 10.0 * cosine), look_at=(0.0, 0.0, 0.0), height=2.4 * sine
    )
    checks = Material(
        emission=(1.0, 1.0, 1.0), pattern=Checker(type="checker", scale=4.0, origin=(-1.03125, -0.125, -1.03125))
    )
    points = ((-1.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 0.0, -1.0), (-1.0, 0.0, -1.0))

    def truth(u: Array, v: Array) -> Array:
        z = -v / sine
        odd = (np.floor(4.0 * (u + 1.03125)) + np.floor(4.0 * (z + 1.03125))) % 2.0
        return np.asarray(odd * (np.abs(z) < 1.0))

    return made(camera, [polygon("checks", *points)], checks=checks), truth


def one_before_another(gap: float, white_first: bool) -> tuple[Scene, Truth]:
    """A white face across the picture, a black one `gap` behind it, both seen from 10 away, at a slant."""
    corners = np.array([[-9.0, -7.0, -2.0], [8.0, -6.0, 1.0], [0.5, 17.0, 0.5]])
    faces = [polygon("black", *(corners - [0.0, 0.0, gap])), polygon("white", *corners)]
    return made(orthographic(2.0), faces[:: -1 if white_first else 1]), lambda u, v: np.ones(u.shape)


def tiles(count: float) -> tuple[Scene, Truth]:
    """So many triangles in each of four pixels: a picture 2 pixels wide and high, of white and black squares."""
    side = max(1, round(math.sqrt(count / 2.0))) * 2
    at = np.linspace(-1.0, 1.0, side + 1)
    left, bottom = (each.ravel() for each in np.meshgrid(np.arange(side), np.arange(side)))
    corners = [
        np.column_stack([at[left + i], at[bottom + j], np.zeros(left.size)])
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))
    ]
    triangles = np.stack([np.stack([corners[0], corners[k], corners[k + 1]], axis=1) for k in (1, 2)], axis=1)
    odd = (left + bottom) % 2 == 1

    def truth(u: Array, v: Array) -> Array:
        squares = [np.searchsorted(at, each, side="right") - 1 for each in (u, v)]
        return np.asarray((squares[0] + squares[1]) % 2 * 1.0)

    meshes = [mesh("white", triangles[odd].reshape(-1, 3, 3)), mesh("black", triangles[~odd].reshape(-1, 3, 3))]
    return made(orthographic(2.0), meshes), truth


def room(degrees: float) -> tuple[Scene, Truth]:
    """The inside of a cube from -1 to 1, of checks, seen from its middle."""
    checks = Material(emission=(1.0, 1.0, 1.0), pattern=Checker(type="checker", scale=3.0, origin=(0.09, 0.07, 0.05)))
    sides = []
    for axis in range(3):
        for end in (-1.0, 1.0):
            across = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
            sides.append(polygon("checks", *(np.insert(each, axis, end).tolist() for each in across)))

    def truth(u: Array, v: Array) -> Array:
        way = np.stack([u, v, -np.ones(u.shape)])
        place = way / np.abs(way).max(axis=0)
        origin = np.array([0.09, 0.07, 0.05]).reshape(3, 1, 1, 1)
        return np.asarray(np.floor(3.0 * (place - origin)).sum(axis=0) % 2.0)

    return made(perspective(degrees), sides, checks=checks), truth


def rough_ball(side: int) -> Scene:
    """From within a closed mesh, a cube of squares that were moved out to a ball with waves: 12 side^2 triangles,
    white, before nothing, which is black."""
    at = np.linspace(-1.0, 1.0, side + 1)
    first, second = np.meshgrid(at, at, indexing="ij")
    faces = []
    for axis in range(3):
        for end in (-1.0, 1.0):
            grid = np.insert(np.stack([first, second], axis=-1), axis, end, axis=-1)
            faces.append(_squares(grid))
    # Corners are moved once each, so that triangles share them to the bit.
    corners, number = np.unique(np.concatenate(faces).reshape(-1, 3), axis=0, return_inverse=True)
    waves = 1.0 + 0.2 * np.sin(9.0 * corners).prod(axis=1)
    ball = corners * (waves / np.linalg.norm(corners, axis=1))[:, np.newaxis]
    camera = perspective(100.0, (0.11, -0.07, 0.13), (-0.5, 0.37, -0.71))
    return made(camera, [mesh("white", ball[number.ravel()].reshape(-1, 3, 3))])


def aimed_at(side: int) -> Scene:
    """For a picture of 2 side pixels a side, each with one ray through its middle: a rough white mesh beyond the
    picture's border, whose corners lie on every second ray along and down, so that the others go through its edges."""
    camera = perspective(70.0, (0.31, -1.27, 2.03), (-0.41, 0.22, 0.17))
    frame = frame_of(made(camera, []), (2 * side, 2 * side))
    middles = np.arange(-2.0, 2 * side + 3.0, 2.0) + 0.5
    right, down = np.meshgrid(middles, middles)
    u = (right / side - 1.0) * frame.half_width
    v = (1.0 - down / side) * frame.half_height
    away = 1.0 + 0.5 * np.random.default_rng(5).random(u.shape)
    way = frame.forward + u[..., np.newaxis] * frame.right + v[..., np.newaxis] * frame.up
    return made(camera, [mesh("white", _squares(frame.eye + away[..., np.newaxis] * way))])


def _squares(grid: Array) -> Array:
    """Two triangles for each square of a grid of corners (n, m, 3): (2 (n - 1) (m - 1), 3, 3)."""
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return np.concatenate([np.stack(each, axis=-2).reshape(-1, 3, 3) for each in ((a, b, c), (a, c, d))])


def ball_on_a_floor(camera: Camera) -> tuple[Scene, Truth]:
    """A ball of radius 1 just over a square floor, under the sun, all chalk; the camera looks at (0, 0, 0) along -z and
    down by 3 in 5."""
    radius, height, half = 1.0, 1.0009765625, 4.0
    floor = polygon("chalk", *((x, -1.0, z) for x, z in ((-half, half), (half, half), (half, -half), (-half, -half))))
    ball = Sphere(type="sphere", material="chalk", centre=(0.0, height - 1.0, 0.0), radius=radius)
    eye, away = np.array(camera.eye), np.array([0.0, 0.6, 0.8])
    up, right = np.array([0.0, 0.8, -0.6]), np.array([1.0, 0.0, 0.0])
    centre, sun = np.array(ball.centre), -np.array(SUN)

    def truth(u: Array, v: Array) -> Array:
        """From the plane through the origin that faces the camera, where the picture is sharpest in double."""
        distance = float(eye @ away)
        start = distance * (u[..., np.newaxis] * right + v[..., np.newaxis] * up)
        way = u[..., np.newaxis] * right + v[..., np.newaxis] * up - away
        to_ball = _meets(centre, radius, start, way)
        to_floor = (-1.0 - start[..., 1]) / way[..., 1]
        place = start + to_floor[..., np.newaxis] * way
        on_floor = (np.abs(place[..., 0]) < half) & (np.abs(place[..., 2]) < half)
        lit = ~np.isfinite(_meets(centre, radius, place, np.broadcast_to(sun, place.shape)))
        normal = (start + np.where(np.isfinite(to_ball), to_ball, 0.0)[..., np.newaxis] * way - centre) / radius
        shaded = np.maximum(normal @ sun, 0.0)
        return np.asarray(np.where(np.isfinite(to_ball), shaded, np.where(on_floor, lit * sun[1], 0.0)))

    return made(camera, [floor, ball], lit=True), truth


def _meets(centre: Array, radius: float, start: Array, way: Array) -> Array:
    """How far along ways (..., 3) the ball is first met; infinite where it is not. From outside, either way."""
    to = centre - start
    squared = (way * way).sum(axis=-1)
    foot = (to * way).sum(axis=-1) / squared
    miss = to - foot[..., np.newaxis] * way
    inside = radius * radius - (miss * miss).sum(axis=-1)
    return np.where(inside > 0.0, foot - np.sqrt(np.maximum(inside, 0.0) / squared), np.inf)


def narrow_camera(degrees: float) -> Camera:
    """Looks at (0, 0, 0) from so far away that the picture is about 6 high there."""
    distance = 3.0 / math.tan(math.radians(degrees) / 2.0)
    return perspective(degrees, (0.0, 0.6 * distance, 0.8 * distance), (0.0, 0.0, 0.0))
