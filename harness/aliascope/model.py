"""The scene as a file states it, validated and frozen. Nothing here knows a renderer."""

from __future__ import annotations

import functools
import hashlib
import json
import weakref
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Concatenate, Literal, ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from aliascope.bounded import steers

LARGEST_SIDE = 16384
LARGEST_AREA = 1 << 26
LARGEST_COORDINATE = 1e30
LONGEST_TITLE, LONGEST_TEXT, LONGEST_NAME = 1000, 20_000, 1000
MOST_MATERIALS, MOST_LIGHTS = 200_000, 10_000
MOST_POINTS = 20_000
"""Of a polygon. Triangles are found in a time as the square of their number: 5 s on an idle core."""
MOST_SQUARES = 10**9
"""Of all polygons of a scene: the sum of the squares of their numbers of points."""

Coordinate = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST_COORDINATE, le=LARGEST_COORDINATE)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0.0, le=LARGEST_COORDINATE)]
Intensity = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.0, le=LARGEST_COORDINATE)]
Share = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.0, le=1.0)]
Side = Annotated[int, Field(strict=True, ge=1, le=LARGEST_SIDE)]
Vector = tuple[Coordinate, Coordinate, Coordinate]
Colour = tuple[Intensity, Intensity, Intensity]

BLACK: Colour = (0.0, 0.0, 0.0)


LEAST_DIRECTION = 1e-100
"""Shorter ones have no square, so no length, among doubles."""


def _check_direction(name: str, vector: Vector) -> None:
    if max(map(abs, vector)) < LEAST_DIRECTION:
        raise ValueError(f"{name} must not be zero, nor shorter than {LEAST_DIRECTION:g}")


class Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


Rest = ParamSpec("Rest")
Found = TypeVar("Found")


def by_scene(function: Callable[Concatenate[Scene, Rest], Found]) -> Callable[Concatenate[Scene, Rest], Found]:
    """The function, with what it gave for a scene kept as long as the scene is there: a plan asks the same of one scene
    for each of its modes. A scene is known by its identity, which is enough as it is immutable."""
    kept: dict[int, dict[object, Found]] = {}

    @functools.wraps(function)
    def found(scene: Scene, *rest: Rest.args, **more: Rest.kwargs) -> Found:
        if id(scene) not in kept:
            kept[id(scene)] = {}
            weakref.finalize(scene, kept.pop, id(scene), None).atexit = False
        answers, key = kept[id(scene)], (rest, *sorted(more.items()))
        if key not in answers:
            answer = function(scene, *rest, **more)
            answers[key] = _ITSELF if answer is scene else answer  # which would hold it for ever
        known = answers[key]
        return scene if known is _ITSELF else known  # type: ignore[return-value]

    return cast(Callable[Concatenate[Scene, Rest], Found], found)


_ITSELF: Any = object()


class View(Part):
    size: tuple[Side, Side]
    background: Colour = BLACK

    @model_validator(mode="after")
    def _area(self) -> View:
        if self.size[0] * self.size[1] > LARGEST_AREA:
            raise ValueError(f"a picture has at most {LARGEST_AREA} pixels")
        return self


class Camera(Part):
    type: Literal["perspective", "orthographic"]
    eye: Vector
    look_at: Vector
    up: Vector = (0.0, 1.0, 0.0)
    height: Positive | None = None
    vertical_fov_degrees: Annotated[float, Field(strict=True, gt=0.0, lt=180.0)] | None = None
    lens_radius: Annotated[float, Field(strict=True, ge=0.0, le=LARGEST_COORDINATE)] | None = None
    focus_distance: Positive | None = None
    blades: Annotated[int, Field(strict=True, ge=0, le=64)] = 0
    shutter: tuple[Coordinate, Coordinate] | None = None
    response: Literal["box", "triangle"] = "box"

    @model_validator(mode="after")
    def _whole(self) -> Camera:
        perspective = self.type == "perspective"
        if perspective and (self.vertical_fov_degrees is None or self.height is not None):
            raise ValueError('a "perspective" camera has vertical_fov_degrees, and no height')
        if not perspective and (self.height is None or self.vertical_fov_degrees is not None):
            raise ValueError('an "orthographic" camera has height, and no vertical_fov_degrees')
        if (self.lens_radius is None) != (self.focus_distance is None):
            raise ValueError("lens_radius and focus_distance come together")
        if self.lens_radius and not perspective:
            raise ValueError('a lens is for a "perspective" camera')
        if self.blades in (1, 2):
            raise ValueError(f"a lens has 3 blades or more, or 0 where it is round, not {self.blades}")
        if self.shutter is not None and not 0.0 <= self.shutter[0] <= self.shutter[1] <= 1.0:
            raise ValueError("shutter is [open, close] with 0 <= open <= close <= 1")
        forward = [b - a for a, b in zip(self.eye, self.look_at, strict=True)]
        length = sum(x * x for x in forward) ** 0.5
        if length == 0.0:
            raise ValueError("eye and look_at must differ")
        fx, fy, fz = (x / length for x in forward)
        ux, uy, uz = self.up
        cross = (fy * uz - fz * uy, fz * ux - fx * uz, fx * uy - fy * ux)
        if sum(x * x for x in cross) <= 1e-24 * (ux * ux + uy * uy + uz * uz):
            raise ValueError("up must not be zero or along the line of sight (look_at - eye)")
        return self


class ZonePlate(Part):
    """colours[0] + (colours[1] - colours[0]) (1 + cos(scale |p - origin|^2)) / 2."""

    type: Literal["zone-plate"]
    scale: Positive
    origin: Vector = (0.0, 0.0, 0.0)
    colours: tuple[Colour, Colour] = (BLACK, (1.0, 1.0, 1.0))


class Checker(Part):
    """colours[parity of the sum over axes of floor(scale (p - origin))]."""

    type: Literal["checker"]
    scale: Positive
    origin: Vector = (0.0, 0.0, 0.0)
    colours: tuple[Colour, Colour] = (BLACK, (1.0, 1.0, 1.0))


Pattern = Annotated[ZonePlate | Checker, Field(discriminator="type")]


class Phong(Part):
    """The lobe (exponent + 1) / (2 pi) cos^exponent about the mirror direction, over the solid angle."""

    type: Literal["phong"]
    exponent: Annotated[float, Field(strict=True, ge=1.0, le=1e6)]


class Ggx(Part):
    """Microfacets of the distribution GGX, `roughness` its alpha, seen with Smith's masking; no Fresnel term."""

    type: Literal["ggx"]
    roughness: Annotated[float, Field(strict=True, ge=1e-3, le=1.0)]


Lobe = Annotated[Phong | Ggx, Field(discriminator="type")]


class Material(Part):
    """The colour of the pattern, where there is one, multiplies emission and albedo.

    `reflection` is the share of light that is mirrored: in a perfect mirror, or spread by the lobe `gloss`.
    """

    albedo: tuple[Share, Share, Share] = BLACK
    emission: Colour = BLACK
    pattern: Pattern | None = None
    reflection: tuple[Share, Share, Share] = BLACK
    gloss: Lobe | None = None

    @model_validator(mode="after")
    def _energy(self) -> Material:
        colours = zip(*self.pattern.colours, strict=True) if self.pattern else ((1.0,),) * 3
        channels = zip(self.albedo, colours, self.reflection, strict=True)
        if any(albedo * max(1e-300, *colour) + mirrored > 1.0 for albedo, colour, mirrored in channels):
            raise ValueError("albedo (times the pattern) and reflection together are at most 1")
        if self.gloss is not None and self.reflection == BLACK:
            raise ValueError("gloss spreads a reflection, and there is none")
        return self


class Translate(Part):
    """By so much in a unit of time."""

    type: Literal["translate"]
    by: Vector


class Rotate(Part):
    """Right-handed about the axis, `degrees` in a unit of time."""

    type: Literal["rotate"]
    axis: Vector
    centre: Vector = (0.0, 0.0, 0.0)
    degrees: Coordinate

    @model_validator(mode="after")
    def _axis(self) -> Rotate:
        _check_direction("axis", self.axis)
        return self


class Frames(Part):
    """A mesh that changes shape: from its own file at time 0 through these, as far apart in time each, to the last at
    time 1; its corners move along straight lines between them."""

    type: Literal["frames"]
    files: Annotated[
        tuple[Annotated[str, Field(min_length=1, max_length=255)], ...], Field(min_length=1, max_length=128)
    ]


Motion = Annotated[Translate | Rotate | Frames, Field(discriminator="type")]


class Surface(Part):
    material: Annotated[str, Field(max_length=LONGEST_NAME)]
    motion: Motion | None = None


class Polygon(Surface):
    type: Literal["polygon"]
    points: Annotated[tuple[Vector, ...], Field(min_length=3, max_length=MOST_POINTS)]


class Mesh(Surface):
    """A mesh as a scene file states it: the name of a file beside it."""

    type: Literal["mesh"]
    file: Annotated[str, Field(min_length=1, max_length=255)]


class LoadedMesh(Surface):
    """A mesh as it was read, in the place of its `Mesh`: (n, 3, 3) float64, world coordinates. The hash of its file
    stands for the triangles in the scene's digest."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)

    type: Literal["mesh"] = "mesh"
    sha256: str
    triangles: Annotated[NDArray[np.float64], Field(exclude=True)]
    frames: Annotated[NDArray[np.float64] | None, Field(exclude=True)] = None
    """(frames, n, 3, 3), where the motion is of frames: those after the first, which is `triangles`."""


class Sphere(Surface):
    type: Literal["sphere"]
    centre: Vector
    radius: Positive


class Disc(Surface):
    type: Literal["disc"]
    centre: Vector
    normal: Vector = (0.0, 0.0, 1.0)
    radius: Positive

    @model_validator(mode="after")
    def _normal(self) -> Disc:
        _check_direction("normal", self.normal)
        return self


class Plane(Surface):
    type: Literal["plane"]
    point: Vector
    normal: Vector

    @model_validator(mode="after")
    def _normal(self) -> Plane:
        _check_direction("normal", self.normal)
        return self


AnySurface = Annotated[Polygon | Mesh | Sphere | Disc | Plane, Field(discriminator="type")]


class Light(Part):
    intensity: Colour
    falloff: Literal["none", "inverse-square"] = "none"


class PointLight(Light):
    type: Literal["point"]
    position: Vector


class DirectionalLight(Light):
    """`direction` is the way in which the light travels."""

    type: Literal["directional"]
    direction: Vector

    @model_validator(mode="after")
    def _direction(self) -> DirectionalLight:
        _check_direction("direction", self.direction)
        if self.falloff != "none":
            raise ValueError("a directional light comes from no point, so it has no falloff")
        return self


class AreaLight(Light):
    """A parallelogram. It shines to the side of edges[0] x edges[1] where it falls off, else to both."""

    type: Literal["area"]
    corner: Vector
    edges: tuple[Vector, Vector]

    @model_validator(mode="after")
    def _area(self) -> AreaLight:
        (ax, ay, az), (bx, by, bz) = self.edges
        cross = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
        across = (ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz)
        if sum(x * x for x in cross) <= 1e-24 * across:
            raise ValueError("edges must span an area: neither zero nor parallel")
        return self


class DiscLight(Light):
    """It shines to the side of its normal where it falls off, else to both."""

    type: Literal["disc"]
    centre: Vector
    normal: Vector
    radius: Positive

    @model_validator(mode="after")
    def _normal(self) -> DiscLight:
        _check_direction("normal", self.normal)
        return self


class SphereLight(Light):
    type: Literal["sphere"]
    centre: Vector
    radius: Positive


AnyLight = Annotated[PointLight | DirectionalLight | AreaLight | DiscLight | SphereLight, Field(discriminator="type")]


class Transport(Part):
    """How far light is followed. `diffuse_bounces`: over so many diffuse surfaces between a light and the one that is
    seen; 0: from lights alone; none where every albedo is 0. `mirror_bounces`: of a path in mirrors, glossy ones too;
    past them there is no light."""

    diffuse_bounces: Annotated[int, Field(strict=True, ge=0, le=64)] = 0
    mirror_bounces: Annotated[int, Field(strict=True, ge=1, le=64)] = 8


class Needs(Part):
    """What a picture of a scene is an integral over, beside the pixel: read off what the scene contains."""

    lens: bool
    shutter: bool
    area_lights: int
    mirror: bool
    gloss: bool
    diffuse_bounces: int
    mirror_bounces: int
    emitters: int
    """Surfaces that shine, planes and meshes of frames not among them, where gloss or diffuse bounces look for them."""

    @property
    def groups(self) -> tuple[int, ...]:
        """The dimensions of a sample that belong together, in their order: two of the pixel, one of time, two of the
        lens, two of each area light, two of the place on a surface that shines; then of each bounce one of the choice
        how a path goes on, where there are diffuse ones, and two of a direction, where a mirror is not all there is.
        tracer.h has the same."""
        bounce = (1, 2) if self.diffuse_bounces else (2,) if self.gloss else ()
        areas = self.area_lights + (self.emitters > 0)
        bounces = bounce * (self.mirror_bounces + self.diffuse_bounces)
        return (2, *(1,) * self.shutter, *(2,) * self.lens, *(2,) * areas, *bounces)

    @property
    def dimensions(self) -> int:
        """Of a sample: all groups together."""
        return sum(self.groups)


Name = Annotated[str, Field(max_length=LONGEST_NAME)]


def _shown(text: str) -> str:
    if steers(text.replace("\n", "").replace("\t", "")):
        raise ValueError("has control characters, which would steer a terminal: take them out")
    return text


Words = AfterValidator(_shown)
"""Of people, for people."""


class Scene(Part):
    title: Annotated[str, Field(max_length=LONGEST_TITLE), Words]
    shows: Annotated[str, Field(max_length=LONGEST_TEXT), Words]
    view: View
    camera: Camera
    materials: Annotated[dict[Annotated[Name, Words], Material], Field(max_length=MOST_MATERIALS)]
    surfaces: Annotated[tuple[AnySurface, ...], Field(max_length=1_000_000)] = ()
    """Of these, each `Mesh` becomes a `LoadedMesh` when the file is read; nothing else is given one."""
    lights: Annotated[tuple[AnyLight, ...], Field(max_length=MOST_LIGHTS)] = ()
    transport: Transport = Transport()

    def with_meshes(self, loaded: Mapping[int, LoadedMesh]) -> Scene:
        """The scene with the surfaces of these numbers replaced."""
        surfaces = tuple(loaded.get(number, surface) for number, surface in enumerate(self.surfaces))
        return self.model_copy(update={"surfaces": surfaces})

    def features(self) -> frozenset[str]:
        """What the scene asks of a renderer, read off its contents: "disc", "zone-plate", "lens", "point light"..."""
        needs = self.needs()
        found: set[str] = {self.camera.type}
        asked = {"lens": needs.lens, "mirror": needs.mirror, "gloss": needs.gloss}
        # Reading a scene file leaves motion only where a shutter is open (`motion.at`).
        asked["motion"] = any(surface.motion for surface in self.surfaces)
        asked["mesh of frames"] = needs.shutter and any(isinstance(each.motion, Frames) for each in self.surfaces)
        asked["diffuse bounces"] = needs.diffuse_bounces > 0
        found.update(name for name, there in asked.items() if there)
        for surface in self.surfaces:
            found.add(surface.type)
            pattern = self.materials[surface.material].pattern
            if pattern:
                found.add(pattern.type)
        found.update(f"{light.type} light" for light in self.lights)
        return frozenset(found)

    def needs(self) -> Needs:
        """A lens of radius 0, a shutter that nothing moves under, a material that no surface has, bounces between
        surfaces that scatter nothing: none of them is needed."""
        shutter = self.camera.shutter
        is_open = shutter is not None and shutter[0] < shutter[1]
        used = {surface.material for surface in self.surfaces}
        materials = [each for name, each in self.materials.items() if name in used]
        mirrors = [each for each in materials if any(each.reflection)]
        gloss = any(each.gloss is not None for each in mirrors)
        scatters = any(any(each.albedo) for each in materials)
        diffuse_bounces = self.transport.diffuse_bounces if scatters else 0
        emitters = sum(
            any(self.materials[each.material].emission)
            and not isinstance(each, Plane)
            and not (is_open and isinstance(each.motion, Frames))
            for each in self.surfaces
        )
        return Needs(
            lens=bool(self.camera.lens_radius),
            shutter=is_open and any(surface.motion for surface in self.surfaces),
            area_lights=sum(isinstance(light, AreaLight | DiscLight | SphereLight) for light in self.lights),
            mirror=any(each.gloss is None for each in mirrors),
            gloss=gloss,
            diffuse_bounces=diffuse_bounces,
            mirror_bounces=self.transport.mirror_bounces if mirrors else 0,
            emitters=emitters if gloss or diffuse_bounces else 0,
        )

    def digest(self) -> str:
        """SHA-256, in hexadecimal, of what a picture of the scene depends on: not of its words, and a default that is
        written out counts as left out."""
        contents = self.model_dump(
            mode="json",
            exclude={"title", "shows"},
            exclude_defaults=True,
            serialize_as_any=True,  # a LoadedMesh stands where the schema has a Mesh
        )
        text = json.dumps(contents, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()
