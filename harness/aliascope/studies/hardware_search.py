"""Searches the 8 x 8 grid of cell centres for the sets with the least discrepancy; prints hardware_sets.py.

Run: .venv/bin/python -m aliascope.studies.hardware_search >harness/aliascope/studies/hardware_sets.py
and ruff format; some five minutes.

edge-rms: for 1, 2, 4 and 8 points csrc/sampler/make_sgi_positions.py went through all sets, and the sampler sgi-8x8 has
what it found; here are 16, by descent from random sets, over all exchanges of a point for a free cell.

half-plane: through all sets, where "all" shrinks by what the half-planes with horizontal and vertical edges demand. The
closed one up to row k's centres and the open one up to row k + 1's hold the same points, c of them, and have the areas
(k -+ 1/2) / 8, so c / n is off one of them by less than D only if |c - n k / 8| < n D - n / 16. For 8 points and
D < 3/16 that leaves one point a row and column, 8! sets; for 16 points and D < 1/8, two of each, 187,530,840 sets,
which are put together from an upper and a lower half. Of sets that tie, the one with the least edge-rms, then the
first.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from aliascope.native import samplers
from aliascope.native.discrepancy import measure

SIDE = 8
CELLS = SIDE * SIDE
STARTS = 100_000
TIED = 1e-12  # discrepancies this close are equal: they are 0.01 or more, each good to 14 digits

Set = tuple[int, ...]
Masks = NDArray[np.uint64]


def centres(cells: Iterable[int]) -> NDArray[np.float64]:
    """The points of a set of cells, numbered by rows."""
    return np.array([((cell % SIDE + 0.5) / SIDE, (cell // SIDE + 0.5) / SIDE) for cell in cells])


def first_image(cells: Set) -> Set:
    """The first of the set's images under the square's eight symmetries."""
    found = []
    for flip in range(8):
        moved = []
        for cell in cells:
            x, y = cell % SIDE, cell // SIDE
            x, y = (SIDE - 1 - x if flip & 1 else x), (SIDE - 1 - y if flip & 2 else y)
            moved.append(x * SIDE + y if flip & 4 else y * SIDE + x)
        found.append(tuple(sorted(moved)))
    return min(found)


def least(sets: Iterable[Set]) -> tuple[float, Set]:
    """The least half-plane discrepancy of these sets, and the set that has it."""
    best, tied = math.inf, list[Set]()
    for cells in sorted({first_image(cells) for cells in sets}):
        value = measure("half-plane", centres(cells)).value
        if value < best - TIED:
            best, tied = value, []
        if value < best + TIED:
            tied.append(cells)
    edges = [(round(measure("edge-rms", centres(cells)).value, 12), cells) for cells in tied]
    return best, min(edges)[1]


# --- half-plane, 16 points --------------------------------------------------------------------------------------------


def demands(n: int, bound: float) -> list[tuple[np.uint64, int, int]]:
    """Half-planes as masks of cells, with the fewest and most of n points that a discrepancy up to `bound` allows.

    The edges go through centres, askew and in directions of small slope: not all that there are, but enough to leave
    few sets. What horizontal and vertical ones demand is taken care of.
    """
    points = centres(range(CELLS))
    found = []
    directions = {(a, b) for a in range(-4, 5) for b in range(1, 5) if a and math.gcd(a, b) == 1}
    for a, b in sorted(directions, key=lambda d: abs(d[0]) + abs(d[1])):
        along = a * (2 * SIDE * points[:, 0]).astype(int) + b * (2 * SIDE * points[:, 1]).astype(int)
        for level in sorted(set(along)):
            area = area_below(a, b, level / (2 * SIDE))
            most = math.floor(n * (area + bound) + 1e-9)
            fewest = math.ceil(n * (area - bound) - 1e-9)
            closed, opened = mask(np.flatnonzero(along <= level)), mask(np.flatnonzero(along < level))
            if most < min(n, int(np.bitwise_count(closed))):
                found.append((closed, 0, most))
            if fewest > 0:
                found.append((opened, fewest, n))
    return found


def area_below(a: int, b: int, c: float) -> float:
    """Of the part of the unit square where a x + b y <= c, b > 0: the mean over y of where the edge is."""
    if a < 0:  # x to 1 - x
        return area_below(-a, b, c - a)

    def ramp(t: float) -> float:  # the integral of min(max(u, 0), 1) up to t
        return 0.0 if t <= 0.0 else t * t / 2.0 if t <= 1.0 else t - 0.5

    return (ramp(c / a) - ramp((c - b) / a)) * a / b


def mask(cells: Iterable[int]) -> np.uint64:
    """The bits of cells."""
    return np.uint64(sum(1 << int(cell) for cell in cells))


def half_sets() -> tuple[Masks, NDArray[np.int64]]:
    """All fillings of four rows with two points each and at most two a column, and their counts by column, base 3."""
    pairs = list(itertools.combinations(range(SIDE), 2))
    filled, codes = np.zeros(1, np.uint64), np.zeros(1, np.int64)
    columns = np.zeros((1, SIDE), np.int8)
    for row in range(SIDE // 2):
        rows = np.array([sum(1 << (row * SIDE + x) for x in pair) for pair in pairs], np.uint64)
        added = np.array([[x in pair for x in range(SIDE)] for pair in pairs], np.int8)
        filled = (filled[:, None] | rows).ravel()
        columns = (columns[:, None, :] + added).reshape(-1, SIDE)
        kept = (columns <= 2).all(axis=1)
        filled, columns = filled[kept], columns[kept]
    codes = columns.astype(np.int64) @ 3 ** np.arange(SIDE)
    return filled, codes


def sixteens(bound: float) -> Iterator[Set]:
    """All sets of two points in each row and column whose discrepancy may be `bound` or less."""
    filled, codes = half_sets()
    order = np.argsort(codes, kind="stable")
    filled, codes = filled[order], codes[order]
    whole = sum(2 * 3**x for x in range(SIDE))
    limits = demands(16, bound)
    values, begins = np.unique(codes, return_index=True)
    ends = np.append(begins[1:], len(codes))
    group = {int(code): filled[begin:end] for code, begin, end in zip(values, begins, ends, strict=True)}
    for code, upper in group.items():
        lower = group.get(whole - code)
        if lower is not None:
            yield from _joined(upper, lower << np.uint64(CELLS // 2), limits)


def _joined(upper: Masks, lower: Masks, limits: list[tuple[np.uint64, int, int]]) -> Iterator[Set]:
    """Each of `upper` with each of `lower`, where the limits allow."""
    joined = (upper[:, None] | lower).ravel()
    for of, fewest, most in limits:
        count = np.bitwise_count(joined & of)
        joined = joined[(count >= fewest) & (count <= most)]
        if not len(joined):
            return
    for bits in joined:
        yield tuple(cell for cell in range(CELLS) if int(bits) >> cell & 1)


def best_half_plane(n: int) -> tuple[float, Set]:
    """The set of n with the least half-plane discrepancy."""
    if n <= 4:
        return least(itertools.combinations(range(CELLS), n))
    if n == 8:
        found = least(
            tuple(SIDE * row + x for row, x in enumerate(columns)) for columns in itertools.permutations(range(SIDE))
        )
        assert found[0] < 3 / 16
        return found
    for bound in (0.1, 0.105, 0.11, 0.115, 0.12, 0.125 - TIED):
        sets = list(sixteens(bound))
        if sets:
            found = least(sets)
            if found[0] <= bound:
                return found
    raise AssertionError("no set of 16 below 1/8")


# --- edge-rms, 16 points ----------------------------------------------------------------------------------------------


def best_edge_rms(n: int, starts: int) -> tuple[float, Set, int]:
    """The set of n with the least edge-rms that descents reach, and how many reach it."""
    points = centres(range(CELLS))
    distance = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    # edge-rms^2 = sum of own / n - sum of distances / (2 n^2) + constant, from the figures of single points
    single = np.array([measure("edge-rms", points[[cell]]).value ** 2 for cell in range(CELLS)])
    own = single / n
    random = np.random.default_rng(1)
    best, cells, hits = math.inf, tuple[int, ...](), 0
    for _ in range(starts):
        inside = np.zeros(CELLS, bool)
        inside[random.permutation(CELLS)[:n]] = True
        while True:
            taken, free = np.flatnonzero(inside), np.flatnonzero(~inside)
            pull = distance[taken].sum(axis=0)
            alone = own - pull / (2 * n * n)
            change = alone[free] - alone[taken][:, None] + distance[np.ix_(taken, free)] / (2 * n * n)
            at = int(change.argmin())
            if change.flat[at] > -TIED:
                break
            inside[taken[at // len(free)]], inside[free[at % len(free)]] = False, True
        found = first_image(tuple(map(int, np.flatnonzero(inside))))
        value = measure("edge-rms", centres(found)).value
        if value < best - TIED:
            best, cells, hits = value, found, 0
        if value < best + TIED:
            cells, hits = min(cells, found), hits + 1
    return best, cells, hits


def main() -> None:
    """Prints the module."""
    print('"""Generated: .venv/bin/python -m aliascope.studies.hardware_search, which says how."""\n')
    print("from __future__ import annotations\n")
    print("SETS: dict[tuple[str, int], tuple[str, tuple[int, ...]]] = {")
    print("    # (measure, points): how it was found, the cells of the 8 x 8 grid, by rows")
    for n in (1, 2, 4, 8):
        at = samplers.points("sgi-8x8", n) * SIDE
        cells = tuple(sorted(int(y) * SIDE + int(x) for x, y in at))
        print(f'    ("edge-rms", {n}): ("exhaustive", {cells}),')
    _, cells, hits = best_edge_rms(16, STARTS)
    print(f'    ("edge-rms", 16): ("descent from {STARTS} random sets, {hits} of which end there", {cells}),')
    for n in (1, 2, 4, 8, 16):
        _, cells = best_half_plane(n)
        print(f'    ("half-plane", {n}): ("exhaustive", {cells}),', flush=True)
    print("}")


if __name__ == "__main__":
    main()
