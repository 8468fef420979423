"""What `aliascope doctor` asks of POV-Ray beyond what it asks of every renderer: the weights of its antialiasing, its
tiles, its lens.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from aliascope.renderers.povray_frames import PICTURE_SHIFT
from aliascope.studies.doctor_charts import BEHIND, Chart, Edges, Shadow, Star
from aliascope.studies.doctor_findings import Figure, Finding, Inquiry, Shot, Shown, within
from aliascope.studies.doctor_general import CENTRE_LIMIT, WHITE, centres, difference, levels, placed, repeats
from aliascope.studies.doctor_patterns import grid_pattern, trapezoid_pattern, weighted

NAME = "povray"

FIXED = "jitter=0,threshold=0"
"""All samples of all pixels, each in its place."""

SMALL_LENS, WIDE_LENS = 0.5, 10.0
"""Radii in pixels: one for a chart in focus; one that blurs a chart out of focus by 2 pixels."""

BLUR = "focal-blur:blur_samples=128,variance=0"
UNCOMPENSATED = f"{BLUR},compensation=off"

LENS_LIMIT = 0.02
"""Of a radius: 128 random rays at each of the phases were seen to leave 0.005 of it."""

FORMATS = {
    "16-bit PNG": (1.0, 1.0 / 65535.0),
    "16-bit PNG, exposure 4": (3.0, 4.0 / 65535.0),
    "half-float EXR": (100.0, 2.0**-4),
}
"""Those that the driver chooses, by the brightest value: its peak, and its step between 0.7 of that and all of it."""

AM1_DEPTHS, AM2_DEPTHS = (2, 3, 4, 9), (1, 2, 3, 4, 5)

TILES = (4, 32)


def inquiries() -> list[Inquiry]:
    sharp = Edges(lens_radius=SMALL_LENS)
    return [
        centres(
            NAME,
            {
                "none": Edges(),
                f"am1:depth=3,{FIXED}": Edges(),
                "am1:depth=9,jitter=1,threshold=0": Edges(),
                f"am2:depth=3,{FIXED}": Edges(),
                "am2:depth=4,jitter=1,threshold=0": Edges(),
                "regular:n=16": Edges(),
                "accumulate:n=16,sampler=regular": Edges(),
                BLUR: sharp,
            },
        ),
        *levels(NAME, "none", FORMATS),
        weighted(
            "weights of am1",
            NAME,
            {f"am1:depth={depth},{FIXED}": grid_pattern(depth, centre=True) for depth in AM1_DEPTHS},
            "d x d centres of cells and the pixel's own, 1/(d*d+1) each: .4 .2 .4 of depth 2, .3 .4 .3 of depth 3",
            (
                "AM1 is no even grid: the ray through the centre stays in the mean, so it is judged as what it is, "
                "d*d+1 samples.",
                "AM1 does not weigh as it is said to: its errors are those of another pattern than the one named.",
            ),
        ),
        weighted(
            "weights of am2",
            NAME,
            {f"am2:depth={depth},{FIXED}": trapezoid_pattern(2 ** (depth - 1)) for depth in AM2_DEPTHS},
            "the trapezoid rule in x and y, (2^(depth-1)+1)^2 distinct samples: 4, 9, 25, 81, 289",
            (
                "Pixels share the samples on their borders, so AM2 traces fewer rays than it has samples: compare it "
                "at the rays that it traced.",
                "AM2 does not weigh as it is said to: its errors are those of another pattern than the one named.",
            ),
        ),
        _independent_of_tiles(),
        _tiles_of_am1(),
        repeats(NAME, _repeated(), note="; light_jitter is kept to one thread, whatever is asked for"),
        _lens(),
    ]


def _repeated() -> dict[str, Chart]:
    star: Chart = Star()
    modes = ("none", "am1", "am1:jitter=0", "am2", "am2:jitter=0", "regular:n=16", "accumulate:n=4")
    return {
        **dict.fromkeys(modes, star),
        "focal-blur": Star(lens_radius=2.0),
        "am1:light_jitter=on": Shadow(),
    }


# --- tiles ------------------------------------------------------------------------------------------------------------


def _tile_shots(modes: tuple[str, ...]) -> dict[str, Shot]:
    return {f"{mode} {tile}": Shot(NAME, mode, Star(), tile=tile) for mode in modes for tile in TILES}


def _tile_figures(modes: tuple[str, ...], shown: Mapping[str, Shown]) -> tuple[list[Figure], list[float]]:
    figures, largest = [], []
    for mode in modes:
        rms, most = difference(*(shown[f"{mode} {tile}"] for tile in TILES))
        text = f"rms {rms:.4f}, largest {most:.4f}" if most > 0.0 else "the same bits"
        figures.append(Figure(mode, text, {"rms": rms, "largest": most}, WHITE))
        largest.append(most)
    return figures, largest


def _independent_of_tiles() -> Inquiry:
    name = "tile size, where it must not count"
    modes = ("none", "am1:threshold=0", "am2", "am2:jitter=0")

    def judge(shown: Mapping[str, Shown]) -> Finding:
        figures, largest = _tile_figures(modes, shown)
        holds = not any(largest)
        return Finding(
            name,
            tuple(figures),
            f"the same bits with tiles of {TILES[0]} and of {TILES[1]} pixels (+BS)",
            holds,
            "These pictures do not depend on how POV-Ray cuts them up; nor does its jitter, which follows the place."
            if holds
            else "How POV-Ray cuts a picture up changes it: pictures compare only between equal tiles.",
        )

    return Inquiry(name, _tile_shots(modes), judge)


def _tiles_of_am1() -> Inquiry:
    name = "tile size in am1"
    modes = ("am1", "am1:jitter=0")

    def judge(shown: Mapping[str, Shown]) -> Finding:
        figures, largest = _tile_figures(modes, shown)
        return Finding(
            name,
            tuple(figures),
            "a difference: a pixel is compared with its left and upper neighbours in the tile alone",
            all(largest),
            f"AM1 with a threshold is compared at tiles of {TILES[1]} (+BS{TILES[1]}, stated in every run); "
            "with another +BS it is another picture."
            if all(largest)
            else "AM1 no longer depends on the size of tiles, and no note of it is needed.",
            needed=False,
        )

    return Inquiry(name, _tile_shots(modes), judge)


# --- the lens ---------------------------------------------------------------------------------------------------------


def _blur_radius(chart: Edges, shown: Shown) -> float:
    """Of the disc that spreads the chart, in pixels: its variance along an axis is radius^2 / 4, the pixel's 1/12."""
    variances = [chart.second_moment(spread) for spread in chart.spreads(shown.pixels)]
    return 2.0 * math.sqrt(max(0.0, float(np.mean(variances)) - 1.0 / 12.0))


def _lens() -> Inquiry:
    """What the compensation of focal-blur makes good."""
    name = "lens of focal-blur"
    sharp, wide = Edges(lens_radius=SMALL_LENS), Edges(cell=12, lens_radius=WIDE_LENS, focus=BEHIND)
    radius = WIDE_LENS * (1.0 - 1.0 / BEHIND)
    shots = {
        "compensated": Shot(NAME, BLUR, wide),
        "as the manual reads": Shot(NAME, UNCOMPENSATED, wide),
        "shift": Shot(NAME, UNCOMPENSATED, sharp),
    }

    def judge(shown: Mapping[str, Shown]) -> Finding:
        ratios = {label: _blur_radius(wide, shown[label]) / radius for label in list(shots)[:2]}
        shift = placed(sharp, shown["shift"])
        found = {"ratio": ratios["as the manual reads"], "right": shift.right, "down": shift.down}
        holds = (
            within(ratios["compensated"] - 1.0, LENS_LIMIT)
            and within(found["ratio"] - 0.5, LENS_LIMIT)
            and all(within(found[way] - PICTURE_SHIFT, CENTRE_LIMIT) for way in ("right", "down"))
        )
        return Finding(
            name,
            (
                Figure(
                    UNCOMPENSATED,
                    f"{found['ratio']:.3f} of the lens; {shift.text}",
                    {"lens": found["ratio"], **shift.values},
                    "pixel",
                ),
                Figure(BLUR, f"{ratios['compensated']:.3f} of the lens", {"lens": ratios["compensated"]}),
            ),
            f"half the diameter, and {PICTURE_SHIFT:g} pixel off, as POV-Ray has it; made good by the compensation",
            holds,
            "focal-blur is compared with its lens and place mended; with compensation=off both count as errors."
            if holds
            else "The compensation of focal-blur does not fit this POV-Ray: its pictures have another lens or place.",
        )

    return Inquiry(name, shots, judge)
