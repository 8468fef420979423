"""What each safeguard of the arithmetic costs: CPU time of a picture with it over that without, in turn, on the scenes
of `scenes/` that are named, else on five. Modes are those that `aliascope knobs` turns; its table has all scenes and
the errors, this the ratios to a hundredth."""

from __future__ import annotations

import statistics
import sys

from aliascope import renderers, scene_io
from aliascope.errors import AliascopeError
from aliascope.model import Scene
from aliascope.renderers.base import Request

SIZE = (128, 96)
SCENES = ("edge", "spheres", "siemens-star", "terrain", "depth-of-field")
ROUNDS = 21
SPAN = 5, 15
"""The order statistics of ROUNDS ratios between which their median lies with a probability of 97 %."""

SAFEGUARDS = (
    ("embree", "relative to the eye, in double", "uniform", "uniform:relative=off"),
    ("embree", "a second look at rays through corners", "uniform", "uniform:again=off"),
    ("embree", "robust intersection", "uniform", "uniform:robust=off"),
    ("embree", "a film of doubles", "uniform", "uniform:film=float"),
    ("embree", "compensated sums, over doubles", "uniform:film=compensated", "uniform"),
    ("osmesa", "moved to the origin", "accumulate", "accumulate:recentre=0"),
    ("povray", "moved to the origin", "none", "none:recentre=0"),
    ("povray", "light divided by a power of two", "none", "none:exposure=off"),
)
"""(renderer, safeguard, mode with it, mode without)."""


def seconds(renderer: str, mode: str, scene: Scene) -> float:
    """CPU time of one picture."""
    found = renderers.find(renderer)
    width, height = SIZE
    request = Request(scene=scene, width=width, height=height, mode=renderers.mode_of(found, mode), least_seconds=0.02)
    return found.render(request).cost.cpu_seconds


def ratios(renderer: str, guarded: str, bare: str, scene: Scene) -> list[float]:
    """Of ROUNDS rounds, in order of size."""
    seconds(renderer, guarded, scene)  # the first makes what is kept between pictures
    return sorted(seconds(renderer, guarded, scene) / seconds(renderer, bare, scene) for _ in range(ROUNDS))


def main() -> None:
    names = sys.argv[1:] or SCENES
    print(
        f"the price of each safeguard: time with it over time without, median of {ROUNDS} rounds in turn and its "
        f"interval of 97 %; {SIZE[0]}x{SIZE[1]}"
    )
    for renderer, safeguard, guarded, bare in SAFEGUARDS:
        for name in names:
            scene = scene_io.load(name).scene
            try:
                found = ratios(renderer, guarded, bare, scene)
            except AliascopeError as error:
                print(f"  {renderer:8}{safeguard:40}{name:16} not drawn: {str(error).partition(': ')[0]}")
                continue
            low, high = (found[place] for place in SPAN)
            print(f"  {renderer:8}{safeguard:40}{name:16}{statistics.median(found):5.2f} [{low:.2f}, {high:.2f}]")


if __name__ == "__main__":
    main()
