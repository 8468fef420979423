"""The wheel: what is in it, that its commands work where there is no source tree and no network, and what a build says
that cannot be made."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path
from types import ModuleType

import pytest

from aliascope import jobs, places, renderers
from aliascope.errors import InvalidInput

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ("Makefile", "pyproject.toml", "README.md", "LICENSE", ".gitignore")
FOLDERS = ("csrc", "harness", "scenes", "reference", "tests/renderers")
IGNORED = shutil.ignore_patterns("__pycache__", "*.egg-info", "test_*", "bench_*")
MAKE = ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")

DRIVER = """
import contextlib, io, json, sys
from aliascope import cli

if __name__ == "__main__":
    for words in json.loads(sys.argv[1]):
        sys.argv = ["aliascope", *words]
        said, complained, status = io.StringIO(), io.StringIO(), 0
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(complained):
            try:
                cli.main()
            except SystemExit as ended:
                status = ended.code or 0
        print(json.dumps([status, said.getvalue(), complained.getvalue()]), flush=True)
"""
"""Runs commands one after the other, as each would run alone, and loads numpy and its kin once."""


def run(command: list[str | Path], folder: Path, **more: str) -> str:
    environment = {name: value for name, value in os.environ.items() if name not in (*MAKE, "PYTHONPATH")}
    result = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=600, check=False, env={**environment, **more}
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the source tree as make left it, in a repository of its own."""
    copy = tmp_path_factory.mktemp("tree")
    for name in FOLDERS:
        shutil.copytree(ROOT / name, copy / name, ignore=IGNORED)
    shutil.copytree(ROOT / ".build" / "release", copy / ".build" / "release", ignore=IGNORED)
    for name in (*SOURCES, ".build/exports.map", ".build/bindings.stamp"):
        shutil.copy2(ROOT / name, copy / name)
    author = ["-c", "user.name=Nobody", "-c", "user.email=nobody@localhost"]
    for words in (["init", "-q"], ["add", "-A"], [*author, "commit", "-q", "-m", "All of it"]):
        run(["git", *words], copy)
    return copy


def without_network() -> list[str]:
    """The words before a command that take the network from it, where the system lets one; none where not."""
    for words in (["unshare", "--net"], ["unshare", "--map-root-user", "--net"]):
        if (found := shutil.which("unshare")) and subprocess.run(
            [*words, "true"], capture_output=True, check=False
        ).returncode == 0:
            return [found, *words[1:]]
    return []


def built(sources: Path, folder: Path) -> Path:
    """A wheel, as a packager makes it: without a network."""
    words = ["wheel", "--no-index", "--no-build-isolation", "--no-deps", "--quiet", "-w", str(folder), str(sources)]
    run([*without_network(), sys.executable, "-m", "pip", "--disable-pip-version-check", *words], sources.parent)
    (made,) = folder.iterdir()
    return made


@pytest.fixture(scope="module")
def wheel(tree: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make finds that nothing is to be compiled."""
    native = tree / "harness" / "aliascope" / "native"
    before = {path: path.stat().st_mtime_ns for path in native.rglob("*.so")}
    made = built(tree, tmp_path_factory.mktemp("wheel"))
    assert before == {path: path.stat().st_mtime_ns for path in native.rglob("*.so")}
    assert len(before) == 8
    assert not (tree / "build").exists()
    return made


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """In a folder whose name has what paths of others have: blanks, letters past ASCII."""
    folder = tmp_path_factory.mktemp("in stalled, \u00e9")
    words = ["install", "--no-index", "--no-deps", "--quiet", "--target", str(folder), str(wheel)]
    run([sys.executable, "-m", "pip", "--disable-pip-version-check", *words], folder)
    return folder


def test_the_wheel_is_for_this_kind_of_machine_and_has_all_that_commands_need(wheel: Path, tree: Path) -> None:
    machine = re.escape(os.uname().machine)
    assert re.fullmatch(rf"aliascope-{re.escape(places.own_version())}-cp311-abi3-linux_{machine}\.whl", wheel.name)
    with zipfile.ZipFile(wheel) as opened:
        names = {name for name in opened.namelist() if not name.endswith("/")}
        said = opened.read(f"aliascope-{places.own_version()}.dist-info/WHEEL").decode()
        assert opened.read("aliascope/data/revision").decode() == run(["git", "rev-parse", "--short=12", "HEAD"], tree)
    assert "Root-Is-Purelib: false" in said
    data = "aliascope/data/"
    assert {name for name in names if name.startswith(data + "reference/")} == {
        data + str(path.relative_to(ROOT)) for path in places.REFERENCES.rglob("*") if path.is_file()
    }
    assert {Path(name).name for name in names if name.startswith(data + "scenes/")} == {
        path.name for path in places.SCENES.iterdir() if path.suffix in (".toml", ".ply", ".md")
    }
    package = ROOT / "harness" / "aliascope"
    own = {path for path in package.rglob("*") if path.is_file() and "__pycache__" not in path.parts}
    assert {f"aliascope/{path.relative_to(package)}" for path in own} == {
        name for name in names if name.startswith("aliascope/") and not name.startswith(data)
    }
    assert all(name.startswith(("aliascope/", "aliascope-")) for name in names)


def test_the_libraries_name_no_folder_of_the_machine_that_built_them(installed: Path, tree: Path) -> None:
    """Nor does their debugging information: the same sources make the same files, and keys of pictures, anywhere."""
    folders = [str(path).encode() for path in (ROOT, tree, Path.home(), Path(sys.prefix), Path(sys.base_prefix))]
    folders = [folder for folder in folders if folder not in (b"/", b"/usr")]
    libraries = sorted(installed.rglob("*.so"))
    assert len(libraries) == 8
    for library in libraries:
        contents = library.read_bytes()
        assert [folder for folder in folders if folder in contents] == []
        paths = re.findall(r"R(?:UN)?PATH.*\[(.*)\]", run(["readelf", "-d", library], installed))
        plugin = library.name == "not_finite.so"  # calls nothing of ours
        assert paths == ([] if plugin else ["$ORIGIN"] if library.parent.name == "lib" else ["$ORIGIN/lib"])


def test_the_modules_keep_to_the_stable_abi(installed: Path) -> None:
    """They are compiled with Py_LIMITED_API, under which the headers show nothing else; nothing private is taken."""
    for module in (installed / "aliascope" / "native").glob("_*.so"):
        assert module.name.endswith(".abi3.so")
        needed = re.findall(r" U (_?Py\w+)", run(["nm", "-D", "--undefined-only", module], installed))
        assert len(needed) > 5
        # None, True, and the end of an object: part of the stable ABI in spite of their names.
        assert set(re.findall(r"\b_Py\w+", " ".join(needed))) <= {"_Py_NoneStruct", "_Py_TrueStruct", "_Py_Dealloc"}


def test_keys_of_pictures_are_those_of_the_source_tree(installed: Path) -> None:
    """So that results of one are those of the other: the same files, by the same names."""
    script = (
        "import json; from aliascope import jobs, renderers; print(json.dumps([jobs.code_digest(name, "
        "renderers.mode_of(renderers.find(name), renderers.find(name).probe_mode)) for name in renderers.BUILT_IN]))"
    )
    theirs = json.loads(run([sys.executable, "-c", script], installed, PYTHONPATH=str(installed)))
    found = [renderers.find(name) for name in renderers.BUILT_IN]
    assert theirs == [jobs.code_digest(each.name, renderers.mode_of(each, each.probe_mode)) for each in found]


COMMANDS = [
    "list scenes",
    "points sobol -n 4",
    "compare edge -r embree -r povray -m uniform:n=4 -m none --size 24x18 -o compared",
    "regress discs -r embree -m uniform:n=16,sampler=random -o regressed -q",
    "history -o regressed",
    "reference edge --verify",
    "mitchell --realisations 2",
    "doctor -r embree --quick",
    "stability */mean --quick -o broken",
    "knobs --help",
    "reference edge",
    "regress --bless edge/* --reason none",
]


def contents(folder: Path) -> dict[Path, int]:
    """When each file was written, but those that Python keeps for itself."""
    return {
        path: path.stat().st_mtime_ns
        for path in folder.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


@pytest.fixture(scope="module")
def ran(installed: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[int, str, str]]:
    """Status, output and complaints of each command: run elsewhere, without a network, a compiler on the PATH or a home
    that can be written to, and nothing written into the package."""
    folder = tmp_path_factory.mktemp("elsewhere")
    (folder / "driver.py").write_text(DRIVER)
    programs = folder / "programs"
    programs.mkdir()
    (programs / "povray").symlink_to(shutil.which("povray") or "none")
    asked = json.dumps([command.split() for command in COMMANDS])
    before = contents(installed)
    words = [*without_network(), sys.executable, "driver.py", asked]
    # No folder can be made below a device, not even by root.
    printed = run(words, folder, PYTHONPATH=str(installed), HOME="/dev/null", PATH=str(programs)).splitlines()
    assert contents(installed) == before
    assert (folder / "compared" / "report.html").stat().st_size > 100_000
    return {command: tuple(json.loads(line)) for command, line in zip(COMMANDS, printed, strict=True)}


def test_it_is_the_installed_package_that_runs(installed: Path, tmp_path: Path) -> None:
    script = "import aliascope; from aliascope import places; print(aliascope.__file__, places.INSTALLED, sep='\\n')"
    printed = run([sys.executable, "-c", script], tmp_path, PYTHONPATH=str(installed)).splitlines()
    assert printed == [str(installed / "aliascope" / "__init__.py"), "True"]


@pytest.mark.parametrize("command", COMMANDS[:-2])
def test_a_command_outside_the_source_tree(command: str, ran: dict[str, tuple[int, str, str]]) -> None:
    status, said, complained = ran[command]
    assert status == 0, said + complained
    telling = {
        "list": "zone-plate",
        "points": "0.25,0.75",
        "compare": "6 pictures, 0 failed",
        "regress": "3 of 3 controls caught",
        "history": "regressed/history.html",
        "reference": "edge: holds",
        "mitchell": "Zaremba",
        "doctor": "pictures can be compared",
        "stability": "cells keep their bounds",
        "knobs": "--time-limit",
    }
    assert telling[command.split()[0]] in said


@pytest.mark.parametrize(("command", "option"), [(COMMANDS[-2], "-o DIR"), (COMMANDS[-1], "--references DIR")])
def test_its_references_are_not_written_to(command: str, option: str, ran: dict[str, tuple[int, str, str]]) -> None:
    status, said, complained = ran[command]
    assert (status, said) == (2, "")
    assert complained.count("\n") == 1
    assert complained.endswith(f"name a folder of yours with {option}\n")


def test_where_references_are_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert places.kept_in(None, "-o") == ROOT / "reference"
    monkeypatch.setattr(places, "INSTALLED", True)
    assert places.kept_in(tmp_path, "-o") == tmp_path
    for folder in (None, ROOT / "reference"):
        with pytest.raises(InvalidInput, match="with -o DIR"):
            places.kept_in(folder, "-o")


@pytest.fixture(scope="module")
def sources(tree: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source distribution, packed."""
    folder = tmp_path_factory.mktemp("sources")
    run([sys.executable, "-c", f"from setuptools.build_meta import build_sdist; build_sdist({str(folder)!r})"], tree)
    (made,) = folder.iterdir()
    return made


def test_the_sources_are_those_of_the_repository(tree: Path, sources: Path) -> None:
    with tarfile.open(sources) as opened:
        files = {member.name.partition("/")[2] for member in opened.getmembers() if member.isfile()}
        revision = opened.extractfile(f"{sources.name.removesuffix('.tar.gz')}/revision")
        assert revision is not None
        assert revision.read().decode() == run(["git", "rev-parse", "--short=12", "HEAD"], tree)
    listed = set(run(["git", "-c", "core.quotePath=off", "ls-files"], tree).splitlines())
    assert listed > {"csrc/sampler/registry.c", "Makefile", "harness/build_package.py", "reference/blessings.jsonl"}
    assert files - {"PKG-INFO", "setup.cfg", "revision"} == listed


def test_the_wheel_of_the_sources_is_that_of_the_tree(wheel: Path, tree: Path, sources: Path, tmp_path: Path) -> None:
    """Bit for bit, in another folder, where libraries are linked again and bindings compiled."""
    folder = tmp_path / "another folder, \u00e9"
    with tarfile.open(sources) as opened:
        opened.extractall(folder)  # ours; Python 3.11.2, Debian's, knows no filters
    (unpacked,) = folder.iterdir()
    shutil.copytree(tree / ".build" / "release", unpacked / ".build" / "release")
    made = built(unpacked, tmp_path / "made")
    assert made.name == wheel.name
    with zipfile.ZipFile(wheel) as one, zipfile.ZipFile(made) as other:
        assert sorted(one.namelist()) == sorted(other.namelist())
        assert [name for name in one.namelist() if one.read(name) != other.read(name)] == []


@pytest.fixture
def hook() -> ModuleType:
    spec = importlib.util.spec_from_file_location("build_package", ROOT / "harness" / "build_package.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_build_without_its_system_packages_says_which(hook: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    assert hook.missing() == {}
    monkeypatch.setitem(hook.HEADERS, "no_such/header.h", "libnone-dev")
    with pytest.raises(hook.PlatformError) as caught:
        hook.compile_libraries()
    assert str(caught.value) == (
        "the C libraries cannot be compiled without no_such/header.h; on Debian: apt-get install libnone-dev"
    )
    monkeypatch.setitem(hook.PROGRAMS, "no-such-compiler", "build-essential")
    assert set(hook.missing()) == {"no-such-compiler", *hook.HEADERS}


def test_pip_shows_that_line_and_no_traceback(tree: Path, tmp_path: Path) -> None:
    words = ["wheel", "--no-index", "--no-build-isolation", "--no-deps", "--quiet", "-w", str(tmp_path), str(tree)]
    result = subprocess.run(
        [sys.executable, "-m", "pip", "--disable-pip-version-check", *words],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "CC": "no-such-compiler"},
    )
    assert result.returncode != 0
    assert "error: the C libraries cannot be compiled without no-such-compiler" in result.stderr
    assert "Traceback" not in result.stderr
