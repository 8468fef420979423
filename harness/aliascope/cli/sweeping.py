"""The command that finds the setting to use for a scene of one's own."""

from __future__ import annotations

import os
import re
import time
from pathlib import Path
from typing import Annotated

import typer

from aliascope.cli.shared import Json, app, begin_log, command_said, print_json, size_of
from aliascope.errors import Interrupted, InvalidInput

_UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0}


def _loading_seconds() -> float:
    """How long this process has run: what Python took to load counts too. 0 where the system does not tell."""
    try:
        ticks = int(Path("/proc/self/stat").read_text().rpartition(")")[2].split()[19])
        return time.clock_gettime(time.CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError, AttributeError):
        return 0.0


_LOADING_SECONDS = min(max(0.0, _loading_seconds()), 10.0)
"""At the time of the import, which the program begins with; in a program of somebody else that says nothing."""


@app.command(epilog="Example: aliascope sweep my/scene.pov --budget 5m --size 320x240 -o sweep")
def sweep(
    scene: Annotated[Path, typer.Argument(metavar="FILE", help="A .pov, .glb, .gltf or .toml file.")],
    budget: Annotated[
        str | None, typer.Option(metavar="TIME", help="On the wall, all in all: 90s, 5m (the default), 1h.")
    ] = None,
    size: Annotated[
        str | None, typer.Option("--size", metavar="WxH", help="Pixels; 320x240 for a .pov file, else the scene's own.")
    ] = None,
    threads: Annotated[
        int | None, typer.Option(min=1, max=256, help="Of the reference, and pictures side by side; all cores.")
    ] = None,
    out: Annotated[Path, typer.Option("-o", metavar="DIR", help="report.html, and sweep.ini for a .pov file.")] = Path(
        "aliascope-sweep"
    ),
    exhaustive: Annotated[
        bool, typer.Option("--exhaustive", help="The whole grid of settings instead of a search; may take hours.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Find which setting to use for a scene: fast, balanced, and final, each with its time and error.

    A .pov file is rendered by POV-Ray as it is, in its folder; the reference is a regular grid of 12 x 12 rays a pixel
    or more. fast: the best of those that take at most twice as long as the fastest. final: the fastest whose error is
    that of 8 bits, or within 5 % of the least there is. balanced: between them, the least time x MSE.
    """
    begun = time.monotonic() - _LOADING_SECONDS
    from datetime import UTC, datetime

    from aliascope.folder_lock import locked
    from aliascope.studies import sweep as study
    from aliascope.studies import sweep_text  # with what a report takes, which is not loaded when time is short
    from aliascope.studies.progress import progress_bar

    asked = study.Asked(scene, seconds_of(budget), size_of(size), threads, out, exhaustive, begun)
    started = datetime.now(UTC)
    study.check_file(scene)
    begin_log(out)
    with locked(out):
        with progress_bar() as tell:
            swept = study.sweep(asked, tell)
        report = sweep_text.write(swept, started, command_said())
    if as_json:
        print_json(sweep_text.document(swept, report))
    else:
        for line in sweep_text.lines(swept, report):
            typer.echo(line)
    if swept.found.interrupted:
        raise Interrupted("interrupted; what was found until then is above, and in the report")


def seconds_of(text: str | None) -> float | None:
    """A time as people write it. Raises InvalidInput."""
    if text is None:
        return None
    found = re.fullmatch(r"(\d+(?:\.\d+)?)([smh])", text.strip())
    if found is None:
        raise InvalidInput(f'--budget "{text}" is no time: a number with its unit, such as 90s, 5m or 1h')
    return float(found[1]) * _UNITS[found[2]]
