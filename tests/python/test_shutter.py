"""The tracer's shutter: what moves, against closed forms and against the mean of still pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

from aliascope import motion
from aliascope.errors import InvalidInput, Unsupported
from aliascope.model import Scene
from aliascope.native.tracer import Tracer
from aliascope.renderers import base, embree, mode_of

SIZE = (24, 16)
SHUTTER = (0.13, 0.91)
WHITE = {"emission": (1.0, 1.0, 1.0)}


def scene_of(surfaces: list[dict[str, Any]], materials: dict[str, Any] | None = None, **more: Any) -> Scene:
    """Seen along -z, one unit a pixel, y up from the lower border."""
    camera = {
        "type": "orthographic",
        "eye": (SIZE[0] / 2, SIZE[1] / 2, 50.0),
        "look_at": (SIZE[0] / 2, SIZE[1] / 2, 0.0),
        "height": float(SIZE[1]),
        "shutter": SHUTTER,
    }
    return Scene.model_validate(
        {
            "title": "t",
            "shows": "s",
            "view": {"size": SIZE},
            "camera": camera | more.pop("camera", {}),
            "materials": materials or {"white": WHITE},
            "surfaces": surfaces,
        }
        | more
    )


def box(x0: float, y0: float, x1: float, y1: float, **more: Any) -> dict[str, Any]:
    points = [(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0)]
    return {"type": "polygon", "material": "white", "points": points} | more


RESPONSES = {"box": stats.uniform(0.0, 1.0), "triangle": stats.triang(0.5)}


@pytest.mark.parametrize("response", RESPONSES)
def test_a_translating_edge_is_the_distribution_of_the_response(response: str) -> None:
    """At x the edge has passed by the time (x - start) / speed; the mean over a pixel by Gauss's rule, piecewise."""
    start, speed = 5.17, 13.3
    moves = {"type": "translate", "by": (speed, 3.1, 0.0)}
    scene = scene_of([box(-99.0, -99.0, start, 99.0, motion=moves)], camera={"response": response})
    built = Tracer(scene, SIZE)
    assert built.dimensions == scene.needs().dimensions == 3
    drawn = np.array([built.render("sobol:scramble=owen", 256, seed)[0][:, :, 0] for seed in range(8)], np.float64)
    columns = drawn.reshape(-1, SIZE[0])
    x = np.arange(SIZE[0] * 512) / 512 + 1 / 1024  # the midpoint rule: kinks and all to 1e-5
    moment = ((x - start) / speed - SHUTTER[0]) / (SHUTTER[1] - SHUTTER[0])
    wanted = RESPONSES[response].sf(moment).reshape(SIZE[0], -1).mean(axis=1)
    assert ((wanted > 0.01) & (wanted < 0.99)).sum() >= 8
    deviation = columns.std(axis=0, ddof=1) / np.sqrt(len(columns))
    assert deviation.max() < 1e-3
    # Significance 1e-4 over all columns (Bonferroni).
    limit = stats.norm.isf(0.5e-4 / SIZE[0])
    assert (np.abs(columns.mean(axis=0) - wanted) <= limit * deviation + 1e-5).all()


def turning(degrees: float) -> Scene:
    """Of every kind of surface one that turns, in patterns, under a light, before a plane that stands still."""
    turn = {"type": "rotate", "axis": (0.1, -0.2, 1.0), "centre": (11.3, 8.7, 0.0), "degrees": degrees}
    materials = {
        "white": {
            "emission": (0.1, 0.2, 0.3),
            "albedo": (0.9, 0.7, 0.5),
            "pattern": {"type": "zone-plate", "scale": 0.021, "origin": (5.1, 6.2, 0.3)},
        },
        "tiles": {
            "emission": (0.3, 0.2, 0.1),
            "pattern": {"type": "checker", "scale": 0.41, "origin": (0.1, 0.2, 0.3)},
        },
        "grey": {"albedo": (0.5, 0.5, 0.5)},
    }
    surfaces = [
        box(12.3, 8.1, 21.7, 11.9, motion=turn),
        {"type": "disc", "material": "white", "centre": (6.1, 4.2, 1.0), "radius": 2.9, "motion": turn},
        {"type": "sphere", "material": "white", "centre": (8.3, 12.9, 2.0), "radius": 2.2, "motion": turn},
        {
            "type": "plane",
            "material": "tiles",
            "point": (0.0, 1.7, 0.0),
            "normal": (0.3, 0.8, 0.5),
            "motion": {"type": "translate", "by": (0.0, 2.2, 0.0)},
        },
        {"type": "plane", "material": "grey", "point": (0.0, 0.0, -4.0), "normal": (0.0, 0.1, 1.0)},
    ]
    lights = [{"type": "directional", "direction": (0.3, -0.4, -1.0), "intensity": (1.0, 1.0, 1.0)}]
    return scene_of(surfaces, materials, lights=lights)


# To the first Embree's straight lines are within 1e-5 of the radius, to the second within 2e-4.
@pytest.mark.parametrize("degrees", [71.0, -305.0])
def test_what_turns_is_the_mean_of_still_pictures(degrees: float) -> None:
    scene = turning(degrees)
    seen = np.mean([Tracer(scene, SIZE).render("sobol:scramble=owen", 256, seed)[0] for seed in range(4)], axis=0)
    count = 160
    times = SHUTTER[0] + (SHUTTER[1] - SHUTTER[0]) * (np.arange(count) + 0.5) / count
    stills = [
        Tracer(motion.at(scene, time), SIZE).render("sobol:scramble=owen", 8, seed)[0]
        for seed, time in enumerate(times)
    ]
    difference = seen - np.mean(stills, axis=0)
    assert seen.std() > 0.05
    assert np.sqrt(np.mean(difference**2)) < 0.006  # measured: 0.003
    assert np.abs(difference.mean(axis=(0, 1))).max() < 1e-3


@pytest.mark.parametrize("degrees", [71.0, -305.0])
def test_a_moment_is_the_still_picture(degrees: float) -> None:
    """A shutter that is open for 1e-9 of the time: what differs from the still picture is float's rounding."""
    scene = turning(degrees)
    for time in (0.0, 0.37, 0.999):
        shut = scene.camera.model_copy(update={"shutter": (time, time + 1e-9)})
        seen, _ = Tracer(scene.model_copy(update={"camera": shut}), SIZE).render("sobol:scramble=owen", 64, 3)
        still, _ = Tracer(motion.at(scene, time), SIZE).render("sobol:scramble=owen", 64, 3)
        assert np.abs(seen - still).max() <= 2.0 / 64.0
        assert np.mean(np.abs(seen - still)) < 1e-4


def test_an_instant_is_the_still_picture_to_the_bit() -> None:
    scene = turning(71.0)
    instant = scene.camera.model_copy(update={"shutter": (0.4, 0.4)})
    built = Tracer(scene.model_copy(update={"camera": instant}), SIZE)
    assert built.dimensions == 2
    still = Tracer(motion.at(scene, 0.4), SIZE).render("halton", 33)[0]
    assert np.array_equal(built.render("halton", 33)[0], still)


def test_an_open_shutter_before_still_surfaces_changes_no_bit() -> None:
    surfaces = [
        box(3.1, 2.2, 17.3, 12.9),
        {"type": "disc", "material": "white", "centre": (19.0, 9.1, 0.0), "radius": 3.3},
    ]
    first, second = Tracer(scene_of(surfaces), SIZE), Tracer(scene_of(surfaces, camera={"shutter": None}), SIZE)
    assert first.dimensions == second.dimensions == 2
    assert np.array_equal(first.render("halton", 33)[0], second.render("halton", 33)[0])


def test_shadows_move_with_what_throws_them() -> None:
    """The shadow of a plate that moves lies where the light's rays past its edges end, at each time."""
    surfaces = [
        {"type": "plane", "material": "grey", "point": (0.0, 0.0, 0.0), "normal": (0.0, 0.0, 1.0)},
        {
            "type": "polygon",
            "material": "grey",
            "points": [(-90.0, -90.0, 20.0), (-20.0, -90.0, 20.0), (-20.0, 90.0, 20.0), (-90.0, 90.0, 20.0)],
            "motion": {"type": "translate", "by": (10.0, 0.0, 0.0)},
        },
    ]
    lights = [{"type": "directional", "direction": (1.0, 0.0, -1.0), "intensity": (1.0, 1.0, 1.0)}]
    scene = scene_of(surfaces, {"grey": {"albedo": (1.0, 1.0, 1.0)}}, lights=lights)
    drawn, _ = Tracer(scene, SIZE).render("sobol:scramble=owen", 1024, 1)
    # Its edge at -20 + 10 t is thrown 20 to the right: to 10 t.
    x = (np.arange(SIZE[0] * 512) + 0.5) / 512
    lit = stats.uniform(10.0 * SHUTTER[0], 10.0 * (SHUTTER[1] - SHUTTER[0])).cdf(x).reshape(SIZE[0], -1).mean(axis=1)
    assert np.abs(drawn[:, :, 0].mean(axis=0) - lit / np.sqrt(2.0)).max() < 2e-3  # 16 rows of 1,024 samples


@pytest.mark.parametrize("filter_", ["box", "mitchell"])
def test_threads_change_no_bit(filter_: str) -> None:
    built = Tracer(turning(71.0), (37, 27))
    one, three = (built.render("sobol:scramble=owen", 21, 4, threads, filter_)[0] for threads in (1, 3))
    assert np.array_equal(one, three)


@pytest.mark.parametrize("sampler", ["cook", "pan-diagonal", "mitchell-spacetime"])
def test_patterns_of_space_and_time_draw_it(sampler: str) -> None:
    renderer, scene = embree.RENDERER, turning(71.0)
    mode = mode_of(renderer, f"uniform:n=16,sampler={sampler}")
    assert base.lacks(renderer, scene, mode) is None
    renderer.seeded(mode)
    drawn = renderer.render(base.Request(scene, *SIZE, mode)).pixels
    dense, _ = Tracer(scene, SIZE).render("sobol:scramble=owen", 256)
    assert np.sqrt(np.mean((drawn - dense) ** 2)) < 0.1
    assert base.lacks(renderer, motion.at(scene, 0.0), mode) is not None


@pytest.mark.parametrize("sampler", ["standard-msaa,n=4", "sgi-8x8,n=8"])
def test_planar_patterns_are_refused(sampler: str) -> None:
    reason = base.lacks(embree.RENDERER, turning(71.0), mode_of(embree.RENDERER, f"uniform:sampler={sampler}"))
    assert reason is not None
    assert "dimension" in reason


def test_a_checker_turns_with_its_surface() -> None:
    """A board that turns about the axis of sight, seen at a moment: as by a camera that turned the other way."""
    turn = {"type": "rotate", "axis": (0.0, 0.0, 1.0), "centre": (12.0, 8.0, 0.0), "degrees": 40.0}
    tiles = {"white": WHITE | {"pattern": {"type": "checker", "scale": 0.41, "origin": (0.1, 0.2, 0.3)}}}
    board = box(-99.0, -99.0, 99.0, 99.0, motion=turn)
    scene = scene_of([board], tiles, camera={"shutter": (0.6, 0.6 + 1e-9)})
    angle = np.radians(24.0)
    still = scene_of([board | {"motion": None}], tiles, camera={"up": (np.sin(angle), np.cos(angle), 0.0)})
    seen, wanted = (Tracer(each, SIZE).render("sobol:scramble=owen", 64, 3)[0] for each in (scene, still))
    assert wanted.std() > 0.3
    assert np.abs(seen - wanted).max() <= 2.0 / 64.0
    with pytest.raises(InvalidInput, match="a checker that has turned"):
        motion.at(scene, 0.6)


def test_too_many_turns_are_refused() -> None:
    with pytest.raises(Unsupported, match="turns by more than 360 degrees"):
        Tracer(turning(360.0 * 40.0), SIZE)
