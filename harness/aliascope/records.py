"""What the stages hand to each other: frozen, and free of behaviour."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.float32]
"""A picture: (height, width, 3) float32, linear RGB, row 0 on top."""
Counts = NDArray[np.uint32]
"""The samples of each pixel: (height, width)."""


@dataclass(frozen=True)
class Cost:
    """What a picture cost.

    `samples` counts all of them; `cpu_seconds` is CPU time of the rendering phase of one picture, on one thread, the
    mean over `repeats` renderings in a row; `wall_seconds` is the same by the clock on the wall. `instructions` are
    those of the rendering phase of one picture, where the processor's counters can be read.
    """

    samples: int
    samples_per_pixel: float
    rays: Mapping[str, int]
    cpu_seconds: float
    wall_seconds: float
    repeats: int = 1
    instructions: float | None = None


@dataclass(frozen=True)
class Rendering:
    """A picture as a renderer gives it. `quantum` is the step of its output, 0 for float.

    `counts` are the samples of each pixel, where they differ: those of adaptive modes; else None.
    """

    pixels: Pixels
    cost: Cost
    quantum: float = 0.0
    counts: Counts | None = None


@dataclass(frozen=True)
class Job:
    """One picture to make and measure. `key` is the hash of everything that the picture depends on."""

    key: str
    scene: str
    scene_path: str
    renderer: str
    mode: str
    width: int
    height: int
    seed: int
    shift: tuple[float, float] = (0.0, 0.0)
    """Pixels to the right and down by which the film is moved (`draws`), and with it the reference."""


@dataclass(frozen=True)
class Machine:
    """A machine that timed pictures elsewhere. `identity` is the same in all of its containers."""

    name: str
    processor: str
    cores: str
    identity: str

    def __str__(self) -> str:
        return f"{self.name} ({self.processor}, {self.cores} cores)"


@dataclass(frozen=True)
class EmptyCell:
    """A renderer and mode that cannot draw a scene, and why."""

    scene: str
    renderer: str
    mode: str
    reason: str


@dataclass(frozen=True)
class Outcome:
    """What became of a job: `status` is "done" or "failed"; a failed one has a `message` and no numbers."""

    job: Job
    status: str
    message: str = ""
    cost: Cost | None = None
    metrics: Mapping[str, float | None] = field(default_factory=dict)
    quantum: float = 0.0
    image: str = ""
    """Path of the picture, relative to the output folder."""
    harness_seconds: float = 0.0
    """Wall time of the job beyond rendering and measuring."""
    processes: int = 1
    """How many jobs ran side by side, on the same machine, while this one was timed."""
    machine: str = ""
    """Which one timed it, where it was not that of the run."""


@dataclass(frozen=True)
class Estimate:
    """A figure and its standard error: None where it is not known, 0 where the figure is exact. `interval`: that of
    95 % where it was found otherwise than by two standard errors."""

    value: float | None
    standard_error: float | None = None
    interval: tuple[float, float] | None = None


@dataclass(frozen=True)
class MetricInfo:
    """What a report says of a metric, and how it orders and plots it.

    `better`: which values are, "zero" for a signed error. `best` is the value of equal pictures where more is better
    and it is finite: plots then show how far from it. `signed`: less is better and the values can be negative.
    `axis` is the title of its axis, where that says more than the label.
    """

    label: str
    better: Literal["less", "more", "zero"]
    unit: str = ""
    best: float | None = None
    signed: bool = False
    axis: str = ""


@dataclass(frozen=True)
class ModeRow:
    """One renderer and mode on one scene, over all its seeds, as the report shows it.

    `mode` is the canonical spec, `label` the same for people to read, with its defaults named.
    `family` groups modes that differ in their sample count alone ("embree uniform sobol:scramble=owen"), for lines in
    plots. `pixels` is the picture of the first seed, `counts` the samples of its pixels, where they differ; `metrics`
    maps "rmse" and the like to their estimates. `p_values` (height, width, 3) are those of the mean of all pictures
    against the reference, where a test made them.

    `cpu_seconds` is the median of the timed runs, `seconds` are these, CPU seconds of one picture each. `draws` maps
    each metric to its value for each picture, draw by draw; `deterministic`: they differ by shifts of the film, not by
    seeds. `samples` and `rays` (by kind) are of one picture, and so are `instructions`. `settings` are the keys of the
    mode's spec with their values, those left out and of inner specs too ("depth": "3", "sampler.scramble": "owen").
    """

    renderer: str
    mode: str
    label: str
    family: str
    samples_per_pixel: float
    cpu_seconds: Estimate
    metrics: Mapping[str, Estimate]
    pictures: int
    pixels: Pixels
    quantum: float = 0.0
    counts: Counts | None = None
    p_values: NDArray[np.float64] | None = None
    seconds: tuple[float, ...] = ()
    draws: Mapping[str, tuple[float | None, ...]] = field(default_factory=dict)
    deterministic: bool = False
    samples: int = 0
    rays: Mapping[str, int] = field(default_factory=dict)
    instructions: float | None = None
    settings: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Noise:
    """How steady the machine was: a fixed job of calibration, run throughout a comparison.

    `seconds` is the median CPU time of the job, `spread` the standard deviation of its times over that, `drift` by how
    much the last quarter of the runs was slower than the first (0.01: 1 %), `slowest` the largest time over the median.
    `loaded`: something else ran on the machine, so that times are not to be trusted; `told` says so, or that it was
    quiet, in one sentence.
    """

    runs: int
    seconds: float
    spread: float
    drift: float
    slowest: float
    loaded: bool
    told: str


@dataclass(frozen=True)
class SceneSection:
    """One scene of the report under one filter. `reference_note` says how the reference was made, how exact it is."""

    name: str
    title: str
    shows: str
    reference: Pixels
    reference_note: str
    rows: tuple[ModeRow, ...]
    empty: tuple[EmptyCell, ...] = ()
    filter: str = "box"


@dataclass(frozen=True)
class Probe:
    """The conventions of a renderer, measured in a mode: how far right and down of where it is an edge is found, in
    pixels; output = gain * input^gamma, fitted; the largest difference of output from input. Without figures, `reason`
    says why there are none."""

    renderer: str
    mode: str
    holds: bool
    centre: tuple[float, float] | None = None
    gain: float | None = None
    gamma: float | None = None
    deviation: float | None = None
    reason: str = ""


@dataclass(frozen=True)
class ProbeLimits:
    """What a renderer is held to: an edge lies within so many pixels of its place, output within so much of input."""

    centre: float
    response: float


@dataclass(frozen=True)
class Failure:
    """A job that failed, and the command that does it again alone."""

    scene: str
    renderer: str
    mode: str
    message: str
    command: str


@dataclass(frozen=True)
class ReportData:
    """All that report.html is made from. `headlines` are sentences, computed from the rows, the most telling first."""

    title: str
    started: str
    wall_seconds: float
    pictures: int
    reused: int
    headlines: tuple[str, ...]
    scenes: tuple[SceneSection, ...]
    failures: tuple[Failure, ...]
    machine: Mapping[str, str]
    versions: Mapping[str, str]
    metrics: Mapping[str, MetricInfo]
    """Of all metrics that the rows have."""
    skipped: Mapping[str, str] = field(default_factory=dict)
    """Renderers that are not there, and why."""
    undrawn: tuple[EmptyCell, ...] = ()
    """The empty cells of scenes that have no section of their own, since nothing drew them."""
    probes: tuple[Probe, ...] = ()
    """Of the renderers that took part."""
    probe_limits: ProbeLimits | None = None
    noise: Noise | None = None
