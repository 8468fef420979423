"""What `aliascope regress` says: a line a check, failures first, with the commands that go on from there."""

from __future__ import annotations

import math
import textwrap
from collections import Counter
from collections.abc import Iterable, Sequence

from aliascope.regression.records import CellVerdict, Check, Control, Run
from aliascope.regression.verdict import SHARES

WIDTH = 120
CHANNELS = ("red", "green", "blue")

_FAMILIES = {"effect": "effects", "block": "blocks", "accuracy": "accuracy"}
SHARED = (
    "corrected for all of them together: Bonferroni, "
    + ", ".join(f"{share:.0%} of it for {_FAMILIES[family]}" for family, share in SHARES.items())
    + ", each part shared evenly by its tests"
)


def lines(run: Run, quiet: bool = False) -> list[str]:
    """All of it; `quiet`: failures, controls and the summary."""
    made = [*head(run), ""]
    failed, fine = split(run)
    for cell in failed:
        made += [*cell_lines(cell, everything=not quiet), ""]
    if not quiet:
        for cell in fine:
            made += [*cell_lines(cell), ""]
        made += empty_lines(run)
    made += [control_line(control) for control in run.controls]
    made += [f"skipped  {name}: {reason}" for name, reason in run.skipped.items()]
    if not quiet:
        made += warning_lines(run)
    return [*made, *([""] if made[-1] else []), summary(run)]


def head(run: Run) -> list[str]:
    """How much was tested, and what a failure means."""
    by = Counter(cell.name.renderer for cell in run.cells)
    scenes = len({cell.name.scene for cell in run.cells})
    cells = f"{counted(len(run.cells), 'cell')} on {counted(scenes, 'scene')}"
    told = ", ".join(f"{name} {count}" for name, count in by.items())
    text = (
        f"{cells}{f' ({told})' if told else ''}, {run.replicates} pictures each, {run.tests:,} statistical tests. "
        f"Significance {run.significance:g}, {SHARED}. Chance alone fails one run in "
        f"{1 / run.significance:,.0f} at most."
    )
    return textwrap.wrap(text, WIDTH)


def split(run: Run) -> tuple[list[CellVerdict], list[CellVerdict]]:
    """The cells that failed, jobs that crashed before the others, and those that passed."""
    failed = [cell for cell in run.cells if not cell.passed]
    return sorted(failed, key=lambda cell: not cell.failed), [cell for cell in run.cells if cell.passed]


def in_order(checks: Iterable[Check]) -> list[Check]:
    """Failures first, warnings after them."""
    return sorted(checks, key=lambda check: (check.passed, check.warning))


# --- a cell -----------------------------------------------------------------------------------------------------------


def cell_lines(cell: CellVerdict, everything: bool = True) -> list[str]:
    """A cell with its checks; without `everything` those alone that failed."""
    word = "passed" if cell.passed else "CRASHED" if cell.failed else "FAILED"
    made = [f"{word:7}  {cell.name.text}"]
    if cell.problem:
        made += _problem(cell)
    for check in in_order(cell.checks):
        if everything or not (check.passed or check.warning):
            made += check_lines(check)
    return made + ([] if cell.passed else [f"         {text}" for text in after(cell)])


def after(cell: CellVerdict) -> list[str]:
    """What a user goes on with: the worst pixel, the commands."""
    made = []
    if cell.observed is not None and cell.observed.worst is not None:
        worst = cell.observed.worst
        made.append(
            f"worst pixel ({worst.x}, {worst.y}), {CHANNELS[worst.channel]}: {worst.value:.6g}, "
            f"expected {worst.expected:.6g}"
        )
    made += [f"again: {cell.again}"] if cell.again else []
    return made + ([f"bless: {cell.bless}"] if cell.bless and not cell.failed else [])


def check_lines(check: Check) -> list[str]:
    """One check in columns: what was tested, figure, limit, head-room; the p-value, how many it stands for. What more
    there is to say follows, on a line of its own if it has to; of a check that passed the documents have that."""
    sign = ">=" if check.at_least else "<="
    figures = f"{number(check.observed):>10} {sign} {number(check.limit):<10} {check.unit:<17}"
    line = f"  {mark(check):5}  {check.about:<32} {figures} {headroom(check):>9}  {'; '.join(notes(check))}".rstrip()
    if not check.detail:
        return [line]
    longer = f"{line}{'; ' if notes(check) else '  '}{check.detail}"
    if len(longer) <= WIDTH:
        return [longer]
    return [line] if check.passed else [line, *_wrapped(check.detail)]


def mark(check: Check) -> str:
    return "ok" if check.passed else "warn" if check.warning else "FAIL"


def notes(check: Check) -> list[str]:
    """What there is to say of a check beyond its figures, in short."""
    made = [] if check.p_value is None or math.isnan(check.p_value) else [f"p {check.p_value:.2g}"]
    return made + ([f"worst of {check.tests:,}"] if check.tests > 1 else [])


def headroom(check: Check) -> str:
    """What is left to the limit, in percent of it; negative beyond it, and far beyond it how many times it is."""
    room = check.headroom
    if room is None or not math.isfinite(room):
        return "-"
    return f"{100 * room:.0f} %" if room > -10 else f"{1 - room:.3g} times"


def number(value: float) -> str:
    """Four digits, or all of a whole number: counts are exact."""
    if not math.isfinite(value):
        return "none" if math.isnan(value) else "infinite"
    return f"{value:,.0f}" if value == int(value) and abs(value) < 1e15 else f"{value:.4g}"


def figure(check: Check) -> str:
    """What was observed beside what may be, in words."""
    unit = f" {check.unit}" if check.unit else ""
    least = "at least" if check.at_least else "at most"
    return f"{check.about}: {number(check.observed)}{unit}, {least} {number(check.limit)}"


def reasons(cell: CellVerdict) -> list[str]:
    """Why a cell failed, a line each."""
    made = [cell.problem] if cell.problem else []
    return made + [figure(check) for check in in_order(cell.checks) if not (check.passed or check.warning)]


def _problem(cell: CellVerdict) -> list[str]:
    """A problem may end in a command, which is not to be broken over lines; the one that blesses stands below it."""
    told, sign, command = cell.problem.partition(": aliascope ")
    if not sign:
        return _wrapped(told)
    if f"aliascope {command}" == cell.bless:
        short = told.removesuffix("; look at it, and bless it with")
        return _wrapped(short if short != told else f"{told}, as below")
    return [*_wrapped(f"{told}:"), f"         aliascope {command}"]


def _wrapped(text: str) -> list[str]:
    indent = " " * 9
    return textwrap.wrap(
        text, WIDTH, initial_indent=indent, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


# --- the rest of a run ------------------------------------------------------------------------------------------------


def control_line(control: Control) -> str:
    """Whether a defect that was put in on purpose was found."""
    problem = control.problem.partition("; ")[0]
    how = f"caught by {control.by}" if control.caught else f"NOT CAUGHT{f': {problem}' if problem else ''}"
    return f"control  {control.defect}, in {control.name.text}: {how}"


def warnings_of(run: Run) -> list[tuple[CellVerdict, Check]]:
    return [(cell, check) for cell in run.cells for check in cell.checks if check.warning and not check.passed]


def warning_lines(run: Run) -> list[str]:
    """What is beyond its limit and fails nothing: times."""
    return [f"warning  {cell.name.text}: {figure(check)}" for cell, check in warnings_of(run)]


def empty_lines(run: Run) -> list[str]:
    """Cells that are not drawn, those of a reason together."""
    groups: dict[tuple[str, str, str], list[str]] = {}
    for name, reason in run.empty:
        groups.setdefault((name.scene, name.renderer, reason), []).append(name.mode)
    made = [
        f"empty    {scene}/{renderer}, {counted(len(modes), 'mode')}: {reason}"
        for (scene, renderer, reason), modes in groups.items()
    ]
    return [*made, ""] if made else []


def counted(count: int, what: str) -> str:
    return f"{count:,} {what}{'' if count == 1 else 's'}"


def summary(run: Run) -> str:
    """One line: how the run came out."""
    failed = [cell for cell in run.cells if not cell.passed]
    crashed = sum(cell.failed for cell in failed)
    missed = sum(not control.caught for control in run.controls)
    parts = [
        f"{len(failed)} of {counted(len(run.cells), 'cell')} failed" + (f" ({crashed} crashed)" if crashed else "")
    ]
    if run.controls:
        parts.append(f"{len(run.controls) - missed} of {counted(len(run.controls), 'control')} caught")
    parts += _counts(run)
    return f"{'PASSED' if run.passed else 'FAILED'}: {', '.join(parts)}; {run.wall_seconds:.0f} s"


def _counts(run: Run) -> Sequence[str]:
    warned = len(warnings_of(run))
    made = [counted(warned, "warning")] if warned else []
    made += [f"{counted(len(run.empty), 'cell')} not drawn"] if run.empty else []
    skipped = ", ".join(run.skipped)
    return [*made, *([f"{len(run.skipped)} skipped ({skipped})"] if run.skipped else [])]
