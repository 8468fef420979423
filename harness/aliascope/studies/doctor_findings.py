"""What `aliascope doctor` asks of a renderer and what it finds: an inquiry names the pictures that it needs, and makes
one finding of them. Inquiries share pictures, and the pictures are rendered side by side.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from typing import Any, Protocol

from aliascope import renderers
from aliascope.errors import AliascopeError
from aliascope.native import raster
from aliascope.records import Pixels
from aliascope.renderers.base import Renderer, Request
from aliascope.renderers.povray import PovRay
from aliascope.studies.doctor_charts import Chart
from aliascope.workers import Task, Workers

Tell = Callable[[str | None, int, int], None]
Value = float | int | bool | str | Sequence[float]

TIME_LIMIT = 60.0
"""Seconds for one picture; the slowest takes 3 on a machine that has nothing else to do."""


@dataclass(frozen=True)
class Shot:
    """A picture to render. again: tells apart those that should come out alike. tile: POV-Ray's, see PovRay;
    own_threads: llvmpipe's, in a process of its own, see raster.use_own_threads."""

    renderer: str
    mode: str
    chart: Chart
    threads: int = 1
    again: int = 0
    tile: int | None = None
    own_threads: int = 0


@dataclass(frozen=True)
class Shown:
    """What came of a shot; see records.Rendering."""

    pixels: Pixels
    quantum: float
    samples_per_pixel: float


@dataclass(frozen=True)
class Figure:
    """What was measured in one mode, or format: `values` by their names, in `unit`; `text` for people, of one
    line or more."""

    label: str
    text: str
    values: Mapping[str, Value]
    unit: str = ""


@dataclass(frozen=True)
class Finding:
    """One convention, measured. `holds`: whether it is as expected; `needed`: whether comparisons rest on that, so that
    a deviation is a failure. `means`: a sentence on what it means for a comparison."""

    name: str
    figures: tuple[Figure, ...]
    expected: str
    holds: bool
    means: str
    needed: bool = True

    @property
    def failed(self) -> bool:
        return self.needed and not self.holds

    @property
    def document(self) -> dict[str, Any]:
        """What JSON can hold: null for what is no number."""
        figures = [
            {**asdict(each), "values": {name: _finite(value) for name, value in each.values.items()}}
            for each in self.figures
        ]
        return {**asdict(self), "figures": figures, "status": self.status}

    @property
    def status(self) -> str:
        """In a word: what is not needed is a property of the renderer, good to know."""
        if not self.needed:
            return "property" if self.holds else "changed"
        return "holds" if self.holds else "DEVIATES"


@dataclass(frozen=True)
class Inquiry:
    """The pictures that a finding needs, and how it is made of them."""

    name: str
    shots: Mapping[str, Shot]
    judge: Callable[[Mapping[str, Shown]], Finding]


class _Pool(Protocol):
    def begin(self, task: Callable[..., Any], arguments: Sequence[Any], time_limit: float) -> Task[Any]: ...


def render(shot: Shot) -> Shown:
    """Runs in a worker process."""
    if shot.own_threads:
        raster.use_own_threads(shot.own_threads)
    found: Renderer = renderers.find(shot.renderer) if shot.tile is None else PovRay(shot.tile)
    mode = renderers.mode_of(found, shot.mode)
    made = found.render(
        Request(shot.chart.scene(), *shot.chart.size, mode, threads=shot.threads, time_limit=TIME_LIMIT)
    )
    return Shown(made.pixels, made.quantum, made.cost.samples_per_pixel)


def answers(inquiries: Sequence[Inquiry], workers: _Pool, tell: Tell) -> list[Finding]:
    """The findings, in the order of the inquiries. A picture that fails fails those that need it, and no others."""
    shots = list(dict.fromkeys(shot for inquiry in inquiries for shot in inquiry.shots.values()))
    with ExitStack() as stack:
        alone: dict[int, _Pool] = {0: workers}
        for count in sorted({shot.own_threads for shot in shots} - {0}):
            alone[count] = stack.enter_context(Workers(1))
        begun = {shot: alone[shot.own_threads].begin(render, [shot], TIME_LIMIT) for shot in shots}
        made: dict[Shot, Shown | AliascopeError] = {}
        for done, shot in enumerate(shots):
            tell(f"{shot.renderer}  {shot.mode}", done, len(shots))
            try:
                made[shot] = begun[shot].result()
            except AliascopeError as error:
                made[shot] = error
    tell(None, len(shots), len(shots))
    return [_answer(inquiry, made) for inquiry in inquiries]


def _answer(inquiry: Inquiry, made: Mapping[Shot, Shown | AliascopeError]) -> Finding:
    shown: dict[str, Shown] = {}
    for label, shot in inquiry.shots.items():
        found = made[shot]
        if isinstance(found, AliascopeError):
            return Finding(inquiry.name, (), "a picture", False, f"Not measured: {label}: {found}.")
        shown[label] = found
    try:
        return inquiry.judge(shown)
    except AliascopeError as error:
        return Finding(inquiry.name, (), "an answer", False, f"Not measured: {error}.")


def _finite(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def within(value: float, limit: float) -> bool:
    """Whether the magnitude is, and is a number."""
    return math.isfinite(value) and abs(value) <= limit
