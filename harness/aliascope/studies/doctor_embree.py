"""What `aliascope doctor` asks of Embree and the tracer on it beyond what it asks of every renderer: how it traces, and
how wide its filters are.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from aliascope.native import filters, tracer
from aliascope.studies.doctor_charts import Chart, Edges, Levels, Star
from aliascope.studies.doctor_findings import Figure, Finding, Inquiry, Shot, Shown
from aliascope.studies.doctor_general import centres, float32_step, levels, repeats

NAME = "embree"

FORMATS = {
    "float32": (1.0, float32_step(0.7)),
    "float32, bright": (1000.0, float32_step(700.0)),
}

INSTRUCTIONS = {4: "SSE", 8: "AVX", 16: "AVX-512"}

FILTERS = ("box", "tent", "gaussian", "mitchell", "catmull-rom")
"""Those that reach 2 pixels at most."""

FILTER_SAMPLES = 256

FILTER_LIMIT = 0.002
"""Square pixels: a pixel's 16 columns of samples take (1/16)^2 / 12 = 3.3e-4 off a second moment, or add it."""


def inquiries() -> list[Inquiry]:
    modes = (
        *("uniform:n=1,sampler=regular", "uniform:n=16,sampler=regular", "uniform:n=256"),
        "uniform:n=64,sampler=regular,filter=mitchell",
    )
    repeated: dict[str, Chart] = dict.fromkeys(
        ("uniform:n=16", "uniform:n=16,filter=mitchell", "adaptive:n=64", "adaptive:n=64,method=mitchell"), Star()
    )
    return [
        centres(NAME, {mode: Edges(cell=12 if "filter" in mode else 8) for mode in modes}),
        *levels(NAME, "uniform:n=1,sampler=regular", FORMATS),
        _filters(),
        _kernel(),
        repeats(NAME, repeated),
    ]


def _kernel() -> Inquiry:
    name = "kernel"

    def judge(shown: Mapping[str, Shown]) -> Finding:
        chart = Levels((1.0,))
        found = tracer.Tracer(chart.scene(), chart.size).kernel
        compiled = tracer.embree_version()
        holds = found.robust and found.version == compiled
        return Finding(
            name,
            (
                Figure(
                    "version",
                    f"{found.version}, compiled with {compiled}",
                    {"loaded": found.version, "compiled": compiled},
                ),
                Figure("packets", f"of {found.packet} rays", {"packet": found.packet}),
                Figure(
                    "instructions",
                    f"{INSTRUCTIONS[found.native]}, {found.native} rays at a time",
                    {"native": found.native, "isa": INSTRUCTIONS[found.native]},
                ),
                Figure("robust", "on" if found.robust else "off", {"robust": found.robust}),
            ),
            "the version that it was compiled with, and robust, so that no ray slips between triangles",
            holds,
            "Another machine's instructions may round otherwise: its pictures agree within that, not to the bit."
            if holds
            else "Rays may slip between triangles, or the library is another: pictures are not those of this version.",
        )

    return Inquiry(name, {}, judge)


def _filters() -> Inquiry:
    name = "width of filters"
    chart = Edges(cell=12)
    modes = {each: f"uniform:n={FILTER_SAMPLES},sampler=regular,filter={each}" for each in FILTERS}

    def judge(shown: Mapping[str, Shown]) -> Finding:
        figures, holds = [], True
        for each in FILTERS:
            found = [chart.second_moment(spread) for spread in chart.spreads(shown[each].pixels)]
            expected = _moment_of(each)
            off = max(abs(moment - expected) for moment in found)
            holds = holds and off <= FILTER_LIMIT
            figures.append(
                Figure(
                    each,
                    f"{found[0]:z.4f} in x, {found[1]:z.4f} in y; expected {expected:z.4f}",
                    {"x": found[0], "y": found[1], "expected": expected},
                    "pixel^2",
                )
            )
        return Finding(
            name,
            tuple(figures),
            f"second moments, in square pixels: those of the profiles, within {FILTER_LIMIT:g}",
            holds,
            "Pictures of a filter are judged by references of the same filter."
            if holds
            else "A filter is wider or narrower than its reference's: its blur would count as an error.",
        )

    return Inquiry(name, {each: Shot(NAME, mode, chart) for each, mode in modes.items()}, judge)


def _moment_of(spec: str) -> float:
    """The integral of x^2 times the profile, by the midpoint rule."""
    radius = filters.radius(spec)
    x = radius * ((np.arange(20000) + 0.5) / 10000 - 1.0)
    return float((x * x * filters.evaluate(spec, x)).mean() * 2.0 * radius)
