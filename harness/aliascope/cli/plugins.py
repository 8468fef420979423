"""The commands about plugins."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aliascope.cli.shared import Json, app, print_json

plugins = typer.Typer(no_args_is_help=True, rich_markup_mode=None)
app.add_typer(
    plugins,
    name="plugin",
    help="Samplers of others and of yours: shared objects that any command takes with --plugin or --trust-plugin.",
    epilog="Example: aliascope plugin check ./mine.so",
)


@plugins.command(epilog="Example: aliascope plugin check ./kronecker.so --spec kronecker:shift=0.25")
def check(
    file: Annotated[Path, typer.Argument(metavar="F.so", help="A shared object; csrc/plugins/ has an example.")],
    spec: Annotated[
        str | None, typer.Option(metavar="SPEC", help="Which configuration, name:key=value; its defaults if not said.")
    ] = None,
    time_limit: Annotated[float, typer.Option(min=0.1, max=86400.0, help="Seconds that one check may take.")] = 20.0,
    as_json: Json = False,
) -> None:
    """Check that a plugin's sampler keeps to the contracts of plugin.h.

    Each check runs in a process of its own, which reads the plugin's folder and the system's libraries, writes nothing,
    starts no program and has no network (by Landlock and seccomp, where the system has them: see doctor). Ends with 1
    where one fails, with 2 where the file is no plugin.
    """
    from aliascope.studies import plugin_check

    outcomes = []
    for outcome in plugin_check.check(file, spec, time_limit):
        outcomes.append(outcome)
        if not as_json:
            typer.echo(plugin_check.line_of(outcome))
    document = plugin_check.document(file, outcomes)
    if as_json:
        print_json(document)
    else:
        typer.echo(plugin_check.last_line(file, outcomes))
    if not document["holds"]:
        raise typer.Exit(1)
