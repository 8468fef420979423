"""The commands about integration."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from aliascope.cli.shared import Json, Seed, app, print_json
from aliascope.errors import InvalidInput


@app.command(epilog="Example: aliascope integrate edge --sampler random --sampler jittered -o edge")
def integrate(
    integrand: Annotated[
        str | None, typer.Argument(metavar="INTEGRAND", help="Spec; see aliascope list integrands.")
    ] = None,
    sampler: Annotated[
        list[str] | None,
        typer.Option("--sampler", metavar="S", help='Spec, or names such as "halton*"; repeat. If not: a telling set.'),
    ] = None,
    d: Annotated[int | None, typer.Option("-d", min=1, max=64, help="Dimensions, 2.")] = None,
    realisations: Annotated[int, typer.Option(min=2, max=1_000_000, help="Of patterns that are random.")] = 64,
    least_n: Annotated[int | None, typer.Option(min=1, max=1 << 24, help="Fewest points, 16.")] = None,
    most_n: Annotated[int | None, typer.Option(min=1, max=1 << 24, help="Most points, 4096.")] = None,
    seed: Seed = 0,
    shift: Annotated[
        bool, typer.Option("--shift", help="Shift fixed patterns modulo 1 at random (Cranley and Patterson 1976).")
    ] = False,
    variation: Annotated[
        bool, typer.Option("--variation", help="Koksma and Hlawka's bound beside the error: V(f) D*_N.")
    ] = False,
    lecture: Annotated[
        bool, typer.Option("--lecture", help="A plot for each page of the lecture, and a page with all; takes -o.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="Plot and figures there, as SVG and CSV.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Integrate a function whose integral is known, with each sampler, and measure how fast the error falls with N.

    Of a random pattern the error is the root mean square over realisations, of a fixed one |error|. The rate is the r
    of error ~ N^r, fitted to one N an octave, with a 95 % interval; errors that are rounding are left out of it.
    Theory: "~" an order that is reached, "<=" a bound, blank where nothing is proved.
    """
    from aliascope.integration import integrate as measure
    from aliascope.studies import integrate as study
    from aliascope.studies.progress import progress_bar

    if lecture:
        _lecture(integrand or sampler or d or least_n or most_n or shift or variation, out, realisations, seed, as_json)
        return
    if integrand is None:
        raise InvalidInput("INTEGRAND is missing; see aliascope list integrands, or --lecture")
    with progress_bar() as tell:
        found = measure(
            integrand,
            study.expand(sampler) if sampler else None,
            d or 2,
            realisations=realisations,
            **study.span(least_n, most_n),
            seed=seed,
            shift=shift,
            variation=variation,
            tell=tell,
        )
    study.check_all_there(found, sampler or [])
    if out is not None:
        study.write(out, found)
    _print(study.document(found) if as_json else study.lines(found, variation))


def _lecture(others: object, out: Path | None, realisations: int, seed: int, as_json: bool) -> None:
    from aliascope.studies import integrate_lecture as study
    from aliascope.studies.progress import progress_bar

    if others:
        raise InvalidInput("--lecture has its own integrands and samplers; with it go --realisations, --seed and -o")
    if out is None:
        raise InvalidInput("--lecture takes -o DIR, the folder of its page and plots")
    with progress_bar() as tell:
        made = study.make(realisations, seed, tell)
    paths = study.write(out, made)
    _print(study.document(made) if as_json else [*study.lines(made), f"{paths[0]}"])


def _print(answer: dict[str, Any] | list[str]) -> None:
    if isinstance(answer, dict):
        print_json(answer)
    else:
        typer.echo("\n".join(answer))
