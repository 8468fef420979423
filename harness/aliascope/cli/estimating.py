"""The command about estimators."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aliascope.cli.shared import Json, Seed, app, print_json


@app.command(
    epilog="Example: aliascope estimate bright-feature:brightness=100 --estimator student-t:tolerance=1 -o bias"
)
def estimate(
    integrand: Annotated[
        list[str] | None,
        typer.Argument(metavar="INTEGRAND", help="Specs; see aliascope list integrands. If not: a telling set."),
    ] = None,
    estimator: Annotated[
        list[str] | None,
        typer.Option("--estimator", metavar="E", help="Spec; see aliascope list estimators; repeat. If not: all."),
    ] = None,
    sampler: Annotated[
        str | None, typer.Option("--sampler", metavar="S", help="Spec of a random sampler; random if not said.")
    ] = None,
    d: Annotated[int, typer.Option("-d", min=1, max=64, help="Dimensions.")] = 2,
    n: Annotated[int, typer.Option("-n", min=2, max=1 << 24, help="The most samples of a pixel.")] = 1024,
    repetitions: Annotated[int, typer.Option(min=2, max=10_000_000, help="Pixels, each an estimate.")] = 10_000,
    confidence: Annotated[float, typer.Option(min=0.01, max=0.9999, help="Of the intervals.")] = 0.95,
    seed: Seed = 0,
    out: Annotated[Path | None, typer.Option("-o", metavar="DIR", help="Page, plots and figures there.")] = None,
    as_json: Json = False,
) -> None:
    """Measure the bias of estimators, and how often their confidence intervals hold the integral, which is known."""
    from aliascope.studies import estimate as study
    from aliascope.studies.progress import progress_bar

    asked = study.Asked(
        integrands=study.parse_integrands(integrand or [], d),
        estimators=tuple(estimator) if estimator else None,
        sampler=sampler,
        dimensions=d,
        samples=n,
        repetitions=repetitions,
        confidence=confidence,
        seed=seed,
    )
    with progress_bar() as tell:
        measured = study.measure_all(asked, tell)
    page = None
    if out is not None:
        from aliascope.studies.estimate_page import write

        page = write(out, asked, measured)
    if as_json:
        print_json(study.document(asked, measured))
        return
    for line in study.lines(asked, measured):
        typer.echo(line)
    if page is not None:
        typer.echo(f"{page}")
