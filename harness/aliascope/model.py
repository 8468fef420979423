"""The scene as a file states it, validated and frozen. Nothing here knows a renderer."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

LARGEST_SIDE = 16384
LARGEST_AREA = 1 << 26
LARGEST_COORDINATE = 1e30

Coordinate = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST_COORDINATE, le=LARGEST_COORDINATE)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0.0, le=LARGEST_COORDINATE)]
Intensity = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.0, le=LARGEST_COORDINATE)]
Share = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.0, le=1.0)]
Side = Annotated[int, Field(strict=True, ge=1, le=LARGEST_SIDE)]
Vector = tuple[Coordinate, Coordinate, Coordinate]
Colour = tuple[Intensity, Intensity, Intensity]

BLACK: Colour = (0.0, 0.0, 0.0)


class Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


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
        if self.shutter is not None and not self.shutter[0] <= self.shutter[1]:
            raise ValueError("shutter must open before it closes: [open, close]")
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


class Material(Part):
    """The colour of the pattern, where there is one, multiplies emission and albedo."""

    albedo: tuple[Share, Share, Share] = BLACK
    emission: Colour = BLACK
    pattern: Pattern | None = None


class Translate(Part):
    type: Literal["translate"]
    by: Vector


class Rotate(Part):
    type: Literal["rotate"]
    axis: Vector
    centre: Vector = (0.0, 0.0, 0.0)
    degrees: Coordinate


Motion = Annotated[Translate | Rotate, Field(discriminator="type")]


class Surface(Part):
    material: str
    motion: Motion | None = None


class Polygon(Surface):
    type: Literal["polygon"]
    points: Annotated[tuple[Vector, ...], Field(min_length=3, max_length=100_000)]


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
        if not any(self.normal):
            raise ValueError("normal must not be zero")
        return self


class Plane(Surface):
    type: Literal["plane"]
    point: Vector
    normal: Vector

    @model_validator(mode="after")
    def _normal(self) -> Plane:
        if not any(self.normal):
            raise ValueError("normal must not be zero")
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
        if not any(self.direction):
            raise ValueError("direction must not be zero")
        if self.falloff != "none":
            raise ValueError("a directional light comes from no point, so it has no falloff")
        return self


class AreaLight(Light):
    type: Literal["area"]
    corner: Vector
    edges: tuple[Vector, Vector]


class DiscLight(Light):
    type: Literal["disc"]
    centre: Vector
    normal: Vector
    radius: Positive


class SphereLight(Light):
    type: Literal["sphere"]
    centre: Vector
    radius: Positive


AnyLight = Annotated[PointLight | DirectionalLight | AreaLight | DiscLight | SphereLight, Field(discriminator="type")]


class Scene(Part):
    title: str
    shows: str
    view: View
    camera: Camera
    materials: dict[str, Material]
    surfaces: Annotated[tuple[AnySurface, ...], Field(max_length=1_000_000)] = ()
    """Of these, each `Mesh` becomes a `LoadedMesh` when the file is read; nothing else is given one."""
    lights: tuple[AnyLight, ...] = ()

    def with_meshes(self, loaded: Mapping[int, LoadedMesh]) -> Scene:
        """The scene with the surfaces of these numbers replaced."""
        surfaces = tuple(loaded.get(number, surface) for number, surface in enumerate(self.surfaces))
        return self.model_copy(update={"surfaces": surfaces})

    def features(self) -> frozenset[str]:
        """What the scene asks of a renderer, read off its contents: "disc", "zone-plate", "lens", "point light"..."""
        found: set[str] = {self.camera.type}
        if self.camera.lens_radius:
            found.add("lens")
        if any(surface.motion for surface in self.surfaces):
            found.add("motion")
        for surface in self.surfaces:
            found.add(surface.type)
            pattern = self.materials[surface.material].pattern
            if pattern:
                found.add(pattern.type)
        found.update(f"{light.type} light" for light in self.lights)
        return frozenset(found)

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
