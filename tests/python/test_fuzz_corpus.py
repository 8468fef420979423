"""The kept inputs of the fuzz targets in Python, and what fuzzing found: nothing but one line of an error comes out."""

from __future__ import annotations

import importlib
import logging
import sys
from pathlib import Path

import numpy as np
import pytest

from aliascope import image, meshes, scene_io
from aliascope.errors import LONGEST_MESSAGE, InvalidInput, JobFailed, SpecError
from aliascope.renderers import external_file, find, mode_of
from aliascope.studies import point_files

FUZZ = Path(__file__).resolve().parents[1] / "fuzz"
TARGETS = sorted(path.stem.removeprefix("fuzz_") for path in FUZZ.glob("fuzz_*.py"))


@pytest.mark.parametrize("target", TARGETS)
def test_kept_inputs(target: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(FUZZ), *sys.path])
    one_input = importlib.import_module(f"fuzz_{target}").one_input
    inputs = sorted((FUZZ / "corpus" / target).iterdir())
    assert inputs
    for path in inputs:
        one_input(path.read_bytes())


def test_every_target_has_inputs() -> None:
    sources = [*FUZZ.glob("fuzz_*.c"), *FUZZ.glob("fuzz_*.py")]
    assert {path.name for path in (FUZZ / "corpus").iterdir()} == {path.stem.removeprefix("fuzz_") for path in sources}
    assert sum(path.stat().st_size for path in (FUZZ / "corpus").rglob("*") if path.is_file()) < 500_000


# --- what was found ---------------------------------------------------------------------------------------------------


def test_a_message_is_one_line_and_ends() -> None:
    assert str(InvalidInput('unknown key "a\nb\x1b[0m\udc80"')) == 'unknown key "a\\nb\\x1b[0m\\udc80"'
    assert str(JobFailed("Größe é 4 × 4")) == "Größe é 4 × 4"
    text = str(InvalidInput("x" * 100_000))
    assert len(text) <= LONGEST_MESSAGE + 40
    assert " [... 96000 characters ...] " in text


def test_a_key_with_a_line_end_is_shown_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    path.write_text('"a\\nb" = 1\n')
    with pytest.raises(InvalidInput, match=r's.toml:1: .*"a\\nb"'):
        scene_io.load_file(path)


def test_whole_numbers_beyond_all_doubles_are_refused() -> None:
    for digits in ("1" * 400, "-" + "1" * 400, "1" * 5000):
        with pytest.raises(SpecError, match=r"outside|at most 4096 characters"):
            mode_of(find("embree"), f"uniform:n={digits}")


def test_toml_too_deep_or_too_long_a_number_is_refused(tmp_path: Path) -> None:
    for name, text in (("deep", "a = " + "[" * 5000), ("digits", "a = " + "1" * 5000)):
        path = tmp_path / f"{name}.toml"
        path.write_text(text)
        with pytest.raises(InvalidInput, match=f"{name}.toml: "):
            scene_io.load_file(path)


def test_a_name_with_a_nul_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="is no name of a file"):
        meshes.within(tmp_path, "m\0.obj")


@pytest.mark.parametrize("pattern", ["a{99999999999}(?P<s>.)", "(" * 2000 + "(?P<s>.)" + ")" * 2000])
def test_a_regular_expression_that_python_cannot_take_is_refused(pattern: str) -> None:
    assert "is no regular expression" in str(external_file._regular(pattern, ("s",)))


def test_a_regular_expression_that_another_python_reads_otherwise_is_refused() -> None:
    problem = external_file._regular("(?P<s>[0-9--])", ("s",))
    assert problem == "is ambiguous: Possible set difference at position 10; escape what is meant as it is"


def test_a_header_of_npy_that_does_not_end_is_refused(tmp_path: Path) -> None:
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1, "
    path = tmp_path / "p.npy"
    path.write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    with pytest.raises(InvalidInput, match=r"p.npy: is no .npy file"):
        point_files.read_points(str(path))


@pytest.mark.parametrize("value", [np.nan, -1.0, 0.5, 2.0**32, np.inf])
def test_what_are_no_counts_is_refused(tmp_path: Path, value: float) -> None:
    path = tmp_path / "c.exr"
    image.write_exr(path, np.array([[[1.0], [value]]], np.float32), {}, finite=False)
    with pytest.raises(InvalidInput, match="no counts"):
        image.read_counts(path)


def test_a_mesh_in_the_plane_is_refused() -> None:
    """As an OBJ comes out whose lines have two coordinates here and there."""
    with pytest.raises(InvalidInput, match="corners of 2 coordinates"):
        meshes._check(np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]]), "m.obj")


def test_a_broken_mesh_is_told_once(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "m.stl"
    path.write_text("solid m\nfacet normal 0 0 x\nouter loop\nvertex 0 0 0\nendloop\nendfacet\nendsolid m\n")
    with pytest.raises(InvalidInput, match=r"m\.stl"):
        meshes.load(path)
    assert capfd.readouterr().err == ""
    assert not logging.getLogger("trimesh").isEnabledFor(logging.ERROR)
