"""Which code and which plugins a picture is kept under."""

from __future__ import annotations

import ast
import subprocess
from pathlib import Path

import pytest

import aliascope
from aliascope import pipeline, renderers, scene_io, workers
from aliascope.errors import JobFailed
from aliascope.renderers.base import Request

PACKAGE = Path(aliascope.__file__).parent
HARMLESS = {"errors.py", "records.py"}
"""Imported by renderers, and free of anything that could change a picture: messages and frozen types."""


def imported(path: Path) -> set[Path]:
    """The files of the package that a file imports, those in a function too."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.update({node.module, *(f"{node.module}.{alias.name}" for alias in node.names)})
    files = {PACKAGE.parent / (name.replace(".", "/") + ".py") for name in names if name.startswith("aliascope.")}
    return {file for file in files if file.is_file()}


@pytest.mark.parametrize("name", list(renderers.RENDERERS))
def test_the_code_of_a_renderer_is_all_that_it_imports(name: str) -> None:
    """A file that is left out would leave pictures of an earlier version in the report."""
    waiting, seen = [PACKAGE / "renderers" / f"{name}.py"], set()
    while waiting:
        path = waiting.pop()
        if path not in seen:
            seen.add(path)
            waiting += imported(path)
    assert len(seen) > 5
    code = set(pipeline.code_of(name, True))
    assert {path.name for path in seen - code} <= HARMLESS
    # What changes a scene after its digest was taken from the file: the triangles of its meshes.
    assert PACKAGE / "meshes.py" in code


def test_the_rasteriser_takes_nothing_from_the_samplers() -> None:
    """It is why a mode without a sampler does not depend on their library."""
    library = PACKAGE / "native" / "lib" / "libaliascope-raster.so"
    text = subprocess.run(["nm", "-D", "--undefined-only", library], capture_output=True, text=True, check=True).stdout
    assert {word for word in text.split() if word.startswith("asc_")} == {"asc_fail"}


def test_pictures_do_not_depend_on_the_code_of_another_renderer() -> None:
    def names(renderer: str, mode: str) -> set[str]:
        with_samplers = any(key.kind == "spec" for key in renderers.mode_of(renderers.find(renderer), mode).form.keys)
        return {path.name for path in pipeline.code_of(renderer, with_samplers)}

    embree, povray, osmesa = names("embree", "uniform"), names("povray", "am1"), names("osmesa", "msaa")
    assert {"embree.py", "tracer.py", "libaliascope-tracer.so", "libaliascope.so"} <= embree
    assert not embree & {"osmesa.py", "raster.py", "libaliascope-raster.so", "povray.py", "povray_sdl.py"}
    assert {"povray.py", "povray_sdl.py"} <= povray
    assert not [name for name in povray if name.endswith(".so")]
    assert {"osmesa.py", "raster.py", "libaliascope-raster.so"} <= osmesa
    assert not osmesa & {"libaliascope.so", "libaliascope-tracer.so", "tracer.py"}
    assert "libaliascope.so" in names("osmesa", "accumulate") & names("povray", "accumulate")
    modes = (("embree", "uniform"), ("povray", "am1"), ("povray", "accumulate"), ("osmesa", "msaa"))
    found = {pipeline.code_digest(name, renderers.mode_of(renderers.find(name), mode)) for name, mode in modes}
    assert len(found) == len(modes)


def test_a_process_is_ended_not_long_after_its_time_limit() -> None:
    assert [workers.patience(seconds) for seconds in (0.1, 2.0, 10.0, 120.0)] == [2.1, 4.0, 15.0, 140.0]


@pytest.mark.parametrize("name", ["embree", "osmesa"])
def test_a_time_limit_that_has_passed_is_a_failed_job(name: str) -> None:
    scene = scene_io.load("edge").scene
    renderer = renderers.find(name)
    mode = renderers.mode_of(renderer, "uniform:n=1" if name == "embree" else "none")
    with pytest.raises(JobFailed, match="took more than 1e-06 s"):
        renderer.render(Request(scene, 8, 6, mode, least_seconds=60.0, time_limit=1e-6))
