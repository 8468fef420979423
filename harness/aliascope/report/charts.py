"""The figures of a teaching page: figures against counts, point sets, an edge across one, radial spectra."""

from __future__ import annotations

import base64
import math
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from aliascope.report.teaching import attributes, spread_out

Array = NDArray[np.float64]
Bytes = NDArray[np.uint8]


@dataclass(frozen=True)
class Series:
    """A line of a chart: (n, value) measured; published ones where there are; closed: (constant, exponent)."""

    name: str
    measured: tuple[tuple[float, float], ...]
    published: tuple[tuple[float, float], ...] = ()
    closed: tuple[float, float] | None = None


def element(name: str, content: str = "", **values: object) -> str:
    """An SVG element; `class_` stands for class, "_" in a name for "-". The content is markup."""
    named = {key.rstrip("_"): value for key, value in values.items()}
    return f"<{name}{attributes(named)}>{content}</{name}>" if content else f"<{name}{attributes(named)}/>"


def words(text: str, **values: object) -> str:
    """A text element; the text is escaped."""
    return element("text", str(Markup.escape(text)), **values)


# --- figures against counts -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Frame:
    """The log-log axes: from data to the units of the drawing."""

    low_n: float
    high_n: float
    low: float
    high: float
    left: float
    right: float
    top: float
    bottom: float

    def x(self, n: float) -> float:
        share = math.log(n / self.low_n) / math.log(self.high_n / self.low_n)
        return round(self.left + share * (self.right - self.left), 2)

    def y(self, value: float) -> float:
        share = math.log(value / self.low) / math.log(self.high / self.low)
        return round(self.bottom - share * (self.bottom - self.top), 2)

    def path(self, points: Sequence[tuple[float, float]]) -> str:
        return "M" + "L".join(f"{self.x(n)} {self.y(value)}" for n, value in points)


def convergence_chart(series: Sequence[Series], title: str, counts: Sequence[int]) -> str:
    """Both axes logarithmic, the names at the lines' ends. Five series have colours, more are all in ink."""
    values = [value for one in series for _, value in (*one.measured, *one.published)]
    few = len(series) <= 5
    height = 400.0 if few else max(400.0, 15.0 * len(series) + 80.0)
    low, high = min(values) / 1.1, max(values) * 1.1
    measured = [n for one in series for n, _ in one.measured]
    frame = _Frame(
        min(measured) / 1.18, max(measured) * 1.18, low, high, 44.0, 392.0 if few else 330.0, 26.0, height - 44.0
    )
    parts = [words(title, x=0, y=13, class_="title"), _grid(frame, counts)]
    ends = [one.measured[-1] for one in series]
    places = spread_out([frame.y(value) for _, value in ends], 14.0, frame.top + 4.0, frame.bottom)
    for i, (one, place) in enumerate(zip(series, places, strict=True)):
        parts.append(_line(frame, one, f"series s{i}" if few else "series many", place))
    label = f"{title}, against the number of points: " + ", ".join(one.name for one in series)
    return element("svg", "".join(parts), class_="chart", viewBox=f"0 0 520 {height:g}", role="img", aria_label=label)


def _grid(frame: _Frame, counts: Sequence[int]) -> str:
    parts = []
    for exponent in range(math.floor(math.log10(frame.low)), math.ceil(math.log10(frame.high)) + 1):
        for factor in (1, 2, 5):
            value = factor * 10.0**exponent
            if not frame.low < value < frame.high:
                continue
            y = frame.y(value)
            parts.append(element("path", d=f"M{frame.left} {y}H{frame.right}", class_="grid"))
            parts.append(words(f"{value:g}", x=frame.left - 5, y=y + 4, text_anchor="end"))
    for n in counts:
        x = frame.x(n)
        parts.append(element("path", d=f"M{x} {frame.top}V{frame.bottom}", class_="grid"))
        parts.append(words(f"{n:,}", x=x, y=frame.bottom + 17, text_anchor="middle"))
    parts.append(element("path", d=f"M{frame.left} {frame.bottom}H{frame.right}", class_="axis"))
    middle = (frame.left + frame.right) / 2
    parts.append(words("points", x=middle, y=frame.bottom + 35, text_anchor="middle", class_="title"))
    return "".join(parts)


def _line(frame: _Frame, one: Series, class_: str, place: float) -> str:
    parts = []
    if one.closed:
        constant, exponent = one.closed
        ends = [(n, constant * n**exponent) for n in (frame.low_n, frame.high_n)]
        parts.append(element("path", d=frame.path(ends), class_="closed"))
    parts.append(element("path", d=frame.path(one.measured), class_="fitted"))
    for n, value in one.published:
        parts.append(element("circle", cx=frame.x(n), cy=frame.y(value), r=5, class_="published"))
    for n, value in one.measured:
        parts.append(element("circle", cx=frame.x(n), cy=frame.y(value), r=2.6, class_="measured"))
    n, value = one.measured[-1]
    start, end = frame.x(n) + 8, frame.right + 14
    parts.append(element("path", d=f"M{start} {frame.y(value)}L{end} {round(place, 2)}H{end + 4}", class_="leader"))
    parts.append(words(one.name, x=end + 8, y=round(place + 4, 2), class_="label"))
    return element("g", "".join(parts), class_=class_)


# --- point sets -------------------------------------------------------------------------------------------------------


def set_picture(points: Array, name: str, cells: int = 0, downward: bool = False) -> str:
    """Points in the unit square, the second coordinate upward or `downward`; `cells`: a grid of so many a side."""
    shown = points * (1.0, -1.0) + (0.0, 1.0) if downward else points
    return element(
        "svg",
        _lines(cells) + element("rect", x=0, y=0, width=100, height=100, class_="frame") + _dots(shown),
        class_="set",
        viewBox="-2 -2 104 104",
        role="img",
        aria_label=f"{name}: {len(points)} points",
    )


def _lines(cells: int) -> str:
    step = [round(100 * i / cells, 3) for i in range(1, cells)]
    return element("path", d="".join(f"M{x} 0V100M0 {x}H100" for x in step), class_="cells") if cells else ""


def _dots(points: Array) -> str:
    """As one path of round caps: small also where there are many."""
    size = min(max(16.0 / math.sqrt(len(points)), 0.9), 5.0)
    path = "".join(f"M{100 * x:.2f} {100 - 100 * y:.2f}h0" for x, y in points)
    return element("path", d=path, class_="dots", stroke_width=round(size, 2))


def edge_picture(points: Array, angle: float, offset: float) -> tuple[str, int, float]:
    """A set and an edge, the side where x cos + y sin < offset shaded; how many points that side has, and what area."""
    a, b = math.cos(angle), math.sin(angle)
    inside = int((points @ np.array([a, b]) < offset).sum())
    side = _clipped([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], a, b, offset)
    pairs = list(zip(side, side[1:] + side[:1], strict=True))
    area = abs(sum(x * v - u * y for (x, y), (u, v) in pairs)) / 2.0
    on_edge = [(x, y) for x, y in side if abs(a * x + b * y - offset) < 1e-9]
    path = "M" + "L".join(f"{100 * x:.2f} {100 - 100 * y:.2f}" for x, y in side) + "Z"
    ends = "M" + "L".join(f"{100 * x:.2f} {100 - 100 * y:.2f}" for x, y in on_edge[:2])
    drawn = element("path", d=path, class_="side") + element("path", d=ends, class_="edge")
    picture = element(
        "svg",
        drawn + element("rect", x=0, y=0, width=100, height=100, class_="frame") + _dots(points),
        class_="set",
        viewBox="-2 -2 104 104",
        role="img",
        aria_label=f"{len(points)} points and an edge; {inside} points on its shaded side",
    )
    return picture, inside, area


def _clipped(polygon: list[tuple[float, float]], a: float, b: float, offset: float) -> list[tuple[float, float]]:
    """The part of a convex polygon where a x + b y <= offset (Sutherland and Hodgman 1974)."""
    made = []
    for (x, y), (u, v) in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        here, there = a * x + b * y - offset, a * u + b * v - offset
        if here <= 0.0:
            made.append((x, y))
        if here * there < 0.0:
            share = here / (here - there)
            made.append((x + share * (u - x), y + share * (v - y)))
    return made


# --- spectra ----------------------------------------------------------------------------------------------------------


def power_picture(power: Array, name: str) -> str:
    """The power in two dimensions as a grey picture, white from twice that of independent points."""
    grey = np.clip(np.rint(power[::-1] * 127.5), 0, 255).astype(np.uint8)
    text = base64.b64encode(png(grey)).decode("ascii")
    return element(
        "img", src=f"data:image/png;base64,{text}", alt=f"Power spectrum of {name}, frequency 0 in the middle"
    )


def png(pixels: Bytes) -> bytes:
    """(height, width) grey or (height, width, 3) as a PNG of 8 bits (ISO 15948), its rows unfiltered: noise gains
    nothing by a filter."""
    height, width = pixels.shape[:2]
    kind = 0 if pixels.ndim == 2 else 2
    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1).tobytes()
    chunks = [
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)),
        (b"IDAT", zlib.compress(rows, 9)),
        (b"IEND", b""),
    ]
    made = b"\x89PNG\r\n\x1a\n"
    for name, data in chunks:
        made += struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    return made


def radial_picture(frequencies: Sequence[float], power: Sequence[float], peak: float, series: int, name: str) -> str:
    """Radial mean power, 0 to 2 and what is more cut off, against frequency; lines at 1, and where even points peak."""
    last = frequencies[-1]
    places = [(24 + 176 * f / last, 76 - 66 * min(p, 2.2) / 2.2) for f, p in zip(frequencies, power, strict=True)]
    path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    one, at = 76 - 66 / 2.2, 24 + 176 * peak / last
    parts = [
        element("path", d=f"M24 {one:.1f}H200M{at:.1f} 10V76", class_="grid"),
        element("path", d="M24 10V76H200", class_="axis"),
        words("1", x=18, y=f"{one + 4:.1f}", text_anchor="end", class_="small"),
        words("0", x=18, y=78, text_anchor="end", class_="small"),
        words("√N", x=f"{at:.1f}", y=90, text_anchor="middle", class_="small"),
        words(f"{last:g}", x=200, y=90, text_anchor="end", class_="small"),
        element("g", element("path", d=path, class_="fitted"), class_=f"series s{series}"),
    ]
    label = f"Radial mean power of {name}"
    return element("svg", "".join(parts), class_="chart", viewBox="0 0 204 94", role="img", aria_label=label)
