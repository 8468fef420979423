"""Measured limits of the renderers: past them pictures are wrong, within them right, and commands leave cells empty."""

from __future__ import annotations

import numpy as np
import pytest

from aliascope import api, jobs, scene_io
from aliascope.errors import Unsupported
from aliascope.model import Scene
from aliascope.renderers import BUILT_IN, base, limits, mode_of
from aliascope.scene_io import SceneFile
from aliascope.stability import areas, subjects
from aliascope.stability.extremes import EXTREMES
from aliascope.stability.subjects import Subject

GRIDS = {
    "povray": "regular:n=16",
    "osmesa": "accumulate:n=16,sampler=regular",
    "embree": "uniform:n=16,sampler=regular",
}
SWITCHED = {"povray": "recentre=0", "osmesa": "recentre=0", "embree": "relative=off"}

CASES = [
    ("povray", "grazing", subjects.grazing, 6e-9, 5e-9),
    ("povray", "far", subjects.far, 3e6, 1e8),
    ("povray", "shadow", subjects.shadow, 1e-1, 1e-3),
    ("osmesa", "far", subjects.far, 1e5, 1e7),
    ("osmesa", "coplanar", subjects.coplanar, 1e-6, 1e-7),
    ("embree", "far", subjects.far, 1e3, 1e7),
    ("embree", "coplanar", subjects.coplanar, 1e-5, 1e-8),
]
"""Renderer, extreme, the last level within the limit that is tried, and one past it at which the picture is wrong."""


def limit_of(renderer: str, extreme: str) -> limits.Limit:
    return next(each for each in limits.LIMITS if (each.renderer, each.extreme) == (renderer, extreme))


def mode_for(renderer: str, subject: Subject, as_they_are: bool) -> str:
    mode = GRIDS[renderer] if subject.own is not None else BUILT_IN[renderer].single_mode
    return f"{mode}{',' if ':' in mode else ':'}{SWITCHED[renderer]}" if as_they_are else mode


def test_each_limit_is_tried() -> None:
    assert [(each.renderer, each.extreme) for each in limits.LIMITS] == [case[:2] for case in CASES]
    assert all(EXTREMES[each.extreme].group == "geometry" for each in limits.LIMITS)


@pytest.mark.parametrize(("renderer", "extreme", "made", "within", "past"), CASES)
def test_past_the_limit_pictures_are_wrong_and_refused(renderer, extreme, made, within, past) -> None:
    """A tenth of the error of 16 samples tells a right picture from a wrong one, as in the map."""
    limit, found = limit_of(renderer, extreme), BUILT_IN[renderer]
    for at, right in ((within, True), (past, False)):
        subject = made(at)
        mode = mode_for(renderer, subject, limit.as_they_are)
        spec = mode_of(found, mode)
        off = subjects.rms(subjects.picture(found, mode, subject.scene) - subject.truth)
        bound = subjects.BOUND if subject.own is None else 1.1 * subject.own
        assert (off < bound) == right
        assert base.unable(found, subject.scene, spec) is None
        reason = base.lacks(found, subject.scene, spec)
        if right:
            assert reason is None
            continue
        assert reason is not None
        assert (": take " in reason) == limit.as_they_are
        file = SceneFile("extreme", "extreme.toml", subject.scene)
        with pytest.raises(Unsupported, match="extreme: "):
            api.render(file, renderer, mode)
        plan = jobs.make_plan([file], {renderer: [mode]}, 1, None)
        assert not plan.jobs
        assert [cell.reason for cell in plan.empty] == [reason]
        if limit.as_they_are:
            there = base.lacks(found, subject.scene, mode_of(found, mode_for(renderer, subject, False)))
            assert there is None


@pytest.mark.parametrize("name", scene_io.names())
def test_our_scenes_are_within_all_limits(name: str) -> None:
    scene = scene_io.load(name).scene
    for renderer in BUILT_IN:
        for as_they_are in (False, True):
            assert limits.beyond(renderer, scene, as_they_are) is None


def flat(*surfaces: dict[str, object], **camera: object) -> Scene:
    return Scene.model_validate(
        {
            "title": "flat",
            "shows": "faces",
            "view": {"size": (16, 12)},
            "camera": {"type": "orthographic", "eye": (0, 0, 4), "look_at": (0, 0, 0), "height": 2.0, **camera},
            "materials": {"m": {"emission": (1, 1, 1)}},
            "surfaces": [{"material": "m", **surface} for surface in surfaces],
        }
    )


def square(z: float, left: float = -0.5) -> dict[str, object]:
    x = left + 1.0
    return {"type": "polygon", "points": ((left, -0.5, z), (x, -0.5, z), (x, 0.5, z), (left, 0.5, z))}


@pytest.mark.parametrize(
    ("surfaces", "refused"),
    [
        ([square(0.0), square(1e-7)], True),
        ([square(0.0), square(1e-6)], False),
        ([square(0.0), square(0.0)], False),  # which is in front is for the scene to say
        ([square(0.0), square(1e-7, 0.6)], False),  # beside each other
        ([square(0.0), {"type": "disc", "centre": (0, 0, 1e-7), "radius": 0.3}], True),
    ],
)
def test_faces_that_opengl_cannot_tell_apart(surfaces: list[dict[str, object]], refused: bool) -> None:
    assert (limits.beyond("osmesa", flat(*surfaces), False) is not None) == refused
    assert limits.beyond("povray", flat(*surfaces), False) is None


def test_a_gap_in_perspective_is_of_the_depth() -> None:
    view = {"type": "perspective", "vertical_fov_degrees": 40.0, "height": None}
    assert limits.beyond("osmesa", flat(square(0.0), square(5e-7), **view), False) is not None  # of 4 units
    assert limits.beyond("osmesa", flat(square(0.0), square(5e-6), **view), False) is None


def test_what_is_seen_from_its_very_edge_is_no_matter() -> None:
    """To rounding: nothing of it is to be seen."""
    floor = {"type": "polygon", "points": ((-1, 0, -1), (1, 0, -1), (1, 1e-17, 1), (-1, 1e-17, 1))}
    for surface in (floor, {"type": "plane", "point": (0, 0, 0), "normal": (0, 1, 1e-17)}):
        assert limits.beyond("povray", flat(surface), False) is None

    vast = ((-1e14, 0, -1e14), (1e14, 0, -1e14), (1e14, 1e-2, 1e14), (-1e14, 1e-2, 1e14))
    assert limits.beyond("povray", flat({"type": "polygon", "points": vast}), False) is None


def test_faces_at_an_angle_are_told_apart_but_where_they_cross() -> None:
    leaning = {"type": "polygon", "points": ((-0.5, -0.5, 1e-7), (0.5, -0.5, 1e-7), (0.5, 0.5, 1e-3))}
    assert limits.beyond("osmesa", flat(square(0.0), leaning), False) is None


def test_only_what_light_can_show_has_shadows() -> None:
    light = {"type": "directional", "direction": (0, 0, -1), "intensity": (1, 1, 1)}
    for albedo, lights, refused in ((0.5, (light,), True), (0.5, (), False), (0.0, (light,), False)):
        said = flat({"type": "sphere", "centre": (0, 0, 0), "radius": 1e-3}, eye=(0, 0, 0.02), height=0.01)
        scene = Scene.model_validate(
            {**said.model_dump(), "materials": {"m": {"albedo": (albedo,) * 3}}, "lights": lights}
        )
        assert (limits.beyond("povray", scene, True) is not None) == refused


def test_what_rounding_moves_is_of_the_pixels_at_its_depth() -> None:
    """Coordinates of 3e4 as float are off by 0.001: of pixels that are 0.06 wide at a depth of 1."""
    view = {"type": "perspective", "vertical_fov_degrees": 40.0, "height": None}
    for depth, refused in ((0.1, True), (4.0, False)):
        scene = flat(square(4.0 - depth, 3e4), **view, eye=(3e4, 0, 4), look_at=(3e4, 0, 0))
        assert (limits.beyond("embree", scene, True) is not None) == refused


def test_a_plane_through_a_telescope_is_refused() -> None:
    """Pixels of 2e-10 radians: a whole one below the horizon is met at less than 1e-10."""
    plane = {"type": "plane", "point": (0, -1, 0), "normal": (0, 1, 0)}
    for degrees, refused in ((1e-7, True), (1.0, False)):
        view = {"type": "perspective", "vertical_fov_degrees": degrees, "height": None}
        assert (limits.beyond("povray", flat(plane, **view), False) is not None) == refused
    facing = {"type": "plane", "point": (0, 0, 0), "normal": (0, 0, 1)}
    view = {"type": "perspective", "vertical_fov_degrees": 1e-7, "height": None}
    assert limits.beyond("povray", flat(facing, **view), False) is None


def test_areas_and_samples_of_polygons() -> None:
    """A triangle that is half a square of 2 x 2 pixels, also by samples, and one that lies outside."""
    triangle = [(areas.Fraction(x), areas.Fraction(y)) for x, y in ((1, 1), (3, 1), (1, 3))]
    found = areas.coverage(triangle, (5, 4))
    expected = np.zeros((4, 5))
    expected[1, 1], expected[1, 2], expected[2, 1] = 1.0, 0.5, 0.5
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(areas.coverage(triangle[::-1], (5, 4)), expected)
    for side in (4, 64):
        # On the diagonal lie side of side^2 samples, of which all count.
        assert np.abs(areas.samples(triangle, (5, 4), side) - expected).max() == pytest.approx(0.5 / side)
    away = [(x + 9, y) for x, y in triangle]
    assert not areas.coverage(away, (5, 4)).any()
    assert not areas.samples(away, (5, 4), 4).any()
