"""Scene files: TOML, validated, where every error names file, line and key; and those of other programs, glTF."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import numpy as np
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from aliascope import meshes, model, motion, places
from aliascope.errors import InvalidInput, near_misses
from aliascope.geometry import Array, triangulate
from aliascope.gltf import document, reading
from aliascope.model import Frames, LoadedMesh, Mesh, Part, Polygon, Scene

LARGEST_FILE = 64 << 20
ENDINGS = (".toml", *document.ENDINGS)

Path_ = tuple[str | int, ...]


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
    if path.suffix.lower() in document.ENDINGS:
        found = reading.read(path)
        return SceneFile(path.stem, path, found.scene, found.notes)
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise InvalidInput(f"{path}: a scene file has at most {LARGEST_FILE >> 20} MiB")
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InvalidInput(f"{path}: is not UTF-8 text") from error
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"\(at line (\d+), column \d+\)", str(error))
        line = place[1] if place else str(text.count("\n") + 1)
        reason = re.sub(r" \(at .*\)$", "", str(error))
        raise InvalidInput(f"{path}:{line}: not TOML: {reason}") from error
    lines = line_map(text)
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        # An unknown key first: most often it is a misspelling of the one that is missing.
        details = sorted(error.errors(include_url=False), key=lambda detail: detail["type"] != "extra_forbidden")
        more = f" (and {len(details) - 1} more)" if len(details) > 1 else ""
        raise InvalidInput(_message(path, lines, details[0]) + more) from error
    _check_surfaces(path, lines, scene)
    scene = scene.with_meshes(_meshes(path, lines, scene))
    try:
        return SceneFile(path.stem, path, motion.stilled(scene))
    except InvalidInput as error:
        raise InvalidInput(f"{path}:{_line(lines, ('camera', 'shutter'))}: camera.shutter: {error}") from error


def _meshes(path: Path, lines: dict[Path_, int], scene: Scene) -> dict[int, LoadedMesh]:
    """The meshes of a scene by the number of their surface; their files lie in its folder or below."""
    loaded: dict[int, LoadedMesh] = {}
    for index, surface in enumerate(scene.surfaces):
        if isinstance(surface, Mesh):
            names = (surface.file, *(surface.motion.files if isinstance(surface.motion, Frames) else ()))
            read = [_mesh(path, lines, index, name, later > 0) for later, name in enumerate(names)]
            sha256, triangles = read[0]
            frames = None
            for name, (frame_sha256, frame) in zip(names[1:], read[1:], strict=True):
                if frame.shape != triangles.shape:
                    line = _line(lines, ("surfaces", index, "motion"))
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


def _mesh(path: Path, lines: dict[Path_, int], index: int, name: str, frame: bool) -> tuple[str, Array]:
    key = "motion" if frame else "file"
    try:
        return meshes.load(meshes.within(path.parent, name))
    except InvalidInput as error:
        line = _line(lines, ("surfaces", index, key))
        raise InvalidInput(f"{path}:{line}: surfaces.{key}: {error}") from error


def _check_surfaces(path: Path, lines: dict[Path_, int], scene: Scene) -> None:
    for index, surface in enumerate(scene.surfaces):
        if surface.material not in scene.materials:
            line = _line(lines, ("surfaces", index, "material"))
            missed = near_misses(surface.material, scene.materials)
            raise InvalidInput(f'{path}:{line}: surfaces.material: unknown material "{surface.material}"{missed}')
        if isinstance(surface.motion, Frames):
            line = _line(lines, ("surfaces", index, "motion"))
            if not isinstance(surface, Mesh):
                raise InvalidInput(
                    f'{path}:{line}: surfaces.motion: only a mesh has "frames"; translate or rotate this'
                )
        if isinstance(surface, Polygon):
            try:
                triangulate(surface)
            except ValueError as error:
                line = _line(lines, ("surfaces", index, "points"))
                raise InvalidInput(f"{path}:{line}: surfaces.points: {error}") from error


# --- what pydantic found, in words ------------------------------------------------------------------------------------


_BOUNDS = {
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
}


def _message(path: Path, lines: dict[Path_, int], detail: ErrorDetails) -> str:
    location = detail["loc"]
    shown = ".".join(str(part) for part in location if isinstance(part, str) and part not in _TAGS) or "scene"
    text = detail["msg"].removeprefix("Value error, ")
    if detail["type"] == "extra_forbidden":
        key = str(location[-1])
        text = f'unknown key "{key}"{near_misses(key, _fields_at(location[:-1]))}'
        shown = shown.rpartition(".")[0] or "scene"
    elif detail["type"] == "union_tag_invalid":
        tag = str(detail.get("ctx", {}).get("tag"))
        expected = re.findall(r"'([^']*)'", str(detail.get("ctx", {}).get("expected_tags")))
        text = f'unknown type "{tag}"{near_misses(tag, expected)}'
        location = (*location, "type")
    elif detail["type"] == "missing":
        text = f'the key "{location[-1]}" is missing'
    elif detail["type"] in _BOUNDS:
        words, bound = _BOUNDS[detail["type"]]
        text = f"must be {words} {detail['ctx'][bound]:g}, not {detail['input']!r}"
    elif "input" in detail and isinstance(detail["input"], str | int | float):
        text += f", not {detail['input']!r}"
    return f"{path}:{_line(lines, location)}: {shown}: {text}"


def _line(lines: dict[Path_, int], location: tuple[int | str, ...]) -> int:
    """The line of the deepest part of a location that the file has; tags of unions are not in the file."""
    found: Path_ = ()
    for part in location:
        if (*found, part) in lines:
            found = (*found, part)
    return lines.get(found, 1)


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


# --- lines of keys ----------------------------------------------------------------------------------------------------

_HEADER = re.compile(r"^\s*\[(\[)?\s*([^\[\]]+?)\s*\]\]?\s*(?:#.*)?$")
_PAIR = re.compile(r"^\s*((?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*'))*)\s*=")
_KEY_PART = re.compile(r"[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*'")
_STRINGS_AND_COMMENTS = re.compile(r"\"(?:\\.|[^\"\\])*\"|'[^']*'|#.*")


def line_map(text: str) -> dict[Path_, int]:
    """The line of every table and key of a TOML file, from 1: ("surfaces", 3, "points") -> 41.

    tomllib keeps no positions. Keys within inline tables and values of many lines have the line of the key before
    their "=".
    """
    lines: dict[Path_, int] = {}
    counts: dict[Path_, int] = {}
    table: Path_ = ()
    depth = 0
    for number, line in enumerate(text.splitlines(), 1):
        if depth == 0:
            header, pair = _HEADER.match(line), _PAIR.match(line)
            if header:
                table = _table(_parts(header[2]), bool(header[1]), counts)
                for length in range(1, len(table) + 1):
                    lines.setdefault(table[:length], number)
                continue
            if pair:
                key = table
                for part in _parts(pair[1]):
                    key = (*key, part)
                    lines.setdefault(key, number)
        bare = _STRINGS_AND_COMMENTS.sub("", line)
        depth += sum(bare.count(opening) for opening in "[{") - sum(bare.count(closing) for closing in "]}")
        depth = max(depth, 0)
    return lines


def _parts(key: str) -> list[str]:
    return [part.strip("\"'") for part in _KEY_PART.findall(key)]


def _table(parts: list[str], is_array: bool, counts: dict[Path_, int]) -> Path_:
    """The path of a table from its header: the last element of each array of tables on the way."""
    path: Path_ = ()
    for position, part in enumerate(parts):
        path = (*path, part)
        if is_array and position == len(parts) - 1:
            counts[path] = counts.get(path, -1) + 1
        if path in counts:
            path = (*path, counts[path])
    return path


def describe(file: SceneFile) -> dict[str, Any]:
    """One line of `aliascope list scenes`."""
    scene = file.scene
    return {"name": file.name, "title": scene.title, "shows": scene.shows, "needs": sorted(scene.features())}
