"""What the commands do, as functions on numpy arrays. Errors are those of `aliascope.errors`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, overload

import numpy as np

from aliascope import metrics, point_sets, references, renderers, scene_io
from aliascope.errors import InvalidInput, Unsupported
from aliascope.integration import integrate
from aliascope.native import samplers
from aliascope.native.discrepancy import Measured, measure
from aliascope.native.estimate import Estimates, Estimator, Integrand
from aliascope.native.samplers import points
from aliascope.native.uneven import voronoi_areas
from aliascope.native.uneven import weights as uneven_weights
from aliascope.point_sets import PointSpectrum, Refused, point_statistics
from aliascope.point_sets.arrays import checked
from aliascope.records import Pixels, Rendering
from aliascope.references import Reference
from aliascope.renderers.base import Request, lacks
from aliascope.scene_io import SceneFile

__all__ = [
    "discrepancy",
    "error",
    "estimate",
    "integrate",
    "load_scene",
    "point_spectrum",
    "point_statistics",
    "points",
    "reference",
    "render",
    "uneven_weights",
    "voronoi_areas",
]


def load_scene(scene: str) -> SceneFile:
    """A scene by its name in scenes/ or the path of its file: TOML, or glTF (.glb, .gltf)."""
    return scene_io.load(scene)


def render(
    scene: str | SceneFile,
    renderer: str,
    mode: str,
    *,
    size: tuple[int, int] | None = None,
    seed: int = 0,
    threads: int = 1,
    least_seconds: float = 0.0,
    time_limit: float = Request.time_limit,
    shift: tuple[float, float] = Request.shift,
) -> Rendering:
    """One picture, in this process: `pixels` (height, width, 3) float32 linear RGB, row 0 on top, and its `cost`.

    `least_seconds`: render again until the CPU time adds up to this, for a steady figure. `time_limit`: seconds on the
    wall, which POV-Ray is ended after, and which the others look at between renderings. `shift`: pixels to the right
    and down by which all that is seen is moved on the film, each from -16 to 16. Raises Unsupported where the renderer
    cannot draw the scene, NotAvailable, JobFailed.
    """
    file = load_scene(scene) if isinstance(scene, str) else scene
    found = renderers.find(renderer)
    spec = renderers.mode_of(found, mode)
    reason = lacks(found, file.scene, spec)
    if reason:
        raise Unsupported(f"{file.name}: {reason}")
    width, height = size or file.scene.view.size
    return found.render(Request(file.scene, width, height, spec, seed, threads, least_seconds, time_limit, shift))


def reference(
    scene: str | SceneFile, *, size: tuple[int, int] | None = None, shift: tuple[float, float] = Request.shift
) -> Reference:
    """The exact picture of a scene under the box filter, made now, in this process; moved on the film as `render`
    does it by `shift`.

    Raises Unsupported where there is none.
    """
    file = load_scene(scene) if isinstance(scene, str) else scene
    return references.make(file.scene, size or file.scene.view.size, shift=shift)


def error(image: Pixels, reference: Pixels) -> dict[str, float | None]:
    """The metrics of a picture (height, width, channels) against its reference, by name."""
    return {name: measured.value for name, measured in metrics.measure(image, reference).items()}


def estimate(
    integrand: Integrand,
    estimator: str = "fixed",
    sampler: str = "random",
    n: int = 1024,
    *,
    dimensions: int = 2,
    channels: int = 1,
    seed: int = 0,
    group: tuple[int, int, int, int] = (0, 0, 1, 1),
) -> Estimates:
    """The integral over the unit cube of a function of points (count, dimensions) that gives (count, channels).

    n: the most samples; group: pixels (x, y, columns, rows), each an estimate with samples of its own. Raises
    SpecError, Unsupported for a sampler that the estimator cannot use, and what the integrand raises.

    >>> float(estimate(lambda x: x[:, 0] ** 3, sampler="gauss-legendre", n=4).means[0, 0, 0])
    0.25
    """
    return Estimator(estimator, sampler, n, dimensions, channels, seed).estimate(integrand, group)


def point_spectrum(points: Any | Iterable[Any], cut_off: int | None = None) -> PointSpectrum:
    """The power spectrum of points (n, 2) in [0, 1), or the mean of that of several sets of n: (realisations, n, 2).

    Up to frequency `cut_off`, 1 to 2048, if not given about 4 sqrt(n). Raises InvalidInput, Unsupported where the
    points have not two dimensions. See `aliascope.point_sets.point_spectrum` for the definitions.

    >>> point_spectrum([points("jittered", 64, seed=seed) for seed in range(10)]).radial_power[0] < 0.2
    True
    """
    one = isinstance(points, np.ndarray) and points.ndim == 2
    return point_sets.point_spectrum([points] if one else points, cut_off)


@overload
def discrepancy(points: Any, measures: str, *, n: int | None = None, d: int = 2, seed: int = 0) -> Measured: ...


@overload
def discrepancy(
    points: Any, measures: Iterable[str] | None = None, *, n: int | None = None, d: int = 2, seed: int = 0
) -> dict[str, Measured | Refused]: ...


def discrepancy(
    points: Any, measures: str | Iterable[str] | None = None, *, n: int | None = None, d: int = 2, seed: int = 0
) -> Measured | dict[str, Measured | Refused]:
    """Measures of points (rows, columns) in [0, 1], or of the first n points in d dimensions of a sampler's spec.

    `measures`: one, as "star" or "edge-mean:edges=chord" (`aliascope list measures`), for its `value` and `details`
    (certainty; bounds, standard error, where an extreme is met); or several, by canonical spec in a dict; or, if none
    is named, all that are quick for so many points, of which one that these points do not have is there with the value
    None and the reason in its details. `seed`: of the sampler, and of measures that draw at random.

    Raises InvalidInput for what are no points; SpecError; Unsupported for a named measure that these points do not
    have, or a number that the sampler does not.

    >>> discrepancy([[0.5, 0.5]], "star").value
    0.75
    >>> discrepancy("hammersley", ["star", "l2-star"], n=16)["star"].value
    0.171875
    """
    if isinstance(points, str):
        if n is None:
            raise InvalidInput("n is missing: how many points of the sampler")
        values = samplers.points(points, n, d, seed)
    elif n is None:
        values = checked(points, closed=True)
    else:
        raise InvalidInput("n is of a sampler; of an array take the rows")
    if isinstance(measures, str):
        return measure(measures, values, seed)
    return {one.spec: one for one in point_sets.measure_all(values, measures or (), seed)}
