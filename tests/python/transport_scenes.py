"""Small scenes of mirrors, gloss and bounces."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.model import Scene
from aliascope.native.tracer import Tracer, TracerCost

Pixels = NDArray[np.float64]
ACROSS = {"type": "orthographic", "eye": (0.0, 0.0, 9.0), "look_at": (0.0, 0.0, 0.0), "height": 2.0}


def grey(share: float) -> tuple[float, float, float]:
    return (share, share, share)


def scene_of(
    surfaces: list[dict[str, Any]],
    materials: dict[str, Any],
    camera: dict[str, Any] = ACROSS,
    background: tuple[float, float, float] = (0.0, 0.0, 0.0),
    **more: Any,
) -> Scene:
    """`diffuse_bounces`, `mirror_bounces`: of the transport; other keys are the scene's."""
    transport = {key: more.pop(key) for key in ("diffuse_bounces", "mirror_bounces") if key in more}
    whole = {"title": "t", "shows": "s", "view": {"size": (8, 8), "background": background}, "camera": camera}
    whole |= {"materials": materials, "surfaces": surfaces, "transport": transport}
    return Scene.model_validate(whole | more)


def quad(material: str, corner: Any, first: Any, second: Any) -> dict[str, Any]:
    """A parallelogram."""
    a, u, v = (np.array(each, float) for each in (corner, first, second))
    return {"type": "polygon", "material": material, "points": [tuple(p) for p in (a, a + u, a + u + v, a + v)]}


def drawn(
    scene: Scene, size: tuple[int, int] = (8, 8), samples: int = 64, sampler: str = "sobol:scramble=owen", seed: int = 0
) -> tuple[Pixels, TracerCost]:
    pixels, cost = Tracer(scene, size).render(sampler, samples, seed)
    return pixels.astype(np.float64), cost
