"""Warps, densities and the areas of triangles, against fractions and mpmath."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial

import mpmath

from aliascope.native import warps
from aliascope.stability.exact.sets import LEVELS
from aliascope.stability.records import Probe

DIGITS = 60
ROUNDING = 2.0**-53
BOUND = 1e-12


def _relative(found: float, truth: mpmath.mpf) -> float:
    return float(abs(found - truth) / (truth or 1))


# ---- Hemispheres, disc, sphere: u = (at, 0.3), near an edge of the square ----


def _short(at: float) -> mpmath.mpf:
    """What the radius lacks of 1."""
    return 2 * min(mpmath.mpf(at), 1 - mpmath.mpf(at))


def _height(warp: warps.Warp, root: bool, at: float) -> float:
    """Of the direction above the rim: samples are divided by it, so that its digits count."""
    found = float(warp.sample([[at, 0.3]])[0, 2])
    with mpmath.workdps(DIGITS):
        square = _short(at) * (2 - _short(at))
        return _relative(found, mpmath.sqrt(square) if root else square)


def _on_disc(at: float) -> float:
    """How far the point is from where it should be."""
    found = warps.DISC.sample([[at, 0.3]])[0].tolist()
    with mpmath.workdps(DIGITS):
        a, b = 2 * mpmath.mpf(at) - 1, 2 * mpmath.mpf(0.3) - 1
        radius, across = (a, b) if abs(a) > abs(b) else (b, a)
        angle = mpmath.pi / 4 * across / radius
        along, aside = radius * mpmath.cos(angle), radius * mpmath.sin(angle)
        truth = (along, aside) if abs(a) > abs(b) else (aside, along)
        return float(mpmath.hypot(found[0] - truth[0], found[1] - truth[1]))


def _on_sphere(at: float) -> float:
    """How far the direction is from where it should be."""
    found = warps.SPHERE.sample([[at, 0.3]])[0].tolist()
    with mpmath.workdps(DIGITS):
        a, b = 2 * mpmath.mpf(at) - 1, 2 * mpmath.mpf(0.3) - 1
        below = abs(a) + abs(b) > 1
        p, q = (1 - abs(b), 1 - abs(a)) if below else (abs(a), abs(b))
        r = p + q
        longitude, ring = mpmath.pi / 2 * q / r, r * mpmath.sqrt(2 - r * r)
        truth = (
            mpmath.sign(a) * ring * mpmath.cos(longitude),
            mpmath.sign(b) * ring * mpmath.sin(longitude),
            (-1 if below else 1) * (1 - r * r),
        )
        return float(mpmath.norm([mpmath.mpf(x) - y for x, y in zip(found, truth, strict=True)]))


# ---- Triangles ----

Vertex = tuple[float, float, float]


def _area(vertices: Sequence[Vertex]) -> mpmath.mpf:
    """Of the very doubles."""
    exact = [[Fraction(value) for value in vertex] for vertex in vertices]
    e, f = ([to - begin for begin, to in zip(exact[0], other, strict=True)] for other in exact[1:])
    cross = [e[i - 2] * f[i - 1] - e[i - 1] * f[i - 2] for i in range(3)]
    square = sum((value * value for value in cross), Fraction(0))
    return mpmath.sqrt(mpmath.mpf(square.numerator) / square.denominator) / 2


def _sliver(at: float) -> list[Vertex]:
    """Long and thin by so much, in no plane of the axes."""
    middle = (0.1 + 0.55, 0.2 + 0.35, 0.3 - 0.25)
    return [(0.1, 0.2, 0.3), (1.2, 0.9, -0.2), (middle[0] - 0.3 / at, middle[1] + 0.7 / at, middle[2] + 0.32 / at)]


def _scaled(at: float) -> list[Vertex]:
    return [(0.1 * at, 0.2 * at, 0.3 * at), (1.2 * at, 0.9 * at, -0.2 * at), (0.3 * at, 0.8 * at, 0.5 * at)]


def _far(at: float) -> list[Vertex]:
    return [(at + x, at + y, z - at) for x, y, z in _scaled(1.0)]


def _triangle(made: Callable[[float], list[Vertex]], at: float) -> float:
    vertices = made(at)
    found = warps.triangle_pdf(vertices)
    with mpmath.workdps(DIGITS):
        return _relative(found, 1 / _area(vertices))


# ---- Densities ----


def _density(at: float) -> float:
    """Of cells of which one weighs `at` times the other two."""
    weights = [1.0, at, 1.0]
    found = warps.Density(weights).pdf([[0.1], [0.5], [0.9]]).tolist()
    with mpmath.workdps(400):
        whole = mpmath.fsum(map(mpmath.mpf, weights))
        return max(_relative(value, 3 * mpmath.mpf(own) / whole) for value, own in zip(found, weights, strict=True))


def _round_trip(at: float) -> float:
    density = warps.Density([1.0, 2.0, 0.0, 3.0])
    ends = [[at], [1.0 - at]]
    return float(abs(density.inverse(density.sample(ends)) - ends).max())


def _probe(
    component: str, extreme: str, unit: str, run: Callable[[float], float], levels: tuple[float, ...], note: str = ""
) -> Probe:
    quick = (levels[len(levels) // 2], levels[-1])
    against = "mpmath and fractions of the same doubles"
    return Probe(component, "sampler", extreme, unit, against, ROUNDING, BOUND, levels, run, quick, note)


SCALES = (1.0, 1e-12, 1e12, 1e-50, 1e50, 1e-100, 1e100, 1e-150, 1e150)


def probes() -> list[Probe]:
    border = LEVELS["border"]
    cosine = partial(_height, warps.COSINE_HEMISPHERE, True)
    uniform = partial(_height, warps.UNIFORM_HEMISPHERE, False)
    return [
        _probe("cosine-hemisphere", "border", "relative", cosine, border),
        _probe("uniform-hemisphere", "border", "relative", uniform, border),
        _probe("disc", "border", "radii", _on_disc, border),
        _probe("sphere", "border", "radii", _on_sphere, border),
        _probe("triangle", "sliver", "relative", partial(_triangle, _sliver), (1.0, 1e3, 1e6, 1e9, 1e12, 1e15)),
        _probe("triangle", "scaled", "relative", partial(_triangle, _scaled), SCALES),
        _probe("triangle", "far", "relative", partial(_triangle, _far), (1.0, 1e3, 1e6, 1e9, 1e12)),
        _probe("density", "mixed", "relative", _density, (1.0, 1e10, 1e50, 1e100, 1e200, 1e300)),
        _probe("density", "border", "of the square's side", _round_trip, border),
    ]
