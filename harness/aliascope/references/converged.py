"""References of scenes that no exact method covers, and of every filter: the project's tracer, run until it is steady.

Two of the exact methods' promises are given up. The pixels have a standard error, one for each value, and they are
those of the tracer's geometry, which meets triangles and spheres in single precision first: what it gets wrong
everywhere, a converged reference has too. `tests/python/test_reference_converged.py` holds it to the exact references.

R pictures ("replicates") of N samples a pixel, each with its own seed, give the mean, and its standard error from how
they scatter: the sum of (p - mean)^2 over R (R - 1). It is good to 1 / sqrt(2 (R - 1)) of itself: 13 % for R = 32.
Points shifted at random modulo 1 (Cranley and Patterson 1976) are each uniform over the pixel, so that the mean has no
bias at any N. Seeds from 2^40 on, and a pattern that no mode of the quick and full profile uses, keep it independent of
the pictures that it judges.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from aliascope.agreement import Estimate
from aliascope.draws import UNMOVED
from aliascope.errors import NotFinite, Unsupported
from aliascope.geometry import Array
from aliascope.model import Scene
from aliascope.native import tracer
from aliascope.records import Pixels
from aliascope.references.result import Reference

ROUNDING = 2.0**-24
"""Each replicate is rounded to float32: half an ulp, relative to the value."""

Render = Callable[[int], Pixels]
"""A picture from a seed."""
Apart = Callable[[Callable[..., Pixels], Sequence[Any]], Pixels]
"""Has a picture drawn elsewhere, as by another process: by a function that it is given, of these arguments."""
Tell = Callable[[int, int, float | None], None]
"""Told how many of how many replicates are done, and the standard error of their mean, rms over pixels and channels;
None for fewer than two."""


@dataclass(frozen=True)
class Plan:
    """How a reference is converged: `replicates` pictures of `samples` points a pixel, seeds `first_seed` and on, drawn
    here or `apart`."""

    samples: int = 4096
    replicates: int = 32
    sampler: str = "sobol:scramble=shift"
    first_seed: int = 1 << 40
    threads: int = 1
    tell: Tell = field(default=lambda done, total, standard_error: None, compare=False, repr=False)
    apart: Apart | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.replicates < 2:
            raise Unsupported("a standard error needs two replicates or more")

    def provenance(self) -> dict[str, str]:
        """For the header of a file; the number of threads changes no bit."""
        return {
            "samples_per_pixel": str(self.samples),
            "replicates": str(self.replicates),
            "sampler": self.sampler,
            "seeds": f"{self.first_seed} to {self.first_seed + self.replicates - 1}",
            "embree": tracer.embree_version(),
        }


def renderer(
    scene: Scene, size: tuple[int, int], filter_: str, plan: Plan, shift: tuple[float, float] = UNMOVED
) -> Render:
    """The tracer, made ready for a scene, moved by `shift` pixels to the right and down on the film.

    Raises Unsupported for what it does not draw, NotAvailable; the picture raises what `plan.apart` does.
    """
    lacking = sorted(scene.features() - tracer.DRAWS)
    if lacking:
        raise Unsupported(f"the scene has no reference: the tracer has no answer for {', '.join(lacking)}")
    if plan.apart is None:
        built = tracer.Tracer(scene, size, shift)
        return lambda seed: built.render(plan.sampler, plan.samples, seed, plan.threads, filter_)[0]
    built_of = (scene, size, shift)
    apart, how = plan.apart, (plan.sampler, plan.samples, plan.threads, filter_)
    return lambda seed: apart(_drawn, (built_of, how, seed))


_built: dict[tuple[object, ...], tracer.Tracer] = {}
"""The last tracer that this process built for another."""


def _drawn(
    built_of: tuple[Scene, tuple[int, int], tuple[float, float]], how: tuple[str, int, int, str], seed: int
) -> Pixels:
    """A picture of `renderer`, in a process that is given one after the other."""
    (scene, *where), (sampler, samples, threads, filter_) = built_of, how
    key = (scene.digest(), *where)
    if key not in _built:
        _built.clear()
        _built[key] = tracer.Tracer(*built_of)
    return _built[key].render(sampler, samples, seed, threads, filter_)[0]


class _Squares:
    """The standard error of the pictures so far, for who waits: Welford's update, on differences from the first."""

    def __init__(self) -> None:
        self._count, self._first, self._mean, self._sum = 0, np.zeros(()), np.zeros(()), 0.0

    def add(self, picture: Pixels) -> None:
        self._count += 1
        if self._count == 1:
            self._first = picture.astype(np.float64)
        moved = picture - self._first
        before = moved - self._mean
        self._mean = self._mean + before / self._count
        self._sum += float((before * (moved - self._mean)).mean())

    @property
    def standard_error(self) -> float | None:
        n = self._count
        return float(np.sqrt(self._sum / (n * (n - 1)))) if n > 1 else None


def estimate(render: Render, plan: Plan) -> tuple[Estimate, Array]:
    """Mean and standard error of the plan's pictures, and these, (R, height, width, 3) float64.

    Sums of squares are of differences from the mean. Raises Unsupported where a picture has values that are not finite.
    """
    rendered: list[Pixels] = []
    squares = _Squares()
    for number in range(plan.replicates):
        plan.tell(number, plan.replicates, squares.standard_error)
        try:
            rendered.append(render(plan.first_seed + number))
        except NotFinite as error:
            raise Unsupported(f"the scene is brighter than float32 holds: {error}") from error
        squares.add(rendered[-1])
    pictures = np.array(rendered, dtype=np.float64)
    mean = pictures.mean(axis=0)
    # Equal pictures have a mean that rounding moved by an ulp; their difference from the first is exactly 0.
    scatter = np.where((pictures == pictures[0]).all(axis=0), 0.0, pictures.std(axis=0, ddof=1))
    mean = np.where(scatter == 0.0, pictures[0], mean)
    samples = plan.samples * plan.replicates
    return Estimate(mean, scatter / np.sqrt(plan.replicates), plan.replicates, samples), pictures


def make(
    scene: Scene, size: tuple[int, int], filter_: str, plan: Plan, shift: tuple[float, float] = UNMOVED
) -> Reference:
    """Raises Unsupported where the tracer does not draw the scene, NotAvailable, and what `plan.apart` raises."""
    found, pictures = estimate(renderer(scene, size, filter_, plan, shift), plan)
    return Reference(
        pixels=found.mean.astype(np.float32),
        exact=found.mean,
        error=ROUNDING * float(np.abs(pictures).max()),
        method="converged",
        standard_error=found.standard_error,
        provenance=plan.provenance(),
    )
