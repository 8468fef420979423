"""`aliascope discrepancy`: measures of a sampler's points or a file's."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput
from aliascope.native import discrepancy
from aliascope.native.discrepancy import Measured
from aliascope.point_sets import Refused, measure_all

Array = NDArray[np.float64]


def asked(texts: Iterable[str]) -> list[str]:
    """The measures of `--measure M,M...`, in canonical form. A comma parts measures unless a key=value of the same
    measure follows it: "star,edge-mean:edges=chord,draws=1000". Raises SpecError."""
    found: list[str] = []
    for text in texts:
        open_spec = False
        for part in text.split(","):
            head = part.split(":")[0]
            if open_spec and "=" in head:
                found[-1] += "," + part
            else:
                found.append(part)
                open_spec = ":" in part
    return list(dict.fromkeys(discrepancy.canonical(spec) for spec in found))


def document(measured: Sequence[Measured | Refused]) -> dict[str, Any]:
    """The part "measures" and "details" of what --json prints."""
    return {
        "measures": {one.spec: one.value for one in measured},
        "details": {one.spec: one.details for one in measured},
    }


def lines(measured: Sequence[Measured | Refused]) -> list[str]:
    """A line a measure: its name, its value, how certain that is, where an extreme is met."""
    width = max(len(one.spec) for one in measured)
    return [f"{one.spec:{width}}  {_said(one)}" for one in measured]


WITHOUT_BORDER = frozenset({"dispersion", "min-distance"})
"""Measures whose extreme is no set that points are counted in, with its border or without."""


def _said(one: Measured | Refused) -> str:
    if isinstance(one, Refused):
        return f"none: {one.reason}"
    text = f"{one.value:.10g}"
    if one.certainty == "bounds":
        text += f"  in [{one.lower:.6g}, {one.upper:.6g}]"
    if one.certainty == "estimated":
        text += f"  +- {one.standard_error:.2g}"
    if one.witness:
        text += f"  at {', '.join(f'{x:.6g}' for x in one.witness)}"
        if one.spec.split(":")[0] not in WITHOUT_BORDER:
            text += ", closed" if one.closed else ", open"
    return text


def projections(points: Array, specs: Sequence[str], seed: int) -> list[tuple[int, int, list[Measured | Refused]]]:
    """Every pair of dimensions A < B, with the measures of the points' projection onto it.

    Raises InvalidInput for points of one dimension.
    """
    if points.shape[1] < 2:
        raise InvalidInput("projections are onto two dimensions; these points have one")
    pairs = itertools.combinations(range(points.shape[1]), 2)
    return [(a, b, measure_all(points[:, [a, b]], specs, seed)) for a, b in pairs]
