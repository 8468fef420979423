"""A process of its own, with the sampler `not-finite` loaded: what each that takes its samples says of them, as JSON.

python -m aliascope.stability.plugged NOT_FINITE.so COUNT
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterator
from functools import partial

from aliascope import renderers
from aliascope.errors import AliascopeError, NotAvailable
from aliascope.model import Scene
from aliascope.native import estimate, samplers
from aliascope.renderers.base import Request

SAMPLES = 256
FIRST = 37
"""The first sample that is none."""

MODES = {"embree": "uniform", "osmesa": "accumulate", "povray": "accumulate"}


def main(path: str, count: str) -> None:
    samplers.load_plugin(path, trusted=True)
    found: dict[str, list[tuple[str, str]]] = {}
    for component, act, names in _acts(count):
        found.setdefault(component, []).append((_told(act), names))
    json.dump(found, sys.stdout)


def _told(act: Callable[[], object]) -> str:
    try:
        return f"not refused: {act()!r:.80}"
    except NotAvailable as absent:
        return f"absent: {absent}"
    except AliascopeError as refusal:
        return str(refusal)


def _acts(count: str) -> Iterator[tuple[str, Callable[[], object], str]]:
    for value, shown in (("nan", "-?nan"), ("inf", "inf"), ("negative", "-inf")):
        bad = f"not-finite:value={value},first={FIRST},count={count}"
        names = rf"sampler not-finite:.* {shown} as number 1 of sample {FIRST} of pixel \(0, 0\)"
        yield "sampler-plugin", partial(_points, bad), names
        for info in estimate.registered():
            # Whitted's takes samples in the order of corners.
            own = names if info.name != "whitted" else names.replace(f"sample {FIRST} ", r"sample \d+ ")
            yield f"{info.name}:sampler=plugin", partial(_estimated, info.name, bad), own
        for name in MODES:
            yield f"{name}:sampler=plugin", partial(_drawn, name, bad), names
        weights = f"not-finite:of=weights,value={value},first={FIRST},count={count}"
        of_weight = rf"sampler not-finite:.* gives sample {FIRST} the weight {shown}"
        yield "sampler-plugin", partial(_weights, weights), of_weight
        yield "fixed:sampler=plugin", partial(_estimated, "fixed", weights), of_weight
        yield "embree:sampler=plugin", partial(_drawn, "embree", weights), of_weight


def _points(sampler: str) -> object:
    return samplers.Sampler(sampler, SAMPLES).points(SAMPLES)


def _weights(sampler: str) -> object:
    return samplers.Sampler(sampler, SAMPLES).weights(SAMPLES)


def _estimated(name: str, sampler: str) -> object:
    return estimate.Estimator(name, sampler, SAMPLES).estimate(lambda points: points[:, 0])


def _drawn(name: str, sampler: str) -> object:
    """A picture of nothing, of 2 x 2 pixels."""
    camera = {"type": "orthographic", "eye": (0.0, 0.0, 9.0), "look_at": (0.0, 0.0, 0.0), "height": 2.0}
    about = {"title": "none", "shows": "none", "view": {"size": (2, 2)}, "camera": camera, "materials": {}}
    renderer = renderers.find(name)
    inner = re.sub("[:,]", ",sampler.", sampler)
    mode = renderers.mode_of(renderer, f"{MODES[name]}:n={SAMPLES},sampler={inner}")
    return renderer.render(Request(Scene.model_validate(about), 2, 2, mode))


if __name__ == "__main__":
    main(*sys.argv[1:])
