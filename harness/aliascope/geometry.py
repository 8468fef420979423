"""From a scene to numbers that every renderer and reference shares: the frame of the view, the triangles."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from aliascope.draws import UNMOVED
from aliascope.model import Disc, LoadedMesh, Motion, Plane, Polygon, Scene, Sphere, Vector

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """The view in numbers. right, up, forward: orthonormal (3,) float64.

    Picture position (px, py), in pixels from the left and top border, lies at u = (2 px / width - 1) half_width along
    right and v = (1 - 2 py / height) half_height along up: a perspective ray goes from eye along forward + u right +
    v up, an orthographic one from eye + u right + v up along forward. With a `shift`, by which all that is seen is
    moved to the right and down, it lies where (px, py) less the shift does without one.
    """

    perspective: bool
    width: int
    height: int
    eye: Array
    right: Array
    up: Array
    forward: Array
    half_width: float
    half_height: float
    shift: tuple[float, float] = UNMOVED

    @property
    def middle(self) -> tuple[float, float]:
        """Where u and v are 0, in pixels from the left and top border."""
        return self.width / 2 + self.shift[0], self.height / 2 + self.shift[1]

    @property
    def spans(self) -> tuple[float, float]:
        """The largest numbers, in pixels across and down, that places on the picture are sums of: they set rounding."""
        return self.width + abs(self.shift[0]), self.height + abs(self.shift[1])

    @property
    def pixel(self) -> float:
        """The side of a pixel, in the units of u and v."""
        return 2.0 * self.half_height / self.height


def frame_of(scene: Scene, size: tuple[int, int] | None = None, shift: tuple[float, float] = UNMOVED) -> Frame:
    """The frame of a scene's camera, moved by `shift` pixels to the right and down on the film. Another `size` keeps
    the vertical extent; the horizontal follows the aspect."""
    width, height = size or scene.view.size
    camera = scene.camera
    eye = np.array(camera.eye)
    forward = np.array(camera.look_at) - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, np.array(camera.up))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    if camera.height is not None:
        half_height = camera.height / 2.0
    else:
        assert camera.vertical_fov_degrees is not None  # the model's validator holds this
        half_height = math.tan(math.radians(camera.vertical_fov_degrees) / 2.0)
    return Frame(
        perspective=camera.type == "perspective",
        width=width,
        height=height,
        eye=eye,
        right=right,
        up=up,
        forward=forward,
        half_width=half_height * width / height,
        half_height=half_height,
        shift=shift,
    )


def across(normal: Array) -> tuple[Array, Array]:
    """Two orthonormal axes at a right angle to a unit vector (3,), which is their cross product."""
    smallest = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(normal, smallest)
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)


def plane_axes(points: Array) -> tuple[Array, Array, Array]:
    """Two orthonormal axes within the plane of a polygon's points (n, 3), and its unit normal (Newell 1972)."""
    following = np.roll(points, -1, axis=0)
    centred, after = points - points[0], following - points[0]
    normal = np.cross(centred, after).sum(axis=0)
    length = float(np.linalg.norm(normal))
    if length == 0.0:
        raise ValueError("the polygon has no area")
    normal /= length
    return *across(normal), normal


def triangulate(polygon: Polygon) -> Array:
    """The triangles of a planar simple polygon, (n, 3, 3) float64, its own corners only.

    Raises ValueError for a polygon that crosses itself, has no area or does not lie in a plane.
    """
    points = np.array(polygon.points)
    if len(points) == 3:
        plane_axes(points)
        return points[np.newaxis]
    first, second, normal = plane_axes(points)
    relative = points - points[0]
    extent = float(np.abs(relative).max())
    # Far from the origin, corners are rounded out of the plane: each coordinate by half a unit in its last place, those
    # of points[0] and of the normal too.
    rounding = 8.0 * 2.0**-53 * float(np.abs(points).max())
    if float(np.abs(relative @ normal).max()) > 1e-9 * extent + rounding:
        raise ValueError("the points of the polygon do not lie in one plane")
    flat = np.column_stack([relative @ first, relative @ second])
    outline = shapely.Polygon(flat)
    if not outline.is_valid:
        raise ValueError("the polygon crosses or touches itself")
    pieces = shapely.constrained_delaunay_triangles(outline).geoms
    corners = np.array([np.asarray(piece.exterior.coords)[:3] for piece in pieces])
    # The corners are the polygon's, to the bit: found by their values, as there may be too many for all distances.
    number = {place: i for i, place in enumerate(map(tuple, flat.tolist()))}
    found = [number[place] for place in map(tuple, corners.reshape(-1, 2).tolist())]
    drawn: Array = points[np.array(found)].reshape(-1, 3, 3)
    return drawn


@dataclass(frozen=True)
class Surfaces:
    """A scene's surfaces as arrays; materials by index into `materials`, its names in order of first use.

    triangles (n, 3, 3), triangle_material (n,); discs (centre, normal, radius, material), spheres (centre, radius,
    material) and planes (point, normal, material) as the scene states them, at time 0. What moves has, by kind and in
    the same order, one more than the index of its motion, and 0 what stands still. frames: by motion, None but for
    meshes of frames: (frames, n, 3, 3), the n triangles that have that motion.
    """

    materials: tuple[str, ...]
    triangles: Array
    triangle_material: NDArray[np.uint32]
    discs: tuple[tuple[Vector, Vector, float, int], ...]
    spheres: tuple[tuple[Vector, float, int], ...]
    planes: tuple[tuple[Vector, Vector, int], ...]
    motions: tuple[Motion, ...]
    triangle_motion: NDArray[np.uint32]
    disc_motion: tuple[int, ...]
    sphere_motion: tuple[int, ...]
    plane_motion: tuple[int, ...]
    frames: tuple[Array | None, ...]


def surfaces_of(scene: Scene) -> Surfaces:
    """The surfaces of a scene. Only those are here that a renderer was found able to draw (see `Scene.features`)."""
    names = tuple(dict.fromkeys(surface.material for surface in scene.surfaces))
    index = {name: i for i, name in enumerate(names)}
    triangles: list[Array] = []
    material: list[NDArray[np.uint32]] = []
    discs: list[tuple[Vector, Vector, float, int]] = []
    spheres: list[tuple[Vector, float, int]] = []
    planes: list[tuple[Vector, Vector, int]] = []
    motions = tuple(dict.fromkeys(surface.motion for surface in scene.surfaces if surface.motion))
    moving = {None: 0} | {motion: i for i, motion in enumerate(motions, 1)}
    triangle_motion: list[NDArray[np.uint32]] = []
    frames: list[list[Array]] = [[] for _ in motions]
    round_motion: dict[type, list[int]] = {Disc: [], Sphere: [], Plane: []}
    for surface in scene.surfaces:
        number, motion = index[surface.material], moving[surface.motion]
        if type(surface) in round_motion:
            round_motion[type(surface)].append(motion)
        match surface:  # a mesh was read with its file
            case Polygon():
                pieces = triangulate(surface)
                triangles.append(pieces)
                material.append(np.full(len(pieces), number, np.uint32))
                triangle_motion.append(np.full(len(pieces), motion, np.uint32))
            case Disc(centre=centre, normal=normal, radius=radius):
                discs.append((centre, normal, radius, number))
            case Sphere(centre=centre, radius=radius):
                spheres.append((centre, radius, number))
            case Plane(point=point, normal=normal):
                planes.append((point, normal, number))
            case LoadedMesh(triangles=pieces):
                triangles.append(pieces)
                material.append(np.full(len(pieces), number, np.uint32))
                triangle_motion.append(np.full(len(pieces), motion, np.uint32))
                if surface.frames is not None:
                    frames[motion - 1].append(surface.frames)
    return Surfaces(
        materials=names,
        triangles=np.concatenate(triangles) if triangles else np.zeros((0, 3, 3)),
        triangle_material=np.concatenate(material) if material else np.zeros(0, np.uint32),
        discs=tuple(discs),
        spheres=tuple(spheres),
        planes=tuple(planes),
        motions=motions,
        triangle_motion=np.concatenate(triangle_motion) if triangle_motion else np.zeros(0, np.uint32),
        disc_motion=tuple(round_motion[Disc]),
        sphere_motion=tuple(round_motion[Sphere]),
        plane_motion=tuple(round_motion[Plane]),
        frames=tuple(np.concatenate(each, axis=1) if each else None for each in frames),
    )
