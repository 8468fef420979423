"""Which pictures a comparison makes: its jobs, each under the key of all that its picture depends on."""

from __future__ import annotations

import functools
import hashlib
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from aliascope import draws, places, plan, renderers, sharing
from aliascope.errors import NotAvailable
from aliascope.model import Scene
from aliascope.native import samplers
from aliascope.native.samplers import Plugin
from aliascope.records import EmptyCell, Job
from aliascope.renderers.base import Renderer, filter_of, lacks
from aliascope.scene_io import SceneFile
from aliascope.specs import Spec


@dataclass(frozen=True)
class Plan:
    """Jobs in the order in which they run; cells that stay empty; renderers that are not there, with the reason."""

    jobs: tuple[Job, ...]
    empty: tuple[EmptyCell, ...]
    skipped: Mapping[str, str]
    files: Mapping[str, SceneFile]
    versions: Mapping[str, str]
    plugins: Mapping[str, str] = field(default_factory=dict)
    """Of the modes' samplers: path and hash by "plugin NAME"."""
    about: str = ""
    """What was chosen, for the title of a report: "quick profile, chosen scenes"."""


COMMON = ("draws.py", "geometry.py", "image.py", "meshes.py", "model.py", "motion.py", "placement.py", "specs.py")
"""What the pictures of every renderer depend on, beside renderers/ and native/ without the files of other renderers."""

SAMPLER_LIBRARY = "libaliascope.so"


@functools.cache
def code_of(renderer: str, with_samplers: bool) -> tuple[Path, ...]:
    """The files whose code a picture of this renderer depends on; `with_samplers`: one of a mode with a sampler.

    A mode without one depends on no sampler of the library: of it, the rasteriser takes the text of errors alone.
    """
    here = Path(__file__).parent
    own = _own_files(here, renderer)
    others = {path for name in renderers.BUILT_IN if name != renderer for path in _own_files(here, name)}
    others |= _external_files(here)
    others -= own
    libraries = set((here / "native" / "lib").glob("*.so"))
    if not with_samplers:
        libraries = {path for path in libraries if path.name != SAMPLER_LIBRARY}
    folders = {path for name in ("renderers", "native") for path in (here / name).glob("*.py")}
    registries = {path for path in folders if path.name == "__init__.py"}
    found = ({here / name for name in COMMON} | folders | libraries) - others - registries
    return tuple(sorted(found))


def _own_files(here: Path, renderer: str) -> set[Path]:
    """Those of a renderer that is none of ours are what runs it and writes scenes for it, as glTF or for POV-Ray."""
    if renderer not in renderers.BUILT_IN:
        return {*_external_files(here), *(here / "gltf").glob("*.py"), *(here / "renderers").glob("povray*.py")}
    native = renderers.find(renderer).native
    return {
        *(here / "renderers").glob(f"{renderer}*.py"),
        *(here / "native" / f"{name}.py" for name in native),
        *(here / "native" / "lib" / f"libaliascope-{name}.so" for name in native),
    }


def _external_files(here: Path) -> set[Path]:
    return set((here / "renderers").glob("external*.py"))


@functools.cache
def _digest(paths: tuple[Path, ...]) -> str:
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def code_digest(renderer: str, mode: Spec) -> str:
    """A hash of the code that pictures of this mode depend on: when it changes, they are made again."""
    return code_of_kind(renderer, has_sampler(mode))


def code_of_kind(renderer: str, with_samplers: bool) -> str:
    """The same of all modes that have a sampler, or have none."""
    return _digest(code_of(renderer, with_samplers))


def has_sampler(mode: Spec) -> bool:
    """Whether pictures of this mode depend on the library of samplers."""
    return any(key.kind == "spec" for key in mode.form.keys)


def plugins_of(mode: Spec) -> dict[str, Plugin]:
    """The plugins whose samplers a mode names, by the sampler. Every word counts, a value of a key too: an inner spec
    may stand anywhere."""
    words = {word for value in mode.values.values() for word in re.split("[:,=]", str(value))}
    return {name: plugin for plugin in samplers.plugins() for name in plugin.samplers if name in words}


def plugin_versions(mode: Spec) -> dict[str, str]:
    """For provenance: path and hash of the plugins that a mode names, by "plugin NAME"."""
    return {
        f"plugin {name}": f"{sharing.shared(plugin.path)} sha256 {plugin.sha256} ({plugin.where})"
        for name, plugin in plugins_of(mode).items()
    }


def make_plan(
    files: Sequence[SceneFile],
    wanted: Mapping[str, Sequence[str]],
    seeds: int,
    size: tuple[int, int] | None = None,
    required: Sequence[str] = (),
    suits: Callable[[str, Spec, Scene], bool] | None = None,
) -> Plan:
    """The jobs of these scenes with these modes by renderer; a randomised mode gets `seeds` pictures, one that is not
    as many draws, as far as `places_of` has them.

    suits: whether a scene has a cell for a mode of the renderer of this name; None: for all.
    Raises NotAvailable for a `required` renderer that is not there, SpecError for a mode that can't be read.
    """
    jobs: list[Job] = []
    empty: list[EmptyCell] = []
    skipped: dict[str, str] = {}
    versions: dict[str, str] = {}
    plugins: dict[str, str] = {}
    for name, modes in wanted.items():
        renderer = renderers.find(name)
        specs = {spec.text: spec for spec in (renderers.mode_of(renderer, mode) for mode in modes)}
        try:
            own = dict(renderer.versions())
        except NotAvailable as error:
            if name in required:
                raise
            skipped[name] = str(error)
            continue
        versions.update(own)
        for spec in specs.values():
            plugins.update(plugin_versions(spec))
        for file in files:
            digest = file.scene.digest()
            for spec in specs.values():
                if suits is not None and not suits(name, spec, file.scene):
                    continue
                reason = lacks(renderer, file.scene, spec)
                if reason:
                    empty.append(EmptyCell(file.name, name, spec.text, reason))
                else:
                    jobs += _jobs(file, digest, renderer, spec, seeds, size, own)
    # By key, that is by chance: the time left can be told from the count, and no mode has the cold machine to itself.
    jobs.sort(key=lambda job: job.key)
    return Plan(tuple(jobs), tuple(empty), skipped, {file.name: file for file in files}, versions, plugins)


def _jobs(
    file: SceneFile,
    digest: str,
    renderer: Renderer,
    spec: Spec,
    seeds: int,
    size: tuple[int, int] | None,
    versions: Mapping[str, str],
) -> Iterator[Job]:
    pixels = size or file.scene.view.size
    if renderer.seeded(spec):
        made = [(seed, draws.UNMOVED) for seed in range(seeds)]
    else:
        places = places_of(file, pixels, filter_of(spec), seeds if renderer.shifts else 1)
        made = [(0, shift) for shift in places]
    versions = versions_of(renderer, spec, versions)
    for seed, shift in made:
        yield plan.make_job(
            scene=file.name,
            scene_path=sharing.shared(str(file.path)),
            digest=digest,
            renderer=renderer.name,
            mode=spec.text,
            size=pixels,
            seed=seed,
            shift=shift,
            versions=versions,
        )


@functools.cache
def renderer_versions(renderer: str) -> Mapping[str, str]:
    """A renderer's own; asked once. Raises NotAvailable."""
    return renderers.find(renderer).versions()


def versions_of(renderer: Renderer, mode: Spec, versions: Mapping[str, str]) -> dict[str, str]:
    """Of all that renders a picture of this mode, where these are the renderer's own."""
    return {
        **versions,
        "code": code_digest(renderer.name, mode),
        **{f"plugin {name}": plugin.version for name, plugin in plugins_of(mode).items()},
    }


def places_of(file: SceneFile, size: tuple[int, int], filter_: str, count: int) -> tuple[tuple[float, float], ...]:
    """Where the film lies in the draws of a mode without seeds: so many places, `draws.MOST` at most. The first alone,
    where it is, for a scene that has no reference elsewhere: none is kept, and no exact method may have it."""
    from aliascope import references  # takes a second to load, and workers do without
    from aliascope.references import files as reference_files

    shifts = tuple(map(draws.shift_of, range(min(count, draws.MOST))))
    own = file.path.parent == places.SCENES and size == file.scene.view.size
    kept = own and all(
        reference_files.path_of(places.REFERENCES, file.name, size, filter_, shift).is_file() for shift in shifts
    )
    return shifts if kept or references.may_be_exact(file.scene, filter_) else shifts[:1]


def without(whole: Plan, judged: Judged) -> Plan:
    """A plan without the jobs that this reference judges."""
    return replace(whole, jobs=tuple(job for job in whole.jobs if judged_by(job) != judged))


Judged = tuple[str, str, tuple[float, float]]
"""A reference: scene, filter, and the pixels to the right and down by which all is moved on the film."""


def judged_by(job: Job) -> Judged:
    """Which reference judges a job: its scene's, of the filter that its mode has, moved as far as its film."""
    return job.scene, filter_of(mode_of(job)), job.shift


def mode_of(job: Job) -> Spec:
    """The parsed mode of a job."""
    renderer: Any = renderers.find(job.renderer)
    return _parsed(renderer, job.mode)


@functools.lru_cache(maxsize=1 << 14)
def _parsed(renderer: Renderer, mode: str) -> Spec:
    """A plan has a mode once for each scene and seed."""
    return renderers.mode_of(renderer, mode)
