"""Mesh files, read with trimesh: triangles in double, checked before anything is drawn with them."""

from __future__ import annotations

import hashlib
import logging
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aliascope.bounded import read_bytes, shortened
from aliascope.errors import InvalidInput
from aliascope.geometry import Array
from aliascope.model import LARGEST_COORDINATE

LARGEST_FILE = 256 << 20
MOST_TRIANGLES = 4_000_000
MOST_OF_A_SCENE = 16_000_000
"""Triangles of all meshes of a scene, those of frames too: 1.1 GiB."""
LARGEST_FILES = 1 << 30
"""Bytes of all mesh files of a scene."""
ENDINGS = (".obj", ".ply", ".stl", ".off", ".glb")


def within(folder: Path, name: str) -> Path:
    """The path of a mesh in a scene's folder or below. Raises InvalidInput for one that leads out of it."""
    path = folder / name
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError) as error:  # a NUL byte; links that lead to each other
        raise InvalidInput(f'"{shortened(name)}" is no name of a file: {error}') from error
    if Path(name).is_absolute() or not inside:
        raise InvalidInput(f'"{shortened(name)}" leads out of the scene\'s folder; put the mesh beside the scene')
    return path


@np.errstate(all="ignore")  # what is not finite is refused by name
def load(path: Path) -> tuple[str, Array]:
    """The SHA-256 of a mesh file and its triangles, (n, 3, 3) float64, in the file's own coordinates.

    Raises InvalidInput for a file that is missing, too large, of an unknown kind, broken or empty, or that has a corner
    which is not finite or a triangle without area.
    """
    if path.suffix.lower() not in ENDINGS:
        raise InvalidInput(f'"{path.name}": a mesh is one of {", ".join(ENDINGS)}')
    data = read_bytes(path, LARGEST_FILE, "mesh", f'"{path.name}"')
    triangles = _parse(data, path)
    if len(triangles) > MOST_TRIANGLES:
        raise InvalidInput(f'"{path.name}": has {len(triangles)} triangles, at most {MOST_TRIANGLES} are taken')
    _check(triangles, path.name)
    return hashlib.sha256(data).hexdigest(), triangles


def _parse(data: bytes, path: Path) -> Array:
    import trimesh  # takes half a second to load, and most scenes have no mesh

    logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # else it prints how it failed, beside our line
    try:
        mesh = trimesh.load_mesh(BytesIO(data), file_type=path.suffix[1:].lower(), process=False, skip_materials=True)
        return np.array(mesh.triangles, dtype=np.float64)
    except Exception as error:  # what a parser raises on a broken file is anything
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InvalidInput(f'"{path.name}": is broken or empty: {reason}') from error


def _check(triangles: Array, name: str) -> None:
    if len(triangles) == 0:
        raise InvalidInput(f'"{name}": has no triangles that are whole: it is empty, or ends before them')
    if triangles.shape[1:] != (3, 3):
        raise InvalidInput(f'"{name}": has corners of {triangles.shape[-1]} coordinates, not x, y and z')
    bad = ~(np.abs(triangles) <= LARGEST_COORDINATE).all(axis=(1, 2))
    if bad.any():
        number = int(np.argmax(bad))
        raise InvalidInput(f'"{name}": triangle {number} has a corner that is not finite or beyond 1e30')
    flat = without_area(triangles)
    if flat.any():
        raise InvalidInput(f'"{name}": triangle {int(np.argmax(flat))} has no area; {int(flat.sum())} such in all')


def without_area(triangles: Array) -> NDArray[np.bool_]:
    """Which of (n, 3, 3) have no area: less than 1e-12 of their longest edge squared, whatever the scale."""
    edges = triangles - np.roll(triangles, 1, axis=1)
    longest = np.abs(edges).max(axis=(1, 2))
    scaled = edges / np.where(longest > 0.0, longest, 1.0)[:, np.newaxis, np.newaxis]
    flat: NDArray[np.bool_] = np.linalg.norm(np.cross(scaled[:, 0], scaled[:, 1]), axis=1) < 1e-12
    return flat
