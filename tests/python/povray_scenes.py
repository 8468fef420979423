"""Scenes for the tests of the POV-Ray renderer, and shorthand to render them."""

from __future__ import annotations

import shutil
from typing import Any

import pytest

from aliascope.model import Scene
from aliascope.records import Rendering
from aliascope.renderers.base import Request
from aliascope.renderers.povray import RENDERER
from aliascope.specs import Spec, parse

needs_povray = pytest.mark.skipif(shutil.which("povray") is None, reason="POV-Ray is not installed")


def mode(text: str) -> Spec:
    return parse(text, RENDERER.modes, "mode of povray")


def scene_of(
    surfaces: list[dict[str, Any]],
    materials: dict[str, dict[str, Any]],
    camera: dict[str, Any] | None = None,
    size: tuple[int, int] = (16, 12),
    background: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Scene:
    """A scene; without a camera, one unit is one pixel, and the origin is the middle of the picture."""
    return Scene.model_validate(
        {
            "title": "test",
            "shows": "test",
            "view": {"size": size, "background": background},
            "camera": camera
            or {"type": "orthographic", "eye": (0, 0, 9), "look_at": (0, 0, 0), "height": float(size[1])},
            "materials": materials,
            "surfaces": surfaces,
        }
    )


def render(scene: Scene, text: str, **options: Any) -> Rendering:
    return RENDERER.render(Request(scene, *scene.view.size, mode(text), **options))


PLAIN = scene_of(
    [{"type": "disc", "material": "white", "centre": (0, 0, 0), "radius": 2.0}],
    {"white": {"emission": (1, 1, 1)}},
    size=(8, 8),
    background=(0.25, 0.25, 0.25),
)
