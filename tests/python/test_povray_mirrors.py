"""The POV-Ray renderer's mirrors: what is seen in them against the scene mirrored."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from povray_scenes import mode, render, render_all, scene_of

from aliascope.model import Scene
from aliascope.renderers.base import lacks
from aliascope.renderers.povray import RENDERER
from aliascope.renderers.povray_light import lighting_of

STEP = 1.0 / 65535.0
SHARES = (0.8, 0.5, 0.25)


def checkered(flip: float, **mirror: Any) -> dict[str, Any]:
    """A board above the plane y = 0 and a ball, or their images below it."""
    colours = ((0.9, 0.8, 0.1), (0.2, 0.3, 1.0))
    if flip < 0.0:
        colours = (colours[1], colours[0])  # floor(-y) is -floor(y) - 1: of the other parity
    origin = (0.13, flip * 0.21, -4.0)
    board = [(-9, flip * 0.5, -4), (9, flip * 0.5, -4), (9, flip * 6, -4), (-9, flip * 6, -4)]
    return {
        "surfaces": [
            {"type": "polygon", "material": "board", "points": board},
            {"type": "sphere", "material": "ball", "centre": (0.6, flip * 1.2, -1.5), "radius": 0.7},
        ],
        "materials": {
            "board": {
                "emission": (1, 1, 1),
                # Half a cell off in z, so that the board lies within a layer of cells.
                "pattern": {"type": "checker", "scale": 1.3, "origin": (*origin[:2], -4.4), "colours": colours},
            },
            "ball": {"emission": (0.1, 0.7, 0.4)},
            **mirror,
        },
    }


CAMERA = {"type": "perspective", "eye": (0.3, 2.0, 6.0), "look_at": (0.1, -1.5, -4.0), "vertical_fov_degrees": 22.0}


def test_a_plane_mirror_shows_the_mirrored_scene_at_its_share() -> None:
    direct = checkered(1.0, floor={"emission": (0.05, 0.1, 0.0), "reflection": SHARES})
    floor = {"type": "plane", "material": "floor", "point": (0, 0, 0), "normal": (0, 1, 0)}
    seen = scene_of([*direct["surfaces"], floor], direct["materials"], camera=CAMERA, size=(48, 36))
    mirrored = scene_of(**checkered(-1.0), camera=CAMERA, size=(48, 36))
    upright = scene_of(**checkered(1.0), camera=CAMERA, size=(48, 36))
    got, image, own = (each.pixels.astype(np.float64) for each in render_all([seen, mirrored, upright]))
    below = own.max(axis=-1) == 0.0
    assert below.sum() > 1000  # the floor fills most of the picture
    expected = np.where(below[..., None], np.array((0.05, 0.1, 0.0)) + np.array(SHARES) * image, own)
    assert len(np.unique(np.round(image[below], 3), axis=0)) == 4  # both colours, the ball, and nothing
    # Two values that are rounded to 16 bits. A few of 1,728 rays pass an edge of the pattern by less than 1e-7.
    wrong = np.abs(got - expected).max(axis=-1) > STEP + 2.0**-23
    assert wrong.sum() <= 2


@pytest.mark.parametrize("bounces", [1, 2, 5])
def test_mirrors_that_face_each_other_end_after_the_bounces(bounces: int) -> None:
    """Each plane sends out 0.1 and half of what it gets: 0.1 (1 + 1/2 + ... + 1/2^bounces)."""
    planes = [{"type": "plane", "material": "both", "point": (0, 0, z), "normal": (0, 0, 1)} for z in (-2.0, 11.0)]
    scene = scene_of(planes, {"both": {"emission": (0.1, 0.1, 0.1), "reflection": (0.5, 0.5, 0.5)}}, size=(8, 4))
    transport = scene.transport.model_copy(update={"mirror_bounces": bounces})
    rendering = render(scene.model_copy(update={"transport": transport}), "none")
    expected = 0.1 * (2.0 - 0.5**bounces)
    np.testing.assert_allclose(rendering.pixels, expected, rtol=0, atol=0.5 * STEP + 2.0**-24)
    assert dict(rendering.cost.rays) == {"camera": 32, "reflection": 32 * (bounces + 1)}
    assert rendering.cost.samples == 32


def test_what_a_mirror_adds_is_not_clipped() -> None:
    """Lamps of 0.9 that mirror each other: 0.9 (2 - 2^-8) is brighter than 1."""
    planes = [{"type": "plane", "material": "both", "point": (0, 0, z), "normal": (0, 0, 1)} for z in (-2.0, 11.0)]
    scene = scene_of(planes, {"both": {"emission": (0.9, 0.1, 0.1), "reflection": (0.5, 0, 0)}}, size=(4, 4))
    assert lighting_of(scene).peak == pytest.approx(0.9 * (2.0 - 0.5**8))
    rendering = render(scene, "none")
    assert rendering.quantum == 2.0 * STEP
    np.testing.assert_allclose(rendering.pixels[..., 0], 0.9 * (2.0 - 0.5**8), rtol=0, atol=STEP + 2.0**-23)
    np.testing.assert_allclose(rendering.pixels[..., 1], 0.1, rtol=0, atol=STEP + 2.0**-23)


def test_gloss_and_diffuse_bounces_are_empty_cells_that_say_why() -> None:
    plane = {"type": "plane", "material": "steel", "point": (0, 0, 0), "normal": (0, 0, 1)}
    steel = {"albedo": (0.1, 0.1, 0.1), "reflection": SHARES, "gloss": {"type": "phong", "exponent": 20.0}}
    scene: Scene = scene_of([plane], {"steel": steel})
    reason = lacks(RENDERER, scene, mode("none")) or ""
    assert reason.startswith("POV-Ray here does not draw: gloss (POV-Ray 3.7 mirrors sharply;")
    bounces = scene.transport.model_copy(update={"diffuse_bounces": 2})
    reason = lacks(RENDERER, scene.model_copy(update={"transport": bounces}), mode("none")) or ""
    assert "does not draw: diffuse bounces (POV-Ray's radiosity interpolates" in reason
    assert "), gloss (" in reason
    assert lacks(RENDERER, scene_of([plane], {"steel": {"reflection": SHARES}}), mode("am1")) is None
