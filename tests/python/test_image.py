"""Pictures on disk."""

from __future__ import annotations

import contextlib
import os
import struct
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from aliascope import image
from aliascope.errors import InvalidInput, NotFinite, NotWritable
from aliascope.image import read_header, read_image, write_exr
from aliascope.studies import error_maps


def test_every_float_and_the_header_come_back(tmp_path: Path) -> None:
    pixels = np.random.default_rng(3).normal(0, 1e10, (5, 7, 3)).astype(np.float32)
    pixels[0, 0] = [np.nan, np.inf, 1e-42]
    header = {"scene": "edge", "mode": "uniform:n=4", "words": 'a "b" é'}
    write_exr(tmp_path / "new" / "a.exr", pixels, header, finite=False)
    assert np.array_equal(read_image(tmp_path / "new" / "a.exr"), pixels, equal_nan=True)
    assert read_header(tmp_path / "new" / "a.exr") == header


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_picture_that_is_no_number_is_not_written(tmp_path: Path, value: float) -> None:
    pixels = np.full((5, 7, 3), 3e38, np.float32)
    pixels[4, 6, 2] = pixels[3, 5, 1] = value
    with pytest.raises(NotFinite, match=r"a\.exr: not written: 2 values .* first at x=5, y=3, channel 1"):
        write_exr(tmp_path / "a.exr", pixels, {})
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_is_said_and_nothing_is_left(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(NotWritable):
        write_exr(tmp_path / "file" / "a.exr", np.zeros((1, 1, 3), np.float32), {})
    (tmp_path / "taken.exr").mkdir()
    with pytest.raises(NotWritable):
        write_exr(tmp_path / "taken.exr", np.zeros((1, 1, 3), np.float32), {})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "taken.exr"]


def test_what_is_no_picture_is_said(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no such file"):
        read_image(tmp_path / "absent.exr")
    (tmp_path / "text.exr").write_text("not a picture")
    with pytest.raises(InvalidInput, match="not a picture"):
        read_image(tmp_path / "text.exr")
    whole = tmp_path / "whole.exr"
    write_exr(whole, np.ones((64, 64, 3), np.float32) * np.random.default_rng(1).random((64, 64, 1), np.float32), {})
    (tmp_path / "cut.exr").write_bytes(whole.read_bytes()[:900])
    with pytest.raises(InvalidInput, match=r"cut\.exr: "):
        read_image(tmp_path / "cut.exr")


def test_a_jpeg_that_ends_too_soon_is_no_picture(tmp_path: Path) -> None:
    """It has pixels all the same, the rest of them grey."""
    whole, cut = tmp_path / "whole.jpg", tmp_path / "cut.jpg"
    made = oiio.ImageBuf(np.random.default_rng(1).random((64, 64, 3), np.float32))
    assert made.write(str(whole))
    assert read_image(whole).shape == (64, 64, 3)
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    with pytest.raises(InvalidInput, match=r"cut\.jpg: the picture is broken: "):
        read_image(cut)


def test_how_many_channels_and_values_a_picture_may_have(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for channels in (256, 257):
        write_exr(tmp_path / f"{channels}.exr", np.ones((2, 2, channels), np.float32), {})
    assert read_image(tmp_path / "256.exr").shape == (2, 2, 256)
    with pytest.raises(InvalidInput, match="says that it has 257 channels"):
        read_header(tmp_path / "257.exr")
    monkeypatch.setattr(image, "LARGEST_PICTURE", 1024)
    monkeypatch.setattr(image, "LARGEST_ROW", 512)
    read_image(tmp_path / "256.exr")
    monkeypatch.setattr(image, "LARGEST_PICTURE", 1023)
    with pytest.raises(InvalidInput, match="says that it has 1024 values, and at most 1023 are read"):
        read_image(tmp_path / "256.exr")
    monkeypatch.setattr(image, "LARGEST_ROW", 511)
    with pytest.raises(InvalidInput, match="at most 256 channels, 511 values in a row"):
        read_header(tmp_path / "256.exr")


def test_what_a_row_and_a_picture_hold_at_most() -> None:
    """In bytes, as float32: of a row some are held at once (`read_rows`), of a picture it and its copy."""
    assert 4 * image.LARGEST_ROW <= 1 << 27
    assert 4 * image.LARGEST_PICTURE <= 1 << 30


def test_a_picture_of_layers_is_refused(tmp_path: Path) -> None:
    """A DDS file of 2 x 2 x 2 values."""
    head = struct.pack("<7I", 124, 0x801007, 2, 2, 8, 2, 0) + bytes(44)
    head += struct.pack("<8I", 32, 0x41, 0, 32, 0xFF0000, 0xFF00, 0xFF, 0xFF000000)
    (tmp_path / "a.dds").write_bytes(b"DDS " + head + struct.pack("<5I", 0x1008, 0x200000, 0, 0, 0) + bytes(32))
    with pytest.raises(InvalidInput, match="2 layers: at most"):
        read_image(tmp_path / "a.dds")


def test_a_picture_that_fails_without_a_word_is_broken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Silent:
        def spec(self) -> oiio.ImageSpec:
            return oiio.ImageSpec(2, 2, 3, "float")

        def read_image(self, _: object) -> None:
            return None

        def geterror(self) -> str:
            return ""

    monkeypatch.setattr(image, "opened", lambda path: contextlib.nullcontext(Silent()))
    with pytest.raises(InvalidInput, match="the picture is broken: no reason given"):
        read_image(tmp_path / "a.exr")


def test_a_picture_that_may_not_be_read_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    write_exr(tmp_path / "a.exr", np.ones((2, 2, 3), np.float32), {})
    monkeypatch.setattr(Path, "open", forbidden)  # root may read all
    with pytest.raises(InvalidInput, match=r"a\.exr: cannot be read: Permission denied"):
        read_image(tmp_path / "a.exr")


def test_rows_that_are_cut_off_are_broken(tmp_path: Path) -> None:
    whole = tmp_path / "whole.exr"
    write_exr(whole, np.random.default_rng(1).random((64, 64, 3), np.float32), {})
    data = whole.read_bytes()
    (tmp_path / "cut.exr").write_bytes(data[: len(data) // 2] + bytes(len(data) // 4))
    with (
        image.opened(tmp_path / "cut.exr") as found,
        pytest.raises(InvalidInput, match=r"cut\.exr: the picture is broken: "),
    ):
        image.read_rows(found, tmp_path / "cut.exr", 0, 64)


def test_names_that_are_no_text_are_escaped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, path = tmp_path / "whole.exr", tmp_path / "named.exr"
    write_exr(whole, np.ones((2, 2, 3), np.float32), {"one": "two"})
    contents = whole.read_bytes()
    for place, instead in ((b"two", b"t\xe6o"), (b":one", b":o\xe6e"), (b"R\0", b"\xe6\0")):
        assert contents.count(place) == 1
        contents = contents.replace(place, instead)
    path.write_bytes(contents)
    assert read_header(path) == {"o\\xe6e": "t\\xe6o"}
    assert "\\xe6" in error_maps.describe(path).channels
    assert read_image(path).shape == (2, 2, 3)

    def quoting() -> str:
        return b"broken at \xe6".decode()

    (tmp_path / "no.exr").write_text("no picture")
    monkeypatch.setattr("aliascope.image.oiio.geterror", quoting)  # as OpenImageIO does, found by fuzz_picture
    with pytest.raises(InvalidInput, match=r"no\.exr: a name in it is no text: broken at \\xe6"):
        read_image(tmp_path / "no.exr")


def test_contents_reach_the_disk_before_the_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    monkeypatch.setattr("os.fsync", lambda number: done.append(f"sync {os.path.samestat(os.fstat(number), part())}"))
    replace = Path.replace
    monkeypatch.setattr(Path, "replace", lambda own, to: (done.append("replace"), replace(own, to))[1])

    def part() -> os.stat_result:
        (path,) = tmp_path.glob(".a.*.exr")
        return path.stat()

    write_exr(tmp_path / "a.exr", np.zeros((1, 1, 3), np.float32), {})
    assert done == ["sync True", "replace"]


@pytest.mark.parametrize(("magic", "channels"), [(b"PF", 3), (b"Pf", 1)])
@pytest.mark.parametrize(("scale", "order"), [(b"-1.0", "<f4"), (b"1.0", ">f4")])
def test_a_pfm_goes_from_the_bottom_to_the_top(
    tmp_path: Path, magic: bytes, channels: int, scale: bytes, order: str
) -> None:
    """Its definition: https://www.pauldebevec.com/Research/HDR/PFM/ (a negative scale: least byte first)."""
    pixels = np.random.default_rng(5).normal(0, 3, (4, 7, channels)).astype(np.float32)
    path = tmp_path / "a.pfm"
    path.write_bytes(magic + b"\n7 4\n" + scale + b"\n" + pixels[::-1].astype(order).tobytes())
    assert np.array_equal(read_image(path), pixels)


def test_integers_of_netpbm_go_from_the_top(tmp_path: Path) -> None:
    (tmp_path / "a.pgm").write_bytes(b"P5\n2 2\n255\n" + bytes([0, 51, 102, 255]))
    assert np.allclose(read_image(tmp_path / "a.pgm")[:, :, 0], [[0, 0.2], [0.4, 1]], atol=1e-6)


@pytest.mark.parametrize("ending", ["exr", "hdr", "jpg", "pfm", "png", "tif"])
@pytest.mark.parametrize("share", [0.66, 0.9])
def test_a_picture_that_was_cut_short_is_refused_without_noise(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], ending: str, share: float
) -> None:
    whole, cut = tmp_path / f"whole.{ending}", tmp_path / f"cut.{ending}"
    out = oiio.ImageOutput.create(str(whole))
    assert out.open(str(whole), oiio.ImageSpec(64, 48, 3, "uint8" if ending in ("jpg", "png", "tif") else "float"))
    assert out.write_image(np.random.default_rng(2).random((48, 64, 3), dtype=np.float32))
    assert out.close()
    assert read_image(whole).shape == (48, 64, 3)
    data = whole.read_bytes()
    cut.write_bytes(data[: int(len(data) * share)])
    with pytest.raises(InvalidInput, match=rf"cut\.{ending}: the picture is broken: \w"):
        read_image(cut)
    assert capfd.readouterr() == ("", "")


def test_a_png_with_a_broken_head_is_refused_without_noise(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
    with pytest.raises(InvalidInput, match="not a picture that can be read"):
        read_image(tmp_path / "a.png")
    assert capfd.readouterr() == ("", "")
    print("heard", file=sys.stderr)  # standard error is back
    assert capfd.readouterr().err == "heard\n"
