"""Where the samples of a pixel lie and what each weighs: measured with edges and corners at all phases, and held to the
pattern that a mode is believed to have.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from aliascope.geometry import Array
from aliascope.studies.doctor_charts import PHASES, Corners, Edges
from aliascope.studies.doctor_findings import Figure, Finding, Inquiry, Shot, Shown

WEIGHT_LIMIT = 1e-4
"""A weight is a difference of up to four values of 16 bits, off by half of 1/65535 each: 3.1e-5. Thrice that."""

PLACE_LIMIT = 2.0 / PHASES
"""Pixels: a step between two phases is found at the middle between them; a phase more for OSMesa's grid of 1/256."""

SHOWN_COLUMNS = 5
"""Of more columns, text has the ends and the range between."""


@dataclass(frozen=True)
class Pattern:
    """samples (n, 3): x to the right and y down from the pixel's corner, both within 1/2 pixel of it, and the weight,
    which sum to 1."""

    samples: Array

    def columns(self, axis: int) -> tuple[Array, Array]:
        """The places along x (0) or y (1), ascending, and the sums of the weights there."""
        places, which = np.unique(np.round(self.samples[:, axis], 9), return_inverse=True)
        weights: Array = np.bincount(which, self.samples[:, 2]).astype(np.float64)
        return places, weights

    @property
    def chart(self) -> Corners:
        """Corners halfway between the columns and rows of the pattern, and of its neighbours'."""
        places = np.unique(np.round(self.samples[:, :2] % 1.0, 9))
        middles = 0.5 * (places + np.append(places[1:], places[0] + 1.0)) % 1.0
        return Corners(tuple(sorted(middles.tolist())))


def grid_pattern(side: int, centre: bool) -> Pattern:
    """The centres of side x side cells, all of one weight, and the pixel's centre too, if so."""
    places = (np.arange(side) + 0.5) / side
    samples = [(x, y) for y in places for x in places] + ([(0.5, 0.5)] if centre else [])
    return Pattern(np.array([(x, y, 1.0 / len(samples)) for x, y in samples]))


def trapezoid_pattern(intervals: int) -> Pattern:
    """The trapezoid rule in x and y, of intervals + 1 places from one border to the other."""
    weights = np.full(intervals + 1, 1.0 / intervals)
    weights[[0, -1]] *= 0.5
    places = np.linspace(0.0, 1.0, intervals + 1)
    return Pattern(
        np.array(
            [(x, y, w * v) for y, v in zip(places, weights, strict=True) for x, w in zip(places, weights, strict=True)]
        )
    )


@dataclass(frozen=True)
class Columns:
    """What an edge finds of the columns that it passes: the weight and the place of each, in pixels; and how far the
    values between them are from flat, 0 where there are no further columns."""

    weights: Array
    places: Array
    rest: float


def columns_of(spread: Array, at: Array, expected: Array) -> Columns:
    """spread: a pixel's values with an edge at these places, evenly spaced; expected: the places of the columns. Each
    weight is a difference of two means, over the middle half of the phases between columns: so it is what it is where
    columns lie somewhat off, too."""
    middles = 0.5 * (expected[1:] + expected[:-1])
    borders = np.concatenate([[at[0]], middles, [at[-1]]])
    step = at[1] - at[0]
    values, rest = [], 0.0
    for left, right in zip([at[0] - 9 * step, *expected], [*expected, at[-1] + 9 * step], strict=True):
        between = spread[(at > left + 3.0 * step) & (at < right - 3.0 * step)]
        values.append(float(between[len(between) // 4 : len(between) - len(between) // 4].mean()))
        rest = max(rest, float(np.abs(between - values[-1]).max()))
    weights, places = np.diff(values), []
    for k, weight in enumerate(weights):
        here = (at >= borders[k]) & (at < borders[k + 1])
        share = (spread[here] - values[k]) / weight if weight else np.zeros(int(here.sum()))
        places.append(float(at[here][-1] + 0.5 * step - step * share.sum()))
    return Columns(weights, np.array(places), rest)


@dataclass(frozen=True)
class Measured:
    """Of one mode: its columns and rows; the weight of each sample by itself, [rows][columns] of the chart's corners;
    how many samples are distinct; and the largest differences from the pattern. sampled: rays a pixel, as the renderer
    counts them."""

    columns: Columns
    rows: Columns
    samples: Array
    distinct: int
    weights_off: float
    places_off: float
    sampled: float

    @property
    def holds(self) -> bool:
        rest = max(self.columns.rest, self.rows.rest)
        return self.weights_off <= WEIGHT_LIMIT and self.places_off <= PLACE_LIMIT and rest <= WEIGHT_LIMIT


def measured(pattern: Pattern, edges: Shown, corners: Shown) -> Measured:
    chart = Edges()
    found, off, moved = [], [], []
    for axis, spread in enumerate(chart.spreads(edges.pixels)):
        places, weights = pattern.columns(axis)
        found.append(columns_of(spread, chart.places(), places))
        off.append(np.abs(found[-1].weights - weights).max())
        moved.append(np.abs(found[-1].places - places).max())
    seen = pattern.chart.weights(corners.pixels)
    between = pattern.chart.between()
    right, down = (np.searchsorted(between, pattern.samples[:, axis]) - 1 for axis in (0, 1))
    expected = np.zeros_like(seen)
    np.add.at(expected, (down, right), pattern.samples[:, 2])
    off.append(np.abs(seen - expected).max())
    distinct = int((np.abs(seen) > 0.5 * expected[expected > 0.0].min()).sum())
    return Measured(found[0], found[1], seen, distinct, float(max(off)), float(max(moved)), edges.samples_per_pixel)


def _weights_text(columns: Columns) -> str:
    weights = columns.weights
    if len(weights) <= SHOWN_COLUMNS:
        return " ".join(f"{weight:.4f}" for weight in weights)
    within = weights[1:-1]
    return f"{weights[0]:.4f}, {len(within)} from {within.min():.4f} to {within.max():.4f}, {weights[-1]:.4f}"


def _figure(mode: str, pattern: Pattern, found: Measured) -> Figure:
    places, weights = pattern.columns(0)
    expected = Columns(weights, places, 0.0)
    text = (
        f"columns  {_weights_text(found.columns)}\n"
        f"expected {_weights_text(expected)}\n"
        f"off by {found.weights_off:.1e}, their places by {found.places_off:.4f} pixel; "
        f"{found.distinct} distinct samples, {found.sampled:.2f} traced a pixel"
    )
    return Figure(
        mode,
        text,
        {
            "columns": found.columns.weights.tolist(),
            "rows": found.rows.weights.tolist(),
            "expected_columns": weights.tolist(),
            "expected_rows": pattern.columns(1)[1].tolist(),
            "column_places": found.columns.places.tolist(),
            "row_places": found.rows.places.tolist(),
            "expected_column_places": places.tolist(),
            "expected_row_places": pattern.columns(1)[0].tolist(),
            "samples": found.samples.ravel().tolist(),
            "distinct_samples": found.distinct,
            "expected_distinct_samples": len(np.unique(np.round(pattern.samples[:, :2], 9), axis=0)),
            "samples_per_pixel": found.sampled,
            "weights_off": found.weights_off,
            "places_off": found.places_off,
            "between_columns": max(found.columns.rest, found.rows.rest),
        },
    )


def weighted(name: str, renderer: str, patterns: Mapping[str, Pattern], expected: str, means: Sequence[str]) -> Inquiry:
    """Whether each mode has its pattern. means: what it means where all have, and where some have not."""
    shots = {f"{mode}, edges": Shot(renderer, mode, Edges()) for mode in patterns}
    shots |= {f"{mode}, corners": Shot(renderer, mode, pattern.chart) for mode, pattern in patterns.items()}

    def judge(shown: Mapping[str, Shown]) -> Finding:
        found = {
            mode: measured(pattern, shown[f"{mode}, edges"], shown[f"{mode}, corners"])
            for mode, pattern in patterns.items()
        }
        holds = all(each.holds for each in found.values())
        figures = tuple(_figure(mode, patterns[mode], each) for mode, each in found.items())
        return Finding(name, figures, expected, holds, means[0] if holds else means[1])

    return Inquiry(name, shots, judge)
