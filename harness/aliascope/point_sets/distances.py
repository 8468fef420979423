"""How far apart points can be."""

from __future__ import annotations

import math

from aliascope.errors import Unsupported


def densest_distance(n: int, dimensions: int = 2) -> float:
    """The minimum distance that n points of the densest packing have, an upper bound of any n points on the torus.

    1/n on a line; sqrt(2 / (sqrt(3) n)) in the plane, hexagonal (Thue 1910; Fejes Toth 1940); (sqrt(2) / n)^(1/3) in
    space, face-centred cubic (Hales 2005). A set on the torus is a packing of the whole space, so none exceeds it, and
    few n reach it. Raises Unsupported for other dimensions.
    """
    if dimensions not in (1, 2, 3):
        raise Unsupported(f"the densest packing is held for 1, 2 and 3 dimensions, not {dimensions}")
    return {1: 1.0 / n, 2: math.sqrt(2.0 / (math.sqrt(3.0) * n)), 3: math.cbrt(math.sqrt(2.0) / n)}[dimensions]
