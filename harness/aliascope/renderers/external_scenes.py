"""The forms in which a scene is given to another program: a placeholder of its command each, a file in its folder."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aliascope.errors import NotWritable
from aliascope.gltf import writing
from aliascope.model import LoadedMesh, Scene
from aliascope.placement import placed
from aliascope.renderers import limits
from aliascope.renderers.base import Request
from aliascope.renderers.povray_frames import Frames, moved
from aliascope.renderers.povray_limits import out_of_reach
from aliascope.renderers.povray_sdl import scene_text


@dataclass(frozen=True)
class Format:
    """A file of a scene. `draws`: the features that it can say; `unable`: why it cannot say a scene all the same;
    `write`: to this path, for a request; `shifts`: it says too where the film lies."""

    draws: frozenset[str]
    unable: Callable[[Scene], str | None]
    write: Callable[[Path, Request], None]
    shifts: bool = False


def _write_glb(path: Path, request: Request) -> None:
    writing.write(path, request.scene, (request.width, request.height))


def _write_pov(path: Path, request: Request) -> None:
    frames = moved(Frames(np.zeros((1, 2)), np.ones(1)), request.shift)
    _write(path, scene_text(placed(request.scene), (request.width, request.height), frames=frames))


def _out_of_povrays_reach(scene: Scene) -> str | None:
    return out_of_reach(placed(scene)) or limits.beyond("povray", scene, as_they_are=False)


def _write_toml(path: Path, request: Request) -> None:
    """The scene at the size of the picture, its meshes beside it."""
    contents = request.scene.model_dump(mode="json", exclude_defaults=True, serialize_as_any=True, exclude_none=True)
    contents["view"] = {**contents["view"], "size": [request.width, request.height]}
    for number, surface in enumerate(request.scene.surfaces):
        if isinstance(surface, LoadedMesh):
            name = f"mesh-{number}.obj"
            _write(path.with_name(name), "".join(_obj_lines(surface)))
            kept = {
                key: contents["surfaces"][number][key]
                for key in ("material", "motion")
                if surface.motion or key != "motion"
            }
            contents["surfaces"][number] = {**kept, "type": "mesh", "file": name}
    for key in ("surfaces", "lights"):  # `type` has a default where a mesh was loaded, else none
        for entry, part in zip(contents.get(key, []), getattr(request.scene, key), strict=True):
            entry["type"] = part.type
    _write(path, "".join(f"{key} = {_toml(value)}\n" for key, value in contents.items()))


def _obj_lines(mesh: LoadedMesh) -> Iterable[str]:
    for x, y, z in mesh.triangles.reshape(-1, 3).tolist():
        yield f"v {x!r} {y!r} {z!r}\n"
    for number in range(1, 3 * len(mesh.triangles), 3):
        yield f"f {number} {number + 1} {number + 2}\n"


def _toml(value: Any) -> str:
    """A value of JSON in one line of TOML, tables as inline tables."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_toml(key)} = {_toml(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float):
        assert math.isfinite(value)  # the model holds this
        return repr(value)
    # As they are: of characters past 16 bits JSON's escapes are two, which TOML does not have.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise NotWritable(f"{path}: cannot be written: {error.strerror}") from error


_SHAPES = frozenset({"orthographic", "perspective", "polygon", "mesh", "disc", "sphere", "plane"})
_STILL = _SHAPES | {"zone-plate", "checker", "point light", "directional light", "mirror"}
_ALL = _STILL | {"area light", "disc light", "sphere light", "lens", "motion", "gloss", "diffuse bounces"}

FORMATS: Mapping[str, Format] = {
    "scene.glb": Format(writing.FORMS, writing.no_form, _write_glb),
    "scene.pov": Format(_STILL, _out_of_povrays_reach, _write_pov, shifts=True),
    "scene.toml": Format(_ALL, lambda _: None, _write_toml),
}
"""By placeholder, which is the file's name too."""
