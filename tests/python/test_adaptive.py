"""Adaptive modes of the tracer: what they reach, what they cost, and what is kept of them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from page_data import shown

from aliascope import api, image, jobs, plan, references, renderers, scene_io
from aliascope.errors import SpecError, Unsupported
from aliascope.records import Rendering

SEEDS = 6
SCENES = ("edge", "siemens-star")


def crossed(scene: str) -> tuple[np.ndarray, np.ndarray]:
    """The exact picture, and which of its pixels an edge crosses: those that are of no surface's own colour."""
    file = scene_io.load(scene)
    exact = references.make(file.scene, file.scene.view.size).exact
    plain = np.zeros(exact.shape[:2], bool)
    for colour in (file.scene.view.background, *(material.emission for material in file.scene.materials.values())):
        plain |= np.abs(exact - np.array(colour)).max(axis=2) < 1e-9
    return exact, ~plain


CROSSED = {scene: crossed(scene) for scene in SCENES}


def render(mode: str, seed: int = 0, scene: str = "edge", threads: int = 1) -> Rendering:
    return api.render(scene, "embree", mode, seed=seed, threads=threads)


def measured(mode: str, scene: str) -> tuple[float, float]:
    """The RMSE over the pixels that an edge crosses, and the samples a pixel of the whole picture."""
    exact, mask = CROSSED[scene]
    made = [render(mode, seed, scene) for seed in range(SEEDS)]
    error = float(np.sqrt(np.mean([(each.pixels[mask] - exact[mask]) ** 2 for each in made])))
    return error, float(np.mean([each.cost.samples_per_pixel for each in made]))


@pytest.fixture(scope="module")
def uniform() -> dict[str, float]:
    return {scene: measured("uniform:n=64", scene)[0] for scene in SCENES}


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("mode", plan.ADAPTIVE)
def test_a_third_of_the_samples_reaches_the_error_of_64(mode: str, scene: str, uniform: dict[str, float]) -> None:
    """Both with Owen-scrambled Sobol points and the same seeds; samples are all that were traced."""
    error, samples = measured(mode, scene)
    print(f"{scene} {mode}: {error / uniform[scene]:.3f} of the error, {samples:.2f} samples a pixel")
    assert error <= uniform[scene]
    assert samples <= 64.0 / 3.0


def test_every_method_has_its_numbers() -> None:
    assert [mode.split("method=")[1].split(",")[0] for mode in plan.ADAPTIVE] == list(renderers.embree.METHODS)


@pytest.mark.parametrize("mode", plan.ADAPTIVE)
def test_threads_do_not_change_a_bit(mode: str) -> None:
    one, three = render(mode, scene="siemens-star"), render(mode, scene="siemens-star", threads=3)
    assert one.pixels.tobytes() == three.pixels.tobytes()
    assert one.counts is not None
    assert three.counts is not None
    assert np.array_equal(one.counts, three.counts)
    assert one.cost.samples == three.cost.samples


@pytest.mark.parametrize("criterion", ["contrast", "variance", "range", "student-t", "chi-squared"])
@pytest.mark.parametrize("method", ["whitted", "kajiya", "mitchell"])
def test_criteria_and_methods_combine(method: str, criterion: str) -> None:
    mode = f"adaptive:method={method},method.criterion={criterion},n=40"
    made = render(mode)
    exact, mask = CROSSED["edge"]
    assert made.counts is not None
    assert made.counts.max() <= 40
    # Without refinement the first samples err by 0.04 and more.
    assert np.sqrt(np.mean((made.pixels[mask] - exact[mask]) ** 2)) < 0.025


def test_samples_go_where_the_edges_are() -> None:
    made, (_, mask) = render("adaptive:n=64"), CROSSED["edge"]
    assert made.counts is not None
    assert made.counts[mask].mean() > 5.0 * made.counts[~mask].mean()
    # All that the pixels took, and those of the ring around each tile.
    assert made.counts.sum() < made.cost.samples < 1.1 * made.counts.sum()
    assert made.cost.rays["primary"] == made.cost.samples


def test_a_lit_scene_counts_its_shadow_rays() -> None:
    made = render("adaptive:method=whitted,n=32", scene="spheres")
    assert 0 < made.cost.rays["shadow"] < made.cost.samples * len(scene_io.load("spheres").scene.lights) + 1


@pytest.mark.parametrize(
    ("mode", "reason"),
    [
        ("adaptive:filter=tent", "box filter alone"),
        ("adaptive:sampler=regular", "no sequence"),
        ("adaptive:sampler=gauss-legendre", "gauss-legendre"),
        ("adaptive:method=kajiya,method.unbiased=1,sampler=halton", "randomised"),
    ],
)
def test_what_cannot_be_is_an_empty_cell(mode: str, reason: str) -> None:
    with pytest.raises(Unsupported, match=reason):
        render(mode)
    found = jobs.make_plan([scene_io.load("edge")], {"embree": [mode]}, 1)
    assert not found.jobs
    assert reason in found.empty[0].reason


@pytest.mark.parametrize("mode", ["adaptive:method=fixed", "adaptive:method=kajiya,method.nod=3", "adaptive:n=2"])
def test_what_makes_no_sense_is_said(mode: str) -> None:
    with pytest.raises(SpecError):
        render(mode)


def test_the_canonical_form_leaves_out_defaults() -> None:
    found = renderers.mode_of(renderers.embree.RENDERER, "adaptive:method.depth=3,method=whitted,n=64,method.start=1")
    assert found.text == "adaptive:method=whitted,method.depth=3"


def command(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "aliascope.cli", *words], capture_output=True, text=True, check=False)


def test_counts_are_written_and_told(tmp_path: Path) -> None:
    out, counts = tmp_path / "out.exr", tmp_path / "counts.exr"
    words = ["render", "edge", "-r", "embree", "-o", str(out), "--counts", str(counts)]
    told = json.loads(command(*words, "-m", "adaptive:n=64", "--json").stdout)
    kept = image.read_counts(counts)
    assert kept.shape == (96, 128)
    assert told["counts"] == {"least": kept.min(), "most": kept.max(), "image": str(counts)}
    assert told["samples_per_pixel"] == pytest.approx(told["samples"] / (128 * 96))
    assert image.read_header(counts)["mode"] == "adaptive"
    counts.unlink()
    refused = command(*words, "-m", "uniform:n=4")
    assert refused.returncode == 2
    assert "--counts is for adaptive modes" in refused.stderr
    assert not counts.exists()


def test_a_comparison_keeps_the_counts_and_makes_them_again(tmp_path: Path) -> None:
    words = ["compare", "edge", "-r", "embree", "-m", "adaptive:n=32", "-o", str(tmp_path), "--json"]
    assert json.loads(command(*words).stdout)["rendered"] == 3
    kept = sorted(tmp_path.glob("images/*/*/*.counts.exr"))
    assert len(kept) == 3
    most = max(int(image.read_counts(path).max()) for path in kept)
    assert most <= 32
    assert shown((tmp_path / "report.html").read_text())["scenes"][0]["mostSamples"] == most
    kept[0].unlink()
    told = json.loads(command(*words).stdout)
    assert (told["rendered"], told["reused"]) == (1, 2)
    assert kept[0].is_file()
