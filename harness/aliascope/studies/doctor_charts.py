"""What `aliascope doctor` has renderers draw: charts whose pictures tell where the samples of a pixel lie, what each
weighs, and what becomes of a level.

In all of them a unit is a pixel, and the picture begins at (0, 0), its upper left corner, y down.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from aliascope.geometry import Array
from aliascope.model import Scene
from aliascope.records import Pixels

Quad = list[tuple[float, float]]

DISTANCE = 100.0
"""Of the eye from the chart, in pixels."""

BEHIND = 1.25
"""Where a chart is out of focus, over the distance in focus."""


class Chart(Protocol):
    """A picture to draw, and how to read it."""

    @property
    def size(self) -> tuple[int, int]: ...

    def scene(self) -> Scene: ...


def chart_scene(
    size: tuple[int, int], drawn: list[tuple[Quad, float]], lens_radius: float | None = None, focus: float = 1.0
) -> Scene:
    """Grey polygons (corners, level) on black. With a lens the view is a perspective one, in which the chart still has
    a pixel to a unit, and the focus lies at so much of its distance."""
    width, height = size
    camera: dict[str, Any] = {"type": "orthographic", "height": float(height)}
    if lens_radius is not None:
        camera = {
            "type": "perspective",
            "vertical_fov_degrees": math.degrees(2.0 * math.atan(0.5 * height / DISTANCE)),
            "lens_radius": lens_radius,
            "focus_distance": focus * DISTANCE,
        }
    levels = sorted({level for _, level in drawn})
    names = {level: f"m{i}" for i, level in enumerate(levels)}
    return Scene.model_validate(
        {
            "title": "chart",
            "shows": "The conventions of a renderer.",
            "view": {"size": size},
            "camera": {"eye": (0.0, 0.0, DISTANCE), "look_at": (0.0, 0.0, 0.0), **camera},
            "materials": {name: {"emission": (level,) * 3} for level, name in names.items()},
            "surfaces": [
                {
                    "type": "polygon",
                    "material": names[level],
                    "points": [(x - 0.5 * width, 0.5 * height - y, 0.0) for x, y in quad],
                }
                for quad, level in drawn
            ],
        }
    )


# --- edges ------------------------------------------------------------------------------------------------------------

EDGE_CELLS, EDGE_ROWS = 8, 64
MARGIN = 5
"""Pixels about a panel of edges that are not looked at; the edges go on for all of them but one, so that samples
outside of their row, and filters, find them too."""
PHASES = EDGE_CELLS * EDGE_ROWS
"""The phases of an edge against the pixels that a chart has, evenly spaced: all of them once, in x and in y."""


@dataclass(frozen=True)
class Edges:
    """Edges that lean by 1/PHASES: each row of pixels meets them in another phase. Above those that cross the columns,
    below those that cross the rows.

    cell: pixels from one edge to the next, a multiple of 4. lens_radius: in pixels; focus: its distance, over that of
    the chart.
    """

    cell: int = 8
    lens_radius: float | None = None
    focus: float = 1.0

    @property
    def _side(self) -> int:
        return max(EDGE_CELLS * self.cell, EDGE_ROWS) + 2 * MARGIN

    @property
    def size(self) -> tuple[int, int]:
        return self._side, 2 * self._side

    def scene(self) -> Scene:
        upright = [self._bar(i) for i in range(EDGE_CELLS)]
        lying = [[(y, x + self._side) for x, y in quad] for quad in upright]
        return chart_scene(self.size, [(quad, 1.0) for quad in (*upright, *lying)], self.lens_radius, self.focus)

    def _bar(self, i: int) -> Quad:
        """From near the cell's left border to its middle, and a phase further."""
        left = MARGIN + i * self.cell + 0.77
        ends = (1.0 - MARGIN, EDGE_ROWS + MARGIN - 1.0)
        top, bottom = (MARGIN + i * self.cell + self.cell // 2 + (i + row / EDGE_ROWS) / EDGE_CELLS for row in ends)
        first, last = (MARGIN + row for row in ends)
        return [(left, first), (top, first), (bottom, last), (left, last)]

    def spreads(self, pixels: Pixels) -> tuple[Array, Array]:
        """What a pixel makes of an edge that lies so far to the right of its left border, and so far below its upper
        one, all to the left and above being white: a value for each of `places`."""
        green = pixels[:, :, 1].astype(np.float64)
        return self._spread(green[: self._side]), self._spread(green[self._side :].T)

    def _spread(self, panel: Array) -> Array:
        within = panel[MARGIN:, MARGIN:][:EDGE_ROWS, : EDGE_CELLS * self.cell]
        cells = within.reshape(EDGE_ROWS, EDGE_CELLS, self.cell)
        # (pixels, cells, rows): the further right a pixel is in its cell, the further to the left of it is the edge.
        by_pixel = cells.transpose(2, 1, 0)[self.cell // 4 : self.cell - self.cell // 4 + 1][::-1]
        return by_pixel.reshape(-1)

    def places(self) -> Array:
        """Of the edge: from cell/4 pixels to the left of the pixel to as many to the right of it, in PHASES a pixel."""
        return (np.arange((2 * (self.cell // 4) + 1) * PHASES) + 0.5) / PHASES - self.cell // 4

    def second_moment(self, spread: Array) -> float:
        """In square pixels, about its mean, of the density whose integral a pixel shows as an edge passes it."""
        at, end = self.places(), self.cell // 4 + 1
        mean = end - float(spread.sum()) / PHASES
        return end * end - 2.0 * float((at * spread).sum()) / PHASES - mean * mean


# --- corners ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Corners:
    """Squares whose lower right corner lies in a pixel at each pair of these phases, ascending in [0, 1): between any
    two of them, and over the pixel's border, samples of one column, or row.

    A picture of these has each sample by itself: what a pixel gains as the corner passes it.
    """

    phases: tuple[float, ...]

    @property
    def size(self) -> tuple[int, int]:
        return 4 * len(self.phases), 4 * len(self.phases)

    def scene(self) -> Scene:
        quads: list[Quad] = []
        for i, y in enumerate(self.phases):
            for j, x in enumerate(self.phases):
                left, top, right, bottom = 4 * j + 0.6, 4 * i + 0.6, 4 * j + 2 + x, 4 * i + 2 + y
                quads.append([(left, top), (right, top), (right, bottom), (left, bottom)])
        return chart_scene(self.size, [(quad, 1.0) for quad in quads])

    def weights(self, pixels: Pixels) -> Array:
        """[rows][columns]: the weight of the samples between each phase and the one before it, from phases[0] - 1 + the
        first step to phases[-1] + 1; n phases give 3 n - 1 of them each way."""
        count = len(self.phases)
        green = pixels[:, :, 1].astype(np.float64).reshape(count, 4, count, 4)
        # A corner at phase p in pixel 2 lies at 1 + p in pixel 1, and at p - 1 in pixel 3: which of them, then p.
        seen = green[:, 3:0:-1, :, 3:0:-1].transpose(1, 0, 3, 2).reshape(3 * count, 3 * count)
        found: Array = np.diff(np.diff(seen, axis=0), axis=1)
        return found

    def between(self) -> Array:
        """The phases on both sides of the weights: 3 n of them."""
        phases = np.array(self.phases)
        return np.concatenate([phases - 1.0, phases, phases + 1.0])


# --- levels -----------------------------------------------------------------------------------------------------------

LEVEL_SIDE = 3
"""Pixels of a square of one level: its middle one is read."""
LEVELS_ACROSS = 16


@dataclass(frozen=True)
class Levels:
    """Squares of these levels of grey, LEVELS_ACROSS side by side."""

    levels: tuple[float, ...]

    @property
    def size(self) -> tuple[int, int]:
        return LEVEL_SIDE * LEVELS_ACROSS, LEVEL_SIDE * math.ceil(len(self.levels) / LEVELS_ACROSS)

    def _squares(self) -> Iterator[tuple[int, int, float]]:
        for i, level in enumerate(self.levels):
            yield i % LEVELS_ACROSS * LEVEL_SIDE, i // LEVELS_ACROSS * LEVEL_SIDE, level

    def scene(self) -> Scene:
        side = LEVEL_SIDE
        drawn: list[tuple[Quad, float]] = [
            ([(x, y), (x + side, y), (x + side, y + side), (x, y + side)], level) for x, y, level in self._squares()
        ]
        return chart_scene(self.size, drawn)

    def shown(self, pixels: Pixels) -> Array:
        """What became of each."""
        green = pixels[:, :, 1].astype(np.float64)
        return np.array([green[y + LEVEL_SIDE // 2, x + LEVEL_SIDE // 2] for x, y, _ in self._squares()])


# --- a star -----------------------------------------------------------------------------------------------------------

STAR_SIDE, SPOKES = 96, 24


@dataclass(frozen=True)
class Star:
    """A star of thin spokes: edges of all directions, and parts too fine for a pixel. lens_radius: in pixels."""

    lens_radius: float | None = None

    @property
    def size(self) -> tuple[int, int]:
        return STAR_SIDE, STAR_SIDE

    def scene(self) -> Scene:
        middle, reach = (0.5 * STAR_SIDE + 0.31, 0.5 * STAR_SIDE + 0.17), 0.47 * STAR_SIDE
        drawn: list[tuple[Quad, float]] = []
        for i in range(SPOKES):
            ends = [2.0 * math.pi * (i + share) / SPOKES + 0.11 for share in (0.0, 0.5)]
            rim = [(middle[0] + reach * math.cos(a), middle[1] + reach * math.sin(a)) for a in ends]
            drawn.append(([middle, *rim], 0.3 + 0.7 * (i % 3) / 2.0))
        return chart_scene(self.size, drawn, self.lens_radius, BEHIND)


# --- a staircase ------------------------------------------------------------------------------------------------------

STAIRS, STAIR_ROWS = 64, 64


@dataclass(frozen=True)
class Staircase:
    """Edges that lean by 1/1024 pixel a row, each 1/1024 further to the right than the last. Where corners lie on a
    grid, several of them come to lie at one place. All together go span pixels to the right."""

    span = STAIRS / 1024.0

    @property
    def size(self) -> tuple[int, int]:
        return 4 * STAIRS, STAIR_ROWS

    def scene(self) -> Scene:
        lean = STAIR_ROWS / 1024.0  # over the whole edge: the steps' span
        drawn: list[tuple[Quad, float]] = []
        for i in range(STAIRS):
            left, top = 4.0 * i + 0.75, 4.0 * i + 2.5 - lean + i / 1024.0
            bottom = top + lean
            drawn.append(([(left, 0.0), (top, 0.0), (bottom, STAIR_ROWS), (left, STAIR_ROWS)], 1.0))
        return chart_scene(self.size, drawn)

    def places(self, pixels: Pixels) -> Array:
        """Of each edge, in pixels to the right of where the first should be, within 1/2048, as far as 1/16."""
        lit = (pixels[:, 2::4, 1] > 0.5).sum(axis=0)
        found: Array = lit / 1024.0
        return found


# --- shadow -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Shadow:
    """A soft shadow: a floor under an area light, and a square between them."""

    @property
    def size(self) -> tuple[int, int]:
        return 64, 64

    def scene(self) -> Scene:
        def square(middle: tuple[float, float], half: float, z: float) -> list[tuple[float, float, float]]:
            return [(middle[0] + half * x, middle[1] + half * y, z) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]

        return Scene.model_validate(
            {
                "title": "chart",
                "shows": "A soft shadow.",
                "view": {"size": self.size},
                "camera": {"type": "orthographic", "eye": (0, 0, 100), "look_at": (0, 0, 0), "height": 64.0},
                "materials": {"floor": {"albedo": (0.8,) * 3}, "blocker": {"emission": (0.3,) * 3}},
                "surfaces": [
                    {"type": "polygon", "material": "floor", "points": square((0.0, 0.0), 40.0, 0.0)},
                    {"type": "polygon", "material": "blocker", "points": square((3.7, 2.3), 11.3, 20.0)},
                ],
                "lights": [
                    {
                        "type": "area",
                        "corner": (-10.0, -10.0, 60.0),
                        "edges": ((20.0, 0.0, 0.0), (0.0, 20.0, 0.0)),
                        "intensity": (0.9,) * 3,
                        "falloff": "none",
                    }
                ],
            }
        )
