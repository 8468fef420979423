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


@app.command(epilog="Example: aliascope doctor")
def doctor(as_json: Json = False) -> None:
    """Say what is installed, and measure where each renderer has its pixels and whether its output is linear.

    Ends with 1 where a renderer's pictures cannot be compared.
    """
    from aliascope.studies.doctor import examine, lines_of

    document = examine()
    if as_json:
        print_json(document)
    else:
        for line in lines_of(document):
            typer.echo(line)
    if not all(entry.get("holds", True) for entry in document["renderers"]):
        raise typer.Exit(1)
