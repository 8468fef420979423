"""Libraries of others, tried in a process of their own before this one loads them: what crashes there, as a driver may
that does not suit the machine, does not take this process along."""

from __future__ import annotations

import functools
import importlib.util
import signal
import subprocess
import sys
from dataclasses import dataclass

LIMIT = 120.0
"""Seconds that a trial may take; a tenth of one is usual."""

_ABSENT, _DECLINES = 3, 4
"""What the program below ends with where the module does not load, and where the library says no."""

_PROGRAM = f"""
import importlib.machinery, importlib.util, resource, signal, sys
resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
signal.alarm({round(LIMIT) + 10})  # where nobody waits any more
name, path = sys.argv[1:]
try:
    loader = importlib.machinery.ExtensionFileLoader(name, path)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
except ImportError as error:
    print(error)
    sys.exit({_ABSENT})
ffi, lib = module.ffi, module.lib
if name == "_raster":
    text = ffi.new("char[]", 256)
    status = lib.raster_describe(text, len(text))
else:
    scene, out, box = ffi.new("asc_scene *"), ffi.new("tracer **"), ffi.new("asc_error *")
    scene.struct_size, view = ffi.sizeof("asc_scene"), scene.view
    view.projection, view.width, view.height, view.half_width, view.half_height = lib.ASC_ORTHOGRAPHIC, 1, 1, 1, 1
    view.right, view.up, view.forward = (1, 0, 0), (0, 1, 0), (0, 0, -1)
    status = lib.tracer_create(scene, out, box)
    lib.tracer_destroy(out[0])
    text = ffi.new("char[]", str(lib.tracer_embree_version()).encode()) if status == 0 else box.text
print(ffi.string(text if status == 0 or name == "_tracer" else lib.asc_status_text(status)).decode(errors="replace"))
sys.exit({_DECLINES} if status else 0)
"""
"""Makes a context of OSMesa, or a device and a scene of Embree. It starts without this package, which takes longer."""

_loads_at_once = False


@dataclass(frozen=True)
class Trial:
    """How it ended: what the library says of itself; why it cannot be loaded, a crash too; why it declines, which does
    not keep it from being loaded. One of the three, the others ""."""

    said: str = ""
    absent: str = ""
    declines: str = ""


def load_at_once() -> None:
    """Has this process load libraries without a trial from now on: one of a pool, whose crash is that of its task."""
    global _loads_at_once
    _loads_at_once = True


def tried(name: str) -> Trial | None:
    """The trial of what `_tracer` or `_raster` needs, once a process; None in a process that does without, and where no
    process can be started."""
    return None if _loads_at_once else _tried(name)


@functools.cache
def _tried(name: str) -> Trial | None:
    spec = importlib.util.find_spec(f"aliascope.native.{name}")
    if spec is None or spec.origin is None:
        return Trial(absent=f"there is no module aliascope.native.{name}")
    command = [sys.executable, "-P", "-c", _PROGRAM, name, spec.origin]
    try:
        # A group of its own: Ctrl-C is for this process to handle, which ends that one.
        ended = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, timeout=LIMIT, check=False, process_group=0
        )
    except subprocess.TimeoutExpired:
        return Trial(absent=f"a process that tries it has not ended within {LIMIT:g} s")
    except OSError:
        return None
    text = ended.stdout.decode(errors="replace").strip()
    if ended.returncode == 0:
        return Trial(said=text)
    if ended.returncode == _ABSENT:
        return Trial(absent=text)
    if ended.returncode == _DECLINES:
        return Trial(declines=text)
    return Trial(absent=f"a process that tries it ends {_how(ended.returncode)}")


def _how(code: int) -> str:
    return f"by {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
