"""The commands about what there is: list, doctor."""

from __future__ import annotations

from typing import Annotated

import typer

from aliascope.cli.shared import Json, app, print_json
from aliascope.errors import InvalidInput, near_misses

# The keys of studies.lists.LISTS, which takes the renderers' modules with it; a test holds them equal.
LISTED = (
    *("scenes", "renderers", "modes", "samplers", "measures", "filters", "weightings", "metrics", "integrands"),
    "estimators",
)


@app.command("list", epilog="Example: aliascope list modes")
def list_(
    what: Annotated[str, typer.Argument(metavar="|".join(LISTED), help="What to list.")],
    as_json: Json = False,
) -> None:
    """List what there is, as it would stand in a spec."""
    from aliascope.studies.lists import LISTS

    if what not in LISTS:
        raise InvalidInput(f'cannot list "{what}"{near_misses(what, LISTS)}')
    entries = LISTS[what]()
    if as_json:
        print_json({what: entries})
        return
    for entry in entries:
        typer.echo("  ".join(str(value) for value in entry.values() if isinstance(value, str)))
        for key in entry.get("keys", []):
            typer.echo(f"    {key}")


@app.command(epilog="Example: aliascope doctor -r povray")
def doctor(
    renderer: Annotated[list[str] | None, typer.Option("-r", help="Renderer; may stand several times.")] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="One picture of each: its pixel centres, its response.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Say what is installed, and measure the conventions of each renderer that comparisons rest on.

    Where it has its pixels, what becomes of a level, what its samples weigh, whether a picture comes out the same
    again; and what that means. Ends with 1 where a renderer's pictures cannot be compared.
    """
    from aliascope.studies.doctor import examine, lines_of
    from aliascope.studies.progress import progress_bar

    with progress_bar() as tell:
        document = examine(renderer or (), quick, tell)
    if as_json:
        print_json(document)
    else:
        for line in lines_of(document):
            typer.echo(line)
    if not all(entry.get("holds", True) for entry in document["renderers"]):
        raise typer.Exit(1)
