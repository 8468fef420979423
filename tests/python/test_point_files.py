"""Files of points: what is read, bit for bit, and what an error says where."""

from __future__ import annotations

import io
import os
import pickle
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from commands import COMMAND, complaint, run
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import aliascope
from aliascope.errors import InvalidInput
from aliascope.studies import point_files
from aliascope.studies.point_files import read_points

Array = NDArray[np.float64]
TWO = [[0.125, 0.5], [1.0, 0.0]]


def wrong(path: Path) -> str:
    with pytest.raises(InvalidInput) as caught:
        read_points(str(path))
    return str(caught.value)


# --- what is read -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        "0.125,0.5\n1,0\n",
        "0.125,0.5\n1,0",
        "0.125 , 0.5\n 1,0 \n",
        "0.125;0.5\n1; 0\n",
        "0.125\t0.5\n1\t\t0\n",
        "  .125   5e-1\n1.   +0\n",
        "x,y\n0.125,0.5\n1,-0.0\n",
        '"x 1";"y 1"\n0.125;0.5\n1;0\n',
        "u v\n0.125,0.5\n1,0\n",
        "# 16 points\n\n  # x y\nx y\n\n0.125 0.5 # the first\n   \n1 0\n# end\n",
        "\ufeffx,y\n0.125,0.5\n1,0\n",
        "\ufeff0.125,0.5\r\n\r\n1,0\r\n",
        "0.125,0.5\r1,0\r",
        "点,é\n0.125,0.5\n1,0\n",
    ],
)
@pytest.mark.parametrize("chunk", [1, 7, 1 << 22])
def test_texts_of_two_points(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, chunk: int) -> None:
    monkeypatch.setattr(point_files, "_CHUNK", chunk)  # rows and characters of several bytes are cut anywhere
    path = tmp_path / "a.txt"
    path.write_bytes(text.encode())
    found = read_points(str(path))
    assert found.tolist() == TWO
    assert not np.signbit(found).any()
    assert found.flags.c_contiguous


def test_one_column_and_many() -> None:
    for shape in ((5, 1), (1, 1), (1, 3000)):
        values = np.random.default_rng(1).random(shape)
        assert np.array_equal(read(values), values)


def read(values: Array, separator: str = ",") -> Array:
    """By a text with the shortest digits that tell doubles apart."""
    stream = io.BytesIO("\n".join(separator.join(map(repr, row)) for row in values.tolist()).encode())
    return point_files._Text("a").read(stream)


@pytest.mark.parametrize(
    ("ending", "options"),
    [("csv", ("-d", "3")), ("npy", ("-d", "1")), ("npy", ("-d", "2", "--dimensions", "1,0")), ("txt", ("-d", "2"))],
)
def test_what_the_command_writes_is_read_bit_for_bit(tmp_path: Path, ending: str, options: tuple[str, ...]) -> None:
    path, arguments = tmp_path / f"a.{ending}", ("points", "random", "-n", "3000", "--seed", "7", *options)
    if ending == "txt":
        path.write_text(run(*arguments).stdout)
    else:
        run(*arguments, "-o", path)
    expected = aliascope.points("random", 3000, int(options[1]), seed=7)
    assert np.array_equal(read_points(str(path)), expected[:, ::-1] if "--dimensions" in options else expected)


def test_many_rows_grow_in_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(point_files, "_CHUNK", 1 << 14)
    values = np.random.default_rng(2).random((20_000, 2))  # 50 chunks
    assert np.array_equal(read(values), values)


@pytest.mark.parametrize("kind", ["f2", "f4", "<f8", ">f8", "u1", "i8"])
@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_of_other_numbers(tmp_path: Path, kind: str, order: str) -> None:
    values = np.array(TWO if "f" in kind else [[0, 1], [1, 0]]).astype(kind, order=order)  # type: ignore[call-overload]
    np.save(tmp_path / "a.npy", values)
    found = read_points(str(tmp_path / "a.npy"))
    assert (found.tolist(), found.dtype, found.flags.c_contiguous) == (values.tolist(), np.float64, True)


def test_standard_input() -> None:
    made = subprocess.run(
        [*COMMAND, "discrepancy", "-", "--measure", "star"], input="x y\n.5 .5\n", capture_output=True, text=True
    )
    assert made.stdout.startswith("star  0.75  at 0.5, 0.5, closed")
    made = subprocess.run([*COMMAND, "points", "-"], input="0.5,2\n", capture_output=True, text=True)
    assert (made.returncode, made.stdout) == (2, "")
    assert made.stderr.startswith("aliascope: standard input:1: 2 is not in [0, 1]")


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("0.1,0.2\n0.3\n", 2, "has 1 column, the rows before it 2"),
        ("0.1,0.2\n\n# no\n0.3,0.4,0.5\n", 4, "has 3 columns, the rows before it 2"),
        ("x,y\n0.1,0.2\n0.3,1.5\n", 3, r"1.5 is not in \[0, 1\]"),
        ("x,y\n0.1,0.2\n-1e-300,1\n", 3, r"-1e-300 is not in \[0, 1\]"),
        ("0.1,0.2\n1.0000000000000002,0\n", 2, "1.0000000000000002 is not in"),
        ("0.1,nan\n", 1, "nan is not in"),
        ("0.1 0.2\ninf 0.1", 2, "inf is not in"),
        ("0.1,0.2\n0.1,x\n", 2, '"x" is no number'),
        ("0.1,x\n0.1,0.2\n", 1, '"x" is no number'),
        ("x,y\nu,v\n", 2, '"u" is no number'),
        ("0.1,0.2\nx,y\n", 2, '"x" is no number'),
        ("0.1x,0.2y\n0.1,0.2\n", 1, '"0.1x" is no number'),
        ("0.1,,0.2\n", 1, "a field is empty"),
        ("0.1,0.2,\n", 1, "a field is empty"),
        ("0,1;0,2\n", 1, '"0,1" is no number, whose decimal sign has to be a point'),
        ("0.1,0.2\n0.1;0.2\n", 2, '"0.1;0.2" is no number'),
        ("0.1,0.2\n0.1 0.2\n", 2, '"0.1 0.2" is no number'),
        ("0.1,0.2\n1_0,0.2\n", 2, '"1_0" is no number'),
        ("0.1,0.2\n0x1p-1,0.2\n", 2, '"0x1p-1" is no number'),
        ("0.1,0.2\n٣,0.2\n", 2, '"٣" is no number'),
        ("x\n0.1,0.2\n", 1, "names 1 columns, but line 2 has 2"),
        ("x y\n0.1\n", 1, "names 2 columns, but line 2 has 1"),
        ("0.1,0.2\n" * 9 + "0.1,\0\n", 10, r'"\\x00" is no number'),
        ("x\x07,y\n0.1,0.2\n", 1, r'"x\\x07" is no number'),
        ("0.1," + "z" * 1000 + "\n", 1, r'"z{37}\.\.\." is no number'),
    ],
)
@pytest.mark.parametrize("chunk", [5, 1 << 22])
def test_the_line_that_is_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, line: int, says: str, chunk: int
) -> None:
    monkeypatch.setattr(point_files, "_CHUNK", chunk)
    path = tmp_path / "a.csv"
    path.write_text(text)
    assert re.match(re.escape(f"{path}:{line}: ") + says, wrong(path))


def test_a_wrong_line_far_down(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("x y\n" + "0.123456789012345 0.123456789012345\n" * 300_000 + "\n0.1 0.2 0.3\n")
    assert wrong(path).startswith(f"{path}:300003: has 3 columns")


@pytest.mark.parametrize("text", ["", "\n\n", "# only\n", "x,y\n", "\ufeff"])
def test_no_points(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    assert "a.csv: has no points; " in wrong(tmp_path / "a.csv")


def test_rubbish(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"0.1,0.2\n0.3,0.4\n0.5,\xff\n")
    assert wrong(path).startswith(f"{path}:3: is no text in UTF-8")
    monkeypatch.setattr(point_files, "_CHUNK", 4)
    assert wrong(path).startswith(f"{path}:3: is no text in UTF-8")
    path.write_bytes(np.random.default_rng(1).bytes(5000))
    assert "is no text" in wrong(path)
    monkeypatch.setattr(point_files, "_LONGEST_LINE", 100)
    path.write_bytes(b"0.1 0.2\n" + bytes(1000))
    assert wrong(path).startswith(f"{path}:2: is too long a line")
    assert "Is a directory" in wrong(tmp_path)
    assert "No such file" in wrong(tmp_path / "none.csv")


def saved(values: object) -> bytes:
    stream = io.BytesIO()
    np.save(stream, values, allow_pickle=True)  # type: ignore[arg-type]
    return stream.getvalue()


# Version 3 of the format, which NumPy warns of.
NAMED_COLUMNS = saved(np.zeros(2, [("x", float)])).replace(b"NUMPY\x01\x00v\x00", b"NUMPY\x03\x00v\x00\x00\x00")


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "is no .npy file; write one with numpy.save"),
        (b"no array", "is no .npy file"),
        (b"\x93NUMPY\x01\x00", "is no .npy file"),
        (pickle.dumps([[0.5, 0.5]]), "is no .npy file"),
        (saved(np.array([[0.5, None]], dtype=object)), "holds object, not float64"),
        (saved(np.array([["a", "b"]])), "holds <U1, not float64"),
        (saved(np.array([[0.5 + 0j]])), "holds complex128"),
        (saved(np.array([[True]])), "holds bool"),
        (saved(np.array([[0.5]], np.longdouble)), "holds float128"),
        (saved(np.zeros(2, [("x", float), ("y", float)])), "not float64"),
        (NAMED_COLUMNS, "holds no plain numbers"),
        (saved(np.zeros(4)), r"shape \(4,\), not \(n, d\)"),
        (saved(np.zeros((2, 2, 2))), r"shape \(2, 2, 2\)"),
        (saved(np.float64(0.5)), r"shape \(\)"),
        (saved(np.zeros((0, 2))), r"shape \(0, 2\)"),
        (saved(np.zeros((2, 0))), r"shape \(2, 0\)"),
        (saved(np.zeros((4, 2)))[:-1], "is cut off: 63 of 64 bytes are there"),
        (saved(np.zeros((4, 2))).replace(b"(4, 2)", b"(-4,2)"), r"shape \(-4, 2\)"),
        (saved(np.array([[0.5, 1.0], [0.0, np.nan]])), r"row 1, counted from 0: nan is not in \[0, 1\]"),
        (saved(np.array([[0.5, 1.0], [2.0, 0.0]], order="F")), "row 1, counted from 0: 2 is not in"),
        (saved(np.array([[-1]])), "row 0, counted from 0: -1 is not in"),
    ],
)
def test_arrays_that_are_no_points(tmp_path: Path, content: bytes, says: str) -> None:
    (tmp_path / "a.npy").write_bytes(content)
    assert re.match(re.escape(f"{tmp_path / 'a.npy'}: ") + ".*" + says, wrong(tmp_path / "a.npy"))


def test_a_shape_that_no_memory_holds(tmp_path: Path) -> None:
    (tmp_path / "a.npy").write_bytes(saved(np.zeros((4, 2))).replace(b"(4, 2), }        ", b"(4000000000000, 9)}"))
    assert "is cut off: " in wrong(tmp_path / "a.npy")


def test_the_limits_are_taken_to_their_edge(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text, stored = tmp_path / "a.csv", tmp_path / "a.npy"
    text.write_text("0.5,0.25,0.125\n" * 20)
    np.save(stored, np.full((20, 3), 0.5))
    monkeypatch.setattr(point_files, "MOST_COLUMNS", 3)
    monkeypatch.setattr(point_files, "MOST_NUMBERS", 60)
    for chunk in (16, 1 << 22):  # the numbers of all chunks count
        monkeypatch.setattr(point_files, "_CHUNK", chunk)
        for path in (text, stored) if chunk > 16 else (text,):
            with monkeypatch.context() as lowered:
                assert read_points(str(path)).shape == (20, 3)
                lowered.setattr(point_files, "MOST_NUMBERS", 59)
                assert "has more than 59 numbers, the most that are read" in wrong(path)
                lowered.setattr(point_files, "MOST_COLUMNS", 2)
                assert "has 3 columns; points have at most 2 dimensions" in wrong(path)
    assert wrong(stored.rename(tmp_path / "b.txt")).startswith(f"{tmp_path / 'b.txt'}:1: is no text")


def test_the_line_that_has_too_many_columns_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(point_files, "MOST_COLUMNS", 2)
    (tmp_path / "a.csv").write_text("# x\n0.5,0.5,0.5\n")
    assert wrong(tmp_path / "a.csv").startswith(f"{tmp_path / 'a.csv'}:2: has 3 columns")


def test_an_array_in_a_file_that_is_too_large_is_not_looked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its header may say that it is as long."""
    (tmp_path / "a.npy").write_bytes(saved(np.full((4, 2), 0.5)) + bytes(2000))
    monkeypatch.setattr(point_files, "_CHUNK", 1000)
    assert read_points(str(tmp_path / "a.npy")).shape == (4, 2)
    monkeypatch.setattr(point_files, "MOST_NUMBERS", 100)
    assert "has more than 100 numbers" in wrong(tmp_path / "a.npy")


def test_what_points_hold_at_most() -> None:
    """In bytes, as float64; a line is held as text."""
    assert 8 * point_files.MOST_NUMBERS <= 1 << 30
    assert point_files._LONGEST_LINE <= 1 << 26


def test_the_pipe_of_a_shell_is_read_and_no_other_device() -> None:
    reading, writing = os.pipe()
    zero = os.open("/dev/zero", os.O_RDONLY)
    try:
        os.write(writing, b"0.125,0.5\n1,0\n")
        os.close(writing)
        assert read_points(f"/dev/fd/{reading}").tolist() == TWO
        assert "it is no file, but a pipe or a device" in wrong(Path(f"/dev/fd/{zero}"))
    finally:
        os.close(reading)
        os.close(zero)


def test_a_pipe_by_its_name_may_have_no_writer(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.csv")
    with pytest.raises(InvalidInput, match="it is no file, but a pipe or a device"):
        point_files._check_kind(tmp_path / "a.csv")


def test_names_of_no_points(tmp_path: Path) -> None:
    assert "a name has no NUL byte" in wrong(tmp_path / "a\0.csv")
    assert "Is a directory" in wrong(tmp_path)
    (tmp_path / "a.npy").mkdir()
    assert "Is a directory" in wrong(tmp_path / "a.npy")


def test_errors_are_one_line_and_exit_code_2(tmp_path: Path) -> None:
    (tmp_path / "a.dat").write_text("0.1 0.2\n0.1 a\n")
    for command in (("points",), ("discrepancy", "--measure", "star")):
        assert f"{tmp_path / 'a.dat'}:2: " in complaint(*command, tmp_path / "a.dat", code=2)


TOKENS = ["0.1", "0.25", "1", "0", "-0.0", "1e-3", ".5", "5.", "1e999", "1.5", "nan", "inf", "x", "y1", "1_0", "0x1p-1"]
MARKS = ["#", ",", ";", ".", "+", "-"]
SPACES = [" ", "\t", "\n", "\r\n", "\r", "\x0b", "\x0c", "\x1c", "\x85", "\xa0", "\u2028", "\ufeff", "\0"]


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.lists(st.sampled_from(TOKENS + MARKS + SPACES), max_size=14))
def test_all_rows_at_once_are_the_rows_one_by_one(tokens: list[str]) -> None:
    def found(read: Callable[[], Array]) -> object:
        try:
            return read().tolist()
        except InvalidInput as error:
            return str(error)

    def refuse(lines: list[str], separator: str | None) -> Array:
        raise ValueError

    text = "".join(tokens).encode()
    quick = found(lambda: point_files._Text("a").read(io.BytesIO(text)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(point_files, "_parse", refuse)
        assert found(lambda: point_files._Text("a").read(io.BytesIO(text))) == quick
