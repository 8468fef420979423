"""What the commands share: the application, options that several have, how a document is printed."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from aliascope import logs, sharing
from aliascope.draws import UNMOVED, checked
from aliascope.errors import Interrupted, InvalidInput


class _Commands(TyperGroup):
    """Of which each ends by one line where it is interrupted, and has nothing better to say."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as error:
            raise Interrupted("interrupted") from error


app = typer.Typer(
    cls=_Commands,
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
        typer.Option(
            metavar="F.so",
            help="A sampler, run in a process of its own without files, programs or network; as often as needed.",
        ),
    ] = None,
    trust_plugin: Annotated[
        list[str] | None,
        typer.Option(
            metavar="F.so",
            help="A sampler of yours, run inside of the renderer: at its full speed, with your rights.",
        ),
    ] = None,
    verbose: Annotated[
        bool,
        typer.Option("--verbose", "-v", help="Say on standard error what happens: each job as it ends, commands."),
    ] = False,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Nothing on standard error but errors; regress: what failed alone.")
    ] = False,
) -> None:
    """Measures how well renderers antialias, and what that costs.

    These options may stand before or after the command.
    """
    if verbose and quiet:
        raise InvalidInput("--verbose and --quiet: give one of them")
    logs.tell(verbose, quiet)
    if plugin or trust_plugin:
        from aliascope.native.samplers import load_plugin

        for path in plugin or ():
            load_plugin(path)
        for path in trust_plugin or ():
            load_plugin(path, trusted=True)


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
                logs.warn(f"{path}: {note}")


def command_said() -> str:
    """The command line of this run, as others may read it."""
    return sharing.command_line(["aliascope", *sys.argv[1:]])


def begin_log(folder: Path | None) -> None:
    """Begins the log of this run in the folder of its results, if it has one."""
    logs.begin(folder, command_said())


def print_json(document: Any) -> None:
    typer.echo(json.dumps(document, allow_nan=False))


ClusterAddress = Annotated[
    str | None,
    typer.Option(
        "--cluster",
        metavar="tcp://HOST:PORT",
        help="Have the jobs done by the workers of a dask scheduler (see worker); of compare and knobs alone.",
    ),
]
TlsCa = Annotated[Path | None, typer.Option("--tls-ca", metavar="F.pem", help="Of a cluster at tls://: the authority.")]
TlsCert = Annotated[Path | None, typer.Option("--tls-cert", metavar="F.pem", help="The own certificate.")]
TlsKey = Annotated[Path | None, typer.Option("--tls-key", metavar="F.pem", help="Its key.")]


def cluster_of(address: str | None, ca: Path | None, certificate: Path | None, key: Path | None, plan: Any) -> Any:
    """The cluster that does the jobs of a plan, or None. Raises InvalidInput, also for TLS without a cluster."""
    if address is None:
        if (ca, certificate, key) != (None, None, None):
            raise InvalidInput(
                "--tls-ca, --tls-cert and --tls-key are those of a cluster: add --cluster tls://HOST:PORT"
            )
        return None
    from aliascope.cluster.address import Tls
    from aliascope.cluster.client import Cluster

    return Cluster(address, Tls(ca, certificate, key), plan, lambda text: typer.echo(text, err=True))
