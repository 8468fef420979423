"""The metrics, against OpenImageIO's compare and against numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import OpenImageIO as oiio
import pytest

from aliascope import metrics
from aliascope.errors import CheckFailed, InvalidInput


def pictures() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(5)
    reference = rng.random((48, 64, 3), dtype=np.float32)
    return reference + rng.normal(0.0, 0.02, reference.shape).astype(np.float32), reference


def values(image: np.ndarray, reference: np.ndarray) -> dict[str, float | None]:
    return {name: measured.value for name, measured in metrics.measure(image, reference).items()}


def test_openimageio_finds_the_same() -> None:
    image, reference = pictures()
    theirs = oiio.ImageBufAlgo.compare(oiio.ImageBuf(image), oiio.ImageBuf(reference), 0.1, 0.05)
    ours = metrics.measure(image, reference)
    # It takes differences in float: half an ulp of values near 1, 6e-8, relative to errors near 0.02.
    assert ours["mae"].value == pytest.approx(theirs.meanerror, rel=1e-5)
    assert ours["rmse"].value == pytest.approx(theirs.rms_error, rel=1e-5)
    assert ours["max"].value == pytest.approx(theirs.maxerror, rel=1e-5)
    assert ours["max"].details["max-at"] == [theirs.maxx, theirs.maxy, theirs.maxc]
    # Its PSNR takes the largest value of the pictures as the peak, ours takes 1.
    peak = 20 * math.log10(float(max(image.max(), reference.max())))
    assert ours["psnr"].value == pytest.approx(theirs.PSNR - peak, abs=1e-4)


def test_by_hand() -> None:
    reference = np.zeros((1, 2, 1), np.float32)
    image = np.array([[[0.3], [-0.1]]], np.float32)
    found = values(image, reference)
    assert found["bias"] == pytest.approx(0.1, rel=1e-6)
    assert found["mae"] == pytest.approx(0.2, rel=1e-6)
    assert found["rmse"] == pytest.approx(math.sqrt(0.05), rel=1e-6)
    assert found["psnr"] == pytest.approx(10 * math.log10(20), rel=1e-6)
    assert found["relative-mse"] == pytest.approx(0.05 / 0.01, rel=1e-6)
    assert found["max"] == pytest.approx(0.3, rel=1e-6)


def test_bias_has_its_sign() -> None:
    image, reference = pictures()
    assert values(reference + 0.25, reference)["bias"] == pytest.approx(0.25, rel=1e-6)
    assert values(reference - 0.25, reference)["bias"] == pytest.approx(-0.25, rel=1e-6)
    assert values(image, reference)["bias"] == pytest.approx(-float(values(reference, image)["bias"] or 0))


def test_equal_pictures_have_no_psnr() -> None:
    _, reference = pictures()
    measured = metrics.measure(reference, reference)
    assert measured["psnr"].value is None
    assert measured["psnr"].details["psnr-reason"] == "the pictures are equal"
    assert measured["rmse"].value == 0.0


def test_large_values_do_not_overflow() -> None:
    reference = np.full((2, 2, 3), 1e30, np.float32)
    assert values(reference * np.float32(2), reference)["rmse"] == pytest.approx(1e30, rel=1e-6)


@pytest.mark.parametrize(("value", "words"), [(np.nan, "1 NaN and 0 infinite"), (-np.inf, "0 NaN and 1 infinite")])
def test_what_is_no_number_is_never_a_number(value: float, words: str) -> None:
    image, reference = pictures()
    image[7, 11, 2] = value
    for pair in ((image, reference), (reference, image)):
        with pytest.raises(CheckFailed, match=f"{words} values, the first at x=11, y=7, channel 2"):
            metrics.measure(*pair)


def test_other_sizes_and_channels_are_refused() -> None:
    image, reference = pictures()
    with pytest.raises(InvalidInput, match="63 x 48 pixels of 3 channels, the reference 64 x 48 pixels of 3 channels"):
        metrics.measure(image[:, 1:], reference)
    with pytest.raises(InvalidInput, match="of 1 channels"):
        metrics.measure(image[:, :, :1], reference)


def test_unknown_metrics_have_near_misses() -> None:
    with pytest.raises(InvalidInput, match='unknown metric "rsme"; did you mean "rmse"'):
        metrics.chosen("rsme")
    assert metrics.chosen("max, bias") == ["max", "bias"]
