"""Writes the scenes and the mesh that have too many numbers to write by hand.

Run: .venv/bin/python scenes/make_scenes.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import trimesh

HERE = Path(__file__).parent
COMMAND = "# Generated: .venv/bin/python scenes/make_scenes.py\n"
PIXEL = 2.0 / 96

FLAT = """
[view]
size = [128, 96]
background = [{background}]

[camera]
type = "orthographic"
eye = [0.0, 0.0, 4.0]
look_at = [0.0, 0.0, 0.0]
height = 2.0
"""


def polygon(material: str, points: list[tuple[float, float]], z: float = 0.0) -> str:
    corners = ", ".join(f"[{x:.9g}, {y:.9g}, {z:.9g}]" for x, y in points)
    return f'\n[[surfaces]]\ntype = "polygon"\nmaterial = "{material}"\npoints = [{corners}]\n'


def siemens_star() -> str:
    """36 spokes, off the middle; toward the centre they are narrower than a pixel, and their turn is irrational."""
    spokes, centre, radius, turn = 36, (-0.2113, 0.0877), 0.8719, 0.0371
    text = (
        COMMAND
        + 'title = "Siemens star"\nshows = "Spokes that narrow toward the centre at every angle: where they blur into '
        + 'grey is the limit of the pixels, and rings or moire there are alias."\n'
        + FLAT.format(background="0.0417, 0.0533, 0.0719")
        + "\n[materials.spoke]\nemission = [0.9273, 0.8941, 0.8117]\n"
    )
    for k in range(spokes):
        ends = [2 * math.pi * (k + part) / spokes + turn for part in (0.0, 0.5)]
        rim = [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in ends]
        text += polygon("spoke", [centre, *rim])
    return text


def comb() -> str:
    """22 slivers, nearly horizontal, from nine tenths of a pixel thick down to one sixteenth; each leans
    differently, and the lower ones lie in front where they cross."""
    text = (
        COMMAND
        + 'title = "Comb"\nshows = "Slivers thinner than a pixel and nearly horizontal: a renderer that samples too '
        + 'little breaks them into dashes, or loses them."\n'
        + FLAT.format(background="0.0291, 0.0317, 0.0373")
        + "\n[materials.tooth]\nemission = [0.8919, 0.9347, 0.7813]\n"
        + "\n[materials.rust]\nemission = [0.9571, 0.4129, 0.1931]\n"
    )
    for k in range(22):
        thickness = PIXEL * 0.9 * (1 / 14.4) ** (k / 21)
        slope = (0.0137 + 0.00291 * k) * (-1) ** k
        y = 0.9231 - 0.0843 * k + 0.0017 * math.sin(7.3 * k)
        left, right = -1.1873 + 0.0129 * k, 1.2317 - 0.0093 * k
        material = "rust" if k % 5 == 2 else "tooth"
        middle = 0.5 * (left + right)
        low = [(x, y + slope * (x - middle)) for x in (left, right)]
        high = [(x, y + slope * (x - middle) + thickness) for x in (right, left)]
        text += polygon(material, low + high, 0.0131 * k)
    return text


def terrain_mesh() -> trimesh.Trimesh:
    """A height field of 224 x 224 cells: hills, and ridges down to the size of a cell."""
    cells = 224
    x, z = np.meshgrid(np.linspace(-3.0, 3.0, cells + 1), np.linspace(-4.0, 2.0, cells + 1), indexing="xy")
    y = (
        0.31 * np.sin(1.7 * x + 0.4) * np.cos(1.3 * z - 0.7)
        + 0.13 * np.sin(4.1 * x - 2.3 * z + 1.1)
        + 0.043 * np.sin(11.3 * z + 3.7 * x) * np.sin(9.7 * x)
        + 0.011 * np.sin(37.1 * x + 5.3 * z) * np.cos(31.7 * z)
    )
    corner = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    faces = np.concatenate([np.stack([a, d, c], -1).reshape(-1, 3), np.stack([a, c, b], -1).reshape(-1, 3)])
    vertices = np.stack([x, y, z], -1).reshape(-1, 3).astype(np.float32)
    return trimesh.Trimesh(vertices, faces, process=False)


def main() -> None:
    (HERE / "siemens-star.toml").write_text(siemens_star())
    (HERE / "comb.toml").write_text(comb())
    terrain_mesh().export(HERE / "terrain.ply", encoding="binary", vertex_normal=False)


if __name__ == "__main__":
    main()
