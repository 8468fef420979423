"""Filtering of uneven samples: Voronoi cells against Qhull and exact fractions, weights against integrals of the
filters, the multi-stage filter against a program of its own here, and the pixel whose samples crowd beside an edge."""

from __future__ import annotations

import csv
import itertools
import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import shapely
from commands import complaint, run
from numpy.typing import NDArray
from scipy.spatial import Voronoi, cKDTree

import aliascope
from aliascope.errors import InvalidInput, JobFailed, SpecError, Unsupported
from aliascope.native import filters, uneven
from aliascope.studies.uneven import Study, study
from aliascope.studies.uneven_pictures import stages_response
from aliascope.studies.uneven_samples import CrowdedSamples, open_samples

Array = NDArray[np.float64]
PIXEL = (-0.5, -0.5, 0.5, 0.5)
EPSILON = float(np.finfo(float).eps)


# --- cells ------------------------------------------------------------------------------------------------------------


def mirrored_cells(points: Array, radius: float) -> list[shapely.Polygon]:
    """Qhull's cells of the points and their four mirror images: the square's sides are cell borders then."""
    x, y = points.T
    images = [np.column_stack([side - x, y]) for side in (-2 * radius, 2 * radius)]
    images += [np.column_stack([x, side - y]) for side in (-2 * radius, 2 * radius)]
    diagram = Voronoi(np.concatenate([points, *images]))
    regions = [diagram.regions[diagram.point_region[i]] for i in range(len(points))]
    return [shapely.Polygon(diagram.vertices[region]).convex_hull for region in regions]


def spread(name: str, n: int) -> Array:
    rng = np.random.default_rng(n)
    u = rng.random((n, 2)) - 0.5
    turn = 2.0 * np.pi * rng.random(n)
    return {
        "uniform": u,
        "corner": 0.49 + 0.01 * (u + 0.5),
        "two densities": np.where(rng.random((n, 1)) < 0.5, u, 0.2 + 1e-3 * u),
        "slanted line": np.column_stack([u[:, 0], 0.25 * u[:, 0]]),
        "circle": 0.4 * np.column_stack([np.cos(turn), np.sin(turn)]),
    }[name]


@pytest.mark.parametrize("name", ["uniform", "corner", "two densities", "slanted line", "circle"])
@pytest.mark.parametrize("n", [2, 3, 17, 400, 4096])
def test_areas_are_those_of_qhull(name: str, n: int) -> None:
    if n == 4096 and name in ("slanted line", "circle"):
        n = 800  # for which Qhull takes as long as for 4096 of the others; what holds for these is in test_uneven.c
    points = spread(name, n)
    areas = uneven.voronoi_areas(points, PIXEL)
    expected = np.array([cell.area for cell in mirrored_cells(points, 0.5)])
    # A corner between sites at distance d is good to 1e-16 / d: here and, less so, there. The closest are 1e-7 apart.
    assert np.abs(areas - expected).max() < (1e-15 if name == "uniform" else 1e-9)
    assert abs(areas.sum() - 1.0) < 1e-13
    assert np.abs(uneven.weights(points) - areas).max() < 1e-14


def exact_cell(sites: list[tuple[int, int]], own: tuple[int, int], side: int) -> Fraction:
    """By cutting the square [0, side]^2 half-way to every other site, in fractions."""
    corners = [tuple(map(Fraction, corner)) for corner in ((0, 0), (side, 0), (side, side), (0, side))]
    for other in sites:
        x, y = other[0] - own[0], other[1] - own[1]
        half = Fraction(other[0] ** 2 + other[1] ** 2 - own[0] ** 2 - own[1] ** 2, 2)
        kept: list[tuple[Fraction, ...]] = []
        for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1], strict=True):
            a, b = x * ax + y * ay - half, x * bx + y * by - half
            if a <= 0:
                kept.append((ax, ay))
            if a * b < 0:
                kept.append((ax + a / (a - b) * (bx - ax), ay + a / (a - b) * (by - ay)))
        corners = kept
    turned = corners[1:] + corners[:1]
    return sum((ax * by - ay * bx for (ax, ay), (bx, by) in zip(corners, turned, strict=True)), Fraction(0)) / 2


def test_areas_of_lattice_points_are_the_fractions() -> None:
    """On a lattice nearly everything is collinear or cocircular; some sites are there twice, some on the border."""
    side, rng = 6, np.random.default_rng(5)
    for n in (1, 2, 3, 4, 5, 8, 12, 20, 30):
        for _ in range(6):
            points = rng.integers(0, side + 1, (n, 2))
            sites = sorted({(int(x), int(y)) for x, y in points})
            areas = {site: exact_cell([other for other in sites if other != site], site, side) for site in sites}
            assert sum(areas.values()) == side * side
            keys = [(int(x), int(y)) for x, y in points]
            expected = [float(areas[key] / keys.count(key)) for key in keys]
            found = uneven.voronoi_areas(points.astype(float), (0.0, 0.0, float(side), float(side)))
            assert np.abs(found - expected).max() < 64 * EPSILON  # of 36, summed from some 8 corners


def test_areas_refuse_what_they_cannot_have() -> None:
    for points, bounds, text in (
        ([[0.0, 2.0]], (0.0, 0.0, 1.0, 1.0), "point 0"),
        ([[np.nan, 0.0]], (0.0, 0.0, 1.0, 1.0), "point 0"),
        ([[0.0, 0.0]], (0.0, 0.0, 0.0, 1.0), "no area"),
        ([0.0, 0.0], (0.0, 0.0, 1.0, 1.0), "shape"),
        (np.empty((0, 2)), (0.0, 0.0, 1.0, 1.0), "shape"),
    ):
        with pytest.raises(InvalidInput, match=text):
            uneven.voronoi_areas(points, bounds)


# --- weights by area and density --------------------------------------------------------------------------------------


@pytest.mark.parametrize("info", filters.registered(), ids=lambda info: info.name)
def test_weights_of_a_grid_are_products_of_integrals(info: filters.FilterInfo) -> None:
    """The cells of a grid are squares, so the weights are known to 1e-14."""
    radius = filters.radius(info.name)
    for count in (1, 3, 16):
        x = radius * ((np.arange(count) + 0.5) / count * 2.0 - 1.0)
        one = np.array([filters.integral(info.name, at - radius / count, at + radius / count) for at in x])
        grid = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
        weights = uneven.weights(grid, "area", info.name)
        assert np.abs(weights - np.outer(one, one).ravel()).max() < 1e-11  # what the table of integrals is good to


def integral_over(cell: shapely.Polygon, spec: str, panels: int = 48) -> float:
    """Of the filter: for each y the primitive from the left side to the right one, by panels of Gauss and Legendre."""
    corners = np.asarray(cell.exterior.coords)
    nodes, factors = np.polynomial.legendre.leggauss(6)
    heights, total = np.unique(corners[:, 1]), 0.0
    for low, high in itertools.pairwise(heights):
        if high - low < 1e-12:
            continue
        for edge in np.linspace(low, high, panels + 1)[:-1]:
            width = (high - low) / panels
            for node, factor in zip(nodes, factors, strict=True):
                y = edge + width * (node + 1.0) / 2.0
                met = []
                for (ax, ay), (bx, by) in itertools.pairwise(corners):
                    if min(ay, by) < y < max(ay, by):
                        met.append(ax + (y - ay) / (by - ay) * (bx - ax))
                profile = float(filters.evaluate(spec, [y])[0])
                total += factor * width / 2.0 * profile * filters.integral(spec, min(met), max(met))
    return total


@pytest.mark.parametrize("spec", ["tent", "mitchell", "blackman-harris"])
def test_weights_are_integrals_over_the_cells(spec: str) -> None:
    radius = filters.radius(spec)
    points = 2.0 * radius * spread("uniform", 17)
    weights = uneven.weights(points, "area", spec)
    cells = mirrored_cells(points, radius)
    for index in (0, 5, 11):
        # The panels here: of 1/48 of a side, on which the cubics' knots leave errors of the fourth power.
        assert weights[index] == pytest.approx(integral_over(cells[index], spec), abs=1e-6)


def test_inverse_density_is_the_disc_to_the_nearest() -> None:
    """Sites that are there twice are one, whose weight is shared; of the discs counts what is in the pixel."""
    points = np.concatenate([spread("two densities", 60), [[0.5, 0.5], [-0.5, 0.1]]])
    points = np.concatenate([points, points[:20]])
    sites, place, shared = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    for k in (1, 3, 8):
        distances = cKDTree(sites).query(sites, k=k + 1)[0][:, k]
        pixel = shapely.box(*PIXEL)
        discs = [
            pixel.intersection(shapely.Point(*site).buffer(r, quad_segs=500)).area
            for site, r in zip(sites, distances, strict=True)
        ]
        expected = (np.array(discs) / shared)[place.reshape(-1)]
        found = uneven.weights(points, f"inverse-density:neighbours={k}")
        # A polygon of 2000 sides has 1.6e-6 less area than its circle.
        assert found == pytest.approx(expected / expected.sum(), rel=4e-6)


def test_weights_are_refused_in_one_line() -> None:
    for points, method, under, kind, text in (
        ([[0.0, 0.6]], "area", None, InvalidInput, r"sample 0 at \(0, 0.6\) is outside the filter"),
        ([[0.0, np.inf]], "area", "mitchell", InvalidInput, "nowhere"),
        (np.empty((0, 2)), "area", None, InvalidInput, "shape"),
        ([[0.0, 0.0]], "aera", None, SpecError, "area"),
        ([[0.0, 0.0]], "multi-stage", "tent", Unsupported, "takes multi-stage, not tent"),
        ([[1.5, 0.1]], "average", "lanczos", JobFailed, "no average"),
    ):
        with pytest.raises(kind, match=text):
            uneven.weights(points, method, under)
    assert uneven.canonical("inverse-density:neighbours=3") == "inverse-density"
    assert [info.filter for info in uneven.registered() if info.name == "multi-stage"] == ["multi-stage"]
    assert aliascope.uneven_weights([[0.1, 0.2]]).tolist() == [1.0]


# --- the multi-stage filter -------------------------------------------------------------------------------------------


def test_the_response_is_the_product_of_the_boxes() -> None:
    """np.sinc(f w) is the transform of a box of width w. The other reading has boxes that widen with the factor."""
    frequencies = np.linspace(0.0, 4.0, 161)
    for spec, widths in (("multi-stage", (1.0, 0.5, 0.5, 0.25)), ("multi-stage:radius=4.5", (1.0, 2.0, 2.0, 4.0))):
        closed = np.prod([np.sinc(frequencies * width) for width in widths], axis=0)
        assert np.abs(filters.response(spec, frequencies) - closed).max() < 1e-12  # what a response is good to
    # By FFT of the profile: the sum over steps of 1/64 is the integral, but for aliases from 32 cycles and more, where
    # a product of four sincs is below 1e-6.
    step, count = 1.0 / 64.0, 1024
    x = (np.arange(count) - count // 2) * step
    transform = np.abs(np.fft.rfft(filters.evaluate("multi-stage", x))) * step
    exact = np.prod([np.sinc(np.fft.rfftfreq(count, step) * width) for width in (1.0, 0.5, 0.5, 0.25)], axis=0)
    assert np.abs(transform - np.abs(exact))[: count // 8].max() < 1e-6


def test_stages_of_even_samples_are_that_filter() -> None:
    frequencies = np.linspace(0.0, 2.0, 81)
    difference = np.abs(stages_response(frequencies) - filters.response("multi-stage", frequencies)).max()
    assert difference < 0.005  # as stages.c says: its grid has 32 steps a pixel


def forward(points: Array, values: Array) -> float:
    """The stages one after the other, on positions 1/32 apart: the averages of averages, where there are any."""
    step = 1.0 / 32.0
    at = (np.arange(62) - 30.5) * step
    inside = (points[:, None, :] >= at[None, :, None] - 0.125) & (points[:, None, :] < at[None, :, None] + 0.125)
    counts = np.einsum("nc,nr->rc", inside[:, :, 0].astype(float), inside[:, :, 1].astype(float))
    sums = np.einsum("n,nc,nr->rc", values, inside[:, :, 0].astype(float), inside[:, :, 1].astype(float))
    picture = np.where(counts > 0, sums / np.maximum(counts, 1.0), np.nan)
    for width in (16, 16, 32):
        boxes = np.lib.stride_tricks.sliding_window_view(picture, (width, width))
        there = ~np.isnan(boxes)
        picture = np.where(there, boxes, 0.0).sum(axis=(2, 3)) / np.where(
            there.any(axis=(2, 3)), there.sum(axis=(2, 3)), np.nan
        )
    assert picture.shape == (1, 1)
    return float(picture[0, 0])


@pytest.mark.parametrize("n", [1, 2, 9, 200])
def test_stages_are_averages_of_averages(n: int) -> None:
    rng = np.random.default_rng(n)
    for points in (0.4 * spread("uniform", n), 2.2 * spread("two densities", n), 2.1 * spread("circle", n)):
        values = rng.random(n)
        expected = forward(points, values)
        assert uneven.weights(points, "multi-stage") @ values == pytest.approx(expected, abs=1e-13)


# --- a pixel whose samples crowd on one side of an edge ---------------------------------------------------------------


@pytest.fixture(scope="module")
def crowded() -> Study:
    """64 samples a pixel, three quarters in its left half; 200 realisations; all with the filter multi-stage too."""
    return study(CrowdedSamples("random", 64, 0.75, 0), [], "box", 200)


def test_the_plain_average_is_wrong_and_the_others_are_right(crowded: Study) -> None:
    """The edge between the halves, of which 1/2 is covered: the plain average has 1/2 * 1/4 + 3/4 of the weight there.

    Significance: five standard errors of 200 realisations. What the others leave is the reach of the crowd half-way to
    the nearest samples on the other side; REMAINING has what was measured, and five standard errors of that.
    """
    found = {one.method: one for one in crowded.outcomes}
    assert set(found) == {"average", *REMAINING}
    wrong = found["average"].at_middle
    assert wrong.value is not None
    assert wrong.standard_error is not None
    assert abs(wrong.value - 0.375) < 5.0 * wrong.standard_error < 0.0125
    assert (found["average"].rmse.value or 0.0) > 0.2
    for method, (rmse, middle) in REMAINING.items():
        assert (found[method].rmse.value or 1.0) < rmse, method
        assert abs(found[method].at_middle.value or 1.0) < middle, method


REMAINING = {"area": (0.056, 0.102), "multi-stage": (0.033, 0.105), "inverse-density": (0.073, 0.102)}
"""RMS over positions of the edge, 0.049, 0.030, 0.062; and the error where it is in the middle, 0.088, 0.094, 0.082."""


def test_more_samples_mend_what_weights_leave_and_not_the_average() -> None:
    average, area = study(CrowdedSamples("random", 1024, 0.75, 0), ["average", "area"], "box", 20).outcomes
    assert (average.at_middle.value or 0.0) > 0.36
    assert abs(area.at_middle.value or 1.0) < 0.025  # 0.019 was measured: a quarter of that of 64 samples


def test_even_samples_are_filtered_right_by_all() -> None:
    """Without a crowd nothing leans: the mean error is zero within five standard errors."""
    for one in study(CrowdedSamples("random", 64, 0.0, 0), [], "tent", 100).outcomes:
        assert one.at_middle.value is not None
        assert one.at_middle.standard_error is not None
        assert abs(one.at_middle.value) < 5.0 * one.at_middle.standard_error, one.method


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_command(tmp_path: Path) -> None:
    folder = tmp_path / "made"
    text = run(
        "uneven", "random", "-n", "64", "--crowd", "0.25", "--filter", "tent", "--realisations", "2", "-o", folder
    )
    lines = text.stdout.splitlines()
    assert lines[0] == "random, 64 samples a pixel, 25 % in its left half; 2 realisations"
    assert [line.split()[:2] for line in lines[3:7]] == [
        ["average", "tent"],
        ["area", "tent"],
        ["multi-stage", "multi-stage"],
        ["inverse-density", "tent"],
    ]
    assert (folder / "uneven.png").read_bytes().startswith(b"\x89PNG")
    assert b"<svg" in (folder / "uneven.svg").read_bytes()
    rows = list(csv.DictReader((folder / "uneven.csv").read_text().splitlines()))
    assert len(rows) == 4 * 129
    assert {row["filter"] for row in rows} == {"tent", "multi-stage"}


def test_the_command_with_a_file(tmp_path: Path) -> None:
    points = tmp_path / "points.csv"
    np.savetxt(points, [[0.25, 0.5], [0.5, 0.5], [0.75, 0.5]], delimiter=",")
    found = json.loads(run("uneven", points, "--method", "area", "--method", "average", "--json").stdout)
    assert (found["n"], found["realisations"]) == (3, 1)
    area, average = found["results"]
    assert area["error_at_middle"] == pytest.approx(3 / 8 - 1 / 2, abs=1e-15)
    assert average["error_at_middle"] == pytest.approx(1 / 3 - 1 / 2, abs=1e-15)
    assert area["rmse_standard_error"] is None
    assert "-n and --crowd are a sampler's" in complaint("uneven", points, "--crowd", "0.5", code=2)


def test_what_the_command_refuses() -> None:
    assert "48 samples, in the left half" in complaint("uneven", "jittered", code=2)
    with pytest.raises(InvalidInput, match="is not randomised: it has one realisation, not 5"):
        study(open_samples("halton", 16, None, 0), [], "box", 5)
    with pytest.raises(InvalidInput, match="would take minutes"):
        study(open_samples("random", 65536, 0.0, 0), ["area"], "lanczos")
    with pytest.raises(InvalidInput, match="--crowd nan is no share"):
        open_samples("random", 16, float("nan"), 0)
    with pytest.raises(SpecError, match="weighting"):
        study(open_samples("halton", 16, None, 0), ["areas"], "box")
