"""Mitsuba 3, a renderer that is none of ours, by its TOML file: its pictures go to our references."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from aliascope import api, at_start, metrics, places, renderers, scene_io
from aliascope.model import PointLight
from aliascope.references import files
from aliascope.studies import probes

FILE = Path(__file__).parents[1] / "renderers" / "mitsuba.toml"


@pytest.fixture(autouse=True)
def _registry(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(renderers, "RENDERERS", dict(renderers.BUILT_IN))
    monkeypatch.setattr(at_start, "_STEPS", {})
    return


def rmse(scene: str, mode: str) -> float:
    file = scene_io.load(scene)
    reference = files.load(places.REFERENCES, scene, file.scene, file.scene.view.size, "box")
    found = metrics.measure(api.render(file, str(FILE), mode).pixels, reference.pixels)["rmse"].value
    assert found is not None
    return found


def test_its_version_is_stated() -> None:
    assert renderers.find(str(FILE)).versions()["mitsuba"].startswith("3.")


@pytest.mark.parametrize("scene", ["edge", "discs"])
def test_its_pictures_go_to_the_reference(scene: str) -> None:
    """Stratified samples of an edge have an error of order n^(-3/4): 16 times as many, an eighth; a quarter holds."""
    errors = [rmse(scene, f"path:sampler=multijitter,n={n}") for n in (4, 64)]
    assert errors[1] < errors[0] / 4.0
    assert errors[1] < 0.003


def test_light_and_shadow_are_those_of_the_tracer() -> None:
    """Spheres, a lamp that falls off, a sun: 64 random samples each of Mitsuba's, and no bias beyond their chance."""
    file = scene_io.load("spheres")
    lights = tuple(
        light.model_copy(update={"falloff": "inverse-square", "intensity": tuple(15.0 * x for x in light.intensity)})
        if isinstance(light, PointLight)
        else light
        for light in file.scene.lights
    )
    lit = scene_io.SceneFile("lit", file.path, file.scene.model_copy(update={"lights": lights}))
    ours = api.render(lit, "embree", "uniform:n=1024", size=(64, 48)).pixels.astype(float)
    theirs = api.render(lit, str(FILE), "path:sampler=multijitter,n=64", size=(64, 48)).pixels
    assert np.sqrt(((theirs - ours) ** 2).mean()) < 0.003
    assert abs((theirs - ours).mean()) < 1e-4


def test_its_conventions_are_ours() -> None:
    """Pixel centres, linear output, no gain, by the probe of `compare`."""
    probe = probes.measure(renderers.find(str(FILE)))
    assert probe.holds, probe
