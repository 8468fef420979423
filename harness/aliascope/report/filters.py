"""The reconstruction filters as signals: what each lets through at which frequency."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aliascope.errors import AliascopeError

NYQUIST = 0.5
"""Cycles per pixel. A picture holds what is below; what a filter leaves of the rest comes back as a pattern."""

HIGHEST = 2.0
STEPS = 80
FREQUENCIES = tuple(round(HIGHEST * i / STEPS, 6) for i in range(STEPS + 1))
"""Cycles per pixel, from 0 to HIGHEST; quarters are among them, which the page's table tells."""


@dataclass(frozen=True)
class Response:
    """A filter with its parameters' defaults: its amplitude at FREQUENCIES, and its radius in pixels."""

    name: str
    title: str
    source: str
    radius: float
    amplitude: tuple[float, ...]


def filter_responses() -> tuple[Response, ...]:
    """Those of all registered filters; none where the library that has them cannot be loaded."""
    try:
        from aliascope.native import filters  # late: a report of old results needs no library

        return tuple(
            Response(
                name=info.name,
                title=info.title,
                source=info.source,
                radius=filters.radius(info.name),
                # 6 decimals: below those, a response is the rounding of its integral; + 0.0 makes -0.0 plain 0
                amplitude=tuple(round(float(a), 6) + 0.0 for a in filters.response(info.name, np.array(FREQUENCIES))),
            )
            for info in filters.registered()
        )
    except (ImportError, AliascopeError):
        return ()


def filters_json(responses: Sequence[Response]) -> list[dict[str, Any]]:
    """For the page's scripts; amplitudes to 4 decimals, finer than a plot shows."""
    return [
        {
            "name": response.name,
            "title": response.title,
            "source": response.source,
            "radius": response.radius,
            "amplitude": [round(a, 4) + 0.0 for a in response.amplitude],
        }
        for response in responses
    ]


def filters_csv(responses: Sequence[Response]) -> str:
    """One line a frequency, one column of amplitudes a filter."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["cycles_per_pixel", *(response.name for response in responses)])
    writer.writerows(zip(FREQUENCIES, *(response.amplitude for response in responses), strict=True))
    return out.getvalue()
