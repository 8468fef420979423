"""Scene files: TOML, validated, where every error names file, line and key; and those of other programs, glTF."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

import numpy as np
from pydantic import ValidationError

from aliascope import meshes, model, motion, places, toml_files
from aliascope.bounded import as_shown, shortened, steers
from aliascope.errors import InvalidInput, near_misses
from aliascope.geometry import Array, triangulate
from aliascope.gltf import document, reading
from aliascope.model import Frames, LoadedMesh, Mesh, Part, Polygon, Scene

LONGEST_NAME = 200
"""Of a scene: what is added for a file of results still fits."""
FORMULA = "=+-@"
"""What a spreadsheet takes for the beginning of a formula, quoted in a CSV file or not."""

ENDINGS = (".toml", *document.ENDINGS)


@dataclass(frozen=True)
class SceneFile:
    """A scene and where it came from. `name` is the file's, without its ending."""

    name: str
    path: Path
    scene: Scene
    notes: tuple[str, ...] = ()
    """What the file has that is not drawn, or had to be added, in words; nothing of a TOML file is."""


def is_path(scene: str) -> bool:
    """Whether a word names a scene's file: it has a slash, or the ending of one."""
    return "/" in scene or scene.lower().endswith(ENDINGS)


def names() -> list[str]:
    """The scenes that the project has."""
    return sorted(path.stem for path in places.SCENES.glob("*.toml"))


def load(scene: str) -> SceneFile:
    """A scene by its name in scenes/ or the path of its file (`is_path`)."""
    if is_path(scene):
        return load_file(Path(scene))
    if scene not in names():
        raise InvalidInput(f'unknown scene "{scene}"{near_misses(scene, names())}')
    return load_file(places.SCENES / f"{scene}.toml")


def load_file(path: Path) -> SceneFile:
    """The scene of a file, read as its ending says: glTF, else TOML."""
    check_name(path)
    if path.suffix.lower() in document.ENDINGS:
        found = reading.read(path)
        return SceneFile(path.stem, path, found.scene, found.notes)
    data, lines = toml_files.read(path, "scene")
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        raise toml_files.refused(path, lines, error, "scene", _fields_at, _TAGS) from error
    _check_surfaces(path, lines, scene)
    scene = scene.with_meshes(_meshes(path, lines, scene))
    try:
        return SceneFile(path.stem, path, motion.stilled(scene))
    except InvalidInput as error:
        raise InvalidInput(
            f"{path}:{toml_files.line_of(lines, ('camera', 'shutter'))}: camera.shutter: {error}"
        ) from error


def check_name(path: Path) -> None:
    """Raises InvalidInput for a file whose name, which is its scene's, would lead elsewhere as the name of a folder,
    steer a terminal, or be computed by a spreadsheet that opens a table of results."""
    name = path.stem
    if name in ("", ".", "..") or len(name) > LONGEST_NAME or steers(name):
        raise InvalidInput(
            f"{as_shown(str(path))}: a scene is named as its file, with 1 to {LONGEST_NAME} characters, which are "
            "letters, digits and signs, and not . or ..: rename it"
        )
    if name[0] in FORMULA:
        raise InvalidInput(
            f"{path}: a scene is named as its file, and in a table of results a spreadsheet takes a name that begins "
            f"with {name[0]} for a formula: rename it"
        )


def _meshes(path: Path, lines: dict[toml_files.Place, int], scene: Scene) -> dict[int, LoadedMesh]:
    """The meshes of a scene by the number of their surface; their files lie in its folder or below."""
    loaded: dict[int, LoadedMesh] = {}
    reader = _Meshes(path, lines)
    for index, surface in enumerate(scene.surfaces):
        if isinstance(surface, Mesh):
            names = (surface.file, *(surface.motion.files if isinstance(surface.motion, Frames) else ()))
            read = [reader.read(index, name, later > 0) for later, name in enumerate(names)]
            sha256, triangles = read[0]
            frames = None
            for name, (frame_sha256, frame) in zip(names[1:], read[1:], strict=True):
                if frame.shape != triangles.shape:
                    line = toml_files.line_of(lines, ("surfaces", index, "motion"))
                    raise InvalidInput(
                        f'{path}:{line}: surfaces.motion: "{name}" has {len(frame)} triangles and "{surface.file}" '
                        f"{len(triangles)}: the frames of a mesh have the same"
                    )
                sha256 += frame_sha256
            if len(read) > 1:
                frames = np.stack([frame for _, frame in read[1:]])
            loaded[index] = LoadedMesh(
                material=surface.material, motion=surface.motion, sha256=sha256, triangles=triangles, frames=frames
            )
    return loaded


@dataclass
class _Meshes:
    """Reads the meshes of a scene, each file once, and holds them to what a scene may have together."""

    path: Path
    lines: dict[toml_files.Place, int]
    known: dict[Path, tuple[str, Array]] = field(default_factory=dict)
    triangles: int = 0
    size: int = 0

    def read(self, index: int, name: str, frame: bool) -> tuple[str, Array]:
        """The file's SHA-256, and its triangles. Raises InvalidInput."""
        key = "motion" if frame else "file"
        try:
            place = meshes.within(self.path.parent, name)
            if place not in self.known:
                self._add(place)
            found = self.known[place]
            self.triangles += len(found[1])
            if self.triangles > meshes.MOST_OF_A_SCENE:
                raise InvalidInput(f"the meshes of a scene have at most {meshes.MOST_OF_A_SCENE} triangles, frames too")
        except InvalidInput as error:
            line = toml_files.line_of(self.lines, ("surfaces", index, key))
            raise InvalidInput(f"{self.path}:{line}: surfaces.{key}: {error}") from error
        return found

    def _add(self, place: Path) -> None:
        if place.is_file():
            self.size += place.stat().st_size
        if self.size > meshes.LARGEST_FILES:
            raise InvalidInput(f"the mesh files of a scene have at most {meshes.LARGEST_FILES >> 20} MiB together")
        if place.suffix.lower() in document.ENDINGS:
            reading.check(place)  # its nodes and counts, which trimesh takes as they are
        self.known[place] = meshes.load(place)


def _check_surfaces(path: Path, lines: dict[toml_files.Place, int], scene: Scene) -> None:
    if sum(len(each.points) ** 2 for each in scene.surfaces if isinstance(each, Polygon)) > model.MOST_SQUARES:
        raise InvalidInput(
            f"{path}: the squares of the numbers of points of its polygons add up to more than {model.MOST_SQUARES}, "
            "and their triangles would take too long to find: cut the largest into pieces"
        )
    for index, surface in enumerate(scene.surfaces):
        if surface.material not in scene.materials:
            line = toml_files.line_of(lines, ("surfaces", index, "material"))
            missed = near_misses(surface.material, scene.materials)
            raise InvalidInput(
                f'{path}:{line}: surfaces.material: unknown material "{shortened(surface.material)}"{missed}'
            )
        if isinstance(surface.motion, Frames):
            line = toml_files.line_of(lines, ("surfaces", index, "motion"))
            if not isinstance(surface, Mesh):
                raise InvalidInput(
                    f'{path}:{line}: surfaces.motion: only a mesh has "frames"; translate or rotate this'
                )
        if isinstance(surface, Polygon):
            try:
                triangulate(surface)
            except ValueError as error:
                line = toml_files.line_of(lines, ("surfaces", index, "points"))
                raise InvalidInput(f"{path}:{line}: surfaces.points: {error}") from error


# --- which keys there are, for what pydantic found --------------------------------------------------------------------


def _tagged() -> dict[str, type[Part]]:
    classes: list[type[Part]] = list(Part.__subclasses__())
    for each in classes:
        classes.extend(each.__subclasses__())
    sections: dict[str, type[Part]] = {"view": model.View, "camera": model.Camera, "materials": model.Material}
    sections["transport"] = model.Transport
    tags = {
        tag: each
        for each in classes
        if each is not model.Camera and "type" in each.model_fields
        for tag in get_args(each.model_fields["type"].annotation)
    }
    return sections | tags


_CLASSES = _tagged()
_TAGS = frozenset(_CLASSES) - {"view", "camera", "materials", "transport"}


def _fields_at(location: tuple[int | str, ...]) -> list[str]:
    """The keys that may stand at a location: those of the last section or tag on the way."""
    for part in reversed(location):
        if part in _CLASSES:
            return list(_CLASSES[str(part)].model_fields)
    return list(Scene.model_fields)


def describe(file: SceneFile) -> dict[str, Any]:
    """One line of `aliascope list scenes`."""
    scene = file.scene
    return {"name": file.name, "title": scene.title, "shows": scene.shows, "needs": sorted(scene.features())}
