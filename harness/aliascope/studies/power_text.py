"""What `make power` says: lines, a table in Markdown, a document in JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from aliascope import places, renderers
from aliascope.regression.defects import DEFECTS
from aliascope.regression.verdict import SHARES
from aliascope.sharing import records_shared
from aliascope.studies.power import MOST_ALARMS, Answer
from aliascope.studies.power_caught import Caught
from aliascope.studies.power_machines import INSTRUCTIONS, VECTOR_BITS
from aliascope.text_files import write_text


@dataclass(frozen=True)
class Row:
    """A defect in a renderer, over scenes: of those that can have it, where it was caught each time; of all tries, how
    many; and where it stood out least, with how many times its limit."""

    defect: str
    renderer: str
    scenes: int
    caught: int
    tries: int
    tries_caught: int
    least: float | None
    where: str

    @property
    def text(self) -> str:
        """For a cell of a table."""
        if not self.scenes:
            return "–"
        found = f"{self.caught} of {self.scenes} scenes, {self.tries_caught} of {self.tries} times"
        if self.least is None:
            return found
        return f"{found}; {shortened(self.least)} x on `{self.where}`"


def shortened(times: float) -> str:
    """Two digits of a number that is at least 1, or whole where it has more."""
    return f"{times:.2g}" if times < 10.0 else f"{times:.0f}" if times < 1e4 else f"{times:.0e}"


def rows(answer: Answer) -> list[Row]:
    """Each defect in each renderer. On a scene the cell counts that caught it most often, and by the most."""
    found = []
    for defect in DEFECTS:
        for renderer, scenes in answer.drawn.items():
            own = [each for each in answer.caught if each.defect == defect and each.renderer == renderer]
            best = [max(cells, key=_telling) for scene in scenes if (cells := [e for e in own if e.scene == scene])]
            caught = [each for each in best if each.caught == each.tries]
            stated = [(each.times, each.scene) for each in caught if each.times is not None]
            least, where = min(stated) if stated else (None, "")
            found.append(
                Row(
                    defect,
                    renderer,
                    len(best),
                    len(caught),
                    sum(each.tries for each in best),
                    sum(each.caught for each in best),
                    least,
                    where,
                )
            )
    return found


def _telling(each: Caught) -> tuple[float, float]:
    return each.caught / each.tries, float("inf") if each.times is None else each.times


def null_text(answer: Answer) -> str:
    """Of false alarms, in a sentence or two."""
    null = answer.null
    shares = ", ".join(f"{name} {100 * share:g} %" for name, share in SHARES.items())
    scenes = sorted({scene for own in answer.drawn.values() for scene in own})
    what = f"the suite on {', '.join(scenes)} alone" if answer.asked.scenes else "the whole suite"
    return (
        f"{null.alarms} of {null.repetitions} repetitions of {what} in which nothing changed raised an alarm: "
        f"below {100 * null.bound:.2g} % of runs, with 95 % confidence. The suite has {answer.cells} cells and "
        f"{answer.tests} statistical tests, which share a significance of {100 * answer.significance:g} % ({shares}, "
        f"each divided evenly); {answer.seeded} cells have seeds, and took other pictures for each repetition, now and "
        "as blessed; the others draw the same each time"
        + (", and raised none." if answer.calm else ", AND YET RAISED AN ALARM.")
    )


def elsewhere_text(answer: Answer) -> str:
    """Of other instructions, or nothing."""
    found = answer.elsewhere
    if found is None:
        return ""
    said = f"{len(found.alarms)} alarms" if found.alarms else "no alarm"
    return (
        f"Drawn by other instructions of the processor (Embree by {INSTRUCTIONS.upper()}, llvmpipe with vectors of "
        f"{VECTOR_BITS} bits), {found.other_bits} of {found.pictures} pictures of {found.cells} cells have other bits: "
        f"{said}."
    )


def markdown(answer: Answer) -> str:
    """The table for a README."""
    names = list(answer.drawn)
    titles = [renderers.find(name).title for name in names]
    every = {(row.defect, row.renderer): row for row in rows(answer)}
    lines = [
        f"| put in | {' | '.join(titles)} |",
        f"|---|{'---|' * len(names)}",
        *(
            f"| {defect.text} | {' | '.join(every[name, renderer].text for renderer in names)} |"
            for name, defect in DEFECTS.items()
        ),
    ]
    paragraphs = ["\n".join(lines), null_text(answer), elsewhere_text(answer), *_reasons()]
    return "\n\n".join(filter(None, paragraphs)) + "\n"


def _reasons() -> list[str]:
    """Why a defect is not in every mode."""
    by: dict[str, list[str]] = {}
    for defect in DEFECTS.values():
        if defect.absent:
            by.setdefault(defect.absent, []).append(defect.name)
    return [f"Not everywhere: {' and '.join(names)}: {reason}." for reason, names in by.items()]


def lines(answer: Answer) -> list[str]:
    """For people at a terminal."""
    found = [null_text(answer), *_alarms(answer), elsewhere_text(answer)]
    if answer.elsewhere is not None:
        found += [f"  {alarm}" for alarm in answer.elsewhere.alarms]
    width = max(map(len, DEFECTS))
    for row in rows(answer):
        if row.scenes:
            found.append(f"{row.defect:{width}}  {row.renderer:8}  {row.text}")
    found += [f"MISSED  {scene}  {renderer}  {defect}" for scene, renderer, defect in answer.missed]
    found.append(
        "holds" if answer.holds else f"does not hold: at most {1000 * MOST_ALARMS:g} alarms in 1,000, none missed"
    )
    return [line for line in found if line]


def _alarms(answer: Answer) -> Sequence[str]:
    ordered = sorted(answer.null.by.items(), key=lambda each: -each[1])
    return [f"  {count} x  {what}" for what, count in ordered]


def document(answer: Answer) -> dict[str, Any]:
    """All figures, for JSON."""
    return {
        "revision": places.revision(),
        "machine": places.machine(),
        "versions": dict(answer.versions),
        "holds": answer.holds,
        "significance": answer.significance,
        "cells": answer.cells,
        "seeded": answer.seeded,
        "tests": answer.tests,
        "null": {**asdict(answer.null), "bound": answer.null.bound, "unseeded_calm": answer.calm},
        "other_instructions": None if answer.elsewhere is None else asdict(answer.elsewhere),
        "defects": [{"name": name, "text": defect.text, "absent": defect.absent} for name, defect in DEFECTS.items()],
        "caught": [asdict(each) for each in answer.caught],
        "missed": [list(each) for each in answer.missed],
    }


def write(folder: Path, answer: Answer) -> Path:
    """power.json, and power.md, whose path is given. Raises NotWritable."""
    write_text(folder / "power.json", json.dumps(records_shared(document(answer)), indent=1, allow_nan=False) + "\n")
    return write_text(folder / "power.md", markdown(answer))
