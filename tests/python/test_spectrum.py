"""Spectra of error pictures: Parseval, white noise, waves, and the shape of what comes back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aliascope import api
from aliascope.errors import CheckFailed, InvalidInput
from aliascope.spectrum import RadialSpectrum, radial_spectrum


def wave(height: int, width: int, fx: float, fy: float, phase: float = 0.4) -> np.ndarray:
    """Of mean square 1/2."""
    y, x = np.mgrid[:height, :width]
    return np.cos(2 * np.pi * (fx * x + fy * y) + phase)


def variance(spectrum: RadialSpectrum) -> float:
    return float((spectrum.bins * spectrum.power).sum() / spectrum.bins.sum())


@pytest.mark.parametrize("shape", [(48, 64), (64, 48), (33, 7), (1, 9), (9, 1), (2, 2), (1, 1), (31, 20, 3)])
def test_parseval(shape: tuple[int, ...]) -> None:
    """The whole power is the variance under the squared window, summed here without a transform."""
    error = np.random.default_rng(1).normal(3.0, 2.0, shape)
    height, width = shape[:2]
    window = np.array(
        [
            [
                math.sin(math.pi * (x + 0.5) / width) ** 2 * math.sin(math.pi * (y + 0.5) / height) ** 2
                for x in range(width)
            ]
            for y in range(height)
        ]
    )
    channels = error.reshape(height, width, -1)
    expected = 0.0
    for channel in range(channels.shape[2]):
        values = channels[:, :, channel]
        mean = (window * values).sum() / window.sum()
        expected += (window**2 * (values - mean) ** 2).sum() / (window**2).sum() / channels.shape[2]
    spectrum = radial_spectrum(error)
    assert variance(spectrum) == pytest.approx(expected, rel=1e-12, abs=1e-25)
    assert spectrum.bins.sum() == height * width


def test_white_noise_is_flat_at_its_variance() -> None:
    rng = np.random.default_rng(2)
    found = np.array([radial_spectrum(rng.normal(0.7, 0.5, (48, 64))).power for _ in range(400)])
    bins = radial_spectrum(np.zeros((48, 64))).bins
    mean, spread = found.mean(axis=0), found.std(axis=0, ddof=1)
    # The first two rings lose the mean's part; five standard errors, of some thirty rings.
    assert np.all(np.abs(mean[2:] - 0.25) < 5 * spread[2:] / math.sqrt(400))
    assert mean[0] < 1e-20
    # The standard error that the docstring promises; the last ring is the one frequency (1/2, 1/2), which has no pair.
    assert spread[2:-1] * np.sqrt(bins[2:-1]) / 0.25 == pytest.approx(2.0, rel=0.25)


def test_white_noise_of_any_variance_over_the_picture_is_flat_too() -> None:
    rng = np.random.default_rng(3)
    growing = np.linspace(0, 2, 64)
    powers = np.array([radial_spectrum(rng.normal(size=(48, 64)) * growing).power for _ in range(400)])
    mean, spread = powers.mean(axis=0), powers.std(axis=0, ddof=1)
    level = mean[2:].mean()
    assert np.all(np.abs(mean[2:] - level) < 5 * spread[2:] / math.sqrt(400))


@pytest.mark.parametrize(("fx", "fy"), [(0.25, 0.0), (0.0, 0.25), (0.21, -0.17), (0.4, 0.45)])
def test_a_wave_has_its_power_at_its_frequency(fx: float, fy: float) -> None:
    spectrum = radial_spectrum(3.0 * wave(96, 128, fx, fy))
    assert variance(spectrum) == pytest.approx(4.5, rel=1e-3)  # 3^2 / 2
    far = np.abs(spectrum.frequencies - math.hypot(fx, fy)) > 3 / 96
    share = (spectrum.bins * spectrum.power)[far].sum() / (spectrum.bins * spectrum.power).sum()
    assert share < 1e-3  # without the window 0.02 to 0.1 leaks there
    peak = spectrum.frequencies[spectrum.power.argmax()]
    assert peak == pytest.approx(math.hypot(fx, fy), abs=1 / 96)


def test_frequencies_are_those_of_the_rings() -> None:
    spectrum = radial_spectrum(np.zeros((96, 128)))
    assert spectrum.frequencies[0] == 0.0
    assert spectrum.frequencies[-1] == pytest.approx(math.sqrt(0.5), abs=1 / 96)
    assert np.all(np.diff(spectrum.frequencies) > 0)
    assert np.all(np.abs(spectrum.frequencies - np.arange(len(spectrum.bins)) / 96) <= 0.5 / 96)
    # The first 41 rings fill the disc of radius 40.5 / 96, with 96 * 128 frequencies in the unit square.
    assert spectrum.bins[:41].sum() == pytest.approx(math.pi * (40.5 / 96) ** 2 * 96 * 128, rel=0.01)


def test_a_constant_has_no_power_and_a_transposed_picture_the_same() -> None:
    assert np.all(radial_spectrum(np.full((20, 31, 3), -7.25)).power < 1e-20)
    noise = np.random.default_rng(4).normal(size=(20, 31))
    here, there = radial_spectrum(noise), radial_spectrum(noise.T)
    assert np.allclose(here.power, there.power, rtol=1e-12)
    assert np.allclose(radial_spectrum(noise[::-1, ::-1]).power, here.power, rtol=1e-12)


def test_channels_are_averaged_in_power() -> None:
    noise = np.random.default_rng(5).normal(size=(20, 31))
    one = radial_spectrum(noise).power
    opposite = np.stack([noise, -noise, 2 * noise], axis=2)
    assert np.allclose(radial_spectrum(opposite).power, 2 * one, rtol=1e-12)
    assert radial_spectrum(opposite.astype(np.float32)).power.dtype == np.float64


def test_random_samples_leave_the_same_power_at_all_frequencies() -> None:
    """Each pixel has points of its own, so its error is independent of the others."""
    exact = api.reference("zone-plate").pixels.astype(np.float64)
    error = api.render("zone-plate", "embree", "uniform:n=16,sampler=random").pixels - exact
    spectrum = radial_spectrum(error)
    low, high = (spectrum.frequencies > 0.05) & (spectrum.frequencies < 0.25), spectrum.frequencies > 0.4
    levels = [np.average(spectrum.power[band], weights=spectrum.bins[band]) for band in (low, high)]
    assert levels[0] == pytest.approx(levels[1], rel=0.15)  # 2 / sqrt(2000 bins) = 4.5%, three times


def test_what_has_no_spectrum_is_said() -> None:
    for shape in ((5,), (0, 4), (2, 2, 2, 2)):
        with pytest.raises(InvalidInput, match="height, width"):
            radial_spectrum(np.zeros(shape))
    broken = np.zeros((4, 4))
    broken[1, 2] = np.nan
    with pytest.raises(CheckFailed, match="no numbers"):
        radial_spectrum(broken)
