"""What `aliascope agree -o DIR` writes: report.html with the verdicts, the maps and the power, and results.json."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from aliascope import places, sharing
from aliascope.agreement import SIGNIFICANCE
from aliascope.geometry import Array
from aliascope.report import charts
from aliascope.report.files import write_text
from aliascope.report.teaching import PageTable, Panel, Section, TeachingPage, Value, teaching_page
from aliascope.studies.agree import Answer, Cell
from aliascope.studies.agree_known import BOUNDS
from aliascope.studies.agree_text import amount, document, failures, granted, place_of, powers, summary

MOST_ERRORS = 6.0
"""Standard errors at the ends of the scale of a map."""

WORDS = {"agree": "agree", "known": "differ as known", "differ": "differ"}


def write(folder: Path, answer: Answer) -> Path:
    """Writes the page and results.json; returns the path of the page. Raises NotWritable."""
    answer = replace(answer, cells=sharing.records_shared(answer.cells), skipped=sharing.records_shared(answer.skipped))
    write_text(folder / "results.json", json.dumps(document(answer), allow_nan=False, indent=1) + "\n")
    return write_text(folder / "report.html", teaching_page(page_of(answer)))


def page_of(answer: Answer) -> TeachingPage:
    """The page."""
    asked = answer.asked
    wrong = [(f"{cell.scene}: {cell.one}, {cell.other}", "; ".join(failures(cell))) for cell in _of(answer, "differ")]
    known = dict.fromkeys(
        (f"{cell.scene}: {cell.one}, {cell.other}", f"{each.reason} (up to {each.most:.2g})")
        for cell in answer.cells
        for each in cell.known
    )
    empty = bool(_of(answer, "empty")) or bool(answer.skipped)
    beyond = granted(answer)
    sections = [
        Section("verdicts", "The verdicts", (summary(answer) + ".", _TEXT), (_verdicts(answer),)),
        Section("differ", "What differs", definitions=tuple(wrong)) if wrong else None,
        Section("known", "What is known to differ", definitions=tuple(known)) if known else None,
        Section("power", "What it would have found", (_POWER,), (_power(answer),)),
        Section("effects", "What was found", (_FOUND,), tuple(_effects(answer))),
        Section("beyond", "More than chance, and granted", (_GRANTED,), definitions=tuple(beyond)) if beyond else None,
        Section("maps", "Where", (_MAPS,), panels=tuple(_maps(answer)), columns=5),
        Section("empty", "What two do not both draw", definitions=tuple(_empty(answer))) if empty else None,
        Section("granted", "What is granted beside the standard errors", definitions=BOUNDS),
        Section("made", "How it was made", definitions=(*answer.modes.items(), ("command", command(answer)))),
        Section("files", "Files beside this page", files=(("All figures", (("results.json", "results.json"),)),)),
    ]
    return TeachingPage(
        title="Do the renderers agree?",
        lead=(
            "Renderers that draw the same scene should go to the same picture, the integral over pixel, time, lens and "
            f"light. Each drew {asked.replicates} pictures with other seeds: their means are compared, and how they "
            "scatter says what may be chance."
        ),
        facts=(f"version {places.own_version()}", f"{asked.size[0]} × {asked.size[1]} pixels"),
        sections=tuple(section for section in sections if section),
    )


def command(answer: Answer) -> str:
    """The command that makes the same figures."""
    asked = answer.asked
    words = ["aliascope", "agree", *asked.scenes]
    for name in asked.renderers:
        words += ["-r", name]
    words += ["--size", f"{asked.size[0]}x{asked.size[1]}", "--samples", str(asked.samples)]
    return sharing.command_line([*words, "--replicates", str(asked.replicates), "--seed", str(asked.seed)])


_TEXT = (
    "Tested are all values, the means of blocks of 8 × 8 pixels, those of the picture, and how much of each flaw that "
    "is listed below is in it. A cell has the test that came nearest to its limit, or went furthest beyond, and its "
    f"share of the limit. A whole run is wrong about renderers that agree once in {1.0 / SIGNIFICANCE:,.0f}."
)
_POWER = (
    "The least of each flaw in one of the two renderers that the best of the scenes would have shown 99 times in 100; "
    "and, of the amount on the left, put into the pictures on purpose, with either sign: how many scenes showed it."
)
_FOUND = (
    "How much more of each flaw the second renderer has than the first, by least squares, with its standard error. "
    "Strong where it is beyond its limit, in which there is what is granted."
)
_GRANTED = (
    "This is no chance, and no more than what is granted beside the standard errors. OSMesa moves everything by 1/1024 "
    "pixel, the best for edges along an axis, which the grid of its corners displaces, and slanted ones, which it does "
    "not, together."
)
_MAPS = (
    "The difference, second less first, in standard errors, of the channel where it has most; what is granted is taken "
    f"off before. Blue: the second is darker, red: brighter, white: none; the ends are ± {MOST_ERRORS:g}."
)


def _of(answer: Answer, verdict: str) -> list[Cell]:
    return [cell for cell in answer.cells if cell.verdict == verdict]


def _empty(answer: Answer) -> Iterable[tuple[str, str]]:
    """The scenes of each reason, and renderers that are not there."""
    scenes: dict[str, list[str]] = {}
    for cell in _of(answer, "empty"):
        named = scenes.setdefault(cell.reason, [])
        if cell.scene not in named:
            named.append(cell.scene)
    for reason, named in scenes.items():
        yield ", ".join(named), reason
    yield from answer.skipped.items()


def _pairs(answer: Answer) -> list[tuple[str, str]]:
    return list(dict.fromkeys((cell.one, cell.other) for cell in answer.cells))


def _verdicts(answer: Answer) -> PageTable:
    rows: dict[str, list[Value]] = {}
    for cell in answer.cells:
        rows.setdefault(cell.scene, []).append(_verdict(cell))
    head = ("scene", *(f"{one}, {other}" for one, other in _pairs(answer)))
    return PageTable(
        "Each pair of renderers on each scene", head, tuple((name, tuple(each)) for name, each in rows.items())
    )


def _verdict(cell: Cell) -> Value:
    if cell.judgement is None:
        return Value("–", reason=cell.reason)
    near = cell.judgement.nearest
    return Value(WORDS[cell.verdict], f"{near.share:.2f}, {place_of(near, cell)}", strong=cell.verdict != "agree")


def _power(answer: Answer) -> PageTable:
    rows: dict[str, dict[tuple[str, str], Value]] = {}
    for each in powers(answer):
        named = f"{each.name}, {amount(each.amount, each.unit)}"
        found = f"{each.caught} of {each.scenes}"
        rows.setdefault(named, {})[each.pair] = Value(amount(each.least, each.unit), f"{each.scene}; {found}")
    pairs = _pairs(answer)
    head = ("flaw, and how much was put in", *(f"{one}, {other}" for one, other in pairs))
    body = tuple((name, tuple(values.get(pair, Value("–")) for pair in pairs)) for name, values in rows.items())
    return PageTable("The least that is found; the scene that shows it best; where the amount was found", head, body)


def _effects(answer: Answer) -> Iterable[PageTable]:
    for pair in _pairs(answer):
        cells = [cell for cell in answer.tested if (cell.one, cell.other) == pair]
        names = dict.fromkeys(
            (found.effect.name, found.effect.unit) for cell in cells if cell.judgement for found in cell.judgement.found
        )
        rows = []
        for cell in cells:
            assert cell.judgement is not None
            by_name = {found.effect.name: found for found in cell.judgement.found}
            values = [
                Value(
                    f"{found.value:+.2g}".replace("-", "−"),
                    f"± {found.standard_error:.1g}",
                    strong=abs(found.value) > found.limit,
                )
                if (found := by_name.get(name))
                else Value("–")
                for name, _ in names
            ]
            rows.append((cell.scene, tuple(values)))
        if rows:
            head = ("scene", *(f"{name}, {unit}" for name, unit in names))
            yield PageTable(f"{pair[1]} against {pair[0]}", head, tuple(rows))


# --- maps -------------------------------------------------------------------------------------------------------------


def _maps(answer: Answer) -> Iterable[Panel]:
    for cell in answer.tested:
        assert cell.judgement is not None
        errors = next(tests.errors for tests in cell.judgement.tests if tests.kind == "pixel")
        strongest = np.take_along_axis(errors, np.abs(errors).argmax(axis=2)[..., np.newaxis], axis=2)[..., 0]
        most = float(np.abs(strongest).max())
        text = base64.b64encode(charts.png(coloured(strongest / MOST_ERRORS))).decode("ascii")
        about = f"{cell.scene}: {cell.other} less {cell.one}, in standard errors"
        image = charts.element("img", src=f"data:image/png;base64,{text}", alt=about)
        yield Panel(image, f"{cell.scene}: {cell.other} − {cell.one}", f"{WORDS[cell.verdict]}; at most {most:.1f}")


_LOW, _HIGH = np.array([5.0, 72.0, 140.0]), np.array([178.0, 24.0, 43.0])
"""The ends of the scale."""


def coloured(share: Array) -> charts.Bytes:
    """(height, width, 3), from -1 (blue) over 0 (white) to 1 (red); the root makes what is small seen."""
    reach = np.sqrt(np.clip(np.abs(share), 0.0, 1.0))[..., np.newaxis]
    ends = np.where(share[..., np.newaxis] < 0.0, _LOW, _HIGH)
    return np.asarray(np.rint(255.0 + reach * (ends - 255.0)), dtype=np.uint8)
