"""What a renderer is to the rest: its modes, what it can draw, and one call that makes a picture."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from aliascope.draws import UNMOVED, checked
from aliascope.errors import InvalidInput, whole
from aliascope.model import LARGEST_SIDE, Scene, by_scene
from aliascope.native import samplers
from aliascope.placement import placed
from aliascope.records import Rendering
from aliascope.renderers import limits
from aliascope.specs import Form, Key, Spec

LEAST_SECONDS = 0.1
"""CPU time of a timed run: a short picture is rendered until it has lasted this long; the mean is the cost of one."""

DIMENSIONS = Key(
    "dimensions",
    "choice",
    "joint",
    "how pixel, time, lens and lights go together: joint, one pattern in all their dimensions; padded, one each, "
    "shuffled against each other; decorrelated, one each, near in the pixel and far in the others",
    choices=samplers.ARRANGEMENTS,
)
"""Of modes that take what a sample needs from one sampler; `aliascope render --dimensions` sets it."""

RECENTRE = Key(
    "recentre",
    "integer",
    1,
    "1: a scene that is far from the origin is moved there, and one that is tiny or huge is scaled by a power of two, "
    "before it is handed over; 0: its coordinates go over as they are (OSMesa: as float)",
    0,
    1,
)
"""Of renderers whose arithmetic ends sooner than that of the scene's doubles."""

AS_THEY_ARE = {RECENTRE.name: "0", "relative": "off"}
"""Keys of modes, and with what value coordinates go over as they are."""


def as_drawn(scene: Scene, mode: Spec) -> Scene:
    """The scene in the place and at the size in which a mode with the key `recentre` draws it."""
    return _placed(scene) if mode.integer(RECENTRE.name) else scene


_placed = by_scene(placed)


@dataclass(frozen=True)
class Request:
    """One picture: a scene whose features the renderer draws, its size, a parsed mode, and the seed.

    `least_seconds`: render again and again until the CPU time adds up to this, for a steady figure (0: once).
    `time_limit`: seconds on the wall after which the renderer gives up with JobFailed.
    `shift`: pixels to the right and down by which all that is seen is moved on the film: pixel (x, y) covers
    [x - right, x + 1 - right) x [y - down, y + 1 - down) of the picture without it. The eye stays where it is, and so
    does what is in focus; samples stay where they are in their pixels. Raises InvalidInput beyond
    `draws.LARGEST_SHIFT`, and for a size, seed, number of threads or time that there is not.
    """

    scene: Scene
    width: int
    height: int
    mode: Spec
    seed: int = 0
    threads: int = 1
    least_seconds: float = 0.0
    time_limit: float = 600.0
    shift: tuple[float, float] = UNMOVED

    def __post_init__(self) -> None:
        checked(self.shift)
        if not (1 <= self.width <= LARGEST_SIDE and 1 <= self.height <= LARGEST_SIDE):
            raise InvalidInput(f"a picture has 1 to {LARGEST_SIDE} pixels a side, not {self.width} x {self.height}")
        whole(self.seed, "a seed", 0, 2**64 - 1)
        whole(self.threads, "a number of threads", 0, 2**32 - 1)
        if not 0.0 <= self.least_seconds < math.inf:
            raise InvalidInput(f"the least time of rendering is 0 s or more, not {self.least_seconds:g} s")
        if not self.time_limit > 0.0:
            raise InvalidInput(f"a time limit is more than 0 s, not {self.time_limit:g} s")


class Renderer(Protocol):
    """A renderer. `title` is what people call it; `draws` are the features of scenes that it can draw.

    `native` names its own libraries libaliascope-NAME.so, and the modules of `aliascope.native` that wrap them. With
    these, its files are `renderers/NAME*.py`: pictures are made again when one of them changes. One that is none of
    ours says in `versions` what its pictures depend on, and may have `profiles`, its modes by the profile's name.
    `probe_mode` is a mode that resolves a hundredth of a pixel, its pattern centred in the pixel; `single_mode` has one
    sample, at the pixel's centre. Neither is random. They draw polygons seen orthographically at least: `doctor` looks
    at those.
    `shifts`: whether it moves the film, as `Request.shift` asks for; else a mode without a seed has one draw.
    `absent`: of features that it does not draw though one might expect them of it, why, in words that stand alone.
    """

    name: str
    title: str
    modes: Mapping[str, Form]
    draws: frozenset[str]
    native: tuple[str, ...]
    probe_mode: str
    single_mode: str
    shifts: bool
    absent: Mapping[str, str]

    def versions(self) -> Mapping[str, str]:
        """The versions that a picture depends on. Raises NotAvailable where the renderer is not there."""
        ...

    def unable(self, scene: Scene, mode: Spec) -> str | None:
        """Why this mode cannot draw this scene beyond the features it lacks, or None."""
        ...

    def seeded(self, mode: Spec) -> bool:
        """Whether the picture depends on the seed."""
        ...

    def render(self, request: Request) -> Rendering:
        """Makes the picture. Raises JobFailed, NotAvailable, Unsupported."""
        ...


def filter_of(mode: Spec) -> str:
    """The canonical spec of the filter that a mode reconstructs with, so of the reference that judges it: its key
    `filter`, or the box where it has none."""
    return mode.word("filter") if "filter" in mode.values else "box"


def lacks(renderer: Renderer, scene: Scene, mode: Spec) -> str | None:
    """The reason for an empty cell: the features of the scene that the renderer does not draw, the mode's own, or a
    measured limit past which its pictures are not right."""
    as_they_are = any(key in mode.values and mode.word(key) == off for key, off in AS_THEY_ARE.items())
    return unable(renderer, scene, mode) or limits.beyond(renderer.name, scene, as_they_are)


_features = by_scene(Scene.features)


def unable(renderer: Renderer, scene: Scene, mode: Spec) -> str | None:
    """Why the renderer would not draw the scene at all: what it draws past its measured limits, it draws wrong."""
    missing = sorted(_features(scene) - renderer.draws)
    if missing:
        why = [f" ({renderer.absent[name]})" if name in renderer.absent else "" for name in missing]
        return f"{renderer.title} here does not draw: {', '.join(map(str.__add__, missing, why))}"
    return renderer.unable(scene, mode)
