"""Half-planes, discs, distances and Voronoi cells of a few points, in fractions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations, pairwise

Point = tuple[Fraction, Fraction]
Line = tuple[Fraction, Fraction, Fraction]
"""a, b, c of a x + b y + c."""

SQUARE: tuple[Point, ...] = tuple((Fraction(x), Fraction(y)) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))


def value(line: Line, point: Point) -> Fraction:
    return line[0] * point[0] + line[1] * point[1] + line[2]


def clipped(polygon: Sequence[Point], line: Line) -> list[Point]:
    """The part of a convex polygon where a x + b y + c >= 0."""
    made: list[Point] = []
    for begin, end in zip(polygon, [*polygon[1:], *polygon[:1]], strict=True):
        at, to = value(line, begin), value(line, end)
        if at >= 0:
            made.append(begin)
        if at * to < 0:
            share = at / (at - to)
            made.append((begin[0] + share * (end[0] - begin[0]), begin[1] + share * (end[1] - begin[1])))
    return made


def area(polygon: Sequence[Point]) -> Fraction:
    """Of a polygon, counterclockwise."""
    pairs = zip(polygon, [*polygon[1:], *polygon[:1]], strict=True)
    return sum((p[0] * q[1] - p[1] * q[0] for p, q in pairs), Fraction(0)) / 2


def excess(line: Line, points: Sequence[Point]) -> Fraction:
    """n/N - area of the closed half-plane."""
    inside = sum(value(line, point) >= 0 for point in points)
    return Fraction(inside, len(points)) - area(clipped(SQUARE, line))


def half_plane(points: Sequence[Point]) -> Fraction:
    """sup over half-planes of |n/N - area|: lines through two points, and those whose chord a point halves."""
    return max(max(excess(line, points), excess(_other(line), points)) for line in _lines(points))


def _other(line: Line) -> Line:
    return (-line[0], -line[1], -line[2])


def _lines(points: Sequence[Point]) -> Iterator[Line]:
    places = sorted(set(points))
    for p, q in combinations(places, 2):
        yield _through(p, q)
    for x, y in places:
        # A point nearer to a corner than to the middle halves the chord of twice its distances from the corner's sides.
        across, up = min(x, 1 - x), min(y, 1 - y)
        if across == 0 and up == 0:
            yield (Fraction(1), Fraction(0), -x)
        else:
            sign = 1 if (x <= 1 - x) != (y <= 1 - y) else -1
            yield _through((x - across, y), (x, y)) if up == 0 else _through((x, y), (x + across, y + sign * up))


def _through(p: Point, q: Point) -> Line:
    a, b = q[1] - p[1], p[0] - q[0]
    if a == b == 0:
        a = Fraction(1)
    return (a, b, -(a * p[0] + b * p[1]))


def least_square(points: Sequence[Point], torus: bool) -> Fraction:
    """The square of the least distance of two points."""
    if len(set(points)) < len(points):
        return Fraction(0)

    def along(p: Fraction, q: Fraction) -> Fraction:
        return min(abs(p - q), 1 - abs(p - q)) if torus else abs(p - q)

    return min(along(p[0], q[0]) ** 2 + along(p[1], q[1]) ** 2 for p, q in combinations(points, 2))


def nearest_square(place: Point, points: Sequence[Point]) -> Fraction:
    return min((place[0] - x) ** 2 + (place[1] - y) ** 2 for x, y in points)


def empty_disc_square(points: Sequence[Point]) -> Fraction:
    """The square of the radius of the largest disc without points, its centre in the square: the vertices of the
    Voronoi cells, clipped."""
    places = sorted(set(points))
    return max(nearest_square(corner, (own,)) for own in places for corner in cell(own, places, SQUARE))


def cell(own: Point, points: Sequence[Point], bounds: Sequence[Point]) -> list[Point]:
    """The Voronoi cell of a point among others, clipped to a convex polygon."""
    made = list(bounds)
    for other in points:
        if other != own:
            a, b = own[0] - other[0], own[1] - other[1]
            half = (own[0] ** 2 + own[1] ** 2 - other[0] ** 2 - other[1] ** 2) / 2
            made = clipped(made, (a, b, -half))
    return made


def tent_integral(polygon: Sequence[Point], radius: Fraction) -> Fraction:
    """The integral of (1 - |x| / radius) (1 - |y| / radius) over a convex polygon: by the midpoints of the sides of
    triangles, which is exact for a polynomial of degree 2."""
    whole = Fraction(0)
    for right in (1, -1):
        for up in (1, -1):
            part = clipped(polygon, (Fraction(right), Fraction(0), Fraction(0)))
            part = clipped(part, (Fraction(0), Fraction(up), Fraction(0))) if part else part
            for first, second in pairwise(part[1:]):
                triangle = (part[0], first, second)
                middles = [((p[0] + q[0]) / 2, (p[1] + q[1]) / 2) for p, q in combinations(triangle, 2)]
                heights = [(1 - abs(x) / radius) * (1 - abs(y) / radius) for x, y in middles]
                whole += area(triangle) * sum(heights) / 3
    return whole
