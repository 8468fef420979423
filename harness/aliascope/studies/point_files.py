"""Files of points: text of one point a line, or .npy.

Text is UTF-8, with or without a byte order mark, with any line ends. Columns are parted by commas, by semicolons, or by
blanks and tabs, as the first row has them; a comma or semicolon may have blanks around it. What follows a # is a
comment. Lines without anything else are passed over. The first line may be a header: names, none of which begins as a
number does, one for each column.
"""

from __future__ import annotations

import codecs
import contextlib
import io
import stat
import sys
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from aliascope.errors import InvalidInput
from aliascope.point_sets.arrays import outside

Array = NDArray[np.float64]
STANDARD_INPUT = "-"
_CHUNK = 1 << 22
"""Bytes that are read at a time."""
_LONGEST_LINE = 1 << 22

MOST_NUMBERS = 1 << 27
"""Coordinates of a file: 1 GiB."""
MOST_COLUMNS = 10_000
_REMEDY = "points are numbers in [0, 1], one point a line"


def read_points(name: str) -> Array:
    """Points (n, d) in [0, 1], C-ordered float64, of a .npy file, a text file, or "-", standard input, which is text.

    Ten million points of two dimensions: 5 seconds of text. Raises InvalidInput, with the line.
    """
    try:
        if name == STANDARD_INPUT:
            return _Text("standard input").read(sys.stdin.buffer)
        path = Path(name)
        _check_kind(path)
        if path.suffix.lower() == ".npy":
            return _read_npy(path)
        with path.open("rb") as stream:
            return _Text(name).read(stream)
    except (OSError, ValueError) as error:  # ValueError: of a name with a NUL byte
        if isinstance(error, ValueError):
            raise InvalidInput(f"{name}: cannot be read: a name has no NUL byte") from error
        raise InvalidInput(f"{name}: cannot be read: {error.strerror or error}") from error


def _check_kind(path: Path) -> None:
    """Raises InvalidInput for a pipe that may have no writer, and a device, which may never end."""
    mode = path.stat().st_mode
    given = stat.S_ISFIFO(mode) and path.is_relative_to("/dev/fd")  # by a shell, as <(...)
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode) or given):
        raise InvalidInput(f"{path}: cannot be read: it is no file, but a pipe or a device; for standard input take -")


def _check_count(place: str, rows: int, columns: int) -> None:
    if columns > MOST_COLUMNS:
        raise InvalidInput(f"{place}: has {columns} columns; points have at most {MOST_COLUMNS} dimensions")
    if rows * columns > MOST_NUMBERS:
        raise InvalidInput(f"{place}: has more than {MOST_NUMBERS} numbers, the most that are read")


# --- text -------------------------------------------------------------------------------------------------------------


@dataclass
class _Text:
    """A text that is read: what is known of it so far."""

    name: str
    columns: int = 0
    separator: str | None = None
    header: tuple[int, int] | None = None
    """Its line, and how many columns it names."""
    lines: int = 0
    """That are done."""
    before: int = 0
    """That were passed over after those, up to the first row."""

    def read(self, stream: BinaryIO) -> Array:
        values, count = np.empty((0, 1)), 0
        for lines in self._chunks(stream):
            rows = self._rows(lines)
            if not len(rows):
                continue
            _check_count(self.name, count + len(rows), self.columns)
            if count + len(rows) > len(values):
                room = max(count + len(rows), len(values) + len(values) // 2)
                if not count:
                    values = np.empty((room, self.columns))
                else:
                    values.resize((room, self.columns), refcheck=False)  # in place: two copies need twice the memory
            values[count : count + len(rows)] = rows
            count += len(rows)
        if not count:
            raise InvalidInput(f"{self.name}: has no points; {_REMEDY}")
        values.resize((count, self.columns), refcheck=False)
        values += 0.0  # no negative zeros
        return values

    def _chunks(self, stream: BinaryIO) -> Iterator[list[str]]:
        """The lines, some at a time."""
        decoder = io.IncrementalNewlineDecoder(codecs.getincrementaldecoder("utf-8-sig")(), translate=True)
        rest, ended = "", False
        while not ended:
            data = stream.read(_CHUNK)
            ended = not data
            try:
                text = decoder.decode(data, final=ended)
            except UnicodeDecodeError as error:
                number = self.lines + bytes(error.object[: error.start]).count(b"\n") + 1
                raise InvalidInput(f"{self.name}:{number}: is no text in UTF-8; {_REMEDY}, or a .npy file") from None
            lines = (rest + text).split("\n")
            rest = "" if ended else lines.pop()
            if len(rest) > _LONGEST_LINE:
                raise InvalidInput(f"{self.name}:{self.lines + len(lines) + 1}: is too long a line; {_REMEDY}")
            yield lines
            self.lines += len(lines)
            self.before = 0

    def _rows(self, lines: list[str]) -> Array:
        """Those of some lines: all at once, and one by one where something is wrong with them."""
        if not self.columns:
            lines = self._begin(lines)
        if not self.columns:
            return np.empty((0, 1))
        try:
            rows = _parse(lines, self.separator)
            if not rows.size or (rows.shape[1] == self.columns and outside(rows, closed=True) is None):
                return rows
        except ValueError:
            pass
        return self._one_by_one(lines)

    def _begin(self, lines: list[str]) -> list[str]:
        """Takes the separator and the columns from the first row, and a header before it; the lines from that row."""
        for index, line in enumerate(lines):
            content = _content(line)
            if not content:
                continue
            self.separator = ";" if ";" in content else "," if "," in content else None
            fields = content.split(self.separator)
            if self.header is None and all(_is_name(field.strip()) for field in fields):
                self.header = self.lines + index + 1, len(fields)
                continue
            self.columns = len(fields)
            _check_count(f"{self.name}:{self.lines + index + 1}", 1, self.columns)
            self._checked(self.lines + index + 1, fields)
            self.before = index
            return lines[index:]
        return []

    def _one_by_one(self, lines: list[str]) -> Array:
        """Raises InvalidInput for the first line that is wrong."""
        each = ((number, _content(line)) for number, line in enumerate(lines, self.lines + self.before + 1))
        rows = [self._checked(number, content.split(self.separator)) for number, content in each if content]
        return np.array(rows)

    def _checked(self, number: int, fields: list[str]) -> list[float]:
        """The coordinates in a line. Raises InvalidInput."""
        place = f"{self.name}:{number}"
        values = []
        for field in map(str.strip, fields):
            if (value := _number(field)) is None:
                raise InvalidInput(f"{place}: {_what_is_no_number(field)}; {_REMEDY}")
            if not 0.0 <= value <= 1.0:
                raise InvalidInput(f"{place}: {field} is not in [0, 1]; scale the points to the unit square or cube")
            values.append(value)
        if len(fields) != self.columns:
            count = f"{len(fields)} column{'s' * (len(fields) != 1)}"
            raise InvalidInput(f"{place}: has {count}, the rows before it {self.columns}; every point has as many")
        if self.header is not None and self.header[1] != self.columns:
            line, names = self.header
            raise InvalidInput(
                f"{self.name}:{line}: names {names} columns, but line {number} has {self.columns}; "
                "give each column one name, or begin the line with #"
            )
        return values


def _parse(lines: list[str], separator: str | None) -> Array:
    """All rows of some lines at once, (rows, columns). Raises ValueError."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="loadtxt: input contained no data")
        return np.loadtxt(lines, delimiter=separator, comments="#", ndmin=2)


def _content(line: str) -> str:
    return line.partition("#")[0].strip()


def _number(field: str) -> float | None:
    """As NumPy reads it: without underscores between digits and digits of other scripts, which Python takes."""
    with contextlib.suppress(ValueError):
        return float(field) if field.isascii() and "_" not in field else None
    return None


def _is_name(field: str) -> bool:
    return _number(field) is None and field.isprintable() and bool(field) and field[0] not in "0123456789+-.,"


def _what_is_no_number(field: str) -> str:
    if not field:
        return "a field is empty"
    shown = field if len(field) <= 40 else field[:37] + "..."
    remark = ", whose decimal sign has to be a point" if _number(field.replace(",", ".", 1)) is not None else ""
    return f'"{shown}" is no number{remark}'


# --- .npy -------------------------------------------------------------------------------------------------------------


def _read_npy(path: Path) -> Array:
    """By its header first: an array of something else is not read, nor one that is not all there."""
    with path.open("rb") as stream:
        if path.stat().st_size > 8 * MOST_NUMBERS + _CHUNK:  # so that its header is no longer either
            raise InvalidInput(f"{path}: has more than {MOST_NUMBERS} numbers, the most that are read")
        try:
            version = np.lib.format.read_magic(stream)
            read_header = {
                (1, 0): np.lib.format.read_array_header_1_0,
                (2, 0): np.lib.format.read_array_header_2_0,
            }.get(version)
            if read_header is None:
                raise InvalidInput(f"{path}: holds no plain numbers; save the points as float64, of shape (n, d)")
            shape, fortran, dtype = read_header(stream)
        except InvalidInput:
            raise
        except Exception as error:  # what NumPy raises of a broken header, which is Python, is anything
            raise InvalidInput(f"{path}: is no .npy file; write one with numpy.save(file, points)") from error
        if dtype.kind not in "fiu" or dtype.itemsize > 8:
            raise InvalidInput(f"{path}: holds {dtype}, not float64; save points.astype(float)")
        if len(shape) != 2 or min(shape) < 1:
            raise InvalidInput(f"{path}: has the shape {shape}, not (n, d); save n points as n rows of d coordinates")
        here = path.stat().st_size - stream.tell()
        needed = shape[0] * shape[1] * dtype.itemsize
        if here < needed:
            raise InvalidInput(f"{path}: is cut off: {here} of {needed} bytes are there; write it again")
        _check_count(str(path), *shape)
        stored = np.fromfile(stream, dtype, shape[0] * shape[1])
    values = stored.reshape(shape[::-1]).T if fortran else stored.reshape(shape)
    points = np.ascontiguousarray(values, dtype=np.float64)
    row = outside(points, closed=True)
    if row is not None:
        wrong = next(value for value in points[row].tolist() if not 0.0 <= value <= 1.0)
        raise InvalidInput(
            f"{path}: row {row}, counted from 0: {wrong:.17g} is not in [0, 1]; "
            "scale the points to the unit square or cube"
        )
    points += 0.0  # no negative zeros
    return points
