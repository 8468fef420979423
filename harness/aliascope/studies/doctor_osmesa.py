"""What `aliascope doctor` asks of OSMesa beyond what it asks of every renderer: its samples, its grid of corners."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from aliascope.geometry import Array
from aliascope.native import raster
from aliascope.renderers.osmesa import CENTRE, EIGHT
from aliascope.studies.doctor_charts import Edges, Staircase, Star
from aliascope.studies.doctor_findings import Figure, Finding, Inquiry, Shot, Shown
from aliascope.studies.doctor_general import RESOLUTION, centres, float32_step, levels, repeats
from aliascope.studies.doctor_patterns import PLACE_LIMIT, Measured, Pattern, measured

NAME = "osmesa"

FORMATS = {
    "float32": (1.0, float32_step(0.7)),
    "float32, bright": (1000.0, float32_step(700.0)),
}

BITS = 8
"""Of a pixel, on which grid llvmpipe puts corners."""


def inquiries() -> list[Inquiry]:
    modes = ("none", "msaa:n=4", "msaa:n=8", "accumulate:n=16,sampler=regular", "accumulate:n=256,sampler=regular")
    return [
        centres(NAME, dict.fromkeys(modes, Edges())),
        *levels(NAME, "none", FORMATS),
        _limits(),
        *([_samples()] if raster.limits().max_samples >= raster.MULTISAMPLES else []),
        _corners(),
        repeats(NAME, dict.fromkeys(("none", "msaa:n=4", "msaa:n=8", "accumulate:n=16"), Star()), own_threads=True),
    ]


def _limits() -> Inquiry:
    name = "what OpenGL says"

    def judge(shown: Mapping[str, Shown]) -> Finding:
        found = raster.limits()
        holds = found.samples == raster.MULTISAMPLES and found.subpixel_bits >= BITS
        return Finding(
            name,
            (
                Figure("GL_MAX_SAMPLES", str(found.max_samples), {"max_samples": found.max_samples}),
                Figure("GL_SAMPLES of a buffer that was asked for 4", str(found.samples), {"samples": found.samples}),
                Figure("GL_SUBPIXEL_BITS", str(found.subpixel_bits), {"subpixel_bits": found.subpixel_bits}),
            ),
            f"a buffer of {raster.MULTISAMPLES} samples, and {BITS} bits or more",
            holds,
            "Multisampling has 4 samples a pass; msaa:n=8 is two passes, and any other count is accumulate's."
            if holds
            else "This OpenGL has other samples than the modes are made for: msaa is refused, or is another pattern.",
        )

    return Inquiry(name, {}, judge)


def _samples() -> Inquiry:
    """Where an edge finds the samples of multisampling, and where OpenGL says they are."""
    name = "samples of msaa"
    at = raster.sample_positions()
    patterns = {"msaa:n=4": _moved(at, (CENTRE,)), "msaa:n=8": _moved(at, EIGHT)}
    shots = {f"{mode}, edges": Shot(NAME, mode, Edges()) for mode in patterns}
    shots |= {f"{mode}, corners": Shot(NAME, mode, pattern.chart) for mode, pattern in patterns.items()}

    def judge(shown: Mapping[str, Shown]) -> Finding:
        figures, holds = [], True
        for mode, pattern in patterns.items():
            found = measured(pattern, shown[f"{mode}, edges"], shown[f"{mode}, corners"])
            holds = holds and found.holds and found.distinct == len(pattern.samples)
            figures.append(_sample_figure(mode, pattern, found))
        return Finding(
            name,
            tuple(figures),
            f"where OpenGL says within {PLACE_LIMIT:.3f} pixel (phases resolve {RESOLUTION:.3f}), all of one weight",
            holds,
            "msaa is the rotated grid that it is named for, so its errors are that pattern's."
            if holds
            else "The samples do not lie where OpenGL says: msaa is another pattern than the one it is compared as.",
        )

    return Inquiry(name, shots, judge)


def _moved(at: Array, moves: tuple[tuple[float, float], ...]) -> Pattern:
    """The samples of a pass (n, 2), in passes moved so; see native.raster.Passes."""
    moved = np.concatenate([at + np.array(move) - 0.5 for move in moves])
    return Pattern(np.column_stack([moved, np.full(len(moved), 1.0 / len(moved))]))


def _sample_figure(mode: str, pattern: Pattern, found: Measured) -> Figure:
    """Each sample at the column and the row in which corners find it."""
    said = pattern.samples[np.argsort(pattern.samples[:, 0])]
    x, y = (
        columns.places[np.searchsorted(pattern.columns(axis)[0], np.round(said[:, axis], 9))]
        for axis, columns in enumerate((found.columns, found.rows))
    )
    places = " ".join(f"({right:z.3f},{down:z.3f})" for right, down in zip(x, y, strict=True))
    return Figure(
        mode,
        f"{places}\n{found.distinct} distinct samples of weight 1/{len(said)}, "
        f"within {found.places_off:.4f} pixel of where OpenGL says",
        {
            "x": x.tolist(),
            "y": y.tolist(),
            "said_x": said[:, 0].tolist(),
            "said_y": said[:, 1].tolist(),
            "distinct_samples": found.distinct,
            "weights_off": found.weights_off,
            "places_off": found.places_off,
        },
        "pixel",
    )


def _corners() -> Inquiry:
    name = "grid of corners"
    chart = Staircase()
    mode = "none"

    def judge(shown: Mapping[str, Shown]) -> Finding:
        places = np.unique(chart.places(shown[mode].pixels))
        step = float(np.median(np.diff(places))) if len(places) > 1 else math.nan
        bits = -math.log2(step) if step > 0.0 else math.nan
        text = f"1/{1.0 / step:g} pixel, {bits:g} bits" if step > 0.0 else f"coarser than 1/{1.0 / chart.span:g} pixel"
        holds = bits >= BITS
        return Finding(
            name,
            (Figure(mode, text, {"step": step, "bits": bits}, "pixel"),),
            f"1/{2**BITS} pixel, {BITS} bits, or finer",
            holds,
            "An edge of one pass lies up to 1/512 pixel off, as no other renderer's does; many passes average that out."
            if holds
            else "Corners lie on another grid than the one that OSMesa is granted where renderers are held to agree.",
        )

    return Inquiry(name, {mode: Shot(NAME, mode, chart)}, judge)
