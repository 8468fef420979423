"""A small report with everything that a page has to bear: a failure, an empty cell, a hostile name, a NaN."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from aliascope.records import (
    EmptyCell,
    Estimate,
    Failure,
    MetricInfo,
    ModeRow,
    Pixels,
    Probe,
    ProbeLimits,
    ReportData,
    SceneSection,
)

WIDTH, HEIGHT = 40, 30
MARK = (7, 5)
"""(x, y) of a pixel whose values are known: see `pictures_of`."""
BRIGHT, DARK, NOT_A_NUMBER = (20, 11), (21, 12), (3, 28)
HOSTILE = "</script><script>window.hacked = 1</script><img src=x onerror='window.hacked = 2'>"
HEADLINE = "To reach RMSE 0.01 over these 3 scenes: embree 0.02 s; osmesa cannot (its best is 0.03)."
FILTERED = "zone-plate, mitchell"
"""A scene under another filter: its name has a comma and a space, and its modes are of no other scene."""
STRUCTURES = {"embree": -0.0012, "povray": 0.456, "osmesa": 0.0312}
METRICS = {
    "rmse": MetricInfo("RMSE", "less"),
    "bias": MetricInfo("bias", "zero"),
    "psnr": MetricInfo("PSNR", "more", unit="dB"),
    "max": MetricInfo("largest |error|", "less"),
    "flip": MetricInfo("FLIP", "less"),
    "sharpness": MetricInfo("sharpness", "more"),
    "structure": MetricInfo("structure", "less", signed=True),
}
"""Those of the project, and one that the page cannot know: of sharpness, more is better."""
MODES = (
    # renderer, mode, label, family, samples a pixel, CPU seconds, noise
    ("embree", "uniform:n=4", "uniform halton, n=4", "uniform halton", 4.0, 0.004, 0.08),
    ("embree", "uniform:n=64", "uniform halton, n=64", "uniform halton", 64.0, 0.05, 0.005),
    ("povray", "am2:depth=3", "am2, depth=3", "am2", 9.25, 0.9, 0.02),
    ("osmesa", "msaa:n=4", "msaa, n=4", "msaa", 4.0, 0.001, 0.1),
)


def reference_of(rng: np.random.Generator) -> Pixels:
    """Stripes of slanted coverage: smooth edges between two colours, as renderers make them."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    coverage = np.clip((x * 0.83 + y * 0.41) % 9.7 - 3.1, 0.0, 1.0)[..., np.newaxis]
    return (coverage * [0.8, 0.6, 0.4] + 0.1 + 0.01 * rng.random((HEIGHT, WIDTH, 1))).astype(np.float32)


def picture_of(reference: Pixels, noise: float, rng: np.random.Generator) -> Pixels:
    """The reference with noise, but for three pixels: MARK has known values, BRIGHT is 3 above it, DARK is 3 below."""
    pixels = (reference + rng.normal(0.0, noise, reference.shape)).astype(np.float32)
    pixels[MARK[1], MARK[0]] = (1.0 / 3.0, 1.2345678e-5, 0.1 + noise)
    pixels[BRIGHT[1], BRIGHT[0]] = reference[BRIGHT[1], BRIGHT[0]] + 3.0
    pixels[DARK[1], DARK[0]] = reference[DARK[1], DARK[0]] - 3.0
    return pixels


def scene_of(name: str, title: str, shows: str, seed: int) -> SceneSection:
    rng = np.random.default_rng(seed)
    reference = reference_of(rng)
    rows = []
    for renderer, mode, label, family, spp, seconds, noise in MODES:
        if name == "zone-plate" and mode == "uniform:n=4":
            continue
        pixels = picture_of(reference, noise, rng)
        rmse = noise * (1.0 + 0.1 * seed)
        metrics = {
            "rmse": Estimate(rmse, 0.03 * rmse),
            "bias": Estimate(-0.001, None),
            "psnr": Estimate(-20.0 * math.log10(rmse), 0.2),
            "max": Estimate(float("inf")),
            "flip": Estimate(None),
            "sharpness": Estimate(3.0 - noise),
            "structure": Estimate(STRUCTURES[renderer], 0.01 if renderer == "embree" else None),
        }
        seed_pictures = 4 if renderer == "embree" else 1
        time = Estimate(seconds, 0.04 * seconds if renderer == "embree" else None)
        quantum = 1.0 / 65535.0 if renderer == "povray" else 0.0
        rows.append(ModeRow(renderer, mode, label, family, spp, time, metrics, seed_pictures, pixels, quantum))
    if name == "edge":
        rows[2].pixels[NOT_A_NUMBER[1], NOT_A_NUMBER[0]] = np.nan
    reason = "adaptive passes need a <lens>"
    empty = (EmptyCell(name, "embree", "uniform:n=4", reason),) if name == "zone-plate" else ()
    return SceneSection(name, title, shows, reference, "exact (polygons), error below 6e-08", tuple(rows), empty)


def filtered() -> SceneSection:
    """Drawn by one renderer: without an error, and off by the same everywhere."""
    scene = scene_of(FILTERED, "Zone plate, filtered with mitchell", "Where moiré begins.", 3)
    reference = np.round(scene.reference * 256.0) / np.float32(256.0)  # so that the constant is the same to the bit
    exact, constant = reference.copy(), reference + np.float32(0.125)
    names = ("uniform:filter=mitchell,n=4", "uniform:filter=mitchell,n=64")
    rows = tuple(
        replace(row, mode=mode, label=mode, family="uniform halton mitchell", pixels=pixels)
        for row, mode, pixels in zip(scene.rows, names, (exact, constant), strict=False)
    )
    return replace(scene, reference=reference, rows=rows, filter="mitchell")


def report_data() -> ReportData:
    """Four scenes, three renderers; the third scene has a hostile name, title and sentence, the fourth a filter."""
    return ReportData(
        title="aliascope compare, quick profile, chosen scenes and modes",
        started="2026-12-01T14:03:22+00:00",
        wall_seconds=221.4,
        pictures=27,
        reused=3,
        headlines=(HEADLINE, "Error falls as N^-0.74 & more."),
        scenes=(
            scene_of("edge", "Slanted edges", "Whether an edge is as smooth as it can be.", 0),
            scene_of("zone-plate", "Zone plate", "Where moiré begins.", 1),
            scene_of(HOSTILE, HOSTILE, HOSTILE, 2),
            filtered(),
        ),
        failures=(Failure("edge", "povray", "am2:depth=9", f"povray was killed {HOSTILE}", "aliascope render edge"),),
        machine={"processor": "a test", HOSTILE: HOSTILE},
        versions={"aliascope": "0.1.0"},
        metrics=METRICS,
        skipped={"cycles": "not installed"},
        probes=(
            Probe("cycles", "path", False, reason="not there: not installed"),
            Probe("povray", "am1:depth=9,jitter=0", False, reason=f"its probe failed: {HOSTILE}"),
            Probe("osmesa", "accumulate:n=256", False, (0.0312, -0.00004), 1.00123, 0.99871, 0.00123),
            Probe("embree", "uniform:n=256", True, (-0.0031, 0.00002), 1.0000000231, 1.0000000134, 1.8e-8),
        ),
        probe_limits=ProbeLimits(0.01, 1e-4),
    )
