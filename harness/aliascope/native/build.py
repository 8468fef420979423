"""Builds the cffi modules in API mode, their declarations generated from the C headers by the preprocessor.

Run by make, after the shared libraries: python build.py SCRATCH_FOLDER. API mode, compiled with errors for pointers of
the wrong type: the mode that reads declarations at run time takes a wrong field of a struct in silence. The modules
keep to Python's stable ABI, so one build serves every version from LEAST_PYTHON on.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import sysconfig
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

from cffi import FFI

HERE = Path(__file__).parent
SOURCE = HERE.parents[2] / "csrc"
INCLUDE = [SOURCE / "include", SOURCE / "tracer", SOURCE / "raster"]
COMPILER = os.environ.get("CC", "cc")

LEAST_PYTHON = 0x030B0000
"""Python 3.11, as PY_VERSION_HEX has it."""

MODULES = {
    "_sampler": (
        "aliascope",
        [
            "aliascope/plugin.h",
            "aliascope/filter.h",
            "aliascope/uneven.h",
            "aliascope/discrepancy.h",
            "aliascope/warp.h",
            "aliascope/estimate.h",
        ],
    ),
    "_tracer": ("aliascope-tracer", ["tracer.h"]),
    "_raster": ("aliascope-raster", ["raster.h"]),
}


ADDITIONS = {
    "_sampler": """
        static const uint32_t ASC_ABI_VERSION; static char *const ASC_SAMPLER_INTERFACE_ID;
        extern "Python" asc_status aliascope_integrand(void *context, size_t count, const asc_pixel *pixels,
                                                       const double *points, double *values);
    """,
}
"""Macros that Python reads, of which the preprocessor leaves nothing (the compiler fills in their values), and what C
calls in Python."""


def declarations(headers: list[str]) -> str:
    """What the project's own headers declare, macros expanded; the system's types are known to cffi."""
    text = "".join(f'#include "{header}"\n' for header in headers)
    command = [COMPILER, "-E", "-DASC_CDEF", *(f"-I{folder}" for folder in INCLUDE), "-x", "c", "-"]
    expanded = subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout
    own, lines = False, []
    for line in expanded.splitlines():
        marker = re.match(r'# \d+ "([^"]*)"', line)
        if marker:
            own = str(SOURCE) in marker[1]
        elif own:
            lines.append(line)
    return "\n".join(lines)


def compile_module(name: str, library: str, headers: list[str], folder: Path) -> Path:
    """The shared object of one module. By the compiler itself: what Python was compiled with names its own folders."""
    builder = FFI()
    builder.cdef(declarations(headers) + ADDITIONS.get(name, ""))
    builder.set_source(f"aliascope.native.{name}", "".join(f'#include "{header}"\n' for header in headers))
    folder.mkdir(parents=True, exist_ok=True)
    source, made = folder / f"{name}.c", folder / f"{name}.abi3.so"
    with redirect_stdout(StringIO()):  # it says what it does
        builder.emit_c_code(str(source))
    libraries = dict.fromkeys(["aliascope", library])
    command = [
        *(COMPILER, "-shared", "-fPIC", "-std=c11", "-O2", "-Werror=incompatible-pointer-types"),
        f"-DPy_LIMITED_API={LEAST_PYTHON:#010x}",
        *(f"-I{path}" for path in (*INCLUDE, sysconfig.get_paths()["include"])),
        *(str(source), "-o", str(made), f"-L{HERE / 'lib'}"),
        *(f"-l{each}" for each in libraries),
        "-Wl,-rpath,$ORIGIN/lib",
    ]
    subprocess.run(command, check=True)
    return made


def main() -> None:
    scratch = Path(sys.argv[1])
    for name, (library, headers) in MODULES.items():
        built = compile_module(name, library, headers, scratch / name)
        for stale in HERE.glob(f"{name}.*.so"):
            stale.unlink()
        (HERE / built.name).write_bytes(built.read_bytes())


if __name__ == "__main__":
    main()
