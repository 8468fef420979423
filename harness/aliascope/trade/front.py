"""Which modes are on the Pareto front of error against time, and how surely."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aliascope.trade.records import OnFront
from aliascope.trade.uncertainty import Array, Points


def undominated(times: Array, errors: Array) -> NDArray[np.bool_]:
    """Of points (n, draws): whether no other one of the same draw is as fast and as good, and better in one of them."""
    order = np.lexsort((errors, times), axis=0)
    time, error = np.take_along_axis(times, order, 0), np.take_along_axis(errors, order, 0)
    found = np.ones(time.shape, dtype=bool)
    found[1:] = error[1:] < np.minimum.accumulate(error)[:-1]
    for k in range(1, len(found)):
        # Equals of one that is on the front are on it.
        found[k] |= found[k - 1] & (time[k] == time[k - 1]) & (error[k] == error[k - 1])
    result = np.empty_like(found)
    np.put_along_axis(result, order, found, 0)
    return result


def front(points: Points) -> tuple[OnFront, ...]:
    """All modes of a scene with their probability, by falling probability, then by time."""
    if not points.rows:
        return ()
    probability = undominated(points.times, points.errors).mean(axis=1)
    known = _known(points)
    return tuple(
        OnFront(points.rows[i].renderer, points.rows[i].mode, float(probability[i]), bool(known[i]))
        for i in np.lexsort((points.time, -probability))
    )


def front_over(scenes: Sequence[Points]) -> tuple[OnFront, ...]:
    """The same over scenes together, of the modes that all of them have: by the mean of a mode's times and the root of
    the mean of its squared errors, each scene weighing the same."""
    modes = [{(row.renderer, row.mode): i for i, row in enumerate(own.rows)} for own in scenes]
    common = [mode for mode in (modes[0] if modes else ()) if all(mode in each for each in modes)]
    if not common:
        return ()
    picked = [[each[mode] for mode in common] for each in modes]
    # As logarithms of sums: a spread that is known from two draws has tails that no double holds.
    times = np.logaddexp.reduce([own.times[i] for own, i in zip(scenes, picked, strict=True)])
    squares = np.logaddexp.reduce([2.0 * own.errors[i] for own, i in zip(scenes, picked, strict=True)])
    probability = undominated(times, squares).mean(axis=1)
    known = np.any([_known(own)[i] for own, i in zip(scenes, picked, strict=True)], axis=0)
    order = np.lexsort((times.mean(axis=1), -probability))
    return tuple(OnFront(common[i][0], common[i][1], float(probability[i]), bool(known[i])) for i in order)


def _known(points: Points) -> NDArray[np.bool_]:
    """Whether the spread of a mode's time or error is known."""
    return ~(np.isnan(points.time_spread.standard_error) & np.isnan(points.error_spread.standard_error))
