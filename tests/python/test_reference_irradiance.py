"""References of polygons under area lights: Lambert's formula against integrals over the light, and published ones."""

from __future__ import annotations

import math

import numpy as np
import pytest
from reference_scenes import scene
from scipy.integrate import dblquad

from aliascope.errors import Unsupported
from aliascope.model import Scene
from aliascope.native import tracer
from aliascope.references import Reference, make
from aliascope.references.irradiance import Receiver, form_factor

SIZE = (24, 18)
MATERIALS = {
    "floor": {"albedo": [0.7, 0.6, 0.5], "emission": [0.02, 0.03, 0.01]},
    "wall": {"albedo": [0.2, 0.6, 0.9]},
    "sign": {"emission": [0.8, 0.1, 0.4]},
}
FLOOR = {"type": "polygon", "material": "floor", "points": [[-3.0, 0, -2], [3.2, 0, -2], [2.8, 0, 3.1], [-2.7, 0, 2.9]]}
WALL = {"type": "polygon", "material": "wall", "points": [[-3.0, 0, -2], [3.2, 0, -2], [3.2, 2.9, -2], [-3.0, 2.7, -2]]}
BOARD = {"type": "polygon", "material": "wall", "points": [[0.5, 1, 0], [1, 1, 0.1], [1, 1, 1], [0.4, 1, 0.9]]}
LIGHT = {
    "type": "area",
    "corner": [-1.2, 3.1, -0.7],
    "edges": [[2.3, 0.2, 0.0], [0.1, 0.05, 2.1]],
    "intensity": [5.0, 4.0, 3.0],
    "falloff": "inverse-square",
}
CAMERAS = {
    "perspective": {
        "type": "perspective",
        "eye": [0.4, 2.2, 7.0],
        "look_at": [0.1, 1.1, 0.0],
        "vertical_fov_degrees": 40.0,
    },
    "orthographic": {"type": "orthographic", "eye": [0.4, 3.2, 7.0], "look_at": [0.1, 0.9, 0.0], "height": 5.0},
}


def lit(*surfaces: dict[str, object], camera: str = "perspective", light: dict[str, object] | None = None) -> Scene:
    return scene(*surfaces, camera=CAMERAS[camera], materials=MATERIALS, lights=[light or LIGHT], size=SIZE)


@pytest.fixture(scope="module", params=CAMERAS)
def pictured(request: pytest.FixtureRequest) -> tuple[Scene, Reference]:
    of = lit(FLOOR, WALL, camera=request.param)
    return of, make(of, SIZE)


def test_the_limit_of_the_tracers_pictures(pictured: tuple[Scene, Reference]) -> None:
    of, found = pictured
    assert found.method == "irradiance"
    assert 0.0 < found.error < 1e-10
    built = tracer.Tracer(of, SIZE)
    pictures = np.array([built.render("sobol:scramble=shift", 1024, seed, 1, "box")[0] for seed in range(16)], float)
    mean, error = pictures.mean(axis=0), pictures.std(axis=0, ddof=1) / 4
    # Student's t of 15 degrees, 1296 values, 1 in 1000 for all: 7.1. A part of a pixel that none of 16,384 samples met
    # is smaller than 15 of them. 1e-7: float32.
    assert np.all(np.abs(mean - found.exact) < 7.1 * error + np.where(error == 0.0, 15 / 16384, 0.0) + 1e-7)
    assert abs((mean - found.exact).mean()) < 2e-5


@pytest.mark.parametrize("pixel", [(12, 13), (8, 12), (12, 4)])
def test_pixels_against_quadrature_over_pixel_and_light(
    pictured: tuple[Scene, Reference], pixel: tuple[int, int]
) -> None:
    """The scene equation as it stands, over the pixel and the light by Gauss-Legendre, in pixels of one surface."""
    of, found = pictured
    eye, at = np.array(of.camera.eye), np.array(of.camera.look_at)
    ahead = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(ahead, [0, 1, 0]) / np.linalg.norm(np.cross(ahead, [0, 1, 0]))
    above = np.cross(right, ahead)
    tall = of.camera.height or 2 * math.tan(math.radians(20))
    x, w = np.polynomial.legendre.leggauss(14)
    x, w = (x + 1) / 2, w / 2
    a, b, s, t = (g.ravel() for g in np.meshgrid(x, x, x, x, indexing="ij"))
    weight = np.einsum("i,j,k,l->ijkl", w, w, w, w).ravel()
    u = ((pixel[0] + a - 12) * tall / 18)[:, np.newaxis] * right
    v = ((9 - pixel[1] - b) * tall / 18)[:, np.newaxis] * above
    perspective = of.camera.type == "perspective"
    origin, way = (eye, ahead + u + v) if perspective else (eye + u + v, ahead + 0 * u)
    normal, base = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 0.0])
    distance = (base - origin) @ normal / (way @ normal)
    place = origin + way * distance[..., np.newaxis]
    name, beyond = "floor", (place[:, 2] < -2) | (distance < 0)
    assert beyond.all() or not beyond.any()
    if beyond.all():
        normal, base, name = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -2.0]), "wall"
        place = origin + way * ((base - origin) @ normal / (way @ normal))[..., np.newaxis]
    first, second = (np.array(edge) for edge in LIGHT["edges"])
    to = np.array(LIGHT["corner"]) + s[:, np.newaxis] * first + t[:, np.newaxis] * second - place
    squared = (to**2).sum(axis=1)
    shining = np.cross(first, second) / np.linalg.norm(np.cross(first, second))
    share = np.maximum(0, to @ normal) * np.maximum(0, -to @ shining) / squared**2
    mean = float((weight * share).sum())
    material = MATERIALS[name]
    emission = np.array(material.get("emission", [0, 0, 0]))
    expected = emission + np.array(material["albedo"]) * LIGHT["intensity"] * mean
    # 14 nodes in each variable of functions as smooth as these; a light below a horizon in part would have a kink.
    assert np.abs(found.exact[pixel[1], pixel[0]] - expected).max() < 1e-9


@pytest.mark.parametrize("apart", [0.2, 1.0, 3.0])
def test_published_form_factors_of_squares(apart: float) -> None:
    """From a small patch to a rectangle parallel to it, one corner above it (Howell, catalogue, B-3)."""
    a, b, c = 1.3, 0.7, apart
    corners = np.array([[0, 0, c], [a, 0, c], [a, b, c], [0, b, c]])
    x, y = a / c, b / c
    one, other = math.sqrt(1 + x * x), math.sqrt(1 + y * y)
    expected = (x / one * math.atan(y / one) + y / other * math.atan(x / other)) / (2 * math.pi)
    found = float(form_factor(np.zeros(3), np.array([0.0, 0.0, 1.0]), corners))
    assert abs(found - expected) < 1e-15


def test_what_lies_below_the_horizon_is_cut_off() -> None:
    """A rectangle that stands on the far side of the plane too: its part above, by quadrature."""
    receiver = Receiver(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    corners = np.array([[1.0, -0.7, -0.4], [1.3, 0.9, -0.4], [1.3, 0.9, 0.8], [1.0, -0.7, 0.8]])
    kept = receiver.above(corners)
    assert kept[:, 2].min() == 0.0
    found = float(form_factor(np.zeros(3), receiver.normal, kept))
    along = corners[1] - corners[0]
    facing = np.cross(along, [0, 0, 1.0])
    facing /= np.linalg.norm(along)

    def share(z: float, t: float) -> float:
        place = corners[0] + t * along
        place[2] = z
        squared = float(place @ place)
        return z * abs(float(place @ facing)) / (math.pi * squared**2)

    expected, _ = dblquad(share, 0, 1, 0, 0.8, epsabs=1e-11)
    assert abs(found - expected * float(np.linalg.norm(along))) < 1e-10
    assert len(receiver.above(corners - [0, 0, 2.0])) == 0


def test_the_back_of_a_light_is_dark() -> None:
    behind = LIGHT | {"edges": LIGHT["edges"][::-1]}
    exact = make(lit(FLOOR, light=behind), SIZE).exact
    assert np.array_equal(exact[13, 12], MATERIALS["floor"]["emission"])


REFUSED = {
    "an occluder": (lit(FLOOR, BOARD), "may stand between"),
    "no fall-off": (lit(FLOOR, light=LIGHT | {"falloff": "none"}), "inverse-square"),
    "both sides of the light": (lit(FLOOR, WALL, light=LIGHT | {"corner": [-1.2, 1.1, -0.7]}), "both sides"),
    "a light on the surface": (
        lit(FLOOR, light=LIGHT | {"corner": [-1.2, 0.0, -0.7], "edges": [[2.3, 0.0, 0.0], [0.0, 1.0, 1e-7]]}),
        "does not settle|rounding could move|both sides",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_exact_irradiance_is_refused(name: str) -> None:
    of, reason = REFUSED[name]
    with pytest.raises(Unsupported, match=reason):
        make(of, SIZE)


def test_what_lies_behind_a_surface_or_aside_hides_no_light() -> None:
    below = FLOOR | {"material": "sign", "points": [[x, -1.0, z] for x, _, z in FLOOR["points"]]}
    beside = WALL | {"points": [[x + 9.0, y, z + 1.0] for x, y, z in WALL["points"]]}
    alone = make(lit(FLOOR), SIZE).exact[12:16, 4:20]
    assert np.abs(make(lit(FLOOR, below, beside), SIZE).exact[12:16, 4:20] - alone).max() < 1e-13
