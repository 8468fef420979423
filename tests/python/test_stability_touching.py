"""The probes of faces in one place and of closed meshes see what is wrong: a hole, an edge beside its place."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aliascope.geometry import Array
from aliascope.model import Scene
from aliascope.renderers import find
from aliascope.stability import geometry_scenes
from aliascope.stability.probes import counts, radiance, touching
from aliascope.stability.running import all_probes, run
from aliascope.stability.subjects import BOUND


@pytest.mark.parametrize("name", ["osmesa", "povray"])
def test_a_triangle_that_is_missing_is_seen(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = geometry_scenes.rough_ball

    def pricked(side: int) -> Scene:
        """Without one of the triangles that are in view."""
        ball = whole(side)
        (mesh,) = ball.surfaces
        looking = np.array(ball.camera.look_at) - np.array(ball.camera.eye)
        ahead = (mesh.triangles.mean(axis=1) - np.array(ball.camera.eye)) @ looking  # type: ignore[union-attr]
        kept = np.delete(mesh.triangles, int(ahead.argmax()), axis=0)  # type: ignore[union-attr]
        return ball.model_copy(update={"surfaces": (mesh.model_copy(update={"triangles": kept}),)})

    probe = all_probes()[f"{name} | watertight"]
    assert run(probe, [1e4]).readings[0].error == 0.0
    monkeypatch.setattr(touching.scenes, "rough_ball", pricked)
    cell = run(probe, [1e4])
    assert cell.status == "breaks"
    assert cell.readings[0].error >= 1.0


def test_what_is_neither_face_or_beside_its_edge_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, (lower, upper) = touching.touching(3)
    right = np.repeat(upper[..., np.newaxis], 3, axis=2)
    hole, mixed, beside, one = (right.copy() for _ in range(4))
    hole[6, 3] = 0.0
    mixed[6, 3] = 0.5
    beside[6, 9] = touching.ABOVE  # of the face that rises, a column to the left of where it begins
    one[6, 3] = touching.BELOW  # sample by sample either face will do
    for seen, keeps in ((right, True), (one, True), (hole, False), (mixed, False), (beside, False)):

        def drawn(*asked: object, seen: Array = seen) -> Array:
            return seen

        monkeypatch.setattr(touching, "picture", drawn)
        assert (touching._off(find("embree"), 3.0) < BOUND) == keeps
    assert len(scene.surfaces) == 5
    assert int((lower != upper).sum()) == 32


def test_columns_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each from its bottom, where rows begin at the left."""
    scene, _ = counts._bars(5, upright=True)
    assert scene.view.size == (1, 5)
    assert counts._row_and_column("embree")(5.0) == 0.0
    bars = counts._bars

    def upside_down(length: int, upright: bool) -> tuple[Scene, Array]:
        scene, truth = bars(length, upright)
        return scene, truth[::-1] if upright else truth

    monkeypatch.setattr(counts, "_bars", upside_down)
    assert counts._row_and_column("embree")(5.0) > 0.1


def test_light_beside_nothing_has_nothing_beside_it(monkeypatch: pytest.MonkeyPatch) -> None:
    draw = radiance._draw

    def leaking(row: str, scene: Scene, mode: str = "") -> Array:
        found = draw(row, scene, mode)
        found[0, 3] += 1e-38
        return found

    assert radiance._alone("embree", 1e-30) < 1e-7
    monkeypatch.setattr(radiance, "_draw", leaking)
    assert radiance._alone("embree", 1e-30) == math.inf
