"""Cells and runs of regressions with figures made up, for the tests of what is kept and said of them."""

from __future__ import annotations

import dataclasses
import hashlib

import numpy as np

from aliascope.records import Estimate
from aliascope.regression.records import (
    CellName,
    CellVerdict,
    Check,
    Control,
    Draw,
    Observed,
    Replicate,
    Run,
    WorstPixel,
)

NAMES = ("offset red", "offset green", "offset blue", "gain", "moved right", "moved down", "wider across")
BLOCKS = 48
"""Of a picture of 128 x 96."""


def replicate(seed: int, seeded: bool = True, scale: float = 1.0) -> Replicate:
    rng = np.random.default_rng([seed, seeded])
    shifted = not seeded and seed > 0
    values = [float(value) for value in scale * 1e-3 * rng.standard_normal(len(NAMES) + BLOCKS)]
    squares = rng.gamma(2.0, 1e-4, BLOCKS)
    return Replicate(
        draw=Draw(seed) if seeded else Draw(0, tuple(rng.uniform(0, 1, 2)) if shifted else (0.0, 0.0)),
        sha256=hashlib.sha256(repr((seed, scale)).encode()).hexdigest(),
        coefficients=tuple(values[: len(NAMES)]),
        blocks=tuple(values[len(NAMES) :]),
        rmse=None if shifted else float(np.sqrt(squares.mean())),
        block_squares=() if shifted else tuple(float(square) for square in squares),
        least=float(np.float32(0.0417)),
        largest=float(np.float32(0.9412)),
        not_finite=0,
        outlier=float(rng.uniform(1, 2)),
        samples=786432,
        rays={"primary": 786432},
        cpu_seconds=float(rng.uniform(0.1, 0.2)),
    )


def observed(name: CellName, seeded: bool = True, scale: float = 1.0) -> Observed:
    return Observed(
        name=name,
        judged="reference" if seeded else "blessed",
        scene_digest="5c" * 32,
        size=(128, 96),
        filter="box",
        names=NAMES,
        replicates=tuple(replicate(seed, seeded, scale) for seed in range(16)),
        known=(0.0,) * len(NAMES),
        known_blocks=(0.0,) * BLOCKS,
        scatter=1.23456789123e-05,
        versions={"embree": "3.13.5"},
        metrics={"rmse": Estimate(0.0123456789123, 1e-4), "psnr": Estimate(None)},
        quantum=1 / 65535,
    )


def check(name: CellName, about: str, figure: float, limit: float, **other: object) -> Check:
    passed = figure >= limit if other.get("at_least") else figure <= limit
    return dataclasses.replace(Check(name, "effect", about, figure, limit, "%", passed), **other)  # type: ignore[arg-type]


EDGE = CellName("edge", "embree", "uniform:n=64,sampler=sobol,sampler.scramble=owen")
STAR = CellName("siemens-star", "povray", "am2:depth=3")
GONE = CellName("siemens-star", "osmesa", "msaa:n=4")
CRASHED = CellName("discs", "osmesa", "none")


def verdict(name: CellName, *checks: Check, **other: object) -> CellVerdict:
    word = f"-r {name.renderer} -m {name.mode}"
    made = CellVerdict(
        name,
        checks,
        again=f"aliascope regress {name.scene} {word}",
        bless=f"aliascope regress {name.scene} {word} --bless {name.text} --reason why",
    )
    return dataclasses.replace(made, **other)  # type: ignore[arg-type]


def passing() -> Run:
    """Two cells, all well; one renderer is not there and one cell is empty."""
    fine = observed(EDGE)
    cells = (
        verdict(
            EDGE,
            check(EDGE, "gain", 0.02, 0.13, p_value=0.4, tests=9),
            check(EDGE, "samples", 786432, 786432, unit="", family="cost"),
            check(EDGE, "scatter", 1.1, 0.5, unit="of the blessed", family="variance", at_least=True),
            check(EDGE, "CPU time", 1.7, 1.5, unit="times the blessed", family="time", warning=True),
            observed=fine,
        ),
        verdict(
            STAR, check(STAR, "moved right", 0.0, 0.0031, unit="pixel", p_value=1.0), observed=observed(STAR, False)
        ),
    )
    return Run(
        started="2026-11-23T07:05:12+00:00",
        wall_seconds=61.25,
        revision="f4f130cc513c",
        machine={"processor": "a processor", "cores": "2", "system": "Linux"},
        versions={"embree": "3.13.5"},
        command="aliascope regress edge siemens-star",
        significance=0.001,
        tests=412,
        replicates=16,
        cells=cells,
        controls=(Control("gain of 1 %", EDGE, True, "gain"), Control("one firefly", STAR, True, "outlier")),
        empty=((CellName("terrain", "osmesa", "none"), "OSMesa here does not draw: shadows of meshes"),),
        skipped={"osmesa": "libOSMesa.so.8 is not there"},
    )


def failing(crashed: bool = False) -> Run:
    """One cell that fails, one whose blessed figures are missing, a control that was not caught; or a crash too."""
    run = passing()
    worst = WorstPixel(51, 23, 0, 0.8127, 0.6046)
    wrong = dataclasses.replace(
        run.cells[0],
        checks=(*run.cells[0].checks, check(EDGE, "offset <red> & co", 1.01, 0.13, p_value=3e-12, detail="9 sigma")),
        observed=dataclasses.replace(observed(EDGE), worst=worst),
    )
    cells = (run.cells[1], wrong, verdict(GONE, problem=f"{GONE.text}: no blessed figures"))
    if crashed:
        cells = (*cells, verdict(CRASHED, problem="its process ended by SIGSEGV\x00", failed=True))
    return dataclasses.replace(
        run, cells=cells, controls=(*run.controls, Control("moved right by 1/32 pixel", STAR, False))
    )
