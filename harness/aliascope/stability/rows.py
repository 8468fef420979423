"""Rows of the map for a renderer: one probe for each extreme of geometry, of the subjects whose pictures are known."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import partial

from aliascope.renderers.base import Renderer
from aliascope.stability import edges, subjects
from aliascope.stability.records import NEVER, Probe
from aliascope.stability.subjects import BOUND, QUANTUM, Subject


def _tens(first: int, last: int, step: int = 1) -> tuple[float, ...]:
    return tuple(10.0**power for power in range(first, last + (1 if step > 0 else -1), step))


@dataclass(frozen=True)
class Column:
    """A subject with the levels of the map, and those that a test can afford. grid: whether 16 samples a pixel are held
    against areas, else one against what its ray meets."""

    subject: Callable[[float], Subject]
    levels: tuple[float, ...]
    quick: tuple[float, ...]
    grid: bool = True


COLUMNS: Mapping[str, Column] = {
    "far": Column(subjects.far, _tens(0, 12), (1e9,)),
    "scaled": Column(subjects.resized, _tens(0, -12, -2) + _tens(2, 12, 2), (1e-9, 1e9)),
    "depth-range": Column(subjects.depth_range, _tens(0, 12), (1e6,), grid=False),
    "sliver": Column(subjects.sliver, _tens(0, 12), (1e9,)),
    "coplanar": Column(subjects.coplanar, _tens(0, -12, -1), (1e-6,), grid=False),
    "grazing": Column(subjects.grazing, _tens(1, -12, -1), (1e-6,)),
    "dense": Column(subjects.dense, _tens(0, 6), (1e2,)),
    "narrow": Column(subjects.narrow, (40.0, *_tens(1, -6, -1)), (1e-6,)),
    "wide": Column(subjects.wide, (90.0, *_tens(1, -4, -1)), (1e-3,)),
    "shadow": Column(subjects.shadow, _tens(0, -12, -1) + _tens(1, 12), (1e-9, 1e9), grid=False),
}


@dataclass(frozen=True)
class Row:
    """A component of the map: a renderer, in its modes of a grid of 16 samples and of one. notes: by extreme, of what
    breaks. fewer: levels in place of those of COLUMNS, where those take too long. excused: extremes at which what
    breaks is the renderer's own arithmetic, and nothing compensates for it. refused: the levels
    from which on it may decline, none at other extremes. quick: whether tests run it."""

    component: str
    renderer: Renderer
    grid: str
    single: str
    notes: Mapping[str, str]
    fewer: Mapping[str, tuple[float, ...]]
    excused: Collection[str]
    refused: Mapping[str, float]
    quick: bool = True


def probes_of(row: Row) -> list[Probe]:
    """Those of COLUMNS, and of edges beside samples."""
    found = []
    for extreme, column in COLUMNS.items():
        made = Probe(
            row.component,
            "renderer",
            extreme,
            "RMSE over that of exact samples" if column.grid else "RMS of radiance",
            "exact areas of polygons" if column.grid else "what exact rays meet",
            1.0 if column.grid else QUANTUM,
            1.1 if column.grid else BOUND,
            row.fewer.get(extreme, column.levels),
            partial(_error, row, column),
            column.quick if row.quick else (),
            row.notes.get(extreme, ""),
            extreme in row.excused,
            refuses_from=row.refused.get(extreme, NEVER),
        )
        found.append(made)
    beside = edges.probes_of(row.component, row.renderer, row.single, row.notes, row.excused, row.quick)
    return [*found, *beside]


def _error(row: Row, column: Column, at: float) -> float:
    subject = column.subject(at)
    mode = row.grid if column.grid else row.single
    error = subjects.rms(subjects.picture(row.renderer, mode, subject.scene) - subject.truth)
    return error if subject.own is None else error / subject.own
