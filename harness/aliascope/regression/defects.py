"""Defects that are put into pictures on purpose, to see whether they are caught."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from aliascope.model import Scene
from aliascope.records import Pixels
from aliascope.regression.records import Draw
from aliascope.specs import Spec


@dataclass(frozen=True)
class Defect:
    """Changes a picture after it was rendered, or the request for it before; `applies`: whether a renderer's mode can
    have it on a scene."""

    name: str
    applies: Callable[[Scene, str, Spec], bool]
    picture: Callable[[Pixels, Draw], Pixels] | None = None
    request: Callable[[Any], Any] | None = None


def _always(scene: Scene, renderer: str, mode: Spec) -> bool:
    return True


def _gain(pixels: Pixels, draw: Draw) -> Pixels:
    return pixels * np.float32(1.01)


def _moved(request: Any) -> Any:
    return replace(request, shift=(request.shift[0] + 1 / 32, request.shift[1]))


def _firefly(pixels: Pixels, draw: Draw) -> Pixels:
    """In the first replicate alone."""
    if draw != Draw():
        return pixels
    found = pixels.copy()
    found[len(found) // 3, found.shape[1] // 3] = 10 * pixels.max()
    return found


CONTROLS = (
    Defect("gain 1 %", _always, picture=_gain),
    Defect("shift of 1/32 pixel to the right", _always, request=_moved),
    Defect("firefly", _always, picture=_firefly),
)
DEFECTS = {defect.name: defect for defect in CONTROLS}
