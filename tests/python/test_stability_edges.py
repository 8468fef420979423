"""Which side of an edge samples see: that pictures of other edges are told from the right one at every level."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from aliascope.stability.edges import ABOVE, BELOW, OFF, near_axis, near_diagonal, off, on_samples

MAKERS = (near_axis, near_diagonal, on_samples)


def picture(distances: np.ndarray) -> np.ndarray:
    return np.repeat(np.where(distances > 0.0, BELOW, ABOVE)[..., np.newaxis], 3, axis=-1)


@pytest.mark.parametrize("make", MAKERS)
@pytest.mark.parametrize("at", [1e-2, 1e-3, 1e-6, 1e-12])
def test_the_right_picture_is_not_off_and_others_are(make, at: float) -> None:
    _, distances = make(at)
    assert off(picture(distances), distances) == 0.0
    nearest = np.abs(distances).min()
    assert 0.0 < nearest <= at
    # Of an edge on the samples, each of which sees the same face, and of one on their other side.
    for other in (make(0.0)[1] - 1e-15, make(-at)[1]):
        assert nearest <= off(picture(other), distances) <= 24.0 * at
    assert off(picture(distances) * 0.0, distances) == math.inf


@pytest.mark.parametrize("make", [near_axis, near_diagonal])
def test_an_edge_without_its_slope_passes_the_bound_where_that_can_be_seen(make) -> None:
    assert off(picture(make(0.0)[1] - 1e-15), make(1e-3)[1]) > OFF
    assert off(picture(make(-1e-3)[1]), make(1e-3)[1]) > OFF


def test_distances_are_those_of_exact_fractions() -> None:
    slope = 1e-7
    _, distances = near_axis(slope)
    exact = [Fraction(slope) * (Fraction(2 * x + 1, 2) - 12) for x in range(24)]
    np.testing.assert_allclose(distances[8], [float(each) for each in exact], rtol=1e-15)
    _, distances = near_diagonal(slope)
    more = Fraction(1.0 + slope) - 1
    exact = [more * (Fraction(2 * k + 1, 2) - 8) for k in range(16)]
    along = [distances[15 - k, k + 4] for k in range(16)]
    np.testing.assert_allclose(along, [float(each) / math.hypot(1.0, 1.0 + slope) for each in exact], rtol=1e-12)
