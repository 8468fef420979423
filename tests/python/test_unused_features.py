"""A scene pays for nothing that it does not need: what it declares without effect changes no ray, no dimension, no bit
of a picture, no statement of POV-Ray's text and no shader."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from aliascope import places, scene_io
from aliascope.model import LoadedMesh, Scene
from aliascope.native import raster
from aliascope.native.tracer import Tracer
from aliascope.renderers import base, embree, mode_of, osmesa, povray
from aliascope.renderers.povray_frames import frames_of
from aliascope.renderers.povray_light import lighting_of
from aliascope.renderers.povray_sdl import moving_texts, scene_text

SIZE = (32, 24)


@cache
def plain(name: str) -> Scene:
    return scene_io.load(name).scene


def is_flat(scene: Scene) -> bool:
    needs = scene.needs()
    return not (
        needs.lens or needs.shutter or needs.area_lights or needs.mirror or needs.gloss or needs.diffuse_bounces
    )


FLAT = [name for name in scene_io.names() if is_flat(plain(name))]

CAMERA = {
    "a lens of radius 0": "lens_radius = 0.0\nfocus_distance = 2.7\nblades = 5",
    "a shutter before what stands still": 'shutter = [0.1, 0.9]\nresponse = "triangle"',
    "a shutter that is open for an instant": "shutter = [0.0, 0.0]",
}
MOVING = {
    "translate": 'motion = { type = "translate", by = [1.3, -2.1, 0.7] }',
    "rotate": 'motion = { type = "rotate", axis = [0.3, 1.0, 0.2], degrees = 71.0 }',
}
MORE = {
    "a mirror that no surface has": "\n[materials.unused]\nreflection = [0.7, 0.8, 0.9]\n",
    "a gloss that no surface has": '\n[materials.unused]\nreflection = [0.7, 0.8, 0.9]\ngloss = { type = "ggx", '
    "roughness = 0.2 }\n",
    "bounces of mirrors": "\n[transport]\nmirror_bounces = 3\n",
}


def write(folder: Path, name: str, text: str) -> Path:
    """The text as the file of a scene of this name, its mesh beside it."""
    for mesh in re.findall(r'^file = "(.*)"$', text, re.MULTILINE):
        if not (folder / mesh).exists():
            shutil.copy(places.SCENES / mesh, folder)
    path = folder / f"{name}.toml"
    path.write_text(text)
    return path


def declarations(name: str) -> dict[str, str]:
    """The scene's text with each of the features that it does not use, and with all of them together; of a large mesh,
    with all alone, for the time that it takes."""
    text = (places.SCENES / f"{name}.toml").read_text()
    assert "[[surfaces]]" in text

    def declaring(camera: str = "", surfaces: str = "", more: str = "") -> str:
        changed = text.replace("[camera]", f"[camera]\n{camera}", 1)
        return changed.replace("[[surfaces]]", f"[[surfaces]]\n{surfaces}") + more

    instant = CAMERA["a shutter that is open for an instant"]
    made = {
        "all": declaring(
            CAMERA["a lens of radius 0"] + "\n" + instant,
            MOVING["rotate"],
            MORE["a gloss that no surface has"] + MORE["bounces of mirrors"],
        )
    }
    if '"mesh"' in text:
        return made
    made |= {what: declaring(camera) for what, camera in CAMERA.items()}
    made |= {f"{what} in an instant": declaring(instant, surfaces) for what, surfaces in MOVING.items()}
    made |= {f"{what} without a shutter": declaring("", surfaces) for what, surfaces in MOVING.items()}
    made |= {what: declaring(more=more) for what, more in MORE.items()}
    if not any(any(material.albedo) for material in plain(name).materials.values()):
        made["bounces of nothing"] = declaring(more="\n[transport]\ndiffuse_bounces = 4\n")
    return made


@pytest.fixture(scope="module")
def declared(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Scene]]:
    folder = tmp_path_factory.mktemp("declared")
    return {
        name: {what: scene_io.load_file(write(folder, name, text)).scene for what, text in declarations(name).items()}
        for name in FLAT
    }


def test_there_are_flat_scenes() -> None:
    assert {"checker-horizon", "comb", "discs", "edge", "siemens-star", "spheres", "terrain", "zone-plate"} <= set(FLAT)


@pytest.mark.parametrize("name", FLAT)
def test_the_tracer_has_the_same_rays_dimensions_and_bits(name: str, declared: dict[str, dict[str, Scene]]) -> None:
    def drawn(scene: Scene) -> tuple[object, ...]:
        built = Tracer(scene, SIZE)
        pixels, cost = built.render("sobol:scramble=owen", 4, 5)
        whole = base.Request(scene, *SIZE, mode_of(embree.RENDERER, "uniform:n=1"))
        rays = dict(embree.RENDERER.render(whole).cost.rays)
        return pixels.tobytes(), built.dimensions, cost.samples, cost.primary_rays, cost.shadow_rays, rays

    expected = drawn(plain(name))
    assert expected[1] == 2
    for what, scene in declared[name].items():
        assert (scene.needs(), scene.features()) == (plain(name).needs(), plain(name).features()), what
        assert drawn(scene) == expected, what


def with_few_triangles(scene: Scene) -> Scene:
    few = {
        number: mesh.model_copy(update={"triangles": mesh.triangles[:50]})
        for number, mesh in enumerate(scene.surfaces)
        if isinstance(mesh, LoadedMesh)
    }
    return scene.with_meshes(few)


SDL_OF_NEEDS = ("aperture", "focal_point", "blur", "area_light", "#include", "array", "reflection", "trace_level")


@pytest.mark.parametrize("name", FLAT)
def test_povray_has_the_same_text(name: str, declared: dict[str, dict[str, Scene]]) -> None:
    def texts(scene: Scene) -> tuple[object, ...]:
        scene = with_few_triangles(scene)
        found: list[object] = []
        for text in ("none", "am1:depth=2", "accumulate:n=2"):
            mode = mode_of(povray.RENDERER, text)
            assert base.lacks(povray.RENDERER, scene, mode) is None
            frames = frames_of(mode, 0, scene)
            assert frames.times is None
            assert frames.lens is None
            found += [scene_text(scene, SIZE, 1.0, frames), *moving_texts(scene, 1.0, frames)]
            found += [lighting_of(scene, frames.times), frames.shifts.tobytes(), frames.weights.tobytes()]
        return tuple(found)

    expected = texts(plain(name))
    for word in SDL_OF_NEEDS:
        assert word not in str(expected[0]), word
    for what, scene in declared[name].items():
        assert texts(scene) == expected, what


OSMESA = [name for name in FLAT if base.lacks(osmesa.RENDERER, plain(name), mode_of(osmesa.RENDERER, "none")) is None]


@pytest.mark.parametrize("name", OSMESA)
def test_osmesa_has_the_same_bits(name: str, declared: dict[str, dict[str, Scene]]) -> None:
    expected = None
    for what, scene in {"plain": plain(name), **declared[name]}.items():
        pixels, cost = raster.Raster(scene, SIZE).render(raster.Passes(np.array([(0.3, 0.6)]), np.ones(1)))
        expected = expected or (pixels.tobytes(), cost.samples)
        assert (pixels.tobytes(), cost.samples) == expected, what


DUMPING = """
import sys
import numpy as np
from aliascope import scene_io
from aliascope.native import raster
for path in sys.argv[1:]:
    raster.Raster(scene_io.load(path).scene, (32, 24)).render(raster.Passes(np.array([(0.3, 0.6)]), np.ones(1)))
"""


def shaders(folder: Path, paths: list[str]) -> dict[str, str]:
    """The texts that Mesa got, as a C preprocessor leaves them, by the names that it gives their hashes."""
    folder.mkdir()
    environment = {**os.environ, "MESA_SHADER_DUMP_PATH": str(folder), "MESA_SHADER_CACHE_DISABLE": "true"}
    subprocess.run([sys.executable, "-c", DUMPING, *paths], env=environment, check=True)
    found = {}
    for path in folder.iterdir():
        body = "\n".join(line for line in path.read_text().splitlines() if not line.startswith("#version"))
        done = subprocess.run(
            ["cc", "-E", "-P", "-x", "c", "-"], input=body, capture_output=True, text=True, check=True
        )
        found[path.name] = done.stdout
    return found


def test_osmesa_has_the_same_shaders(tmp_path: Path) -> None:
    paths = [str(write(tmp_path, name, declarations(name)["all"])) for name in OSMESA]
    expected, found = shaders(tmp_path / "plain", OSMESA), shaders(tmp_path / "all", paths)
    assert found == expected
    assert len(expected) == 7
    lit = [text for text in expected.values() if "vec3 light(" in text]
    assert len(lit) == 2  # of `spheres`, its polygons and its spheres
    # Branches of all, for a scene that needs no lens, no shutter and no light with an area.
    branches = Counter(word for text in expected.values() for word in re.findall(r"\b(?:if|for)\b|\?", text))
    assert branches == BRANCHES
    for word in ("lens", "shutter", "time", "area", "focus", "edges"):
        assert not any(re.search(rf"\b{word}", text, re.IGNORECASE) for text in expected.values()), word


BRANCHES = {"if": 20, "for": 6, "?": 7}


def test_what_has_an_effect_does_cost(tmp_path: Path) -> None:
    """Or the tests above could not fail."""
    text = (places.SCENES / "spheres.toml").read_text()
    lens = text.replace("[camera]", "[camera]\nlens_radius = 0.1\nfocus_distance = 2.7", 1)
    going = text.replace("[camera]", "[camera]\nshutter = [0.0, 0.5]", 1)
    going = going.replace("[[surfaces]]", f"[[surfaces]]\n{MOVING['translate']}")
    first = Tracer(plain("spheres"), SIZE).render("sobol:scramble=owen", 4, 5)[0]
    for changed, dimensions in ((lens, 4), (going, 3)):
        scene = scene_io.load_file(write(tmp_path, "spheres", changed)).scene
        assert Tracer(scene, SIZE).dimensions == dimensions
        assert not np.array_equal(Tracer(scene, SIZE).render("sobol:scramble=owen", 4, 5)[0], first)
        mode = mode_of(povray.RENDERER, "accumulate:n=2")
        assert scene_text(scene, SIZE, 1.0, frames_of(mode, 0, scene)) != scene_text(
            plain("spheres"), SIZE, 1.0, frames_of(mode, 0, plain("spheres"))
        )
