"""Groups of dimensions: what the scene needs, how a sampler's points are arranged for it, and what comes of that."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from commands import run

from aliascope import api, renderers
from aliascope.errors import InvalidInput, SpecError, Unsupported
from aliascope.model import Scene
from aliascope.native import samplers
from aliascope.native.samplers import ARRANGEMENTS, Sampler
from aliascope.native.tracer import Tracer
from aliascope.renderers.povray_frames import frames_of

SIZE = (24, 18)
LIGHTS = (
    {"type": "point", "position": (1.0, 2.0, 3.0), "intensity": (0.3, 0.3, 0.3)},
    {
        "type": "area",
        "corner": (-0.5, 2.0, 0.5),
        "edges": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        "intensity": (0.7, 0.7, 0.7),
    },
)


def scene_of(*, lens: float = 0.05, lights: bool = True) -> Scene:
    return Scene.model_validate(
        {
            "title": "t",
            "shows": "s",
            "view": {"size": SIZE, "background": (0.1, 0.2, 0.3)},
            "camera": {
                "type": "perspective",
                "eye": (0.0, 0.3, 4.0),
                "look_at": (0.0, 0.0, 0.0),
                "vertical_fov_degrees": 40.0,
                "shutter": (0.0, 1.0),
            }
            | ({"lens_radius": lens, "focus_distance": 3.7} if lens else {}),
            "materials": {"paper": {"albedo": (0.8, 0.7, 0.6), "emission": (0.1, 0.1, 0.1)}},
            "surfaces": [
                {
                    "type": "polygon",
                    "material": "paper",
                    "points": ((-0.71, -0.53, 0.0), (0.37, -0.61, 0.2), (0.13, 0.57, -0.1)),
                    "motion": {"type": "translate", "by": (0.43, 0.29, 0.0)},
                }
            ],
            "lights": LIGHTS if lights else (),
        }
    )


@pytest.fixture(scope="module")
def built() -> Tracer:
    return Tracer(scene_of(), SIZE)


def test_the_tracer_has_the_groups_that_the_scene_needs(built: Tracer) -> None:
    assert built.groups == scene_of().needs().groups == (2, 1, 2, 2)
    assert built.dimensions == scene_of().needs().dimensions == 7
    bare = scene_of(lens=0.0, lights=False)
    assert Tracer(bare, SIZE).groups == bare.needs().groups == (2, 1)


def test_pictures_of_all_arrangements_have_one_mean(built: Tracer) -> None:
    """Each is the mean of 96 independent pictures of 16 samples. Over all pixels the difference is that of two normal
    numbers with known standard errors: 5 of it, and of each pixel and channel 6."""
    means, errors = [], []
    for arrangement in ARRANGEMENTS:
        pictures = np.stack(
            [built.render("sobol:scramble=owen", 16, seed, arrangement=arrangement)[0] for seed in range(96)]
        ).astype(np.float64)
        means.append(pictures.mean(axis=0))
        errors.append(pictures.std(axis=0, ddof=1) / np.sqrt(len(pictures)))
    for mean, error in zip(means[1:], errors[1:], strict=True):
        deviation = np.hypot(error, errors[0])
        seen = deviation > 1e-6
        z = (mean - means[0])[seen] / deviation[seen]
        assert np.abs(z).max() < 6.0
        assert abs((mean - means[0]).sum()) < 5.0 * np.sqrt(3.0 * (deviation**2).sum())  # channels go together
        assert np.abs((mean - means[0])[~seen]).max() < 1e-6


@pytest.mark.parametrize("arrangement", ARRANGEMENTS[1:])
def test_threads_change_no_bit(built: Tracer, arrangement: str) -> None:
    one, three = (built.render("jittered", 16, 4, threads, "tent", arrangement)[0] for threads in (1, 3))
    assert np.array_equal(one, three)
    assert not np.array_equal(one, built.render("jittered", 16, 4, 1, "tent")[0])


def test_an_adaptive_mode_takes_a_padded_sequence(built: Tracer) -> None:
    whole = built.render("sobol:scramble=owen", 4096)[0]
    picture, counts, _ = built.render_adaptive(
        "kajiya:tolerance=0.01", "sobol:scramble=owen", 256, arrangement="padded"
    )
    assert counts.min() < counts.max()
    assert np.abs(picture - whole).mean() < 0.01  # its tolerance
    # Other samples for the value than for the decision: the sampler is made again, arranged alike.
    fresh = built.render_adaptive("kajiya:tolerance=0.01,unbiased=1", "sobol:scramble=owen", 256, arrangement="padded")
    assert np.abs(fresh[0] - whole).mean() < 0.01


def test_what_an_adaptive_mode_cannot_take() -> None:
    embree = renderers.find("embree")
    mode = renderers.mode_of(embree, "adaptive:dimensions=decorrelated")
    assert "on the way" in (embree.unable(scene_of(), mode) or "")
    mode = renderers.mode_of(embree, "adaptive:dimensions=padded,sampler=jittered")
    assert "sequence" in (embree.unable(scene_of(), mode) or "")
    assert embree.unable(scene_of(), renderers.mode_of(embree, "adaptive:dimensions=padded")) is None


def test_modes_say_how_their_dimensions_go_together() -> None:
    embree = renderers.find("embree")
    assert renderers.mode_of(embree, "uniform:dimensions=joint").text == "uniform"
    assert renderers.mode_of(embree, "uniform:n=4,dimensions=padded").text == "uniform:dimensions=padded,n=4"
    assert renderers.arranged(embree, "uniform:n=4", "padded") == "uniform:dimensions=padded,n=4"
    assert renderers.arranged(embree, "uniform:dimensions=joint", "padded") == "uniform:dimensions=joint"
    assert renderers.arranged(renderers.find("osmesa"), "msaa", "padded") == "msaa"
    with pytest.raises(SpecError, match="none of joint, padded, decorrelated"):
        renderers.arranged(embree, "uniform", "pad")
    # A pattern that is not randomised is shuffled by the seed.
    assert embree.seeded(renderers.mode_of(embree, "uniform:sampler=hammersley,dimensions=padded"))
    assert not embree.seeded(renderers.mode_of(embree, "uniform:sampler=hammersley"))


@pytest.mark.parametrize("sampler", ["cook", "pan-diagonal", "mitchell-spacetime", "lattice", "latin-square"])
def test_three_dimensional_patterns_drive_place_and_time(sampler: str) -> None:
    """Two of the picture, one of time: each as its own pattern in three dimensions."""
    moving = scene_of(lens=0.0, lights=False)
    embree = renderers.find("embree")
    mode = renderers.mode_of(embree, f"uniform:n=16,sampler={sampler}")
    assert embree.unable(moving, mode) is None
    picture = Tracer(moving, SIZE).render(sampler, 16, 3)[0]
    converged = Tracer(moving, SIZE).render("sobol:scramble=owen", 4096)[0]
    assert np.sqrt(((picture - converged) ** 2).mean()) < 0.05
    if sampler in ("cook", "pan-diagonal", "mitchell-spacetime"):
        assert "dimensions=padded" in (embree.unable(scene_of(), mode) or "")
    padded = renderers.mode_of(embree, f"uniform:n=16,dimensions=padded,sampler={sampler}")
    assert embree.unable(scene_of(), padded) is None


def test_points_come_in_groups() -> None:
    found = samplers.points("sobol:scramble=owen", 16, (2, 1, 2), 7, arrangement="padded")
    assert found.shape == (16, 5)
    assert np.array_equal(found[:, :2], samplers.points("sobol:scramble=owen", 16, 2, 7))
    assert np.array_equal(samplers.points("halton", 16, (2, 1)), samplers.points("halton", 16, 3))
    with pytest.raises(SpecError, match='"pad"'):
        Sampler("halton", 16, (2, 1), arrangement="pad")
    with pytest.raises(Unsupported, match="16384"):
        Sampler("halton", 1 << 20, (2, 1), arrangement="decorrelated")
    assert "dimensions=padded" in (samplers.refusal("regular", 16, (2, 1)) or "")
    assert samplers.refusal("regular", 16, (2, 1), "padded") is None


def test_pov_ray_accumulates_the_same_points() -> None:
    scene = scene_of(lights=False)
    povray = renderers.find("povray")
    mode = renderers.mode_of(povray, "accumulate:n=16,sampler=jittered,dimensions=decorrelated")
    assert povray.unable(scene, mode) is None
    assert povray.seeded(mode)
    frames = frames_of(mode, 5, scene)
    points = samplers.points("jittered", 16, (2, 1, 2), 5, arrangement="decorrelated")
    assert frames.times is not None
    assert np.array_equal(frames.shifts, points[:, :2] - 0.5)
    assert np.array_equal(frames.times, points[:, 2])


def test_the_commands(tmp_path: Path) -> None:
    common = ("points", "hammersley", "-n", "8", "--groups", "2,1")
    found = json.loads(run(*common, "--arrangement", "padded", "--json").stdout)
    assert (found["groups"], found["arrangement"], found["d"]) == ([2, 1], "padded", 3)
    expected = samplers.points("hammersley", 8, (2, 1), arrangement="padded")
    assert np.allclose(found["points"], expected, rtol=0, atol=0)
    assert "joint" in run("points", "hammersley", "-n", "8", "--groups", "2,1", "--arrangement", "x", code=2).stderr
    run("points", "hammersley", "-n", "8", "--groups", "2,0", code=2)
    run("points", "hammersley", "-n", "8", "--arrangement", "padded", code=2)
    run(*common, "-d", "4", code=2)
    out = tmp_path / "edge.exr"
    drawn = ("render", "edge", "-r", "embree", "-m", "uniform:n=4", "-o", out, "--size", "16x12", "--json")
    assert json.loads(run(*drawn, "--dimensions", "padded").stdout)["mode"] == "uniform:dimensions=padded,n=4"
    other = ("render", "edge", "-r", "osmesa", "-m", "msaa", "-o", out, "--size", "16x12")
    assert "--dimensions" in run(*other, "--dimensions", "padded", code=2).stderr
    listed = run(
        *("compare", "edge", "-r", "embree", "-m", "uniform:n=4", "--dry-run", "--json"),
        *("--dimensions", "joint", "--dimensions", "padded"),
    )
    assert {job["mode"] for job in json.loads(listed.stdout)["jobs"]} == {
        "uniform:n=4",
        "uniform:dimensions=padded,n=4",
    }


def test_a_quadrature_rule_is_not_taken_apart() -> None:
    with pytest.raises(Unsupported, match="dimensions=joint"):
        api.points("gauss-legendre", 16, (2, 1), arrangement="padded")
    with pytest.raises(InvalidInput):
        api.points("halton", 16, (2, 0))
