"""The conventions of a renderer, measured rather than believed: where it has its pixels, whether its output is linear.

All of it is read off one picture, of three panels above each other: strips of known levels, an edge that crosses the
columns, and one that crosses the rows.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from aliascope import jobs, renderers
from aliascope.errors import AliascopeError, NotAvailable
from aliascope.geometry import Array
from aliascope.model import Scene
from aliascope.pipeline import Options, Progress
from aliascope.records import Outcome, Probe, ProbeLimits
from aliascope.renderers.base import Renderer, Request
from aliascope.store import Store
from aliascope.workers import Pool

LIMITS = ProbeLimits(centre=0.01, response=1e-4)
SIZE = 48
"""The side of a panel, in pixels."""
SPACING = SIZE + 12
HEIGHT = SIZE + 2 * SPACING
MARGIN = 4
"""How far beyond its panel what is drawn goes: what the renderer does at its ends is not looked at."""
LEVELS = (0.0123, 0.0521, 0.1173, 0.2619, 0.5037, 0.7871, 1.0)
STRIP = SIZE / len(LEVELS)
OFFSET = 1.61803
SLOPE = (math.sqrt(5) - 1) / 10
"""Irrational, near 1 : 8, so that each column or row that an edge crosses meets another phase of the samples."""

Quad = list[tuple[float, float]]


def scene() -> Scene:
    """Grey polygons in an orthographic view where a unit is a pixel and (0, 0) the middle."""
    reach = SIZE / 2 + MARGIN
    strips: list[tuple[Quad, float]] = []
    for i, level in enumerate(LEVELS):
        left = -SIZE / 2 + i * STRIP
        corners = ((left, -reach), (left + STRIP, -reach), (left + STRIP, reach), (left, reach))
        strips.append(([(x, y + SPACING) for x, y in corners], level))
    ends = [(end, OFFSET + SLOPE * end) for end in (-reach, reach)]
    flat = [*ends, (reach, -reach), (-reach, -reach)]
    steep = [(x, y - SPACING) for y, x in flat]
    drawn = [*strips, (flat, 1.0), (steep, 1.0)]
    return Scene.model_validate(
        {
            "title": "probe",
            "shows": "Where a renderer has its pixels, and whether its output is linear.",
            "view": {"size": (SIZE, HEIGHT)},
            "camera": {"type": "orthographic", "eye": (0, 0, 100), "look_at": (0, 0, 0), "height": float(HEIGHT)},
            "materials": {f"m{i}": {"emission": (level,) * 3} for i, (_, level) in enumerate(drawn)},
            "surfaces": [
                {"type": "polygon", "material": f"m{i}", "points": [(x, y, 0.0) for x, y in points]}
                for i, (points, _) in enumerate(drawn)
            ],
        }
    )


def measure(renderer: Renderer, time_limit: float = Request.time_limit) -> Probe:
    """Measures a renderer. Raises AliascopeError where it does not render."""
    mode = renderers.mode_of(renderer, renderer.probe_mode)
    request = Request(scene(), SIZE, HEIGHT, mode, time_limit=time_limit)
    green = renderer.render(request).pixels[:, :, 1].astype(np.float64)
    strips, flat, steep = (green[top : top + SIZE] for top in (0, SPACING, 2 * SPACING))
    shown = strips[SIZE // 2, [int((i + 0.5) * STRIP) for i in range(len(LEVELS))]]
    gamma, intercept = np.polyfit(np.log(LEVELS), np.log(np.maximum(shown, 1e-9)), 1)
    deviation = float(np.abs(shown - LEVELS).max())
    # Of a picture moved by (right, up): above = up - SLOPE right, beside = right - SLOPE up.
    above, beside = _found(flat, 0), _found(steep, 1)
    right, up = ((a + SLOPE * b) / (1 - SLOPE**2) for a, b in ((beside, above), (above, beside)))
    centre = right, -up
    return Probe(
        renderer=renderer.name,
        mode=renderer.probe_mode,
        holds=max(map(abs, centre)) < LIMITS.centre and deviation < LIMITS.response,
        centre=centre,
        gain=math.exp(float(intercept)),
        gamma=float(gamma),
        deviation=deviation,
    )


def _found(panel: Array, axis: int) -> float:
    """How far up (axis 0) or right (1) of where it is the edge is found, in the mean over what it crosses."""
    return float(panel.sum(axis=axis).mean() - SIZE / 2 - OFFSET)


# --- in a comparison --------------------------------------------------------------------------------------------------


def of_those_that_drew(
    outcomes: Iterable[Outcome],
    skipped: Mapping[str, str],
    store: Store,
    options: Options,
    progress: Progress,
    workers: Pool | None,
) -> tuple[Probe, ...]:
    """What holds of each renderer that took part: from the store, where it was measured of this version, else measured
    and kept. A renderer that is not there or made no picture is not probed, and one whose probe fails stops nothing:
    the reason is in their place. They come first, then what does not hold. Without `workers` nothing is measured."""
    drew: dict[str, bool] = {}
    for outcome in outcomes:
        name = outcome.job.renderer
        drew[name] = drew.get(name, False) or outcome.status == "done"
    found = [_without(name, f"not there: {reason}") for name, reason in skipped.items()]
    found += [_without(name, "none of its pictures was made") for name, some in drew.items() if not some]
    wanted = [name for name in renderers.RENDERERS if drew.get(name)]
    keys = {name: _key(renderers.find(name)) for name in wanted}
    kept = {name: store.probe(key) for name, key in keys.items()}
    begun = {
        name: workers.begin(measure_named, [name, options.time_limit], options.time_limit, {"probe": name})
        for name in wanted
        if kept[name] is None and workers is not None
    }
    for name in wanted:
        if kept[name] is None and workers is None:
            kept[name] = _without(name, "interrupted before it was probed")
    for count, (name, task) in enumerate(begun.items()):
        progress(f"probing {name}", count, len(begun))
        try:
            kept[name] = task.result()
        except AliascopeError as error:
            kept[name] = _without(name, f"its probe failed: {error}")
    for name in begun:
        probe = kept[name]
        assert probe is not None
        store.put_probe(keys[name], probe)
    found += [probe for probe in kept.values() if probe is not None]
    return tuple(sorted(found, key=lambda probe: (probe.centre is not None, probe.holds)))


def warning_of(probe: Probe) -> str:
    """What a person has to know of a renderer whose pictures were made and cannot be compared; else nothing."""
    if probe.centre is None or probe.holds:
        return ""
    x, y = probe.centre
    return (
        f"{probe.renderer}: PICTURES CANNOT BE COMPARED: pixel centres {x:+.4f} right, {y:+.4f} down (within "
        f"{LIMITS.centre} pixel), response off by {probe.deviation:.1e} (within {LIMITS.response})"
    )


def measure_named(name: str, time_limit: float = Request.time_limit) -> Probe:
    """`measure`, in a worker process."""
    return measure(renderers.find(name), time_limit)


def _without(name: str, reason: str) -> Probe:
    return Probe(name, renderers.find(name).probe_mode, holds=False, reason=reason)


def _key(renderer: Renderer) -> str:
    """A hash of all that the figures depend on: what renders them, and what draws and reads the panels."""
    mode = renderers.mode_of(renderer, renderer.probe_mode)
    try:
        versions = dict(renderer.versions())
    except NotAvailable:  # gone since the plan was made: its probe says so
        versions = {}
    code = [jobs.code_digest(renderer.name, mode), hashlib.sha256(Path(__file__).read_bytes()).hexdigest()]
    contents = [renderer.name, mode.text, versions, code]
    return hashlib.sha256(json.dumps(contents, sort_keys=True).encode()).hexdigest()[:32]
