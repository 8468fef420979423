"""What crashes on purpose: libraries in place of others, or before them, and a reader of pictures in workers."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path
from typing import Any
from unittest.mock import patch

from aliascope import image, places

INCLUDE = Path(__file__).resolve().parents[2] / "csrc" / "include"

NAMES = {"raster": ("libOSMesa.so.8", ("gl", "OSMesa")), "tracer": ("libembree3.so.3", ("rtc",))}
"""The library of others that each of ours needs, and how the names of its functions begin."""


def compiled(folder: Path, name: str, text: str, *flags: str | Path) -> Path:
    """A shared library, "NAME.so", of a C source."""
    source, library = folder / f"{name}.c", folder / f"{name}.so"
    source.write_text(text)
    subprocess.run(["cc", "-shared", "-fPIC", f"-I{INCLUDE}", source, "-o", library, *flags], check=True)
    return library


def crashing_when_loaded(folder: Path, ours: str, how: str) -> Path:
    """A library with all that ours takes of OSMesa or Embree, which does this, a statement of C, when it is loaded."""
    name, beginnings = NAMES[ours]
    taken = subprocess.run(
        ["nm", "-D", "--undefined-only", places.LIBRARIES / f"libaliascope-{ours}.so"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    functions = [word for word in taken if word.startswith(beginnings)]
    assert functions
    stubs = "".join(f"void {function}(void) {{}}\n" for function in functions)
    before = "#include <signal.h>\n#include <stdlib.h>\n#include <unistd.h>\n"
    text = f"{before}{stubs}__attribute__((constructor)) static void loaded(void) {{ {how} }}\n"
    return compiled(folder, f"crashing-{ours}", text, f"-Wl,-soname,{name}").rename(folder / name)


CRASHING_CALLS = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <sys/stat.h>

/* The function, after a crash where there was none. */
static void *real(const char *library, const char *name, const char *marker) {
  if (mkdir(marker, 0777) == 0) raise(SIGSEGV);
  return dlsym(dlopen(library, RTLD_NOW | RTLD_NOLOAD), name);
}
void glReadPixels(int x, int y, int width, int height, unsigned format, unsigned type, void *pixels) {
  void (*read)(int, int, int, int, unsigned, unsigned, void *) =
      real("libOSMesa.so.8", "glReadPixels", FOLDER "/osmesa-crashed");
  read(x, y, width, height, format, type, pixels);
}
void rtcIntersect16(const int *valid, void *scene, void *context, void *rays) {
  void (*intersect)(const int *, void *, void *, void *) =
      real("libembree3.so.3", "rtcIntersect16", FOLDER "/embree-crashed");
  intersect(valid, scene, context, rays);
}
"""
"""Stands before OSMesa and Embree: the first picture that each draws ends in a crash, and no other."""


def crashing_calls(folder: Path) -> Path:
    """A library to be preloaded, which leaves a marker of each crash in the folder."""
    return compiled(folder, "calls", CRASHING_CALLS, f'-DFOLDER="{folder}"', "-ldl")


def crash_the_first_reader(marker: Path) -> None:
    """In a worker process: the first picture that any of them opens crashes OpenImageIO."""
    real = image.oiio.ImageInput.open

    def opened(*arguments: Any) -> Any:
        try:
            marker.mkdir()
        except FileExistsError:
            return real(*arguments)
        os.kill(os.getpid(), signal.SIGSEGV)
        raise AssertionError("no crash")

    patch.object(image.oiio, "ImageInput", type("ImageInput", (), {"open": staticmethod(opened)})).start()
