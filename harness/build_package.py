"""What setuptools does beside its own when it builds the Python package: compiles the libraries with make, packs the
scenes and references that the commands need, and names the wheel for what is in it.

`tool.setuptools.cmdclass` in pyproject.toml names these classes. An editable installation, as make has it, builds
nothing here: it is make that builds there.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build import build
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist
from setuptools.errors import ExecError, PlatformError

ROOT = Path(__file__).resolve().parents[1]
SCRATCH = ".build/package"

PROGRAMS = {"make": "make", os.environ.get("CC", "cc"): "build-essential"}
HEADERS = {"Python.h": "python3-dev", "embree3/rtcore.h": "libembree-dev", "GL/osmesa.h": "libosmesa6-dev"}
"""What the libraries cannot be compiled without, and the Debian package that has it."""


class Build(build):
    """All that is made on the way lies in make's folder: the source tree has no `build` of its own."""

    def initialize_options(self) -> None:
        super().initialize_options()
        self.build_base = SCRATCH


class BuildPy(build_py):
    """The modules, and what lies elsewhere in the source tree: libraries, scenes, references, the revision."""

    def run(self) -> None:
        if self.editable_mode:
            super().run()
            return
        shutil.rmtree(self.build_lib, ignore_errors=True)  # a file that is no more must not stay in the wheel
        compile_libraries()
        super().run()
        data = Path(self.build_lib) / "aliascope" / "data"
        shutil.copytree(
            ROOT / "scenes", data / "scenes", ignore=shutil.ignore_patterns("*.py", "__pycache__", "pictures")
        )
        shutil.copytree(ROOT / "reference", data / "reference")
        (data / "revision").write_text(revision() + "\n", encoding="utf-8")


class BdistWheel(bdist_wheel):
    """A wheel for one kind of machine, and every Python from 3.11 on: the modules keep to its stable ABI."""

    def initialize_options(self) -> None:
        super().initialize_options()
        self.py_limited_api = "cp311"

    def finalize_options(self) -> None:
        self.distribution.has_ext_modules = lambda: True
        super().finalize_options()


class Sdist(sdist):
    """What the repository has, all of it and nothing else, and from which revision it is."""

    def make_distribution(self) -> None:
        listed = _output(["git", "ls-files", "-z"])
        if Path(_output(["git", "rev-parse", "--show-toplevel"]).strip()) != ROOT or not listed:
            raise PlatformError("a source distribution is made from the repository: this is none")
        self.filelist.files = [name for name in listed.split("\0") if name]
        super().make_distribution()

    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        super().make_release_tree(base_dir, files)
        (Path(base_dir) / "revision").write_text(revision() + "\n", encoding="utf-8")


def compile_libraries() -> None:
    """With make, for any Python. Raises PlatformError, one line, where something is missing; ExecError."""
    lacking = missing()
    if lacking:
        what, packages = ", ".join(lacking), " ".join(dict.fromkeys(lacking.values()))
        raise PlatformError(f"the C libraries cannot be compiled without {what}; on Debian: apt-get install {packages}")
    if importlib.util.find_spec("cffi") is None:
        raise PlatformError("the bindings cannot be compiled without cffi; install it: pip install cffi")
    # The options of a make that runs this one are not meant for it.
    environment = {
        name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")
    }
    command = ["make", f"--jobs={os.cpu_count() or 1}", "native", f"CFFI_PYTHON={sys.executable}"]
    status = subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode
    if status:
        raise ExecError(f"the C libraries could not be compiled: {' '.join(command)} ended with {status}")


def missing() -> dict[str, str]:
    """Programs and headers that are not there, with the Debian package of each."""
    found = {name: package for name, package in PROGRAMS.items() if shutil.which(name) is None}
    if any(package == "build-essential" for package in found.values()):
        return {**found, **HEADERS}  # nothing can tell which of these are there
    return {**found, **{header: package for header, package in HEADERS.items() if not _there(header)}}


def _there(header: str) -> bool:
    command = [os.environ.get("CC", "cc"), "-E", f"-I{sysconfig.get_paths()['include']}", "-x", "c", "-"]
    text = f"#include <{header}>\n"
    return subprocess.run(command, input=text, capture_output=True, text=True, check=False).returncode == 0


def revision() -> str:
    """As the package itself tells it of the source tree."""
    return _output(
        [sys.executable, "-B", "-c", "from aliascope.places import revision; print(revision())"], "harness"
    ).strip()


def _output(command: list[str], folder: str = ".") -> str:
    """What a command prints; nothing where it fails."""
    try:
        return subprocess.run(command, cwd=ROOT / folder, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return ""
