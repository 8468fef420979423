"""`make install`, and what its user does then: compile with pkg-config, link, check a plugin, load it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from aliascope import places, points

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "csrc" / "plugins" / "kronecker.c"
STRICT = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]

PROGRAM = r"""
#include <stdio.h>
#include "aliascope/filter.h"
#include "aliascope/plugin.h"
#include "aliascope/sampler.h"
#include "aliascope/warp.h"

int main(void) {
  const asc_sampler_desc desc = {.struct_size = sizeof desc, .spec = "sobol", .samples = 8};
  const asc_range all = {.sample_count = 8, .dimension_count = 2};
  asc_sampler *sampler = NULL;
  asc_error error;
  double u[16], disc[16];
  if (asc_sampler_create(&desc, &sampler, &error)) return fprintf(stderr, "%s\n", error.text), 1;
  if (asc_sampler_fill(sampler, &all, u) || asc_disc_sample(u, 8, disc)) return 2;
  for (int i = 0; i < 8; i++) printf("%.17g %.17g %.17g\n", u[2 * i], u[2 * i + 1], disc[2 * i]);
  asc_sampler_destroy(sampler);
  fprintf(stderr, "%s", asc_version());
  return 0;
}
"""


MAKE = ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")
"""What a make that runs the tests would say to the one that is tested."""


def run(command: list[str | Path] | str, folder: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """In a folder, `command` a list or words for a shell; `more` goes into its environment."""
    result = subprocess.run(
        command,
        cwd=folder,
        shell=isinstance(command, str),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env={name: value for name, value in {**os.environ, **more}.items() if name not in MAKE},
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result


@pytest.fixture(scope="module")
def staged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A DESTDIR, installed to as a packager does, of a tree that is built."""
    stage = tmp_path_factory.mktemp("stage")
    before = {
        path: path.stat().st_mtime_ns for path in (ROOT / ".build").rglob("*") if path.suffix in (".o", ".0", ".so")
    }
    made = run(["make", "install", f"DESTDIR={stage}", "prefix=/usr"], ROOT)
    assert made.stdout.splitlines()[-1] == f"installed libaliascope {places.own_version()} to {stage}/usr"
    assert not re.search("compiling|linking|building|pip|apt-get", made.stdout + made.stderr)
    assert before == {path: path.stat().st_mtime_ns for path in before}
    return stage


def pkg_config(stage: Path) -> dict[str, str]:
    return {"PKG_CONFIG_SYSROOT_DIR": str(stage), "PKG_CONFIG_LIBDIR": str(stage / "usr" / "lib" / "pkgconfig")}


def test_what_is_installed(staged: Path) -> None:
    version = places.own_version()
    library = staged / "usr" / "lib"
    assert {path.name for path in library.iterdir()} == {
        "libaliascope.so",
        f"libaliascope.so.{version.split('.')[0]}",
        f"libaliascope.so.{version}",
        "pkgconfig",
    }
    assert all(
        not path.is_symlink() or path.resolve() == library / f"libaliascope.so.{version}" for path in library.iterdir()
    )
    headers = {path.name for path in (staged / "usr" / "include" / "aliascope").iterdir()}
    # scene.h is between the harness and the renderers, which are not installed.
    assert headers == {path.name for path in (ROOT / "csrc" / "include" / "aliascope").iterdir()} - {"scene.h"}
    tags = run(["readelf", "-d", library / "libaliascope.so"], staged).stdout
    assert f"soname: [libaliascope.so.{version.split('.')[0]}]" in tags
    # The C library alone, whose loader (ld-linux-*) has the variables that each thread has of its own.
    assert {name for name in re.findall(r"NEEDED.*\[(.*?)\.so", tags) if not name.startswith("ld-")} <= {
        "libm",
        "libc",
        "libdl",
    }
    assert "RUNPATH" not in tags
    assert "RPATH" not in tags
    assert str(staged) not in (library / "pkgconfig" / "aliascope.pc").read_text()
    assert run(["pkg-config", "--modversion", "aliascope"], staged, **pkg_config(staged)).stdout.strip() == version


def test_what_the_headers_declare_is_what_the_library_exports(staged: Path) -> None:
    """No more: a function compiled for several instruction sets comes with names of the compiler's."""
    headers = sorted((ROOT / "csrc" / "include" / "aliascope").iterdir())
    declared = re.findall(r"^ASC_API\b[^;]*?\b(asc_\w+)\(", "\n".join(map(Path.read_text, headers)), re.MULTILINE)
    for library in (staged / "usr" / "lib" / "libaliascope.so", ROOT / "harness/aliascope/native/lib/libaliascope.so"):
        listed = run(["nm", "-D", "--defined-only", library.resolve()], staged).stdout.splitlines()
        assert sorted(line.split()[-1] for line in listed) == sorted(declared)
    assert "asc_sampler_fill" in declared


def test_each_header_stands_alone(tmp_path: Path, staged: Path) -> None:
    for header in (staged / "usr" / "include" / "aliascope").iterdir():
        (tmp_path / "one.c").write_text(f'#include "aliascope/{header.name}"\nint main(void) {{ return 0; }}\n')
        run(["cc", *STRICT, f"-I{staged / 'usr' / 'include'}", "one.c", "-o", "one"], tmp_path)


def test_a_program_links_and_prints_points(tmp_path: Path, staged: Path) -> None:
    (tmp_path / "program.c").write_text(PROGRAM)
    flags = "$(pkg-config --cflags --libs aliascope)"
    run(f"cc {' '.join(STRICT)} program.c -o program {flags}", tmp_path, **pkg_config(staged))
    result = run([tmp_path / "program"], tmp_path, LD_LIBRARY_PATH=str(staged / "usr" / "lib"))
    printed = np.loadtxt(result.stdout.splitlines())
    assert printed[:, :2].tolist() == points("sobol", 8).tolist()
    assert np.abs(printed[:, 2]).max() <= 1
    assert result.stderr == places.own_version()
    assert "libaliascope.so.0" in run(["readelf", "-d", tmp_path / "program"], tmp_path).stdout


def test_the_example_by_the_commands_of_its_first_lines(tmp_path: Path, staged: Path) -> None:
    (tmp_path / "kronecker.c").write_text(EXAMPLE.read_text())
    compile_, check, show, _ = re.findall(r"^ \*     (.*)$", EXAMPLE.read_text(), re.MULTILINE)
    search = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    run(compile_.replace("cc ", f"cc {' '.join(STRICT)} "), tmp_path, **pkg_config(staged))
    lines = run(check, tmp_path, **search).stdout.splitlines()
    assert lines[-1] == "kronecker.so: every contract holds"
    printed = np.loadtxt(run(show, tmp_path, **search).stdout.splitlines(), delimiter=",")
    expected = (0.25 + np.arange(16)[:, np.newaxis] * np.sqrt([2.0, 3.0])) % 1.0
    assert np.abs(printed - expected).max() < 1e-14  # 16 sqrt(3) < 28, half an ulp of which is 2e-15


def test_an_installation_into_folders_with_blanks_and_more(tmp_path: Path) -> None:
    stage, prefix = tmp_path / "st age, \u00e9", "/o&pt, | \u00e9"
    run(["make", "install", f"DESTDIR={stage}", f"prefix={prefix}"], ROOT)
    assert [path.name for path in tmp_path.iterdir()] == [stage.name]
    installed = stage / prefix[1:]
    assert (installed / "lib" / "pkgconfig" / "aliascope.pc").read_text().startswith(f"prefix={prefix}\n")
    found = {"PKG_CONFIG_SYSROOT_DIR": str(stage), "PKG_CONFIG_LIBDIR": str(installed / "lib" / "pkgconfig")}
    (tmp_path / "program.c").write_text(PROGRAM)
    # What pkg-config prints has escapes for a shell that reads it as it reads a command.
    run('eval "cc program.c -o program $(pkg-config --cflags --libs aliascope)"', tmp_path, **found)
    run([tmp_path / "program"], tmp_path, LD_LIBRARY_PATH=str(installed / "lib"))
