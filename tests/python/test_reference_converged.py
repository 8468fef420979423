"""Converged references: honest standard errors, the exact references as their limit, and what a check can see."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from reference_scenes import box, scene, stored

from aliascope import agreement
from aliascope.errors import CheckFailed, SpecError, Unsupported
from aliascope.image import read_header, read_image, write_exr
from aliascope.records import Pixels
from aliascope.references import Ambiguous, Plan, converged, files, make

SIZE = (32, 24)
PLAN = Plan(samples=144, replicates=16, threads=2)
CHECK = Plan(samples=144, replicates=16, sampler="jittered", first_seed=1 << 41, threads=2)


def estimate(name: str, filter_: str, plan: Plan) -> tuple[agreement.Estimate, np.ndarray]:
    return converged.estimate(converged.renderer(stored(name), SIZE, filter_, plan), plan)


@pytest.mark.parametrize("name", ["edge", "discs", "zone-plate", "siemens-star", "checker-horizon", "depth-of-field"])
def test_exact_references_are_the_limit(name: str) -> None:
    exact = make(stored(name), SIZE).exact
    found, pictures = estimate(name, "box", PLAN)
    # What n samples all miss, or all but a few meet, is smaller than 20 / n of the pixel: exp(-20) otherwise.
    chance = 20 / found.samples
    assert np.all(np.abs(exact - found.mean) <= 9 * found.standard_error + chance)  # 2e-7 of Student's, 15 degrees
    blocks, replicates = agreement.blocks(exact), agreement.blocks(pictures)
    error = replicates.std(axis=0, ddof=1) / 4
    assert np.all(np.abs(blocks - replicates.mean(axis=0)) <= 7 * error + chance / 64)
    whole = pictures.mean(axis=(1, 2))
    assert np.all(np.abs(exact.mean(axis=(0, 1)) - whole.mean(axis=0)) <= 5 * whole.std(axis=0, ddof=1) / 4)
    assert np.all(whole.std(axis=0, ddof=1) / 4 < 2e-4)


@pytest.mark.parametrize(("name", "filter_"), [("spheres", "box"), ("terrain", "box"), ("spheres", "mitchell")])
def test_standard_errors_are_honest(name: str, filter_: str) -> None:
    """Two estimates with different patterns and seeds differ by what both say."""
    (one, _), (other, pictures) = estimate(name, filter_, PLAN), estimate(name, filter_, CHECK)
    variance = one.standard_error**2 + other.standard_error**2
    noisy = variance > 1e-12
    z = (one.mean - other.mean)[noisy] / np.sqrt(variance[noisy])
    # Student's distribution with some 30 degrees of freedom has the variance 30/28; 700 independent pixels or more know
    # it to 6 %, and under mitchell neighbours are not independent.
    assert 0.8 < (z**2).mean() < 1.4
    assert abs(z.mean()) < 0.25
    factor = agreement.correlation(pictures)
    assert factor == pytest.approx(1.0, abs=0.3) if filter_ == "box" else factor > 1.3
    result = agreement.agreement(one, other, 1e-7, 1.0 if filter_ == "box" else factor)
    assert not result.reason
    assert 0.6 < result.mean_square < 1.2  # the check is granted at least the variance of the first


def test_the_check_is_wrong_as_seldom_as_it_says() -> None:
    """Normal pictures: 200 sound files at SIGNIFICANCE 1e-3 each; 4 or more failures have a chance of 6e-5."""
    rng = np.random.default_rng(5)
    wrong = 0
    for _ in range(200):
        spread = 10.0 ** rng.uniform(-6, -2, (1, 16, 20, 3))
        one, other = (normal_estimate(rng, spread, many) for many in (16, 24))
        wrong += bool(agreement.agreement(one, other, 0.0).reason)
    assert wrong < 4


def normal_estimate(rng: np.random.Generator, spread: np.ndarray, many: int) -> agreement.Estimate:
    pictures = 0.5 + spread * rng.standard_normal((many, *spread.shape[1:]))
    mean, error = pictures.mean(axis=0), pictures.std(axis=0, ddof=1) / np.sqrt(many)
    return agreement.Estimate(mean, error, many, many)


def one_value(by: float) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    def change(mean: np.ndarray, error: np.ndarray) -> np.ndarray:
        changed = mean.copy()
        changed[7, 11, 1] += by * error[7, 11, 1]
        return changed

    return change


def block(mean: np.ndarray, error: np.ndarray) -> np.ndarray:
    changed = mean.copy()
    changed[8:16, 16:24, 2] += 2.0 * error[8:16, 16:24, 2]
    return changed


TAMPERED = {
    "one value by 16 standard errors of its own": (one_value(16.0), "pixel (11, 7) channel 1"),
    "a NaN": (one_value(np.nan), "pixel (11, 7) channel 1"),
    "a block by 2 standard errors": (block, "the block of pixels from (16, 8) channel 2"),
    "a gain of 0.03 %": (lambda mean, error: mean * 1.0003, "the whole picture"),
    "more noise than is said": (
        lambda mean, error: mean + 1.5 * error * np.random.default_rng(3).standard_normal(mean.shape),
        "standard errors are too small",
    ),
}


@pytest.mark.parametrize("name", TAMPERED)
def test_what_is_wrong_is_found(name: str) -> None:
    change, reason = TAMPERED[name]
    rng = np.random.default_rng(7)
    spread = np.full((1, 48, 64, 3), 5e-3)
    one, other = normal_estimate(rng, spread, 32), normal_estimate(rng, spread, 32)
    assert not agreement.agreement(one, other, 0.0).reason
    changed = dataclasses.replace(one, mean=change(one.mean, one.standard_error))
    assert reason in agreement.agreement(changed, other, 0.0).reason


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("references")
    of = stored("spheres")
    files.save(folder, "spheres", of, SIZE, "box", make(of, SIZE, "box", PLAN))
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    (tmp_path / "spheres").mkdir()
    for path in (made / "spheres").iterdir():
        (tmp_path / "spheres" / path.name).write_bytes(path.read_bytes())
    return tmp_path


def test_the_header_says_how_it_was_made(folder: Path) -> None:
    header = read_header(folder / "spheres" / "32x24-box.exr")
    assert header["method"] == "converged"
    assert header["command"] == "aliascope reference spheres --size 32x24 --samples 144"
    assert (header["samples_per_pixel"], header["replicates"]) == ("144", "16")
    assert header["sampler"] == "sobol:scramble=shift"
    assert header["seeds"] == "1099511627776 to 1099511627791"
    loaded = files.load(folder, "spheres", stored("spheres"), SIZE, "box")
    made_again = make(stored("spheres"), SIZE, "box", dataclasses.replace(PLAN, threads=1))
    assert np.array_equal(loaded.pixels, made_again.pixels)  # the same seeds, on another number of threads
    assert loaded.provenance == made_again.provenance
    assert loaded.standard_error is not None
    assert made_again.standard_error is not None
    assert loaded.standard_error_rms == pytest.approx(made_again.standard_error_rms, rel=2.0**-7)
    assert np.all(loaded.standard_error >= made_again.standard_error * (1 - 1e-7))  # rounded up
    assert "standard error" in loaded.uncertainty


def test_progress_is_told_and_leaves_no_trace() -> None:
    told: list[tuple[int, int, float | None]] = []
    plan = Plan(samples=4, replicates=3, tell=lambda *what: told.append(what))
    quiet = dataclasses.replace(plan, tell=lambda done, total, standard_error: None)
    found, silent, two = (
        make(stored("spheres"), SIZE, "box", each) for each in (plan, quiet, dataclasses.replace(quiet, replicates=2))
    )
    assert [each[:2] for each in told] == [(0, 3), (1, 3), (2, 3)]
    assert (told[0][2], told[1][2]) == (None, None)
    assert told[2][2] == pytest.approx(two.standard_error_rms, rel=1e-12)
    assert np.array_equal(found.pixels, silent.pixels)
    assert found.provenance == silent.provenance
    assert plan == quiet


def test_a_sound_file_holds(folder: Path) -> None:
    of = stored("spheres")
    result = files.verify(folder, "spheres", of, SIZE, "box", CHECK)
    assert result.holds, result.reason
    assert result.method == "converged"
    assert 0.0 < result.difference <= result.tolerance


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda pixels: pixels * np.float32(1.001), "differs by"),
        (lambda pixels: np.where(np.arange(3) == 1, pixels[:, ::-1], pixels), "pixel"),
        (lambda pixels: np.nextafter(pixels, np.float32(2)), "changed since it was made"),
    ],
    ids=["gain", "mirrored green", "one unit in the last place"],
)
def test_a_changed_file_is_found(folder: Path, change: Callable[[Pixels], Pixels], reason: str) -> None:
    path = folder / "spheres" / "32x24-box.exr"
    header, pixels = read_header(path), change(read_image(path))
    if reason != "changed since it was made":  # by someone who corrects the digest too
        header["pixels"] = files._digest(pixels)
    write_exr(path, pixels, header, finite=False)
    result = files.verify(folder, "spheres", stored("spheres"), SIZE, "box", CHECK)
    assert not result.holds
    assert reason in result.reason


@pytest.mark.parametrize(("key", "reason"), [("replicates", "how many samples"), ("error", "its error")])
def test_a_header_that_says_nothing_is_found(folder: Path, key: str, reason: str) -> None:
    path = folder / "spheres" / "32x24-box.exr"
    write_exr(path, read_image(path), read_header(path) | {key: "?"})
    check = dataclasses.replace(CHECK, samples=36)
    assert reason in files.verify(folder, "spheres", stored("spheres"), SIZE, "box", check).reason


def test_a_standard_error_that_is_missing_or_changed_is_found(folder: Path) -> None:
    beside = folder / "spheres" / "32x24-box.standard-error.exr"
    write_exr(beside, read_image(beside) * np.float32(100), read_header(beside))
    for use in (files.load, files.verify):
        with pytest.raises(CheckFailed, match="standard error was changed"):
            use(folder, "spheres", stored("spheres"), SIZE, "box")
    beside.unlink()
    with pytest.raises(CheckFailed, match="standard error of the reference is missing"):
        files.verify(folder, "spheres", stored("spheres"), SIZE, "box")


@pytest.mark.parametrize("name", ["spheres", "terrain"])
def test_committed_references_are_those_of_the_scenes_and_steady(name: str) -> None:
    """`aliascope reference NAME --verify` takes longer: here with fewer samples, which sees less."""
    of = stored(name)
    folder = Path(__file__).resolve().parents[2] / "reference"
    loaded = files.load(folder, name, of, of.view.size, "box")
    assert loaded.standard_error_rms is not None
    assert loaded.standard_error_rms < 5e-5
    check = dataclasses.replace(files.CHECK, samples=64, threads=2)
    result = files.verify(folder, name, of, of.view.size, "box", check)
    assert result.holds, result.reason


def test_what_the_tracer_does_not_draw_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(converged.tracer, "DRAWS", converged.tracer.DRAWS - {"gloss"})
    steel = {"reflection": [0.5, 0.5, 0.5], "gloss": {"type": "phong", "exponent": 9.0}}
    glossy = scene(box(1, 1, 5, 5, material="steel"), materials={"steel": steel})
    with pytest.raises(Unsupported, match="no answer for gloss"):
        make(glossy, (12, 9), "box", PLAN)
    with pytest.raises(Ambiguous, match="same depth"):
        make(scene(box(1, 1, 8, 8), box(4, 4, 9, 9, material="blue")), (12, 9), "box", PLAN)
    with pytest.raises(SpecError):
        make(stored("edge"), (12, 9), "mitchel", PLAN)
    with pytest.raises(Unsupported, match="two replicates"):
        Plan(replicates=1)
    glowing = {"emission": [1e30] * 3, "pattern": {"type": "zone-plate", "scale": 1, "colours": [[1e20] * 3] * 2}}
    light = {"type": "point", "position": [0, 0, 9], "intensity": [1, 1, 1]}
    bright = scene(box(1, 1, 5, 5, material="sun"), materials={"sun": glowing}, lights=[light])
    with pytest.raises(Unsupported, match="brighter than float32"):
        make(bright, (12, 9), "box", Plan(samples=4, replicates=2))


def test_surfaces_that_cross_are_converged_and_say_so() -> None:
    crossing = scene(
        box(1, 1, 8, 8),
        box(2, 2, 9, 7, 0.0) | {"points": [[-4, 2, -1], [3, 2, 2], [3, -3, 2], [-4, -3, -1]], "material": "green"},
    )
    found = make(crossing, (12, 9), "box", Plan(samples=64, replicates=4))
    assert found.method == "converged"
    assert found.standard_error is not None
    assert found.standard_error.max() > 0
