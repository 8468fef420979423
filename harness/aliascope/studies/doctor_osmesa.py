"""What `aliascope doctor` asks of OSMesa beyond what it asks of every renderer: its samples, its grid of corners."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from aliascope.native import raster
from aliascope.renderers.osmesa import CENTRE, EIGHT
from aliascope.studies.doctor_charts import Edges, Staircase, Star
from aliascope.studies.doctor_findings import Figure, Finding, Inquiry, Shot, Shown
from aliascope.studies.doctor_general import centres, float32_step, levels, repeats
from aliascope.studies.doctor_patterns import Pattern, measured

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
    modes = {"msaa:n=4": (CENTRE,), "msaa:n=8": EIGHT}

    def patterns() -> dict[str, Pattern]:
        at = raster.sample_positions()
        made = {}
        for mode, moves in modes.items():
            moved = np.concatenate([at + np.array(move) - 0.5 for move in moves])
            made[mode] = Pattern(np.column_stack([moved, np.full(len(moved), 1.0 / len(moved))]))
        return made

    found = patterns()
    shots = {f"{mode}, edges": Shot(NAME, mode, Edges()) for mode in modes}
    shots |= {f"{mode}, corners": Shot(NAME, mode, pattern.chart) for mode, pattern in found.items()}

    def judge(shown: Mapping[str, Shown]) -> Finding:
        figures, holds = [], True
        for mode, pattern in found.items():
            seen = measured(pattern, shown[f"{mode}, edges"], shown[f"{mode}, corners"])
            # Each sample by itself: in which row and column of the corners' differences a weight is found.
            across, down = pattern.columns(0)[0], pattern.columns(1)[0]
            said = pattern.samples[np.lexsort(pattern.samples[:, :2].T[::-1])]
            places = [
                (
                    float(seen.columns.places[np.searchsorted(across, x)]),
                    float(seen.rows.places[np.searchsorted(down, y)]),
                )
                for x, y in np.round(said[:, :2], 9)
            ]
            text = " ".join(f"({x:z.3f},{y:z.3f})" for x, y in places)
            holds = holds and seen.holds and seen.distinct == len(said)
            figures.append(
                Figure(
                    mode,
                    f"{text}\n{seen.distinct} distinct samples of weight 1/{len(said)}, "
                    f"within {seen.places_off:.4f} pixel of where OpenGL says",
                    {
                        "x": [x for x, _ in places],
                        "y": [y for _, y in places],
                        "said_x": said[:, 0].tolist(),
                        "said_y": said[:, 1].tolist(),
                        "distinct_samples": seen.distinct,
                        "weights_off": seen.weights_off,
                        "places_off": seen.places_off,
                    },
                    "pixel",
                )
            )
        return Finding(
            name,
            tuple(figures),
            "where OpenGL says, one in each row and column, all of one weight",
            holds,
            "msaa is the rotated grid that it is named for, so its errors are that pattern's."
            if holds
            else "The samples do not lie where OpenGL says: msaa is another pattern than the one it is compared as.",
        )

    return Inquiry(name, shots, judge)


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
