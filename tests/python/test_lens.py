"""The tracer's thin lens against the distribution functions of its aperture, and against the pinhole."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from pydantic import ValidationError
from scipy import stats

from aliascope.errors import Unsupported
from aliascope.model import Scene
from aliascope.native.tracer import Tracer
from aliascope.renderers import base, embree, mode_of
from aliascope.renderers.base import Request

SIZE = (24, 16)
FOCUS = 5.3
RADIUS = 0.73
SEEDS = 8
SAMPLES = 256
HALF_HEIGHT = np.tan(np.radians(31.0) / 2.0)
FAR = 400.0


def half_plane(depth: float, edge: float, axis: int) -> dict[str, Any]:
    """All that lies beyond `edge` along x (axis 0) or y (axis 1), at a depth before the eye."""
    corners = np.array([[edge, -FAR], [FAR, -FAR], [FAR, FAR], [edge, FAR]])
    if axis == 1:
        corners = corners[:, ::-1]
    return {"type": "polygon", "material": "white", "points": [[float(x), float(y), -depth] for x, y in corners]}


def scene_of(surfaces: list[dict[str, Any]], **camera: Any) -> Scene:
    return Scene.model_validate(
        {
            "title": "t",
            "shows": "s",
            "view": {"size": SIZE},
            "camera": {
                "type": "perspective",
                "eye": (0.0, 0.0, 0.0),
                "look_at": (0.0, 0.0, -1.0),
                "vertical_fov_degrees": 31.0,
            }
            | camera,
            "materials": {"white": {"emission": (1.0, 1.0, 1.0)}},
            "surfaces": surfaces,
        }
    )


def blades_beyond(blades: int, axis: int, where: float) -> float:
    """The share of an aperture of radius 1 that lies beyond `where` along an axis."""
    if blades == 0:
        s = float(np.clip(where, -1.0, 1.0))
        return 0.5 - (s * np.sqrt(1.0 - s * s) + np.arcsin(s)) / np.pi
    angles = 2.0 * np.pi * np.arange(blades) / blades
    polygon = shapely.Polygon(np.column_stack([np.sin(angles), np.cos(angles)]))
    low, high = ((where, -2.0), (2.0, 2.0)) if axis == 0 else ((-2.0, where), (2.0, 2.0))
    return float(polygon.intersection(shapely.box(*low, *high)).area / polygon.area) if where < 2.0 else 0.0


def expected(depth: float, edge: float, axis: int, blades: int) -> np.ndarray:
    """Of each column (axis 0) or row, from the left or the bottom: the mean over the pixel by Gauss's rule."""
    count, half = SIZE[axis], HALF_HEIGHT * (SIZE[axis] / SIZE[1])
    nodes, weights = np.polynomial.legendre.leggauss(24)
    stretch = RADIUS * (1.0 - depth / FOCUS)  # the ray through lens point x is at depth * u + x (1 - depth / focus)
    means = []
    for pixel in range(count):
        u = (2.0 * (pixel + 0.5 + 0.5 * nodes) / count - 1.0) * half
        needed = (edge - depth * u) / stretch
        shares = [blades_beyond(blades, axis, each) for each in needed]
        if stretch < 0.0:
            shares = [1.0 - share for share in shares]
        means.append(0.5 * float(weights @ shares))
    return np.array(means)


@pytest.mark.parametrize(
    ("depth", "axis", "blades"), [(3.1, 0, 0), (11.7, 1, 0), (3.1, 1, 3), (11.7, 1, 3), (11.7, 0, 5), (3.1, 0, 6)]
)
def test_a_defocused_edge_is_the_apertures_distribution(depth: float, axis: int, blades: int) -> None:
    edge = 0.043 * depth
    scene = scene_of([half_plane(depth, edge, axis)], lens_radius=RADIUS, focus_distance=FOCUS, blades=blades)
    built = Tracer(scene, SIZE)
    drawn = np.array([built.render("sobol:scramble=owen", SAMPLES, seed)[0][:, :, 0] for seed in range(SEEDS)])
    lines = np.moveaxis(drawn, 2 - axis, 0)  # (columns or rows, ...): the picture is constant along the edge
    lines = lines.reshape(len(lines), -1).astype(np.float64)
    if axis == 1:
        lines = lines[::-1]
    wanted = expected(depth, edge, axis, blades)
    assert ((wanted > 0.02) & (wanted < 0.98)).sum() >= 3
    error = lines.mean(axis=1) - wanted
    deviation = lines.std(axis=1, ddof=1) / np.sqrt(lines.shape[1])
    assert deviation.max() < 2e-3
    # Significance 1e-4 for each case, over all lines (Bonferroni); 1e-4 more for the quadrature over corners.
    limit = stats.norm.isf(0.5e-4 / len(wanted))
    assert (np.abs(error) <= limit * deviation + 1e-4).all()


def test_what_is_in_focus_is_as_through_a_pinhole() -> None:
    """The rays of a sample meet the plane in the same point, but for float's rounding."""
    surface = half_plane(FOCUS, 0.1234, 0)
    with_lens = Tracer(scene_of([surface], lens_radius=RADIUS, focus_distance=FOCUS), SIZE)
    pinhole = Tracer(scene_of([surface]), SIZE)
    seen, _ = with_lens.render("sobol:scramble=owen", 64, 5)
    wanted, _ = pinhole.render("sobol:scramble=owen", 64, 5)
    assert 0.0 < wanted.mean() < 1.0
    assert np.abs(seen - wanted).max() <= 1.0 / 64.0  # a sample on the edge itself may fall to either side


def checkered(**camera: Any) -> Scene:
    """Planes, patterns and lights take another way through the tracer than plain surfaces."""
    scene = scene_of([half_plane(2.3, 0.0813, 0), half_plane(9.1, -40.0, 1)], **camera).model_dump()
    scene["materials"]["white"] |= {"albedo": (0.3, 0.4, 0.5), "pattern": {"type": "checker", "scale": 1.37}}
    scene["surfaces"] += ({"type": "plane", "material": "white", "point": (0.0, -1.1, 0.0), "normal": (0.0, 1.0, 0.1)},)
    scene["lights"] = ({"type": "point", "position": (0.4, 2.0, -1.0), "intensity": (1.0, 1.0, 1.0)},)
    return Scene.model_validate(scene)


def test_shading_is_at_the_point_that_the_ray_from_the_lens_meets() -> None:
    """Against the mean of pinholes at points of the lens: from each, the picture of the plane of focus keeps its
    place, so that a sample at (u, v) looks from (x, y) along (u - x / F, v - y / F)."""
    lens = Tracer(checkered(lens_radius=RADIUS, focus_distance=FOCUS), SIZE)
    seen = np.mean([lens.render("sobol:scramble=owen", 256, seed)[0] for seed in range(4)], axis=0)
    rays = 120
    angle, out = 2.0 * np.pi * (np.arange(rays) * 0.6180339887498949 % 1.0), np.sqrt((np.arange(rays) + 0.5) / rays)
    pixel = 2.0 * HALF_HEIGHT / SIZE[1]
    total = np.zeros(seen.shape)
    for x, y in zip(RADIUS * out * np.cos(angle), RADIUS * out * np.sin(angle), strict=True):
        # The shift is rounded to a quarter of a pixel, which moves edges both ways alike.
        total += pinhole_from(x, y, pixel)
    assert (
        np.sqrt(np.mean((seen - total / rays) ** 2)) < 0.015
    )  # measured 0.010: 120 points of the lens, a quarter pixel; the other sign 0.1


def pinhole_from(x: float, y: float, pixel: float) -> np.ndarray:
    """The picture from (x, y) with its frustum skewed: a larger picture, of which the shifted samples are taken."""
    border = 4
    large = (SIZE[0] + 2 * border, SIZE[1] + 2 * border)
    shift_x, shift_y = -x / FOCUS / pixel, y / FOCUS / pixel  # of the sample, in pixels: right, and down
    scene = checkered(eye=(x, y, 0.0), look_at=(x, y, -1.0))
    degrees = float(np.degrees(2.0 * np.arctan(HALF_HEIGHT * large[1] / SIZE[1])))
    camera = scene.camera.model_copy(update={"vertical_fov_degrees": degrees})
    fine = 4
    built = Tracer(scene.model_copy(update={"camera": camera}), (large[0] * fine, large[1] * fine))
    drawn, _ = built.render("regular", 1)
    left, top = (round(fine * (border + shift)) for shift in (shift_x, shift_y))
    part = drawn[top : top + fine * SIZE[1], left : left + fine * SIZE[0]]
    return part.reshape(SIZE[1], fine, SIZE[0], fine, 3).mean(axis=(1, 3))


def test_a_lens_of_no_radius_is_a_pinhole_to_the_bit() -> None:
    pinhole, closed = Tracer(checkered(), SIZE), Tracer(checkered(lens_radius=0.0, focus_distance=FOCUS), SIZE)
    assert pinhole.dimensions == closed.dimensions == 2
    first, second = (built.render("halton", 37, 0) for built in (pinhole, closed))
    assert np.array_equal(first[0], second[0])
    assert (first[1].primary_rays, first[1].shadow_rays) == (second[1].primary_rays, second[1].shadow_rays)


@pytest.mark.parametrize("filter_", ["box", "mitchell"])
def test_threads_change_no_bit(filter_: str) -> None:
    built = Tracer(checkered(lens_radius=RADIUS, focus_distance=FOCUS, blades=7), (37, 27))
    one, three = (built.render("sobol:scramble=owen", 21, 4, threads, filter_)[0] for threads in (1, 3))
    assert np.array_equal(one, three)
    adaptive = [built.render_adaptive("fixed", "sobol:scramble=owen", 21, 4, threads)[0] for threads in (1, 3)]
    assert np.array_equal(*adaptive)
    if filter_ == "box":
        assert np.allclose(adaptive[0], one, atol=1e-6)  # the same samples in other packets


def test_a_sample_has_as_many_dimensions_as_the_scene_needs() -> None:
    scene = checkered(lens_radius=RADIUS, focus_distance=FOCUS)
    assert Tracer(scene, SIZE).dimensions == scene.needs().dimensions == 4


@pytest.mark.parametrize("sampler", ["standard-msaa,n=4", "sgi-8x8,n=8"])
def test_planar_patterns_are_refused_where_there_is_a_lens(sampler: str) -> None:
    scene, renderer = checkered(lens_radius=RADIUS, focus_distance=FOCUS), embree.RENDERER
    mode = mode_of(renderer, f"uniform:sampler={sampler}")
    assert base.lacks(renderer, checkered(), mode) is None
    reason = base.lacks(renderer, scene, mode)
    assert reason is not None
    assert "dimension" in reason
    with pytest.raises(Unsupported, match="dimension"):
        renderer.render(Request(scene, *SIZE, mode))


@pytest.mark.parametrize("blades", [1, 2])
def test_an_aperture_of_one_or_two_blades_is_refused(blades: int) -> None:
    with pytest.raises(ValidationError, match="a lens has 3 blades or more"):
        checkered(lens_radius=RADIUS, focus_distance=FOCUS, blades=blades)
