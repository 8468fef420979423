"""Which pictures a regression run makes, by what they are judged, and where its controls go."""

from __future__ import annotations

import difflib
import fnmatch
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from aliascope import plan, renderers
from aliascope.errors import InvalidInput, SpecError, near_misses
from aliascope.model import Scene
from aliascope.regression.defects import CONTROLS, Defect
from aliascope.regression.records import CellName, Draw, Judged
from aliascope.renderers.base import Renderer, lacks
from aliascope.scene_io import SceneFile
from aliascope.specs import Spec, split

REPLICATES = 16

OWEN = "sampler=sobol,sampler.scramble=owen"

_EMBREE_FLAT = (
    f"uniform:n=64,{OWEN}",
    "uniform:n=16,sampler=random",
    "uniform:n=16,sampler=jittered",
    "uniform:n=16,sampler=regular",
    "adaptive:method=kajiya,n=64",
)
_EMBREE_SPREAD = (
    f"uniform:n=64,{OWEN}",
    "uniform:n=16,sampler=random",
    "uniform:n=16,sampler=jittered",
    "uniform:n=16,sampler=halton",
    "adaptive:method=mitchell,n=96",
)
_ACCUMULATE = ("accumulate:n=16,sampler=halton", f"accumulate:n=16,{OWEN}")

SUITE: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "embree": {
        "plain": _EMBREE_FLAT,
        "lens": (f"uniform:n=256,{OWEN}", *_EMBREE_SPREAD[1:]),
        "area light": _EMBREE_SPREAD,
        "frames": _EMBREE_SPREAD,
        "gloss": _EMBREE_SPREAD,
        "heavy": _EMBREE_FLAT,
        "bounces": (f"uniform:n=64,{OWEN}", "uniform:n=16,sampler=random", "uniform:n=4,sampler=halton"),
    },
    "povray": {
        "gloss": ("none",),
        "heavy": ("am2:depth=3",),
        "plain": ("none", "am1:depth=3", "am2:depth=3", "regular:n=16"),
        "lens": ("focal-blur", f"accumulate:n=16,{OWEN}"),
        "area light": ("none", f"accumulate:n=16,{OWEN}"),
        "frames": (f"accumulate:n=16,{OWEN}",),
        "bounces": ("none",),
    },
    "osmesa": {
        "gloss": ("none",),
        "heavy": ("none",),
        "plain": ("none", "msaa:n=4", *_ACCUMULATE),
        "lens": _ACCUMULATE,
        "area light": _ACCUMULATE,
        "frames": _ACCUMULATE,
        "bounces": ("none",),
    },
}
"""By renderer and kind of scene (`kind_of`): one mode that goes to the integral, with few samples and with more; one of
each other kind. Where a renderer draws nothing of a kind, one mode stands for the reason. All of it takes 300 s of CPU
time, a third of that POV-Ray's, and has to end in 4 minutes on two cores."""

UNBIASED: Mapping[str, frozenset[str]] = {
    "random": frozenset({""}),
    "jittered": frozenset({""}),
    "multi-jittered": frozenset({""}),
    "correlated-multi-jittered": frozenset({""}),
    "n-rooks": frozenset({""}),
    "latin-square": frozenset({""}),
    "orthogonal-array": frozenset({""}),
    "pmj02": frozenset({""}),
    "halton": frozenset({"shift", "digit", "owen"}),
    "hammersley": frozenset({"shift", "digit", "owen"}),
    "sobol": frozenset({"shift", "digit", "owen"}),
}
"""Samplers, by their scrambles, each of whose points is uniform in the cell by itself: their means are without bias at
any count. Measured in tests/python/test_regression.py. Any other key of such a sampler takes it out of this table."""

CONTROL_SCENE = "siemens-star"
CONTROL_MODES: Mapping[str, tuple[str, ...]] = {
    "embree": (f"uniform:n=64,{OWEN}",),
    "povray": ("regular:n=16", f"accumulate:n=16,{OWEN}"),
    "osmesa": (f"accumulate:n=16,{OWEN}",),
}
"""Where the controls go, the first that a run has."""


@dataclass(frozen=True)
class Cell:
    """A cell to render. `spec` is its parsed mode."""

    name: CellName
    file: SceneFile
    spec: Spec
    judged: Judged
    draws: tuple[Draw, ...]


def judged_by(renderer: str, mode: Spec) -> Judged:
    """The reference judges modes whose mean over seeds is the integral; what else there is has a bias by design. Of a
    renderer that is none of ours nobody knows: it is held to what was blessed."""
    if renderer not in SUITE or mode.name not in ("uniform", "accumulate"):
        return "blessed"
    name, pairs = split(mode.word("sampler"))
    scramble = pairs.pop("scramble", "")
    return "reference" if scramble in UNBIASED.get(name, ()) and not pairs else "blessed"


def draws_of(renderer: Renderer, mode: Spec, replicates: int = REPLICATES) -> tuple[Draw, ...]:
    """The seeds 0, 1, ... of a mode that has one, else as many shifts: none, then uniform ones, always the same."""
    if renderer.seeded(mode):
        return tuple(Draw(seed=seed) for seed in range(replicates))
    shifts = np.random.Generator(np.random.PCG64(8)).random((replicates - 1, 2))
    return (Draw(), *(Draw(shift=(float(right), float(down))) for right, down in shifts))


def kind_of(scene: Scene) -> str:
    """As `plan.kind_of`; but glossy mirrors, which give samples more dimensions, are no plain scene."""
    kind = plan.kind_of(scene)
    return "gloss" if kind in ("plain", "heavy") and scene.needs().gloss else kind


def suite_of(renderer: Renderer) -> Mapping[str, tuple[str, ...]]:
    """The modes of the suite by kind of scene; of a renderer that is none of ours its quick profile, for all."""
    if renderer.name in SUITE:
        return SUITE[renderer.name]
    return dict.fromkeys(SUITE["embree"], renderers.of_profile(renderer, "quick"))


def modes_of(renderer: str, scene: Scene, wanted: Sequence[str] = ()) -> list[Spec]:
    """The modes of a scene: those of the suite; or of the words of -m those with a wildcard chosen among these, others
    as they are where the renderer has them. Raises SpecError."""
    found = renderers.find(renderer)
    own = {spec.text: spec for spec in (renderers.mode_of(found, text) for text in suite_of(found)[kind_of(scene)])}
    if not wanted:
        return list(own.values())
    chosen: dict[str, Spec] = {}
    for text in wanted:
        if set("*?[") & set(text):
            chosen.update({name: own[name] for name in fnmatch.filter(own, text)})
        elif split(text)[0] in found.modes:
            spec = renderers.mode_of(found, text)
            chosen[spec.text] = spec
    return list(chosen.values())


def check_modes(names: Sequence[str], wanted: Sequence[str]) -> None:
    """Raises SpecError for a word of -m that chooses nothing in any of these renderers."""
    known = {name: renderers.find(name) for name in names}
    texts = {
        name: {renderers.mode_of(known[name], mode).text for modes in suite_of(known[name]).values() for mode in modes}
        for name in names
    }
    for text in wanted:
        wild = set("*?[") & set(text)
        hits = (fnmatch.filter(texts[name], text) if wild else split(text)[0] in known[name].modes for name in names)
        if not any(hits):
            forms = [form for renderer in known.values() for form in renderer.modes]
            raise SpecError(f'no mode "{text}" of {", ".join(names)}{near_misses(text.partition(":")[0], forms)}')


def cells_of(
    files: Sequence[SceneFile], names: Sequence[str], wanted: Sequence[str] = (), replicates: int = REPLICATES
) -> tuple[list[Cell], list[tuple[CellName, str]]]:
    """The cells of a run, and those that stay empty, with the reason. Raises SpecError."""
    check_modes(names, wanted)
    cells: list[Cell] = []
    empty: list[tuple[CellName, str]] = []
    for file in files:
        for name in names:
            renderer = renderers.find(name)
            for spec in modes_of(name, file.scene, wanted):
                cell = CellName(file.name, name, spec.text)
                reason = lacks(renderer, file.scene, spec) or _undrawn(renderer, spec)
                if reason:
                    empty.append((cell, reason))
                else:
                    draws = draws_of(renderer, spec, replicates)
                    cells.append(Cell(cell, file, spec, judged_by(name, spec), draws))
    return cells, empty


def _undrawn(renderer: Renderer, mode: Spec) -> str | None:
    """Why there is one picture of a mode, where there have to be several."""
    if renderer.seeded(mode) or renderer.shifts:
        return None
    return "it has no seed, and its film cannot be moved: all its pictures are one (give it {seed}, or {shift.x})"


def matching(patterns: Sequence[str], cells: Sequence[Cell]) -> set[str]:
    """The texts of the cells that patterns of the shell match. Raises InvalidInput for one that matches none, with the
    near misses: not all cells, which are many."""
    texts = [cell.name.text for cell in cells]
    found: set[str] = set()
    for pattern in patterns:
        hits = set(fnmatch.filter(texts, pattern)) | ({pattern} & set(texts))
        if not hits:
            groups = {f"{cell.name.scene}/{cell.name.renderer}/*" for cell in cells}
            close = difflib.get_close_matches(pattern, [*sorted(groups), *texts], n=3)
            raise InvalidInput(f'no cell matches "{pattern}"{near_misses(pattern, close or groups)}')
        found |= hits
    return found


def controls_of(cells: Sequence[Cell]) -> list[Cell]:
    """The cells that the controls go into: one of each renderer, on CONTROL_SCENE if the run has it."""
    chosen = []
    for renderer in dict.fromkeys(cell.name.renderer for cell in cells):
        own = [cell for cell in cells if cell.name.renderer == renderer]
        own = [cell for cell in own if cell.name.scene == CONTROL_SCENE] or own
        best = [renderers.mode_of(renderers.find(renderer), text).text for text in CONTROL_MODES.get(renderer, ())]
        telling = [cell for text in best for cell in own if cell.name.mode == text]
        chosen.append((telling or own)[0])
    return chosen


def controls_in(cell: Cell) -> tuple[Defect, ...]:
    """The controls that can be put into a cell: where the film cannot be moved, none is moved."""
    moves = renderers.find(cell.name.renderer).shifts
    return tuple(defect for defect in CONTROLS if moves or not defect.name.startswith("shift"))
