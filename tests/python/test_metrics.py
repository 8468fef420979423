"""The metrics, against OpenImageIO's compare, FLIP's own program, SSIM's definition, and numbers worked out by hand."""

from __future__ import annotations

import itertools
import math
import re
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.lib.stride_tricks import sliding_window_view

from aliascope import api, metrics
from aliascope.errors import InvalidInput

FLIP = Path(sys.executable).with_name("flip")


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


def test_bias_keeps_its_digits_where_errors_cancel() -> None:
    """Of errors up to 1e4 and values up to 1e8 whose mean is some 1e-7 of them; exact in fractions."""
    noise = np.random.default_rng(6)
    reference = (10.0 ** noise.uniform(-3, 8, (33, 47, 3))).astype(np.float32)
    half = noise.standard_normal((33, 23, 3)) * 1e4
    error = np.concatenate([half, -half, np.zeros((33, 1, 3))], axis=1) + 1e-3
    image = (reference + error).astype(np.float32)
    exact = sum(map(Fraction, image.ravel().tolist())) - sum(map(Fraction, reference.ravel().tolist()))
    assert values(image, reference)["bias"] == pytest.approx(float(exact / image.size), rel=1e-15)
    for order in itertools.permutations((1e30, -1e30, 1.0)):
        far = np.float32([[order]])
        assert values(far, np.zeros_like(far))["bias"] == 1.0 / 3.0


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
        with pytest.raises(InvalidInput, match=f"{words} values, the first at x=11, y=7, channel 2"):
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


# --- p99 --------------------------------------------------------------------------------------------------------------


def test_p99_by_hand() -> None:
    """Errors of 0 to 200: place 0.99 * 200 = 198. Of 0 to 10: place 9.9, nine tenths of the way to the last."""
    order = np.random.default_rng(3).permutation(201)
    signs = np.where(order % 2 == 0, 1, -1)
    assert p99_of(order * signs) == 198.0
    assert p99_of(np.arange(11.0)) == pytest.approx(9.9, rel=1e-15)
    assert p99_of(np.array([0.25])) == 0.25


def p99_of(errors: np.ndarray) -> float | None:
    image = errors.astype(np.float32).reshape(1, -1, 1)
    return metrics.measure(image, np.zeros_like(image), ["p99"])["p99"].value


def test_p99_counts_every_channel() -> None:
    image, reference = pictures()
    found = metrics.measure(image, reference, ["p99"])["p99"].value
    sizes = sorted(abs(float(a) - float(r)) for a, r in zip(image.ravel(), reference.ravel(), strict=True))
    place = 0.99 * (len(sizes) - 1)
    low = sizes[int(place)]
    assert found == pytest.approx(low + (place - int(place)) * (sizes[int(place) + 1] - low), rel=1e-12)
    assert found == pytest.approx(np.percentile(np.abs(image.astype(float) - reference), 99), rel=1e-12)
    assert found == pytest.approx(0.02 * 2.576, rel=0.03)  # normal errors: 9216 values, 1% of them beyond; 1.3% s.e.


# --- SSIM -------------------------------------------------------------------------------------------------------------


def ssim_by_definition(image: np.ndarray, reference: np.ndarray) -> float:
    """Wang et al. 2004, eq. 13 to 16, window by window, variances as means of squared deviations; in long double."""
    place = np.arange(-5, 6)
    weights = np.exp(-(place[:, None] ** 2 + place[None, :] ** 2) / (2 * 1.5**2)).astype(np.longdouble)
    weights /= weights.sum()
    of_channels = []
    for channel in range(image.shape[2]):
        x, y = (sliding_window_view(each[:, :, channel].astype(np.longdouble), (11, 11)) for each in (image, reference))
        mu_x, mu_y = ((weights * each).sum(axis=(2, 3)) for each in (x, y))
        dx, dy = x - mu_x[..., None, None], y - mu_y[..., None, None]
        var_x, var_y, cov = ((weights * each).sum(axis=(2, 3)) for each in (dx * dx, dy * dy, dx * dy))
        c1, c2 = 0.01**2, 0.03**2
        similar = (2 * mu_x * mu_y + c1) * (2 * cov + c2) / ((mu_x**2 + mu_y**2 + c1) * (var_x + var_y + c2))
        of_channels.append(similar.mean())
    return float(np.mean(of_channels))


def test_ssim_is_its_definition() -> None:
    image, reference = pictures()
    noisier = reference + 10 * (image - reference)
    for a in (image, noisier, 1 - reference, reference[::-1], image * 0.1):
        assert values(a, reference)["ssim"] == pytest.approx(ssim_by_definition(a, reference), abs=1e-12)
    least = values(image[:11, :11], reference[:11, :11])["ssim"]
    assert least == pytest.approx(ssim_by_definition(image[:11, :11], reference[:11, :11]), abs=1e-12)


def test_ssim_of_constants_by_hand() -> None:
    """No variance: (2 a r + C1) / (a^2 + r^2 + C1) is left."""
    reference = np.full((16, 16, 3), 0.5, np.float32)
    assert values(reference, reference)["ssim"] == 1.0
    expected = (2 * 0.5 * 0.25 + 1e-4) / (0.25 + 0.0625 + 1e-4)
    assert values(reference / 2, reference)["ssim"] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("bright", [1.0, 3.0, 30.0, 32000.0, 1e6, 1e30])
def test_ssim_keeps_its_digits(bright: float) -> None:
    image, reference = pictures()
    a, r = np.float32(bright) * image, np.float32(bright) * reference  # what is brighter is no whiter, but has contrast
    exact = ssim_by_definition(a, r)
    assert values(a, r)["ssim"] == pytest.approx(exact, abs=1e-10)
    a, r = image + np.float32(bright), reference + np.float32(bright)  # little contrast, and less the brighter
    if bright < 1e6:  # at which it has none left
        assert values(a, r)["ssim"] == pytest.approx(ssim_by_definition(a, r), abs=1e-10)


def test_small_pictures_have_no_ssim() -> None:
    image, reference = pictures()
    for narrow in (np.s_[:10, :], np.s_[:, :10]):
        measured = metrics.measure(image[narrow], reference[narrow])["ssim"]
        assert measured.value is None
        assert measured.details["ssim-reason"] == "its windows have 11 x 11 pixels, the picture is smaller"


# --- FLIP -------------------------------------------------------------------------------------------------------------


def write_png(path: Path, encoded: np.ndarray) -> None:
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), oiio.ImageSpec(encoded.shape[1], encoded.shape[0], 3, "uint8"))
    assert out.write_image(encoded)
    assert out.close()


def test_flip_is_that_of_its_own_program(tmp_path: Path) -> None:
    """The program reads 8-bit sRGB; the metric gets what these stand for, linear."""
    rng = np.random.default_rng(8)
    reference = rng.integers(0, 256, (40, 56, 3), dtype=np.uint8)
    image = np.clip(reference + rng.normal(4, 12, reference.shape), 0, 255).astype(np.uint8)
    write_png(tmp_path / "a.png", image)
    write_png(tmp_path / "r.png", reference)
    command = [FLIP, "-r", tmp_path / "r.png", "-t", tmp_path / "a.png", "-v", "2", "-nerm", "-d", tmp_path]
    said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    theirs = float(re.search(r"Mean:\s*([0-9.]+)", said)[1])
    coded = [oiio.ImageBuf((each / 255).astype(np.float32)) for each in (image, reference)]
    a, r = (
        oiio.ImageBufAlgo.colorconvert(each, "srgb_rec709_scene", "lin_rec709_scene").get_pixels() for each in coded
    )
    ours = values(a, r)["flip"]
    assert 0.05 < theirs < 0.5
    assert ours == pytest.approx(theirs, abs=2e-6)  # it prints six digits and adds in float


def test_flip_is_clipped_and_bounded() -> None:
    image, reference = pictures()
    assert values(reference, reference)["flip"] == 0.0
    white, black = np.ones((9, 7, 3), np.float32), np.zeros((9, 7, 3), np.float32)
    far = values(white, black)["flip"]
    assert 0.9 < far <= 1.0  # 0.9675, black to white; 1 is green to blue
    assert values(white * np.float32(3e38), black - np.float32(3e38))["flip"] == far
    assert values(image, reference)["flip"] == values(np.clip(image, 0, 1), reference)["flip"]


def test_flip_needs_three_channels() -> None:
    image, reference = pictures()
    measured = metrics.measure(image[:, :, :1], reference[:, :, :1])["flip"]
    assert measured.value is None
    assert measured.details["flip-reason"] == "it needs red, green and blue, and the pictures have 1 channels"


# --- structure --------------------------------------------------------------------------------------------------------


def structure_of(error: np.ndarray) -> tuple[float, float]:
    """The value, and the standard deviation that it says noise has."""
    error = (error if error.ndim == 3 else error[:, :, None]).astype(np.float32)
    measured = metrics.measure(error, np.zeros_like(error), ["structure"])["structure"]
    assert measured.value is not None
    return measured.value, measured.details["structure-noise"]


def waves(height: int = 96, width: int = 128) -> np.ndarray:
    y, x = np.mgrid[:height, :width]
    return np.sqrt(2) * np.cos(2 * np.pi * (0.23 * x + 0.11 * y))


def structure_by_definition(error: np.ndarray) -> float:
    """The module's formula, pixel by pixel."""
    height, width = error.shape[:2]
    top = bottom = 0.0
    for dy, dx in [(0, 1), (0, 2), *((dy, dx) for dy in (1, 2) for dx in range(-2, 3))]:
        sums: dict[tuple[int, int], float] = {}
        x_first = max(0, -dx)  # blocks are counted from the first pair of the lag
        for y in range(height - dy):
            for x in range(x_first, width - max(0, dx)):
                product = float(error[y, x] @ error[y + dy, x + dx])
                block = y // 8, (x - x_first) // 8
                sums[block] = sums.get(block, 0.0) + product
                bottom += product**2
        top += sum(value**2 for value in sums.values())
    return (top / bottom - 1) / 63


@pytest.mark.parametrize("shape", [(17, 21, 3), (8, 8, 1), (1, 9, 1), (9, 1, 3), (3, 2, 3)])
def test_structure_is_its_definition(shape: tuple[int, int, int]) -> None:
    error = np.random.default_rng(2).normal(0.3, 1, shape).astype(np.float32)
    expected = structure_by_definition(error.astype(np.float64))
    assert structure_of(error)[0] == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_structure_of_white_noise_is_0_however_it_is_spread() -> None:
    rng = np.random.default_rng(4)
    size = (96, 128)
    y, x = np.mgrid[: size[0], : size[1]]
    noises = {
        "normal": lambda: rng.normal(size=size),
        "in three channels": lambda: rng.normal(size=(*size, 3)),
        "skew": lambda: np.where(rng.random(size) < 0.1, 9.0, -1.0),
        "sparse": lambda: rng.normal(size=size) * (rng.random(size) < 0.05),
        "growing": lambda: rng.normal(size=size) * x,
        "on a line": lambda: rng.normal(size=size) * (np.abs(x - 0.7 * y - 20) < 2),
    }
    for name, noise in noises.items():
        found = np.array([structure_of(noise()) for _ in range(40)])
        mean, spread, told = found[:, 0].mean(), found[:, 0].std(ddof=1), found[:, 1].mean()
        assert abs(mean) < 4 * spread / math.sqrt(40), name
        # 40 values know their spread to 11%, more where it has tails; four times that.
        assert 0.6 < spread / told < 1.6, (name, spread, told)
        if name == "normal":
            assert told == pytest.approx(0.0005, rel=0.1)


def test_structure_of_waves_edges_and_their_share() -> None:
    value, noise = structure_of(waves())
    assert value == pytest.approx(0.5, abs=0.05)
    assert structure_of(waves()[:, :, None] * [1, -2, 0.5])[0] == pytest.approx(value, rel=1e-5)
    # 63 and, in the blocks at the border that lack pairs, less.
    assert 0.95 < structure_of(np.full((96, 128), -0.1))[0] <= 1.0
    y, x = np.mgrid[:96, :128]
    assert 0.95 < structure_of((-1.0) ** (x + y))[0] <= 1.0
    chirp = np.cos(2 * np.pi * (0.002 * x**2 + 0.003 * y**2))
    assert structure_of(chirp)[0] > 0.3
    rng = np.random.default_rng(5)
    for share in (0.1, 0.5, 0.9):
        mixed = math.sqrt(share) * waves() + math.sqrt(1 - share) * rng.normal(size=(96, 128))
        assert structure_of(mixed)[0] == pytest.approx(share**2 * value, rel=0.15, abs=4 * noise)


def test_moire_is_told_from_noise_of_the_same_size() -> None:
    """The zone plate by 2 x 2 points, the same in each pixel, and by so many random ones that RMSE is the same."""
    exact = api.reference("zone-plate").pixels
    found = {}
    for mode in ("n=4,sampler=regular", "n=144,sampler=random", "n=16,sampler=sobol,sampler.scramble=owen"):
        pixels = api.render("zone-plate", "embree", f"uniform:{mode}").pixels
        found[mode] = metrics.measure(pixels, exact, ["rmse", "structure"])
    regular, random, owen = found.values()
    assert random["rmse"].value == pytest.approx(regular["rmse"].value, rel=0.05)
    assert regular["structure"].value > 0.4
    for noise in (random, owen):
        assert abs(noise["structure"].value) < 4 * noise["structure"].details["structure-noise"]
        assert noise["structure"].details["structure-noise"] < 0.002


def test_structure_has_no_value_without_pairs() -> None:
    zero = np.zeros((9, 9, 3), np.float32)
    assert metrics.measure(zero, zero)["structure"].details["structure-reason"] == "the pictures are equal"
    alone = zero.copy()
    alone[4, 4, 1] = 0.5
    for image in (alone, alone[4:5, 4:5]):
        measured = metrics.measure(image, np.zeros_like(image))["structure"]
        assert measured.value is None
        assert "no two pixels within 2" in measured.details["structure-reason"]


# --- all of them ------------------------------------------------------------------------------------------------------

finite = st.floats(width=32, allow_nan=False, allow_infinity=False)
shapes = st.tuples(st.integers(1, 13), st.integers(1, 13), st.integers(1, 4))


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_finite_pictures_have_finite_figures_or_a_reason(data: st.DataObject) -> None:
    shape = data.draw(shapes)
    picture = arrays(np.float32, shape, elements=finite, fill=finite)
    image, reference = data.draw(picture), data.draw(picture)
    for name, measured in metrics.measure(image, reference).items():
        if measured.value is None:
            assert measured.details[f"{name}-reason"]
        else:
            assert math.isfinite(measured.value), name
        assert all(math.isfinite(value) for value in measured.details.values() if isinstance(value, float))


def test_the_same_figures_each_time_and_nothing_is_changed() -> None:
    image, reference = pictures()
    assert values(image, reference) == values(image, reference)
    a, r = image.astype(np.float64), reference.astype(np.float64)
    a.flags.writeable = r.flags.writeable = False
    for metric in metrics.METRICS.values():
        metric(a, r)


def test_each_metric_says_what_it_is_in_one_line() -> None:
    for name, metric in metrics.METRICS.items():
        first, _, rest = metric.__doc__.partition("\n")
        assert first.strip().endswith("."), name
        assert not rest or rest.startswith("\n"), name
