"""The pictures of a page: to the bit, and small."""

from __future__ import annotations

import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from picture_data import HEIGHT, STEP, WIDTH, lit, odd, stepped

from aliascope.records import Pixels
from aliascope.report.encode import ALPHABET, from_text, to_text
from aliascope.report.packing import NOTHING, Known, pack, unpack
from aliascope.report.relations import NONE, Relations, find_relations, line_errors, plane_errors


@pytest.fixture(scope="module")
def known() -> Known:
    pictures = [lit(seed) for seed in range(4)]
    return Known(lit(0, noise=0.0), find_relations(pictures))


def equal_bits(a: Pixels, b: Pixels) -> bool:
    return a.shape == b.shape and np.array_equal(a.view(np.uint32), b.view(np.uint32))


PICTURES = {
    "lit": (lit(9), 0.0),
    "stepped": (stepped(9), STEP),
    "of a step that it has not": (lit(9), STEP),
    "the reference": (lit(0, noise=0.0), 0.0),
    "odd": (odd(), 0.0),
    "any bits": (np.random.default_rng(3).integers(0, 1 << 32, (HEIGHT, WIDTH, 3), np.uint32).view(np.float32), 0.0),
    "flat": (np.full((HEIGHT, WIDTH, 3), 0.5, np.float32), 0.0),
}


@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.parametrize("alone", [False, True])
def test_to_the_bit(known: Known, name: str, alone: bool) -> None:
    pixels, step = PICTURES[name]
    told = NOTHING if alone else known
    assert equal_bits(unpack(pack(pixels, told, step), WIDTH, HEIGHT, told), pixels)


@settings(max_examples=60, deadline=None)
@given(arrays(np.uint32, (18, 20, 3)), arrays(np.uint32, (18, 20, 3)), st.sampled_from([0.0, STEP, 0.25]))
def test_any_bits_against_any_reference(bits: np.ndarray, others: np.ndarray, step: float) -> None:
    told = Known(others.view(np.float32), Relations(np.array([[0.1, 0.5, 0.0, 2.0]]), np.array([[0.0, 1.0, -1.0]])))
    assert equal_bits(unpack(pack(bits.view(np.float32), told, step), 20, 18, told), bits.view(np.float32))


def test_the_relations_of_a_scene_are_found(known: Known) -> None:
    """One lamp on the first material: a line. Two on the others: a line where only one shines, else a plane."""
    colours = np.unique(lit(9).reshape(-1, 3), axis=0).astype(np.float64)
    on_line = (line_errors(known.relations.lines, colours) <= 60).any(axis=0)
    on_plane = (plane_errors(known.relations.planes, colours) <= 60).any(axis=0)
    assert 0.3 < on_line.mean() < 0.9
    assert (on_line | on_plane).mean() > 0.98  # the background is a colour of its own


def test_a_line_is_what_made_the_colours() -> None:
    rng = np.random.default_rng(1)
    red = rng.random((30, 30)).astype(np.float32).astype(np.float64)
    pixels = np.stack([red, 0.0137 + 0.9554 * red, 0.9 - 0.5 * red], axis=2).astype(np.float32)
    found = find_relations([pixels])
    assert len(found.lines) == 1
    assert found.lines[0] == pytest.approx([0.0137, 0.9554, 0.9, -0.5], abs=1e-7)  # a float32 has 6e-8


def test_noise_has_no_relations() -> None:
    found = find_relations([np.random.default_rng(2).random((60, 60, 3), np.float32)])
    assert (len(found.lines), len(found.planes)) == (0, 0)
    assert find_relations([]) is NONE
    assert find_relations([np.full((4, 4, 3), np.nan, np.float32)]) is NONE


def test_what_is_known_makes_pictures_small(known: Known) -> None:
    """Noise in the lights is told once where one lamp shines, twice where two do, never for each of the channels."""
    lit_pixels = int((lit(9) != lit(9)[0, 0]).any(axis=2).sum())
    assert len(pack(lit(9), known)) < 6.0 * lit_pixels
    assert len(pack(lit(9), known)) < 0.6 * len(pack(lit(9)))
    # Numbers of steps have 16 bits, where floats have 24.
    assert len(pack(stepped(9), known, STEP)) < 0.45 * len(pack(stepped(9), known))
    assert len(pack(lit(0, noise=0.0), known)) < 250  # the reference again


def test_what_is_not_a_picture_is_refused(known: Known) -> None:
    data = pack(lit(9), known)
    body = zlib.decompress(data)
    for bad in (zlib.compress(body[:-1]), zlib.compress(body + b"\0"), data[:-9], b"", zlib.compress(b"")):
        with pytest.raises(ValueError, match=f"not a picture of {WIDTH} x {HEIGHT}"):
            unpack(bad, WIDTH, HEIGHT, known)
    told = pack(lit(1, noise=1e-5), known)
    with pytest.raises(ValueError, match="not a picture"):
        unpack(told, WIDTH, HEIGHT)


@given(st.binary(max_size=200))
def test_bytes_as_characters(data: bytes) -> None:
    text = to_text(data)
    assert set(text.encode()) <= set(ALPHABET)
    assert len(text) <= 2 * -(-8 * len(data) // 13)
    assert from_text(text) == data


@pytest.mark.parametrize("bad", ["<", "ab&", "é!", "~~", "~"])
def test_other_characters_are_refused(bad: str) -> None:
    with pytest.raises(ValueError, match="not the text"):
        from_text(bad)
