"""`aliascope regress --bless`: what cells render now is what they are compared with from then on, and why is kept."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from aliascope.errors import CheckFailed, InvalidInput, JobFailed
from aliascope.regression import blessed as blessed_files
from aliascope.regression.records import Blessed, CellName, CellVerdict
from aliascope.studies import regress, regress_text
from aliascope.studies.regress import Asked, Problem, Seen, Tell


@dataclass(frozen=True)
class Blessing:
    """A cell that was blessed. `before`: what was there; None where there was nothing, or nothing that can be trusted,
    and `refused` says why. `verdict`: of the same pictures by what they are compared with from now on."""

    blessed: Blessed
    before: Blessed | None
    refused: str
    verdict: CellVerdict


@dataclass(frozen=True)
class Blessings:
    """All of a command, and the files that were written."""

    each: tuple[Blessing, ...]
    files: tuple[Path, ...]

    @property
    def hold(self) -> bool:
        """Whether all cells pass now: blessing does not change what a reference says."""
        return all(blessing.verdict.passed for blessing in self.each)


def bless(asked: Asked, pattern: str, reason: str, tell: Tell) -> Blessings:
    """Renders the cells that a pattern matches and keeps what came of them, all or none.

    Raises InvalidInput for a pattern that matches none and for no reason, JobFailed where a cell cannot be rendered,
    CheckFailed where its reference is missing or its pictures are none, NotWritable.
    """
    if not reason.strip():
        raise InvalidInput("--bless needs --reason TEXT: why the new figures are right; it is kept in the log")
    seen = regress.observe(replace(asked, cells=(pattern,), controls=False), tell)
    _check(seen)
    now = [
        blessed_files.bless(found, " ".join(reason.split()), asked.command)
        for cell in seen.cells
        if not isinstance(found := seen.observed[cell.name], Problem)
    ]
    before = [_before(asked.references, each.observed.name) for each in now]
    files = blessed_files.save(asked.references, now)
    for each, (then, _) in zip(now, before, strict=True):
        log = blessed_files.log(asked.references, each, then)
    verdicts = {cell.name: cell for cell in regress.judged(seen).cells}
    made = [
        Blessing(each, then, refused, verdicts[each.observed.name])
        for each, (then, refused) in zip(now, before, strict=True)
    ]
    return Blessings(tuple(made), (*files, log))


def _check(seen: Seen) -> None:
    """Raises what stands against blessing all of them."""
    problems = [(name.text, found) for name, found in seen.observed.items() if isinstance(found, Problem)]
    for name, problem in sorted(problems, key=lambda pair: not pair[1].failed):
        kind = JobFailed if problem.failed else CheckFailed
        raise kind(f"nothing was blessed: {name}: {problem.text}")


def _before(folder: Path, name: CellName) -> tuple[Blessed | None, str]:
    try:
        return blessed_files.load(folder, name.scene, name.renderer).get(name.mode), ""
    except CheckFailed as error:
        return None, str(error).partition("; ")[0]


UNCHANGED = 1e-5
"""Relative to a figure: the rounding of what was kept of it."""


# --- what is said -----------------------------------------------------------------------------------------------------


def lines(blessings: Blessings) -> list[str]:
    """Of each cell its old and new hash and what changed; loudly, which still fail."""
    made: list[str] = []
    for blessing in blessings.each:
        made += [*_lines(blessing), ""]
    still = sum(not blessing.verdict.passed for blessing in blessings.each)
    made += [f"written: {path}" for path in blessings.files]
    cells = regress_text.counted(len(blessings.each), "cell")
    return [*made, f"blessed {cells}" + (f"; {still} STILL FAIL, as blessing does not change that" if still else "")]


def _lines(blessing: Blessing) -> list[str]:
    name, then = blessing.blessed.observed.name, blessing.before
    made = [f"blessed  {name.text}"]
    if blessing.refused:
        made.append(f"         what was there cannot be compared: {blessing.refused}")
    made.append(f"         old hash {then.sha256 if then else 'none'}")
    made.append(f"         new hash {blessing.blessed.sha256}{', the same' if _same(blessing) else ''}")
    made += [f"         {line}" for line in _changes(blessing)]
    if not blessing.verdict.passed:
        judge = "its reference" if blessing.blessed.observed.judged == "reference" else "what it must be"
        made.append(f"         STILL FAILS by {judge}, which blessing does not change:")
        made += [f"           {text}" for text in regress_text.reasons(blessing.verdict)]
    return made


def _same(blessing: Blessing) -> bool:
    return blessing.before is not None and blessing.before.sha256 == blessing.blessed.sha256


def changes(blessing: Blessing) -> dict[str, tuple[float | None, float | None]]:
    """Each figure before and now; None where it has none."""
    now = blessed_files.figures(blessing.blessed.observed)
    then = blessed_files.figures(blessing.before.observed) if blessing.before else {}
    return {name: (then.get(name), now.get(name)) for name in {**then, **now}}


def _changes(blessing: Blessing) -> list[str]:
    rows = changes(blessing)
    width = max(map(len, rows))
    return [f"{name:{width}}  {_change(*pair)}" for name, pair in rows.items()]


def _change(then: float | None, now: float | None) -> str:
    before, after = ("none" if value is None else regress_text.number(value) for value in (then, now))
    if then is None or now is None:
        return f"{before:>12} -> {after}"
    if abs(now - then) <= UNCHANGED * abs(then):
        return f"{before:>12}    unchanged"
    ratio = f"{100 * (now / then - 1):+.3g} %" if then else ""
    return f"{before:>12} -> {after:<12} {ratio}".rstrip()


def document(blessings: Blessings) -> dict[str, Any]:
    """What --json prints."""
    return {
        "hold": blessings.hold,
        "files": [str(path) for path in blessings.files],
        "blessed": [
            {
                **_names(blessing.blessed.observed.name),
                "old": blessing.before.sha256 if blessing.before else None,
                "new": blessing.blessed.sha256,
                "refused": blessing.refused,
                "reason": blessing.blessed.reason,
                "changes": {name: list(pair) for name, pair in changes(blessing).items()},
                "passes": blessing.verdict.passed,
                "fails": regress_text.reasons(blessing.verdict),
            }
            for blessing in blessings.each
        ],
    }


def _names(name: CellName) -> dict[str, str]:
    return {"scene": name.scene, "renderer": name.renderer, "mode": name.mode}
