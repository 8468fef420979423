"""What a worker says of itself, and how it does a job."""

from __future__ import annotations

import functools
import hashlib
import json
import pickle
import socket
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from pebble import ProcessExpired

from aliascope import calibration, jobs, logs, places, renderers
from aliascope.errors import AliascopeError, JobFailed, NotAvailable, Unsupported
from aliascope.native import samplers
from aliascope.pipeline import Options, Timed, render_job
from aliascope.records import Job, Machine
from aliascope.scene_io import SceneFile
from aliascope.workers import Workers

ANY = "aliascope"
"""The resource that every worker of ours has."""

BOOT = Path("/proc/sys/kernel/random/boot_id")


@dataclass(frozen=True)
class About:
    """What a worker says of itself. versions: of each renderer, and of the code that pictures depend on, without and
    with the library of samplers; absent: why it has not the others."""

    machine: Machine
    versions: Mapping[str, Mapping[str, Mapping[str, str]]]
    absent: Mapping[str, str]

    def resources(self) -> dict[str, float]:
        """What the scheduler is told that it can do, once at a time."""
        kinds = [resource(name, kind) for name, both in self.versions.items() for kind in both.values()]
        return dict.fromkeys([ANY, *self.versions, *kinds], 1.0)


def resource(renderer: str, versions: Mapping[str, str]) -> str:
    """The name of the resource that renders with these versions."""
    return f"{renderer} {hashlib.sha256(json.dumps(dict(versions), sort_keys=True).encode()).hexdigest()[:16]}"


def kind_of(with_samplers: bool) -> str:
    return "with samplers" if with_samplers else "without samplers"


@functools.cache
def machine() -> Machine:
    """This one."""
    told, name = places.machine(), socket.gethostname()
    try:
        identity = BOOT.read_text().strip()
    except OSError:
        identity = name
    return Machine(name, told["processor"], told["cores"], identity)


def about(without: Sequence[str] = ()) -> About:
    """What this process can draw with: our renderers, those of packages, and those of files that were added, `without`
    some. Raises InvalidInput for a name among these that there is not."""
    versions: dict[str, dict[str, dict[str, str]]] = {}
    absent = {renderers.find(name).name: "its worker was started without it" for name in without}
    for name in dict.fromkeys([*renderers.RENDERERS, *renderers.plugged_in()]):
        if name in absent:
            continue
        try:
            own = dict(renderers.find(name).versions())
        except (AliascopeError, OSError) as error:
            absent[name] = str(error)
            continue
        versions[name] = {kind_of(each): {**own, "code": jobs.code_of_kind(name, each)} for each in (False, True)}
    return About(machine(), versions, absent)


def document(said: About) -> dict[str, Any]:
    """As the scheduler keeps it."""
    return {"machine": asdict(said.machine), "versions": dict(said.versions), "absent": dict(said.absent)}


def of_document(said: Mapping[str, Any]) -> About:
    return About(Machine(**said["machine"]), said["versions"], said["absent"])


@dataclass(frozen=True)
class Sent:
    """A job on its way. versions: what its worker has to have; packed scenes and plugins are kept by their hashes."""

    job: Job
    options: Options
    with_samplers: bool
    versions: Mapping[str, str]
    limit: float


@dataclass(frozen=True)
class SentPlugin:
    """A plugin, by what its file holds: where it lies on the machine that sends it does not matter."""

    name: str
    sha256: str
    contents: bytes
    trusted: bool

    def whole(self) -> bool:
        """Whether these are the contents of the hash."""
        return hashlib.sha256(self.contents).hexdigest() == self.sha256


class OtherVersions(JobFailed):
    """A worker that would draw another picture than the job's key says."""


def hold(packed: bytes) -> bytes:
    """What is sent once to a worker, and stays with it as long as a job may need it. Runs on a worker."""
    return packed


def perform(scene: bytes, plugins: Sequence[bytes], packed: bytes) -> bytes:
    """Does a job in a process of its own; gives the packed logs.Answer, of Timed or an error of ours. Runs on a worker,
    which does one at a time."""
    return pickle.dumps(_answer(scene, tuple(plugins), packed), protocol=pickle.HIGHEST_PROTOCOL)


def _answer(scene: bytes, plugins: tuple[bytes, ...], packed: bytes) -> logs.Answer:
    """That of the process that renders, with what was logged on the way to it; this worker's own where it gave none."""
    own = logs.there(_performed, scene, plugins, packed)
    if own.error is not None:
        ended = own.error.__cause__
        process = ended.pid if isinstance(ended, ProcessExpired) and ended.pid else own.place.process
        return replace(own, place=replace(own.place, process=process, worker=_address()))
    its: logs.Answer = own.result
    return replace(
        its,
        result=None if its.error else replace(its.result, machine=machine()),
        place=replace(its.place, worker=_address()),
        records=own.records + its.records,
        counts=Counter(own.counts) + Counter(its.counts),
    )


def _worker() -> Any:
    """Dask's, which this is a task of; None elsewhere."""
    from distributed import get_worker

    try:
        return get_worker()
    except ValueError:
        return None


def _address() -> str:
    """Of this worker, as the scheduler knows it."""
    worker = _worker()
    return "" if worker is None else str(worker.address)


def _performed(scene: bytes, plugins: tuple[bytes, ...], packed: bytes) -> logs.Answer:
    sent: Sent = pickle.loads(packed)
    _check(sent)
    pool, paths = _pool(plugins)
    arguments = [paths, hashlib.sha256(scene).hexdigest(), scene, sent.job, sent.options]
    return pool.begin(_render, arguments, sent.limit).answer()


_left_out: set[str] = set()


def leave_out(names: Sequence[str]) -> None:
    """This process does no jobs of these renderers."""
    _left_out.update(names)


def _check(sent: Sent) -> None:
    """Whether this worker says that it can do the job; the scheduler sends no others. Raises OtherVersions."""
    name = sent.job.renderer
    if name in _left_out:
        raise OtherVersions(f"{machine().name} draws nothing with {name}")
    own = {**_own_versions(name), "code": jobs.code_of_kind(name, sent.with_samplers)}
    if own != dict(sent.versions):
        raise OtherVersions(f"{machine().name} has {difference(own, sent.versions)}")


@functools.cache
def _own_versions(renderer: str) -> Mapping[str, str]:
    return renderers.find(renderer).versions()


def difference(own: Mapping[str, str], wanted: Mapping[str, str]) -> str:
    """What a worker has of other versions than are wanted, in words."""
    names = [name for name in {**own, **wanted} if own.get(name) != wanted.get(name)]
    told = (f"{name} {own.get(name, 'not at all')} where {wanted.get(name, 'none')} is wanted" for name in names)
    return ", ".join("other code of ours" if name == "code" else text for name, text in zip(names, told, strict=True))


_pools: dict[tuple[tuple[str, bool], ...], tuple[Workers, list[tuple[str, bool]]]] = {}
_folders: list[tempfile.TemporaryDirectory[str]] = []


def _pool(plugins: tuple[bytes, ...]) -> tuple[Workers, list[tuple[str, bool]]]:
    """The process that does the jobs with these plugins, and their files, with whether they are trusted: a plugin, once
    loaded, stays, so others have another process."""
    sent: list[SentPlugin] = [pickle.loads(each) for each in plugins]
    key = tuple((each.sha256, each.trusted) for each in sent)
    if key not in _pools:
        for other in list(_pools):
            _pools.pop(other)[0].__exit__(None, None, None)
        files = [(str(_written(each)), each.trusted) for each in sent]
        # Its tasks load them: what cannot be loaded is then said of each, and ends no process.
        _pools[key] = Workers(1, plugins=[]).__enter__(), files
    return _pools[key]


def _written(plugin: SentPlugin) -> Path:
    if not plugin.whole():
        raise Unsupported(f"the plugin {plugin.name} did not arrive as it was sent")
    if not _folders:
        # In dask's folder, which goes with the worker however it ends.
        where = getattr(_worker(), "local_directory", None)
        _folders.append(tempfile.TemporaryDirectory(prefix="aliascope-plugins-", dir=where))
    path = Path(_folders[0].name) / plugin.sha256 / Path(plugin.name).name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(plugin.contents)
    return path


def plugins_sent() -> list[SentPlugin]:
    """Those that are loaded here. Raises NotAvailable for one whose file is another now."""
    try:
        sent = [
            SentPlugin(Path(p.path).name, p.sha256, Path(p.path).read_bytes(), p.trusted) for p in samplers.plugins()
        ]
    except OSError as error:
        raise NotAvailable(f"{error.filename}: cannot be read: {error.strerror}") from error
    for each in sent:
        if not each.whole():
            raise NotAvailable(f"{each.name}: the file of this plugin changed since it was loaded; begin anew")
    return sent


# --- in the process that renders --------------------------------------------------------------------------------------

_scene: tuple[str, SceneFile] | None = None
_rendered = 0


def _render(plugins: Sequence[tuple[str, bool]], digest: str, packed: bytes, job: Job, options: Options) -> Timed:
    """The picture of a job; before every few of them, the fixed job of calibration."""
    global _scene, _rendered
    _load(plugins)
    if _scene is None or _scene[0] != digest:
        _scene = digest, pickle.loads(packed)
    beats = (calibration.beat(),) if _rendered % calibration.EVERY == 0 else ()
    _rendered += 1
    return replace(render_job(_scene[1], job, options), beats=beats)


def _load(plugins: Sequence[tuple[str, bool]]) -> None:
    """Those that are loaded already stay. Raises JobFailed."""
    for path, trusted in plugins:
        try:
            samplers.load_plugin(path, trusted=trusted)
        except AliascopeError as error:
            name = Path(path).name
            why = str(error).replace(path, name)
            raise JobFailed(f"a plugin cannot be loaded on {machine().name}: {why}") from error
