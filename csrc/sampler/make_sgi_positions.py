"""Searches the 8 x 8 grid for the positions with the least edge discrepancy; writes sgi_positions.h. About 20 seconds.

Run: .venv/bin/python csrc/sampler/make_sgi_positions.py > csrc/sampler/sgi_positions.h

The edge discrepancy is the root of the mean square, over random lines, of the share of points on one side less the
share of the unit square's area there; lines from the measure that motions leave unchanged, restricted to those that
meet the square. By Crofton's formula lines that part two points have measure twice their distance, and lines that meet
the square have its perimeter, 4, so the mean square is

    1/4 [ 2/N sum_i phi(x_i) - 1/N^2 sum_ij |x_i - x_j| - integral of phi over the square ],

phi(x) the mean distance from x to the square's points. The search is exhaustive: all 1, 2, 4 and 8 of the 64 cells'
centres, 4.4e9 sets of 8, each as four cells in row order and four that come after them.
"""

from itertools import combinations
from math import asinh, hypot, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

SIDE = 8
CELLS = SIDE * SIDE
TIED = 1e-12  # mean squares this close are equal: they are about 1e-3, each the sum of fewer than 100 doubles


def corner(a: float, b: float) -> float:
    """The integral over [0, a] x [0, b] of the distance to the origin."""
    return a * b * hypot(a, b) / 3 + (a**3 * asinh(b / a) + b**3 * asinh(a / b)) / 6


def mean_distance(x: float, y: float) -> float:
    """From (x, y) to the points of the unit square that it lies in."""
    return sum(corner(a, b) for a in (x, 1 - x) for b in (y, 1 - y))


CENTRES = [((cell % SIDE + 0.5) / SIDE, (cell // SIDE + 0.5) / SIDE) for cell in range(CELLS)]
PHI = np.array([mean_distance(x, y) for x, y in CENTRES])
DISTANCE = np.array([[hypot(x - u, y - v) for u, v in CENTRES] for x, y in CENTRES])
PHI_MEAN = (2 + sqrt(2) + 5 * asinh(1)) / 15  # over the square


def mean_squares(sets: NDArray[Any], n: int) -> NDArray[np.float64]:
    """Of the sets' own terms, (m,), for sets (m, k) of cells, as parts of a set of n; the constant left out."""
    own = PHI[sets].sum(axis=1) / (2 * n)
    for i, j in combinations(range(sets.shape[1]), 2):
        own -= DISTANCE[sets[:, i], sets[:, j]] / (2 * n * n)
    return np.asarray(own)


def images(cells: tuple[int, ...]) -> set[tuple[int, ...]]:
    """The set under the square's 8 symmetries, each in row order."""
    found = set()
    for flip in range(8):
        moved = []
        for cell in cells:
            x, y = cell % SIDE, cell // SIDE
            x, y = (SIDE - 1 - x if flip & 1 else x), (SIDE - 1 - y if flip & 2 else y)
            moved.append(x * SIDE + y if flip & 4 else y * SIDE + x)
        found.add(tuple(sorted(moved)))
    return found


def best_of(n: int) -> tuple[float, list[tuple[int, ...]]]:
    """The least mean square and all sets of n <= 4 cells that have it."""
    sets = np.array(list(combinations(range(CELLS), n)))
    own = mean_squares(sets, n)
    least = own.min()
    return float(least), [tuple(map(int, row)) for row in sets[own < least + TIED]]


def best_of_eight() -> tuple[float, list[tuple[int, ...]]]:
    """The same for 8: four cells (`front`), and all fours that come after them, side by side."""
    fours = np.array(list(combinations(range(CELLS), 4)))
    own = mean_squares(fours, 8)
    first_pair, last_pair = fours[:, 0] * CELLS + fours[:, 1], fours[:, 2] * CELLS + fours[:, 3]
    begins = np.searchsorted(fours[:, 0], np.arange(CELLS + 1))  # of the fours whose first cell is this or a later one
    least, found = np.inf, list[tuple[int, ...]]()
    for number, front in enumerate(fours):
        begin = begins[front[3] + 1]
        if begin == len(fours):
            continue
        pull = DISTANCE[front].sum(axis=0) / (2 * 8 * 8)
        pulls = (pull[:, None] + pull[None, :]).ravel()
        whole = own[begin:] - pulls[first_pair[begin:]] - pulls[last_pair[begin:]]
        here = whole.min() + own[number]
        if here > least + TIED:
            continue
        if here < least - TIED:
            found = []
        least = min(least, here)
        close = np.flatnonzero(whole + own[number] < least + TIED)
        found += [tuple(map(int, (*front, *fours[begin + index]))) for index in close]
    return float(least), found


def main() -> None:
    print("/* Generated: .venv/bin/python csrc/sampler/make_sgi_positions.py > csrc/sampler/sgi_positions.h */")
    print("#ifndef ASC_SGI_POSITIONS_H\n#define ASC_SGI_POSITIONS_H\n\n#include <stdint.h>\n")
    print("/* The centres {x, y} of 1, 2, 4 and 8 cells, in sixteenths, from the upper row to the lower. */")
    print("static const uint8_t sgi_positions[1 + 2 + 4 + 8][2] = {")
    for n in (1, 2, 4, 8):
        least, sets = best_of_eight() if n == 8 else best_of(n)
        shapes = {min(images(cells)) for cells in sets}
        cells = min(sets)
        print(
            f"    /* {n}: edge discrepancy {sqrt(least - PHI_MEAN / 4):.6f}; {len(sets)} sets have it, "
            f"{len(shapes)} but for the square's symmetries */"
        )
        print("".join(f"    {{{2 * (cell % SIDE) + 1}, {2 * (cell // SIDE) + 1}}},\n" for cell in cells), end="")
    print("};\n\n#endif")


if __name__ == "__main__":
    main()
