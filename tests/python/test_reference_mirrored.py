"""References of polygons and their images in a mirror, against rays that are followed one by one."""

from __future__ import annotations

import numpy as np
import pytest
from reference_scenes import BACKGROUND, SIZE, _in_polygon, box, polygon, scene, stored

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame, frame_of
from aliascope.model import Scene
from aliascope.native import tracer
from aliascope.references import make

MATERIALS = {
    "red": {"emission": [0.9, 0.2, 0.1]},
    "green": {"emission": [0.2, 0.8, 0.3]},
    "blue": {"emission": [0.1, 0.3, 0.95]},
    "water": {"emission": [0.03, 0.05, 0.02], "reflection": [0.6, 0.7, 0.8]},
}
CAMERAS = {
    "perspective": {
        "type": "perspective",
        "eye": [0.3, 2.1, 7.0],
        "look_at": [0.1, 0.4, 0.0],
        "vertical_fov_degrees": 40.0,
    },
    "orthographic": {"type": "orthographic", "eye": [0.4, 3.2, 7.0], "look_at": [0.1, 0.2, 0.0], "height": 5.0},
}
WATER = {
    "type": "polygon",
    "material": "water",
    "points": [[-2.6, 0, -2], [2.1, 0, -1.7], [2.4, 0, 2.6], [-2.1, 0, 2.3]],
}
HOUSE = {
    "type": "polygon",
    "material": "red",
    "points": [[-2, 0, -1], [-0.3, 0, -1.2], [-0.3, 1.9, -1.2], [-2, 1.4, -1]],
}
SIGN = {"type": "polygon", "material": "green", "points": [[-0.9, 0.3, 0.1], [1.2, 0.4, -0.3], [0.7, 1.3, 0.4]]}
SIGN["points"][2][2] = 0.1
FLAG = {"type": "polygon", "material": "blue", "points": [[0.9, 0.1, 1.1], [1.8, 0.2, 1.1], [1.5, 0.9, 0.9]]}
ASIDE = {"type": "polygon", "material": "blue", "points": [[3.1, 0.1, -4.1], [4.8, 0.2, -4.1], [3.5, 1.9, -3.9]]}


def seen(of: Scene, camera: str) -> Scene:
    return of.model_copy(update={"camera": type(of.camera).model_validate(CAMERAS[camera])})


def meet(of: Scene, origin: Array, direction: Array, mirrors: bool) -> Array:
    """The radiance (n, 3) that comes along rays (n, 3), each from its origin; mirrors send them on once."""
    result = np.tile(np.array(of.view.background), (len(origin), 1))
    nearest, which = np.full(len(origin), np.inf), np.full(len(origin), -1)
    for number, surface in enumerate(of.surfaces):
        points = np.array(surface.points)
        normal = np.cross(points[1] - points[0], points[2] - points[0])
        with np.errstate(divide="ignore", invalid="ignore"):
            time = (points[0] - origin) @ normal / (direction @ normal)
        hit = (origin + time[:, np.newaxis] * direction).T
        inside = _in_polygon(list(hit), points, int(np.argmax(np.abs(normal)))) & (time > 1e-9) & (time < nearest)
        nearest[inside], which[inside] = time[inside], number
    for number, surface in enumerate(of.surfaces):
        met, material = which == number, of.materials[surface.material]
        result[met] = material.emission
        if any(material.reflection) and mirrors and met.any():
            points = np.array(surface.points)
            normal = np.cross(points[1] - points[0], points[2] - points[0])
            normal = normal / np.linalg.norm(normal)
            place = origin[met] + nearest[met, np.newaxis] * direction[met]
            back = direction[met] - 2 * (direction[met] @ normal)[:, np.newaxis] * normal
            result[met] += np.array(material.reflection) * meet(of, place, back, False)
    return result


def rays(frame: Frame, x: int, y: int, strata: int, rng: np.random.Generator) -> tuple[Array, Array]:
    corner = np.indices((strata, strata)).reshape(2, -1).T
    places = (corner + rng.random(corner.shape)) / strata + (x, y)
    u = (places[:, :1] - frame.width / 2) * frame.pixel * frame.right
    v = (frame.height / 2 - places[:, 1:]) * frame.pixel * frame.up
    if frame.perspective:
        return np.tile(frame.eye, (len(places), 1)), frame.forward + u + v
    return frame.eye + u + v, np.tile(frame.forward, (len(places), 1))


@pytest.mark.parametrize("camera", CAMERAS)
def test_images_agree_with_rays(camera: str) -> None:
    of = seen(scene(WATER, HOUSE, SIGN, FLAG, ASIDE, materials=MATERIALS), camera)
    found = make(of, SIZE)
    assert found.method == "mirrored-polygons"
    assert 0.0 < found.error < 1e-11
    rng, frame = np.random.default_rng(11), frame_of(of, SIZE)
    for y in range(SIZE[1]):
        for x in range(SIZE[0]):
            first, second = (meet(of, *rays(frame, x, y, 40, rng), True) for _ in range(2))
            # What differs between two rays of a stratum is its variance.
            error = np.sqrt(((first - second) ** 2 / 4).sum(axis=0)) / 1600
            mean = (first + second).mean(axis=0) / 2
            # 6 standard errors: 1 in 1e6 for all 324 values; and a corner that 3,200 rays miss is below 20 of them.
            assert np.all(np.abs(found.exact[y, x] - mean) <= 6 * error + 0.006), (x, y)
            assert np.all(np.abs(found.exact[y, x] - mean) <= 6 * error + 1e-12) or error.max() < 2e-3, (x, y)


def test_the_limit_of_the_tracers_pictures() -> None:
    of = seen(scene(WATER, HOUSE, SIGN, FLAG, ASIDE, materials=MATERIALS), "perspective")
    built, exact = tracer.Tracer(of, SIZE), make(of, SIZE).exact
    pictures = np.array([built.render("sobol:scramble=shift", 1024, seed, 1, "box")[0] for seed in range(16)], float)
    mean, error = pictures.mean(axis=0), pictures.std(axis=0, ddof=1) / 4
    # Student's t of 15 degrees, 324 values, 1 in 1000 for all: 6.3. A part of a pixel that none of 16,384 samples met
    # is below 15 of them. 1e-7: float32.
    assert np.all(np.abs(mean - exact) < 6.3 * error + np.where(error == 0.0, 15 / 16384, 0.0) + 1e-7)


def test_the_mirror_shows_the_background_beside_all_images() -> None:
    of = seen(scene(WATER, materials=MATERIALS), "perspective")
    expected = np.array([0.03, 0.05, 0.02]) + np.array([0.6, 0.7, 0.8]) * BACKGROUND
    exact = make(of, SIZE).exact
    assert np.abs(exact[5, 6] - expected).max() < 1e-15
    assert np.array_equal(exact[0, 0], BACKGROUND)


def test_highlights_are_ten_thousand_times_as_bright_as_the_dark() -> None:
    of = stored("highlights")
    found = make(of, of.view.size)
    assert found.method == "mirrored-polygons"
    brightest = max(max(material.emission) for material in of.materials.values())
    assert brightest / min(max(of.view.background), found.exact.max()) > 5e3
    assert found.error < 1e-9 * brightest
    rng, frame = np.random.default_rng(3), frame_of(of)
    bright = np.argwhere(found.exact.sum(axis=2) > 30)
    for y, x in bright[:: len(bright) // 12]:
        first, second = (meet(of, *rays(frame, x, y, 60, rng), True) for _ in range(2))
        error = np.sqrt(((first - second) ** 2 / 4).sum(axis=0)) / 3600
        assert np.all(np.abs(found.exact[y, x] - (first + second).mean(axis=0) / 2) <= 6 * error), (x, y)


REFUSED = {
    "two mirrors": (scene(WATER, HOUSE | {"material": "water"}, materials=MATERIALS), "mirrors that see each other"),
    "behind it": (
        scene(box(1, 1, 9, 8, 0.0, "water"), polygon([(3, 3), (5, 3), (4, 6)], -1.0, "red"), materials=MATERIALS),
        "reaches behind the mirror",
    ),
    "through it": (
        scene(box(1, 1, 9, 8, 0.0, "water"), polygon([(3, 3, 1), (5, 3, 1), (4, 6, -1)], 0.0), materials=MATERIALS),
        "reaches behind the mirror",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_exact_image_is_refused(name: str) -> None:
    of, reason = REFUSED[name]
    with pytest.raises(Unsupported, match=reason):
        make(of, SIZE)
