"""What is known of how renderers differ, with its size: bounds that all pictures have, disagreements that some have.

Neither is ever silent: bounds are listed with every run, and a disagreement that is known is shown with its reason.
"""

from __future__ import annotations

from dataclasses import dataclass

from aliascope.model import Scene

FLOAT32 = 2.0**-24
"""Pictures are float32: half an ulp, relative to the value."""

SNAPPED = 0.0014
"""Pixels by which OSMesa's edges of triangles may lie off in the mean of passes: corners are snapped to 1/256 pixel
(csrc/raster/raster.c, EDGE_BIAS_PX)."""

BOUNDS = (
    ("step of the output", "Half of it: POV-Ray writes 16 bits, rounded to the nearest, 7.6e-6 where white is 1."),
    (
        "snapped corners",
        f"OSMesa's edges of triangles lie within {SNAPPED:g} pixel in the mean of passes: as much times the total "
        "variation across outlines within a pixel, that is, their contrast times their length.",
    ),
    (
        "float32",
        "Pictures of 24 bits: 6.0e-8 of the value; for each sample in renderers that are not the project's own, which "
        "may sum in float32.",
    ),
)


@dataclass(frozen=True)
class Known:
    """A disagreement whose reason was found: of a pair of renderers, in their order, on scenes of some names or with
    all of some features. `most`: the largest difference of a value, block or picture that the reason accounts for."""

    pair: frozenset[str]
    reason: str
    most: float
    scenes: frozenset[str] = frozenset()
    features: frozenset[str] = frozenset()

    def is_about(self, name: str, scene: Scene, pair: frozenset[str]) -> bool:
        """Whether it may show on a scene."""
        named = name in self.scenes if self.scenes else self.features <= scene.features()
        return named and pair == self.pair


KNOWN: tuple[Known, ...] = ()


def known_of(name: str, scene: Scene, one: str, other: str) -> tuple[Known, ...]:
    """Those that a pair of renderers may show on a scene."""
    pair = frozenset({one, other})
    return tuple(each for each in KNOWN if each.is_about(name, scene, pair))


def displaced(renderer: str, scene: Scene) -> float:
    """Pixels by which the edges of a scene may lie off in a renderer's pictures."""
    triangles = bool({"polygon", "mesh"} & scene.features())
    return SNAPPED if renderer == "osmesa" and triangles else 0.0
