"""The whole analysis: each scene, then all of them together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from aliascope.records import SceneSection
from aliascope.trade import targets
from aliascope.trade.convergence import convergence, efficiency
from aliascope.trade.front import front, front_over
from aliascope.trade.knobs import knobs
from aliascope.trade.ratios import Compared, base_family, ratios
from aliascope.trade.reach import afford, at_time, families, reach, to_error
from aliascope.trade.records import QUANTISATION, SceneTrade, Trade
from aliascope.trade.uncertainty import Points, points


def analyse(scenes: Sequence[SceneSection], seed: int = 0, together: Sequence[str] = ()) -> Trade:
    """The trade of speed for accuracy from the rows of a comparison. The same rows and seed give the same figures,
    whatever the order of rows.

    Modes without an RMSE or a time above 0 are left out; a scene without any other stays, empty. Ratios are over the
    scenes under the filter of the first. The front over several scenes is over those named in `together`.
    """
    measured = points(scenes, seed)
    found = [_scene(own) for own in measured]
    first = next((scene.filter for scene in scenes if scene.rows), "box")
    pooled = [each for each, scene in zip(found, scenes, strict=True) if scene.filter == first]
    base = base_family([each.on_front for each in pooled])
    told = ratios([each.compared for each in pooled], base) if base else ()
    over_all = front_over([own for own in measured if own.scene in together])
    return Trade(tuple(each.trade for each in found), told, base, knobs(scenes, measured), over_all)


@dataclass(frozen=True)
class _Scene:
    """One scene, and what the pooling over scenes takes from it."""

    trade: SceneTrade
    compared: Compared
    on_front: dict[tuple[str, str], float]


def _scene(points: Points) -> _Scene:
    own = families(points)
    errors, times = targets.errors(points), targets.times(points)
    on_front = front(points)
    surest: dict[tuple[str, str], float] = {}
    of_mode = {(row.renderer, row.mode): (row.renderer, row.family) for row in points.rows}
    for mode in on_front:
        name = of_mode[mode.renderer, mode.mode]
        surest[name] = max(surest.get(name, 0.0), mode.probability)
    compared = Compared(
        points.scene,
        {family.name: family for family in own},
        {family.name: [to_error(family, error) for error in errors] for family in own},
        {family.name: [at_time(family, seconds) for seconds in reversed(times)] for family in own},
    )
    trade = SceneTrade(
        scene=points.scene,
        front=on_front,
        equal_error=tuple(
            reach(family, errors[i], compared.to_error[family.name][i]) for i in targets.few(errors) for family in own
        ),
        equal_time=tuple(
            afford(family, times[i], compared.at_time[family.name][-1 - i])
            for i in targets.few(times)
            for family in own
        ),
        quantisation=tuple(reach(family, QUANTISATION, to_error(family, QUANTISATION)) for family in own),
        convergence=tuple(convergence(points).values()),
        efficiency=efficiency(points),
    )
    return _Scene(trade, compared, surest)
