"""The command that finds where each part breaks: stability."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aliascope.cli.shared import Json, app, begin_log, command_said, print_json
from aliascope.errors import Interrupted

if TYPE_CHECKING:
    from aliascope.studies.stability import Asked


@app.command(epilog="Example: aliascope stability 'embree*' 'variance/mean' --quick -o stability")
def stability(
    patterns: Annotated[
        list[str] | None,
        typer.Argument(metavar="[PATTERN...]", help="Components, extremes or component/extreme; else all."),
    ] = None,
    group: Annotated[
        list[str] | None,
        typer.Option(help="geometry, radiance, counts, statistics, points or metrics; may stand several times."),
    ] = None,
    kind: Annotated[
        list[str] | None,
        typer.Option(
            help="renderer, sampler, measure, estimator, statistic, filter, metric or film; may stand several times."
        ),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="A few levels of each alone, those that tests run.")] = False,
    out: Annotated[
        Path, typer.Option("-o", metavar="DIR", help="report.html, stability.json, .csv and .md there.")
    ] = Path("aliascope-stability"),
    processes: Annotated[
        int | None, typer.Option("-j", min=1, max=64, help="Probes side by side; else as many as processors.")
    ] = None,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds that one probe may take.")] = 300.0,
    as_json: Json = False,
) -> None:
    """Find how far an input can go before a result is wrong: each component at each extreme, and the map of it.

    Every reading is an error against a truth in higher precision, or an exact one. A cell of the map says at which
    level a component passes its bound; what POV-Ray's, Embree's or Mesa's own arithmetic breaks is told apart, and what
    a row without one of our safeguards does. Ends with 1 where a component of ours passes its bound, with 4 where a
    measurement of ours crashed or hung.
    """
    from aliascope.studies.stability import Asked

    asked = Asked(
        tuple(patterns or ()),
        tuple(group or ()),
        tuple(kind or ()),
        quick,
        processes or len(os.sched_getaffinity(0)),
        time_limit,
        command_said(),
    )
    try:
        _run(asked, out, as_json)
    except KeyboardInterrupt as error:  # which would end with 1, as if something had broken
        raise Interrupted("interrupted: nothing was measured to the end") from error


def _run(asked: Asked, out: Path, as_json: bool) -> None:
    from rich.console import Console

    from aliascope.folder_lock import locked
    from aliascope.studies import stability as study
    from aliascope.studies import stability_files, stability_text
    from aliascope.studies.progress import progress_bar

    begin_log(out)
    with locked(out):
        stability_files.check_writable(out)
        with progress_bar() as tell:
            found = study.run(asked, tell)
        # Said before it is written: a full disk loses no finding.
        if as_json:
            print_json(stability_files.document(found))
        else:
            stability_text.show(found, Console(width=stability_text.WIDTH, highlight=False))
        page = stability_files.write(out, found)
    if not as_json:
        typer.echo(str(page))
    if found.exit_code:
        raise typer.Exit(found.exit_code)
