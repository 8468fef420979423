"""References on disk: what is missing, outdated or changed is found."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from reference_scenes import REPOSITORY, SIZE, box, scene, stored

from aliascope import draws
from aliascope.errors import CheckFailed
from aliascope.image import read_header, read_image, write_exr
from aliascope.model import Scene
from aliascope.records import Pixels
from aliascope.references import Reference, files, make

SCENE = scene(box(1.3, 1.2, 9.7, 7.9))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    files.save(tmp_path, "square", SCENE, SIZE, "box", make(SCENE, SIZE))
    return tmp_path


def rewrite(path: Path, change: Callable[[Pixels], None], **header: str) -> None:
    """The file again with other pixels, its header kept but for what is said."""
    pixels = read_image(path).copy()
    change(pixels)
    write_exr(path, pixels, read_header(path) | header, finite=False)


def nudge(by: float) -> Callable[[Pixels], None]:
    def change(pixels: Pixels) -> None:
        pixels[4, 7, 1] += by

    return change


@pytest.mark.parametrize(
    "name", ["edge", "zone-plate", "discs", "siemens-star", "comb", "checker-horizon", "depth-of-field", "highlights"]
)
def test_committed_references_hold(name: str) -> None:
    """In their place; and of the moved pictures, those that take no second to make."""
    of, folder = stored(name), REPOSITORY / "reference"
    for draw in range(1 if name in ("checker-horizon", "depth-of-field") else draws.MOST):
        shift = draws.shift_of(draw)
        result = files.verify(folder, name, of, of.view.size, "box", shift=shift)
        assert result.holds, result.reason
        assert result.difference <= result.tolerance
        loaded = files.load(folder, name, of, of.view.size, "box", shift)
        brightest = max(1.0, float(loaded.pixels.max()))
        # float32 rounds values by this much, and both bounds
        assert result.max_difference <= 2.0**-24 * brightest + 2e-9
        assert loaded.error < 1e-7 * brightest


def test_what_was_saved_is_loaded(folder: Path) -> None:
    made, loaded = make(SCENE, SIZE), files.load(folder, "square", SCENE, SIZE, "box")
    assert np.array_equal(made.pixels, loaded.pixels)
    assert np.array_equal(loaded.exact, loaded.pixels)
    assert np.abs(loaded.exact - made.exact).max() + made.error <= loaded.error
    assert loaded.method == made.method
    assert loaded.standard_error is None


def test_the_header_says_where_it_came_from(folder: Path) -> None:
    header = read_header(folder / "square" / "12x9-box.exr")
    assert header["command"] == "aliascope reference square"
    assert header["scene_hash"] == SCENE.digest()
    assert (header["size"], header["filter"], header["method"]) == ("12x9", "box", "polygons")
    assert header["numpy"] == np.__version__
    assert float(header["error"]) == make(SCENE, SIZE).error
    assert {"scipy", "shapely"} <= set(header)


def test_the_same_reference_is_the_same_file(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    other = tmp_path_factory.mktemp("other")
    again = files.save(other, "square", SCENE, SIZE, "box", make(SCENE, SIZE))
    path = folder / "square" / "12x9-box.exr"
    assert again.read_bytes() == path.read_bytes()


def test_a_missing_reference_says_how_to_make_it(folder: Path) -> None:
    for use in (files.load, files.verify):
        with pytest.raises(CheckFailed, match=r"no reference for square at 24x18 .* aliascope reference square --size"):
            use(folder, "square", SCENE, (24, 18), "box")
        with pytest.raises(CheckFailed, match="make it with: aliascope reference square --filter mitchell"):
            use(folder, "square", SCENE, SIZE, "mitchell")
        with pytest.raises(CheckFailed, match=r"no reference for other .*aliascope reference other$"):
            use(folder, "other", SCENE, SIZE, "box")


def test_a_reference_of_another_version_of_the_scene_is_refused(folder: Path) -> None:
    moved = scene(box(1.3, 1.2, 9.7000001, 7.9))
    for use in (files.load, files.verify):
        with pytest.raises(CheckFailed, match="was made for another version of the scene"):
            use(folder, "square", moved, SIZE, "box")


def test_title_and_purpose_do_not_change_the_scene_but_everything_else_does() -> None:
    same = SCENE.model_copy(update={"title": "x", "shows": "y"})
    assert same.digest() == SCENE.digest()
    others: list[Scene] = [
        scene(box(1.3, 1.2, 9.7, 7.9), view={"size": SIZE, "background": [0.07, 0.11, 0.050000001]}),
        scene(box(1.3, 1.2, 9.7, 7.9, material="blue")),
        scene(box(1.3, 1.2, 9.7, 7.9), box(1.3, 1.2, 9.7, 7.9)),
        scene(box(1.3, 1.2, 9.7, 7.9), materials={"red": {"emission": [0.9, 0.2, 0.1], "albedo": [0.1, 0, 0]}}),
    ]
    assert len({of.digest() for of in [SCENE, *others]}) == 5


def test_a_file_that_was_moved_to_another_size_is_refused(folder: Path) -> None:
    (folder / "square" / "12x9-box.exr").rename(folder / "square" / "9x12-box.exr")
    for use in (files.load, files.verify):
        with pytest.raises(CheckFailed, match="says 12x9"):
            use(folder, "square", SCENE, (9, 12), "box")


def test_a_file_that_was_moved_to_another_filter_is_refused(folder: Path) -> None:
    (folder / "square" / "12x9-box.exr").rename(folder / "square" / "12x9-mitchell.exr")
    for use in (files.load, files.verify):
        with pytest.raises(CheckFailed, match="says 12x9, filter box"):
            use(folder, "square", SCENE, SIZE, "mitchell")


def test_a_file_that_is_no_picture_is_refused(folder: Path) -> None:
    (folder / "square" / "12x9-box.exr").write_bytes(b"not a picture")
    with pytest.raises(CheckFailed, match="make the reference again"):
        files.load(folder, "square", SCENE, SIZE, "box")


@pytest.mark.parametrize("by", [1e-5, -1e-5, 1.0, np.nan, np.inf])
def test_one_changed_pixel_is_found(folder: Path, by: float) -> None:
    path = folder / "square" / "12x9-box.exr"
    rewrite(path, nudge(by))
    with pytest.raises(CheckFailed, match=r"changed since it was made|not finite"):
        files.load(folder, "square", SCENE, SIZE, "box")
    # The same by someone who also corrects the digest: the pixels themselves are compared.
    rewrite(path, nudge(0.0), pixels=files._digest(read_image(path)))
    result = files.verify(folder, "square", SCENE, SIZE, "box")
    assert not result.holds
    assert (result.x, result.y, result.channel) == (7, 4, 1)
    assert "pixel (7, 4) channel 1" in result.reason
    assert not result.difference <= result.tolerance
    assert result.difference == result.max_difference or np.isnan(by)
    if abs(by) == 1e-5:
        assert result.max_difference == pytest.approx(1e-5, abs=1e-7)  # float32 of a value near 0.2 is within 1.5e-8


def test_a_nan_is_found_even_with_its_digest_corrected(folder: Path) -> None:
    path = folder / "square" / "12x9-box.exr"
    rewrite(path, nudge(np.nan))
    rewrite(path, nudge(0.0), pixels=files._digest(read_image(path)))
    with pytest.raises(CheckFailed, match="not finite"):
        files.load(folder, "square", SCENE, SIZE, "box")


@pytest.mark.parametrize("error", ["", "nan", "inf", "-1", "a lot"])
def test_an_error_bound_that_says_nothing_is_refused(folder: Path, error: str) -> None:
    rewrite(folder / "square" / "12x9-box.exr", nudge(0.0), error=error)
    with pytest.raises(CheckFailed, match="does not state its error"):
        files.load(folder, "square", SCENE, SIZE, "box")
    assert files.verify(folder, "square", SCENE, SIZE, "box").reason == "the file does not state its error"


def test_a_change_below_the_error_is_found_by_the_digest(folder: Path) -> None:
    rewrite(folder / "square" / "12x9-box.exr", nudge(0.0), pixels="0" * 64)
    result = files.verify(folder, "square", SCENE, SIZE, "box")
    assert not result.holds
    assert "changed since it was made" in result.reason


def test_another_method_than_the_one_stated_is_found(folder: Path) -> None:
    rewrite(folder / "square" / "12x9-box.exr", nudge(0.0), method="guess")
    assert files.verify(folder, "square", SCENE, SIZE, "box").reason == 'the file was made by "guess", not "polygons"'


def converged() -> Reference:
    reference = make(SCENE, SIZE)
    return dataclasses.replace(reference, method="converged", standard_error=np.full_like(reference.exact, 1e-4))


def test_a_converged_reference_keeps_its_standard_error(tmp_path: Path) -> None:
    path = files.save(tmp_path, "square", SCENE, SIZE, "box", converged())
    loaded = files.load(tmp_path, "square", SCENE, SIZE, "box")
    assert loaded.standard_error is not None
    # Rounded up to 8 bits: 210 / 2^21.
    assert np.array_equal(loaded.standard_error, np.full((9, 12, 3), 210 / 2**21))
    beside = path.with_name("12x9-box.standard-error.exr")
    rewrite(beside, nudge(1e-6))
    with pytest.raises(CheckFailed, match="standard error was changed"):
        files.load(tmp_path, "square", SCENE, SIZE, "box")
    beside.unlink()
    with pytest.raises(CheckFailed, match="standard error of the reference is missing"):
        files.load(tmp_path, "square", SCENE, SIZE, "box")
