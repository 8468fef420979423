"""A regression run over the scenes of the small report: cells that pass, fail, warn, and have a problem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from aliascope.records import ReportData
from aliascope.regression.records import CellName, CellVerdict, Check, Control, Observed, Run, WorstPixel
from browser.report_data import BRIGHT, HEIGHT, HOSTILE, WIDTH

FAILED = CellName("edge", "povray", "am2:depth=3")
P_VALUE = 3e-7
"""Of the pixel BRIGHT."""


def with_p_values(data: ReportData) -> ReportData:
    """The report with p-values for what embree drew of `edge`: 1 but for BRIGHT, and NaN at (0, 0)."""
    p_values = np.ones((HEIGHT, WIDTH, 3))
    p_values[BRIGHT[1], BRIGHT[0], 1] = P_VALUE
    p_values[0, 0] = np.nan
    scene = data.scenes[0]
    rows = tuple(replace(row, p_values=p_values) if row.renderer == "embree" else row for row in scene.rows)
    return replace(data, title="aliascope regress", headlines=(), scenes=(replace(scene, rows=rows), *data.scenes[1:]))


def _check(name: CellName, about: str, observed: float, limit: float, unit: str = "", **more: object) -> Check:
    found = Check(name, "effect", about, observed, limit, unit, passed=observed <= limit)
    return replace(found, **more)


def _observed(name: CellName, data: ReportData) -> Observed:
    row = next(row for row in data.scenes[0].rows if (row.renderer, row.mode) == (name.renderer, name.mode))
    return Observed(
        name=name,
        judged="blessed" if name.renderer == "povray" else "reference",
        scene_digest="",
        size=(WIDTH, HEIGHT),
        filter="box",
        names=("gain",),
        replicates=(),
        known=(0.0,),
        known_blocks=(),
        scatter=1e-3,
        versions={},
        first=row.pixels,
        p_values=row.p_values,
        worst=WorstPixel(*BRIGHT, 1, 3.5, 0.5),
    )


def run_data(data: ReportData, passed: bool = False) -> Run:
    """A run with a failure, a missing reference with a hostile name, a warning and a control that was caught; `passed`:
    without what fails."""
    fine = CellName("edge", "embree", "uniform:n=64")
    slow = CellName("edge", "osmesa", "msaa:n=4")
    lost = CellName(HOSTILE, "embree", "uniform:n=64")
    cells = (
        CellVerdict(
            FAILED,
            (
                _check(FAILED, "moved right", 0.031, 0.0042, "pixel", p_value=1e-12, tests=8, detail="as if shifted"),
                _check(FAILED, "blocks", 0.0001, 0.002, family="block", p_value=0.3, tests=48),
            ),
            observed=_observed(FAILED, data),
            again="aliascope regress edge -r povray -m am2:depth=3",
            bless="aliascope regress --bless 'edge/povray/am2:depth=3' --reason '...'",
        ),
        CellVerdict(
            fine, (_check(fine, "gain", 0.0002, 0.0011, p_value=0.21, tests=9),), observed=_observed(fine, data)
        ),
        CellVerdict(
            slow,
            (
                _check(slow, "gain", 0.0, 0.001),
                _check(slow, "CPU time", 1.7, 1.5, "times", family="time", warning=True),
            ),
            observed=_observed(slow, data),
        ),
        CellVerdict(
            lost, problem=f"no reference for {HOSTILE}: make it with: aliascope reference x", again="aliascope"
        ),
    )
    return Run(
        started=data.started,
        wall_seconds=100.0,
        revision="abc",
        machine={},
        versions={},
        command="aliascope regress",
        significance=0.001,
        tests=12480,
        replicates=16,
        cells=cells[1:3] if passed else cells,
        controls=(Control("gain 1 %", fine, True, "gain"), Control("one firefly", fine, passed, "", "no outlier")),
    )
