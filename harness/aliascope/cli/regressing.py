"""The command that tests whether what renders now is as good as what was blessed: regress."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aliascope import logs
from aliascope.cli.shared import Json, app, begin_log, command_said, print_json, say_notes
from aliascope.errors import Interrupted, InvalidInput

if TYPE_CHECKING:
    from aliascope.studies.regress import Asked


@app.command(epilog="Example: aliascope regress edge siemens-star -r embree -r povray -o results")
def regress(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE...]", help="Names, patterns, files (TOML, glTF).")
    ] = None,
    renderer: Annotated[list[str] | None, typer.Option("-r", help="Renderer; may stand several times.")] = None,
    mode: Annotated[
        list[str] | None, typer.Option("-m", help="Mode, or a pattern of the suite's; may stand several times.")
    ] = None,
    bless: Annotated[
        str | None,
        typer.Option(metavar="PATTERN", help="Keep what these cells, scene/renderer/mode, render now as right."),
    ] = None,
    reason: Annotated[str | None, typer.Option(metavar="TEXT", help="Why that is right; goes into the log.")] = None,
    require: Annotated[
        list[str] | None, typer.Option(metavar="R", help="A renderer that must be there; may stand several times.")
    ] = None,
    references: Annotated[
        Path | None, typer.Option(metavar="DIR", help="References and blessed figures, instead of the project's own.")
    ] = None,
    out: Annotated[
        Path, typer.Option("-o", metavar="DIR", help="report.html, results.json, summary.md, history.sqlite there.")
    ] = Path("aliascope-regress"),
    junit: Annotated[Path | None, typer.Option(metavar="F.xml", help="For CI systems: JUnit's XML.")] = None,
    markdown: Annotated[Path | None, typer.Option(metavar="F.md", help="For reviews: the summary, here too.")] = None,
    processes: Annotated[int, typer.Option("-j", min=1, max=64, help="Cells side by side.")] = 2,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds that the pictures of one cell may take.")] = 120.0,
    as_json: Json = False,
) -> None:
    """Test whether scenes render as well as when they were blessed, and as their references have it.

    Each cell, a mode of a renderer on a scene, is 16 pictures with other seeds or shifts. Ends with 1 where a check
    fails, a reference or blessed figures are missing, or a defect that was put in as a control was not caught; with 4
    where a job crashed or hung. A renderer that is not there is skipped, unless it is required: then 3.
    """
    from aliascope import places
    from aliascope.studies.regress import Asked

    say_notes(scenes or [])
    asked = Asked(
        scenes=tuple(scenes or ()),
        renderers=tuple(renderer or ()),
        modes=tuple(mode or ()),
        required=tuple(require or ()),
        references=places.kept_in(references, "--references") if bless is not None else references or places.REFERENCES,
        processes=processes,
        time_limit=time_limit,
        command=command_said(),
        options=_options(time_limit),
    )
    if bless is not None and (junit or markdown):
        raise InvalidInput("--bless renders and keeps, and tests nothing that --junit or --markdown could hold")
    if bless is None and reason is not None:
        raise InvalidInput("--reason says why something is blessed: name it with --bless PATTERN")
    try:
        if bless is not None:
            _bless(asked, bless, reason or "", as_json)
        else:
            _run(asked, out, (junit, markdown), as_json)
    except KeyboardInterrupt as error:  # which would end with 1, as if a check had failed
        raise Interrupted("interrupted: nothing was tested to the end") from error


def _options(time_limit: float) -> tuple[str, ...]:
    """What the commands that are told need too."""
    from aliascope.native import samplers
    from aliascope.studies.regress import Asked

    words = [] if time_limit == Asked.time_limit else ["--time-limit", f"{time_limit:g}"]
    for plugin in samplers.plugins():
        words += [plugin.option, plugin.path]
    return tuple(words)


def _run(asked: Asked, out: Path, files: tuple[Path | None, Path | None], as_json: bool) -> None:
    from aliascope.folder_lock import locked
    from aliascope.studies import regress as study
    from aliascope.studies import regress_files, regress_text
    from aliascope.studies.progress import progress_bar

    begin_log(out)
    with locked(out):
        regress_files.check_writable(out)
        with progress_bar() as tell:
            seen = study.observe(asked, tell)
        regress_files.check_drawn(seen)
        run = study.judged(seen)
        # Said before it is written: a full disk loses no verdict.
        if as_json:
            print_json(regress_files.document(run))
        else:
            for line in regress_text.lines(run, logs.is_quiet()):
                typer.echo(line)
        page = regress_files.write(out, run, seen, *files)
    if not as_json:
        typer.echo(str(page))
    if any(cell.failed for cell in run.cells):
        raise typer.Exit(4)
    if not run.passed:
        raise typer.Exit(1)


def _bless(asked: Asked, pattern: str, reason: str, as_json: bool) -> None:
    from aliascope.studies import regress_bless
    from aliascope.studies.progress import progress_bar

    with progress_bar() as tell:
        blessings = regress_bless.bless(asked, pattern, reason, tell)
    if as_json:
        print_json(regress_bless.document(blessings))
    else:
        for line in regress_bless.lines(blessings):
            typer.echo(line)
    if not blessings.hold:
        raise typer.Exit(1)
