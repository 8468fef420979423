"""The command about what is kept on disk: cache."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aliascope.cli.shared import Json, app, print_json
from aliascope.errors import InvalidInput


@app.command(epilog="Example: aliascope cache --empty power --limit 200MB")
def cache(
    folder: Annotated[
        Path | None, typer.Argument(metavar="[DIR]", help="Results of compare or knobs: which pictures could go.")
    ] = None,
    empty: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Empty it: power, fonts, scratch, or all; may stand several times."),
    ] = None,
    limit: Annotated[
        str | None,
        typer.Option(metavar="SIZE", help="How large power may grow, from now on: 200MB, 1GiB; 500MB if never said."),
    ] = None,
    prune: Annotated[bool, typer.Option("--prune", help="Remove from DIR what could go.")] = False,
    as_json: Json = False,
) -> None:
    """Say which caches there are, where, how large they are and may grow; empty them.

    They are below $ALIASCOPE_CACHE, else aliascope in $XDG_CACHE_HOME or ~/.cache. Beyond the limit, what was used
    longest ago goes first. All in them is made again when it is needed, and may be removed at any time.

    Results are no caches. Of DIR it says how much could go: pictures that results.sqlite does not name, and those that
    a later run has made anew with other code or for another version of the scene. Only --prune removes them. Scenes,
    modes and seeds that no later run has made stay, whatever the last run was asked for.
    """
    from aliascope import caches
    from aliascope.caches import Usage
    from aliascope.studies import keeping

    if prune and folder is None:
        raise InvalidInput("--prune removes pictures from a folder of results: name it, aliascope cache DIR --prune")
    removed: list[Usage] = []
    if limit is not None:
        removed.append(caches.set_limit(caches.bytes_of(limit)))
    if empty:
        removed.append(keeping.empty(empty))
    gone = Usage(sum(each.files for each in removed), sum(each.size for each in removed)) if removed else None
    of = None if folder is None else keeping.results(folder, prune)
    if as_json:
        print_json(keeping.document(keeping.entries(), of, gone))
        return
    told = [] if gone is None else [keeping.removed_line(gone)]
    told += keeping.lines(keeping.entries()) if of is None else keeping.result_lines(of)
    for line in told:
        typer.echo(line)
