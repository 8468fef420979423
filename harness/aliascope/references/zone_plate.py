"""Polygons of which some carry a zone plate: its mean over a pixel by Fresnel integrals.

The zone plate's cosine has the phase s |p - o|^2 = s (x^2 + y^2 + z^2), x and y along the picture's axes, z away from
it and constant on a plane that is parallel to the picture. Then the mean of the cosine over a pixel is the real part of

    exp(i s z^2)  mean over x of exp(i s x^2)  mean over y of exp(i s y^2),

and with t = x sqrt(2 s / pi) the mean over x is (F(t1) - F(t0)) / (t1 - t0), F = C + i S the Fresnel integrals
(Abramowitz and Stegun 1964, 7.3.1 and 7.3.2).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import fresnel

from aliascope.errors import Unsupported
from aliascope.geometry import Array, Frame
from aliascope.model import Polygon, Scene, ZonePlate
from aliascope.references.canvas import Canvas
from aliascope.references.polygons import colour_of, coverage_error, visible
from aliascope.references.projection import Outline, outlines_of
from aliascope.references.result import EPSILON, Exact, Method, checked
from aliascope.references.visibility import depth_order

COVERAGE_SLACK = 1e-10
"""A pixel that is covered up to this counts as covered. It is part of the error bound."""
LARGEST_ARGUMENT = 3e4
"""scipy gives up the Fresnel integrals' last digits beyond 36974; they were compared with mpmath up to this."""


def mean_phasor(edges: Array, scale: float) -> tuple[NDArray[np.complex128], float]:
    """The means of exp(i scale x^2) between neighbours of `edges` (n + 1,): (n,) complex, and a bound of their error.

    Raises Unsupported beyond the range in which the Fresnel integrals are known to hold.
    """
    t = edges * math.sqrt(2.0 * scale / math.pi)
    largest = float(np.abs(t).max())
    if not largest <= LARGEST_ARGUMENT:
        raise Unsupported(f"the zone plate turns too often: {largest**2 / 4:.1e} rings away from its centre")
    step = float(np.abs(np.diff(t)).min())
    if not step > 0.0:
        raise Unsupported("the zone plate is too far from its centre to tell one pixel's border from the next")
    sine, cosine = fresnel(t)
    integral: NDArray[np.complex128] = np.asarray(cosine + 1j * sine, dtype=np.complex128)
    # scipy is within eps (1 + t) (measured against mpmath: 0.7 of it), and t itself within 4 eps t.
    error = 2 * 5 * EPSILON * (min(1.0, largest) + largest) / step
    return (integral[1:] - integral[:-1]) / (t[1:] - t[:-1]), error


def mean_zone_plate(pattern: ZonePlate, frame: Frame, points: Array) -> tuple[Array, float]:
    """The mean colours (height, width, 3) of a zone plate on the plane through points (n, 3), and a bound of the error.

    Raises Unsupported where the plane is not parallel to the picture.
    """
    depths = (points - frame.eye) @ frame.forward
    depth = float(depths.mean())
    spread = float(np.ptp(depths))
    to_centre = frame.eye - np.array(pattern.origin)
    reach = float(np.linalg.norm(to_centre)) + float(np.linalg.norm(points - frame.eye, axis=1).max())
    if spread > 16 * EPSILON * reach:
        raise Unsupported("its plane is not parallel to the picture")
    unit = frame.pixel * (depth if frame.perspective else 1.0)
    middle = frame.middle
    x = (np.arange(frame.width + 1.0) - middle[0]) * unit + float(to_centre @ frame.right)
    y = (middle[1] - np.arange(frame.height + 1.0)) * unit + float(to_centre @ frame.up)
    z = depth + float(to_centre @ frame.forward)
    across, across_error = mean_phasor(x, pattern.scale)
    down, down_error = mean_phasor(y, pattern.scale)
    wave = (np.exp(1j * pattern.scale * z**2) * across * down[:, np.newaxis]).real
    # Coordinates within 8 eps of what they are sums of; the phase moves by 2 s |p - o| times that.
    distance = float(np.hypot(np.hypot(np.abs(x).max(), np.abs(y).max()), z))
    moved = 2 * pattern.scale * distance * (8 * EPSILON * (reach + distance) + spread)
    low, high = (np.array(colour) for colour in pattern.colours)
    colours = low + (high - low) * ((1.0 + wave) / 2)[:, :, np.newaxis]
    return colours, across_error + down_error + moved + 4 * EPSILON


def _radiance(scene: Scene, outline: Outline, frame: Frame) -> tuple[Array, float]:
    """The radiance of a surface, (3,) or the mean over each pixel as if it covered all, and its relative error."""
    pattern = outline.material.pattern
    if not isinstance(pattern, ZonePlate):
        return colour_of(outline), 0.0
    surface = scene.surfaces[outline.number]
    assert isinstance(surface, Polygon)  # the method's features hold this
    try:
        colours, error = mean_zone_plate(pattern, frame, np.array(surface.points))
    except Unsupported as unsupported:
        raise Unsupported(f"{outline.label}: {unsupported}") from unsupported
    return colours * np.array(outline.material.emission), error


def make(scene: Scene, frame: Frame) -> Exact:
    """The mean radiance over each pixel. Raises Unsupported where a zone plate covers a pixel in part."""
    outlines = outlines_of(scene, frame)
    order = depth_order(outlines)
    canvas = Canvas(frame.width, frame.height)
    error = 0.0
    for outline, part in zip(outlines, visible(frame, outlines, order), strict=True):
        radiance, relative_error = _radiance(scene, outline, frame)
        if isinstance(outline.material.pattern, ZonePlate):
            _refuse_partial(outline, part.area)
            error += relative_error + COVERAGE_SLACK * bool(np.any((part.area > 0.0) & (part.area < 1.0)))
        canvas.add(part, radiance, _brightest(outline))
    error += coverage_error(frame, outlines, order, canvas)
    return checked(canvas, np.array(scene.view.background), error)


def _brightest(outline: Outline) -> float:
    emission, pattern = outline.material.emission, outline.material.pattern
    colours = pattern.colours if pattern else ((1.0, 1.0, 1.0),)
    return max(e * c for colour in colours for e, c in zip(emission, colour, strict=True))


def _refuse_partial(outline: Outline, area: Array) -> None:
    partial = (area > COVERAGE_SLACK) & (area < 1.0 - COVERAGE_SLACK)
    if partial.any():
        row, column = (int(i) for i in np.argwhere(partial)[0])
        raise Unsupported(
            f"{outline.label} has a zone plate that covers pixel ({column}, {row}) in part: only whole pixels of it "
            "have an exact method"
        )


METHOD = Method(
    name="zone-plate",
    title="Fresnel integrals of a zone plate",
    features=frozenset({"orthographic", "perspective", "polygon", "zone-plate"}),
    make=make,
)
