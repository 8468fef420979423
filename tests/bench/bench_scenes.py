"""The tracer's rate on each scene of `scenes/`, or on those that are named, as a share of a bare loop over Embree on
the same rays: 16 samples a pixel, one thread. Given the library of kept_rays.c, which stands between the tracer and
Embree: it keeps a picture's rays and gives them to Embree again. Both are measured in turn, in CPU time of the
thread."""

from __future__ import annotations

import ctypes
import statistics
import sys
from dataclasses import dataclass

from aliascope import scene_io
from aliascope.model import Scene
from aliascope.native.tracer import Options, Tracer, TracerCost

SIZE = (128, 96)
SAMPLES = 16
ROUNDS = 21


class Counts(ctypes.Structure):
    """kept_counts of kept_rays.h."""

    intersected: int
    occluded: int
    hits: int
    _fields_ = (("intersected", ctypes.c_uint64), ("occluded", ctypes.c_uint64), ("hits", ctypes.c_uint64))


class Kept:
    """kept_rays.h. Made before the tracer's library is loaded, whose calls of Embree come to this one then."""

    def __init__(self, path: str) -> None:
        self._library = ctypes.CDLL(path, ctypes.RTLD_GLOBAL)
        self._library.kept_loop.restype = ctypes.c_double

    def begin(self) -> None:
        if not self._library.kept_begin():
            sys.exit("Embree's functions are not to be found behind those of the benchmark")

    def end(self) -> None:
        self._library.kept_end()

    def loop(self) -> tuple[float, Counts]:
        """CPU seconds of a bare loop, and what was kept."""
        counts = Counts()
        return float(self._library.kept_loop(ctypes.byref(counts))), counts


@dataclass(frozen=True)
class Rates:
    dimensions: int
    cost: TracerCost
    kept: Counts
    bare: float
    tracer: float
    shares: list[float]


def measure(kept: Kept, scene: Scene) -> Rates:
    tracer = Tracer(scene, SIZE)
    once = Tracer(scene, SIZE, options=Options(again=False))  # rays that are looked at again are the tracer's price

    def draw(made: Tracer = tracer) -> TracerCost:
        return made.render("sobol:scramble=owen", SAMPLES)[1]

    kept.begin()
    cost = draw(once)
    kept.end()
    pairs = []
    for _ in range(ROUNDS):
        seconds, counts = kept.loop()
        pairs.append((seconds, draw().cpu_seconds))
    traced = cost.primary_rays + cost.reflection_rays + cost.bounce_rays
    if (counts.intersected, counts.occluded) != (traced, cost.shadow_rays):
        sys.exit(f"kept {counts.intersected} + {counts.occluded} rays of {traced} + {cost.shadow_rays}")
    bare, rendering = (statistics.median(column) for column in zip(*pairs, strict=True))
    return Rates(tracer.dimensions, cost, counts, bare, rendering, sorted(b / r for b, r in pairs))


def main() -> None:
    kept = Kept(sys.argv[1])
    print(
        "the tracer beside a bare loop over rtcIntersect16 and rtcOccluded16 on the same rays: each scene, "
        f"{SIZE[0]}x{SIZE[1]}, {SAMPLES} samples a pixel,\nmedian of {ROUNDS} rounds and extremes; "
        "more: the time of a sample beyond the bare loop's\n"
        f"  {'':17} {'d':>2} {'rays a sample':>13} {'shadow':>8} {'scattered':>9} {'hit':>6}"
        f" {'bare':>8} {'tracer':>8} Mrays/s  {'more':>8}   share"
    )
    for name in sys.argv[2:] or scene_io.names():
        found = measure(kept, scene_io.load(name).scene)
        cost, counts, shares = found.cost, found.kept, found.shares
        rays = counts.intersected + counts.occluded
        scattered = cost.reflection_rays + cost.bounce_rays
        more = 1e9 * (found.tracer - found.bare) / cost.samples
        print(
            f"  {name:17} {found.dimensions:2} {rays / cost.samples:13.2f} {counts.occluded / rays:8.0%}"
            f" {scattered / rays:9.0%} {counts.hits / counts.intersected:6.0%}"
            f" {1e-6 * rays / found.bare:8.1f} {1e-6 * rays / found.tracer:8.1f}"
            f" {more:13.0f} ns {statistics.median(shares):7.1%} ({shares[0]:.1%} to {shares[-1]:.1%})"
        )


if __name__ == "__main__":
    main()
