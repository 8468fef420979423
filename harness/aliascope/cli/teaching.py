"""The commands that show what the lecture says, in figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aliascope import logs
from aliascope.cli.shared import Json, Seed, Size, app, print_json, size_of


@app.command(epilog="Example: aliascope mitchell --half-count -o mitchell")
def mitchell(
    realisations: Annotated[
        int | None,
        typer.Option(min=1, max=1000000, help="Of each randomised cell; as many as it takes where it is not said."),
    ] = None,
    half_count: Annotated[
        bool, typer.Option("--half-count", help="Add 1/(4 N^2) to the mean squares: a fit, no part of the definition.")
    ] = False,
    table: Annotated[
        str, typer.Option(metavar="lecture|samplers|hardware", help="Which patterns and counts.")
    ] = "lecture",
    column: Annotated[
        list[str] | None,
        typer.Option(metavar="M,M", help="Further columns: star, half-plane, edge-mean, edge-max or another measure."),
    ] = None,
    search: Annotated[
        bool,
        typer.Option("--search", help="Which edges, statistic and generators come nearest to the published table."),
    ] = False,
    seed: Seed = 0,
    threads: Annotated[
        int | None, typer.Option("-j", min=1, max=64, help="Threads, one a core if not said; they change no figure.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="A page with plot, point sets and spectra; CSV and JSON.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Measure Mitchell's table of random edges again: five processes at 16, 256 and 1,600 points.

    Each cell is the root mean square over realisations and random edges, with its standard error, the published figure
    and their ratio. --table samplers is the same of every sampler, --table hardware of what a pixel's 1 to 16 samples
    can be.
    """
    from aliascope.studies import mitchell_command as study

    asked = study.Asked(table, realisations, half_count, tuple(column or ()), search, seed, threads, out)
    answer = study.answer(asked)
    if out is not None:
        first, *others = answer.write(out)
        logs.warn(f"wrote {first}, and {len(others)} file{'s' * (len(others) != 1)} beside it")
    if as_json:
        print_json(answer.document())
    else:
        for line in answer.lines():
            typer.echo(line)


@app.command(epilog="Example: aliascope space-time -n 16 -n 64 -o space-time")
def space_time(
    n: Annotated[
        list[int] | None, typer.Option("-n", min=1, max=1024, help="Samples of a pixel, 16 and 64; several times.")
    ] = None,
    scene: Annotated[
        str, typer.Option(help="A scene in motion, without a lens or lights with an area.")
    ] = "motion-blur",
    size: Size = "64x48",
    realisations: Annotated[int, typer.Option(min=2, max=100000, help="Of each randomised pattern.")] = 64,
    pictures: Annotated[int, typer.Option(min=2, max=10000, help="Of each randomised pattern.")] = 12,
    seed: Seed = 0,
    out: Annotated[Path | None, typer.Option("-o", metavar="DIR", help="A page with figures; CSV and JSON.")] = None,
    as_json: Json = False,
) -> None:
    """Measure whether it pays that samples near each other in the pixel are far apart in time.

    Of each pattern in x, y and t: how far near samples are apart in time, its discrepancy in each plane and in all
    three, and the error of a picture in motion. The same places and times are compared dealt out at random, by tables
    such as Cook's, and decorrelated.
    """
    from aliascope.studies import space_time_command as study
    from aliascope.studies.space_time import COUNTS, Options

    options = Options(realisations, pictures, seed)
    found = study.answer(study.Asked(tuple(n or COUNTS), scene, size_of(size), options))
    if out is not None:
        first, *others = study.write(found, out)
        logs.warn(f"wrote {first}, and {len(others)} files beside it")
    if as_json:
        print_json(study.document(found))
    else:
        for line in study.lines(found):
            typer.echo(line)
