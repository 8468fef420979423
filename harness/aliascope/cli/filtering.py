"""The command about filtering samples that are not evenly spread."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aliascope.cli.shared import Json, Seed, app, print_json


@app.command(
    epilog="Example: aliascope uneven sobol:scramble=owen -n 64 --crowd 0.75 --method average --method area -o ."
)
def uneven(
    source: Annotated[
        str,
        typer.Argument(
            metavar="[SAMPLER|FILE]",
            help="Spec; see aliascope list samplers. Or a .csv or .npy file, [0, 1) being the filter's support.",
        ),
    ] = "sobol:scramble=owen",
    n: Annotated[int | None, typer.Option("-n", min=1, max=65536, help="Samples a pixel, 64.")] = None,
    under: Annotated[str, typer.Option("--filter", metavar="F", help="Spec; see aliascope list filters.")] = "box",
    method: Annotated[
        list[str] | None,
        typer.Option("--method", metavar="M", help="See aliascope list weightings; all if none is named."),
    ] = None,
    crowd: Annotated[
        float | None,
        typer.Option(
            min=0.0, max=1.0, help="Share of them in the left half of the pixel, 0.75; the others are spread."
        ),
    ] = None,
    realisations: Annotated[
        int | None, typer.Option(min=1, max=10000, help="Seeds to average: 64 of a randomised sampler, else 1.")
    ] = None,
    seed: Seed = 0,
    out: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="For uneven.svg, uneven.png and uneven.csv.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Filter samples that crowd on one side of an edge, as adaptive sampling leaves them: how wrong is each weighting?

    The edge is vertical, at 129 positions; what it should come to is known. multi-stage is a filter of its own, and is
    judged by that.
    """
    from aliascope.studies import uneven as study
    from aliascope.studies.uneven_samples import open_samples

    found = study.study(open_samples(source, n, crowd, seed), method or [], under, realisations)
    written = study.write(found, out) if out is not None else []
    if as_json:
        print_json(study.document(found))
        return
    for line in study.lines(found):
        typer.echo(line)
    if written:
        typer.echo(f"wrote {', '.join(map(str, written))}")
