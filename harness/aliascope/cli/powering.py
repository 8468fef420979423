"""The command behind `make power`: about the regression harness, not about a renderer."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aliascope.cli.shared import Json, app, begin_log, print_json, say_notes


@app.command(hidden=True, epilog="Example: aliascope power edge --trust-plugin .build/plugins/repeats.so -o power")
def power(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE...]", help="Names, patterns, files (TOML, glTF).")
    ] = None,
    renderer: Annotated[list[str] | None, typer.Option("-r", help="Renderer; may stand several times.")] = None,
    repetitions: Annotated[int, typer.Option(min=1, max=1_000_000, help="Runs in which nothing changed.")] = 1000,
    pool: Annotated[int, typer.Option(min=32, max=65536, help="Pictures of a cell, of which each run draws 32.")] = 128,
    tries: Annotated[int, typer.Option(min=0, max=1000, help="Of a defect with fresh seeds, where time allows.")] = 10,
    shim: Annotated[
        Path | None,
        typer.Option(metavar="F.so", help="tests/c/embree_isa.c, compiled: draw by other instructions too."),
    ] = None,
    processes: Annotated[int, typer.Option("-j", min=1, max=64, help="Cells side by side.")] = 2,
    out: Annotated[Path, typer.Option("-o", metavar="DIR", help="power.json, power.md; what was rendered.")] = Path(
        "aliascope-power"
    ),
    as_json: Json = False,
) -> None:
    """Measure how often `regress` raises an alarm where nothing changed, and which defects it catches.

    Ends with exit code 1 where alarms are more than 4 in 1,000, or a defect is missed. The sampler whose dimension 1
    repeats dimension 0 is a plugin: --trust-plugin repeats.so.
    """
    from aliascope.folder_lock import locked
    from aliascope.studies import power as study
    from aliascope.studies import power_text
    from aliascope.studies.progress import progress_bar

    say_notes(scenes or [])
    asked = study.Asked(
        tuple(scenes or ()), tuple(renderer or ()), repetitions, pool, tries, processes, folder=out, shim=shim
    )
    begin_log(out)
    with locked(out):
        with progress_bar() as tell:
            answer = study.answer(asked, tell)
        written = power_text.write(out, answer)
    if as_json:
        print_json(power_text.document(answer))
    else:
        for line in power_text.lines(answer):
            typer.echo(line)
        typer.echo(str(written))
    if not answer.holds:
        raise typer.Exit(1)
