"""What `aliascope agree` prints: one document, or lines for a person."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from aliascope.agreement import SIGNIFICANCE
from aliascope.studies.agree import Answer, Cell
from aliascope.studies.agree_judge import Found, Worst
from aliascope.studies.agree_known import BOUNDS

VERDICTS = {"agree": "agree", "known": "differ as known", "differ": "DIFFER", "empty": "-"}


def place_of(worst: Worst, cell: Cell) -> str:
    """Where a test looks, in words."""
    assert cell.judgement is not None
    if worst.kind == "effect":
        return f'the effect "{cell.judgement.found[worst.place[0]].effect.name}"'
    channel = ["red", "green", "blue"][worst.place[-1]]
    if worst.kind == "picture":
        return f"{channel} of the picture"
    row, column, _ = worst.place
    return f"{channel} of {worst.kind} ({column}, {row})"


# --- power ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Power:
    """Of an effect between a pair of renderers: the least amount that a scene would have shown, 99 times in 100, and
    which; on how many scenes `amount` was found when it was put in, of how many."""

    name: str
    amount: float
    unit: str
    pair: tuple[str, str]
    least: float
    scene: str
    caught: int
    scenes: int


def powers(answer: Answer) -> list[Power]:
    """Of all effects and pairs that were tested."""
    groups: dict[tuple[str, str, str], list[tuple[str, Found]]] = {}
    for cell in answer.tested:
        assert cell.judgement is not None
        for found in cell.judgement.found:
            groups.setdefault((found.effect.name, cell.one, cell.other), []).append((cell.scene, found))
    made = []
    for (name, one, other), each in groups.items():
        scene, best = min(each, key=lambda pair: pair[1].least)
        caught = sum(found.caught for _, found in each)
        made.append(
            Power(name, best.effect.amount, best.effect.unit, (one, other), best.least, scene, caught, len(each))
        )
    return made


# --- the document -----------------------------------------------------------------------------------------------------


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def document(answer: Answer) -> dict[str, Any]:
    """What --json prints, and results.json holds. A figure that is infinite is null: a difference without any limit, an
    effect that no amount of would show."""
    asked = answer.asked
    return {
        "size": list(asked.size),
        "samples": asked.samples,
        "replicates": asked.replicates,
        "seed": asked.seed,
        "significance": SIGNIFICANCE,
        "modes": dict(answer.modes),
        "skipped": dict(answer.skipped),
        "holds": answer.holds,
        "bounds": dict(BOUNDS),
        "cells": [_cell(cell) for cell in answer.cells],
        "power": [
            {
                "effect": each.name,
                "amount": each.amount,
                "unit": each.unit,
                "renderers": list(each.pair),
                "least": _finite(each.least),
                "scene": each.scene,
                "caught": each.caught,
                "scenes": each.scenes,
            }
            for each in powers(answer)
        ],
    }


def _cell(cell: Cell) -> dict[str, Any]:
    made: dict[str, Any] = {"scene": cell.scene, "renderers": [cell.one, cell.other], "verdict": cell.verdict}
    if cell.judgement is None:
        return made | {"reason": cell.reason}
    return made | {
        "known": [{"reason": each.reason, "most": each.most} for each in cell.known],
        "tests": {
            each.kind: {
                "count": tests.difference.size,
                "limits": [float(tests.limit.min()), float(tests.limit.max())],
                "where": place_of(each, cell),
                "difference": each.difference,
                "standard_error": each.standard_error,
                "limit": each.limit,
                "share": _finite(each.share),
            }
            for each, tests in zip(cell.judgement.worst.values(), cell.judgement.tests, strict=True)
        },
        "effects": {
            found.effect.name: {
                "value": found.value,
                "standard_error": found.standard_error,
                "limit": found.limit,
                "granted": found.granted,
                "least": _finite(found.least),
                "unit": found.effect.unit,
                "amount": found.effect.amount,
                "caught": found.caught,
            }
            for found in cell.judgement.found
        },
    }


# --- lines ------------------------------------------------------------------------------------------------------------


def amount(value: float, unit: str) -> str:
    """A figure with its unit."""
    if unit == "px" and value == 1.0 / 32.0:
        return "1/32 px"
    return f"{value:.2g}{'' if unit in ('%', '/255') else ' '}{unit}"


def lines(answer: Answer) -> list[str]:
    """The verdicts, what they rest on, and what the run would have found."""
    width = max(len(cell.scene) for cell in answer.cells)
    pairs = max(len(f"{cell.one} {cell.other}") for cell in answer.cells)
    made = []
    for cell in answer.cells:
        head = f"{cell.scene:{width}}  {f'{cell.one} {cell.other}':{pairs}}  {VERDICTS[cell.verdict]}"
        if cell.judgement is None:
            made.append(f"{head} {cell.reason}")
            continue
        near = cell.judgement.nearest
        figures = f"{abs(near.difference):.2g} of at most {near.limit:.2g}"
        made.append(f"{head}: {place_of(near, cell)} differs by {figures}, a share of {near.share:.2f}")
        if cell.verdict == "differ":
            made += [f"    {text}" for text in failures(cell)]
        made += [f"    known: {each.reason} (up to {each.most:.2g})" for each in cell.known]
    made += [f"skipped {name}: {reason}" for name, reason in answer.skipped.items()]
    if beyond := granted(answer):
        made += [
            "",
            "More than chance, and no more than is granted below:",
            *(f"  {cell}: {text}" for cell, text in beyond),
        ]
    return [*made, "", *_power_lines(powers(answer)), "", *_bound_lines(), "", summary(answer)]


def failures(cell: Cell) -> list[str]:
    """The worst of each kind of test that failed, and what the picture has more than it should, in words."""
    assert cell.judgement is not None
    made = [
        f"{place_of(worst, cell)}: {worst.difference:+.3g} +- {worst.standard_error:.1g}, limit {worst.limit:.3g}"
        for worst in cell.judgement.failed
        if worst.kind != "effect"
    ]
    return made + [
        f"{cell.other} has {amount(found.value, found.effect.unit)} +- {found.standard_error:.1g} of "
        f'"{found.effect.name}" more, limit {found.limit:.2g}'
        for found in cell.judgement.found
        if abs(found.value) > found.limit
    ]


def granted(answer: Answer) -> list[tuple[str, str]]:
    """Of each flaw that is more than chance, and no more than what is granted: the pair, and how much."""
    return [
        (
            f"{cell.scene}, {cell.one} {cell.other}",
            f"{found.effect.name} by {amount(found.value, found.effect.unit)} +- {found.standard_error:.1g}, at most "
            f"{found.limit:.2g}",
        )
        for cell in answer.tested
        if cell.judgement
        for found in cell.judgement.found
        if found.granted
    ]


def _power_lines(each: Sequence[Power]) -> list[str]:
    if not each:
        return []
    made = ["Found 99 times in 100, from so much on; put in on purpose, found on so many scenes:"]
    for name in dict.fromkeys(one.name for one in each):
        parts = [
            f"{' '.join(one.pair)} {amount(one.least, one.unit)} ({amount(one.amount, one.unit)}: {one.caught} of "
            f"{one.scenes})"
            for one in each
            if one.name == name
        ]
        made.append(f"  {name}: {'; '.join(parts)}")
    return made


def _bound_lines() -> list[str]:
    return ["Granted beside the standard errors:", *(f"  {name}: {text}" for name, text in BOUNDS)]


def summary(answer: Answer) -> str:
    """How many of each verdict."""
    count = {verdict: sum(cell.verdict == verdict for cell in answer.cells) for verdict in VERDICTS}
    known = f", {count['known']} differ for a reason that is known" if count["known"] else ""
    return (
        f"{count['agree']} of {len(answer.tested)} pairs agree{known}, {count['differ']} differ; "
        f"{count['empty']} not drawn by both"
    )
