"""The profiles."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import pytest

from aliascope import plan, renderers, scene_io
from aliascope.studies import selection


def texts(profile: str, name: str) -> list[str]:
    return [renderers.mode_of(renderers.find(name), mode).text for mode in plan.profile(profile)[name]]


@pytest.mark.parametrize("name", list(renderers.RENDERERS))
def test_full_has_every_mode_of_quick_and_none_twice(name: str) -> None:
    assert set(texts("quick", name)) <= set(texts("full", name))
    for profile in plan.PROFILES:
        assert len(set(texts(profile, name))) == len(texts(profile, name))


def test_the_planar_patterns_have_their_counts() -> None:
    embree = renderers.find("embree")
    for pattern in plan.PLANAR:
        for n in (16, 64, 256):
            mode = renderers.mode_of(embree, f"uniform:n={n},sampler={pattern}")
            assert mode.text in texts("full", "embree")
            # What is drawn does not depend on the scene; no cell stays empty for the count's sake.
            embree.seeded(mode)  # raises Unsupported for a count that the pattern has not


def test_a_further_sampler_joins_every_renderer_that_takes_one() -> None:
    own = plan.with_samplers(plan.QUICK, ["r2"])
    for name, count in (("embree", len(plan.COUNTS)), ("povray", 2), ("osmesa", 3)):
        added = own[name][len(plan.QUICK[name]) :]
        assert own[name][: len(plan.QUICK[name])] == plan.QUICK[name]
        assert len(added) == count
        assert all(renderers.mode_of(renderers.find(name), mode).word("sampler") == "r2" for mode in added)


# Modes that suit a scene

LENS = "lens_radius = 0.2\nfocus_distance = 5.0\n"
LAMP = '[[lights]]\ntype = "area"\ncorner = [0, 0, 2]\nedges = [[0, 1, 0], [1, 0, 0]]\nintensity = [1, 1, 1]\n'
MOVING = 'motion = { type = "translate", by = [1, 0, 0] }\n'
SCENES = {
    "plain": ("", "", ""),
    "lens": (LENS, "", ""),
    "area light": ("", "", LAMP),
    "frames": ("shutter = [0.0, 1.0]\n", MOVING, ""),
    "frames of a lens with blades": (LENS + "blades = 6\n", "", ""),
    "frames of a lens and a lamp": (LENS, "", LAMP),
    "frames of a cosine": ("", "", LAMP + 'falloff = "inverse-square"\n'),
}


def written(folder: Path, camera: str, motion: str, lights: str) -> str:
    path = folder / "scene.toml"
    path.write_text(f"""
title = "a floor"
shows = "a floor"
[view]
size = [16, 12]
[camera]
type = "perspective"
eye = [0.0, 0.0, 5.0]
look_at = [0.0, 0.0, 0.0]
vertical_fov_degrees = 40.0
{camera}
[materials.floor]
albedo = [0.5, 0.5, 0.5]
[[surfaces]]
type = "disc"
material = "floor"
centre = [0, 0, 0]
radius = 1.0
{motion}
{lights}""")
    return str(path)


@pytest.mark.parametrize("profile", list(plan.PROFILES))
@pytest.mark.parametrize("name", list(SCENES))
def test_a_scene_gets_the_modes_that_draw_it_and_no_empty_cell(tmp_path: Path, profile: str, name: str) -> None:
    path = written(tmp_path, *SCENES[name])
    made = selection.plan_of([path], ["povray"], [], profile, None)
    kind = name.partition(" of ")[0]
    povray = renderers.find("povray")
    expected = {renderers.mode_of(povray, mode).text for mode in plan.KINDS[profile]["povray"][kind]}
    assert {job.mode for job in made.jobs} == expected
    assert not made.empty
    assert made.about == f"{profile} profile, chosen scenes and modes"  # the renderer was named


def test_modes_that_are_named_are_for_all_scenes(tmp_path: Path) -> None:
    path = written(tmp_path, *SCENES["lens"])
    for mode in ("am1:depth=3", "am1*"):
        made = selection.plan_of([path], ["povray"], [mode], "quick", None)
        assert not made.jobs
        assert all("does not draw a lens" in cell.reason for cell in made.empty)
        assert made.empty


def test_modes_suit_a_scene_however_their_dimensions_are_arranged(tmp_path: Path) -> None:
    path = written(tmp_path, *SCENES["plain"])
    made = selection.plan_of([path], ["povray"], [], "quick", None, ["padded"])
    assert not any(job.mode.startswith("accumulate") for job in made.jobs)
    path = written(tmp_path, *SCENES["frames"])
    made = selection.plan_of([path], ["povray"], [], "quick", None, ["padded"])
    assert {job.mode for job in made.jobs} == {
        f"accumulate:dimensions=padded,n={n},sampler=sobol" if n != 16 else "accumulate:dimensions=padded,sampler=sobol"
        for n in (4, 16, 64)
    }


def test_scenes_of_bounces_get_few_modes_in_the_quick_profile_and_say_who_does_not_draw_them(tmp_path: Path) -> None:
    path = written(tmp_path, "", "", "[transport]\ndiffuse_bounces = 2")
    made = selection.plan_of([path], [], [], "quick", None)
    modes = {job.mode for job in made.jobs}
    assert "uniform:n=64" in modes  # of the default sampler
    assert "uniform:sampler=halton" in modes
    assert not [mode for mode in modes if mode.startswith("adaptive") or "n=256" in mode or "n=64,sampler=" in mode]
    assert {cell.renderer for cell in made.empty} == {"povray", "osmesa"}
    full = {job.mode for job in selection.plan_of([path], ["embree"], [], "full", None).jobs}
    assert "uniform:n=256,sampler=halton" in full


def test_a_regular_grid_is_for_the_two_dimensions_of_a_pixel(tmp_path: Path) -> None:
    modes = []
    for name in ("plain", "area light"):
        made = selection.plan_of([written(tmp_path, *SCENES[name])], ["embree"], [], "quick", None)
        modes.append({job.mode for job in made.jobs} | {cell.mode for cell in made.empty})
        assert not made.empty
    embree = renderers.find("embree")
    assert modes[0] == {renderers.mode_of(embree, mode).text for mode in plan.EMBREE_QUICK}
    assert {mode for mode in modes[0] - modes[1] if "sampler=regular" in mode} == modes[0] - modes[1] != set()


def test_a_scene_of_many_triangles_is_heavy() -> None:
    """povray reads it for seconds in each run."""
    assert plan.kind_of(scene_io.load("terrain").scene) == "heavy"
    made = selection.plan_of(["terrain"], [], [], "quick", None)
    seen = {job.mode for job in made.jobs if job.renderer == "povray"}
    assert seen == {renderers.mode_of(renderers.find("povray"), mode).text for mode in plan.POVRAY_QUICK["heavy"]}
    assert plan.POVRAY_FULL["heavy"] == plan.POVRAY_FULL["plain"]


def test_a_shift_makes_another_key_and_none_the_same_as_ever() -> None:
    """The key of a picture in its place was found by `make_job` before there were shifts."""
    given: dict[str, Any] = {
        "scene": "s",
        "scene_path": "s.toml",
        "digest": "d",
        "renderer": "embree",
        "mode": "uniform",
        "size": (8, 6),
        "seed": 3,
        "versions": {"a": "1"},
    }
    still = plan.make_job(**given)
    assert still.key == hashlib.sha256(b'["d", "embree", "uniform", [8, 6], 3, {"a": "1"}]').hexdigest()[:32]
    moved = [plan.make_job(**given, shift=shift) for shift in ((0.25, 0.0), (0.0, 0.25), (0.0, 0.0))]
    assert [job.shift for job in moved] == [(0.25, 0.0), (0.0, 0.25), (0.0, 0.0)]
    assert len({job.key for job in moved}) == 3
    assert moved[-1] == still
