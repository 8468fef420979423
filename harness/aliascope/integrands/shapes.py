"""Indicators of shapes: what a pixel has of an edge, a disc, a box; and a small bright feature."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext

import numpy as np

from aliascope.errors import SpecError
from aliascope.integrands.base import Array, Factor, Function, Kind, Product
from aliascope.integrands.genz import GOLDEN, irrational_places
from aliascope.specs import Key, Spec

_PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53)
_INFINITE = "infinite: the jump is not parallel to the axes"


@dataclass(frozen=True)
class _Edge(Function):
    """1 where cos(t) (x - 1/2) + sin(t) (y - 1/2) < offset, t in degrees."""

    angle: float
    offset: float

    def _side(self, x: Array, y: Array) -> Array:
        turn = math.radians(self.angle)
        return math.cos(turn) * (x - 0.5) + math.sin(turn) * (y - 0.5) - self.offset

    def evaluate(self, points: Array) -> Array:
        return (self._side(points[:, 0], points[:, 1]) < 0.0).astype(np.float64)

    def exact(self, d: int) -> float:
        # The square, clipped (Sutherland and Hodgman 1974), and the area around the polygon that is left.
        corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        sides = self._side(corners[:, 0], corners[:, 1])
        kept: list[Array] = []
        for k in range(4):
            here, there = sides[k], sides[(k + 1) % 4]
            if here < 0.0:
                kept.append(corners[k])
            if (here < 0.0) != (there < 0.0):
                kept.append(corners[k] + here / (here - there) * (corners[(k + 1) % 4] - corners[k]))
        following = [*kept[1:], *kept[:1]]
        return 0.5 * math.fsum(p[0] * q[1] - p[1] * q[0] for p, q in zip(kept, following, strict=True))

    def variation(self, d: int) -> float | None:
        area = self.exact(2)
        return 0.0 if area in (0.0, 1.0) else None

    def no_variation(self, d: int) -> str:
        return _INFINITE


@dataclass(frozen=True)
class _HalfSpace(Function):
    """1 where the sum of sqrt(p_j) x_j, p_j the primes, is below `position` of its largest value."""

    position: float

    def _threshold(self, d: int) -> tuple[tuple[float, ...], float]:
        normal = tuple(math.sqrt(p) for p in _PRIMES[:d])
        return normal, self.position * math.fsum(normal)

    def evaluate(self, points: Array) -> Array:
        normal, threshold = self._threshold(points.shape[1])
        along: Array = (points * np.array(normal)).sum(axis=1)
        return (along < threshold).astype(np.float64)

    def exact(self, d: int) -> float:
        return half_space_volume(*self._threshold(d))

    def variation(self, d: int) -> float | None:
        return 1.0 if d == 1 else None

    def no_variation(self, d: int) -> str:
        return _INFINITE


@functools.lru_cache(maxsize=64)
def half_space_volume(normal: tuple[float, ...], threshold: float) -> float:
    """The volume of the unit cube where normal . x < threshold, all of the normal above 0.

    The sum over corners v of (-1)^|v| max(threshold - normal.v, 0)^d, over d! times the product of the normal (Barrow
    and Smith 1979). It cancels, so it is done with 120 digits.
    """
    with localcontext(Context(prec=120)):
        exact, limit = [Decimal(a) for a in normal], Decimal(threshold)
        total = Decimal(0)
        for corner in itertools.product((0, 1), repeat=len(exact)):
            left = limit - sum((a for a, at in zip(exact, corner, strict=True) if at), Decimal(0))
            if left > 0:
                total += -(left ** len(exact)) if sum(corner) % 2 else left ** len(exact)
        return float(total / (math.factorial(len(exact)) * math.prod(exact, start=Decimal(1))))


@dataclass(frozen=True)
class _Disc(Function):
    radius: float

    def evaluate(self, points: Array) -> Array:
        # Off the middle, by at most 0.05: a disc of the largest radius, 0.45, still lies in the square.
        centre = 0.5 + 0.25 * (irrational_places(points.shape[1]) - 0.5)
        squares: Array = ((points - centre) ** 2).sum(axis=1)
        return (squares < self.radius**2).astype(np.float64)

    def exact(self, d: int) -> float:
        return math.pow(math.pi, d / 2.0) / math.gamma(d / 2.0 + 1.0) * math.pow(self.radius, d)

    def variation(self, d: int) -> float | None:
        return 2.0 if d == 1 else None

    def no_variation(self, d: int) -> str:
        return _INFINITE


def _interval(low: float, high: float) -> Factor:
    """The indicator of [low, high), of [low, 1] where high is 1."""

    def value(x: Array) -> Array:
        return ((x >= low) & ((x < high) | (high >= 1.0))).astype(np.float64)

    return Factor(value, high - low, float(low > 0.0) + float(high < 1.0), float(high >= 1.0))


def _step(spec: Spec) -> Function:
    cut, whole = _interval(0.0, spec.real("position")), _interval(0.0, 1.0)
    return Product(lambda d: [cut] + [whole] * (d - 1))


def _box(spec: Spec) -> Function:
    low, high = spec.real("low"), spec.real("high")
    if low >= high:
        raise SpecError(f"integrand box: low={low:g} is not below high={high:g}")
    factor = _interval(low, high)
    return Product(lambda d: [factor] * d)


@dataclass(frozen=True)
class _BrightFeature(Function):
    """`background`, and `brightness` more in a small box of the volume `share`."""

    share: float
    brightness: float
    background: float

    def _shape(self, d: int) -> Product:
        side = self.share ** (1.0 / d)
        low = GOLDEN * (1.0 - side)
        factor = _interval(low, low + side)
        return Product(lambda _: [factor] * d)

    def evaluate(self, points: Array) -> Array:
        shape = self._shape(points.shape[1])
        return self.background + self.brightness * shape.evaluate(points)

    def exact(self, d: int) -> float:
        return self.background + self.brightness * self.share

    def variation(self, d: int) -> float:
        return abs(self.brightness) * self._shape(d).variation(d)


def _edge(spec: Spec) -> Function:
    if spec.real("angle") % 90.0 == 0.0:
        raise SpecError(
            f"integrand edge: angle={spec.real('angle'):g} is parallel to an axis; take the integrand step for that"
        )
    return _Edge(spec.real("angle"), spec.real("offset"))


KINDS = (
    Kind(
        name="edge",
        title="1 on one side of an edge, where cos(angle) (x - 1/2) + sin(angle) (y - 1/2) < offset",
        source="Hanrahan 2000, CS348B, Stratified Sampling",
        keys=(
            Key("angle", "real", 31.7, "of its normal, in degrees, no multiple of 90", -360, 360),
            Key("offset", "real", 0.0618, "distance from the centre of the square", -1, 1),
        ),
        smoothness="jump",
        make=_edge,
        least_dimensions=2,
        most_dimensions=2,
    ),
    Kind(
        name="half-space",
        title="an edge in d dimensions: 1 where the sum of sqrt(p_j) x_j, p_j primes, is below a share of its most",
        source="Barrow and Smith 1979",
        keys=(Key("position", "real", 0.4618, "the share", 1e-6, 1 - 1e-6),),
        smoothness="jump",
        make=lambda spec: _HalfSpace(spec.real("position")),
        most_dimensions=16,
    ),
    Kind(
        name="disc",
        title="1 within a disc, in d dimensions a ball, off the centre",
        source="a small round thing in a pixel",
        keys=(Key("radius", "real", 0.4, "in sides of the square", 1e-3, 0.45),),
        smoothness="jump",
        make=lambda spec: _Disc(spec.real("radius")),
        most_dimensions=16,
    ),
    Kind(
        name="step",
        title="1 where x_1 < position",
        source="an edge along an axis",
        keys=(Key("position", "real", 0.5774, "where it falls", 1e-6, 1.0),),
        smoothness="axis-parallel-jump",
        make=_step,
    ),
    Kind(
        name="box",
        title="1 where low <= x_j < high in every dimension",
        source="what the star discrepancy is made of",
        keys=(
            Key("low", "real", 0.2113, "of every side", 0.0, 1.0),
            Key("high", "real", 0.7887, "of every side", 0.0, 1.0),
        ),
        smoothness="axis-parallel-jump",
        make=_box,
    ),
    Kind(
        name="bright-feature",
        title="a small bright box: most samples miss it",
        source="the difficulty of adaptive sampling",
        keys=(
            Key("share", "real", 0.01, "the part of the volume that it takes", 1e-9, 1.0),
            Key("brightness", "real", 1.0, "by how much it is brighter", -1e9, 1e9),
            Key("background", "real", 0.0, "the value elsewhere", -1e9, 1e9),
        ),
        smoothness="axis-parallel-jump",
        make=lambda spec: _BrightFeature(spec.real("share"), spec.real("brightness"), spec.real("background")),
    ),
)
