"""The zone plate's means over pixels, against quadrature."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from reference_scenes import BACKGROUND, SIZE, box, brute_force, scene, stored

from aliascope.errors import Unsupported
from aliascope.geometry import frame_of
from aliascope.references import make
from aliascope.references.zone_plate import mean_phasor

PIXEL = 2.0 / 96
CENTRE = (-0.3137, -0.1573)
SCALE = 98.43


def test_pixels_near_the_centre_and_in_the_corners_agree_with_mpmath() -> None:
    of = stored("zone-plate")
    reference = make(of, (128, 96))
    pattern = of.materials["rings"].pattern
    assert pattern is not None
    for x, y in ((48, 55), (49, 55), (0, 0), (127, 0), (127, 95)):
        left, top = (x - 64) * PIXEL - CENTRE[0], (48 - y) * PIXEL - CENTRE[1]
        with mpmath.workdps(20):
            edge = mpmath.mpf(2) / 96
            wave = mpmath.quad(
                lambda a, b: mpmath.cos(SCALE * (a * a + b * b)), [left, left + edge], [top - edge, top], maxdegree=5
            ) / (edge * edge)
        low, high = (np.array(c) for c in pattern.colours)
        expected = low + (high - low) * (1 + float(wave)) / 2
        # The reference's own bound, and the corner of the pixel, here in double: 2 eps * the phase's slope of 300.
        assert np.abs(reference.exact[y, x] - expected).max() <= reference.error + 2e-13


def test_every_pixel_agrees_with_gauss_legendre() -> None:
    of = stored("zone-plate")
    reference = make(of, (128, 96))
    node, weight = np.polynomial.legendre.leggauss(24)
    x = ((np.arange(128) - 64)[:, np.newaxis] + (node + 1) / 2) * PIXEL - CENTRE[0]
    y = ((48 - np.arange(96))[:, np.newaxis] - (node + 1) / 2) * PIXEL - CENTRE[1]
    # 24 nodes integrate the 8 radians that the phase turns in a pixel, at most, to the last digit.
    across = (np.exp(1j * SCALE * x**2) * weight / 2).sum(axis=1)
    down = (np.exp(1j * SCALE * y**2) * weight / 2).sum(axis=1)
    pattern = of.materials["rings"].pattern
    assert pattern is not None
    low, high = (np.array(c) for c in pattern.colours)
    expected = low + (high - low) * ((1 + (across * down[:, np.newaxis]).real) / 2)[:, :, np.newaxis]
    assert np.abs(reference.exact - expected).max() <= reference.error


@pytest.mark.parametrize("scale", [1e-12, 1e-3, 1.0, 1e3, 1e6])
def test_means_of_any_scale_agree_with_mpmath(scale: float) -> None:
    edges = np.linspace(-0.83, 1.37, 23)
    found, error = mean_phasor(edges, scale)
    assert error < 1e-9
    for i in (0, 8, 9, 21):  # 8 holds the centre
        with mpmath.workdps(30):
            a, b = mpmath.mpf(edges[i]), mpmath.mpf(edges[i + 1])
            root = mpmath.sqrt(2 * mpmath.mpf(scale) / mpmath.pi)
            integral = [mpmath.fresnelc(e * root) + 1j * mpmath.fresnels(e * root) for e in (a, b)]
            expected = complex((integral[1] - integral[0]) / (root * (b - a)))
        assert abs(found[i] - expected) <= error


def test_a_plane_off_the_centre_and_a_perspective_camera_agree_with_a_million_rays() -> None:
    camera = {"type": "perspective", "eye": [0.6, 0.3, 9.0], "look_at": [0.6, 0.3, 0.0], "vertical_fov_degrees": 52.0}
    pattern = {"type": "zone-plate", "scale": 0.7, "origin": [1.3, -0.4, 1.9], "colours": [[0.1, 0.2, 0], [1, 0.7, 2]]}
    rings = {"emission": [0.9, 0.6, 1.2], "pattern": pattern}
    of = scene(box(-20, -20, 30, 30, 0.5, "rings"), camera=camera, materials={"rings": rings})
    reference = make(of, SIZE)
    for seed, (x, y) in enumerate(((6, 4), (2, 7), (11, 0))):
        mean, standard_error = brute_force(of, SIZE, (x, y), seed)
        assert standard_error.min() > 0
        assert np.all(np.abs(reference.exact[y, x] - mean) <= 5 * standard_error)  # 1 in 2 million each


def test_rings_beside_and_below_constant_surfaces() -> None:
    pattern = {"type": "zone-plate", "scale": 0.7, "colours": [[0, 0, 0], [1, 1, 1]]}
    materials = {"rings": {"emission": [1, 1, 1], "pattern": pattern}, "red": {"emission": [0.9, 0.2, 0.1]}}
    alone = make(scene(box(-2, -2, 20, 20, 0.0, "rings"), materials=materials), SIZE).exact
    both = make(scene(box(2, 1, 9, 8, 0.0, "rings"), box(4, 3, 6, 5, 1.0, "red"), materials=materials), SIZE)
    assert both.method == "zone-plate"
    expected = np.tile(np.array(BACKGROUND), (SIZE[1], SIZE[0], 1))
    expected[1:8, 2:9] = alone[1:8, 2:9]
    expected[3:5, 4:6] = [0.9, 0.2, 0.1]
    assert np.abs(both.exact - expected).max() <= both.error


def test_too_many_rings_are_refused() -> None:
    with pytest.raises(Unsupported, match="turns too often"):
        mean_phasor(np.array([1e3, 1e3 + 1]), 1e9)
    with pytest.raises(Unsupported, match="too far from its centre"):
        mean_phasor(np.array([1.0, 1.0]), 1.0)
    pattern = {"type": "zone-plate", "scale": 1.0, "origin": [1e5, 0, 0]}
    of = scene(box(-1, -1, 20, 20, material="rings"), materials={"rings": {"emission": [1, 1, 1], "pattern": pattern}})
    with pytest.raises(Unsupported, match="turns too often"):
        make(of, SIZE)


def test_the_frame_is_that_of_the_scene() -> None:
    """The figures above take the pixel from the scene file; this holds them to it."""
    assert frame_of(stored("zone-plate")).pixel == PIXEL
