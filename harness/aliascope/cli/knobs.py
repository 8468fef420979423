"""The command that turns the knobs of renderers, filters and measures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aliascope import logs
from aliascope.cli.shared import (
    ClusterAddress,
    Json,
    Size,
    TlsCa,
    TlsCert,
    TlsKey,
    app,
    begin_log,
    cluster_of,
    command_said,
    print_json,
    size_of,
)


@app.command(epilog="Example: aliascope knobs edge spheres -r embree -o knobs")
def knobs(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(metavar="[SCENE...]", help="Names, patterns, TOML files; else five of the project's."),
    ] = None,
    renderer: Annotated[list[str] | None, typer.Option("-r", help="Renderer; may stand several times.")] = None,
    out: Annotated[Path, typer.Option("-o", metavar="DIR", help="report.html, knobs.csv and knobs.md there.")] = Path(
        "aliascope-knobs"
    ),
    size: Size = None,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds that one picture may take.")] = 120.0,
    cluster: ClusterAddress = None,
    tls_ca: TlsCa = None,
    tls_cert: TlsCert = None,
    tls_key: TlsKey = None,
    as_json: Json = False,
) -> None:
    """Measure what each setting does to time and error: one key is turned at a time, the others stay.

    Thresholds, depths and jitter of POV-Ray, adaptive tests, packets, robust mode, film, patterns and filters of the
    tracer, passes and multisampling of OSMesa; and measures of point sets, exact against bounded. Pictures that the
    folder already has are not rendered again.
    """
    from aliascope.folder_lock import locked
    from aliascope.pipeline import Options
    from aliascope.studies import knob_text
    from aliascope.studies import knobs as study
    from aliascope.studies.progress import progress_bar
    from aliascope.text_files import write_text

    plan = study.plan_of(scenes or [], renderer or [], size_of(size))
    elsewhere = cluster_of(cluster, tls_ca, tls_cert, tls_key, plan)
    begin_log(out)
    with locked(out):
        with progress_bar() as progress:
            turned = study.turn(plan, out, Options(1, time_limit), command_said(), progress, logs.warn, elsewhere)
        write_text(out / "knobs.csv", knob_text.knobs_csv(turned.knobs))
        write_text(out / "knobs.md", "\n".join(knob_text.markdown(turned.knobs)) + "\n")
    if as_json:
        print_json(knob_text.document(turned))
    else:
        for line in knob_text.lines(turned):
            typer.echo(line)
    if turned.comparison.data.failures:
        raise typer.Exit(4)
