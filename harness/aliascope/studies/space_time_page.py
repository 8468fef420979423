"""The page of `aliascope space-time`: the verdict, the figures behind it, and what they mean."""

from __future__ import annotations

from collections.abc import Sequence

from aliascope import places
from aliascope.native import samplers
from aliascope.records import Estimate
from aliascope.report import space_time_charts as charts
from aliascope.report.space_time_charts import Mark, Profile
from aliascope.report.teaching import PageTable, Panel, Section, TeachingPage, Value
from aliascope.studies import space_time
from aliascope.studies.mitchell_text import figure
from aliascope.studies.space_time import GROUPS, PLANES, Dealing, Pattern, Row, dealings, interval
from aliascope.studies.space_time_command import MEASURES, Answer, verdicts

DRAWN = (
    Pattern("jittered", "padded"),
    Pattern("cook"),
    Pattern("pan-diagonal"),
    Pattern("mitchell-spacetime"),
    Pattern("jittered", "decorrelated"),
)
"""Those of the point sets and of the profile."""
DRAWN_COUNT = 16
HEADS = {"near": "apart in time", "xy": "D* (x, y)", "xt": "D* (x, t)", "yt": "D* (y, t)", "xyt": "D* (x, y, t)"}


def page_of(found: Answer) -> TeachingPage:
    """All of it."""
    counts = sorted({row.n for row in found.rows if row.reason is None})
    width, height = found.size
    options = found.asked.options
    return TeachingPage(
        title="Near in space, far in time",
        lead=(
            "A sample of a picture in motion has a place in the pixel and a time while the shutter is open. The "
            "lecture asks that samples near each other in space differ greatly in time. Does a picture gain by it?"
        ),
        facts=(
            f"version {places.own_version()}",
            f"scene {found.scene}, {width} × {height}",
            f"{options.pictures} pictures, {options.realisations} realisations of each",
            f"seed {options.seed}",
        ),
        sections=(
            Section("verdict", "What came out", tuple(verdicts(found)), (_dealt_table(found, counts),)),
            Section("sets", "The patterns", (_SETS,), panels=_set_panels(options.seed), columns=5),
            Section("distance", "Time against distance", (_DISTANCE,), panels=_profile_panels(found, counts)),
            Section("error", "Error against time", (_ERROR,), (_ranks_table(found, counts),), _scatters(found, counts)),
            Section("table", "All patterns", (_TABLE,), tuple(_table(found, n) for n in counts)),
            Section("notes", "What this shows", definitions=_notes(found)),
            Section("files", "Files beside this page", files=(("All figures", _FILES),)),
        ),
    )


_FILES = (("space-time.csv", "space-time.csv"), ("space-time.json", "space-time.json"))
_SETS = (
    "One pixel of each, at 16 samples. The number is the sixteenth of the time, from 0 when the shutter opens; x to "
    "the right, y downward. All five have one sample in each cell and one in each sixteenth of the time; they differ "
    "in which cell has which. Each pixel has the tables moved, mirrored and turned at random."
)
_DISTANCE = (
    "How far apart in time pairs of samples are, over the 1/4 of independent times, against their distance in space; 1 "
    "is the mean distance of two neighbours in a grid of the same density. Bars are 95 % intervals. Over 1: farther "
    "apart than chance would have them."
)
_ERROR = (
    "Each pattern's error in the picture against how far apart in time a sample and its nearest neighbour are. Rank "
    "correlations, over all patterns, of the error with that and with the star discrepancy in each plane: -1 where "
    "what is larger always has less error, +1 where it always has more."
)
_TABLE = (
    "By rising error. ± is half of the 95 % interval. A pattern that is not random has none: it is the same always."
)


def _within(estimate: Estimate, count: int) -> Value:
    """The figure, and half of its interval."""
    limits = interval(estimate, count)
    if limits is None:
        return Value("–" if estimate.value is None else f"{estimate.value:.4g}")
    half = 0.5 * (limits[1] - limits[0])
    if half == 0.0:
        return Value(f"{estimate.value:.4g}")
    return Value(figure(estimate), f"±\u00a0{half:.2g}")


def _table(found: Answer, n: int) -> PageTable:
    rows = []
    for row in found.of(n):
        count = found.count(row)
        figures = [row.near, row.moran, *(row.star[name] for name in PLANES)]
        cells = [_within(one, count) for one in figures]
        rows.append((row.pattern.name, (_within(row.rmse, found.asked.options.pictures), *cells)))
    for row in found.refused(n):
        none = Value("–", reason=row.reason or "")
        rows.append((row.pattern.name, (none,) * (len(PLANES) + 3)))
    head = ("pattern", "rmse", HEADS["near"], "correlation", *(HEADS[name] for name in PLANES))
    return PageTable(f"{n} samples a pixel", head, tuple(rows))


def _dealt_table(found: Answer, counts: Sequence[int]) -> PageTable:
    made = {(one.pattern, one.n): one for one in dealings(found.rows)}
    patterns = list(dict.fromkeys(pattern for pattern, _ in made))
    rows = tuple(
        (pattern.name, tuple(cell for n in counts for cell in _dealt_cells(made.get((pattern, n)))))
        for pattern in patterns
    )
    return PageTable(
        "The same places and times, dealt out so that near is far: how far apart in time near samples then are (at "
        "random), and the error over that of dealing at random, with its 95 % interval. Strong: less error.",
        ("pattern", *("apart in time", "error, over") * len(counts)),
        rows,
        tuple((f"{n} samples", 2) for n in counts),
    )


def _dealt_cells(one: Dealing | None) -> tuple[Value, Value]:
    if one is None:
        none = Value("–", reason="there is no such pattern of so many samples")
        return none, none
    limits = f"[{one.interval[0]:.2f}, {one.interval[1]:.2f}]" if one.interval else ""
    near = Value(f"{one.near[0]:.2f}", f"({one.near[1]:.2f})")
    return near, Value(f"{one.ratio:.3f}", limits, strong=one.verdict == "less")


def _ranks_table(found: Answer, counts: Sequence[int]) -> PageTable:
    rows = []
    for measure in MEASURES:
        cells = []
        for n in counts:
            made = found.correlation(n, measure)
            if made is None:
                cells.append(Value("–", reason="of five patterns or more"))
                continue
            low, high = made.interval
            strong = low > 0.0 or high < 0.0
            cells.append(Value(f"{made.value:+.2f}", f"[{low:+.2f}, {high:+.2f}]", strong=strong))
        rows.append((HEADS[measure], tuple(cells)))
    caption = "Rank correlation with the error, and its 95 % interval. Strong: the interval does not hold 0."
    return PageTable(caption, ("of the error with", *(f"{n} samples" for n in counts)), tuple(rows))


def _set_panels(seed: int) -> tuple[Panel, ...]:
    panels = []
    for pattern in DRAWN:
        points = samplers.points(pattern.sampler, DRAWN_COUNT, GROUPS, seed, arrangement=pattern.arrangement)
        panels.append(Panel(charts.times_picture(points, pattern.name), pattern.name))
    return tuple(panels)


def _profile_panels(found: Answer, counts: Sequence[int]) -> tuple[Panel, ...]:
    panels = []
    for n in counts:
        rows = {row.pattern: row for row in found.of(n)}
        drawn = [(i, pattern) for i, pattern in enumerate(DRAWN) if pattern in rows]
        profiles = [Profile(pattern.name, _profile(rows[pattern], found), i) for i, pattern in drawn]
        profiles = [one for one in profiles if one.points]
        if profiles:
            title = f"{n} samples: apart in time, over independent"
            panels.append(Panel(charts.profile_chart(profiles, title, "distance, in units of 1/√N pixel")))
    return tuple(panels)


def _profile(row: Row, found: Answer) -> tuple[tuple[float, float, tuple[float, float] | None], ...]:
    """Bins that some realisations lack are left out: too few pairs are as near."""
    count = found.count(row)
    return tuple(
        ((i + 0.5) * space_time.BIN, one.value, interval(one, count))
        for i, one in enumerate(row.profile)
        if one.value is not None and one.standard_error is not None and one.standard_error < 0.1
    )


def _scatters(found: Answer, counts: Sequence[int]) -> tuple[Panel, ...]:
    series = {"padded": 0, "decorrelated": 2}
    panels = []
    for n in counts:
        marks = [
            Mark(
                row.pattern.name,
                row.near.value or 0.0,
                row.rmse.value or 0.0,
                interval(row.near, found.count(row)),
                interval(row.rmse, found.asked.options.pictures),
                1 if row.pattern.sampler in space_time.TABLES else series.get(row.pattern.arrangement, 4),
            )
            for row in found.of(n)
        ]
        if marks:
            label = "nearest neighbours apart in time"
            panels.append(Panel(charts.scatter_chart(marks, f"{n} samples: rmse of {found.scene}", label)))
    return tuple(panels)


def _notes(found: Answer) -> tuple[tuple[str, str], ...]:
    return (
        (
            "Apart in time",
            "Of each sample of a pixel and the sample nearest to it in the plane, in that pixel or in one of the eight "
            "about it: the difference of their times, around the border, in the mean, over the 1/4 of independent "
            "times. 2 at most. N slots of time that are dealt out at random give N/(N - 1) within a pixel, as no slot "
            "comes twice.",
        ),
        ("Correlation", "Of the times of these pairs, about the middle of the shutter: 0 where they are independent."),
        (
            "D*",
            "The star discrepancy, exact: the largest difference between the share of the points and the volume, over "
            "boxes at the origin. In the plane, in each plane with time, in all three.",
        ),
        (
            "rmse",
            f"Of the picture of {found.scene} against the mean of {space_time.REPLICATES} pictures of "
            f"{space_time.REPLICATE_SAMPLES:,} Owen-scrambled Sobol samples, whose standard error is "
            f"{found.reference.standard_error:.1e}; over pictures with seeds of their own.",
        ),
        (
            "Padded, decorrelated",
            "Padded: the plane and the time have patterns of their own, dealt out to each other at random. "
            "Decorrelated: the same, dealt out so that the k-th sample along a Hilbert curve of the pixel has the time "
            "whose rank is the radical inverse of k, rotated at random.",
        ),
        (
            "Intervals",
            "Student's over realisations or pictures. Of a ratio: by the standard errors of both logarithms, as if the "
            "pictures were independent; they share their places, so it is rather too wide. Of a rank correlation: "
            "Bonett and Wright 2000, as if the patterns were drawn from many.",
        ),
    )
