"""`aliascope doctor`: what is installed, and the conventions of each renderer, measured rather than believed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from aliascope import places, renderers
from aliascope.errors import AliascopeError, NotAvailable
from aliascope.model import Scene
from aliascope.records import Pixels
from aliascope.renderers.base import Renderer, Request

SIZE = 48
CENTRE_TOLERANCE = 0.01
RESPONSE_TOLERANCE = 1e-4
LEVELS = (0.0123, 0.0521, 0.1173, 0.2619, 0.5037, 0.7871, 1.0)


@dataclass(frozen=True)
class Probes:
    """What was measured. `centre`: how far right and down of where it is an edge is found, in pixels. `gain` and
    `gamma`: output = gain * input^gamma, fitted; `deviation` the largest difference from output = input."""

    centre: tuple[float, float]
    gain: float
    gamma: float
    deviation: float

    @property
    def holds(self) -> bool:
        return max(map(abs, self.centre)) < CENTRE_TOLERANCE and self.deviation < RESPONSE_TOLERANCE


def _scene(polygons: list[tuple[list[tuple[float, float]], float]]) -> Scene:
    """Grey polygons, the later ones in front, in an orthographic view where a unit is a pixel and (0, 0) the middle."""
    return Scene.model_validate(
        {
            "title": "probe",
            "shows": "a probe",
            "view": {"size": (SIZE, SIZE)},
            "camera": {"type": "orthographic", "eye": (0, 0, 100), "look_at": (0, 0, 0), "height": float(SIZE)},
            "materials": {f"m{i}": {"emission": (level,) * 3} for i, (_, level) in enumerate(polygons)},
            "surfaces": [
                {"type": "polygon", "material": f"m{i}", "points": [(x, y, float(i)) for x, y in points]}
                for i, (points, _) in enumerate(polygons)
            ],
        }
    )


def _render(renderer: Renderer, scene: Scene) -> Pixels:
    mode = renderers.mode_of(renderer, renderer.probe_mode)
    return renderer.render(Request(scene, SIZE, SIZE, mode)).pixels


def _edge(renderer: Renderer, steep: bool) -> float:
    """How far up (right, where steep) of where it is a line is found, in the mean over the columns that it crosses.

    Its slope is irrational, near 1 : 8, so that each column meets another phase of the samples.
    """
    offset, reach, rise = 1.61803, 8.0 * SIZE, SIZE * (math.sqrt(5) - 1) * 0.8
    line = [(-reach, offset - rise), (reach, offset + rise), (reach, -reach), (-reach, -reach)]
    pixels = _render(renderer, _scene([([(y, x) if steep else (x, y) for x, y in line], 1.0)])).astype(np.float64)
    filled = pixels[:, :, 1].sum(axis=1 if steep else 0)
    return float(filled.mean() - SIZE / 2 - offset)


def probe(renderer: Renderer) -> Probes:
    """Measures a renderer. Raises AliascopeError where it does not render."""
    width = SIZE / len(LEVELS)
    strips: list[tuple[list[tuple[float, float]], float]] = []
    for i, level in enumerate(LEVELS):
        left, right = -SIZE / 2 + i * width, -SIZE / 2 + (i + 1) * width
        strips.append(([(left, -SIZE), (right, -SIZE), (right, SIZE), (left, SIZE)], level))
    row = _render(renderer, _scene(strips))[SIZE // 2, :, 1].astype(np.float64)
    middles = [int((i + 0.5) * width) for i in range(len(LEVELS))]
    shown = row[middles]
    gamma, intercept = np.polyfit(np.log(LEVELS), np.log(np.maximum(shown, 1e-9)), 1)
    return Probes(
        centre=(_edge(renderer, True), -_edge(renderer, False)),
        gain=math.exp(float(intercept)),
        gamma=float(gamma),
        deviation=float(np.abs(shown - LEVELS).max()),
    )


def examine() -> dict[str, Any]:
    """The document of `aliascope doctor --json`."""
    found = []
    for renderer in renderers.RENDERERS.values():
        entry: dict[str, Any] = {"name": renderer.name, "title": renderer.title, "there": True}
        try:
            entry["versions"] = dict(renderer.versions())
            probes = probe(renderer)
        except NotAvailable as error:
            entry |= {"there": False, "reason": str(error)}
        except AliascopeError as error:
            entry |= {"holds": False, "reason": str(error)}
        else:
            entry |= {
                "mode": renderer.probe_mode,
                "centre": list(probes.centre),
                "gain": probes.gain,
                "gamma": probes.gamma,
                "deviation": probes.deviation,
                "holds": probes.holds,
            }
        found.append(entry)
    return {
        "aliascope": places.own_version(),
        "revision": places.revision(),
        "machine": places.machine(),
        "renderers": found,
    }


def lines_of(document: Mapping[str, Any]) -> list[str]:
    """The same for people."""
    lines = [
        f"aliascope {document['aliascope']} ({document['revision']})",
        ", ".join(f"{name} {value}" for name, value in document["machine"].items()),
    ]
    for entry in document["renderers"]:
        if not entry["there"]:
            lines.append(f"{entry['title']}: not there: {entry['reason']}")
            continue
        versions = ", ".join(f"{name} {version}" for name, version in entry.get("versions", {}).items())
        lines.append(f"{entry['title']}: {versions}")
        if "centre" not in entry:
            lines.append(f"  does not render: {entry['reason']}")
            continue
        x, y = entry["centre"]
        lines += [
            f"  pixel centres ({entry['mode']}): {x:+.4f} right, {y:+.4f} down of where they should be, in pixels",
            f"  response: gain {entry['gain']:.5f}, gamma {entry['gamma']:.5f}; linear within {entry['deviation']:.1e}",
            "  pictures can be compared"
            if entry["holds"]
            else f"  PICTURES CANNOT BE COMPARED: centres must lie within {CENTRE_TOLERANCE} pixel, "
            f"the response within {RESPONSE_TOLERANCE}",
        ]
    return lines
