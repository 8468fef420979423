"""What `aliascope space-time` was asked for, and what it answers: as text, JSON, CSV and a page."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from aliascope import scene_io
from aliascope.errors import InvalidInput, Unsupported
from aliascope.native.tracer import DRAWS, Tracer
from aliascope.records import Estimate
from aliascope.report.files import write_text
from aliascope.report.teaching import teaching_page
from aliascope.studies import space_time
from aliascope.studies.progress import progress_bar
from aliascope.studies.space_time import (
    GROUPS,
    PATTERNS,
    PLANES,
    Options,
    RankCorrelation,
    Reference,
    Row,
    dealings,
    interval,
    rank_correlation,
)

MEASURES = ("near", *PLANES)
"""What the error is set beside."""


@dataclass(frozen=True)
class Asked:
    """The options of the command."""

    counts: tuple[int, ...] = space_time.COUNTS
    scene: str = "motion-blur"
    size: tuple[int, int] | None = None
    options: Options = field(default_factory=Options)

    def check(self) -> None:
        """Raises InvalidInput for fewer realisations than an interval takes."""
        if self.options.realisations < 2 or self.options.pictures < 2:
            raise InvalidInput("two realisations and two pictures at least: an interval is of several")


@dataclass(frozen=True)
class Answer:
    """All that was measured. `scene`: its name; `shows`: what it says of itself."""

    asked: Asked
    scene: str
    shows: str
    size: tuple[int, int]
    reference: Reference
    rows: tuple[Row, ...]

    def of(self, n: int) -> list[Row]:
        """Those of n samples that were measured, by rising error."""
        found = [row for row in self.rows if row.n == n and row.reason is None]
        return sorted(found, key=lambda row: row.rmse.value or 0.0)

    def refused(self, n: int) -> list[Row]:
        return [row for row in self.rows if row.n == n and row.reason is not None]

    def correlation(self, n: int, measure: str) -> RankCorrelation | None:
        """Of the errors with `near`, or with the star discrepancy in a plane, over all patterns of n samples."""
        rows = self.of(n)
        return rank_correlation([_measured(row, measure) for row in rows], [row.rmse.value or 0.0 for row in rows])

    def count(self, row: Row) -> int:
        """Realisations of a pattern: 1 where it has no standard error."""
        return self.asked.options.realisations if row.near.standard_error is not None else 1


def _measured(row: Row, measure: str) -> float:
    value = row.near.value if measure == "near" else row.star[measure].value
    assert value is not None
    return value


def answer(asked: Asked) -> Answer:
    """Measures. Raises InvalidInput for a scene that is not of this kind, NotAvailable without Embree."""
    asked.check()
    file = scene_io.load(asked.scene)
    if lacking := sorted(file.scene.features() - DRAWS):
        raise InvalidInput(f"{file.name}: the tracer does not draw: {', '.join(lacking)}")
    if file.scene.needs().groups != GROUPS:
        raise InvalidInput(
            f"{file.name}: a sample of it has {file.scene.needs().groups} dimensions, in groups; patterns of space and "
            "time have (2, 1): something must move while the shutter is open, without a lens or lights with an area"
        )
    size = asked.size or file.scene.view.size
    tracer = Tracer(file.scene, size)
    with progress_bar() as tell:
        reference = space_time.reference_of(tracer, tell)
        rows = []
        jobs = [(pattern, n) for n in sorted(set(asked.counts)) for pattern in PATTERNS]
        for number, (pattern, n) in enumerate(jobs):
            tell(f"{pattern.name}, {n} samples", number, len(jobs))
            try:
                row = space_time.measure_pattern(pattern, n, asked.options)
            except Unsupported as error:
                rows.append(Row(pattern, n, reason=str(error)))
                continue
            rows.append(replace(row, rmse=space_time.picture_error(tracer, reference, pattern, n, asked.options)))
    return Answer(asked, file.name, file.scene.shows, size, reference, tuple(rows))


# --- as JSON and CSV --------------------------------------------------------------------------------------------------


def _figure(estimate: Estimate, count: int) -> dict[str, Any]:
    return {
        "value": estimate.value,
        "standard_error": estimate.standard_error,
        "interval": interval(estimate, count),
    }


def document(found: Answer) -> dict[str, Any]:
    """What --json prints."""
    options = found.asked.options
    return {
        "scene": found.scene,
        "width": found.size[0],
        "height": found.size[1],
        "seed": options.seed,
        "realisations": options.realisations,
        "pictures": options.pictures,
        "confidence": space_time.CONFIDENCE,
        "reference_standard_error": found.reference.standard_error,
        "patterns": [_row_document(found, row) for row in found.rows],
        "rank_correlations": [
            {
                "n": n,
                "measure": measure,
                "value": made.value,
                "interval": made.interval,
                "patterns": made.patterns,
            }
            for n in sorted({row.n for row in found.rows})
            for measure in MEASURES
            if (made := found.correlation(n, measure)) is not None
        ],
        "dealings": [
            {
                "n": one.n,
                "pattern": one.pattern.name,
                "other": one.other.name,
                "near": one.near[0],
                "other_near": one.near[1],
                "rmse_ratio": one.ratio,
                "interval": one.interval,
                "verdict": one.verdict,
            }
            for one in dealings(found.rows)
        ],
        "verdict": verdicts(found),
    }


def _row_document(found: Answer, row: Row) -> dict[str, Any]:
    head: dict[str, Any] = {"sampler": row.pattern.sampler, "arrangement": row.pattern.arrangement, "n": row.n}
    if row.reason is not None:
        return {**head, "reason": row.reason}
    count = found.count(row)
    return {
        **head,
        "near": _figure(row.near, count),
        "moran": _figure(row.moran, count),
        "profile": [
            {"distance": (i + 0.5) * space_time.BIN, **_figure(one, count)} for i, one in enumerate(row.profile)
        ],
        "star": {name: _figure(row.star[name], count) for name in PLANES},
        "rmse": _figure(row.rmse, found.asked.options.pictures),
    }


def csv_text(found: Answer) -> str:
    """A row a pattern and count."""
    names = ["near", "moran", *(f"star_{name}" for name in PLANES), "rmse"]
    head = ["sampler", "arrangement", "n", *(f"{name}{end}" for name in names for end in ("", "_low", "_high"))]
    rows: list[Sequence[Any]] = [[*head, "reason"]]
    for row in found.rows:
        cells: list[Any] = [row.pattern.sampler, row.pattern.arrangement, row.n]
        figures = [row.near, row.moran, *(row.star.get(name, space_time.UNKNOWN) for name in PLANES)]
        counts = [found.count(row)] * len(figures)
        for estimate, count in zip([*figures, row.rmse], [*counts, found.asked.options.pictures], strict=True):
            cells += [estimate.value, *(interval(estimate, count) or ("", ""))]
        rows.append([*cells, row.reason])
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


# --- in words ---------------------------------------------------------------------------------------------------------


def verdicts(found: Answer) -> list[str]:
    """What came of the lecture's claim, a sentence each."""
    said = []
    for n in sorted({row.n for row in found.rows}):
        said += [text for text in (_over_all(found, n), _dealt(found, n)) if text]
    return said


def _over_all(found: Answer, n: int) -> str | None:
    near, star = found.correlation(n, "near"), found.correlation(n, "xyt")
    if near is None or star is None:
        return None
    low, high = near.interval
    if high < 0.0:
        what = "patterns whose near samples are far apart in time have less error"
    elif low > 0.0:
        what = "patterns whose near samples are far apart in time have more error"
    else:
        what = "how far apart in time near samples are does not tell the error"
    return (
        f"{n} samples, over {near.patterns} patterns: {what} (rank correlation {near.value:+.2f}, 95 % "
        f"[{low:+.2f}, {high:+.2f}]; of the error with the star discrepancy in x, y and t {star.value:+.2f} "
        f"[{star.interval[0]:+.2f}, {star.interval[1]:+.2f}])."
    )


def _dealt(found: Answer, n: int) -> str | None:
    made = [one for one in dealings(found.rows) if one.n == n]
    if not made:
        return None
    counts = {name: sum(one.verdict == name for one in made) for name in ("less", "alike", "more")}
    best, worst = min(made, key=lambda one: one.ratio), max(made, key=lambda one: one.ratio)
    return (
        f"{n} samples, the same places and times dealt out so that near is far in time: the error is {best.ratio:.2f} "
        f"({best.pattern.name}) to {worst.ratio:.2f} ({worst.pattern.name}) of what dealing them out at random leaves; "
        f"less in {counts['less']} of {len(made)}, more in {counts['more']}, not told apart in {counts['alike']}."
    )


def _limits(limits: tuple[float, float] | None, places: int) -> str:
    return f"[{limits[0]:.{places}f}, {limits[1]:.{places}f}]" if limits else ""


def lines(found: Answer) -> list[str]:
    """The tables as text."""
    options, (width, height) = found.asked.options, found.size
    made = [
        f"{found.scene}, {width} x {height}: {options.pictures} pictures of each pattern, the reference's standard "
        f"error {found.reference.standard_error:.1e}; {options.realisations} realisations; 95 % intervals",
    ]
    for n in sorted({row.n for row in found.rows}):
        made += [
            "",
            f"{f'{n} samples':<40} near in space: apart in time   star (x,y)  (x,t)   (y,t)  (x,y,t)   rmse",
        ]
        made += [_line(found, row) for row in found.of(n)]
        made += [f"{row.pattern.name:<40} {row.reason}" for row in found.refused(n)]
    made += ["", "Apart in time: over the 1/4 of independent times, around the border; 2 at most.", *verdicts(found)]
    return made


def _line(found: Answer, row: Row) -> str:
    stars = "  ".join(f"{row.star[name].value or 0.0:.4f}" for name in PLANES)
    near = f"{row.near.value:.3f} {_limits(interval(row.near, found.count(row)), 3)}"
    rmse = f"{row.rmse.value:.5f} {_limits(interval(row.rmse, found.asked.options.pictures), 5)}"
    return f"{row.pattern.name:<40} {near:<30}  {stars}   {rmse}".rstrip()


def write(found: Answer, folder: Path) -> list[Path]:
    """space-time.html, .csv, .json; the paths, the page first. Raises NotWritable."""
    from aliascope.studies.space_time_page import page_of

    return [
        write_text(folder / "space-time.html", teaching_page(page_of(found))),
        write_text(folder / "space-time.csv", csv_text(found)),
        write_text(folder / "space-time.json", json.dumps(document(found), allow_nan=False, indent=1) + "\n"),
    ]
