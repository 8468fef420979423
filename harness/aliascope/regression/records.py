"""What a regression run observes, tests and says, from stage to stage: frozen, and free of behaviour."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from aliascope.geometry import Array
from aliascope.records import Estimate, Pixels

Judged = Literal["reference", "blessed"]
"""By what a cell's pictures are judged: the scene's reference, where their expectation is the integral itself; else
what the same mode gave when it was blessed."""


@dataclass(frozen=True)
class CellName:
    """One mode of a renderer on a scene; `mode` is the canonical spec. A pattern of the shell chooses cells by
    "scene/renderer/mode"."""

    scene: str
    renderer: str
    mode: str

    @property
    def text(self) -> str:
        return f"{self.scene}/{self.renderer}/{self.mode}"


@dataclass(frozen=True)
class Draw:
    """What makes one replicate another picture than the next: its seed, for a mode that has one; else a shift of the
    film, (right, down) in pixels."""

    seed: int = 0
    shift: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Replicate:
    """What is kept of one picture of a cell.

    `sha256` is of the pixels as little-endian float32, row by row. `coefficients`: of each template (`templates.py`),
    how much of it there is in picture - reference, in its unit; `blocks`: the mean of picture - reference over each
    block, row by row. Both NaN where a pixel is. `least` and `largest` value of the picture; `not_finite`: pixels that
    are no number, or infinite; `outlier`: how far the most outlying pixel lies from its surroundings (`templates.py`).
    `rmse`: against the reference; None under a shift, which the reference has not.
    """

    draw: Draw
    sha256: str
    coefficients: tuple[float, ...]
    blocks: tuple[float, ...]
    rmse: float | None
    block_squares: tuple[float, ...]
    """The mean of (picture - reference)^2 over each block; empty under a shift."""
    least: float
    largest: float
    not_finite: int
    outlier: float
    samples: int
    rays: Mapping[str, int]
    cpu_seconds: float


@dataclass(frozen=True)
class WorstPixel:
    """Where the mean picture is furthest from what it is judged by, in units of its noise; both values there."""

    x: int
    y: int
    channel: int
    value: float
    expected: float


@dataclass(frozen=True)
class Observed:
    """All replicates of a cell. `names` of the templates, in the order of `coefficients`; `known`: the standard errors
    of the coefficients, and `known_blocks` of the blocks, that come of the reference's own noise, 0 where it is exact.
    `floor_blocks`: the least standard errors of the means of blocks, those of one sample more or less in each picture.
    `scatter`: the variance of a value between replicates, its mean over the picture.

    `first`, `mean`, `p_values`, `worst` are for people: the first picture, the mean of all (of unshifted ones), and
    pixel by pixel the two-sided p-value of Student's test against the reference; None where there are none.
    """

    name: CellName
    judged: Judged
    scene_digest: str
    size: tuple[int, int]
    filter: str
    names: tuple[str, ...]
    replicates: tuple[Replicate, ...]
    known: tuple[float, ...]
    known_blocks: tuple[float, ...]
    scatter: float
    versions: Mapping[str, str]
    metrics: Mapping[str, Estimate] = field(default_factory=dict)
    quantum: float = 0.0
    floor_blocks: tuple[float, ...] = ()
    first: Pixels | None = None
    mean: Array | None = None
    p_values: Array | None = None
    worst: WorstPixel | None = None


@dataclass(frozen=True)
class Blessed:
    """A cell as it was blessed, and where that came from."""

    observed: Observed
    sha256: str
    """Of the digests of all replicates in their order: the hash that blessing shows."""
    revision: str
    machine: Mapping[str, str]
    command: str
    reason: str
    blessed_on: str
    """Date and time, ISO 8601, UTC."""


Family = Literal["effect", "block", "value", "variance", "accuracy", "cost", "time"]


@dataclass(frozen=True)
class Check:
    """One test of a cell: `observed` may be `limit` at most (both in `unit`; at least, where `at_least`).

    `about` says what was tested ("gain", "moved right", "block of pixels from (16, 32)", "samples"); `p_value` where
    the test is a statistical one; `tests`: how many tests this stands for, the worst of them shown. `warning`: it does
    not fail a run.
    """

    name: CellName
    family: Family
    about: str
    observed: float
    limit: float
    unit: str
    passed: bool
    p_value: float | None = None
    tests: int = 1
    at_least: bool = False
    warning: bool = False
    detail: str = ""

    @property
    def headroom(self) -> float | None:
        """1 - observed / limit; of a lower limit above 0, 1 - limit / observed; None where there is none to state."""
        if self.at_least and self.limit > 0.0:
            return 1.0 - self.limit / self.observed if self.observed > 0.0 else None
        upright = self.limit < 0.0 if self.at_least else self.limit > 0.0
        return 1.0 - self.observed / self.limit if upright else None


@dataclass(frozen=True)
class CellVerdict:
    """All checks of one cell; `problem` where there was nothing to test: a reference or blessed figures that are
    missing or of another scene, size or filter; a job that failed (`failed`: it was rendering, exit code 4)."""

    name: CellName
    checks: tuple[Check, ...] = ()
    problem: str = ""
    failed: bool = False
    observed: Observed | None = None
    again: str = ""
    """The command that runs this cell alone."""
    bless: str = ""
    """The command that blesses it."""

    @property
    def passed(self) -> bool:
        return not self.problem and all(check.passed or check.warning for check in self.checks)


@dataclass(frozen=True)
class Control:
    """A defect that was put into a cell on purpose, and whether the run caught it, and by which check."""

    defect: str
    name: CellName
    caught: bool
    by: str = ""
    problem: str = ""


@dataclass(frozen=True)
class Run:
    """What a regression run came to. `tests`: how many statistical tests share `significance`."""

    started: str
    wall_seconds: float
    revision: str
    machine: Mapping[str, str]
    versions: Mapping[str, str]
    command: str
    significance: float
    tests: int
    replicates: int
    cells: tuple[CellVerdict, ...]
    controls: tuple[Control, ...]
    empty: tuple[tuple[CellName, str], ...] = ()
    """Cells that a renderer does not draw, and why."""
    skipped: Mapping[str, str] = field(default_factory=dict)
    """Renderers that are not there, and why."""

    @property
    def passed(self) -> bool:
        return all(cell.passed for cell in self.cells) and all(control.caught for control in self.controls)
