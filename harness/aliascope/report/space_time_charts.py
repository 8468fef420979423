"""The figures of the page about patterns of space and time: a pattern's times in the pixel, time against distance,
error against time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aliascope.report.charts import element, words
from aliascope.report.teaching import spread_out

Array = NDArray[np.float64]
RAMP = ((68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37))
"""Of time, from the opening of the shutter to its closing: five colours of matplotlib's viridis."""


def times_picture(points: Array, name: str) -> str:
    """Points (n, 3): their places, x to the right and y downward, and in each the n-th part of the time that it has."""
    n = len(points)
    side = math.isqrt(n)
    size = 25.0 / math.sqrt(n)
    step = [round(100 * i / side, 3) for i in range(1, side)] if side * side == n else []
    parts = [
        element("path", d="".join(f"M{x} 0V100M0 {x}H100" for x in step), class_="cells") if step else "",
        element("rect", x=0, y=0, width=100, height=100, class_="frame"),
    ]
    for x, y, time in points.tolist():
        parts.append(element("circle", cx=f"{100 * x:.2f}", cy=f"{100 * y:.2f}", r=round(size, 2), fill=colour(time)))
        place = {"x": f"{100 * x:.2f}", "y": f"{100 * y + 0.35 * size:.2f}", "font_size": round(size, 2)}
        parts.append(words(f"{math.floor(time * n)}", fill="#ffffff" if time < 0.55 else "#000000", **place))
    label = f"{name}: {n} points, each with the number of its time from 0 to {n - 1}"
    return element("svg", "".join(parts), class_="times", viewBox="-7 -7 114 114", role="img", aria_label=label)


def colour(time: float) -> str:
    """Of a time in [0, 1]."""
    place = time * (len(RAMP) - 1)
    below = min(int(place), len(RAMP) - 2)
    mixed = (round(a + (place - below) * (b - a)) for a, b in zip(RAMP[below], RAMP[below + 1], strict=True))
    return "#" + "".join(f"{each:02x}" for each in mixed)


@dataclass(frozen=True)
class Mark:
    """A point with its error bars, (low, high) or None, the name beside it, and which of the colours it has."""

    name: str
    x: float
    y: float
    x_limits: tuple[float, float] | None
    y_limits: tuple[float, float] | None
    series: int


@dataclass(frozen=True)
class Profile:
    """A line: (x, y, (low, high) or None), and which of the colours it has."""

    name: str
    points: tuple[tuple[float, float, tuple[float, float] | None], ...]
    series: int


LEFT, RIGHT, TOP = 44.0, 318.0, 26.0


@dataclass(frozen=True)
class _Axes:
    low_x: float
    high_x: float
    low_y: float
    high_y: float
    bottom: float
    logarithmic: bool = False

    def x(self, value: float) -> float:
        return round(LEFT + (value - self.low_x) / (self.high_x - self.low_x) * (RIGHT - LEFT), 2)

    def y(self, value: float) -> float:
        low, high = (math.log(self.low_y), math.log(self.high_y)) if self.logarithmic else (self.low_y, self.high_y)
        share = ((math.log(value) if self.logarithmic else value) - low) / (high - low)
        return round(self.bottom - share * (self.bottom - TOP), 2)

    def drawn(self, title: str, label: str, x_ticks: Sequence[float], y_ticks: Sequence[float]) -> str:
        parts = [words(title, x=0, y=13, class_="title")]
        for value in y_ticks:
            parts.append(element("path", d=f"M{LEFT} {self.y(value)}H{RIGHT}", class_="grid"))
            parts.append(words(f"{value:g}", x=LEFT - 5, y=self.y(value) + 4, text_anchor="end"))
        for value in x_ticks:
            parts.append(element("path", d=f"M{self.x(value)} {TOP}V{self.bottom}", class_="grid"))
            parts.append(words(f"{value:g}", x=self.x(value), y=self.bottom + 17, text_anchor="middle"))
        parts.append(element("path", d=f"M{LEFT} {self.bottom}H{RIGHT}", class_="axis"))
        middle = 0.5 * (LEFT + RIGHT)
        parts.append(words(label, x=middle, y=self.bottom + 35, text_anchor="middle", class_="title"))
        return "".join(parts)

    def bar(self, x: float, limits: tuple[float, float] | None) -> str:
        """Upright, over the limits of y."""
        if limits is None:
            return ""
        return element("path", d=f"M{self.x(x)} {self.y(limits[0])}V{self.y(limits[1])}", class_="bar")


def profile_chart(profiles: Sequence[Profile], title: str, label: str) -> str:
    """Up to five lines with their intervals, the names at their ends."""
    values = [value for one in profiles for _, y, limits in one.points for value in (y, *(limits or ()))]
    low, high = min(*values, 0.8) - 0.02, max(*values, 1.3) + 0.02
    axes = _Axes(0.0, max(x for one in profiles for x, *_ in one.points) + 0.2, low, high, 296.0)
    ticks = [round(0.1 * i, 1) for i in range(21) if low <= 0.1 * i <= high]
    parts = [axes.drawn(title, label, range(5), ticks)]
    ends = [one.points[-1] for one in profiles]
    places = spread_out([axes.y(y) for _, y, _ in ends], 15.0, TOP + 4.0, axes.bottom)
    for i, (one, place) in enumerate(zip(profiles, places, strict=True)):
        path = "M" + "L".join(f"{axes.x(x)} {axes.y(y)}" for x, y, _ in one.points)
        drawn = [element("path", d=path, class_="fitted")]
        for x, y, limits in one.points:
            drawn += [axes.bar(x, limits), element("circle", cx=axes.x(x), cy=axes.y(y), r=2.4, class_="measured")]
        drawn.append(_named(one.name, axes.x(ends[i][0]) + 6, axes.y(ends[i][1]), place))
        parts.append(element("g", "".join(drawn), class_=f"series s{one.series}"))
    names = f"{title}: " + ", ".join(one.name for one in profiles)
    return element("svg", "".join(parts), class_="chart", viewBox="0 0 520 340", role="img", aria_label=names)


def scatter_chart(marks: Sequence[Mark], title: str, label: str) -> str:
    """y logarithmic, the names at the right."""
    bottom = max(300.0, 14.5 * len(marks) + TOP)
    xs = [x for one in marks for x in (one.x, *(one.x_limits or ()))]
    ys = [y for one in marks for y in (one.y, *(one.y_limits or ()))]
    sides = min(*xs, 0.94) - 0.04, max(*xs, 1.06) + 0.04
    axes = _Axes(*sides, min(ys) / 1.05, max(ys) * 1.05, bottom, logarithmic=True)
    x_ticks = [0.1 * i for i in range(21) if axes.low_x <= 0.1 * i <= axes.high_x]
    y_ticks = [
        factor * 10.0**exponent
        for exponent in range(-8, 2)
        for factor in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)
        if axes.low_y < factor * 10.0**exponent < axes.high_y
    ]
    parts = [axes.drawn(title, label, [round(x, 1) for x in x_ticks], y_ticks)]
    places = spread_out([axes.y(one.y) for one in marks], 14.5, TOP + 4.0, bottom)
    for one, place in zip(marks, places, strict=True):
        x, y = axes.x(one.x), axes.y(one.y)
        drawn = [_named(one.name, x + 5, y, place), axes.bar(one.x, one.y_limits)]
        if one.x_limits is not None:
            drawn.append(element("path", d=f"M{axes.x(one.x_limits[0])} {y}H{axes.x(one.x_limits[1])}", class_="bar"))
        drawn.append(element("circle", cx=x, cy=y, r=3, class_="measured"))
        parts.append(element("g", "".join(drawn), class_=f"series s{one.series}"))
    names = f"{title}: " + ", ".join(one.name for one in marks)
    height = bottom + 44.0
    return element("svg", "".join(parts), class_="chart", viewBox=f"0 0 570 {height:g}", role="img", aria_label=names)


def _named(name: str, x: float, y: float, place: float) -> str:
    """A name right of the axes, and a line to it."""
    line = f"M{x} {y}L{RIGHT + 10} {round(place, 2)}H{RIGHT + 14}"
    text = words(name, x=RIGHT + 18, y=round(place + 4, 2), class_="label narrow")
    return element("path", d=line, class_="leader") + text
