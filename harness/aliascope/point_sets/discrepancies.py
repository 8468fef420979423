"""Several measures of one set of points: those that are named, or those that are quick."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from aliascope.errors import Unsupported
from aliascope.native import discrepancy
from aliascope.native.discrepancy import Measured
from aliascope.point_sets.arrays import Points


@dataclass(frozen=True)
class Refused:
    """A measure that these points do not have, and why."""

    spec: str
    reason: str
    value: None = None

    @property
    def details(self) -> dict[str, Any]:
        """The reason, as `--json` has it."""
        return {"reason": self.reason}


def quick(n: int, d: int) -> list[str]:
    """The measures that there are for n points in d dimensions within about a second each."""
    return [
        info.name
        for info in discrepancy.registered()
        if info.least_dimensions <= d <= info.most_dimensions and n <= info.quick_points
    ]


def measure_all(points: Points, specs: Iterable[str], seed: int) -> list[Measured | Refused]:
    """These measures of points (n, d) in [0, 1], or the quick ones where none is named; of those some may not be had.

    Raises SpecError; Unsupported for a named one that cannot be had, and where no measure is quick.
    """
    named = list(specs)
    if named:
        return [discrepancy.measure(spec, points, seed) for spec in named]
    found: list[Measured | Refused] = []
    for name in quick(*points.shape):
        try:
            found.append(discrepancy.measure(name, points, seed))
        except Unsupported as error:
            found.append(Refused(name, str(error)))
    if not found:
        raise Unsupported(f"no measure is quick for {len(points)} points; name some (--measure)")
    return found
