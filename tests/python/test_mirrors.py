"""Perfect mirrors of the tracer: what is seen in them against the scene mirrored and against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from transport_scenes import drawn, grey, scene_of

from aliascope.model import Scene
from aliascope.native.tracer import Tracer
from aliascope.renderers import embree, mode_of
from aliascope.renderers.base import Request

FLOAT = 2.0**-23
"""What a picture of numbers below 2 may be off by in float."""
SHARES = (0.8, 0.5, 0.25)
CAMERA = {"type": "perspective", "eye": (0.3, 2.0, 6.0), "look_at": (0.1, -1.5, -4.0), "vertical_fov_degrees": 22.0}


def above(flip: float) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """A board and a ball over the plane y = 0, or their images below it."""
    colours = ((0.9, 0.8, 0.1), (0.2, 0.3, 1.0))
    if flip < 0.0:
        colours = (colours[1], colours[0])  # floor(-y) is -floor(y) - 1: of the other parity
    # Half a cell off in z, so that the board lies within a layer of cells.
    pattern = {"type": "checker", "scale": 1.3, "origin": (0.13, flip * 0.21, -4.4), "colours": colours}
    board = [(-9.0, flip * 0.5, -4.0), (9.0, flip * 0.5, -4.0), (9.0, flip * 6.0, -4.0), (-9.0, flip * 6.0, -4.0)]
    surfaces = [
        {"type": "polygon", "material": "board", "points": board},
        {"type": "sphere", "material": "ball", "centre": (0.6, flip * 1.2, -1.5), "radius": 0.7},
    ]
    return surfaces, {"board": {"emission": grey(1.0), "pattern": pattern}, "ball": {"emission": (0.1, 0.7, 0.4)}}


@pytest.mark.parametrize(
    "floor",
    [
        {"type": "plane", "material": "floor", "point": (0.0, 0.0, 0.0), "normal": (0.0, 1.0, 0.0)},
        {"type": "disc", "material": "floor", "centre": (0.0, 0.0, 0.0), "normal": (0.0, -2.0, 0.0), "radius": 99.0},
        {"type": "polygon", "material": "floor", "points": [(-90.0, 0.0, -90.0), (90.0, 0.0, -90.0), (0.0, 0.0, 90.0)]},
    ],
)
def test_a_plane_mirror_shows_the_mirrored_scene_at_its_share(floor: dict[str, Any]) -> None:
    surfaces, materials = above(1.0)
    steel = {"emission": (0.05, 0.1, 0.0), "reflection": SHARES}
    sky = (0.3, 0.1, 0.7)
    seen = scene_of([*surfaces, floor], {**materials, "floor": steel}, CAMERA, sky)
    got, cost = drawn(seen, (48, 36), 1, "regular")
    image = drawn(scene_of(*above(-1.0), CAMERA, sky), (48, 36), 1, "regular")[0]
    own = drawn(scene_of(*above(1.0), CAMERA, (0.0, 0.0, 0.0)), (48, 36), 1, "regular")[0]
    below = own.max(axis=-1) == 0.0
    assert below.sum() > 1000  # the floor fills most of the picture
    assert cost.reflection_rays == below.sum()
    expected = np.where(below[..., None], np.array(steel["emission"]) + np.array(SHARES) * image, own)
    assert len(np.unique(np.round(image[below], 3), axis=0)) == 4  # both colours, the ball, and the background
    # A few of 1,728 rays pass an edge of the pattern, or of the ball, by less than 1e-6.
    assert (np.abs(got - expected).max(axis=-1) > 2.0 * FLOAT).sum() <= 3


def test_a_mirror_ball_shows_the_checker_where_the_law_of_reflection_has_it() -> None:
    """One ray a pixel, followed by hand: sphere, mirror direction, floor, parity of its cell."""
    radius, centre, size = 1.1, np.array([0.2, 0.35, -0.4]), 33
    colours = ((0.1, 0.2, 0.3), (0.9, 0.7, 0.5))
    pattern = {"type": "checker", "scale": 1.7, "origin": (0.31, -0.5, 0.17), "colours": colours}
    scene = scene_of(
        [
            {"type": "sphere", "material": "steel", "centre": tuple(centre), "radius": radius},
            {"type": "plane", "material": "floor", "point": (0.0, -1.2, 0.0), "normal": (0.0, 1.0, 0.0)},
        ],
        {"steel": {"reflection": SHARES}, "floor": {"emission": grey(1.0), "pattern": pattern}},
        background=(2.0, 1.0, 3.0),
    )
    got = drawn(scene, (size, size), 1, "regular")[0]
    checked, floor_seen = 0, 0
    for row in range(size):
        for column in range(size):
            x, y = (2.0 * (column + 0.5) / size - 1.0, 1.0 - 2.0 * (row + 0.5) / size)
            inside = radius**2 - (x - centre[0]) ** 2 - (y - centre[1]) ** 2
            if inside <= 0.0:
                continue
            point = np.array([x, y, centre[2] + np.sqrt(inside)])
            normal = (point - centre) / radius
            way = np.array([0.0, 0.0, -1.0]) + 2.0 * normal[2] * normal
            expected = np.array((2.0, 1.0, 3.0))
            if way[1] < 0.0:
                met = point + way * (-1.2 - point[1]) / way[1]
                away = 1.7 * (met - np.array(pattern["origin"]))
                away[1] = -0.7 * 1.7  # exactly on the plane
                if np.abs(away - np.round(away))[[0, 2]].min() < 1e-3:
                    continue  # too near an edge of the pattern to say
                expected = np.array(colours[int(np.floor(away).sum()) % 2])
                floor_seen += 1
            assert np.abs(got[row, column] - np.array(SHARES) * expected).max() < 2.0 * FLOAT
            checked += 1
    assert checked > 600
    assert floor_seen > 200


def facing(**mirror: Any) -> Scene:
    planes = [
        {"type": "plane", "material": "both", "point": (0.0, 0.0, z), "normal": (0.0, 0.0, 1.0)} for z in (-2, 11)
    ]
    planes = [each | {"point": tuple(map(float, each["point"]))} for each in planes]
    return scene_of(planes, {"both": {"emission": grey(0.1), "reflection": grey(0.5)}}, **mirror)


@pytest.mark.parametrize("bounces", [1, 2, 5, 64])
def test_mirrors_that_face_each_other_end_after_the_bounces(bounces: int) -> None:
    """Each sends out 0.1 and half of what it gets: 0.1 (1 + 1/2 + ... + 1/2^bounces)."""
    scene = facing(mirror_bounces=bounces)
    got, cost = drawn(scene, (5, 3), 3)
    np.testing.assert_allclose(got, 0.1 * (2.0 - 0.5**bounces), rtol=FLOAT, atol=0.0)
    assert (cost.primary_rays, cost.reflection_rays, cost.shadow_rays) == (45, 45 * bounces, 0)


def test_the_chain_ends_where_there_are_diffuse_bounces_too() -> None:
    """A path may have three bounces more here, and no mirror has them."""
    scene = facing(mirror_bounces=2)
    paper = {"type": "disc", "material": "paper", "centre": (50.0, 0.0, 0.0), "normal": (1.0, 0.0, 0.0), "radius": 0.1}
    more = scene.model_dump() | {"transport": {"mirror_bounces": 2, "diffuse_bounces": 3}}
    more |= {"materials": {**more["materials"], "paper": {"albedo": grey(0.5)}}, "surfaces": [*more["surfaces"], paper]}
    got, cost = drawn(Scene.model_validate(more), (5, 3), 3)
    np.testing.assert_allclose(got, 0.1 * (2.0 - 0.5**2), rtol=FLOAT, atol=0.0)
    assert (cost.reflection_rays, cost.bounce_rays) == (90, 0)


def test_lights_light_what_is_mirrored_and_are_not_seen() -> None:
    """A lamp between eye and mirror, and a wall behind the eye that it lights: the mirror shows the wall alone."""
    wall = {"type": "plane", "material": "wall", "point": (0.0, 0.0, 20.0), "normal": (0.0, 0.0, 1.0)}
    mirror = {"type": "plane", "material": "mirror", "point": (0.0, 0.0, -2.0), "normal": (0.0, 0.0, 1.0)}
    lights = [
        {"type": "point", "position": (0.0, 0.0, 3.0), "intensity": grey(1.0)},
        {"type": "sphere", "centre": (0.0, 0.0, 4.0), "radius": 0.9, "intensity": grey(1.0)},
    ]
    materials = {"wall": {"albedo": (0.5, 0.25, 0.125)}, "mirror": {"reflection": (0.4, 1.0, 0.8)}}
    for light in lights:
        got = drawn(scene_of([wall, mirror], materials, lights=[light]), (4, 4))[0]
        # Seen at right angles, the wall in the mirror is lit as if the eye looked at it.
        behind = {"type": "orthographic", "eye": (0.0, 0.0, 9.0), "look_at": (0.0, 0.0, 20.0), "height": 2.0}
        own = drawn(scene_of([wall], materials, behind, lights=[light]), (4, 4))[0][:, ::-1]
        assert own.min() > 0.05
        assert (
            np.abs(got - np.array((0.4, 1.0, 0.8)) * own).max() < 2e-4
        )  # other lens-free samples: 64 of a smooth light


def test_a_mirror_has_no_dimension_and_an_unused_one_no_ray() -> None:
    scene = facing()
    assert Tracer(scene, (8, 8)).dimensions == scene.needs().dimensions == 2
    paper = {"type": "plane", "material": "paper", "point": (0.0, 0.0, 0.0), "normal": (0.1, 0.0, 1.0)}
    materials = {"paper": {"emission": (0.2, 0.3, 0.4)}, "steel": {"reflection": grey(1.0)}}
    pictures = [
        drawn(scene_of([paper], {name: materials[name] for name in names}))[0] for names in (materials, ["paper"])
    ]
    assert np.array_equal(*pictures)
    mode = mode_of(embree.RENDERER, "uniform:n=4")
    seen = embree.RENDERER.render(Request(scene_of([paper], materials), 8, 8, mode)).cost.rays
    assert dict(seen) == {"primary": 256}
    mirrored = embree.RENDERER.render(Request(scene, 8, 8, mode)).cost.rays
    assert dict(mirrored) == {"primary": 256, "reflection": 8 * 256}


def test_threads_change_no_bit_and_adaptive_modes_mirror() -> None:
    surfaces, materials = above(1.0)
    ball = {"type": "sphere", "material": "floor", "centre": (-0.8, 0.9, -0.5), "radius": 0.8}
    floor = {"type": "plane", "material": "floor", "point": (0.0, 0.0, 0.0), "normal": (0.0, 1.0, 0.0)}
    scene = scene_of([*surfaces, floor, ball], {**materials, "floor": {"reflection": SHARES}}, CAMERA)
    built = Tracer(scene, (37, 27))
    one, three = (built.render("sobol:scramble=owen", 21, 4, threads) for threads in (1, 3))
    assert np.array_equal(one[0], three[0])
    assert one[1].reflection_rays == three[1].reflection_rays > one[1].primary_rays
    adaptive = built.render_adaptive("fixed", "sobol:scramble=owen", 21, 4)
    assert np.allclose(adaptive[0], one[0], atol=1e-6)  # the same samples in other packets
