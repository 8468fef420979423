"""What the commands share: the application, options that several have, how a document is printed."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import typer

from aliascope.draws import UNMOVED, checked
from aliascope.errors import InvalidInput

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Json = Annotated[bool, typer.Option("--json", help="One JSON document on standard output, and nothing else there.")]
Size = Annotated[
    str | None,
    typer.Option("--size", metavar="WxH", help="Pixels; keeps the vertical extent, the horizontal follows the aspect."),
]
Seed = Annotated[int, typer.Option("--seed", min=0, max=2**64 - 1, help="Of the random numbers.")]


def _version(wanted: bool) -> None:
    if wanted:
        from aliascope.places import own_version

        typer.echo(f"aliascope {own_version()}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
    plugin: Annotated[
        list[str] | None,
        typer.Option(metavar="F.so", help="A sampler of yours; before or after the command, any number of times."),
    ] = None,
) -> None:
    """Measures how well renderers antialias, and what that costs."""
    if plugin:
        from aliascope.native.samplers import load_plugin

        for path in plugin:
            load_plugin(path)


def size_of(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    from aliascope.model import LARGEST_AREA, LARGEST_SIDE

    width, cross, height = text.partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise InvalidInput(f'--size "{text}" is not of the form WxH, such as 128x96')
    size = int(width), int(height)
    if not all(1 <= side <= LARGEST_SIDE for side in size) or size[0] * size[1] > LARGEST_AREA:
        raise InvalidInput(f"--size {text}: a side has 1 to {LARGEST_SIDE} pixels, a picture at most {LARGEST_AREA}")
    return size


def shift_of(text: str | None) -> tuple[float, float]:
    """Pixels to the right and down. Raises InvalidInput."""
    if text is None:
        return UNMOVED
    try:
        right, down = (float(pixels) for pixels in text.split(","))
    except ValueError:
        raise InvalidInput(f'--shift "{text}" is not of the form RIGHT,DOWN, such as 0.25,-0.4') from None
    return checked((right, down))


def say_notes(scenes: Iterable[str]) -> None:
    """Says on standard error what the files of other programs among these scenes have that is not drawn."""
    from aliascope import scene_io

    for path in (Path(scene) for scene in scenes if scene_io.is_path(scene)):
        if path.suffix.lower() != ".toml":
            for note in scene_io.load_file(path).notes:
                typer.echo(f"{path}: {note}", err=True)


def print_json(document: Any) -> None:
    typer.echo(json.dumps(document, allow_nan=False))
