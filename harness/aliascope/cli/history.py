"""The command that shows what earlier regression runs came to."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aliascope.cli.shared import Json, app, print_json


@app.command(epilog="Example: aliascope history siemens-star -r povray -o aliascope-regress")
def history(
    scenes: Annotated[list[str] | None, typer.Argument(metavar="[SCENE...]", help="Names or patterns.")] = None,
    renderer: Annotated[list[str] | None, typer.Option("-r", help="Renderer; may stand several times.")] = None,
    mode: Annotated[list[str] | None, typer.Option("-m", help="Mode or a pattern; may stand several times.")] = None,
    out: Annotated[
        Path, typer.Option("-o", metavar="DIR", help="Of aliascope regress; history.html comes there, and history/.")
    ] = Path("aliascope-regress"),
    source: Annotated[
        Path | None, typer.Option("--from", metavar="F.sqlite", help="The history, where it is not in DIR.")
    ] = None,
    metric: Annotated[
        list[str] | None,
        typer.Option(help="rmse, cpu-seconds, samples, rays-primary, ... or a pattern; may stand several times."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Draw error and cost of each mode over the runs of aliascope regress, and mark where they changed.

    A change of what is exact is a step by definition; times, on one machine, are tested for changes of level. All
    tests together raise a false alarm in one history of a hundred.
    """
    from aliascope import history as kept
    from aliascope.studies import history as study
    from aliascope.studies import history_text
    from aliascope.studies.history_page import write
    from aliascope.studies.history_series import Asked

    asked = Asked(tuple(scenes or ()), tuple(renderer or ()), tuple(mode or ()), tuple(metric or ()))
    answer = study.answer(kept.load(source or out / "history.sqlite"), asked)
    page = write(out, answer)
    if as_json:
        print_json(history_text.document(answer))
    else:
        for line in history_text.lines(answer):
            typer.echo(line)
        typer.echo(str(page))
