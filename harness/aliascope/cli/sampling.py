"""The commands about sampling patterns."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Annotated

import typer

from aliascope.cli.shared import Json, Seed, app, print_json
from aliascope.errors import InvalidInput
from aliascope.native.samplers import ARRANGEMENTS

Source = Annotated[
    str,
    typer.Argument(
        metavar="SAMPLER|FILE",
        help="A spec (aliascope list samplers). Or a file, whose name has a slash or a suffix: .npy, or text of one "
        "point a line, its columns parted by commas, semicolons, tabs or blanks, its first line names or not, # before "
        "comments; - is such text from standard input.",
    ),
]
Count = Annotated[int | None, typer.Option("-n", min=1, max=2**53, help="How many points.")]
MOST_DIMENSIONS = 65536
Dimensions = Annotated[int | None, typer.Option("-d", min=1, max=MOST_DIMENSIONS, help="Dimensions of the pattern, 2.")]


@app.command(epilog="Example: aliascope points sobol:scramble=owen -n 64 --spectrum -o spectrum.svg")
def points(
    sampler: Source,
    n: Count = None,
    d: Dimensions = None,
    seed: Seed = 0,
    pixel: Annotated[str, typer.Option(metavar="X,Y", help="Of which pixel.")] = "0,0",
    first: Annotated[int, typer.Option(min=0, max=2**53, help="Index of the first point.")] = 0,
    weights: Annotated[bool, typer.Option("--weights", help="A last column with the weight of each point.")] = False,
    statistics: Annotated[
        bool, typer.Option("--statistics", help="Minimum distance, Voronoi areas, t of a net instead.")
    ] = False,
    spectrum: Annotated[
        bool, typer.Option("--spectrum", help="Radial mean power and anisotropy, in dB, by frequency instead.")
    ] = False,
    dimensions: Annotated[
        str | None, typer.Option(metavar="A,B", help="Which; for statistics and spectrum 0,1 if not said.")
    ] = None,
    groups: Annotated[
        str | None, typer.Option(metavar="A,B,...", help="Dimensions that go together: 2,1 for pixel and time.")
    ] = None,
    arrangement: Annotated[
        str, typer.Option(metavar="|".join(ARRANGEMENTS), help="Of --groups; see aliascope render --dimensions.")
    ] = "joint",
    realisations: Annotated[
        int | None,
        typer.Option(min=1, max=10000, help="Seeds to average: 1, of a spectrum 10 if the pattern is randomised."),
    ] = None,
    cut_off: Annotated[
        int | None, typer.Option(min=1, max=2048, help="Largest frequency of the spectrum; about 4 sqrt(n).")
    ] = None,
    base: Annotated[int | None, typer.Option(min=2, max=1 << 20, help="Of the net whose t is a statistic, 2.")] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", metavar="FILE", help="A .csv, .npy (the spectrum in two dimensions), .svg or .png instead."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Print the points of a sampling pattern: CSV, no header, 17 significant digits. Or their statistics, or spectrum.

    With -o a .svg or .png is a drawing: of the first two dimensions, a third as colour, or of the spectrum.
    """
    from aliascope.studies import points as study
    from aliascope.studies.point_source import open_source

    asked = study.Asked(weights, statistics, spectrum, dimensions, realisations, cut_off, base, out)
    asked.check()
    sizes = _groups(groups, arrangement)
    source = open_source(sampler, n, d, seed, _pixel(pixel), first, sizes, arrangement)
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # a reader that has enough, as `| head`, ends us without a word
    found = study.answer(asked, source)
    if out is not None:
        found.write(out)
    if as_json:
        print_json(found.document())
    elif out is None:
        for text in found.texts():
            sys.stdout.write(text)


def _groups(text: str | None, arrangement: str) -> tuple[int, ...] | None:
    if text is None:
        if arrangement != "joint":
            raise InvalidInput(f"--arrangement {arrangement} needs --groups: which dimensions go together")
        return None
    try:
        sizes = tuple(int(part) for part in text.split(","))
    except ValueError:
        raise InvalidInput(f'--groups "{text}" is not of the form A,B,...') from None
    if not all(size > 0 for size in sizes) or sum(sizes) > MOST_DIMENSIONS:
        raise InvalidInput(f"--groups {text}: each has a dimension or more, all together {MOST_DIMENSIONS} at most")
    return sizes


def _pixel(text: str) -> tuple[int, int]:
    try:
        x, y = (int(part) for part in text.split(","))
    except ValueError:
        raise InvalidInput(f'--pixel "{text}" is not of the form X,Y') from None
    if not all(-(2**31) <= value < 2**31 for value in (x, y)):
        raise InvalidInput(f"--pixel {text}: coordinates have 32 bits")
    return x, y


@app.command(epilog="Example: aliascope discrepancy sobol:scramble=owen -n 256 --measure star,half-plane")
def discrepancy(
    source: Source,
    n: Count = None,
    d: Dimensions = None,
    seed: Seed = 0,
    measure: Annotated[
        list[str] | None,
        typer.Option(metavar="M,M", help="See aliascope list measures; those that are quick if none is named."),
    ] = None,
    projections: Annotated[
        bool, typer.Option("--projections", help="Of every two-dimensional projection, instead.")
    ] = False,
    orders: Annotated[
        bool,
        typer.Option(
            "--orders", help="How star falls with N, from 16 to n points, instead: as log^d N / N, N^-1/2, ..."
        ),
    ] = False,
    realisations: Annotated[
        int | None,
        typer.Option(min=1, max=10000, help="Seeds of --orders to average, 16 if the pattern is randomised."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("-o", metavar="FILE", help="A .svg or .png: n(x, y)/N - xy; or the orders.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Measure the discrepancy of points: how far counts in boxes, half-planes, ... are from areas."""
    if orders:
        _orders(source, n, d, seed, bool(measure or projections), realisations, out, as_json)
        return
    if realisations is not None:
        raise InvalidInput("--realisations needs --orders")
    from aliascope.point_sets import measure_all
    from aliascope.studies import discrepancy as study
    from aliascope.studies.delta import draw
    from aliascope.studies.point_source import open_source

    points_of = open_source(source, n, d, seed, (0, 0), 0)
    points, specs = points_of.realisation(0), study.asked(measure or [])
    document = points_of.document
    if projections:
        found = study.projections(points, specs, seed)
        rows = [{"dimensions": [a, b], **study.document(measured)} for a, b, measured in found]
        document |= {"projections": rows}
        lines = [f"{a}, {b}  {line}" for a, b, measured in found for line in study.lines(measured)]
    else:
        measured = measure_all(points, specs, seed)
        document |= study.document(measured)
        lines = study.lines(measured)
    if out is not None:
        draw(out, points, points_of.name)
    if as_json:
        print_json(document)
    else:
        for line in lines:
            typer.echo(line)


def _orders(
    source: str,
    n: int | None,
    d: int | None,
    seed: int,
    more: bool,
    realisations: int | None,
    out: Path | None,
    as_json: bool,
) -> None:
    from aliascope.studies import orders as study
    from aliascope.studies.point_source import is_file
    from aliascope.studies.progress import progress_bar

    if more:
        raise InvalidInput("--orders are those of star: neither --measure nor --projections")
    if is_file(source):
        raise InvalidInput(f"{source}: --orders are those of a sampler; a file has one number of points")
    if out is not None:
        from aliascope.studies.order_picture import check, draw

        check(out)  # before the seconds of measuring
    with progress_bar() as tell:
        found = study.measure_orders(source, d or 2, seed, n, realisations, tell)
    if out is not None:
        draw(out, found)
    if as_json:
        print_json(study.document(found))
    else:
        for line in study.lines(found):
            typer.echo(line)


@app.command("radical-inverse", epilog="Example: aliascope radical-inverse 3 -n 9")
def radical_inverse(
    base: Annotated[int, typer.Argument(metavar="BASE", min=2, max=2**53, help="Of the digits.")] = 2,
    n: Annotated[int, typer.Option("-n", min=1, max=100_000, help="From 1 to which number.")] = 5,
    as_json: Json = False,
) -> None:
    """Print numbers, their digits in a base, the digits reversed, and the fraction that these are after the point.

    Digits above 9 are letters; above base 36 each digit is a decimal number, with colons between them.
    """
    from aliascope.studies import radical_inverse as study

    rows = study.table(base, n)
    if as_json:
        print_json(study.document(base, rows))
    else:
        for line in study.lines(rows):
            typer.echo(line)
