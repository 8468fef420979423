"""The bounds of a scene's numbers: each is taken at its edge and refused past it."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from aliascope import model

VECTOR = (0.0, 0.0, 0.0)
EDGE = 1e30
PAST = 1.0000001e30
TAKEN: dict[str, tuple[Any, dict[str, Any]]] = {
    "view": (model.View, {"size": (4, 3)}),
    "perspective": (
        model.Camera,
        {"type": "perspective", "eye": (0.0, 0.0, 4.0), "look_at": VECTOR, "vertical_fov_degrees": 40.0},
    ),
    "orthographic": (
        model.Camera,
        {"type": "orthographic", "eye": (0.0, 0.0, 4.0), "look_at": VECTOR, "height": 2.0},
    ),
    "material": (model.Material, {}),
    "phong": (model.Phong, {"type": "phong", "exponent": 2.0}),
    "ggx": (model.Ggx, {"type": "ggx", "roughness": 0.5}),
    "rotate": (model.Rotate, {"type": "rotate", "axis": (0.0, 1.0, 0.0), "degrees": 1.0}),
    "frames": (model.Frames, {"type": "frames", "files": ("a.obj",)}),
    "polygon": (model.Polygon, {"type": "polygon", "material": "m", "points": (VECTOR,) * 3}),
    "mesh": (model.Mesh, {"type": "mesh", "material": "m", "file": "a.obj"}),
    "sphere": (model.Sphere, {"type": "sphere", "material": "m", "centre": VECTOR, "radius": 1.0}),
    "disc": (model.Disc, {"type": "disc", "material": "m", "centre": VECTOR, "radius": 1.0}),
    "plane": (model.Plane, {"type": "plane", "material": "m", "point": VECTOR, "normal": (0.0, 1.0, 0.0)}),
    "point light": (model.PointLight, {"type": "point", "position": VECTOR, "intensity": VECTOR}),
    "directional": (
        model.DirectionalLight,
        {"type": "directional", "direction": (0.0, 1.0, 0.0), "intensity": VECTOR},
    ),
    "area": (
        model.AreaLight,
        {"type": "area", "corner": VECTOR, "edges": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), "intensity": VECTOR},
    ),
    "disc light": (
        model.DiscLight,
        {"type": "disc", "centre": VECTOR, "normal": (0.0, 1.0, 0.0), "radius": 1.0, "intensity": VECTOR},
    ),
    "transport": (model.Transport, {}),
}
NAN, INFINITE = float("nan"), float("inf")
LENS = {"lens_radius": 0.1, "focus_distance": 3.0}


def colour(first: float) -> tuple[float, float, float]:
    return (first, 0.0, 0.0)


BOUNDS: list[tuple[str, dict[str, Any] | None, dict[str, Any]]] = [
    # What is just taken, or None where that is what stands above; and what is refused.
    ("view", {"size": (16384, 4096)}, {"size": (16384, 4097)}),
    ("view", {"size": (16384, 1)}, {"size": (16385, 1)}),
    ("view", {"size": (1, 1)}, {"size": (0, 1)}),
    ("view", None, {"size": (4, -3)}),
    ("view", {"background": colour(EDGE)}, {"background": colour(PAST)}),
    ("view", {"background": colour(0.0)}, {"background": colour(-1e-300)}),
    ("view", None, {"background": colour(NAN)}),
    ("view", None, {"bakground": VECTOR}),
    ("perspective", {"vertical_fov_degrees": 179.9}, {"vertical_fov_degrees": 180.0}),
    ("perspective", {"vertical_fov_degrees": 0.1}, {"vertical_fov_degrees": 0.0}),
    ("perspective", None, {"vertical_fov_degrees": None}),
    ("perspective", None, {"vertical_fov_degrees": NAN}),
    ("perspective", None, {"height": 2.0}),
    ("perspective", LENS, {"lens_radius": 0.1}),
    ("perspective", None, {"focus_distance": 3.0}),
    ("perspective", LENS | {"lens_radius": EDGE}, LENS | {"lens_radius": PAST}),
    ("perspective", LENS | {"lens_radius": 0.0}, LENS | {"lens_radius": -0.1}),
    ("perspective", None, LENS | {"lens_radius": NAN}),
    ("perspective", None, LENS | {"focus_distance": 0.0}),
    ("perspective", LENS | {"blades": 64}, LENS | {"blades": 65}),
    ("perspective", LENS | {"blades": 3}, LENS | {"blades": 2}),
    ("perspective", LENS | {"blades": 0}, LENS | {"blades": 1}),
    ("perspective", None, LENS | {"blades": -1}),
    ("perspective", {"shutter": (0.0, 1.0)}, {"shutter": (-0.1, 1.0)}),
    ("perspective", {"shutter": (1.0, 1.0)}, {"shutter": (0.0, 1.1)}),
    ("perspective", {"shutter": (0.5, 0.5)}, {"shutter": (0.6, 0.5)}),
    ("perspective", None, {"shutter": (NAN, 1.0)}),
    ("perspective", None, {"eye": VECTOR}),
    ("perspective", {"up": (0.0, 1e-3, 1.0)}, {"up": (0.0, 0.0, 1.0)}),
    ("perspective", None, {"up": VECTOR}),
    ("orthographic", {"height": EDGE}, {"height": PAST}),
    ("orthographic", None, {"height": None}),
    ("orthographic", None, {"height": 0.0}),
    ("orthographic", None, {"height": NAN}),
    ("orthographic", None, {"vertical_fov_degrees": 40.0}),
    ("orthographic", LENS | {"lens_radius": 0.0}, LENS),
    ("material", {"albedo": colour(1.0)}, {"albedo": colour(1.0000001)}),
    ("material", {"albedo": colour(0.0)}, {"albedo": colour(-0.1)}),
    ("material", None, {"albedo": colour(NAN)}),
    (
        "material",
        {"albedo": colour(0.5), "reflection": colour(0.5)},
        {"albedo": colour(0.6), "reflection": colour(0.5)},
    ),
    (
        "material",
        {"albedo": colour(0.5), "pattern": model.Checker(type="checker", scale=1.0, colours=(VECTOR, colour(2.0)))},
        {"albedo": colour(0.6), "pattern": model.Checker(type="checker", scale=1.0, colours=(VECTOR, colour(2.0)))},
    ),
    (
        "material",
        {"reflection": colour(0.5), "gloss": model.Phong(type="phong", exponent=2.0)},
        {"gloss": model.Phong(type="phong", exponent=2.0)},
    ),
    ("phong", {"exponent": 1e6}, {"exponent": 1.1e6}),
    ("phong", {"exponent": 1.0}, {"exponent": 0.9}),
    ("ggx", {"roughness": 1.0}, {"roughness": 1.1}),
    ("ggx", {"roughness": 1e-3}, {"roughness": 0.9e-3}),
    ("rotate", {"degrees": -EDGE}, {"degrees": -PAST}),
    ("rotate", {"axis": (0.0, -1e-100, 0.0)}, {"axis": (0.0, -0.9e-100, 0.0)}),
    ("frames", {"files": ("a.obj",) * 128}, {"files": ("a.obj",) * 129}),
    ("frames", {"files": ("a" * 255,)}, {"files": ("a" * 256,)}),
    ("frames", None, {"files": ()}),
    ("frames", None, {"files": ("",)}),
    ("polygon", {"points": (VECTOR,) * 20_000}, {"points": (VECTOR,) * 20_001}),
    ("polygon", None, {"points": (VECTOR,) * 2}),
    ("polygon", {"material": "m" * 1000}, {"material": "m" * 1001}),
    ("mesh", {"file": "a" * 255}, {"file": "a" * 256}),
    ("mesh", None, {"file": ""}),
    ("sphere", {"centre": colour(EDGE)}, {"centre": colour(PAST)}),
    ("sphere", {"centre": colour(-EDGE)}, {"centre": colour(-PAST)}),
    ("sphere", None, {"centre": colour(NAN)}),
    ("sphere", None, {"centre": colour(INFINITE)}),
    ("sphere", {"radius": EDGE}, {"radius": PAST}),
    ("sphere", {"radius": 1e-300}, {"radius": 0.0}),
    ("sphere", None, {"radius": NAN}),
    ("disc", None, {"normal": VECTOR}),
    ("plane", None, {"normal": VECTOR}),
    ("point light", {"intensity": colour(EDGE)}, {"intensity": colour(PAST)}),
    ("point light", None, {"intensity": colour(-0.1)}),
    ("point light", None, {"intensity": colour(NAN)}),
    ("directional", {"falloff": "none"}, {"falloff": "inverse-square"}),
    ("directional", None, {"direction": VECTOR}),
    ("area", None, {"edges": ((1.0, 0.0, 0.0), (2.0, 0.0, 0.0))}),
    ("area", None, {"edges": ((1.0, 0.0, 0.0), VECTOR)}),
    ("disc light", None, {"normal": VECTOR}),
    ("transport", {"diffuse_bounces": 64}, {"diffuse_bounces": 65}),
    ("transport", {"diffuse_bounces": 0}, {"diffuse_bounces": -1}),
    ("transport", {"mirror_bounces": 64}, {"mirror_bounces": 65}),
    ("transport", {"mirror_bounces": 1}, {"mirror_bounces": 0}),
]


@pytest.mark.parametrize(
    ("part", "taken", "refused"), BOUNDS, ids=[f"{b[0]}-{list(b[2])[-1]}-{i}" for i, b in enumerate(BOUNDS)]
)
def test_each_bound(part: str, taken: dict[str, Any] | None, refused: dict[str, Any]) -> None:
    kind, stated = TAKEN[part]
    kind.model_validate(stated | (taken or {}))
    with pytest.raises(ValidationError):
        kind.model_validate(stated | refused)


def scene(**changes: Any) -> dict[str, Any]:
    camera = {"type": "orthographic", "eye": (0.0, 0.0, 4.0), "look_at": VECTOR, "height": 2.0}
    return {"title": "", "shows": "", "view": {"size": (4, 3)}, "camera": camera, "materials": {}} | changes


@pytest.mark.parametrize(
    ("taken", "refused"),
    [
        ({"title": "t" * 1000}, {"title": "t" * 1001}),
        ({"shows": "t" * 20_000}, {"shows": "t" * 20_001}),
        ({"title": "a\tb\nc"}, {"title": "a\x1bc"}),
        ({"shows": "a\tb\nc"}, {"shows": "a\x1bc"}),
        ({"materials": {"m" * 1000: {}}}, {"materials": {"m" * 1001: {}}}),
        ({"materials": {"m\n": {}}}, {"materials": {"m\x1b": {}}}),
    ],
)
def test_each_bound_of_words(taken: dict[str, Any], refused: dict[str, Any]) -> None:
    model.Scene.model_validate(scene(**taken))
    with pytest.raises(ValidationError):
        model.Scene.model_validate(scene(**refused))


@pytest.mark.parametrize(("key", "most"), [("materials", 200_000), ("surfaces", 1_000_000), ("lights", 10_000)])
def test_each_count_is_bounded(key: str, most: int) -> None:
    """Of which so many need not be made here: the schema says it."""
    schema = model.Scene.model_json_schema()["properties"][key]
    assert schema["maxProperties" if key == "materials" else "maxItems"] == most


def test_polygons_together_take_no_longer_than_a_few_of_the_largest() -> None:
    assert model.MOST_POINTS**2 <= model.MOST_SQUARES <= 4 * model.MOST_POINTS**2
