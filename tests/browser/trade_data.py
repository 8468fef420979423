"""A report whose modes have draws and times: two scenes, families of three renderers, knobs, a loaded machine."""

from __future__ import annotations

import math

import numpy as np

from aliascope.records import Estimate, MetricInfo, ModeRow, Noise, Pixels, ReportData, SceneSection

WIDTH, HEIGHT = 24, 16
COUNTS = (1, 4, 16, 64, 256)
NOISE = Noise(40, 0.0312, 0.081, 0.034, 1.9, True, "The job of calibration took up to 1.9 times as long as usual.")


def row(
    renderer: str,
    mode: str,
    family: str,
    settings: dict[str, str],
    spp: float,
    seconds: float,
    rmse: float,
    reference: Pixels,
) -> ModeRow:
    """One mode: three draws about an RMSE, 2 % apart, and three times, 1 % apart."""
    times = tuple(seconds * factor for factor in (0.99, 1.0, 1.01))
    errors = tuple(rmse * factor for factor in (0.98, 1.0, 1.02))
    rng = np.random.default_rng(len(mode) + int(1e6 * rmse))
    noise = rng.normal(0.0, rmse, (*reference.shape[:2], 1))
    return ModeRow(
        renderer,
        mode,
        f"{family}, n={spp:g}",
        family,
        spp,
        Estimate(seconds, 0.006 * seconds, (0.98 * seconds, 1.02 * seconds)),
        {"rmse": Estimate(rmse, 0.012 * rmse), "psnr": Estimate(-20.0 * math.log10(rmse), 0.1)},
        3,
        (reference + noise).astype(np.float32),
        seconds=times,
        draws={"rmse": errors, "psnr": tuple(-20.0 * math.log10(error) for error in errors)},
        deterministic=renderer == "osmesa",
        samples=int(spp * WIDTH * HEIGHT),
        rays={"camera": int(spp * WIDTH * HEIGHT), "shadow": int(spp * WIDTH * HEIGHT)} if renderer != "osmesa" else {},
        settings=settings,
    )


def scene(name: str, hardness: float) -> SceneSection:
    """Errors of `hardness` at one sample, which fall as n^-0.75 and n^-0.5; osmesa's stay."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    reference = np.repeat((0.2 + 0.5 * (x > y))[..., np.newaxis], 3, axis=2).astype(np.float32)
    rows = []
    for sampler, power, cost in (("sobol", 0.75, 1.0), ("random", 0.5, 0.9)):
        for n in COUNTS:
            given = {"n": str(n), "sampler": sampler}
            spec = f"uniform:n={n},sampler={sampler}"
            seconds = 1e-4 * cost * n * (1.0 + 0.1 * hardness)
            error = hardness * n**-power
            rows.append(row("embree", spec, f"uniform {sampler}", given, n, seconds, error, reference))
    for depth, spp, error in ((2, 6.0, 0.05), (3, 9.0, 0.03), (4, 14.0, 0.02)):
        given = {"depth": str(depth), "jitter": "0"}
        rows.append(row("povray", f"am2:depth={depth}", "am2", given, spp, 0.05 * spp, hardness * error, reference))
    for n, error in ((4, 0.1), (8, 0.09)):
        rows.append(row("osmesa", f"msaa:n={n}", "msaa", {"n": str(n)}, n, 3e-3 * n, hardness * error, reference))
    return SceneSection(name, name.title(), f"What {name} shows.", reference, "exact", tuple(rows))


def trade_data() -> ReportData:
    """Two scenes alike but for how hard they are."""
    return ReportData(
        title="aliascope compare",
        started="2026-12-01T14:03:22+00:00",
        wall_seconds=12.0,
        pictures=90,
        reused=0,
        headlines=("Time buys accuracy.",),
        scenes=(scene("edge", 0.4), scene("disc", 0.8)),
        failures=(),
        machine={"processor": "a test"},
        versions={"aliascope": "0.1.0"},
        metrics={"rmse": MetricInfo("RMSE", "less"), "psnr": MetricInfo("PSNR", "more", unit="dB")},
        noise=NOISE,
    )
