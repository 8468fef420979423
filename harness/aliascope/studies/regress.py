"""`aliascope regress`: renders the cells of a run, observes and judges them, and shows that it can fail.

Workers render a cell's replicates and send back what is kept of them (`regression/observe.py`). When all are there the
statistical tests of the run are counted, and each cell is judged at its share of the significance
(`regression/verdict.py`). The controls are cells that are rendered a second time with a defect put in on purpose.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path

from aliascope import places, plan, renderers, scene_io
from aliascope.errors import CheckFailed, NotAvailable
from aliascope.native import samplers
from aliascope.references import files as reference_files
from aliascope.regression import blessed as blessed_files
from aliascope.regression import commands
from aliascope.regression.commands import Setting
from aliascope.regression.observe import Target
from aliascope.regression.records import Blessed, CellName, CellVerdict, Check, Control, Observed, Run
from aliascope.regression.verdict import SIGNIFICANCE, Chances, Tests, count, judge, mismatch, shared
from aliascope.renderers.base import filter_of
from aliascope.sharing import records_shared
from aliascope.studies import regress_suite, selection
from aliascope.studies.regress_render import Problem as Problem
from aliascope.studies.regress_render import Tell as Tell
from aliascope.studies.regress_render import Work, rendered
from aliascope.studies.regress_suite import REPLICATES, Cell


@dataclass(frozen=True)
class Asked:
    """The options of a run; no scenes, renderers or modes: all of the suite. `required`: renderers that must be there.
    `cells`: patterns of "scene/renderer/mode" of which one must match. `time_limit`: seconds that a task, some pictures
    of one cell, may take. `options`: words of the command line that its repetition needs too."""

    scenes: tuple[str, ...] = ()
    renderers: tuple[str, ...] = ()
    modes: tuple[str, ...] = ()
    required: tuple[str, ...] = ()
    cells: tuple[str, ...] = ()
    references: Path = places.REFERENCES
    processes: int = 2
    time_limit: float = 120.0
    replicates: int = REPLICATES
    controls: bool = True
    command: str = "aliascope regress"
    options: tuple[str, ...] = ()
    significance: float = SIGNIFICANCE


@dataclass(frozen=True)
class Injected:
    """A cell that was rendered with a defect."""

    defect: str
    name: CellName
    observed: Observed | Problem


@dataclass(frozen=True)
class Seen:
    """All that a run has rendered, before it is judged; `called`: how the command line names a scene, by its name."""

    asked: Asked
    cells: tuple[Cell, ...]
    observed: Mapping[CellName, Observed | Problem]
    injected: tuple[Injected, ...]
    empty: tuple[tuple[CellName, str], ...]
    skipped: Mapping[str, str]
    versions: Mapping[str, str]
    called: Mapping[str, str]
    started: str
    wall_seconds: float


def run(asked: Asked, tell: Tell) -> Run:
    """Renders and judges. Raises InvalidInput for what was asked wrongly, NotAvailable for a required renderer."""
    return judged(observe(asked, tell))


# --- rendering --------------------------------------------------------------------------------------------------------


def observe(asked: Asked, tell: Tell) -> Seen:
    """Renders all cells and observes them, with nothing but the references to compare with."""
    started, begun = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    names, skipped, versions = _renderers(asked)
    called = {scene_io.load(word).name: word for word in selection.scenes_of(asked.scenes)}
    files = [scene_io.load(word) for word in selection.scenes_of(asked.scenes)]
    selection.check_names(files)
    cells, empty = regress_suite.cells_of(files, names, asked.modes, asked.replicates)
    if asked.cells:
        wanted = regress_suite.matching(asked.cells, cells)
        cells, empty = [cell for cell in cells if cell.name.text in wanted], []
    targets = _targets(cells, asked, called)
    work = [Work(cell, "", target) for cell in cells if isinstance(target := targets[cell.name], Target)]
    if asked.controls:
        work += [
            Work(cell, defect.name, target)
            for cell in regress_suite.controls_of(cells)
            for defect in regress_suite.controls_in(cell)
            if isinstance(target := targets[cell.name], Target)
        ]
    made = rendered(work, asked.processes, asked.time_limit, versions, tell)
    found: dict[CellName, Observed | Problem] = {
        cell.name: target for cell in cells if isinstance(target := targets[cell.name], Problem)
    }
    found.update({each.cell.name: seen for each, seen in zip(work, made, strict=True) if not each.defect})
    injected = tuple(
        Injected(each.defect, each.cell.name, seen) for each, seen in zip(work, made, strict=True) if each.defect
    )
    flat = {name: version for own in versions.values() for name, version in own.items()}
    return Seen(
        asked,
        tuple(cells),
        found,
        injected,
        tuple(empty),
        skipped,
        flat,
        called,
        started,
        time.monotonic() - begun,
    )


def _renderers(asked: Asked) -> tuple[list[str], dict[str, str], dict[str, Mapping[str, str]]]:
    """Those that take part, those that are not there with the reason, and versions."""
    words, needed = renderers.named(asked.renderers), renderers.named(asked.required)
    known = list(renderers.RENDERERS)
    required = plan.matching(needed, known, "renderer")
    chosen = plan.matching(words, known, "renderer") if words else known
    names, skipped, versions = [], {}, {}
    for name in known:
        if name not in chosen and name not in required:
            continue
        try:
            versions[name] = renderers.find(name).versions()
            names.append(name)
        except NotAvailable as error:
            if name in required:
                raise
            skipped[name] = str(error)
    if not names:
        raise NotAvailable("; ".join(f"{name}: {reason}" for name, reason in skipped.items()))
    return [name for name in names if name in chosen], skipped, versions


def _targets(cells: Sequence[Cell], asked: Asked, called: Mapping[str, str]) -> dict[CellName, Target | Problem]:
    """What the pictures of each cell should be; each reference is loaded once."""
    loaded: dict[tuple[str, str], Target | Problem] = {}
    for cell in cells:
        key = name, filter_ = cell.name.scene, filter_of(cell.spec)
        if key not in loaded:
            scene = cell.file.scene
            try:
                reference = reference_files.load(asked.references, name, scene, scene.view.size, filter_)
                loaded[key] = Target(reference.exact, reference.standard_error)
            except CheckFailed as error:  # its command is one for our scenes, in the folder that is ours
                told = str(error).rpartition(" with: ")[0]
                command = commands.reference(called[name], filter_, Setting(asked.references))
                loaded[key] = Problem(f"{told} with: {command}")
    return {cell.name: loaded[cell.name.scene, filter_of(cell.spec)] for cell in cells}


# --- judging ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Kept:
    """What was blessed of each cell, or why there is nothing to go by."""

    blessed: Mapping[CellName, Blessed]
    problems: Mapping[CellName, str] = field(default_factory=dict)


def judged(seen: Seen) -> Run:
    """All verdicts on what was rendered. All tests are counted before the first is made."""
    kept = _kept(seen)
    there = {name: each for name, each in seen.observed.items() if isinstance(each, Observed)}
    tests = sum((count(each, kept.blessed.get(name)) for name, each in there.items()), Tests())
    chances = shared(tests, seen.asked.significance)
    cells = tuple(_verdict(cell, seen, kept, chances) for cell in seen.cells)
    plain = {cell.name: cell.checks for cell in cells}
    run = Run(
        started=seen.started,
        wall_seconds=seen.wall_seconds,
        revision=places.revision(),
        machine=places.machine(),
        versions={**seen.versions, **_plugins()},
        command=seen.asked.command,
        significance=seen.asked.significance,
        tests=tests.total,
        replicates=seen.asked.replicates,
        cells=cells,
        controls=tuple(_control(each, kept, chances, plain[each.name]) for each in seen.injected),
        empty=seen.empty,
        skipped=seen.skipped,
    )
    return records_shared(run)


def _plugins() -> dict[str, str]:
    return {f"plugin {name}": plugin.sha256 for plugin in samplers.plugins() for name in plugin.samplers}


def _kept(seen: Seen) -> _Kept:
    """The blessed figures of all cells, each file loaded once; those of another scene, size, filter or draws, and those
    of a file that was edited, are refused."""
    blessed: dict[CellName, Blessed] = {}
    problems: dict[CellName, str] = {}
    setting = _setting(seen)
    files: dict[tuple[str, str], Mapping[str, Blessed] | str] = {}
    for cell in seen.cells:
        key = cell.name.scene, cell.name.renderer
        called = seen.called.get(cell.name.scene, "")
        if key not in files:
            try:
                files[key] = blessed_files.load(seen.asked.references, *key, called, setting)
            except CheckFailed as error:
                files[key] = str(error)
        modes = files[key]
        advice = f"look at it, and bless it with: {commands.bless(cell.name, called, setting)}"
        if isinstance(modes, str):
            problems[cell.name] = modes
        elif cell.name.mode not in modes:
            problems[cell.name] = f"nothing was blessed of it; {advice}"
        else:
            found = modes[cell.name.mode]
            scene, filter_ = cell.file.scene, filter_of(cell.spec)
            reason = mismatch(found, scene.digest(), scene.view.size, filter_, cell.draws)
            if reason:
                problems[cell.name] = f"{reason}; {advice}"
            else:
                blessed[cell.name] = found
    return _Kept(blessed, problems)


def _setting(seen: Seen) -> Setting:
    words = {cell.name.renderer: renderers.word_of(cell.name.renderer) for cell in seen.cells}
    return Setting(seen.asked.references, seen.asked.options, words)


def _verdict(cell: Cell, seen: Seen, kept: _Kept, chances: Chances) -> CellVerdict:
    called, setting = seen.called.get(cell.name.scene, ""), _setting(seen)
    verdict = CellVerdict(
        cell.name,
        again=commands.again(cell.name, called, setting),
        bless=commands.bless(cell.name, called, setting),
    )
    found = seen.observed[cell.name]
    if isinstance(found, Problem):
        return replace(verdict, problem=found.text, failed=found.failed)
    blessed = kept.blessed.get(cell.name)
    if blessed and blessed.observed.names != found.names:
        return replace(verdict, problem=f"was blessed with other templates; {verdict.bless}", observed=found)
    checks = judge(found, blessed, chances, places.machine())
    return replace(verdict, checks=checks, problem=kept.problems.get(cell.name, ""), observed=found)


def _control(injected: Injected, kept: _Kept, chances: Chances, plain: Sequence[Check]) -> Control:
    """Whether a defect was caught: by a check that its cell passes without it, if there is one."""
    found = injected.observed
    if isinstance(found, Problem):
        return Control(injected.defect, injected.name, False, problem=found.text)
    failed = [check for check in judge(found, kept.blessed.get(injected.name), chances) if not _fine(check)]
    before = {(check.family, check.about) for check in plain if not _fine(check)}
    telling = [check for check in failed if (check.family, check.about) not in before] or failed
    by = f"{telling[0].family}: {telling[0].about}" if telling else ""
    problem = "" if telling or injected.name in kept.blessed else kept.problems.get(injected.name, "")
    return Control(injected.defect, injected.name, bool(telling), by, problem)


def _fine(check: Check) -> bool:
    return check.passed or check.warning
