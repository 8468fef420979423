"""Scenes moved and scaled: each place and length of them goes along, and what is seen stays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aliascope import scene_io
from aliascope.errors import InvalidInput
from aliascope.model import Frames, LoadedMesh, Scene
from aliascope.native.tracer import Tracer
from aliascope.placement import moved, scaled
from aliascope.stability.geometry_scenes import ball_on_a_floor, perspective

SIZE = (24, 18)


def picture(scene: Scene) -> np.ndarray:
    return Tracer(scene, SIZE).render("sobol:scramble=owen", 4, seed=1)[0]


@pytest.mark.parametrize("name", scene_io.names())
def test_by_powers_of_two_what_is_seen_stays(name: str) -> None:
    """Scaling by a power of two changes the exponents of doubles and floats alone: not a bit of the picture. Moving by
    one rounds some coordinates to 2^-42 of a unit, which a sample in a thousand may show."""
    scene = scene_io.load(name).scene
    still = picture(scene)
    np.testing.assert_array_equal(picture(scaled(scene, 2.0)), still)
    np.testing.assert_array_equal(picture(scaled(scene, 0.25)), still)
    there = picture(moved(scene, (1024.0, -512.0, 2048.0)))
    assert np.mean(np.abs(there - still) > 1e-5 * np.abs(still).max()) < 0.01


@given(power=st.integers(-90, 90), away=st.tuples(*(3 * (st.integers(-(2**40), 2**40),))))
@settings(max_examples=25, deadline=None, derandomize=True)
def test_at_any_scale_and_place_that_rounds_nothing_no_bit_changes(power: int, away: tuple[int, int, int]) -> None:
    """Corners are multiples of 2^-4, which sums up to 2^41 hold; the ball is to be seen."""
    scene, _ = ball_on_a_floor(perspective(60.0, (0.0, 3.0, 4.0), (0.0, 0.0, 0.0)))
    surfaces = (scene.surfaces[0], scene.surfaces[1].model_copy(update={"centre": (0.0, 0.0625, 0.0)}))
    still = scene.model_copy(update={"surfaces": surfaces})
    here = picture(still)
    assert np.ptp(here) > 0.5
    x, y, z = away
    np.testing.assert_array_equal(picture(moved(still, (float(x), float(y), float(z)))), here)
    np.testing.assert_array_equal(picture(scaled(still, 2.0**power)), here)


def test_back_again_it_is_the_scene() -> None:
    scene = scene_io.load("everything").scene
    assert scaled(scaled(scene, 8.0), 0.125).digest() == scene.digest()
    assert scaled(scene, 8.0).digest() != scene.digest() != moved(scene, (1.0, 0.0, 0.0)).digest()
    terrain = scene_io.load("terrain").scene
    assert moved(terrain, (0.5, 0.0, 0.0)).digest() != terrain.digest()
    meshes = [each for each in moved(terrain, (0.5, 0.0, 0.0)).surfaces if isinstance(each, LoadedMesh)]
    assert meshes
    assert not {each.sha256 for each in meshes} & {getattr(each, "sha256", "") for each in terrain.surfaces}
    assert all(
        np.array_equal(there.triangles, here.triangles + np.array([0.5, 0.0, 0.0]))
        for there, here in zip(meshes, (each for each in terrain.surfaces if isinstance(each, LoadedMesh)), strict=True)
    )


def test_frames_go_along_with_their_mesh() -> None:
    frames = np.arange(18.0).reshape(2, 1, 3, 3) ** 2
    walking = LoadedMesh(
        material="white",
        sha256="",
        triangles=frames[0],
        frames=frames,
        motion=Frames(type="frames", files=("second.ply",)),
    )
    scene = scene_io.load("edge").scene.model_copy(update={"surfaces": (walking,)})
    (there,) = scaled(moved(scene, (1.0, -2.0, 3.0)), 2.0).surfaces
    assert isinstance(there, LoadedMesh)
    assert there.frames is not None
    np.testing.assert_array_equal(there.frames, 2.0 * (frames + np.array([1.0, -2.0, 3.0])))


def test_where_sums_make_no_scene_it_is_refused() -> None:
    scene = scene_io.load("edge").scene
    with pytest.raises(InvalidInput, match="eye and look_at must differ"):
        moved(scene, (0.0, 0.0, 1e20))
    with pytest.raises(InvalidInput, match=r"less than or equal to 10{30}"):
        moved(scene, (1e31, 0.0, 0.0))
