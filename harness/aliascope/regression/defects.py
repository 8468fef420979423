"""Defects that are put in on purpose: what a regression run has to catch, each of the size that it is held to.

A defect changes the picture after it was rendered, or the request before, so that the renderer itself draws what is
wrong. `aliascope regress` puts CONTROLS into each run, `make power` all DEFECTS into every scene.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from aliascope.model import Scene
from aliascope.records import Pixels
from aliascope.regression.records import Draw
from aliascope.specs import Spec, parse, split

GAIN = 0.01
OFFSET = 1.0 / 255.0
SHIFT = 1.0 / 32.0
"""Of a pixel."""
WIDER = 0.1
"""Of a pixel, and of a lens or a light where renderers are compared."""
GAMMA = 2.2
FIREFLY = 10.0
"""Times the largest value of the picture."""

REPEATS: Mapping[str, str] = {
    "random": "random",
    "regular": "regular",
    "jittered": "jittered",
    "halton": "halton",
    "sobol": "sobol",
    "sobol:scramble=owen": "owen",
}
"""By canonical spec, the patterns that csrc/plugins/repeats.c makes a defective copy of."""

FIRST = Draw()
"""The draw of the replicate that a defect of one picture alone is in."""


class Requested(Protocol):
    """What a defect changes of a `Request`."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def mode(self) -> Spec: ...
    @property
    def seed(self) -> int: ...
    @property
    def shift(self) -> tuple[float, float]: ...


Asked = TypeVar("Asked", bound=Requested)
Applies = Callable[[Scene, str, Spec], bool]
"""Whether a mode of the renderer of this name can have it on a scene."""
Picture = Callable[[Pixels, Draw], Pixels]


@dataclass(frozen=True)
class Defect:
    """One defect: exactly one of `picture` and `request` is there, or neither where the defect has to be drawn another
    way (`studies/power_drawn.py`). `text` says what it is, with its size; `absent` why a mode that it does not apply to
    cannot have it."""

    name: str
    applies: Applies
    picture: Picture | None = None
    request: Callable[[Any], Any] | None = None
    text: str = ""
    absent: str = ""


def _always(scene: Scene, renderer: str, mode: Spec) -> bool:
    return True


# --- of the picture ---------------------------------------------------------------------------------------------------


def _gained(pixels: Pixels, draw: Draw) -> Pixels:
    return pixels * np.float32(1.0 + GAIN)


def _offset(pixels: Pixels, draw: Draw) -> Pixels:
    return pixels + np.float32(OFFSET)


def _encoded(pixels: Pixels, draw: Draw) -> Pixels:
    """Of a filter with negative lobes a value can be below 0."""
    found: Pixels = np.copysign(np.abs(pixels) ** np.float32(1.0 / GAMMA), pixels)
    return found


def _upside_down(pixels: Pixels, draw: Draw) -> Pixels:
    return np.ascontiguousarray(pixels[::-1])


def _transposed(pixels: Pixels, draw: Draw) -> Pixels:
    return np.ascontiguousarray(pixels.transpose(1, 0, 2))


def _square_transposed(pixels: Pixels, draw: Draw) -> Pixels:
    height, width, _ = pixels.shape
    side = min(height, width)
    top, left = (height - side) // 2, (width - side) // 2
    found = pixels.copy()
    found[top : top + side, left : left + side] = pixels[top : top + side, left : left + side].transpose(1, 0, 2)
    return found


def _at_one_pixel(value: Callable[[Pixels], float], place: tuple[float, float]) -> Picture:
    """All channels of one pixel of the first replicate; `place`: (right, down) as shares of the picture."""

    def changed(pixels: Pixels, draw: Draw) -> Pixels:
        if draw != FIRST:
            return pixels
        height, width, _ = pixels.shape
        found = pixels.copy()
        found[min(int(place[1] * height), height - 1), min(int(place[0] * width), width - 1)] = value(pixels)
        return found

    return changed


PLACE = (1.0 / 3.0, 1.0 / 3.0)


def not_a_number(place: tuple[float, float] = PLACE) -> Defect:
    """One pixel of the first replicate is NaN."""
    picture = _at_one_pixel(lambda _: np.nan, place)
    return Defect("one NaN", _always, picture, text="one pixel of one replicate is no number")


def firefly(largest: float | None = None, place: tuple[float, float] = PLACE) -> Defect:
    """One pixel of the first replicate is FIREFLY times as bright as `largest`, the picture's own largest value where
    none is given."""
    picture = _at_one_pixel(lambda pixels: FIREFLY * float(pixels.max() if largest is None else largest), place)
    text = f"one pixel of one replicate is {FIREFLY:g} times as bright as the brightest"
    return Defect("firefly", _always, picture, text=text)


# --- of the request ---------------------------------------------------------------------------------------------------


def _moved(right: float, down: float) -> Callable[[Asked], Asked]:
    def changed(request: Asked) -> Asked:
        return replace(request, shift=(request.shift[0] + right, request.shift[1] + down))

    return changed


def _undrawn(request: Asked) -> Asked:
    """Neither the seed nor the shift is heeded."""
    return replace(request, seed=0, shift=(0.0, 0.0))


def with_keys(mode: Spec, **keys: str) -> Spec:
    """A mode with keys set anew, inner specs whole; "filter" is the spec of a filter, and so on."""
    name, pairs = split(mode.text)
    for key, spec in keys.items():
        pairs = {each: value for each, value in pairs.items() if each.partition(".")[0] != key}
        base, under = split(spec)
        pairs |= {key: base, **{f"{key}.{each}": value for each, value in under.items()}}
    text = ",".join(f"{key}={value}" for key, value in pairs.items())
    return parse(f"{name}:{text}", {mode.form.name: mode.form}, "mode")


def _repeating(request: Asked) -> Asked:
    of = REPEATS[request.mode.word("sampler")]
    return replace(request, mode=with_keys(request.mode, sampler=f"repeats:of={of}"))


def _repeatable(scene: Scene, renderer: str, mode: Spec) -> bool:
    return "sampler" in mode.values and mode.word("sampler") in REPEATS


def _filtered(scene: Scene, renderer: str, mode: Spec) -> bool:
    """Adaptive modes have the key, and one filter alone."""
    return "filter" in mode.values and mode.word("filter") == "box" and mode.name != "adaptive"


def _averaged(scene: Scene, renderer: str, mode: Spec) -> bool:
    """Those that average samples or frames which were drawn one by one, outside of the renderer."""
    return mode.name == "accumulate" or (renderer == "povray" and mode.name == "regular")


def _widened(request: Asked) -> Asked:
    return replace(request, mode=with_keys(request.mode, filter=f"box:radius={0.5 * (1.0 + WIDER):g}"))


OWN_PIXEL = (
    "POV-Ray's own antialiasing and OSMesa's multisampling have their samples where they are, within the pixel, and "
    "the tracer's adaptive modes the box alone: no width can be set"
)

ALL: tuple[Defect, ...] = (
    Defect("gain 1 %", _always, _gained, text="all values times 1.01"),
    Defect("offset 1/255", _always, _offset, text="1/255 more in all channels"),
    Defect("gamma 2.2", _always, _encoded, text="values to the power of 1/2.2 where linear ones are due"),
    Defect("shift right", _always, request=_moved(SHIFT, 0.0), text="all is 1/32 pixel to the right"),
    Defect("shift down", _always, request=_moved(0.0, SHIFT), text="all is 1/32 pixel lower"),
    Defect(
        "wider filter",
        _filtered,
        request=_widened,
        text="the box filter is 1.1 pixels wide, by its radius",
        absent=OWN_PIXEL,
    ),
    Defect(
        "wider samples",
        _averaged,
        text="the samples of a pixel are spread over a square 1.1 pixels wide, about its centre",
        absent=OWN_PIXEL,
    ),
    Defect("rows swapped", _always, _upside_down, text="row 0 is at the bottom"),
    Defect("transposed", _always, _transposed, text="rows are columns: a picture of another shape"),
    Defect(
        "square transposed", _always, _square_transposed, text="rows are columns in the largest square in the middle"
    ),
    not_a_number(),
    firefly(),
    Defect(
        "dimension repeated",
        _repeatable,
        request=_repeating,
        text="dimension 1 of the sampler is dimension 0",
        absent="the mode takes no sampler, or one that csrc/plugins/repeats.c does not copy",
    ),
    Defect("seed ignored", _always, request=_undrawn, text="neither the seed nor the shift of a replicate is heeded"),
)
DEFECTS: Mapping[str, Defect] = {defect.name: defect for defect in ALL}

CONTROLS: tuple[Defect, ...] = tuple(DEFECTS[name] for name in ("gain 1 %", "shift right", "firefly"))
"""Those that each run is shown: one of the values, one of their places, one of a single value."""
