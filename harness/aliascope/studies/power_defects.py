"""Defects that are put into the pictures of a cell, or into what draws them, and what is observed of it then.

The cell is rendered without the defect, which stands for what was blessed, and with it at the same draws.
`power_caught` judges the two.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from aliascope.errors import CheckFailed
from aliascope.native import samplers
from aliascope.records import Cost, Pixels
from aliascope.regression.defects import DEFECTS, FIRST, WIDER, Defect, firefly, not_a_number
from aliascope.regression.observe import Observer, Target
from aliascope.regression.records import Draw, Observed
from aliascope.studies.power_drawn import drawn
from aliascope.studies.power_pool import observed_of, pictures, request_of
from aliascope.studies.regress_suite import Cell

FIRST_SEED = 1 << 46
"""Of the repetitions with fresh seeds."""

REPEATED = (
    *("gain 1 %", "offset 1/255", "shift right", "shift down", "wider filter", "wider samples", "dimension repeated"),
)
"""Those that chance could hide; the others are caught by what they are."""

PLACES = 20
"""Where a single pixel is put, one after the other."""

Made = Sequence[tuple[Draw, Pixels, Cost]]


@dataclass(frozen=True)
class Injected:
    """A cell without a defect, and with each: observed, or why there was nothing to observe. `placed`: those of a
    single pixel, at each of PLACES."""

    plain: Observed
    wrong: Mapping[str, Observed | str]
    placed: Mapping[str, tuple[Observed, ...]]


def code() -> str:
    """A hash of what defects are."""
    here = Path(__file__)
    files = (here, here.with_name("power_drawn.py"), here.parents[1] / "regression" / "defects.py")
    plugins = [plugin.sha256 for plugin in samplers.plugins()]
    return hashlib.sha256(b"".join(path.read_bytes() for path in files) + repr(plugins).encode()).hexdigest()


def draws_of(cell: Cell, repetition: int) -> tuple[Draw, ...]:
    """Those of the suite, or from repetition 1 on fresh seeds."""
    if repetition == 0:
        return cell.draws
    first = FIRST_SEED + (repetition << 16)
    return tuple(Draw(seed=first + number) for number in range(len(cell.draws)))


def inject(cell: Cell, target: Target, names: Sequence[str], repetition: int, time_limit: float) -> Injected:
    """Renders a cell without and with these defects, those that apply to it. Runs in a worker process."""
    draws = draws_of(cell, repetition)
    made, quantum = pictures(cell, draws, time_limit)
    plain = observed_of(cell, target, made, quantum)
    wrong: dict[str, Observed | str] = {}
    placed: dict[str, tuple[Observed, ...]] = {}
    largest = float(target.reference.max())
    for name in names:
        defect = firefly(largest) if name == "firefly" else DEFECTS[name]
        if not defect.applies(cell.file.scene, cell.name.renderer, cell.spec):
            continue
        try:
            wrong[name] = observed_of(cell, target, _with(cell, defect, made, draws, time_limit), quantum)
        except CheckFailed as error:
            wrong[name] = str(error)
        if name in ("firefly", "one NaN"):
            placed[name] = _placed(name, largest, target, made, plain)
    return Injected(plain, wrong, placed)


def _with(cell: Cell, defect: Defect, made: Made, draws: Sequence[Draw], time_limit: float) -> Made:
    if defect.picture is not None:
        # A defect of one replicate is in that whose draw is first in the suite.
        stands_for = [FIRST, *draws[1:]]
        return [
            (draw, defect.picture(pixels, stand_in), cost)
            for stand_in, (draw, pixels, cost) in zip(stands_for, made, strict=True)
        ]
    found: list[tuple[Draw, Pixels, Cost]] = []
    drawn_already: dict[tuple[int, tuple[float, float]], tuple[Pixels, Cost]] = {}
    for draw in draws:
        request = request_of(cell, draw, time_limit)
        asked = defect.request(request) if defect.request is not None else request
        key = asked.seed, asked.shift
        if key not in drawn_already:
            rendering = drawn(cell.name.renderer, asked, WIDER if defect.request is None else 0.0)
            drawn_already[key] = rendering.pixels, rendering.cost
        found.append((draw, *drawn_already[key]))
    return found


def _placed(name: str, largest: float, target: Target, made: Made, plain: Observed) -> tuple[Observed, ...]:
    """A single pixel at places all over the picture, in the first replicate; the variance is left as it is."""
    random = np.random.Generator(np.random.PCG64(PLACES))
    draw, pixels, cost = made[0]
    found = []
    for right, down in random.random((PLACES, 2)).tolist():
        defect = firefly(largest, (right, down)) if name == "firefly" else not_a_number((right, down))
        assert defect.picture is not None
        replicate = Observer(target).part([(draw, defect.picture(pixels, FIRST), cost)]).replicates[0]
        found.append(replace(plain, replicates=(replicate, *plain.replicates[1:])))
    return tuple(found)
